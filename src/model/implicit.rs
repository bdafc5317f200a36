//! The bristle whose force balance is solved, not approximated: it sticks exactly and does not drift.
//!
//! A bristle (spring σ0 beside a dashpot σ1) presses on the sliding surface with the tip, which
//! slides at v_s = v − ż. What it carries is what the surface gives at *that* velocity:
//!
//! σ0 z + σ1 ż = μ(v_s) sgn_ε(v_s)
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | z | bristle deflection | m |
//! | v, v_s = v − ż | velocity of the body, sliding velocity of the bristle's tip | m/s |
//! | e = σ0 z + σ1 v | trial coefficient: what the bristle would carry if it stuck | – |
//! | μ | friction curve | – |
//! | σ0, σ1, σ2 | micro-stiffness, micro-damping, viscous friction (a part of μ) | 1/m, s/m, s/m |
//! | \|v\|_ε, sgn_ε | regularised modulus and sign | m/s, – |
//!
//! [`FrBd`](crate::FrBd) makes one Newton-like step of this equation. Here it is solved: with ż = v − v_s it is one
//! scalar equation,
//!
//! Φ(v_s) = e,  Φ(u) = σ1 u + μ(u) sgn_ε(u).
//!
//! Without regularisation the bristle sticks, v_s = 0 and ż = v, if |e| ≤ μ(0); otherwise the tip slides
//! the way of e. Φ rises, and there is one answer, iff σ1 + dμ/d|v| > 0 at every speed: for the
//! [`Stribeck`](crate::curve::Stribeck) curve with δ = 2 iff σ1 + σ2 > (μ_s − μ_d)√(2/e)/v_S. Otherwise Φ is folded and the caller says
//! by a [`FoldRule`] which of its branches to follow.
//!
//! # The affine form
//!
//! At the answer, FrBD's own coefficients with the surface frozen at v_s in place of v,
//!
//! s = |v_s|_ε/μ(v_s),  λ = σ0 s r,  r = 1/(1 + σ1 s),  c₀ = σ0 r,  c₂ = σ1 r,
//!
//! give the rate and the force of this model exactly: r e = μ sgn_ε(v_s), and v − ż = s r e = v_s.
//! Sticking is s = 0. A step with these coefficients frozen is passive, because c₀ = σ0 r. They depend
//! on z, so such a step is of first order. At a held velocity the tip can be followed instead, see
//! [`ImplicitBristle`].
//!
//! # Derivatives
//!
//! By differentiating Φ(v_s) = σ0 z + σ1 v, with f(u) = μ(u) sgn_ε(u) and Φ' = σ1 + f':
//!
//! ∂ż/∂z = −σ0/Φ',  ∂ż/∂v = f'/Φ',  ∂μ_b/∂z = σ0 f'/Φ',  ∂μ_b/∂v = σ1 f'/Φ'
//!
//! and 0, 1, σ0, σ1 where it sticks.
//!
//! # Laws
//!
//! F v − Ẇ = F v_s + p σ1 ż² ≥ 0 for W = ½ p σ0 z², whatever the branch: both terms are squares or have
//! the same sign. Let M be the largest μ up to a speed V ≥ |v|. From |z| ≤ M/σ0 follows |F| ≤ p M: if
//! |v_s| ≤ V by the choice of M, and if |v_s| > V because |F|/p = |e| − σ1|v_s| ≤ M + σ1 (V − |v_s|).
//! With σ1 > 0, at z = M/σ0 that gives σ1 (v_s − v) = M − F/p ≥ 0, so ż ≤ 0: the deflection turns
//! back at M/σ0. Disturbances decay at σ0/Φ' ≤ σ0/(σ1 + min dμ/d|v|), in the falling part of a
//! curve much faster than FrBD's.
//!
//! Source: the implicit force balance of Romano et al. (arXiv 2602.09429), section II-A, from which
//! their models follow by one step of linearisation; its solution and laws are derived here.

mod hold;

use super::{Affine, HeldStep, Law, Limits, Linearised, finite, unlimited};
use crate::bounds::smaller;
use crate::curve::FrictionCurve;
use crate::parameter::{self, ParameterError, Rule};
use crate::regularisation::{Regularisation, Unregularised};
use crate::rheology::{Elements, KelvinVoigt, Rheology};
use crate::scalar::{is_zero, lit, nan, to_f64};
use crate::{Branch, Bristle, Scalar, Sliding};

/// Which branch of a folded inversion to follow, told by the state alone.
///
/// Where σ1 is too small for the fall of the curve, several tip velocities carry the same load. The
/// state is the deflection only, so a branch is not remembered: a rule picks one at every state, and
/// the tip velocity jumps where that branch ends.
///
/// A curve with several valleys has more branches. Up to the first summit of Φ and beyond its last valley
/// the rules hold as they stand; where neither has an answer, one in between is taken, always the
/// same at the same state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FoldRule {
    /// The slowest: the tip sticks, or creeps, as long as the surface can hold it, and then breaks away.
    Slowest,
    /// The fastest: the tip slides as soon as the surface can keep it sliding, and sticks otherwise.
    Fastest,
}

/// Parameters of [`ImplicitBristle`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImplicitBristleParameters<C, T = f64> {
    /// Friction curve.
    pub curve: C,
    /// Kelvin–Voigt bristle of constant stiffness σ0 and damping σ1, with σ1 + σ2 > 0.
    pub rheology: KelvinVoigt<T>,
    /// What to do where the inversion is folded. With `None` a folded one is refused; with a rule one
    /// that turns out not to be folded does not need it.
    pub fold_rule: Option<FoldRule>,
}

/// The bristle with its force balance solved, of a friction curve C and a regularisation E:
/// σ0 z + σ1 ż = μ(v_s) sgn_ε(v_s), v_s = v − ż. [`FrBd`](crate::FrBd) is one step of linearisation away from it.
///
/// Without regularisation it sticks exactly and leaves no drift under loads below breakaway.
///
/// ```
/// use bristle::{Bristle, ImplicitBristle, ImplicitBristleParameters, paper};
/// use bristle::curve::Stribeck;
/// use bristle::rheology::KelvinVoigt;
///
/// let friction = ImplicitBristle::new(ImplicitBristleParameters {
///     curve: Stribeck::new(paper::STICK_SLIP_CURVE)?,
///     rheology: KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?,
///     fold_rule: None,
/// })?;
/// // 1.2 of 1.5 carried, at rest: it sticks, and the bristle follows the body.
/// assert_eq!(friction.rate(1e-3, 1.2e-4), 1e-3);
/// // Steady sliding is on the curve, as with FrBD; disturbances fade at 418 1/s and not at 32 1/s.
/// let steady = friction.stationary(5.5e-3);
/// assert!((friction.relaxation_rate(5.5e-3, steady) - 418.0).abs() < 0.5);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
///
/// # Cost
///
/// Each evaluation solves one scalar equation by Newton's method, kept within a bracket. Some four to six
/// evaluations of the curve are usual; 160 is the most that can happen. While the tip sticks, one is enough.
///
/// # In a mechanism
///
/// Besides reversals the field has a kink where the tip begins and ends to stick, which
/// [`stick_excess`](Self::stick_excess) tells; an adaptive method finds it by rejecting steps. There is no kink at v = 0. In the stick-slip rig of
/// the paper, 60 s, it takes 1.4 times the evaluations of FrBD at a loose tolerance and as many
/// at a tight one:
///
/// | relative tolerance | 1e-4 | 1e-6 | 1e-8 | 1e-10 |
/// |---|---|---|---|---|
/// | error of the period \[s\], [`DormandPrince8`](crate::ode::DormandPrince8) | 2e-5 | 3e-6 | 4e-8 | 1e-9 |
/// | … of [`DormandPrince`](crate::ode::DormandPrince) | 3e-3 | 4e-6 | 7e-8 | 1e-9 |
/// | … of [`Rodas5P`](crate::ode::Rodas5P) | 9e-5 | 1e-5 | 5e-8 | 1e-9 |
/// | evaluations, `DormandPrince8` (FrBD at 1e-4 and 1e-8: 15 190, 24 585) | 20 318 | 23 338 | 29 195 | 40 924 |
/// | evaluations, `Rodas5P` | 4 342 | 8 101 | 16 221 | 35 380 |
///
/// [`Contact::companion`](crate::Contact::companion) freezes the coefficients at the beginning of a step: passive,
/// and of first order (position in the same rig after 20 s: 9e-4, 5e-4, 3e-4 m off with steps of 2.5, 1.25
/// and 0.6 ms), for it learns within a step neither of breaking away nor of the tip's velocity.
///
/// # At a held velocity
///
/// [`Bristle::hold`] follows the tip through the step, however long: it sticks for exactly as long as the surface holds, goes over
/// from branch to branch by the [`FoldRule`], and slides with an error of some 1e-9 of μ/σ0 (of 2e-6 in `f32`, 1e-4 with a regularisation). Where the rule
/// has both branches lead to the fold, it stays there, at the load of the summit or the valley: the tip changes
/// back and forth without end. Work is what is stored and dissipated, and two half steps make a whole one, within
/// that error.
///
/// Besides the first tip a step looks at the curve four times for each piece that it tries; in Table 2 that is 7 times on average for
/// 10 µs and 23 for steps of up to 1000 s, from anywhere. A regularised tip that creeps for a while and then slides takes
/// some hundred, and fewer than 500 were met in thousands; 1500 is the most that can happen. From 96 pieces on the accuracy is let go
/// step by step, and after 288 what is left is done with the coefficients frozen, as it is altogether where several folds are met
/// by one load (see [`FoldRule`]).
///
/// # Beside FrBD
///
/// Both slide steadily on the curve. In between FrBD is slow where it is slow itself: its rate falls
/// with v, this one's does not. In Table 2 at 5.5 mm/s that is 31.9 against 418 1/s; loops of frictional lag at 25 to
/// 100 Hz are 0.20 to 0.21 apart in μ_b, the period of stick-slip is 7.7558 s against 7.6393 s. At high
/// speed the forces agree but for σ1σ2μ_d/(σ1 + σ2)².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImplicitBristle<C, E = Unregularised, T = f64> {
    curve: C,
    rheology: KelvinVoigt<T>,
    regularisation: E,
    fold_rule: Option<FoldRule>,
    /// The largest known to be below dμ/d|v|, if Φ is known to rise everywhere.
    least_slope: Option<T>,
    /// Folds of Φ, forward and backward.
    folds: [Option<Fold<T>>; 2],
}

/// A fold of Φ: it rises to the summit and again from the valley on.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Fold<T> {
    /// Speed of the (first) summit [m/s] and Φ there.
    summit: (T, T),
    /// Speed of the (last) valley [m/s] and Φ there.
    valley: (T, T),
    /// Speed [m/s] on the branch beyond that carries as much as the summit, with [`FoldRule::Slowest`]; on the branch
    /// before that carries as much as the valley, or zero, with [`FoldRule::Fastest`].
    other: T,
}

impl<T: Scalar, C: FrictionCurve<T>> ImplicitBristle<C, Unregularised, T> {
    /// Checks that the equation has an answer at every state, and one only, or a rule which to take.
    ///
    /// # Errors
    ///
    /// Refuses σ1 + σ2 = 0, for which fast sliding could carry no more than slow; and without a
    /// fold rule a curve that falls as steeply as σ1 or more (the value is σ1 + min dμ/d|v|), or whose steepest
    /// fall is not known (the value is NaN).
    pub fn new(parameters: ImplicitBristleParameters<C, T>) -> Result<Self, ParameterError> {
        let ImplicitBristleParameters { curve, rheology, fold_rule } = parameters;
        let (_, damping) = elements(&rheology);
        parameter::positive(
            "micro_damping + viscous_friction",
            damping + curve.viscous_friction(),
        )?;
        let margin = Self::margin(&curve, &rheology);
        // Above the roundings of the slope.
        let rounding = damping * T::default_epsilon() * lit(16.0);
        let rises = margin.is_some_and(|margin| margin > rounding);
        if !rises && fold_rule.is_none() {
            return Err(ParameterError {
                name: "micro_damping + least slope of the curve",
                component: None,
                value: margin.map_or(f64::NAN, to_f64),
                rule: Rule::PositiveUnless { instead: "a fold_rule is given" },
            });
        }
        let least_slope = if rises { curve.least_slope() } else { None };
        let implicit = Self {
            curve,
            rheology,
            regularisation: Unregularised,
            fold_rule,
            least_slope,
            folds: [None; 2],
        };
        Ok(implicit.regularised(Unregularised))
    }

    /// σ1 + min dμ/d|v| [s/m]: the inversion is single-valued iff it is positive. `None` if the curve
    /// cannot tell its least slope.
    pub fn margin(curve: &C, rheology: &KelvinVoigt<T>) -> Option<T> {
        curve.least_slope().map(|slope| elements(rheology).1 + slope)
    }
}

impl<T: Scalar, C, E> ImplicitBristle<C, E, T> {
    /// The same model with another regularisation of |v_s|: it then creeps where it stuck.
    ///
    /// A regularisation never folds what is not folded without it.
    pub fn regularised<F: Regularisation<T>>(self, regularisation: F) -> ImplicitBristle<C, F, T>
    where
        C: FrictionCurve<T>,
    {
        let mut implicit = ImplicitBristle {
            curve: self.curve,
            rheology: self.rheology,
            regularisation,
            fold_rule: self.fold_rule,
            least_slope: self.least_slope,
            folds: [None; 2],
        };
        if implicit.least_slope.is_none() {
            let forward = implicit.fold(Branch::Forward);
            let same = implicit.curve.is_even();
            let backward = if same { forward } else { implicit.fold(Branch::Backward) };
            implicit.folds = [forward, backward];
        }
        implicit
    }

    /// The friction curve.
    pub fn curve(&self) -> &C {
        &self.curve
    }

    /// The bristle.
    pub fn rheology(&self) -> &KelvinVoigt<T> {
        &self.rheology
    }

    /// The regularisation.
    pub fn regularisation(&self) -> &E {
        &self.regularisation
    }

    /// The rule for a folded inversion.
    pub fn fold_rule(&self) -> Option<FoldRule> {
        self.fold_rule
    }

    /// Whether the inversion is known to have one answer at every state.
    pub fn is_single_valued(&self) -> bool {
        self.least_slope.is_some()
    }
}

/// σ0 and σ1.
#[inline]
fn elements<T: Scalar>(rheology: &KelvinVoigt<T>) -> (T, T) {
    let Elements { stiffness, damping, .. } = rheology.elements(Sliding::from(T::zero()));
    (stiffness, damping)
}

/// Newton steps before a bracket that is still open is halved at every other step.
const FREE: u32 = 8;

/// Most evaluations of one inversion. With a lower end at zero a halving takes the upper one down by
/// 1e-4: eleven of them for 40 decades, then 5 until the ends are within a factor of 16, then 56 for the digits of an
/// `f64`, together 72; every other step after the free ones is such a halving.
const MOST: u32 = 160;

/// The surface under the tip at one speed.
#[derive(Debug, Clone, Copy)]
struct Surface<T> {
    speed: T,
    /// μ and dμ/d|v|.
    mu: T,
    mu_slope: T,
    /// |u|_ε and its slope.
    modulus: T,
    modulus_slope: T,
    /// f = μ sgn_ε and f'.
    carried: T,
    carried_slope: T,
}

/// The state of the tip.
#[derive(Debug, Clone, Copy)]
struct Tip<T> {
    /// ±1, the way in which it slides or would slide.
    direction: T,
    surface: Surface<T>,
    /// At rest for a range of loads (never with a regularisation).
    sticks: bool,
}

impl<T, C, E> ImplicitBristle<C, E, T>
where
    T: Scalar,
    C: FrictionCurve<T>,
    E: Regularisation<T>,
{
    /// The sliding velocity of the bristle's tip, v_s = v − ż [m/s]: zero if it sticks.
    #[doc(alias = "v_s")]
    pub fn tip_velocity(&self, velocity: T, deflection: T) -> T {
        let tip = self.tip(velocity, deflection);
        tip.direction * tip.surface.speed
    }

    /// Whether the tip sticks, ż = v. Never with a regularisation.
    pub fn sticks(&self, velocity: T, deflection: T) -> bool {
        self.tip(velocity, deflection).sticks
    }

    /// |σ0 z + σ1 v| − μ(0) \[–\]: positive if the tip cannot stick, and a kink of the field at
    /// zero, for an [`ode::Event`](crate::ode::Event). (With [`FoldRule::Fastest`] it may slip before.)
    pub fn stick_excess(&self, velocity: T, deflection: T) -> T {
        let trial = self.trial(velocity, deflection);
        trial.abs() - self.curve.coefficient(Branch::towards(trial).of(T::zero()))
    }

    /// σ0 and σ1.
    #[inline]
    fn elements(&self) -> (T, T) {
        elements(&self.rheology)
    }

    /// e = σ0 z + σ1 v.
    #[inline]
    fn trial(&self, velocity: T, deflection: T) -> T {
        let (stiffness, damping) = self.elements();
        stiffness * deflection + damping * velocity
    }

    /// The surface at a tip speed in one direction.
    #[inline]
    fn surface(&self, branch: Branch, speed: T) -> Surface<T> {
        let forward = Branch::Forward.of(speed);
        let sliding = if branch == Branch::Backward { branch.of(-speed) } else { forward };
        let (mu, slope) = self.curve.coefficient_and_slope(sliding);
        // By the speed: the slope comes with the sign of the direction.
        let mu_slope = slope * sliding.direction();
        let (modulus, modulus_slope) = self.regularisation.speed_and_slope(forward);
        let (sign, sign_slope) = self.regularisation.sign_and_slope(forward);
        Surface {
            speed,
            mu,
            mu_slope,
            modulus,
            modulus_slope,
            carried: mu * sign,
            carried_slope: mu_slope * sign + mu * sign_slope,
        }
    }

    /// Solves Φ(v_s) = e.
    #[inline]
    fn tip(&self, velocity: T, deflection: T) -> Tip<T> {
        let trial = self.trial(velocity, deflection);
        let (branch, direction, size) = if trial < T::zero() {
            (Branch::Backward, -T::one(), -trial)
        } else {
            (Branch::Forward, T::one(), trial)
        };
        let zero = T::zero();
        let rest = self.surface(branch, zero);
        let tip = |surface, sticks| Tip { direction, surface, sticks };
        if !size.is_finite() {
            return tip(Surface { speed: nan(), mu: nan(), ..rest }, false);
        }
        let exact = rest.carried > zero;
        let fold = self.folds.get(usize::from(branch == Branch::Backward)).and_then(|fold| *fold);
        // From where on, what Φ is there, and how far.
        let ((low, carried), high) = match (fold, self.fold_rule) {
            (Some(Fold { summit, valley, .. }), Some(rule)) => {
                let (slow, fast) = (((zero, rest.carried), Some(summit.0)), (valley, None));
                let between = (summit, Some(valley.0));
                match (rule, size <= summit.1, size >= valley.1) {
                    (FoldRule::Slowest, true, _) | (FoldRule::Fastest, true, false) => slow,
                    (_, _, true) => fast,
                    (FoldRule::Slowest, ..) => (summit, None),
                    (FoldRule::Fastest, ..) => between,
                }
            }
            _ => ((zero, rest.carried), None),
        };
        if is_zero(low) && rest.carried >= size {
            return tip(rest, exact);
        }
        let (_, damping) = self.elements();
        let viscous = self.curve.viscous_friction();
        // Φ(u) ≥ σ1 u + σ2 u²/(u + |0|_ε) > σ1 u + σ2 (u − |0|_ε), which is e at this u.
        let farthest = (size + viscous * self.regularisation.speed_at_rest()) / (damping + viscous);
        // A few roundings beyond, so that it is not met by a step that should end short of it.
        let farthest = farthest * (T::one() + T::default_epsilon() * lit(8.0));
        let high = high.map_or(farthest, |high| smaller(high, farthest));
        // Beyond μ(0), or from a valley on, a straight line; a regularised tip below that creeps.
        let share = size / rest.mu;
        let guess = if share < T::one() && is_zero(low) {
            rest.modulus * share / (T::one() - share * share).sqrt()
        } else {
            let carried = if is_zero(low) { rest.mu } else { carried };
            low + (size - carried) / (damping + viscous)
        };
        tip(self.root(branch, size, (low, high), guess), false)
    }

    /// The surface where Φ(u) = `size`, within a bracket.
    fn root(&self, branch: Branch, size: T, bracket: (T, T), guess: T) -> Surface<T> {
        let (mut low, mut high) = bracket;
        let (_, damping) = self.elements();
        let epsilon = T::default_epsilon();
        let least_rise = epsilon.sqrt() * (damping + self.curve.viscous_friction());
        let mut speed = if guess > low && guess < high { guess } else { middle(low, high) };
        let mut round = 0;
        loop {
            round += 1;
            // Of a dual number the value alone: the last correction brings the derivative.
            speed = lit(to_f64(speed));
            let here = self.surface(branch, speed);
            let excess = damping * speed + here.carried - size;
            let correction = excess / (damping + here.carried_slope);
            if excess < T::zero() {
                low = speed;
            } else {
                high = speed;
            }
            let newton = speed - correction;
            // Next to a fold, where Φ is flat, roundings over its slope are no small step.
            let steep = damping + here.carried_slope > least_rise;
            let admissible = newton >= low && newton <= high && steep;
            let rounding = epsilon * lit(2.0) * (damping * speed + here.carried + size);
            let arrived = excess.abs() <= rounding || correction.abs() <= epsilon * speed;
            let inside = newton > low && newton < high;
            let next = if inside && (round <= FREE || round % 2 == 0) {
                newton
            } else {
                middle(low, high)
            };
            let closed = !(next > low && next < high);
            if arrived || closed {
                if !admissible {
                    return here;
                }
                // One more step, a few roundings long, to first order.
                return Surface {
                    speed: newton,
                    mu: here.mu - here.mu_slope * correction,
                    modulus: here.modulus - here.modulus_slope * correction,
                    ..here
                };
            }
            if round >= MOST {
                return here;
            }
            speed = next;
        }
    }

    /// The fold of Φ in one direction, if it has one. Φ is looked at from 1e-12 to 1e6 m/s, at
    /// sixteen speeds to each doubling; a fall between two of these is too shallow to matter.
    #[cold]
    fn fold(&self, branch: Branch) -> Option<Fold<T>> {
        const PER_DOUBLING: u32 = 16;
        const DOUBLINGS: u32 = 60;
        let (_, damping) = self.elements();
        let rises = |speed: T| damping + self.surface(branch, speed).carried_slope >= T::zero();
        let exact = is_zero(self.regularisation.speed_at_rest());
        // Next to rest, where |v|^δ with δ < 1 falls steepest.
        let next: T = lit(1e-30);
        // Brackets of the first summit, if it is not at rest, and of the last valley.
        let ratio = lit::<T>(2.0).powf(lit(1.0 / f64::from(PER_DOUBLING)));
        let (mut summit, mut valley) = (None, None);
        let (mut before, mut speed, mut rose) = (T::zero(), lit(1e-12), true);
        for _ in 0..DOUBLINGS * PER_DOUBLING {
            let up = rises(speed);
            if !up {
                summit = summit.or(Some((before, speed)));
            } else if !rose {
                valley = Some((before, speed));
            }
            (before, speed, rose) = (speed, speed * ratio, up);
        }
        let (summit, valley) = (summit?, valley?);
        let turn = |(mut low, mut high): (T, T), first: bool| {
            for _ in 0..200 {
                let middle = (low + high) * lit(0.5);
                if rises(middle) == first { low = middle } else { high = middle }
            }
            let place = (low + high) * lit(0.5);
            (place, damping * place + self.surface(branch, place).carried)
        };
        // From rest on it falls if it does just beyond: at rest |v|^δ with δ < 1 does not tell.
        let summit = if exact && !rises(next) {
            (T::zero(), self.surface(branch, T::zero()).carried)
        } else {
            turn(summit, true)
        };
        let valley = turn(valley, false);
        let other = match self.fold_rule {
            Some(FoldRule::Fastest) => {
                let rest = self.surface(branch, T::zero());
                if rest.carried >= valley.1 {
                    T::zero()
                } else {
                    let ends = (T::zero(), summit.0);
                    self.root(branch, valley.1, ends, middle(ends.0, ends.1)).speed
                }
            }
            _ => {
                // As in the solution of the balance.
                let viscous = self.curve.viscous_friction();
                let rise = damping + viscous;
                let farthest = (summit.1 + viscous * self.regularisation.speed_at_rest()) / rise;
                let ends = (valley.0, farthest * (T::one() + T::default_epsilon() * lit(8.0)));
                self.root(branch, summit.1, ends, valley.0 + (summit.1 - valley.1) / rise).speed
            }
        };
        Some(Fold { summit, valley, other })
    }
}

/// The place to halve a bracket: in the middle of its ends where these are close, of their logarithms where not.
fn middle<T: Scalar>(low: T, high: T) -> T {
    if high <= low * lit(16.0) {
        (low + high) * lit(0.5)
    } else {
        let least = high * lit(1e-8);
        let low = if low > least { low } else { least };
        low.sqrt() * high.sqrt()
    }
}

impl<T, C, E> ImplicitBristle<C, E, T>
where
    T: Scalar,
    C: FrictionCurve<T>,
    E: Regularisation<T>,
{
    fn affine_at(&self, tip: &Tip<T>) -> Affine<T> {
        let compliance = tip.surface.modulus / tip.surface.mu;
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
        if tip.sticks {
            return (T::zero(), T::one());
        }
        let slope = tip.surface.carried_slope;
        let inverse = T::one() / (self.elements().1 + slope);
        (inverse, slope * inverse)
    }
}

impl<T, C, E> Bristle<T> for ImplicitBristle<C, E, T>
where
    T: Scalar,
    C: FrictionCurve<T>,
    E: Regularisation<T>,
{
    type Deflection = T;

    /// The coefficients with the surface frozen at the tip velocity: they give rate and force at this
    /// velocity and deflection exactly, and depend on both.
    fn affine(&self, sliding: Sliding<T>, deflection: T) -> Affine<T> {
        self.affine_at(&self.tip(sliding.velocity(), deflection))
    }

    /// The coefficients and their derivatives with respect to the velocity at a fixed deflection.
    fn affine_and_slopes(&self, sliding: Sliding<T>, deflection: T) -> (Affine<T>, Affine<T>) {
        let tip = self.tip(sliding.velocity(), deflection);
        let affine = self.affine_at(&tip);
        let Surface { mu, mu_slope, modulus, modulus_slope, .. } = tip.surface;
        let (stiffness, damping) = self.elements();
        // ds/dv, with du/dv = ±σ1/Φ'.
        let compliance_slope = (modulus_slope * mu - modulus * mu_slope) / (mu * mu)
            * (tip.direction * damping * self.shares(&tip).0);
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

    /// The rate −∂ż/∂z = σ0/Φ'(v_s) [1/s] at which a small disturbance fades at a held velocity; zero
    /// where it sticks. (The λ of [`Bristle::affine`] is the one of the chord, which for
    /// steady sliding is FrBD's.)
    fn relaxation_rate(&self, sliding: impl Into<Sliding<T>>, deflection: T) -> T {
        let tip = self.tip(sliding.into().velocity(), deflection);
        self.rheology.storage_stiffness() * self.shares(&tip).0
    }

    fn hold(&self, velocity: T, deflection: T, duration: T) -> HeldStep<T> {
        self.step(velocity, deflection, duration)
    }

    fn stationary(&self, sliding: impl Into<Sliding<T>>) -> T {
        let sliding = sliding.into();
        let coefficient = self.regularisation.sign(sliding) * self.curve.coefficient(sliding);
        coefficient / self.rheology.storage_stiffness()
    }

    /// On the curve, on any branch.
    fn stationary_coefficient(&self, sliding: impl Into<Sliding<T>>) -> T {
        let sliding = sliding.into();
        self.regularisation.sign(sliding) * self.curve.coefficient(sliding)
    }

    fn storage_stiffness(&self) -> T {
        self.rheology.storage_stiffness()
    }

    fn obeys(&self, law: Law) -> bool {
        match law {
            Law::Passivity | Law::BoundedForce => true,
            // On a fold, steady sliding may be on a branch that the rule does not follow.
            Law::SteadySliding => self.is_single_valued(),
            Law::NoDrift => is_zero(self.regularisation.speed_at_rest()),
            Law::BoundedDeflection => self.limits(T::one()).deflection.is_some(),
            Law::BoundedRelaxation => self.limits(unlimited()).relaxation_rate.is_some(),
            Law::OddSymmetry => self.curve.is_even(),
            Law::Secant => false,
        }
    }

    fn limits(&self, fastest: T) -> Limits<T> {
        let fastest = fastest.abs();
        if !(fastest >= T::zero()) {
            return Limits::none();
        }
        let mu = self.curve.bounds(fastest).max;
        let (stiffness, damping) = self.elements();
        let exact = is_zero(self.regularisation.speed_at_rest());
        let relaxation_rate = self.least_slope.and_then(|slope| {
            // (μ sgn_ε)' ≥ μ' sgn_ε with sgn_ε ≤ 1: a rise may be lost to the regularisation.
            let slope = if exact { slope } else { smaller(slope, T::zero()) };
            finite(stiffness / (damping + slope))
        });
        // Without damping a folded bristle sits on its limit and jumps across it.
        let turns_back = damping > T::zero() || self.is_single_valued();
        Limits {
            deflection: if turns_back { finite(mu / stiffness) } else { None },
            coefficient: finite(mu),
            relaxation_rate,
        }
    }
}
