//! What a passive step of a gear and of a geared joint costs, beside one exponential:
//! `cargo bench -p bristle-joint --bench cost`.
//!
//! Every measured piece of work waits for the result of the one before, as it does in a simulation
//! or a control loop, and so does the exponential it is compared with. Read the ratios to `exp`
//! of the same scalar within one run; absolute times belong to the machine.
//!
//! The friction is that of the paper's Table 2, in the middle of the Stribeck range, where the
//! friction curve needs its exponential.

use std::hint::black_box;

use bristle::curve::{Stribeck, StribeckParameters};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{FrBd, ParameterError, Scalar, paper};
use bristle_charts::Stopwatch;
use bristle_joint::{
    GearFriction, GearFrictionParameters, GearTorques, GearedJoint, GearedJointParameters,
    JointState, LoadedDeflection, TorqueLoad, TorqueLoadParameters,
};
use nalgebra::convert;

const SPEED: f64 = 0.008;
const DEFLECTION: f64 = 1.1e-4;

/// A result that the next input depends on, without changing its value.
fn chain<T: Scalar>(value: T, result: T) -> T {
    value + result * convert(1e-30)
}

/// Measures a function of a velocity, each call waiting for the last.
fn measure<T: Scalar>(c: &Stopwatch, name: &str, start: f64, mut work: impl FnMut(T) -> T) {
    let start: T = convert(start);
    let mut value = start;
    c.measure(name, || {
        value = chain(start, work(black_box(value)));
        value
    });
}

/// Steps of a gear under torques that vary, in a mass of one's own and in the scene.
fn steps<T: Scalar>(c: &Stopwatch, scalar: &str) -> Result<(), ParameterError> {
    let t = |value: f64| convert::<f64, T>(value);
    let (curve, bristle) = (paper::STICK_SLIP_CURVE, paper::STICK_SLIP_BRISTLE);
    let curve = Stribeck::new(StribeckParameters {
        static_coefficient: t(curve.static_coefficient),
        dynamic_coefficient: t(curve.dynamic_coefficient),
        stribeck_velocity: t(curve.stribeck_velocity),
        stribeck_exponent: t(curve.stribeck_exponent),
        viscous_friction: t(curve.viscous_friction),
    })?;
    let bristle = KelvinVoigt::new(KelvinVoigtParameters {
        micro_stiffness: t(bristle.micro_stiffness),
        micro_damping: t(bristle.micro_damping),
    })?;
    let friction = FrBd::new(curve, bristle);
    measure(c, &format!("{scalar}/exp"), -0.64, |x: T| x.exp());

    let shares =
        TorqueLoadParameters { idle_load: t(0.5), motor_share: t(1.0), external_share: t(0.6) };
    let load = TorqueLoad::new(shares)?;
    let gear = GearFriction::new(GearFrictionParameters {
        friction,
        load,
        reference_load: t(1.0),
        drag: t(0.05),
        fastest: t(1.0),
    })?;
    let (z, h) = (t(DEFLECTION), t(1e-3));
    let name = |what: &str| format!("{scalar}/passive step, FrBD, {what}");
    let mut motor = t(1.28);
    let mut before = LoadedDeflection { deflection: z, load: t(0.0) };
    measure(c, &name("of a gear whose torques vary"), SPEED, |v: T| {
        motor = t(2.5) - motor;
        let torques = GearTorques { motor, external: t(-0.1) };
        let Ok(step) = gear.step(torques, v, before, h) else { return v };
        let mean = (motor - t(0.1) - step.bias() + v * t(2e3)) / (t(2e3) + step.damping());
        let after = step.commit(mean).deflection;
        before.load = after.load;
        after.deflection
    });
    let parameters =
        GearedJointParameters { gear, inertia: t(1.0), motor: t(1.28), external: t(-0.1) };
    let joint = GearedJoint::new(parameters)?;
    measure(c, &name("of a geared joint"), SPEED, |velocity: T| {
        let mut state = JointState::at_rest(t(0.0));
        (state.velocity, state.deflection) = (velocity, z);
        joint.step(&state, h).map_or(velocity, |(state, _)| state.velocity + state.deflection)
    });
    Ok(())
}

fn main() {
    let c = &Stopwatch::from_arguments();
    for done in [steps::<f64>(c, "f64"), steps::<f32>(c, "f32")] {
        if let Err(refused) = done {
            eprintln!("{refused}");
        }
    }
}
