//! The progress of a run over its time span: where a step ends at the latest, and how long the
//! next trial is.

use super::controller::Controller;
use super::failure::StopReason;
use super::statistics::Statistics;
use crate::Scalar;
use crate::parameter::{Checked, Named};
use crate::scalar::{lit, to_f64};

/// A time \[s\] below any that matters, for the rounding of times near zero.
const INSTANT: f64 = 1e-30;

/// A run that needs more trial steps calls for another method.
const MOST_STEPS: u64 = 100_000_000;

/// How a run chooses its steps, and how many it may try.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StepControl<T> {
    /// The length of all steps \[s\]; chosen by the error if there is none.
    pub(crate) fixed_step: Option<T>,
    /// The length of the first adaptive step \[s\]; estimated if there is none.
    pub(crate) first_step: Option<T>,
    /// A limit of adaptive steps \[s\].
    pub(crate) largest_step: Option<T>,
    pub(crate) most_steps: u64,
}

impl<T: Scalar> StepControl<T> {
    pub(crate) fn adaptive() -> Self {
        Self { fixed_step: None, first_step: None, largest_step: None, most_steps: MOST_STEPS }
    }

    /// With a further limit of adaptive steps \[s\].
    pub(crate) fn limited(self, limit: Option<T>) -> Self {
        let limits = self.largest_step.into_iter().chain(limit.filter(|&limit| limit > T::zero()));
        Self { largest_step: limits.reduce(T::smaller), ..self }
    }

    pub(crate) fn fixed(step: T) -> Checked<Self> {
        Ok(Self { fixed_step: Some(Named("step", step).positive()?), ..Self::adaptive() })
    }
}

/// A time that no step may pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StopTime<T> {
    /// The time \[s\].
    pub(crate) time: T,
    /// Whether an input has a kink there.
    pub(crate) is_kink: bool,
}

/// The next step to try.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct NextStep<T> {
    /// Its signed length \[s\].
    pub(crate) step: T,
    /// The time at its end \[s\].
    pub(crate) end_time: T,
    /// What it must not pass.
    pub(crate) stop: StopTime<T>,
    /// Whether it ends at the stop.
    pub(crate) reaches: bool,
}

/// How far a run has come in its time span.
#[derive(Debug, Clone)]
pub(crate) struct Progress<T> {
    control: StepControl<T>,
    pub(crate) start_time: T,
    pub(crate) end_time: T,
    /// The time reached \[s\].
    pub(crate) time: T,
    /// Length of the next trial \[s\], positive.
    pub(crate) length: T,
    controller: Controller,
    /// Steps of a fixed grid completed.
    grid: u64,
    pub(crate) statistics: Statistics,
}

impl<T: Scalar> Progress<T> {
    pub(crate) fn new(control: StepControl<T>, (start_time, end_time): (T, T)) -> Self {
        Self {
            control,
            start_time,
            end_time,
            time: start_time,
            length: T::zero(),
            controller: Controller::new(),
            grid: 0,
            statistics: Statistics::default(),
        }
    }

    /// The length of the first step, if it is fixed or was asked for.
    pub(crate) fn given_length(&self) -> Option<T> {
        self.control.fixed_step.or(self.control.first_step)
    }

    /// Checks that the span ends no earlier than it starts and is long enough, and that the steps
    /// of an adaptive run that were given advance the time where it starts.
    pub(crate) fn check(&self) -> Checked<()> {
        Named("span.end", self.end_time).at_least("span.start", self.start_time)?;
        let is_long = self.span() >= lit(INSTANT) || self.start_time == self.end_time;
        let rule = "be span.start, or at least 1e-30 s later";
        Named("span.end", self.end_time).stated(is_long, rule)?;
        // A span that is one rounding of the time long is one step.
        let least = self.smallest_step().smaller(self.span());
        let StepControl { first_step, largest_step, .. } = self.control;
        for (name, step) in [("first_step", first_step), ("largest_step", largest_step)] {
            if let Some(step) = step.filter(|_| self.is_adaptive()) {
                Named(name, step).at_least("the smallest that advances the time", least)?;
            }
        }
        Ok(())
    }

    /// Sets the length of the first step: as given, or a guess.
    pub(crate) fn start(&mut self, length: T) -> Result<(), StopReason> {
        let late = self.start_time.abs().larger(self.end_time.abs());
        let is_too_small = length < self.span() && length < self.rounding(late);
        if is_too_small && !self.is_adaptive() {
            return Err(self.too_small());
        }
        // A guess may be shorter than what advances the time.
        let is_guess = self.given_length().is_none();
        let least = if is_guess { self.smallest_step() * lit(2.0) } else { T::zero() };
        self.propose(Some(length.larger(least)));
        self.limit_length(self.span());
        Ok(())
    }

    pub(crate) fn is_adaptive(&self) -> bool {
        self.control.fixed_step.is_none()
    }

    pub(crate) fn is_over(&self) -> bool {
        self.time == self.end_time
    }

    /// Length of the time span \[s\].
    pub(crate) fn span(&self) -> T {
        self.end_time - self.start_time
    }

    /// Limits the length of the next trial.
    pub(crate) fn limit_length(&mut self, most: T) {
        self.length = self.length.smaller(most);
    }

    /// The smallest step that surely advances the time.
    pub(crate) fn smallest_step(&self) -> T {
        self.rounding(self.time)
    }

    pub(crate) fn too_small(&self) -> StopReason {
        StopReason::StepTooSmall { smallest: to_f64(self.smallest_step()) }
    }

    /// The rounding of a time \[s\].
    fn rounding(&self, time: T) -> T {
        lit::<T>(4.0) * T::default_epsilon() * time.abs() + lit(INSTANT)
    }

    /// The time just before a kink.
    pub(crate) fn just_before(&self, kink: T) -> T {
        kink - lit::<T>(2.0) * T::default_epsilon() * kink.abs() - lit(INSTANT)
    }

    /// A step by which the time really advances: the rest would add up to a drift of the clock.
    pub(crate) fn rounded(&self, step: T) -> T {
        (self.time + step) - self.time
    }

    /// Where the next step has to end at the latest, given the next kink of an input between two
    /// times.
    pub(crate) fn next_stop(&self, next_kink: impl FnOnce(T, T) -> Option<T>) -> StopTime<T> {
        let mut stop = StopTime { time: self.end_time, is_kink: false };
        // A kink that lies behind, beyond or nowhere (NaN) is none; one at the very end is, for the
        // last stage must not look beyond it.
        let beyond = stop.time + self.rounding(stop.time);
        if let Some(kink) = next_kink(self.time, beyond)
            && self.time < kink
            && kink < beyond
        {
            stop = StopTime { time: stop.time.smaller(kink), is_kink: true };
        }
        if let Some(step) = self.control.fixed_step {
            let grid = self.start_time + step * lit((self.grid + 1) as f64);
            // Rounding must not leave a last step of nothing.
            if stop.time - grid > self.rounding(stop.time) {
                return StopTime { time: grid, is_kink: false };
            }
        }
        stop
    }

    /// The next step to try, given the next kink of an input between two times.
    #[inline]
    pub(crate) fn trial(
        &mut self,
        next_kink: impl Fn(T, T) -> Option<T>,
    ) -> Result<NextStep<T>, StopReason> {
        let Statistics { steps, rejected, .. } = self.statistics;
        let limit = self.control.most_steps;
        if steps + rejected >= limit {
            return Err(StopReason::TooManySteps { limit });
        }
        let stop = self.next_stop(&next_kink);
        let trial = self.trial_to(stop);
        if !trial.reaches && trial.step.abs() < self.smallest_step() {
            return Err(self.too_small());
        }
        Ok(trial)
    }

    fn trial_to(&self, stop: StopTime<T>) -> NextStep<T> {
        let remaining = stop.time - self.time;
        let distance = remaining.abs();
        // A fixed grid is exact only to the rounding of time. A trial that was shortened is not
        // stretched again: the one after it would be shortened for the same reason, for ever.
        let slack = if self.controller.is_rejecting() { T::zero() } else { self.smallest_step() };
        if self.length >= distance * lit(0.999) - slack * lit(4.0) {
            return NextStep { step: remaining, end_time: stop.time, stop, reaches: true };
        }
        let step = if self.is_adaptive() && self.length > distance * lit(0.5) {
            // Two equal steps instead of a long one and a stub.
            self.rounded(remaining * lit(0.5))
        } else {
            self.rounded(self.length)
        };
        NextStep { step, end_time: self.time + step, stop, reaches: false }
    }

    /// Counts a rejected trial and shortens the next one, from the mean square of its error and the
    /// order of the estimate. Answers whether the shorter step still advances the time.
    pub(crate) fn reject(&mut self, tried: T, square: f64, order: u8) -> bool {
        self.statistics.rejected += 1;
        self.length = tried.abs() * lit(self.controller.rejected(square, order));
        self.length >= self.smallest_step()
    }

    /// Counts a trial as rejected, and tries a shorter step of a given length.
    pub(crate) fn shorten(&mut self, length: T) -> Result<(), StopReason> {
        self.statistics.rejected += 1;
        self.controller.rejected(1.0, 1);
        self.length = length;
        if self.length >= self.smallest_step() { Ok(()) } else { Err(self.too_small()) }
    }

    /// Counts an accepted step. Answers with the length proposed for the next one, if it is not
    /// fixed. The trial whose error is given is longer than the step if that was cut, and tells
    /// little of the next one if it was `cut_short` for other reasons than its error.
    pub(crate) fn accept(
        &mut self,
        tried: T,
        cut_short: bool,
        square: f64,
        order: u8,
    ) -> Option<T> {
        self.statistics.steps += 1;
        if let Some(step) = self.control.fixed_step {
            // After a trial shortened at a pole of the field: back to the grid in doublings.
            self.length = step.smaller(self.length * lit(2.0));
            self.controller = Controller::new();
            return None;
        }
        let proposed = tried * lit(self.controller.accepted(square, order));
        let proposed = if cut_short { self.length.larger(proposed) } else { proposed };
        // Only a trial that is rejected tells why none succeeds.
        Some(proposed.larger(self.smallest_step() * lit(2.0)))
    }

    /// Sets the length of the next step, if one is given.
    pub(crate) fn propose(&mut self, length: Option<T>) {
        let Some(length) = length else { return };
        self.length = match self.control.largest_step {
            Some(largest) if self.is_adaptive() => length.smaller(largest),
            _ => length,
        };
    }

    /// Counts a stop that a step has reached and that is not the end of the span.
    pub(crate) fn pass(&mut self, stop: StopTime<T>) {
        if let Some(step) = self.control.fixed_step {
            // A kink may fall on a grid point, and a grid point on a kink but for rounding.
            let travelled = self.time - self.start_time;
            let next = step * lit((self.grid + 1) as f64);
            if !stop.is_kink || next <= travelled + self.smallest_step() {
                self.grid += 1;
            }
            self.length = step;
        }
    }
}
