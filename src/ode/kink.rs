//! Kinks of the right-hand side that nobody declares, such as `max(−x, 0)` or a limited torque.
//!
//! A step h over a kink ΔJ (x − x_k)₊ has an error of about 0.01 h |ΔJ Δx|, where J is the Jacobian
//! and Δx the way of the states. An estimate of it may vanish by chance, where the kink lies at a
//! zero of its kernel. The Jacobians at both ends of the step show it: smooth entries change about
//! as fast as in the step before, those of ΔJ all at once.
//!
//! Where a limited torque goes from one limit to the other within a step, both Jacobians are the
//! same, and the rates jump by Δf. Then f₁ − f₀ − ½(J₀ + J₁)Δx changes all at once. The error is up
//! to 0.3 h Δf, of which the embedded estimate of order 4 shows a hundredth.
//!
//! An error of many tolerances asks for a shorter step, a smaller one is carried along with those
//! of all steps: a tenth of a tolerance in a velocity may be a hundred in a deflection after it has
//! reversed.

use nalgebra::{SMatrix, SVector};

use crate::Scalar;
use crate::scalar::lit;

/// An entry that changes so many times faster than in the step before has a kink.
const SUDDEN: f64 = 200.0;

/// The error of a step over a kink, over h |ΔJ Δx|.
const ERROR: f64 = 0.01;

/// What both Jacobians leave of the change of the rates jumps if it changes so many times faster
/// than in the step before, and by more than |ΔJ Δx|.
const JUMP: f64 = 30.0;

/// The error of a step over a jump, over h Δf: about the mean over its place.
const OF_JUMP: f64 = 0.1;

/// How fast something usually changes falls to no less than this part in a step: it may pass zero.
const FADES: f64 = 0.1;

/// So many tolerances of such an error may be missed.
const MISSED: f64 = 10.0;

/// What is known of the changes of the Jacobian.
#[derive(Debug, Clone, Copy)]
pub(super) struct Kinks<T, const N: usize> {
    /// |dJ/dt| over the step before, if it is known.
    changes: Option<SMatrix<T, N, N>>,
    /// What the Jacobians left unexplained of the change of the rates over the step before \[1/s\],
    /// and how fast that of each rate has changed.
    between: Option<[SVector<T, N>; 2]>,
    /// The error of each state by kinks in the last step, which no estimate need show.
    missed: SVector<T, N>,
}

impl<T: Scalar, const N: usize> Kinks<T, N> {
    /// Nothing known: at the start, and where a branch or an input changes.
    pub(super) fn new() -> Self {
        Self { changes: None, between: None, missed: SVector::zeros() }
    }

    /// The error of each state by kinks in a step that was taken after all.
    pub(super) fn missed(&mut self) -> SVector<T, N> {
        core::mem::replace(&mut self.missed, SVector::zeros())
    }

    /// Takes the Jacobians at both ends of a step of a length, over which the states and their
    /// rates have changed. Answers with a shorter one where the step has passed over a kink, with
    /// an error of many tolerances. The Jacobian of many states serves several steps: it is given
    /// for both ends, and a kink leaves ΔJ Δx.
    pub(super) fn shorter(
        &mut self,
        [start, end]: &[SMatrix<T, N, N>; 2],
        (length, [moved, sped]): (T, [SVector<T, N>; 2]),
        allowed: &SVector<T, N>,
    ) -> Option<T> {
        let (change, mean) = ((end - start).abs(), (end + start) * lit::<T>(0.5));
        let curved = change * moved.abs();
        self.missed = SVector::zeros();
        if let Some(before) = &self.changes {
            for i in 0..N {
                let sudden =
                    (0..N).filter(|&j| change[(i, j)] > before[(i, j)] * length * lit(SUDDEN));
                let sum = sudden.fold(T::zero(), |sum, j| sum + change[(i, j)] * moved[j].abs());
                self.missed[i] = sum * length * lit(ERROR);
            }
        }
        let left = (sped - mean * moved) / length;
        let mut speeds = SVector::repeat(lit(f64::INFINITY));
        if let Some([before, usual]) = &self.between {
            let jumps = (left - before).abs() * length;
            speeds = jumps / (length * length);
            for i in 0..N {
                if jumps[i] > usual[i] * length * length * lit(JUMP) && jumps[i] > curved[i] {
                    self.missed[i] += jumps[i] * length * lit(OF_JUMP);
                }
                if usual[i].is_finite() {
                    speeds[i] = speeds[i].larger(usual[i] * lit(FADES));
                }
            }
        }
        let most = self.missed.component_div(allowed).amax() * lit(1.0 / MISSED);
        if most > T::one() {
            self.missed = SVector::zeros();
            return Some(length * lit::<T>(0.9) / most.sqrt());
        }
        self.between = Some([left, speeds]);
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
        let step = |moved| (0.02, [moved, (away + met) * moved * 0.5]);
        let mut kinks = Kinks::new();
        // Of the first step nothing is known.
        assert_eq!(kinks.shorter(&[away, met], step(moved), &allowed), None);
        let mut kinks = Kinks::new();
        assert_eq!(kinks.shorter(&[away; 2], (0.02, [moved, away * moved]), &allowed), None);
        // 0.01 · 0.02 · 1000 · 0.02 over ten tolerances is 400.
        let shorter = kinks.shorter(&[away, met], step(moved), &allowed);
        assert_eq!(shorter.map(|h: f64| (h / 0.02 * 1e6).round()), Some(45_000.0));
        assert_eq!(kinks.missed(), Vector2::zeros());
        // A shorter way leaves eight tolerances, which are told once.
        assert_eq!(kinks.shorter(&[away, met], step(moved * 2e-3), &allowed), None);
        assert!((kinks.missed() - Vector2::new(0.0, 8e-6)).norm() < 1e-18);
        assert_eq!(kinks.missed(), Vector2::zeros());
        // What has changed fast before may go on.
        let met_more = [met, met * 2.0];
        let sped = met * moved * 1.5;
        assert_eq!(kinks.shorter(&met_more, (0.02, [moved, sped]), &allowed), None);
    }

    #[test]
    fn rates_that_jump_between_equal_jacobians_are_seen() {
        // v̇ = −0.1 t, and by 1 more from 0.035 on: a torque between its limits.
        let free = [Matrix2::new(0.0, 1.0, 0.0, 0.0); 2];
        let rate = |time: f64| -0.1 * time.powi(2) + if time > 0.035 { 1.0 } else { 0.0 };
        let step = |start: f64, end: f64| {
            let moved = Vector2::new(-0.01, -1e-4);
            (end - start, [moved, Vector2::new(moved[1], rate(end) - rate(start))])
        };
        let (mut kinks, allowed) = (Kinks::new(), Vector2::repeat(1e-5));
        for number in 0..3 {
            let start = 0.01 * f64::from(number);
            assert_eq!(kinks.shorter(&free, step(start, start + 0.01), &allowed), None);
            assert_eq!(kinks.missed(), Vector2::zeros());
        }
        // 0.1 · 0.01 · 1 is a hundred tolerances, ten times what may be missed.
        let shorter = kinks.shorter(&free, step(0.03, 0.04), &allowed);
        assert_eq!(shorter.map(|h: f64| (h * 1e5).round()), Some(285.0));
        // One of 0.0008 leaves eight, and nothing a little earlier.
        assert_eq!(kinks.shorter(&free, step(0.0345, 0.0353), &allowed), None);
        let missed = kinks.missed();
        assert!(missed[0] == 0.0 && (missed[1] / 8e-5 - 1.0).abs() < 0.01, "{missed}");
        // What changes slowly, passes zero and changes on does not jump.
        let mut kinks = Kinks::new();
        let cubic = |time: f64| Vector2::new(0.0, time.powi(3));
        for number in -5..6 {
            let start = 0.01 * f64::from(number);
            let step = (0.01, [Vector2::zeros(), cubic(start + 0.01) - cubic(start)]);
            assert_eq!(kinks.shorter(&free, step, &(allowed * 1e-9)), None);
            assert_eq!(kinks.missed(), Vector2::zeros());
        }
    }
}
