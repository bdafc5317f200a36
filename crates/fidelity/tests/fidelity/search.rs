//! The search over scripted scenes, and what the levels of the three scenes promise.

use bristle::curve::{Stribeck, StribeckParameters};
use bristle::signal::Function;
use bristle::{Bristle, Contact, FrBd, paper};
use bristle_fidelity::*;
use bristle_rolling::{Motion, Patch, PatchParameters, PolynomialExponential};
use nalgebra::Vector3;

use crate::known_velocity::sets;
use crate::mechanism::rig;
use crate::patch::{patch, rolling};

const CHEAP: Level = Level { model: "cheap", method: Some("steps") };
const DEAR: Level = Level { model: "dear", method: Some("steps") };

/// Answers and their cost by level and steps.
struct Scripted<F>(F);

impl<F: Fn(Level, f64) -> (Vec<f64>, f64)> Scene for Scripted<F> {
    fn levels(&self) -> Vec<Level> {
        vec![CHEAP, DEAR]
    }

    fn interval(&self) -> f64 {
        1.0
    }

    fn run(&self, level: Level, steps: u32) -> Result<Run, FidelityError> {
        let (answers, cost) = (self.0)(level, f64::from(steps));
        Ok(Run { answers, evaluations: 1, cost })
    }
}

fn chosen(script: impl Fn(Level, f64) -> (Vec<f64>, f64)) -> Choice {
    choose(&Scripted(script), Tolerance::at_every_answer(1.0)).unwrap()
}

#[test]
fn answers_that_are_no_number_are_never_good_enough() {
    for missing in 0..3 {
        let choice = chosen(|level, steps| {
            let mut answers = vec![0.0; 3];
            if level == CHEAP {
                answers[missing] = f64::NAN;
            }
            (answers, if level == CHEAP { 0.01 * steps } else { steps })
        });
        assert_eq!(choice.best.level, DEAR, "{choice}");
        assert!(choice.trials[0].error.is_nan() && choice.trials[0].verdict != Verdict::Enough);
    }
}

#[test]
fn of_levels_of_one_cost_the_simplest_is_taken() {
    assert_eq!(chosen(|_, steps| (vec![0.0; 9], steps)).best.level, CHEAP);
    let choice =
        chosen(|level, steps| (vec![0.0; 9], if level == CHEAP { 2.0 } else { 1.0 } * steps));
    assert_eq!((choice.best.level, choice.trials[0].verdict), (DEAR, Verdict::Enough));
}

/// A reference whose error is 3.2/n tolerances with n steps: two runs differ by 1.6/n at n and 2n
/// steps, by a tenth of the tolerance from 16 steps on. It has to take more than eight, in any
/// unit.
#[test]
fn the_reference_settles_to_a_tenth_and_what_is_left_counts_as_error() {
    for unit in [1e-6, 1.0, 1e6] {
        let chosen = |offset: f64| {
            let script = |level: Level, steps: f64| {
                let answer = if level == CHEAP { offset } else { 3.2 / steps };
                (vec![answer * unit; 4096], if level == CHEAP { 0.01 } else { 1.0 } * steps)
            };
            choose(&Scripted(script), Tolerance::at_every_answer(unit)).unwrap()
        };
        let choice = chosen(0.5);
        let uncertainty = choice.uncertainty / unit;
        assert!(uncertainty <= 0.1 && choice.reference_steps >= 32, "{choice}");
        assert_eq!(choice.best.level, CHEAP);
        // Off by 1 − u/2 of the finest run, where u is by how much that is settled.
        let finest = 3.2 / f64::from(choice.reference_steps);
        let choice = chosen(finest + 1.0 - 0.5 * uncertainty);
        assert!(choice.trials[0].error < unit, "{choice}");
        assert_eq!((choice.best.level, choice.trials[0].verdict), (DEAR, Verdict::NotEnough));
    }
}

#[test]
fn few_answers_get_thousands_of_steps() {
    for (answers, fewest) in [(1, 8192), (64, 128), (512, 16), (4096, 16)] {
        let choice = chosen(|_, steps| (vec![0.0; answers], steps));
        assert!(choice.reference_steps >= 2 * fewest, "{answers}: {}", choice.reference_steps);
    }
}

/// Two runs that agree by chance are no sign that a level has settled on something else.
#[test]
fn a_level_is_given_up_only_when_three_runs_agree() {
    let choice = chosen(|level, steps| {
        let off = if level == DEAR || steps > 40.0 { 0.0 } else { 5.0 };
        (vec![off; 4096], if level == CHEAP { 1e-3 } else { 1.0 } * steps)
    });
    assert_eq!((choice.best.level, choice.best.steps), (DEAR, 1));
    let choice = chosen(|level, steps| {
        let off = if level == CHEAP && steps < 20.0 { 5.0 + 10.0 / steps } else { 0.0 };
        let off = if level == CHEAP && (20.0..40.0).contains(&steps) { 5.625 } else { off };
        (vec![off; 4096], if level == CHEAP { 1e-3 } else { 1.0 } * steps)
    });
    assert_eq!((choice.best.level, choice.best.steps), (CHEAP, 64), "{choice}");
}

fn off(a: &Run, b: &Run) -> f64 {
    a.answers.iter().zip(&b.answers).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Dahl's bristle knows the way only, and steps end at reversals: where the velocity is straight
/// from answer to answer one step is as good as a thousand.
#[test]
fn a_step_of_dahl_across_a_reversal_is_exact() {
    let sawtooth = |time: f64| {
        let (index, part) = (time.floor(), time.fract());
        let forward = (0.7 - part) * 1e-4;
        (if index % 2.0 == 0.0 { forward } else { -forward }, 0.0)
    };
    let jumps: [f64; 11] = std::array::from_fn(|jump| (jump + 1) as f64);
    let velocity = Function::new(sawtooth, jumps);
    let contact = sets()[0].under_load(1.0).unwrap();
    let scene =
        KnownVelocity::new(contact, velocity, Answers { interval: 1.0, count: 10 }).unwrap();
    let [one, many] = [1, 1024].map(|steps| scene.run(Level::DAHL, steps).unwrap());
    assert!(off(&one, &many) < 1e-7, "{one:?} {many:?}");
    assert!(one.answers.iter().any(|force| force.abs() > 0.1));
}

/// In adhesion the steady force is straight in the slip velocity, and the step of the relaxation
/// length is exact for a straight one.
#[test]
fn a_step_of_the_relaxation_length_is_exact_along_a_slow_ramp_of_slip() {
    let slip = Function::new(|time: f64| (1e-7 * time, 1e-7), []);
    let speed = Function::new(|_: f64| (2.0, 0.0), []);
    let scene = rolling(slip, speed, 0.02, 40).unwrap();
    let [one, many] = [1, 256].map(|n| scene.run(Level::RELAXATION_LENGTH, n).unwrap());
    let largest = many.answers.iter().fold(0.0_f64, |most, force| most.max(force.abs()));
    assert!(off(&one, &many) < 1e-4 * largest, "{one:?} {many:?}");
}

/// A bristle that nothing relaxes is deflected by ∫ v dt/U since it entered, so that a patch lags
/// by half of ∫ p ξ² dξ/∫ p ξ dξ of its length: 3/10 under a parabolic pressure.
#[test]
fn the_relaxation_length_in_adhesion_is_the_ratio_of_two_moments_of_the_pressure() {
    for length in [1e-2, 10.0] {
        let pressure = PolynomialExponential::parabolic();
        let model = *patch(0, pressure).model();
        let patch = Patch::new(PatchParameters { model, length, pressure }).unwrap();
        let slip_velocity = Function::new(|_: f64| (0.0, 0.0), []);
        let motion = Motion { slip_velocity, rolling_speed: 2.0 };
        let answers = Answers { interval: 0.02, count: 4 };
        let scene = PatchScene::new(patch.under_load(1.0).unwrap(), motion, answers).unwrap();
        // A phase of a thousandth, of which the square is left.
        let share = scene.relaxation_length() / length;
        assert!((share - 0.3).abs() < 1e-5, "{share}");
        assert_eq!(scene.physics(Level::RELAXATION_LENGTH, 1), Some(("ς/L", share)));
        assert_eq!(scene.physics(Level::PATCH, 1), Some(("adhering", 1.0)));
    }
}

/// Answers that are far apart come out as from a scene whose answers are close, also where the
/// patch has just got fast and not yet rolled by its length.
#[test]
fn a_patch_whose_answers_are_far_apart_forgets_nothing_that_is_in_it() {
    let slip = Function::new(|time: f64| (0.05 * (3.0 * time).sin(), 0.0), []);
    let fast = |time: f64| (if time.fract() > 0.999 || time == 0.0 { 40.0 } else { 0.02 }, 0.0);
    let even = |_: f64| (5.0, 0.0);
    for speed in [fast as fn(f64) -> (f64, f64), even] {
        let forces = |interval: f64, count, steps| {
            let scene = rolling(slip, Function::new(speed, []), interval, count).unwrap();
            scene.run(Level::PATCH, steps).unwrap().answers
        };
        // Up to just before the whole second, where the speed is the fast one.
        let (far, close) = (forces(0.9995, 2, 8192), forces(0.9995 / 512.0, 1024, 16));
        let want = [close[511], close[1023]];
        for (far, want) in far.iter().zip(want) {
            assert!((far - want).abs() < 0.01 * want.abs(), "{far} {want}");
        }
        // Where it rolls evenly a few steps do, for they need to cover the last transit only.
        let few = if speed(0.5).0 > 1.0 { forces(0.9995, 2, 8) } else { far };
        for (few, want) in few.iter().zip(want) {
            assert!((few - want).abs() < 0.01 * want.abs(), "{few} {want}");
        }
    }
}

/// A free mass of 1 kg from a velocity, in steps of 0.1 s.
fn slid<M: Bristle<f64, Deflection = f64>>(
    contact: Contact<f64, M>,
    (velocity, force): (f64, f64),
    (count, quantity): (usize, Quantity),
) -> MechanismScene<f64, M, f64> {
    let system = rig(contact, [1.0, 0.0, 0.0], 0.0, force);
    let start = Vector3::new(0.0, velocity, 0.0);
    MechanismScene::new(system, start, Answers { interval: 0.1, count }, quantity).unwrap()
}

/// A viscous friction that would throw the mass back within a step: it stops instead.
#[test]
fn a_mass_under_the_static_curve_does_not_slide_on_past_rest() {
    let curve =
        Stribeck::new(StribeckParameters { viscous_friction: 100.0, ..paper::STICK_SLIP_CURVE });
    let friction = FrBd::new(curve.unwrap(), *sets()[0].rheology());
    let contact = friction.under_load(1.0).unwrap();
    let scene = slid(contact, (1.0, 0.0), (20, Quantity::Velocity));
    for steps in [1, 2, 4, 64] {
        let run = scene.run(Level::TRUE_REST, steps).unwrap();
        assert!(run.answers.iter().all(|&velocity| (0.0..1.0).contains(&velocity)), "{run:?}");
        assert_eq!(run.answers.last(), Some(&0.0));
    }
}

/// At rest after a step h if the force m v₀/h that stops it within h is at most the static
/// friction. A faster mass slides on under the curve, by v₁ = v₀ − h F(v₀)/m.
#[test]
fn a_mass_under_the_static_curve_stops_by_static_friction_and_slides_on_under_the_curve() {
    let contact = sets()[0].under_load(1.0).unwrap();
    let (step, static_friction) = (0.1, contact.stationary_force(1e-9));
    for (share, stops) in [(0.99, true), (1.01, false), (-0.99, true), (-1.01, false)] {
        let velocity = share * static_friction * step;
        let scene = slid(contact, (velocity, 0.0), (1, Quantity::Velocity));
        let found = scene.run(Level::TRUE_REST, 1).unwrap().answers[0];
        let sliding = velocity - step * contact.stationary_force(velocity);
        let want = if stops { 0.0 } else { sliding };
        assert!((found - want).abs() < 1e-12, "{share}: {found} {want}");
        // The curve alone would stop neither.
        assert!(sliding.abs() > 0.01, "{sliding}");
    }
}

#[test]
fn friction_at_rest_is_the_applied_force_under_the_static_curve() {
    let contact = sets()[0].under_load(1.0).unwrap();
    for share in [0.5, -0.5] {
        let applied = share * contact.stationary_force(1e-9);
        let scene = slid(contact, (0.0, applied), (2, Quantity::Force));
        let found = scene.run(Level::TRUE_REST, 1).unwrap().answers;
        assert_eq!(found, [applied, applied]);
    }
}
