//! Parameters of other tools against those tools' own equations.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test panics to fail")]

use bristle::companion::{PointMass, VelocityHistory};
use bristle::curve::FrictionCurve;
use bristle::ode::{self, Output};
use bristle::rheology::MaxwellParameters;
use bristle::scene::{MassSpringDamper, MassSpringDamperParameters};
use bristle::{Bristle, Contact, Dahl, DahlParameters, FrBd, LuGre, Mechanism, Scalar};
use bristle_analysis::audit::{AuditParameters, audit};
use bristle_convert::{
    DrakeFriction, LossyGear, MujocoDcMotor, MujocoFriction, Presliding, SimscapeFriction,
};
use bristle_joint::{GearFriction, GearFrictionParameters, TorqueLoad, TorqueLoadParameters};
use bristle_specimens::recipe::Recipe;
use bristle_specimens::specimens::coulomb;
use bristle_specimens::{assert_fields_refuse, assert_refused, assert_within, check, lit};

/// Numbers that no positive parameter may be.
const BAD: [f64; 7] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -1.0, 1e-320, 1e300];

/// A block of Simscape with its default values but for the viscous part.
fn simscape<T: Scalar>(viscous_coefficient: T) -> SimscapeFriction<T> {
    let [breakaway_friction, coulomb_friction, breakaway_velocity] = [25.0, 20.0, 0.1].map(lit);
    SimscapeFriction {
        breakaway_friction,
        coulomb_friction,
        breakaway_velocity,
        viscous_coefficient,
    }
}

/// A row of Modelica's loss tables without friction at no load.
fn row<T: Scalar>(there: f64, back: f64, ratio: f64) -> LossyGear<T> {
    LossyGear {
        driving_efficiency: lit(there),
        back_driving_efficiency: lit(back),
        driving_friction: T::zero(),
        back_driving_friction: T::zero(),
        ratio: lit(ratio),
    }
}

/// A constraint of MuJoCo.
fn mujoco(friction_loss: f64, inertia: f64, time: f64, solimp: [f64; 2]) -> MujocoFriction<f64> {
    MujocoFriction { friction_loss, damping: 0.0, inertia, solref: [time, 1.0], solimp }
}

#[test]
fn the_simscape_curve_follows_the_block_from_its_breakaway_velocity_on() {
    let ranges = (0.1..1e3, 0.0..3.0, 1e-4..10.0, 0.0..1.0);
    check(200, ranges, |(coulomb, excess, breakaway_velocity, viscous)| {
        let peak = coulomb * (1.0 + excess);
        let block = SimscapeFriction {
            breakaway_friction: peak,
            coulomb_friction: coulomb,
            breakaway_velocity,
            viscous_coefficient: viscous,
        };
        let curve = block.curve().unwrap();
        assert_within(1e-15, 2.0 * peak, curve.at(0.0), peak, || "rest".into());
        // The documentation's equation.
        let (stribeck, coul) = (breakaway_velocity * 2.0_f64.sqrt(), breakaway_velocity / 10.0);
        let torque = |w: f64| {
            let u = w / stribeck;
            let fall = (2.0 * std::f64::consts::E).sqrt() * (peak - coulomb) * (-u * u).exp() * u;
            fall + coulomb * (w / coul).tanh() + viscous * w
        };
        for i in 0..400 {
            let w = breakaway_velocity * (1.0 + 0.02 * f64::from(i));
            // The fit's error; tanh(10) is 1 − 4e-9.
            let allowed = 0.045 * (peak - coulomb) + 1e-8 * coulomb;
            assert_within(1.0, allowed, curve.at(w), torque(w), || format!("{block:?} at {w}"));
        }
    });
}

#[test]
fn conversions_work_in_single_precision() {
    let row = LossyGear {
        driving_friction: 0.1,
        back_driving_friction: 0.1,
        ..row::<f32>(0.8, 0.75, 50.0)
    };
    // 1 − 2 · 0.8 + 0.8 · 0.75 is zero but for roundings.
    assert_eq!(row.losses().unwrap().load.parameters().motor_share, 0.0);
    assert_eq!(simscape(0.0_f32).curve().unwrap().at(1.0), 20.0);
}

#[test]
fn the_drake_curve_follows_its_continuous_model_from_the_stiction_tolerance_on() {
    check(200, (0.01..2.0, 0.0..1.0, 1e-5..1e-2), |(dynamic, excess, tolerance)| {
        let pair = DrakeFriction {
            static_friction: dynamic * (1.0 + excess),
            dynamic_friction: dynamic,
            stiction_tolerance: tolerance,
        };
        let (curve, drop) = (pair.curve().unwrap(), dynamic * excess);
        let rest = pair.static_friction;
        assert_within(1e-15, 2.0 * rest, curve.at(0.0), rest, || "rest".into());
        for i in 0..=400 {
            let x = 1.0 + 0.01 * f64::from(i);
            let s = (0.5 * (x - 1.0)).min(1.0);
            let step = s * s * s * (10.0 + s * (6.0 * s - 15.0));
            let want = pair.static_friction - drop * step;
            // The fit's error, and roundings.
            let allowed = 0.0245 * drop + 1e-14;
            assert_within(1.0, allowed, curve.at(x * tolerance), want, || format!("{pair:?}, {x}"));
        }
        // A surface against itself; the harmonic mean lies below the arithmetic one.
        let itself = pair.against(pair);
        assert_within(1e-15, dynamic, itself.dynamic_friction, dynamic, || "itself".into());
        let other = DrakeFriction { dynamic_friction: 3.0 * dynamic, ..pair };
        let both = pair.against(other).dynamic_friction;
        assert_within(1e-14, dynamic, both, 1.5 * dynamic, || "2·3/(1 + 3)".into());
    });
}

#[test]
fn a_mujoco_bristle_creeps_as_the_constraint_does() {
    let ranges = (0.1..100.0, 1e-3..10.0, 0.002..0.1, 0.1..0.99, 0.5..0.999);
    check(200, ranges, |(friction_loss, inertia, time, least, most)| {
        let joint = mujoco(friction_loss, inertia, time, [least, most]);
        let bristle = joint.bristle().unwrap();
        let contact = FrBd::new(joint.curve().unwrap(), bristle).under_load(1.0).unwrap();
        for share in [1e-4, 0.1, 0.5] {
            // a₁ + d b v = (1 − d) a₀ with a₁ = 0 and a₀ = share f/M.
            let b = 2.0 / (most * time);
            let creep = (1.0 - least) / (least * b) * share * friction_loss / inertia;
            // v = (F/c) f/(f − F), which at half of f is twice the velocity.
            let force = contact.stationary_force(creep / (1.0 - share));
            let want = share * friction_loss;
            assert_within(1e-12, friction_loss, force, want, || format!("{joint:?}, {share}"));
        }
        // The stuck body on its spring: s² + (k/c) s + k/M has a double root.
        let MaxwellParameters { micro_stiffness: k, series_damping: c } = bristle.parameters();
        assert_within(1e-12, (k / c).powi(2), (k / c).powi(2), 4.0 * k / inertia, || "root".into());
        // The direct form: b = damping/dmax.
        let direct = MujocoFriction { solref: [-1e4, -2.0 / time], ..joint };
        let damping = direct.creep_damping().unwrap();
        assert_within(1e-12, c, damping, c, || "direct form".into());
    });
    // A rigid constraint is clamped, as in MuJoCo.
    let joint = mujoco(1.0, 1.0, 0.02, [1.0, 1.0]);
    let want = 0.9999 * (2.0 / (0.9999 * 0.02)) / 1e-4;
    assert_within(1e-9, want, joint.creep_damping().unwrap(), want, || "clamped".into());
}

/// A gear of a friction coefficient and its load law.
fn gear(
    coefficient: f64,
    load: TorqueLoad<f64>,
    drag: f64,
) -> GearFriction<f64, Dahl<f64>, TorqueLoad<f64>> {
    let friction = DahlParameters { dynamic_coefficient: coefficient, micro_stiffness: 300.0 };
    let friction = Dahl::new(friction).unwrap();
    let (reference_load, fastest) = (1.0, 5.0);
    let gear = GearFrictionParameters { friction, load, reference_load, drag, fastest };
    GearFriction::new(gear).unwrap()
}

#[test]
fn a_gear_and_its_loss_table_pass_the_torques_alike() {
    let ranges = (0.01..0.5, 0.0..1.0, 0.0..1.0, 0.0..5.0, 0.0..1.0, 0.5..200.0, 0.1..20.0);
    check(200, ranges, |(mu, motor_share, external_share, idle_load, drag, ratio, velocity)| {
        let load = TorqueLoadParameters { idle_load, motor_share, external_share };
        let there = gear(mu, TorqueLoad::new(load).unwrap(), drag);
        let row = LossyGear::of(&there, velocity, ratio).unwrap();
        let near = |got: f64, want: f64, what: &str| {
            assert_within(1e-12, 1.0 + want.abs(), got, want, || format!("{what}: {row:?}"));
        };
        for external in [0.5, 5.0, 500.0] {
            // Modelica: −τ_B = i (η_mf1 τ_A − τ_bf1), with τ_A on the side of the motor.
            let driving = there.driving_torque(velocity, external).unwrap() / ratio;
            near(ratio * (row.driving_efficiency * driving - row.driving_friction), external, "up");
            // −τ_B = i (τ_A/η_mf2 − τ_bf2), here with a braking torque τ_A < 0.
            if let Some(braking) = there.braking_torque(velocity, external) {
                let tau_a = -braking / ratio;
                let tau_b =
                    -ratio * (tau_a / row.back_driving_efficiency - row.back_driving_friction);
                near(tau_b, external, "down");
            }
        }
        // And back: the same products, with the drag in the idle load.
        let back = row.losses().unwrap();
        let law = back.load.parameters();
        near(back.coefficient * law.motor_share, mu * motor_share, "mu k_m");
        near(back.coefficient * law.external_share, mu * external_share, "mu k_e");
        near(back.coefficient * law.idle_load, mu * idle_load + drag * velocity, "mu p0");
        let larger = law.motor_share.max(law.external_share);
        assert!((larger - 1.0).abs() < 1e-12 || mu * motor_share.max(external_share) < 1e-12);
    });
}

#[test]
fn loss_tables_of_the_literature() {
    let row = |eta1, eta2, bf1, bf2| LossyGear {
        driving_friction: bf1,
        back_driving_friction: bf2,
        ..row(eta1, eta2, 2.0)
    };
    // Modelica's LossyGearDemo1 with a ratio of 2: η = 0.5 both ways, μ = (1 − η)/(1 + η).
    let demo = row(0.5, 0.5, 0.0, 0.0).losses().unwrap();
    assert_within(1e-15, 1.0, demo.coefficient, 1.0 / 3.0, || "demo 1".into());
    let law = demo.load.parameters();
    assert_eq!((law.idle_load, law.motor_share, law.external_share), (0.0, 1.0, 1.0));
    // Ideal teeth, friction in the bearings: constant, twice 0.3 N m at the joint.
    let ideal = row(1.0, 1.0, 0.3, 0.3).losses().unwrap();
    let law = ideal.load.parameters();
    assert_eq!((law.motor_share, law.external_share), (0.0, 0.0));
    assert_within(1e-15, 1.0, ideal.coefficient * law.idle_load, 0.6, || "ideal".into());
    // The rule of worm gears, η₂ = 2 − 1/η₁, is the end of the range: k_m = 0.
    let worm = row(0.8, 0.75, 0.0, 0.0).losses().unwrap();
    assert_eq!(worm.load.parameters().motor_share, 0.0);
    assert_within(1e-14, 1.0, worm.coefficient, 0.25, || "worm".into());
    // Beyond it no load of this law does it.
    let error = row(0.8, 0.7, 0.0, 0.0).losses().unwrap_err().to_string();
    let want = "driving_efficiency is 0.8, but must be at most 1/(2 - back_driving_efficiency) = ";
    assert!(error.starts_with(want), "{error}");
    assert_refused(row(0.7, 0.8, 0.0, 0.0).losses(), "back_driving_efficiency", 0.8);
    assert_refused(row(0.5, 1.01, 0.0, 0.0).losses(), "back_driving_efficiency", 1.01);
    for bad in BAD {
        assert_refused(row(bad, 0.5, 0.0, 0.0).losses(), "driving_efficiency", bad);
        assert_refused(row(0.5, bad, 0.0, 0.0).losses(), "back_driving_efficiency", bad);
        assert_refused(LossyGear { ratio: bad, ..row(0.5, 0.5, 0.0, 0.0) }.losses(), "ratio", bad);
    }
    assert_refused(row(0.5, 0.5, -1.0, 0.0).losses(), "driving_friction", -1.0);
    assert_refused(row(0.5, 0.5, 0.0, f64::NAN).losses(), "back_driving_friction", f64::NAN);
    // A gear that locks itself has no row.
    let load = TorqueLoadParameters { idle_load: 1.0, motor_share: 0.1, external_share: 1.0 };
    let locks = gear(1.5, TorqueLoad::new(load).unwrap(), 0.0);
    assert_refused(LossyGear::of(&locks, 1.0, 1.0), "mu k_e", 1.5);
    assert_refused(LossyGear::of(&locks, 0.0, 1.0), "velocity", 0.0);
}

#[test]
fn a_presliding_bristle_gives_the_stuck_mass_its_damping() {
    check(50, (0.05..2.0, 1e-6..1e-3, 0.1..1e3, 0.01..100.0, 0.0..2.0), |parameters| {
        let (static_coefficient, travel, normal_force, mass, damping_ratio) = parameters;
        let dry = Presliding { static_coefficient, travel, normal_force, mass, damping_ratio };
        let bristle = dry.bristle().unwrap();
        assert_eq!(bristle.parameters().micro_stiffness, static_coefficient / travel);
        let curve =
            coulomb(&Recipe { dynamic: static_coefficient, viscous: 0.0, ..Recipe::TABLE_2 });
        let contact = FrBd::new::<f64>(curve, bristle).under_load(normal_force).unwrap();
        let mechanism = Mechanism { mass, spring_stiffness: 0.0, viscous_damping: 0.0 };
        let up_to = AuditParameters::up_to(1.0);
        let parameters = AuditParameters { mechanism: Some(mechanism), ..up_to };
        let stuck = audit(&contact, parameters).unwrap().stuck.unwrap();
        assert_within(1e-9, 1.0, stuck.damping_ratio, damping_ratio, || format!("{dry:?}"));
    });
}

#[test]
fn bad_parameters_are_refused_by_the_name_they_have_in_the_tool() {
    let block = simscape(0.001);
    let pair =
        DrakeFriction { static_friction: 0.8, dynamic_friction: 0.6, stiction_tolerance: 1e-3 };
    let joint = mujoco(0.5, 0.01, 0.02, [0.9, 0.95]);
    let dry = Presliding {
        static_coefficient: 0.2,
        travel: 1e-5,
        normal_force: 50.0,
        mass: 2.0,
        damping_ratio: 0.5,
    };
    type Drake = DrakeFriction<f64>;
    type Mujoco = MujocoFriction<f64>;
    assert_fields_refuse!(BAD, |of: SimscapeFriction<f64>| of.curve(), block;
        coulomb_friction breakaway_friction breakaway_velocity);
    assert_fields_refuse!(BAD, |of: Drake| of.curve(), pair;
        static_friction dynamic_friction stiction_tolerance);
    assert_fields_refuse!(BAD, |of: Mujoco| of.curve(), joint; friction_loss);
    assert_fields_refuse!(BAD, |of: Mujoco| of.bristle(), joint; inertia);
    assert_fields_refuse!(BAD, |of: Presliding<f64>| of.bristle(), dry;
        static_coefficient travel normal_force mass);
    let may_be_zero = BAD.into_iter().filter(|bad| ![0.0, 1e-320].contains(bad));
    let negative = || may_be_zero.clone();
    assert_fields_refuse!(negative(), |of: SimscapeFriction<f64>| of.curve(), block;
        viscous_coefficient);
    assert_fields_refuse!(negative(), |of: Mujoco| of.curve(), joint; damping);
    assert_fields_refuse!(negative(), |of: Presliding<f64>| of.bristle(), dry; damping_ratio);
    for bad in BAD {
        assert_refused(Mujoco { solref: [bad, 1.0], ..joint }.bristle(), "solref", bad);
    }
    for bad in negative() {
        assert_refused(Mujoco { solimp: [bad, 0.95], ..joint }.bristle(), "solimp", bad);
    }
    let low = SimscapeFriction { breakaway_friction: 19.0, ..block }.curve().unwrap_err();
    let want = "breakaway_friction is 19, but must be at least coulomb_friction = 20";
    assert_eq!(low.to_string(), want);
    assert_refused(DrakeFriction { static_friction: 0.5, ..pair }.curve(), "static_friction", 0.5);
    // A damping of zero in the direct form brakes nothing.
    assert_refused(MujocoFriction { solref: [-1.0, 0.0], ..joint }.bristle(), "creep_damping", 0.0);
    assert_refused(
        MujocoFriction { solref: [-1.0, f64::NAN], ..joint }.bristle(),
        "solref",
        f64::NAN,
    );
}

#[cfg(feature = "alloc")]
#[test]
fn a_bearing_table_is_met_at_its_rows_and_falls_from_its_peak() {
    use bristle_convert::bearing_friction;

    let rows = [[0.0, 2.0], [1.0, 1.5], [10.0, 2.5], [100.0, 6.0]];
    let curve = bearing_friction(&rows, 1.25, 0.01).unwrap();
    assert_eq!(curve.at(0.0), 2.5);
    for [speed, torque] in &rows[1..] {
        assert_eq!(curve.at(*speed), *torque);
    }
    // Where the fall ends it is on the table's straight line.
    assert_within(1e-15, 2.0, curve.at(0.01), 2.0 - 0.5 * 0.01, || "landing".into());
    // Between rows it is Modelica's straight line, but for the corners, and goes on beyond the
    // last.
    for n in 1..2000 {
        let speed = 0.01 + 0.1 * f64::from(n);
        let place = rows.iter().rposition(|row| row[0] <= speed).unwrap().min(2);
        let [[s0, t0], [s1, t1]] = [rows[place], rows[place + 1]];
        let line = t0 + (t1 - t0) * (speed - s0) / (s1 - s0);
        let corner = (speed - s0).min((s1 - speed).abs()) < (s1 - s0) / 256.0;
        let most = if corner { 1.2e-3 * (t1 - t0).abs() } else { 1e-13 };
        assert_within(most, 1.0, curve.at(speed), line, || format!("at {speed}"));
    }
    // Rows as close as two numbers can be.
    let close = f32::from_bits(1.0_f32.to_bits() + 1);
    assert!(bearing_friction(&[[0.0_f32, 2.0], [1.0, 1.5], [close, 1.5]], 1.25, 0.01).is_ok());
    // One row: constant beyond the fall.
    let one = bearing_friction(&[[0.0, 2.0]], 1.5, 0.1).unwrap();
    assert_eq!((one.at(0.0), one.at(0.1), one.at(1e3)), (3.0, 2.0, 2.0));
    let level = bearing_friction(&[[0.0, 2.0]], 1.0, 0.1).unwrap();
    assert_eq!((level.at(0.0), level.at(0.05)), (2.0, 2.0));

    let refuse = |rows: &[[f64; 2]], peak, fall, name: &str, value| {
        assert_refused(bearing_friction(rows, peak, fall), name, value);
    };
    refuse(&[], 1.0, 0.1, "rows of tau_pos", 0.0);
    refuse(&[[0.1, 2.0]], 1.0, 0.1, "speed", 0.1);
    refuse(&[[0.0, 2.0], [0.0, 1.0]], 1.0, 0.1, "speed", 0.0);
    for bad in BAD {
        refuse(&[[0.0, 2.0], [1.0, bad]], 1.0, 0.1, "torque", bad);
        refuse(&rows, 1.0, bad, "fall_speed", bad);
        if bad != 0.0 && bad != 1e-320 {
            refuse(&[[0.0, 2.0], [bad, 1.0]], 1.0, 0.1, "speed", bad);
        }
        refuse(&rows, bad, 0.1, "peak", bad);
    }
    refuse(&rows, 0.99, 0.1, "peak", 0.99);
    refuse(&rows, 1.0, 1.0, "fall_speed", 1.0);
    let error = bearing_friction(&[[0.0, 2.0], [1.0, -1.0]], 1.0, 0.1).unwrap_err().to_string();
    assert!(error.starts_with("torque[1] is -1, but must lie between"), "{error}");
}

/// The joint of benches/mujoco/creep.py: 0.01 kg m², σ1 = √(J σ0).
fn motor(stiffness: f64) -> MujocoDcMotor<f64> {
    MujocoDcMotor {
        stiffness,
        damping: (0.01 * stiffness).sqrt(),
        coulomb_friction: 1.0,
        static_friction: 1.5,
        stribeck_velocity: 0.1,
        viscous_damping: 0.0,
    }
}

#[test]
fn a_dc_motor_slides_as_mujoco_does_and_comes_back() {
    // `stationary torque` of MuJoCo 4.0.0 at velocities held over 0.2 s.
    let motor = MujocoDcMotor { viscous_damping: 0.3, ..motor(1e4) };
    let (curve, bristle) = (motor.curve().unwrap(), motor.bristle().unwrap());
    let friction = LuGre::classical(curve, bristle).under_load(1.0).unwrap();
    for (v, torque) in [
        (0.02, 1.480_394_719_573_8 + 0.006),
        (0.05, 1.389_400_391_535_7 + 0.015),
        (0.1, 1.183_939_720_585_7 + 0.03),
        (0.2, 1.009_157_819_444_4 + 0.06),
    ] {
        // It had not quite settled.
        assert!((friction.stationary_force(v) - torque).abs() < 1e-11, "{v}");
    }
    assert_eq!(MujocoDcMotor::of(&curve, &bristle, 1.0), Ok(motor));
    assert_eq!(motor.lugre(), [1e4, 10.0, 1.0, 1.5, 0.1]);
    let loaded = MujocoDcMotor::of(&curve, &bristle, 4.0).unwrap();
    assert_eq!((loaded.static_friction, loaded.viscous_damping), (6.0, 1.2));
    let other = simscape(0.0).curve().unwrap();
    assert_refused(MujocoDcMotor::of(&other, &bristle, 1.0), "stribeck_exponent", 4.285);
    assert_refused(MujocoDcMotor::of(&curve, &bristle, 0.0), "load", 0.0);
    type Motor = MujocoDcMotor<f64>;
    assert_fields_refuse!(BAD, |of: Motor| of.bristle(), motor; stiffness);
    assert_fields_refuse!(BAD, |of: Motor| of.curve(), motor;
        coulomb_friction static_friction stribeck_velocity);
    assert_fields_refuse!([f64::NAN, -1.0], |of: Motor| of.bristle(), motor; damping);
    assert_fields_refuse!([f64::NAN, -1.0], |of: Motor| of.curve(), motor; viscous_damping);
}

/// Position after 1 s and 2 s and the bristle at the end, in passive steps of 2 ms under 0.5 N m.
fn held<M: Bristle<f64, Deflection = f64>>(contact: Contact<f64, M>) -> ([f64; 2], f64) {
    let joint = contact.companion(0.1).unwrap();
    let (mut x, mut v, mut z, h) = (0.0, 0.0, 0.0, 2e-3);
    let (mut history, mut places) = (VelocityHistory::new(v), [0.0; 2]);
    for n in 1..=1000 {
        let step = joint.step(history.predict(), z, h);
        let mass = PointMass { mass: 0.01, velocity: v, force: 0.5, end_weight: 1.0 };
        v = step.point_mass(mass);
        z = step.commit(v).deflection;
        x += h * v;
        history.push(v);
        if n % 500 == 0 {
            places[n / 500 - 1] = x;
        }
    }
    (places, z)
}

#[test]
fn a_dc_motor_under_a_third_of_its_breakaway_stands_at_every_stiffness() {
    for stiffness in [1e4, 1e5, 1e6] {
        let (curve, bristle) =
            (motor(stiffness).curve().unwrap(), motor(stiffness).bristle().unwrap());
        let frbd = FrBd::new(curve, bristle).under_load(1.0).unwrap();
        let lugre = LuGre::classical(curve, bristle).under_load(1.0).unwrap();
        let block = MassSpringDamper::new(MassSpringDamperParameters {
            contact: frbd,
            mechanism: Mechanism { mass: 0.01, spring_stiffness: 0.0, viscous_damping: 0.0 },
            drive_velocity: 0.0,
            force: 0.5,
        })
        .unwrap();
        let run = ode::solve(&block, 0.0..2.0, block.at_rest(), 1e-8, Output::Uniform(3)).unwrap();
        let [_, half, end] = run.states()[..] else { panic!("three outputs") };
        for (([half, end], z), what) in [
            (held(frbd), "FrBD, passive steps"),
            (held(lugre), "LuGre, the same steps"),
            (([half[0], end[0]], end[2]), "FrBD, solved"),
        ] {
            // Of F/σ0 itself, once it has swung in; the solver to its tolerance.
            let want = 0.5 / stiffness;
            assert!((z - want).abs() < 1e-7 * want, "{what}: {z:e} is not {want:e}");
            assert!((end - half).abs() < 1e-6 * want, "{what}: {half:e}, {end:e}");
            // While it swung in the bristle has slipped.
            assert!(end > want && end < 4.0 * want, "{what}: {end:e} is not {want:e}");
        }
    }
}
