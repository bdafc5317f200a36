//! Deflections side by side: at a velocity each element relaxes on its own.

use core::ops::{Add, Deref, Mul, Sub};

use bristle::Scalar;
use bristle::nalgebra::{SMatrix, SVector};
use bristle::rheology::{Deflection, HeldWeights, States, Weights};

/// The deflections xᵢ \[m\] of N elements side by side on one velocity; their step costs N steps of
/// one. An [`SVector`] in all but its relaxation, which couples no element with another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parallel<T: Scalar, const N: usize>(pub SVector<T, N>);

/// All at zero.
impl<T: Scalar, const N: usize> Default for Parallel<T, N> {
    fn default() -> Self {
        Self(SVector::zeros())
    }
}

impl<T: Scalar, const N: usize> Deref for Parallel<T, N> {
    type Target = SVector<T, N>;

    fn deref(&self) -> &SVector<T, N> {
        &self.0
    }
}

impl<T: Scalar, const N: usize> Add for Parallel<T, N> {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl<T: Scalar, const N: usize> Sub for Parallel<T, N> {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }
}

impl<T: Scalar, const N: usize> Mul<T> for Parallel<T, N> {
    type Output = Self;

    #[inline]
    fn mul(self, factor: T) -> Self {
        Self(self.0 * factor)
    }
}

impl<T: Scalar, const N: usize> Deflection<T> for Parallel<T, N> {
    const SPRINGS: usize = N;

    type Relaxation = SVector<T, N>;

    #[inline]
    fn relaxation(decay: Self, row: Self) -> SVector<T, N> {
        decay.0 + row.0
    }

    #[inline]
    fn relax(relaxation: SVector<T, N>, state: Self) -> Self {
        Self(relaxation.component_mul(&state.0))
    }

    type Weights = ParallelWeights<T, N>;

    #[inline]
    fn weights(relaxation: SVector<T, N>, duration: T) -> ParallelWeights<T, N> {
        ParallelWeights(
            relaxation.map(|relaxation| <T as Deflection<T>>::weights(relaxation, duration)),
        )
    }

    #[inline]
    fn fill(value: T) -> Self {
        Self(SVector::repeat(value))
    }

    #[inline]
    fn inner_product(self, other: Self) -> T {
        self.0.dot(&other.0)
    }

    #[inline]
    fn scaled_by(self, other: Self) -> Self {
        Self(self.0.component_mul(&other.0))
    }

    #[inline]
    fn each(self, function: impl FnMut(T) -> T) -> Self {
        Self(self.0.map(function))
    }
}

impl<T: Scalar, const N: usize> States<T, N> for Parallel<T, N> {
    fn from_states(states: &SVector<T, N>) -> Self {
        Self(*states)
    }

    fn states(self) -> SVector<T, N> {
        self.0
    }

    fn matrix(relaxation: SVector<T, N>) -> SMatrix<T, N, N> {
        SMatrix::from_diagonal(&relaxation)
    }
}

/// The exact steps of N elements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParallelWeights<T: Scalar, const N: usize>(SVector<Weights<T>, N>);

impl<T: Scalar, const N: usize> HeldWeights<T, Parallel<T, N>> for ParallelWeights<T, N> {
    #[inline]
    fn end(&self, state: Parallel<T, N>, drive: Parallel<T, N>) -> Parallel<T, N> {
        Parallel(SVector::from_fn(|i, _| self.0[i].end(state[i], drive[i])))
    }

    #[inline]
    fn mean(&self, state: Parallel<T, N>, drive: Parallel<T, N>) -> Parallel<T, N> {
        Parallel(SVector::from_fn(|i, _| self.0[i].mean(state[i], drive[i])))
    }

    fn relaxed_energy(
        &self,
        stiffness: Parallel<T, N>,
        state: Parallel<T, N>,
        drive: Parallel<T, N>,
    ) -> T {
        (0..N).fold(T::zero(), |sum, i| {
            sum + self.0[i].relaxed_energy(stiffness[i], state[i], drive[i])
        })
    }
}
