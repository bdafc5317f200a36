//! The curve through one step: a polynomial in the fraction θ of the step, nested so that each term
//! more leaves the values at both ends as they are,
//!
//! x(θ) = x₀ + θ (q₀ + θ̄ (q₁ + θ (q₂ + θ̄ (q₃ + …)))),  θ̄ = 1 − θ,
//!
//! q₀ = x₁ − x₀. With q₁ = h f₀ − q₀ and q₂ = q₀ − h f₁ − q₁ it is the cubic through both ends with
//! their rates, whatever follows.
//!
//! Source: E. Hairer, S. P. Nørsett, G. Wanner, "Solving Ordinary Differential Equations I", 2nd
//! edition (Springer, 1993), section II.6.

use nalgebra::SVector;

use super::method::Point;
use crate::Scalar;

/// Most terms a curve has: degree 7.
pub(super) const TERMS: usize = 7;

/// The curve through one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Curve<T, const N: usize> {
    start: SVector<T, N>,
    terms: [SVector<T, N>; TERMS],
    /// Terms in use.
    count: u8,
}

impl<T: Scalar, const N: usize> Curve<T, N> {
    /// The curve from a state with the terms q₀, q₁, … (at most seven are kept).
    #[inline]
    pub fn new(start: SVector<T, N>, terms: &[SVector<T, N>]) -> Self {
        let mut curve = Self { start, terms: [SVector::zeros(); TERMS], count: 0 };
        for (place, term) in curve.terms.iter_mut().zip(terms) {
            *place = *term;
            curve.count += 1;
        }
        curve
    }

    /// The cubic through both ends with their rates.
    #[inline]
    pub fn hermite(from: &Point<T, N>, end: &Point<T, N>) -> Self {
        let duration = end.time - from.time;
        let chord = end.state - from.state;
        let from_start = from.rate * duration - chord;
        let from_end = chord - end.rate * duration - from_start;
        Self::new(from.state, &[chord, from_start, from_end])
    }

    /// The same curve with one term more.
    #[inline]
    pub(super) fn with(mut self, term: SVector<T, N>) -> Self {
        if let Some(place) = self.terms.get_mut(usize::from(self.count)) {
            *place = term;
            self.count += 1;
        }
        self
    }

    /// The state at the start of the step.
    pub(super) fn start(&self) -> &SVector<T, N> {
        &self.start
    }

    /// Whether every term is.
    pub(super) fn is_finite(&self) -> bool {
        let terms = self.terms.iter().take(usize::from(self.count));
        terms.flatten().all(|value| value.is_finite())
    }

    /// The state at a fraction of the step, 0 at its start and 1 at its end.
    #[inline]
    pub fn at(&self, fraction: T) -> SVector<T, N> {
        let (part, rest) = (fraction, T::one() - fraction);
        let [q0, q1, q2, q3, q4, q5, q6] = &self.terms;
        // Written out for the degrees that occur: a run with many samples spends its time here.
        let inner = match self.count {
            0..=3 => *q2,
            4 => q2 + q3 * rest,
            _ => q2 + (q3 + (q4 + (q5 + q6 * part) * rest) * part) * rest,
        };
        self.start + (q0 + (q1 + inner * part) * rest) * part
    }
}
