//! What a run stores: samples where they were asked for, steps that fill the span and nothing
//! else, forward and backward in time.
#![cfg(feature = "alloc")]

use bristle::Branch;
use bristle::ode::{DormandPrince, Linearisation, Output, RungeKutta4, Solver, System};
use bristle::scene::PrescribedVelocity;
use bristle::signal::{Polyline, Vertex};
use bristle_specimens::ode::{
    Counted, Integral, OfAny, Oscillator, Sided, Swing, but_evaluations, dahl, every_method,
    every_solver, tolerance,
};
use nalgebra::{Matrix1, Vector1, Vector2};

/// RK4 at 0.05: h⁴/120 = 5e-8 per radian over ten of them, and h⁴/384 between steps.
const STEP: f64 = 0.05;
const TOLERANCE: f64 = 1e-9;
const ERROR: f64 = 1e-6;

#[test]
fn uniform_samples_include_both_ends_and_lie_on_the_solution() {
    // Spans and counts of which no quotient is a multiple of a step.
    for (from, to) in [(0.0, 7.3), (-2.1, 5.9), (93.0, 100.0)] {
        for samples in [2, 3, 10, 97, 1001] {
            every_solver!(STEP, tolerance(TOLERANCE), |name, solver| {
                let start = Oscillator::exact(from);
                let run = solver.solve(&Oscillator, from..to, start, Output::Uniform(samples));
                let run = run.unwrap();
                assert_eq!(run.times().len(), samples, "{name}");
                assert_eq!(run.states().len(), samples, "{name}");
                assert_eq!(run.times()[0], from, "{name}");
                assert_eq!(run.states()[0], start, "{name}");
                assert_eq!(run.times()[samples - 1], to, "{name}");
                for (i, (time, state)) in run.iter().enumerate() {
                    let even = from + (to - from) * i as f64 / (samples - 1) as f64;
                    // Rounding of a time of 100.
                    assert!((time - even).abs() < 1e-13, "{name}: {time} {even}");
                    let error = (state - Oscillator::exact(time)).norm();
                    assert!(error < ERROR, "{name}: {error:e} at {time}");
                }
            });
        }
    }
}

#[test]
fn samples_between_reversals_lie_on_the_solution() {
    let swing = Swing { amplitude: 0.5, angular: 2.0, phase: 0.3 };
    let bristle = PrescribedVelocity::new(dahl(), swing);
    every_solver!(0.013, tolerance(1e-10), |name, solver| {
        let run = solver.solve(&bristle, 0.0..10.0, Vector1::new(0.0), Output::Uniform(1234));
        for (time, state) in run.unwrap().iter() {
            // RK4 at a fifteenth of the bristle's 5 1/s: 1e-8, a thousandth of that for order 5.
            let error = (state[0] - swing.deflection(time)).abs();
            assert!(error < 3e-8, "{name}: {error:e} at {time}");
        }
    });
}

#[test]
fn the_last_state_does_not_depend_on_what_is_stored() {
    every_solver!(STEP, tolerance(1e-6), |name, solver| {
        let start = Oscillator::exact(0.0);
        let end = |output: Output<'_, f64>| {
            let run = solver.solve(&Oscillator, 0.0..3.21, start, output).unwrap();
            (run.last().map(|(t, x)| (t, *x)), but_evaluations(run.statistics()), run.stopped_by())
        };
        let steps = end(Output::Steps);
        assert_eq!(steps.2, None);
        assert_eq!(steps, end(Output::Uniform(2)), "{name}");
        assert_eq!(steps, end(Output::Uniform(1000)), "{name}");
        assert_eq!(steps, end(Output::Times(&[1.0, 3.21])), "{name}");
    });
}

#[test]
fn samples_at_given_times_may_repeat_and_include_both_ends() {
    let times = [0.0, 0.0, 0.3, 0.3, 1.7, 1.75, 4.0, 4.0];
    every_solver!(STEP, tolerance(TOLERANCE), |name, solver| {
        let start = Oscillator::exact(0.0);
        let run = solver.solve(&Oscillator, 0.0..4.0, start, Output::Times(&times)).unwrap();
        assert_eq!(run.times(), times, "{name}");
        for (time, state) in run.iter() {
            let error = (state - Oscillator::exact(time)).norm();
            assert!(error < ERROR, "{name}: {error:e} at {time}");
        }
    });
}

#[test]
fn no_times_are_no_samples() {
    every_solver!(STEP, tolerance(TOLERANCE), |name, solver| {
        let run = solver.solve(&Oscillator, 0.0..1.0, Oscillator::exact(0.0), Output::Times(&[]));
        let run = run.unwrap();
        assert_eq!((run.times().len(), run.last()), (0, None), "{name}");
        assert!(run.statistics().steps > 0, "{name}");
        // Times that end before the span are no reason to stop early.
        let run =
            solver.solve(&Oscillator, 0.0..1.0, Oscillator::exact(0.0), Output::Times(&[0.5]));
        assert_eq!(run.unwrap().times(), [0.5], "{name}");
    });
}

#[test]
fn steps_are_stored_at_both_their_ends() {
    for (from, to) in [(0.0, 3.21), (-3.2, 0.1)] {
        every_solver!(STEP, tolerance(TOLERANCE), |name, solver| {
            let start = Oscillator::exact(from);
            let run = solver.solve(&Oscillator, from..to, start, Output::Steps).unwrap();
            assert_eq!(run.times().len() as u64, run.statistics().steps + 1, "{name}");
            assert_eq!((run.times()[0], run.last().unwrap().0), (from, to), "{name}");
            for pair in run.times().windows(2) {
                assert!((pair[1] - pair[0]) * (to - from) > 0.0, "{name}: {pair:?}");
            }
            for (time, state) in run.iter() {
                assert!((state - Oscillator::exact(time)).norm() < ERROR, "{name}: {time}");
            }
        });
    }
}

#[test]
fn a_span_of_no_length_is_its_start() {
    let system = Counted::new(Oscillator);
    let start = Vector2::new(3.0, 4.0);
    every_solver!(STEP, tolerance(TOLERANCE), |name, solver| {
        let run = solver.solve(&system, 2.0..2.0, start, Output::Steps).unwrap();
        assert_eq!((run.times(), run.states()), (&[2.0][..], &[start][..]), "{name}");
        assert_eq!(run.stopped_by(), None, "{name}");
        let run = solver.solve(&system, 2.0..2.0, start, Output::Uniform(3)).unwrap();
        assert_eq!(run.times(), [2.0; 3], "{name}");
        let run = solver.solve(&system, 2.0..2.0, start, Output::Times(&[2.0])).unwrap();
        assert_eq!((run.times(), run.states()), (&[2.0][..], &[start][..]), "{name}");
        let run = solver.solve(&system, 2.0..2.0, start, Output::Dense).unwrap();
        assert_eq!(
            (run.at(2.0), run.at(1.9), run.at(f64::NAN)),
            (Some(start), None, None),
            "{name}"
        );
        let mut run = solver.begin(&system, 2.0..2.0, start).unwrap();
        assert!(run.advance().unwrap().is_none(), "{name}");
        assert_eq!((run.time(), *run.state()), (2.0, start), "{name}");
    });
    assert_eq!(system.calls.get(), 0);
}

/// The grid of a fixed step over a span.
fn grid(from: f64, to: f64, step: f64) -> Vec<f64> {
    let grid = (0..).map(|k| from + step * f64::from(k));
    let mut times: Vec<f64> = grid.take_while(|time| to - time > 1e-12).collect();
    times.push(to);
    times
}

#[test]
fn fixed_steps_lie_on_their_grid_wherever_it_starts() {
    for (from, to) in [(0.0, 1.0), (-1.0, 5.7), (0.1, 2.3), (1000.3, 1003.1), (-77.7, -75.2)] {
        for step in [0.1, 0.3, 0.7, 0.017, 1.0 / 3.0] {
            every_method!(|name, method, order, dense| {
                let system = Counted::new(Oscillator);
                // A limit, so that the test ends if the run does not.
                let solver = OfAny::fixed(method, step).unwrap().with_most_steps(2000);
                let start = Oscillator::exact(from);
                let run = solver.solve(&system, from..to, start, Output::Steps);
                let Ok(run) = run else {
                    panic!("{name}, {from}..{to} by {step}: {}", run.unwrap_err())
                };
                let grid = grid(from, to, step);
                assert_eq!(run.times().len(), grid.len(), "{name}, {from}..{to} by {step}");
                for (time, grid) in run.times().iter().zip(&grid) {
                    // The rounding of a time of 1000.
                    assert!((time - grid).abs() < 1e-12, "{name}: {time} {grid}");
                }
                assert_eq!(run.statistics().rejected, 0, "{name}");
            });
        }
    }
}

#[test]
fn a_step_longer_than_the_span_is_cut_to_it() {
    for (from, to) in [(0.0, 0.01), (7.0, 7.01)] {
        every_solver!(5.0, tolerance(1e-6), |name, solver| {
            let solver = solver.with_first_step(5.0).unwrap();
            let start = Oscillator::exact(from);
            let run = solver.solve(&Oscillator, from..to, start, Output::Steps).unwrap();
            assert_eq!(run.times(), [from, to], "{name}");
            // One step of 0.01.
            assert!((run.states()[1] - Oscillator::exact(to)).norm() < 1e-11, "{name}");
        });
    }
}

#[test]
fn a_kink_on_the_grid_does_not_shift_it() {
    // Kinks on grid points, as decimals: some are a rounding before, some after k·0.1.
    for kink in [0.1, 0.2, 0.3, 0.6, 0.7, 0.9] {
        let ramp = Polyline::new([
            Vertex { time: kink, value: 0.0 },
            Vertex { time: kink + 10.0, value: 10.0 },
        ]);
        let system = Integral(ramp.unwrap());
        every_method!(|name, method, order, dense| {
            let solver = OfAny::fixed(method, 0.1).unwrap();
            let run = solver.solve(&system, 0.0..1.0, Vector1::new(0.0), Output::Steps);
            let run = run.unwrap();
            assert_eq!(run.statistics().steps, 10, "{name}, kink at {kink}");
            for (time, grid) in run.times().iter().zip(grid(0.0, 1.0, 0.1)) {
                assert!((time - grid).abs() < 1e-15, "{name}: {time} {grid}");
            }
            // A parabola from the kink on.
            let area = (1.0 - kink) * (1.0 - kink) / 2.0;
            // Rounding, magnified by the Rosenbrock methods' weights of up to a hundred.
            assert!((run.last().unwrap().1[0] - area).abs() < 1e-13, "{name}, {kink}");
        });
    }
}

#[test]
fn a_kink_or_a_reversal_between_grid_points_is_a_step_of_its_own_and_does_not_shift_the_grid() {
    let vertices = |points: [(f64, f64); 2]| points.map(|(time, value)| Vertex { time, value });
    let ramp = Integral(Polyline::new(vertices([(0.23, 0.0), (10.23, 10.0)])).unwrap());
    let turn = Sided(Polyline::new(vertices([(-10.0, 10.23), (10.0, -9.77)])).unwrap());
    every_method!(|name, method, order, dense| {
        let solver = OfAny::fixed(method, 0.1).unwrap();
        let (span, start) = (0.0..0.5, Vector1::new(0.0));
        let kink = solver.solve(&ramp, span.clone(), start, Output::Steps).unwrap();
        let reversal = solver.solve(&turn, span.clone(), start, Output::Steps).unwrap();
        // A kink is met, a reversal is located to rounding.
        for (run, rounding) in [(kink, 1e-15), (reversal, 1e-14)] {
            let expected = [0.0, 0.1, 0.2, 0.23, 0.3, 0.4, 0.5];
            assert_eq!(run.times().len(), expected.len(), "{name}: {:?}", run.times());
            for (time, expected) in run.times().iter().zip(expected) {
                assert!((time - expected).abs() < rounding, "{name}: {:?}", run.times());
            }
        }
        // The plain method has no stop there.
        let run = solver.plain().solve(&ramp, span, start, Output::Steps).unwrap();
        assert_eq!(run.times().len(), 6, "{name}: {:?}", run.times());
    });
}

#[test]
fn a_run_by_hand_is_the_same_run() {
    let swing = Swing { amplitude: 0.5, angular: 2.0, phase: 0.3 };
    let bristle = PrescribedVelocity::new(dahl(), swing);
    every_solver!(0.03, tolerance(1e-7), |name, solver| {
        let start = Vector1::new(0.01);
        let mut run = solver.begin(&bristle, 0.0..5.0, start).unwrap();
        let mut points = vec![(run.time(), *run.state())];
        while let Some(step) = run.advance().unwrap() {
            assert_eq!((step.end_time(), *step.end()), (run.time(), *run.state()), "{name}");
            assert_eq!((step.start_time(), *step.start()), points[points.len() - 1], "{name}");
            points.push((step.end_time(), *step.end()));
        }
        // It stays at its end.
        assert!(run.advance().unwrap().is_none(), "{name}");
        assert_eq!(run.time(), 5.0, "{name}");

        let mut streamed = vec![(0.0, start)];
        let summary = solver
            .stream(&bristle, 0.0..5.0, start, &[], &mut |step: &bristle::ode::Step<f64, 1>| {
                streamed.push((step.end_time(), *step.end()));
                std::ops::ControlFlow::Continue(())
            })
            .unwrap();
        assert_eq!(streamed, points, "{name}");
        let (streamed, by_hand) = (summary.statistics, run.statistics());
        assert_eq!(but_evaluations(streamed), but_evaluations(by_hand), "{name}");
        assert_eq!(summary.event, None, "{name}");
    });
}

#[test]
fn a_step_knows_the_state_at_both_its_ends_and_between() {
    every_solver!(STEP, tolerance(1e-7), |name, solver| {
        let mut run = solver.begin(&Oscillator, 0.0..2.0, Oscillator::exact(0.0)).unwrap();
        while let Some(step) = run.advance().unwrap() {
            assert_eq!(step.at(step.start_time()), *step.start(), "{name}");
            assert_eq!(step.at(step.end_time()), *step.end(), "{name}");
            let middle = 0.5 * (step.start_time() + step.end_time());
            let difference = (step.at(middle) - step.at_fraction(0.5)).norm();
            assert!(difference < 1e-14, "{name}: {difference:e}");
        }
    });
}

#[test]
fn the_bare_step_of_runge_kutta_is_the_plain_solver() {
    let swing = Swing { amplitude: 0.5, angular: 2.0, phase: 0.3 };
    let bristle = PrescribedVelocity::new(dahl(), swing);
    let solver = OfAny::fixed(RungeKutta4, 0.125).unwrap().plain();
    let run = solver.solve(&bristle, 0.0..8.0, Vector1::new(0.0), Output::Steps).unwrap();
    let mut state = Vector1::new(0.0);
    for (k, (time, stored)) in run.iter().enumerate() {
        // Steps of an eighth add up without rounding.
        assert_eq!((time, *stored), (0.125 * k as f64, state), "step {k}");
        state = RungeKutta4::step(&bristle, time, &state, 0.125);
    }
}

#[test]
fn a_first_step_is_taken_as_given() {
    let solver = OfAny::checked(DormandPrince, tolerance(1e-3));
    let first = |solver: OfAny<f64, DormandPrince, 2>| {
        let mut run = solver.begin(&Oscillator, 1.0..9.0, Oscillator::exact(1.0)).unwrap();
        run.advance().unwrap().unwrap().end_time() - 1.0
    };
    // The rounding of a time of 1.
    assert!((first(solver.with_first_step(1e-4).unwrap()) - 1e-4).abs() < 1e-15);
    assert!((first(solver.with_first_step(0.03).unwrap()) - 0.03).abs() < 1e-15);
    // Without one, a guess that neither crawls nor has to be taken back.
    let guess = first(solver);
    assert!(guess > 0.01 && guess < 1.0, "{guess}");
    let run = solver.solve(&Oscillator, 1.0..9.0, Oscillator::exact(1.0), Output::Steps).unwrap();
    assert!(run.statistics().rejected <= 2, "{}", run.statistics());
}

#[test]
fn what_is_only_for_adaptive_steps_does_not_touch_fixed_ones() {
    let solver = Solver::<f64, _, 2>::fixed(RungeKutta4, 0.25).unwrap();
    let limited = solver.with_largest_step(0.1).unwrap().with_first_step(0.01).unwrap();
    let run = |solver: Solver<f64, RungeKutta4, 2>| {
        solver.solve(&Oscillator, 0.0..3.0, Oscillator::exact(0.0), Output::Steps).unwrap()
    };
    assert_eq!(run(solver), run(limited));
}

/// A system whose right-hand side depends on time alone and is known to the last digit.
#[derive(Debug)]
struct Quartic;

impl System<f64, 1, 0> for Quartic {
    fn rate(&self, t: f64, _: &Vector1<f64>, _: [Branch; 0]) -> Vector1<f64> {
        Vector1::new(4.0 * t * t * t - 6.0 * t * t + 2.0)
    }

    fn linearised(
        &self,
        t: f64,
        x: &Vector1<f64>,
        branches: [Branch; 0],
    ) -> Option<Linearisation<f64, 1>> {
        let by_time = Vector1::new(12.0 * t * t - 12.0 * t);
        Some(Linearisation { rate: self.rate(t, x, branches), by_state: Matrix1::zeros(), by_time })
    }

    fn sliding_velocities(&self, _: f64, _: &Vector1<f64>) -> [f64; 0] {
        []
    }
}

#[test]
fn polynomials_of_the_order_of_the_method_are_exact() {
    // x = t⁴ − 2t³ + 2t in steps of any length.
    let exact = |t: f64| t.powi(4) - 2.0 * t.powi(3) + 2.0 * t;
    every_solver!(0.7, tolerance(1e-3), |name, solver| {
        let run = solver.solve(&Quartic, -1.0..2.0, Vector1::new(exact(-1.0)), Output::Steps);
        for (time, state) in run.unwrap().iter() {
            // Values of up to ten, a dozen roundings each, magnified by weights of up to a hundred.
            assert!((state[0] - exact(time)).abs() < 1e-12, "{name}: {time}");
        }
    });
}
