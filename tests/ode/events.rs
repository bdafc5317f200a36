//! Events: zeros of a function along the solution.
#![cfg(feature = "alloc")]

use std::cell::RefCell;
use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::ControlFlow;

use bristle::ode::{Direction, Event, Observer, Occurrence, Output, Step};
use bristle_specimens::ode::{Field, OfAny, Oscillator, every_solver, tolerance};
use nalgebra::Vector2;

/// Times are as good as the solution: RK4 with steps of 0.05 is off by h⁴/120 = 5e-8 per radian
/// after up to 13 of them, and a cubic by h⁴/384; the adaptive run meets a tolerance of 1e-10.
const TIMES: f64 = 1e-6;
const STEP: f64 = 0.05;
const TOLERANCE: f64 = 1e-10;

fn start() -> Vector2<f64> {
    Oscillator::exact(0.0)
}

type Function<'a> = &'a dyn Fn(f64, &Vector2<f64>) -> f64;

fn event(function: Function<'_>, direction: Direction, stops: bool) -> Event<'_, f64, 2> {
    Event { function, direction, stops }
}

/// The run of the oscillator from `start()` up to a time.
macro_rules! run {
    ($solver:expr, $end:expr, $events:expr) => {
        $solver.solve_with_events(&Oscillator, 0.0..$end, start(), $events, Output::Steps).unwrap()
    };
}

#[track_caller]
fn assert_times(name: &str, events: &[Occurrence<f64, 2>], times: &[f64]) {
    let found: Vec<f64> = events.iter().map(|event| event.time).collect();
    assert_eq!(found.len(), times.len(), "{name}: {found:?} instead of {times:?}");
    for (found, time) in found.iter().zip(times) {
        assert!((found - time).abs() < TIMES, "{name}: {found} instead of {time}");
    }
}

#[test]
fn events_happen_where_the_function_passes_zero_in_the_direction_asked_for() {
    // x = cos t falls through zero at π/2, rises at 3π/2, …
    let position: Function<'_> = &|_, x| x[0];
    for (direction, times) in [
        (Direction::Falling, vec![FRAC_PI_2, 5.0 * FRAC_PI_2]),
        (Direction::Rising, vec![3.0 * FRAC_PI_2]),
        (Direction::Either, vec![FRAC_PI_2, 3.0 * FRAC_PI_2, 5.0 * FRAC_PI_2]),
    ] {
        every_solver!(STEP, tolerance(TOLERANCE), |name, solver| {
            let events = [event(position, direction, false)];
            let run = run!(solver, 9.0, &events);
            assert_times(name, run.events(), &times);
            assert_eq!(run.stopped_by(), None, "{name}");
            assert_eq!(run.last().unwrap().0, 9.0, "{name}");
            for occurrence in run.events() {
                assert_eq!(occurrence.index, 0);
                let exact = Oscillator::exact(occurrence.time);
                assert!((occurrence.state - exact).norm() < TIMES, "{name}: {occurrence:?}");
            }
        });
    }
}

#[test]
fn a_stop_ends_the_run_there() {
    let velocity: Function<'_> = &|_, x| x[1] + 0.5;
    for i in 0..50 {
        // Various places within a step; −sin t + 0.5 rises through zero at π − π/6 + shift.
        let shift = 0.013 * f64::from(i);
        let from = Oscillator::exact(shift);
        every_solver!(STEP, tolerance(TOLERANCE), |name, solver| {
            let events = [event(velocity, Direction::Rising, true)];
            let run = solver.solve_with_events(&Oscillator, 0.0..9.0, from, &events, Output::Steps);
            let run = run.unwrap();
            assert_eq!(run.stopped_by(), Some(0), "{name}");
            assert_times(name, run.events(), &[PI - PI / 6.0 - shift]);
            let (time, state) = run.last().unwrap();
            let occurrence = run.events()[0];
            // The very same point, to rounding, ends the trajectory and is reported.
            assert!((time - occurrence.time).abs() < 1e-14, "{name}");
            assert!((state - occurrence.state).norm() < 1e-14, "{name}");
            assert!((state - Oscillator::exact(time + shift)).norm() < TIMES, "{name}");
        });
    }
}

#[test]
fn a_run_that_stopped_goes_on_without_stopping_at_once() {
    let position: Function<'_> = &|_, x| x[0] - 0.3;
    let first = f64::acos(0.3);
    every_solver!(STEP, tolerance(TOLERANCE), |name, solver| {
        for direction in [Direction::Falling, Direction::Either] {
            let events = [event(position, direction, true)];
            let (mut time, mut state) = (0.0, start());
            let mut stops = Vec::new();
            while time < 12.0 {
                let span = time..12.0;
                let run =
                    solver.solve_with_events(&Oscillator, span, state, &events, Output::Steps);
                let run = run.unwrap();
                (time, state) = (run.last().unwrap().0, *run.last().unwrap().1);
                stops.extend(run.events().iter().map(|event| event.time));
            }
            let times = match direction {
                Direction::Falling => vec![first, 2.0 * PI + first],
                _ => vec![first, 2.0 * PI - first, 2.0 * PI + first, 4.0 * PI - first],
            };
            assert_eq!(stops.len(), times.len(), "{name}: {stops:?}");
            for (stop, time) in stops.iter().zip(times) {
                // The interpolant's error stays in the state at each stop.
                assert!((stop - time).abs() < 4.0 * TIMES, "{name}: {stop} {time}");
            }
        }
    });
}

#[test]
fn samples_end_at_a_stop() {
    let position: Function<'_> = &|_, x| x[0];
    every_solver!(STEP, tolerance(TOLERANCE), |name, solver| {
        let events = [event(position, Direction::Either, true)];
        let output = Output::Uniform(101);
        let run = solver.solve_with_events(&Oscillator, 0.0..10.0, start(), &events, output);
        let run = run.unwrap();
        // 0, 0.1, … 1.5 lie before π/2.
        assert_eq!(run.times().len(), 16, "{name}");
        assert!(run.times().iter().all(|&time| time <= FRAC_PI_2), "{name}");
        for (time, state) in run.iter() {
            assert!((state - Oscillator::exact(time)).norm() < TIMES, "{name}: {time}");
        }
    });
}

#[test]
fn zeros_in_time_are_found_once_each_and_in_order_up_to_a_stop() {
    let at = |zero: f64| move |t: f64, _: &Vector2<f64>| t - zero;
    let (grid, middle, early, second, late) = (at(0.5), at(0.125), at(0.2), at(0.3), at(0.8));
    let falls = |t: f64, _: &Vector2<f64>| 0.5 - t;
    // Both signs of its value are seen only from the middle of a long step, by its interpolant.
    let window = |t: f64, _: &Vector2<f64>| (t - 0.2) * (t - 0.8);
    let ends = |t: f64, _: &Vector2<f64>| t * (t - 1.0);
    type Case<'a> = (&'a [(Function<'a>, bool)], &'a [(usize, f64)]);
    let cases: [Case<'_>; 9] = [
        // The order is that of time, and of the list for the same time.
        (&[(&late, false), (&early, false), (&early, false)], &[(1, 0.2), (2, 0.2), (0, 0.8)]),
        (&[(&second, false), (&early, true), (&second, true)], &[(1, 0.2)]),
        (&[(&window, false)], &[(0, 0.2), (0, 0.8)]),
        // One at the end of the span counts, one at its start does not.
        (&[(&ends, false)], &[(0, 1.0)]),
        (&[(&ends, true)], &[(0, 1.0)]),
        // 0.5 and 0.125 are the end or the middle of a step: exactly zero, rising and falling.
        (&[(&grid, false), (&middle, false)], &[(1, 0.125), (0, 0.5)]),
        (&[(&grid, true)], &[(0, 0.5)]),
        (&[(&falls, true)], &[(0, 0.5)]),
        (&[(&falls, false)], &[(0, 0.5)]),
    ];
    for (step, first) in [(3.0, 1.0), (0.25, 1e-3), (0.5, 0.5)] {
        every_solver!(step, tolerance(1e-2), |name, solver| {
            let solver = solver.with_first_step(first).unwrap();
            for (case, (functions, occurrences)) in cases.iter().enumerate() {
                let listed: Vec<_> = functions
                    .iter()
                    .map(|&(function, stops)| event(function, Direction::Either, stops))
                    .collect();
                let run = run!(solver, 1.0, &listed);
                let times: Vec<f64> = occurrences.iter().map(|at| at.1).collect();
                assert_times(name, run.events(), &times);
                let order = run.events().iter().map(|event| event.index);
                assert!(order.eq(occurrences.iter().map(|at| at.0)), "{name}: {case}");
                let &(last, time) = occurrences.last().unwrap();
                let stop = functions[last].1.then_some(last);
                assert_eq!(run.stopped_by(), stop, "{name}: {case}");
                let end = if stop.is_some() { time } else { 1.0 };
                assert!((run.last().unwrap().0 - end).abs() < 1e-14, "{name}: {case}");
            }
        });
    }
}

#[test]
fn a_limit_on_the_step_finds_what_is_shorter_than_a_step() {
    // Both zeros lie in the first half of a step of length 1; the first step is limited too.
    let window: Function<'_> = &|t, _| (t - 0.1) * (t - 0.3);
    let solver = OfAny::checked(bristle::ode::DormandPrince, tolerance(1e-2));
    let solver = solver.with_largest_step(0.15).unwrap();
    for solver in [solver, solver.with_first_step(1.0).unwrap()] {
        let events = [event(window, Direction::Either, false)];
        let run = run!(solver, 1.0, &events);
        assert_times("limited", run.events(), &[0.1, 0.3]);
        for times in run.times().windows(2) {
            // A step that nearly reaches the end may be stretched to it, by a thousandth.
            assert!(times[1] - times[0] <= 0.15 * 1.001, "{times:?}");
        }
    }
}

/// An observer that keeps what it is told, and breaks off where asked.
#[derive(Default)]
struct Listener {
    steps: Vec<(f64, f64)>,
    events: Vec<f64>,
    break_at_step: Option<usize>,
    break_at_event: bool,
}

impl Observer<f64, Vector2<f64>> for Listener {
    fn step(&mut self, step: &Step<f64, 2>) -> ControlFlow<()> {
        self.steps.push((step.start_time(), step.end_time()));
        if self.break_at_step == Some(self.steps.len()) {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }

    fn event(&mut self, occurrence: &Occurrence<f64, 2>) -> ControlFlow<()> {
        self.events.push(occurrence.time);
        if self.break_at_event { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

macro_rules! listen {
    ($solver:expr, $events:expr, $listener:ident) => {
        $solver.stream(&Oscillator, 0.0..3.0, start(), $events, &mut $listener).unwrap()
    };
}

#[test]
fn an_observer_sees_every_step_and_every_event() {
    let position: Function<'_> = &|_, x| x[0];
    every_solver!(STEP, tolerance(TOLERANCE), |name, solver| {
        let mut listener = Listener::default();
        let events = [event(position, Direction::Either, false)];
        let summary = listen!(solver, &events, listener);
        assert_eq!(summary.event, None, "{name}");
        assert_eq!((summary.time, listener.events.len()), (3.0, 1), "{name}");
        assert_eq!(summary.statistics.steps, listener.steps.len() as u64, "{name}");
        // One step begins where the one before ends.
        assert_eq!(listener.steps[0].0, 0.0, "{name}");
        for pair in listener.steps.windows(2) {
            assert_eq!(pair[0].1, pair[1].0, "{name}");
        }
        assert_eq!(listener.steps.last().unwrap().1, 3.0, "{name}");
    });
}

#[test]
fn an_observer_can_break_off() {
    let position: Function<'_> = &|_, x| x[0];
    every_solver!(STEP, tolerance(TOLERANCE), |name, solver| {
        let events = [event(position, Direction::Either, false)];
        let mut listener = Listener { break_at_step: Some(3), ..Listener::default() };
        let summary = listen!(solver, &events, listener);
        assert_eq!(summary.event, None, "{name}");
        assert_eq!((listener.steps.len(), summary.statistics.steps), (3, 3), "{name}");
        assert_eq!(summary.time, listener.steps[2].1, "{name}");

        // At an event: the run ends at the end of its step.
        let mut listener = Listener { break_at_event: true, ..Listener::default() };
        let summary = listen!(solver, &events, listener);
        assert_eq!(summary.event, None, "{name}");
        let (from, to) = *listener.steps.last().unwrap();
        assert_eq!(summary.time, to, "{name}");
        assert!(from <= listener.events[0] && listener.events[0] <= to, "{name}");
        assert!((summary.state - Oscillator::exact(to)).norm() < TIMES, "{name}");

        // An event that stops wins over an observer that breaks off at it.
        let events = [event(position, Direction::Either, true)];
        let mut listener = Listener { break_at_event: true, ..Listener::default() };
        let summary = listen!(solver, &events, listener);
        assert_eq!(summary.event, Some(0), "{name}");
    });
}

#[test]
fn events_are_found_on_the_solution_and_not_on_trial_steps() {
    // Rejected steps are looked at by nobody: the function is only asked about the solution.
    every_solver!(0.5, tolerance(1e-8), |name, solver| {
        let worst = RefCell::new(0.0_f64);
        let function = |t: f64, x: &Vector2<f64>| {
            let error = (x - Oscillator::exact(t)).norm();
            worst.replace_with(|&mut worst| worst.max(error));
            x[0]
        };
        let events = [event(&function, Direction::Either, false)];
        let solver = solver.with_first_step(5.0).unwrap();
        let mut listener = Listener::default();
        solver.stream(&Oscillator, 0.0..5.0, start(), &events, &mut listener).unwrap();
        // RK4 at half a radian: 0.5⁵/120 per step, ten of them. A trial of 5 is off by 1 or more.
        assert!(*worst.borrow() < 5e-3, "{name}: {worst:?}");
    });
}

#[test]
fn a_stop_is_a_place_to_switch_the_system() {
    // The bouncing ball, ẍ = −1, restitution 1/2: it hits the ground at √2, 2√2, 2.5√2, …
    let ball = Field(|_: f64, x: &Vector2<f64>| Vector2::new(x[1], -1.0));
    let height: Function<'_> = &|_, x| x[0];
    every_solver!(0.1, tolerance(1e-9), |name, solver| {
        let hits = [event(height, Direction::Falling, true)];
        let (mut time, mut state) = (0.0, Vector2::new(1.0, 0.0));
        let root = f64::sqrt(2.0);
        for expected in [root, 2.0 * root, 2.5 * root, 2.75 * root] {
            let run =
                solver.solve_with_events(&ball, time..10.0, state, &hits, Output::Steps).unwrap();
            assert_eq!(run.stopped_by(), Some(0), "{name}");
            time = run.last().unwrap().0;
            // Parabolas are exact for both interpolants; what is left is the place of the zero.
            assert!((time - expected).abs() < 1e-12, "{name}: {time} {expected}");
            state = Vector2::new(0.0, -0.5 * run.last().unwrap().1[1]);
        }
    });
}
