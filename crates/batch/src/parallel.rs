//! The blocks of a batch on several threads.

use super::Outcome;
use super::drive::{self, Slices};
use super::kernel::Kernel;
use super::real::{BLOCK, Real};

/// Fewest bristles for a thread: some 5 µs of work, about the time that waking the thread takes.
const GRAIN: usize = 4096;

impl<'a, T, const N: usize, const P: usize, const I: usize, const O: usize>
    Slices<'a, T, N, P, I, O>
{
    /// Takes off the bristles before an index, which is within the length.
    fn split_off(&mut self, index: usize) -> Self {
        self.length -= index;
        let head = |slice: &mut &'a [T]| slice.split_off(..index).unwrap_or_default();
        Slices {
            parameters: self.parameters.each_mut().map(head),
            inputs: self.inputs.each_mut().map(|axes| axes.each_mut().map(head)),
            outputs: self.outputs.each_mut().map(|axes| {
                axes.each_mut().map(|slice| slice.split_off_mut(..index).unwrap_or_default())
            }),
            length: index,
        }
    }
}

/// Applies a kernel to all bristles, in halves of halves, on rayon's threads.
pub(super) fn run<T: Real, const N: usize, const P: usize, const I: usize, const O: usize>(
    kernel: impl Kernel<T, N, P, I, O>,
    mut slices: Slices<'_, T, N, P, I, O>,
) -> Outcome {
    if slices.length < 2 * GRAIN {
        return drive::run(kernel, slices);
    }
    // At the edge of a block, so that only the last block of all is padded.
    let middle = slices.length / 2 / BLOCK * BLOCK;
    let left = slices.split_off(middle);
    let (left, right) = rayon::join(|| run(kernel, left), || run(kernel, slices));
    left.and(right, middle)
}
