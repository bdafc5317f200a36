//! The limit of the estimated error of a solution: a run stops where the errors of its steps have
//! grown beyond it.

use nalgebra::ComplexField;

use super::controller::rough_power;
use super::failure::StopReason;
use super::growth::{LARGE, MANY};
use super::integration::Integration;
use super::locked::{Interval, Locked};
use super::stepper::{OneStep, Point, Stepper, TrialStep};
use super::storage::{Entries, States, of_both, product, product_to};
use super::system::Equations;
use super::tolerance::Tolerances;
use crate::Scalar;
use crate::scalar::{lit, to_f64};

/// An estimated error so many times its limit tells no more than that it is too large.
const HOPELESS: f64 = 1e4;

/// A run that is stopped early has not met its largest errors: they grow about as the root of its
/// part of the span, taken to be at least this.
const LEAST_DONE: f64 = 0.1;

impl<T: Scalar, V: States<T>, S: Equations<T, V, K> + ?Sized, M: OneStep<T, V>, K>
    Integration<'_, T, V, S, M, K>
{
    /// Whether a step may be accepted by its part in the error of the solution; otherwise the next
    /// one is shorter. Told whether it was cut at a reversal.
    #[inline]
    pub(super) fn stands(
        &mut self,
        end: &Point<T, V>,
        trial: (&TrialStep<T, V>, f64),
        interval: Interval<T>,
        is_cut: bool,
    ) -> Result<bool, StopReason> {
        let strayed = self.strayed(end, interval, is_cut);
        match strayed.or_else(|| self.estimate(end, trial, interval)) {
            Some(shorter) => self.progress.shorten(shorter).map(|()| false),
            None => Ok(true),
        }
    }

    /// Takes the error of a step about to be accepted into the estimate of that of the solution.
    /// Answers with a shorter step where this one does not follow what grows, passes over a kink or
    /// over what happens while nothing moves, or has a curve between its ends that is farther off
    /// than a solution may be.
    #[inline]
    fn estimate(
        &mut self,
        end: &Point<T, V>,
        (trial, square): (&TrialStep<T, V>, f64),
        interval: Interval<T>,
    ) -> Option<T> {
        let most = self.most_growth?;
        let step = end.time - self.point.time;
        let shorter = self.grazed(end, interval).or_else(|| self.bent(end, most));
        let shorter = shorter.or_else(|| self.unseen(end, interval));
        if shorter.is_some() {
            return shorter;
        }
        let (stability, states) = (self.stepper.stability(), end.state.count());
        let mut field = Locked {
            system: self.system,
            scales: &self.scales,
            branches: &self.branches,
            interval,
            statistics: &mut self.progress.statistics,
        };
        let has_jacobian = states <= LARGE || stability.is_empty();
        let jacobians =
            has_jacobian.then(|| self.stepper.jacobians_of_step(&mut field, &self.point, end));
        let half = step * lit(0.5);
        let growth = jacobians.map(|[at, end]| of_both(at, end, |at, end| (at + end) * half));
        let tolerance = self.settings.tolerances.as_ref().map_or(0.0, Tolerances::largest);
        let change = |end: &V, start| end.with(start, |end, start| end - start);
        let changes = [change(&end.state, &self.point.state), change(&end.rate, &self.point.rate)];
        let times = |x: &V| match jacobians {
            Some([start, _]) => product(states, start.entries(), x),
            None => field.along(&self.point, x, T::one()),
        };
        let ends = jacobians.filter(|_| states < MANY);
        let remaining = (self.progress.end_time - self.point.time).abs();
        let (lengths, follows) = ((step.abs(), remaining), (trial.order, tolerance));
        let shorter = self.kinks.shorter(ends, (step, changes), times, &end.scale);
        let shorter =
            shorter.or_else(|| self.seeds.shorter(growth.as_ref()?, lengths, &end.scale, follows));
        if shorter.is_some() {
            return shorter;
        }
        let part = self.settings.method.tolerance_range().part_of_estimate(tolerance, trial.order);
        let mut times = |x: &V, to: &mut V| match &growth {
            Some(growth) => product_to(states, growth.entries(), x, to),
            None => *to = field.along(&self.point, x, step),
        };
        let errors = (&self.kinks.missed(), &end.scale);
        let carried = self.growth.carried((&mut times, growth.as_ref()), stability, errors);
        let square = self.growth.counted(jacobians, (step, trial.order), (square, part));
        let carried = (carried, growth.as_ref(), stability);
        self.growth.step(carried, (trial, square), &end.scale);
        None
    }

    /// A shorter step, where the curve within this one, which no later step carries along, is
    /// farther off than a solution may be.
    #[inline]
    fn bent(&self, end: &Point<T, V>, most: f64) -> Option<T> {
        let within = to_f64(self.step.dense_output.error(&end.scale)) / most;
        let step = end.time - self.point.time;
        (within > 1.0).then(|| step * lit(0.9 * rough_power(within, -1.0 / 8.0)))
    }

    /// Stops a run whose estimated error has outgrown its limit, once it is known by how much: a
    /// quarter of the steps later.
    pub(super) fn check_growth(&mut self) -> Result<(), StopReason> {
        let Some(limit) = self.most_growth else { return Ok(()) };
        let times = self.growth.greatest / limit;
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
