//! After a rejected trial step: a shorter one, or the reason why none succeeds.

use nalgebra::SVector;

use super::failure::StopReason;
use super::integration::{Integration, is_finite};
use super::stepper::{Field, Point, TrialStep};
use super::{Method, System};
use crate::Scalar;

impl<T: Scalar, S: System<T, N, K>, M: Method<T, N>, const N: usize, const K: usize>
    Integration<'_, T, S, M, N, K>
{
    /// Shortens the step after a rejected trial, or gives up at the smallest one.
    #[cold]
    pub(super) fn shorten(
        &mut self,
        tried: T,
        trial: &TrialStep<T, N>,
        square: f64,
    ) -> Result<(), StopReason> {
        let can_go_on = self.progress.reject(tried, square, trial.order);
        if !self.settings.locks && !self.progress.is_adaptive() {
            // Plain fixed steps have a fixed cost: there is no second trial.
            if is_finite(&trial.state) {
                let rate = self.evaluate(self.point.time + tried, &trial.state);
                return check_finite(&rate);
            }
        } else if can_go_on {
            return Ok(());
        }
        self.diagnosis(tried, trial)
    }

    /// Why no step from the current point succeeds.
    fn diagnosis(&mut self, tried: T, trial: &TrialStep<T, N>) -> Result<(), StopReason> {
        // The state that went bad first is the one whose rate did, a tiny step ahead.
        let Point { time, state, rate, .. } = self.point;
        let ahead = state + rate * tried;
        if self.settings.locks {
            self.velocities(time + tried, &ahead)?;
        }
        check_finite(&self.evaluate(time + tried, &ahead))?;
        if self.progress.statistics.jacobians > 0 {
            // Or the one whose derivatives did.
            let end = self.progress.end_time;
            let (_, mut field, _) = self.parts((time.smaller(end), time.larger(end)));
            let tangent = field.linearised(time, &state);
            check_finite(&tangent.by_time)?;
            for column in tangent.by_state.column_iter() {
                check_finite(&column.into_owned())?;
            }
        }
        // Where the linear system of an implicit method breaks down, the field is sound.
        if !self.progress.is_adaptive() || self.progress.statistics.jacobians == 0 {
            check_finite(&trial.state)?;
        }
        let contact = self.locks.iter().position(|lock| lock.stalled > 0);
        Err(contact
            .map_or(self.progress.too_small(), |contact| StopReason::EndlessReversals { contact }))
    }
}

/// Names the first component that is not finite.
pub(super) fn check_finite<T: Scalar, const N: usize>(
    vector: &SVector<T, N>,
) -> Result<(), StopReason> {
    match vector.iter().position(|value| !value.is_finite()) {
        Some(component) => Err(StopReason::NotFinite { component }),
        None => Ok(()),
    }
}
