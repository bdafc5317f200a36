//! How long a step may be: where explicit methods become unstable on friction.
//!
//! A contact has two fast motions, and a step that is too long makes them grow.
//!
//! **The bristle at a held velocity** relaxes, ż = −λ(v) z + …. A disturbance of it dies out in a
//! method with stability function R only if |R(−λh)| ≤ 1.
//!
//! **The stuck mechanism** oscillates on its bristles. Near v = 0, on the branch s = sgn v,
//!
//! ż = (μ v − σ0|v| z)/g  ⇒  ∂ż/∂v = 1 − s σ0 z/μ_s = c,
//!
//! μ_b = σ0 z + σ1 ż  ⇒  ∂F/∂v = σ1 c p, ∂F/∂z = σ0 p,
//!
//! while ∂ż/∂z = −λ(0) = 0, so that m v̇ = −k x − d v − F has the characteristic equation
//!
//! m s² + (σ1 c p + d) s + (σ0 c p + k) = 0.
//!
//! A contact that starts from rest (z = 0) has c = 1. One that comes to rest and turns round keeps
//! the deflection −s μ_s/σ0 of the sliding before, and has c = 2: the bristle unbends with the body
//! and relaxes at once. (Classical LuGre adds σ2 p to the damping; an elasto-plastic bristle sticks
//! after a reversal and keeps c = 1.) A step is stable if |R(hs)| ≤ 1 for both roots.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | h | step | s |
//! | m, k, d | mass, stiffness and damping of the mechanism without its friction | kg, N/m, N s/m |
//! | p | normal force | N |
//! | σ0, σ1, σ2 | stiffness, damping, viscous friction per unit of it | 1/m, s/m, s/m |
//! | μ_s, g | static coefficient, resistance of the bristle | – |
//! | λ | relaxation rate at a held velocity | 1/s |
//! | s | rate of a motion e^(st) | 1/s |
//! | R | stability function: a step of ẋ = s x multiplies x by R(hs) | – |
//!
//! | scheme | R or rule | real axis: λh ≤ |
//! |---|---|---|
//! | [`Euler`](Scheme::Euler) | 1 + z | 2 |
//! | [`RungeKutta4`](Scheme::RungeKutta4) | Σ zᵏ/k!, k ≤ 4 | 2.785 293 563 |
//! | [`DormandPrince`](Scheme::DormandPrince) | Σ zᵏ/k!, k ≤ 5, + z⁶/600 | 3.306 567 893 |
//! | [`DormandPrince8`](Scheme::DormandPrince8) | Σ zᵏ/k!, k ≤ 8, + four terms | 6.393 651 523 |
//! | [`SemiImplicitEuler`](Scheme::SemiImplicitEuler) | below | 2 |
//! | [`ExactHold`](Scheme::ExactHold) | below | no limit |
//! | [`Passive`](Scheme::Passive), [`Rosenbrock`](Scheme::Rosenbrock) | – | no limit |
//!
//! The semi-implicit method takes the new velocity from the old force and everything else from the
//! new velocity. With a = (σ1 c p + d)/m and b = (σ0 c p + k)/m its step map has the determinant
//! 1 − ha and the trace 2 − ha − h²b. It is stable for h²b + 2ha ≤ 4: h ≤ 2/√b without damping and
//! *less* with it.
//!
//! The exact hold keeps v over the step and pushes the mass with the mean of the forces. Its step
//! map has the determinant 1 − ha + h²b/2 and the trace 2 − ha − h²b/2, and is stable for h ≤ 2a/b
//! and h ≤ 2/a. The hold makes the bristle exact, not the mass: without damping no step is stable.
//!
//! The limits concern two small motions, that of the bristle in steady sliding and that of the
//! stuck mass. They say nothing about accuracy, nor about a mass that slides on a soft spring:
//! explicit steps add hω²/2 and held steps hω²/4 to the growth rate of its oscillation at ω =
//! √(k/m), which near the threshold of stick-slip exceeds the damping.
//!
//! Beyond the limit of the bristle a run diverges once it slides for a while. Beyond the limit of
//! the stuck mechanism alone it chatters and slides under forces far below breakaway: the result
//! looks like friction and is wrong.
//!
//! Sources: E. Hairer, G. Wanner, "Solving Ordinary Differential Equations II", 2nd edition
//! (Springer, 1996), section IV.2, for stability functions; the models of Romano et al.
//! (arXiv 2602.09429), section III-A, linearised at rest.

mod region;

use core::fmt;

use bristle::number::Number;
use bristle::parameter::{Checked, Named, Rule};
use bristle::scalar::{lit, to_f64};
use bristle::{Branch, Bristle, Contact, Mechanism, Scalar};
use nalgebra::{Complex, ComplexField, Matrix2, SMatrix};

use crate::eigenvalues::eigenvalues;

/// How a step is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Scheme {
    /// The explicit Euler method.
    Euler,
    /// The semi-implicit (symplectic) Euler method: v from the force at the start of the step, then
    /// position and deflection from the new v.
    #[doc(alias = "symplectic")]
    SemiImplicitEuler,
    /// [`ode::RungeKutta4`](bristle::ode::RungeKutta4).
    RungeKutta4,
    /// [`ode::DormandPrince`](bristle::ode::DormandPrince), of order 5.
    DormandPrince,
    /// [`ode::DormandPrince8`](bristle::ode::DormandPrince8), of order 8.
    DormandPrince8,
    /// v held over the step: [`Contact::hold`] for the bristle, and the mean forces of friction and
    /// spring for the mass.
    ExactHold,
    /// A passive step, which solves for the mean velocity of the step, as with a
    /// [`Companion`](bristle::companion::Companion). By its energy balance no step is too long for
    /// FrBD with springs of constant stiffness, Dahl and elasto-plastic models; for LuGre nothing
    /// is promised.
    Passive,
    /// An L-stable Rosenbrock method, as [`ode::Rodas4`](bristle::ode::Rodas4) and
    /// [`ode::Rodas5P`](bristle::ode::Rodas5P).
    Rosenbrock,
}

/// The largest stable steps of one scheme: `None` where every step is stable, zero where none is.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct StepLimits<T> {
    /// The scheme.
    pub scheme: Scheme,
    /// Largest step \[s\] at which the bristle relaxes, at every velocity in its range.
    pub bristle: Option<T>,
    /// Largest step \[s\] at which the oscillation of the stuck mechanism decays, with an
    /// undeflected bristle (c = 1). `None` also without a mechanism.
    pub stuck_from_rest: Option<T>,
    /// Largest step \[s\] at which it decays just after a reversal of steady sliding (c = 2 for
    /// most models). `None` also without a mechanism.
    pub stuck_reversed: Option<T>,
}

/// The largest stable steps for a contact, and for the mechanism that it holds or brakes if there
/// is one, at velocities |v| ≤ `fastest` [m/s].
///
/// `fastest` may be infinite for a model of bounded relaxation rate. A regularised contact never
/// quite rests; it is linearised where its steady friction breaks away.
///
/// ```
/// use bristle::curve::Stribeck;
/// use bristle::rheology::KelvinVoigt;
/// use bristle::{Bristle, FrBd, paper};
/// use bristle_analysis::step_limits::{self, Scheme};
///
/// let friction = FrBd::new(
///     Stribeck::new(paper::STICK_SLIP_CURVE)?,
///     KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?,
/// );
/// let contact = friction.under_load(1.0)?;
/// let rig = Some(paper::stick_slip_rig(contact).mechanism);
/// let limits = step_limits::largest_step(&contact, rig, 1.0, Scheme::RungeKutta4)?;
/// assert_eq!(
///     limits.to_string(),
///     "RungeKutta4: bristle 0.018244 s, stuck 0.02804 s, stuck after a reversal 0.018711 s"
/// );
/// // A loop at 1 kHz is safe, one at 50 Hz is not:
/// assert!(limits.check(1e-3).is_ok());
/// assert!(limits.check(20e-3).is_err());
/// # Ok::<(), bristle::ParameterError>(())
/// ```
///
/// # Errors
///
/// Names the parameter of the mechanism that is out of its range. Refuses a velocity that is NaN,
/// and a model without a bound on its relaxation rate up to that velocity (LuGre up to an infinite
/// one).
pub fn largest_step<T: Scalar, M: Bristle<T, Deflection = T>>(
    contact: &Contact<T, M>,
    mechanism: Option<Mechanism<T>>,
    fastest: T,
    scheme: Scheme,
) -> Checked<StepLimits<T>> {
    let mechanism = mechanism.map(Mechanism::checked).transpose()?;
    Named("fastest", fastest).number()?;
    let bristle = if region::polynomial(scheme).is_some() {
        let unbounded = || Named("relaxation_rate", T::unlimited()).refused(Rule::Finite);
        let rate = contact.limits(fastest).relaxation_rate.ok_or_else(unbounded)?;
        region::largest_step(scheme, Complex::new(-to_f64(rate), 0.0))
    } else {
        None
    };
    let stuck = |reversed: bool| {
        [Branch::Forward, Branch::Backward]
            .into_iter()
            .filter_map(|branch| Some(Swing::new(contact, mechanism?, branch, reversed, fastest)))
            .filter_map(|swing| swing.largest_step(scheme))
            .reduce(f64::smaller)
    };
    Ok(StepLimits {
        scheme,
        bristle: in_type(bristle),
        stuck_from_rest: in_type(stuck(false)),
        stuck_reversed: in_type(stuck(true)),
    })
}

/// A limit in the scalar type; none if it is infinite there.
fn in_type<T: Scalar>(limit: Option<f64>) -> Option<T> {
    limit.map(lit::<T>).filter(|limit| limit.is_finite())
}

/// The largest step \[s\] at which every decaying mode of ẋ = J x decays in a Runge–Kutta or
/// Rosenbrock method too; `None` if no step is too long.
///
/// J is the Jacobian of any mechanism at one state, such as
/// [`System::linearised`](bristle::ode::System::linearised) gives. Modes that grow by themselves
/// are left out, because no step makes them decay.
///
/// NaN for a Jacobian that is not finite, and for the schemes that treat velocities and positions
/// differently.
///
/// ```
/// use bristle::curve::Stribeck;
/// use bristle::ode::System;
/// use bristle::rheology::KelvinVoigt;
/// use bristle::scene::MassSpringDamper;
/// use bristle::{Branch, Bristle, FrBd, paper};
/// use bristle_analysis::step_limits::{self, Scheme};
///
/// let friction = FrBd::new(
///     Stribeck::new(paper::STICK_SLIP_CURVE)?,
///     KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?,
/// );
/// let rig = MassSpringDamper::new(paper::stick_slip_rig(friction.under_load(1.0)?))?;
/// let tangent = rig.linearised(0.0, &rig.at_rest(), [Branch::Forward]).unwrap();
/// let step = step_limits::largest_step_of(&tangent.by_state, Scheme::RungeKutta4).unwrap();
/// assert!((step - 2.8040e-2).abs() < 1e-6);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
pub fn largest_step_of<T: Scalar, const N: usize>(
    jacobian: &SMatrix<T, N, N>,
    scheme: Scheme,
) -> Option<T> {
    let rates = match scheme {
        Scheme::SemiImplicitEuler | Scheme::ExactHold | Scheme::Passive => None,
        _ => eigenvalues(&jacobian.map(to_f64)),
    };
    let Some(rates) = rates else { return Some(T::nan()) };
    // A mode that stands still, such as the difference of position and deflection of a
    // stuck mass, has a rate of rounding size. A true mode as slow as that gains or loses
    // nothing over a step that suits the fastest.
    let sizes = rates.map(|rate| ComplexField::hypot(rate.re, rate.im));
    let fastest = sizes.into_iter().fold(0.0, f64::max);
    let moving = rates.iter().zip(sizes).filter(|(_, size)| *size > 1e-9 * fastest);
    let limits = moving.filter_map(|(rate, _)| region::largest_step(scheme, *rate));
    in_type(limits.reduce(f64::smaller))
}

/// The oscillation of the stuck mass: m s² + (∂F/∂v + d) s + (∂F/∂z ∂ż/∂v + k) = 0, divided by the
/// mass, s² + a s + b = 0.
pub(crate) struct Swing {
    /// a [1/s]
    pub(crate) damping: f64,
    /// b [1/s²]
    pub(crate) stiffness: f64,
}

impl Swing {
    pub(crate) fn new<T: Scalar, M: Bristle<T, Deflection = T>>(
        contact: &Contact<T, M>,
        mechanism: Mechanism<T>,
        branch: Branch,
        reversed: bool,
        fastest: T,
    ) -> Self {
        let (velocity, deflection) = if reversed {
            let velocity = breakaway_velocity(contact, branch, fastest);
            (velocity, -contact.stationary(branch.of(velocity)))
        } else {
            (T::zero(), T::zero())
        };
        let friction = contact.linearised(branch.of(velocity), deflection);
        let mass = to_f64(mechanism.mass);
        let bristle = to_f64(friction.force_by_deflection) * to_f64(friction.rate_by_velocity);
        let damping = to_f64(friction.force_by_velocity) + to_f64(mechanism.viscous_damping);
        // A bristle that creeps (Maxwell) lets go of the mass: (s + λ)(m s² + D s + k) + C B s = 0
        // has a slow root near −λ k/(C B + k + λ D). The oscillation is what is left of the sum and
        // the product of the roots; the limits of the two methods with a formula of their own are
        // then on the safe side.
        let creeps = contact.model().characteristics(T::zero()).is_some_and(|model| model.creeps);
        let rest = branch.of(T::zero());
        let relaxation = if creeps {
            to_f64(contact.model().affine(rest.into(), T::zero()).relaxation)
        } else {
            0.0
        };
        let spring = to_f64(mechanism.spring_stiffness);
        let stiffness = bristle + spring + relaxation * damping;
        let slow = if relaxation > 0.0 { relaxation * spring / stiffness } else { 0.0 };
        Self { damping: damping / mass + (relaxation - slow), stiffness: stiffness / mass }
    }

    fn largest_step(&self, scheme: Scheme) -> Option<f64> {
        let Self { damping: a, stiffness: b } = *self;
        let limit = match scheme {
            // h²b + 2ha = 4, solved for 1/h, which cancels nothing and allows b = 0.
            Scheme::SemiImplicitEuler => 4.0 / (a + ComplexField::sqrt(a * a + 4.0 * b)),
            Scheme::ExactHold if b > 0.0 => (2.0 * a / b).min(2.0 / a),
            Scheme::ExactHold => 2.0 / a,
            _ => return largest_step_of(&Matrix2::new(0.0, 1.0, -b, -a), scheme),
        };
        limit.is_finite().then_some(limit)
    }
}

/// The velocity at which steady friction reaches its first maximum from rest: zero, unless the
/// contact is regularised.
fn breakaway_velocity<T: Scalar, M: Bristle<T, Deflection = T>>(
    contact: &Contact<T, M>,
    branch: Branch,
    fastest: T,
) -> T {
    let deflection = |speed: T| contact.stationary(branch.at_speed(speed)).abs();
    if !(deflection(T::zero()) <= T::zero()) {
        return T::zero();
    }
    // Upward by doubling, until doubling no longer gains a percent: the square root is then within
    // two percent of the sign it stands for, at a speed far below the curve's own.
    let mut speed: T = lit(1e-15);
    let end = fastest.abs();
    while speed < end && !(deflection(speed + speed) < deflection(speed) * lit(1.01)) {
        speed += speed;
    }
    branch.at_speed(speed).velocity()
}

impl<T: Scalar> StepLimits<T> {
    /// What sets a limit, as named in an error, with the largest step \[s\] it allows.
    fn causes(&self) -> [(&'static str, Option<T>); 3] {
        [
            ("the bristle's critical step", self.bristle),
            ("the stuck mechanism's critical step", self.stuck_from_rest),
            ("the stuck mechanism's critical step after a reversal", self.stuck_reversed),
        ]
    }

    /// The smallest of the limits \[s\].
    pub fn overall(&self) -> Option<T> {
        self.causes().into_iter().filter_map(|(_, limit)| limit).reduce(T::smaller)
    }

    /// Accepts a step \[s\] that is within every limit.
    ///
    /// ```
    /// use bristle::{Bristle, Dahl, DahlParameters, Mechanism};
    /// use bristle_analysis::step_limits::{self, Scheme};
    ///
    /// let parameters = DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: 5e3 };
    /// let friction = Dahl::new(parameters)?;
    /// let mechanism = Some(Mechanism { mass: 1.0, spring_stiffness: 0.0, viscous_damping: 0.0 });
    /// let contact = friction.under_load(1.0)?;
    /// let scheme = Scheme::SemiImplicitEuler;
    /// let limits = step_limits::largest_step(&contact, mechanism, 0.0, scheme)?;
    /// assert_eq!(
    ///     limits.check(0.025).unwrap_err().to_string(),
    ///     "step is 0.025, but must be at most \
    ///      the stuck mechanism's critical step after a reversal = 0.02"
    /// );
    /// # Ok::<(), bristle::ParameterError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Refuses a step that is not positive, and one beyond a limit: the error names the step and
    /// the smallest limit with its cause.
    pub fn check(&self, step: T) -> Checked<()> {
        Named("step", step).positive()?;
        let limits = self.causes().into_iter().filter_map(|(name, limit)| Some((name, limit?)));
        let smallest = limits.reduce(|a, b| if b.1 < a.1 { b } else { a });
        smallest.map_or(Ok(step), |(cause, limit)| Named("step", step).at_most(cause, limit))?;
        Ok(())
    }
}

impl Scheme {
    /// All schemes.
    pub const ALL: [Self; 8] = [
        Self::Euler,
        Self::SemiImplicitEuler,
        Self::RungeKutta4,
        Self::DormandPrince,
        Self::DormandPrince8,
        Self::ExactHold,
        Self::Passive,
        Self::Rosenbrock,
    ];
}

impl fmt::Display for Scheme {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self, f)
    }
}

impl<T: Scalar> fmt::Display for StepLimits<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:", self.scheme)?;
        let words = ["bristle", "stuck", "stuck after a reversal"];
        let mut separator = " ";
        for (word, (_, limit)) in words.into_iter().zip(self.causes()) {
            match limit {
                Some(limit) if limit == T::zero() => write!(f, "{separator}{word} never stable")?,
                Some(limit) => write!(f, "{separator}{word} {:.5} s", Number::of(limit))?,
                None => write!(f, "{separator}{word} unlimited")?,
            }
            separator = ", ";
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{Scheme, StepLimits};

    #[test]
    fn the_overall_limit_is_the_smallest_wherever_it_stands() {
        let overall = |bristle: Option<f64>, stuck_from_rest, stuck_reversed| {
            let scheme = Scheme::Euler;
            StepLimits { scheme, bristle, stuck_from_rest, stuck_reversed }.overall()
        };
        assert_eq!(overall(Some(1.0), Some(2.0), Some(3.0)), Some(1.0));
        assert_eq!(overall(Some(3.0), Some(1.0), Some(2.0)), Some(1.0));
        assert_eq!(overall(Some(2.0), Some(3.0), Some(1.0)), Some(1.0));
        assert_eq!(overall(None, Some(2.0), Some(1.0)), Some(1.0));
        assert_eq!(overall(Some(1.0), None, Some(2.0)), Some(1.0));
        assert_eq!(overall(None, None, Some(2.0)), Some(2.0));
        assert_eq!(overall(None, None, None), None);
    }
}
