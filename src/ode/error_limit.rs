//! The limit of the estimated error of a solution: a run stops where the errors of its steps have
//! grown beyond it.

use super::System;
use super::failure::StopReason;
use super::integration::Integration;
use super::locked::Interval;
use super::stepper::{Method, Point, Stepper, TrialStep};
use crate::Scalar;

/// An estimated error so many times its limit tells no more than that it is too large.
const HOPELESS: f64 = 1e4;

impl<T: Scalar, S: System<T, N, K>, M: Method<T, N>, const N: usize, const K: usize>
    Integration<'_, T, S, M, N, K>
{
    /// Takes the error of a step about to be accepted into the estimate of that of the solution.
    #[inline]
    pub(super) fn estimate(
        &mut self,
        end: &Point<T, N>,
        (trial, square): (&TrialStep<T, N>, f64),
        interval: Interval<T>,
    ) {
        if self.most_growth.is_none() {
            return;
        }
        let (stepper, mut field, from) = self.parts(interval);
        let jacobian = stepper.mean_jacobian(&mut field, from, end);
        let growth = jacobian * (end.time - self.point.time);
        self.growth.step(&growth, (&trial.error, square), &end.scale);
    }

    /// Stops a run whose estimated error has outgrown its limit, once it is known by how much: a
    /// quarter of the steps later.
    pub(super) fn check_growth(&mut self) -> Result<(), StopReason> {
        let Some(limit) = self.most_growth else { return Ok(()) };
        let times = self.growth.greatest() / limit;
        if times <= 1.0 {
            return Ok(());
        }
        let steps = self.progress.statistics.steps;
        let enough = *self.enough.get_or_insert(steps + steps / 4);
        if self.progress.is_over() || steps >= enough || times > HOPELESS {
            return Err(StopReason::ErrorsGrow { times });
        }
        Ok(())
    }
}
