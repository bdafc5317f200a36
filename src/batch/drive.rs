//! The loop over the bristles, in blocks of one length, compiled for several instruction sets.
//!
//! Every bristle takes the same unfused operations, wherever it stands. The last block is padded
//! with ones and goes through the same code.

use super::Outcome;
use super::kernel::Kernel;
use super::real::{BLOCK, Real};

/// What a kernel works on: P columns of parameters, I of inputs and O of outputs, all of one
/// length.
#[derive(Debug)]
pub(super) struct Slices<'a, T, const P: usize, const I: usize, const O: usize> {
    pub(super) parameters: [&'a [T]; P],
    pub(super) inputs: [&'a [T]; I],
    pub(super) outputs: [&'a mut [T]; O],
    pub(super) length: usize,
}

/// One block, in place in `outputs`; false if a result is not finite.
#[inline(always)]
fn block<T: Real, const P: usize, const I: usize, const O: usize>(
    kernel: &impl Kernel<T, P, I, O>,
    parameters: [&[T; BLOCK]; P],
    inputs: [&[T; BLOCK]; I],
    outputs: &mut [[T; BLOCK]; O],
) -> bool {
    let mut finite = true;
    for k in 0..BLOCK {
        // `get`, because optimising for size keeps the bounds check of an index.
        let at = |column: &[T; BLOCK]| column.get(k).copied().unwrap_or_else(T::one);
        let before = outputs.each_ref().map(at);
        let after = kernel.apply(parameters.map(at), inputs.map(at), before);
        // Finite only if all terms are: ∞ − ∞ is NaN.
        let sum = after.into_iter().reduce(|sum, value| sum + value);
        finite &= sum.is_none_or(|sum| sum.is_finite());
        for (column, value) in outputs.iter_mut().zip(after) {
            if let Some(to) = column.get_mut(k) {
                *to = value;
            }
        }
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
#[inline(always)]
fn sweep<T: Real, K: Kernel<T, P, I, O>, const P: usize, const I: usize, const O: usize>(
    kernel: K,
    slices: Slices<'_, T, P, I, O>,
) -> Outcome {
    let Slices { mut parameters, mut inputs, mut outputs, length } = slices;
    let (mut outcome, mut done) = (Outcome::default(), 0);
    let mut results = [*T::ONES; O];
    while done + BLOCK <= length {
        if K::READS_OUTPUTS {
            let ones = *T::ONES;
            results = outputs.each_ref().map(|slice| slice.first_chunk().copied().unwrap_or(ones));
        }
        let finite = block(&kernel, next(&mut parameters), next(&mut inputs), &mut results);
        for (slice, result) in outputs.iter_mut().zip(&results) {
            if let Some(to) = slice.split_off_mut(..BLOCK).and_then(|to| to.first_chunk_mut()) {
                *to = *result;
            }
        }
        if !finite {
            outcome.count(&results, done, BLOCK);
        }
        done += BLOCK;
    }
    if done < length {
        let (parameters, inputs) = (padded(parameters), padded(inputs));
        let mut results = padded(outputs.each_ref().map(|slice| &**slice));
        let finite = block(&kernel, parameters.each_ref(), inputs.each_ref(), &mut results);
        for (slice, result) in outputs.iter_mut().zip(&results) {
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
pub(super) fn run<
    T: Real,
    K: Kernel<T, P, I, O>,
    const P: usize,
    const I: usize,
    const O: usize,
>(
    kernel: K,
    slices: Slices<'_, T, P, I, O>,
) -> Outcome {
    sweep(kernel, slices)
}

#[cfg(all(test, feature = "simd"))]
mod tests {
    use super::{Slices, run, sweep};
    use crate::batch::Real;
    use crate::batch::kernel::{Bound, Hold, Predict};
    use crate::batch::material::{GAUSSIAN, Material};
    use crate::curve::Valley;
    use crate::scalar::{lit, to_f64};

    /// Velocities, normal forces and deflections of many decades.
    fn inputs<T: Real>() -> [[T; 501]; 3] {
        let wave = |k: usize, pace: f64| {
            lit::<T>((pace * k as f64).sin() * (pace * k as f64).exp2().recip())
        };
        [0.021, 0.017, 0.013].map(|pace| core::array::from_fn(|k| wave(k, pace)))
    }

    fn the_widest_vectors_give_the_bits_of_the_narrowest<T: Real>() {
        let (drop, viscous) = (lit(0.5), lit(0.04));
        let curve = Valley { dynamic: T::one(), drop, inverse_velocity: lit(100.0), viscous };
        let source = Material { curve, stiffness: lit(1e4), damping: lit(64.5) };
        let [velocities, loads, deflections] = inputs::<T>();
        let loads = loads.map(|load| load.abs());
        let bits = |values: &[T]| -> std::vec::Vec<u64> {
            values.iter().map(|&x| to_f64(x).to_bits()).collect()
        };
        for h in [1e-4, 0.1] {
            let duration = lit(h);
            let outcome = |wide: bool| {
                let mut out = [[T::zero(); 501]; 3];
                let outputs = out.each_mut().map(|column| column.as_mut_slice());
                let inputs = [&velocities[..], &loads, &deflections];
                let slices = Slices { parameters: [], inputs, outputs, length: 501 };
                let kernel = Bound::<_, _, GAUSSIAN> { source, operation: Predict { duration } };
                let _ = if wide { run(kernel, slices) } else { sweep(kernel, slices) };
                let mut held = [deflections, deflections];
                let outputs = held.each_mut().map(|column| column.as_mut_slice());
                let inputs = [&velocities[..], &loads];
                let slices = Slices { parameters: [], inputs, outputs, length: 501 };
                let kernel = Bound::<_, _, GAUSSIAN> { source, operation: Hold { duration } };
                let _ = if wide { run(kernel, slices) } else { sweep(kernel, slices) };
                (out.map(|column| bits(&column)), held.map(|column| bits(&column)))
            };
            assert_eq!(outcome(true), outcome(false));
        }
    }

    #[test]
    fn every_instruction_set_gives_the_same_bits() {
        the_widest_vectors_give_the_bits_of_the_narrowest::<f64>();
        the_widest_vectors_give_the_bits_of_the_narrowest::<f32>();
    }
}
