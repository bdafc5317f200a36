//! The exact reduction of a rolling patch under velocities that vary over time.

use core::ops::Range;

use crate::characteristics::{SmoothHistory, gauss};
use crate::tyre::{
    LENGTH, Model, constant, coulomb, exponential, frbd, lugre, motion, parabolic, patch, tyre,
};
use bristle::signal::{Function, Polyline, Signal, Vertex};
use bristle::{Bristle, FrBd};
use bristle_rolling::{ExactPatch, Motion, PolynomialExponential, Pressure, Segment};
use bristle_specimens::specimens::spring;

const END: f64 = 0.1;
const SAMPLES: usize = 25;

type Rolling<M, const N: usize> = ExactPatch<f64, M, N, Vec<Segment<f64, N>>>;
/// How a patch rolls over a span of time, and the force at its end.
type Step<M, S, W, const N: usize> = fn(&mut Rolling<M, N>, &Motion<S, W>, Range<f64>) -> f64;

fn followed<M: Model, S: Signal<f64>, W: Signal<f64>, const N: usize>(
    rolling: &mut Rolling<M, N>,
    motion: &Motion<S, W>,
    span: Range<f64>,
) -> f64 {
    rolling.follow(motion, span).unwrap()
}

/// The motion of the middle of the span, held.
fn held<M: Model, S: Signal<f64>, W: Signal<f64>, const N: usize>(
    rolling: &mut Rolling<M, N>,
    motion: &Motion<S, W>,
    span: Range<f64>,
) -> f64 {
    let middle = 0.5 * (span.start + span.end);
    let slip_velocity = motion.slip_velocity.value(middle);
    let rolling_speed = motion.rolling_speed.value(middle);
    rolling.step(Motion { slip_velocity, rolling_speed }, span.end - span.start).unwrap();
    rolling.force(motion.slip_velocity.value(span.end))
}

/// The greatest error of the force over some samples, over the normal force.
fn error<M: Model, S: Signal<f64>, W: Signal<f64>, const N: usize>(
    model: M,
    pressure: PolynomialExponential<f64, N>,
    motion: &Motion<S, W>,
    reference: &[f64],
    (parts, step): (usize, Step<M, S, W, N>),
) -> f64 {
    let mut rolling = patch(model, pressure).exact_in(20_000).unwrap();
    let steps = SAMPLES * parts;
    let time = |number: usize| END * number as f64 / steps as f64;
    let mut worst = 0.0_f64;
    for number in 0..steps {
        let force = step(&mut rolling, motion, time(number)..time(number + 1));
        if (number + 1) % parts == 0 {
            worst = worst.max((force - reference[number / parts]).abs() / LENGTH);
        }
    }
    worst
}

/// The force of the characteristics at the samples.
fn reference<M: Model, S: Signal<f64>, W: Signal<f64>, const N: usize>(
    model: M,
    pressure: PolynomialExponential<f64, N>,
    motion: &Motion<S, W>,
    kinks: &[f64],
) -> Vec<f64> {
    let v = |t: f64| motion.slip_velocity.value(t);
    let affine = |t: f64| model.affine(v(t).into(), 0.0);
    let history = SmoothHistory {
        coefficients: &|t| (affine(t).relaxation, affine(t).drive * v(t)),
        transport: &|t| motion.rolling_speed.value(t) / LENGTH,
        kinks,
        panel: 2e-4,
    };
    let gauss = gauss();
    // ∫ p from a place to the outlet.
    let rest = |place: f64| {
        let part = 1.0 - place;
        gauss.iter().map(|(node, weight)| part * weight * pressure.at(place + part * node)).sum()
    };
    let force = |number: usize| {
        let time = END * number as f64 / SAMPLES as f64;
        let deflections = history.weighted(0.0, time, &rest);
        let viscous = pressure.total() * affine(time).damping * v(time);
        LENGTH * (affine(time).stiffness * deflections + viscous)
    };
    (1..=SAMPLES).map(force).collect()
}

/// The slope of the error over halved steps: of fourth order, and of second if they are held at
/// their middle and the signals are smooth.
fn orders<M: Model, S: Signal<f64>, W: Signal<f64>, const N: usize>(
    name: &str,
    model: M,
    pressure: PolynomialExponential<f64, N>,
    motion: &Motion<S, W>,
    kinks: &[f64],
    smooth: bool,
) {
    let reference = reference(model, pressure, motion, kinks);
    let steps: [(Step<M, S, W, N>, f64); 2] = [(followed, 4.0), (held, 2.0)];
    for (step, order) in steps.into_iter().take(1 + usize::from(smooth)) {
        let errors = [8, 64].map(|parts| error(model, pressure, motion, &reference, (parts, step)));
        // The steps cut the patch differently every time, which scatters an error.
        let mean = (errors[0] / errors[1]).log2() / 3.0;
        assert!(mean > order - 0.35, "{name}, {order}: {errors:?}");
    }
}

#[test]
fn the_force_converges_to_that_of_the_characteristics_with_its_order() {
    let steady = Motion { slip_velocity: Function::new(swing, []), rolling_speed: 6.17 };
    let (pulsing, kinks) = (pulsing(), reversals());
    assert!(kinks.len() >= 4);
    orders("FrBD, constant", tyre(), constant(), &steady, &kinks, true);
    orders("FrBD, exponential", tyre(), exponential(0.7), &steady, &kinks, true);
    orders("V(t), constant", tyre(), constant(), &pulsing, &kinks, true);
    orders("V(t), parabola", tyre(), parabolic(), &pulsing, &kinks, true);
    orders("damped", frbd(0.5), constant(), &pulsing, &kinks, true);
    orders("LuGre", lugre(0.5), constant(), &pulsing, &kinks, true);
}

fn swing(t: f64) -> (f64, f64) {
    let w = 2.0 * std::f64::consts::PI * 23.0;
    (0.3 * (w * t + 0.4).sin() + 0.1, 0.3 * w * (w * t + 0.4).cos())
}

fn pulse(t: f64) -> (f64, f64) {
    (7.0 + 4.5 * (61.0 * t).sin(), 4.5 * 61.0 * (61.0 * t).cos())
}

fn pulsing() -> Motion<impl Signal<f64>, impl Signal<f64>> {
    Motion { slip_velocity: Function::new(swing, []), rolling_speed: Function::new(pulse, []) }
}

/// The zeros of the swing.
fn reversals() -> Vec<f64> {
    let mut found = Vec::new();
    let steps = 10_000;
    for number in 0..steps {
        let (a, b) = (END * f64::from(number) / 1e4, END * f64::from(number + 1) / 1e4);
        let (at_a, at_b) = (swing(a).0, swing(b).0);
        if at_a * at_b < 0.0 {
            let sign = at_b.signum();
            found.push(bristle_specimens::root(a, b, |t| sign * swing(t).0));
        }
    }
    found
}

#[test]
fn the_error_of_the_force_is_within_the_tolerance() {
    fn each<M: Model, const N: usize>(
        name: &str,
        model: M,
        pressure: PolynomialExponential<f64, N>,
        motion: &Motion<impl Signal<f64>, impl Signal<f64>>,
    ) {
        let reference = reference(model, pressure, motion, &reversals());
        for tolerance in [1e-3, 1e-5, 1e-7, 1e-9] {
            let mut rolling = patch(model, pressure).exact_in(20_000).unwrap();
            let mut worst = 0.0_f64;
            for (number, want) in reference.iter().enumerate() {
                let time = |number: usize| END * number as f64 / SAMPLES as f64;
                let span = time(number)..time(number + 1);
                let force = rolling.follow_within(motion, span, tolerance).unwrap();
                worst = worst.max((force - want).abs() / LENGTH);
            }
            assert!(worst <= tolerance, "{name}, {tolerance:e}: {worst:e}");
            // In one call, with all its reversals.
            let mut at_once = patch(model, pressure).exact_in(20_000).unwrap();
            let force = at_once.follow_within(motion, 0.0..END, tolerance).unwrap();
            let off = (force - reference[SAMPLES - 1]).abs() / LENGTH;
            assert!(off <= tolerance, "{name}, {tolerance:e}: {off:e} at once");
            let (few, many) = (at_once.segments(), rolling.segments());
            assert!(few <= 2 * many, "{name}, {tolerance:e}: {few}, {many} segments");
        }
    }
    let steady = Motion { slip_velocity: Function::new(swing, []), rolling_speed: 6.17 };
    let pulsing = pulsing();
    each("FrBD, constant", tyre(), constant(), &steady);
    each("FrBD, parabola", tyre(), parabolic(), &pulsing);
    each("damped", frbd(0.5), constant(), &pulsing);
    each("LuGre", lugre(0.5), parabolic(), &pulsing);
    each("stiff", FrBd::new(*tyre().curve(), spring(1e5)), parabolic(), &pulsing);
}

#[test]
fn a_standing_patch_and_single_precision_keep_a_tolerance() {
    // All bristles of a patch that stands are one.
    let mut standing = patch(tyre(), constant()).exact_in(100).unwrap();
    let mut fine = standing.clone();
    let motion = Motion { slip_velocity: Function::new(swing, []), rolling_speed: 0.0 };
    let got = standing.follow_within(&motion, 0.0..END, 1e-8).unwrap();
    let mut want = f64::NAN;
    for number in 0..2000 {
        let time = |number: i32| END * f64::from(number) / 2000.0;
        want = fine.follow(&motion, time(number)..time(number + 1)).unwrap();
    }
    assert!((got - want).abs() < 1e-8 * LENGTH, "{got:e} {want:e}");

    let single = patch(coulomb::<f32>(0.5, 0.0), constant());
    let swing =
        Function::new(|t: f32| (0.1 + 0.3 * (100.0 * t).sin(), 30.0 * (100.0 * t).cos()), []);
    let motion = Motion { slip_velocity: swing, rolling_speed: 6.0_f32 };
    let force =
        |tolerance| single.exact_in(1000).unwrap().follow_within(&motion, 0.0..0.1, tolerance);
    let (coarse, fine) = (force(1e-2).unwrap(), force(2e-4).unwrap());
    assert!((coarse - fine).abs() <= 1e-2 * 0.1, "{coarse:e} {fine:e}");
}

#[test]
fn a_tolerance_that_cannot_be_kept_is_refused() {
    let mut rolling = patch(tyre(), constant()).exact_in(400).unwrap();
    let before = format!("{rolling:?}");
    let motion = Motion { slip_velocity: Function::new(swing, []), rolling_speed: 6.17 };
    for tolerance in [0.0, -1.0, 1e-14, f64::NAN, f64::INFINITY] {
        let refused = rolling.follow_within(&motion, 0.0..0.01, tolerance).unwrap_err();
        assert_eq!(refused.name, "tolerance");
    }
    // Noise of 10 % at a time scale of a nanosecond.
    let noisy = |t: f64| (1.0 + 0.1 * (1e9 * t).sin(), 0.0);
    let noise = Motion { slip_velocity: Function::new(noisy, []), rolling_speed: 6.17 };
    let refused = rolling.follow_within(&noise, 0.0..1.0, 1e-12).unwrap_err();
    assert_eq!(refused.name, "pieces of the span");
    assert_eq!(format!("{rolling:?}"), before);
}

#[test]
fn kinks_and_jumps_of_the_signals_do_not_spoil_the_order() {
    let vertex = |time, value| Vertex { time, value };
    let slip = Polyline::new([
        vertex(0.0, 0.0),
        vertex(0.0113, 0.4),
        vertex(0.0517, -0.3),
        vertex(0.1, 0.2),
    ]);
    // U jumps.
    let speed = |t: f64| if t < 0.0319 { (5.0 + 90.0 * t, 90.0) } else { (9.0, 0.0) };
    let motion =
        Motion { slip_velocity: slip.unwrap(), rolling_speed: Function::new(speed, [0.0319]) };
    let v = |t: f64| motion.slip_velocity.value(t);
    let mut kinks = vec![0.0113, 0.0319, 0.0517];
    kinks.push(bristle_specimens::root(0.02, 0.05, |t| -v(t)));
    kinks.push(bristle_specimens::root(0.06, 0.099, v));
    orders("polyline", tyre(), constant(), &motion, &kinks, false);
}

#[test]
fn constant_signals_make_a_held_step() {
    let new = || patch(tyre(), parabolic()).exact_in(200).unwrap();
    let (mut held, mut followed) = (new(), new());
    for number in 0..300 {
        let motion = motion(0.3 * (f64::from(number % 7) - 3.0), 20.0 * f64::from(number % 4));
        let end = 5.0 + 1e-3 * f64::from(1 + number % 5);
        let got = followed.follow(&motion, 5.0..end).unwrap();
        let want = held.step(motion, end - 5.0).unwrap();
        assert!((got - want).abs() < 1e-14 * LENGTH, "{number}: {got:e} {want:e}");
    }
}

#[test]
fn a_stiff_bristle_follows_its_stationary_deflection() {
    // λh from 2e4 to 2e5 while V h = 0.01: the force is that of full sliding at the end of the
    // step, except near the inlet.
    let model = FrBd::new(*tyre().curve(), spring(1e7));
    let slip = Function::new(|t: f64| (5.0 + 4.0 * (30.0 * t).sin(), 120.0 * (30.0 * t).cos()), []);
    let motion = Motion { slip_velocity: slip, rolling_speed: 1.0 };
    let mut rolling = patch(model, parabolic()).exact_in(400).unwrap();
    for number in 0..400 {
        let time = 1e-3 * f64::from(number);
        let force = rolling.follow(&motion, time..time + 1e-3).unwrap();
        let want = LENGTH * model.stationary_coefficient(slip.value(time + 1e-3));
        // What the method misses of a velocity that changes by up to 3 % in a step: measured
        // 2.6e-5.
        assert!(number < 100 || (force / want - 1.0).abs() < 5e-5, "{number}: {force:e} {want:e}");
        assert!(force.abs() <= 0.6 * LENGTH);
    }
}

#[test]
fn a_patch_comes_to_rest_and_starts_again() {
    // U(t) falls to zero, stays there, and rises.
    let speed = |t: f64| {
        if t < 0.04 {
            (250.0 * (0.04 - t), -250.0)
        } else if t < 0.06 {
            (0.0, 0.0)
        } else {
            (250.0 * (t - 0.06), 250.0)
        }
    };
    let motion = Motion {
        slip_velocity: Function::new(swing, []),
        rolling_speed: Function::new(speed, [0.04, 0.06]),
    };
    let mut kinks = reversals();
    kinks.extend([0.04, 0.06]);
    let reference = reference(tyre(), constant(), &motion, &kinks);
    let errors =
        [16, 64].map(|parts| error(tyre(), constant(), &motion, &reference, (parts, followed)));
    // Bristles that come in at V → 0 have a profile like √ξ, which costs orders, not sense.
    assert!(errors[0] < 1e-8 && errors[1] < 1e-10, "{errors:?}");
}

#[test]
fn bad_signals_are_refused_by_name_and_change_nothing() {
    let mut rolling = patch(tyre(), parabolic()).exact([[Segment::default(); 50]]).unwrap();
    let good = pulsing();
    for number in 0..20 {
        let time = 1e-3 * f64::from(number);
        rolling.follow(&good, time..time + 1e-3).unwrap();
    }
    let before = format!("{rolling:?}");
    let function = |f: fn(f64) -> f64| Function::new(move |t| (f(t), 0.0), [0.5]);
    // The last is fine for the first part of its span.
    let bad_slips: [fn(f64) -> f64; 4] = [
        |_| f64::NAN,
        |_| f64::INFINITY,
        |t| 1.0 / (t - t),
        |t| if t > 0.6 { f64::NAN } else { 1.0 },
    ];
    for slip in bad_slips {
        let motion = Motion { slip_velocity: function(slip), rolling_speed: 1.0 };
        let refused = rolling.follow(&motion, 0.0..1.0).unwrap_err();
        assert_eq!(refused.name, "slip_velocity");
    }
    let bad_speeds: [fn(f64) -> f64; 4] =
        [|_| f64::NAN, |_| -1.0, |_| f64::INFINITY, |t| if t > 0.6 { -1e-9 } else { 1.0 }];
    for speed in bad_speeds {
        let motion = Motion { slip_velocity: 1.0, rolling_speed: function(speed) };
        let refused = rolling.follow(&motion, 0.0..1.0).unwrap_err();
        assert_eq!(refused.name, "rolling_speed");
    }
    for span in [1.0..0.5, f64::NAN..1.0, 0.0..f64::NAN, 0.0..f64::INFINITY] {
        assert!(rolling.follow(&good, span).is_err());
    }
    let fast = Motion { slip_velocity: 1.0, rolling_speed: 100000.0 };
    let refused = rolling.follow(&fast, 0.0..1.0).unwrap_err();
    assert_eq!((refused.name, refused.value), ("crossings of the patch", 1e6));
    assert_eq!(format!("{rolling:?}"), before);
    // A span of no length changes nothing either.
    let force = rolling.follow(&good, 0.02..0.02).unwrap();
    assert_eq!(force, rolling.force(swing(0.02).0));
    assert_eq!(format!("{rolling:?}"), before);
}

#[test]
fn a_rolling_speed_that_swings_fast_keeps_a_tolerance_at_a_constant_slip_velocity() {
    // Pieces far shorter than the patch: what they change of the deflections is far smaller than
    // these are, and the error of the way counts.
    let w = 2e4;
    let speed = |t: f64| (2.0 + 1.8 * (w * t).sin(), 1.8 * w * (w * t).cos());
    let motion = Motion { slip_velocity: 0.02, rolling_speed: Function::new(speed, []) };
    let forces = |tolerance: f64| -> Vec<f64> {
        let mut rolling = patch(tyre(), constant()).exact_in(20_000).unwrap();
        let span = |n: u32| f64::from(n) * 0.004..f64::from(n + 1) * 0.004;
        (0..10).map(|n| rolling.follow_within(&motion, span(n), tolerance).unwrap()).collect()
    };
    let want = forces(1e-10);
    for tolerance in [1e-3, 1e-6] {
        for (force, want) in forces(tolerance).iter().zip(&want) {
            let off = (force - want).abs() / LENGTH;
            assert!(off <= tolerance, "{tolerance:e}: {off:e}");
        }
    }
}
