//! A run along a known velocity: it chooses steps and splits them at reversals and kinks of the
//! velocity.

use core::ops::Range;

use nalgebra::Vector1;

use super::dense_step::{DenseStep, Sample};
use super::nodes::Nodes;
use super::{CollocationSolver, crossing, places};
use crate::ode::{Crossing, Failure, NextStep, Progress, Statistics, StopReason};
use crate::parameter::Named;
use crate::scalar::{is_zero, lit, to_f64};
use crate::signal::Signal;
use crate::{Branch, Bristle, Contact, Scalar};

/// Between speeds of at least this ratio no friction curve does much that the nodes do not show.
const SLOW: f64 = 0.8;
/// Most samples between a node and a slower end, each at half the distance: down to 2⁻²⁰ of the
/// gap.
const MOST_SAMPLES: u32 = 20;
/// Most cuts of one step at ever earlier reversals.
const MOST_CUTS: u32 = 100;

/// A run in progress: call [`CollocationRun::advance`] until it returns `None`.
#[derive(Debug, Clone)]
pub struct CollocationRun<'a, T: Scalar, M, V, const S: usize> {
    contact: &'a Contact<T, M>,
    velocity: &'a V,
    /// Error allowed in a step \[m\]; none for fixed steps.
    allowed: Option<T>,
    progress: Progress<T>,
    deflection: T,
    branch: Branch,
    /// Velocity at the current time, and the bristle there.
    now: T,
    sample: Sample<T>,
}

/// Why a trial step ends where it does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum End {
    /// It is as long as it was to be, or ends at a grid point.
    Smooth,
    /// The velocity has a kink.
    Kink,
    /// The direction reverses.
    Reversal,
}

impl<T: Scalar, const S: usize> CollocationSolver<T, S> {
    /// Starts a run over a time span \[s\] from a deflection \[m\], to be stepped by hand.
    ///
    /// # Errors
    ///
    /// Refuses a time or a deflection that is not finite, a span that ends before it starts, and a
    /// fixed step that does not advance the time.
    pub fn begin<'a, M: Bristle<T, Deflection = T>, V: Signal<T>>(
        &self,
        contact: &'a Contact<T, M>,
        velocity: &'a V,
        span: Range<T>,
        deflection: T,
    ) -> Result<CollocationRun<'a, T, M, V, S>, Failure<T, 1>> {
        let (now, rate) = velocity.value_and_rate(span.start);
        let branch = Branch::locked(now);
        let breakaway = contact.limits(T::zero()).deflection.unwrap_or_else(|| lit(1e-6));
        let mut run = CollocationRun {
            contact,
            velocity,
            allowed: self.tolerance.map(|tolerance| tolerance * breakaway),
            progress: Progress::new(self.control, (span.start, span.end)),
            deflection,
            branch,
            now,
            sample: Sample::new(contact, branch, now, deflection),
        };
        let times =
            Named("span.start", span.start).finite().and(Named("span.end", span.end).finite());
        let finite = times.and(Named("deflection", deflection).finite());
        let checked = finite.and_then(|_| run.progress.check());
        checked.map_err(|error| run.failure(error.into()))?;
        run.progress.statistics.evaluations = 1;
        // A part of the time in which the velocity doubles; estimates correct it from there.
        let guess = now.abs() / rate.abs() * lit(0.25);
        let most = (span.end - span.start) * lit(0.01);
        let guess = if guess > T::zero() { most.smaller(guess) } else { most };
        let first = run.progress.given_length().unwrap_or(guess);
        run.progress.start(first).map_err(|reason| run.failure(reason))?;
        Ok(run)
    }
}

impl<T, M, V, const S: usize> CollocationRun<'_, T, M, V, S>
where
    T: Scalar,
    M: Bristle<T, Deflection = T>,
    V: Signal<T>,
{
    /// The time reached \[s\].
    pub fn time(&self) -> T {
        self.progress.time
    }

    /// The deflection there \[m\].
    pub fn deflection(&self) -> T {
        self.deflection
    }

    /// What the run has cost so far; evaluations are of the friction model.
    pub fn statistics(&self) -> Statistics {
        self.progress.statistics
    }

    /// Takes one step. `None` at the end of the time span.
    ///
    /// # Errors
    ///
    /// Says why the run cannot go on, and where it stands. It stays there.
    #[inline]
    pub fn advance(&mut self) -> Result<Option<DenseStep<T, S>>, Failure<T, 1>> {
        self.try_advance().map_err(|reason| self.failure(reason))
    }

    fn failure(&self, reason: StopReason) -> Failure<T, 1> {
        let state = Vector1::new(self.deflection);
        Failure::new(reason, (self.time(), state), self.statistics())
    }

    /// Evaluates the bristle at the current point anew.
    fn refresh(&mut self, velocity: T) {
        self.now = velocity;
        self.sample = Sample::new(self.contact, self.branch, velocity, self.deflection);
        self.progress.statistics.evaluations += 1;
    }

    fn try_advance(&mut self) -> Result<Option<DenseStep<T, S>>, StopReason> {
        // Of the estimate of the error of the dense output.
        let order = S as u8 + 2;
        while !self.progress.is_over() {
            let velocity = self.velocity;
            let trial = self.progress.trial(|from, towards| velocity.next_kink(from, towards))?;
            let (step, end) = self.attempt(&trial);
            let duration = step.end_time() - self.time();
            let is_finite = step.end().is_finite();
            let square = match self.allowed {
                Some(allowed) if is_finite => {
                    let mut error = step.error;
                    if error <= allowed {
                        error = error.larger(self.hidden(allowed, &step));
                    }
                    let ratio = to_f64(error / allowed);
                    ratio * ratio
                }
                _ if is_finite => 0.0,
                _ => f64::NAN,
            };
            if square <= 1.0 {
                let is_cut = trial.reaches || end == End::Reversal;
                let length = self.progress.accept(duration, is_cut, square, order);
                self.progress.propose(length);
                self.arrive(&step, end, &trial);
                return Ok(Some(step));
            }
            if !self.progress.reject(duration, square, order) || self.allowed.is_none() {
                return Err(if !self.velocity.value(step.end_time()).is_finite() {
                    StopReason::VelocityNotFinite { contact: 0 }
                } else if !is_finite {
                    StopReason::NotFinite { component: 0 }
                } else {
                    self.progress.too_small()
                });
            }
        }
        Ok(None)
    }

    /// Tries a step, cut where the direction first reverses.
    fn attempt(&mut self, trial: &NextStep<T>) -> (DenseStep<T, S>, End) {
        let contact = self.contact;
        let is_kink = trial.reaches && trial.stop.is_kink;
        let (mut end_time, mut end) =
            (trial.end_time, if is_kink { End::Kink } else { End::Smooth });
        let start = self.time();
        let mut cuts = 0;
        loop {
            let mut times = places::<T, S>((start, end_time));
            if end == End::Kink {
                // Nothing of a step lies beyond the kink at which it ends.
                let last = self.progress.just_before(end_time);
                for time in &mut times {
                    *time = if *time > last && last > start { last } else { *time };
                }
            }
            // Plain loops: the compiler does not see through a map over an array.
            let (mut velocities, mut speeds) = (times, times);
            for ((velocity, speed), time) in velocities.iter_mut().zip(&mut speeds).zip(times) {
                *velocity = self.velocity.value(time);
                *speed = self.branch.of(*velocity).speed();
            }
            cuts += 1;
            if cuts < MOST_CUTS {
                let ahead = |time| self.branch.of(self.velocity.value(time)).speed();
                let from = (start, self.branch.of(self.now).speed());
                match crossing(ahead, from, (times, speeds), self.progress.smallest_step()) {
                    Crossing::At(place) if place < end_time => {
                        (end_time, end) = (place, End::Reversal);
                        continue;
                    }
                    Crossing::AtStart => {
                        self.branch = self.branch.reversed();
                        self.refresh(T::zero());
                        continue;
                    }
                    Crossing::At(_) | Crossing::None => {}
                }
            }
            self.progress.statistics.evaluations += S as u64;
            let mut samples = [self.sample; S];
            for (sample, velocity) in samples.iter_mut().zip(velocities) {
                *sample = Sample::new(contact, self.branch, velocity, self.deflection);
            }
            let (span, force) = ((start, end_time), self.contact.reference_load());
            return (DenseStep::new(span, force, self.deflection, &self.sample, &samples), end);
        }
    }

    /// Moves to the end of an accepted step.
    fn arrive(&mut self, step: &DenseStep<T, S>, end: End, trial: &NextStep<T>) {
        self.progress.time = step.end_time();
        self.deflection = step.end();
        match end {
            End::Reversal => {
                self.progress.statistics.reversals += 1;
                self.branch = self.branch.reversed();
                self.refresh(self.velocity.value(step.end_time()));
            }
            End::Kink => {
                let velocity = self.velocity.value(step.end_time());
                if !is_zero(velocity) {
                    self.branch = Branch::locked(velocity);
                }
                self.refresh(velocity);
            }
            End::Smooth => {
                self.sample = step.samples[S - 1];
                self.now = self.sample.velocity;
            }
        }
        if trial.reaches && end != End::Reversal && !self.progress.is_over() {
            self.progress.pass(trial.stop);
        }
    }

    /// The error \[m\] that the nodes may not show near rest, where friction changes within speeds
    /// far below those at the nodes: ∫|defect| between an end at which it slides slower and the
    /// node next to it.
    fn hidden(&mut self, allowed: T, step: &DenseStep<T, S>) -> T {
        let duration = step.end_time() - step.start_time();
        let places = &Nodes::<S>::OF.places;
        let at_start = self.sample;
        let mut gap = |end, at_end, from: f64, node: usize| {
            let gap = duration * lit(places[node] - from);
            self.towards(allowed, step, (end, at_end), (gap, step.samples[node]))
        };
        gap(step.start_time(), at_start, 0.0, 0)
            + gap(step.end_time(), step.samples[S - 1], 1.0, S - 2)
    }

    /// ∫|defect| \[m\] over the gap between an end of a step and a node, from samples ever nearer
    /// to the end, until the rest of the gap cannot matter.
    fn towards(
        &mut self,
        allowed: T,
        step: &DenseStep<T, S>,
        (end, at_end): (T, Sample<T>),
        (gap, at_node): (T, Sample<T>),
    ) -> T {
        let enough = allowed * lit(0.1);
        let (mut sum, mut part, mut before) = (T::zero(), T::one(), T::zero());
        let (mut speed, slowest) = (at_node.velocity.abs() * lit(SLOW), at_end.velocity.abs());
        for _ in 0..MOST_SAMPLES {
            if speed <= slowest || !(sum <= allowed) {
                break;
            }
            let next = part * lit(0.5);
            let time = end + gap * next;
            let velocity = self.velocity.value(time);
            let sample = Sample::new(self.contact, self.branch, velocity, step.start());
            self.progress.statistics.evaluations += 1;
            let defect = step.defect(time, &sample).abs();
            sum += (defect + before) * lit(0.5) * (part - next) * gap.abs();
            if step.reach(&sample, next * gap.abs()) < enough {
                break;
            }
            (part, before, speed) = (next, defect, velocity.abs() * lit(SLOW));
        }
        sum
    }
}
