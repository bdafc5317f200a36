//! Rodas5P: a stiffly accurate, L-stable Rosenbrock method of order 5 with an embedded estimate of
//! order 4, eight stages and a continuous extension of order 4. On stiff, linear problems (Prothero and
//! Robinson's) its order falls to 3, and that of RODAS to 1, with errors that fall as 1/λ.
//!
//! Source: G. Steinebach, "Construction of Rosenbrock–Wanner method Rodas5P and numerical benchmarks
//! within the Julia Differential Equations package", BIT Numerical Mathematics 63 (2023), 27.

use nalgebra::SVector;

use super::curve::Curve;
use super::method::{Attempt, Embedded, Field, Method, Point, combine};
use super::rosenbrock::{Stages, Tableau};
use crate::Scalar;
use crate::stability::Scheme;

/// The L-stable Rosenbrock method Rodas5P of order 5(4), for stiff systems and tight tolerances.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Rodas5P;

const GAMMA: f64 = 0.211_937_563_194_290_14;

const TABLEAU: Tableau<8> = Tableau {
    gamma: GAMMA,
    chained: 6,
    times: [
        0.0,
        0.635_812_689_582_870_4,
        0.409_579_839_339_753_5,
        0.976_930_672_506_071_6,
        0.428_840_360_955_866_4,
        1.0,
        1.0,
        1.0,
    ],
    time_weights: [
        GAMMA,
        -0.423_875_126_388_580_27,
        -0.338_462_712_623_592_4,
        1.804_645_287_288_273_4,
        2.325_825_639_765_069,
        0.0,
        0.0,
        0.0,
    ],
    a: [
        [0.0; 8],
        [3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [2.849_394_379_747_939, 0.458_422_422_044_639_23, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [
            -6.954_028_509_809_101,
            2.489_845_061_869_568,
            -10.358_996_098_473_584,
            0.0,
            0.0,
            0.0,
            0.0,
            0.0,
        ],
        [
            2.802_998_627_562_896_4,
            0.507_246_473_622_820_6,
            -0.398_831_254_177_052_4,
            -0.047_211_872_304_046_41,
            0.0,
            0.0,
            0.0,
            0.0,
        ],
        [
            -7.502_846_399_306_121,
            2.561_846_144_803_919,
            -11.627_539_656_261_098,
            -0.182_687_676_599_422_56,
            0.030_198_172_008_377_946,
            0.0,
            0.0,
            0.0,
        ],
        [
            -7.502_846_399_306_121,
            2.561_846_144_803_919,
            -11.627_539_656_261_098,
            -0.182_687_676_599_422_56,
            0.030_198_172_008_377_946,
            1.0,
            0.0,
            0.0,
        ],
        [
            -7.502_846_399_306_121,
            2.561_846_144_803_919,
            -11.627_539_656_261_098,
            -0.182_687_676_599_422_56,
            0.030_198_172_008_377_946,
            1.0,
            1.0,
            0.0,
        ],
    ],
    c: [
        [0.0; 8],
        [-14.155_112_264_123_755, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [-17.972_960_358_859_52, -2.859_693_295_451_294, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [
            147.121_502_757_117_16,
            -1.412_214_027_182_13,
            71.689_402_513_023_58,
            0.0,
            0.0,
            0.0,
            0.0,
            0.0,
        ],
        [
            165.435_170_248_716_76,
            -0.459_282_345_649_112_6,
            42.909_383_369_586_03,
            -5.961_986_721_573_306,
            0.0,
            0.0,
            0.0,
            0.0,
        ],
        [
            24.854_864_614_690_072,
            -3.000_922_700_283_218_6,
            47.493_111_002_076_8,
            5.581_419_782_155_812_5,
            -0.661_069_182_524_947_1,
            0.0,
            0.0,
            0.0,
        ],
        [
            30.912_732_140_285_99,
            -3.120_824_334_993_797_4,
            77.799_546_460_708_92,
            34.286_460_282_947_83,
            -19.097_331_116_725_623,
            -28.087_943_162_872_662,
            0.0,
            0.0,
        ],
        [
            37.802_771_233_905_63,
            -3.257_196_902_907_227_6,
            112.269_188_494_963_27,
            66.934_723_124_404_7,
            -40.066_189_370_910_02,
            -54.667_802_628_779_68,
            -9.488_616_523_096_27,
            0.0,
        ],
    ],
};

/// Weights of the three inner terms of the continuous extension, k₁ + θ(k₂ + θ k₃).
const EXTENSION: [[f64; 8]; 3] = [
    [
        25.948_786_856_663_858,
        -2.557_972_484_584_623_5,
        10.433_815_404_888_879,
        -2.367_925_102_268_520_4,
        0.524_948_541_321_073,
        1.124_108_831_045_040_4,
        0.427_287_619_443_187_4,
        -0.172_022_210_701_554_93,
    ],
    [
        -9.915_688_506_951_71,
        -0.968_994_459_411_515_4,
        3.043_803_724_297_845_3,
        -24.495_224_566_215_796,
        20.176_138_334_709_044,
        15.980_663_614_246_51,
        -6.789_040_303_419_874,
        -6.710_236_069_923_372,
    ],
    [
        11.419_903_575_922_262,
        2.887_964_514_613_699_4,
        72.921_379_959_960_29,
        80.125_118_346_226_43,
        -52.072_871_366_152_654,
        -59.789_936_252_667_29,
        -0.155_826_842_827_519_13,
        4.883_087_185_713_722,
    ],
];

impl Embedded for Rodas5P {}

impl<T: Scalar, const N: usize> Method<T, N> for Rodas5P {
    type Memory = Stages<T, N, 8>;

    fn scheme(&self) -> Option<Scheme> {
        Some(Scheme::Rosenbrock)
    }

    fn memory(&self) -> Self::Memory {
        Stages::new()
    }

    fn begin<F: Field<T, N>>(
        &self,
        stages: &mut Self::Memory,
        field: &mut F,
        point: &mut Point<T, N>,
    ) {
        stages.begin(field, point);
    }

    #[inline]
    fn attempt<F: Field<T, N>>(
        &self,
        stages: &mut Self::Memory,
        field: &mut F,
        from: &Point<T, N>,
        step: T,
    ) -> Attempt<T, N> {
        stages.attempt(&TABLEAU, field, from, step, 5)
    }

    #[inline]
    fn arrive<F: Field<T, N>>(
        &self,
        stages: &mut Self::Memory,
        field: &mut F,
        end: &mut Point<T, N>,
    ) {
        stages.arrive(field, end);
    }

    fn curve<F: Field<T, N>>(
        &self,
        stages: &Self::Memory,
        _field: &mut F,
        from: &Point<T, N>,
        end: &Point<T, N>,
    ) -> Curve<T, N> {
        let u = &stages.u;
        let inner =
            |weights: &[f64; 8]| -> SVector<T, N> { combine(u, weights, [0, 1, 2, 3, 4, 5, 6, 7]) };
        let [first, second, third] = &EXTENSION;
        let (first, second, third) = (inner(first), inner(second), inner(third));
        // θ = 1 − θ̄ turns the powers of θ into the nested form.
        let terms = [end.state - from.state, first, second + third, -third];
        Curve::new(from.state, &terms)
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
        stages.tangent = stages.at_end;
        proposed
    }
}

#[cfg(test)]
mod tests {
    use super::{EXTENSION, TABLEAU};
    use crate::ode::trees::{Rosenbrock, trees};

    fn method() -> Rosenbrock {
        Rosenbrock::new(TABLEAU.gamma, &TABLEAU.a, &TABLEAU.c)
    }

    /// Weights of the U in the solution: those of the last stage's state, and one.
    fn solution() -> [f64; 8] {
        let mut weights = TABLEAU.a[7];
        weights[7] = 1.0;
        weights
    }

    #[test]
    fn the_stages_lie_where_their_weights_say() {
        let method = method();
        for stage in 0..8 {
            let time: f64 = method.alpha[stage].iter().sum();
            assert!((time - TABLEAU.times[stage]).abs() < 1e-13, "{stage}: {time}");
            let weight = method.time_weight(stage);
            assert!((weight - TABLEAU.time_weights[stage]).abs() < 1e-13, "{stage}: {weight}");
        }
    }

    #[test]
    fn the_solution_meets_every_condition_up_to_order_five_and_no_further() {
        for tree in trees(5) {
            let defect = method().weighted(&tree, &solution()) - 1.0 / tree.density();
            assert!(defect.abs() < 1e-13, "{tree:?}: {defect}");
        }
        let next = trees(6).into_iter().filter(|tree| tree.order() == 6);
        let defect = next.map(|tree| method().weighted(&tree, &solution()) - 1.0 / tree.density());
        assert!(defect.fold(0.0, |most, defect| f64::max(most, defect.abs())) > 1e-5);
    }

    #[test]
    fn the_error_estimate_vanishes_up_to_order_four_and_no_further() {
        // It is the last U.
        let mut weights = [0.0; 8];
        weights[7] = 1.0;
        for tree in trees(4) {
            let defect = method().weighted(&tree, &weights);
            assert!(defect.abs() < 1e-13, "{tree:?}: {defect}");
        }
        let next = trees(5).into_iter().filter(|tree| tree.order() == 5);
        let greatest =
            next.map(|tree| method().weighted(&tree, &weights).abs()).fold(0.0, f64::max);
        assert!(greatest > 1e-4, "{greatest}");
    }

    #[test]
    fn the_method_is_stiffly_accurate() {
        // The last stage is the solution: R(∞) = 0, for the estimate too.
        let method = method();
        let weights = method.weights(&solution());
        for (beta, weight) in method.beta[7].iter().zip(&weights) {
            assert!((beta - weight).abs() < 1e-13, "{beta} {weight}");
        }
    }

    #[test]
    fn a_state_that_follows_from_the_one_before_is_the_one_that_its_weights_say() {
        for stage in TABLEAU.chained..8 {
            let mut before = TABLEAU.a[stage - 1];
            before[stage - 1] = 1.0;
            assert_eq!(TABLEAU.a[stage], before);
        }
    }

    #[test]
    fn the_continuous_extension_meets_every_condition_up_to_order_four_within_the_step() {
        let solution = solution();
        let [first, second, third] = &EXTENSION;
        let sum: [f64; 8] = core::array::from_fn(|i| second[i] + third[i]);
        let last = third.map(|weight| -weight);
        let terms: [&[f64]; 4] = [&solution, first, &sum, &last];
        for theta in [0.1, 0.37, 0.5, 0.9] {
            for tree in trees(4) {
                let got = method().extended(&tree, theta, &terms);
                let want = theta.powi(tree.order() as i32) / tree.density();
                assert!((got - want).abs() < 1e-13, "{theta} {tree:?}: {}", got - want);
            }
        }
    }
}
