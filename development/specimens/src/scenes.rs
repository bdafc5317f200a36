//! Scenes with parameters of which none is one, in any scalar type.

use bristle::scene::{
    DiaphragmValve, DiaphragmValveParameters, MassSpringDamper, MassSpringDamperParameters,
    PrescribedVelocity,
};
use bristle::signal::{Sine, SineParameters};
use bristle::{Bristle, Mechanism, Scalar};
use nalgebra::SVector;

use super::lit;

/// Normal force, mass, spring stiffness and drive velocity of the scenes below, none of them 1.
pub const LOAD: f64 = 3.0;
pub const MASS: f64 = 0.7;
pub const SPRING: f64 = 11.0;
pub const DRIVE: f64 = -0.13;

pub fn input<T: Scalar>() -> Sine<T> {
    Sine::new(SineParameters {
        mean: lit(0.3),
        amplitude: lit(2.0),
        frequency: lit(0.7),
        phase: lit(0.2),
    })
    .unwrap()
}

pub fn prescribed<T: Scalar, M: Bristle<T, Deflection = T>>(
    friction: M,
) -> PrescribedVelocity<T, M, Sine<T>> {
    PrescribedVelocity::new(friction.under_load(lit(LOAD)).unwrap(), input())
}

pub fn mechanism<T: Scalar>(spring_stiffness: f64, viscous_damping: f64) -> Mechanism<T> {
    Mechanism {
        mass: lit(MASS),
        spring_stiffness: lit(spring_stiffness),
        viscous_damping: lit(viscous_damping),
    }
}

/// A mass under a force, without spring and damper.
pub fn forced<T: Scalar, M: Bristle<T, Deflection = T>>(
    friction: M,
) -> MassSpringDamper<T, M, Sine<T>> {
    MassSpringDamper::new(MassSpringDamperParameters {
        contact: friction.under_load(lit(LOAD)).unwrap(),
        mechanism: mechanism(0.0, 0.0),
        drive_velocity: T::zero(),
        force: input(),
    })
    .unwrap()
}

/// A mass pulled by a spring alone.
pub fn driven<T: Scalar, M: Bristle<T, Deflection = T>>(friction: M) -> MassSpringDamper<T, M> {
    MassSpringDamper::new(MassSpringDamperParameters {
        contact: friction.under_load(lit(LOAD)).unwrap(),
        mechanism: mechanism(SPRING, 0.0),
        drive_velocity: lit(DRIVE),
        force: T::zero(),
    })
    .unwrap()
}

/// A mass under a force and pulled by a spring, with a damper.
pub fn shaken<T: Scalar, M: Bristle<T, Deflection = T>>(
    friction: M,
) -> MassSpringDamper<T, M, Sine<T>> {
    MassSpringDamper::new(MassSpringDamperParameters {
        contact: friction.under_load(lit(LOAD)).unwrap(),
        mechanism: mechanism(SPRING, 0.7),
        drive_velocity: lit(DRIVE),
        force: input(),
    })
    .unwrap()
}

pub fn valve_parameters<T: Scalar, M: Bristle<T, Deflection = T>, U>(
    friction: M,
    opening: U,
) -> DiaphragmValveParameters<T, M, U> {
    DiaphragmValveParameters {
        contact: friction.under_load(lit(LOAD)).unwrap(),
        mechanism: mechanism(2e3, 0.0),
        diaphragm_area: lit(0.04),
        preload: lit(25.0),
        least_pressure: lit(410.0),
        pressure_gain: lit(17.0),
        time_constant: lit(0.9),
        opening,
    }
}

pub fn valve<T: Scalar, M: Bristle<T, Deflection = T>>(
    friction: M,
) -> DiaphragmValve<T, M, Sine<T>> {
    DiaphragmValve::new(valve_parameters(friction, input())).unwrap()
}
/// A state from random numbers in [−1, 1], within a few scales.
pub fn random_state<const N: usize>(
    scales: SVector<f64, N>,
    numbers: &[f64; 4],
) -> SVector<f64, N> {
    SVector::from_fn(|i, _| 2.0 * numbers[i] * scales[i])
}
