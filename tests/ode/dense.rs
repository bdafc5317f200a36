//! Dense trajectories and the reversals that a run reports.
#![cfg(feature = "alloc")]

use bristle::ode::{Direction, DormandPrince8, Event, Output, Solver, System, Tolerances};
use bristle::scene::PrescribedVelocity;
use bristle::{Branch, Dahl};
use bristle_specimens::ode::{
    Field, Oscillator, Swing, but_evaluations, dahl, every_solver, tolerance,
};
use nalgebra::{Vector1, Vector2};

fn swung(swing: Swing) -> PrescribedVelocity<f64, Dahl<f64>, Swing> {
    PrescribedVelocity::new(dahl(), swing)
}

#[test]
fn a_dense_trajectory_answers_at_every_time_it_reached() {
    for (from, to) in [(0.0, 5.0), (-3.0, -1.0)] {
        every_solver!(0.05, tolerance(1e-9), |name, solver| {
            let start = Oscillator::exact(from);
            let run = solver.solve(&Oscillator, from..to, start, Output::Dense).unwrap();
            for i in 0..=1000 {
                let time = if i == 1000 { to } else { from + (to - from) * 0.001 * f64::from(i) };
                let state = run.at(time).unwrap();
                // h⁴/120 per radian for RK4.
                assert!((state - Oscillator::exact(time)).norm() < 1e-6, "{name} at {time}");
            }
            // At the ends of the steps exactly what was stored.
            for (time, state) in run.iter() {
                assert_eq!(run.at(time), Some(*state), "{name} at {time}");
            }
            assert_eq!(run.at(from - 1e-9), None, "{name}");
            assert_eq!(run.at(to + 1e-9), None, "{name}");
            assert_eq!(run.at(f64::NAN), None, "{name}");
        });
    }
}

#[test]
fn a_dense_trajectory_stores_the_steps() {
    every_solver!(0.05, tolerance(1e-6), |name, solver| {
        let start = Oscillator::exact(0.0);
        let dense = solver.solve(&Oscillator, 0.0..3.0, start, Output::Dense).unwrap();
        let steps = solver.solve(&Oscillator, 0.0..3.0, start, Output::Steps).unwrap();
        assert_eq!((dense.times(), dense.states()), (steps.times(), steps.states()), "{name}");
        assert_eq!(
            but_evaluations(dense.statistics()),
            but_evaluations(steps.statistics()),
            "{name}"
        );
        // Without dense output there is nothing between the samples.
        assert_eq!(steps.at(1.0), None, "{name}");
    });
}

#[test]
fn a_dense_trajectory_ends_where_an_event_stops_it() {
    let position = |_: f64, x: &Vector2<f64>| x[0];
    every_solver!(0.05, tolerance(1e-9), |name, solver| {
        let events = [Event { function: &position, direction: Direction::Falling, stops: true }];
        let start = Oscillator::exact(0.0);
        let run = solver.solve_with_events(&Oscillator, 0.0..5.0, start, &events, Output::Dense);
        let run = run.unwrap();
        let (end, state) = run.last().unwrap();
        assert_eq!(run.at(end), Some(*state), "{name}");
        assert_eq!(run.at(end + 1e-9), None, "{name}");
        for i in 0..100 {
            let time = end * 0.01 * f64::from(i);
            let error = (run.at(time).unwrap() - Oscillator::exact(time)).norm();
            // The last step keeps its interpolant when it is shortened.
            assert!(error < 1e-6, "{name} at {time}: {error:e}");
        }
    });
}

#[test]
fn a_step_that_is_shortened_at_a_stop_keeps_its_curve() {
    let position = |_: f64, x: &Vector2<f64>| x[0];
    every_solver!(0.7, tolerance(1e-3), |name, solver| {
        let stop = [Event { function: &position, direction: Direction::Falling, stops: true }];
        let start = Oscillator::exact(0.0);
        let whole = solver.solve(&Oscillator, 0.0..5.0, start, Output::Dense).unwrap();
        let cut = solver.solve_with_events(&Oscillator, 0.0..5.0, start, &stop, Output::Dense);
        let cut = cut.unwrap();
        let end = cut.last().unwrap().0;
        for i in 0..=100 {
            let time = f64::min(end * 0.01 * f64::from(i), end);
            let difference = (cut.at(time).unwrap() - whole.at(time).unwrap()).norm();
            // The same polynomial, written from its start to another end.
            assert!(difference < 1e-14, "{name} at {time}: {difference:e}");
        }
    });
}

#[test]
fn a_failed_run_says_so_and_answers_until_then() {
    let breaks =
        Field(|t: f64, _: &Vector1<f64>| Vector1::new(if t < 0.5 { 2.0 } else { f64::NAN }));
    every_solver!(0.03, tolerance(1e-6), |name, solver| {
        let run = solver.solve(&breaks, 0.0..1.0, Vector1::new(0.0), Output::Dense);
        let trajectory = run.unwrap_err().trajectory.unwrap();
        let state = trajectory.at(0.25).unwrap();
        // The Rosenbrock methods' weights of up to 165 magnify the rounding of 1e-16.
        assert!((state[0] - 0.5).abs() < 1e-13, "{name}: {state}");
        assert_eq!(trajectory.at(0.75), None, "{name}");
    });
}

#[test]
fn every_reversal_is_reported_with_its_time() {
    // The sixth part of a turn after a zero, and at a zero: then the velocity is zero at the end of
    // every tenth, fourteenth or twentieth step, give or take a rounding, and a step that ends
    // there must be neither split into nothing nor run past.
    for (phase, parts) in [(0.3, 23), (-1.0, 31), (0.0, 20), (0.0, 28), (0.0, 40)] {
        for frequency in [0.1, 0.3, 0.7, 1.0, 1.3, 7.0] {
            // Slow enough for a stable step: σ0 v/μ_d below 1 per step.
            let amplitude = 0.05 * frequency * f64::from(parts);
            let swing = Swing { amplitude, angular: std::f64::consts::TAU * frequency, phase };
            let (end, fixed) = (4.75 / frequency, 1.0 / (frequency * f64::from(parts)));
            let turns = |n: i32| std::f64::consts::PI * f64::from(n) - phase;
            let times: Vec<f64> = (0..11).map(|n| turns(n) / swing.angular).collect();
            let times: Vec<f64> = times.into_iter().filter(|&t| t > 0.0 && t < end).collect();
            every_solver!(fixed, tolerance(1e-6), |name, solver| {
                let run = solver.solve(&swung(swing), 0.0..end, Vector1::new(0.0), Output::Steps);
                let run = run.unwrap();
                assert_eq!(run.reversals().len(), times.len(), "{name}, {swing:?}");
                for (reversal, time) in run.reversals().iter().zip(&times) {
                    // A zero of the velocity itself, to roundings of a time of 50 s.
                    assert_eq!(reversal.index, 0, "{name}");
                    assert!((reversal.time - time).abs() < 1e-12, "{name}: {reversal:?} {time}");
                }
                assert_eq!(run.statistics().reversals, times.len() as u64, "{name}, {swing:?}");
                assert!(run.times().windows(2).all(|pair| pair[1] > pair[0]), "{name}, {swing:?}");
                if !name.contains("adaptive") {
                    let steps = (4.75 * f64::from(parts)).ceil() as u64;
                    let most = steps + run.statistics().reversals;
                    assert!((steps..=most).contains(&run.statistics().steps), "{name}, {swing:?}");
                }
            });
        }
    }
}

#[test]
fn the_contact_that_reverses_is_named_and_the_first_comes_first() {
    /// Two contacts that slide at given velocities, which pass zero at given times.
    #[derive(Debug)]
    struct Two([f64; 2]);
    impl System<f64, 1, 2> for Two {
        fn rate(&self, t: f64, x: &Vector1<f64>, [a, b]: [Branch; 2]) -> Vector1<f64> {
            let [first, second] = self.sliding_velocities(t, x);
            Vector1::new(a.of(first).direction() + 10.0 * b.of(second).direction())
        }
        fn sliding_velocities(&self, t: f64, _: &Vector1<f64>) -> [f64; 2] {
            self.0.map(|zero| t - zero)
        }
    }
    for (zeros, order) in [([0.7, 0.3], [1, 0]), ([0.3, 0.7], [0, 1])] {
        for step in [0.1, 0.23, 5.0] {
            every_solver!(step, tolerance(1e-6), |name, solver| {
                let two = Two(zeros);
                let run = solver.solve(&two, 0.0..1.0, Vector1::new(0.0), Output::Steps).unwrap();
                let contacts: Vec<_> = run.reversals().iter().map(|r| r.index).collect();
                assert_eq!(contacts, order, "{name} by {step}: {:?}", run.reversals());
                assert!((run.reversals()[0].time - 0.3).abs() < 1e-14, "{name}");
                assert!((run.reversals()[1].time - 0.7).abs() < 1e-14, "{name}");
                // 1 − 2 t₀ from each, exact to rounding.
                let exact = 1.0 - 2.0 * zeros[0] + 10.0 * (1.0 - 2.0 * zeros[1]);
                let error = run.last().unwrap().1[0] - exact;
                assert!(error.abs() < 1e-13, "{name} by {step}: {error:e}");
            });
        }
    }
}

#[test]
fn a_reversal_is_not_reported_before_the_velocity_is_zero_however_coarse_the_dense_output() {
    /// v = 1 − tⁿ, which falls far too sharply for the dense output of a step of 0.3 or more.
    #[derive(Debug)]
    struct Fall(i32);
    impl System<f64, 1> for Fall {
        fn rate(&self, t: f64, _: &Vector1<f64>, _: [Branch; 1]) -> Vector1<f64> {
            Vector1::new(-f64::from(self.0) * t.powi(self.0 - 1))
        }
        fn sliding_velocities(&self, _: f64, v: &Vector1<f64>) -> [f64; 1] {
            [v[0]]
        }
    }
    for power in [4, 6, 8, 12, 20] {
        for step in [0.2, 0.3, 0.45, 0.7, 1.1, 1.3] {
            every_solver!(step, tolerance(1e-6), |name, solver| {
                let start = Vector1::new(1.0);
                let run = solver.solve(&Fall(power), 0.0..1.4, start, Output::Dense).unwrap();
                assert_eq!(run.reversals().len(), 1, "{name} by {step}");
                let v = run.at(run.reversals()[0].time).unwrap()[0];
                // To a hundredth of the velocity at the start of its step, at most 1.
                assert!(v < 0.01, "{name} by {step}: {v} for {power}");
            });
        }
    }
}

#[test]
fn a_step_says_whether_it_ends_at_a_reversal() {
    let swing = Swing { amplitude: 0.5, angular: 2.0, phase: 0.3 };
    every_solver!(0.03, tolerance(1e-6), |name, solver| {
        let system = swung(swing);
        let mut run = solver.begin(&system, 0.0..5.0, Vector1::new(0.0)).unwrap();
        let mut reversals = 0;
        while let Some(step) = run.advance().unwrap() {
            let velocity = system.velocity(step.end_time());
            match step.reversal() {
                // Rounding of the angle, times the slope of the velocity.
                Some(contact) => assert!(contact == 0 && velocity.abs() < 1e-13, "{name}"),
                None => assert!(velocity.abs() > 1e-9, "{name}"),
            }
            reversals += u64::from(step.reversal().is_some());
            assert_eq!(run.statistics().reversals, reversals, "{name}");
        }
        assert_eq!(reversals as usize, swing.reversals(5.0).len(), "{name}");
    });
}

#[test]
fn between_the_ends_of_steps_that_stability_holds_a_curve_keeps_its_tolerance() {
    /// ẋ = λ (cos t − x).
    struct Relaxing(f64);
    impl System<f64, 1, 0> for Relaxing {
        fn rate(&self, time: f64, x: &Vector1<f64>, _: [Branch; 0]) -> Vector1<f64> {
            Vector1::new(self.0 * (time.cos() - x[0]))
        }
        fn sliding_velocities(&self, _: f64, _: &Vector1<f64>) -> [f64; 0] {
            []
        }
    }
    let rate = 3000.0f64;
    let exact = |time: f64| {
        let slow = rate * time.cos() + time.sin() - rate * (-rate * time).exp();
        slow * rate / (1.0 + rate * rate)
    };
    let tolerances = Tolerances::scaled(1e-4, Vector1::new(1.0)).unwrap();
    let solver = Solver::checked(DormandPrince8, tolerances);
    let run = solver.solve(&Relaxing(rate), 0.0..10.0, Vector1::new(0.0), Output::Uniform(2001));
    let worst = run
        .unwrap()
        .iter()
        .fold(0.0, |most, (time, x)| f64::max(most, (x[0] - exact(time)).abs() / 1e-4));
    // Where the fast mode was not followed between the ends, it was 9 tolerances.
    assert!(worst < 3.0, "{worst}");
}
