//! Periodic motions by shooting.
//!
//! x(t₀ + T) = x(t₀) = x₀, by Newton's method with the derivatives Φ of the run:
//!
//! (Φ − 1) δx + f(x(t₀ + T)) δT = x₀ − x(t₀ + T),  f(x₀)·δx = 0
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | x, f | state and its rate | of each state |
//! | T | period: given, or found with the phase fixed by the second equation | s |
//! | δ | corrections, in units of the scales of the states and of T | |
//!
//! Source: A. H. Nayfeh, B. Balachandran, "Applied Nonlinear Dynamics" (Wiley, 1995), section 5.4.

use bristle::Branch;
use bristle::ode::{Direction, Event, Occurrence, System};
use bristle::parameter::{Named, ParameterError};
use nalgebra::{DMatrix, DVector, SVector};

use crate::PeriodicError;
use crate::flow::{Flow, Runs};
use crate::multipliers::{Multiplier, multipliers};

/// How periodic motions are looked for.
///
/// ```
/// use bristle::{Bristle, FrBd, curve::Stribeck, paper, rheology::KelvinVoigt};
/// use bristle::ode::{Direction, Event};
/// use bristle::nalgebra::Vector3;
/// use bristle_periodic::{DrivenMass, Shooting};
///
/// let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
/// let contact = FrBd::new(Stribeck::new(paper::STICK_SLIP_CURVE)?, bristle).under_load(1.0)?;
/// let rig = paper::stick_slip_rig(contact);
/// let rig = DrivenMass::new(contact, rig.mechanism, rig.drive_velocity)?;
/// // Once a cycle the slipping mass becomes as fast as the end of the spring.
/// let overtakes = |_: f64, state: &Vector3<f64>| state[1] - 0.1;
/// let overtakes = Event { function: &overtakes, direction: Direction::Rising, stops: false };
/// let shooting = Shooting::default();
/// let guess = shooting.settle(&rig, rig.at_rest(), 40.0, &overtakes)?;
/// let cycle = shooting.free(&rig, guess)?;
/// assert!((cycle.period - 7.639267).abs() < 1e-6 && cycle.is_stable());
/// # Ok::<(), bristle_periodic::PeriodicError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shooting {
    /// Tolerance of a step of the runs, relative to the scales of the states.
    pub tolerance: f64,
    /// Iterations of Newton's method, at most.
    pub most_iterations: usize,
    /// Steps of all runs of a search, or of a branch, at most.
    pub most_steps: u64,
}

impl Default for Shooting {
    /// Steps to 10⁻¹², which leaves nine digits or more of a period, 30 iterations, and 10⁷ steps.
    fn default() -> Self {
        Self { tolerance: 1e-12, most_iterations: 30, most_steps: 10_000_000 }
    }
}

/// Where a periodic motion may be, and how long it may last.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guess<const N: usize> {
    /// A state on it.
    pub state: SVector<f64, N>,
    /// The period \[s\].
    pub period: f64,
}

/// A periodic motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Orbit<const N: usize> {
    /// The time t₀ of `start` \[s\]; of a motion whose system does not depend on time, zero.
    pub start_time: f64,
    /// The state at t₀.
    pub start: SVector<f64, N>,
    /// Period T \[s\].
    pub period: f64,
    /// Whether the period was given (by an input, or as a multiple of its period), or found.
    pub forced: bool,
    /// By decreasing modulus. Of a motion whose period was found one is 1: it has no phase to
    /// return to.
    pub multipliers: [Multiplier; N],
}

impl<const N: usize> Orbit<N> {
    /// Whether small disturbances die out: no multiplier is neutral, nor larger.
    pub fn is_stable(&self) -> bool {
        self.transverse().iter().all(|it| it.log_modulus < 0.0 && !it.is_neutral())
    }

    /// The multipliers of disturbances across the motion: all but the 1 of a period that was found.
    pub fn transverse(&self) -> Vec<Multiplier> {
        let mut all = self.multipliers.to_vec();
        if !self.forced {
            let off = |m: &Multiplier| (m.value() - 1.0).norm();
            let trivial = (0..N).min_by(|&a, &b| off(&all[a]).total_cmp(&off(&all[b])));
            trivial.map(|at| all.remove(at));
        }
        all
    }

    /// The motion of which this is the first half, with its mirror image as the second.
    pub(crate) fn doubled(self) -> Self {
        let multipliers = self.multipliers.map(Multiplier::squared);
        Self { period: 2.0 * self.period, multipliers, ..self }
    }

    /// This motion as a guess for one nearby.
    pub fn guess(&self) -> Guess<N> {
        Guess { state: self.start, period: self.period }
    }
}

impl Shooting {
    /// The runs of a search, of settings that are checked.
    pub(crate) fn runs(&self) -> Result<Runs, ParameterError> {
        let least = 10.0 * f64::EPSILON;
        Named("tolerance", self.tolerance).at_least("ten roundings", least)?;
        Named("most_iterations", self.most_iterations).count(1)?;
        Ok(Runs::new(self.tolerance, self.most_steps))
    }

    /// The motion that repeats with a given period T \[s\] under inputs that do, near a state at
    /// the time `start_time`. T may be a multiple of the period of the inputs.
    ///
    /// # Errors
    ///
    /// Says why there is none: a refused parameter, a run that stopped, Newton's method that did
    /// not converge.
    pub fn forced<S: System<f64, N, K>, const N: usize, const K: usize>(
        &self,
        system: &S,
        (start_time, period): (f64, f64),
        guess: SVector<f64, N>,
    ) -> Result<Orbit<N>, PeriodicError> {
        let runs = self.runs()?;
        let scales = checked_scales(system.scales())?;
        let mut state = guess;
        let mut newton = Newton::new(self.most_iterations, CLOSE);
        loop {
            let flow = runs.flow(system, (start_time, state), period)?;
            let (product, defect) = (flow.product(), (state - flow.end).component_div(&scales));
            let matrix = DMatrix::from_fn(N, N, |i, j| product[(i, j)] - identity(i, j));
            let correction = solve(matrix, &DVector::from_fn(N, |i, _| defect[i]))?;
            if newton.is_over(correction.norm())? {
                return orbit(&flow, (start_time, state), period, true);
            }
            let share = newton.share(correction.norm(), flow.extent.max(1.0));
            state += SVector::from_fn(|i, _| share * correction[i] * scales[i]);
        }
    }

    /// The cycle of a system without inputs, near a guess; its period is found, too.
    ///
    /// # Errors
    ///
    /// As [`Shooting::forced`]; [`PeriodicError::Equilibrium`] if the cycle shrinks to a point.
    pub fn free<S: System<f64, N, K>, const N: usize, const K: usize>(
        &self,
        system: &S,
        guess: Guess<N>,
    ) -> Result<Orbit<N>, PeriodicError> {
        let runs = self.runs()?;
        let scales = checked_scales(system.scales())?;
        let mut point = guess;
        let mut newton = Newton::new(self.most_iterations, CLOSE);
        loop {
            point.period = time_of_return(&runs, system, &scales, &point)?;
            let flow = runs.flow(system, (0.0, point.state), point.period)?;
            let (matrix, right) = free_equations(system, &scales, &point, &flow);
            let correction = solve(matrix, &right)?;
            if newton.is_over(correction.norm())? {
                if !(flow.extent > SMALLEST) {
                    return Err(PeriodicError::Equilibrium);
                }
                return orbit(&flow, (0.0, point.state), point.period, false);
            }
            let share = newton.share(correction.norm(), flow.extent.max(SMALLEST));
            point.correct(&(correction * share), &scales);
        }
    }

    /// A guess for [`Shooting::free`]: simulates over a duration \[s\], and takes the last passage
    /// through an event (a sliding velocity that rises through some value, for instance) with the
    /// time since the earlier passage nearest to it.
    ///
    /// # Errors
    ///
    /// [`PeriodicError::DoesNotRepeat`] if there are no two passages alike; else as the run.
    pub fn settle<S: System<f64, N, K>, const N: usize, const K: usize>(
        &self,
        system: &S,
        start: SVector<f64, N>,
        duration: f64,
        section: &Event<'_, f64, N>,
    ) -> Result<Guess<N>, PeriodicError> {
        self.runs()?;
        let scales = checked_scales(system.scales())?;
        Named("duration", duration).positive()?;
        // A guess need not be exact.
        let runs = Runs::new(1e-9, self.most_steps);
        let section = Event { stops: false, ..*section };
        let run = runs.run(system, start, duration, &[section])?;
        settled(run.events(), duration, &scales).ok_or(PeriodicError::DoesNotRepeat)
    }
}

/// When the motion comes back to the plane across it at its start, nearest to the start of all
/// times not far from the period that is expected; that period itself if it does not. If it comes
/// back to the start itself earlier, then: the period expected is a multiple of its own.
pub(crate) fn time_of_return<S: System<f64, N, K>, const N: usize, const K: usize>(
    runs: &Runs,
    system: &S,
    scales: &SVector<f64, N>,
    point: &Guess<N>,
) -> Result<f64, PeriodicError> {
    let Guess { state: start, period } = *point;
    let from_start = |state: &SVector<f64, N>| (state * runs.sign - start).component_div(scales);
    let normal = scaled_rate(system, scales, 0.0, &start);
    let ahead = |_: f64, state: &SVector<f64, N>| normal.dot(&from_start(state));
    let plane = Event { function: &ahead, direction: Direction::Rising, stops: false };
    let run = runs.run(system, start, LATEST * period, &[plane])?;
    let passages = run.events();
    let apart = |it: &&Occurrence<f64, N>| from_start(&it.state).norm();
    let multiple = passages.iter().find(|it| it.time > LEAST * period && apart(it) < SAME);
    let returns = passages.iter().filter(|it| it.time > EARLIEST * period);
    let nearest = || returns.min_by(|a, b| apart(a).total_cmp(&apart(b)));
    Ok(multiple.or_else(nearest).map_or(period, |it| it.time))
}

/// A guess from passages through a section until some time: the last passage, and the time since
/// the latest one that is nearly as near as any.
fn settled<const N: usize>(
    passages: &[Occurrence<f64, N>],
    end: f64,
    scales: &SVector<f64, N>,
) -> Option<Guess<N>> {
    let (last, earlier) = passages.split_last()?;
    let apart = |it: &Occurrence<f64, N>| (it.state - last.state).component_div(scales).norm();
    let least = earlier.iter().map(apart).reduce(f64::min)?;
    let alike = earlier.iter().rev().find(|it| apart(it) <= 2.0 * least + 1e-4)?;
    let period = last.time - alike.time;
    // A motion that repeated until a while ago has come to rest.
    let goes_on = least < 1.0 && end - last.time < 2.0 * period;
    goes_on.then_some(Guess { state: last.state, period })
}

/// A period is looked for between these parts of the one that is expected.
const EARLIEST: f64 = 0.6;
const LATEST: f64 = 1.6;

/// A motion that comes this near to its start, over the scales, has closed; not within the second
/// part of the period that is expected, where it has hardly left.
const SAME: f64 = 1e-8;
const LEAST: f64 = 1e-3;

/// An orbit that goes less far than this, over the scales, is a point.
pub(crate) const SMALLEST: f64 = 1e-6;

/// A correction below this, over the scales, is none; one below the second that no longer shrinks
/// is of roundings.
const CLOSE: (f64, f64) = (1e-10, 1e-7);

/// The progress of Newton's method.
pub(crate) struct Newton {
    most: usize,
    /// A correction below the first is not made; those below the second that no longer shrink are
    /// roundings.
    close: (f64, f64),
    done: usize,
    last: f64,
}

impl Newton {
    pub(crate) fn new(most: usize, close: (f64, f64)) -> Self {
        Self { most, close, done: 0, last: f64::INFINITY }
    }

    /// Whether a correction is the last one: it need not be made.
    pub(crate) fn is_over(&mut self, correction: f64) -> Result<bool, PeriodicError> {
        let stands = correction < self.close.1 && correction > 0.5 * self.last;
        if correction < self.close.0 || stands {
            return Ok(true);
        }
        (self.done, self.last) = (self.done + 1, correction);
        if self.done >= self.most || !correction.is_finite() {
            return Err(PeriodicError::NotConverged { iterations: self.done, correction });
        }
        Ok(false)
    }

    /// The share of a correction that is made: it must not exceed half of the largest.
    pub(crate) fn share(&self, correction: f64, largest: f64) -> f64 {
        (0.5 * largest / correction).min(1.0)
    }
}

impl<const N: usize> Guess<N> {
    /// Adds corrections in units of the scales and of the period; the period changes by a fifth at
    /// most.
    pub(crate) fn correct(&mut self, by: &DVector<f64>, scales: &SVector<f64, N>) {
        self.state += SVector::from_fn(|i, _| by[i] * scales[i]);
        self.period *= 1.0 + by[N].clamp(-0.2, 0.2);
    }
}

/// Newton's equations for δx and δT, in units of the scales and of T.
pub(crate) fn free_equations<S: System<f64, N, K>, const N: usize, const K: usize>(
    system: &S,
    scales: &SVector<f64, N>,
    point: &Guess<N>,
    flow: &Flow<N>,
) -> (DMatrix<f64>, DVector<f64>) {
    let rate = |state: &SVector<f64, N>| scaled_rate(system, scales, 0.0, state) * point.period;
    let (at_start, at_end) = (rate(&point.state), rate(&flow.end));
    let (defect, product) = ((point.state - flow.end).component_div(scales), flow.product());
    // A phase condition of the size of the other equations.
    let size = at_start.norm();
    let matrix = DMatrix::from_fn(N + 1, N + 1, |i, j| match (i < N, j < N) {
        (true, true) => product[(i, j)] - identity(i, j),
        (true, false) => at_end[i],
        (false, true) => at_start[j] / size,
        (false, false) => 0.0,
    });
    (matrix, DVector::from_fn(N + 1, |i, _| if i < N { defect[i] } else { 0.0 }))
}

/// The rate of a system over the scales [1/s].
pub(crate) fn scaled_rate<S: System<f64, N, K>, const N: usize, const K: usize>(
    system: &S,
    scales: &SVector<f64, N>,
    time: f64,
    state: &SVector<f64, N>,
) -> SVector<f64, N> {
    let branches = system.sliding_velocities(time, state).map(Branch::towards);
    system.rate(time, state, branches).component_div(scales)
}

/// 1 on the diagonal.
pub(crate) fn identity(i: usize, j: usize) -> f64 {
    f64::from(u8::from(i == j))
}

/// The solution of linear equations.
pub(crate) fn solve(
    matrix: DMatrix<f64>,
    right: &DVector<f64>,
) -> Result<DVector<f64>, PeriodicError> {
    let singular = PeriodicError::NotConverged { iterations: 0, correction: f64::INFINITY };
    let found = matrix.full_piv_lu().solve(right).ok_or(singular)?;
    if found.iter().all(|entry| entry.is_finite()) { Ok(found) } else { Err(singular) }
}

/// Scales that are positive and finite.
pub(crate) fn checked_scales<const N: usize>(
    scales: SVector<f64, N>,
) -> Result<SVector<f64, N>, ParameterError> {
    for (index, &scale) in scales.iter().enumerate() {
        ParameterError::of_component(index, Named("scales", scale).positive())?;
    }
    Ok(scales)
}

/// The orbit of a run that has closed.
pub(crate) fn orbit<const N: usize>(
    flow: &Flow<N>,
    (start_time, start): (f64, SVector<f64, N>),
    period: f64,
    forced: bool,
) -> Result<Orbit<N>, PeriodicError> {
    let multipliers = multipliers(&flow.factors)
        .ok_or(PeriodicError::NotConverged { iterations: 0, correction: f64::NAN })?;
    Ok(Orbit { start_time, start, period, forced, multipliers })
}
