//! A quarter of a typical passenger car, none of a particular one: 400 kg on a wheel of 1 kg m² and
//! 0.3 m, a patch of 0.12 m; a dry road with a peak near μ = 0.8 at a slip of some 20 % and 0.75
//! when the wheel slides fast; a brake that winds up by 0.02 rad under 1500 N m with all that holds
//! it.

use std::error::Error;

use bristle::curve::{Coulomb, CoulombParameters, Stribeck, StribeckParameters};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{Bristle, FrBd, ParameterError};
use bristle_rolling::{BrakedWheel, BrakedWheelParameters, Tyre};

pub(crate) const MASS: f64 = 400.0; // kg
pub(crate) const INERTIA: f64 = 1.0; // kg m²
pub(crate) const RADIUS: f64 = 0.3; // m
pub(crate) const LOAD: f64 = MASS * 9.81; // N
/// Length of the patch \[m\].
pub(crate) const LENGTH: f64 = 0.12;

/// A quarter of a car on a tyre.
pub(crate) type QuarterCar<P> = BrakedWheel<f64, P, FrBd<Coulomb<f64>, KelvinVoigt<f64>>>;

/// The friction of the road, and the bristles of the tread.
pub(crate) fn road_and_tread() -> Result<(Stribeck<f64>, KelvinVoigt<f64>), ParameterError> {
    let road = Stribeck::new(StribeckParameters {
        static_coefficient: 1.1,
        dynamic_coefficient: 0.75,
        stribeck_velocity: 6.0,
        stribeck_exponent: 1.0,
        viscous_friction: 0.0,
    })?;
    let tread =
        KelvinVoigt::new(KelvinVoigtParameters { micro_stiffness: 200.0, micro_damping: 0.5 })?;
    Ok((road, tread))
}

/// The car, rolling freely at a speed \[m/s\].
pub(crate) fn rolling<P: Tyre<f64>>(tyre: P, speed: f64) -> Result<QuarterCar<P>, Box<dyn Error>> {
    // 1 N m of torque per newton, so that the brake's normal force is its capacity.
    let pads = Coulomb::new(CoulombParameters { dynamic_coefficient: 1.0, viscous_friction: 0.0 })?;
    let holder =
        KelvinVoigt::new(KelvinVoigtParameters { micro_stiffness: 50.0, micro_damping: 0.1 })?;
    Ok(BrakedWheel::new(BrakedWheelParameters {
        tyre,
        brake: FrBd::new(pads, holder).under_load(0.0)?.measured_at(1500.0)?,
        mass: MASS,
        inertia: INERTIA,
        radius: RADIUS,
        speed,
        angular_velocity: speed / RADIUS,
    })?)
}
