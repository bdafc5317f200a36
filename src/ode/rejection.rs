//! What follows a rejected trial: a shorter one, or the reason why none succeeds.

use nalgebra::SVector;

use super::System;
use super::failure::StopReason;
use super::integration::Integration;
use super::stepper::{Field, Method, TrialStep};
use crate::Scalar;
use crate::bounds::{larger, smaller};

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
        let can_go_on = self.walk.reject(tried, square, trial.order);
        if !self.settings.locks && !self.walk.is_adaptive() {
            // Plain fixed steps have a fixed cost: there is no second trial.
            if is_finite(&trial.state) {
                let rate = self.evaluate(self.point.time + tried, &trial.state);
                return check_finite(&rate);
            }
        } else if can_go_on {
            return Ok(());
        }
        Err(self.diagnosis(tried, trial))
    }

    /// Why no step from the current point succeeds.
    fn diagnosis(&mut self, tried: T, trial: &TrialStep<T, N>) -> StopReason {
        // The state that went bad first is the one whose rate did, a tiny step ahead.
        let time = self.point.time;
        let ahead = self.point.state + self.point.rate * tried;
        let mut found = check_finite(&self.evaluate(time + tried, &ahead));
        if self.settings.locks {
            let velocities = self.system.sliding_velocities(time + tried, &ahead);
            if let Some(contact) = velocities.iter().position(|velocity| !velocity.is_finite()) {
                return StopReason::VelocityNotFinite { contact };
            }
        }
        if self.walk.statistics.jacobians > 0 {
            // Or the one whose derivatives did.
            let (now, state) = (self.point.time, self.point.state);
            let end = self.walk.end_time;
            let (_, mut field, _) = self.parts((smaller(now, end), larger(now, end)));
            let tangent = field.linearised(now, &state);
            found = found.and_then(|()| check_finite(&tangent.by_time));
            for column in tangent.by_state.column_iter() {
                found = found.and_then(|()| check_finite(&column.into_owned()));
            }
        }
        if let Err(reason) = found.and_then(|()| check_finite(&trial.state)) {
            return reason;
        }
        match self.locks.iter().position(|lock| lock.stalled > 0) {
            Some(contact) => StopReason::EndlessReversals { contact },
            None => self.walk.too_small(),
        }
    }
}

pub(super) fn is_finite<T: Scalar, const N: usize>(vector: &SVector<T, N>) -> bool {
    vector.iter().all(|value| value.is_finite())
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
