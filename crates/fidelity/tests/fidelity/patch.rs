//! Contact patches along a known motion.

use bristle::Bristle;
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

/// The force at a time, from nothing but the model's coefficients: every bristle followed back to
/// where it entered, in steps that cross a `finesse`th of the patch.
fn force_at<const N: usize>(parameters: &Parameters<N>, time: f64, finesse: f64) -> f64 {
    let Parameters { patch, motion, steady: steady_start, .. } = parameters;
    let model = patch.model();
    let slip_at = |t: f64| motion.slip_velocity.value(t);
    let transport_at = |t: f64| motion.rolling_speed.value(t) / patch.length();
    // What has become of a bristle of z: kept z + gained.
    let (mut kept, mut gained, mut place, mut now) = (1.0_f64, 0.0_f64, 0.0_f64, time);
    let mut sum = 0.0;
    let mut piece = |from: f64, z_from: f64, to: f64, z_to: f64| {
        // Three points: z is taken to be straight, p as it is.
        let to = to.min(1.0);
        let pressures = [from.min(1.0), 0.5 * (from + to), to].map(|xi| patch.pressure().at(xi));
        let [p, q, r] = pressures;
        sum += (to - from) / 6.0 * (p * z_from + 2.0 * q * (z_from + z_to) + r * z_to);
    };
    while place < 1.0 && now > 0.0 {
        let h = (1.0 / (finesse * transport_at(now))).min(now);
        let (v, transport) = (slip_at(now - 0.5 * h), transport_at(now - 0.5 * h));
        let affine = model.affine(v.into(), 0.0);
        let x = affine.relaxation * h;
        let fresh = if x == 0.0 {
            affine.drive * v * h
        } else {
            affine.drive * v / affine.relaxation * -(-x).exp_m1()
        };
        let before = (place, gained);
        gained += kept * fresh;
        kept *= (-x).exp();
        place += transport * h;
        now -= h;
        piece(before.0, before.1, place, gained);
    }
    if place < 1.0 {
        // Those that were there at the start.
        let rolling_speed = motion.rolling_speed.value(0.0);
        let at_start = Motion { slip_velocity: slip_at(0.0), rolling_speed };
        let steady = patch.steady(at_start).unwrap();
        let (width, parts) = (1.0 - place, 2000);
        let z = |xi: f64| {
            if *steady_start { kept * steady.deflection(xi) + gained } else { gained }
        };
        for part in 0..parts {
            let [a, b] = [part, part + 1].map(|p| width * f64::from(p) / f64::from(parts));
            piece(place + a, z(a), place + b, z(b));
        }
    }
    let affine = model.affine(slip_at(time).into(), 0.0);
    let pressed = patch.normal_force() / patch.pressure().total();
    pressed * affine.stiffness * sum + patch.normal_force() * affine.damping * slip_at(time)
}

/// The forces; between the jumps of a square wave (at a constant rolling speed) exactly.
fn truth<const N: usize>(parameters: &Parameters<N>, finesse: f64) -> Vec<f64> {
    let Parameters { patch, motion, answers: Answers { interval, count }, steady } = parameters;
    let times = (1..=*count).map(|answer| interval * answer as f64);
    let slip = motion.slip_velocity.clone().declared();
    if !matches!(slip, Wave::Repeated { shape: Shape::Square, .. }) {
        return times.map(|time| force_at(parameters, time, finesse)).collect();
    }
    let motion = |time: f64| Motion {
        slip_velocity: slip.value(time),
        rolling_speed: motion.rolling_speed.value(time),
    };
    let mut exact = patch.exact_in(40_000).unwrap();
    if *steady {
        exact.settle(motion(0.0)).unwrap();
    }
    let mut time = 0.0;
    times
        .map(|answer| {
            while time < answer {
                let next = slip.next_kink(time, answer).unwrap_or(answer);
                exact.step(motion(time), next - time).unwrap();
                time = next;
            }
            exact.force(motion(answer).slip_velocity)
        })
        .collect()
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
        let mut finesse =
            (200.0 * frequency * bristle_rolling::TYRE_LENGTH / (0.7 * speed)).max(1000.0);
        match slip_velocity {
            Wave::Repeated { shape: Shape::Square, .. } => swing = 0.0,
            Wave::Repeated { shape: Shape::Steep(slope), .. } => finesse *= slope,
            _ => {}
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
                let truth = truth(&parameters, finesse);
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
