//! Ready systems with analytic Jacobians, among them the mechanisms of the paper's experiments
//! (section V).
//!
//! | scene | states |
//! |---|---|
//! | [`PrescribedVelocity`] | deflection, or the stretches of the springs of a bristle |
//! | [`MassSpringDamper`] | position, velocity, deflection |
//! | [`DiaphragmValve`] | position, velocity, deflection, pressure |
//!
//! A scene of your own implements [`System`](crate::ode::System) in about twenty lines.

mod diaphragm_valve;
mod mass_spring_damper;
mod prescribed_velocity;

pub use diaphragm_valve::{DiaphragmValve, DiaphragmValveParameters};
pub use mass_spring_damper::{MassSpringDamper, MassSpringDamperParameters};
pub use prescribed_velocity::PrescribedVelocity;

use nalgebra::{SMatrix, SVector};

use crate::ode::Linearisation;
use crate::scalar::lit;
use crate::{Branch, Bristle, Contact, Mechanism, Scalar};

/// Places of the states of a [`Body`] in those of its system.
const POSITION: usize = 0;
const VELOCITY: usize = 1;
const DEFLECTION: usize = 2;

/// A mass with a spring, a damper and friction: ẋ = v, m v̇ = f − c v − F(v, z), ż = h(v, z), the
/// first three states of a system of N.
///
/// The force f is everything but damper and friction. It contains the spring −k x.
#[derive(Debug, Clone, Copy)]
struct Body<'a, T, M> {
    contact: &'a Contact<T, M>,
    mechanism: Mechanism<T>,
    inverse_mass: T,
}

impl<T: Scalar, M: Bristle<T, Deflection = T>> Body<'_, T, M> {
    fn friction_force<const N: usize>(&self, state: &SVector<T, N>) -> T {
        self.contact.force(state[VELOCITY], state[DEFLECTION])
    }

    #[inline(always)]
    fn switching_function<const N: usize>(&self, x: &SVector<T, N>, branch: Branch) -> Option<T> {
        self.contact.switching_function(branch.of(x[VELOCITY]), x[DEFLECTION])
    }

    /// The rates of the states under a force f.
    #[inline(always)]
    fn rate<const N: usize>(
        &self,
        force: T,
        state: &SVector<T, N>,
        branch: Branch,
    ) -> SVector<T, N> {
        let velocity = state[VELOCITY];
        let friction = self.contact.response(branch.of(velocity), state[DEFLECTION]);
        let force = force - self.mechanism.viscous_damping * velocity - friction.force;
        let mut rate = SVector::zeros();
        rate[POSITION] = velocity;
        rate[VELOCITY] = force * self.inverse_mass;
        rate[DEFLECTION] = friction.rate;
        rate
    }

    /// The rates and their derivatives under a force f with ∂f/∂x = −k and without other
    /// derivatives.
    #[inline(always)]
    fn linearised<const N: usize>(
        &self,
        force: T,
        state: &SVector<T, N>,
        branch: Branch,
    ) -> Linearisation<T, N> {
        let Mechanism { spring_stiffness, viscous_damping, .. } = self.mechanism;
        let velocity = state[VELOCITY];
        let friction = self.contact.linearised(branch.of(velocity), state[DEFLECTION]);
        let force = force - viscous_damping * velocity - friction.force;
        let mut rate = SVector::zeros();
        rate[POSITION] = velocity;
        rate[VELOCITY] = force * self.inverse_mass;
        rate[DEFLECTION] = friction.rate;
        let damping = friction.force_by_velocity + viscous_damping;
        let mut by_state = SMatrix::zeros();
        by_state[(POSITION, VELOCITY)] = T::one();
        by_state[(VELOCITY, POSITION)] = -spring_stiffness * self.inverse_mass;
        by_state[(VELOCITY, VELOCITY)] = -damping * self.inverse_mass;
        by_state[(VELOCITY, DEFLECTION)] = -friction.force_by_deflection * self.inverse_mass;
        by_state[(DEFLECTION, VELOCITY)] = friction.rate_by_velocity;
        by_state[(DEFLECTION, DEFLECTION)] = friction.rate_by_deflection;
        Linearisation { rate, by_state, by_time: SVector::zeros() }
    }

    /// Deflection [m] at breakaway: the largest that the model allows at rest, or one micrometre if
    /// it has no bound.
    fn breakaway_deflection(&self) -> T {
        self.contact.limits(T::zero()).deflection.unwrap_or_else(|| lit(1e-6))
    }

    /// Friction force [N] at breakaway.
    fn breakaway_force(&self) -> T {
        let stiffness = self.contact.model().storage_stiffness() * self.contact.reference_load();
        (stiffness * self.breakaway_deflection()).larger(T::default_epsilon())
    }

    /// Velocity [m/s] at which the mass oscillates on its bristles through the breakaway
    /// deflection.
    fn bristle_velocity(&self) -> T {
        (self.breakaway_force() * self.inverse_mass * self.breakaway_deflection()).sqrt()
    }
}
