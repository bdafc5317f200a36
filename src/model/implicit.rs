//! The implicit bristle: its force balance is solved, so that it sticks exactly and does not drift.
//!
//! A bristle (spring σ0 beside a dashpot σ1) presses on the sliding surface with its tip, which
//! slides at v_s = v − ż. It carries what the surface gives at *that* velocity:
//!
//! σ0 z + σ1 ż = μ(v_s) sgn(v_s)
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | z | bristle deflection | m |
//! | v, v_s = v − ż | velocity of the body, sliding velocity of the bristle's tip | m/s |
//! | e = σ0 z + σ1 v | trial coefficient: what the bristle would carry if it stuck | – |
//! | μ | friction curve | – |
//! | σ0, σ1, σ2 | micro-stiffness, micro-damping, viscous friction (a part of μ) | 1/m, s/m, s/m |
//!
//! [`FrBd`](crate::FrBd) makes one Newton-like step of this equation. Here it is solved: with
//! ż = v − v_s it is a scalar equation for v_s,
//!
//! Φ(v_s) = e,  Φ(u) = σ1 u + μ(u) sgn u.
//!
//! The bristle sticks, v_s = 0 and ż = v, if |e| ≤ μ(0); otherwise the tip
//! slides in the direction of e. Φ rises, so that there is a single solution, if and only if
//! σ1 + dμ/d|v| > 0 at every speed. For the [`Stribeck`](crate::curve::Stribeck) curve with δ = 2
//! that is σ1 + σ2 > (μ_s − μ_d)√(2/e)/v_S. Otherwise Φ is folded, and a [`FoldRule`] says which
//! branch to follow.
//!
//! # The affine form
//!
//! FrBD's own coefficients, with the surface taken at v_s in place of v,
//!
//! s = |v_s|/μ(v_s),  λ = σ0 s r,  r = 1/(1 + σ1 s),  c₀ = σ0 r,  c₂ = σ1 r,
//!
//! give rate and force of this model exactly: r e = μ sgn v_s, and v − ż = s r e = v_s. Sticking
//! is s = 0. A step with these coefficients frozen is passive, because c₀ = σ0 r, and of first
//! order, because they depend on z. At a held velocity the tip is followed instead, see
//! [`ImplicitBristle`].
//!
//! # Derivatives
//!
//! From Φ(v_s) = σ0 z + σ1 v, with f(u) = μ(u) sgn u and Φ' = σ1 + f':
//!
//! ∂ż/∂z = −σ0/Φ',  ∂ż/∂v = f'/Φ',  ∂μ_b/∂z = σ0 f'/Φ',  ∂μ_b/∂v = σ1 f'/Φ'
//!
//! and 0, 1, σ0, σ1 where it sticks.
//!
//! # Laws
//!
//! Passivity: F v − Ẇ = F v_s + p σ1 ż² ≥ 0 for W = ½ p σ0 z², on any branch.
//!
//! Bounds: let M be the largest μ up to a speed V ≥ |v|, and |z| ≤ M/σ0. Then |F| ≤ p M. If
//! |v_s| ≤ V, that is the choice of M; if |v_s| > V, then
//! |F|/p = |e| − σ1|v_s| ≤ M + σ1 (V − |v_s|). With σ1 > 0, at z = M/σ0 that gives
//! σ1 (v_s − v) = M − F/p ≥ 0, so ż ≤ 0: the deflection turns back at M/σ0.
//!
//! Disturbances decay at σ0/Φ' ≤ σ0/(σ1 + min dμ/d|v|): in the falling part of a curve much faster
//! than FrBD's.
//!
//! Source: the implicit force balance of Romano et al. (arXiv 2602.09429), section II-A, from which
//! their models follow by one step of linearisation; its solution and laws are derived here.

mod hold;
mod solve;

use solve::{Fold, Surface, Tip};

use super::{Affine, HeldStep, Law, Limits, Linearised, finite};
use crate::curve::FrictionCurve;
use crate::parameter::{self, ParameterError, Rule};
use crate::rheology::{Elements, KelvinVoigt, Rheology};
use crate::scalar::{lit, nan, unlimited};
use crate::{Branch, Bristle, Scalar, Sliding};

/// Which branch of a folded inversion to follow.
///
/// Where σ1 is too small for the fall of the curve, several tip velocities carry the same load. The
/// state is the deflection only, so that a branch is not remembered: the rule picks one at every
/// state, and the tip velocity jumps where that branch ends.
///
/// A curve with several valleys has more branches. Up to the first summit of Φ and beyond its last
/// valley the rules apply unchanged; where neither has an answer, one in between is taken, always
/// the same at the same state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum FoldRule {
    /// The slowest: the tip sticks, or creeps, as long as the surface can hold it, and then breaks
    /// away.
    Slowest,
    /// The fastest: the tip slides as soon as the surface can keep it sliding, and sticks
    /// otherwise.
    Fastest,
}

/// The bristle with its force balance solved, of a friction curve C:
/// σ0 z + σ1 ż = μ(v_s) sgn(v_s), v_s = v − ż.
///
/// [`FrBd`](crate::FrBd) is one step of linearisation away from it. It
/// sticks exactly and leaves no drift under loads below breakaway.
///
/// ```
/// use bristle::{Bristle, ImplicitBristle, paper};
/// use bristle::curve::Stribeck;
/// use bristle::rheology::KelvinVoigt;
///
/// let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
/// let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
/// let friction = ImplicitBristle::new(curve, bristle, None)?;
/// // 1.2 of 1.5 carried, at rest: it sticks, and the bristle follows the body.
/// assert_eq!(friction.rate(1e-3, 1.2e-4), 1e-3);
/// // Steady sliding is on the curve, as with FrBD; disturbances fade at 418 1/s and not at 32 1/s.
/// let steady = friction.stationary(5.5e-3);
/// assert!((friction.linearised(5.5e-3, steady).rate_by_deflection + 418.0).abs() < 0.5);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
///
/// # Cost
///
/// Each evaluation solves one scalar equation by Newton's method within a bracket. Four to six
/// evaluations of the curve are usual, 160 is the most. While the tip sticks, one is enough.
///
/// # In a mechanism
///
/// Besides reversals the field has a kink where the tip begins or ceases to stick, which
/// [`stick_excess`](Self::stick_excess) tells; an adaptive method finds it by rejecting steps.
/// There is no kink at v = 0. In the stick-slip rig of the paper, 60 s, it takes 1.4 times the
/// evaluations of FrBD at a loose tolerance and as many at a tight one:
///
/// | relative tolerance | 1e-4 | 1e-6 | 1e-8 | 1e-10 |
/// |---|---|---|---|---|
/// | error of the period \[s\], `DormandPrince8` | 2e-5 | 3e-6 | 4e-8 | 1e-9 |
/// | … of [`DormandPrince`](crate::ode::DormandPrince) | 3e-3 | 4e-6 | 7e-8 | 1e-9 |
/// | … of [`Rodas5P`](crate::ode::Rodas5P) | 9e-5 | 1e-5 | 5e-8 | 1e-9 |
/// | evaluations (FrBD at 1e-4, 1e-8: 15 190, 24 585) | 20 318 | 23 338 | 29 195 | 40 924 |
/// | evaluations, `Rodas5P` | 4 342 | 8 101 | 16 221 | 35 380 |
///
/// The force of such a run is as far off as its tolerance says: 4e-6, 1e-8 and 4e-10 N at worst
/// with `DormandPrince8` at 1e-9, 1e-11 and 1e-12, met where the body stops and the force falls by
/// 56 N/s. The model's own error is below that.
///
/// [`Contact::companion`](crate::Contact::companion) freezes the coefficients at the beginning of a
/// step. That is passive and of first order: the position in this rig after 20 s is 9e-4, 5e-4 and
/// 3e-4 m off with steps of 2.5, 1.25 and 0.6 ms.
///
/// # At a held velocity
///
/// [`Bristle::hold`] follows the tip through a step of any length: it sticks for exactly as long as
/// the surface holds, changes branches by the [`FoldRule`], and slides with an error of about 1e-9
/// of μ/σ0 (2e-6 in `f32`). Two half steps make a whole one, and the
/// work is what is stored and dissipated, within that error.
///
/// Where both branches of a fold lead to it, the load stays at the fold.
///
/// In Table 2 a step evaluates the curve 7 times on average for 10 µs, and 23 times for steps of up
/// to 1000 s; 1500 is the most. If 288 pieces of a step have not sufficed, the rest of it is done
/// with the coefficients frozen, and so is every step of a curve with several folds at one load
/// (see [`FoldRule`]).
///
/// # Compared with FrBD
///
/// Both slide steadily on the curve. FrBD relaxes slowly where it slides slowly: its rate falls
/// with v, this one's does not. In Table 2 at 5.5 mm/s the rates are 31.9 and 418 1/s; loops of
/// frictional lag at 25 to 100 Hz are 0.20 to 0.21 apart in μ_b; the period of stick-slip is
/// 7.7558 s against 7.6393 s. At high speed the forces agree up to σ1σ2μ_d/(σ1 + σ2)².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImplicitBristle<C, T = f64> {
    curve: C,
    rheology: KelvinVoigt<T>,
    fold_rule: Option<FoldRule>,
    /// A lower bound of dμ/d|v|, if Φ is known to rise everywhere.
    least_slope: Option<T>,
    /// Folds of Φ, forward and backward.
    folds: [Option<Fold<T>>; 2],
}

impl<T: Scalar, C: FrictionCurve<T>> ImplicitBristle<C, T> {
    /// Checks that the force balance has a single solution at every state, or a rule which to take
    /// where it is folded. A rule for an inversion that is not folded has no effect.
    ///
    /// # Errors
    ///
    /// Refuses σ1 + σ2 = 0, for which fast sliding could carry no more than slow. Without a fold
    /// rule, refuses a curve that falls as steeply as σ1 or more (the value is σ1 + min dμ/d|v|),
    /// or whose steepest fall is not known (the value is NaN).
    pub fn new(
        curve: C,
        rheology: KelvinVoigt<T>,
        fold_rule: Option<FoldRule>,
    ) -> Result<Self, ParameterError> {
        let damping = rheology.elements(Branch::Forward.of(T::zero())).damping;
        let viscous = curve.viscous_friction();
        parameter::positive("micro_damping + viscous_friction", damping + viscous)?;
        // The solution is unique if and only if σ1 + min dμ/d|v| is positive: above the roundings
        // of the slope.
        let margin = curve.least_slope().map_or_else(nan, |slope| damping + slope);
        let rises = margin > damping * T::default_epsilon() * lit(16.0);
        if !rises && fold_rule.is_none() {
            let rule = Rule::Stated("be positive unless a fold_rule is given");
            return Err(parameter::refused(
                "micro_damping + least slope of the curve",
                margin,
                rule,
            ));
        }
        let least_slope = curve.least_slope().filter(|_| rises);
        let mut implicit = Self { curve, rheology, fold_rule, least_slope, folds: [None; 2] };
        if !rises {
            implicit.folds = [Branch::Forward, Branch::Backward].map(|way| implicit.fold(way));
        }
        Ok(implicit)
    }

    /// The model with its curve in another type.
    pub(super) fn map<C2>(self, curve: impl FnOnce(C) -> C2) -> ImplicitBristle<C2, T> {
        let Self { rheology, fold_rule, least_slope, folds, .. } = self;
        ImplicitBristle { curve: curve(self.curve), rheology, fold_rule, least_slope, folds }
    }

    /// The friction curve.
    pub fn curve(&self) -> &C {
        &self.curve
    }

    /// The bristle.
    pub fn rheology(&self) -> &KelvinVoigt<T> {
        &self.rheology
    }

    /// The branch that is followed where the force balance is folded, as it was given.
    pub fn fold_rule(&self) -> Option<FoldRule> {
        self.fold_rule
    }

    /// Whether the force balance is known to have a single solution at every state.
    pub fn is_single_valued(&self) -> bool {
        self.least_slope.is_some()
    }

    /// σ0 and σ1.
    #[inline]
    fn elements(&self) -> (T, T) {
        let Elements { stiffness, damping, .. } =
            self.rheology.elements(Branch::Forward.of(T::zero()));
        (stiffness, damping)
    }

    /// The sliding velocity of the bristle's tip, v_s = v − ż [m/s]: zero if it sticks.
    #[doc(alias = "v_s")]
    pub fn tip_velocity(&self, velocity: T, deflection: T) -> T {
        let tip = self.tip(velocity, deflection);
        tip.direction * tip.surface.speed
    }

    /// Whether the tip sticks, ż = v.
    pub fn sticks(&self, velocity: T, deflection: T) -> bool {
        self.tip(velocity, deflection).sticks()
    }

    /// |σ0 z + σ1 v| − μ(0) \[–\]: positive if the tip cannot stick, and a kink of the field at
    /// zero, for an [`ode::Event`](crate::ode::Event). With [`FoldRule::Fastest`] it may slip
    /// before.
    pub fn stick_excess(&self, velocity: T, deflection: T) -> T {
        let trial = self.trial(velocity, deflection);
        trial.abs() - self.curve.coefficient(Branch::towards(trial).of(T::zero()))
    }

    /// By the compliance s = |v_s|/μ of the surface, which keeps more digits at low speed than g.
    fn affine_at(&self, tip: &Tip<T>) -> Affine<T> {
        let compliance = tip.surface.speed / tip.surface.mu;
        let (stiffness, damping) = self.elements();
        let drive = T::one() / (T::one() + damping * compliance);
        Affine {
            relaxation: stiffness * (compliance * drive),
            drive,
            stiffness: stiffness * drive,
            damping: damping * drive,
        }
    }

    /// 1/Φ' and f'/Φ'.
    fn shares(&self, tip: &Tip<T>) -> (T, T) {
        if tip.sticks() {
            return (T::zero(), T::one());
        }
        let slope = tip.surface.mu_slope;
        let inverse = T::one() / (self.elements().1 + slope);
        (inverse, slope * inverse)
    }
}

impl<T: Scalar, C: FrictionCurve<T>> Bristle<T> for ImplicitBristle<C, T> {
    type Deflection = T;

    /// The coefficients with the surface taken at the tip velocity: they give rate and force at
    /// this velocity and deflection exactly, and depend on both.
    fn affine(&self, sliding: Sliding<T>, deflection: T) -> Affine<T> {
        self.affine_at(&self.tip(sliding.velocity(), deflection))
    }

    /// The coefficients and their derivatives with respect to the velocity at a fixed deflection.
    fn affine_and_slopes(&self, sliding: Sliding<T>, deflection: T) -> (Affine<T>, Affine<T>) {
        let tip = self.tip(sliding.velocity(), deflection);
        let affine = self.affine_at(&tip);
        let Surface { speed, mu, mu_slope } = tip.surface;
        let (stiffness, damping) = self.elements();
        // ds/dv, with du/dv = ±σ1/Φ'.
        let compliance_slope =
            (mu - speed * mu_slope) / (mu * mu) * (tip.direction * damping * self.shares(&tip).0);
        let share_slope = affine.drive * affine.drive * compliance_slope;
        let drive = -damping * share_slope;
        let slopes = Affine {
            relaxation: stiffness * share_slope,
            drive,
            stiffness: stiffness * drive,
            damping: damping * drive,
        };
        (affine, slopes)
    }

    fn linearised(&self, sliding: impl Into<Sliding<T>>, deflection: T) -> Linearised<T> {
        let velocity = sliding.into().velocity();
        let tip = self.tip(velocity, deflection);
        let affine = self.affine_at(&tip);
        let (inverse, share) = self.shares(&tip);
        let (stiffness, damping) = self.elements();
        Linearised {
            rate: affine.rate(velocity, deflection),
            coefficient: affine.coefficient(velocity, deflection),
            rate_by_deflection: -stiffness * inverse,
            rate_by_velocity: share,
            coefficient_by_deflection: stiffness * share,
            coefficient_by_velocity: damping * share,
        }
    }

    fn hold(&self, velocity: T, deflection: T, duration: T) -> HeldStep<T> {
        self.step(velocity, deflection, duration)
    }

    fn stationary(&self, sliding: impl Into<Sliding<T>>) -> T {
        self.stationary_coefficient(sliding) / self.rheology.storage_stiffness()
    }

    /// On the curve, on any branch.
    fn stationary_coefficient(&self, sliding: impl Into<Sliding<T>>) -> T {
        let sliding = sliding.into();
        sliding.direction() * self.curve.coefficient(sliding)
    }

    fn storage_stiffness(&self) -> T {
        self.rheology.storage_stiffness()
    }

    fn obeys(&self, law: Law) -> bool {
        match law {
            Law::Passivity | Law::BoundedForce | Law::NoDrift => true,
            // On a fold, steady sliding may be on a branch that the rule does not follow.
            Law::SteadySliding => self.is_single_valued(),
            Law::BoundedDeflection => self.limits(T::one()).deflection.is_some(),
            Law::BoundedRelaxation => self.limits(unlimited()).relaxation_rate.is_some(),
            Law::OddSymmetry => self.curve.is_even(),
            Law::Secant => false,
        }
    }

    fn limits(&self, fastest: T) -> Limits<T> {
        Limits::up_to(fastest, |fastest| {
            let mu = self.curve.bounds(fastest).max;
            let (stiffness, damping) = self.elements();
            let relaxation_rate =
                self.least_slope.and_then(|slope| finite(stiffness / (damping + slope)));
            // Without damping a folded bristle sits on its limit and jumps across it.
            let turns_back = damping > T::zero() || self.is_single_valued();
            Limits {
                deflection: if turns_back { finite(mu / stiffness) } else { None },
                coefficient: finite(mu),
                relaxation_rate,
            }
        })
    }
}
