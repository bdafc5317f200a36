//! The Dormand–Prince method of order 8 with embedded estimates of orders 5 and 3.
//!
//! Twelve stages, and three more for a continuous extension of order 7 where it is asked for. The
//! error is |e₅|²/√(|e₅|² + 0.01|e₃|²), which behaves as h⁸. Where |e₅| passes zero by chance, as it
//! does in systems of one or two states, the step would be far too long: so |e₅|/|e₃|, which
//! behaves as h², may fall to no less than a third of what the step before foretells.
//!
//! Sources: J. R. Dormand, P. J. Prince, "High order embedded Runge–Kutta formulae", Journal of
//! Computational and Applied Mathematics 7 (1981), 67–75; E. Hairer, S. P. Nørsett, G. Wanner, "Solving
//! Ordinary Differential Equations I", 2nd edition (Springer, 1993), sections II.5 and II.10, and
//! their program DOP853.

use nalgebra::SVector;

use super::curve::Curve;
use super::method::{Attempt, Embedded, Field, Method, Point, along, combine};
use crate::Scalar;
use crate::scalar::lit;
use crate::stability::Scheme;

/// The Dormand–Prince method of order 8(5,3), for tight tolerances.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DormandPrince8;

/// Weights of the earlier stages in each. The twelfth is the last of the step itself; the thirteenth
/// lies at its end, and its weights are those of the solution; the last three serve the continuous
/// extension alone.
const A: [[f64; 15]; 16] = [
    [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [
        0.052_600_151_958_767_73,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
    ],
    [
        0.019_725_056_984_537_9,
        0.059_175_170_953_613_7,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
    ],
    [
        0.029_587_585_476_806_85,
        0.0,
        0.088_762_756_430_420_54,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
    ],
    [
        0.241_365_134_159_266_7,
        0.0,
        -0.884_549_479_328_286_1,
        0.924_834_003_261_792,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
    ],
    [
        0.037_037_037_037_037_035,
        0.0,
        0.0,
        0.170_828_608_729_473_86,
        0.125_467_687_566_822_42,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
    ],
    [
        0.037_109_375,
        0.0,
        0.0,
        0.170_252_211_019_544_05,
        0.060_216_538_980_455_96,
        -0.017_578_125,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
    ],
    [
        0.037_092_000_118_504_79,
        0.0,
        0.0,
        0.170_383_925_712_239_98,
        0.107_262_030_446_373_28,
        -0.015_319_437_748_624_402,
        0.008_273_789_163_814_023,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
    ],
    [
        0.624_110_958_716_075_7,
        0.0,
        0.0,
        -3.360_892_629_446_941_4,
        -0.868_219_346_841_726,
        27.592_099_699_446_71,
        20.154_067_550_477_894,
        -43.489_884_181_069_96,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
    ],
    [
        0.477_662_536_438_264_34,
        0.0,
        0.0,
        -2.488_114_619_971_667_7,
        -0.590_290_826_836_843,
        21.230_051_448_181_193,
        15.279_233_632_882_423,
        -33.288_210_968_984_86,
        -0.020_331_201_708_508_627,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
    ],
    [
        -0.937_142_430_085_987_3,
        0.0,
        0.0,
        5.186_372_428_844_064,
        1.091_437_348_996_729_5,
        -8.149_787_010_746_927,
        -18.520_065_659_996_96,
        22.739_487_099_350_505,
        2.493_605_552_679_652_3,
        -3.046_764_471_898_219_6,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
    ],
    [
        2.273_310_147_516_538,
        0.0,
        0.0,
        -10.534_495_466_737_25,
        -2.000_872_058_224_862_5,
        -17.958_931_863_118_8,
        27.948_884_529_419_96,
        -2.858_998_277_135_023_5,
        -8.872_856_933_530_63,
        12.360_567_175_794_303,
        0.643_392_746_015_763_6,
        0.0,
        0.0,
        0.0,
        0.0,
    ],
    [
        0.054_293_734_116_568_765,
        0.0,
        0.0,
        0.0,
        0.0,
        4.450_312_892_752_409,
        1.891_517_899_314_500_3,
        -5.801_203_960_010_585,
        0.311_164_366_957_819_9,
        -0.152_160_949_662_516_1,
        0.201_365_400_804_030_34,
        0.044_710_615_727_772_59,
        0.0,
        0.0,
        0.0,
    ],
    [
        0.056_167_502_283_047_954,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.253_500_210_216_624_83,
        -0.246_239_037_470_802_5,
        -0.124_191_423_263_816_37,
        0.153_291_798_278_765_68,
        0.008_201_052_295_634_69,
        0.007_567_897_660_545_699,
        -0.008_298,
        0.0,
        0.0,
    ],
    [
        0.031_834_648_163_502_14,
        0.0,
        0.0,
        0.0,
        0.0,
        0.028_300_909_672_366_776,
        0.053_541_988_307_438_566,
        -0.054_923_748_571_390_99,
        0.0,
        0.0,
        -0.000_108_347_328_697_249_32,
        0.000_382_571_090_835_658_4,
        -0.000_340_465_008_687_404_56,
        0.141_312_443_674_632_5,
        0.0,
    ],
    [
        -0.428_896_301_583_791_94,
        0.0,
        0.0,
        0.0,
        0.0,
        -4.697_621_415_361_164,
        7.683_421_196_062_599,
        4.068_989_818_397_11,
        0.356_727_187_455_281_1,
        0.0,
        0.0,
        0.0,
        -0.001_399_024_165_159_014_5,
        2.947_514_789_152_772_4,
        -9.150_958_472_179_87,
    ],
];

/// Times of the stages.
const C: [f64; 16] = [
    0.0,
    0.052_600_151_958_767_73,
    0.078_900_227_938_151_6,
    0.118_350_341_907_227_4,
    0.281_649_658_092_772_6,
    0.333_333_333_333_333_3,
    0.25,
    0.307_692_307_692_307_7,
    0.651_282_051_282_051_3,
    0.6,
    0.857_142_857_142_857_1,
    1.0,
    1.0,
    0.1,
    0.2,
    0.777_777_777_777_777_8,
];

/// Weights of the error estimate of order 5.
const FINE: [f64; 12] = [
    0.013_120_044_994_194_88,
    0.0,
    0.0,
    0.0,
    0.0,
    -1.225_156_446_376_204_4,
    -0.495_758_949_657_250_2,
    1.664_377_182_454_986_4,
    -0.350_328_848_749_973_66,
    0.334_179_118_713_017_5,
    0.081_923_206_485_115_71,
    -0.022_355_307_863_886_294,
];

/// Weights of the error estimate of order 3.
const COARSE: [f64; 12] = [
    -0.189_800_754_072_407_62,
    0.0,
    0.0,
    0.0,
    0.0,
    4.450_312_892_752_409,
    1.891_517_899_314_500_3,
    -5.801_203_960_010_585,
    -0.422_682_321_323_791_97,
    -0.152_160_949_662_516_1,
    0.201_365_400_804_030_34,
    0.022_651_792_198_360_825,
];

/// Weights of the last four terms of the continuous extension.
const EXTENSION: [[f64; 16]; 4] = [
    [
        -8.428_938_276_109_013,
        0.0,
        0.0,
        0.0,
        0.0,
        0.566_714_953_519_377_7,
        -3.068_949_945_949_891_7,
        2.384_667_656_512_07,
        2.117_034_582_445_028,
        -0.871_391_583_777_973,
        2.240_437_430_260_788_3,
        0.631_578_778_769_468_8,
        -0.088_990_336_451_333_31,
        18.148_505_520_854_727,
        -9.194_632_392_478_356,
        -4.436_036_387_594_894,
    ],
    [
        10.427_508_642_579_134,
        0.0,
        0.0,
        0.0,
        0.0,
        242.283_491_775_258_17,
        165.200_451_717_270_28,
        -374.546_754_722_690_2,
        -22.113_666_853_125_306,
        7.733_432_668_472_264,
        -30.674_084_731_089_398,
        -9.332_130_526_430_229,
        15.697_238_121_770_845,
        -31.139_403_219_565_178,
        -9.352_924_358_844_48,
        35.816_841_486_394_08,
    ],
    [
        19.985_053_242_002_433,
        0.0,
        0.0,
        0.0,
        0.0,
        -387.037_308_749_351_8,
        -189.178_138_195_167_58,
        527.808_159_205_423_6,
        -11.573_902_539_959_63,
        6.881_232_694_696_3,
        -1.000_605_096_691_083_8,
        0.777_713_779_805_344_3,
        -2.778_205_752_353_508,
        -60.196_695_231_264_12,
        84.320_405_506_677_16,
        11.992_291_136_182_79,
    ],
    [
        -25.693_933_462_703_75,
        0.0,
        0.0,
        0.0,
        0.0,
        -154.189_748_690_236_43,
        -231.529_379_176_045_5,
        357.639_117_910_614_1,
        93.405_324_183_624_32,
        -37.458_323_136_451_63,
        104.099_649_508_962_3,
        29.840_293_426_660_5,
        -43.533_456_590_011_14,
        96.324_553_959_188_28,
        -39.177_261_675_615_44,
        -149.726_836_257_985_64,
    ],
];

impl Embedded for DormandPrince8 {}

/// The stages of the last trial, of which the thirteenth is the rate at its end, and the state at
/// the twelfth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stages<T, const N: usize> {
    pub(super) k: [SVector<T, N>; 13],
    /// The state at which k₁₂ was evaluated: at the end of the step, as is k₁₃'s.
    pub(super) twelfth: SVector<T, N>,
    /// |e₅|²/|e₃|² over h⁴ of the last accepted step, and of the last trial.
    smoothness: (T, T),
}

/// The part of its expected value to which |e₅|/|e₃| may fall from one step to the next.
const CHANCE: f64 = 0.3;

impl<T: Scalar, const N: usize> Stages<T, N> {
    /// Forgets what the step before foretells.
    pub(super) fn forget(&mut self) {
        self.smoothness.0 = T::zero();
    }

    /// The finer error, no smaller than the step before makes likely.
    fn likely(
        &mut self,
        fine: SVector<T, N>,
        coarse: &SVector<T, N>,
        scale: &SVector<T, N>,
        step: T,
    ) -> SVector<T, N> {
        let square = |error: &SVector<T, N>| {
            error.iter().zip(scale).fold(T::zero(), |sum, (&error, &scale)| {
                let ratio = error / scale;
                sum + ratio * ratio
            })
        };
        let (of_fine, of_coarse) = (square(&fine), square(coarse));
        let fourth = step * step * step * step;
        let expected = self.smoothness.0 * fourth * lit(CHANCE * CHANCE);
        if of_fine < expected * of_coarse {
            self.smoothness.1 = self.smoothness.0 * lit(CHANCE * CHANCE);
            coarse * expected.sqrt()
        } else {
            self.smoothness.1 = of_fine / (of_coarse * fourth);
            fine
        }
    }
}

impl<T: Scalar, const N: usize> Method<T, N> for DormandPrince8 {
    type Memory = Stages<T, N>;

    fn scheme(&self) -> Option<Scheme> {
        Some(Scheme::DormandPrince8)
    }

    fn memory(&self) -> Self::Memory {
        Stages {
            k: [SVector::zeros(); 13],
            twelfth: SVector::zeros(),
            smoothness: (T::zero(), T::zero()),
        }
    }

    fn begin<F: Field<T, N>>(
        &self,
        stages: &mut Self::Memory,
        field: &mut F,
        point: &mut Point<T, N>,
    ) {
        stages.forget();
        point.rate = field.rate(point.time, &point.state);
    }

    #[inline]
    fn attempt<F: Field<T, N>>(
        &self,
        stages: &mut Self::Memory,
        field: &mut F,
        from: &Point<T, N>,
        step: T,
    ) -> Attempt<T, N> {
        let Stages { k, twelfth, .. } = stages;
        k[0] = from.rate;
        let time = |stage: usize| from.time + step * lit::<T>(C[stage]);
        let x = &from.state;
        k[1] = field.rate(time(1), &along(x, step, k, &A[1], [0]));
        k[2] = field.rate(time(2), &along(x, step, k, &A[2], [0, 1]));
        k[3] = field.rate(time(3), &along(x, step, k, &A[3], [0, 2]));
        k[4] = field.rate(time(4), &along(x, step, k, &A[4], [0, 2, 3]));
        k[5] = field.rate(time(5), &along(x, step, k, &A[5], [0, 3, 4]));
        k[6] = field.rate(time(6), &along(x, step, k, &A[6], [0, 3, 4, 5]));
        k[7] = field.rate(time(7), &along(x, step, k, &A[7], [0, 3, 4, 5, 6]));
        k[8] = field.rate(time(8), &along(x, step, k, &A[8], [0, 3, 4, 5, 6, 7]));
        k[9] = field.rate(time(9), &along(x, step, k, &A[9], [0, 3, 4, 5, 6, 7, 8]));
        k[10] = field.rate(time(10), &along(x, step, k, &A[10], [0, 3, 4, 5, 6, 7, 8, 9]));
        *twelfth = along(x, step, k, &A[11], [0, 3, 4, 5, 6, 7, 8, 9, 10]);
        k[11] = field.rate(time(11), twelfth);
        let state = along(x, step, k, &A[12], USED);
        let fine = combine(k, &FINE, USED) * step;
        let coarse = combine(k, &COARSE, USED) * step;
        let error = stages.likely(fine, &coarse, &from.scale, step);
        Attempt { state, error, coarse_error: Some(coarse), order: 8 }
    }

    #[inline]
    fn accepted<F: Field<T, N>>(
        &self,
        stages: &mut Self::Memory,
        _field: &mut F,
        _from: &Point<T, N>,
        _end: &Point<T, N>,
        proposed: Option<T>,
    ) -> Option<T> {
        let (_, latest) = stages.smoothness;
        stages.smoothness.0 = if latest.is_finite() { latest } else { T::zero() };
        proposed
    }

    #[inline]
    fn arrive<F: Field<T, N>>(
        &self,
        stages: &mut Self::Memory,
        field: &mut F,
        end: &mut Point<T, N>,
    ) {
        end.rate = field.rate(end.time, &end.state);
        stages.k[12] = end.rate;
    }

    fn curve<F: Field<T, N>>(
        &self,
        stages: &Self::Memory,
        field: &mut F,
        from: &Point<T, N>,
        end: &Point<T, N>,
    ) -> Curve<T, N> {
        let step = end.time - from.time;
        let mut k = [SVector::zeros(); 16];
        k[..13].copy_from_slice(&stages.k);
        let time = |stage: usize| from.time + step * lit::<T>(C[stage]);
        let x = &from.state;
        k[13] = field.rate(time(13), &along(x, step, &k, &A[13], [0, 6, 7, 8, 9, 10, 11, 12]));
        k[14] = field.rate(time(14), &along(x, step, &k, &A[14], [0, 5, 6, 7, 10, 11, 12, 13]));
        k[15] = field.rate(time(15), &along(x, step, &k, &A[15], [0, 5, 6, 7, 8, 12, 13, 14]));
        EXTENSION.iter().fold(Curve::hermite(from, end), |curve, weights| {
            let inner = [0, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];
            curve.with(combine(&k, weights, inner) * step)
        })
    }
}

/// The stages that the solution and its error estimates use.
const USED: [usize; 8] = [0, 5, 6, 7, 8, 9, 10, 11];

#[cfg(test)]
mod tests {
    use super::{A, C, COARSE, EXTENSION, FINE};
    use crate::ode::trees::{RungeKutta, trees};

    fn method() -> RungeKutta {
        RungeKutta { a: A.iter().map(|row| row.to_vec()).collect() }
    }

    #[test]
    fn the_stages_lie_where_their_weights_say() {
        for (row, c) in A.iter().zip(C) {
            // Weights of up to 44 in magnitude.
            assert!((row.iter().sum::<f64>() - c).abs() < 2e-14, "{c}");
        }
    }

    #[test]
    fn the_solution_meets_every_condition_up_to_order_eight() {
        for tree in trees(8) {
            let defect = method().weighted(&tree, &A[12]) - 1.0 / tree.density();
            assert!(defect.abs() < 2e-14, "{tree:?}: {defect}");
        }
        let ninth = trees(9).into_iter().filter(|tree| tree.order() == 9);
        let defect = ninth.map(|tree| method().weighted(&tree, &A[12]) - 1.0 / tree.density());
        assert!(defect.fold(0.0, |most, defect| f64::max(most, defect.abs())) > 1e-7);
    }

    #[test]
    fn the_error_estimates_vanish_up_to_orders_five_and_three_and_no_further() {
        for (weights, order) in [(&FINE, 5), (&COARSE, 3)] {
            let greatest = |order: usize| {
                let trees = trees(order).into_iter().filter(|tree| tree.order() == order);
                trees.map(|tree| method().weighted(&tree, weights).abs()).fold(0.0, f64::max)
            };
            for below in 1..=order {
                assert!(greatest(below) < 2e-14, "{order}: {}", greatest(below));
            }
            assert!(greatest(order + 1) > 1e-5, "{order}: {}", greatest(order + 1));
        }
    }

    #[test]
    fn the_continuous_extension_meets_every_condition_up_to_order_seven_within_the_step() {
        let [a, b, c, d] = &EXTENSION;
        for theta in [0.1, 0.37, 0.5, 0.9] {
            for tree in trees(7) {
                let got = method().extended(&tree, theta, &A[12], 12, &[a, b, c, d]);
                let want = theta.powi(tree.order() as i32) / tree.density();
                // Weights of up to 500.
                assert!((got - want).abs() < 2e-13, "{theta} {tree:?}: {}", got - want);
            }
        }
    }
}
