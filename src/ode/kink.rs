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

use super::growth::MANY;
use super::storage::{Entries, States, of_both, product};
use crate::Scalar;
use crate::scalar::lit;

/// An entry that changes so many times faster than in the step before has a kink.
const SUDDEN: f64 = 200.0;

/// The error of a step over a kink, over h |ΔJ Δx|.
const ERROR: f64 = 0.01;

/// What both Jacobians leave of the change of the rates jumps if it changes so many times faster
/// than in the step before, and by more than |ΔJ Δx|. Of many states more often one had passed zero
/// there: in proportion to their number more times faster.
const JUMP: f64 = 30.0;

/// The error of a step over a jump, over h Δf: about the mean over its place.
const OF_JUMP: f64 = 0.1;

/// How fast something usually changes falls to no less than this part in a step: it may pass zero.
const FADES: f64 = 0.1;

/// So many tolerances of such an error may be missed.
const MISSED: f64 = 10.0;

/// Beyond this part of a tolerance the error of a step tells of a kink, ...
const TELLS: f64 = 0.1;

/// ... which may be met again in so many steps.
const AGAIN: u32 = 40;

/// What is known of the changes of the Jacobian.
#[derive(Debug, Clone)]
pub(super) struct Kinks<T: Scalar, V: States<T>> {
    /// |dJ/dt| over the step before, if it is known.
    changes: Option<V::Matrix>,
    /// How fast the states have changed in the step before and what the Jacobians left unexplained
    /// of the change of the rates \[1/s\], or zeros and all; and how fast that of each has changed.
    between: Option<[V; 3]>,
    /// The error of each state by kinks in the last step, which no estimate need show.
    missed: V,
    /// Steps in which one that was met may be met again.
    near: u32,
}

impl<T: Scalar, V: States<T>> Kinks<T, V> {
    /// Nothing known of such states: at the start, and where a branch or an input changes.
    pub(super) fn new(state: &V) -> Self {
        Self { changes: None, between: None, missed: state.like(|_| T::zero()), near: 0 }
    }

    /// Whether one was met a few steps ago.
    pub(super) fn is_near(&self) -> bool {
        self.near > 0
    }

    /// The error of each state by kinks in a step that was taken after all.
    pub(super) fn missed(&mut self) -> V {
        let none = self.missed.like(|_| T::zero());
        core::mem::replace(&mut self.missed, none)
    }

    /// Takes a step of a length, over which the states and their rates have changed, and the
    /// product of the Jacobian with a vector. The Jacobians at both ends are given of few states,
    /// for that of many serves several steps, and a kink leaves ΔJ Δx. Answers with a shorter step
    /// where this one has passed over a kink, with an error of many tolerances.
    pub(super) fn shorter(
        &mut self,
        ends: Option<[&V::Matrix; 2]>,
        (length, [moved, sped]): (T, [V; 2]),
        times: impl FnOnce(&V) -> V,
        allowed: &V,
    ) -> Option<T> {
        let states = moved.count();
        self.missed.entries_mut().fill(T::zero());
        let (mut left, mut curved, mut change) = (sped, None, None);
        if let Some([start, end]) = ends {
            let changes = of_both(end, start, |end, start| (end - start).abs());
            let mean = of_both(end, start, |end, start| (end + start) * lit(0.5));
            curved = Some(product(states, changes.entries(), &moved.like(|i| moved[i].abs())));
            let explained = product(states, mean.entries(), &moved);
            left = left.with(&explained, |left, explained| left - explained);
            change = Some(changes);
        }
        left.entries_mut().iter_mut().for_each(|left| *left /= length);
        if let (Some(change), Some(before)) = (&change, &self.changes) {
            self.missed = sudden(change.entries(), before.entries(), &moved, length);
        }
        let mut moving = moved;
        for moving in moving.entries_mut() {
            *moving = if change.is_some() { T::zero() } else { *moving / length };
        }
        let mut speeds = left.like(|_| lit(f64::INFINITY));
        let leap = lit::<T>(JUMP * (states as f64 / MANY as f64).max(1.0)) * length * length;
        if let Some([moving_before, before, usual]) = &self.between {
            // One Jacobian for both steps: what another left is no jump.
            let explained = change.is_none().then(|| {
                let turned = moving.with(moving_before, |now, before| now - before);
                times(&turned)
            });
            for i in 0..states {
                let explained = explained.as_ref().map_or(T::zero(), |explained| explained[i]);
                let jump = (left[i] - before[i] - explained).abs() * length;
                speeds[i] = jump / (length * length);
                if jump > usual[i] * leap && curved.as_ref().is_none_or(|curved| jump > curved[i]) {
                    self.missed[i] += jump * length * lit(OF_JUMP);
                }
                if usual[i].is_finite() {
                    speeds[i] = speeds[i].larger(usual[i] * lit(FADES));
                }
            }
        }
        let missed = self.missed.over(allowed);
        self.near = if missed > lit(TELLS) { AGAIN } else { self.near.saturating_sub(1) };
        let most = missed * lit(1.0 / MISSED);
        if most > T::one() {
            self.missed.entries_mut().fill(T::zero());
            return Some(length * lit::<T>(0.9) / most.sqrt());
        }
        self.between = Some([moving, left, speeds]);
        self.changes = change.map(|mut change| {
            change.entries_mut().iter_mut().for_each(|change| *change /= length);
            change
        });
        None
    }
}

/// The error of each state, over a step of a length, by entries of the Jacobian that change far
/// more in it than in the step before.
fn sudden<T: Scalar, V: States<T>>(change: &[T], before: &[T], moved: &V, length: T) -> V {
    let states = moved.count();
    moved.like(|i| {
        let at = |j: usize| j * states + i;
        let sudden = (0..states).filter(|&j| change[at(j)] > before[at(j)] * length * lit(SUDDEN));
        let sum = sudden.fold(T::zero(), |sum, j| sum + change[at(j)] * moved[j].abs());
        sum * length * lit(ERROR)
    })
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
        let mut kinks = Kinks::new(&Vector2::zeros());
        // Of the first step nothing is known.
        assert_eq!(kinks.shorter(Some([&away, &met]), step(moved), |x| *x, &allowed), None);
        let mut kinks = Kinks::new(&Vector2::zeros());
        assert_eq!(
            kinks.shorter(Some([&away; 2]), (0.02, [moved, away * moved]), |x| *x, &allowed),
            None
        );
        // 0.01 · 0.02 · 1000 · 0.02 over ten tolerances is 400.
        let shorter = kinks.shorter(Some([&away, &met]), step(moved), |x| *x, &allowed);
        assert_eq!(shorter.map(|h: f64| (h / 0.02 * 1e6).round()), Some(45_000.0));
        assert_eq!(kinks.missed(), Vector2::zeros());
        // A shorter way leaves eight tolerances, which are told once.
        assert_eq!(kinks.shorter(Some([&away, &met]), step(moved * 2e-3), |x| *x, &allowed), None);
        assert!((kinks.missed() - Vector2::new(0.0, 8e-6)).norm() < 1e-18);
        assert_eq!(kinks.missed(), Vector2::zeros());
        // What has changed fast before may go on.
        let met_more = [&met, &(met * 2.0)];
        let sped = met * moved * 1.5;
        assert_eq!(kinks.shorter(Some(met_more), (0.02, [moved, sped]), |x| *x, &allowed), None);
    }

    #[test]
    fn rates_that_jump_between_equal_jacobians_are_seen() {
        // v̇ = −0.1 t, and by 1 more from 0.035 on: a torque between its limits.
        let free = Matrix2::new(0.0, 1.0, 0.0, 0.0);
        let rate = |time: f64| -0.1 * time.powi(2) + if time > 0.035 { 1.0 } else { 0.0 };
        let step = |start: f64, end: f64| {
            let moved = Vector2::new(-0.01, -1e-4);
            (end - start, [moved, Vector2::new(moved[1], rate(end) - rate(start))])
        };
        let (mut kinks, allowed) = (Kinks::new(&Vector2::zeros()), Vector2::repeat(1e-5));
        for number in 0..3 {
            let start = 0.01 * f64::from(number);
            assert_eq!(
                kinks.shorter(None, step(start, start + 0.01), |x| free * x, &allowed),
                None
            );
            assert_eq!(kinks.missed(), Vector2::zeros());
        }
        // 0.1 · 0.01 · 1 is a hundred tolerances, ten times what may be missed.
        let shorter = kinks.shorter(None, step(0.03, 0.04), |x| free * x, &allowed);
        assert_eq!(shorter.map(|h: f64| (h * 1e5).round()), Some(285.0));
        // One of 0.0008 leaves eight, and nothing a little earlier.
        assert_eq!(kinks.shorter(None, step(0.0345, 0.0353), |x| free * x, &allowed), None);
        let missed = kinks.missed();
        assert!(missed[0] == 0.0 && (missed[1] / 8e-5 - 1.0).abs() < 0.01, "{missed}");
        // What changes slowly, passes zero and changes on does not jump.
        let mut kinks = Kinks::new(&Vector2::zeros());
        let cubic = |time: f64| Vector2::new(0.0, time.powi(3));
        for number in -5..6 {
            let start = 0.01 * f64::from(number);
            let step = (0.01, [Vector2::zeros(), cubic(start + 0.01) - cubic(start)]);
            assert_eq!(kinks.shorter(None, step, |x| free * x, &(allowed * 1e-9)), None);
            assert_eq!(kinks.missed(), Vector2::zeros());
        }
    }

    #[test]
    fn a_jacobian_that_has_served_several_steps_and_is_renewed_is_no_jump() {
        let (mut kinks, step) = (Kinks::new(&Vector2::zeros()), Vector2::repeat(0.1));
        for number in 0..12 {
            let times = |x: &Vector2<f64>| x * f64::from(number / 4);
            let shorter = kinks.shorter(None, (0.1, [step; 2]), times, &(step * 1e-5));
            assert_eq!((shorter, kinks.missed()), (None, Vector2::zeros()), "{number}");
        }
    }
}
