//! The loop over the bristles, in blocks of one length, compiled for several instruction sets.
//!
//! Every bristle, wherever it stands, takes the same plain operations, none of them fused: what is
//! left of the last block is filled up with ones and goes the same way.

use super::Outcome;
use super::kernel::Operation;
use super::material::{Falling, Source};
use super::real::{BLOCK, Real};
use core::marker::PhantomData;

/// An operation O on bristles whose parameters come from a source S and whose curves fall like F.
#[derive(Debug, Clone, Copy)]
pub(super) struct Kernel<F, S, O> {
    pub(super) fall: PhantomData<F>,
    pub(super) source: S,
    pub(super) operation: O,
}

/// What a kernel works on: P columns of parameters, I of inputs, O of outputs, all of one length.
#[derive(Debug)]
pub(super) struct Slices<'a, T, const P: usize, const I: usize, const O: usize> {
    pub(super) parameters: [&'a [T]; P],
    pub(super) inputs: [&'a [T]; I],
    pub(super) outputs: [&'a mut [T]; O],
    /// Of all of them.
    pub(super) length: usize,
}

/// The next block of every slice; ones for what a slice lacks.
#[inline(always)]
fn next<'a, T: Real, const N: usize>(slices: &mut [&'a [T]; N]) -> [&'a [T; BLOCK]; N] {
    slices.each_mut().map(|slice| match slice.split_first_chunk() {
        Some((block, rest)) => {
            *slice = rest;
            block
        }
        None => T::ONES,
    })
}

/// What is left of every slice, filled up with ones.
#[inline(always)]
fn filled<T: Real, const N: usize>(slices: [&[T]; N]) -> [[T; BLOCK]; N] {
    slices.map(|slice| {
        let mut block = *T::ONES;
        block.iter_mut().zip(slice).for_each(|(to, from)| *to = *from);
        block
    })
}

impl<F, S, O> Kernel<F, S, O> {
    /// One block, in place in `outputs`; false if some number may be none.
    #[inline(always)]
    fn block<T, const P: usize, const I: usize, const N: usize>(
        &self,
        parameters: [&[T; BLOCK]; P],
        inputs: [&[T; BLOCK]; I],
        outputs: &mut [[T; BLOCK]; N],
    ) -> bool
    where
        T: Real,
        F: Falling<T>,
        S: Source<T, P>,
        O: Operation<T, I, N>,
    {
        let mut alarm = T::Alarm::default();
        for k in 0..BLOCK {
            // There are so many; an index would be checked where the optimiser minds the size of the code.
            let at = |column: &[T; BLOCK]| column.get(k).copied().unwrap_or_else(T::one);
            let material = self.source.material(parameters.map(at));
            let before = outputs.each_ref().map(at);
            let after = self.operation.apply::<F>(&material, inputs.map(at), before);
            // Finite only if all are: ∞ − ∞ is NaN.
            let sum = after.into_iter().reduce(|sum, value| sum + value);
            alarm = alarm | sum.unwrap_or_else(T::zero).alarm();
            for (column, value) in outputs.iter_mut().zip(after) {
                if let Some(to) = column.get_mut(k) {
                    *to = value;
                }
            }
        }
        !T::is_raised(alarm)
    }

    /// All blocks.
    #[inline(always)]
    fn sweep<T, const P: usize, const I: usize, const N: usize>(
        &self,
        slices: Slices<'_, T, P, I, N>,
    ) -> Outcome
    where
        T: Real,
        F: Falling<T>,
        S: Source<T, P>,
        O: Operation<T, I, N>,
    {
        let Slices { mut parameters, mut inputs, mut outputs, length } = slices;
        let mut outcome = Outcome::default();
        let mut block = [*T::ONES; N];
        let mut done = 0;
        while done + BLOCK <= length {
            let (columns, numbers) = (next(&mut parameters), next(&mut inputs));
            if O::READS {
                for (column, slice) in block.iter_mut().zip(&outputs) {
                    *column = slice.first_chunk().copied().unwrap_or(*T::ONES);
                }
            }
            let finite = self.block(columns, numbers, &mut block);
            for (slice, column) in outputs.iter_mut().zip(&block) {
                if let Some((to, rest)) = core::mem::take(slice).split_first_chunk_mut() {
                    *to = *column;
                    *slice = rest;
                }
            }
            if !finite {
                outcome.count(&block, done, BLOCK);
            }
            done += BLOCK;
        }
        if done < length {
            let (columns, numbers) = (filled(parameters), filled(inputs));
            let mut block = filled(outputs.each_ref().map(|slice| &**slice));
            let finite = self.block(columns.each_ref(), numbers.each_ref(), &mut block);
            for (slice, column) in outputs.iter_mut().zip(&block) {
                slice.iter_mut().zip(column).for_each(|(to, from)| *to = *from);
            }
            if !finite {
                outcome.count(&block, done, length - done);
            }
        }
        outcome
    }
}

/// All bristles, with the widest vectors that the processor has.
#[cfg_attr(
    feature = "simd",
    multiversion::multiversion(targets(
        "x86_64+avx512f+avx512bw+avx512dq+avx512vl",
        "x86_64+avx2",
        "aarch64+neon",
    ))
)]
pub(super) fn run<T, F, S, K, const P: usize, const I: usize, const O: usize>(
    kernel: Kernel<F, S, K>,
    slices: Slices<'_, T, P, I, O>,
) -> Outcome
where
    T: Real,
    F: Falling<T>,
    S: Source<T, P>,
    K: Operation<T, I, O>,
{
    kernel.sweep(slices)
}

#[cfg(all(test, feature = "simd"))]
mod tests {
    use super::{Kernel, PhantomData, Slices, run};
    use crate::batch::Real;
    use crate::batch::kernel::{Hold, Predict};
    use crate::batch::material::{Gaussian, Material};
    use crate::scalar::{lit, to_f64};

    /// Velocities, normal forces and deflections of many decades.
    fn inputs<T: Real>() -> [[T; 501]; 3] {
        let wave = |k: usize, pace: f64| {
            lit::<T>((pace * k as f64).sin() * (pace * k as f64).exp2().recip())
        };
        [0.021, 0.017, 0.013].map(|pace| core::array::from_fn(|k| wave(k, pace)))
    }

    fn the_widest_vectors_give_the_bits_of_the_narrowest<T: Real>() {
        let source = Material {
            dynamic: T::one(),
            drop: lit(0.5),
            inverse_velocity: lit(100.0),
            viscous: lit(0.04),
            stiffness: lit(1e4),
            damping: lit(64.5),
        };
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
                let operation = Predict { duration };
                let kernel = Kernel { fall: PhantomData::<Gaussian>, source, operation };
                let _ = if wide { run(kernel, slices) } else { kernel.sweep(slices) };
                let mut held = [deflections, deflections];
                let outputs = held.each_mut().map(|column| column.as_mut_slice());
                let inputs = [&velocities[..], &loads];
                let slices = Slices { parameters: [], inputs, outputs, length: 501 };
                let kernel =
                    Kernel { fall: PhantomData::<Gaussian>, source, operation: Hold { duration } };
                let _ = if wide { run(kernel, slices) } else { kernel.sweep(slices) };
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
