//! What a step reports of its batch, and why a step is refused.

use core::fmt;

use super::real::{BLOCK, Real};
use bristle::ParameterError;

/// How many bristles a step has left with a result that is NaN or infinite. (Why a search for
/// parameters ended is a `bristle_identify::Outcome`.)
///
/// Such a bristle affects no other: the step is done for all. The crate's table says what it gets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[must_use = "bristles that became NaN are reported here and nowhere else"]
pub struct Outcome {
    /// Bristles with a result that is not finite.
    pub not_finite: usize,
    /// Index of the first of them.
    pub first: Option<usize>,
}

impl Outcome {
    /// Whether every bristle has finite results.
    pub fn is_finite(&self) -> bool {
        self.not_finite == 0
    }

    /// Counts the first `used` bristles of a block that begins at an index.
    #[cold]
    pub(super) fn count<T: Real, const N: usize, const O: usize>(
        &mut self,
        block: &[[[T; BLOCK]; N]; O],
        start: usize,
        used: usize,
    ) {
        for k in 0..used {
            let mut columns = block.iter().flatten();
            let finite = columns.all(|column| column.get(k).is_some_and(|x| x.is_finite()));
            if !finite {
                self.not_finite += 1;
                self.first = self.first.or(Some(start + k));
            }
        }
    }

    /// The outcome of this part of a batch and of the next, which begins at an index.
    #[cfg(feature = "rayon")]
    pub(super) fn and(self, next: Self, start: usize) -> Self {
        Self {
            not_finite: self.not_finite + next.not_finite,
            first: self.first.or(next.first.map(|first| start + first)),
        }
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.first {
            None => f.write_str("all finite"),
            Some(first) => write!(f, "{} not finite, the first at {first}", self.not_finite),
        }
    }
}

/// Why a batch, or a step of it, was refused. Nothing has been changed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BatchError {
    /// A parameter is out of its range. Of a slice the index is given too.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The lengths of two slices do not go together.
    #[error("{name} has length {length}, but {other} asks for {expected}")]
    Length {
        /// Name of the slice.
        name: &'static str,
        /// Its length.
        length: usize,
        /// Name of the slice to whose length it must be in proportion.
        other: &'static str,
        /// The length that it must have.
        expected: usize,
    },
    /// A slice does not hold one number for every axis of every bristle.
    #[error("{name} has length {length}, which is no multiple of {axes}, the number of axes")]
    Axes {
        /// Name of the slice.
        name: &'static str,
        /// Its length.
        length: usize,
        /// Number of axes.
        axes: usize,
    },
}
