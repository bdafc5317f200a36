//! Kinks of the right-hand side that nobody declares, such as `max(−x, 0)` or a limited torque.
//!
//! A step h over a kink ΔJ (x − x_k)₊ has an error of about 0.01 h |ΔJ Δx|, where J is the Jacobian
//! and Δx the way of the states. An estimate of it may vanish by chance, where the kink lies at a
//! zero of its kernel. The Jacobians at both ends of the step show it: smooth entries change about
//! as fast as in the step before, those of ΔJ all at once.

use nalgebra::{SMatrix, SVector};

use crate::Scalar;
use crate::scalar::lit;

/// An entry that changes so many times faster than in the step before has a kink.
const SUDDEN: f64 = 200.0;

/// The error of a step over a kink, over h |ΔJ Δx|.
const ERROR: f64 = 0.01;

/// So many tolerances of such an error may be missed.
const MISSED: f64 = 10.0;

/// What is known of the changes of the Jacobian.
#[derive(Debug, Clone, Copy)]
pub(super) struct Kinks<T, const N: usize> {
    /// |dJ/dt| over the step before, if it is known.
    changes: Option<SMatrix<T, N, N>>,
}

impl<T: Scalar, const N: usize> Kinks<T, N> {
    /// Nothing known: at the start, and where a branch or an input changes.
    pub(super) fn new() -> Self {
        Self { changes: None }
    }

    /// Takes the Jacobians at both ends of a step of a length, over which the states have moved.
    /// Answers with a shorter one where the step has passed over a kink, with an error of many
    /// tolerances.
    pub(super) fn shorter(
        &mut self,
        [start, end]: &[SMatrix<T, N, N>; 2],
        (length, moved): (T, &SVector<T, N>),
        allowed: &SVector<T, N>,
    ) -> Option<T> {
        let change = (end - start).abs();
        if let Some(before) = &self.changes {
            let mut most = T::zero();
            for i in 0..N {
                let sudden =
                    (0..N).filter(|&j| change[(i, j)] > before[(i, j)] * length * lit(SUDDEN));
                let sum = sudden.fold(T::zero(), |sum, j| sum + change[(i, j)] * moved[j].abs());
                most = most.larger(sum * length * lit(ERROR / MISSED) / allowed[i]);
            }
            if most > T::one() {
                return Some(length * lit::<T>(0.9) / most.sqrt());
            }
        }
        self.changes = Some(change / length);
        None
    }
}

#[cfg(test)]
mod tests {
    use super::Kinks;
    use nalgebra::{Matrix2, Vector2};

    #[test]
    fn a_step_over_a_kink_is_shortened_and_a_smooth_one_is_not() {
        // A spring that is met: its stiffness of 1 000 comes all at once.
        let (away, met) = (Matrix2::new(0.0, 1.0, 0.0, -0.1), Matrix2::new(0.0, 1.0, -1e3, -0.1));
        let (moved, allowed) = (Vector2::new(-0.02, 0.0), Vector2::repeat(1e-6));
        let mut kinks = Kinks::new();
        // Of the first step nothing is known.
        assert_eq!(kinks.shorter(&[away, met], (0.02, &moved), &allowed), None);
        let mut kinks = Kinks::new();
        assert_eq!(kinks.shorter(&[away; 2], (0.02, &moved), &allowed), None);
        // 0.01 · 0.02 · 1000 · 0.02 over ten tolerances is 400.
        let shorter = kinks.shorter(&[away, met], (0.02, &moved), &allowed);
        assert_eq!(shorter.map(|h: f64| (h / 0.02 * 1e6).round()), Some(45_000.0));
        assert_eq!(kinks.shorter(&[away, met], (0.02, &(moved * 2e-3)), &allowed), None);
        // What has changed fast before may go on.
        assert_eq!(kinks.shorter(&[met, met * 2.0], (0.02, &moved), &allowed), None);
    }
}
