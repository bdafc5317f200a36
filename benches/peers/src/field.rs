//! A scene as a general-purpose code sees it: f(t, x), ∂f/∂x, and where the input has a kink.
//!
//! The right-hand side carries the true |v|. A peer with a root function may be told where the
//! sliding velocity reverses; then |v| continues as ±v beyond it, as with our own methods.
//! Every evaluation is counted here, so that all peers count alike, and a run that spends too
//! much is ended here, from inside its own evaluations.

use std::cell::Cell;
use std::panic::resume_unwind;
use std::time::Duration;

use bristle::Branch;
use bristle::ode::System;
use cpu_time::ThreadTime;
use nalgebra::{SMatrix, SVector};

use crate::scenes::{SAMPLES, Scene};

/// Evaluations after which a run is given up.
pub(crate) const MOST_EVALUATIONS: u64 = 30_000_000;
/// Time after which a run is given up: implicit codes may spend a microsecond and more around
/// each evaluation.
pub(crate) const LONGEST_RUN: Duration = Duration::from_millis(1500);
/// Share of the tolerance of the velocity by which a reversal is beyond zero.
const MARGIN: f64 = 0.01;
/// Evaluations between two looks at the clock.
const BETWEEN_LOOKS: u64 = 4096;

/// Unwinds out of a peer that has spent its allowance; see [`crate::measure`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Spent {
    /// [`MOST_EVALUATIONS`].
    Evaluations,
    /// [`LONGEST_RUN`].
    Time,
}

/// A scene with its counters, for one run.
#[derive(Debug)]
pub(crate) struct Field<'a, S, const N: usize> {
    scene: &'a Scene<S, N>,
    start: ThreadTime,
    rates: Cell<u64>,
    jacobians: Cell<u64>,
    branch: Cell<Branch>,
    /// How far beyond zero a reversal is [m/s].
    margin: Cell<f64>,
}

/// A stretch without input kinks.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Leg {
    /// Its first time [s].
    pub(crate) start: f64,
    /// Its last time [s].
    pub(crate) end: f64,
    /// The output times in it, after `start` and up to `end`; `end` is always among them [s].
    pub(crate) times: Vec<f64>,
    /// Whether the last of them is no output sample, but only where the next leg begins.
    pub(crate) ends_between_samples: bool,
}

impl<'a, S: System<f64, N>, const N: usize> Field<'a, S, N> {
    pub(crate) fn new(scene: &'a Scene<S, N>) -> Self {
        Self {
            scene,
            start: ThreadTime::now(),
            rates: Cell::new(0),
            jacobians: Cell::new(0),
            branch: Cell::new(Branch::Free),
            margin: Cell::new(0.0),
        }
    }

    pub(crate) fn scene(&self) -> &'a Scene<S, N> {
        self.scene
    }

    /// f(t, x).
    #[inline]
    pub(crate) fn rate(&self, time: f64, state: &SVector<f64, N>) -> SVector<f64, N> {
        self.rates.set(self.rates.get() + 1);
        self.watch();
        let rate = self.scene.system.rate(time, state, [self.branch.get()]);
        if rate.iter().all(|value| value.is_finite()) {
            return rate;
        }
        // A trial step far beyond a reversal, near the pole of a locked branch: our own methods
        // reject it, these would carry NaN on.
        self.scene.system.rate(time, state, [Branch::Free])
    }

    /// ∂f/∂x.
    #[inline]
    pub(crate) fn jacobian(&self, time: f64, state: &SVector<f64, N>) -> SMatrix<f64, N, N> {
        self.jacobians.set(self.jacobians.get() + 1);
        self.watch();
        let of = |branch| {
            let tangent = self.scene.system.linearised(time, state, [branch]);
            // Every scene of the list has one.
            tangent.map_or_else(|| SMatrix::repeat(f64::NAN), |tangent| tangent.by_state)
        };
        let jacobian = of(self.branch.get());
        let usable = jacobian.iter().all(|value| value.is_finite());
        if usable { jacobian } else { of(Branch::Free) }
    }

    /// The same right-hand side for y = x/scales, for codes that know only one absolute tolerance.
    #[inline]
    pub(crate) fn scaled_rate(&self, time: f64, state: &SVector<f64, N>) -> SVector<f64, N> {
        let scales = &self.scene.scales;
        self.rate(time, &state.component_mul(scales)).component_div(scales)
    }

    /// The Jacobian for y = x/scales.
    #[inline]
    pub(crate) fn scaled_jacobian(&self, time: f64, state: &SVector<f64, N>) -> SMatrix<f64, N, N> {
        let scales = &self.scene.scales;
        let jacobian = self.jacobian(time, &state.component_mul(scales));
        SMatrix::from_fn(|i, j| jacobian[(i, j)] * scales[j] / scales[i])
    }

    /// The speed [m/s] on the locked branch and a margin, whose zero ends the piece. With the
    /// margin it is clearly positive where the next piece begins.
    pub(crate) fn reversal(&self, time: f64, state: &SVector<f64, N>) -> f64 {
        let [velocity] = self.scene.system.sliding_velocities(time, state);
        self.branch.get().of(velocity).speed() + self.margin.get()
    }

    /// Locks |v| to the direction into which the motion goes from a state.
    pub(crate) fn lock(&self, time: f64, state: &SVector<f64, N>, tolerance: f64) {
        let velocity = |time, state: &_| self.scene.system.sliding_velocities(time, state)[0];
        // What the tolerance leaves of the velocity, to a hundredth, and what rounding does.
        let part = velocity(time, &(state + self.scene.scales)) - velocity(time, state);
        self.margin.set(MARGIN * tolerance * part.abs() + 1e-10);
        let step = 1e-9 * self.scene.end;
        let after = velocity(time + step, &(state + self.rate(time, state) * step));
        self.branch.set(Branch::towards(after));
        if self.branch.get() == Branch::Free {
            self.branch.set(Branch::Forward);
        }
    }

    /// Locks |v| to the other direction.
    pub(crate) fn reverse(&self) {
        self.branch.set(self.branch.get().reversed());
    }

    pub(crate) fn free(&self) {
        self.branch.set(Branch::Free);
    }

    pub(crate) fn rates(&self) -> u64 {
        self.rates.get()
    }

    pub(crate) fn jacobians(&self) -> u64 {
        self.jacobians.get()
    }

    /// The scene from kink to kink of its input, to be integrated one after the other.
    pub(crate) fn legs(&self) -> Vec<Leg> {
        let Scene { system, end, .. } = self.scene;
        let mut legs = Vec::new();
        let mut samples = (1..SAMPLES).map(|i| sample_time(i, *end)).peekable();
        let mut start = 0.0;
        while start < *end {
            let stop = system.next_kink(start, *end).unwrap_or(*end);
            let mut times = Vec::new();
            while let Some(time) = samples.next_if(|&time| time <= stop) {
                times.push(time);
            }
            let ends_between_samples = times.last() != Some(&stop);
            if ends_between_samples {
                times.push(stop);
            }
            legs.push(Leg { start, end: stop, times, ends_between_samples });
            start = stop;
        }
        legs
    }

    #[inline]
    fn watch(&self) {
        let spent = self.rates.get() + self.jacobians.get();
        if spent.is_multiple_of(BETWEEN_LOOKS) {
            self.look(spent);
        }
    }

    #[cold]
    fn look(&self, spent: u64) {
        if spent >= MOST_EVALUATIONS {
            resume_unwind(Box::new(Spent::Evaluations));
        }
        if self.start.elapsed() > LONGEST_RUN {
            resume_unwind(Box::new(Spent::Time));
        }
    }
}

/// The time [s] of an output sample.
pub(crate) fn sample_time(index: usize, end: f64) -> f64 {
    if index + 1 == SAMPLES { end } else { end * index as f64 / (SAMPLES - 1) as f64 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::{Visitor, each};

    /// Every output sample after the first, leg by leg, and where the legs end.
    struct Legs(Vec<(String, Vec<f64>)>);

    impl Visitor for Legs {
        fn visit<S: System<f64, N> + Clone, const N: usize>(&mut self, scene: &Scene<S, N>) {
            let legs = Field::new(scene).legs();
            let samples: Vec<f64> = legs
                .iter()
                .flat_map(|leg| {
                    &leg.times[..leg.times.len() - usize::from(leg.ends_between_samples)]
                })
                .copied()
                .collect();
            let expected: Vec<f64> = (1..SAMPLES).map(|i| sample_time(i, scene.end)).collect();
            assert_eq!(samples, expected, "{}", scene.name);
            assert!(legs.iter().all(|leg| leg.times.last() == Some(&leg.end)), "{}", scene.name);
            self.0.push((scene.name.to_owned(), legs.iter().map(|leg| leg.end).collect()));
        }
    }

    #[test]
    fn legs_end_at_kinks_of_the_input_and_miss_no_sample() -> Result<(), bristle::ParameterError> {
        let mut legs = Legs(Vec::new());
        each(&mut legs)?;
        for (name, ends) in legs.0 {
            // The ramp reaches its upper end after 100 s, between two samples; a sine has no kink.
            let expected = if name == "S2_ramp" { 2 } else { 1 };
            assert_eq!(ends.len(), expected, "{name}: {ends:?}");
            assert!(expected == 1 || ends[0] == 100.0, "{name}: {ends:?}");
        }
        Ok(())
    }
}
