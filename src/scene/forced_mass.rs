//! A mass under a given force: ẋ = v, m v̇ = f(t) − F.

use nalgebra::Vector3;

use super::{DEFLECTION, Moving, VELOCITY, typical_deflection, typical_force};
use crate::ode::{Linearisation, System};
use crate::parameter::{self, ParameterError};
use crate::signal::Signal;
use crate::{Branch, Bristle, Contact, Scalar};

/// Parameters of [`ForcedMass`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForcedMassParameters<T, M, F> {
    /// Friction under its normal force.
    pub contact: Contact<T, M>,
    /// Mass m \[kg\], positive.
    pub mass: T,
    /// Applied force f(t) \[N\].
    pub force: F,
}

/// A mass under a given force. States: position \[m\], velocity [m/s], deflection \[m\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForcedMass<T, M, F> {
    contact: Contact<T, M>,
    inverse_mass: T,
    force: F,
}

impl<T, M, F> ForcedMass<T, M, F>
where
    T: Scalar,
    M: Bristle<T, Deflection = T>,
    F: Signal<T>,
{
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Refuses a mass that is not positive.
    pub fn new(parameters: ForcedMassParameters<T, M, F>) -> Result<Self, ParameterError> {
        let ForcedMassParameters { contact, mass, force } = parameters;
        let mass = parameter::positive("mass", mass)?;
        Ok(Self { contact, inverse_mass: T::one() / mass, force })
    }

    /// The state at rest at the origin, the bristle undeflected.
    pub fn at_rest(&self) -> Vector3<T> {
        Vector3::zeros()
    }

    /// The friction force \[N\] at a state.
    pub fn friction_force(&self, state: &Vector3<T>) -> T {
        self.contact.force(state[VELOCITY], state[DEFLECTION])
    }

    /// A typical magnitude of each state, for tolerances: a breakaway deflection, and the velocity
    /// at which the mass oscillates on its bristles through it.
    pub fn scales(&self) -> Vector3<T> {
        let deflection = typical_deflection(&self.contact);
        let force = typical_force(&self.contact);
        Vector3::new(deflection, (force * self.inverse_mass * deflection).sqrt(), deflection)
    }
}

impl<T, M, F> System<T, 3> for ForcedMass<T, M, F>
where
    T: Scalar,
    M: Bristle<T, Deflection = T>,
    F: Signal<T>,
{
    #[inline]
    fn rate(&self, time: T, state: &Vector3<T>, [branch]: [Branch; 1]) -> Vector3<T> {
        let velocity = state[VELOCITY];
        let friction = self.contact.response(branch.of(velocity), state[DEFLECTION]);
        let force = self.force.value(time) - friction.force;
        Vector3::new(velocity, force * self.inverse_mass, friction.rate)
    }

    #[inline]
    fn sliding_velocities(&self, _time: T, state: &Vector3<T>) -> [T; 1] {
        [state[VELOCITY]]
    }

    #[inline]
    fn linearised(
        &self,
        time: T,
        state: &Vector3<T>,
        [branch]: [Branch; 1],
    ) -> Option<Linearisation<T, 3>> {
        let sliding = branch.of(state[VELOCITY]);
        let Moving { mut rate, by_state } =
            Moving::new(&self.contact, sliding, state[DEFLECTION], self.inverse_mass);
        let (force, force_rate) = self.force.value_and_rate(time);
        rate[VELOCITY] += force * self.inverse_mass;
        let by_time = Vector3::new(T::zero(), force_rate * self.inverse_mass, T::zero());
        Some(Linearisation { rate, by_state, by_time })
    }

    fn next_kink(&self, time: T, towards: T) -> Option<T> {
        self.force.next_kink(time, towards)
    }

    fn scales(&self) -> Vector3<T> {
        ForcedMass::scales(self)
    }
}
