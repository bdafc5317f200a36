//! The scenes: their derivatives against dual numbers, their balances against closed forms, their
//! scales, and what they refuse.
#![cfg(feature = "alloc")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test panics to fail")]

use bristle::curve::Stribeck;
use bristle::ode::{DormandPrince, Output, System, Tolerances};
use bristle::rheology::KelvinVoigt;
use bristle::scene::{
    DiaphragmValve, DiaphragmValveParameters, MassSpringDamper, MassSpringDamperParameters,
    PrescribedVelocity,
};
use bristle::signal::{Polyline, Signal, Sine, SineParameters, Vertex};
use bristle::{
    Branch, Bristle, Contact, Dahl, DahlParameters, FrBd, Mechanism, ParameterError, Scalar,
};
use bristle_specimens::ode::{OfAny, lit, table_2_frbd, table_2_lugre};
use bristle_specimens::{assert_within, check};
use nalgebra::{SVector, Vector1, Vector2, Vector3, Vector4};
use num_dual::Dual64;
use proptest::prelude::*;

/// Normal force, mass, spring stiffness and drive velocity of the scenes below, none of them 1.
const LOAD: f64 = 3.0;
const MASS: f64 = 0.7;
const SPRING: f64 = 11.0;
const DRIVE: f64 = -0.13;

fn input<T: Scalar>() -> Sine<T> {
    Sine::new(SineParameters {
        mean: lit(0.3),
        amplitude: lit(2.0),
        frequency: lit(0.7),
        phase: lit(0.2),
    })
    .unwrap()
}

fn prescribed<T: Scalar, M: Bristle<T, Deflection = T>>(
    friction: M,
) -> PrescribedVelocity<T, M, Sine<T>> {
    PrescribedVelocity::new(friction.under_load(lit(LOAD)).unwrap(), input())
}

fn mechanism<T: Scalar>(spring_stiffness: f64, viscous_damping: f64) -> Mechanism<T> {
    Mechanism {
        mass: lit(MASS),
        spring_stiffness: lit(spring_stiffness),
        viscous_damping: lit(viscous_damping),
    }
}

/// A mass under a force, without spring and damper.
fn forced<T: Scalar, M: Bristle<T, Deflection = T>>(
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
fn driven<T: Scalar, M: Bristle<T, Deflection = T>>(friction: M) -> MassSpringDamper<T, M> {
    MassSpringDamper::new(MassSpringDamperParameters {
        contact: friction.under_load(lit(LOAD)).unwrap(),
        mechanism: mechanism(SPRING, 0.0),
        drive_velocity: lit(DRIVE),
        force: T::zero(),
    })
    .unwrap()
}

/// A mass under a force and pulled by a spring, with a damper.
fn shaken<T: Scalar, M: Bristle<T, Deflection = T>>(
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

fn valve_parameters<T: Scalar, M: Bristle<T, Deflection = T>, U>(
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

fn valve<T: Scalar, M: Bristle<T, Deflection = T>>(friction: M) -> DiaphragmValve<T, M, Sine<T>> {
    DiaphragmValve::new(valve_parameters(friction, input())).unwrap()
}

/// Runs a block with every scene, once in `f64` and once in dual numbers, for two models.
macro_rules! every_scene {
    (|$name:ident, $scene:ident, $dual:ident| $body:block) => {
        every_scene!(@model "FrBD", table_2_frbd, |$name, $scene, $dual| $body);
        every_scene!(@model "LuGre", table_2_lugre, |$name, $scene, $dual| $body);
    };
    (@model $model:expr, $friction:ident, |$name:ident, $scene:ident, $dual:ident| $body:block) => {
        {
            let ($name, $scene, $dual) = (
                concat!("prescribed velocity, ", $model),
                prescribed($friction::<f64>()),
                prescribed($friction::<Dual64>()),
            );
            $body
        }
        {
            let ($name, $scene, $dual) = (
                concat!("forced mass, ", $model),
                forced($friction::<f64>()),
                forced($friction::<Dual64>()),
            );
            $body
        }
        {
            let ($name, $scene, $dual) = (
                concat!("spring-driven mass, ", $model),
                driven($friction::<f64>()),
                driven($friction::<Dual64>()),
            );
            $body
        }
        {
            let ($name, $scene, $dual) = (
                concat!("all forces, ", $model),
                shaken($friction::<f64>()),
                shaken($friction::<Dual64>()),
            );
            $body
        }
        {
            let ($name, $scene, $dual) = (
                concat!("valve, ", $model),
                valve($friction::<f64>()),
                valve($friction::<Dual64>()),
            );
            $body
        }
    };
}

/// A state from random numbers in [−1, 1], within a few scales.
fn random_state<const N: usize>(scales: SVector<f64, N>, numbers: &[f64; 4]) -> SVector<f64, N> {
    SVector::from_fn(|i, _| 2.0 * numbers[i] * scales[i])
}

/// Checks `tangent` against the dual numbers of `rate`, column by column, on one branch.
fn assert_tangent<const N: usize>(
    name: &str,
    scene: &impl System<f64, N>,
    dual: &impl System<Dual64, N>,
    time: f64,
    state: SVector<f64, N>,
    branch: Branch,
) {
    let tangent = scene.linearised(time, &state, [branch]).unwrap();
    let rate = scene.rate(time, &state, [branch]);
    let scales = scene.scales();
    // The sum of the absolute terms of a row is not less than what the row's own derivatives
    // give over typical states; rates of a few scales lose a dozen roundings in sums of these.
    let sizes = SVector::<f64, N>::from_fn(|i, _| {
        (0..N).map(|j| (tangent.by_state[(i, j)] * state[j]).abs()).sum::<f64>()
            + (0..N).map(|j| (tangent.by_state[(i, j)] * scales[j]).abs()).sum::<f64>()
            + rate[i].abs()
            + tangent.by_time[i].abs()
    });
    let what = |part: &str, i: usize, j: usize| {
        format!("{name}, {part} [{i}, {j}] on {branch:?} at t = {time}, {state}")
    };
    let lifted = state.map(Dual64::from);
    for i in 0..N {
        assert_within(1e-13, sizes[i], tangent.rate[i], rate[i], || what("rate", i, 0));
    }
    for j in 0..N {
        let mut moved = lifted;
        moved[j].eps = 1.0;
        let column = dual.rate(Dual64::from(time), &moved, [branch]);
        for i in 0..N {
            let unit = sizes[i] / scales[j];
            let (got, want) = (tangent.by_state[(i, j)], column[i].eps);
            assert_within(1e-12, unit, got, want, || what("by_state", i, j));
        }
    }
    let column = dual.rate(Dual64::new(time, 1.0), &lifted, [branch]);
    for i in 0..N {
        // An input changes by its amplitude times 2π·0.7 per second.
        let unit = sizes[i] * 5.0;
        assert_within(1e-12, unit, tangent.by_time[i], column[i].eps, || what("by_time", i, 0));
    }
}

#[test]
fn every_tangent_is_the_derivative_of_the_rate() {
    let numbers = prop::array::uniform4(-1.0..1.0_f64);
    check(200, (numbers, 0.0..5.0_f64), |(numbers, time)| {
        every_scene!(|name, scene, dual| {
            let state = random_state(System::scales(&scene), &numbers);
            let [velocity] = scene.sliding_velocities(time, &state);
            // Free, on the right side, and on the wrong side where a model has an answer there (it
            // has none beyond a third of the way to its pole at 0.0155 m/s or more).
            let mut branches = vec![Branch::Free, Branch::towards(velocity)];
            if velocity.abs() < 0.004 {
                branches.push(Branch::towards(velocity).reversed());
            }
            for branch in branches {
                assert_tangent(name, &scene, &dual, time, state, branch);
            }
        });
    });
}

#[test]
fn a_locked_branch_has_derivatives_beyond_the_reversal() {
    // The law above meets slow slips rarely; here every state is one. A third of the way to the
    // pole at −μ_d/(σ1 + σ2) = −0.0155 m/s the model ends.
    let numbers = prop::array::uniform4(-1.0..1.0_f64);
    check(100, numbers, |numbers| {
        let (scene, dual) = (driven(table_2_frbd::<f64>()), driven(table_2_frbd::<Dual64>()));
        let mut state = random_state(scene.scales(), &numbers);
        state[1] = 0.004 * numbers[1];
        for branch in [Branch::Forward, Branch::Backward] {
            assert_tangent("slow", &scene, &dual, 1.0, state, branch);
        }
    });
}

#[test]
fn a_scene_knows_its_sliding_velocity_and_its_kinks() {
    let contact = || table_2_frbd::<f64>().under_load(1.0).unwrap();
    let ramp = Polyline::new([Vertex { time: 1.0, value: 0.0 }, Vertex { time: 2.0, value: 0.5 }])
        .unwrap();
    let kinks = |next: &dyn Fn(f64, f64) -> Option<f64>| {
        assert_eq!((next(0.0, 9.0), next(1.0, 9.0), next(2.0, 9.0)), (Some(1.0), Some(2.0), None));
    };
    let dragged = PrescribedVelocity::new(contact(), ramp);
    kinks(&|a, b| dragged.next_kink(a, b));
    assert_eq!(dragged.sliding_velocities(1.5, &Vector1::new(7.0)), [0.25]);
    assert_eq!(dragged.velocity(1.5), 0.25);
    let forced = MassSpringDamper::new(MassSpringDamperParameters {
        contact: contact(),
        mechanism: mechanism(0.0, 0.0),
        drive_velocity: 0.0,
        force: ramp,
    })
    .unwrap();
    kinks(&|a, b| forced.next_kink(a, b));
    assert_eq!(forced.sliding_velocities(1.5, &Vector3::new(7.0, 8.0, 9.0)), [8.0]);
    let valve = DiaphragmValve::new(valve_parameters(table_2_frbd(), ramp)).unwrap();
    kinks(&|a, b| valve.next_kink(a, b));
    assert_eq!(valve.sliding_velocities(1.5, &Vector4::new(6.0, 7.0, 8.0, 9.0)), [7.0]);
    let driven = driven(table_2_frbd::<f64>());
    assert_eq!(driven.next_kink(0.0, 9.0), None);
    assert_eq!(driven.sliding_velocities(1.5, &Vector3::new(7.0, 8.0, 9.0)), [8.0]);
}

// ---------------------------------------------------------------------------------------------
// Balances

#[test]
fn in_steady_sliding_the_spring_carries_the_friction() {
    // v = v_ref, z at its stationary value: every rate is zero where the spring's force is
    // p μ(v_ref), with the sign of the velocity.
    for drive in [0.1, -0.1, 0.003] {
        let rig = MassSpringDamper::new(MassSpringDamperParameters {
            contact: table_2_frbd::<f64>().under_load(LOAD).unwrap(),
            mechanism: mechanism(SPRING, 0.0),
            drive_velocity: drive,
            force: 0.0,
        })
        .unwrap();
        // Table 2 at the speed |v_ref|, written out.
        let speed = f64::abs(drive);
        let mu = 1.0 + 0.5 * (-(speed / 0.01).powi(2)).exp() + 0.04 * speed;
        let force = LOAD * mu * drive.signum();
        let time = 2.0;
        let state = Vector3::new(drive * time - force / SPRING, drive, mu * drive.signum() / 1e4);
        let friction = rig.friction_force(&state);
        // A few roundings of forces of a few newtons.
        assert!((friction - force).abs() < 1e-14 * 10.0, "{friction} {force}");
        assert!((rig.spring_force(time, &state) - force).abs() < 1e-14 * 10.0);
        let rate = rig.rate(time, &state, [Branch::Free]);
        assert!((rate - Vector3::new(drive, 0.0, 0.0)).norm() < 1e-13, "{rate}");
    }
}

#[test]
fn a_dragged_bristle_settles_at_its_stationary_force() {
    let velocity = -0.02;
    let contact = table_2_frbd::<f64>().under_load(LOAD).unwrap();
    let scene = PrescribedVelocity::new(contact, velocity);
    let mu = 1.0 + 0.5 * (-4.0f64).exp() + 0.04 * 0.02;
    let stationary = scene.stationary(0.0);
    assert!((stationary.x + mu / 1e4).abs() < 1e-18 * 10.0, "{stationary}");
    assert!((scene.friction_force(0.0, &stationary) + LOAD * mu).abs() < 1e-14 * 10.0);
    assert!(scene.rate(0.0, &stationary, [Branch::Free]).norm() < 1e-16);
    let solver = OfAny::checked(DormandPrince, Tolerances::scaled(1e-9, scene.scales()).unwrap());
    // λ = σ0 v/g is 88 1/s: in half a second e^-44 is left of the start.
    let run = solver.solve(&scene, 0.0..0.5, Vector1::new(1e-4), Output::Uniform(2)).unwrap();
    assert!((run.last().unwrap().1 - stationary).norm() < 1e-12);
}

#[test]
fn the_power_of_every_force_is_accounted_for() {
    // Kinetic and stored energy change by the work of the forces less the dissipated power, at
    // every state: checked with the rates themselves.
    let numbers = prop::array::uniform4(-1.0..1.0_f64);
    check(100, (numbers, 0.0..5.0_f64), |(numbers, time)| {
        let contact: Contact<f64, _> = table_2_frbd().under_load(LOAD).unwrap();
        let stored_rate = |z: f64, z_rate: f64| LOAD * 1e4 * z * z_rate;

        let rig = driven(table_2_frbd::<f64>());
        let state = random_state(rig.scales(), &numbers);
        let rate = rig.rate(time, &state, [Branch::Free]);
        let kinetic = MASS * state[1] * rate[1];
        let stored = stored_rate(state[2], rate[2]);
        let work = rig.spring_force(time, &state) * state[1];
        let loss = contact.dissipated_power(state[1], state[2]);
        let size = kinetic.abs() + stored.abs() + work.abs() + loss.abs();
        assert_within(1e-13, size, kinetic + stored + loss, work, || format!("rig, {state}"));
        assert!(loss >= 0.0);

        let mass = forced(table_2_frbd::<f64>());
        let state = random_state(mass.scales(), &numbers);
        let rate = mass.rate(time, &state, [Branch::Free]);
        let kinetic = MASS * state[1] * rate[1];
        let stored = stored_rate(state[2], rate[2]);
        let work = input::<f64>().value(time) * state[1];
        let loss = contact.dissipated_power(state[1], state[2]);
        let size = kinetic.abs() + stored.abs() + work.abs() + loss.abs();
        assert_within(1e-13, size, kinetic + stored + loss, work, || format!("mass, {state}"));

        let valve = valve(table_2_frbd::<f64>());
        let state = random_state(valve.scales(), &numbers);
        let rate = valve.rate(time, &state, [Branch::Free]);
        let kinetic = MASS * state[1] * rate[1];
        let stored = stored_rate(state[2], rate[2]);
        // S_a P − k x − F₀, with the numbers of `valve_parameters`.
        let forces = [0.04 * state[3], -2e3 * state[0], -25.0].map(|force| force * state[1]);
        let work: f64 = forces.iter().sum();
        let loss = contact.dissipated_power(state[1], state[2]);
        let size =
            kinetic.abs() + stored.abs() + loss.abs() + forces.map(f64::abs).iter().sum::<f64>();
        assert_within(1e-13, size, kinetic + stored + loss, work, || format!("valve, {state}"));
        // τ Ṗ = K_P OP + P_min − P.
        let lag = 0.9 * rate[3] + state[3];
        let asked = 17.0 * input::<f64>().value(time) + 410.0;
        assert_within(1e-14, asked.abs() + state[3].abs(), lag, asked, || format!("{state}"));
        assert_eq!(rate[0], state[1]);
    });
}

#[test]
fn energy_is_conserved_over_a_run_but_for_what_friction_takes() {
    // Over a slip of the rig: the work of the drive is ∫ k (y − x) v_ref dt, by the trapezium rule
    // on a fine grid; the loss by the same of the dissipated power.
    let rig = bristle_specimens::ode::stick_slip::<f64>();
    let contact: Contact<f64, FrBd<Stribeck<f64>, KelvinVoigt<f64>>> =
        table_2_frbd().under_load(1.0).unwrap();
    let solver = OfAny::checked(DormandPrince, Tolerances::scaled(1e-9, rig.scales()).unwrap());
    let samples = 10_001;
    let run = solver.solve(&rig, 0.0..11.0, rig.at_rest(), Output::Uniform(samples)).unwrap();
    let step = 11.0 / (samples - 1) as f64;
    let (mut work, mut loss) = (0.0, 0.0);
    for (i, (time, state)) in run.iter().enumerate() {
        let weight = if i == 0 || i == samples - 1 { 0.5 * step } else { step };
        work += weight * rig.spring_force(time, state) * 0.1;
        loss += weight * contact.dissipated_power(state[1], state[2]);
    }
    let (time, end) = run.last().unwrap();
    let stretch = rig.spring_force(time, end) / 2.0;
    let energy = stretch * stretch + 0.5 * end[1] * end[1] + contact.stored_energy(end[2]);
    // The trapezium rule over a slip that lasts ten milliseconds at its sharpest: (h/10 ms)²/12 of
    // the loss there.
    assert!((work - energy - loss).abs() < 1e-4 * work, "{work} {energy} {loss}");
    assert!(loss > 0.1 * work, "{loss} of {work}");
}

#[test]
fn at_rest_is_an_equilibrium_of_what_is_not_driven() {
    let rig = driven(table_2_frbd::<f64>());
    let rate = rig.rate(0.0, &rig.at_rest(), [Branch::Free]);
    assert_eq!(rate, Vector3::zeros());
    let mass = MassSpringDamper::new(MassSpringDamperParameters {
        contact: table_2_frbd::<f64>().under_load(LOAD).unwrap(),
        mechanism: mechanism(0.0, 0.0),
        drive_velocity: 0.0,
        force: 0.0,
    })
    .unwrap();
    assert_eq!(mass.rate(0.0, &mass.at_rest(), [Branch::Free]), Vector3::zeros());
}

#[test]
fn a_balanced_valve_moves_with_its_pressure_alone() {
    let valve = DiaphragmValve::new(valve_parameters(table_2_frbd(), 40.0)).unwrap();
    let state = valve.balanced(0.0);
    // P = 410 + 17·40 = 1090 Pa; x = (0.04·1090 − 25)/2000 m.
    let expected = Vector4::new(18.6 / 2e3, 0.0, 0.0, 1090.0);
    assert!((state - expected).norm() < 1e-12, "{state}");
    let rate = valve.rate(0.0, &state, [Branch::Free]);
    // Forces of 40 N that cancel.
    assert!(rate.norm() < 1e-12, "{rate}");
    assert_eq!(valve.friction_force(&state), 0.0);
}

// ---------------------------------------------------------------------------------------------
// Scales

#[test]
fn every_scale_is_positive_and_makes_tolerances() {
    every_scene!(|name, scene, dual| {
        let scales = System::scales(&scene);
        assert!(scales.iter().all(|scale| scale.is_finite() && *scale > 0.0), "{name}: {scales}");
        assert!(Tolerances::scaled(1e-6, scales).is_ok(), "{name}");
        let lifted = System::scales(&dual).map(|scale| scale.re);
        // Dual numbers divide by way of the reciprocal.
        assert!((lifted - scales).component_div(&scales).abs().max() < 1e-15, "{name}: {lifted}");
    });
}

#[test]
fn the_scales_are_those_of_a_breakaway() {
    // μ_s = 1.5, σ0 = 1e4: z = 1.5e-4 m, F = 1.5 p.
    let force = 1.5 * LOAD;
    let rig = driven(table_2_frbd::<f64>());
    let stretch = force / SPRING;
    let released = stretch * f64::sqrt(SPRING / MASS);
    let expected = Vector3::new(stretch, released, 1.5e-4);
    // Two or three roundings.
    let close = |got: f64, want: f64| (got / want - 1.0).abs() < 1e-14;
    assert!(rig.scales().iter().zip(&expected).all(|(&a, &b)| close(a, b)), "{}", rig.scales());
    // A drive that is faster than the release sets the scale of the velocity.
    let fast = MassSpringDamper::new(MassSpringDamperParameters {
        contact: table_2_frbd::<f64>().under_load(LOAD).unwrap(),
        mechanism: mechanism(SPRING, 0.0),
        drive_velocity: -50.0,
        force: 0.0,
    });
    assert_eq!(fast.unwrap().scales()[1], 50.0);

    let oscillation = f64::sqrt(force / MASS * 1.5e-4);
    let expected = Vector3::new(1.5e-4, oscillation, 1.5e-4);
    let scales = forced(table_2_frbd::<f64>()).scales();
    assert!(scales.iter().zip(&expected).all(|(&a, &b)| close(a, b)), "{scales}");

    let expected = Vector4::new(0.04 * 1700.0 / 2e3, oscillation, 1.5e-4, 1700.0);
    let scales = valve(table_2_frbd::<f64>()).scales();
    assert!(scales.iter().zip(&expected).all(|(&a, &b)| close(a, b)), "{scales}");

    assert!(close(prescribed(table_2_frbd::<f64>()).scales()[0], 1.5e-4));
}

#[test]
fn a_system_of_ones_own_has_scales_of_one_and_no_tangent() {
    assert_eq!(bristle_specimens::ode::Oscillator.scales(), Vector2::repeat(1.0));
    assert_eq!(bristle_specimens::ode::Oscillator.next_kink(0.0, 1.0), None);
    assert_eq!(bristle_specimens::ode::Oscillator.linearised(0.0, &Vector2::zeros(), []), None);
}

// ---------------------------------------------------------------------------------------------
// What is refused

fn dahl() -> Contact<f64, Dahl<f64>> {
    let dahl = DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: 1e3 };
    Dahl::new(dahl).unwrap().under_load(1.0).unwrap()
}

#[track_caller]
fn assert_refused<S>(result: Result<S, ParameterError>, name: &str, value: f64) {
    let Err(error) = result else { panic!("{name} = {value} is accepted") };
    assert_eq!((error.name, error.value.to_bits()), (name, value.to_bits()));
}

#[test]
fn a_parameter_out_of_its_range_is_refused_by_name() {
    let force = 1.0;
    let whole = Mechanism { mass: 1.0, spring_stiffness: 2.0, viscous_damping: 0.5 };
    let driven = MassSpringDamperParameters {
        contact: dahl(),
        mechanism: whole,
        drive_velocity: 0.1,
        force,
    };
    let of = |mechanism| MassSpringDamper::new(MassSpringDamperParameters { mechanism, ..driven });
    let model = Dahl::new(DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: 1e3 });
    let valve = valve_parameters(model.unwrap(), force);

    let not_numbers = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    for bad in not_numbers {
        let refused = MassSpringDamperParameters { drive_velocity: bad, ..driven };
        assert_refused(MassSpringDamper::new(refused), "drive_velocity", bad);
        let refused = DiaphragmValveParameters { preload: bad, ..valve };
        assert_refused(DiaphragmValve::new(refused), "preload", bad);
    }
    for bad in not_numbers.into_iter().chain([-1.0]) {
        let refused = DiaphragmValveParameters { least_pressure: bad, ..valve };
        assert_refused(DiaphragmValve::new(refused), "least_pressure", bad);
        let refused = of(Mechanism { spring_stiffness: bad, ..whole });
        assert_refused(refused, "spring_stiffness", bad);
        let refused = of(Mechanism { viscous_damping: bad, ..whole });
        assert_refused(refused, "viscous_damping", bad);
    }
    for bad in not_numbers.into_iter().chain([-1.0, 0.0]) {
        assert_refused(of(Mechanism { mass: bad, ..whole }), "mass", bad);
        let spring = Mechanism { spring_stiffness: bad, ..valve.mechanism };
        let refused = [
            ("diaphragm_area", DiaphragmValveParameters { diaphragm_area: bad, ..valve }),
            ("spring_stiffness", DiaphragmValveParameters { mechanism: spring, ..valve }),
            ("pressure_gain", DiaphragmValveParameters { pressure_gain: bad, ..valve }),
            ("time_constant", DiaphragmValveParameters { time_constant: bad, ..valve }),
        ];
        for (name, parameters) in refused {
            assert_refused(DiaphragmValve::new(parameters), name, bad);
        }
    }
    // What may be zero or negative is.
    let still = MassSpringDamperParameters { drive_velocity: 0.0, ..driven };
    assert!(MassSpringDamper::new(still).is_ok());
    assert!(of(Mechanism { spring_stiffness: 0.0, viscous_damping: 0.0, ..whole }).is_ok());
    let slack = DiaphragmValveParameters { preload: -3.0, least_pressure: 0.0, ..valve };
    assert!(DiaphragmValve::new(slack).is_ok());
}
