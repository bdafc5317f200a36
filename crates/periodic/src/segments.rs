//! Newton's equations of a motion in segments, each of which begins where the one before ends.
//!
//! Φ_i δx_i + f(x_i(τ_i)) δτ_i − δx_{i+1} = x_{i+1} − x_i(τ_i),  f(x_i)·δx_i = 0,  x_M = ± x₀
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | x_i, τ_i | state at the start of segment i of M, and how long that lasts | of each state, s |
//! | Φ_i, f | derivatives of the segment's run by its start; rate of the state | |
//! | δ | corrections, in units of the scales of the states and of τ_i | |
//!
//! A motion that forgets where it was and then magnifies what is left has Φ = Φ_M … Φ₁ of ordinary
//! size, and no digits in x₀; the x_i between have them. The equations are solved together, by one
//! factorisation: no product of the Φ_i is formed.
//!
//! Source: J. Stoer, R. Bulirsch, "Introduction to Numerical Analysis" (Springer, 2002), section
//! 7.3.5.

use core::cell::Cell;

use bristle::ode::{Direction, Event, Occurrence, System};
use bristle::parameter::{Checked, Named};
use nalgebra::{DMatrix, DVector, SMatrix, SVector};

use crate::flow::Flow;
use crate::multipliers::multipliers;
use crate::{Answer, Guess, Orbit, PeriodicError};

/// A motion that is looked for: how it closes.
pub(crate) struct Cyclic<const N: usize> {
    /// Of a step of its runs, over the scales.
    pub(crate) tolerance: f64,
    /// The scales of the states: of one branch the same throughout.
    pub(crate) scales: SVector<f64, N>,
    /// Steps, and parts of them, that may still be taken.
    pub(crate) left: Cell<u64>,
    /// How often a state x jumps to J x \[s\], first at the start of a run, and J.
    pub(crate) samples: Option<(f64, SMatrix<f64, N, N>)>,
    /// How many segments there are.
    pub(crate) count: usize,
    /// When the first begins \[s\].
    pub(crate) start_time: f64,
    /// Whether the durations of the segments are given.
    pub(crate) forced: bool,
    /// −1 if the last one ends at the mirror image of x₀, x(T/2) = −x(0), else 1.
    pub(crate) sign: f64,
}

/// A system in which the motion is looked for.
pub(crate) struct Running<'a, S, const N: usize, const K: usize> {
    pub(crate) system: &'a S,
    pub(crate) cyclic: &'a Cyclic<N>,
}

/// The equations at some segments.
pub(crate) struct Equations<const N: usize> {
    /// N + 1 unknowns for each segment, with as many equations.
    pub(crate) matrix: DMatrix<f64>,
    pub(crate) right: DVector<f64>,
    pub(crate) flows: Vec<Flow<N>>,
    /// How far the motion goes from its start, over the scales.
    pub(crate) extent: f64,
}

impl<const N: usize> Cyclic<N> {
    /// In a system.
    pub(crate) fn of<'a, S, const K: usize>(&'a self, system: &'a S) -> Running<'a, S, N, K> {
        Running { system, cyclic: self }
    }

    /// Runs from a state, cut into segments with about as many of their steps in each.
    pub(crate) fn recut(&self, start: SVector<f64, N>, runs: &[Flow<N>]) -> Checked<Vec<Guess<N>>> {
        let steps = || runs.iter().flat_map(|run| &run.steps);
        // Between equal times and equal numbers of steps: those behind a reversal are short.
        let share = steps().map(|step| step.0.sqrt()).sum::<f64>() / self.count as f64;
        let (mut state, mut period, mut filled) = (start, 0.0, 0.0);
        let mut segments = Vec::with_capacity(self.count);
        for &(duration, end) in steps() {
            period += duration;
            filled += duration.sqrt();
            if filled > (1 + segments.len()) as f64 * share && segments.len() + 1 < self.count {
                segments.push(Guess { state, period });
                (state, period) = (end, 0.0);
            }
        }
        let is_enough = period > 0.0 && segments.len() + 1 == self.count;
        let rule = "be less: the run over a period has too few steps for as many";
        Named("segments", self.count as f64).stated(is_enough, rule)?;
        segments.push(Guess { state, period });
        Ok(segments)
    }

    /// Whether some segment has far more or fewer steps than others.
    pub(crate) fn is_uneven(&self, runs: &[Flow<N>]) -> bool {
        let filled = |run: &Flow<N>| run.steps.iter().map(|step| step.0.sqrt()).sum::<f64>();
        let all: f64 = runs.iter().map(filled).sum();
        let shares = runs.iter().map(|run| filled(run) * self.count as f64 / all);
        shares.into_iter().any(|share| !(0.5..=2.0).contains(&share))
    }

    /// When the segments begin, where they have to end, and that factor of the next one's start.
    pub(crate) fn target(&self, segments: &[Guess<N>], index: usize) -> (f64, SVector<f64, N>) {
        let sign = if index + 1 == segments.len() { self.sign } else { 1.0 };
        (sign, segments[(index + 1) % segments.len()].state * sign)
    }

    /// Adds corrections in units of the scales and of the durations; these change by a fifth at
    /// most.
    pub(crate) fn correct(&self, segments: &mut [Guess<N>], by: &DVector<f64>) {
        for (index, segment) in segments.iter_mut().enumerate() {
            let by = by.rows(index * (N + 1), N + 1);
            segment.state += SVector::from_fn(|i, _| by[i] * self.scales[i]);
            segment.period *= 1.0 + by[N].clamp(-0.2, 0.2);
        }
    }

    /// The motion of segments that have closed.
    pub(crate) fn orbit(&self, segments: &[Guess<N>], flows: &[Flow<N>]) -> Answer<Orbit<N>> {
        let mut factors: Vec<_> = flows.iter().flat_map(|flow| &flow.factors).copied().collect();
        if let Some(last) = factors.last_mut() {
            *last *= self.sign;
        }
        let multipliers = multipliers(&factors)
            .ok_or(PeriodicError::NotConverged { iterations: 0, correction: f64::NAN })?;
        let period = segments.iter().map(|it| it.period).sum();
        let (start_time, start, forced) = (self.start_time, segments[0].state, self.forced);
        Ok(Orbit { start_time, start, period, forced, multipliers })
    }
}

impl<S: System<f64, N, K>, const N: usize, const K: usize> Running<'_, S, N, K> {
    /// The segments of a motion from a guess, with about as many steps of its run in each.
    pub(crate) fn cut(&self, guess: Guess<N>) -> Answer<Vec<Guess<N>>> {
        Named("period", guess.period).positive()?;
        if self.cyclic.count == 1 {
            return Ok(vec![guess]);
        }
        let flow = self.flow((self.cyclic.start_time, guess.state), guess.period)?;
        Ok(self.cyclic.recut(guess.state, &[flow])?)
    }

    /// The equations. How long the segments of a free motion last is set to when they arrive.
    pub(crate) fn equations(&self, segments: &mut [Guess<N>]) -> Answer<Equations<N>> {
        let Cyclic { start_time, forced, ref scales, .. } = *self.cyclic;
        let (count, size) = (segments.len(), N + 1);
        let mut matrix = DMatrix::zeros(count * size, count * size);
        let mut right = DVector::zeros(count * size);
        let (mut flows, mut time) = (Vec::with_capacity(count), start_time);
        for index in 0..count {
            let (sign, target) = self.cyclic.target(segments, index);
            // The samples of a controller leave no plane to arrive at.
            if !forced && self.cyclic.samples.is_none() {
                segments[index].period = self.arrival(&segments[index], &target)?;
            }
            let Guess { state, period } = segments[index];
            let flow = self.flow((time, state), period)?;
            let at_end = self.rate(time + period, &flow.end)? * period;
            let (row, next) = (index * size, (index + 1) % count * size);
            matrix.fixed_view_mut::<N, N>(row, row).copy_from(&flow.product());
            matrix.fixed_view_mut::<N, 1>(row, row + N).copy_from(&at_end);
            for i in 0..N {
                matrix[(row + i, next + i)] -= sign;
            }
            if forced {
                matrix[(row + N, row + N)] = 1.0;
            } else {
                // A phase condition of the size of the other equations.
                let at_start = self.rate(time, &state)? * period;
                let phase = at_start.normalize().transpose();
                matrix.fixed_view_mut::<1, N>(row + N, row).copy_from(&phase);
            }
            let defect = (target - flow.end).component_div(scales);
            right.fixed_rows_mut::<N>(row).copy_from(&defect);
            flows.push(flow);
            time += period;
        }
        let ends = flows.iter().flat_map(|flow| &flow.steps);
        let far = ends.map(|it| (it.1 - segments[0].state).component_div(scales).norm());
        let extent = far.fold(0.0, f64::max);
        Ok(Equations { matrix, right, flows, extent })
    }

    /// When the motion of a segment comes to the plane across it at its end, nearest to that end of
    /// all times not far from the duration that is expected; that duration itself if it does not.
    /// If it comes to the end itself earlier, then: the duration expected is a multiple of its own.
    pub(crate) fn arrival(&self, segment: &Guess<N>, end: &SVector<f64, N>) -> Answer<f64> {
        let (Guess { state: start, period }, scales) = (*segment, &self.cyclic.scales);
        let from_end = |state: &SVector<f64, N>| (state - end).component_div(scales);
        let normal = self.scaled_rate(0.0, end);
        let ahead = |_: f64, state: &SVector<f64, N>| normal.dot(&from_end(state));
        let plane = Event { function: &ahead, direction: Direction::Rising, stops: false };
        let run = self.run((0.0, start), LATEST * period, &[plane])?;
        let passages = run.events();
        let apart = |it: &&Occurrence<f64, N>| from_end(&it.state).norm();
        let multiple = passages.iter().find(|it| it.time > LEAST * period && apart(it) < SAME);
        let arrivals = passages.iter().filter(|it| it.time > EARLIEST * period);
        let nearest = || arrivals.min_by(|a, b| apart(a).total_cmp(&apart(b)));
        Ok(multiple.or_else(nearest).map_or(period, |it| it.time))
    }
}

/// A duration is looked for between these parts of the one that is expected.
const EARLIEST: f64 = 0.6;
const LATEST: f64 = 1.6;

/// A motion that comes this near to its end, over the scales, has arrived; not within the second
/// part of the duration that is expected, where it has hardly left.
const SAME: f64 = 1e-8;
const LEAST: f64 = 1e-3;

/// The solution of linear equations.
pub(crate) fn solve(matrix: DMatrix<f64>, right: &DVector<f64>) -> Answer<DVector<f64>> {
    let singular = PeriodicError::NotConverged { iterations: 0, correction: f64::INFINITY };
    let found = matrix.full_piv_lu().solve(right).ok_or(singular)?;
    if found.iter().all(|entry| entry.is_finite()) { Ok(found) } else { Err(singular) }
}
