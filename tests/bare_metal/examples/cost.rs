//! What a held and a passive step cost beside one exponential, on libm or the platform's, optimised
//! as a firmware is: `cargo run --release --example cost`, with `--features std` for the latter.
//!
//! Every piece of work waits for the result of the one before, as in a control loop, and so does
//! the exponential. The pieces take turns, and the best of many rounds counts. FrBD with Table 2 of
//! the paper, in the middle of the Stribeck range.

use std::hint::black_box;
use std::time::Instant;

use bristle::curve::{Stribeck, StribeckParameters};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{Bristle, FrBd, ParameterError, Scalar, paper};
use nalgebra::convert;

const ROUNDS: u32 = 400;
const CALLS: u32 = 20_000;

/// Nanoseconds of one call.
fn time<T: Scalar>(start: f64, mut work: impl FnMut(T) -> T) -> f64 {
    let start: T = convert(start);
    let mut value = start;
    let begin = Instant::now();
    for _ in 0..CALLS {
        // The next input depends on the result, without changing its value.
        value = start + work(black_box(value)) * convert(1e-30);
    }
    black_box(value);
    begin.elapsed().as_secs_f64() / f64::from(CALLS) * 1e9
}

fn measure<T: Scalar>(scalar: &str) -> Result<(), ParameterError> {
    let t = |value: f64| convert::<f64, T>(value);
    let curve = Stribeck::new(StribeckParameters {
        static_coefficient: t(paper::STICK_SLIP_CURVE.static_coefficient),
        dynamic_coefficient: t(paper::STICK_SLIP_CURVE.dynamic_coefficient),
        stribeck_velocity: t(paper::STICK_SLIP_CURVE.stribeck_velocity),
        stribeck_exponent: t(paper::STICK_SLIP_CURVE.stribeck_exponent),
        viscous_friction: t(paper::STICK_SLIP_CURVE.viscous_friction),
    })?;
    let bristle = KelvinVoigt::new(KelvinVoigtParameters {
        micro_stiffness: t(paper::STICK_SLIP_BRISTLE.micro_stiffness),
        micro_damping: t(paper::STICK_SLIP_BRISTLE.micro_damping),
    })?;
    let contact = FrBd::new(curve, bristle).under_load(t(1.0))?;
    let companion = contact.companion(t(1.0))?;
    let (z, h) = (t(1.1e-4), t(1e-3));
    // A unit mass under the force that keeps it sliding at about this speed.
    let passive = |v: T| {
        let step = companion.step(v, z, h);
        step.commit((t(1.28) - step.bias() + v * t(2e3)) / (t(2e3) + step.damping()))
    };
    let mut best = [f64::INFINITY; 4];
    for _ in 0..ROUNDS {
        let times = [
            time(-0.64, |x: T| x.exp()),
            time(0.008, |v| contact.hold(v, z, h).mean_force),
            time(0.008, |v| passive(v).deflection),
            time(0.008, |v| {
                let done = passive(v);
                done.deflection + done.work + done.stored + done.dissipated
            }),
        ];
        for (best, time) in best.iter_mut().zip(times) {
            *best = best.min(time);
        }
    }
    let [exp, ..] = best;
    let names = ["exp", "held step", "passive step", "passive step with its ledger"];
    for (name, time) in names.into_iter().zip(best) {
        println!("{scalar} {name}: {time:.1} ns, {:.2} exp", time / exp);
    }
    Ok(())
}

fn main() -> Result<(), ParameterError> {
    measure::<f64>("f64")?;
    measure::<f32>("f32")
}
