//! RODAS: a stiffly accurate, L-stable Rosenbrock method of order 4 with an embedded estimate of
//! order 3, six stages and a dense output of order 3.
//!
//! Source: E. Hairer, G. Wanner, "Solving Ordinary Differential Equations II", 2nd edition
//! (Springer, 1996), section IV.7, and their program of the same name.

use super::rosenbrock::{Rosenbrock, RosenbrockTableau};
use super::stepper::OneStep;
use super::storage::States;
use super::tolerance::ToleranceRange;
use crate::Scalar;

/// The L-stable Rosenbrock method RODAS of order 4(3), for stiff systems and moderate tolerances.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Rodas4;

impl<T: Scalar, V: States<T>> OneStep<T, V> for Rodas4 {
    type Stepper = Rosenbrock<Self, T, V, 6>;

    fn stepper(&self, _tolerance: f64, state: &V) -> Self::Stepper {
        Rosenbrock::new(state)
    }

    fn tolerance_range(&self) -> ToleranceRange {
        ToleranceRange::ROSENBROCK
    }
}

#[rustfmt::skip] // Several coefficients a line.
impl RosenbrockTableau for Rodas4 {
    const GAMMA: f64 = 0.25;
    const TIMES: &'static [f64] = &[0.0, 0.386, 0.21, 0.63, 1.0, 1.0];
    const TIME_WEIGHTS: &'static [f64] = &[0.25, -0.1043, 0.1035, -0.036_200_000_000_000_23];
    const WEIGHTS: &'static [&'static [f64]] = &[
        &[],
        &[1.544],
        &[0.946_678_528_081_582_6, 0.255_701_169_898_328_4],
        &[3.314_825_187_068_521, 2.896_124_015_972_201, 0.998_641_913_997_781_7],
        &[
            1.221_224_509_226_641, 6.019_134_481_288_629, 12.537_083_329_320_87,
            -0.687_886_036_105_895_0,
        ],
    ];
    const COUPLING: &'static [&'static [f64]] = &[
        &[],
        &[-5.6688],
        &[-2.430_093_356_833_875, -0.206_359_915_709_191_5],
        &[-0.107_352_905_815_137_5, -9.594_562_251_023_355, -20.470_286_148_096_16],
        &[
            7.496_443_313_967_647, -10.246_804_314_643_52, -33.999_903_528_199_05,
            11.708_908_932_061_60,
        ],
        &[
            8.083_246_795_921_522, -7.981_132_988_064_893, -31.521_594_328_743_71,
            16.319_305_431_231_36, -6.058_818_238_834_054,
        ],
    ];
    const EXTENSION: &'static [&'static [f64]] = &[
        &[
            10.126_235_083_445_86, -7.487_995_877_610_167, -34.800_918_615_557_47,
            -7.992_771_707_568_823, 1.025_137_723_295_662,
        ],
        &[
            -0.676_280_339_280_125_3, 6.087_714_651_680_015, 16.430_843_208_924_78,
            24.767_225_114_183_86, -6.594_389_125_716_872,
        ],
    ];
    const ERROR_ORDER: u8 = 4;
}

#[cfg(test)]
mod tests {
    use super::Rodas4;
    use crate::ode::rosenbrock::laws;

    #[test]
    fn the_stages_lie_where_their_weights_say() {
        laws::times::<Rodas4>();
    }

    #[test]
    fn the_solution_meets_every_condition_up_to_order_four_and_no_further() {
        laws::order::<Rodas4>(4);
    }

    #[test]
    fn the_error_estimate_vanishes_up_to_order_three_and_no_further() {
        laws::estimate::<Rodas4>(3);
    }

    #[test]
    fn the_method_is_stiffly_accurate() {
        laws::stiff_accuracy::<Rodas4>();
    }

    #[test]
    fn the_dense_output_meets_every_condition_up_to_order_three_within_the_step() {
        laws::extension::<Rodas4>(3);
    }
}
