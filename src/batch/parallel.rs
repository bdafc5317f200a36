//! The blocks of a batch on several threads.

use super::Outcome;
use super::drive::{self, Slices};
use super::kernel::Kernel;
use super::real::{BLOCK, Real};

/// Fewest bristles for a thread: some 5 µs of work, about the time that waking the thread takes.
const GRAIN: usize = 4096;

impl<'a, T, const P: usize, const I: usize, const O: usize> Slices<'a, T, P, I, O> {
    /// The bristles before an index, which is within the length, and the others.
    fn split_at(self, index: usize) -> (Self, Self) {
        let Slices { parameters, inputs, mut outputs, length } = self;
        let halves = |slice: &'a [T]| slice.split_at_checked(index).unwrap_or((slice, &[]));
        let heads = outputs.each_mut().map(|slice| {
            let whole = core::mem::take(slice);
            let (head, tail) = whole.split_at_mut_checked(index).unwrap_or_default();
            *slice = tail;
            head
        });
        let head = Slices {
            parameters: parameters.map(|slice| halves(slice).0),
            inputs: inputs.map(|slice| halves(slice).0),
            outputs: heads,
            length: index,
        };
        let tail = Slices {
            parameters: parameters.map(|slice| halves(slice).1),
            inputs: inputs.map(|slice| halves(slice).1),
            outputs,
            length: length - index,
        };
        (head, tail)
    }
}

/// Applies a kernel to all bristles, in halves of halves, on rayon's threads.
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
    if slices.length < 2 * GRAIN {
        return drive::run(kernel, slices);
    }
    // At the edge of a block, so that only the last block of all is padded.
    let middle = slices.length / 2 / BLOCK * BLOCK;
    let (left, right) = slices.split_at(middle);
    let (left, right) = rayon::join(|| run(kernel, left), || run(kernel, right));
    left.and(right, middle)
}
