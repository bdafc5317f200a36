//! A batch of 4096 bristles beside `exp` over as many numbers and beside the scalar steps in a
//! loop, all within one run: nanoseconds per bristle, and ratios.
//!
//! Every line is the best of many rounds, and the lines take turns, so that other load of the
//! machine affects them alike.
//!
//! ```sh
//! cargo bench -p bristle-batch                       # the target's own vectors, SSE2 on x86-64
//! cargo bench -p bristle-batch --features simd,rayon # the widest that the processor has
//! RUSTFLAGS="-C target-feature=+avx2" cargo bench -p bristle-batch
//! ```

use std::hint::black_box;
use std::time::Instant;

use bristle::curve::{Stribeck, StribeckParameters};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{Bristle, FrBd, ParameterError};
use bristle_batch::{Batch, BatchError, CommitInput, PassiveOutput, Real, ReloadInput, StepInput};
use bristle_plane::{Axis, PlaneFrBd};
use nalgebra::convert;

/// Bristles of a batch: everything stays in the second cache.
const COUNT: usize = 4096;
/// Rounds of which the best counts, and repetitions in each.
const ROUNDS: usize = 200;
const REPETITIONS: usize = 10;

/// Nanoseconds per bristle of the best round so far.
struct Best(f64);

impl Best {
    fn time(&mut self, count: usize, mut work: impl FnMut()) {
        let start = Instant::now();
        (0..REPETITIONS).for_each(|_| work());
        let each = start.elapsed().as_secs_f64() * 1e9 / (REPETITIONS * count) as f64;
        self.0 = self.0.min(each);
    }
}

/// Curve and bristle of every comparison.
fn material<T: Real>() -> Result<(Stribeck<T>, KelvinVoigt<T>), ParameterError> {
    let t = |value: f64| convert::<f64, T>(value);
    let curve = Stribeck::new(StribeckParameters {
        static_coefficient: t(1.5),
        dynamic_coefficient: t(1.0),
        stribeck_velocity: t(0.01),
        stribeck_exponent: t(2.0),
        viscous_friction: t(0.04),
    })?;
    let bristle = KelvinVoigt::new(KelvinVoigtParameters {
        micro_stiffness: t(1e4),
        micro_damping: t(64.5),
    })?;
    Ok((curve, bristle))
}

fn compare<T: Real>(name: &str) -> Result<(), BatchError> {
    let t = |value: f64| convert::<f64, T>(value);
    let (curve, bristle) = material()?;
    let model = FrBd::new(curve, bristle);
    let batch = Batch::of(&model)?;
    let companion = model.under_load(t(1.0))?.companion(t(1.0))?;
    let h = t(1e-3);

    // Velocities over ±2.5 v_S in no order, so that no branch of the scalar steps is foreseen.
    let column = |f: &dyn Fn(f64) -> f64| -> Vec<T> {
        (0..COUNT).map(|i| t(f((i * 37 % 1000) as f64 / 1000.0))).collect()
    };
    let velocities = column(&|u| 0.05 * (u - 0.5));
    let normal_forces = column(&|u| 1.0 + u);
    let exponents = column(&|u| -25.0 * (u - 0.5) * (u - 0.5));
    let mut deflections = column(&|u| 2e-4 * (0.5 - u));
    let (mut shares, mut biases, mut dampings) =
        (exponents.clone(), exponents.clone(), exponents.clone());

    let mut best: [Best; 6] = core::array::from_fn(|_| Best(f64::INFINITY));
    let [exp, begin, commit, hold, scalar_passive, scalar_hold] = &mut best;
    for _ in 0..ROUNDS {
        exp.time(COUNT, || {
            for (to, &x) in biases.iter_mut().zip(&exponents) {
                *to = x.exp();
            }
            black_box(&mut biases);
        });
        begin.time(COUNT, || {
            let predicted = StepInput {
                velocities: &velocities,
                normal_forces: &normal_forces,
                deflections: &mut deflections,
            };
            let dampers =
                PassiveOutput { shares: &mut shares, biases: &mut biases, dampings: &mut dampings };
            let _ = black_box(batch.companions(predicted, h, dampers));
        });
        commit.time(COUNT, || {
            let found = CommitInput {
                shares: &shares,
                velocities: &velocities,
                normal_forces: &normal_forces,
            };
            let _ = black_box(batch.commit(found, h, &mut deflections));
        });
        hold.time(COUNT, || {
            let held = StepInput {
                velocities: &velocities,
                normal_forces: &normal_forces,
                deflections: &mut deflections,
            };
            let _ = black_box(batch.hold(held, h, &mut biases));
        });
        scalar_passive.time(COUNT, || {
            for (((z, &v), bias), damping) in
                deflections.iter_mut().zip(&velocities).zip(&mut biases).zip(&mut dampings)
            {
                let step = companion.step(v, *z, h);
                (*bias, *damping) = (step.bias(), step.damping());
                *z = step.commit(v).deflection;
            }
            black_box((&mut deflections, &mut biases, &mut dampings));
        });
        scalar_hold.time(COUNT, || {
            for (((z, &v), force), &p) in
                deflections.iter_mut().zip(&velocities).zip(&mut biases).zip(&normal_forces)
            {
                let step = model.hold(v, *z, h);
                (*z, *force) = (step.deflection, p * step.mean_coefficient);
            }
            black_box((&mut deflections, &mut biases));
        });
    }
    let [exp, begin, commit, hold, scalar_passive, scalar_hold] = best.map(|best| best.0);
    let passive = begin + commit;
    let line = |what: &str, time: f64| {
        println!("{name}  {what:<28} {time:8.2} ns {:8.2} exp", time / exp);
    };
    line("exp", exp);
    line("passive step, its beginning", begin);
    line("passive step, its end", commit);
    line("passive step", passive);
    line("exact step", hold);
    line("scalar passive step", scalar_passive);
    line("scalar exact step", scalar_hold);
    println!(
        "{name}  scalar over batch: passive {:.1}, exact {:.1}",
        scalar_passive / passive,
        scalar_hold / hold
    );
    Ok(())
}

/// Passive steps of bristles of N axes.
struct Steps<'a, T, const N: usize> {
    batch: Batch<'a, T, N>,
    velocities: Vec<T>,
    normal_forces: Vec<T>,
    deflections: Vec<T>,
    output: [Vec<T>; 3],
    best: Best,
}

impl<'a, T: Real, const N: usize> Steps<'a, T, N> {
    fn new(batch: Batch<'a, T, N>) -> Self {
        let column = |length: usize, f: &dyn Fn(f64) -> f64| -> Vec<T> {
            (0..length).map(|i| convert(f((i * 37 % 1000) as f64 / 1000.0))).collect()
        };
        Self {
            batch,
            velocities: column(N * COUNT, &|u| 0.05 * (u - 0.5)),
            normal_forces: column(COUNT, &|u| 1.0 + u),
            deflections: column(N * COUNT, &|u| 2e-4 * (0.5 - u)),
            output: [(); 3].map(|()| column(N * COUNT, &|u| u)),
            best: Best(f64::INFINITY),
        }
    }

    fn time(&mut self) {
        let Self { batch, velocities, normal_forces, deflections, output, best } = self;
        let [shares, biases, dampings] = output;
        best.time(COUNT, || {
            let h = convert(1e-3);
            let predicted = StepInput { velocities, normal_forces, deflections };
            let dampers = PassiveOutput { shares, biases, dampings };
            let _ = black_box(batch.companions(predicted, h, dampers));
            let found = CommitInput { shares, velocities, normal_forces };
            let _ = black_box(batch.commit(found, h, deflections));
        });
    }
}

/// Passive steps under a load that scales the friction, and of a model that goes one by one, beside
/// those of a stiffness that follows the load; and a change of the load.
fn loads<T: Real>(name: &str) -> Result<(), BatchError> {
    let (curve, bristle) = material::<T>()?;
    let model = FrBd::new(curve, bristle);
    let batch = Batch::of(&model)?;
    let (one, each) = (convert(1.0), vec![convert::<f64, T>(1.5); COUNT]);
    let mut steps = [
        ("stiffness follows the load", Steps::new(batch)),
        ("a reference load", Steps::new(batch.measured_at(one)?)),
        ("one by one", Steps::new(Batch::of_model(&model)?)),
    ];
    let (mut reload, mut dissipated) = (Best(f64::INFINITY), each.clone());
    for _ in 0..ROUNDS {
        steps.iter_mut().for_each(|(_, steps)| steps.time());
        let Steps { velocities, normal_forces, deflections, .. } = &mut steps[1].1;
        let change = ReloadInput { before: &each, after: normal_forces, velocities };
        let measured = batch.measured_at(one)?;
        reload.time(COUNT, || {
            let _ = black_box(measured.reload(change, deflections, &mut dissipated));
        });
    }
    let first = steps[0].1.best.0;
    for (what, steps) in &steps {
        let (time, ratio) = (steps.best.0, steps.best.0 / first);
        println!("{name}  passive step, {what:<26} {time:8.2} ns {ratio:8.2} of the first");
    }
    println!("{name}  reload {:8.2} ns {:8.2} of the first", reload.0, reload.0 / first);
    Ok(())
}

/// Passive steps of bristles of one axis beside those of more, alike on all axes or not.
fn axes<T: Real>(name: &str) -> Result<(), BatchError> {
    let t = |value: f64| convert::<f64, T>(value);
    let (curve, bristle) = material()?;
    let line = Batch::of(&FrBd::new(curve, bristle))?;
    let ratio = |friction_ratio: f64| Axis { friction_ratio: t(friction_ratio), bristle };
    let grain = PlaneFrBd::new(curve, [ratio(1.0), ratio(0.6)])?;
    let (mut one, mut two) = (Steps::new(line), Steps::new(line.isotropic::<2>()?));
    let (mut unlike, mut three) =
        (Steps::new(Batch::of(&grain)?), Steps::new(line.isotropic::<3>()?));
    for _ in 0..ROUNDS {
        one.time();
        two.time();
        unlike.time();
        three.time();
    }
    let times = [
        ("one axis", one.best.0),
        ("two axes alike", two.best.0),
        ("two axes unlike", unlike.best.0),
        ("three axes alike", three.best.0),
    ];
    for (axes, time) in times {
        let ratio = time / one.best.0;
        println!("{name}  passive step, {axes:<16} {time:8.2} ns {ratio:8.2} of one axis");
    }
    Ok(())
}

/// A million bristles on one thread and on all that rayon has.
#[cfg(feature = "rayon")]
fn threads() -> Result<(), BatchError> {
    const MANY: usize = 1 << 20;
    let curve = Stribeck::new(bristle::paper::STICK_SLIP_CURVE)?;
    let bristle = KelvinVoigt::new(bristle::paper::STICK_SLIP_BRISTLE)?;
    let one = Batch::of(&FrBd::new(curve, bristle))?;
    let velocities: Vec<f64> = (0..MANY).map(|i| (i % 1000) as f64 * 5e-5 - 0.025).collect();
    let normal_forces = vec![1.0; MANY];
    let (mut deflections, mut mean_forces) = (vec![0.0; MANY], vec![0.0; MANY]);
    let mut best = [Best(f64::INFINITY), Best(f64::INFINITY)];
    for _ in 0..ROUNDS / 10 {
        for (best, batch) in best.iter_mut().zip([one, one.in_parallel()]) {
            best.time(MANY, || {
                let held = StepInput {
                    velocities: &velocities,
                    normal_forces: &normal_forces,
                    deflections: &mut deflections,
                };
                let _ = black_box(batch.hold(held, 1e-3, &mut mean_forces));
            });
        }
    }
    let [one, all] = best.map(|best| best.0);
    let count = std::thread::available_parallelism().map_or(1, usize::from);
    println!(
        "f64  a million exact steps: {one:.2} ns each, on {count} threads {all:.2}, \
         {:.2} times as fast",
        one / all
    );
    Ok(())
}

fn main() -> Result<(), BatchError> {
    compare::<f64>("f64")?;
    compare::<f32>("f32")?;
    loads::<f64>("f64")?;
    loads::<f32>("f32")?;
    axes::<f64>("f64")?;
    axes::<f32>("f32")?;
    #[cfg(feature = "rayon")]
    threads()?;
    Ok(())
}
