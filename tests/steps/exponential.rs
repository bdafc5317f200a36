//! A bristle under a known velocity: orders, bounds, limits.

use std::f64::consts::TAU;

use bristle::curve::Stribeck;
use bristle::exponential::{CollocationSolver, Exponential, StepSummary};
use bristle::ode::{Statistics, StopReason};
use bristle::rheology::KelvinVoigt;
use bristle::signal::{Function, Polyline, Signal, Sine, SineParameters, Vertex};
use bristle::{Bristle, Contact, Dahl, DahlParameters, FrBd, Law};
use bristle_specimens::recipe::{Recipe, decades, recipe};
use bristle_specimens::specimens::{specimens, table_2_frbd, table_2_lugre};
use bristle_specimens::{check, runge_kutta};
use proptest::prelude::*;

type Friction = FrBd<Stribeck<f64>, KelvinVoigt<f64>>;

fn friction() -> Contact<f64, Friction> {
    table_2_frbd().under_load(2.0).unwrap()
}

/// Breakaway deflection of that friction [m].
const BREAKAWAY: f64 = 1.5e-4;

fn sine(mean: f64, amplitude: f64, frequency: f64, phase: f64) -> Sine<f64> {
    Sine::new(SineParameters { mean, amplitude, frequency, phase }).unwrap()
}

fn dahl() -> Contact<f64, Dahl<f64>> {
    let dahl = DahlParameters { dynamic_coefficient: 1.0, micro_stiffness: 1e4 };
    Dahl::new(dahl).unwrap().under_load(3.0).unwrap()
}

/// The closed form of a Dahl bristle with z_m = 1e-4 m from one position to another, without
/// reversal.
fn along(z: f64, from: f64, to: f64) -> f64 {
    let end = 1e-4 * (to - from).signum();
    end + (z - end) * (-(to - from).abs() / 1e-4).exp()
}

/// Deflection, mean force and work after a step, by the classical Runge–Kutta method, for a
/// velocity without reversal.
fn reference<M: Bristle<f64, Deflection = f64>>(
    contact: &Contact<f64, M>,
    velocity: impl Fn(f64) -> f64,
    z: f64,
    duration: f64,
    steps: u32,
) -> [f64; 3] {
    let [z, impulse, work] = runge_kutta(0.0..duration, steps, [z, 0.0, 0.0], |t, [z, ..]| {
        let (v, now) = (velocity(t), contact.response(velocity(t), z));
        [now.rate, now.force, now.force * v]
    });
    [z, impulse / duration, work]
}

fn close(found: f64, wanted: f64, tolerance: f64, what: &str) {
    assert!((found - wanted).abs() <= tolerance, "{what}: {found:e} instead of {wanted:e}");
}

/// Errors of deflection, mean force and work after one step and after so many equal ones.
fn errors<const S: usize, M: Bristle<f64, Deflection = f64>>(
    contact: &Contact<f64, M>,
    velocity: impl Fn(f64) -> f64 + Copy,
    (z, duration): (f64, f64),
    steps: u32,
) -> [f64; 3] {
    let wanted = reference(contact, velocity, z, duration, 5000);
    let h = duration / f64::from(steps);
    let (mut deflection, mut impulse, mut work) = (z, 0.0, 0.0);
    for n in 0..steps {
        let part = |place: f64| velocity((f64::from(n) + place) * h);
        let step = Exponential::<S>.step(contact, part, deflection, h);
        deflection = step.deflection;
        impulse += step.mean * h;
        work += step.work;
    }
    [
        (deflection - wanted[0]).abs() / BREAKAWAY,
        (impulse / duration - wanted[1]).abs() / 3.0,
        (work - wanted[2]).abs() / wanted[2].abs(),
    ]
}

fn has_its_order<const S: usize>(coarse: u32) {
    // Frictional lag at 25 Hz: three eighths of a period, so that nothing is symmetric.
    let velocity = |t: f64| 0.0055 + 0.005 * (TAU * 25.0 * t + 0.3).sin();
    let lugre = table_2_lugre().under_load(2.0).unwrap();
    let at = |steps: u32| {
        let one = errors::<S, _>(&friction(), velocity, (-4e-5, 0.015), steps);
        one.into_iter().chain(errors::<S, _>(&lugre, velocity, (-4e-5, 0.015), steps))
    };
    for (index, (coarse, fine)) in at(coarse).zip(at(coarse * 4)).enumerate() {
        let order = (coarse / fine).log2() / 2.0;
        // Half an order for what the next term of the error still adds.
        assert!(order > 2.0 * S as f64 - 1.5, "{S} nodes, {index}: {coarse:e} {fine:e} {order}");
        // Above rounding, or the order would mean nothing.
        assert!(fine > 2e-15, "{S} nodes, {index}: {fine:e}");
    }
}

#[test]
fn deflection_mean_force_and_work_have_the_order_2s_minus_1() {
    has_its_order::<2>(8);
    has_its_order::<3>(6);
    has_its_order::<4>(4);
    has_its_order::<5>(2);
}

#[test]
fn the_curve_between_the_ends_has_the_order_s_plus_2() {
    let contact = friction();
    let velocity = sine(0.0055, 0.005, 25.0, 0.3);
    fn worst<const S: usize>(contact: &Contact<f64, Friction>, v: &Sine<f64>, steps: u32) -> f64 {
        let solver = Exponential::<S>.fixed(0.03 / f64::from(steps)).unwrap();
        let mut worst = 0.0;
        let mut before = (0.0, -4e-5);
        solver
            .sample(contact, v, 0.0..0.03, -4e-5, 98, |t, z| {
                if t > 0.0 {
                    let on = |s| v.value(before.0 + s);
                    let [on, ..] = reference(contact, on, before.1, t - before.0, 200);
                    worst = f64::max(worst, (z - on).abs() / BREAKAWAY);
                    before = (t, on);
                }
            })
            .unwrap();
        worst
    }
    let order = |coarse: f64, fine: f64| (coarse / fine).log2() / 2.0;
    // Local order S + 2, and no accumulation, for the ends are better.
    let three = order(worst::<3>(&contact, &velocity, 12), worst::<3>(&contact, &velocity, 48));
    assert!(three > 4.5, "{three}");
    let five = order(worst::<5>(&contact, &velocity, 8), worst::<5>(&contact, &velocity, 32));
    assert!(five > 6.5, "{five}");
}

#[test]
fn the_order_survives_reversals() {
    // x = X sin(2πt): a Dahl bristle between reversals is an exponential of the way.
    let amplitude = 2.5e-4;
    let exact = |time: f64| {
        let (mut x, mut z) = (0.0, 0.0);
        for reversal in 0..(time * 2.0 + 0.5).floor() as u32 {
            let next = if reversal % 2 == 0 { amplitude } else { -amplitude };
            z = along(z, x, next);
            x = next;
        }
        along(z, x, amplitude * (TAU * time).sin())
    };
    fn worst<const S: usize>(amplitude: f64, exact: impl Fn(f64) -> f64, per_period: f64) -> f64 {
        let velocity = sine(0.0, amplitude * TAU, 1.0, TAU / 4.0);
        let (contact, solver) = (dahl(), Exponential::<S>.fixed(1.0 / per_period).unwrap());
        let mut run = solver.begin(&contact, &velocity, 0.0..3.0, 0.0).unwrap();
        let mut worst = 0.0;
        while let Some(piece) = run.advance().unwrap() {
            worst = f64::max(worst, (piece.end() - exact(piece.end_time())).abs() / 1e-4);
        }
        assert_eq!(run.statistics().reversals, 6);
        worst
    }
    // No whole number of steps a period, so that no grid point meets a reversal.
    let order = |coarse: f64, fine: f64| (coarse / fine).log2() / 2.0;
    let three = [18.74, 74.96].map(|steps| worst::<3>(amplitude, exact, steps));
    let four = [9.37, 37.48].map(|steps| worst::<4>(amplitude, exact, steps));
    assert!(order(three[0], three[1]) > 4.5 && order(four[0], four[1]) > 6.5, "{three:?} {four:?}");
    assert!(four[1] > 1e-14, "{four:?}");
    // With more nodes nothing is left but rounding, a few hundred steps of it and e^−x of x ≈ 30.
    assert!(worst::<7>(amplitude, exact, 60.3) < 1e-12);
    assert!(worst::<8>(amplitude, exact, 60.3) < 1e-12);
}

/// Deflections along a run of Table 2, from zero, and what it cost.
fn sampled<const S: usize>(
    solver: CollocationSolver<f64, S>,
    velocity: &Sine<f64>,
    end: f64,
    samples: usize,
) -> (Vec<f64>, Statistics) {
    let mut list = Vec::new();
    let each = |_, z| list.push(z);
    let cost = solver.sample(&friction(), velocity, 0.0..end, 0.0, samples, each).unwrap();
    (list, cost)
}

/// The largest difference, in breakaway deflections.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / BREAKAWAY
}

#[test]
fn an_adaptive_run_keeps_its_tolerance_also_across_reversals() {
    for (mean, frequency) in [(0.0055, 25.0), (0.0055, 100.0), (0.001, 25.0), (0.0, 1.0)] {
        let (velocity, end) = (sine(mean, 0.005, frequency, 0.2), 5.0 / frequency);
        // The same driver with other nodes and fixed short steps, whose order is shown above.
        let exact = Exponential::<4>.fixed(end / 4000.0).unwrap();
        let (exact, _) = sampled(exact, &velocity, end, 501);
        let mut steps = 0;
        for tolerance in [1e-4, 1e-6, 1e-8] {
            let solver = Exponential::<5>.adaptive(tolerance).unwrap();
            let (found, statistics) = sampled(solver, &velocity, end, 501);
            let error = apart(&found, &exact);
            // The tolerance is for each step; a few of them add up before they are forgotten.
            assert!(error < 5.0 * tolerance, "{mean} {frequency} {tolerance:e}: {error:e}");
            assert!(statistics.steps > steps && statistics.steps < 500, "{statistics}");
            steps = statistics.steps;
        }
    }
}

#[test]
fn a_step_towards_rest_does_not_pass_by_the_stribeck_range_unseen() {
    // Quarter periods in which nothing happens but for the last percent of the speed, where
    // friction rises.
    for amplitude in [0.01, 0.05, 0.2, 1.67, 5.0] {
        for (mean, frequency) in [(0.0, 0.003), (0.6, 0.003), (0.0, 0.011), (0.6, 0.1)] {
            let velocity = sine(mean * amplitude, amplitude, frequency, 0.7);
            let end = 2.0 / frequency;
            let run = |solver| sampled::<5>(solver, &velocity, end, 201).0;
            // Fixed steps of which some fifty lie in the range, of an order shown above.
            let exact = run(Exponential.fixed(end / 8000.0).unwrap());
            let error = apart(&run(Exponential.adaptive(1e-4).unwrap()), &exact);
            // As above, a few steps may add up.
            assert!(error < 5e-4, "{mean} {amplitude} {frequency}: {error:e}");
        }
    }
}

#[test]
fn a_dahl_bristle_on_a_ramp_is_exact_also_across_its_reversal() {
    // λ is linear and z_ss constant: nothing is approximated. Tolerance: roundings of z_m, times Λ
    // for that of e^−Λ.
    let contact = dahl();
    for (from, to, h) in
        [(0.01, 0.02, 1e-3), (-0.01, 0.03, 0.1), (0.2, -0.1, 0.01), (0.0, -1.0, 1e-4)]
    {
        for z in [-1e-4, 0.0, 3e-5, 4e-4] {
            let step = Exponential::<2>.ramp(&contact, from..to, z, h);
            let v = |s: f64| from + (to - from) * s;
            // The fewest and the most nodes.
            let closures = [
                Exponential::<2>.step(&contact, v, z, h),
                Exponential::<3>.step(&contact, v, z, h),
                Exponential::<8>.step(&contact, v, z, h),
            ];
            let exact = if from * to < 0.0 {
                let turn = from / (from - to) * h;
                along(along(z, 0.0, from * turn / 2.0), 0.0, to * (h - turn) / 2.0)
            } else {
                along(z, 0.0, (from + to) / 2.0 * h)
            };
            close(step.deflection, exact, 1e-18, &format!("{from} {to} {h} {z}"));
            for closure in closures {
                close(closure.deflection, exact, 1e-18, &format!("{from} {to} {h} {z}, closure"));
            }
            close(step.end, 3e4 * exact, 1e-13, "force");
        }
    }
}

#[test]
fn a_smooth_curve_without_reversal_is_not_split_and_one_that_dips_is() {
    // The velocity is negative for a while between two nodes of any of the methods.
    let contact = dahl();
    for bottom in [1e-6, -1e-6] {
        let v = |s: f64| 1e-3 * (s - 0.4) * (s - 0.4) + bottom;
        let step = Exponential::<4>.step(&contact, v, 2e-5, 1.0);
        // ∫v, from reversal to reversal.
        let x = |s: f64| 1e-3 * (s - 0.4_f64).powi(3) / 3.0 + bottom * s;
        let exact = if bottom < 0.0 {
            let half = (-bottom / 1e-3_f64).sqrt();
            let (a, b) = (0.4 - half, 0.4 + half);
            along(along(along(2e-5, x(0.0), x(a)), x(a), x(b)), x(b), x(1.0))
        } else {
            along(2e-5, x(0.0), x(1.0))
        };
        close(step.deflection, exact, 1e-18, &format!("{bottom}"));
    }
}

#[test]
fn kinks_and_jumps_of_the_velocity_cost_nothing() {
    let contact = dahl();
    let corner = |time, value| Vertex { time, value };
    let velocity = Polyline::new([
        corner(0.0, 0.001),
        corner(0.3, 0.003),
        corner(0.7, -0.002),
        corner(0.9, -0.002),
        corner(1.0, 0.0),
    ])
    .unwrap();
    // Ways between corners and reversal (at 0.54 s) by the trapezium rule.
    let ways = [0.0006, 0.003 * 0.24 / 2.0, -0.002 * 0.16 / 2.0, -0.0004, -0.0001];
    let exact = ways.iter().fold(5e-5, |z, &way| along(z, 0.0, way));
    let adaptive = Exponential::<3>.adaptive(1e-3).unwrap();
    for solver in [adaptive, Exponential.fixed(0.37).unwrap()] {
        let mut run = solver.begin(&contact, &velocity, 0.0..2.0, 5e-5).unwrap();
        while run.advance().unwrap().is_some() {}
        // z_ss is constant and λ linear: exact to rounding, whatever the step.
        close(run.deflection(), exact, 1e-18, "corners");
        assert_eq!((run.time(), run.statistics().reversals), (2.0, 1));
    }
    // A jump that turns the direction, and one that keeps it and is met by no node before it.
    for (before, after) in [(0.002, -0.001), (0.0002, 0.0007)] {
        let jump = Function::new(|t: f64| (if t < 0.25 { before } else { after }, 0.0), [0.25]);
        let exact = along(along(0.0, 0.0, 0.25 * before), 0.0, 0.1 * after);
        let fixed = [0.1, 0.25, 1.0].map(|step| Exponential.fixed(step).unwrap());
        for solver in fixed.into_iter().chain([adaptive]) {
            let mut run = solver.begin(&contact, &jump, 0.0..0.35, 0.0).unwrap();
            while run.advance().unwrap().is_some() {}
            close(run.deflection(), exact, 1e-18, &format!("jump to {after}"));
        }
    }
}

#[test]
fn the_curve_passes_an_extreme_of_the_stationary_deflection_between_the_nodes() {
    // The deflection comes close to z_ss where that has its maximum, at the slowest sliding.
    let velocity = sine(0.0055, 0.005, 50.0, 0.0);
    let [coarse, fine] = [160.0, 1600.0]
        .map(|steps| sampled(Exponential::<6>.fixed(0.4 / steps).unwrap(), &velocity, 0.4, 2001).0);
    // Eight steps a period of local order 8 leave 4e-9; a curve cut to the z_ss at the nodes, 4e-7.
    assert!(apart(&coarse, &fine) < 2e-8, "{:e}", apart(&coarse, &fine));
}

#[test]
fn a_constant_velocity_gives_the_exact_hold() {
    for specimen in specimens::<f64>(&Recipe::TABLE_2) {
        if specimen.freezes() {
            continue; // the hold of an α above one at every node is the same, below it is not
        }
        let contact = specimen.model().under_load(1.0).unwrap();
        for v in [1e-6, -3e-3, 0.02, -1.5, 0.0] {
            for z in [0.0, 1e-4, -3e-4] {
                for h in [1e-9, 1e-5, 1e-3, 0.03, 1.0, 1e3] {
                    let wanted = contact.hold(v, z, h);
                    let found = Exponential::<4>.step(&contact, |_| v, z, h);
                    let what = format!("{} {v} {z} {h}", specimen.name());
                    // A rounding of z, of z_ss, and of what is added to them.
                    let size =
                        1e-14 * (z.abs() + wanted.deflection.abs() + contact.stationary(v).abs());
                    close(found.deflection, wanted.deflection, size, &what);
                    let affine = contact.model().affine(v.into(), z);
                    let force = affine.stiffness.abs() * size + 1e-14 * (affine.damping * v).abs();
                    close(found.end, wanted.end_force, force, &what);
                    close(found.mean, wanted.mean_force, force, &what);
                    close(found.work, wanted.mean_force * v * h, force * (v * h).abs(), &what);
                    let ramp = Exponential::<3>.ramp(&contact, v..v, z, h);
                    close(ramp.deflection, wanted.deflection, size, &what);
                }
            }
        }
    }
}

#[test]
fn a_stuck_bristle_follows_the_body_to_rounding() {
    let contact = friction();
    let resting = Exponential::<5>.step(&contact, |_| 0.0, 4e-5, 1e3);
    assert_eq!((resting.deflection, resting.work), (4e-5, 0.0));
    // So slow that σ1|v| is below a rounding of μ, and λ z of v: ż = v.
    for fastest in [1e-300, 1e-25, 1e-19] {
        let h = 1e-3;
        // ∫ (1 + 2s − 4s³ + s⁶) ds = 1 + 1/7 over the unit step.
        let v = |s: f64| fastest * (1.0 + 2.0 * s - 4.0 * s * s * s + s.powi(6));
        let exact = fastest * h * (8.0 / 7.0);
        for found in [
            Exponential::<4>.step(&contact, v, 0.0, h).deflection,
            Exponential::<6>.step(&contact, v, 0.0, h).deflection,
            Exponential::<8>.step(&contact, v, 0.0, h).deflection,
        ] {
            // Roundings of the places, of v there, and of the sum.
            close(found, exact, exact * 2e-15, &format!("{fastest:e}"));
        }
    }
}

#[test]
fn a_stiff_bristle_ends_at_the_stationary_deflection_to_rounding() {
    for specimen in specimens::<f64>(&Recipe::TABLE_2) {
        if specimen.freezes() {
            continue;
        }
        let contact = specimen.model().under_load(1.0).unwrap();
        let v = |s: f64| -0.02 - 0.01 * s * s;
        let wanted = contact.stationary(v(1.0));
        // λ > 1 1/s at these speeds, so λh > 1e15 … 1e20 and what lags behind is below a rounding.
        for (z, h) in [(0.0, 1e18), (-1e-4, 1e20), (5e-4, 1e18), (5e-4, 1e20)] {
            let ends = [
                Exponential::<3>.step(&contact, v, z, h),
                Exponential::<6>.step(&contact, v, z, h),
                Exponential::<4>.ramp(&contact, 0.05..-0.03, z, h),
            ];
            for end in ends {
                let tolerance = 4.0 * f64::EPSILON * wanted.abs();
                close(end.deflection, wanted, tolerance, &specimen.name());
            }
        }
    }
}

#[test]
fn no_step_of_any_length_leaves_the_bound() {
    let strategy = (
        recipe(),
        -1.0..=1.0,
        0.0..=4.0,
        decades(1e-7, 1e2),
        prop::collection::vec(decades(1e-9, 1e3), 6),
        prop::collection::vec(prop::array::uniform4(-1.0..=1.0), 6),
        0.0..6.0,
    );
    check(if cfg!(debug_assertions) { 24 } else { 200 }, strategy, |case| {
        let (recipe, fraction, wide, speed, lengths, coefficients, waves): Case = case;
        for specimen in specimens::<f64>(&recipe) {
            if specimen.freezes() || !specimen.subject.model().obeys(Law::BoundedDeflection) {
                continue;
            }
            let contact = specimen.model().under_load(1.0).unwrap();
            // |a + b s + c s² + d sin| ≤ 4; the velocities met are among these.
            let fastest = 4.0 * speed;
            let Some(limit) = contact.limits(fastest).deflection else { continue };
            // Roundings of μ/σ0, by a handful of sums, products and powers on either side.
            let bound = |z: f64| f64::max(limit, z.abs()) * (1.0 + 1e-13);
            for start in [fraction, fraction * wide] {
                let mut z: f64 = start * limit;
                for (&h, [a, b, c, d]) in lengths.iter().zip(&coefficients) {
                    let v = |s: f64| speed * (a + b * s + c * s * s + d * (waves * s).sin());
                    let ramp = v(0.0)..v(1.0);
                    let steps = [
                        Exponential::<4>.step(&contact, v, z, h),
                        Exponential::<2>.step(&contact, v, z, h),
                        Exponential::<3>.ramp(&contact, ramp, z, h),
                    ];
                    for step in steps {
                        let name = specimen.name();
                        assert!(step.deflection.abs() <= bound(z), "{name} {h} {z:e} {step:?}");
                        // The law of the bounded force holds for the mean too.
                        if z.abs() <= limit && specimen.subject.model().obeys(Law::BoundedForce) {
                            let most = contact.limits(fastest).force.unwrap();
                            let most = most * (1.0 + 1e-12);
                            assert!(step.mean.abs() <= most, "{name} {h} {z:e} {step:?} {most:e}");
                        }
                    }
                    z = steps[0].deflection;
                }
            }
        }
    });
}

type Case = (Recipe, f64, f64, f64, Vec<f64>, Vec<[f64; 4]>, f64);

#[test]
fn single_precision_loses_nothing_but_digits() {
    let wide = table_2_frbd().under_load(1.0).unwrap();
    let narrow = table_2_frbd().under_load(1.0).unwrap();
    let (mut a, mut b) = (0.0_f64, 0.0_f32);
    for n in 0..400_u16 {
        let v = |n: u16| 0.01 * (f64::from(n) * 0.07).sin();
        let (from, to) = (v(n), v(n + 1));
        let one = Exponential::<3>.ramp(&wide, from..to, a, 1e-3);
        let velocities = from as f32..to as f32;
        let other = Exponential::<3>.ramp(&narrow, velocities, b, 1e-3);
        // Roundings of f32, as many as steps that are not yet forgotten.
        close(f64::from(other.deflection), one.deflection, 20.0 * 1.2e-7 * BREAKAWAY, "deflection");
        close(f64::from(other.mean), one.mean, 40.0 * 1.2e-7 * 1.5, "mean");
        (a, b) = (one.deflection, other.deflection);
    }
    let sine =
        Sine::new(SineParameters { mean: 0.0_f32, amplitude: 0.01, frequency: 5.0, phase: 0.0 });
    let solver = Exponential::<4>.adaptive(1e-4_f32).unwrap();
    let mut largest = 0.0;
    let statistics = solver
        .sample(&narrow, &sine.unwrap(), 0.0..1.0, 0.0, 101, |_, z| largest = f32::max(largest, z))
        .unwrap();
    assert!(
        (1e-4..1.5e-4).contains(&largest) && statistics.reversals >= 9,
        "{largest} {statistics}"
    );
}

#[test]
fn what_is_not_a_number_stays_one() {
    let contact = friction();
    let nan = f64::NAN;
    let all = |step: StepSummary<f64>| {
        [step.deflection, step.end, step.mean, step.work].iter().all(|value| value.is_nan())
    };
    assert!(all(Exponential::<4>.step(&contact, |_| 0.01, nan, 1e-3)));
    assert!(all(Exponential::<4>.step(&contact, |_| nan, 1e-5, 1e-3)));
    assert!(all(Exponential::<4>.step(&contact, |s| if s < 0.5 { 0.01 } else { nan }, 1e-5, 1e-3)));
    for duration in [nan, -1e-3] {
        assert!(all(Exponential::<4>.step(&contact, |_| 0.01, 1e-5, duration)));
        let ramp = -0.02..0.1;
        assert!(all(Exponential::<3>.ramp(&contact, ramp, 1e-5, duration)));
    }
    for (from, to) in [(nan, 0.1), (0.1, nan), (nan, nan)] {
        assert!(all(Exponential::<3>.ramp(&contact, from..to, 1e-5, 1e-3)));
    }
    // A velocity that jumps about ends as a number or as none, but it ends.
    let rough = |s: f64| ((s * 1e15).sin() * 1e4).sin();
    let _ = Exponential::<4>.step(&contact, rough, 1e-5, 1e-3);
}

#[test]
fn a_run_refuses_what_it_cannot_do_and_says_where_it_stopped() {
    let contact = friction();
    let constant = 0.01;
    assert!(Exponential::<4>.adaptive(0.0).is_err() && Exponential::<4>.fixed(f64::NAN).is_err());
    let solver = Exponential::<4>.adaptive(1e-6).unwrap();
    assert!(solver.with_largest_step(-1.0).is_err());
    let refused = |span: core::ops::Range<f64>, z: f64, samples| {
        let failure = solver.sample(&contact, &constant, span, z, samples, |_, _| {}).unwrap_err();
        matches!(failure.reason, StopReason::Refused(_))
    };
    assert!(refused(1.0..0.0, 0.0, 5) && refused(0.0..f64::INFINITY, 0.0, 5));
    assert!(refused(0.0..1.0, f64::NAN, 5) && refused(0.0..1.0, 0.0, 1));
    assert!(refused(0.0..5e-324, 0.0, 5) && refused(0.0..1e-310, 0.0, 5));
    let short = solver.with_largest_step(1e-90).unwrap();
    let failure = short.sample(&contact, &constant, 0.0..1.0, 0.0, 5, |_, _| {}).unwrap_err();
    assert!(failure.to_string().contains("largest_step is 1e-90"), "{failure}");
    let few = solver.with_most_steps(3);
    let wave = sine(0.0, 0.01, 5.0, 0.0);
    let failure = few.sample(&contact, &wave, 0.0..9.0, 0.0, 5, |_, _| {}).unwrap_err();
    assert_eq!(failure.reason, StopReason::TooManySteps { limit: 3 });
    let broken = Function::new(|t: f64| (if t < 0.5 { 0.01 } else { f64::NAN }, 0.0), []);
    let failure = solver.sample(&contact, &broken, 0.0..1.0, 0.0, 5, |_, _| {}).unwrap_err();
    assert!(failure.time < 0.5 && failure.time > 0.49, "{failure}");
    assert_eq!(failure.reason, StopReason::VelocityNotFinite { contact: 0 });
    let solver = Exponential::<4>.fixed(0.1).unwrap();
    let failure = solver.sample(&contact, &broken, 0.0..1.0, 0.0, 5, |_, _| {}).unwrap_err();
    assert_eq!(failure.reason, StopReason::VelocityNotFinite { contact: 0 });
}

#[test]
fn samples_lie_where_they_should_and_the_curve_joins_the_ends() {
    let contact = friction();
    let wave = sine(0.0, 0.01, 5.0, 0.0);
    let solver = Exponential::<5>.adaptive(1e-8).unwrap();
    let mut times = Vec::new();
    solver.sample(&contact, &wave, 0.25..1.25, 1e-5, 11, |time, _| times.push(time)).unwrap();
    let wanted: Vec<f64> = (0..11).map(|i| 0.25 + 0.1 * f64::from(i)).collect();
    assert_eq!(times.len(), 11);
    assert!(times.iter().zip(&wanted).all(|(a, b)| (a - b).abs() < 1e-15), "{times:?}");
    assert_eq!((times[0], times[10]), (0.25, 1.25));
    let mut run = solver.begin(&contact, &wave, 0.25..1.25, 1e-5).unwrap();
    let (mut time, mut deflection) = (0.25, 1e-5);
    while let Some(piece) = run.advance().unwrap() {
        assert_eq!((piece.start_time(), piece.start()), (time, deflection));
        assert_eq!((piece.at(time), piece.at(piece.end_time())), (deflection, piece.end()));
        (time, deflection) = (piece.end_time(), piece.end());
        close(piece.summary().end, contact.force(wave.value(time), deflection), 1e-12, "force");
    }
    assert_eq!((time, run.time()), (1.25, 1.25));
    // A span of no length.
    let mut list = Vec::new();
    solver.sample(&contact, &wave, 1.0..1.0, 1e-5, 3, |t, z| list.push((t, z))).unwrap();
    assert_eq!(list, [(1.0, 1e-5); 3]);
}
