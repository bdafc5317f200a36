//! A contact as a linear system from its velocity to its force.

use bristle::parameter::{Checked, Named};
use bristle::rheology::{Deflection, States};
use bristle::scalar::{is_zero, lit};
use bristle::{Branch, Bristle, Contact, LinearisedContact, Scalar, Sliding};

use super::StateSpace;

/// The matrices, from the velocity [m/s] to the force \[N\].
fn matrices<T: Scalar, D: Deflection<T> + States<T, N>, const N: usize>(
    contact: &LinearisedContact<T, D>,
) -> StateSpace<T, N> {
    StateSpace {
        dynamics: D::matrix(contact.rate_by_deflection),
        input: contact.rate_by_velocity.states(),
        output: contact.force_by_deflection.states().transpose(),
        feedthrough: contact.force_by_velocity,
    }
}

/// Small motions about any velocity and deflection: from the velocity [m/s] to the force \[N\].
///
/// Away from an equilibrium they hold only as long as the state has not moved on.
///
/// # Errors
///
/// Refuses rest where friction has a kink (choose a side by [`Branch::of`](bristle::Branch::of)),
/// and derivatives that are not finite.
pub fn state_space<T: Scalar, M: Bristle<T>, const N: usize>(
    contact: &Contact<T, M>,
    sliding: impl Into<Sliding<T>>,
    deflection: M::Deflection,
) -> Checked<StateSpace<T, N>>
where
    M::Deflection: States<T, N>,
{
    let sliding = sliding.into();
    Named("velocity", sliding.velocity()).finite()?;
    Named("deflection", deflection.largest()).finite()?;
    if undecided(sliding) {
        let side = |branch: Branch| {
            matrices(&contact.linearised(branch.of(T::zero()), deflection)).finite()
        };
        let (one, other) = (side(Branch::Forward)?, side(Branch::Backward)?);
        Named("velocity", T::zero()).stated(same(&one, &other), KINK)?;
    }
    matrices(&contact.linearised(sliding, deflection)).finite()
}

/// Small motions about steady sliding at a velocity: from the velocity [m/s] to the force \[N\].
///
/// ```
/// use bristle::curve::Stribeck;
/// use bristle::rheology::KelvinVoigt;
/// use bristle::{Bristle, FrBd, paper};
/// use bristle_analysis::linear::steady_state_space;
///
/// let friction = FrBd::new(
///     Stribeck::new(paper::STICK_SLIP_CURVE)?,
///     KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?,
/// );
/// let small = steady_state_space(&friction.under_load(1.0)?, 5.5e-3)?;
/// // In the Stribeck range friction falls, by 40 N per m/s …
/// assert!((small.static_gain()? + 40.603).abs() < 1e-3);
/// // … as long as the velocity changes more slowly than the bristles adapt, at 32 1/s.
/// assert!((small.abscissa()? + 31.9).abs() < 0.1);
/// // Much faster, it falls by a fifth of that.
/// assert!((small.frequency_response(1e6)?.re + 8.353).abs() < 1e-3);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
///
/// # Errors
///
/// Refuses rest where friction has a kink (choose a side by [`Branch::of`](bristle::Branch::of)), a
/// model without an equilibrium there, and derivatives that are not finite.
pub fn steady_state_space<T: Scalar, M: Bristle<T>, const N: usize>(
    contact: &Contact<T, M>,
    sliding: impl Into<Sliding<T>>,
) -> Checked<StateSpace<T, N>>
where
    M::Deflection: States<T, N>,
{
    let sliding = sliding.into();
    Named("velocity", sliding.velocity()).finite()?;
    let side = |branch: Branch| contact.stationary(branch.of(T::zero())).states();
    let velocity = sliding.velocity();
    let decided = !undecided(sliding) || side(Branch::Forward) == side(Branch::Backward);
    Named("velocity", velocity).stated(decided, KINK)?;
    let deflection = contact.stationary(sliding);
    // The rate is a difference of terms of the size of the velocity.
    let rounding = lit::<T>(1e4) * T::default_epsilon() * velocity.abs();
    for &rate in contact.rate(sliding, deflection).states().iter() {
        let rule = "vanish in steady sliding: the model has no equilibrium there";
        Named("rate of the deflection", rate).stated(rate.abs() <= rounding, rule)?;
    }
    if undecided(sliding) {
        return state_space(contact, sliding, deflection);
    }
    matrices(&contact.steady_linearised(sliding)).finite()
}

/// At rest, with an exact modulus of the velocity, the two sliding directions differ: there is
/// neither a derivative nor a single stationary deflection.
const KINK: &str = "not be 0, where friction has a kink: choose a side by Branch, or regularise";

/// Rest, with no side chosen.
fn undecided<T: Scalar>(sliding: Sliding<T>) -> bool {
    is_zero(sliding.velocity()) && is_zero(sliding.direction())
}

/// Whether two systems are equal up to rounding.
fn same<T: Scalar, const N: usize>(one: &StateSpace<T, N>, other: &StateSpace<T, N>) -> bool {
    let near = |a: T, b: T| {
        (a - b).abs() <= lit::<T>(1e3) * T::default_epsilon() * a.abs().larger(b.abs())
    };
    one.entries().zip(other.entries()).all(|((_, a), (_, b))| near(a, b))
}
