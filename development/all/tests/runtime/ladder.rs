//! Which model is enough below the implicit bristle.

use bristle::curve::StribeckParameters;
use bristle::rheology::KelvinVoigtParameters;
use bristle::signal::{Signal, Sine, SineParameters};
use bristle::{Bristle, FrBd};
use bristle_fidelity::{Answers, KnownVelocity, Level, Scene, Tolerance, choose};
use bristle_specimens::draw::Draw;
use bristle_specimens::implicit::{Set, TABLE_2};

/// Two periods of forty answers each.
const PERIOD: usize = 40;

struct Wave {
    mean: f64,
    amplitude: f64,
    frequency: f64,
}

impl Wave {
    fn velocity(&self) -> Sine<f64> {
        let Wave { mean, amplitude, frequency } = *self;
        Sine::new(SineParameters { mean, amplitude, frequency, phase: 0.0 }).unwrap()
    }

    fn interval(&self) -> f64 {
        1.0 / (self.frequency * PERIOD as f64)
    }
}

/// The forces of a set along a wave, from tiny steps with the velocity held over a 16th of the
/// time between answers.
fn truth(set: &Set, wave: &Wave) -> Vec<f64> {
    const STEPS: u32 = 16;
    let velocity = wave.velocity();
    let step = wave.interval() / f64::from(STEPS);
    let mut z = 0.0;
    let mut forces = Vec::new();
    for index in 0..2 * PERIOD {
        let start = index as f64 * wave.interval();
        for substep in 0..STEPS {
            let middle = velocity.value(start + step * (f64::from(substep) + 0.5));
            z = set.truth(middle, z, step).0;
        }
        let v = velocity.value((index + 1) as f64 * wave.interval());
        forces.push(set.model().coefficient(v, z));
    }
    forces
}

/// The level chosen, and how far its forces are off as a share of those allowed.
fn chosen(set: &Set, wave: &Wave, share: f64) -> (Level, f64) {
    let contact = set.model().under_load(1.0).unwrap();
    let fastest = wave.mean + wave.amplitude;
    let tolerance = Tolerance::root_mean_square(share * contact.limits(fastest).force.unwrap());
    let answers = Answers { interval: wave.interval(), count: 2 * PERIOD };
    let frbd = FrBd::new(contact.model().curve().to_owned(), *contact.model().rheology());
    let scene = KnownVelocity::new(contact, wave.velocity(), answers).unwrap();
    let scene = scene.with_lumped(frbd).unwrap();
    let choice = choose(&scene, tolerance).unwrap_or_else(|e| panic!("{set:?}: {e}"));
    let best = choice.best;
    let forces = scene.run(best.level, best.steps).unwrap().answers;
    let off = forces.iter().zip(truth(set, wave)).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
    (best.level, (off / forces.len() as f64).sqrt() / tolerance.error)
}

#[test]
fn the_ladder_is_right_below_the_implicit_bristle() {
    // Another unfolded set: half the drop, and a damping of twice what it takes.
    let other = Set {
        curve: StribeckParameters {
            static_coefficient: 0.5,
            dynamic_coefficient: 0.3,
            stribeck_velocity: 0.002,
            stribeck_exponent: 2.0,
            viscous_friction: 1.0,
        },
        bristle: KelvinVoigtParameters { micro_stiffness: 1e5, micro_damping: 170.0 },
    };
    let mut dice = Draw(5);
    for index in 0..12 {
        let set = if index % 2 == 0 { TABLE_2 } else { other };
        let amplitude = dice.logarithmic(1e-4, 1.0);
        let mean = if index % 3 == 0 { 1.1 * amplitude } else { 0.0 };
        let wave = Wave { mean, amplitude, frequency: dice.logarithmic(0.1, 100.0) };
        let (level, off) = chosen(&set, &wave, 0.02);
        assert!(off <= 1.0, "{off} of what is allowed: {level:?}, {mean:e} + {amplitude:e} sin");
    }
}

#[test]
fn frbd_does_not_do_in_the_stribeck_range_and_does_beyond() {
    // The loops of lag, 0.20 apart of 1.5.
    for frequency in [25.0, 100.0] {
        let wave = Wave { mean: 0.0055, amplitude: 0.005, frequency };
        let (level, off) = chosen(&TABLE_2, &wave, 0.02);
        assert!(level == Level::REFERENCE && off <= 1.0, "{frequency} Hz: {level:?}, {off}");
    }
    let wave = Wave { mean: 1.0, amplitude: 0.5, frequency: 10.0 };
    let (level, off) = chosen(&TABLE_2, &wave, 0.02);
    assert!(level != Level::REFERENCE && off <= 1.0, "{level:?}, {off}");
}
