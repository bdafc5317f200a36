//! What a step costs: the exact reduction with its rebuilding spread over the steps, over one
//! exact step of a lumped contact with the same velocities; and a companion step with its commit
//! over the plain one. Then both steps in combined slip over those of one axis.

use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

use bristle::curve::Stribeck;
use bristle::rheology::KelvinVoigt;
use bristle::{Bristle, FrBd, LuGre, ParameterError, paper};
use bristle_plane::PlaneFrBd;
use bristle_rolling::{Motion, Patch, PatchParameters, PolynomialExponential};
use nalgebra::Vector2;

/// Runs of each, in turns; the shortest counts.
const RUNS: usize = 7;
/// Steps of a run.
const STEPS: usize = 100_000;

/// Prints the table.
pub(crate) fn report() -> Result<(), Box<dyn Error>> {
    let curve = Stribeck::new(paper::TYRE_CURVE)?;
    let bristle = KelvinVoigt::new(paper::TYRE_BRISTLE)?;
    println!("a step of the exact reduction, of a lumped contact, ns, and their ratio;");
    println!("a companion step with its commit, ns, over the plain step");
    println!("model  pressure     segments   patch  lumped  ratio companion  ratio");
    model("FrBD", FrBd::new(curve, bristle))?;
    model("LuGre", LuGre::classical(curve, bristle))?;
    println!();
    println!(
        "FrBD in combined slip: a step and a companion step with its commit, ns, over those of"
    );
    println!("one axis (M_z: with the self-aligning moment, on one axis as well)");
    println!("pressure          segments    step  ratio companion  ratio");
    let constant = PolynomialExponential::constant();
    let exponential = PolynomialExponential::exponential(bristle_rolling::TYRE_PRESSURE_DECAY)?;
    let parabolic = PolynomialExponential::parabolic();
    for segments in [100, 1000] {
        combined("constant", constant, segments, false)?;
        combined("constant, M_z", constant.padded::<2>(), segments, true)?;
        combined("exponential", exponential, segments, false)?;
        combined("exponential, M_z", exponential.padded::<2>(), segments, true)?;
        combined("parabolic", parabolic, segments, false)?;
        combined("parabolic, M_z", parabolic.padded::<4>(), segments, true)?;
    }
    Ok(())
}

fn combined<const N: usize>(
    name: &str,
    pressure: PolynomialExponential<f64, N>,
    segments: usize,
    moment: bool,
) -> Result<(), Box<dyn Error>> {
    let velocities: Vec<Vector2<f64>> = (0..1024)
        .map(|n| 0.37 * f64::from(n))
        .map(|phase| Vector2::new(1.0 + 0.5 * phase.sin(), 0.5 * (0.7 * phase).cos()))
        .collect();
    let rolling_speed = 2.0; // m/s
    let duration = bristle_rolling::TYRE_LENGTH / (rolling_speed * segments as f64);
    let length = bristle_rolling::TYRE_LENGTH;
    let curve = Stribeck::new(paper::TYRE_CURVE)?;
    let bristle = KelvinVoigt::new(paper::TYRE_BRISTLE)?;
    let line = FrBd::new(curve, bristle);
    let line = Patch::new(PatchParameters { model: line, length, pressure })?;
    let plane = PlaneFrBd::isotropic(curve, bristle);
    let plane = Patch::new(PatchParameters { model: plane, length, pressure })?;
    let mut one = line.under_load(1.0)?.exact_in(segments)?;
    let mut two = plane.under_load(1.0)?.exact_in(segments)?;
    let along = |n: usize| Motion { slip_velocity: velocities[n % 1024].x, rolling_speed };
    let both = |n: usize| Motion { slip_velocity: velocities[n % 1024], rolling_speed };
    // A transit, so that the queues are full.
    for n in 0..2 * segments {
        one.step(along(n), duration)?;
        two.step(both(n), duration)?;
    }
    // Short runs, and many, so that some fall between what else the machine does; at least two
    // crossings of the patch, so that each rebuilds the queues.
    const STEPS: usize = 2000;
    let mut shortest = [f64::INFINITY; 4];
    for _ in 0..40 * RUNS {
        let mut take = |number: usize, work: &mut dyn FnMut() -> Result<f64, ParameterError>| {
            let begin = Instant::now();
            black_box(work()?);
            shortest[number] = shortest[number].min(begin.elapsed().as_secs_f64());
            Ok::<(), ParameterError>(())
        };
        take(0, &mut || {
            let step = |n| {
                let motion = along(n);
                let force = one.step(motion, duration)?;
                Ok(if moment { force + one.moment(motion.slip_velocity) } else { force })
            };
            (0..STEPS).map(step).sum()
        })?;
        take(1, &mut || {
            let step = |n| {
                let motion = both(n);
                let force = two.step(motion, duration)?;
                Ok(if moment { force + two.moment(motion.slip_velocity) } else { force }.sum())
            };
            (0..STEPS).map(step).sum()
        })?;
        take(2, &mut || {
            let step = |n| {
                let motion = along(n);
                one.companion_step(motion, duration)?.commit(motion.slip_velocity)
            };
            (0..STEPS).map(step).sum()
        })?;
        take(3, &mut || {
            let step = |n| {
                let motion = both(n);
                Ok(two.companion_step(motion, duration)?.commit(motion.slip_velocity)?.sum())
            };
            (0..STEPS).map(step).sum()
        })?;
    }
    let [one, two, one_coupled, two_coupled] = shortest.map(|time| time * 1e9 / STEPS as f64);
    println!(
        "{name:17} {segments:8} {two:7.1} {:6.2} {two_coupled:9.1} {:6.2}",
        two / one,
        two_coupled / one_coupled,
    );
    Ok(())
}

fn model<M: Bristle<f64, Deflection = f64> + Copy>(
    name: &str,
    model: M,
) -> Result<(), Box<dyn Error>> {
    for segments in [100, 1000, 10_000] {
        row(name, "constant", model, PolynomialExponential::constant(), segments)?;
        let decay = bristle_rolling::TYRE_PRESSURE_DECAY;
        row(name, "exponential", model, PolynomialExponential::exponential(decay)?, segments)?;
        row(name, "parabolic", model, PolynomialExponential::parabolic(), segments)?;
    }
    Ok(())
}

fn row<M: Bristle<f64, Deflection = f64> + Copy, const N: usize>(
    name: &str,
    pressure_name: &str,
    model: M,
    pressure: PolynomialExponential<f64, N>,
    segments: usize,
) -> Result<(), Box<dyn Error>> {
    let velocities: Vec<f64> = (0..1024).map(|n| 1.0 + 0.5 * (0.37 * f64::from(n)).sin()).collect();
    let rolling_speed = 2.0; // m/s
    let duration = bristle_rolling::TYRE_LENGTH / (rolling_speed * segments as f64);
    let contact = model.under_load(1.0)?;
    let patch =
        Patch::new(PatchParameters { model, length: bristle_rolling::TYRE_LENGTH, pressure })?;
    let mut rolling = patch.under_load(1.0)?.exact_in(segments)?;
    // A transit, so that the queue is full.
    for n in 0..2 * segments {
        rolling.step(Motion { slip_velocity: velocities[n % 1024], rolling_speed }, duration)?;
    }
    let mut coupled = rolling.clone();
    let (mut patch_time, mut lumped_time, mut coupled_time) =
        (f64::INFINITY, f64::INFINITY, f64::INFINITY);
    for _ in 0..RUNS {
        let begin = Instant::now();
        let mut sum = 0.0;
        for n in 0..STEPS {
            let slip_velocity = velocities[n % 1024];
            sum += rolling.step(Motion { slip_velocity, rolling_speed }, duration)?;
        }
        black_box(sum);
        patch_time = patch_time.min(begin.elapsed().as_secs_f64());
        let begin = Instant::now();
        let (mut sum, mut z) = (0.0, 0.0);
        for n in 0..STEPS {
            let hold = contact.hold(velocities[n % 1024], z, duration);
            z = hold.deflection;
            sum += hold.end_force + hold.mean_force;
        }
        black_box((sum, z));
        lumped_time = lumped_time.min(begin.elapsed().as_secs_f64());
        let begin = Instant::now();
        let mut sum = 0.0;
        for n in 0..STEPS {
            let slip_velocity = velocities[n % 1024];
            // The prediction is right.
            let step = coupled.companion_step(Motion { slip_velocity, rolling_speed }, duration)?;
            sum += step.commit(slip_velocity)?;
        }
        black_box(sum);
        coupled_time = coupled_time.min(begin.elapsed().as_secs_f64());
    }
    let per_step = 1e9 / STEPS as f64;
    println!(
        "{name:6} {pressure_name:12} {segments:8} {:7.1} {:7.1} {:6.2} {:9.1} {:6.2}",
        patch_time * per_step,
        lumped_time * per_step,
        patch_time / lumped_time,
        coupled_time * per_step,
        coupled_time / patch_time
    );
    Ok(())
}
