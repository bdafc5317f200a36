//! How a run chooses its steps.

use nalgebra::SVector;

use super::Tolerances;
use crate::Scalar;

/// What a run needs to know besides its method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Settings<T: Scalar, const N: usize> {
    pub(super) control: Control<T, N>,
    /// Whether sliding directions are locked, and steps split at reversals and input kinks.
    pub(super) locks: bool,
    /// Limit on the number of trial steps.
    pub(super) most_steps: u64,
}

/// How the step is chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Control<T: Scalar, const N: usize> {
    Fixed(T),
    Adaptive { tolerances: Tolerances<T, N>, first_step: Option<T>, largest_step: Option<T> },
}

/// A run that needs more is one for another method.
const MOST_STEPS: u64 = 100_000_000;

impl<T: Scalar, const N: usize> Settings<T, N> {
    pub(super) fn new(control: Control<T, N>) -> Self {
        Self { control, locks: true, most_steps: MOST_STEPS }
    }
}

impl<T: Scalar, const N: usize> Control<T, N> {
    /// The error of each state that is allowed where it is found.
    #[inline]
    pub(super) fn scale(&self, state: &SVector<T, N>) -> SVector<T, N> {
        match self {
            Self::Fixed(_) => SVector::repeat(T::one()),
            Self::Adaptive { tolerances, .. } => tolerances.at(state),
        }
    }
}
