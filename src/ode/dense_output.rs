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
use crate::scalar::lit;

/// Largest number of terms: degree 7.
pub(super) const MOST_TERMS: usize = 7;

/// The largest θ⁴ θ̄³, which the last term is multiplied by.
const LAST: f64 = 6912.0 / 823_543.0;

/// The dense output of one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DenseOutput<T, const N: usize> {
    start: SVector<T, N>,
    terms: [SVector<T, N>; MOST_TERMS],
    /// Number of terms in use.
    count: u8,
}

impl<T: Scalar, const N: usize> DenseOutput<T, N> {
    /// The polynomial from a state with the terms q₀, q₁, …, at most seven.
    #[inline(always)]
    pub(super) fn new(start: SVector<T, N>, terms: &[SVector<T, N>]) -> Self {
        Self { start, terms: [SVector::zeros(); MOST_TERMS], count: 0 }.with(terms)
    }

    /// The polynomial with some further terms.
    #[inline(always)]
    pub(super) fn with(mut self, further: &[SVector<T, N>]) -> Self {
        for (place, term) in self.terms.iter_mut().skip(usize::from(self.count)).zip(further) {
            *place = *term;
        }
        self.count += further.len() as u8;
        self
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

    /// The estimated error within the step, over the error allowed each state, if the degree is 7:
    /// its last term falls from the one before as the error falls from it.
    pub(super) fn error(&self, allowed: &SVector<T, N>) -> T {
        let [.., before, last] = &self.terms;
        if usize::from(self.count) < MOST_TERMS {
            return T::zero();
        }
        let size = |term: &SVector<T, N>| term.component_div(allowed).amax();
        let (before, last) = (size(before), size(last));
        last * (last / before).smaller(T::one()) * lit(LAST)
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
