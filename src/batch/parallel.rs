//! The same blocks on several threads.

use super::Outcome;
use super::drive::{self, Kernel, Slices};
use super::kernel::Operation;
use super::material::{Falling, Source};
use super::real::{BLOCK, Real};

/// Bristles that are not worth a second thread: some 5 µs of work, as much as waking one takes.
const GRAIN: usize = 4096;

impl<'a, T, const P: usize, const I: usize, const O: usize> Slices<'a, T, P, I, O> {
    /// The bristles before an index, which is within the length, and the others.
    fn split_at(self, index: usize) -> (Self, Self) {
        let Slices { parameters, inputs, mut outputs, length } = self;
        let left = |slice: &'a [T]| slice.split_at_checked(index).unwrap_or((slice, &[])).0;
        let right = |slice: &'a [T]| slice.split_at_checked(index).unwrap_or((slice, &[])).1;
        let heads = outputs.each_mut().map(|slice| {
            let whole = core::mem::take(slice);
            match whole.split_at_mut_checked(index) {
                Some((head, tail)) => {
                    *slice = tail;
                    head
                }
                None => Default::default(),
            }
        });
        (
            Slices {
                parameters: parameters.map(left),
                inputs: inputs.map(left),
                outputs: heads,
                length: index,
            },
            Slices {
                parameters: parameters.map(right),
                inputs: inputs.map(right),
                outputs,
                length: length - index,
            },
        )
    }
}

/// All bristles, in halves of halves, on rayon's threads.
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
    if slices.length < 2 * GRAIN {
        return drive::run(kernel, slices);
    }
    // At a block's edge, so that only the last of all blocks is filled up.
    let middle = slices.length / 2 / BLOCK * BLOCK;
    let (left, right) = slices.split_at(middle);
    let (left, right) = rayon::join(|| run(kernel, left), || run(kernel, right));
    left.and(right, middle)
}
