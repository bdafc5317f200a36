//! The Dormand–Prince method of order 5 with an embedded estimate of order 4.
//!
//! Seven stages, of which the last is the first of the next step, and a dense output of order 4.
//!
//! Sources: J. R. Dormand, P. J. Prince, "A family of embedded Runge–Kutta formulae", Journal of
//! Computational and Applied Mathematics 6 (1980), 19–26; the dense output is that of E. Hairer,
//! S. P. Nørsett, G. Wanner, "Solving Ordinary Differential Equations I", 2nd edition (Springer,
//! 1993), section II.6.

use super::explicit::{Explicit, ExplicitTableau};
use super::stepper::OneStep;
use super::storage::States;
use crate::Scalar;

/// The Dormand–Prince method of order 5(4).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DormandPrince;

impl<T: Scalar, V: States<T>> OneStep<T, V> for DormandPrince {
    type Stepper = Explicit<Self, T, V, 7>;

    fn stepper(&self, _tolerance: f64, state: &V) -> Self::Stepper {
        Explicit::new(state)
    }
}

#[rustfmt::skip] // Several coefficients a line.
impl ExplicitTableau for DormandPrince {
    const STAGES: usize = 6;
    const TIMES: &'static [f64] = &[0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0];
    const WEIGHTS: &'static [&'static [f64]] = &[
        &[],
        &[1.0 / 5.0],
        &[3.0 / 40.0, 9.0 / 40.0],
        &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
        &[19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0],
        &[9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0],
        &[35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
    ];
    /// The solution of order 5 less that of order 4.
    const ERROR: &'static [f64] = &[
        71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339_200.0, 22.0 / 525.0,
        -1.0 / 40.0,
    ];
    /// The solution less the mean of the rates at both ends: of a kink between them it sees h²
    /// whatever its place.
    const COARSE_ERROR: &'static [f64] = &[
        35.0 / 384.0 - 0.5, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0, -0.5,
    ];
    const COARSE_ORDER: i32 = 3;
    const ERROR_ORDER: u8 = 5;
    const EXTENSION: &'static [&'static [f64]] = &[&[
        -12_715_105_075.0 / 11_282_082_432.0, 0.0, 87_487_479_700.0 / 32_700_410_799.0,
        -10_690_763_975.0 / 1_880_347_072.0, 701_980_252_875.0 / 199_316_789_632.0,
        -1_453_857_185.0 / 822_651_844.0, 69_997_945.0 / 29_380_423.0,
    ]];
    const REAL_LIMIT: f64 = 3.3;
}

#[cfg(test)]
mod tests {
    use super::{DormandPrince, ExplicitTableau};
    use crate::ode::explicit::laws;

    #[test]
    fn the_stages_lie_where_their_weights_say() {
        laws::times::<DormandPrince>(4e-15);
    }

    #[test]
    fn the_solution_meets_every_condition_up_to_order_five_and_no_further() {
        laws::order::<DormandPrince>(5, 4e-15, 1e-5);
    }

    #[test]
    fn the_error_estimate_vanishes_up_to_order_four_and_no_further() {
        laws::estimate::<DormandPrince>(DormandPrince::ERROR, 4);
        laws::estimate::<DormandPrince>(DormandPrince::COARSE_ERROR, 2);
    }

    #[test]
    fn the_dense_output_meets_every_condition_up_to_order_four_within_the_step() {
        laws::extension::<DormandPrince>(4, 1e-14);
    }
}
