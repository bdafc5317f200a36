//! The system as a method sees it: on locked branches, between two kinks of its inputs, counted.

use super::Statistics;
use super::stepper::{Field, Point};
use super::storage::{Entries, States};
use super::system::{Equations, Linearisation};
use crate::scalar::lit;
use crate::{Branch, Scalar};

/// The earliest and the latest time of a smooth stretch \[s\].
pub(super) type Interval<T> = (T, T);

/// The system on its locked branches, with the evaluations counted.
pub(super) struct Locked<'a, T: Scalar, V: States<T>, S: Equations<T, V, K> + ?Sized, K> {
    pub(super) system: &'a S,
    /// Typical magnitudes of the states, asked for once a run.
    pub(super) scales: &'a V,
    pub(super) branches: &'a S::Contacts<Branch>,
    /// Times are cut to these, so that no stage looks beyond a kink.
    pub(super) interval: Interval<T>,
    pub(super) statistics: &'a mut Statistics,
}

impl<T: Scalar, V: States<T>, S: Equations<T, V, K> + ?Sized, K> Field<T, V>
    for Locked<'_, T, V, S, K>
{
    #[inline(always)]
    fn rate_to(&mut self, time: T, state: &V, rate: &mut V) {
        self.statistics.evaluations += 1;
        self.system.rate_to(self.within(time), state, self.branches, rate);
    }

    #[inline(always)]
    fn linearised(&mut self, time: T, state: &V) -> Linearisation<V, V::Matrix> {
        self.statistics.jacobians += 1;
        match self.system.tangent(self.within(time), state, self.branches) {
            Some(tangent) => tangent,
            None => self.differences(time, state),
        }
    }

    #[inline(always)]
    fn jacobian(&mut self, point: &Point<T, V>) -> V::Matrix {
        self.statistics.jacobians += 1;
        let time = self.within(point.time);
        match self.system.tangent(time, &point.state, self.branches) {
            Some(tangent) => tangent.by_state,
            None => self.differences_of_states(point.time, &point.state, &point.rate),
        }
    }
}

impl<T: Scalar, V: States<T>, S: Equations<T, V, K> + ?Sized, K> Locked<'_, T, V, S, K> {
    #[inline(always)]
    fn within(&self, time: T) -> T {
        let (earliest, latest) = self.interval;
        time.larger(earliest).smaller(latest)
    }

    /// The derivatives by one-sided differences of √ε ≈ 10⁻⁸ of each state's magnitude: half of the
    /// digits are lost.
    #[cold]
    fn differences(&mut self, time: T, state: &V) -> Linearisation<V, V::Matrix> {
        let part = T::default_epsilon().sqrt();
        let rate = self.rate(time, state);
        let by_state = self.differences_of_states(time, state, &rate);
        // Towards the side on which there is room, and nowhere if there is none.
        let (earliest, latest) = self.interval;
        let room = if latest - time > time - earliest { latest } else { earliest };
        let reach = part * time.abs().larger((latest - earliest).abs());
        let most = (room - time) * lit(0.5);
        let apart = if most > reach { reach } else { most.larger(-reach) };
        let later = time + apart;
        let mut by_time = self.rate(later, state);
        for i in 0..state.count() {
            by_time[i] = (by_time[i] - rate[i]) / (later - time);
        }
        if !by_time.is_finite() {
            by_time = state.like(|_| T::zero());
        }
        Linearisation { rate, by_state, by_time }
    }

    /// ∂f/∂x at a point, times a vector and a factor: by one difference along it, of √ε of the
    /// states' magnitudes.
    pub(super) fn along(&mut self, point: &Point<T, V>, x: &V, factor: T) -> V {
        let state = &point.state;
        let sizes = state.like(|i| self.scales[i].abs().larger(state[i].abs()));
        let reach = T::default_epsilon().sqrt() / x.over(&sizes);
        if !reach.is_finite() {
            return x.like(|_| T::zero());
        }
        let beside = state.with(x, |state, x| state + x * reach);
        let changed = self.rate(point.time, &beside);
        changed.with(&point.rate, |changed, rate| (changed - rate) * (factor / reach))
    }

    /// ∂f/∂x at a point with its rate.
    fn differences_of_states(&mut self, time: T, state: &V, rate: &V) -> V::Matrix {
        let part = T::default_epsilon().sqrt();
        let mut by_state = state.matrix();
        let (mut beside, mut changed) = (state.clone(), state.clone());
        let columns = by_state.entries_mut().chunks_exact_mut(state.count().max(1));
        for (j, column) in columns.enumerate() {
            let reach = part * self.scales[j].abs().larger(state[j].abs());
            // The other side where the field ends.
            for reach in [reach, -reach] {
                beside[j] = state[j] + reach;
                // What was added after rounding.
                let apart = beside[j] - state[j];
                self.rate_to(time, &beside, &mut changed);
                let rates = changed.entries().iter().zip(rate.entries());
                for (entry, (&changed, &rate)) in column.iter_mut().zip(rates) {
                    *entry = (changed - rate) / apart;
                }
                if column.iter().all(|change| change.is_finite()) {
                    break;
                }
            }
            beside[j] = state[j];
        }
        by_state
    }
}
