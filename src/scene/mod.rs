//! Ready systems with analytic Jacobians: the mechanisms of the paper's experiments (section V).
//!
//! | scene | states |
//! |---|---|
//! | [`PrescribedVelocity`] | deflection; of a bristle of several springs their stretches |
//! | [`MassSpringDamper`] | position, velocity, deflection |
//! | [`DiaphragmValve`] | position, velocity, deflection, pressure |
//!
//! A scene of your own is a [`System`](crate::ode::System): about twenty lines.
//!
//! [`BrakedWheel`], a wheel on a rolling patch from free rolling to standstill, is no system with a few
//! states; it takes passive steps of its own.

mod braked_wheel;
mod diaphragm_valve;
mod mass_spring_damper;
mod prescribed_velocity;

pub use braked_wheel::{
    BrakedWheel, BrakedWheelParameters, WheelError, WheelLedger, WheelLoads, WheelState, WheelStep,
};
pub use diaphragm_valve::{DiaphragmValve, DiaphragmValveParameters};
pub use mass_spring_damper::{MassSpringDamper, MassSpringDamperParameters};
pub use prescribed_velocity::{PrescribedVelocity, PrescribedVelocityParameters};

use nalgebra::{SMatrix, SVector};

use crate::bounds::larger;
use crate::{Bristle, Contact, Scalar};

/// Deflection [m] that is typical of a contact: the largest the model's theorems allow for slow
/// sliding, or one micrometre where there is none.
fn typical_deflection<T: Scalar, M: Bristle<T, Deflection = T>>(contact: &Contact<T, M>) -> T {
    // At rest: the static friction over the stiffness, whatever the curve does at high speed.
    let limit = contact.limits(T::zero()).deflection;
    limit.unwrap_or_else(|| crate::scalar::lit(1e-6))
}

/// Friction force [N] that is typical of a contact.
fn typical_force<T: Scalar, M: Bristle<T, Deflection = T>>(contact: &Contact<T, M>) -> T {
    let stiffness = contact.model().storage_stiffness() * contact.normal_force();
    larger(stiffness * typical_deflection(contact), T::default_epsilon())
}

/// Rate and derivatives of a mass m on a line with friction, ẋ = v, m v̇ = … − F, ż = …, for the
/// first three states of a system; all other forces and their derivatives are added by the scene.
struct Moving<T, const N: usize> {
    rate: SVector<T, N>,
    by_state: SMatrix<T, N, N>,
}

impl<T: Scalar, const N: usize> Moving<T, N> {
    fn new<M: Bristle<T, Deflection = T>>(
        contact: &Contact<T, M>,
        sliding: crate::Sliding<T>,
        deflection: T,
        inverse_mass: T,
    ) -> Self {
        let friction = contact.linearised(sliding, deflection);
        let mut rate = SVector::zeros();
        rate[POSITION] = sliding.velocity();
        rate[VELOCITY] = -friction.force * inverse_mass;
        rate[DEFLECTION] = friction.rate;
        let mut by_state = SMatrix::zeros();
        by_state[(POSITION, VELOCITY)] = T::one();
        by_state[(VELOCITY, VELOCITY)] = -friction.force_by_velocity * inverse_mass;
        by_state[(VELOCITY, DEFLECTION)] = -friction.force_by_deflection * inverse_mass;
        by_state[(DEFLECTION, VELOCITY)] = friction.rate_by_velocity;
        by_state[(DEFLECTION, DEFLECTION)] = friction.rate_by_deflection;
        Self { rate, by_state }
    }
}

const POSITION: usize = 0;
const VELOCITY: usize = 1;
const DEFLECTION: usize = 2;
