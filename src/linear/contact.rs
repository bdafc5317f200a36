//! A contact as a linear system from its velocity to its force.

use super::StateSpace;
use crate::bounds::larger;
use crate::parameter::{self, ParameterError};
use crate::rheology::{Deflection, States};
use crate::scalar::{is_zero, lit};
use crate::{Branch, Bristle, Contact, LinearisedContact, Scalar, Sliding};

impl<T: Scalar, D: Deflection<T>> LinearisedContact<T, D> {
    /// The matrices, from the velocity [m/s] to the force \[N\].
    fn matrices<const N: usize>(&self) -> StateSpace<T, N>
    where
        D: States<T, N>,
    {
        StateSpace {
            dynamics: D::matrix(self.rate_by_deflection),
            input: self.rate_by_velocity.states(),
            output: self.force_by_deflection.states().transpose(),
            feedthrough: self.force_by_velocity,
        }
    }
}

impl<T: Scalar, M: Bristle<T>> Contact<T, M> {
    /// Small motions about any velocity and deflection: from the velocity [m/s] to the force \[N\].
    ///
    /// Away from an equilibrium they hold only as long as the state has not moved on.
    ///
    /// # Errors
    ///
    /// Refuses rest where friction has a kink (choose a side by [`Branch::of`](crate::Branch::of)),
    /// and derivatives that are not finite.
    pub fn state_space<const N: usize>(
        &self,
        sliding: impl Into<Sliding<T>>,
        deflection: M::Deflection,
    ) -> Result<StateSpace<T, N>, ParameterError>
    where
        M::Deflection: States<T, N>,
    {
        let sliding = sliding.into();
        parameter::finite("velocity", sliding.velocity())?;
        parameter::finite("deflection", deflection.largest())?;
        if undecided(sliding) {
            let side = |branch: Branch| {
                self.linearised(branch.of(T::zero()), deflection).matrices().finite()
            };
            let (one, other) = (side(Branch::Forward)?, side(Branch::Backward)?);
            parameter::stated("velocity", T::zero(), same(&one, &other), KINK)?;
        }
        self.linearised(sliding, deflection).matrices().finite()
    }

    /// Small motions about steady sliding at a velocity: from the velocity [m/s] to the force
    /// \[N\].
    ///
    /// ```
    /// use bristle::{Bristle, FrBd, paper};
    /// use bristle::curve::Stribeck;
    /// use bristle::rheology::KelvinVoigt;
    ///
    /// let friction = FrBd::new(
    ///     Stribeck::new(paper::STICK_SLIP_CURVE)?,
    ///     KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?,
    /// );
    /// let small = friction.under_load(1.0)?.steady_state_space(5.5e-3)?;
    /// // In the Stribeck range friction falls, by 40 N per m/s …
    /// assert!((small.static_gain()? + 40.603).abs() < 1e-3);
    /// // … as long as the velocity changes more slowly than the bristles adapt, at 32 1/s.
    /// assert!((small.corner_frequency()? - 31.9).abs() < 0.1);
    /// // Much faster, it falls by a fifth of that.
    /// assert!((small.frequency_response(1e6)?.re + 8.353).abs() < 1e-3);
    /// # Ok::<(), bristle::ParameterError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Refuses rest where friction has a kink (choose a side by [`Branch::of`](crate::Branch::of)),
    /// a model without an equilibrium there, and derivatives that are not finite.
    pub fn steady_state_space<const N: usize>(
        &self,
        sliding: impl Into<Sliding<T>>,
    ) -> Result<StateSpace<T, N>, ParameterError>
    where
        M::Deflection: States<T, N>,
    {
        let sliding = sliding.into();
        parameter::finite("velocity", sliding.velocity())?;
        let side = |branch: Branch| self.stationary(branch.of(T::zero())).states();
        let velocity = sliding.velocity();
        let decided = !undecided(sliding) || side(Branch::Forward) == side(Branch::Backward);
        parameter::stated("velocity", velocity, decided, KINK)?;
        let deflection = self.stationary(sliding);
        // The rate is a difference of terms of the size of the velocity.
        let rounding = lit::<T>(1e4) * T::default_epsilon() * velocity.abs();
        for &rate in self.rate(sliding, deflection).states().iter() {
            let rule = "vanish in steady sliding: the model has no equilibrium there";
            parameter::stated("rate of the deflection", rate, rate.abs() <= rounding, rule)?;
        }
        if undecided(sliding) {
            return self.state_space(sliding, deflection);
        }
        self.steady_linearised(sliding).matrices().finite()
    }
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
        (a - b).abs() <= lit::<T>(1e3) * T::default_epsilon() * larger(a.abs(), b.abs())
    };
    let entries = one.dynamics.iter().zip(other.dynamics.iter());
    let entries = entries.chain(one.input.iter().zip(other.input.iter()));
    let mut entries = entries.chain(one.output.iter().zip(other.output.iter()));
    entries.all(|(&a, &b)| near(a, b)) && near(one.feedthrough, other.feedthrough)
}
