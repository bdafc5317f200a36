//! After a rejected trial step: a shorter one, or the reason why none succeeds.

use super::failure::StopReason;
use super::integration::Integration;
use super::stepper::{Field, OneStep, Point, TrialStep};
use super::storage::{Entries, States, columns};
use super::system::Equations;
use crate::Scalar;

impl<T: Scalar, V: States<T>, S: Equations<T, V, K> + ?Sized, M: OneStep<T, V>, K>
    Integration<'_, T, V, S, M, K>
{
    /// Shortens the step after a rejected trial, or gives up at the smallest one.
    #[cold]
    pub(super) fn shorten(
        &mut self,
        tried: T,
        trial: &TrialStep<T, V>,
        square: f64,
    ) -> Result<(), StopReason> {
        let can_go_on = self.progress.reject(tried, square, trial.order);
        if !self.settings.locks && !self.progress.is_adaptive() {
            // Plain fixed steps have a fixed cost: there is no second trial.
            if trial.state.is_finite() {
                let rate = self.evaluate(self.point.time + tried, &trial.state);
                return check_finite(rate.entries());
            }
        } else if can_go_on {
            return Ok(());
        }
        self.diagnosis(tried, trial)
    }

    /// Why no step from the current point succeeds.
    fn diagnosis(&mut self, tried: T, trial: &TrialStep<T, V>) -> Result<(), StopReason> {
        // The state that went bad first is the one whose rate did, a tiny step ahead.
        let Point { time, state, rate, .. } = self.point.clone();
        let ahead = state.with(&rate, |state, rate| state + rate * tried);
        if self.settings.locks {
            self.velocities(time + tried, &ahead)?;
        }
        check_finite(self.evaluate(time + tried, &ahead).entries())?;
        if self.progress.statistics.jacobians > 0 {
            // Or the one whose derivatives did.
            let end = self.progress.end_time;
            let (_, mut field, _) = self.parts((time.smaller(end), time.larger(end)));
            let tangent = field.linearised(time, &state);
            check_finite(tangent.by_time.entries())?;
            for column in columns(tangent.by_state.entries(), state.count()) {
                check_finite(column)?;
            }
        }
        // Where the linear system of an implicit method breaks down, the field is sound.
        if !self.progress.is_adaptive() || self.progress.statistics.jacobians == 0 {
            check_finite(trial.state.entries())?;
        }
        let contact = self.locks.entries().iter().position(|lock| lock.stalled > 0);
        Err(contact
            .map_or(self.progress.too_small(), |contact| StopReason::EndlessReversals { contact }))
    }
}

/// Names the first component that is not finite.
pub(super) fn check_finite<T: Scalar>(vector: &[T]) -> Result<(), StopReason> {
    match vector.iter().position(|value| !value.is_finite()) {
        Some(component) => Err(StopReason::NotFinite { component }),
        None => Ok(()),
    }
}
