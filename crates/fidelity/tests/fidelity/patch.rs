//! Contact patches along a known motion.

use bristle::curve::{Stribeck, StribeckParameters};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::signal::{Signal, Sine, SineParameters};
use bristle::{FrBd, ParameterError, paper};
use bristle_fidelity::*;
use bristle_rolling::*;

use crate::judge::{ALL, Tally};
use crate::known_velocity::Lumped;
use bristle_specimens::draw::{Draw, Shape, Wave};

/// What a scene is made of.
struct Parameters<const N: usize> {
    patch: Patch<f64, Lumped, PolynomialExponential<f64, N>>,
    motion: Motion<Wave, Sine<f64>>,
    answers: Answers<f64>,
    steady: bool,
}

/// The paper's tyre, a rubber with damping, the paper's stick-slip rig.
fn model(set: usize) -> Lumped {
    let rubber = StribeckParameters {
        static_coefficient: 1.3,
        dynamic_coefficient: 0.9,
        stribeck_velocity: 0.5,
        stribeck_exponent: 1.0,
        viscous_friction: 0.01,
    };
    let soft = KelvinVoigtParameters { micro_stiffness: 400.0, micro_damping: 0.5 };
    let (curve, bristle) = match set {
        0 => (paper::TYRE_CURVE, paper::TYRE_BRISTLE),
        1 => (rubber, soft),
        _ => (paper::STICK_SLIP_CURVE, paper::STICK_SLIP_BRISTLE),
    };
    FrBd::new(Stribeck::new(curve).unwrap(), KelvinVoigt::new(bristle).unwrap())
}

/// A patch of 1 kN.
pub(crate) fn patch<P: Pressure<f64>>(set: usize, pressure: P) -> Patch<f64, Lumped, P> {
    let parameters =
        PatchParameters { model: model(set), length: bristle_rolling::TYRE_LENGTH, pressure };
    Patch::new(parameters).unwrap().under_load(1000.0).unwrap()
}

/// The paper's tyre under a parabolic pressure along a motion.
pub(crate) fn rolling<S: Signal<f64>, W: Signal<f64>>(
    slip_velocity: S,
    rolling_speed: W,
    interval: f64,
    count: usize,
) -> Result<PatchScene<f64, Lumped, 3, S, W>, ParameterError> {
    let patch = patch(0, PolynomialExponential::parabolic());
    PatchScene::new(patch, Motion { slip_velocity, rolling_speed }, Answers { interval, count })
}

/// The forces, by steps of fourth order under error control, which no level takes.
fn truth<const N: usize>(parameters: &Parameters<N>) -> Vec<f64> {
    let Parameters { patch, motion, answers: Answers { interval, count }, steady } = parameters;
    let slip_velocity = motion.slip_velocity.clone().declared();
    let mut exact = patch.exact_in(40_000).unwrap();
    if *steady {
        let (slip_velocity, rolling_speed) =
            (slip_velocity.value(0.0), motion.rolling_speed.value(0.0));
        exact.settle(Motion { slip_velocity, rolling_speed }).unwrap();
    }
    let motion = Motion { slip_velocity, rolling_speed: motion.rolling_speed };
    let force = |answer: usize| {
        let (from, to) = (interval * (answer - 1) as f64, interval * answer as f64);
        // Nothing is left of what was before the last crossing, at a speed that varies by 30 %.
        let from = from.max(to - 4.0 * patch.length() / motion.rolling_speed.value(to));
        exact.follow_within(&motion, from..to, 1e-6).unwrap()
    };
    (1..=*count).map(force).collect()
}

fn study(scenes: usize, most_answers: f64) -> Tally {
    let mut dice = Draw::seeded(27_182);
    let mut tally = Tally::default();
    for index in 0..scenes {
        let amplitude = dice.logarithmic(1e-6, 10.0);
        let frequency = dice.logarithmic(0.01, 1000.0);
        let mean = amplitude * dice.one_of(&[0.0, 0.0, 0.3, 1.1, 2.0]);
        let speed = dice.logarithmic(1.0, 50.0);
        let per_period = dice.one_of(&[36.0, 97.0, 100.0, 211.0, 7.3, 1.0, 0.31]);
        let interval = 1.0 / (frequency * per_period);
        let answers = dice.logarithmic(20.0, most_answers) as usize;
        let slip_velocity = dice.wave(mean, amplitude, frequency, interval * answers as f64);
        let mut swing = speed * dice.one_of(&[0.0, 0.0, 0.1, 0.3]);
        if let Wave::Repeated { shape: Shape::Square, .. } = slip_velocity {
            swing = 0.0;
        }
        let rolling = SineParameters { mean: speed, amplitude: swing, frequency, phase: 0.5 };
        let rolling_speed = Sine::new(rolling).unwrap();
        let steady = dice.one_of(&[false, true]);
        let error = 1000.0 * dice.logarithmic(1e-3, 0.1);
        let root_mean_square = dice.one_of(&[false, true]);
        let tolerance = Tolerance { root_mean_square, ..Tolerance::at_every_answer(error) };
        let what = format!(
            "{index:3} {slip_velocity:?} at {rolling:?}, {answers} answers, {interval:.2e} s"
        );
        let motion = Motion { slip_velocity, rolling_speed };
        let answers = Answers { interval, count: answers };
        let set = index % 3;
        macro_rules! under {
            ($pressure:expr) => {{
                let patch = patch(set, $pressure);
                let parameters = Parameters { patch, motion, answers, steady };
                let truth = truth(&parameters);
                let scene = PatchScene::new(patch, parameters.motion, answers).unwrap();
                let scene = if steady { scene.starting_steadily() } else { scene };
                tally.judge(&scene, tolerance, &truth, &what);
            }};
        }
        match (index / 3) % 3 {
            0 => under!(PolynomialExponential::constant()),
            1 => under!(PolynomialExponential::exponential(1.0).unwrap()),
            _ => under!(PolynomialExponential::parabolic()),
        }
    }
    tally
}

#[test]
fn no_choice_along_a_drawn_motion_is_wrong_and_hardly_one_is_dear() {
    study(9, 40.0).verdict(0);
}

#[test]
#[ignore = "minutes, in release"]
fn no_choice_along_three_hundred_drawn_motions_is_wrong() {
    study(ALL, 400.0).verdict(0);
}
