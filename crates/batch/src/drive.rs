//! The loop over the bristles, in blocks of one length, compiled for several instruction sets.
//!
//! Every bristle takes the same unfused operations, wherever it stands. The last block is padded
//! with ones and goes through the same code.

use super::Outcome;
use super::kernel::Kernel;
use super::real::{BLOCK, Real};

/// What a kernel works on: P columns of parameters, and of N axes I columns of inputs and O of
/// outputs, all of one length. An axis that a column lacks is empty.
#[derive(Debug)]
pub(super) struct Slices<'a, T, const N: usize, const P: usize, const I: usize, const O: usize> {
    pub(super) parameters: [&'a [T]; P],
    pub(super) inputs: [[&'a [T]; N]; I],
    pub(super) outputs: [[&'a mut [T]; N]; O],
    pub(super) length: usize,
}

/// One block, in place in `outputs`; false if a result is not finite.
#[allow(clippy::needless_range_loop, reason = "iterators in two depths are not unrolled")]
#[inline(always)]
fn block<T: Real, const N: usize, const P: usize, const I: usize, const O: usize>(
    kernel: &impl Kernel<T, N, P, I, O>,
    parameters: [&[T; BLOCK]; P],
    inputs: [[&[T; BLOCK]; N]; I],
    outputs: &mut [[[T; BLOCK]; N]; O],
) -> bool {
    let mut finite = true;
    for k in 0..BLOCK {
        // `get`, because optimising for size keeps the bounds check of an index.
        let at = |column: &[T; BLOCK]| column.get(k).copied().unwrap_or_else(T::one);
        // Loops over axes, because maps of maps are not inlined.
        let (mut read, mut before) = ([[T::one(); N]; I], [[T::one(); N]; O]);
        for axis in 0..N {
            (0..I).for_each(|column| read[column][axis] = at(inputs[column][axis]));
            (0..O).for_each(|column| before[column][axis] = at(&outputs[column][axis]));
        }
        let after = kernel.apply(parameters.map(at), read, before);
        // Finite only if all terms are: ∞ − ∞ is NaN.
        let mut sum = T::zero();
        for axis in 0..N {
            for column in 0..O {
                sum += after[column][axis];
                if let Some(to) = outputs[column][axis].get_mut(k) {
                    *to = after[column][axis];
                }
            }
        }
        finite &= sum.is_finite();
    }
    finite
}

/// The next block of every slice; ones for what a slice lacks.
#[inline(always)]
fn next<'a, T: Real, const N: usize>(slices: &mut [&'a [T]; N]) -> [&'a [T; BLOCK]; N] {
    slices.each_mut().map(|slice| {
        let block = slice.split_off(..BLOCK).and_then(|block| block.first_chunk());
        block.unwrap_or(T::ONES)
    })
}

/// What is left of every slice, padded with ones.
#[inline(always)]
fn padded<T: Real, const N: usize>(slices: [&[T]; N]) -> [[T; BLOCK]; N] {
    slices.map(|slice| {
        let mut block = *T::ONES;
        block.iter_mut().zip(slice).for_each(|(to, from)| *to = *from);
        block
    })
}

/// All blocks.
#[allow(clippy::needless_range_loop, reason = "iterators in two depths are not unrolled")]
#[inline(always)]
fn sweep<
    T: Real,
    K: Kernel<T, N, P, I, O>,
    const N: usize,
    const P: usize,
    const I: usize,
    const O: usize,
>(
    kernel: K,
    slices: Slices<'_, T, N, P, I, O>,
) -> Outcome {
    let Slices { mut parameters, mut inputs, mut outputs, length } = slices;
    let (mut outcome, mut done) = (Outcome::default(), 0);
    let mut results = [[*T::ONES; N]; O];
    while done + BLOCK <= length {
        if K::READS_OUTPUTS {
            for column in 0..O {
                for axis in 0..N {
                    let before = outputs[column][axis].first_chunk();
                    results[column][axis] = *before.unwrap_or(T::ONES);
                }
            }
        }
        let (parameters, inputs) = (next(&mut parameters), inputs.each_mut().map(next));
        let finite = block(&kernel, parameters, inputs, &mut results);
        for column in 0..O {
            for axis in 0..N {
                let written = outputs[column][axis].split_off_mut(..BLOCK);
                if let Some(to) = written.and_then(|to| to.first_chunk_mut()) {
                    *to = results[column][axis];
                }
            }
        }
        if !finite {
            outcome.count(&results, done, BLOCK);
        }
        done += BLOCK;
    }
    if done < length {
        let (parameters, inputs) = (padded(parameters), inputs.map(padded));
        let mut results =
            outputs.each_ref().map(|axes| padded(axes.each_ref().map(|slice| &**slice)));
        let inputs = inputs.each_ref().map(|axes| axes.each_ref());
        let finite = block(&kernel, parameters.each_ref(), inputs, &mut results);
        for (slice, result) in outputs.iter_mut().flatten().zip(results.iter().flatten()) {
            slice.iter_mut().zip(result).for_each(|(to, from)| *to = *from);
        }
        if !finite {
            outcome.count(&results, done, length - done);
        }
    }
    outcome
}

/// Applies a kernel to all bristles, with the widest vectors that the processor has.
#[cfg_attr(
    feature = "simd",
    multiversion::multiversion(targets(
        "x86_64+avx512f+avx512bw+avx512dq+avx512vl",
        "x86_64+avx2",
        "aarch64+neon",
    ))
)]
pub(super) fn run<T: Real, const N: usize, const P: usize, const I: usize, const O: usize>(
    kernel: impl Kernel<T, N, P, I, O>,
    slices: Slices<'_, T, N, P, I, O>,
) -> Outcome {
    sweep(kernel, slices)
}

#[cfg(all(test, feature = "simd"))]
mod tests {
    use super::{Slices, run, sweep};
    use crate::Real;
    use crate::kernel::{Bound, Hold, Predict, Step};
    use crate::material::{AxisMaterial, GAUSSIAN, Material, Valley};
    use bristle::scalar::{lit, to_f64};

    /// Numbers of many decades.
    fn column<T: Real>(pace: f64) -> [T; 501] {
        core::array::from_fn(|k| {
            lit::<T>((pace * k as f64).sin() * (pace * k as f64).exp2().recip())
        })
    }

    fn bits<T: Real, const N: usize>(columns: &[[[T; 501]; N]]) -> std::vec::Vec<u64> {
        columns.iter().flatten().flatten().map(|&x| to_f64(x).to_bits()).collect()
    }

    fn the_widest_vectors_give_the_bits_of_the_narrowest<T: Real, const N: usize>() {
        let (drop, viscous) = (lit(0.5), lit(0.04));
        let curve = Valley { dynamic: T::one(), drop, inverse_velocity: lit(100.0), viscous };
        let ratio = |axis: usize| lit::<T>(1.0 - 0.3 * axis as f64);
        let axes: [_; N] = core::array::from_fn(|axis| AxisMaterial {
            ratio: ratio(axis),
            stiffness: lit(1e4),
            damping: lit(64.5),
        });
        let source = Material { curve, axes, ellipsoid: false };
        let velocities: [_; N] = core::array::from_fn(|axis| column(0.021 + 0.003 * axis as f64));
        let deflections: [_; N] = core::array::from_fn(|axis| column(0.013 + 0.001 * axis as f64));
        let loads = column::<T>(0.017).map(|load| load.abs());
        let mut load = [&loads[..0]; N];
        load[0] = &loads;
        for h in [1e-4, 0.1] {
            let step = Step::<T, true> { duration: lit(h), reference: lit(0.7) };
            let outcome = |wide: bool| {
                let velocity = velocities.each_ref().map(|column| column.as_slice());
                let deflection = deflections.each_ref().map(|column| column.as_slice());
                let mut out = [[[T::zero(); 501]; N]; 3];
                let outputs = out.each_mut().map(|axes| axes.each_mut().map(|c| c.as_mut_slice()));
                let inputs = [velocity, load, deflection];
                let slices = Slices { parameters: [], inputs, outputs, length: 501 };
                let kernel = Bound::<_, _, GAUSSIAN> { source, operation: Predict(step) };
                let _ = if wide { run(kernel, slices) } else { sweep(kernel, slices) };
                let mut held = [deflections, deflections];
                let outputs = held.each_mut().map(|axes| axes.each_mut().map(|c| c.as_mut_slice()));
                let inputs = [velocity, load];
                let slices = Slices { parameters: [], inputs, outputs, length: 501 };
                let kernel = Bound::<_, _, GAUSSIAN> { source, operation: Hold(step) };
                let _ = if wide { run(kernel, slices) } else { sweep(kernel, slices) };
                (bits(&out), bits(&held))
            };
            assert_eq!(outcome(true), outcome(false));
        }
    }

    #[test]
    fn every_instruction_set_gives_the_same_bits() {
        the_widest_vectors_give_the_bits_of_the_narrowest::<f64, 1>();
        the_widest_vectors_give_the_bits_of_the_narrowest::<f32, 1>();
        the_widest_vectors_give_the_bits_of_the_narrowest::<f64, 2>();
        the_widest_vectors_give_the_bits_of_the_narrowest::<f32, 3>();
    }
}
