//! The classical Runge–Kutta method of order 4.
//!
//! Source: W. Kutta, "Beitrag zur näherungsweisen Integration totaler Differentialgleichungen",
//! Zeitschrift für Mathematik und Physik 46 (1901), 435–453.

use nalgebra::SVector;

use super::method::{Attempt, Field, Method, Point};
use super::system::System;
use crate::scalar::lit;
use crate::stability::Scheme;
use crate::{Branch, Scalar};

/// The classical Runge–Kutta method of order 4, for fixed steps.
///
/// [`RungeKutta4::step`] is the bare step of four evaluations and no more, for a loop of fixed
/// cost; with [`Solver::fixed`](super::Solver::fixed) the method also splits its step at each
/// reversal, which restores the full order that the kink of |v| costs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RungeKutta4;

impl RungeKutta4 {
    /// One bare step of length h from (t, x), with |v| as it is: four evaluations, whatever
    /// happens to the sliding direction.
    ///
    /// ```
    /// use bristle::Branch;
    /// use bristle::ode::{RungeKutta4, System};
    /// use nalgebra::Vector1;
    ///
    /// struct Decay;
    /// impl System<f64, 1, 0> for Decay {
    ///     fn rate(&self, _: f64, x: &Vector1<f64>, _: [Branch; 0]) -> Vector1<f64> {
    ///         -x
    ///     }
    ///     fn sliding_velocities(&self, _: f64, _: &Vector1<f64>) -> [f64; 0] {
    ///         []
    ///     }
    /// }
    /// let x = RungeKutta4::step(&Decay, 0.0, &Vector1::new(1.0), 0.1);
    /// assert!((x[0] - (-0.1f64).exp()).abs() < 1e-7);
    /// ```
    #[inline]
    pub fn step<T, S, const N: usize, const K: usize>(
        system: &S,
        time: T,
        state: &SVector<T, N>,
        step: T,
    ) -> SVector<T, N>
    where
        T: Scalar,
        S: System<T, N, K>,
    {
        let rate = |time, state: &SVector<T, N>| system.rate(time, state, [Branch::Free; K]);
        advance(rate, time, state, rate(time, state), step)
    }
}

/// The state after a step, from the rate at its start.
#[inline]
fn advance<T: Scalar, const N: usize>(
    mut rate: impl FnMut(T, &SVector<T, N>) -> SVector<T, N>,
    time: T,
    state: &SVector<T, N>,
    k1: SVector<T, N>,
    step: T,
) -> SVector<T, N> {
    let half = step * lit(0.5);
    let k2 = rate(time + half, &(state + k1 * half));
    let k3 = rate(time + half, &(state + k2 * half));
    let k4 = rate(time + step, &(state + k3 * step));
    state + (k1 + (k2 + k3) * lit::<T>(2.0) + k4) * (step / lit(6.0))
}

impl<T: Scalar, const N: usize> Method<T, N> for RungeKutta4 {
    type Memory = ();

    fn scheme(&self) -> Option<Scheme> {
        Some(Scheme::RungeKutta4)
    }

    fn memory(&self) {}

    #[inline]
    fn attempt<F: Field<T, N>>(
        &self,
        _memory: &mut (),
        field: &mut F,
        from: &Point<T, N>,
        step: T,
    ) -> Attempt<T, N> {
        let state = advance(|t, x| field.rate(t, x), from.time, &from.state, from.rate, step);
        Attempt { state, error: SVector::zeros(), coarse_error: None, order: 1 }
    }
}
