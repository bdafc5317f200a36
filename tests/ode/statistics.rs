//! Statistics are exact counts, and no method costs more than it has to.
#![cfg(feature = "alloc")]

use bristle::ode::{DormandPrince, Output, RungeKutta4, Statistics, Tolerances};
use bristle::scene::PrescribedVelocity;
use bristle::signal::Function;
use bristle_specimens::ode::{
    Counted, Field, Integral, OfAny, Oscillator, Swing, dahl, every_method, every_solver,
    stick_slip, tolerance,
};
use nalgebra::{Vector1, Vector2, Vector3};

#[test]
fn evaluations_are_counted_to_the_last_one() {
    let rig = stick_slip::<f64>();
    let swing = Swing { amplitude: 0.5, angular: 2.0, phase: 0.0 };
    let bristle = PrescribedVelocity::new(dahl(), swing);
    every_solver!(0.004, Tolerances::scaled(1e-5, rig.scales()).unwrap(), |name, solver| {
        for solver in [solver, solver.plain()] {
            let system = Counted::new(rig);
            let run = solver.solve(&system, 0.0..11.0, rig.at_rest(), Output::Uniform(50)).unwrap();
            assert_eq!(run.statistics().evaluations, system.calls.get(), "{name}");
        }
    });
    every_solver!(0.03, tolerance(1e-6), |name, solver| {
        let system = Counted::new(bristle);
        let mut run = solver.begin(&system, 0.0..5.0, Vector1::new(0.0)).unwrap();
        loop {
            assert_eq!(run.statistics().evaluations, system.calls.get(), "{name}");
            if run.advance().unwrap().is_none() {
                break;
            }
        }
        assert!(run.statistics().reversals > 0, "{name}");
    });
    let jump = Function::new(|t: f64| (if t < 0.5 { 1.0 } else { 2.0 }, 0.0), [0.5]);
    every_solver!(0.03, tolerance(1e-6), |name, solver| {
        let system = Counted::new(Integral(jump));
        let run = solver.solve(&system, 0.0..1.0, Vector1::new(0.0), Output::Steps).unwrap();
        assert_eq!(run.statistics().evaluations, system.calls.get(), "{name}");
    });
}

#[test]
fn evaluations_of_a_run_that_fails_are_counted_too() {
    let breaks = |t: f64, _: &Vector1<f64>| Vector1::new(if t < 0.5 { 1.0 } else { f64::NAN });
    every_solver!(0.03, tolerance(1e-6), |name, solver| {
        let system = Counted::new(Field(breaks));
        let run = solver.solve(&system, 0.0..1.0, Vector1::new(0.0), Output::Steps);
        let statistics = run.unwrap_err().statistics;
        assert_eq!(statistics.evaluations, system.calls.get(), "{name}");
        assert!(statistics.rejected > 0, "{name}");
    });
}

#[test]
fn a_plain_step_of_runge_kutta_costs_four_evaluations() {
    let rig = stick_slip::<f64>();
    let solver = OfAny::fixed(RungeKutta4, 1.0 / 256.0).unwrap().plain();
    let run = solver.solve(&rig, 0.0..8.0, rig.at_rest(), Output::Uniform(3)).unwrap();
    // And one for the first rate.
    let expected = Statistics { steps: 2048, evaluations: 4 * 2048 + 1, ..Statistics::default() };
    assert_eq!(run.statistics(), expected);

    let system = Counted::new(Oscillator);
    RungeKutta4::step(&system, 0.0, &Vector2::new(1.0, 0.0), 0.1);
    assert_eq!(system.calls.get(), 4);
}

#[test]
fn a_step_of_dormand_and_prince_costs_six_evaluations() {
    // Seven stages, the last of which is the first of the next step. Two first rates: one to see
    // whether there is a solution, one on the branch on which it starts.
    let solver = OfAny::fixed(DormandPrince, 0.125).unwrap();
    for (solver, first) in [(solver, 2), (solver.plain(), 1)] {
        let run = solver.solve(&Oscillator, 0.0..8.0, Vector2::new(1.0, 0.0), Output::Uniform(3));
        let statistics = run.unwrap().statistics();
        assert_eq!((statistics.steps, statistics.rejected), (64, 0));
        assert!(statistics.evaluations <= 6 * 64 + first, "{statistics}");
        assert!(statistics.evaluations > 6 * 64, "{statistics}");
    }
    // Adaptive: rejected trials cost as much, but for the last stage; one more for the first step.
    let solver = OfAny::adaptive(DormandPrince, tolerance(1e-9));
    let run = solver.solve(&Oscillator, 0.0..8.0, Vector2::new(1.0, 0.0), Output::Uniform(3));
    let Statistics { steps, rejected, evaluations, .. } = run.unwrap().statistics();
    assert!(evaluations <= 6 * (steps + rejected) + 3, "{evaluations} in {steps} + {rejected}");
    // The growth of errors takes one evaluation more per step and state where a system gives no
    // derivatives, and another Jacobian at the start.
    let solver = OfAny::checked(DormandPrince, tolerance(1e-9));
    let mut run = solver.begin(&Oscillator, 0.0..8.0, Vector2::new(1.0, 0.0)).unwrap();
    while run.advance().unwrap().is_some() {}
    let Statistics { steps, rejected, evaluations, jacobians, .. } = run.statistics();
    assert_eq!(jacobians, steps + 1);
    let most = 6 * (steps + rejected) + 2 * jacobians + 3;
    assert!(evaluations <= most, "{evaluations} in {steps} + {rejected}");
}

#[test]
fn a_reversal_costs_a_step_and_a_rate() {
    // One trial that is cut, the step that is taken instead, and the rate on the other branch.
    every_method!(|name, method, order, dense| {
        let swing = Swing { amplitude: 0.5, angular: 2.0, phase: 0.3 };
        let bristle = PrescribedVelocity::new(dahl(), swing);
        let solver = OfAny::fixed(method, 0.03125).unwrap();
        let run = solver.solve(&bristle, 0.0..8.0, Vector1::new(0.0), Output::Uniform(3));
        let statistics = run.unwrap().statistics();
        let reversals = swing.reversals(8.0).len() as u64;
        assert_eq!(statistics.reversals, reversals, "{name}");
        assert_eq!(statistics.rejected, reversals, "{name}");
        assert_eq!(statistics.steps, 256 + reversals, "{name}");
        // The others evaluate more for a dense output or the Jacobian.
        let stages = match name {
            "RungeKutta4" => Some(4),
            "DormandPrince" => Some(6),
            _ => None,
        };
        let trials = statistics.steps + statistics.rejected;
        if let Some(stages) = stages {
            assert_eq!(statistics.evaluations, stages * trials + reversals + 2, "{name}");
        }
    });
}

#[test]
fn statistics_read_as_a_sentence() {
    let statistics =
        Statistics { steps: 5, rejected: 4, evaluations: 3, jacobians: 2, reversals: 1 };
    assert_eq!(
        statistics.to_string(),
        "5 steps, 4 rejected, 3 evaluations, 2 Jacobians, 1 reversals"
    );
}

#[test]
fn rejected_steps_leave_no_trace_but_their_count() {
    // A first step that is far too long is taken back, and the run is as good as another.
    let rig = stick_slip::<f64>();
    let solver = OfAny::checked(DormandPrince, Tolerances::scaled(1e-8, rig.scales()).unwrap());
    let end = |solver: OfAny<f64, DormandPrince, 3>| {
        let run = solver.solve(&rig, 0.0..1.0, Vector3::new(0.0, 0.0, 1e-5), Output::Uniform(2));
        let run = run.unwrap();
        (*run.last().unwrap().1, run.statistics().rejected)
    };
    let (state, _) = end(solver);
    let (other, rejected) = end(solver.with_first_step(0.9).unwrap());
    assert!(rejected > 1, "{rejected}");
    let error = (state - other).component_div(&rig.scales()).abs().max();
    assert!(error < 1e-7, "{error:e}");
}

#[test]
fn a_kink_does_not_make_the_steps_after_it_short() {
    // Two kinks a millionth of a second apart, in a signal that hardly bends there.
    let close = Function::new(|t: f64| ((0.3 * t).sin(), f64::NAN), [5.0, 5.000_001]);
    let smooth = Function::new(|t: f64| ((0.3 * t).sin(), f64::NAN), []);
    let solver = OfAny::checked(DormandPrince, tolerance(1e-6));
    let steps = |run: Result<bristle::ode::Trajectory<f64, 1>, _>| {
        let run: Result<_, Box<bristle::ode::Failure<f64, 1>>> = run;
        run.unwrap().statistics().steps
    };
    let start = Vector1::new(0.0);
    let with = steps(solver.solve(&Integral(close), 0.0..20.0, start, Output::Steps));
    let without = steps(solver.solve(&Integral(smooth), 0.0..20.0, start, Output::Steps));
    // One more step for each of them, and one for what they displace; to grow again from a
    // microsecond, eightfold at a time, would take seven.
    assert!(with <= without + 4, "{with} {without}");
}
