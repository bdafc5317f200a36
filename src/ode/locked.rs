//! The system as a method sees it: on locked branches, between two kinks of its inputs, counted.

use nalgebra::{SMatrix, SVector};

use super::stepper::{Field, Point};
use super::{Linearisation, Statistics, System};
use crate::scalar::lit;
use crate::{Branch, Scalar};

/// The earliest and the latest time of a smooth stretch \[s\].
pub(super) type Interval<T> = (T, T);

/// The system on its locked branches, with the evaluations counted.
pub(super) struct Locked<'a, T, S, const N: usize, const K: usize> {
    pub(super) system: &'a S,
    /// Typical magnitudes of the states, asked for once a run.
    pub(super) scales: &'a SVector<T, N>,
    pub(super) branches: [Branch; K],
    /// Times are cut to these, so that no stage looks beyond a kink.
    pub(super) interval: Interval<T>,
    pub(super) statistics: &'a mut Statistics,
}

impl<T: Scalar, S, const N: usize, const K: usize> Locked<'_, T, S, N, K> {
    #[inline(always)]
    fn within(&self, time: T) -> T {
        let (earliest, latest) = self.interval;
        time.larger(earliest).smaller(latest)
    }
}

impl<T: Scalar, S: System<T, N, K>, const N: usize, const K: usize> Field<T, N>
    for Locked<'_, T, S, N, K>
{
    #[inline(always)]
    fn rate(&mut self, time: T, state: &SVector<T, N>) -> SVector<T, N> {
        self.statistics.evaluations += 1;
        self.system.rate(self.within(time), state, self.branches)
    }

    #[inline(always)]
    fn linearised(&mut self, time: T, state: &SVector<T, N>) -> Linearisation<T, N> {
        self.statistics.jacobians += 1;
        match self.system.linearised(self.within(time), state, self.branches) {
            Some(tangent) => tangent,
            None => self.differences(time, state),
        }
    }

    #[inline(always)]
    fn jacobian(&mut self, point: &Point<T, N>) -> SMatrix<T, N, N> {
        self.statistics.jacobians += 1;
        let time = self.within(point.time);
        match self.system.linearised(time, &point.state, self.branches) {
            Some(tangent) => tangent.by_state,
            None => self.differences_of_states(point.time, &point.state, &point.rate),
        }
    }
}

impl<T: Scalar, S: System<T, N, K>, const N: usize, const K: usize> Locked<'_, T, S, N, K> {
    /// The derivatives by one-sided differences of √ε ≈ 10⁻⁸ of each state's magnitude: half of the
    /// digits are lost.
    #[cold]
    fn differences(&mut self, time: T, state: &SVector<T, N>) -> Linearisation<T, N> {
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
        let by_time = (self.rate(later, state) - rate) / (later - time);
        let known = by_time.iter().all(|change| change.is_finite());
        Linearisation { rate, by_state, by_time: if known { by_time } else { SVector::zeros() } }
    }

    /// ∂f/∂x at a point with its rate.
    fn differences_of_states(
        &mut self,
        time: T,
        state: &SVector<T, N>,
        rate: &SVector<T, N>,
    ) -> SMatrix<T, N, N> {
        let part = T::default_epsilon().sqrt();
        let mut by_state = SMatrix::<T, N, N>::zeros();
        for j in 0..N {
            let reach = part * self.scales[j].abs().larger(state[j].abs());
            // The other side where the field ends.
            for reach in [reach, -reach] {
                let mut beside = *state;
                beside[j] += reach;
                // What was added after rounding.
                let apart = beside[j] - state[j];
                let change = (self.rate(time, &beside) - rate) / apart;
                by_state.set_column(j, &change);
                if change.iter().all(|change| change.is_finite()) {
                    break;
                }
            }
        }
        by_state
    }
}
