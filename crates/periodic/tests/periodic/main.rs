//! Periodic motions against the check values, simulation and differences of the flow.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod branches;
mod orbits;
mod refusals;
mod sampled;
mod special;

use bristle::curve::{Stribeck, StribeckParameters};
use bristle::ode::{Direction, Event};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{Bristle, Contact, FrBd, Mechanism, paper};
use bristle_periodic::{ControlLoopParameters, DrivenMass, Guess, Pid, Shooting};
use nalgebra::Vector3;

type Model = FrBd<Stribeck<f64>, KelvinVoigt<f64>>;
type Friction = Contact<f64, Model>;

/// Table 2 of the paper.
fn curve() -> Stribeck<f64> {
    Stribeck::new(paper::STICK_SLIP_CURVE).unwrap()
}

fn bristle() -> KelvinVoigt<f64> {
    KelvinVoigt::new(paper::STICK_SLIP_BRISTLE).unwrap()
}

fn friction(
    [static_coefficient, dynamic_coefficient, stribeck_velocity, viscous_friction]: [f64; 4],
    [micro_stiffness, micro_damping]: [f64; 2],
) -> Friction {
    let curve = Stribeck::new(StribeckParameters {
        static_coefficient,
        dynamic_coefficient,
        stribeck_velocity,
        stribeck_exponent: 2.0,
        viscous_friction,
    });
    let bristle = KelvinVoigt::new(KelvinVoigtParameters { micro_stiffness, micro_damping });
    FrBd::new(curve.unwrap(), bristle.unwrap()).under_load(1.0).unwrap()
}

/// The hunting loop of the check values: m = 1, u = −400 x − 20 v − 400 ∫x dt, μ_s = 5, μ_d = 3.
fn hunting_loop() -> ControlLoopParameters<Model> {
    ControlLoopParameters {
        contact: friction([5.0, 3.0, 0.01, 1.0], [5e4, 224.0]),
        mechanism: Mechanism { mass: 1.0, spring_stiffness: 0.0, viscous_damping: 0.0 },
        controller: Pid {
            proportional: 400.0,
            integral: 400.0,
            derivative: 20.0,
            filter_time: 0.0,
            sample_time: 0.0,
        },
    }
}

/// A stiff loop of 5 kg, which hunts with a period of 0.952564 s.
fn stiff_loop() -> ControlLoopParameters<Model> {
    let (proportional, integral, derivative) = (5e3, 1e5, 200.0);
    ControlLoopParameters {
        contact: friction([12.0, 8.0, 5e-3, 20.0], [6e5, 1700.0]),
        mechanism: Mechanism { mass: 5.0, spring_stiffness: 0.0, viscous_damping: 0.0 },
        controller: Pid { proportional, integral, derivative, ..hunting_loop().controller },
    }
}

/// The stick-slip rig of the paper with a model on Table 2, drawn at a velocity [m/s].
fn rig<M: Bristle<f64, Deflection = f64>>(model: M, velocity: f64) -> DrivenMass<M> {
    rig_on(2.0, model, velocity)
}

/// The same on a spring of another stiffness [N/m].
fn rig_on<M: Bristle<f64, Deflection = f64>>(
    spring_stiffness: f64,
    model: M,
    velocity: f64,
) -> DrivenMass<M> {
    let rig = paper::stick_slip_rig(model.under_load(1.0).unwrap());
    let mechanism = Mechanism { spring_stiffness, ..rig.mechanism };
    DrivenMass::new(rig.contact, mechanism, velocity).unwrap()
}

/// A cycle of stick-slip: the passage of the mass through the velocity of the drive, rising.
fn stick_slip<M: Bristle<f64, Deflection = f64>>(rig: &DrivenMass<M>, velocity: f64) -> Guess<3> {
    let ahead = |_: f64, state: &Vector3<f64>| state[1] - velocity;
    let overtakes = Event { function: &ahead, direction: Direction::Rising, stops: false };
    Shooting::default().settle(rig, rig.at_rest(), 400.0, &overtakes).unwrap()
}
