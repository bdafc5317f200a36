//! The Dormand–Prince method of order 5 with an embedded estimate of order 4.
//!
//! Seven stages, of which the last is the first of the next step, and a continuous extension of
//! order 4.
//!
//! Sources: J. R. Dormand, P. J. Prince, "A family of embedded Runge–Kutta formulae", Journal of
//! Computational and Applied Mathematics 6 (1980), 19–26; the extension is that of E. Hairer,
//! S. P. Nørsett, G. Wanner, "Solving Ordinary Differential Equations I", 2nd edition (Springer,
//! 1993), section II.6.

use nalgebra::SVector;

use super::curve::Curve;
use super::method::{Attempt, Embedded, Field, Method, Point, along, combine};
use crate::Scalar;
use crate::scalar::lit;
use crate::stability::Scheme;

/// The Dormand–Prince method of order 5(4).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DormandPrince;

/// Times of the stages.
const C: [f64; 7] = [0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0];

/// Weights of the earlier stages in each; the last row is also the solution.
const A: [[f64; 6]; 7] = [
    [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
    [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];

/// Weights of the error estimate: the solution of order 5 less that of order 4.
const E: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339_200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

/// Weights of the quartic term of the continuous extension.
const D: [f64; 7] = [
    -12_715_105_075.0 / 11_282_082_432.0,
    0.0,
    87_487_479_700.0 / 32_700_410_799.0,
    -10_690_763_975.0 / 1_880_347_072.0,
    701_980_252_875.0 / 199_316_789_632.0,
    -1_453_857_185.0 / 822_651_844.0,
    69_997_945.0 / 29_380_423.0,
];

impl Embedded for DormandPrince {}

/// The stages k₁ … k₇ of the last trial, and the state at its sixth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stages<T, const N: usize> {
    pub(super) k: [SVector<T, N>; 7],
    /// The state at which k₆ was evaluated: at the end of the step, as is k₇'s.
    pub(super) sixth: SVector<T, N>,
}

impl<T: Scalar, const N: usize> Method<T, N> for DormandPrince {
    type Memory = Stages<T, N>;

    fn scheme(&self) -> Option<Scheme> {
        Some(Scheme::DormandPrince)
    }

    fn memory(&self) -> Self::Memory {
        Stages { k: [SVector::zeros(); 7], sixth: SVector::zeros() }
    }

    #[inline]
    fn attempt<F: Field<T, N>>(
        &self,
        stages: &mut Self::Memory,
        field: &mut F,
        from: &Point<T, N>,
        step: T,
    ) -> Attempt<T, N> {
        let Stages { k, sixth } = stages;
        k[0] = from.rate;
        let x = &from.state;
        let time = |stage: usize| from.time + step * lit::<T>(C[stage]);
        k[1] = field.rate(time(1), &along(x, step, k, &A[1], [0]));
        k[2] = field.rate(time(2), &along(x, step, k, &A[2], [0, 1]));
        k[3] = field.rate(time(3), &along(x, step, k, &A[3], [0, 1, 2]));
        k[4] = field.rate(time(4), &along(x, step, k, &A[4], [0, 1, 2, 3]));
        *sixth = along(x, step, k, &A[5], [0, 1, 2, 3, 4]);
        k[5] = field.rate(time(5), sixth);
        let state = along(x, step, k, &A[6], [0, 2, 3, 4, 5]);
        k[6] = field.rate(from.time + step, &state);
        let error = combine(&stages.k, &E, USED) * step;
        Attempt { state, error, coarse_error: None, order: 5 }
    }

    #[inline]
    fn arrive<F: Field<T, N>>(
        &self,
        stages: &mut Self::Memory,
        _field: &mut F,
        end: &mut Point<T, N>,
    ) {
        end.rate = stages.k[6];
    }

    fn curve<F: Field<T, N>>(
        &self,
        stages: &Self::Memory,
        _field: &mut F,
        from: &Point<T, N>,
        end: &Point<T, N>,
    ) -> Curve<T, N> {
        let quartic = combine(&stages.k, &D, USED) * (end.time - from.time);
        Curve::hermite(from, end).with(quartic)
    }
}

/// The stages that the error estimate and the continuous extension use.
const USED: [usize; 6] = [0, 2, 3, 4, 5, 6];

#[cfg(test)]
mod tests {
    use super::{A, C, D, E};
    use crate::ode::trees::{RungeKutta, trees};

    /// The tableau, its last row that of the solution.
    fn method() -> RungeKutta {
        RungeKutta { a: A.iter().map(|row| row.to_vec()).collect() }
    }

    #[test]
    fn the_stages_lie_where_their_weights_say() {
        for (row, c) in A.iter().zip(C) {
            assert!((row.iter().sum::<f64>() - c).abs() < 4e-15);
        }
    }

    #[test]
    fn the_solution_meets_every_condition_up_to_order_five() {
        for tree in trees(5) {
            let defect = method().weighted(&tree, &A[6]) - 1.0 / tree.density();
            assert!(defect.abs() < 4e-15, "{tree:?}: {defect}");
        }
    }

    #[test]
    fn the_error_estimate_vanishes_up_to_order_four_and_not_at_five() {
        for tree in trees(4) {
            let defect = method().weighted(&tree, &E);
            assert!(defect.abs() < 4e-15, "{tree:?}: {defect}");
        }
        let fifth = trees(5).into_iter().filter(|tree| tree.order() == 5);
        let greatest = fifth.map(|tree| method().weighted(&tree, &E).abs()).fold(0.0, f64::max);
        assert!(greatest > 1e-5);
    }

    #[test]
    fn the_continuous_extension_meets_every_condition_up_to_order_four_within_the_step() {
        // A tree of order ρ needs Σ bᵢ(θ) Φᵢ = θ^ρ/γ.
        for theta in [0.1, 0.37, 0.5, 0.9] {
            for tree in trees(4) {
                let got = method().extended(&tree, theta, &A[6], 6, &[&D]);
                let want = theta.powi(tree.order() as i32) / tree.density();
                assert!((got - want).abs() < 1e-14, "{theta} {tree:?}: {}", got - want);
            }
        }
    }
}
