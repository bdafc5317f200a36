//! Bristles along a known velocity.

use bristle::curve::Stribeck;
use bristle::ode::{Output, Rodas5P, Solver, System, Tolerances};
use bristle::rheology::{
    Deflection, GeneralisedMaxwell, KelvinVoigt, Rheology, States, ZenerParameters,
};
use bristle::scene::PrescribedVelocity;
use bristle::signal::{Signal, Sine, SineParameters};
use bristle::{Bristle, Contact, FrBd, paper};
use bristle_fidelity::*;
use nalgebra::SVector;

use crate::judge::{ALL, Tally};
use bristle_specimens::draw::{Draw, Shape, Wave};
use bristle_specimens::specimens::{elasto_plastic, table_2_bristle, table_2_curve, table_2_lugre};

pub(crate) type Lumped = FrBd<Stribeck<f64>, KelvinVoigt<f64>>;

/// The paper's stick-slip rig, its tyre and its valve.
pub(crate) fn sets() -> [Lumped; 3] {
    [
        (paper::STICK_SLIP_CURVE, paper::STICK_SLIP_BRISTLE),
        (paper::TYRE_CURVE, paper::TYRE_BRISTLE),
        (paper::VALVE_CURVE, paper::VALVE_BRISTLE),
    ]
    .map(|(curve, bristle)| {
        FrBd::new(Stribeck::new(curve).unwrap(), KelvinVoigt::new(bristle).unwrap())
    })
}

/// The paper's stick-slip curve with a Maxwell element beside a spring.
fn zener(series_damping: f64) -> FrBd<Stribeck<f64>, GeneralisedMaxwell<f64, 2>> {
    let (static_stiffness, relaxing_stiffness) = (1e4, 2e4);
    let zener = ZenerParameters { static_stiffness, relaxing_stiffness, series_damping };
    FrBd::new(table_2_curve(), GeneralisedMaxwell::zener(zener).unwrap())
}

/// The forces by Rodas5P under error control, which shares no step with any level; between the
/// jumps of a square wave exactly.
fn truth<M: Bristle<f64>, const N: usize>(
    contact: &Contact<f64, M>,
    velocity: &Wave,
    answers: Answers<f64>,
    steady: bool,
) -> Vec<f64>
where
    M::Deflection: States<f64, N>,
{
    let (contact, velocity) = (contact.clone(), velocity.clone().declared());
    let Answers { interval, count } = answers;
    let times: Vec<f64> = (1..=count).map(|answer| interval * answer as f64).collect();
    if let Wave::Repeated { shape: Shape::Square, .. } = velocity {
        let mut time = 0.0;
        let mut z =
            if steady { contact.stationary(velocity.value(0.0)) } else { M::Deflection::fill(0.0) };
        let to_answer = |answer: &f64| {
            while time < *answer {
                let next = velocity.next_kink(time, *answer).unwrap_or(*answer);
                z = contact.hold(velocity.value(time), z, next - time).deflection;
                time = next;
            }
            contact.force(velocity.value(*answer), z)
        };
        return times.iter().map(to_answer).collect();
    }
    let system = PrescribedVelocity::new(contact, velocity);
    let state: SVector<f64, N> = if steady { system.stationary(0.0) } else { SVector::zeros() };
    let tolerances = Tolerances::scaled(1e-9, System::<f64, N, 1>::scales(&system)).unwrap();
    let solver = Solver::checked(Rodas5P, tolerances);
    let solver = solver.with_largest_step(interval / 4.0).unwrap();
    let span = 0.0..interval * count as f64;
    let run = solver.solve(&system, span, state, Output::Times(&times)).unwrap();
    let forces = times.iter().zip(run.states());
    forces.map(|(time, state)| system.friction_force(*time, state)).collect()
}

#[test]
fn a_bristle_starts_at_rest_or_steadily_at_every_level_that_has_one() {
    let contact = sets()[0].under_load(1.0).unwrap();
    // Over 8e-6 m, a twentieth of what it deflects while it slides.
    let sine = SineParameters { mean: 0.008, amplitude: 0.0, frequency: 1.0, phase: 0.0 };
    let velocity = Sine::new(sine).unwrap();
    let scene =
        KnownVelocity::new(contact, velocity, Answers { interval: 1e-3, count: 1 }).unwrap();
    let steady = contact.stationary_force(0.008);
    for level in [Level::DAHL, Level::REFERENCE] {
        let first = |scene: &KnownVelocity<_, _, _>| scene.run(level, 1).unwrap().answers[0];
        let from_rest = first(&scene);
        assert!(from_rest > 0.03 * steady && from_rest < 0.5 * steady, "{level}: {from_rest}");
    }
    let scene = scene.starting_steadily();
    let slides = scene.run(Level::REFERENCE, 1).unwrap().answers[0];
    assert!((slides / steady - 1.0).abs() < 1e-12, "{slides}");
}

fn study(scenes: usize, most_answers: f64) -> Tally {
    let mut dice = Draw::seeded(31_415);
    let mut tally = Tally::default();
    for index in 0..scenes {
        let amplitude = dice.logarithmic(1e-6, 10.0);
        let frequency = dice.logarithmic(0.01, 1000.0);
        let mean = amplitude * dice.one_of(&[0.0, 0.0, 0.3, 1.1, 2.0]);
        // Also periods of large prime numbers of answers, and of less than an answer.
        let per_period = dice.one_of(&[36.0, 50.0, 97.0, 100.0, 211.0, 7.3, 1.0, 0.31]);
        let interval = 1.0 / (frequency * per_period);
        let answers = dice.logarithmic(20.0, most_answers) as usize;
        let steady = dice.one_of(&[false, true]);
        let root_mean_square = dice.one_of(&[false, true]);
        let share = dice.logarithmic(1e-3, 0.2);
        let velocity = dice.wave(mean, amplitude, frequency, interval * answers as f64);
        let what =
            format!("{index:3} {velocity:?}, {answers} answers, {interval:.2e} s, steady {steady}");
        let tolerance = |contact: &Contact<f64, Lumped>| {
            let scale = contact.limits(mean + amplitude).force.unwrap();
            Tolerance { root_mean_square, ..Tolerance::at_every_answer(share * scale) }
        };
        let answers = Answers { interval, count: answers };
        let lumped = sets()[index % 3].under_load(1.0).unwrap();
        if index % 4 == 3 {
            let contact = zener(dice.logarithmic(10.0, 1e4)).under_load(2.0).unwrap();
            let truth = truth::<_, 2>(&contact, &velocity, answers, steady);
            let scene = KnownVelocity::new(contact, velocity, answers).unwrap();
            let below = lumped_frbd(contact.model(), scene.angular_frequency()).unwrap();
            let scene = scene.with_lumped(below).unwrap();
            let scene = if steady { scene.starting_steadily() } else { scene };
            tally.judge(&scene, tolerance(&lumped), &truth, &format!("{what}, Zener"));
        } else {
            let truth = truth::<_, 1>(&lumped, &velocity, answers, steady);
            let scene = KnownVelocity::new(lumped, velocity, answers).unwrap();
            let scene = if steady { scene.starting_steadily() } else { scene };
            tally.judge(&scene, tolerance(&lumped), &truth, &what);
        }
    }
    tally
}

#[test]
fn no_choice_along_a_drawn_velocity_is_wrong_and_hardly_one_is_dear() {
    study(12, 60.0).verdict(0); // every set, every fourth scene with Zener's bristle
}

#[test]
#[ignore = "minutes, in release"]
fn no_choice_along_three_hundred_drawn_velocities_is_wrong() {
    study(ALL, 10_000.0).verdict(0);
}

#[test]
fn lugre_and_elasto_plastic_friction_can_be_the_reference() {
    fn chosen<M: Bristle<f64>>(friction: M) -> Level {
        let velocity = SineParameters { mean: 0.0, amplitude: 1e-4, frequency: 1.0, phase: 0.0 };
        let (contact, velocity) = (friction.under_load(1.0).unwrap(), Sine::new(velocity).unwrap());
        let scene = KnownVelocity::new(contact, velocity, Answers { interval: 0.01, count: 200 });
        choose(&scene.unwrap(), Tolerance::at_every_answer(1e-6)).unwrap().best.level
    }
    assert_eq!(chosen(table_2_lugre()), Level::REFERENCE);
    let soft = elasto_plastic(table_2_curve(), table_2_bristle(), 0.7e-4);
    assert_eq!(chosen(soft), Level::REFERENCE);
}

#[test]
fn a_level_of_one_spring_is_there_where_it_was_given() {
    let friction = zener(1e3);
    let velocity = SineParameters { mean: 0.0, amplitude: 1e-4, frequency: 1.0, phase: 0.0 };
    let answers = Answers { interval: 0.01, count: 100 };
    let contact = friction.under_load(1.0).unwrap();
    let scene = KnownVelocity::new(contact, Sine::new(velocity).unwrap(), answers).unwrap();
    assert_eq!(scene.levels(), [Level::STATIC_CURVE, Level::DAHL, Level::REFERENCE]);
    assert!(matches!(
        scene.run(Level::LUMPED, 1).unwrap_err(),
        FidelityError::NoSuchLevel(Level::LUMPED)
    ));
    // No deflection of a bristle of several springs has a limit.
    assert_eq!(scene.physics(Level::DAHL, 1), None);
    // The velocity turns by ω, as the answers see it; the lumped bristle answers as the bristle.
    let omega = scene.angular_frequency();
    assert!((omega / std::f64::consts::TAU - 1.0).abs() < 1e-3, "{omega}");
    let lumped = lumped_frbd(&friction, omega).unwrap();
    assert_eq!(lumped.storage_stiffness(), friction.rheology().complex_modulus(omega).re);
    let scene = scene.with_lumped(lumped).unwrap();
    assert!(scene.levels().contains(&Level::LUMPED) && scene.physics(Level::DAHL, 1).is_some());
}

/// The stiffness stays that of the reference load, and the load scales the friction.
#[test]
fn a_contact_that_is_measured_at_another_load_keeps_its_stiffness_at_every_level() {
    let answers = Answers { interval: 1e-3, count: 10 };
    let force = |load: f64, velocity: f64, level: Level| {
        let contact = sets()[0].under_load(load).unwrap().measured_at(2.0).unwrap();
        let scene = KnownVelocity::new(contact, velocity, answers).unwrap();
        let scene = if velocity < 0.1 { scene } else { scene.starting_steadily() };
        scene.run(level, 8).unwrap().answers[9]
    };
    for level in [Level::DAHL, Level::REFERENCE] {
        let [one, other] = [2.0, 8.0].map(|load| force(load, 1e-6, level));
        assert!((one / other - 1.0).abs() < 2e-3, "{level}: {one} {other}"); // stuck
    }
    for level in [Level::STATIC_CURVE, Level::DAHL, Level::REFERENCE] {
        let [one, other] = [2.0, 8.0].map(|load| force(load, 1.0, level));
        assert!((4.0 * one / other - 1.0).abs() < 1e-3, "{level}: {one} {other}"); // sliding
    }
}

/// Steps of whole and half periods see a sine stand still, and agree about it. The bristle slides
/// by 30 breakaway distances in half a period and forgets what was before: after 100 periods the
/// force is that after 1000.
#[test]
fn no_choice_is_an_alias_of_a_sine() {
    for (count, amplitude, interval) in
        [(10, 0.1, 1000.0), (100, 0.01, 1000.0), (10_000, 0.01, 1000.0)]
    {
        let wave = SineParameters { mean: 0.0, amplitude, frequency: 1.0, phase: 0.0 };
        let scene = |interval, count| {
            let contact = sets()[0].under_load(1.0).unwrap();
            let answers = Answers { interval, count };
            KnownVelocity::new(contact, Sine::new(wave).unwrap(), answers).unwrap()
        };
        let truth = scene(100.0, 1).run(Level::REFERENCE, 1 << 18).unwrap().answers[0];
        let scene = scene(interval, count);
        let tolerance = Tolerance { budget: 4e6, ..Tolerance::at_every_answer(0.015) };
        match choose(&scene, tolerance) {
            Ok(Choice { best, .. }) => {
                for answer in scene.run(best.level, best.steps).unwrap().answers {
                    assert!((answer - truth).abs() <= 0.015, "{count} {amplitude}: {answer}");
                }
            }
            // Resolved by 4 steps in a period, and none of them counted before.
            Err(FidelityError::Undetermined { fewest, .. }) => assert_eq!(fewest, 4000),
            Err(error) => panic!("{error}"),
        }
    }
}
