//! The limit of the estimated error of a solution: a run stops where the errors of its steps have
//! grown beyond it.

use nalgebra::ComplexField;

use super::System;
use super::controller::rough_power;
use super::failure::StopReason;
use super::growth::MANY;
use super::integration::Integration;
use super::locked::Interval;
use super::stepper::{Method, Point, Stepper, TrialStep};
use crate::Scalar;
use crate::scalar::{lit, to_f64};

/// An estimated error so many times its limit tells no more than that it is too large.
const HOPELESS: f64 = 1e4;

/// A run that is stopped early has not met its largest errors: they grow about as the root of its
/// part of the span, taken to be at least this.
const LEAST_DONE: f64 = 0.1;

impl<T: Scalar, S: System<T, N, K>, M: Method<T, N>, const N: usize, const K: usize>
    Integration<'_, T, S, M, N, K>
{
    /// Takes the error of a step about to be accepted into the estimate of that of the solution.
    /// Answers with a shorter step where this one does not follow what grows, passes over a kink or
    /// over what happens while nothing moves, or has a curve between its ends that is farther off
    /// than a solution may be; a step that ends at a reversal is taken as it is.
    #[inline]
    pub(super) fn estimate(
        &mut self,
        end: &Point<T, N>,
        (trial, square): (&TrialStep<T, N>, f64),
        (interval, is_cut): (Interval<T>, bool),
    ) -> Option<T> {
        let most = self.most_growth?;
        let step = end.time - self.point.time;
        if !is_cut {
            // The curve within the step, which no later step carries along.
            let within = to_f64(self.step.dense_output.error(&end.scale)) / most;
            if within > 1.0 {
                return Some(step * lit(0.9 * rough_power(within, -1.0 / 8.0)));
            }
            let shorter = self.unseen(end, interval);
            if shorter.is_some() {
                return shorter;
            }
        }
        let (stepper, mut field, from) = self.parts(interval);
        let jacobians = stepper.jacobians_of_step(&mut field, from, end);
        let growth = (jacobians[0] + jacobians[1]) * (step * lit(0.5));
        let tolerance = self.settings.tolerances.map_or(0.0, |tolerances| tolerances.largest());
        if !is_cut {
            let changes = [end.state - self.point.state, end.rate - self.point.rate];
            let ends = if N < MANY { jacobians } else { [jacobians[0]; 2] };
            let shorter = self.kinks.shorter(&ends, (step, changes), &end.scale);
            if shorter.is_some() {
                return shorter;
            }
            let remaining = (self.progress.end_time - self.point.time).abs();
            let follows = (trial.order, tolerance);
            let shorter = self.seeds.shorter(&growth, (step.abs(), remaining), &end.scale, follows);
            if shorter.is_some() {
                return shorter;
            }
        }
        let part = self.settings.method.tolerance_range().part_of_estimate(tolerance, trial.order);
        let stability = self.stepper.stability();
        let errors = (trial, square * part * part, &self.kinks.missed());
        self.growth.step((&growth, stability), errors, &end.scale);
        None
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
            let way = self.progress.end_time - self.progress.start_time;
            let done = to_f64((self.point.time - self.progress.start_time) / way);
            return Err(StopReason::ErrorsGrow {
                times: times / ComplexField::sqrt(f64::max(done, LEAST_DONE)),
            });
        }
        Ok(())
    }
}
