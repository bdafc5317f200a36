//! What holds of every scene: the report, refusals, references that do not settle.

use bristle::curve::{Coulomb, CoulombParameters, FrictionCurve};
use bristle::signal::{Function, Signal, Sine, SineParameters};
use bristle::{Bristle, FrBd, ParameterError, Rule, Units};
use bristle_fidelity::*;
use nalgebra::Vector3;

use crate::known_velocity::{Lumped, sets};
use crate::mechanism::rig;
use crate::patch::rolling;
use bristle_specimens::specimens::{table_2_bristle, table_2_curve, table_2_frbd};

fn sine(mean: f64, amplitude: f64, frequency: f64) -> Sine<f64> {
    Sine::new(SineParameters { mean, amplitude, frequency, phase: 0.0 }).unwrap()
}

/// The paper's stick-slip set under 1 N along a velocity.
fn dragged<V: Signal<f64>>(
    velocity: V,
    interval: f64,
    answers: usize,
) -> Result<KnownVelocity<f64, Lumped, V>, ParameterError> {
    let answers = Answers { interval, count: answers };
    let scene = KnownVelocity::new(sets()[0].under_load(1.0)?, velocity, answers)?;
    Ok(scene.starting_steadily())
}

fn lag() -> KnownVelocity<f64, Lumped, Sine<f64>> {
    dragged(sine(0.0055, 0.005, 25.0), 4e-4, 1000).unwrap()
}

/// A mass on a spring whose far end moves steadily, from rest.
fn pulled(
    mass: f64,
    spring_stiffness: f64,
    drive_velocity: f64,
    (interval, answers): (f64, usize),
) -> MechanismScene<f64, Lumped, f64> {
    let contact = sets()[0].under_load(1.0).unwrap();
    let system = rig(contact, [mass, spring_stiffness, 0.0], drive_velocity, 0.0);
    let answers = Answers { interval, count: answers };
    MechanismScene::new(system, Vector3::zeros(), answers, Quantity::Position).unwrap()
}

#[test]
fn what_the_documentation_shows_is_what_comes_out() {
    let choice = choose(&lag(), Tolerance::at_every_answer(0.015)).unwrap();
    let text: Vec<String> = choice.to_string().lines().map(|l| l.trim_end().into()).collect();
    let text = text.join("\n");
    assert!(text.lines().all(|line| line.chars().count() <= 100), "it fits a page\n{text}");
    assert!(include_str!("../../../../docs/choosing.md").contains(&text), "{text}");
}

#[test]
fn the_report_lists_every_level_with_what_its_plan_costs_when_it_runs() {
    for scene in [&lag() as &dyn Scene, &pulled(1.0, 2.0, 0.1, (0.1, 100))] {
        let choice = choose(scene, Tolerance::at_every_answer(0.01)).unwrap();
        let levels: Vec<Level> = choice.trials.iter().map(|trial| trial.level).collect();
        assert_eq!(levels, scene.levels());
        for trial in &choice.trials {
            let run = scene.run(trial.level, trial.steps).unwrap();
            assert_eq!((run.evaluations, run.cost), (trial.evaluations, trial.cost));
            let (_, physics) = trial.physics.unwrap();
            assert!((0.0..=2.0).contains(&physics), "{choice}");
        }
    }
}

/// By how much the friction of a mass differs from that at rest, at steady sliding from the start.
fn variation<C: FrictionCurve<f64>>(curve: C, velocity: f64) -> f64 {
    let contact = FrBd::new(curve, table_2_bristle()).under_load(1.0).unwrap();
    let force = contact.stationary_force(velocity);
    let scene = MechanismScene::new(
        rig(contact, [1.0, 2.0, 0.0], velocity, 0.0),
        Vector3::new(-force / 2.0, velocity, force / 1e4),
        Answers { interval: 0.01, count: 20 },
        Quantity::Force,
    );
    let (name, variation) = scene.unwrap().physics(Level::DAHL_COMPANION, 4).unwrap();
    assert_eq!(name, "variation");
    variation
}

#[test]
fn friction_varies_by_its_viscous_part_and_by_its_fall() {
    let coulomb = CoulombParameters { dynamic_coefficient: 1.0, viscous_friction: 0.5 };
    let rising = variation(Coulomb::new(coulomb).unwrap(), 0.6);
    assert!((rising - 0.3).abs() < 1e-9, "{rising}"); // σ2 V/μ_d
    let falling = variation(table_2_curve(), 0.5);
    assert!((falling - (1.5 - 1.02) / 1.5).abs() < 1e-6, "{falling}"); // μ(V) = μ_d + σ2 V
    assert_eq!(variation(Coulomb::new(coulomb).unwrap(), 0.0), 0.0);
}

#[test]
fn the_report_of_a_joint_is_in_radians_and_newton_metres() {
    for (scene, line, joint) in [
        (&lag() as &dyn Scene, ("friction force", "N"), ("friction torque", "N m")),
        (&pulled(1.0, 2.0, 0.1, (0.1, 100)), ("position", "m"), ("angle", "rad")),
    ] {
        let tolerance = Tolerance::at_every_answer(0.01);
        let [first, other] = [Units::Translation, Units::Rotation]
            .map(|units| choose(scene, tolerance.in_units(units)).unwrap().to_string());
        for (text, (quantity, unit)) in [(&first, line), (&other, joint)] {
            assert!(text.starts_with(&format!("{quantity} within 0.01 {unit}, ")), "{text}");
            assert!(text.contains(&format!(" {unit}\n\n")), "settled to: {text}");
            assert!(text.contains(&format!("  error / {unit}  verdict")), "{text}");
        }
        // But for the words the reports are one.
        let numbers = |text: &str| -> Vec<f64> {
            text.split_whitespace().filter_map(|word| word.parse().ok()).collect()
        };
        assert_eq!(numbers(&first), numbers(&other));
    }
}

#[test]
fn levels_of_other_scenes_and_no_steps_are_refused() {
    let (scene, level) = (lag(), Level::REFERENCE);
    let error = scene.run(Level::PATCH, 1).unwrap_err();
    assert_eq!(error, FidelityError::NoSuchLevel(Level::PATCH));
    assert_eq!(error.to_string(), "this scene has no patch, exact hold");
    for steps in [0, (1 << 20) + 1, u32::MAX] {
        let error = scene.run(level, steps).unwrap_err();
        let FidelityError::Parameter(error) = error else { panic!("{error}") };
        assert_eq!((error.name, error.value), ("steps", f64::from(steps)));
    }
}

#[test]
fn senseless_input_is_refused_by_name() {
    let name = |scene: Result<_, ParameterError>| scene.map(|_| ()).unwrap_err().name;
    let steady = 0.1;
    for interval in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(name(dragged(steady, interval, 10).map(|_| ())), "interval");
    }
    for answers in [0, 1_000_001, usize::MAX] {
        let error = dragged(steady, 0.1, answers).unwrap_err();
        assert_eq!(error.rule, Rule::CountBetween { least: 1, most: 1_000_000 });
        assert_eq!(error.name, "answers");
        assert!(error.to_string().starts_with("there must be 1 to 1000000 answers"), "{error}");
    }
    let broken = |time: f64| (if time < 0.55 { 1.0 } else { f64::NAN }, 0.0);
    let error = dragged(Function::new(broken, []), 0.1, 10).unwrap_err();
    assert_eq!((error.name, error.component), ("velocity", Some(6)));
    for speed in [-1.0, f64::NAN] {
        let speed = Function::new(move |_: f64| (speed, 0.0), []);
        assert_eq!(name(rolling(steady, speed, 0.1, 10).map(|_| ())), "rolling_speed");
    }
    for (error, budget) in [(0.0, 1.0), (f64::NAN, 1.0), (1.0, -1.0), (1.0, f64::NAN)] {
        let tolerance = Tolerance { budget, ..Tolerance::at_every_answer(error) };
        let FidelityError::Parameter(error) = choose(&lag(), tolerance).unwrap_err() else {
            panic!("{tolerance:?}")
        };
        assert!(error.name.starts_with("tolerance."), "{error}");
    }
}

/// A mass that is pulled so slowly that it waits on the falling part of its curve. Its steady
/// sliding is unstable, σ = 8.668/s; it comes there at 22 s and slips at 24.37 s (multiple
/// precision of 30 and of 40 digits), when roundings have grown as large as the motion.
#[test]
#[ignore = "seconds, in release"]
fn a_slip_whose_time_roundings_decide_is_undetermined() {
    let scene = pulled(1.581_093_576e-2, 98.600_011, 7.519_596e-4, (1.893_790_26e-2, 1476));
    let error = choose(&scene, Tolerance::at_every_answer(1.37e-3)).unwrap_err();
    let FidelityError::Undetermined { difference, allowed, .. } = error else { panic!("{error}") };
    assert!(difference > 0.1 * allowed, "{error}");
    assert!(error.to_string().contains("roundings decide"));
}

/// A tolerance of a few roundings, a search whose budget has no third run, and one whose budget has
/// no second.
#[test]
fn what_cannot_settle_is_undetermined_and_says_by_how_much() {
    let text = |error: f64, budget: f64, units: Units| {
        let tolerance = Tolerance { budget, ..Tolerance::at_every_answer(error) };
        let error = choose(&lag(), tolerance.in_units(units)).unwrap_err();
        assert!(matches!(error, FidelityError::Undetermined { .. }), "{error}");
        error.to_string()
    };
    for (text, words) in [
        (text(1e-15, 1e6, Units::Translation), "N allowed"),
        (text(1e-7, 1e5, Units::Translation), "more than 0.1 times the 1e-7 N allowed"),
        (text(1e-7, 1e5, Units::Rotation), "more than 0.1 times the 1e-7 N m allowed"),
        (text(1e-7, 1.0, Units::Translation), "no second run within the budget"),
    ] {
        assert!(text.contains(words) && !text.contains("NaN"), "{text}");
    }
    // Two runs that agree do not differ by more than is allowed.
    let text = text(1e-5, 1e5, Units::Translation);
    assert!(text.contains("agree within") && !text.contains("more than"), "{text}");
}

#[test]
fn an_input_that_is_not_a_number_between_answers_stops_the_search_at_once() {
    let torn = |time: f64| {
        let at_answer = (time * 100.0 - (time * 100.0).round()).abs() < 1e-6;
        (if at_answer { 1e-3 } else { f64::NAN }, 0.0)
    };
    let refused = |error: FidelityError, name: &str| {
        let FidelityError::Parameter(error) = error else { panic!("{name}: {error}") };
        assert_eq!(error.name, name);
        assert!(error.value.is_nan(), "{error}");
    };
    let tolerance = Tolerance::at_every_answer(1e-3);
    let torn = Function::new(torn, []);
    refused(choose(&dragged(torn, 0.01, 100).unwrap(), tolerance).unwrap_err(), "velocity");
    let scene = rolling(torn, 1.0, 0.01, 100).unwrap();
    refused(choose(&scene, tolerance).unwrap_err(), "slip_velocity");
    let answers = Answers { interval: 0.01, count: 100 };
    let system = rig(sets()[0].under_load(1.0).unwrap(), [1.0, 0.0, 0.0], 0.0, torn);
    let scene = MechanismScene::new(system, system.at_rest(), answers, Quantity::Position).unwrap();
    refused(choose(&scene, tolerance).unwrap_err(), "force");
}

/// At a hundred periods and a whole number of them from one answer to the next, runs with 1, 2 and
/// 4 steps see the velocity at one phase only.
#[test]
fn what_happens_between_answers_is_seen() {
    for periods in [4.0, 8.0, 96.0, 100.0] {
        let scene = dragged(sine(0.0, 1e-3, periods), 1.0, 20).unwrap();
        let tolerance = Tolerance::at_every_answer(0.015);
        let choice = choose(&scene, tolerance).unwrap();
        let fine = scene.run(Level::REFERENCE, 12_345).unwrap();
        let found = scene.run(choice.best.level, choice.best.steps).unwrap();
        let off = crate::judge::distance(tolerance, &found.answers, &fine.answers);
        assert!(off <= 0.015, "{periods} {off}\n{choice}");
    }
}

#[test]
fn single_precision_gets_the_same_choice() {
    let wave = SineParameters { mean: 0.0055_f32, amplitude: 0.005, frequency: 25.0, phase: 0.0 };
    let contact = table_2_frbd::<f32>().under_load(1.0).unwrap();
    let answers = Answers { interval: 4e-4, count: 200 };
    let scene = KnownVelocity::new(contact, Sine::new(wave).unwrap(), answers).unwrap();
    let scene = scene.starting_steadily();
    let tolerance = Tolerance::at_every_answer(0.015);
    let [single, double] =
        [choose(&scene, tolerance), choose(&lag(), tolerance)].map(|choice| choice.unwrap().best);
    assert_eq!((single.level, single.steps), (double.level, double.steps));
}
