//! A geared joint: check values, closed forms of steady motion, energy, order of its own step.
#![cfg(feature = "alloc")]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test panics to fail")]

use bristle::curve::{Asymmetric, Stribeck, StribeckParameters};
use bristle::nalgebra::Vector3;
use bristle::ode::{self, Automatic, Output, Solver, System, Tolerances};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::signal::{Function, Sine, SineParameters};
use bristle::{Branch, Dahl, DahlParameters, FrBd, Scalar, Surface};
use bristle_joint::{
    CurrentMotor, CurrentMotorParameters, GearFriction, GearFrictionParameters, GearTorques,
    GearedJoint, GearedJointParameters, Gravity, JointInput, JointInputValue, JointMotion,
    JointState, JointTorques, LoadLaw, LoadedDeflection, PositionControl, TorqueLoad,
    TorqueLoadParameters, VoltageMotor, VoltageMotorParameters,
};
use bristle_specimens::draw::Draw;
use bristle_specimens::implicit::TABLE_2;
use bristle_specimens::{assert_fields_refuse, assert_refused, assert_within, check};
use proptest::prelude::*;

type Friction = FrBd<Stribeck<f64>, KelvinVoigt<f64>>;
type Gear = GearFriction<f64, Friction, TorqueLoad<f64>>;

fn friction() -> Friction {
    let curve = StribeckParameters {
        static_coefficient: 0.15,
        dynamic_coefficient: 0.1,
        stribeck_velocity: 0.05,
        stribeck_exponent: 1.0,
        viscous_friction: 0.0,
    };
    let bristle = KelvinVoigtParameters { micro_stiffness: 300.0, micro_damping: 1.0 };
    FrBd::new(Stribeck::new(curve).unwrap(), KelvinVoigt::new(bristle).unwrap())
}

const LOAD: TorqueLoadParameters<f64> =
    TorqueLoadParameters { idle_load: 2.0, motor_share: 1.0, external_share: 0.6 };

/// Stiffness and damping were measured on the idle gear.
const REFERENCE: f64 = LOAD.idle_load;

fn gear_of(load: TorqueLoadParameters<f64>) -> Gear {
    measured_at(REFERENCE, load)
}

fn measured_at(reference_load: f64, load: TorqueLoadParameters<f64>) -> Gear {
    let load = TorqueLoad::new(load).unwrap();
    GearFriction::new(GearFrictionParameters {
        friction: friction(),
        load,
        reference_load,
        drag: 0.05,
        fastest: 5.0,
    })
    .unwrap()
}

/// 1.5 sin 2t.
fn motor() -> Sine<f64> {
    let frequency = std::f64::consts::FRAC_1_PI;
    Sine::new(SineParameters { mean: 0.0, amplitude: 1.5, frequency, phase: 0.0 }).unwrap()
}

const GRAVITY: Gravity<f64> = Gravity { horizontal_torque: 1.2, hanging_angle: 0.0 };

fn joint<A: JointInput<f64>>(
    motor: A,
) -> GearedJoint<f64, Friction, TorqueLoad<f64>, A, Gravity<f64>> {
    driven(LOAD, motor, GRAVITY)
}

/// The joint of [`joint`] with another gear and other torques.
fn driven<A: JointInput<f64>, E: JointInput<f64>>(
    load: TorqueLoadParameters<f64>,
    motor: A,
    external: E,
) -> GearedJoint<f64, Friction, TorqueLoad<f64>, A, E> {
    joint_of(gear_of(load), motor, external)
}

fn joint_of<A: JointInput<f64>, E: JointInput<f64>>(
    gear: Gear,
    motor: A,
    external: E,
) -> GearedJoint<f64, Friction, TorqueLoad<f64>, A, E> {
    GearedJoint::new(GearedJointParameters { gear, inertia: 0.02, motor, external }).unwrap()
}

/// Where a joint is after so many steps.
fn stepped<T, M, A, E>(
    joint: &GearedJoint<T, M, TorqueLoad<T>, A, E>,
    start: JointState<T>,
    steps: u32,
    duration: T,
) -> JointState<T>
where
    T: Scalar,
    M: bristle::Bristle<T, Deflection = T>,
    A: JointInput<T>,
    E: JointInput<T>,
{
    (0..steps).fold(start, |state, _| joint.step(&state, duration).unwrap().0)
}

/// Reference load [N m] and state at 10 s of independent integrations, to 1e-8.
const CHECKS: [(f64, [f64; 3]); 2] = [
    (2.0, [1.04519417, 0.0628400642, 7.06572534e-4]),
    (3.0, [1.04772139, 0.042528014, 4.84762174e-4]),
];

#[test]
fn the_check_values() {
    for (reference_load, want) in CHECKS {
        let joint = joint_of(measured_at(reference_load, LOAD), motor(), GRAVITY);
        let run =
            ode::solve(&joint, 0.0..10.0, joint.at_rest(0.3), 1e-9, Output::Uniform(2)).unwrap();
        let end = run.states()[1];
        // Of the angle eight decimals, of the others at least eight digits.
        for (i, digits) in [1e-8, 1e-9, 1e-11].into_iter().enumerate() {
            let what = || format!("state {i} for P = {reference_load}");
            assert_within(digits, 1.0, end[i], want[i], what);
        }
    }
}

/// A gear at rest whose load varies by ±50 % at 20 Hz while it holds a constant torque, with steps
/// of 1 ms. The torque through the friction is a share of what the least load holds.
fn held(share: f64, seconds: f64) -> f64 {
    // p = 2 + 2 + sin, of which a half comes with the motor torque.
    let load = TorqueLoadParameters { idle_load: 2.0, motor_share: 1.0, external_share: 0.0 };
    let (gear, inertia, h) = (measured_at(4.0, load), 0.02, 1e-3);
    let pull = share * 0.15 * 2.0;
    let (mut state, mut way) = (JointState::at_rest(0.0), 0.0);
    while state.time < seconds {
        let torques = |middle: JointMotion<f64>| {
            // What loads the gear is not what moves the joint: an inner pair that cancels.
            let loading = 2.0 + 2.0 * (std::f64::consts::TAU * 20.0 * middle.time).sin();
            let loading = GearTorques { motor: loading, external: 0.0 };
            let (motor, external) =
                (JointInputValue::constant(pull), JointInputValue::constant(0.0));
            JointTorques { motor, external, loading }
        };
        let (next, _) = gear.joint_step(inertia, &state, h, torques).unwrap();
        if state.time >= 1.0 {
            way += next.angle - state.angle;
        }
        state = next;
    }
    way
}

#[test]
fn a_held_joint_does_not_walk_while_the_load_varies() {
    for share in [0.3, 0.9] {
        // A rounding of the angle, 1e-3 rad, in each of 1e5 steps is far more than comes out.
        let way = held(share, 100.0);
        assert!(way.abs() <= 1e-12, "{share} of what it holds: {way:e} rad");
    }
}

#[test]
#[ignore = "an hour of a held joint takes a minute"]
fn a_held_joint_does_not_walk_in_an_hour() {
    let way = held(0.9, 3600.0);
    assert!(way.abs() <= 1e-12, "{way:e} rad");
}

#[test]
fn the_friction_never_exceeds_what_the_load_holds() {
    check(64, any::<u64>(), |seed| {
        let mut draw = Draw(seed);
        let gear = gear_of(LOAD);
        for _ in 0..200 {
            let [before, load] = [0; 2].map(|_| draw.logarithmic(1e-3, 1e2));
            let (v, z) = (draw.sign() * draw.logarithmic(1e-6, 10.0), draw.sign() * draw.next());
            let force = gear.contact().response_under(load, v, z).force;
            // μ ≤ 0.15; a few roundings.
            let most = 0.15 * load * (1.0 + 1e-14);
            assert!(force.abs() <= most, "{force} N m");
            // A stuck bristle that the load before held.
            let deflection = z * 0.15 * before / (300.0 * REFERENCE);
            let torques = GearTorques { motor: load - LOAD.idle_load, external: 0.0 };
            if torques.motor >= 0.0 {
                let bristle = LoadedDeflection { deflection, load: before };
                let step = gear.step(torques, 0.0, bristle, 1e-9).unwrap();
                assert!(step.bias().abs() <= most, "{} N m", step.bias());
            }
        }
    });
}

#[test]
fn steps_under_the_reference_load_are_those_of_its_contact_to_the_last_bit() {
    let number = GearFrictionParameters {
        friction: friction(),
        load: 2.0,
        reference_load: 2.0,
        drag: 0.0,
        fastest: 5.0,
    };
    let gear = GearFriction::new(number).unwrap();
    let companion = bristle::Bristle::under_load(friction(), 2.0).unwrap().companion(5.0).unwrap();
    let (mut loaded, mut plain, mut draw) = (LoadedDeflection::none(), 0.0, Draw(7));
    for _ in 0..1000 {
        let v = draw.sign() * draw.logarithmic(1e-5, 10.0);
        let torques = GearTorques { motor: draw.next(), external: draw.next() };
        let done = gear.step(torques, v, loaded, 1e-3).unwrap().commit(v);
        let want = companion.step(v, plain, 1e-3).commit(v);
        (loaded, plain) = (done.deflection, want.deflection);
        assert_eq!((loaded.deflection, done.force), (plain, want.force));
    }
}

#[test]
fn steady_motion_obeys_the_balances() {
    for scale in [1.0, 0.3] {
        let mut gear = gear_of(LOAD);
        gear.set_friction_scale(scale).unwrap();
        gear.set_drag_scale(0.5).unwrap();
        for (velocity, external) in [(0.01, 5.0), (2.0, 5.0), (0.3, 40.0)] {
            let driving = gear.driving_torque(velocity, external).unwrap();
            let braking = gear.braking_torque(velocity, external).unwrap();
            for (motor, external) in [(driving, -external), (-braking, external)] {
                for direction in [1.0, -1.0] {
                    let parameters = GearedJointParameters {
                        gear,
                        inertia: 1.0,
                        motor: direction * motor,
                        external: direction * external,
                    };
                    let joint = GearedJoint::new(parameters).unwrap();
                    let torques = joint.torques(0.0, &Vector3::zeros());
                    let surface = Surface::scaled(velocity, gear.load(torques) / REFERENCE);
                    let z = direction * gear.contact().stationary(surface);
                    let state = Vector3::new(0.0, direction * velocity, z);
                    let branch = if direction > 0.0 { Branch::Forward } else { Branch::Backward };
                    let rate = joint.rate(0.0, &state, [branch]);
                    assert_within(1e-14, external.abs(), rate[1], 0.0, || "v̇".into());
                    assert_within(1e-14, 1.0, rate[2], 0.0, || "ż".into());
                }
            }
        }
    }
    // At 40 rad/s μ = 0.1: μ k_m = 1 jams, μ k_e = 1 holds.
    let jams = gear_of(TorqueLoadParameters { motor_share: 10.0, ..LOAD });
    assert_eq!(jams.driving_torque(40.0, 1.0), None);
    let holds = gear_of(TorqueLoadParameters { external_share: 10.0, ..LOAD });
    assert_eq!(holds.braking_torque(1.0, 1e9), None);
}

/// A gear whose stiffness was measured under an external torque.
fn measured_under(external: f64, external_share: f64) -> Gear {
    let load = TorqueLoadParameters { external_share, ..LOAD };
    measured_at(load.idle_load + external_share * external, load)
}

/// How far [rad] an external torque that grows for two seconds, and stays for one, turns a gear.
fn turned(external_share: f64, external: f64) -> f64 {
    let gear = measured_under(external, external_share);
    let external = Function::new(|t: f64| (external * f64::min(0.5 * t, 1.0), 0.0), [2.0]);
    stepped(&joint_of(gear, 0.0, external), JointState::at_rest(0.0), 3000, 1e-3).angle
}

#[test]
fn a_gear_is_driven_from_outside_beyond_its_torque_and_a_self_locking_one_never() {
    let audit = gear_of(LOAD).audit(1.0, 5.0).unwrap();
    // μ_s p0/(1 − μ_s k_e) = 0.3/0.91
    let torque = audit.back_driving_torque.unwrap();
    assert_within(1e-14, 1.0, torque, 0.3 / 0.91, || "torque".into());
    // The bristle at breakaway is deflected by μ_s/σ0 = 5e-4 rad.
    let (below, beyond) = (turned(0.6, 0.9 * torque), turned(0.6, 1.1 * torque));
    assert!(below < 2e-3 && beyond > 0.1, "{below} and {beyond} rad");
    // μ_s k_e = 1: the torque would be infinite.
    let load = TorqueLoadParameters { external_share: 0.15_f64.recip(), ..LOAD };
    let audit = gear_of(load).audit(1.0, 5.0).unwrap();
    assert!(audit.static_locking == 1.0 && audit.back_driving_torque.is_none(), "{audit:?}");
    // μ_d k_e = 1.1
    let load = TorqueLoadParameters { external_share: 11.0, ..LOAD };
    let audit = gear_of(load).audit(1.0, 5.0).unwrap();
    assert!(audit.locking > 1.0 && audit.back_driving_torque.is_none());
    assert_within(1e-14, 1.65, audit.static_locking, 1.65, || "μ_s k_e".into());
    for external in [1.0, 1e2, 1e4] {
        // The bristle takes the torque with its stiffness P σ0. It carries at most 1/1.1 of μ_d p,
        // so that a radian of motion deflects it by 1 − 1/1.1 at least.
        let (turned, least) =
            (turned(11.0, external), external / (300.0 * (2.0 + 11.0 * external)));
        assert!(turned > least && turned < least / (1.0 - 1.0 / 1.1), "{external} N m: {turned}");
        // In motion it stops. The stuck joint swings at √(σ0 p/J) = 4e4 rad/s at most.
        let start = JointState { velocity: 1.0, ..JointState::at_rest(0.0) };
        let joint = joint_of(measured_under(external, 11.0), 0.0, external);
        let state = stepped(&joint, start, 20_000, 2e-5);
        assert!(state.velocity.abs() < 1e-3, "{external} N m: {} rad/s", state.velocity);
    }
}

#[test]
fn the_audit_prints_efficiencies() {
    // μ = 0.1 at 1 rad/s up to e⁻²⁰: c = 0.2 + 0.05.
    let audit = gear_of(LOAD).audit(-1.0, 5.0).unwrap();
    let mu = 0.1 + 0.05 * (-20.0f64).exp();
    let driving = (5.0 * (1.0 + 0.6 * mu) + 2.0 * mu + 0.05) / (1.0 - mu);
    let braking = (5.0 * (1.0 - 0.6 * mu) - 2.0 * mu - 0.05) / (1.0 + mu);
    assert_within(1e-14, driving, audit.driving_torque.unwrap(), driving, || "driving".into());
    assert_within(1e-14, braking, audit.braking_torque.unwrap(), braking, || "braking".into());
    assert_within(1e-14, 1.0, audit.driving_efficiency.unwrap(), 5.0 / driving, || "η".into());
    assert_within(1e-14, 1.0, audit.braking_efficiency.unwrap(), braking / 5.0, || "η".into());
    let printed = audit.to_string();
    for part in ["no, moves", "μ_s k_e = 0.09", "from 0.32967 N m on", "0.84906", "0.85455"] {
        assert!(printed.contains(part), "{part} in\n{printed}");
    }
    let locking = gear_of(TorqueLoadParameters { external_share: 12.0, motor_share: 11.0, ..LOAD });
    let printed = locking.audit(1.0, 5.0).unwrap().to_string();
    for part in ["yes: μ_s k_e = 1.8, μ k_e = 1.2", "JAMS", "friction holds this torque"] {
        assert!(printed.contains(part), "{part} in\n{printed}");
    }
    let holds = gear_of(TorqueLoadParameters { external_share: 8.0, ..LOAD });
    assert!(holds.audit(1.0, 5.0).unwrap().to_string().contains("AT REST ONLY: μ_s k_e = 1.2"));
    for (velocity, torque, name) in [
        (0.0, 1.0, "velocity"),
        (f64::NAN, 1.0, "velocity"),
        (1.0, 0.0, "external_torque"),
        (1.0, f64::INFINITY, "external_torque"),
    ] {
        assert_eq!(locking.audit(velocity, torque).unwrap_err().name, name);
    }
}

#[test]
fn a_step_of_the_joint_is_of_second_order() {
    let servo = joint(servo());
    let end = 0.4;
    let start = Vector3::new(0.3, 0.0, 0.0);
    let want = ode::solve(&servo, 0.0..end, start, 1e-11, Output::Uniform(2)).unwrap().states()[1];
    let first = servo.rate(0.0, &start, [Branch::Forward])[1];
    let mut errors = |steps: u32| {
        let start = JointState { acceleration: first, ..JointState::at_rest(0.3) };
        let state = stepped(&servo, start, steps, end / f64::from(steps));
        [state.angle - want[0], state.velocity - want[1], state.deflection - want[2]].map(f64::abs)
    };
    let all = [500, 1000, 2000, 4000].map(&mut errors);
    for i in 0..3 {
        let order = (all[0][i] / all[3][i]).log2() / 3.0;
        assert!((order - 2.0).abs() < 0.25, "state {i}: order {order}, {all:?}");
    }
}

/// A position servo that runs into the limit of its supply.
fn servo() -> impl JointInput<f64> + Copy {
    VoltageMotor::new(VoltageMotorParameters {
        voltage: PositionControl {
            reference: motor(),
            proportional_gain: 20.0,
            derivative_gain: 0.2,
        },
        torque_constant: 1.2,
        resistance: 2.4,
        largest_voltage: Some(12.0),
        largest_current: Some(4.0),
    })
    .unwrap()
}

#[test]
fn a_gear_gives_no_more_than_it_stored_whatever_torques_and_scales_do() {
    check(64, any::<u64>(), |seed| {
        let mut draw = Draw(seed);
        let idle_load = if seed % 2 == 0 { 0.0 } else { 2.0 };
        let mut gear = gear_of(TorqueLoadParameters { idle_load, ..LOAD });
        let (mut bristle, mut given, mut size) = (LoadedDeflection::none(), 0.0, 0.0);
        let stored = |z: f64| 0.5 * REFERENCE * 300.0 * z * z;
        for _ in 0..300 {
            let mut torque = || {
                let none = draw.next() < 0.2;
                if none { 0.0 } else { draw.sign() * draw.logarithmic(1e-2, 1e2) }
            };
            let torques = GearTorques { motor: torque(), external: torque() };
            gear.set_friction_scale(draw.one_of(&[0.0, 0.5, 1.0, 2.0])).unwrap();
            gear.set_drag_scale(draw.one_of(&[0.0, 1.0])).unwrap();
            let mut velocity = || draw.sign() * draw.logarithmic(1e-5, 10.0);
            let (predicted, mean) = (velocity(), velocity());
            let before = stored(bristle.deflection);
            let h = draw.logarithmic(1e-5, 1.0);
            let step = gear.step(torques, predicted, bristle, h).unwrap();
            assert!(step.damping() >= 0.0);
            let done = step.commit(mean);
            bristle = done.deflection;
            assert_eq!(bristle.load, gear.load(torques));
            let after = stored(bristle.deflection);
            let terms = before + after + done.work.abs();
            // A hundred roundings of the terms.
            assert_within(1e-14, terms, done.stored, after - before, || "stored".into());
            assert_within(1e-14, terms, done.work, done.stored + done.dissipated, || "D".into());
            assert_within(1e-14, terms, done.work, h * done.force * mean, || "T".into());
            let torque = step.torque(mean);
            let sum = step.bias().abs() + step.damping() * mean.abs();
            assert_within(1e-15, sum, done.force, torque, || "T".into());
            assert!(done.dissipated >= 0.0);
            given += done.work;
            size += terms;
            assert!(given - after >= -1e-14 * size, "{given:e} of {size:e}");
        }
    });
}

#[test]
fn a_joint_in_single_precision_goes_the_same_way() {
    fn lit<T: Scalar>(value: f64) -> T {
        bristle::nalgebra::convert(value)
    }
    fn end<T: Scalar>() -> f64 {
        let friction = Dahl::new(DahlParameters {
            dynamic_coefficient: lit::<T>(0.1),
            micro_stiffness: lit(300.0),
        });
        let load = TorqueLoadParameters {
            idle_load: lit::<T>(2.0),
            motor_share: lit(1.0),
            external_share: lit(0.6),
        };
        let gear = GearFriction::new(GearFrictionParameters {
            friction: friction.unwrap(),
            load: TorqueLoad::new(load).unwrap(),
            reference_load: lit(2.0),
            drag: lit(0.05),
            fastest: lit(5.0),
        });
        let gravity = Gravity { horizontal_torque: lit(1.2), hanging_angle: lit(0.0) };
        let joint = GearedJoint::new(GearedJointParameters {
            gear: gear.unwrap(),
            inertia: lit(0.02),
            motor: lit::<T>(0.0),
            external: gravity,
        })
        .unwrap();
        let state = stepped(&joint, JointState::at_rest(lit(1.5)), 500, lit(1e-3));
        state.angle.to_subset_unchecked()
    }
    assert_within(1e-4, 1.0, end::<f32>(), end::<f64>(), || "angle".into());
}

/// The derivatives of an input, by central differences.
fn derivatives_are_slopes(input: &impl JointInput<f64>, motion: JointMotion<f64>) {
    let h = 1e-5;
    let at = |angle: f64, velocity: f64| {
        let JointMotion { time, angle: q, velocity: v } = motion;
        input.at(JointMotion { time, angle: q + angle, velocity: v + velocity }).value
    };
    let got = input.at(motion);
    let slope = |up: f64, down: f64| (up - down) / (2.0 * h);
    let want = [slope(at(h, 0.0), at(-h, 0.0)), slope(at(0.0, h), at(0.0, -h))];
    for (got, want) in [got.by_angle, got.by_velocity].into_iter().zip(want) {
        // h² and roundings over h.
        assert_within(1e-8, 1.0 + want.abs(), got, want, || format!("{input:?} at {motion:?}"));
    }
}

#[test]
fn the_derivatives_of_every_input_are_its_slopes() {
    let current = CurrentMotorParameters {
        current: motor(),
        torque_constant: 1.2,
        largest_current: Some(1.0),
    };
    let current = CurrentMotor::new(current).unwrap();
    let time = Function::new(|t: f64| (t * t, 2.0 * t), [1.0]);
    for n in 0..200 {
        let t = 0.037 * f64::from(n);
        let motion = JointMotion { time: t, angle: t.sin(), velocity: 3.0 * (2.3 * t).cos() };
        derivatives_are_slopes(&GRAVITY, motion);
        derivatives_are_slopes(&time, motion);
        derivatives_are_slopes(&3.0, motion);
        derivatives_are_slopes(&motor(), motion);
        derivatives_are_slopes(&current, motion);
        derivatives_are_slopes(&servo(), motion);
    }
    let saturated = current.at(JointMotion { time: 0.8, angle: 0.0, velocity: 0.0 });
    assert_eq!(saturated.value, 1.2);
    // Kinks are those of the signals, the next of both torques.
    let joint = driven(LOAD, time, Function::new(|_| (0.0, 0.0), [0.5, 2.0]));
    assert_eq!(joint.next_kink(0.0, 9.0), Some(0.5));
    assert_eq!(joint.next_kink(0.5, 9.0), Some(1.0));
    assert_eq!(joint.next_kink(2.0, 9.0), None);
}

#[test]
fn a_law_of_ones_own_and_a_number_load_a_gear() {
    #[derive(Debug, Clone)]
    struct Upright;
    impl LoadLaw<f64> for Upright {
        fn load(&self, torques: GearTorques<f64>) -> f64 {
            torques.motor - 1.0
        }
    }
    let torques = GearTorques { motor: 3.0, external: 7.0 };
    let number = of_load(2.5);
    assert_eq!(GearFriction::new(number).unwrap().load(torques), 2.5);
    // A load that is negative is refused, at once or when it comes.
    assert_eq!(GearFriction::new(of_load(Upright)).unwrap_err().name, "load");
}

fn of_load<L>(load: L) -> GearFrictionParameters<f64, Friction, L> {
    let friction = friction();
    GearFrictionParameters { friction, load, reference_load: 2.0, drag: 0.0, fastest: 1.0 }
}

#[test]
fn bad_input_of_a_joint_is_named() {
    let bad = [f64::NAN, -1.0, f64::INFINITY];
    let loaded = of_load(2.0);
    let (gear, largest_current) = (gear_of(LOAD), None);
    let geared = GearedJointParameters { gear, inertia: 1.0, motor: 0.0, external: 0.0 };
    let current = CurrentMotorParameters { current: 1.0, torque_constant: 1.0, largest_current };
    let voltage = VoltageMotorParameters {
        voltage: 1.0,
        torque_constant: 1.0,
        resistance: 1.0,
        largest_voltage: None,
        largest_current: None,
    };
    assert_fields_refuse!(bad, TorqueLoad::new, LOAD; idle_load motor_share external_share);
    assert_fields_refuse!(bad, GearFriction::new, loaded; reference_load load drag fastest);
    assert_fields_refuse!(bad, GearedJoint::new, geared; inertia);
    assert_fields_refuse!([f64::NAN, f64::INFINITY], GearedJoint::new, geared; motor external);
    assert_fields_refuse!(bad, CurrentMotor::new, current; torque_constant);
    assert_fields_refuse!(bad, VoltageMotor::new, voltage; torque_constant resistance);
    for bad in bad {
        let limited = VoltageMotorParameters { largest_voltage: Some(bad), ..voltage };
        assert_refused(VoltageMotor::new(limited), "largest_voltage", bad);
        let limited = VoltageMotorParameters { largest_current: Some(bad), ..voltage };
        assert_refused(VoltageMotor::new(limited), "largest_current", bad);
        let mut gear = gear;
        assert_refused(gear.set_friction_scale(bad), "friction_scale", bad);
        assert_refused(gear.set_drag_scale(bad), "drag_scale", bad);
        assert_eq!((gear.friction_scale(), gear.drag()), (1.0, 0.05));
    }
    for bad in [f64::NAN, f64::INFINITY] {
        let torques = GearTorques { motor: bad, external: 0.0 };
        assert_refused(gear.step(torques, 0.0, LoadedDeflection::none(), 1e-3), "load", bad);
    }
    // A step backwards is none.
    let joint = joint(motor());
    assert!(joint.step(&JointState::at_rest(0.3), -1e-3).unwrap().0.angle.is_nan());
}

#[test]
fn a_load_that_vanishes_is_passed() {
    let joint_of = |idle_load| driven(TorqueLoadParameters { idle_load, ..LOAD }, motor(), GRAVITY);
    let by_steps =
        |idle_load| stepped(&joint_of(idle_load), JointState::at_rest(0.3), 8000, 5e-4).angle;
    for idle_load in [1e-1, 1e-3, 1e-6, 0.0] {
        let joint = joint_of(idle_load);
        // Where little is left the Jacobian has a peak, and the estimated error of the solution
        // with it: steps of a tolerance of their own.
        let tolerances = Tolerances::scaled(1e-7, joint.scales()).unwrap();
        let solver = Solver::adaptive(Automatic, tolerances);
        let run = solver.solve(&joint, 0.0..4.0, joint.at_rest(0.3), Output::Uniform(2)).unwrap();
        // The error of the steps, which are of second order: 8000 and 16 000 of them differ by
        // 1e-4 rad.
        let want = run.states()[1][0];
        assert_within(5e-4, 1.0, by_steps(idle_load), want, || format!("p0 = {idle_load}"));
        assert!(run.statistics().steps < 2000, "{}", run.statistics());
    }
}

#[test]
fn steps_do_not_pass_over_what_a_reference_does() {
    // A motor of 6 N m at its limit holds a joint that is stuck under 50 to 200 N m; it lets go for
    // a moment in each half period of the reference.
    let reference = SineParameters { mean: 0.5, amplitude: 0.5, frequency: 0.5, phase: 0.0 };
    for idle_load in [50.0, 100.0, 200.0] {
        let control = PositionControl {
            reference: Sine::new(reference).unwrap(),
            proportional_gain: 400.0,
            derivative_gain: 4.0,
        };
        let motor = CurrentMotorParameters {
            current: control,
            torque_constant: 1.0,
            largest_current: Some(6.0),
        };
        let load = TorqueLoadParameters { idle_load, ..LOAD };
        let joint = driven(load, CurrentMotor::new(motor).unwrap(), 0.0);
        assert_eq!(joint.longest_step(), Some(0.25));
        let start = joint.at_rest(0.0);
        let scales = joint.scales();
        let fine = Solver::automatic(1e-9, scales).unwrap().with_largest_step(5e-3).unwrap();
        let times = Output::Uniform(33);
        let want = fine.solve(&joint, 0.0..8.0, start, times).unwrap();
        for tolerance in [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8] {
            let run = ode::solve(&joint, 0.0..8.0, start, tolerance, times).unwrap();
            for (got, want) in run.states().iter().zip(want.states()) {
                let off = (got - want).component_div(&scales).abs().max() / tolerance;
                assert!(off < 1000.0, "{idle_load} N m at {tolerance:e}: {off} tolerances");
            }
        }
    }
}

#[test]
fn the_audit_is_of_the_direction_of_the_motion() {
    let curve = |static_coefficient| {
        let plain = friction().curve().parameters();
        Stribeck::new(StribeckParameters { static_coefficient, ..plain }).unwrap()
    };
    let gear = GearFriction::new(GearFrictionParameters {
        friction: FrBd::new(
            Asymmetric { forward: curve(0.15), backward: curve(0.25) },
            *friction().rheology(),
        ),
        load: TorqueLoad::new(LOAD).unwrap(),
        reference_load: 2.0,
        drag: 0.05,
        fastest: 5.0,
    })
    .unwrap();
    for (velocity, want) in [(1.0, 0.15), (-1.0, 0.25)] {
        let audit = gear.audit(velocity, 5.0).unwrap();
        // The curve at rest: a sum and a difference of its coefficients.
        assert_within(1e-14, 1.0, audit.static_coefficient, want, || format!("{velocity}"));
    }
}

#[test]
fn a_tip_sticks_where_the_switching_function_is_negative() {
    // Under 2.9 N m: 2 and 0.3 by the motor, 0.6 times 1 by the load.
    let joint = GearedJoint::new(GearedJointParameters {
        gear: GearFriction::new(GearFrictionParameters {
            friction: TABLE_2.model(),
            load: TorqueLoad::new(LOAD).unwrap(),
            reference_load: REFERENCE,
            drag: 0.05,
            fastest: 5.0,
        })
        .unwrap(),
        inertia: 0.02,
        motor: 0.3,
        external: -1.0,
    })
    .unwrap();
    let mut both = [0, 0];
    for i in 0..=60 {
        let state = Vector3::new(0.1, 1e-3, 1e-5 * f64::from(i));
        let mut excess = f64::NAN;
        joint.switching_functions(0.0, &state, [Branch::Forward], &mut |told| excess = told);
        let sticks = joint.rate(0.0, &state, [Branch::Forward])[2] == 1e-3;
        assert_eq!(excess < 0.0, sticks, "{i}: {excess}");
        both[usize::from(sticks)] += 1;
    }
    assert!(both[0] > 5 && both[1] > 5, "{both:?}");
}
