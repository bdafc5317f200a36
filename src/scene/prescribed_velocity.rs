//! A bristle dragged at a given velocity: ż = h(z, v(t)).

use nalgebra::{Matrix1, Vector1};

use super::typical_deflection;
use crate::ode::{System, Tangent};
use crate::signal::Signal;
use crate::{Branch, Bristle, Contact, Scalar};

/// Parameters of [`PrescribedVelocity`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PrescribedVelocityParameters<T, M, V> {
    /// Friction under its normal force.
    pub contact: Contact<T, M>,
    /// Sliding velocity v(t) [m/s].
    pub velocity: V,
}

/// A bristle dragged at a given velocity. State: its deflection \[m\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PrescribedVelocity<T, M, V> {
    contact: Contact<T, M>,
    velocity: V,
}

impl<T, M, V> PrescribedVelocity<T, M, V>
where
    T: Scalar,
    M: Bristle<T, Deflection = T>,
    V: Signal<T>,
{
    /// The scene.
    pub fn new(parameters: PrescribedVelocityParameters<T, M, V>) -> Self {
        let PrescribedVelocityParameters { contact, velocity } = parameters;
        Self { contact, velocity }
    }

    /// The sliding velocity [m/s] at a time.
    pub fn velocity(&self, time: T) -> T {
        self.velocity.value(time)
    }

    /// The friction force \[N\] at a time and state.
    pub fn friction_force(&self, time: T, state: &Vector1<T>) -> T {
        self.contact.force(self.velocity.value(time), state.x)
    }

    /// The state in which the bristle has adapted to the velocity at a time.
    pub fn stationary(&self, time: T) -> Vector1<T> {
        Vector1::new(self.contact.stationary(self.velocity.value(time)))
    }

    /// A typical magnitude of each state, for tolerances.
    pub fn scales(&self) -> Vector1<T> {
        Vector1::new(typical_deflection(&self.contact))
    }
}

impl<T, M, V> System<T, 1> for PrescribedVelocity<T, M, V>
where
    T: Scalar,
    M: Bristle<T, Deflection = T>,
    V: Signal<T>,
{
    #[inline]
    fn rate(&self, time: T, state: &Vector1<T>, [branch]: [Branch; 1]) -> Vector1<T> {
        Vector1::new(self.contact.rate(branch.of(self.velocity.value(time)), state.x))
    }

    #[inline]
    fn sliding_velocities(&self, time: T, _state: &Vector1<T>) -> [T; 1] {
        [self.velocity.value(time)]
    }

    fn tangent(&self, time: T, state: &Vector1<T>, [branch]: [Branch; 1]) -> Option<Tangent<T, 1>> {
        let (velocity, acceleration) = self.velocity.value_and_rate(time);
        let friction = self.contact.linearised(branch.of(velocity), state.x);
        Some(Tangent {
            rate: Vector1::new(friction.rate),
            by_state: Matrix1::new(friction.rate_by_deflection),
            by_time: Vector1::new(friction.rate_by_velocity * acceleration),
        })
    }

    fn next_kink(&self, time: T, towards: T) -> Option<T> {
        self.velocity.next_kink(time, towards)
    }

    fn scales(&self) -> Vector1<T> {
        PrescribedVelocity::scales(self)
    }
}
