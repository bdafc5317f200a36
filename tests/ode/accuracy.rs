//! How accurate the integrators are: golden states, the order measured by halving the step, and
//! what an adaptive run makes of its tolerances.
#![cfg(feature = "alloc")]

use bristle::curve::Stribeck;
use bristle::ode::{DormandPrince, Output, RungeKutta4, Solver, System, Tolerances};
use bristle::rheology::KelvinVoigt;
use bristle::scene::{DiaphragmValve, MassSpringDamper, PrescribedVelocity};
use bristle::signal::{Polyline, Vertex};
use bristle::{Branch, Bristle, FrBd, paper};
use bristle_specimens::ode::{
    OfAny, Oscillator, Swing, dahl, every_method, every_solver, observed_order, rig, stick_slip,
    table_2_frbd, table_2_lugre, tolerance,
};
use nalgebra::{SVector, Vector1, Vector3};

/// Position, velocity and deflection of the stick-slip rig at t = 25 s. They were found without the
/// library: by the classical Runge–Kutta method in C at 5 µs, where 10 µs give the same digits, and
/// by adaptive solvers of three other codes at tolerances of 1e-13.
const FRBD: [f64; 3] = [2.231_433_760_84, 0.245_259_15, 1.009_939_48e-4];
const LUGRE: [f64; 3] = [2.234_089_300_2, 0.234_890_9, 1.000_0e-4];

fn at_25_seconds<M: Bristle<f64, Deflection = f64>>(
    rig: &MassSpringDamper<f64, M>,
) -> Vector3<f64> {
    let tolerances = Tolerances::scaled(1e-10, rig.scales()).unwrap();
    let solver = OfAny::checked(DormandPrince, tolerances);
    let run = solver.solve(rig, 0.0..25.0, rig.at_rest(), Output::Uniform(2)).unwrap();
    *run.last().unwrap().1
}

#[test]
fn stick_slip_with_frbd_reaches_the_reference_state() {
    let state = at_25_seconds(&stick_slip());
    // The tolerance of 1e-10 grows about tenfold over six slips; then the digits printed.
    assert!((state[0] - FRBD[0]).abs() < 1e-8, "x = {}", state[0]);
    assert!((state[1] - FRBD[1]).abs() < 1e-8, "v = {}", state[1]);
    assert!((state[2] - FRBD[2]).abs() < 1e-12, "z = {}", state[2]);
}

#[test]
fn stick_slip_with_lugre_reaches_the_reference_state() {
    let state = at_25_seconds(&rig(table_2_lugre(), 0.1));
    assert!((state[0] - LUGRE[0]).abs() < 1e-8, "x = {}", state[0]);
    assert!((state[1] - LUGRE[1]).abs() < 1e-7, "v = {}", state[1]);
    // At 23 times the Stribeck velocity the bristle is at its stationary μ_d/σ0.
    assert!((state[2] - LUGRE[2]).abs() < 1e-12, "z = {}", state[2]);
}

/// Dahl's bristle swung to and fro. In ten seconds it reverses six times; it forgets at up to
/// 10 1/s, so that the steps below lie between an asymptotic 0.05 s and the rounding.
const SWING: Swing = Swing { amplitude: 1.0, angular: 2.0, phase: 0.3 };
const SPAN: f64 = 10.0;

/// The largest error of the Dahl problem over some output, for a step halved from 0.05 s, or for a
/// method of high order from 0.2 s.
fn dahl_errors<M: bristle::ode::Method<f64, 1>>(
    method: &M,
    order: f64,
    halvings: i32,
    locked: bool,
    output: Output<'_, f64>,
) -> Vec<(f64, f64)> {
    let bristle = PrescribedVelocity::new(dahl(), SWING);
    (0..=halvings)
        .map(|k| {
            let step = if order > 6.0 { 0.2 } else { 0.05 } / 2f64.powi(k);
            let solver = OfAny::fixed(*method, step).unwrap();
            let solver = if locked { solver } else { solver.plain() };
            let run = solver.solve(&bristle, 0.0..SPAN, Vector1::new(0.0), output).unwrap();
            let error = run.iter().map(|(t, z)| (z[0] - SWING.deflection(t)).abs());
            (step, error.fold(0.0, f64::max))
        })
        .collect()
}

/// A fit over halvings from a step that is only nearly asymptotic: up to half an order too high
/// (one for order 8, whose leading coefficient is tiny), never as low as the order below.
#[track_caller]
fn assert_order(what: &str, points: &[(f64, f64)], order: f64) {
    // Rounding is 1e-16 in each of some hundred steps.
    let above: Vec<_> = points.iter().copied().filter(|(_, error)| *error > 3e-14).collect();
    assert!(above.len() >= 2, "{what}: nothing to tell the order from, {points:?}");
    let observed = observed_order(&above);
    assert!(
        observed > order - 0.2 && observed < order + if order > 6.0 { 1.1 } else { 0.5 },
        "{what}: order {observed} instead of {order}, {points:?}"
    );
}

#[test]
fn the_order_of_a_method_survives_reversals() {
    every_method!(|name, method, order, dense| {
        // Three halvings: the error of order 5 ends at 2e-12, far above the rounding of 1e-16.
        assert_order(name, &dahl_errors(&method, order, 3, true, Output::Steps), order);
    });
}

#[test]
fn the_plain_method_loses_its_order_at_reversals() {
    every_method!(|name, method, order, dense| {
        let points = dahl_errors(&method, order, 5, false, Output::Steps);
        let observed = observed_order(&points);
        // A kink of the field within a step is an error of second order, whatever the method.
        assert!(observed < 3.0, "{name}: {observed}");
        let locked = dahl_errors(&method, order, 5, true, Output::Steps);
        assert!(points[5].1 > 100.0 * locked[5].1, "{name}: {points:?} {locked:?}");
    });
}

#[test]
fn the_dense_output_keeps_its_order_across_reversals() {
    every_method!(|name, method, order, dense| {
        assert_order(name, &dahl_errors(&method, order, 3, true, Output::Uniform(2001)), dense);
    });
}

#[test]
fn the_dense_output_has_its_order_on_a_smooth_problem() {
    every_method!(|name, method, order, dense| {
        let errors: Vec<_> = [0.4, 0.2, 0.1, 0.05]
            .iter()
            .map(|&step| {
                let solver = OfAny::fixed(method, step).unwrap();
                let start = Oscillator::exact(0.0);
                let run = solver.solve(&Oscillator, 0.0..2.0, start, Output::Uniform(2001));
                let run = run.unwrap();
                let error = run.iter().map(|(t, x)| (x - Oscillator::exact(t)).norm());
                (step, error.fold(0.0, f64::max))
            })
            .collect();
        assert_order(name, &errors, dense);
    });
}

#[test]
fn runge_kutta_converges_at_order_four_to_the_reference_state() {
    let rig = stick_slip();
    // Below 1 ms the digits of the golden value end; above 4 ms the stuck mass (100 rad/s) is no
    // longer asymptotic.
    let errors: Vec<_> = [4e-3, 2e-3, 1e-3]
        .iter()
        .map(|&step| {
            let solver = OfAny::fixed(RungeKutta4, step).unwrap();
            let run = solver.solve(&rig, 0.0..25.0, rig.at_rest(), Output::Uniform(2)).unwrap();
            (step, (run.last().unwrap().1[0] - FRBD[0]).abs())
        })
        .collect();
    assert_order("stick-slip", &errors, 4.0);
    assert!(errors[2].1 < 2e-9, "{errors:?}");
}

#[test]
fn a_tighter_tolerance_gives_a_smaller_error() {
    let bristle = PrescribedVelocity::new(dahl(), SWING);
    let error = |relative: f64| {
        let tolerances = Tolerances::scaled(relative, bristle.scales()).unwrap();
        let solver = OfAny::checked(DormandPrince, tolerances);
        let run = solver.solve(&bristle, 0.0..SPAN, Vector1::new(0.0), Output::Uniform(2001));
        let run = run.unwrap();
        let error = run.iter().map(|(t, z)| (z[0] - SWING.deflection(t)).abs());
        error.fold(0.0, f64::max) / bristle.scales()[0]
    };
    let tolerances = [1e-5, 1e-7, 1e-9];
    let errors = tolerances.map(error);
    for (tolerance, error) in tolerances.iter().zip(errors) {
        // The bristle forgets, so that errors do not add up; the dense output has no estimate of
        // its own.
        assert!(error < 10.0 * tolerance, "{tolerances:?} gives {errors:?}");
        // Nor is it much more accurate than asked: that would be work for nothing.
        assert!(error > 1e-3 * tolerance, "{tolerances:?} gives {errors:?}");
    }
    for pair in errors.windows(2) {
        // Two decades of tolerance; the error of order 5 follows in proportion.
        assert!(pair[1] < 0.1 * pair[0], "{errors:?}");
    }
}

#[test]
fn the_work_grows_with_the_fifth_root_of_the_tolerance() {
    let steps = [1e-5, 1e-10].map(|relative| {
        let solver = OfAny(Solver::adaptive(DormandPrince, tolerance(relative)));
        let run = solver.solve(&Oscillator, 0.0..30.0, Oscillator::exact(0.0), Output::Uniform(2));
        let statistics = run.unwrap().statistics();
        // On a problem that does not change, the controller hardly ever guesses wrong.
        assert!(statistics.rejected <= 3, "{statistics}");
        statistics.steps as f64
    });
    // 10⁵ to the power 1/5 is 10.
    let ratio = steps[1] / steps[0];
    assert!(ratio > 8.0 && ratio < 12.0, "{steps:?}");
}

/// A pressure of 1e5 that settles in half a minute beside a vibration of 1e-6 at 10 rad/s.
#[derive(Debug)]
struct TwoScales;

impl System<f64, 3, 0> for TwoScales {
    fn rate(&self, _: f64, x: &Vector3<f64>, _: [Branch; 0]) -> Vector3<f64> {
        Vector3::new(-0.03 * x[0], x[2], -100.0 * x[1])
    }

    fn sliding_velocities(&self, _: f64, _: &Vector3<f64>) -> [f64; 0] {
        []
    }

    fn scales(&self) -> Vector3<f64> {
        Vector3::new(1e5, 1e-6, 1e-5)
    }
}

#[test]
fn a_small_state_beside_a_large_one_keeps_its_own_accuracy() {
    // Errors in parts of each state's own size, after five periods of the vibration.
    let errors = |relative: f64, scales: Vector3<f64>| {
        let solver = OfAny::checked(DormandPrince, Tolerances::scaled(relative, scales).unwrap());
        let start = Vector3::new(1e5, 1e-6, 0.0);
        let run = solver.solve(&TwoScales, 0.0..3.0, start, Output::Uniform(2)).unwrap();
        let state = run.last().unwrap().1;
        let exact = Vector3::new(1e5 * (-0.09f64).exp(), 1e-6 * 30f64.cos(), -1e-5 * 30f64.sin());
        (state - exact).component_div(&TwoScales.scales()).abs()
    };
    let own = errors(1e-6, TwoScales.scales());
    // Thirty steps or so, each off by one tolerance at most.
    assert!(own.max() < 1e-4, "{own}");
    // The same number for all three is tight for the pressure and nothing for the vibration.
    let same = errors(1e-3, Vector3::repeat(1.0));
    assert!(same[0] < 1e-6 && same[1] > 0.03, "{same}");
}

#[test]
fn the_relative_tolerance_belongs_to_its_own_component_too() {
    // Absolute tolerances out of play: each state's error follows its own relative one.
    let error = |relative: Vector3<f64>| {
        let tolerances = Tolerances::new(relative, Vector3::repeat(1e-14));
        let solver = OfAny::checked(DormandPrince, tolerances.unwrap());
        let start = Vector3::new(1e5, 1e-6, 0.0);
        let run = solver.solve(&TwoScales, 0.0..3.0, start, Output::Uniform(2)).unwrap();
        (run.last().unwrap().1[1] - 1e-6 * 30f64.cos()).abs() / 1e-6
    };
    let tight = error(Vector3::new(1e-2, 1e-8, 1e-8));
    let loose = error(Vector3::new(1e-8, 1e-2, 1e-2));
    assert!(tight < 1e-8 && loose > 20.0 * tight, "{tight:e} {loose:e}");
}

#[test]
fn the_valve_is_integrated_without_chatter() {
    // Table 3 of the paper, opening by 10 % per second from a balanced state.
    let (curve, bristle) =
        (Stribeck::new(paper::VALVE_CURVE), KelvinVoigt::new(paper::VALVE_BRISTLE));
    let contact = FrBd::new(curve.unwrap(), bristle.unwrap()).under_load(1.0).unwrap();
    let ramp =
        Polyline::new([Vertex { time: 0.0, value: 10.0 }, Vertex { time: 9.0, value: 100.0 }]);
    let valve = DiaphragmValve::new(paper::valve(contact, 0.933, ramp.unwrap())).unwrap();
    let run = |relative: f64| {
        let tolerances = Tolerances::scaled(relative, valve.scales()).unwrap();
        let solver = OfAny::checked(DormandPrince, tolerances);
        let run = solver.solve(&valve, 0.0..1.5, valve.balanced(0.0), Output::Uniform(2)).unwrap();
        (*run.last().unwrap().1, run.statistics())
    };
    let (state, statistics) = run(1e-6);
    let (reference, _) = run(1e-9);
    // The stem only ever moves one way: every reversal is noise at rest.
    assert!(statistics.reversals * 20 < statistics.steps, "{statistics}");
    assert!(statistics.rejected * 10 < statistics.steps, "{statistics}");
    // The stuck stem swings at √(σ0 p/m) = 6529 rad/s, at which this method is stable up to
    // 3.3/6529 = 0.5 ms: 3000 steps while it sticks, and fewer for the part in which it slides.
    assert!(statistics.steps > 500 && statistics.steps < 5000, "{statistics}");
    let error = (state - reference).component_div(&valve.scales()).abs();
    assert!(error.max() < 1e-5, "{error}");
    // It did come loose.
    assert!(state[1] > 1e-3, "the stem slides at {} m/s", state[1]);
}

#[test]
fn single_precision_runs_the_rig_to_its_own_accuracy() {
    let rig = stick_slip::<f32>();
    let tolerances = Tolerances::scaled(1e-4, rig.scales()).unwrap();
    let solver = OfAny::checked(DormandPrince, tolerances);
    let run = solver.solve(&rig, 0.0..25.0, rig.at_rest(), Output::Uniform(2)).unwrap();
    // Twenty tolerances, as in double precision.
    let error = run.last().unwrap().1[0] - FRBD[0] as f32;
    assert!(error.abs() < 2e-3, "{error}");

    let steps = 12_500;
    let solver = OfAny::fixed(RungeKutta4, 2e-3).unwrap();
    let run = solver.solve(&rig, 0.0..25.0, rig.at_rest(), Output::Uniform(2)).unwrap();
    // A position of 2 rounded to 1.2e-7 at each of 12500 steps: at random 3e-5, at worst 3e-3.
    let error = run.last().unwrap().1[0] - FRBD[0] as f32;
    assert!(error.abs() < 3e-4, "{error}");
    let split = run.statistics().reversals;
    assert_eq!(run.statistics().steps, steps + split, "the grid of a fixed step is not split");
}

type Rig = MassSpringDamper<f64, FrBd<Stribeck<f64>, KelvinVoigt<f64>>>;

/// Two rigs that know nothing of each other.
#[derive(Debug)]
struct TwoRigs(Rig, Rig);

impl System<f64, 6, 2> for TwoRigs {
    fn rate(&self, time: f64, state: &SVector<f64, 6>, [a, b]: [Branch; 2]) -> SVector<f64, 6> {
        let first = self.0.rate(time, &state.fixed_rows::<3>(0).into_owned(), [a]);
        let second = self.1.rate(time, &state.fixed_rows::<3>(3).into_owned(), [b]);
        let [x, y] = [first, second];
        SVector::from([x[0], x[1], x[2], y[0], y[1], y[2]])
    }

    fn sliding_velocities(&self, _: f64, state: &SVector<f64, 6>) -> [f64; 2] {
        [state[1], state[4]]
    }

    fn scales(&self) -> SVector<f64, 6> {
        let [x, y] = [self.0.scales(), self.1.scales()];
        SVector::from([x[0], x[1], x[2], y[0], y[1], y[2]])
    }
}

#[test]
fn two_contacts_in_one_system_slide_as_they_do_alone() {
    // Different drives, one of them backward, so that their reversals interleave.
    let two = TwoRigs(rig(table_2_frbd(), 0.1), rig(table_2_frbd(), -0.17));
    // Both stuck, half a second before they slip.
    let starts = [Vector3::new(-0.7, 0.0, 1.4e-4), Vector3::new(0.65, 0.0, -1.3e-4)];
    let start = SVector::from_fn(|i, _| starts[i / 3][i % 3]);
    let end = 5.0;
    let alone = [(&two.0, starts[0]), (&two.1, starts[1])].map(|(rig, start)| {
        let solver =
            OfAny::checked(DormandPrince, Tolerances::scaled(1e-10, rig.scales()).unwrap());
        let run = solver.solve(rig, 0.0..end, start, Output::Uniform(49)).unwrap();
        assert!(run.statistics().reversals > 0);
        run
    });
    every_solver!(7e-4, Tolerances::scaled(1e-8, two.scales()).unwrap(), |name, solver| {
        let run = solver.solve(&two, 0.0..end, start, Output::Uniform(49)).unwrap();
        let mut reversals = 0;
        for (offset, rig, single) in [(0, &two.0, &alone[0]), (3, &two.1, &alone[1])] {
            reversals += single.statistics().reversals;
            for ((t, both), (_, one)) in run.iter().zip(single.iter()) {
                let error = both.fixed_rows::<3>(offset) - one;
                let error = error.component_div(&rig.scales()).abs().max();
                // A hundred tolerances of 1e-8 (six for one rig after 25 s, more within a slip),
                // and as much for the fixed step of 0.7 ms.
                assert!(error < 1e-6, "{name}: {error:e} at {t} s");
            }
        }
        assert_eq!(run.statistics().reversals, reversals, "{name}");
    });
}

#[test]
fn a_mirrored_rig_moves_in_mirror_image() {
    // Both directions of sliding are the same physics, hence the same arithmetic.
    every_solver!(
        5e-3,
        Tolerances::scaled(1e-6, stick_slip::<f64>().scales()).unwrap(),
        |name, solver| {
            let run = |drive: f64| {
                let rig = rig(table_2_frbd(), drive);
                solver.solve(&rig, 0.0..9.0, rig.at_rest(), Output::Uniform(19)).unwrap()
            };
            let (forward, backward) = (run(0.1), run(-0.1));
            for ((_, a), (_, b)) in forward.iter().zip(backward.iter()) {
                assert_eq!(*a, -b, "{name}");
            }
            // At rest the first direction is a guess, which costs a trial if it is wrong.
            assert_eq!(forward.statistics().steps, backward.statistics().steps, "{name}");
        }
    );
}

#[test]
fn the_scales_of_the_rig_are_the_size_of_its_states() {
    // The scales are what the tolerances above rest on: a run's extremes are within a decade.
    let rig = stick_slip::<f64>();
    let solver = OfAny::checked(DormandPrince, Tolerances::scaled(1e-6, rig.scales()).unwrap());
    let run = solver.solve(&rig, 0.0..25.0, rig.at_rest(), Output::Uniform(2001)).unwrap();
    let stretch = run.iter().map(|(t, x)| (rig.spring_force(t, x) / 2.0).abs());
    let extremes = [
        stretch.fold(0.0, f64::max),
        run.iter().map(|(_, x)| x[1].abs()).fold(0.0, f64::max),
        run.iter().map(|(_, x)| x[2].abs()).fold(0.0, f64::max),
    ];
    for (extreme, scale) in extremes.iter().zip(&rig.scales()) {
        assert!(extreme / scale > 0.1 && extreme / scale < 10.0, "{extremes:?}");
    }
}
