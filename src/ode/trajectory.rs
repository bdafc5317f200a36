//! A stored solution.

use alloc::boxed::Box;
use alloc::vec::Vec;
use core::ops::{ControlFlow, Range};

use super::dense_output::MOST_TERMS;
use super::event::{Event, Occurrence};
use super::failure::{Failure, StopReason};
use super::solver::{Observer, Solver, Summary, check_sizes};
use super::statistics::Statistics;
use super::step::Step;
use super::stepper::OneStep;
use super::storage::States;
use super::system::Equations;
use crate::Scalar;
use crate::parameter::{Checked, Named, ParameterError, Rule};
use crate::scalar::lit;

/// The tolerance of a step that is tried first, over that of the solution and over the one that a
/// run with this method aims at.
const FIRST: f64 = 500.0;

/// An attempt whose errors have grown to so many times their limit is followed by one with steps so
/// much tighter, and this much more.
const SAFETY: f64 = 0.1;

/// But not by more than this at once: with loose steps the growth may be far overestimated.
const MOST_AT_ONCE: f64 = 1e-4;

/// The limit of such an attempt is so much wider: to miss it by a little would cost a third one.
const LENIENT: f64 = 1.5;

/// Which points of a solution to store.
///
/// The error of a solution is estimated at the ends of steps. Between them lies the method's curve.
/// For [`DormandPrince8`](super::DormandPrince8), whose steps are long and may be held by stability
/// alone, its error is estimated as well, and steps are shorter where it is larger than that of a
/// solution may be. For the others it is mostly less than ten times that at the ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Output<'a, T> {
    /// The start and the end of every step.
    Steps,
    /// Those, and the curves between: [`Trajectory::at`] interpolates at any time.
    Dense,
    /// This many times, at least 2, evenly spaced and including both ends of the span.
    Uniform(usize),
    /// These times, in the order of the run and within its span.
    Times(&'a [T]),
}

/// A stored solution: states over time, the events that happened, and what the run cost.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory<T: Scalar, V: States<T>> {
    times: Vec<T>,
    states: Vec<V>,
    /// Empty unless the output is dense.
    steps: Vec<Step<T, V>>,
    events: Vec<Occurrence<T, V>>,
    reversals: Vec<Occurrence<T, V>>,
    stopped_by: Option<usize>,
    statistics: Statistics,
}

impl<T: Scalar, V: States<T>> Trajectory<T, V> {
    /// The stored times \[s\].
    pub fn times(&self) -> &[T] {
        &self.times
    }

    /// The states at the stored times.
    pub fn states(&self) -> &[V] {
        &self.states
    }

    /// Times and states together.
    pub fn iter(&self) -> impl Iterator<Item = (T, &V)> {
        self.times.iter().copied().zip(&self.states)
    }

    /// The last stored time and state; `None` if nothing was stored.
    pub fn last(&self) -> Option<(T, &V)> {
        Some((*self.times.last()?, self.states.last()?))
    }

    /// The state at any time of a run with [`Output::Dense`], to the order of the method's
    /// interpolant. `None` outside the time reached, or without dense output.
    ///
    /// ```
    /// use bristle::ode::{DormandPrince, Output, Solver, Tolerances};
    /// use bristle::scene::MassSpringDamper;
    /// use bristle::{Bristle, FrBd, paper};
    /// use bristle::curve::Stribeck;
    /// use bristle::rheology::KelvinVoigt;
    ///
    /// let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
    /// let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
    /// let contact = FrBd::new(curve, bristle).under_load(1.0)?;
    /// let rig = MassSpringDamper::new(paper::stick_slip_rig(contact))?;
    /// let solver = Solver::checked(DormandPrince, Tolerances::scaled(1e-6, rig.scales())?);
    /// let motion = solver.solve(&rig, 0.0..9.0, rig.at_rest(), Output::Dense)?;
    /// let sticking = motion.at(1.0).unwrap();
    /// assert!(sticking[0] < 1e-4);
    /// assert_eq!(motion.at(9.1), None);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn at(&self, time: T) -> Option<V> {
        let Some(first) = self.steps.first() else {
            // A run over no time, or one that failed at once, has one state.
            let [only] = self.times[..] else { return None };
            return self.states.first().cloned().filter(|_| time == only);
        };
        let step = self.steps.get(self.steps.partition_point(|step| step.end_time < time))?;
        (time >= first.start_time).then(|| step.at(time))
    }

    /// The reversals of sliding directions at which a step was split, in the order of the run.
    pub fn reversals(&self) -> &[Occurrence<T, V>] {
        &self.reversals
    }

    /// The events that happened, in the order of the run.
    pub fn events(&self) -> &[Occurrence<T, V>] {
        &self.events
    }

    /// The event that stopped the run, by its place in the list, if one did.
    pub fn stopped_by(&self) -> Option<usize> {
        self.stopped_by
    }

    /// Counts of the run's steps and evaluations.
    pub fn statistics(&self) -> Statistics {
        self.statistics
    }
}

impl<T: Scalar, V: States<T>, M: OneStep<T, V>> Solver<T, M, V> {
    /// Runs over a time span \[s\] and stores the solution.
    ///
    /// # Errors
    ///
    /// Says why the run ended before its time, and keeps what was stored until then.
    pub fn solve<S: Equations<T, V, K> + ?Sized, K>(
        &self,
        system: &S,
        span: Range<T>,
        initial_state: V,
        output: Output<'_, T>,
    ) -> Result<Trajectory<T, V>, Box<Failure<T, V>>> {
        self.solve_with_events(system, span, initial_state, &[], output)
    }

    /// Runs over a time span \[s\], looks for events, and stores the solution.
    ///
    /// # Errors
    ///
    /// Says why the run ended before its time, and keeps what was stored until then.
    pub fn solve_with_events<S: Equations<T, V, K> + ?Sized, K>(
        &self,
        system: &S,
        span: Range<T>,
        initial_state: V,
        events: &[Event<'_, T, V>],
        output: Output<'_, T>,
    ) -> Result<Trajectory<T, V>, Box<Failure<T, V>>> {
        let Some(mut solver) = self.first_attempt() else {
            return self.attempt(system, span, initial_state.clone(), events, output);
        };
        let mut spent = Statistics::default();
        loop {
            match solver.attempt(system, span.clone(), initial_state.clone(), events, output) {
                Ok(mut trajectory) => {
                    trajectory.statistics = trajectory.statistics.after(&spent);
                    return Ok(trajectory);
                }
                Err(mut failure) => {
                    spent = failure.statistics.after(&spent);
                    match solver.next_attempt(self, failure.reason) {
                        Some(next) => solver = next,
                        None => {
                            failure.statistics = spent;
                            if let Some(stored) = &mut failure.trajectory {
                                stored.statistics = spent;
                            }
                            return Err(failure);
                        }
                    }
                }
            }
        }
    }

    /// The solver that is tried first, with loose steps. None if the error of the solution is not
    /// estimated.
    fn first_attempt(&self) -> Option<Self> {
        let (mut first, range) = (self.clone(), self.method.tolerance_range());
        let tolerances = first.tolerances.as_mut()?;
        let times = FIRST * range.aim * self.aim? / tolerances.largest();
        if times > 1.0
            && let Some(looser) = tolerances.times(times)
        {
            *tolerances = looser;
        }
        Some(first)
    }

    /// The solver to try after this one failed, where the one given is that for a stream.
    fn next_attempt(&self, careful: &Self, reason: StopReason) -> Option<Self> {
        match reason {
            StopReason::ErrorsGrow { times } => {
                let tighter =
                    self.tolerances.as_ref()?.times(f64::max(SAFETY / times, MOST_AT_ONCE))?;
                let aim = self.aim.map(|aim| aim * LENIENT);
                Some(Self { tolerances: Some(tighter), aim, ..self.clone() })
            }
            // Loose steps may leave the range where the right-hand side is sound.
            StopReason::NotFinite { .. }
            | StopReason::VelocityNotFinite { .. }
            | StopReason::StepTooSmall { .. } => {
                (self.most_growth() < careful.most_growth()).then(|| careful.clone())
            }
            // Tighter steps meet a jump of the right-hand side just so.
            _ => None,
        }
    }

    fn attempt<S: Equations<T, V, K> + ?Sized, K>(
        &self,
        system: &S,
        span: Range<T>,
        initial_state: V,
        events: &[Event<'_, T, V>],
        output: Output<'_, T>,
    ) -> Result<Trajectory<T, V>, Box<Failure<T, V>>> {
        let mut recorder = Recorder::new(output, span.clone());
        if let Err(error) = recorder.check() {
            return Err(Box::new(Failure::refused(error, span.start, initial_state.clone())));
        }
        recorder.start(&initial_state);
        let ended = self.stream(system, span, initial_state.clone(), events, &mut recorder);
        let (stored, full) = (recorder.trajectory, recorder.full);
        match ended {
            Ok(Summary { time, state, statistics, .. }) if full => {
                let reason = StopReason::TooMuchToStore { steps: stored.times.len() };
                let mut failure = Failure::new(reason, (time, state), statistics);
                failure.trajectory = Some(Box::new(Trajectory { statistics, ..stored }));
                Err(Box::new(failure))
            }
            Ok(Summary { event: stopped_by, statistics, .. }) => {
                Ok(Trajectory { stopped_by, statistics, ..stored })
            }
            Err(mut failure) => {
                // Nothing of a start that was refused is a solution.
                if !matches!(failure.reason, StopReason::Refused(_)) {
                    let stored = Trajectory { statistics: failure.statistics, ..stored };
                    failure.trajectory = Some(Box::new(stored));
                }
                Err(Box::new(failure))
            }
        }
    }
}

/// Solves a system over a time span \[s\], given nothing but a tolerance: relative to each state's
/// typical magnitude, which the system has to tell ([`System::scales`](super::System::scales)).
/// Methods and steps are chosen and changed on the way ([`Solver::automatic`]).
///
/// ```
/// use bristle::ode::{self, Output};
/// use bristle::scene::MassSpringDamper;
/// use bristle::{Bristle, FrBd, paper};
/// use bristle::curve::Stribeck;
/// use bristle::rheology::KelvinVoigt;
///
/// let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
/// let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
/// let contact = FrBd::new(curve, bristle).under_load(1.0)?;
/// let rig = MassSpringDamper::new(paper::stick_slip_rig(contact))?;
/// let motion = ode::solve(&rig, 0.0..20.0, rig.at_rest(), 1e-6, Output::Uniform(201))?;
/// assert!(motion.statistics().reversals > 5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// Says why the run ended before its time, and keeps what was stored until then.
pub fn solve<T: Scalar, V: States<T>, S: Equations<T, V, K> + ?Sized, K>(
    system: &S,
    span: Range<T>,
    initial_state: V,
    tolerance: T,
    output: Output<'_, T>,
) -> Result<Trajectory<T, V>, Box<Failure<T, V>>> {
    let solver = check_sizes(system, &initial_state)
        .and_then(|()| Solver::automatic(tolerance, system.magnitudes()))
        .map_err(|error| Failure::refused(error, span.start, initial_state.clone()))?;
    solver.solve(system, span, initial_state, output)
}

/// The most that is stored of a run by its steps: a gibibyte.
const MOST_BYTES: usize = 1 << 30;

/// The observer that stores.
struct Recorder<'a, T: Scalar, V: States<T>> {
    output: Output<'a, T>,
    span: Range<T>,
    /// The time of the next sample.
    next: Option<T>,
    /// The most bytes to be stored by its steps.
    most_bytes: usize,
    /// Whether there is no room for more.
    full: bool,
    trajectory: Trajectory<T, V>,
}

impl<'a, T: Scalar, V: States<T>> Recorder<'a, T, V> {
    fn new(output: Output<'a, T>, span: Range<T>) -> Self {
        let trajectory = Trajectory {
            times: Vec::new(),
            states: Vec::new(),
            steps: Vec::new(),
            events: Vec::new(),
            reversals: Vec::new(),
            stopped_by: None,
            statistics: Statistics::default(),
        };
        Self { output, span, next: None, most_bytes: MOST_BYTES, full: false, trajectory }
    }

    /// Checks the output, and makes room for it.
    fn check(&mut self) -> Checked<()> {
        Named("span.start", self.span.start).finite()?;
        Named("span.end", self.span.end).finite()?;
        Named("span.end", self.span.end).at_least("span.start", self.span.start)?;
        match self.output {
            Output::Uniform(samples) => {
                Named("samples", samples).count(2)?;
                reserve(&mut self.trajectory.times, samples)?;
                reserve(&mut self.trajectory.states, samples)
            }
            Output::Times(times) => {
                let mut before = ("span.start", self.span.start);
                ParameterError::of_components(times, |&time| {
                    let time = Named("times", Named("times", time).finite()?);
                    time.at_least(before.0, before.1)?;
                    before = ("the time before", time.1);
                    time.at_most("span.end", self.span.end)
                })
            }
            Output::Steps | Output::Dense => Ok(()),
        }
    }

    /// Whether the output is the ends of the steps, and not samples.
    fn is_by_step(&self) -> bool {
        matches!(self.output, Output::Steps | Output::Dense)
    }

    /// Whether there is room for one more step.
    fn has_room(&mut self, state: &V) -> bool {
        // The state, and the curve of a step.
        let on_heap = state.on_heap() * (MOST_TERMS + 3);
        let Trajectory { times, states, steps, .. } = &mut self.trajectory;
        let of_step = size_of::<T>() + size_of::<V>() + size_of::<Step<T, V>>() + on_heap;
        let is_dense = self.output == Output::Dense;
        times.len() < self.most_bytes / of_step
            && times.try_reserve(1).is_ok()
            && states.try_reserve(1).is_ok()
            && (!is_dense || steps.try_reserve(1).is_ok())
    }

    fn store(&mut self, time: T, state: V) {
        self.trajectory.times.push(time);
        self.trajectory.states.push(state);
    }

    /// The time of the sample that follows those stored.
    fn next_sample(&self) -> Option<T> {
        let stored = self.trajectory.times.len();
        match self.output {
            Output::Steps | Output::Dense => None,
            Output::Times(times) => times.get(stored).copied(),
            Output::Uniform(samples) if stored >= samples => None,
            Output::Uniform(samples) if stored + 1 == samples => Some(self.span.end),
            Output::Uniform(samples) => {
                let fraction = lit::<T>(stored as f64) / lit((samples - 1) as f64);
                Some(self.span.start + (self.span.end - self.span.start) * fraction)
            }
        }
    }

    /// Stores the samples up to a time.
    fn sample(&mut self, reached: T, state: impl Fn(T) -> V) {
        while let Some(time) = self.next
            && time <= reached
        {
            self.store(time, state(time));
            self.next = self.next_sample();
        }
    }

    /// Stores what lies at the very start.
    fn start(&mut self, state: &V) {
        if self.is_by_step() {
            self.store(self.span.start, state.clone());
        }
        self.next = self.next_sample();
        self.sample(self.span.start, |_| state.clone());
    }
}

impl<T: Scalar, V: States<T>> Observer<T, V> for Recorder<'_, T, V> {
    fn needs_dense_output(&self, _start_time: T, end_time: T) -> bool {
        self.output == Output::Dense || self.next.is_some_and(|time| time < end_time)
    }

    fn step(&mut self, step: &Step<T, V>) -> ControlFlow<()> {
        if self.is_by_step() {
            if !self.has_room(&step.end) {
                self.full = true;
                return ControlFlow::Break(());
            }
            self.store(step.end_time, step.end.clone());
        }
        if self.output == Output::Dense {
            self.trajectory.steps.push(step.clone());
        }
        let reversals = &mut self.trajectory.reversals;
        for index in step.reversals_at_start() {
            let (time, state) = (step.start_time, step.start().clone());
            reversals.push(Occurrence { index, time, state });
        }
        if let Some(index) = step.reversal {
            let (time, state) = (step.end_time, step.end.clone());
            reversals.push(Occurrence { index, time, state });
        }
        self.sample(step.end_time, |time| step.at(time));
        ControlFlow::Continue(())
    }

    fn event(&mut self, occurrence: &Occurrence<T, V>) -> ControlFlow<()> {
        self.trajectory.events.push(occurrence.clone());
        ControlFlow::Continue(())
    }
}

/// Makes room for so many samples, or refuses them.
fn reserve<V>(list: &mut Vec<V>, samples: usize) -> Checked<()> {
    let rule = Rule::Stated("fit into the memory");
    list.try_reserve_exact(samples).map_err(|_| Named("samples", samples as f64).refused(rule))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test panics to fail")]
mod tests {
    use super::{Output, Recorder};
    use crate::Branch;
    use crate::ode::{Solver, System};
    use nalgebra::Vector1;

    /// ẋ = cos t.
    struct Swing;

    impl System<f64, 1, 0> for Swing {
        fn rate(&self, time: f64, _: &Vector1<f64>, _: [Branch; 0]) -> Vector1<f64> {
            Vector1::new(time.cos())
        }
        fn sliding_velocities(&self, _: f64, _: &Vector1<f64>) -> [f64; 0] {
            []
        }
    }

    #[test]
    fn a_run_ends_where_its_steps_are_more_than_can_be_stored() {
        let solver = Solver::automatic(1e-6, Vector1::new(1.0)).unwrap();
        for output in [Output::Steps, Output::Dense] {
            let mut recorder = Recorder::new(output, 0.0..100.0);
            recorder.most_bytes = 2000;
            recorder.start(&Vector1::new(0.0));
            let start = Vector1::new(0.0);
            let ended = solver.stream(&Swing, 0.0..100.0, start, &[], &mut recorder);
            let ended = ended.unwrap();
            assert!(recorder.full && ended.time < 100.0, "{output:?}");
            let stored = recorder.trajectory.times.len();
            assert!(stored > 1 && stored * 16 <= 2000, "{output:?}: {stored}");
        }
    }
}
