//! The classical Runge–Kutta method of order 4.
//!
//! Source: W. Kutta, "Beitrag zur näherungsweisen Integration totaler Differentialgleichungen",
//! Zeitschrift für Mathematik und Physik 46 (1901), 435–453.

use nalgebra::SVector;

use super::explicit::{Explicit, ExplicitTableau};
use super::stepper::OneStep;
use super::storage::States;
use super::system::System;
use crate::scalar::lit;
use crate::{Branch, Scalar};

/// The classical Runge–Kutta method of order 4, for fixed steps.
///
/// [`RungeKutta4::step`] is the bare step of four evaluations, for a loop of fixed cost. With
/// [`Solver::fixed`](super::Solver::fixed) the method also splits its step at each reversal, which
/// restores the order that the kink of |v| costs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RungeKutta4;

impl<T: Scalar, V: States<T>> OneStep<T, V> for RungeKutta4 {
    type Stepper = Explicit<Self, T, V, 5>;

    fn stepper(&self, _tolerance: f64, state: &V) -> Self::Stepper {
        Explicit::new(state)
    }
}

impl ExplicitTableau for RungeKutta4 {
    const STAGES: usize = 4;
    const TIMES: &'static [f64] = &[0.0, 0.5, 0.5, 1.0, 1.0];
    const WEIGHTS: &'static [&'static [f64]] = &[
        &[],
        &[0.5],
        &[0.0, 0.5],
        &[0.0, 0.0, 1.0],
        &[1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0],
    ];
    const ERROR_ORDER: u8 = 4;
    const REAL_LIMIT: f64 = 2.785;
}

impl RungeKutta4 {
    /// One bare step of length h from (t, x), with |v| as it is: four evaluations, whatever
    /// happens to the sliding direction.
    ///
    /// ```
    /// use bristle::Branch;
    /// use bristle::ode::{RungeKutta4, System};
    /// use bristle::nalgebra::Vector1;
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
    pub fn step<T: Scalar, S: System<T, N, K>, const N: usize, const K: usize>(
        system: &S,
        time: T,
        state: &SVector<T, N>,
        step: T,
    ) -> SVector<T, N> {
        let rate = |time, state: &SVector<T, N>| system.rate(time, state, [Branch::Free; K]);
        let [half, third, sixth]: [T; 3] = [0.5, 1.0 / 3.0, 1.0 / 6.0].map(lit);
        // In the order of the tableau's sums, so that a plain solver gives the same bits.
        let k1 = rate(time, state);
        let k2 = rate(time + step * half, &(state + k1 * half * step));
        let k3 = rate(time + step * half, &(state + k2 * half * step));
        let k4 = rate(time + step, &(state + k3 * step));
        state + (k1 * sixth + k2 * third + k3 * third + k4 * sixth) * step
    }
}

#[cfg(test)]
mod tests {
    use super::RungeKutta4;
    use crate::ode::explicit::laws;

    #[test]
    fn the_tableau_is_consistent_and_of_order_four() {
        laws::times::<RungeKutta4>(1e-15);
        laws::order::<RungeKutta4>(4, 1e-15, 1e-3);
    }
}
