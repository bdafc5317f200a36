//! Kinks of the right-hand side that nobody declares, such as `max(−x, 0)` or a limited torque.
//!
//! A step h over a kink ΔJ (x − x_k)₊ has an error of about 0.01 h |ΔJ Δx|, where J is the Jacobian
//! and Δx the way of the states. An estimate of it may vanish by chance, where the kink lies at a
//! zero of its kernel. The Jacobians at both ends of the step show it: smooth entries change about
//! as fast as in the step before, those of ΔJ all at once.

use nalgebra::{SMatrix, SVector};

use super::stepper::Point;
use crate::Scalar;
use crate::scalar::lit;

/// An entry that changes so many times faster than in the step before has a kink.
const SUDDEN: f64 = 200.0;

/// What a Jacobian leaves of the change of the rates has a kink if it changes so many times faster
/// than in the step before.
const LEFT: f64 = 10.0;

/// The error of a step over a kink, over h |ΔJ Δx|.
const ERROR: f64 = 0.01;

/// So many tolerances of such an error may be missed.
const MISSED: f64 = 10.0;

/// What is known of the changes of the Jacobian.
#[derive(Debug, Clone, Copy)]
pub(super) struct Kinks<T, const N: usize> {
    /// |dJ/dt| over the step before, if it is known.
    changes: Option<SMatrix<T, N, N>>,
    /// What a Jacobian left unexplained of the change of the rates over the step before \[1/s\],
    /// and how fast that has changed.
    left: Option<(SVector<T, N>, T)>,
}

impl<T: Scalar, const N: usize> Kinks<T, N> {
    /// Nothing known: at the start, and where a branch or an input changes.
    pub(super) fn new() -> Self {
        Self { changes: None, left: None }
    }

    /// Takes both ends of a step of many states, whose Jacobian serves several steps. What it
    /// leaves of the change of the rates, (f₁ − f₀ − J Δx)/h, comes of time and curvature and
    /// changes slowly. Answers with a shorter step where it changes all at once, for a kink adds ΔJ
    /// Δx.
    pub(super) fn sudden(
        &mut self,
        jacobian: &SMatrix<T, N, N>,
        (from, end): (&Point<T, N>, &Point<T, N>),
    ) -> Option<T> {
        let length = end.time - from.time;
        let explained = jacobian * (end.state - from.state);
        let left = (end.rate - from.rate - explained) / length;
        let mut speed = lit(f64::INFINITY);
        if let Some((before, usual)) = &self.left {
            let change = (left - before).component_div(&end.scale).amax();
            let most = change * length * length * lit(ERROR / MISSED);
            if change > *usual * length * lit(LEFT) && most > T::one() {
                return Some(length * lit::<T>(0.9) / most.sqrt());
            }
            speed = change / length;
        }
        self.left = Some((left, speed));
        None
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
    use super::{Kinks, Point};
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

    #[test]
    fn of_many_states_a_kink_shows_in_what_the_jacobian_leaves() {
        // v̇ = −1 + 1000 max(−x, 0) with the Jacobian of free flight.
        let free = Matrix2::new(0.0, 1.0, 0.0, 0.0);
        let point = |time: f64| {
            let state = Vector2::new(0.03 - time, -1.0);
            let rate = Vector2::new(-1.0, -1.0 - 0.1 * time + 1e3 * (-state[0]).max(0.0));
            Point { time, state, rate, scale: Vector2::repeat(1e-5) }
        };
        let mut kinks = Kinks::new();
        for step in 0..3 {
            let [from, end] = [0, 1].map(|end| point(0.01 * f64::from(step + end)));
            assert_eq!(kinks.sudden(&free, (&from, &end)), None, "{step}");
        }
        let from = point(0.03);
        // It leaves 10 after 0.01: an error of 0.001 · 0.01 · 10 is ten tolerances.
        let shorter = kinks.sudden(&free, (&from, &point(0.04)));
        assert_eq!(shorter.map(|h: f64| (h * 1e6).round()), Some(2846.0));
        assert_eq!(kinks.sudden(&free, (&from, &point(0.031))), None);
    }
}
