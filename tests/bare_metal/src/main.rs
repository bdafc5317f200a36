//! The same bits again: prints a hash of the results of 200 000 steps of friction, in `f32` and in
//! `f64`.
//!
//! `.ci/run` runs it without optimisation and twice with it, on libm and (`--features std`) on the
//! platform's mathematics, and compares. On libm the hash is that of every machine with IEEE
//! arithmetic.

use bristle::curve::{Stribeck, StribeckParameters};
use bristle::exponential::Exponential;
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{Bristle, FrBd, LuGre, ParameterError, Scalar, paper};
use bristle_rolling::{Motion, Patch, PatchParameters, PolynomialExponential, Segment};
use nalgebra::convert;

/// FNV-1a.
struct Hash(u64);

impl Hash {
    fn add<T: Scalar>(&mut self, value: T) {
        // Exact: every f32 is an f64.
        let value: f64 = value.to_subset_unchecked();
        for byte in value.to_bits().to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
        }
    }
}

/// A velocity that wanders about, sticks, creeps and slips, made of integers: no machine knows
/// better.
struct Velocities {
    seed: u64,
    target: f64,
    velocity: f64,
}

impl Velocities {
    fn next<T: Scalar>(&mut self) -> T {
        self.seed = self.seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        let draw = (self.seed >> 40) as i32;
        if draw % 64 == 0 {
            // Between ±2⁻²⁰ and ±2⁻¹ m/s.
            let octave = (draw >> 6) % 20;
            let size = 1.0 / f64::from(2_u32 << octave);
            self.target = if (draw >> 12) % 2 == 0 { size } else { -size };
        }
        self.velocity += (self.target - self.velocity) * 0.125;
        // Rounded to what an f32 holds.
        convert(f64::from(self.velocity as f32))
    }
}

const STEPS: u32 = 200_000;

fn run<T: Scalar>() -> Result<u64, ParameterError> {
    let lit = |value: f64| convert::<f64, T>(value);
    let curve = |exponent: f64| {
        Stribeck::new(StribeckParameters {
            static_coefficient: lit(paper::STICK_SLIP_CURVE.static_coefficient),
            dynamic_coefficient: lit(paper::STICK_SLIP_CURVE.dynamic_coefficient),
            stribeck_velocity: lit(paper::STICK_SLIP_CURVE.stribeck_velocity),
            stribeck_exponent: lit(exponent),
            viscous_friction: lit(paper::STICK_SLIP_CURVE.viscous_friction),
        })
    };
    let bristle = KelvinVoigt::new(KelvinVoigtParameters {
        micro_stiffness: lit(paper::STICK_SLIP_BRISTLE.micro_stiffness),
        micro_damping: lit(paper::STICK_SLIP_BRISTLE.micro_damping),
    })?;
    let frbd = FrBd::new(curve(2.0)?, bristle).under_load(lit(10.0))?;
    let lugre = LuGre::classical(curve(0.75)?, bristle).under_load(lit(10.0))?;
    let companion = frbd.companion(lit(1.0))?;
    let patch = Patch::new(PatchParameters {
        model: *frbd.model(),
        length: lit(0.125),
        pressure: PolynomialExponential::parabolic(),
    })?;
    let mut rolling = patch.under_load(lit(10.0))?.exact([[Segment::default(); 64]])?;

    let mut hash = Hash(0xcbf2_9ce4_8422_2325);
    let mut velocities = Velocities { seed: 7, target: 0.0, velocity: 0.0 };
    let (mut held, mut lagged, mut passive, mut dragged) = (lit(0.0), lit(0.0), lit(0.0), lit(0.0));
    let mut before = lit(0.0);
    for number in 0..STEPS {
        let velocity = velocities.next();
        // Milliseconds, and some steps so long that the bristle's own exponential is needed.
        let duration = if number % 16 == 0 { lit(0.015_625) } else { lit(0.001) };
        let step = frbd.hold(velocity, held, duration);
        held = step.deflection;
        hash.add(step.mean_force);
        let step = lugre.hold(velocity, lagged, duration);
        lagged = step.deflection;
        hash.add(step.end_force);
        let done = companion.step(before, passive, duration).commit(velocity);
        passive = done.deflection;
        hash.add(done.force);
        hash.add(done.dissipated);
        if number % 8 == 0 {
            let ramp = before..velocity;
            let step = Exponential::<3>.ramp(&frbd, ramp, dragged, duration);
            dragged = step.deflection;
            hash.add(step.work);
            let motion = Motion { slip_velocity: velocity, rolling_speed: lit(0.5) };
            hash.add(rolling.step(motion, duration)?);
        }
        before = velocity;
    }
    Ok(hash.0)
}

fn main() -> Result<(), ParameterError> {
    println!("f32 {:016x}", run::<f32>()?);
    println!("f64 {:016x}", run::<f64>()?);
    Ok(())
}
