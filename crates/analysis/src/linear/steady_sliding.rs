//! Steady sliding of a mass that is pulled by a spring whose far end moves steadily.
//!
//! ė = v_d − v,  m v̇ = k e − d v − F(v, z),  ż = h(z, v)
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | e | stretch of the spring | m |
//! | v_d | velocity of its far end | m/s |
//! | m, k, d | mass, stiffness, damping beside the friction | kg, N/m, N s/m |
//!
//! Steady sliding: v = v_d, z = z_ss(v), e = (F_ss(v) + d v)/k. Its small motions, and when they
//! grow into stick-slip, follow the cubic of the [module](super).
//!
//! A mass on a moving belt, held by a spring and a damper on the ground, has the same small
//! motions, with v the sliding velocity; only its stretch in steady sliding is F_ss/k.

use bristle::parameter::{Checked, Named};
use bristle::scalar::lit;
use bristle::{Bristle, Contact, Mechanism, Scalar, Sliding};
use nalgebra::{RowVector3, Vector3};

use super::{StateSpace, steady_state_space};

/// Steady sliding of a mass on a driven spring, and the small motions about it. Made by
/// [`steady_sliding`](steady_sliding()).
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct SteadySliding<T: Scalar> {
    /// Velocity of the mass and of the spring's far end [m/s].
    pub velocity: T,
    /// Stretch of the spring \[m\].
    pub stretch: T,
    /// Deflection of the bristle \[m\].
    pub deflection: T,
    /// Friction force \[N\].
    pub friction_force: T,
    /// Small motions. States: stretch \[m\], velocity [m/s], deflection \[m\]; input: velocity of
    /// the spring's far end [m/s]; output: friction force \[N\].
    pub state_space: StateSpace<T, 3>,
}

/// The values of a quantity at which steady sliding is stable: of the speed [m/s] from
/// [`critical_speed`], of the spring stiffness [N/m] from [`critical_stiffness`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Threshold<T> {
    /// All values.
    AlwaysStable,
    /// No value.
    NeverStable,
    /// Values above this one.
    StableAbove(T),
    /// Values below this one.
    StableBelow(T),
    /// No value, but small motions do not grow either: friction does not depend on the speed.
    Marginal,
}

/// The ratio of neighbouring speeds in a search: 64 a decade.
const DOWN: f64 = 0.964_661_619_911_199;

/// A mechanism in range that has a spring.
fn on_spring<T: Scalar>(mechanism: Mechanism<T>) -> Checked<Mechanism<T>> {
    Named("spring_stiffness", mechanism.checked()?.spring_stiffness).positive()?;
    Ok(mechanism)
}

/// Steady sliding of a mass on a spring whose far end moves at a velocity, and the small motions
/// about it: stick-slip if they grow.
///
/// For a bristle of several springs, linearise the whole mechanism as a
/// [`System`](bristle::ode::System): [`StateSpace`] shows how.
///
/// ```
/// use bristle::curve::Stribeck;
/// use bristle::rheology::KelvinVoigt;
/// use bristle::{Bristle, FrBd, paper};
/// use bristle_analysis::linear::{self, Threshold};
///
/// let friction = FrBd::new(
///     Stribeck::new(paper::STICK_SLIP_CURVE)?,
///     KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?,
/// );
/// let contact = friction.under_load(1.0)?;
/// let rig = paper::stick_slip_rig(contact).mechanism;
/// // The curve of Table 2 falls up to 30 mm/s: no small disturbance dies out below.
/// let threshold = linear::critical_speed(&contact, rig, 1e-3..1.0)?;
/// let Threshold::StableAbove(speed) = threshold else { unreachable!() };
/// assert!((speed - 0.029863).abs() < 1e-6);
/// // No spring is stiff enough to prevent that at 5 mm/s …
/// assert_eq!(linear::critical_stiffness(&contact, rig, 5e-3)?, Threshold::NeverStable);
/// // … and at 0.1 m/s small motions die out on any spring. (From rest the rig of the paper
/// // sticks and slips there, too.)
/// assert_eq!(linear::critical_stiffness(&contact, rig, 0.1)?, Threshold::AlwaysStable);
/// let sliding = linear::steady_sliding(&contact, rig, 0.1)?;
/// assert!(sliding.state_space.abscissa()? < 0.0);
/// assert!((sliding.stretch - 0.502).abs() < 1e-12); // 1.004 N on 2 N/m
/// # Ok::<(), bristle::ParameterError>(())
/// ```
///
/// # Errors
///
/// Refuses a mechanism without a spring or out of range, rest where friction has a kink, a model
/// without an equilibrium there, and derivatives that are not finite.
pub fn steady_sliding<T: Scalar, M: Bristle<T, Deflection = T>>(
    contact: &Contact<T, M>,
    mechanism: Mechanism<T>,
    sliding: impl Into<Sliding<T>>,
) -> Checked<SteadySliding<T>> {
    let Mechanism { mass, spring_stiffness, viscous_damping } = on_spring(mechanism)?;
    let sliding = sliding.into();
    let friction: StateSpace<T, 1> = steady_state_space(contact, sliding)?;
    let velocity = sliding.velocity();
    let friction_force = contact.stationary_force(sliding);
    let (zero, one) = (T::zero(), T::one());
    let (by_velocity, by_deflection) = (friction.feedthrough, friction.output.x);
    let damping = by_velocity + viscous_damping;
    let rows = [
        [zero, -one, zero],
        [spring_stiffness / mass, -damping / mass, -by_deflection / mass],
        [zero, friction.input.x, friction.dynamics.x],
    ];
    let dynamics = nalgebra::Matrix3::from(rows).transpose();
    let state_space = StateSpace {
        dynamics,
        input: Vector3::new(one, zero, zero),
        output: RowVector3::new(zero, by_velocity, by_deflection),
        feedthrough: zero,
    };
    Ok(SteadySliding {
        velocity,
        stretch: (friction_force + viscous_damping * velocity) / spring_stiffness,
        deflection: contact.stationary(sliding),
        friction_force,
        state_space: state_space.finite()?,
    })
}

/// The spring stiffnesses [N/m] for which steady sliding at a velocity is stable; mass and damping
/// are those of the mechanism.
///
/// # Errors
///
/// As for [`steady_sliding`](steady_sliding()).
pub fn critical_stiffness<T: Scalar, M: Bristle<T, Deflection = T>>(
    contact: &Contact<T, M>,
    mechanism: Mechanism<T>,
    sliding: impl Into<Sliding<T>>,
) -> Checked<Threshold<T>> {
    let condition = last_condition(contact, on_spring(mechanism)?, sliding.into())?;
    let Some((without, quick)) = condition else { return Ok(Threshold::NeverStable) };
    let zero = T::zero();
    Ok(match (without > zero, without < zero, quick > zero, quick < zero) {
        (true, _, _, false) | (false, false, true, _) => Threshold::AlwaysStable,
        (true, _, _, true) => Threshold::StableBelow(without / -quick),
        (_, true, true, _) => Threshold::StableAbove(-without / quick),
        (false, false, false, false) => Threshold::Marginal,
        _ => Threshold::NeverStable,
    })
}

/// The speeds in a range [m/s] at which steady sliding is stable against small disturbances; of
/// several changes the one at the highest speed.
///
/// A mass that starts stuck can stick and slip far above that speed: simulate it.
///
/// The search goes down from the highest speed, 64 speeds a decade, and narrows a change down to
/// rounding. It can miss two changes within less than 4 % of the speed.
///
/// # Errors
///
/// Refuses a range that does not start above zero or ends before it starts, and what
/// [`steady_sliding`](steady_sliding()) refuses.
pub fn critical_speed<T: Scalar, M: Bristle<T, Deflection = T>>(
    contact: &Contact<T, M>,
    mechanism: Mechanism<T>,
    speeds: core::ops::Range<T>,
) -> Checked<Threshold<T>> {
    let mechanism = on_spring(mechanism)?;
    let start = Named("speeds.start", speeds.start).positive()?;
    let end = Named("speeds.end", speeds.end).positive()?;
    Named("speeds.end", end).at_least("speeds.start", start)?;
    let mut marginal = true;
    let mut stable = |speed: T| -> Checked<bool> {
        let condition = last_condition(contact, mechanism, Sliding::from(speed))?;
        let (zero, stiffness) = (T::zero(), mechanism.spring_stiffness);
        let decay = condition.map(|(without, quick)| without + quick * stiffness);
        marginal &= decay.is_some_and(|decay| !(decay.abs() > zero));
        Ok(decay.is_some_and(|decay| decay > zero))
    };
    let at_top = stable(end)?;
    let mut above = end;
    while above > start {
        let mut below = (above * lit(DOWN)).larger(start);
        if stable(below)? == at_top {
            above = below;
            continue;
        }
        for _ in 0..200 {
            let middle = (above + below) * lit(0.5);
            if !(middle > below && middle < above) {
                break;
            }
            let end = if stable(middle)? == at_top { &mut above } else { &mut below };
            *end = middle;
        }
        let threshold = if at_top { Threshold::StableAbove } else { Threshold::StableBelow };
        return Ok(threshold(above));
    }
    Ok(match (at_top, marginal) {
        (true, _) => Threshold::AlwaysStable,
        (false, true) => Threshold::Marginal,
        (false, false) => Threshold::NeverStable,
    })
}

/// The last Routh–Hurwitz condition (mλ + D) λ S + D k > 0, S = d + dF_ss/dv, D = d + ∂F/∂v: the
/// part without the spring, and D. None unless the others hold, λ > 0 and mλ + D > 0.
fn last_condition<T: Scalar, M: Bristle<T, Deflection = T>>(
    contact: &Contact<T, M>,
    Mechanism { mass, viscous_damping, .. }: Mechanism<T>,
    sliding: Sliding<T>,
) -> Checked<Option<(T, T)>> {
    let friction: StateSpace<T, 1> = steady_state_space(contact, sliding)?;
    let relaxation = -friction.dynamics.x;
    let quick = viscous_damping + friction.feedthrough;
    // λ S = λ D + C B.
    let slope = quick + friction.output.x * friction.input.x / relaxation;
    let shifted = mass * relaxation + quick;
    let others = relaxation > T::zero() && shifted > T::zero();
    Ok(others.then(|| (shifted * relaxation * slope, quick)))
}
