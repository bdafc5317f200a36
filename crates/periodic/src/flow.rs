//! A run with its derivatives by the initial state.
//!
//! Φ̇ = A(t) Φ,  A = ∂f/∂x along the run
//!
//! | symbol | meaning |
//! |---|---|
//! | Φ | derivatives of the state by that at the start, in units of the scales of the states |
//! | h | length of a part of a step \[s\]; A₁, A₂, A₃ at its Gauss nodes |
//! | Ω | Φ of the part is e^Ω |
//!
//! The run is that of `bristle::ode`, split at reversals; there Φ does not jump, because the field
//! is continuous. Within each step the linear equation is solved by Magnus' series of order 6:
//!
//! α₁ = h A₂,  α₂ = (√15/3) h (A₃ − A₁),  α₃ = (10/3) h (A₃ − 2 A₂ + A₁)
//!
//! C₁ = [α₁, α₂],  C₂ = −[α₁, 2α₃ + C₁]/60,  Ω = α₁ + α₃/12 + [−20α₁ − α₃ + C₁, α₂ + C₂]/240
//!
//! It is exact where A is constant, so what dies out quickly does so at its own rate.
//!
//! Source: S. Blanes, F. Casas, J. A. Oteo, J. Ros, "The Magnus expansion and some of its
//! applications", Physics Reports 470 (2009), section 5.4.

use core::ops::ControlFlow;

use bristle::Branch;
use bristle::ode::{
    Automatic, Event, Failure, Output, Solver, Statistics, Step, System, Tolerances, Trajectory,
};
use bristle::parameter::Named;
use nalgebra::{SMatrix, SVector};

use crate::segments::{Cyclic, Running};
use crate::{Answer, PeriodicError};

/// Length of a part over the time constant of the quickest motion: hunting then has its multipliers
/// to 10⁻⁶.
const LONGEST: f64 = 0.5;

/// Samples of a run, at most.
const MOST_SAMPLES: f64 = 1e7;

/// A factor goes on for so many time constants: what it holds differs by e⁴ or so.
const TOGETHER: f64 = 4.0;

/// Terms of the exponential series: with the largest rate below one, those left out are below a
/// rounding, 1/18! = 1.6e-16.
const TERMS: u32 = 17;

/// When a run starts \[s\], and where.
pub(crate) type Start<const N: usize> = (f64, SVector<f64, N>);

/// A run over a time span with its derivatives.
pub(crate) struct Flow<const N: usize> {
    /// The state at the end.
    pub(crate) end: SVector<f64, N>,
    /// The factors of Φ, the first first, in units of the scales.
    pub(crate) factors: Vec<SMatrix<f64, N, N>>,
    /// The steps: how long they last \[s\], and the state at their end.
    pub(crate) steps: Vec<(f64, SVector<f64, N>)>,
    /// By how many time constants of the quickest motion the last factor goes on.
    turned: f64,
}

impl<const N: usize> Flow<N> {
    /// Φ over the whole run, in units of the scales.
    pub(crate) fn product(&self) -> SMatrix<f64, N, N> {
        self.factors.iter().fold(SMatrix::identity(), |product, factor| factor * product)
    }

    /// Appends a factor, or multiplies the last one by it as long as that loses no digits.
    fn push(&mut self, factor: SMatrix<f64, N, N>, turned: f64) {
        self.turned += turned;
        match self.factors.last_mut() {
            Some(last) if self.turned <= TOGETHER => *last = factor * *last,
            _ => {
                self.factors.push(factor);
                self.turned = turned;
            }
        }
    }
}

impl<const N: usize> Cyclic<N> {
    fn solver(&self, duration: f64) -> Answer<Solver<f64, Automatic, N>> {
        Named("period", duration).positive()?;
        let tolerances = Tolerances::scaled(self.tolerance, self.scales)?;
        Ok(Solver::adaptive(Automatic, tolerances).with_most_steps(self.left.get()))
    }

    /// Counts the steps of a run.
    fn counted<R>(
        &self,
        run: Result<R, Box<Failure<f64, N>>>,
        statistics: impl Fn(&R) -> Statistics,
    ) -> Answer<R> {
        let taken = run.as_ref().map_or_else(|failed| failed.statistics, statistics);
        self.left.set(self.left.get().saturating_sub(taken.steps + taken.rejected));
        run.map_err(|failed| (*failed).into())
    }
}

impl<S: System<f64, N, K>, const N: usize, const K: usize> Running<'_, S, N, K> {
    /// A run with its derivatives over a duration > 0. If there are samples, over the whole number
    /// of them that is nearest, and along the rate from there on.
    pub(crate) fn flow(&self, (start_time, start): Start<N>, duration: f64) -> Answer<Flow<N>> {
        Named("period", duration).positive()?;
        let Cyclic { scales, samples, .. } = *self.cyclic;
        let mut flow = Flow { end: start, factors: Vec::new(), steps: Vec::new(), turned: 0.0 };
        let part = samples.map_or(duration, |(time, _)| time);
        let parts = Named("samples", (duration / part).round()).between(1.0, MOST_SAMPLES)?;
        for part_start in (0..parts as u32).map(|index| start_time + f64::from(index) * part) {
            if let Some((_, jump)) = samples {
                flow.end = jump * flow.end;
                let scaled = |i, j| jump[(i, j)] * scales[j] / scales[i];
                flow.push(SMatrix::from_fn(scaled), 0.0);
            }
            let (span, from) = (part_start..part_start + part, flow.end);
            let mut failed = Ok(());
            let mut observer = |step: &Step<f64, N>| {
                flow.steps.push((step.end_time() - step.start_time(), *step.end()));
                failed = self.append(step, &mut flow);
                if failed.is_ok() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
            };
            let solver = self.cyclic.solver(part)?;
            let run = solver.stream(self.system, span, from, &[], &mut observer);
            flow.end = self.cyclic.counted(run.map_err(Box::new), |it| it.statistics)?.state;
            failed?;
        }
        if samples.is_some() {
            let rest = duration - parts * part;
            flow.end += self.rate(start_time, &flow.end)?.component_mul(&scales) * rest;
        }
        Ok(flow)
    }

    /// The rate of the system over the scales [1/s].
    pub(crate) fn scaled_rate(&self, time: f64, state: &SVector<f64, N>) -> SVector<f64, N> {
        let branches = self.system.sliding_velocities(time, state).map(Branch::towards);
        self.system.rate(time, state, branches).component_div(&self.cyclic.scales)
    }

    /// The rate over the scales [1/s]; of a sampled system that of the change over a sample.
    pub(crate) fn rate(&self, time: f64, state: &SVector<f64, N>) -> Answer<SVector<f64, N>> {
        let Some((part, jump)) = self.cyclic.samples else {
            return Ok(self.scaled_rate(time, state));
        };
        let end = self.end((time, jump * state), part)?;
        Ok((end - state).component_div(&self.cyclic.scales) / part)
    }

    /// A run over a duration > 0; it keeps its ends and its events.
    pub(crate) fn run(
        &self,
        (start_time, start): Start<N>,
        duration: f64,
        events: &[Event<'_, f64, N>],
    ) -> Answer<Trajectory<f64, N>> {
        let (solver, end) = (self.cyclic.solver(duration)?, start_time + duration);
        let ends = Output::Uniform(2);
        let run = solver.solve_with_events(self.system, start_time..end, start, events, ends);
        self.cyclic.counted(run, Trajectory::statistics)
    }

    /// The end of a run.
    pub(crate) fn end(&self, start: Start<N>, duration: f64) -> Answer<SVector<f64, N>> {
        let run = self.run(start, duration, &[])?;
        Ok(run.last().map_or(start.1, |(_, end)| *end))
    }

    /// Appends the factors of a step.
    fn append(&self, step: &Step<f64, N>, flow: &mut Flow<N>) -> Answer<()> {
        let Self { system, cyclic: Cyclic { scales, left: steps, .. } } = self;
        let (start, length) = (step.start_time(), step.end_time() - step.start_time());
        if length == 0.0 {
            return Ok(());
        }
        // Within a step no sliding direction changes.
        let middle = start + 0.5 * length;
        let branches =
            system.sliding_velocities(middle, &step.at_fraction(0.5)).map(Branch::towards);
        let jacobian = |fraction: f64| -> Answer<SMatrix<f64, N, N>> {
            let state = step.at_fraction(fraction);
            let linearised = system.linearised(start + fraction * length, &state, branches);
            let by_state = linearised.ok_or(PeriodicError::NoDerivatives)?.by_state;
            Ok(SMatrix::from_fn(|i, j| by_state[(i, j)] * scales[j] / scales[i]))
        };
        let turned = largest_rate(&jacobian(0.5)?) * length;
        let parts = (turned / LONGEST).ceil().max(1.0);
        // Each costs as much as a step.
        let left = steps.get().checked_sub(parts as u64).ok_or(PeriodicError::TooManySteps)?;
        steps.set(left);
        let gauss = 0.5 * 0.6_f64.sqrt();
        for part in 0..parts as usize {
            let node = |offset: f64| jacobian((part as f64 + 0.5 + offset) / parts);
            let nodes = [node(-gauss)?, node(0.0)?, node(gauss)?];
            flow.push(exponential(&magnus(&nodes, length / parts)), turned / parts);
        }
        Ok(())
    }
}

/// A bound of the largest eigenvalue, that of A⁸ by its largest row.
fn largest_rate<const N: usize>(a: &SMatrix<f64, N, N>) -> f64 {
    let size = a.amax();
    if !(size > 0.0) {
        return 0.0;
    }
    let second = (a / size) * (a / size);
    let fourth = second * second;
    let eighth = fourth * fourth;
    let row = eighth.row_iter().map(|row| row.abs().sum()).fold(0.0, f64::max);
    size * row.powf(0.125)
}

/// Ω of a part of length h, from A at its Gauss nodes.
fn magnus<const N: usize>(
    [first, middle, last]: &[SMatrix<f64, N, N>; 3],
    h: f64,
) -> SMatrix<f64, N, N> {
    let commutator = |a: &SMatrix<f64, N, N>, b: &SMatrix<f64, N, N>| a * b - b * a;
    let one = middle * h;
    let two = (last - first) * (15_f64.sqrt() / 3.0 * h);
    let three = (last - middle * 2.0 + first) * (10.0 / 3.0 * h);
    let inner = commutator(&one, &two);
    let outer = commutator(&one, &(three * 2.0 + inner)) * (-1.0 / 60.0);
    let last = commutator(&(inner - one * 20.0 - three), &(two + outer));
    one + three * (1.0 / 12.0) + last * (1.0 / 240.0)
}

/// e^Ω by its series, for eigenvalues up to about one.
fn exponential<const N: usize>(omega: &SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    let (mut term, mut sum) = (SMatrix::identity(), SMatrix::identity());
    for count in 1..=TERMS {
        term = term * omega / f64::from(count);
        sum += term;
    }
    sum
}
