//! The driver: it chooses steps, locks the sliding directions, and splits steps at reversals and
//! at kinks of the inputs. One driver serves every method.

use nalgebra::SVector;

use super::controller::Controller;
use super::curve::Curve;
use super::failure::{Failure, StopReason};
use super::locked::{Locked, Window};
use super::method::{Attempt, Field, Method, Point};
use super::reversal::{Lock, Verdict, first_reversal, surely_none};
use super::settings::{Control, Settings};
use super::step::Step;
use super::{Statistics, System};
use crate::bounds::{larger, smaller};
use crate::scalar::{is_zero, lit, to_f64};
use crate::{Branch, Scalar};

/// A time [s] shorter than any, but not zero at t = 0, where rounding is.
const INSTANT: f64 = 1e-30;

/// So many contacts in turn that slide in neither direction, within so small a part of the time
/// span: the right-hand side jumps at zero velocity, and holds them there.
const ENDLESS: (u32, f64) = (100, 1e-2);

/// A run in progress: call [`Integration::advance`] until it answers `None`.
///
/// Nothing is allocated, and nothing is lost if it is dropped half-way. Made by
/// [`Solver::begin`](super::Solver::begin).
///
/// ```
/// use bristle::ode::{RungeKutta4, Solver};
/// use bristle::scene::MassSpringDamper;
/// use bristle::{Bristle, Dahl, DahlParameters, paper};
///
/// let friction = Dahl::new(DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: 1e4 })?;
/// let rig = MassSpringDamper::new(paper::stick_slip_rig(friction.under_load(1.0)?))?;
/// let solver = Solver::fixed(RungeKutta4, 1e-3)?;
/// let mut run = solver.begin(&rig, 0.0..1.0, rig.at_rest())?;
/// while let Some(step) = run.advance()? {
///     assert!(step.end()[1] < 0.2); // the velocity
/// }
/// assert_eq!(run.time(), 1.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Integration<'a, T: Scalar, S, M: Method<T, N>, const N: usize, const K: usize> {
    system: &'a S,
    method: M,
    memory: M::Memory,
    settings: Settings<T, N>,
    start_time: T,
    end_time: T,
    point: Point<T, N>,
    /// Length of the next trial, positive.
    length: T,
    controller: Controller,
    locks: [Lock<T>; K],
    /// Whether `point.time` is a kink of an input.
    at_kink: bool,
    /// The contact that reverses at the current point, where the next step starts.
    turned: Option<usize>,
    /// Steps of a fixed grid completed.
    grid: u64,
    /// A time \[s\], and how often since then a lock was given up because neither direction led on.
    given_up: (T, u32),
    /// The step taken last.
    step: Step<T, N>,
    statistics: Statistics,
}

impl<'a, T, S, M, const N: usize, const K: usize> Integration<'a, T, S, M, N, K>
where
    T: Scalar,
    S: System<T, N, K>,
    M: Method<T, N>,
{
    pub(super) fn new(
        method: M,
        settings: Settings<T, N>,
        system: &'a S,
        (start_time, end_time): (T, T),
        state: SVector<T, N>,
    ) -> Result<Self, Failure<T, N>> {
        let mut run = Self {
            system,
            memory: method.memory(),
            method,
            settings,
            start_time,
            end_time,
            point: Point {
                time: start_time,
                state,
                rate: SVector::zeros(),
                scale: settings.control.scale(&state),
            },
            length: T::zero(),
            controller: Controller::new(),
            locks: [Lock::free(); K],
            at_kink: false,
            turned: None,
            grid: 0,
            given_up: (start_time, 0),
            step: Step {
                start_time,
                end_time: start_time,
                whole: T::zero(),
                end: state,
                curve: Curve::new(state, &[]),
                reversal_at_start: None,
                reversal: None,
            },
            statistics: Statistics::default(),
        };
        if start_time != end_time {
            run.start().map_err(|reason| run.failure(reason))?;
        }
        Ok(run)
    }

    /// The time reached \[s\].
    pub fn time(&self) -> T {
        self.point.time
    }

    /// The state there.
    pub fn state(&self) -> &SVector<T, N> {
        &self.point.state
    }

    /// The branch on which each contact slides now.
    pub fn branches(&self) -> [Branch; K] {
        self.locks.map(|lock| lock.branch)
    }

    /// What the run has cost so far.
    pub fn statistics(&self) -> Statistics {
        self.statistics
    }

    /// Takes one step. `None` at the end of the time span.
    ///
    /// # Errors
    ///
    /// Says why the run cannot go on, and where it stands. It stays there.
    #[inline]
    pub fn advance(&mut self) -> Result<Option<Step<T, N>>, Failure<T, N>> {
        Ok(self.advance_seen(|_, _| true)?.copied())
    }

    /// Takes one step, whose curve is the method's own only if someone looks between the two times,
    /// and else the cubic through its ends.
    #[inline]
    pub(crate) fn advance_seen(
        &mut self,
        looks: impl Fn(T, T) -> bool,
    ) -> Result<Option<&Step<T, N>>, Failure<T, N>> {
        match self.try_advance(looks) {
            Ok(true) => Ok(Some(&self.step)),
            Ok(false) => Ok(None),
            Err(reason) => Err(self.failure(reason)),
        }
    }

    fn failure(&self, reason: StopReason) -> Failure<T, N> {
        Failure {
            reason,
            time: self.point.time,
            state: self.point.state,
            statistics: self.statistics,
        }
    }

    /// +1 for a run forward in time, −1 for one backward.
    fn direction(&self) -> T {
        if self.end_time >= self.start_time { T::one() } else { -T::one() }
    }

    fn span(&self) -> T {
        (self.end_time - self.start_time).abs()
    }

    /// The smallest step that surely advances the time.
    fn smallest_step(&self) -> T {
        self.rounding(self.point.time)
    }

    /// The rounding of a time \[s\].
    fn rounding(&self, time: T) -> T {
        lit::<T>(4.0) * T::default_epsilon() * time.abs() + lit(INSTANT)
    }

    /// The time just before a kink.
    fn just_before(&self, kink: T) -> T {
        kink - lit::<T>(2.0) * T::default_epsilon() * kink.abs() - lit(INSTANT)
    }

    /// First evaluation, first branches, first step size.
    fn start(&mut self) -> Result<(), StopReason> {
        let time = self.point.time;
        self.at_kink = self.settings.locks && {
            let beside = self.just_before(time);
            self.system.next_kink(beside, time + (time - beside)).is_some()
        };
        if let Control::Fixed(step) = self.settings.control {
            let late = larger(time.abs(), self.end_time.abs());
            if step < self.span() && step < late * T::default_epsilon() * lit(4.0) {
                return Err(self.too_small());
            }
        }
        self.refresh_rate();
        check_finite(&self.point.rate)?;
        self.length = match self.settings.control {
            Control::Fixed(step) => step,
            Control::Adaptive { first_step: Some(step), .. } => step,
            Control::Adaptive { .. } => self.first_step(),
        };
        self.length = smaller(self.length, self.span());
        if let Control::Adaptive { largest_step: Some(largest), .. } = self.settings.control {
            self.length = smaller(self.length, largest);
        }
        if self.settings.locks {
            // Without a velocity, the one a little later tells the direction.
            let later = self.length * self.direction() * lit(1e-3);
            let state = self.point.state + self.point.rate * later;
            let now = self.system.sliding_velocities(time, &self.point.state);
            let mut soon = self.system.sliding_velocities(time + later, &state);
            if now.iter().zip(&soon).any(|(&now, &soon)| is_zero(now) && is_zero(soon)) {
                // Nor an acceleration: the one a little later tells.
                let rate = self.evaluate(time + later, &state);
                let state = state + rate * later;
                let later = time + later + later;
                let then = self.system.sliding_velocities(later, &state);
                for (soon, then) in soon.iter_mut().zip(then) {
                    if is_zero(*soon) {
                        *soon = then;
                    }
                }
            }
            for ((lock, now), soon) in self.locks.iter_mut().zip(now).zip(soon) {
                let velocity = if is_zero(now) { soon } else { now };
                lock.branch = Branch::towards(velocity);
                if lock.branch == Branch::Free {
                    lock.branch = Branch::Forward;
                }
            }
            self.refresh_locks();
            self.refresh_rate();
        }
        Ok(())
    }

    /// The first step, from the size of the rate and its change along it (E. Hairer, S. P. Nørsett,
    /// G. Wanner, "Solving Ordinary Differential Equations I", section II.4).
    fn first_step(&mut self) -> T {
        let Point { time, state, rate, scale } = self.point;
        let norm = |vector: &SVector<T, N>| {
            (vector.component_div(&scale)).norm() / lit::<T>(N.max(1) as f64).sqrt()
        };
        let (size, speed) = (norm(&state), norm(&rate));
        let tiny: T = lit(1e-5);
        let guess = if size > tiny && speed > tiny { size / speed * lit(0.01) } else { T::zero() };
        let fallback = self.span() * lit(1e-6);
        let guess = if guess > T::zero() { guess } else { fallback };
        let guess = smaller(guess, self.span());
        let signed = guess * self.direction();
        let later = self.evaluate(time + signed, &(state + rate * signed));
        let bend = norm(&(later - rate)) / guess;
        let most = larger(speed, bend);
        let by_rate = if most > lit(1e-15) {
            lit::<T>(super::controller::rough_power(to_f64(most) * 100.0, -0.2))
        } else {
            guess * lit(1e3)
        };
        let step = smaller(guess * lit(100.0), by_rate);
        if step.is_finite() && step > T::zero() { step } else { fallback }
    }

    /// The method, its memory, the system on the current branches, and the current point.
    #[inline(always)]
    #[allow(clippy::type_complexity, reason = "what a method asks for, borrowed apart")]
    fn parts(
        &mut self,
        window: Window<T>,
    ) -> (&M, &mut M::Memory, Locked<'_, T, S, K>, &mut Point<T, N>) {
        let field = Locked {
            system: self.system,
            branches: self.locks.map(|lock| lock.branch),
            window,
            statistics: &mut self.statistics,
        };
        (&self.method, &mut self.memory, field, &mut self.point)
    }

    /// The right-hand side on the current branches.
    fn evaluate(&mut self, time: T, state: &SVector<T, N>) -> SVector<T, N> {
        self.statistics.evaluations += 1;
        self.system.rate(time, state, self.branches())
    }

    /// Evaluates the rate at the current point anew.
    fn refresh_rate(&mut self) {
        let (stop, kink) = self.next_stop();
        let window = self.window(stop, kink);
        let (method, memory, mut field, point) = self.parts(window);
        method.begin(memory, &mut field, point);
    }

    /// Brings what is known of the contacts to the current point.
    fn refresh_locks(&mut self) {
        let Point { time, state, .. } = self.point;
        let velocities = self.system.sliding_velocities(time, &state);
        let mut noise = [T::zero(); K];
        if let Control::Adaptive { tolerances, .. } = &self.settings.control {
            for i in 0..N {
                let mut beside = state;
                beside[i] += tolerances.absolute()[i];
                let moved = self.system.sliding_velocities(time, &beside);
                for ((noise, moved), still) in noise.iter_mut().zip(moved).zip(velocities) {
                    *noise += (moved - still).abs();
                }
            }
        }
        for ((lock, velocity), noise) in self.locks.iter_mut().zip(velocities).zip(noise) {
            lock.begin(velocity);
            lock.allow(noise);
        }
    }

    /// Where the next step has to end at the latest, and whether that is a kink.
    fn next_stop(&self) -> (T, bool) {
        let mut stop = self.end_time;
        let mut kink = false;
        // A system's answer that lies behind, beyond or nowhere (NaN) is no kink; one at the very end
        // is, for the last stage must not look beyond it.
        let beyond = stop + self.rounding(stop) * self.direction();
        if self.settings.locks
            && let Some(time) = self.system.next_kink(self.point.time, beyond)
            && (time - self.point.time) * self.direction() > T::zero()
            && (beyond - time) * self.direction() > T::zero()
        {
            if (stop - time) * self.direction() > T::zero() {
                stop = time;
            }
            kink = true;
        }
        if let Control::Fixed(step) = self.settings.control {
            let grid = self.start_time + step * lit((self.grid + 1) as f64) * self.direction();
            // Rounding must not leave a last step of nothing.
            if (stop - grid) * self.direction() > self.rounding(stop) {
                return (grid, false);
            }
        }
        (stop, kink)
    }

    /// Takes one step and describes it; false at the end of the time span.
    #[inline]
    fn try_advance(&mut self, looks: impl Fn(T, T) -> bool) -> Result<bool, StopReason> {
        while self.point.time != self.end_time {
            if self.statistics.steps + self.statistics.rejected >= self.settings.most_steps {
                return Err(StopReason::TooManySteps { limit: self.settings.most_steps });
            }
            let (stop, kink) = self.next_stop();
            let (step, reaches) = self.trial_step(stop);
            if reaches && !kink && stop != self.end_time && step.abs() < self.smallest_step() {
                // A step split at a reversal has ended on the grid, but for rounding.
                self.grid += 1;
                continue;
            }
            if !reaches && step.abs() < self.smallest_step() {
                return Err(self.too_small());
            }
            let window = self.window(stop, kink);
            let attempt = self.attempt(step, window);
            let end_time = if reaches { stop } else { self.point.time + step };
            let scale = self.settings.control.scale(&attempt.state);
            let finite = is_finite(&attempt.state);
            let square = if finite { self.mean_square(&attempt, &scale) } else { f64::NAN };
            if !(square <= 1.0) {
                self.shorten(step, &attempt, square)?;
                continue;
            }
            let end = self.arrive(end_time, &attempt, scale, window);
            if !is_finite(&end.rate) {
                self.shorten(step, &attempt, f64::NAN)?;
                continue;
            }
            let seen = looks(self.point.time, end_time);
            let clear =
                !self.settings.locks || surely_none(self.system, &self.locks, &self.point, &end);
            self.describe(&end, seen || !clear, window);
            let reversal = if clear {
                Verdict::None
            } else {
                first_reversal(self.system, &self.locks, &self.step, self.smallest_step())
            };
            match reversal {
                Verdict::None => {
                    for lock in &mut self.locks {
                        lock.stalled = 0;
                    }
                    self.accept(&end, step.abs(), reaches, square, attempt.order);
                    if reaches && stop != self.end_time {
                        self.arrive_at_stop(kink);
                    }
                    return Ok(true);
                }
                Verdict::AtStart(contact) => {
                    self.statistics.rejected += 1;
                    self.turn(contact, T::zero())?;
                    // Turned back again, it has not reversed; nor has it where the first direction
                    // was a wrong guess.
                    self.turned = match self.turned {
                        Some(turned) if turned == contact => None,
                        _ if self.point.time == self.start_time => None,
                        _ => Some(contact),
                    };
                    let fixed = matches!(self.settings.control, Control::Fixed(_));
                    if fixed && self.branches().get(contact) == Some(&Branch::Free) {
                        // Neither branch leads anywhere, and without an error estimate there is no
                        // telling whether the free one does.
                        return Err(StopReason::EndlessReversals { contact });
                    }
                }
                Verdict::Within(contact, fraction) => {
                    // The dense output finds the reversal, but the state there comes from a step
                    // of its own: that keeps the order of the method.
                    let cut = self.rounded(step * fraction);
                    let attempt = self.attempt(cut, window);
                    let scale = self.settings.control.scale(&attempt.state);
                    if !is_finite(&attempt.state) {
                        self.shorten(cut, &attempt, f64::NAN)?;
                        continue;
                    }
                    let end = self.arrive(self.point.time + cut, &attempt, scale, window);
                    if !is_finite(&end.rate) {
                        self.shorten(cut, &attempt, f64::NAN)?;
                        continue;
                    }
                    self.describe(&end, looks(self.point.time, end.time), window);
                    let before = self.locks;
                    self.statistics.rejected += 1;
                    self.accept(&end, step.abs(), false, square, attempt.order);
                    // Where the dense output was too coarse, the rest of the way is another step.
                    let arrived = match (before.get(contact), self.locks.get(contact)) {
                        (Some(before), Some(after)) => after.reaches_zero(before),
                        _ => true,
                    };
                    if arrived {
                        self.step.reversal = Some(contact);
                        self.statistics.reversals += 1;
                        self.turn(contact, fraction)?;
                    }
                    return Ok(true);
                }
            }
        }
        Ok(false)
    }

    /// The smooth stretch from here to a stop. At a kink the inputs answer with what holds just after
    /// it.
    fn window(&self, stop: T, kink: bool) -> Window<T> {
        let now = self.point.time;
        if self.end_time >= self.start_time {
            (now, if kink { self.just_before(stop) } else { stop })
        } else {
            (stop, if self.at_kink { self.just_before(now) } else { now })
        }
    }

    /// A step by which the time really advances: the rest would add up to a drift of the clock.
    fn rounded(&self, step: T) -> T {
        (self.point.time + step) - self.point.time
    }

    /// Length of the next trial, signed, and whether it ends at the stop.
    fn trial_step(&self, stop: T) -> (T, bool) {
        let remaining = stop - self.point.time;
        let distance = remaining.abs();
        // A fixed grid is exact only to the rounding of time.
        if self.length >= distance * lit(0.999) - self.smallest_step() * lit(4.0) {
            (remaining, true)
        } else if matches!(self.settings.control, Control::Adaptive { .. })
            && self.length > distance * lit(0.5)
        {
            // Two equal steps instead of a long one and a stub.
            (self.rounded(remaining * lit(0.5)), false)
        } else {
            (self.rounded(self.length * self.direction()), false)
        }
    }

    fn attempt(&mut self, step: T, window: Window<T>) -> Attempt<T, N> {
        let (method, memory, mut field, from) = self.parts(window);
        method.attempt(memory, &mut field, from, step)
    }

    /// The end of a trial step, with the rate there.
    fn arrive(
        &mut self,
        time: T,
        attempt: &Attempt<T, N>,
        scale: SVector<T, N>,
        window: Window<T>,
    ) -> Point<T, N> {
        let mut end = Point { time, state: attempt.state, rate: SVector::zeros(), scale };
        let (method, memory, mut field, _) = self.parts(window);
        method.arrive(memory, &mut field, &mut end);
        end
    }

    /// Mean square of the error of a trial over the tolerances; not finite if the step is not.
    fn mean_square(&self, attempt: &Attempt<T, N>, scale: &SVector<T, N>) -> f64 {
        if matches!(self.settings.control, Control::Fixed(_)) {
            return 0.0;
        }
        let (mut fine, mut coarse) = (T::zero(), T::zero());
        for i in 0..N {
            let inverse = T::one() / larger(self.point.scale[i], scale[i]);
            let ratio = attempt.error[i] * inverse;
            fine += ratio * ratio;
            if let Some(error) = &attempt.coarse_error {
                let ratio = error[i] * inverse;
                coarse += ratio * ratio;
            }
        }
        let (fine, count) = (to_f64(fine), N.max(1) as f64);
        match attempt.coarse_error {
            None => fine / count,
            Some(_) => {
                let weighed = fine + 0.01 * to_f64(coarse);
                if weighed > 0.0 { fine * (fine / weighed) / count } else { weighed }
            }
        }
    }

    /// Describes a trial step, with the method's own curve or with the cubic through its ends.
    fn describe(&mut self, end: &Point<T, N>, full: bool, window: Window<T>) {
        let (method, memory, mut field, from) = self.parts(window);
        let cubic = || Curve::hermite(from, end);
        let curve = if full {
            let curve = method.curve(memory, &mut field, from, end);
            // A stage that serves the curve alone may hit the pole beyond a reversal.
            if curve.is_finite() { curve } else { cubic() }
        } else {
            cubic()
        };
        self.step = Step {
            start_time: self.point.time,
            end_time: end.time,
            whole: end.time - self.point.time,
            end: end.state,
            curve,
            reversal_at_start: self.turned,
            reversal: None,
        };
    }

    /// Shortens the step after a rejected trial, or gives up at the smallest one.
    fn shorten(
        &mut self,
        tried: T,
        attempt: &Attempt<T, N>,
        square: f64,
    ) -> Result<(), StopReason> {
        self.statistics.rejected += 1;
        let plain = !self.settings.locks && matches!(self.settings.control, Control::Fixed(_));
        if !plain {
            self.length = tried.abs() * lit(self.controller.rejected(square, attempt.order));
            if self.length >= self.smallest_step() {
                return Ok(());
            }
        } else if is_finite(&attempt.state) {
            // Plain fixed steps have a fixed cost: there is no second trial.
            let rate = self.evaluate(self.point.time + tried, &attempt.state);
            return check_finite(&rate);
        }
        // The state that went bad first is the one whose rate did, a tiny step ahead.
        let ahead = self.point.state + self.point.rate * tried;
        let rate = self.evaluate(self.point.time + tried, &ahead);
        check_finite(&rate)?;
        if self.statistics.jacobians > 0 {
            // Or the one whose derivatives did.
            let (time, state) = (self.point.time, self.point.state);
            let window = (smaller(time, self.end_time), larger(time, self.end_time));
            let (_, _, mut field, _) = self.parts(window);
            let tangent = field.linearised(time, &state);
            check_finite(&tangent.by_time)?;
            for column in tangent.by_state.column_iter() {
                check_finite(&column.into_owned())?;
            }
        }
        check_finite(&attempt.state)?;
        match self.locks.iter().position(|lock| lock.stalled > 0) {
            Some(contact) => Err(StopReason::EndlessReversals { contact }),
            None => Err(self.too_small()),
        }
    }

    fn too_small(&self) -> StopReason {
        StopReason::StepTooSmall { smallest: to_f64(self.smallest_step()) }
    }

    /// Moves to the end of a step and proposes the next one, from the length of the trial whose
    /// error is given (a step cut at a reversal is shorter than its trial).
    fn accept(&mut self, end: &Point<T, N>, tried: T, reaches: bool, square: f64, order: u8) {
        self.statistics.steps += 1;
        self.statistics.reversals += u64::from(self.turned.take().is_some());
        for lock in &mut self.locks {
            lock.took(tried);
        }
        let now = self.point.time;
        let passed = (smaller(now, end.time), larger(now, end.time));
        self.at_kink = false;
        match self.settings.control {
            Control::Fixed(fixed) => {
                // After a trial shortened at a pole of the field: back to the grid in doublings.
                self.length = smaller(fixed, self.length * lit(2.0));
                let (method, memory, mut field, from) = self.parts(passed);
                method.accepted(memory, &mut field, from, end, None);
            }
            Control::Adaptive { largest_step, .. } => {
                let factor = lit(self.controller.accepted(square, order));
                let proposed = if reaches {
                    // The stop made the step short, not its error.
                    larger(self.length, tried * factor)
                } else {
                    tried * factor
                };
                let (method, memory, mut field, from) = self.parts(passed);
                let answer = method.accepted(memory, &mut field, from, end, Some(proposed));
                let proposed = answer.unwrap_or(proposed);
                self.length = largest_step.map_or(proposed, |largest| smaller(proposed, largest));
            }
        }
        self.point = *end;
        if self.settings.locks {
            self.look_ahead();
        }
    }

    /// Brings the velocities to the current point, and locks the contacts that slide clearly.
    fn look_ahead(&mut self) {
        let velocities = self.system.sliding_velocities(self.point.time, &self.point.state);
        let mut locked = false;
        for (lock, velocity) in self.locks.iter_mut().zip(velocities) {
            if lock.branch == Branch::Free && velocity.abs() > lock.noise {
                lock.branch = Branch::towards(velocity);
                locked = true;
            }
            lock.look(velocity);
        }
        if locked {
            self.refresh_rate();
        }
    }

    /// Business at a stop that is not the end: a grid point, or a kink of an input.
    fn arrive_at_stop(&mut self, kink: bool) {
        if let Control::Fixed(step) = self.settings.control {
            // A kink may fall on a grid point, and a grid point on a kink but for rounding.
            let travelled = (self.point.time - self.start_time).abs();
            if !kink || step * lit((self.grid + 1) as f64) <= travelled + self.smallest_step() {
                self.grid += 1;
            }
            self.length = step;
        }
        if kink {
            self.at_kink = true;
            self.refresh_rate();
        }
    }

    /// Turns a contact to the other branch at the current point, after a step cut to a fraction.
    fn turn(&mut self, index: usize, fraction: T) -> Result<(), StopReason> {
        if let Some(lock) = self.locks.get_mut(index) {
            lock.turn(fraction);
            if matches!(self.settings.control, Control::Adaptive { .. }) {
                self.length = lock.likely(self.length);
            }
            if lock.branch == Branch::Free {
                let (since, times) = self.given_up;
                let (many, part) = ENDLESS;
                self.given_up = (since, times + 1);
                if times >= many {
                    if (self.point.time - since).abs() < self.span() * lit(part) {
                        return Err(StopReason::EndlessReversals { contact: index });
                    }
                    self.given_up = (self.point.time, 0);
                }
            }
        }
        self.refresh_locks();
        self.refresh_rate();
        Ok(())
    }
}

fn is_finite<T: Scalar, const N: usize>(vector: &SVector<T, N>) -> bool {
    vector.iter().all(|value| value.is_finite())
}

/// Names the first component that is not finite.
fn check_finite<T: Scalar, const N: usize>(vector: &SVector<T, N>) -> Result<(), StopReason> {
    match vector.iter().position(|value| !value.is_finite()) {
        Some(component) => Err(StopReason::NotFinite { component }),
        None => Ok(()),
    }
}
