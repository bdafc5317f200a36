//! What is refused at the door, and how a run that goes bad ends: with a reason, a time, a place,
//! and everything stored until then.
#![cfg(feature = "alloc")]

use std::error::Error;

use bristle::curve::Stribeck;
use bristle::ode::{
    DormandPrince, Failure, Output, Rodas4, RungeKutta4, Solver, StopReason, System, Tolerances,
};
use bristle::{Branch, Bristle, Contact, ImplicitBristle, ParameterError, Rule};
use bristle_specimens::ode::{
    Counted, Field, OfAny, Oscillator, every_method, every_solver, stick_slip, tolerance,
};
use nalgebra::{Vector1, Vector2};

/// The second component is not a number from some time on, or beyond some state.
fn breaks(time: f64, position: f64) -> impl System<f64, 2, 0> + Copy + std::fmt::Debug {
    Field(move |t: f64, x: &Vector2<f64>| {
        Vector2::new(1.0, if t > time || x[0] > position { f64::NAN } else { 2.0 })
    })
}

fn late() -> impl System<f64, 2, 0> + Copy + std::fmt::Debug {
    breaks(1.0, f64::INFINITY)
}

type Stopped = Box<Failure<f64, 2>>;

#[test]
fn a_right_hand_side_that_breaks_ends_the_run_where_it_breaks() {
    for (time, position) in [(1.0, f64::INFINITY), (f64::INFINITY, 1.0)] {
        let system = breaks(time, position);
        every_solver!(0.3, tolerance(1e-6), |name, solver| {
            let system = Counted::new(system);
            let run = solver.solve(&system, 0.0..2.0, Vector2::new(0.0, 1.0), Output::Steps);
            let failure: Stopped = run.unwrap_err();
            let stored = failure.trajectory.as_ref().unwrap();
            assert_eq!(failure.reason, StopReason::NotFinite { component: 1 }, "{name}");
            // Shortened until a step no longer advances the time.
            assert!((failure.time - 1.0).abs() < 1e-12, "{name}: {}", failure.time);
            // A position of 1 may be reached a few roundings of the stages late.
            assert!(failure.time <= 1.0 + 1e-14, "{name}: {}", failure.time);
            // In two attempts.
            assert!(system.calls.get() < 4000, "{name}: {} calls", system.calls.get());
            // What was stored until then is there, finite, and right.
            let (time, state) = stored.last().unwrap();
            assert_eq!((time, *state), (failure.time, failure.state), "{name}");
            for (time, state) in stored.iter() {
                let exact = Vector2::new(time, 1.0 + 2.0 * time);
                assert!((state - exact).norm() < 1e-12, "{name}: {state} at {time}");
            }
            assert_eq!(stored.statistics(), failure.statistics, "{name}");
        });
    }
}

#[test]
fn a_plain_fixed_step_does_not_try_again() {
    every_method!(|name, method, order, dense| {
        let solver = OfAny::fixed(method, 0.3).unwrap().plain();
        let run = solver.solve(&late(), 0.0..2.0, Vector2::new(0.0, 1.0), Output::Steps);
        let stopped = run.unwrap_err();
        assert_eq!(stopped.reason, StopReason::NotFinite { component: 1 }, "{name}");
        // 0.9 is the last point of the grid before 1.
        assert!((stopped.time - 0.9).abs() < 1e-15, "{name}: {}", stopped.time);
        assert_eq!(stopped.statistics.rejected, 1, "{name}");
        assert_eq!(stopped.trajectory.as_ref().unwrap().times().len(), 4, "{name}");
    });
}

#[test]
fn a_run_that_failed_stays_where_it_stands() {
    every_solver!(0.3, tolerance(1e-6), |name, solver| {
        let system = late();
        let mut run = solver.begin(&system, 0.0..2.0, Vector2::new(0.0, 1.0)).unwrap();
        let failure = loop {
            match run.advance() {
                Ok(step) => assert!(step.is_some(), "{name}"),
                Err(failure) => break failure,
            }
        };
        assert_eq!((run.time(), *run.state()), (failure.time, failure.state), "{name}");
        let again = run.advance().unwrap_err();
        assert_eq!((again.time, again.state), (failure.time, failure.state), "{name}");
    });
}

#[test]
fn a_right_hand_side_that_is_broken_from_the_start_is_refused_there() {
    let broken = breaks(-1.0, f64::INFINITY);
    every_solver!(0.3, tolerance(1e-6), |name, solver| {
        let failure = solver.begin(&broken, 0.0..2.0, Vector2::zeros()).unwrap_err();
        assert_eq!(failure.reason, StopReason::NotFinite { component: 1 }, "{name}");
        assert_eq!((failure.time, failure.state), (0.0, Vector2::zeros()), "{name}");
        let stopped = solver.solve(&broken, 0.0..2.0, Vector2::zeros(), Output::Steps);
        assert_eq!(stopped.unwrap_err().reason, failure.reason, "{name}");
    });
}

#[test]
fn a_state_that_overflows_is_never_a_solution() {
    // x = 1/(1 − t): infinite at t = 1.
    let explosion = Field(|_: f64, x: &Vector1<f64>| Vector1::new(x[0] * x[0]));
    // Errors grow without bound, too.
    let solver = OfAny::checked(DormandPrince, tolerance(1e-6));
    let stopped = solver.solve(&explosion, 0.0..2.0, Vector1::new(1.0), Output::Steps);
    assert!(stopped.unwrap_err().time < 1.0);
    let solver = OfAny::adaptive(DormandPrince, tolerance(1e-7));
    let stopped = solver.solve(&explosion, 0.0..2.0, Vector1::new(1.0), Output::Steps);
    let stopped = stopped.unwrap_err();
    let reason = stopped.reason;
    assert!(matches!(reason, StopReason::StepTooSmall { smallest } if smallest < 1e-14));
    // The pole is placed to the error of the run so far.
    assert!((stopped.time - 1.0).abs() < 1e-5, "{}", stopped.time);
    assert!(stopped.trajectory.as_ref().unwrap().states().iter().all(|x| x[0].is_finite()));
    assert_eq!(
        stopped.to_string().split(':').next().unwrap(),
        format!("integration stopped at t = {} s", stopped.time)
    );
    // A fixed step walks past the pole, until the numbers end.
    let solver = OfAny::fixed(RungeKutta4, 0.1).unwrap();
    let stopped = solver.solve(&explosion, 0.0..2.0, Vector1::new(1.0), Output::Steps);
    let stopped = stopped.unwrap_err();
    assert_eq!(stopped.reason, StopReason::NotFinite { component: 0 });
    assert!(stopped.trajectory.as_ref().unwrap().states().iter().all(|x| x[0].is_finite()));
}

#[test]
fn the_number_of_steps_is_limited() {
    every_solver!(0.01, tolerance(1e-9), |name, solver| {
        let solver = solver.with_most_steps(10);
        let run = solver.solve(&Oscillator, 0.0..5.0, Vector2::new(1.0, 0.0), Output::Steps);
        let stopped = run.unwrap_err();
        let (failure, stored) = (&stopped, stopped.trajectory.as_ref().unwrap());
        assert_eq!(failure.reason, StopReason::TooManySteps { limit: 10 }, "{name}");
        let trials = failure.statistics.steps + failure.statistics.rejected;
        assert_eq!(trials, 10, "{name}: {}", failure.statistics);
        let (time, state) = stored.last().unwrap();
        assert_eq!((time, *state), (failure.time, failure.state), "{name}");
        assert_eq!(stored.times().len() as u64, failure.statistics.steps + 1);
        assert_eq!(
            stopped.to_string(),
            format!("integration stopped at t = {time} s: the limit of 10 steps is used up")
        );
    });
}

#[test]
fn a_limit_that_is_just_enough_is_enough() {
    let solver = OfAny::fixed(RungeKutta4, 0.125).unwrap().with_most_steps(8);
    assert!(solver.solve(&Oscillator, 0.0..1.0, Vector2::zeros(), Output::Steps).is_ok());
    let solver = solver.with_most_steps(7);
    assert!(solver.solve(&Oscillator, 0.0..1.0, Vector2::zeros(), Output::Steps).is_err());
}

#[test]
fn a_step_below_the_rounding_of_the_time_is_refused() {
    every_method!(|name, method, order, dense| {
        // At t = 1 the next number is 2e-16 away.
        let solver = OfAny::fixed(method, 1e-20).unwrap().with_most_steps(1000);
        let run = solver.solve(&Oscillator, 1.0..2.0, Vector2::zeros(), Output::Steps);
        let reason = run.unwrap_err().reason;
        assert!(matches!(reason, StopReason::StepTooSmall { .. }), "{name}: {reason:?}");
    });
}

#[test]
fn failures_are_errors_with_a_cause() {
    let solver = OfAny::fixed(RungeKutta4, 0.3).unwrap();
    let failure: Stopped =
        solver.solve(&late(), 0.0..2.0, Vector2::zeros(), Output::Steps).unwrap_err();
    let message = format!(
        "integration stopped at t = {} s: component 1 of the right-hand side or of the state is \
         not finite",
        failure.time
    );
    assert_eq!(failure.to_string(), message);
    let source = failure.source().and_then(|source| source.downcast_ref::<StopReason>());
    assert_eq!(source, Some(&failure.reason));
    // A question mark in a main function takes it.
    let boxed: Box<dyn Error> = failure;
    assert_eq!(boxed.to_string(), message);
}

/// What `main` prints of an error: not the trajectory.
#[test]
fn a_failure_that_is_printed_says_why_in_a_line() {
    let tolerance = Tolerances::new(Vector1::repeat(1e-9), Vector1::repeat(1e-9)).unwrap();
    let solver = Solver::adaptive(Rodas4, tolerance).with_most_steps(100);
    let wave = Field(|t: f64, _: &Vector1<f64>| Vector1::new((1e3 * t).sin()));
    let stopped = solver.solve(&wave, 0.0..1.0, Vector1::zeros(), Output::Steps).unwrap_err();
    let states = stopped.trajectory.as_ref().unwrap().states().len();
    let printed = format!("{stopped:?}");
    assert!(printed.contains(&stopped.to_string()), "{printed}");
    assert!(states > 50 && printed.contains(&format!("{states} states")), "{printed}");
    assert!(printed.len() < 300, "{printed}");
}

#[test]
fn every_reason_says_what_happened() {
    let texts = [
        (StopReason::NotFinite { component: 2 }, "component 2"),
        (StopReason::StepTooSmall { smallest: 1e-16 }, "1e-16 s"),
        (StopReason::EndlessReversals { contact: 1 }, "contact 1"),
        (StopReason::TooManySteps { limit: 12 }, "12 steps"),
    ];
    for (reason, part) in texts {
        assert!(reason.to_string().contains(part), "{reason}");
    }
}

/// The parameter error for which a run was refused.
#[track_caller]
fn refusal<const N: usize>(stopped: &Failure<f64, N>) -> ParameterError {
    assert_eq!(stopped.trajectory, None);
    assert_eq!(stopped.statistics.evaluations, 0);
    match stopped.reason {
        StopReason::Refused(error) => error,
        other => panic!("refused for {other}"),
    }
}

const NOT_NUMBERS: [f64; 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];

#[test]
fn a_span_that_is_none_is_refused_by_its_end() {
    let mut spans = vec![(1.0, 0.0, "span.end"), (0.0, -1e-100, "span.end")];
    spans.extend(NOT_NUMBERS.map(|bad| (bad, 1.0, "span.start")));
    spans.extend(NOT_NUMBERS.map(|bad| (0.0, bad, "span.end")));
    // Shorter than any time that matters.
    spans.extend([5e-324, 1e-320, 1e-310, 1e-100, 9e-31].map(|end| (0.0, end, "span.end")));
    every_solver!(0.1, tolerance(1e-6), |name, solver| {
        for &(start, end, parameter) in &spans {
            for output in [Output::Steps, Output::Dense, Output::Uniform(3)] {
                let run = solver.solve(&Oscillator, start..end, Vector2::zeros(), output);
                let failure = run.unwrap_err();
                let (error, text) = (refusal(&failure), failure.to_string());
                let value = if parameter == "span.end" { end } else { start };
                assert_eq!((error.name, error.value.to_bits()), (parameter, value.to_bits()));
                let backwards = end < start && (start - end).is_finite();
                assert!(!backwards || text.contains("at least span.start"), "{name}: {text}");
            }
            assert!(solver.begin(&Oscillator, start..end, Vector2::zeros()).is_err(), "{name}");
        }
        let run = solver.solve(&Oscillator, 0.0..2e-30, Vector2::zeros(), Output::Steps);
        assert_eq!(run.unwrap().last().unwrap().0, 2e-30, "{name}");
    });
    // Backward, this bristle grows by e^125 in a second.
    let rig = stick_slip::<f64>();
    assert!(bristle::ode::solve(&rig, 1.0..0.0, rig.at_rest(), 1e-6, Output::Uniform(2)).is_err());
}

#[test]
fn samples_that_cannot_be_are_refused() {
    // Times out of order or out of the span, and the component that is wrong.
    let cases: [((f64, f64), &[f64], usize); 6] = [
        ((0.0, 1.0), &[0.2, 0.7, 0.6], 2),
        ((0.0, 1.0), &[-0.1, 0.6], 0),
        ((0.0, 1.0), &[0.1, 1.1], 1),
        ((0.0, 1.0), &[0.1, f64::NAN], 1),
        ((0.0, 1.0), &[f64::INFINITY], 0),
        ((1.0, 1.0), &[1.0, 1.1], 1),
    ];
    every_solver!(0.1, tolerance(1e-6), |name, solver| {
        let refused = |span, output| {
            refusal(&solver.solve(&Oscillator, span, Vector2::zeros(), output).unwrap_err())
        };
        for ((from, to), times, component) in cases {
            let error = refused(from..to, Output::Times(times));
            assert_eq!(error.component, Some(component), "{name}: {error} for {times:?}");
        }
        for samples in [0, 1] {
            let error = refused(0.0..1.0, Output::Uniform(samples));
            assert_eq!((error.name, error.value), ("samples", samples as f64), "{name}");
            assert_eq!(error.rule, Rule::Count { least: 2 }, "{name}");
            let want = format!("there must be at least 2 samples, not {samples}");
            assert_eq!(error.to_string(), want, "{name}");
        }
        // More than there is memory for.
        for samples in [1_000_000_000_000_000, usize::MAX] {
            assert_eq!(refused(0.0..1.0, Output::Uniform(samples)).name, "samples", "{name}");
        }
    });
}

#[test]
fn a_given_step_that_does_not_advance_the_time_is_refused_by_name() {
    // At t = 1 the next number is 2e-16 away, at t = 0 it is the smallest time that matters.
    for (start, step) in [(0.0, 1e-90), (0.0, 1e-31), (1.0, 1e-17), (-1.0, 1e-90)] {
        let solver = OfAny::checked(DormandPrince, tolerance(1e-6));
        for (solver, name) in [
            (solver.with_first_step(step), "first_step"),
            (solver.with_largest_step(step), "largest_step"),
        ] {
            let span = start..start + 1.0;
            let run = solver.unwrap().solve(&Oscillator, span, Vector2::zeros(), Output::Steps);
            let stopped = run.unwrap_err();
            let error = refusal(&stopped);
            assert_eq!((error.name, error.value), (name, step));
            let rule = "must be at least the smallest that advances the time";
            assert!(stopped.to_string().contains(rule), "{stopped}");
        }
    }
}

#[test]
fn a_time_too_late_for_the_steps_that_a_bristle_needs_is_not_called_infinite() {
    // At 1e14 s the next time is 16 ms away; the bristle of the rig relaxes in less.
    let rig = stick_slip::<f64>();
    let tolerances = Tolerances::scaled(1e-6, rig.scales()).unwrap();
    let span = 1e14..1e14 + 1.0;
    let reasons = [
        Solver::checked(DormandPrince, tolerances).solve(
            &rig,
            span.clone(),
            rig.at_rest(),
            Output::Steps,
        ),
        Solver::checked(Rodas4, tolerances).solve(&rig, span.clone(), rig.at_rest(), Output::Steps),
        bristle::ode::solve(&rig, span, rig.at_rest(), 1e-6, Output::Steps),
    ];
    for stopped in reasons {
        let reason = stopped.unwrap_err().reason;
        assert!(matches!(reason, StopReason::StepTooSmall { .. }), "{reason}");
    }
}

#[test]
fn an_initial_state_that_is_not_finite_is_refused_by_component() {
    for bad in NOT_NUMBERS {
        for component in 0..2 {
            let mut state = Vector2::new(1.0, 2.0);
            state[component] = bad;
            every_solver!(0.1, tolerance(1e-6), |name, solver| {
                let failure = solver.begin(&Oscillator, 0.0..1.0, state).unwrap_err();
                let StopReason::Refused(error) = failure.reason else {
                    panic!("{name}: {failure}")
                };
                assert_eq!(error.name, "initial_state", "{name}");
                assert_eq!(error.component, Some(component), "{name}");
                // The span of no length is no exception.
                assert!(solver.begin(&Oscillator, 1.0..1.0, state).is_err(), "{name}");
            });
        }
    }
}

#[test]
fn tolerances_that_are_not_positive_are_refused_by_component() {
    for bad in [0.0, -1e-6, f64::NAN, f64::INFINITY, 1e200] {
        for component in 0..2 {
            let good = Vector2::repeat(1e-6);
            let mut wrong = good;
            wrong[component] = bad;
            for (relative, absolute, parameter) in
                [(wrong, good, "relative"), (good, wrong, "absolute")]
            {
                let error = Tolerances::new(relative, absolute).unwrap_err();
                assert_eq!((error.name, error.component), (parameter, Some(component)));
                assert_eq!(error.value.to_bits(), bad.to_bits());
            }
            let error = Tolerances::scaled(1e-6, wrong).unwrap_err();
            assert_eq!((error.name, error.component), ("scales", Some(component)));
        }
        let error = Tolerances::scaled(bad, Vector2::repeat(1.0)).unwrap_err();
        assert_eq!((error.name, error.component), ("relative", None));
    }
    // Scaled ones are parts of the scales.
    let scaled = Tolerances::scaled(1e-6, Vector2::new(3.0, 1e5)).unwrap();
    assert_eq!(*scaled.relative(), Vector2::repeat(1e-6));
    assert_eq!(*scaled.absolute(), Vector2::new(3.0, 1e5) * 1e-6);
    let (relative, absolute) = (Vector2::new(1e-3, 1e-4), Vector2::new(1e-5, 1e-6));
    let given = Tolerances::new(relative, absolute).unwrap();
    assert_eq!((*given.relative(), *given.absolute()), (relative, absolute));
}

#[test]
fn steps_that_are_not_positive_are_refused_by_name() {
    let adaptive = OfAny::checked(DormandPrince, tolerance::<2>(1e-6));
    for bad in [0.0, -0.1, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        every_method!(|name, method, order, dense| {
            let error = Solver::<f64, _, 2>::fixed(method, bad).unwrap_err();
            assert_eq!((error.name, error.value.to_bits()), ("step", bad.to_bits()), "{name}");
            // Also where it would not be used.
            let fixed = Solver::<f64, _, 2>::fixed(method, 0.1).unwrap();
            assert_eq!(fixed.with_largest_step(bad).unwrap_err().name, "largest_step");
            assert_eq!(fixed.with_first_step(bad).unwrap_err().name, "first_step");
        });
        assert_eq!(adaptive.with_largest_step(bad).unwrap_err().name, "largest_step");
        assert_eq!(adaptive.with_first_step(bad).unwrap_err().name, "first_step");
    }
}

#[test]
fn a_field_that_ends_with_the_span_ends_the_run() {
    let fields: [fn(f64) -> f64; 5] = [
        |t| (1.0 - t).ln(),
        |t| 1.0 / (1.0 - t).sqrt(),
        |t| if t < 1.0 { 1.0 } else { f64::NAN },
        |t| if t < 1.0 { 1.0 } else { 2e9 },
        |t| if t < 1.0 { 1.0 } else { 0.0126 },
    ];
    let ends = [1.0, 1e3, 1e6].into_iter().flat_map(|end| fields.map(|field| (field, end)));
    for (index, (field, end)) in ends.enumerate() {
        every_solver!(0.1 * end, tolerance(1e-6), |name, solver| {
            let driven = Field(|t: f64, _: &Vector1<f64>| Vector1::new(field(t / end)));
            let run = solver.solve(&driven, 0.0..end, Vector1::zeros(), Output::Steps);
            let cost = match &run {
                Ok(run) => run.statistics(),
                Err(stopped) => {
                    let reason = stopped.reason;
                    let is_named = matches!(
                        reason,
                        StopReason::NotFinite { .. } | StopReason::StepTooSmall { .. }
                    );
                    assert!(is_named, "{name}, field {index}: {reason}");
                    assert!(stopped.time > 0.99 * end, "{name}, field {index}: {stopped}");
                    stopped.statistics
                }
            };
            // Each trial leaves a part of the rest, which ends at a rounding of the time.
            // A run that fails is tried twice.
            assert!(cost.steps + cost.rejected < 4000, "{name}, field {index}: {cost}");
        });
    }
}

#[test]
fn a_first_step_advances_a_late_time() {
    let single = Field(|_: f32, _: &Vector1<f32>| Vector1::new(1.0));
    let clock = Field(|_: f64, _: &Vector1<f64>| Vector1::new(1.0));
    let solver =
        OfAny::checked(DormandPrince, Tolerances::scaled(1e-3f32, Vector1::new(1.0)).unwrap());
    let run = solver.solve(&single, 1000.0f32..1001.0, Vector1::new(0.0), Output::Steps).unwrap();
    assert!((run.last().unwrap().1[0] - 1.0).abs() < 1e-3);
    every_solver!(0.25, tolerance(1e-6), |name, solver| {
        let run = solver.solve(&clock, 1e13..1e13 + 1.0, Vector1::new(0.0), Output::Steps);
        let x: f64 = run.unwrap_or_else(|stopped| panic!("{name}: {stopped}")).last().unwrap().1[0];
        assert!((x - 1.0).abs() < 1e-6, "{name}: {x}");
        // A span of one rounding of the time.
        let end = 1e13f64.next_up();
        let run = solver.solve(&clock, 1e13..end, Vector1::new(0.0), Output::Steps);
        let run = run.unwrap_or_else(|stopped| panic!("{name}: {stopped}"));
        assert_eq!(run.last().unwrap().0, end, "{name}");
    });
}

#[test]
fn a_tolerance_below_the_rounding_of_the_scalar_is_refused() {
    let error = Tolerances::scaled(1e-20, Vector1::new(1.0)).unwrap_err();
    assert_eq!((error.name, error.value), ("relative", 1e-20));
    // The range that is named is the one that is taken.
    for wrong in [1e-20, -1.0, 0.2] {
        let error = Tolerances::scaled(wrong, Vector1::new(1.0)).unwrap_err().to_string();
        assert!(error.contains("between 2.22") && error.ends_with("e-15 and 0.1"), "{error}");
    }
    assert!(Tolerances::scaled(0.1, Vector1::new(1.0)).is_ok());
    assert!(Tolerances::scaled(1e-6f32, Vector1::new(1.0)).is_err());
    assert!(Tolerances::scaled(2e-6f32, Vector1::new(1.0)).is_ok());
    assert!(Tolerances::scaled(1e-14, Vector1::new(1.0)).is_ok());
    let refused = Solver::<f64, _, 1>::automatic(1e-20, Vector1::new(1.0)).unwrap_err();
    assert_eq!(refused.value, 1e-20);
}

#[test]
fn a_sliding_velocity_that_is_not_a_number_stops_the_run() {
    /// The velocity is lost at t = 1.
    struct Lost;
    impl System<f64, 1> for Lost {
        fn rate(&self, _: f64, _: &Vector1<f64>, _: [Branch; 1]) -> Vector1<f64> {
            Vector1::new(1.0)
        }
        fn sliding_velocities(&self, time: f64, _: &Vector1<f64>) -> [f64; 1] {
            [if time < 1.0 { 2.0 + time } else { f64::NAN }]
        }
    }
    every_solver!(0.25, tolerance(1e-6), |name, solver| {
        for from in [0.0, 1.5] {
            let run = solver.solve(&Lost, from..2.0, Vector1::new(0.0), Output::Steps);
            let failure = run.expect_err(name);
            assert_eq!(failure.reason, StopReason::VelocityNotFinite { contact: 0 }, "{name}");
            assert!(failure.time <= from.max(1.0), "{name}: {failure}");
        }
    });
}

/// An implicit bristle under a load, dragged at 1 mm/s and more.
struct Loaded(Contact<f64, ImplicitBristle<Stribeck<f64>>>, f64);

impl System<f64, 1> for Loaded {
    fn rate(&self, time: f64, z: &Vector1<f64>, [branch]: [Branch; 1]) -> Vector1<f64> {
        Vector1::new(self.0.response_under(self.1, branch.of(1e-3 + 0.1 * time), z[0]).rate)
    }
    fn sliding_velocities(&self, time: f64, _: &Vector1<f64>) -> [f64; 1] {
        [1e-3 + 0.1 * time]
    }
}

#[test]
fn an_implicit_bristle_beyond_its_fold_is_refused_at_once() {
    let model = bristle_specimens::implicit::TABLE_2.model();
    let fold = model.folding_scale().unwrap();
    let solve = |scale: f64| {
        let loaded = Loaded(model.under_load(1.0).unwrap(), scale);
        bristle::ode::solve(&loaded, 0.0..1.0, Vector1::new(0.0), 1e-6, Output::Uniform(2))
    };
    assert!(solve(0.999 * fold).is_ok());
    for scale in [fold, 1.5 * fold] {
        let failure = solve(scale).unwrap_err();
        assert_eq!(failure.reason, StopReason::NotFinite { component: 0 }, "{failure}");
        assert!(failure.statistics.evaluations < 10, "{}", failure.statistics);
    }
}
