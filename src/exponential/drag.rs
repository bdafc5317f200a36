//! The driver: it chooses steps, splits them at reversals and kinks of the velocity, and answers at
//! any time.

use core::ops::Range;

use nalgebra::Vector1;

use super::crossing::{Reversal, first_reversal};
use super::nodes::Nodes;
use super::piece::{Piece, Sample};
use super::{direction, places};
use crate::bounds::larger;
use crate::ode::{Failure, Statistics, StopReason};
use crate::parameter::{self, ParameterError, Rule};
use crate::scalar::{is_zero, lit, to_f64};
use crate::signal::Signal;
use crate::{Branch, Bristle, Contact, Scalar};

/// A step grows and shrinks by no more than these factors.
const LEAST_FACTOR: f64 = 0.2;
const MOST_FACTOR: f64 = 2.0;
/// The next step aims below the tolerance by this factor of its length.
const SAFETY: f64 = 0.8;
/// Between speeds of at least this ratio no curve does much that the nodes do not show.
const SLOW: f64 = 0.8;
/// Most looks between a node and a slower end, each at half the distance: down to 2⁻²⁰ of the gap.
const MOST_LOOKS: u32 = 20;

/// How a bristle is dragged along: exponential collocation with its step control. Made by
/// [`Exponential::adaptive`](super::Exponential::adaptive) and
/// [`Exponential::fixed`](super::Exponential::fixed).
///
/// ```
/// use bristle::exponential::Exponential;
/// use bristle::signal::{Sine, SineParameters};
/// use bristle::{Bristle, FrBd, paper};
/// use bristle::curve::Stribeck;
/// use bristle::rheology::KelvinVoigt;
///
/// let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
/// let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
/// let contact = FrBd::new(curve, bristle).under_load(1.0)?;
/// let velocity = Sine::new(SineParameters { mean: 0.0, amplitude: 0.01, frequency: 25.0, phase: 0.0 })?;
///
/// let drag = Exponential::<5>.adaptive(1e-8)?;
/// let mut largest = 0.0;
/// drag.sample(&contact, &velocity, 0.0..0.2, 0.0, 201, |_time, deflection: f64| {
///     largest = f64::max(largest, deflection.abs());
/// })?;
/// assert!(largest < 1.5e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drag<T, const S: usize> {
    control: Control<T>,
    most_steps: u64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Control<T> {
    Fixed(T),
    Adaptive { tolerance: T, largest_step: Option<T> },
}

impl<T: Scalar, const S: usize> Drag<T, S> {
    pub(super) fn adaptive(tolerance: T) -> Self {
        let control = Control::Adaptive { tolerance, largest_step: None };
        Self { control, most_steps: 100_000_000 }
    }

    pub(super) fn fixed(step: T) -> Self {
        Self { control: Control::Fixed(step), most_steps: 100_000_000 }
    }

    /// A limit on the length of adaptive steps \[s\]. Fixed steps ignore it.
    ///
    /// A periodic velocity that a step would skip whole periods of needs one.
    ///
    /// # Errors
    ///
    /// Refuses a limit that is not positive.
    pub fn with_largest_step(mut self, largest: T) -> Result<Self, ParameterError> {
        let largest = parameter::positive("largest_step", largest)?;
        if let Control::Adaptive { largest_step, .. } = &mut self.control {
            *largest_step = Some(largest);
        }
        Ok(self)
    }

    /// A limit on the number of trial steps, 10⁸ if not given.
    #[must_use]
    pub fn with_most_steps(self, most: u64) -> Self {
        Self { most_steps: most, ..self }
    }

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
    ) -> Result<Run<'a, T, M, V, S>, Failure<T, 1>> {
        let refuse = |error: ParameterError| {
            failure(StopReason::Refused(error), span.start, deflection, Statistics::default())
        };
        parameter::finite("span.start", span.start).map_err(refuse)?;
        parameter::finite("span.end", span.end).map_err(refuse)?;
        parameter::at_least("span.end", span.end, "span.start", span.start).map_err(refuse)?;
        parameter::finite("deflection", deflection).map_err(refuse)?;
        if let Control::Fixed(step) = self.control {
            let late = larger(span.start.abs(), span.end.abs());
            let smallest = late * T::default_epsilon() * lit(4.0);
            if step < smallest && step < span.end - span.start {
                let reason = StopReason::StepTooSmall { smallest: to_f64(smallest) };
                return Err(failure(reason, span.start, deflection, Statistics::default()));
            }
        }
        Ok(Run::new(*self, contact, velocity, span, deflection))
    }

    /// Runs over a time span \[s\] from a deflection \[m\], and hands over time and deflection at so
    /// many times, at least 2, evenly spaced and including both ends.
    ///
    /// The model's limit of the deflection is kept at the ends of steps; between those of long fixed
    /// steps the curve may pass it by a part of what the deflection varies.
    ///
    /// # Errors
    ///
    /// Refuses what [`Drag::begin`] refuses, and fewer than 2 samples; says why a run ended before its
    /// time. What lies before that has been handed over.
    pub fn sample<M: Bristle<T, Deflection = T>, V: Signal<T>>(
        &self,
        contact: &Contact<T, M>,
        velocity: &V,
        span: Range<T>,
        deflection: T,
        samples: usize,
        mut observer: impl FnMut(T, T),
    ) -> Result<Statistics, Failure<T, 1>> {
        if samples < 2 {
            let error = ParameterError {
                name: "samples",
                component: None,
                value: samples as f64,
                rule: Rule::Count { least: 2 },
            };
            let reason = StopReason::Refused(error);
            return Err(failure(reason, span.start, deflection, Statistics::default()));
        }
        let mut run = self.begin(contact, velocity, span.clone(), deflection)?;
        let last = samples - 1;
        let spacing = (span.end - span.start) / lit(last as f64);
        let time_of = |index: usize| {
            if index == last { span.end } else { span.start + spacing * lit(index as f64) }
        };
        observer(span.start, deflection);
        let mut index = 1;
        let mut time = time_of(index);
        while let Some(piece) = run.advance()? {
            while index <= last && time <= piece.end_time() {
                observer(time, piece.at(time));
                index += 1;
                time = time_of(index);
            }
        }
        // A span of no length has no pieces.
        while index <= last {
            observer(time_of(index), run.deflection());
            index += 1;
        }
        Ok(run.statistics())
    }

    /// The same, stored.
    ///
    /// # Errors
    ///
    /// As [`Drag::sample`]; what lies before is lost.
    #[cfg(feature = "alloc")]
    pub fn deflections<M: Bristle<T, Deflection = T>, V: Signal<T>>(
        &self,
        contact: &Contact<T, M>,
        velocity: &V,
        span: Range<T>,
        deflection: T,
        samples: usize,
    ) -> Result<alloc::vec::Vec<T>, Failure<T, 1>> {
        let mut stored = alloc::vec::Vec::with_capacity(samples);
        self.sample(contact, velocity, span, deflection, samples, |_, deflection| {
            stored.push(deflection);
        })?;
        Ok(stored)
    }
}

fn failure<T: Scalar>(
    reason: StopReason,
    time: T,
    deflection: T,
    statistics: Statistics,
) -> Failure<T, 1> {
    Failure { reason, time, state: Vector1::new(deflection), statistics }
}

/// A run in progress: call [`Run::advance`] until it answers `None`.
#[derive(Debug, Clone)]
pub struct Run<'a, T: Scalar, M, V, const S: usize> {
    contact: &'a Contact<T, M>,
    velocity: &'a V,
    control: Control<T>,
    most_steps: u64,
    /// Error allowed in a step [m].
    allowed: T,
    start_time: T,
    end_time: T,
    time: T,
    deflection: T,
    branch: Branch,
    /// Velocity at the current time, and the bristle there.
    now: T,
    sample: Sample<T>,
    /// Length of the next trial.
    step: T,
    /// Steps of a fixed grid completed.
    grid: u64,
    statistics: Statistics,
}

/// Where a trial step ends, and why.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum End {
    /// Nothing happens there.
    Smooth,
    /// A point of a fixed grid, or the end of the span.
    Grid,
    /// The velocity is not smooth.
    Kink,
    /// The direction reverses.
    Reversal,
}

impl<'a, T, M, V, const S: usize> Run<'a, T, M, V, S>
where
    T: Scalar,
    M: Bristle<T, Deflection = T>,
    V: Signal<T>,
{
    fn new(
        drag: Drag<T, S>,
        contact: &'a Contact<T, M>,
        velocity: &'a V,
        span: Range<T>,
        deflection: T,
    ) -> Self {
        let (now, rate) = velocity.value_and_rate(span.start);
        let branch = direction(now);
        let length = span.end - span.start;
        let (allowed, step) = match drag.control {
            Control::Fixed(step) => (T::zero(), step),
            Control::Adaptive { tolerance, .. } => {
                let breakaway = contact.limits(T::zero()).deflection;
                // A part of the time in which the velocity doubles; estimates correct it from there.
                let guess = now.abs() / rate.abs() * lit(0.25);
                let most = length * lit(0.01);
                let guess = if guess > T::zero() && guess < most { guess } else { most };
                (tolerance * breakaway.unwrap_or_else(|| lit(1e-6)), guess)
            }
        };
        Self {
            contact,
            velocity,
            control: drag.control,
            most_steps: drag.most_steps,
            allowed,
            start_time: span.start,
            end_time: span.end,
            time: span.start,
            deflection,
            branch,
            now,
            sample: Sample::new(contact.model(), branch, now, deflection),
            step,
            grid: 0,
            statistics: Statistics { evaluations: 1, ..Statistics::default() },
        }
    }

    /// The time reached \[s\].
    pub fn time(&self) -> T {
        self.time
    }

    /// The deflection there \[m\].
    pub fn deflection(&self) -> T {
        self.deflection
    }

    /// What the run has cost so far; evaluations are of the friction model.
    pub fn statistics(&self) -> Statistics {
        self.statistics
    }

    /// Takes one step. `None` at the end of the time span.
    ///
    /// # Errors
    ///
    /// Says why the run cannot go on, and where it stands. It stays there.
    #[inline]
    pub fn advance(&mut self) -> Result<Option<Piece<T, S>>, Failure<T, 1>> {
        self.try_advance()
            .map_err(|reason| failure(reason, self.time, self.deflection, self.statistics))
    }

    /// The bristle at the current point, anew.
    fn look(&mut self) {
        self.now = self.velocity.value(self.time);
        self.sample = Sample::new(self.contact.model(), self.branch, self.now, self.deflection);
        self.statistics.evaluations += 1;
    }

    /// Where the next step has to end at the latest.
    fn next_stop(&self) -> (T, End) {
        let (mut stop, mut end) = (self.end_time, End::Grid);
        if let Control::Fixed(step) = self.control {
            let grid = self.start_time + step * lit((self.grid + 1) as f64);
            // Rounding must not leave a last step of nothing.
            if grid < self.end_time - step * lit(1e-6) {
                stop = grid;
            }
        }
        if let Some(kink) = self.velocity.next_kink(self.time, self.beyond(stop))
            && kink > self.time
            && kink <= self.beyond(stop)
        {
            end = End::Kink;
            if kink < stop {
                stop = kink;
            }
        }
        (stop, end)
    }

    /// A rounding later.
    fn beyond(&self, time: T) -> T {
        time + self.rounding(time)
    }

    /// The rounding of a time [s].
    fn rounding(&self, time: T) -> T {
        lit::<T>(4.0) * T::default_epsilon() * (time.abs() + self.start_time.abs())
    }

    fn try_advance(&mut self) -> Result<Option<Piece<T, S>>, StopReason> {
        if !(self.time < self.end_time) {
            return Ok(None);
        }
        let (stop, why) = self.next_stop();
        let mut duration = stop - self.time;
        if let Control::Adaptive { largest_step, .. } = self.control {
            if let Some(largest) = largest_step
                && self.step > largest
            {
                self.step = largest;
            }
            // No last step of nothing.
            if self.step < duration {
                let rest = duration * lit(0.5);
                duration = if rest < self.step { rest } else { self.step };
            }
        }
        loop {
            if self.statistics.steps + self.statistics.rejected >= self.most_steps {
                return Err(StopReason::TooManySteps { limit: self.most_steps });
            }
            let smallest = self.rounding(self.time);
            if !(duration > smallest) && stop - self.time > smallest {
                return Err(StopReason::StepTooSmall { smallest: to_f64(smallest) });
            }
            let (end_time, end) = self.time_after(duration, stop, why);
            let (piece, end) = self.attempt(end_time, end);
            let mut error = piece.error();
            let finite = piece.end().is_finite();
            if let Control::Adaptive { .. } = self.control
                && error <= self.allowed
            {
                error = larger(error, self.hidden(&piece));
            }
            if let Control::Adaptive { .. } = self.control {
                let length = piece.end_time() - self.time;
                let ratio = self.allowed / error;
                let factor = if ratio.is_finite() {
                    let factor = ratio.powf(lit(1.0 / (S + 2) as f64)) * lit(SAFETY);
                    let factor = if factor < lit(MOST_FACTOR) { factor } else { lit(MOST_FACTOR) };
                    if factor > lit(LEAST_FACTOR) { factor } else { lit(LEAST_FACTOR) }
                } else if error > T::zero() || !finite {
                    lit(LEAST_FACTOR)
                } else {
                    lit(MOST_FACTOR)
                };
                if !(error <= self.allowed) || !finite {
                    self.statistics.rejected += 1;
                    duration = length * factor;
                    self.step = duration;
                    continue;
                }
                let next = length * factor;
                // A step that was cut short tells little of the next.
                if next > self.step || !(length < self.step * lit(0.999)) {
                    self.step = next;
                }
            }
            if !finite {
                return Err(StopReason::NotFinite { component: 0 });
            }
            self.accept(&piece, end);
            return Ok(Some(piece));
        }
    }

    /// The end of a trial step.
    fn time_after(&self, duration: T, stop: T, why: End) -> (T, End) {
        let end_time = self.time + duration;
        if end_time >= stop - self.rounding(stop) { (stop, why) } else { (end_time, End::Smooth) }
    }

    /// Tries a step, cut where the direction first reverses.
    fn attempt(&mut self, end_time: T, end: End) -> (Piece<T, S>, End) {
        let (mut end_time, mut end) = (end_time, end);
        let mut rounds = 0;
        loop {
            // Nothing of a step lies beyond the kink at which it ends.
            let last = if end == End::Kink { end_time - self.rounding(end_time) } else { end_time };
            let last = if last > self.time { last } else { self.time };
            let mut times = places::<T, S>((self.time, end_time));
            for time in &mut times {
                if *time > last {
                    *time = last;
                }
            }
            // Plain loops: the compiler does not see through a map over an array.
            let mut velocities = times;
            let mut nodes = [(T::zero(), T::zero()); S];
            for ((node, velocity), time) in nodes.iter_mut().zip(&mut velocities).zip(times) {
                *velocity = self.velocity.value(time);
                *node = (time, self.branch.of(*velocity).speed());
            }
            let ahead = |time| self.branch.of(self.velocity.value(time)).speed();
            let start = (self.time, self.branch.of(self.now).speed());
            rounds += 1;
            if rounds < 100 {
                match first_reversal(ahead, start, &nodes) {
                    Reversal::None => {}
                    Reversal::At(place) if place - self.time > self.rounding(place) => {
                        if place < end_time {
                            (end_time, end) = (place, End::Reversal);
                            continue;
                        }
                    }
                    Reversal::AtStart | Reversal::At(_) => {
                        self.branch = self.branch.reversed();
                        self.now = T::zero();
                        let model = self.contact.model();
                        self.sample = Sample::new(model, self.branch, self.now, self.deflection);
                        self.statistics.evaluations += 1;
                        continue;
                    }
                }
            }
            self.statistics.evaluations += S as u64;
            let model = self.contact.model();
            let mut samples = [self.sample; S];
            for (sample, velocity) in samples.iter_mut().zip(velocities) {
                *sample = Sample::new(model, self.branch, velocity, self.deflection);
            }
            let force = self.contact.normal_force();
            let span = (self.time, end_time);
            return (Piece::new(span, force, self.deflection, &self.sample, &samples), end);
        }
    }

    /// What the nodes may not have seen of the curve near rest, where friction changes within speeds far below those
    /// at the nodes \[m\]: ∫|defect| between an end at which it slides slower and the node next to it.
    fn hidden(&mut self, piece: &Piece<T, S>) -> T {
        let duration = piece.end_time() - piece.start_time();
        let at_start = self.sample;
        let mut sum = T::zero();
        if let (Some(&place), Some(node)) = (Nodes::<S>::OF.places.first(), piece.sample(0)) {
            sum +=
                self.towards(piece, (piece.start_time(), at_start), (duration * lit(place), *node));
        }
        if let (Some(&place), Some(node)) = (Nodes::<S>::OF.places.get(S - 2), piece.sample(S - 2))
        {
            let gap = duration * lit(place - 1.0);
            sum += self.towards(piece, (piece.end_time(), piece.last_sample()), (gap, *node));
        }
        sum
    }

    /// ∫|defect| \[m\] over the gap between an end of a piece and a node, by looks that come nearer and nearer to the
    /// end, until nothing more can happen there.
    fn towards(
        &mut self,
        piece: &Piece<T, S>,
        (end, at_end): (T, Sample<T>),
        (gap, at_node): (T, Sample<T>),
    ) -> T {
        let enough = self.allowed * lit(0.1);
        let (mut sum, mut part, mut before) = (T::zero(), T::one(), T::zero());
        let (mut speed, slowest) = (at_node.velocity.abs() * lit(SLOW), at_end.velocity.abs());
        for _ in 0..MOST_LOOKS {
            if speed <= slowest || !(sum <= self.allowed) {
                break;
            }
            let next = part * lit(0.5);
            let time = end + gap * next;
            let velocity = self.velocity.value(time);
            let sample = Sample::new(self.contact.model(), self.branch, velocity, piece.start());
            self.statistics.evaluations += 1;
            let defect = piece.defect(time, &sample).abs();
            sum += (defect + before) * lit(0.5) * (part - next) * gap.abs();
            if piece.reach(&sample, next * gap.abs()) < enough {
                break;
            }
            (part, before, speed) = (next, defect, velocity.abs() * lit(SLOW));
        }
        sum
    }

    fn accept(&mut self, piece: &Piece<T, S>, end: End) {
        self.statistics.steps += 1;
        self.time = piece.end_time();
        self.deflection = piece.end();
        if let Control::Fixed(step) = self.control {
            let grid = self.start_time + step * lit((self.grid + 1) as f64);
            if self.time >= grid - self.rounding(grid) {
                self.grid += 1;
            }
        }
        match end {
            End::Reversal => {
                self.statistics.reversals += 1;
                self.branch = self.branch.reversed();
                self.look();
            }
            End::Kink => {
                self.look();
                if !is_zero(self.now) {
                    self.branch = direction(self.now);
                    self.look();
                }
            }
            End::Smooth | End::Grid => {
                let last = piece.last_sample();
                self.now = last.velocity;
                self.sample = last;
            }
        }
    }
}
