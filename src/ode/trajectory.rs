//! A stored solution.

use alloc::boxed::Box;
use alloc::vec::Vec;
use core::ops::{ControlFlow, Range};

use nalgebra::SVector;

use super::event::{Event, Occurrence};
use super::failure::{Failure, StopReason};
use super::solver::{Observer, Solver};
use super::step::Step;
use super::stepper::Method;
use super::{Statistics, Summary, System};
use crate::Scalar;
use crate::parameter::{Named, ParameterError, Rule};
use crate::scalar::lit;

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
pub struct Trajectory<T, const N: usize> {
    times: Vec<T>,
    states: Vec<SVector<T, N>>,
    /// Empty unless the output is dense.
    steps: Vec<Step<T, N>>,
    events: Vec<Occurrence<T, N>>,
    reversals: Vec<Occurrence<T, N>>,
    stopped_by: Option<usize>,
    statistics: Statistics,
}

impl<T: Scalar, const N: usize> Trajectory<T, N> {
    fn empty() -> Self {
        Self {
            times: Vec::new(),
            states: Vec::new(),
            steps: Vec::new(),
            events: Vec::new(),
            reversals: Vec::new(),
            stopped_by: None,
            statistics: Statistics::default(),
        }
    }

    /// The stored times \[s\].
    pub fn times(&self) -> &[T] {
        &self.times
    }

    /// The states at the stored times.
    pub fn states(&self) -> &[SVector<T, N>] {
        &self.states
    }

    /// Times and states together.
    pub fn iter(&self) -> impl Iterator<Item = (T, &SVector<T, N>)> {
        self.times.iter().copied().zip(&self.states)
    }

    /// The last stored time and state; `None` if nothing was stored.
    pub fn last(&self) -> Option<(T, &SVector<T, N>)> {
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
    pub fn at(&self, time: T) -> Option<SVector<T, N>> {
        let Some(first) = self.steps.first() else {
            // A run over no time, or one that failed at once, has one state.
            let [only] = self.times[..] else { return None };
            return self.states.first().copied().filter(|_| time == only);
        };
        let step = self.steps.get(self.steps.partition_point(|step| step.end_time < time))?;
        (time >= first.start_time).then(|| step.at(time))
    }

    /// The reversals of sliding directions at which a step was split, in the order of the run.
    pub fn reversals(&self) -> &[Occurrence<T, N>] {
        &self.reversals
    }

    /// The events that happened, in the order of the run.
    pub fn events(&self) -> &[Occurrence<T, N>] {
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

impl<T: Scalar, M: Method<T, N>, const N: usize> Solver<T, M, N> {
    /// Runs over a time span \[s\] and stores the solution.
    ///
    /// # Errors
    ///
    /// Says why the run ended before its time, and keeps what was stored until then.
    pub fn solve<S: System<T, N, K>, const K: usize>(
        &self,
        system: &S,
        span: Range<T>,
        initial_state: SVector<T, N>,
        output: Output<'_, T>,
    ) -> Result<Trajectory<T, N>, Box<Failure<T, N>>> {
        self.solve_with_events(system, span, initial_state, &[], output)
    }

    /// Runs over a time span \[s\], looks for events, and stores the solution.
    ///
    /// # Errors
    ///
    /// Says why the run ended before its time, and keeps what was stored until then.
    pub fn solve_with_events<S: System<T, N, K>, const K: usize>(
        &self,
        system: &S,
        span: Range<T>,
        initial_state: SVector<T, N>,
        events: &[Event<'_, T, N>],
        output: Output<'_, T>,
    ) -> Result<Trajectory<T, N>, Box<Failure<T, N>>> {
        let Some(mut solver) = self.first_attempt() else {
            return self.attempt(system, span, initial_state, events, output);
        };
        let mut spent = Statistics::default();
        loop {
            match solver.attempt(system, span.clone(), initial_state, events, output) {
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

    fn attempt<S: System<T, N, K>, const K: usize>(
        &self,
        system: &S,
        span: Range<T>,
        initial_state: SVector<T, N>,
        events: &[Event<'_, T, N>],
        output: Output<'_, T>,
    ) -> Result<Trajectory<T, N>, Box<Failure<T, N>>> {
        let mut recorder = Recorder::new(output, span.clone());
        if let Err(error) = recorder.check() {
            return Err(Box::new(Failure::refused(error, span.start, initial_state)));
        }
        recorder.start(&initial_state);
        let ended = self.stream(system, span, initial_state, events, &mut recorder);
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
/// typical magnitude, which the system has to tell ([`System::scales`]). Methods and steps are
/// chosen and changed on the way ([`Solver::automatic`]).
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
pub fn solve<T: Scalar, S: System<T, N, K>, const N: usize, const K: usize>(
    system: &S,
    span: Range<T>,
    initial_state: SVector<T, N>,
    tolerance: T,
    output: Output<'_, T>,
) -> Result<Trajectory<T, N>, Box<Failure<T, N>>> {
    let solver = Solver::automatic(tolerance, system.scales())
        .map_err(|error| Failure::refused(error, span.start, initial_state))?;
    solver.solve(system, span, initial_state, output)
}

/// The most that is stored of a run by its steps: a gibibyte.
const MOST_BYTES: usize = 1 << 30;

/// The observer that stores.
struct Recorder<'a, T, const N: usize> {
    output: Output<'a, T>,
    span: Range<T>,
    /// The time of the next sample.
    next: Option<T>,
    /// The most bytes to be stored by its steps.
    most_bytes: usize,
    /// Whether there is no room for more.
    full: bool,
    trajectory: Trajectory<T, N>,
}

impl<'a, T: Scalar, const N: usize> Recorder<'a, T, N> {
    fn new(output: Output<'a, T>, span: Range<T>) -> Self {
        let trajectory = Trajectory::empty();
        Self { output, span, next: None, most_bytes: MOST_BYTES, full: false, trajectory }
    }

    /// Checks the output, and makes room for it.
    fn check(&mut self) -> Result<(), ParameterError> {
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
                let mut previous = self.span.start;
                for (index, &time) in times.iter().enumerate() {
                    let before = if index == 0 { "span.start" } else { "the time before" };
                    let checked = Named("times", time)
                        .finite()
                        .and_then(|_| Named("times", time).at_least(before, previous))
                        .and_then(|_| Named("times", time).at_most("span.end", self.span.end));
                    ParameterError::of_component(index, checked)?;
                    previous = time;
                }
                Ok(())
            }
            Output::Steps | Output::Dense => Ok(()),
        }
    }

    /// Whether the output is the ends of the steps, and not samples.
    fn is_by_step(&self) -> bool {
        matches!(self.output, Output::Steps | Output::Dense)
    }

    /// Whether there is room for one more step.
    fn has_room(&mut self) -> bool {
        let Trajectory { times, states, steps, .. } = &mut self.trajectory;
        let of_step = size_of::<T>() + size_of::<SVector<T, N>>() + size_of::<Step<T, N>>();
        let is_dense = self.output == Output::Dense;
        times.len() < self.most_bytes / of_step
            && times.try_reserve(1).is_ok()
            && states.try_reserve(1).is_ok()
            && (!is_dense || steps.try_reserve(1).is_ok())
    }

    fn store(&mut self, time: T, state: SVector<T, N>) {
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
    fn sample(&mut self, reached: T, state: impl Fn(T) -> SVector<T, N>) {
        while let Some(time) = self.next
            && time <= reached
        {
            self.store(time, state(time));
            self.next = self.next_sample();
        }
    }

    /// Stores what lies at the very start.
    fn start(&mut self, state: &SVector<T, N>) {
        if self.is_by_step() {
            self.store(self.span.start, *state);
        }
        self.next = self.next_sample();
        self.sample(self.span.start, |_| *state);
    }
}

impl<T: Scalar, const N: usize> Observer<T, N> for Recorder<'_, T, N> {
    fn needs_dense_output(&self, _start_time: T, end_time: T) -> bool {
        self.output == Output::Dense || self.next.is_some_and(|time| time < end_time)
    }

    fn step(&mut self, step: &Step<T, N>) -> ControlFlow<()> {
        if self.is_by_step() {
            if !self.has_room() {
                self.full = true;
                return ControlFlow::Break(());
            }
            self.store(step.end_time, step.end);
        }
        if self.output == Output::Dense {
            self.trajectory.steps.push(*step);
        }
        let (time, state) = (step.start_time, *step.start());
        let at_start = step.reversals_at_start().map(|index| Occurrence { index, time, state });
        let (time, state) = (step.end_time, step.end);
        let at_end = step.reversal.map(|index| Occurrence { index, time, state });
        self.trajectory.reversals.extend(at_start.chain(at_end));
        self.sample(step.end_time, |time| step.at(time));
        ControlFlow::Continue(())
    }

    fn event(&mut self, occurrence: &Occurrence<T, N>) -> ControlFlow<()> {
        self.trajectory.events.push(*occurrence);
        ControlFlow::Continue(())
    }
}

/// Makes room for so many samples, or refuses them.
fn reserve<V>(list: &mut Vec<V>, samples: usize) -> Result<(), ParameterError> {
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
            let ended = solver.stream(&Swing, 0.0..100.0, start, &[], &mut recorder).unwrap();
            assert!(recorder.full && ended.time < 100.0, "{output:?}");
            let stored = recorder.trajectory.times.len();
            assert!(stored > 1 && stored * 16 <= 2000, "{output:?}: {stored}");
        }
    }
}
