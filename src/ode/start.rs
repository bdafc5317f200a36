//! The start of a run: the first evaluation, the first sliding directions and the first step.

use super::controller::rough_power;
use super::failure::StopReason;
use super::integration::Integration;
use super::rejection::check_finite;
use super::stepper::{OneStep, Point};
use super::storage::{Entries, States, euclidean};
use super::system::Equations;
use crate::scalar::{is_zero, lit, to_f64};
use crate::{Branch, Scalar};

impl<T: Scalar, V: States<T>, S: Equations<T, V, K> + ?Sized, M: OneStep<T, V>, K>
    Integration<'_, T, V, S, M, K>
{
    /// First evaluation, first step size, first branches.
    pub(super) fn start(&mut self) -> Result<(), StopReason> {
        self.refresh_rate();
        check_finite(self.point.rate.entries())?;
        let length = match self.progress.given_length() {
            Some(length) => length,
            None => self.first_step(),
        };
        self.progress.start(length)?;
        if self.settings.locks {
            self.choose_branches()?;
            self.refresh_locks();
            self.refresh_rate();
        }
        Ok(())
    }

    /// Locks each contact to the direction in which it slides, or is about to.
    fn choose_branches(&mut self) -> Result<(), StopReason> {
        let Point { mut time, mut state, mut rate, .. } = self.point.clone();
        let later = self.progress.length * lit(1e-3);
        let mut velocities = self.velocities(time, &state)?;
        // Without a velocity, the one a little later tells the direction; without an acceleration,
        // the one after that.
        for attempt in 0..2 {
            if !velocities.entries().iter().any(|&velocity| is_zero(velocity)) {
                break;
            }
            if attempt > 0 {
                rate = self.evaluate(time, &state);
            }
            (time, state) = (time + later, state.with(&rate, |state, rate| state + rate * later));
            let soon = self.system.velocities(time, &state);
            for (velocity, &soon) in velocities.entries_mut().iter_mut().zip(soon.entries()) {
                *velocity = if is_zero(*velocity) { soon } else { *velocity };
            }
        }
        let locks = self.locks.entries_mut().iter_mut();
        for (lock, &velocity) in locks.zip(velocities.entries()) {
            lock.branch = Branch::locked(velocity);
        }
        Ok(())
    }

    /// The first step, from the size of the rate and its change along it (E. Hairer, S. P. Nørsett,
    /// G. Wanner, "Solving Ordinary Differential Equations I", section II.4).
    fn first_step(&mut self) -> T {
        let Point { time, state, rate, scale } = self.point.clone();
        let states = state.count();
        let norm = |vector: &V| {
            let parts = vector.with(&scale, |entry, scale| entry / scale);
            euclidean(states, parts.entries()) / lit::<T>(states.max(1) as f64).sqrt()
        };
        let (size, speed) = (norm(&state), norm(&rate));
        let (tiny, span): (T, T) = (lit(1e-5), self.progress.span());
        let guess = if size > tiny && speed > tiny { size / speed * lit(0.01) } else { T::zero() };
        let fallback = span * lit(1e-6);
        let guess = (if guess > T::zero() { guess } else { fallback }).smaller(span);
        let later =
            self.evaluate(time + guess, &state.with(&rate, |state, rate| state + rate * guess));
        let bend = norm(&later.with(&rate, |later, rate| later - rate)) / guess;
        let most = speed.larger(bend);
        let by_rate = if most > lit(1e-15) {
            lit::<T>(rough_power(to_f64(most) * 100.0, -0.2))
        } else {
            guess * lit(1e3)
        };
        let step = (guess * lit(100.0)).smaller(by_rate);
        if step.is_finite() && step > T::zero() { step } else { fallback }
    }
}
