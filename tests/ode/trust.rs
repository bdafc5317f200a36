//! Success means success: errors that grow are seen, and steps are as tight as they ask. That no
//! run that answers is far off is the law of `drawn`.
#![cfg(feature = "alloc")]

use bristle::curve::{Stribeck, StribeckParameters};
use bristle::ode::{AnyMethod, Automatic, Output, Rodas5P, Solver, StopReason, Tolerances};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::scene::PrescribedVelocity;
use bristle::signal::{Sine, SineParameters};
use bristle::{Bristle, LuGre};
use bristle_specimens::ode::{Field, stick_slip, table_2_frbd};
use nalgebra::Vector1;

use crate::drawn::distance;

#[test]
fn steps_are_as_tight_as_the_growth_of_errors_asks() {
    let rig = stick_slip::<f64>();
    let solver = |tolerance: f64| {
        Solver::checked(Automatic, Tolerances::scaled(tolerance, rig.scales()).unwrap())
    };
    let solve = |tolerance: f64, end: f64| {
        solver(tolerance).solve(&rig, 0.0..end, rig.at_rest(), Output::Uniform(2)).unwrap()
    };
    // Stuck, errors die out: one run. Slips repeat it, and all its steps are rejected.
    let (stuck, slipping) = (solve(1e-6, 5.0).statistics(), solve(1e-6, 25.0).statistics());
    assert!(stuck.rejected < stuck.steps / 4, "{stuck}");
    assert!(slipping.rejected > slipping.steps / 10, "{slipping}");
}

#[test]
fn a_bristle_at_a_given_velocity_takes_loose_steps_of_order_five() {
    let contact = table_2_frbd().under_load(1.0).unwrap();
    let velocity = SineParameters { mean: 0.0055, amplitude: 0.005, frequency: 50.0, phase: 0.0 };
    let scene = PrescribedVelocity::new(contact, Sine::new(velocity).unwrap());
    let solve = |method: AnyMethod, tolerance: f64| {
        let tolerances = Tolerances::scaled(tolerance, scene.scales()).unwrap();
        let solver = Solver::checked(method, tolerances);
        solver.solve(&scene, 0.0..0.4, Vector1::new(0.0), Output::Uniform(1001)).unwrap()
    };
    // A trial of order 5 evaluates six rates, and up to two where hardly anything moves; one of
    // order 8 twelve, and three for the samples.
    for (tolerance, least, most) in [(1e-3, 5.5, 8.0), (1e-4, 5.5, 6.5), (1e-9, 12.0, 16.0)] {
        let automatic = solve(AnyMethod::Automatic, tolerance);
        let statistics = automatic.statistics();
        let trials = (statistics.steps + statistics.rejected) as f64;
        let of_a_trial = statistics.evaluations as f64 / trials;
        assert!(of_a_trial > least && of_a_trial < most, "{tolerance:e}: {statistics}");
        // Over 24 tolerances from 1e-3 to 3e-7 its error is 0.1 to 2.3 of them, by chance.
        let fine = solve(AnyMethod::Rodas5P, 1e-10);
        let error = distance(&automatic, &fine, &scene.scales());
        assert!(error < f64::max(3.0 * tolerance, 1e-8), "{tolerance:e}: {error:e}");
    }
}

#[test]
fn a_run_whose_errors_outgrow_its_tolerance_is_repeated_or_stopped() {
    // x = cos t, from which every error grows as e^20t.
    let unstable =
        Field(|time: f64, x: &Vector1<f64>| Vector1::new(20.0 * (x[0] - time.cos()) - time.sin()));
    let (start, tolerance) = (Vector1::new(1.0), 1e-6);
    let tolerances = Tolerances::scaled(tolerance, start).unwrap();
    let judge = |method: AnyMethod, repeats: bool| {
        let solver = Solver::checked(method, tolerances);
        // A stream stops where errors have grown too much: steps are 4000 times as tight, the
        // estimate may exceed the tolerance tenfold, and a hundred steps add up.
        let mut run = solver.begin(&unstable, 0.0..1.0, start).unwrap();
        let stopped = loop {
            match run.advance() {
                Ok(Some(_)) => {}
                Ok(None) => panic!("{method:?}: the errors did not grow"),
                Err(failure) => break failure,
            }
        };
        let StopReason::ErrorsGrow { times } = stopped.reason else { panic!("{stopped}") };
        assert!(times > 1.0 && times < 1e4, "{method:?}: {times}");
        assert!(run.advance().is_err(), "{method:?}");
        // Repeated with tighter steps it arrives: errors have grown by e^14 = 1.2e6.
        let answer = solver.solve(&unstable, 0.0..0.7, start, Output::Steps).unwrap();
        let statistics = answer.statistics();
        let repeated = statistics.rejected > statistics.steps / 5;
        assert_eq!(repeated, repeats, "{method:?}: {statistics}");
        for (time, state) in answer.iter() {
            let error = (state[0] - time.cos()).abs();
            assert!(error < 4e-6, "{method:?}: {error:e} at {time}");
        }
        // No steps are tight enough for e^40.
        let failure = solver.solve(&unstable, 0.0..2.0, start, Output::Steps).unwrap_err();
        assert!(matches!(failure.reason, StopReason::ErrorsGrow { .. }), "{method:?}: {failure}");
        assert!(failure.to_string().contains("what the tolerances allow"), "{failure}");
        // Steps with a tolerance of their own go on, far off.
        let solver = Solver::adaptive(method, tolerances);
        let wrong = solver.solve(&unstable, 0.0..1.0, start, Output::Steps).unwrap();
        let (time, state) = wrong.last().unwrap();
        assert!((state[0] - time.cos()).abs() > 1e-2, "{method:?}");
    };
    judge(AnyMethod::DormandPrince, true);
    judge(AnyMethod::DormandPrince8, true);
    judge(AnyMethod::Rodas4, true);
    // Steps that follow e^20t from below the tolerance are tight enough for it at once.
    judge(AnyMethod::Rodas5P, false);
    judge(AnyMethod::Automatic, true);
}

#[test]
fn a_step_does_not_pass_over_two_reversals_of_a_prescribed_velocity() {
    // In the quasi-steady sliding of LuGre nothing else shortens the steps.
    let curve = Stribeck::new(StribeckParameters {
        static_coefficient: 1.2,
        dynamic_coefficient: 0.9,
        stribeck_velocity: 1e-3,
        stribeck_exponent: 2.0,
        viscous_friction: 0.0,
    });
    let bristle = KelvinVoigtParameters { micro_stiffness: 1e6, micro_damping: 10.0 };
    let bristle = KelvinVoigt::new(bristle).unwrap();
    let contact = LuGre::classical(curve.unwrap(), bristle).under_load(1.0).unwrap();
    let velocity = SineParameters { mean: 0.0055, amplitude: 0.01, frequency: 25.0, phase: 0.0 };
    let scene = PrescribedVelocity::new(contact, Sine::new(velocity).unwrap());
    let tolerances = Tolerances::scaled(1e-3, scene.scales()).unwrap();
    let solver = Solver::checked(Rodas5P, tolerances);
    let run = solver.solve(&scene, 0.0..0.2, Vector1::new(0.0), Output::Steps).unwrap();
    // Two in each of five periods.
    assert_eq!(run.reversals().len(), 10);
    let longest = run.times().windows(2).fold(0.0, |most, pair| f64::max(most, pair[1] - pair[0]));
    assert!(longest <= 0.01 * (1.0 + 1e-12), "{longest}");
}
