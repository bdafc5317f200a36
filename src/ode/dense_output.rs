//! The dense output of one step: a polynomial in the fraction θ of the step,
//!
//! x(θ) = x₀ + θ (q₀ + θ̄ (q₁ + θ (q₂ + θ̄ (q₃ + …)))),  θ̄ = 1 − θ,  q₀ = x₁ − x₀.
//!
//! Each further term leaves the values at both ends unchanged. With q₁ = h f₀ − q₀ and
//! q₂ = q₀ − h f₁ − q₁ the polynomial also has the rates f₀ and f₁ at the ends.
//!
//! Source: E. Hairer, S. P. Nørsett, G. Wanner, "Solving Ordinary Differential Equations I", 2nd
//! edition (Springer, 1993), section II.6.

use core::marker::PhantomData;

use super::storage::{States, slices};
use crate::Scalar;
use crate::scalar::lit;

/// Largest number of terms: degree 7.
pub(super) const MOST_TERMS: usize = 7;

/// The largest θ⁴ θ̄³, which the last term is multiplied by.
const LAST: f64 = 6912.0 / 823_543.0;

/// The dense output of one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DenseOutput<T, V> {
    pub(super) start: V,
    terms: [V; MOST_TERMS],
    /// Number of terms in use.
    count: u8,
    scalar: PhantomData<T>,
}

impl<T: Scalar, V: States<T>> DenseOutput<T, V> {
    /// The polynomial from a state with the terms q₀, q₁, q₂.
    #[inline(always)]
    pub(super) fn new(start: V, [q0, q1, q2]: [V; 3]) -> Self {
        let none = || V::filled(0, T::zero());
        Self {
            start,
            terms: [q0, q1, q2, none(), none(), none(), none()],
            count: 3,
            scalar: PhantomData,
        }
    }

    /// Adds a further term, the seventh at most.
    #[inline(always)]
    pub(super) fn push(&mut self, further: V) {
        if let Some(place) = self.terms.get_mut(usize::from(self.count)) {
            *place = further;
            self.count += 1;
        }
    }

    /// Whether it has more than the cubic through both ends with their rates.
    pub(super) fn is_extended(&self) -> bool {
        self.count > 3
    }

    /// Whether every coefficient is finite.
    pub(super) fn is_finite(&self) -> bool {
        self.terms.iter().take(usize::from(self.count)).all(V::is_finite)
    }

    /// The estimated error within the step, over the error allowed each state, if the degree is 7:
    /// its last term falls from the one before as the error falls from it.
    pub(super) fn error(&self, allowed: &V) -> T {
        let [.., before, last] = &self.terms;
        if usize::from(self.count) < MOST_TERMS {
            return T::zero();
        }
        let (before, last) = (before.over(allowed), last.over(allowed));
        last * (last / before).smaller(T::one()) * lit(LAST)
    }

    /// The state at a fraction of the step, 0 at its start and 1 at its end.
    #[inline]
    pub(super) fn at(&self, fraction: T) -> V {
        let mut state = self.start.clone();
        self.at_to(fraction, &mut state);
        state
    }

    /// The same, written over a state.
    #[inline]
    pub(super) fn at_to(&self, fraction: T, state: &mut V) {
        let (part, rest) = (fraction, T::one() - fraction);
        let states = self.start.count();
        let [q0, q1, q2, q3, q4, q5, q6] = &self.terms;
        let [start, q0, q1, q2] = slices(states, [&self.start, q0, q1, q2]);
        let outer = |i: usize, inner: T| start[i] + (q0[i] + (q1[i] + inner * part) * rest) * part;
        // Written out for the degrees that occur: output-heavy runs spend their time here.
        let at = &mut state.entries_mut()[..states];
        match self.count {
            0..=3 => (0..states).for_each(|i| at[i] = outer(i, q2[i])),
            4 => {
                let [q3] = slices(states, [q3]);
                (0..states).for_each(|i| at[i] = outer(i, q2[i] + q3[i] * rest));
            }
            _ => {
                let [q3, q4, q5, q6] = slices(states, [q3, q4, q5, q6]);
                let inner = |i: usize| (q4[i] + (q5[i] + q6[i] * part) * rest) * part;
                (0..states).for_each(|i| at[i] = outer(i, q2[i] + (q3[i] + inner(i)) * rest));
            }
        }
    }
}
