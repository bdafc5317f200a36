//! A method with its step control: what a user configures and runs.

use core::ops::{ControlFlow, Range};

use super::Automatic;
use super::event::{Event, Occurrence};
use super::failure::Failure;
use super::integration::Integration;
use super::progress::StepControl;
use super::statistics::Statistics;
use super::step::Step;
use super::stepper::{OneStep, Stepper};
use super::storage::States;
use super::system::Equations;
use super::tolerance::{Tolerances, check};
use crate::Scalar;
use crate::parameter::{Checked, Named, ParameterError};

/// A method with its step control.
///
/// On the stack, without allocation: [`Solver::stream`] hands every step to an observer,
/// [`Solver::begin`] gives a run to step by hand, and, with the `alloc` feature, [`Solver::solve`]
/// stores a trajectory. Forward in time only: a bristle forgets, so backward its errors grow as
/// e^λt, and an answer would be made of rounding.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solver<T: Scalar, M, V> {
    pub(super) method: M,
    pub(super) control: StepControl<T>,
    /// Of one step; none for fixed steps.
    pub(super) tolerances: Option<Tolerances<T, V>>,
    /// The relative error that the solution aims at; none if its error is not estimated.
    pub(super) aim: Option<f64>,
    /// Whether sliding directions are locked, and steps split at reversals and input kinks.
    pub(super) locks: bool,
}

impl<T: Scalar, V: States<T>, M: OneStep<T, V>> Solver<T, M, V> {
    /// Steps chosen so that the solution meets the tolerances: those of one step are four
    /// thousand times as tight, and a run over which errors grow by more than that stops, see the
    /// [module](super). [`Solver::solve`] begins with looser steps, and repeats the run if needed.
    ///
    /// [`RungeKutta4`](super::RungeKutta4) has no error estimate, and does not compile here.
    pub fn checked(method: M, tolerances: Tolerances<T, V>) -> Self {
        let aim = tolerances.aim(method.tolerance_range());
        Self { aim: Some(aim), ..Self::adaptive(method, tolerances.of_a_step(aim)) }
    }

    /// The largest estimated error of the solution over the tolerances of a step, if it has one.
    pub(super) fn most_growth(&self) -> Option<f64> {
        Some(self.tolerances.as_ref()?.most_growth(self.aim?))
    }

    /// Steps chosen so that the local error of each one meets the tolerances, as in a general ODE
    /// code. For scenes whose error you measure yourself: breakaway amplifies local errors, and
    /// with loose tolerances a slip comes late, or is missed without notice.
    pub fn adaptive(method: M, tolerances: Tolerances<T, V>) -> Self {
        const { assert!(M::Stepper::ESTIMATES_ERROR, "the method has no error estimate") };
        let (control, tolerances) = (StepControl::adaptive(), Some(tolerances));
        Self { method, control, tolerances, aim: None, locks: true }
    }

    /// Steps of a fixed length h \[s\], each split where a sliding direction reverses or an input
    /// is not smooth; the last one is shorter where h does not divide the time span.
    ///
    /// The number of states follows from the system it is given. Standing alone, say it:
    /// `Solver::<f64, _, 3>::fixed(RungeKutta4, 1e-3)`.
    ///
    /// # Errors
    ///
    /// Refuses a step that is not positive.
    pub fn fixed(method: M, step: T) -> Checked<Self> {
        let control = StepControl::fixed(step)?;
        Ok(Self { method, control, tolerances: None, aim: None, locks: true })
    }

    /// The error of each state that is allowed where it is found.
    #[inline]
    pub(super) fn scale(&self, state: &V) -> V {
        match &self.tolerances {
            Some(tolerances) => tolerances.at(state),
            None => state.like(|_| T::one()),
        }
    }

    /// The plain method: |v| as it is, no step split at reversals or input kinks. With fixed steps
    /// each then costs the same; the kinks cost accuracy, down to first or second order.
    #[must_use]
    pub fn plain(self) -> Self {
        Self { locks: false, ..self }
    }

    /// A limit on the length of adaptive steps \[s\]. Fixed steps ignore it.
    ///
    /// # Errors
    ///
    /// Refuses a limit that is not positive.
    pub fn with_largest_step(mut self, largest: T) -> Checked<Self> {
        self.control.largest_step = Some(Named("largest_step", largest).positive()?);
        Ok(self)
    }

    /// The length of the first adaptive step \[s\], instead of an estimate. Fixed steps ignore it.
    ///
    /// # Errors
    ///
    /// Refuses a step that is not positive.
    pub fn with_first_step(mut self, first: T) -> Checked<Self> {
        self.control.first_step = Some(Named("first_step", first).positive()?);
        Ok(self)
    }

    /// A limit on the number of trial steps, 10⁸ if not given.
    #[must_use]
    pub fn with_most_steps(mut self, most: u64) -> Self {
        self.control.most_steps = most;
        self
    }

    /// Starts a run over a time span \[s\], to be stepped by hand.
    ///
    /// # Errors
    ///
    /// Refuses a time or a state that is not finite, a span that ends before it starts or is
    /// shorter than 10⁻³⁰ s but not empty, a first or largest step that does not advance the time,
    /// and a right-hand side that is not finite at the start.
    #[allow(clippy::type_complexity, reason = "a run is of a system and of a method")]
    pub fn begin<'a, S: Equations<T, V, K> + ?Sized, K>(
        &self,
        system: &'a S,
        span: Range<T>,
        initial_state: V,
    ) -> Result<Integration<'a, T, V, S, M, K>, Failure<T, V>> {
        let refuse = |error| Failure::refused(error, span.start, initial_state.clone());
        if self.tolerances.is_some() {
            self.method.check_adaptive().map_err(refuse)?;
        }
        check_sizes(system, &initial_state).map_err(refuse)?;
        let tolerances =
            self.tolerances.as_ref().map_or(system.states(), |it| it.absolute().count());
        as_many_as_states(system, "values of tolerances", tolerances).map_err(refuse)?;
        Named("span.start", span.start).finite().map_err(refuse)?;
        Named("span.end", span.end).finite().map_err(refuse)?;
        let finite = |&value: &T| Named("initial_state", value).finite();
        ParameterError::of_components(initial_state.entries(), finite).map_err(refuse)?;
        let span = (span.start, span.end);
        Integration::new(self.clone(), system, span, initial_state)
    }

    /// Runs over a time span \[s\], handing every step and every event to an observer.
    ///
    /// ```
    /// use core::ops::ControlFlow;
    ///
    /// use bristle::ode::{DormandPrince, Solver, Step, Tolerances};
    /// use bristle::scene::MassSpringDamper;
    /// use bristle::{Bristle, Dahl, DahlParameters, paper};
    ///
    /// let bristle = DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: 1e4 };
    /// let friction = Dahl::new(bristle)?;
    /// let rig = MassSpringDamper::new(paper::stick_slip_rig(friction.under_load(1.0)?))?;
    /// let solver = Solver::checked(DormandPrince, Tolerances::scaled(1e-6, rig.scales())?);
    /// let mut fastest = 0.0;
    /// let mut observer = |step: &Step<f64, 3>| {
    ///     fastest = f64::max(fastest, step.end()[1]);
    ///     ControlFlow::Continue(())
    /// };
    /// let summary = solver.stream(&rig, 0.0..10.0, rig.at_rest(), &[], &mut observer)?;
    /// assert_eq!(summary.time, 10.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Says why the run ended before its time, when and where; the observer has seen every step
    /// until then.
    pub fn stream<S: Equations<T, V, K> + ?Sized, O: Observer<T, V>, K>(
        &self,
        system: &S,
        span: Range<T>,
        initial_state: V,
        events: &[Event<'_, T, V>],
        observer: &mut O,
    ) -> Result<Summary<T, V>, Failure<T, V>> {
        let mut run = self.begin(system, span, initial_state)?;
        let mut end = None;
        while end.is_none()
            && let Some(step) = run.advance_observed(|from, to| {
                !events.is_empty() || observer.needs_dense_output(from, to)
            })?
        {
            end = if !events.is_empty() {
                with_events(events, step, observer)
            } else if observer.step(step).is_break() {
                Some((None, step.end_time, step.end.clone()))
            } else {
                None
            };
        }
        let (event, time, state) = end.unwrap_or_else(|| (None, run.time(), run.state().clone()));
        Ok(Summary { time, state, event, statistics: run.statistics() })
    }
}

impl<T: Scalar, V: States<T>> Solver<T, Automatic, V> {
    /// The default: methods and steps chosen from a tolerance alone, relative to a typical
    /// magnitude of each state ([`System::scales`](super::System::scales)).
    ///
    /// # Errors
    ///
    /// Refuses a tolerance that is not positive, above 0.1 or below 10 ε, and a scale that is not
    /// positive.
    pub fn automatic(tolerance: T, scales: V) -> Checked<Self> {
        check("tolerance", tolerance)?;
        Ok(Self::checked(Automatic, Tolerances::scaled(tolerance, scales)?))
    }
}

/// Tells an observer of a step, cut at the first event that stops the run, and of its events in
/// the order of time. If the run ends there, answers with that event, if there is one, the time
/// and the state.
fn with_events<T: Scalar, V: States<T>, O: Observer<T, V>>(
    events: &[Event<'_, T, V>],
    step: &Step<T, V>,
    observer: &mut O,
) -> Option<(Option<usize>, T, V)> {
    let stop = next_event(events, step, true, None);
    let cut = stop.map(|(fraction, _)| step.until(fraction));
    let step = cut.as_ref().unwrap_or(step);
    let mut is_over = observer.step(step).is_break();
    let mut last = None;
    while let Some((fraction, index)) = next_event(events, step, false, last) {
        let (time, state) = (step.time_at(fraction), step.at_fraction(fraction));
        is_over |= observer.event(&Occurrence { index, time, state }).is_break();
        last = Some((fraction, index));
    }
    let (time, state) = (step.end_time, step.end.clone());
    if let Some((_, index)) = stop {
        let _ = observer.event(&Occurrence { index, time, state: state.clone() });
        return Some((Some(index), time, state));
    }
    is_over.then_some((None, time, state))
}

/// The first event in a step that stops the run, or does not, after a fraction of the step and the
/// place in the list of the event there: the fraction at which it happens, and its place in the
/// list. Of several events at once, the first in the list.
fn next_event<T: Scalar, V: States<T>>(
    events: &[Event<'_, T, V>],
    step: &Step<T, V>,
    stops: bool,
    after: Option<(T, usize)>,
) -> Option<(T, usize)> {
    let wanted = events.iter().enumerate().filter(|(_, event)| event.stops == stops);
    wanted
        .flat_map(|(index, event)| event.within(step).map(|fraction| Some((fraction?, index))))
        .flatten()
        .filter(|&next| after.is_none_or(|after| next > after))
        .reduce(|first, next| if next.0 < first.0 { next } else { first })
}

/// Who is told of the steps and events of a run. A closure that takes a [`Step`] is one.
pub trait Observer<T: Scalar, V: States<T>> {
    /// A step was accepted. Breaking ends the run there.
    fn step(&mut self, step: &Step<T, V>) -> ControlFlow<()>;

    /// Whether the observer will ask the step between these times for a state other than at its
    /// end. If not, some methods save the evaluations of their dense output, and a state within the
    /// step is that of the cubic through its ends with their rates.
    fn needs_dense_output(&self, start_time: T, end_time: T) -> bool {
        let _ = (start_time, end_time);
        true
    }

    /// An event happened within the step just reported. Breaking ends the run at the step's end.
    fn event(&mut self, occurrence: &Occurrence<T, V>) -> ControlFlow<()> {
        let _ = occurrence;
        ControlFlow::Continue(())
    }
}

impl<T: Scalar, V: States<T>, F: FnMut(&Step<T, V>) -> ControlFlow<()>> Observer<T, V> for F {
    fn step(&mut self, step: &Step<T, V>) -> ControlFlow<()> {
        self(step)
    }
}

/// Final time and state, terminating event and evaluation counts of a run whose steps were streamed
/// to an observer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Summary<T, V> {
    /// Time reached \[s\].
    pub time: T,
    /// State there.
    pub state: V,
    /// The event that ended the run, by its place in the list. `None` if it ended with the time
    /// span, or where the observer broke off.
    pub event: Option<usize>,
    /// Counts of its steps and evaluations.
    pub statistics: Statistics,
}

/// More contacts than any scene has, and than would have room.
const MOST_CONTACTS: usize = 1 << 24;

fn as_many_as_states<T: Scalar, V: States<T>, S: Equations<T, V, K> + ?Sized, K>(
    system: &S,
    name: &'static str,
    count: usize,
) -> Checked<()> {
    Named(name, count).count_between(system.states(), system.states())
}

/// Refuses a state of another size than that of the system, and sizes that no system has: before
/// anything of such a size is asked for.
pub(super) fn check_sizes<T: Scalar, V: States<T>, S: Equations<T, V, K> + ?Sized, K>(
    system: &S,
    initial_state: &V,
) -> Checked<()> {
    Named("states", system.states()).count(1)?;
    as_many_as_states(system, "values of initial_state", initial_state.count())?;
    Named("contacts", system.contacts()).count_between(0, MOST_CONTACTS)
}
