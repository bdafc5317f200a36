//! The state of a bristle: one deflection, or the stretches of several springs.

use core::fmt::Debug;
use core::ops::{Add, Mul, Neg, Sub};

use nalgebra::{SMatrix, SVector};

use super::{Modes, Weights};
use crate::Scalar;

/// The state of a bristle \[m\]: a scalar for a single deflection z, an `SVector` for the stretches
/// xᵢ of several springs. A simulation passes it on and needs no method of it; code that is generic
/// over the number of springs does. Implement it only where the relaxation has another structure.
///
/// The rate of any bristle of this crate is affine in its state, ẋ = −Λx + u. The relaxation matrix
/// Λ [1/s] is diag(aᵢ) plus a row repeated in every line: the stretch of each spring follows the
/// common rate ż, which depends on all of them, and decays on its own at aᵢ.
pub trait Deflection<T: Scalar>:
    Copy + Debug + PartialEq + Add<Output = Self> + Sub<Output = Self> + Mul<T, Output = Self>
{
    /// Number of springs.
    const SPRINGS: usize;

    /// The matrix Λ between a state and its rate [1/s]: a scalar λ for a scalar.
    type Relaxation: Copy + Debug + PartialEq + Neg<Output = Self::Relaxation>;

    /// The matrix Λ = diag(decay) + 1·rowᵀ, of the decay rates aᵢ [1/s] and of how each stretch
    /// slows the common rate, (|v|_ε/g) Kᵢ [1/s].
    fn relaxation(decay: Self, row: Self) -> Self::Relaxation;

    /// The matrix applied to a state, Λx [m/s].
    fn relax(relaxation: Self::Relaxation, state: Self) -> Self;

    /// The step of a given length as a linear map, see [`Deflection::weights`].
    type Weights: HeldWeights<T, Self>;

    /// The exact step of length h ≥ 0 \[s\] of ẋ = −Λx + u, with the matrix Λ and the drive u
    /// held: both its end and its mean are linear in the state x at its start and in u.
    fn weights(relaxation: Self::Relaxation, duration: T) -> Self::Weights;

    /// The largest |xᵢ|, to compare with a limit.
    #[inline(always)]
    fn largest(self) -> T {
        let mut most = T::zero();
        let _ = self.each(|x| {
            most = x.abs().larger(most);
            x
        });
        most
    }

    /// Every xᵢ cut to |xᵢ| ≤ limit; NaN stays NaN.
    #[inline(always)]
    fn within(self, limit: T) -> Self {
        self.each(|x| if x.abs() > limit { cut(x, limit) } else { x })
    }

    /// The same number for every spring.
    fn fill(value: T) -> Self;

    /// Σ aᵢ bᵢ: of stiffnesses and stretches, the force of the springs.
    fn inner_product(self, other: Self) -> T;

    /// The products aᵢ bᵢ, spring by spring.
    fn scaled_by(self, other: Self) -> Self;

    /// A function of each xᵢ.
    fn each(self, function: impl FnMut(T) -> T) -> Self;
}

/// The limit with the sign of x. Cold, so that a step does not wait for it: few reach their limit.
#[cold]
fn cut<T: Scalar>(x: T, limit: T) -> T {
    if x > limit { limit } else { -limit }
}

/// The exact step of a relaxing state under a held drive, as a linear map from the state at its
/// start and the drive to the state at its end and to its mean: [`Weights`] for one spring,
/// [`Modes`] for several. From [`Affine::weights`](crate::Affine::weights).
pub trait HeldWeights<T: Scalar, D: Deflection<T>>: Copy + Debug + PartialEq {
    /// The state at the end of the step, under a drive u [m/s] of each spring.
    fn end(&self, state: D, drive: D) -> D;

    /// The state averaged over the step, under a drive u [m/s].
    fn mean(&self, state: D, drive: D) -> D;

    /// The state averaged over the step, without a drive: the part of the mean that the state at
    /// the start has.
    #[inline]
    fn undriven_mean(&self, state: D) -> D {
        self.mean(state, D::fill(T::zero()))
    }

    /// The state averaged over the step, from zero under a drive u [m/s]: the part of the mean that
    /// the velocity has.
    #[inline]
    fn driven_mean(&self, drive: D) -> D {
        self.mean(D::fill(T::zero()), drive)
    }

    /// Σ kᵢ x̄ᵢ of the state averaged over the step, without a drive, for each of two k: the bias
    /// of a [companion step](crate::companion).
    #[inline]
    fn undriven_sums(&self, springs: [D; 2], state: D) -> [T; 2] {
        let mean = self.undriven_mean(state);
        springs.map(|springs| springs.inner_product(mean))
    }

    /// Σ kᵢ x̄ᵢ + d of the state averaged over the step, from zero under a drive of one times r: by
    /// how much a friction coefficient with the stiffness k and the damping d rises with the
    /// velocity, the damping of a [companion step](crate::companion).
    #[inline]
    fn driven_damping(&self, springs: D, drive: D, damping: T) -> T {
        springs.inner_product(self.driven_mean(drive)) + damping
    }

    /// ∫ Σ Kᵢ xᵢ (Λx)ᵢ dt over the step \[m\]: the energy that springs of stiffness K dissipate per
    /// unit normal force, with the matrix of a bristle diag(decay) + 1·(share K)ᵀ. It is a sum of
    /// squares, so that no rounding makes it negative.
    fn relaxed_energy(&self, stiffness: D, state: D, drive: D) -> T;
}

impl<T: Scalar> Deflection<T> for T {
    const SPRINGS: usize = 1;

    type Relaxation = T;

    #[inline(always)]
    fn relaxation(decay: T, row: T) -> T {
        decay + row
    }

    #[inline(always)]
    fn relax(relaxation: T, state: T) -> T {
        relaxation * state
    }

    type Weights = Weights<T>;

    #[inline]
    fn weights(relaxation: T, duration: T) -> Weights<T> {
        Weights::new(relaxation, duration)
    }

    #[inline(always)]
    fn fill(value: T) -> T {
        value
    }

    #[inline(always)]
    fn inner_product(self, other: T) -> T {
        self * other
    }

    #[inline(always)]
    fn scaled_by(self, other: T) -> T {
        self * other
    }

    #[inline(always)]
    fn each(self, mut function: impl FnMut(T) -> T) -> T {
        function(self)
    }
}

/// The matrix Λ = diag(decay) + 1·rowᵀ [1/s] between the stretches of several springs and their
/// rates, ẋ = −Λx + r v. Read it as λ of a model with such a bristle; [`matrix`](Self::matrix) has
/// all its entries.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DiagonalPlusRankOne<D> {
    /// Diagonal: the decay rate of each spring's own stretch.
    pub decay: D,
    /// The row repeated in every line: how each stretch slows the common rate.
    pub row: D,
}

impl<T: Scalar, const N: usize> DiagonalPlusRankOne<SVector<T, N>> {
    /// All entries, for a Jacobian: row i holds how the rate of stretch i depends on every stretch.
    pub fn matrix(&self) -> SMatrix<T, N, N> {
        SMatrix::from_fn(|i, j| self.row[j] + if i == j { self.decay[i] } else { T::zero() })
    }
}

impl<D: Neg<Output = D>> Neg for DiagonalPlusRankOne<D> {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self { decay: -self.decay, row: -self.row }
    }
}

impl<T: Scalar, const N: usize> Deflection<T> for SVector<T, N> {
    const SPRINGS: usize = N;

    type Relaxation = DiagonalPlusRankOne<Self>;

    #[inline]
    fn relaxation(decay: Self, row: Self) -> DiagonalPlusRankOne<Self> {
        DiagonalPlusRankOne { decay, row }
    }

    #[inline]
    fn relax(relaxation: DiagonalPlusRankOne<Self>, state: Self) -> Self {
        let common = Deflection::inner_product(relaxation.row, state);
        relaxation.decay.component_mul(&state).add_scalar(common)
    }

    type Weights = Modes<T, N>;

    #[inline]
    fn weights(relaxation: DiagonalPlusRankOne<Self>, duration: T) -> Modes<T, N> {
        Modes::new(relaxation, duration)
    }

    #[inline]
    fn fill(value: T) -> Self {
        Self::repeat(value)
    }

    #[inline]
    fn inner_product(self, other: Self) -> T {
        nalgebra::Matrix::dot(&self, &other)
    }

    #[inline]
    fn scaled_by(self, other: Self) -> Self {
        self.component_mul(&other)
    }

    #[inline]
    fn each(self, function: impl FnMut(T) -> T) -> Self {
        nalgebra::Matrix::map(&self, function)
    }
}

/// A deflection as N states of a [`System`](crate::ode::System), one for a scalar: for a mechanism
/// that is generic over the number of springs.
pub trait States<T: Scalar, const N: usize>: Deflection<T> {
    /// The deflection from its states \[m\].
    fn from_states(states: &SVector<T, N>) -> Self;

    /// The states \[m\] of a deflection, or their rates.
    fn states(self) -> SVector<T, N>;

    /// All entries of a relaxation, for a Jacobian.
    fn matrix(relaxation: Self::Relaxation) -> SMatrix<T, N, N>;
}

impl<T: Scalar> States<T, 1> for T {
    #[inline(always)]
    fn from_states(states: &SVector<T, 1>) -> T {
        states.x
    }

    #[inline(always)]
    fn states(self) -> SVector<T, 1> {
        SVector::<T, 1>::new(self)
    }

    #[inline(always)]
    fn matrix(relaxation: T) -> SMatrix<T, 1, 1> {
        SMatrix::<T, 1, 1>::new(relaxation)
    }
}

impl<T: Scalar, const N: usize> States<T, N> for SVector<T, N> {
    #[inline]
    fn from_states(states: &Self) -> Self {
        *states
    }

    #[inline]
    fn states(self) -> Self {
        self
    }

    #[inline]
    fn matrix(relaxation: DiagonalPlusRankOne<Self>) -> SMatrix<T, N, N> {
        relaxation.matrix()
    }
}
