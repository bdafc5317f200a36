//! The scenes: their balances against closed forms, their scales, and what they refuse. Their
//! derivatives are in development/all/tests/dual.
#![cfg(feature = "alloc")]

use bristle::ode::{DormandPrince, Output, System, Tolerances};
use bristle::scene::{
    DiaphragmValve, DiaphragmValveParameters, MassSpringDamper, MassSpringDamperParameters,
    PrescribedVelocity,
};
use bristle::signal::{Polyline, Signal, Vertex};
use bristle::{Branch, Bristle, Contact, Dahl, DahlParameters, Mechanism};
use bristle_specimens::ode::{OfAny, table_2_frbd};
use bristle_specimens::scenes::{
    LOAD, MASS, SPRING, driven, forced, input, mechanism, prescribed, random_state, valve,
    valve_parameters,
};
use bristle_specimens::{assert_fields_refuse, assert_within, check};
use nalgebra::{Vector1, Vector2, Vector3, Vector4};
use proptest::prelude::*;

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
        // States and rates of velocity and deflection, and the work of every force.
        let balance = |name, [v, z]: [f64; 2], [v_rate, z_rate]: [f64; 2], work: &[f64]| {
            let (kinetic, stored) = (MASS * v * v_rate, LOAD * 1e4 * z * z_rate);
            let loss = contact.dissipated_power(v, z);
            let size = [kinetic, stored, loss].iter().chain(work).map(|term| term.abs()).sum();
            let (got, work) = (kinetic + stored + loss, work.iter().sum());
            assert_within(1e-13, size, got, work, || format!("{name}, v = {v}, z = {z}"));
            assert!(loss >= 0.0);
        };
        let rig = driven(table_2_frbd::<f64>());
        let state = random_state(rig.scales(), &numbers);
        let rate = rig.rate(time, &state, [Branch::Free]);
        let work = rig.spring_force(time, &state) * state.y;
        balance("rig", [state.y, state.z], [rate.y, rate.z], &[work]);

        let mass = forced(table_2_frbd::<f64>());
        let state = random_state(mass.scales(), &numbers);
        let rate = mass.rate(time, &state, [Branch::Free]);
        let work = input::<f64>().value(time) * state.y;
        balance("mass", [state.y, state.z], [rate.y, rate.z], &[work]);

        let valve = valve(table_2_frbd::<f64>());
        let state = random_state(valve.scales(), &numbers);
        let rate = valve.rate(time, &state, [Branch::Free]);
        // S_a P − k x − F₀, with the numbers of `valve_parameters`.
        let work = [0.04 * state.w, -2e3 * state.x, -25.0].map(|force| force * state.y);
        balance("valve", [state.y, state.z], [rate.y, rate.z], &work);
        // τ Ṗ = K_P OP + P_min − P.
        let lag = 0.9 * rate.w + state.w;
        let asked = 17.0 * input::<f64>().value(time) + 410.0;
        assert_within(1e-14, asked.abs() + state.w.abs(), lag, asked, || format!("{state}"));
        assert_eq!(rate.x, state.y);
    });
}

#[test]
fn energy_is_conserved_over_a_run_but_for_what_friction_takes() {
    // Over a slip of the rig: the work of the drive is ∫ k (y − x) v_ref dt, by the trapezium rule
    // on a fine grid; the loss by the same of the dissipated power.
    let rig = bristle_specimens::ode::stick_slip::<f64>();
    let contact: Contact<f64, _> = table_2_frbd().under_load(1.0).unwrap();
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

fn dahl() -> Contact<f64, Dahl<f64>> {
    let dahl = DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: 1e3 };
    Dahl::new(dahl).unwrap().under_load(1.0).unwrap()
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

    let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, 0.0];
    let (numbers, negative) = (&bad[..3], &bad[..4]);
    let springs = |mechanism| DiaphragmValve::new(DiaphragmValveParameters { mechanism, ..valve });
    assert_fields_refuse!(numbers.iter().copied(), MassSpringDamper::new, driven; drive_velocity);
    assert_fields_refuse!(numbers.iter().copied(), DiaphragmValve::new, valve; preload);
    assert_fields_refuse!(negative.iter().copied(), DiaphragmValve::new, valve; least_pressure);
    assert_fields_refuse!(negative.iter().copied(), of, whole; spring_stiffness viscous_damping);
    assert_fields_refuse!(bad, of, whole; mass);
    assert_fields_refuse!(bad, springs, valve.mechanism; spring_stiffness);
    assert_fields_refuse!(bad, DiaphragmValve::new, valve;
        diaphragm_area pressure_gain time_constant);
    // What may be zero or negative is.
    let still = MassSpringDamperParameters { drive_velocity: 0.0, ..driven };
    assert!(MassSpringDamper::new(still).is_ok());
    assert!(of(Mechanism { spring_stiffness: 0.0, viscous_damping: 0.0, ..whole }).is_ok());
    let slack = DiaphragmValveParameters { preload: -3.0, least_pressure: 0.0, ..valve };
    assert!(DiaphragmValve::new(slack).is_ok());
}
