//! Whether the derivatives that a system gives are those of its right-hand side: looked at now and
//! then, along a random direction d,
//!
//! |2 J d − (f(t, x + d) − f(t, x − d))|ᵢ ≤ 0.6 Σⱼ |Jᵢⱼ dⱼ| + rounding,
//!
//! with dⱼ some √ε of the scale of state j. To both sides, since a bristle about to yield has a
//! derivative of nearly zero: what is left of a difference to one side is then |v| times z. A kink
//! of the right-hand side may lie between, so only one that fails again and again, at other points
//! along other directions, is refused; and none where a switching function tells of the kink.

use super::failure::StopReason;
use super::integration::Integration;
use super::stepper::OneStep;
use super::storage::{Entries, States};
use super::system::Equations;
use crate::Scalar;
use crate::scalar::lit;

/// Steps that fail in a row.
const FAILURES: u32 = 4;

/// The part of its terms by which a derivative may be wrong: a difference is none either.
const PART: f64 = 0.3;

/// Rounding of a rate that is a sum of larger terms, over that of the rate.
const CANCELLED: f64 = 1e4;

/// What is known of the derivatives.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct DerivativeCheck {
    /// Steps that have failed in a row.
    failures: u32,
    /// The number of steps at which the derivatives are looked at next.
    next: u64,
    random: u32,
}

impl DerivativeCheck {
    /// A number of magnitude 0.5 to 1.5, of either sign.
    fn number<T: Scalar>(&mut self) -> T {
        // Numerical Recipes' linear congruential generator.
        self.random = self.random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let magnitude = 0.5 + f64::from(self.random >> 8) / f64::from(1 << 24);
        lit(if self.random >> 7 & 1 == 1 { magnitude } else { -magnitude })
    }
}

impl<T: Scalar, V: States<T>, S: Equations<T, V, K> + ?Sized, M: OneStep<T, V>, K>
    Integration<'_, T, V, S, M, K>
{
    /// Looks at the derivatives after steps 1, 2, 4, 8 and so on, and at once again where they
    /// fail. Not where no method has asked for them.
    #[inline]
    pub(super) fn check_derivatives(&mut self) -> Result<(), StopReason> {
        let statistics = &self.progress.statistics;
        if statistics.jacobians == 0 || statistics.steps < self.derivatives.next {
            return Ok(());
        }
        match self.wrong_derivative() {
            None => {
                self.derivatives.failures = 0;
                self.derivatives.next = 2 * self.progress.statistics.steps;
            }
            Some(component) => {
                self.derivatives.failures += 1;
                if self.derivatives.failures >= FAILURES {
                    return Err(StopReason::WrongDerivative { component });
                }
            }
        }
        Ok(())
    }

    /// The first component whose derivatives are not what a difference shows.
    #[cold]
    fn wrong_derivative(&mut self) -> Option<usize> {
        let (time, state) = (self.point.time, self.point.state.clone());
        let tangent = self.system.tangent(time, &state, &self.branches)?;
        let part = T::default_epsilon().sqrt();
        let (mut ahead, mut behind, states) = (state.clone(), state.clone(), state.count());
        for i in 0..states {
            let size = self.scales[i].abs().larger(state[i].abs());
            let apart = size * part * self.derivatives.number::<T>();
            (ahead[i], behind[i]) = (state[i] + apart, state[i] - apart);
        }
        let side = |state: &V| self.system.switching(time, state, &self.branches);
        if let (Some(one), Some(other)) = (side(&ahead), side(&behind))
            && (0..states).any(|i| !(one[i] * other[i] > T::zero()))
        {
            return None;
        }
        let rates = [self.evaluate(time, &ahead), self.evaluate(time, &behind)];
        (0..states).find(|&i| {
            let (mut along, mut terms) = (T::zero(), T::zero());
            for j in 0..states {
                let entry = tangent.by_state.entries()[j * states + i];
                let term = entry * (ahead[j] - behind[j]);
                (along, terms) = (along + term, terms + term.abs());
            }
            let rounding = T::default_epsilon() * lit(CANCELLED) * tangent.rate[i].abs();
            let off = (along - (rates[0][i] - rates[1][i])).abs();
            off.is_finite() && off > terms * lit(PART) + rounding
        })
    }
}
