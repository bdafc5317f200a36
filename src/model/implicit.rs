//! The implicit bristle: coefficients, derivatives and bounds from the solved force balance.

mod hold;
mod solve;

use solve::{Tip, UnderTip};

use super::{Affine, Form, HeldStep, Law, Limits, Linearised, finite};
use crate::curve::FrictionCurve;
use crate::parameter::{Checked, Named};
use crate::rheology::{Elements, KelvinVoigt, Rheology};
use crate::scalar::{is_zero, lit};
use crate::{Branch, Bristle, Scalar, Surface};

/// The implicit bristle of a friction curve C: its force balance is solved, so that it sticks
/// exactly and does not drift.
///
/// A bristle (spring σ0 beside a dashpot σ1) presses on the surface with its tip, which slides at
/// v_s = v − ż. It carries what the surface gives at *that* velocity:
///
/// μ_b = F/P = σ0 z + σ1 ż = μ(v_s) sgn(v_s),  that is Φ(v_s) = e with Φ(u) = σ1 u + μ(u) sgn u
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | z | bristle deflection, the state | m |
/// | v, v_s = v − ż | velocity of the body, sliding velocity of the bristle's tip | m/s |
/// | F, P, p | friction force, positive against v > 0; reference load; normal force | N |
/// | e = σ0 z + σ1 v | trial coefficient: what the bristle would carry if it stuck | – |
/// | μ | friction curve, viscous part σ2\|v\| included | – |
/// | σ0, σ1 | normalised micro-stiffness and micro-damping | 1/m, s/m |
///
/// The bristle sticks, v_s = 0 and ż = v, if |e| ≤ μ(0); otherwise the tip slides in the direction
/// of e. There is a single solution if and only if σ1 + dμ/d|v| > 0 at every speed, for the
/// [`Stribeck`](crate::curve::Stribeck) curve with δ = 2 if σ1 + σ2 > 0.858 (μ_s − μ_d)/v_S.
/// Otherwise several velocities of the tip carry the same force, and the model is refused. A normal
/// force above the reference load scales μ, and can bring that about, too: see
/// [`Bristle::folding_scale`].
///
/// Take it to study the bristle equation itself, which [`FrBd`](crate::FrBd) linearises once. For a
/// body that must not drift [`ElastoPlastic`](crate::ElastoPlastic) is cheaper and takes any curve.
///
/// It is passive and its force is bounded: with M the largest μ at the velocities met, |z| ≤ M/σ0
/// stays so and |F| ≤ p M. Disturbances decay at σ0/(σ1 + dμ/d|v|) [1/s], in the falling part of a
/// curve much faster than FrBD's.
///
/// Source: the implicit force balance of Romano et al. (arXiv 2602.09429), section II-A, from which
/// their models follow by one step of linearisation; its solution and laws are derived here.
///
/// ```
/// use bristle::{Bristle, ImplicitBristle, paper};
/// use bristle::curve::Stribeck;
/// use bristle::rheology::KelvinVoigt;
///
/// let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
/// let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
/// let friction = ImplicitBristle::new(curve, bristle)?;
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
/// Besides reversals the field has a kink where the tip begins or ceases to stick, a zero of
/// [`stick_excess`](Self::stick_excess); an adaptive method finds it by rejecting steps. A slip
/// that falls between the stages of a step is found by the
/// [switching function](crate::ode::System::switching_functions).
/// There is no kink at v = 0. In the stick-slip rig of the paper, 60 s, it takes 1.34 times the
/// evaluations of FrBD at a tolerance of 1e-4 and 1.24 times at 1e-8 (`Solver::adaptive`):
///
/// | relative tolerance | 1e-4 | 1e-6 | 1e-8 | 1e-10 |
/// |---|---|---|---|---|
/// | error of the period \[s\], `DormandPrince8` | 2e-5 | 3e-6 | 4e-8 | 1e-9 |
/// | … of [`DormandPrince`](crate::ode::DormandPrince) | 3e-3 | 4e-6 | 7e-8 | 1e-9 |
/// | … of [`Rodas5P`](crate::ode::Rodas5P) | 9e-5 | 1e-5 | 5e-8 | 1e-9 |
/// | evaluations (FrBD at 1e-4, 1e-8: 13 737, 22 267) | 18 395 | 21 710 | 27 516 | 37 178 |
/// | evaluations, `Rodas5P` | 4 411 | 8 137 | 16 280 | 35 415 |
///
/// With `DormandPrince8` at tolerances of 1e-9, 1e-11 and 1e-12 the force of such a run is 4e-6,
/// 1e-8 and 4e-10 N off at worst, where the body stops and the force falls by 56 N/s. The equation
/// of the tip is solved more closely than that.
///
/// [`Contact::companion`](crate::Contact::companion) freezes the coefficients at the beginning of a
/// step. That is passive and of first order: the position in this rig after 20 s is 9e-4, 5e-4 and
/// 3e-4 m off with steps of 2.5, 1.25 and 0.6 ms.
///
/// # At a held velocity
///
/// [`Bristle::hold`] follows the tip through a step of any length: it sticks for exactly as long as
/// the surface holds, and slides with an error of about 1e-9 of μ/σ0 (2e-6 in `f32`). Two half
/// steps make a whole one, and the work is what is stored and dissipated, within that error.
///
/// With Table 2 of the paper ([`paper`](crate::paper)) a step evaluates the curve 7 times on
/// average for 10 µs, and 23 times for steps of up to 1000 s; 1500 is the most. If 288 pieces of a
/// step have not sufficed, the rest of it is done with the coefficients frozen.
///
/// # Compared with FrBD
///
/// Both slide steadily on the curve. FrBD's disturbances decay slowly where it slides slowly: the
/// rate −∂ż/∂z falls with v, this one's does not. With Table 2 at 5.5 mm/s they decay at 31.9 and
/// 418 1/s (the coefficient λ of [`Affine`](crate::Affine) is 31.9 1/s in both); loops of
/// frictional lag at 25 to 100 Hz are 0.20 to 0.21 apart in μ_b; the period of stick-slip is
/// 7.7558 s against 7.6393 s. At high speed the forces agree up to σ1σ2μ_d/(σ1 + σ2)².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImplicitBristle<C, T = f64> {
    curve: C,
    rheology: KelvinVoigt<T>,
    /// A lower bound of dμ/d|v|.
    least_slope: T,
}

impl<T: Scalar, C: FrictionCurve<T>> ImplicitBristle<C, T> {
    /// Checks that the force balance has a single solution at every state.
    ///
    /// # Errors
    ///
    /// Refuses σ1 + σ2 = 0, for which fast sliding could carry no more than slow; a curve that
    /// falls as steeply as σ1 or more (the value is σ1 + min dμ/d|v|), and one whose steepest fall
    /// is not known (the value is NaN).
    pub fn new(curve: C, rheology: KelvinVoigt<T>) -> Checked<Self> {
        let damping = rheology.elements(Branch::Forward.of(T::zero())).damping;
        let viscous = curve.viscous_friction();
        Named("micro_damping + viscous_friction", damping + viscous).positive()?;
        let least_slope = curve.least_slope().unwrap_or_else(T::nan);
        // Above the roundings of the slope.
        let margin = damping + least_slope;
        let rises = margin > damping * T::default_epsilon() * lit(16.0);
        let name = "micro_damping + least slope of the curve";
        Named(name, margin).stated(rises, "be positive, or several tip velocities fit")?;
        Ok(Self { curve, rheology, least_slope })
    }

    /// The model with its curve in another type.
    pub(super) fn map<C2>(self, curve: impl FnOnce(C) -> C2) -> ImplicitBristle<C2, T> {
        let Self { rheology, least_slope, .. } = self;
        ImplicitBristle { curve: curve(self.curve), rheology, least_slope }
    }

    /// The friction curve.
    pub fn curve(&self) -> &C {
        &self.curve
    }

    /// The bristle.
    pub fn rheology(&self) -> &KelvinVoigt<T> {
        &self.rheology
    }

    /// The force balance under a friction scale s.
    #[inline]
    fn balance(&self, scale: T) -> Balance<'_, C, T> {
        let Elements { stiffness, damping, .. } =
            self.rheology.elements(Branch::Forward.of(T::zero()));
        Balance { curve: &self.curve, stiffness, damping, scale }
    }

    /// The sliding velocity of the bristle's tip, v_s = v − ż [m/s]: zero if it sticks.
    #[doc(alias = "v_s")]
    pub fn tip_velocity(&self, surface: impl Into<Surface<T>>, deflection: T) -> T {
        let surface = surface.into();
        let tip = self.balance(surface.scale()).tip(surface.velocity(), deflection);
        tip.direction * tip.surface.speed
    }

    /// Whether the tip sticks, ż = v.
    pub fn sticks(&self, surface: impl Into<Surface<T>>, deflection: T) -> bool {
        is_zero(self.tip_velocity(surface, deflection))
    }

    /// |σ0 z + σ1 v| − s μ(0) \[–\], with the friction scale s: positive if the tip cannot stick.
    /// At its zero the field has a kink, which an [`ode::Event`](crate::ode::Event) can locate.
    pub fn stick_excess(&self, surface: impl Into<Surface<T>>, deflection: T) -> T {
        let surface = surface.into();
        let balance = self.balance(surface.scale());
        let trial = balance.trial(surface.velocity(), deflection);
        trial.abs() - balance.surface(Branch::towards(trial), T::zero()).mu
    }
}

/// The force balance σ0 z + σ1 ż = s μ(v_s) sgn(v_s) of a bristle.
struct Balance<'a, C, T> {
    curve: &'a C,
    stiffness: T,
    damping: T,
    scale: T,
}

impl<T: Scalar, C: FrictionCurve<T>> Balance<'_, C, T> {
    /// FrBD's coefficients with the surface taken at v_s in place of v, by its compliance
    /// s = |v_s|/μ(v_s), which keeps more digits at low speed than g: r e = μ sgn v_s, and
    /// v − ż = s r e = v_s. Sticking is s = 0. Frozen they are passive, because c₀ = σ0 r.
    fn affine_at(&self, tip: &Tip<T>) -> Affine<T> {
        let compliance = tip.surface.speed / tip.surface.mu;
        let (stiffness, damping) = (self.stiffness, self.damping);
        let drive = T::one() / (T::one() + damping * compliance);
        Affine {
            relaxation: stiffness * (compliance * drive),
            drive,
            stiffness: stiffness * drive,
            damping: damping * drive,
        }
    }

    /// 1/Φ' and f'/Φ' with f(u) = μ(u) sgn u. From Φ(v_s) = σ0 z + σ1 v follow ∂ż/∂z = −σ0/Φ',
    /// ∂ż/∂v = f'/Φ', ∂μ_b/∂z = σ0 f'/Φ', ∂μ_b/∂v = σ1 f'/Φ'; where it sticks 0, 1, σ0, σ1.
    fn shares(&self, tip: &Tip<T>) -> (T, T) {
        if tip.sticks() {
            return (T::zero(), T::one());
        }
        let slope = tip.surface.mu_slope;
        let inverse = T::one() / (self.damping + slope);
        (inverse, slope * inverse)
    }
}

impl<T: Scalar, C: FrictionCurve<T>> Bristle<T> for ImplicitBristle<C, T> {
    type Deflection = T;

    /// The coefficients with the surface taken at the tip velocity: they give rate and force at
    /// this velocity and deflection exactly, and depend on both.
    fn affine(&self, surface: Surface<T>, deflection: T) -> Affine<T> {
        let balance = self.balance(surface.scale());
        balance.affine_at(&balance.tip(surface.velocity(), deflection))
    }

    /// The coefficients and their derivatives with respect to the velocity at a fixed deflection.
    fn affine_and_slopes(&self, surface: Surface<T>, deflection: T) -> (Affine<T>, Affine<T>) {
        let balance = self.balance(surface.scale());
        let tip = balance.tip(surface.velocity(), deflection);
        let affine = balance.affine_at(&tip);
        let UnderTip { speed, mu, mu_slope } = tip.surface;
        let Balance { stiffness, damping, .. } = balance;
        // ds/dv, with du/dv = ±σ1/Φ'.
        let compliance_slope = (mu - speed * mu_slope) / (mu * mu)
            * (tip.direction * damping * balance.shares(&tip).0);
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

    fn linearised(&self, surface: impl Into<Surface<T>>, deflection: T) -> Linearised<T> {
        let surface = surface.into();
        let (velocity, balance) = (surface.velocity(), self.balance(surface.scale()));
        let tip = balance.tip(velocity, deflection);
        let affine = balance.affine_at(&tip);
        let (inverse, share) = balance.shares(&tip);
        let Balance { stiffness, damping, .. } = balance;
        Linearised {
            rate: affine.rate(velocity, deflection),
            coefficient: affine.coefficient(velocity, deflection),
            rate_by_deflection: -stiffness * inverse,
            rate_by_velocity: share,
            coefficient_by_deflection: stiffness * share,
            coefficient_by_velocity: damping * share,
        }
    }

    fn hold(&self, surface: impl Into<Surface<T>>, deflection: T, duration: T) -> HeldStep<T> {
        let surface = surface.into();
        self.balance(surface.scale()).step(surface.velocity(), deflection, duration)
    }

    fn stationary(&self, surface: impl Into<Surface<T>>) -> T {
        self.stationary_coefficient(surface) / self.rheology.storage_stiffness()
    }

    /// On the curve, on any branch.
    fn stationary_coefficient(&self, surface: impl Into<Surface<T>>) -> T {
        let surface = surface.into();
        surface.direction() * surface.friction(&self.curve)
    }

    fn storage_stiffness(&self) -> T {
        self.rheology.storage_stiffness()
    }

    /// σ1 = −s min dμ/d|v|.
    fn folding_scale(&self) -> Option<T> {
        let damping = self.rheology.elements(Branch::Forward.of(T::zero())).damping;
        (self.least_slope < T::zero()).then(|| -damping / self.least_slope)
    }

    /// [`ImplicitBristle::stick_excess`].
    fn switching_function(&self, surface: Surface<T>, deflection: T) -> Option<T> {
        Some(self.stick_excess(surface, deflection))
    }

    fn form(&self) -> Form {
        Form::Solved
    }

    fn name(&self) -> &'static str {
        "implicit bristle"
    }

    fn obeys(&self, law: Law) -> bool {
        match law {
            Law::Passivity | Law::BoundedForce | Law::NoDrift | Law::SteadySliding => true,
            Law::BoundedDeflection => self.limits(T::one()).deflection.is_some(),
            Law::BoundedRelaxation => self.limits(T::unlimited()).relaxation_rate.is_some(),
            Law::OddSymmetry => self.curve.is_even(),
            Law::Secant => false,
        }
    }

    // Let M be the largest μ up to a speed V ≥ |v|, and |z| ≤ M/σ0. If |v_s| ≤ V, then |F| ≤ p M
    // by the choice of M; else |F|/p = |e| − σ1|v_s| ≤ M + σ1 (V − |v_s|) ≤ M. With σ1 > 0, at
    // z = M/σ0 that gives σ1 (v_s − v) = M − F/p ≥ 0, so ż ≤ 0. Passivity:
    // F v − Ẇ = F v_s + p σ1 ż² ≥ 0.
    fn limits(&self, fastest: T) -> Limits<T> {
        Limits::up_to(fastest, |fastest| {
            let mu = self.curve.bounds(fastest).max;
            let Balance { stiffness, damping, .. } = self.balance(T::one());
            Limits {
                deflection: finite(mu / stiffness),
                coefficient: finite(mu),
                relaxation_rate: finite(stiffness / (damping + self.least_slope)),
            }
        })
    }
}
