//! A braked wheel from rolling to rest: energy, order of accuracy, an independent integrator,
//! lock-up, standstill.

use std::f64::consts::PI;

use crate::tyre::{constant, coulomb, exponential, parabolic};
use bristle::curve::{Coulomb, Stribeck};
use bristle::rheology::KelvinVoigt;
use bristle::{Bristle, FrBd, Rule, Scalar, Surface};
use bristle_plane::PlaneFrBd;
use bristle_rolling::{
    BrakedWheel, BrakedWheelParameters, CombinedPatch, ExactPatch, Motion, Patch, PatchParameters,
    PolynomialExponential, Pressure, Segment, Tyre, WheelLoads, WheelState,
};
use bristle_specimens::recipe::decades;
use bristle_specimens::specimens::kelvin_voigt;
use bristle_specimens::{assert_fields_refuse, assert_within, check, lit};
use proptest::collection::vec;
use proptest::prelude::*;

type Friction<T> = crate::tyre::Tyre<T>;
type Brake<T> = FrBd<Coulomb<T>, KelvinVoigt<T>>;
type Rolling<T, const N: usize> = ExactPatch<T, Friction<T>, N, Vec<Segment<T, N>>>;
type Wheel<T, const N: usize> = BrakedWheel<T, Rolling<T, N>, Brake<T>>;
const MASS: f64 = 400.0;
const INERTIA: f64 = 1.0;
const RADIUS: f64 = 0.3;
const LENGTH: f64 = 0.12;
/// Reference load of the brake [N].
const REFERENCE: f64 = 1500.0;
const LOAD: f64 = 4000.0;

fn tyre<T: Scalar>() -> Friction<T> {
    let bristle = kelvin_voigt(lit(200.0), lit(0.5));
    FrBd::new(crate::combined::curve([0.75, 1.1 / 0.75, 6.0]), bristle)
}

/// Torque per normal force: 1 N m per N, reached after 1/50 rad.
fn pads<T: Scalar>() -> Brake<T> {
    FrBd::new(*coulomb(1.0, 0.0).curve(), kelvin_voigt(lit(50.0), lit(0.1)))
}

fn patch<T: Scalar, M, const N: usize>(
    model: M,
    pressure: PolynomialExponential<T, N>,
) -> Patch<T, M, PolynomialExponential<T, N>> {
    let patch = Patch::new(PatchParameters { model, length: lit(LENGTH), pressure });
    patch.unwrap().under_load(lit(LOAD)).unwrap()
}

fn parameters<T: Scalar, const N: usize>(
    pressure: PolynomialExponential<T, N>,
    speed: f64,
) -> BrakedWheelParameters<T, Rolling<T, N>, Brake<T>> {
    BrakedWheelParameters {
        tyre: patch(tyre(), pressure).exact_in(1000).unwrap(),
        brake: pads::<T>().under_load(lit(0.0)).unwrap().measured_at(lit(REFERENCE)).unwrap(),
        mass: lit(MASS),
        inertia: lit(INERTIA),
        radius: lit(RADIUS),
        speed: lit(speed),
        angular_velocity: lit(speed / RADIUS),
    }
}

fn wheel<T: Scalar, const N: usize>(
    pressure: PolynomialExponential<T, N>,
    speed: f64,
) -> Wheel<T, N> {
    BrakedWheel::new(parameters(pressure, speed)).unwrap()
}

/// Runs to a time in equal steps under a brake's normal force over time.
fn run<const N: usize>(
    wheel: &mut Wheel<f64, N>,
    end: f64,
    steps: u32,
    brake: impl Fn(f64) -> f64,
    mut watch: impl FnMut(&Wheel<f64, N>, WheelState<f64>),
) {
    let h = end / f64::from(steps);
    for _ in 0..steps {
        let middle = wheel.state().time + 0.5 * h;
        let step = wheel.step(WheelLoads::braking(brake(middle)), h).unwrap();
        watch(wheel, step);
    }
}

/// Beyond what the tyre carries: it locks the wheel.
fn hard(t: f64) -> f64 {
    (3000.0 * t).min(2500.0)
}

/// Below that, and as smooth as can be.
fn soft(t: f64) -> f64 {
    900.0 * (1.0 - (-t * t / 0.02).exp())
}

type Steered<T, const N: usize> = BrakedWheel<
    T,
    CombinedPatch<T, PlaneFrBd<Stribeck<T>, T, 2>, 2, N, Vec<Segment<T, N>>>,
    Brake<T>,
>;

/// The wheel with bristles of two axes.
fn steered<T: Scalar, const N: usize>(
    pressure: PolynomialExponential<T, N>,
    speed: f64,
) -> Steered<T, N> {
    let BrakedWheelParameters { tyre, brake, mass, inertia, radius, speed, angular_velocity } =
        parameters(pressure, speed);
    let line = tyre.patch();
    let model = PlaneFrBd::isotropic(*line.model().curve(), *line.model().rheology());
    let tyre = patch(model, pressure).exact_in(1000).unwrap();
    let all = BrakedWheelParameters { tyre, brake, mass, inertia, radius, speed, angular_velocity };
    BrakedWheel::new(all).unwrap()
}

/// Brake's normal force, drive torque, force, slip angle and duration of a step.
fn pulls() -> impl Strategy<Value = Vec<[f64; 5]>> {
    let pull = (0.0..3000.0, -300.0..600.0, -2000.0..2000.0, -0.3..0.3, decades(1e-6, 1.0));
    vec(pull.prop_map(|(brake, torque, force, angle, h)| [brake, torque, force, angle, h]), 1..60)
}

fn energy_balances<T: Scalar, P: Tyre<T>>(
    mut wheel: BrakedWheel<T, P, Brake<T>>,
    steers: bool,
    pulls: &[[f64; 5]],
    rounding: f64,
) {
    let f = |value: T| -> f64 { value.to_subset_unchecked() };
    for pull in pulls {
        let [brake_force, torque, force, angle, h] = *pull;
        let across = if steers { f(wheel.state().speed) * angle.tan() } else { 0.0 };
        let loads = WheelLoads {
            brake_normal_force: lit(brake_force),
            drive_torque: lit(torque),
            force: lit(force),
            lateral_velocity: lit(across),
        };
        let energies = |wheel: &BrakedWheel<T, P, Brake<T>>| {
            let brake = wheel.brake().stored_energy(wheel.state().brake_deflection);
            [wheel.kinetic_energy(), wheel.tyre().stored_energy(), brake].map(f)
        };
        let (from, before) = (wheel.state(), energies(&wheel));
        let to = match wheel.step(loads, lit(h)) {
            Ok(state) => state,
            Err(error) if error.name == "rolled_back" => return,
            Err(other) => panic!("{other} at {pull:?}"),
        };
        let after = energies(&wheel);
        let mean = |a: T, b: T| 0.5 * (f(a) + f(b));
        let speed = mean(from.speed, to.speed);
        let spin = mean(from.angular_velocity, to.angular_velocity);
        let work = h * (force * speed + torque * spin);
        let along = h * f(to.force) * (speed - RADIUS * spin);
        let steering = h * f(to.lateral_force) * across;
        let brake = h * f(to.brake_torque) * spin;
        let size = before.iter().chain(&after).sum::<f64>()
            + [work, along, steering, brake].map(f64::abs).iter().sum::<f64>();
        // What is given is kinetic or goes into tyre and brake.
        let kinetic = after[0] - before[0];
        assert_within(rounding, size, kinetic, work - along - brake, || format!("{pull:?}"));
        // The pressures given here do not rise: tyre and brake lose what they do not store.
        for lost in [along + steering - (after[1] - before[1]), brake - (after[2] - before[2])] {
            assert!(lost >= -rounding * size, "{lost:e} of {size:e} at {pull:?}");
        }
    }
}

#[test]
fn no_step_of_any_length_makes_energy() {
    // A few hundred roundings, in the moments and in what is stored.
    check(60, pulls(), |pulls| {
        energy_balances(wheel::<f64, 1>(constant(), 15.0), false, &pulls, 1e-12);
        energy_balances(wheel::<f32, 1>(constant(), 15.0), false, &pulls, 2e-4);
        energy_balances(wheel::<f64, 1>(exponential(0.7), 15.0), false, &pulls, 1e-12);
        energy_balances(wheel::<f32, 1>(exponential(0.7), 15.0), false, &pulls, 2e-4);
        energy_balances(steered::<f64, 1>(constant(), 15.0), true, &pulls, 1e-12);
    });
}

#[test]
fn a_free_wheel_rolls_on() {
    let mut wheel = wheel::<f64, 3>(parabolic(), 30.0);
    run(&mut wheel, 1.0, 100, |_| 0.0, |_, _| {});
    let WheelState { time, position, angle, speed, angular_velocity, .. } = wheel.state();
    for (got, want) in
        [(time, 1.0), (position, 30.0), (angle, 100.0), (speed, 30.0), (angular_velocity, 100.0)]
    {
        // 100 additions.
        assert_within(1e-13, want, got, want, || format!("{:?}", wheel.state()));
    }
    assert!(wheel.braking_slip().abs() < 1e-13);
}

/// Speed and angular velocity after the same manoeuvre by Runge and Kutta's method on bristles that
/// are followed one by one: a new one enters with every step. The bristle of the brake has the
/// stiffness of its reference load P, and the friction of its load p.
fn followed(end: f64, steps: u32) -> [f64; 2] {
    let h = end / f64::from(steps);
    let (model, brake, pressure) = (tyre::<f64>(), pads::<f64>(), parabolic::<f64>());
    // Speed, angular velocity and the bristle of the brake; then place and deflection of each
    // bristle, the newest last, the first at the outlet or beyond.
    let mut state = vec![30.0, 30.0 / RADIUS, 0.0];
    state.extend((0..=300).rev().flat_map(|n| [f64::from(n) / 300.0, 0.0]));
    let rates = |t: f64, state: &[f64]| -> Vec<f64> {
        let (body, bristles) = state.split_at(3);
        let [speed, spin, pads] = [body[0], body[1], body[2]];
        let v = speed - RADIUS * spin;
        let a = model.affine(v.into(), 0.0);
        // The trapezoidal rule, and the part of it that is inside at the outlet; the pressure
        // vanishes there.
        let inside = |i: usize| bristles[2 * i].min(1.0);
        let density =
            |i: usize| pressure.at(inside(i)) * (a.stiffness * bristles[2 * i + 1] + a.damping * v);
        let cell = |i: usize| 0.5 * (inside(i) - inside(i + 1)) * (density(i) + density(i + 1));
        let force = LOAD * (0..bristles.len() / 2 - 1).map(cell).sum::<f64>();
        let surface = Surface::scaled(spin, soft(t).max(1e-300) / REFERENCE);
        let b = brake.affine(surface, 0.0);
        let torque = REFERENCE * (b.stiffness * pads + b.damping * spin);
        let turning = (RADIUS * force - torque) / INERTIA;
        let mut rates = vec![-force / MASS, turning, b.drive * spin - b.relaxation * pads];
        rates.extend(
            bristles.chunks(2).flat_map(|bristle| {
                [RADIUS * spin / LENGTH, a.drive * v - a.relaxation * bristle[1]]
            }),
        );
        rates
    };
    let moved = |state: &[f64], by: f64, rates: &[f64]| -> Vec<f64> {
        state.iter().zip(rates).map(|(x, rate)| x + by * rate).collect()
    };
    for number in 0..steps {
        let t = f64::from(number) * h;
        let first = rates(t, &state);
        let second = rates(t + 0.5 * h, &moved(&state, 0.5 * h, &first));
        let third = rates(t + 0.5 * h, &moved(&state, 0.5 * h, &second));
        let fourth = rates(t + h, &moved(&state, h, &third));
        for (i, x) in state.iter_mut().enumerate() {
            *x += h / 6.0 * (first[i] + 2.0 * (second[i] + third[i]) + fourth[i]);
        }
        state.extend([0.0, 0.0]);
        let outside = state[3..].chunks(2).take_while(|bristle| bristle[0] >= 1.0).count();
        state.drain(3..3 + 2 * outside.saturating_sub(1));
    }
    [state[0], state[1]]
}

#[test]
fn bristles_followed_one_by_one_give_the_same_motion() {
    let mut wheel = wheel::<f64, 3>(parabolic(), 30.0);
    run(&mut wheel, 0.4, 4000, soft, |_, _| {});
    let got = [wheel.state().speed, wheel.state().angular_velocity];
    let [coarse, fine] = [4000, 8000].map(|steps| followed(0.4, steps));
    for i in 0..2 {
        // 40 and 80 bristles in the patch, by the trapezoidal rule: of second order, up to the cut
        // at the outlet.
        let want = fine[i] + (fine[i] - coarse[i]) / 3.0;
        assert_within(1e-6, want, got[i], want, || format!("speed {i}, {coarse:?} {fine:?}"));
    }
}

#[test]
fn a_locked_wheel_rests_on_the_bristles_of_its_brake() {
    for steps in [300, 3000] {
        let mut wheel = wheel::<f64, 3>(parabolic(), 30.0);
        let mut locked_at: Option<f64> = None;
        run(&mut wheel, 3.0, steps, hard, |wheel, step| {
            let WheelState { time, angle, angular_velocity, .. } = wheel.state();
            if time > 1.0 {
                // It has swung out.
                let from = *locked_at.get_or_insert(angle);
                // 2500 N m are 1/50 rad.
                assert!((angle - from).abs() < 0.02, "turned by {} rad", angle - from);
                assert!(angular_velocity.abs() < 0.05, "{angular_velocity} at {time}");
                assert!((wheel.braking_slip() - 1.0).abs() < 1e-3);
                // Sliding friction at this speed.
                let want = LOAD * (0.75 + 0.35 * (-wheel.slip_velocity().abs() / 6.0).exp());
                assert_within(2e-2, want, step.force, want, || format!("F at {time}"));
                assert_within(2e-2, want, step.brake_torque, RADIUS * want, || "T".into());
            }
        });
        assert!(locked_at.is_some());
    }
}

#[test]
fn a_standing_wheel_neither_creeps_nor_chatters() {
    for (h, slope) in [(1e-2, 0.0), (1e-2, 0.15), (1e-3, -0.15), (5e-2, 0.15)] {
        let mut wheel = wheel::<f64, 3>(parabolic(), 5.0);
        let loads = WheelLoads { force: slope * LOAD, ..WheelLoads::braking(2500.0) };
        let after = |wheel: &mut Wheel<f64, 3>, time: f64| {
            let mut fastest: f64 = 0.0;
            for _ in 0..(time / h) as u32 {
                wheel.step(loads, h).unwrap();
                fastest = fastest.max(wheel.state().speed.abs());
            }
            (wheel.state(), fastest)
        };
        after(&mut wheel, 5.0);
        let (early, _) = after(&mut wheel, 15.0);
        let (late, fastest) = after(&mut wheel, 15.0);
        // Swinging on its bristles dies away.
        assert!(fastest < 1e-4, "{fastest:e} m/s");
        assert!((late.position - early.position).abs() < 1e-6, "creeps");
        assert!((late.angle - early.angle).abs() < 1e-5);
        // It hangs on bristles deflected by the force.
        let step = wheel.step(loads, h).unwrap();
        assert_within(1e-2, LOAD, step.force, slope * LOAD, || "F".into());
        assert_within(1e-2, LOAD, step.brake_torque, RADIUS * slope * LOAD, || "T".into());
    }
}

#[test]
fn the_stopping_distance_does_not_hang_on_the_step() {
    let stop = |steps| {
        let mut wheel = wheel::<f64, 3>(parabolic(), 30.0);
        run(&mut wheel, 6.0, steps, hard, |_, _| {});
        wheel.state().position
    };
    let fine = stop(20_000);
    for (steps, tolerance) in [(600, 3e-2), (6000, 3e-4)] {
        let error = (stop(steps) - fine).abs();
        assert!(error < tolerance, "{error} m with {steps} steps");
    }
}

#[test]
fn single_precision_stops_at_the_same_place() {
    let mut single = wheel::<f32, 3>(parabolic(), 20.0);
    let mut double = wheel::<f64, 3>(parabolic(), 20.0);
    for n in 0..500 {
        let brake = (3000.0 * (f64::from(n) + 0.5) * 1e-2).min(2500.0);
        single.step(WheelLoads::braking(brake as f32), 1e-2).unwrap();
        double.step(WheelLoads::braking(brake), 1e-2).unwrap();
    }
    let (got, want) = (f64::from(single.state().position), double.state().position);
    // 500 additions of 1e-7 to some 30 m.
    assert_within(1e-4, want, got, want, || "stopping distance".into());
    assert!(single.state().speed.abs() < 1e-2);
}

#[test]
fn a_wheel_that_is_driven_backwards_is_refused_and_stays_as_it_was() {
    let mut wheel = wheel::<f64, 1>(constant(), 0.0);
    let loads = WheelLoads { drive_torque: -300.0, ..WheelLoads::braking(0.0) };
    let (before, error) = loop {
        let before = wheel.state();
        match wheel.step(loads, 1e-3) {
            Ok(_) => assert!(before.time < 10.0),
            Err(error) => break (before, error),
        }
    };
    assert_eq!(error.name, "rolled_back");
    assert_eq!(error.rule, Rule::AtMost { other: "what a patch takes", limit: 0.25 });
    assert!(error.value > 0.25 && -before.angle * RADIUS / LENGTH <= 0.25);
    assert_eq!(wheel.state(), before);
    // One that has rocked back by less rolls forward again.
    let mut wheel = self::wheel::<f64, 1>(constant(), 0.0);
    let drive = |drive_torque| WheelLoads { drive_torque, ..WheelLoads::braking(0.0) };
    while wheel.state().rolled_back < 0.1 {
        wheel.step(drive(-300.0), 1e-3).unwrap();
    }
    for _ in 0..1000 {
        wheel.step(drive(600.0), 1e-3).unwrap();
    }
    assert!(wheel.state().rolled_back == 0.0 && wheel.state().angular_velocity > 1.0);
}

#[test]
fn rocking_does_not_pump_bristles_through_the_patch() {
    // The vehicle stands like a wall, and the wheel is rocked by 120 N m on its bristles.
    let heavy = BrakedWheelParameters { mass: 1e12, ..parameters::<f64, 1>(constant(), 0.0) };
    let mut wheel = BrakedWheel::new(heavy).unwrap();
    let mut cycle = || {
        let mut most: f64 = 0.0;
        for n in 0..200 {
            let drive_torque = 120.0 * (2.0 * PI * f64::from(n) / 200.0).sin();
            wheel.step(WheelLoads { drive_torque, ..WheelLoads::braking(0.0) }, 1e-3).unwrap();
            most = most.max(wheel.state().rolled_back);
        }
        (most, wheel.tyre().segments())
    };
    cycle();
    let (_, first) = cycle();
    for _ in 0..50 {
        cycle();
    }
    let (most, last) = cycle();
    // By 400 N on 8e5 N/m both ways, 0.12 m long: several segments of the narrowest kind.
    assert_within(0.1, most, most, 2.0 * 400.0 / 8e5 / 0.12, || "rocked back".into());
    assert!(last <= first + 2, "{first} segments became {last}");
}

/// A slip angle that swings to both sides once, over the time of a lane change.
fn lane_change(time: f64) -> f64 {
    if time < 0.8 { 0.08 * (2.5 * PI * time).sin() } else { 0.0 }
}

#[test]
fn a_steered_wheel_that_runs_straight_is_the_wheel_of_one_axis() {
    let mut straight = wheel::<f64, 3>(parabolic(), 15.0);
    let mut plane = steered::<f64, 3>(parabolic(), 15.0);
    for number in 0..800 {
        let loads = WheelLoads::braking(hard(5e-3 * f64::from(number)));
        // Locks, comes to rest and swings out. To the last bit.
        assert_eq!(plane.step(loads, 5e-3).unwrap(), straight.step(loads, 5e-3).unwrap());
    }
    assert!(plane.state().speed.abs() < 1e-2, "{:?}", plane.state());
    assert_eq!(plane.stored_energy(), straight.stored_energy());
    assert_eq!((plane.state().lateral_force, plane.aligning_moment(0.0)), (0.0, 0.0));
}

#[test]
fn a_free_wheel_at_a_slip_angle_has_the_steady_lateral_force_and_moment() {
    let mut wheel = steered::<f64, 4>(parabolic().padded(), 20.0);
    for slip_angle in [0.02, 0.1, -0.1_f64] {
        let lateral_velocity = 20.0 * slip_angle.tan();
        let loads = WheelLoads { lateral_velocity, ..WheelLoads::braking(0.0) };
        for _ in 0..400 {
            wheel.step(loads, 1e-3).unwrap();
        }
        // In full slip nothing holds the wheel at its rolling speed but its own inertia.
        let WheelState { speed, angular_velocity, lateral_force, .. } = wheel.state();
        assert_within(1e-12, 20.0, speed, 20.0, || format!("{slip_angle}"));
        let along =
            Motion { slip_velocity: lateral_velocity, rolling_speed: angular_velocity * RADIUS };
        let patch = patch(tyre::<f64>(), parabolic());
        let want = patch.steady(along).unwrap().force;
        let moment = want * patch.pneumatic_trail(along).unwrap().unwrap();
        let got = wheel.aligning_moment(lateral_velocity);
        assert_within(1e-9, LOAD, lateral_force, want, || format!("{slip_angle}"));
        assert_within(1e-9, LOAD * LENGTH, got, moment, || format!("{slip_angle}"));
        assert!(lateral_force * slip_angle > 0.0);
    }
}

#[test]
fn a_braking_lane_change_is_of_second_order_and_inside_the_friction_circle() {
    let at_end = |steps: u32| -> [f64; 4] {
        let mut wheel = steered::<f64, 4>(parabolic().padded(), 25.0);
        let h = 0.6 / f64::from(steps);
        let mut largest: f64 = 0.0;
        for number in 0..steps {
            let middle = h * (f64::from(number) + 0.5);
            let lateral_velocity = 25.0 * lane_change(middle).tan();
            let loads = WheelLoads { lateral_velocity, ..WheelLoads::braking(soft(middle)) };
            let state = wheel.step(loads, h).unwrap();
            largest = largest.max(state.force.hypot(state.lateral_force));
        }
        // μ_s = 1.1: the circle is a limit, and the manoeuvre comes near it.
        assert!(largest < 1.1 * LOAD && largest > 0.6 * LOAD, "{largest}");
        let state = wheel.state();
        let moment = wheel.aligning_moment(25.0 * lane_change(0.6).tan());
        [state.position, state.speed, state.angular_velocity, moment]
    };
    let [coarse, middle, fine] = [300, 600, 1200].map(at_end);
    for i in 0..3 {
        let order = ((coarse[i] - middle[i]).abs() / (middle[i] - fine[i]).abs()).log2();
        assert!((1.6..2.4).contains(&order), "{i}: {order}");
    }
    // The moment, whose slip velocity is not that of the middle, is right, too.
    assert_within(2e-3, LOAD * LENGTH, middle[3], fine[3], || "moment".into());
}

#[test]
fn a_tyre_of_one_axis_does_not_steer() {
    let mut wheel = wheel::<f64, 1>(constant(), 20.0);
    let steer = |lateral_velocity| WheelLoads { lateral_velocity, ..WheelLoads::braking(0.0) };
    let before = wheel.state();
    let error = wheel.step(steer(0.1), 1e-3).unwrap_err();
    assert_eq!(
        error.to_string(),
        "lateral_velocity is 0.1, but must be zero on a tyre of one axis (a PlaneBristle makes \
         one of two)"
    );
    assert_eq!(wheel.state(), before);
    let mut wheel = steered::<f64, 1>(constant(), 20.0);
    for bad in [f64::NAN, f64::INFINITY] {
        assert_eq!(wheel.step(steer(bad), 1e-3).unwrap_err().name, "lateral_velocity");
    }
    assert_eq!(wheel.state(), before);
}

#[test]
fn bad_input_is_named() {
    let good = || parameters::<f64, 1>(constant(), 20.0);
    let (nan, infinite) = (f64::NAN, f64::INFINITY);
    assert_fields_refuse!([0.0, -1.0, nan, infinite], BrakedWheel::new, good();
        mass inertia radius);
    assert_fields_refuse!([nan], BrakedWheel::new, good(); speed angular_velocity);
    assert_fields_refuse!([-1.0], BrakedWheel::new, good(); angular_velocity);
    let mut wheel = BrakedWheel::new(good()).unwrap();
    let (before, brake) = (wheel.state(), *wheel.brake());
    let mut refused = |loads, duration| wheel.step(loads, duration).unwrap_err().name;
    let good = WheelLoads::braking(100.0);
    for bad in [nan, infinite] {
        assert_eq!(refused(WheelLoads::braking(bad), 1e-3), "brake_normal_force");
        assert_eq!(refused(WheelLoads { drive_torque: bad, ..good }, 1e-3), "drive_torque");
        assert_eq!(refused(WheelLoads { force: bad, ..good }, 1e-3), "force");
        assert_eq!(refused(good, bad), "duration");
    }
    assert_eq!(refused(WheelLoads::braking(-1.0), 1e-3), "brake_normal_force");
    assert_eq!(refused(good, -1e-3), "duration");
    // A push that no number can follow.
    assert_eq!(refused(WheelLoads { force: 1e99, ..good }, 1e99), "speed");
    assert_eq!((wheel.state(), *wheel.brake()), (before, brake));
    // No time, no change: but a brake that touches has an unstretched bristle.
    for _ in 0..2 {
        wheel.step(good, 0.0).unwrap();
        assert_eq!(wheel.state(), WheelState { brake_deflection: 0.0, ..before });
    }
}

#[test]
fn a_run_in_an_array_allocates_nothing() {
    let BrakedWheelParameters { brake, mass, inertia, radius, speed, angular_velocity, .. } =
        parameters::<f64, 3>(parabolic(), 30.0);
    let counted = allocation_counter::measure(|| {
        let tyre = patch(tyre(), parabolic()).exact([[Segment::default(); 100]]).unwrap();
        let all =
            BrakedWheelParameters { tyre, brake, mass, inertia, radius, speed, angular_velocity };
        let mut wheel = BrakedWheel::new(all).unwrap();
        for n in 0..600 {
            let loads = WheelLoads::braking(hard(f64::from(n) * 1e-2));
            wheel.step(loads, 1e-2).unwrap();
        }
        assert!(wheel.state().speed.abs() < 1e-2);
    });
    assert_eq!(counted.count_total, 0);
}

#[test]
fn a_brake_that_is_pressed_from_the_start_has_its_full_torque_at_once() {
    for (speed, normal_force) in [(2.0, 50.0), (20.0, 1500.0)] {
        let mut given = parameters::<f64, 1>(constant(), speed);
        given.brake = pads().under_load(normal_force).unwrap();
        let mut wheel = BrakedWheel::new(given).unwrap();
        let step = wheel.step(WheelLoads::braking(normal_force), 1e-9).unwrap();
        // Coulomb with 1 N m per newton. The wheel slows by 2e-9 of its speed, which the bristle
        // feels through its damping.
        assert_within(1e-7, normal_force, step.brake_torque, normal_force, || {
            format!("{speed} m/s")
        });
    }
}
