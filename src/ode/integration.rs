//! The driver: it chooses steps, locks the sliding directions, and splits steps at reversals and
//! at kinks of the inputs. One driver serves every method.

use super::dense_output::DenseOutput;
use super::derivative_check::DerivativeCheck;
use super::failure::{Failure, StopReason};
use super::growth::Growth;
use super::kink::Kinks;
use super::locked::{Interval, Locked};
use super::progress::{NextStep, Progress, StopTime};
use super::reversal::{ContactBranch, Reversal, first_reversal, surely_none};
use super::seeds::Seeds;
use super::solver::Solver;
use super::statistics::Statistics;
use super::step::{Contacts, Step};
use super::stepper::{OneStep, Point, Stepper, TrialStep};
use super::storage::{Entries, States};
use super::system::Equations;
use super::tolerance::Tolerances;
use crate::{Branch, Scalar};

/// A run in progress: call [`Integration::advance`] until it returns `None`.
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
pub struct Integration<'a, T, V, S, M, K>
where
    T: Scalar,
    V: States<T>,
    S: Equations<T, V, K> + ?Sized,
    M: OneStep<T, V>,
{
    pub(super) system: &'a S,
    pub(super) scales: V,
    pub(super) stepper: M::Stepper,
    pub(super) settings: Solver<T, M, V>,
    pub(super) progress: Progress<T>,
    pub(super) point: Point<T, V>,
    pub(super) locks: S::Contacts<ContactBranch<T>>,
    /// Their branches, since the rate was evaluated anew.
    pub(super) branches: S::Contacts<Branch>,
    /// The contacts that reverse at the current point, where the next step starts.
    pub(super) turned: V::Contacts,
    /// A time \[s\], and how often since then a contact slid in neither direction.
    pub(super) undecided: (T, u32),
    /// The step taken last.
    pub(super) step: Step<T, V>,
    pub(super) growth: Growth<T, V>,
    pub(super) seeds: Seeds<T>,
    pub(super) kinks: Kinks<T, V>,
    pub(super) derivatives: DerivativeCheck,
    /// The largest estimated error of the solution over the tolerances of a step, if it has one.
    pub(super) most_growth: Option<f64>,
    /// The number of steps after which the error that has outgrown its limit is known well enough.
    pub(super) enough: Option<u64>,
    /// Why the run has stopped, if it has.
    stopped: Option<StopReason>,
}

impl<'a, T: Scalar, V: States<T>, S: Equations<T, V, K> + ?Sized, M: OneStep<T, V>, K>
    Integration<'a, T, V, S, M, K>
{
    pub(super) fn new(
        settings: Solver<T, M, V>,
        system: &'a S,
        (start_time, end_time): (T, T),
        state: V,
    ) -> Result<Self, Failure<T, V>> {
        let of_step = settings.tolerances.as_ref().map_or(0.0, Tolerances::largest);
        let (contacts, none) = (system.contacts(), state.like(|_| T::zero()));
        let control = settings.control.limited(system.limit());
        let mut run = Self {
            system,
            scales: system.magnitudes(),
            stepper: settings.method.stepper(of_step, &state),
            progress: Progress::new(control, (start_time, end_time)),
            point: Point {
                time: start_time,
                state: state.clone(),
                rate: none.clone(),
                scale: settings.scale(&state),
            },
            locks: S::Contacts::filled(contacts, ContactBranch::free()),
            branches: S::Contacts::filled(contacts, Branch::Free),
            turned: V::Contacts::default(),
            undecided: (start_time, 0),
            stopped: None,
            growth: Growth::new(&state),
            seeds: Seeds::new(),
            kinks: Kinks::new(&state),
            derivatives: DerivativeCheck::default(),
            most_growth: settings.most_growth(),
            settings,
            enough: None,
            step: Step {
                start_time,
                end_time: start_time,
                whole: T::zero(),
                end: state.clone(),
                dense_output: DenseOutput::new(state, [none.clone(), none.clone(), none]),
                reversals_at_start: V::Contacts::default(),
                reversal: None,
            },
        };
        if start_time != end_time {
            run.progress.check().map_err(|error| run.failure(error.into()))?;
            run.start().map_err(|reason| run.failure(reason))?;
        }
        Ok(run)
    }

    /// The time reached \[s\].
    pub fn time(&self) -> T {
        self.point.time
    }

    /// The state there.
    pub fn state(&self) -> &V {
        &self.point.state
    }

    /// The branch on which each contact slides now.
    pub fn branches(&self) -> S::Contacts<Branch> {
        self.branches.clone()
    }

    /// Counts of steps and evaluations so far.
    pub fn statistics(&self) -> Statistics {
        self.progress.statistics
    }

    /// Takes one step. `None` at the end of the time span.
    ///
    /// # Errors
    ///
    /// Says why the run cannot go on, and where it stands. It stays there.
    #[inline]
    pub fn advance(&mut self) -> Result<Option<Step<T, V>>, Failure<T, V>> {
        Ok(self.advance_observed(|_, _| true)?.cloned())
    }

    /// Takes one step. Its dense output is the method's own if it is needed between the two times
    /// given, otherwise the cubic through its ends.
    #[inline]
    pub(crate) fn advance_observed(
        &mut self,
        needs_dense_output: impl Fn(T, T) -> bool,
    ) -> Result<Option<&Step<T, V>>, Failure<T, V>> {
        let advanced = match self.stopped {
            None => self.try_advance(needs_dense_output),
            Some(reason) => Err(reason),
        };
        match advanced {
            Ok(true) => Ok(Some(&self.step)),
            Ok(false) => Ok(None),
            Err(reason) => {
                self.stopped = Some(reason);
                Err(self.failure(reason))
            }
        }
    }

    fn failure(&self, reason: StopReason) -> Failure<T, V> {
        Failure::new(reason, (self.point.time, self.point.state.clone()), self.statistics())
    }

    /// The method, the system on the current branches, and the current point.
    #[inline(always)]
    #[allow(clippy::type_complexity, reason = "the three parts of one run")]
    pub(super) fn parts(
        &mut self,
        interval: Interval<T>,
    ) -> (&mut M::Stepper, Locked<'_, T, V, S, K>, &mut Point<T, V>) {
        let statistics = &mut self.progress.statistics;
        let (system, scales, branches) = (self.system, &self.scales, &self.branches);
        let field = Locked { system, scales, branches, interval, statistics };
        (&mut self.stepper, field, &mut self.point)
    }

    /// The right-hand side on the current branches.
    pub(super) fn evaluate(&mut self, time: T, state: &V) -> V {
        self.progress.statistics.evaluations += 1;
        let mut rate = state.clone();
        self.system.rate_to(time, state, &self.branches, &mut rate);
        rate
    }

    /// Evaluates the rate at the current point anew.
    pub(super) fn refresh_rate(&mut self) {
        let branches = self.branches.entries_mut().iter_mut();
        for (branch, lock) in branches.zip(self.locks.entries()) {
            *branch = lock.branch;
        }
        self.kinks = Kinks::new(&self.point.state);
        let stop = self.progress.next_stop(self.input_kinks());
        let interval = self.interval(stop);
        let (stepper, mut field, point) = self.parts(interval);
        stepper.begin(&mut field, point);
    }

    /// The next kink of an input between two times, if steps are split there.
    fn input_kinks(&self) -> impl Fn(T, T) -> Option<T> + use<'a, T, V, S, M, K> {
        let (system, is_locking) = (self.system, self.settings.locks);
        move |from, towards| if is_locking { system.kink(from, towards) } else { None }
    }

    /// Takes one step and describes it; false at the end of the time span.
    #[inline]
    fn try_advance(
        &mut self,
        needs_dense_output: impl Fn(T, T) -> bool,
    ) -> Result<bool, StopReason> {
        self.check_growth()?;
        self.check_derivatives()?;
        while !self.progress.is_over() {
            let trial = self.progress.trial(self.input_kinks())?;
            let NextStep { step, end_time, stop, reaches } = trial;
            let interval = self.interval(stop);
            let Some((end, tried, square)) = self.try_step((step, end_time), interval)? else {
                continue;
            };
            let is_clear = !self.settings.locks
                || surely_none(self.system, self.locks.entries(), [&self.point, &end], interval.1);
            let full = !is_clear || needs_dense_output(self.point.time, end_time);
            self.describe(&end, full, interval);
            let reversal = if is_clear {
                Reversal::None
            } else {
                let limits = (interval.1, self.progress.smallest_step());
                first_reversal(self.system, self.locks.entries(), &self.step, limits)
            };
            match reversal {
                Reversal::None => {
                    if !self.stands(&end, (&tried, square), interval, false)? {
                        continue;
                    }
                    for lock in self.locks.entries_mut() {
                        lock.stalled = 0;
                    }
                    self.accept(&end, step.abs(), reaches, square, tried.order);
                    if reaches && !self.progress.is_over() {
                        self.pass(stop);
                    }
                    return Ok(true);
                }
                Reversal::Unknown => self.shorten(step, &tried, f64::NAN)?,
                Reversal::AtStart(contact) => self.turn_at_start(contact)?,
                Reversal::Within(contact, fraction) => {
                    // The dense output locates the reversal, but the state there comes from a step
                    // of its own: that keeps the order of the method.
                    let cut = self.progress.rounded(step * fraction);
                    let cut_time = self.point.time + cut;
                    let Some(part) = self.try_step((cut, cut_time), interval)? else { continue };
                    let full = needs_dense_output(self.point.time, cut_time);
                    self.describe(&part.0, full, interval);
                    if !self.stands(&part.0, (&part.1, part.2), interval, true)? {
                        continue;
                    }
                    let before = self.locks.entries().get(contact).copied();
                    self.progress.statistics.rejected += 1;
                    self.accept(&part.0, step.abs(), false, square, tried.order);
                    self.reverse(before, contact, fraction)?;
                    return Ok(true);
                }
            }
        }
        Ok(false)
    }

    /// Tries a step. Answers with its end, the trial and the mean square of its error over the
    /// tolerances, or with nothing if it was rejected and the next one shortened.
    #[inline]
    #[allow(clippy::type_complexity, reason = "the three results of one trial")]
    fn try_step(
        &mut self,
        (step, end_time): (T, T),
        interval: Interval<T>,
    ) -> Result<Option<(Point<T, V>, TrialStep<T, V>, f64)>, StopReason> {
        let (stepper, mut field, from) = self.parts(interval);
        let trial = stepper.step(&mut field, from, step);
        let scale = self.settings.scale(&trial.state);
        let mut square = match trial.state.is_finite() {
            true if !self.progress.is_adaptive() => 0.0,
            true => trial.mean_square(&self.point.scale, &scale),
            false => f64::NAN,
        };
        if square <= 1.0 {
            let rate = trial.state.like(|_| T::zero());
            let mut end = Point { time: end_time, state: trial.state.clone(), rate, scale };
            let (stepper, mut field, _) = self.parts(interval);
            stepper.arrive(&mut field, &mut end);
            let is_sound = !self.progress.is_adaptive() || self.stepper.represents_growth();
            if is_sound && end.rate.is_finite() {
                return Ok(Some((end, trial, square)));
            }
            square = f64::NAN;
        }
        self.shorten(step, &trial, square)?;
        Ok(None)
    }

    /// The smooth stretch from here to a stop. At a kink the inputs answer with what holds just
    /// after it.
    fn interval(&self, stop: StopTime<T>) -> Interval<T> {
        let StopTime { time, is_kink } = stop;
        (self.point.time, if is_kink { self.progress.just_before(time) } else { time })
    }

    /// Describes a trial step, with the method's own dense output or with the cubic through its
    /// ends.
    #[inline]
    fn describe(&mut self, end: &Point<T, V>, full: bool, interval: Interval<T>) {
        let (stepper, mut field, from) = self.parts(interval);
        let dense_output =
            if full { stepper.dense_output(&mut field, from, end) } else { from.cubic_to(end) };
        let (step, start_time) = (&mut self.step, self.point.time);
        (step.start_time, step.end_time) = (start_time, end.time);
        step.whole = end.time - start_time;
        step.end.clone_from(&end.state);
        step.dense_output = dense_output;
        step.reversals_at_start.clone_from(&self.turned);
        step.reversal = None;
    }

    /// The method's own dense output of a step that is described.
    pub(super) fn own_curve(
        &mut self,
        end: &Point<T, V>,
        interval: Interval<T>,
    ) -> DenseOutput<T, V> {
        if self.step.dense_output.is_extended() {
            return self.step.dense_output.clone();
        }
        let (stepper, mut field, from) = self.parts(interval);
        stepper.dense_output(&mut field, from, end)
    }

    /// Moves to the end of a step and proposes the next one, from the length of the trial whose
    /// error is given (a step cut at a reversal is shorter than its trial).
    #[inline]
    fn accept(&mut self, end: &Point<T, V>, tried: T, reaches: bool, square: f64, order: u8) {
        let proposed = self.progress.accept(tried, reaches, square, order);
        self.progress.statistics.reversals +=
            core::mem::take(&mut self.turned).iter().count() as u64;
        for lock in self.locks.entries_mut() {
            lock.took(tried);
        }
        let length = self.stepper.accepted(end.time - self.point.time, end, proposed);
        self.progress.propose(length);
        if let Some(longest) = self.seeds.longest() {
            self.progress.limit_length(longest);
        }
        self.progress.time = end.time;
        self.point.state.clone_from(&end.state);
        self.point.rate.clone_from(&end.rate);
        self.point.scale.clone_from(&end.scale);
        self.point.time = end.time;
        if self.settings.locks {
            self.update_locks();
        }
    }

    /// The sliding velocities, all of them finite.
    pub(super) fn velocities(&self, time: T, state: &V) -> Result<S::Contacts<T>, StopReason> {
        let velocities = self.system.velocities(time, state);
        match velocities.entries().iter().position(|velocity| !velocity.is_finite()) {
            Some(contact) => Err(StopReason::VelocityNotFinite { contact }),
            None => Ok(velocities),
        }
    }
}
