//! The dense output of one step: a polynomial in the fraction θ of the step,
//!
//! x(θ) = x₀ + θ (q₀ + θ̄ (q₁ + θ (q₂ + θ̄ (q₃ + …)))),  θ̄ = 1 − θ,  q₀ = x₁ − x₀.
//!
//! Each further term leaves the values at both ends unchanged. With q₁ = h f₀ − q₀ and
//! q₂ = q₀ − h f₁ − q₁ the polynomial also has the rates f₀ and f₁ at the ends.
//!
//! Source: E. Hairer, S. P. Nørsett, G. Wanner, "Solving Ordinary Differential Equations I", 2nd
//! edition (Springer, 1993), section II.6.

use nalgebra::SVector;

use crate::Scalar;

/// Largest number of terms: degree 7.
pub(super) const MOST_TERMS: usize = 7;

/// The dense output of one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DenseOutput<T, const N: usize> {
    start: SVector<T, N>,
    terms: [SVector<T, N>; MOST_TERMS],
    /// Number of terms in use.
    count: u8,
}

impl<T: Scalar, const N: usize> DenseOutput<T, N> {
    /// The polynomial from a state with the first few of the terms q₀, q₁, …
    #[inline]
    pub(super) fn new(
        start: SVector<T, N>,
        terms: [SVector<T, N>; MOST_TERMS],
        count: usize,
    ) -> Self {
        Self { start, terms, count: count as u8 }
    }

    /// The cubic through two states with the rates there, a signed duration apart, with the first
    /// few of some further terms.
    #[inline]
    pub(super) fn hermite(
        [start, end]: [&SVector<T, N>; 2],
        [start_rate, end_rate]: [&SVector<T, N>; 2],
        duration: T,
        further: [SVector<T, N>; MOST_TERMS - 3],
        count: usize,
    ) -> Self {
        let chord = end - start;
        let from_start = start_rate * duration - chord;
        let from_end = chord - end_rate * duration - from_start;
        let [q3, q4, q5, q6] = further;
        Self::new(*start, [chord, from_start, from_end, q3, q4, q5, q6], 3 + count)
    }

    /// The state at the start of the step.
    pub(super) fn start(&self) -> &SVector<T, N> {
        &self.start
    }

    /// Whether every coefficient is finite.
    pub(super) fn is_finite(&self) -> bool {
        let terms = self.terms.iter().take(usize::from(self.count));
        terms.flatten().all(|value| value.is_finite())
    }

    /// The state at a fraction of the step, 0 at its start and 1 at its end.
    #[inline]
    pub(super) fn at(&self, fraction: T) -> SVector<T, N> {
        let (part, rest) = (fraction, T::one() - fraction);
        let [q0, q1, q2, q3, q4, q5, q6] = &self.terms;
        // Written out for the degrees that occur: output-heavy runs spend their time here.
        let inner = match self.count {
            0..=3 => *q2,
            4 => q2 + q3 * rest,
            _ => q2 + (q3 + (q4 + (q5 + q6 * part) * rest) * part) * rest,
        };
        self.start + (q0 + (q1 + inner * part) * rest) * part
    }
}
