//! The Dormand–Prince method of order 8 with embedded estimates of orders 5 and 3.
//!
//! Twelve stages, and three more for a dense output of order 7 where it is asked for. The error is
//! |e₅|²/√(|e₅|² + 0.01|e₃|²), which behaves as h⁸. That is so on smooth steps, where |e₅|/|e₃|
//! behaves as h². Where it is ten times what the step before lets expect, the step is rough, and
//! its error is the larger of |e₅| and |e₃|/10.
//!
//! Sources: J. R. Dormand, P. J. Prince, "High order embedded Runge–Kutta formulae", Journal of
//! Computational and Applied Mathematics 7 (1981), 67–75; E. Hairer, S. P. Nørsett, G. Wanner,
//! "Solving Ordinary Differential Equations I", 2nd edition (Springer, 1993), sections II.5 and
//! II.10, and their program DOP853.

use super::explicit::{Explicit, ExplicitTableau};
use super::stepper::OneStep;
use super::storage::States;
use crate::Scalar;

/// The Dormand–Prince method of order 8(5,3), for tight tolerances.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DormandPrince8;

impl<T: Scalar, V: States<T>> OneStep<T, V> for DormandPrince8 {
    type Stepper = Explicit<Self, T, V, 16>;

    fn stepper(&self, _tolerance: f64, state: &V) -> Self::Stepper {
        Explicit::new(state)
    }
}

#[rustfmt::skip] // Several coefficients a line.
impl ExplicitTableau for DormandPrince8 {
    const STAGES: usize = 12;
    const TIMES: &'static [f64] = &[
        0.0, 0.052_600_151_958_767_73, 0.078_900_227_938_151_6, 0.118_350_341_907_227_4,
        0.281_649_658_092_772_6, 0.333_333_333_333_333_3, 0.25, 0.307_692_307_692_307_7,
        0.651_282_051_282_051_3, 0.6, 0.857_142_857_142_857_1, 1.0, 1.0, 0.1, 0.2,
        0.777_777_777_777_777_8,
    ];
    const WEIGHTS: &'static [&'static [f64]] = &[
        &[],
        &[0.052_600_151_958_767_73],
        &[0.019_725_056_984_537_9, 0.059_175_170_953_613_7],
        &[0.029_587_585_476_806_85, 0.0, 0.088_762_756_430_420_54],
        &[0.241_365_134_159_266_7, 0.0, -0.884_549_479_328_286_1, 0.924_834_003_261_792],
        &[
            0.037_037_037_037_037_035, 0.0, 0.0, 0.170_828_608_729_473_86,
            0.125_467_687_566_822_42,
        ],
        &[
            0.037_109_375, 0.0, 0.0, 0.170_252_211_019_544_05, 0.060_216_538_980_455_96,
            -0.017_578_125,
        ],
        &[
            0.037_092_000_118_504_79, 0.0, 0.0, 0.170_383_925_712_239_98,
            0.107_262_030_446_373_28, -0.015_319_437_748_624_402, 0.008_273_789_163_814_023,
        ],
        &[
            0.624_110_958_716_075_7, 0.0, 0.0, -3.360_892_629_446_941_4, -0.868_219_346_841_726,
            27.592_099_699_446_71, 20.154_067_550_477_894, -43.489_884_181_069_96,
        ],
        &[
            0.477_662_536_438_264_34, 0.0, 0.0, -2.488_114_619_971_667_7, -0.590_290_826_836_843,
            21.230_051_448_181_193, 15.279_233_632_882_423, -33.288_210_968_984_86,
            -0.020_331_201_708_508_627,
        ],
        &[
            -0.937_142_430_085_987_3, 0.0, 0.0, 5.186_372_428_844_064, 1.091_437_348_996_729_5,
            -8.149_787_010_746_927, -18.520_065_659_996_96, 22.739_487_099_350_505,
            2.493_605_552_679_652_3, -3.046_764_471_898_219_6,
        ],
        &[
            2.273_310_147_516_538, 0.0, 0.0, -10.534_495_466_737_25, -2.000_872_058_224_862_5,
            -17.958_931_863_118_8, 27.948_884_529_419_96, -2.858_998_277_135_023_5,
            -8.872_856_933_530_63, 12.360_567_175_794_303, 0.643_392_746_015_763_6,
        ],
        &[
            0.054_293_734_116_568_765, 0.0, 0.0, 0.0, 0.0, 4.450_312_892_752_409,
            1.891_517_899_314_500_3, -5.801_203_960_010_585, 0.311_164_366_957_819_9,
            -0.152_160_949_662_516_1, 0.201_365_400_804_030_34, 0.044_710_615_727_772_59,
        ],
        &[
            0.056_167_502_283_047_954, 0.0, 0.0, 0.0, 0.0, 0.0, 0.253_500_210_216_624_83,
            -0.246_239_037_470_802_5, -0.124_191_423_263_816_37, 0.153_291_798_278_765_68,
            0.008_201_052_295_634_69, 0.007_567_897_660_545_699, -0.008_298,
        ],
        &[
            0.031_834_648_163_502_14, 0.0, 0.0, 0.0, 0.0, 0.028_300_909_672_366_776,
            0.053_541_988_307_438_566, -0.054_923_748_571_390_99, 0.0, 0.0,
            -0.000_108_347_328_697_249_32, 0.000_382_571_090_835_658_4,
            -0.000_340_465_008_687_404_56, 0.141_312_443_674_632_5,
        ],
        &[
            -0.428_896_301_583_791_94, 0.0, 0.0, 0.0, 0.0, -4.697_621_415_361_164,
            7.683_421_196_062_599, 4.068_989_818_397_11, 0.356_727_187_455_281_1, 0.0, 0.0, 0.0,
            -0.001_399_024_165_159_014_5, 2.947_514_789_152_772_4, -9.150_958_472_179_87,
        ],
    ];
    const ERROR: &'static [f64] = &[
        0.013_120_044_994_194_88, 0.0, 0.0, 0.0, 0.0, -1.225_156_446_376_204_4,
        -0.495_758_949_657_250_2, 1.664_377_182_454_986_4, -0.350_328_848_749_973_66,
        0.334_179_118_713_017_5, 0.081_923_206_485_115_71, -0.022_355_307_863_886_294,
    ];
    const COARSE_ERROR: &'static [f64] = &[
        -0.189_800_754_072_407_62, 0.0, 0.0, 0.0, 0.0, 4.450_312_892_752_409,
        1.891_517_899_314_500_3, -5.801_203_960_010_585, -0.422_682_321_323_791_97,
        -0.152_160_949_662_516_1, 0.201_365_400_804_030_34, 0.022_651_792_198_360_825,
    ];
    const COARSE_ORDER: i32 = 4;
    const IS_MEAN: bool = true;
    const ERROR_ORDER: u8 = 8;
    const EXTENSION: &'static [&'static [f64]] = &[
        &[
            -8.428_938_276_109_013, 0.0, 0.0, 0.0, 0.0, 0.566_714_953_519_377_7,
            -3.068_949_945_949_891_7, 2.384_667_656_512_07, 2.117_034_582_445_028,
            -0.871_391_583_777_973, 2.240_437_430_260_788_3, 0.631_578_778_769_468_8,
            -0.088_990_336_451_333_31, 18.148_505_520_854_727, -9.194_632_392_478_356,
            -4.436_036_387_594_894,
        ],
        &[
            10.427_508_642_579_134, 0.0, 0.0, 0.0, 0.0, 242.283_491_775_258_17,
            165.200_451_717_270_28, -374.546_754_722_690_2, -22.113_666_853_125_306,
            7.733_432_668_472_264, -30.674_084_731_089_398, -9.332_130_526_430_229,
            15.697_238_121_770_845, -31.139_403_219_565_178, -9.352_924_358_844_48,
            35.816_841_486_394_08,
        ],
        &[
            19.985_053_242_002_433, 0.0, 0.0, 0.0, 0.0, -387.037_308_749_351_8,
            -189.178_138_195_167_58, 527.808_159_205_423_6, -11.573_902_539_959_63,
            6.881_232_694_696_3, -1.000_605_096_691_083_8, 0.777_713_779_805_344_3,
            -2.778_205_752_353_508, -60.196_695_231_264_12, 84.320_405_506_677_16,
            11.992_291_136_182_79,
        ],
        &[
            -25.693_933_462_703_75, 0.0, 0.0, 0.0, 0.0, -154.189_748_690_236_43,
            -231.529_379_176_045_5, 357.639_117_910_614_1, 93.405_324_183_624_32,
            -37.458_323_136_451_63, 104.099_649_508_962_3, 29.840_293_426_660_5,
            -43.533_456_590_011_14, 96.324_553_959_188_28, -39.177_261_675_615_44,
            -149.726_836_257_985_64,
        ],
    ];
    const REAL_LIMIT: f64 = 6.39;
}

#[cfg(test)]
mod tests {
    use super::{DormandPrince8, ExplicitTableau};
    use crate::ode::explicit::laws;
    use crate::ode::stepper::{Linear, OneStep, Point, Stepper};
    use nalgebra::{Matrix1, Vector1};

    #[test]
    fn the_stages_lie_where_their_weights_say() {
        // Weights of up to 44 in magnitude.
        laws::times::<DormandPrince8>(2e-14);
    }

    #[test]
    fn the_solution_meets_every_condition_up_to_order_eight_and_no_further() {
        laws::order::<DormandPrince8>(8, 2e-14, 1e-7);
    }

    #[test]
    fn the_error_estimates_vanish_up_to_orders_five_and_three_and_no_further() {
        laws::estimate::<DormandPrince8>(DormandPrince8::ERROR, 5);
        laws::estimate::<DormandPrince8>(DormandPrince8::COARSE_ERROR, 3);
    }

    #[test]
    fn the_dense_output_meets_every_condition_up_to_order_seven_within_the_step() {
        // Weights of up to 500.
        laws::extension::<DormandPrince8>(7, 2e-13);
    }

    #[test]
    fn the_error_of_the_curve_is_not_underestimated_where_stability_holds_the_step() {
        // ẋ = λ x over a step of 1: of the fast modes the curve knows nothing.
        for z in [-6.0, -5.0, -4.0, -3.0, -2.0, -1.0f64] {
            let rate = Matrix1::new(z);
            let (mut stepper, mut field) =
                (DormandPrince8.stepper(0.0, &Vector1::zeros()), Linear(&rate));
            let one = Vector1::new(1.0);
            let mut from = Point { time: 0.0, state: one, rate: one, scale: one };
            stepper.begin(&mut field, &mut from);
            let state = stepper.step(&mut field, &from, 1.0).state;
            let mut end = Point { time: 1.0, state, rate: one, scale: one };
            stepper.arrive(&mut field, &mut end);
            let curve = stepper.dense_output(&mut field, &from, &end);
            let error = |i: u32| {
                let part = 0.05 * f64::from(i);
                (curve.at(part)[0] - (z * part).exp()).abs()
            };
            let worst = (0..=20).map(error).fold(0.0, f64::max);
            let estimate = curve.error(&one);
            assert!(estimate > 0.3 * worst && estimate < 1e3 * worst, "{z}: {estimate} {worst}");
        }
    }
}
