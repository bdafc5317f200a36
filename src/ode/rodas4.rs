//! RODAS: a stiffly accurate, L-stable Rosenbrock method of order 4 with an embedded estimate of
//! order 3, six stages and a continuous extension of order 3.
//!
//! Source: E. Hairer, G. Wanner, "Solving Ordinary Differential Equations II", 2nd edition
//! (Springer, 1996), section IV.7, and their program of the same name.

use nalgebra::SVector;

use super::curve::Curve;
use super::method::{Attempt, Embedded, Field, Method, Point, combine};
use super::rosenbrock::{Stages, Tableau};
use crate::Scalar;
use crate::stability::Scheme;

/// The L-stable Rosenbrock method RODAS of order 4(3), for stiff systems and moderate tolerances.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Rodas4;

const TABLEAU: Tableau<6> = Tableau {
    gamma: 0.25,
    chained: 5,
    times: [0.0, 0.386, 0.21, 0.63, 1.0, 1.0],
    time_weights: [0.25, -0.1043, 0.1035, -0.036_200_000_000_000_23, 0.0, 0.0],
    a: [
        [0.0; 6],
        [1.544, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.946_678_528_081_582_6, 0.255_701_169_898_328_4, 0.0, 0.0, 0.0, 0.0],
        [3.314_825_187_068_521, 2.896_124_015_972_201, 0.998_641_913_997_781_7, 0.0, 0.0, 0.0],
        [
            1.221_224_509_226_641,
            6.019_134_481_288_629,
            12.537_083_329_320_87,
            -0.687_886_036_105_895_0,
            0.0,
            0.0,
        ],
        [
            1.221_224_509_226_641,
            6.019_134_481_288_629,
            12.537_083_329_320_87,
            -0.687_886_036_105_895_0,
            1.0,
            0.0,
        ],
    ],
    c: [
        [0.0; 6],
        [-5.6688, 0.0, 0.0, 0.0, 0.0, 0.0],
        [-2.430_093_356_833_875, -0.206_359_915_709_191_5, 0.0, 0.0, 0.0, 0.0],
        [-0.107_352_905_815_137_5, -9.594_562_251_023_355, -20.470_286_148_096_16, 0.0, 0.0, 0.0],
        [
            7.496_443_313_967_647,
            -10.246_804_314_643_52,
            -33.999_903_528_199_05,
            11.708_908_932_061_60,
            0.0,
            0.0,
        ],
        [
            8.083_246_795_921_522,
            -7.981_132_988_064_893,
            -31.521_594_328_743_71,
            16.319_305_431_231_36,
            -6.058_818_238_834_054,
            0.0,
        ],
    ],
};

/// Weights of the two inner terms of the continuous extension.
const EXTENSION: [[f64; 5]; 2] = [
    [
        10.126_235_083_445_86,
        -7.487_995_877_610_167,
        -34.800_918_615_557_47,
        -7.992_771_707_568_823,
        1.025_137_723_295_662,
    ],
    [
        -0.676_280_339_280_125_3,
        6.087_714_651_680_015,
        16.430_843_208_924_78,
        24.767_225_114_183_86,
        -6.594_389_125_716_872,
    ],
];

impl Embedded for Rodas4 {}

impl<T: Scalar, const N: usize> Method<T, N> for Rodas4 {
    type Memory = Stages<T, N, 6>;

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
        stages.attempt(&TABLEAU, field, from, step, 4)
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
        let inner = |weights: &[f64; 5]| -> SVector<T, N> { combine(u, weights, [0, 1, 2, 3, 4]) };
        let terms = [end.state - from.state, inner(&EXTENSION[0]), inner(&EXTENSION[1])];
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
    fn solution() -> [f64; 6] {
        let mut weights = TABLEAU.a[5];
        weights[5] = 1.0;
        weights
    }

    #[test]
    fn the_stages_lie_where_their_weights_say() {
        let method = method();
        for stage in 0..6 {
            let time: f64 = method.alpha[stage].iter().sum();
            assert!((time - TABLEAU.times[stage]).abs() < 1e-13, "{stage}: {time}");
            let weight = method.time_weight(stage);
            assert!((weight - TABLEAU.time_weights[stage]).abs() < 1e-13, "{stage}: {weight}");
        }
    }

    #[test]
    fn the_solution_meets_every_condition_up_to_order_four_and_no_further() {
        for tree in trees(4) {
            let defect = method().weighted(&tree, &solution()) - 1.0 / tree.density();
            assert!(defect.abs() < 1e-13, "{tree:?}: {defect}");
        }
        let next = trees(5).into_iter().filter(|tree| tree.order() == 5);
        let defect = next.map(|tree| method().weighted(&tree, &solution()) - 1.0 / tree.density());
        assert!(defect.fold(0.0, |most, defect| f64::max(most, defect.abs())) > 1e-5);
    }

    #[test]
    fn the_error_estimate_vanishes_up_to_order_three_and_no_further() {
        // It is the last U.
        let mut weights = [0.0; 6];
        weights[5] = 1.0;
        for tree in trees(3) {
            let defect = method().weighted(&tree, &weights);
            assert!(defect.abs() < 1e-13, "{tree:?}: {defect}");
        }
        let next = trees(4).into_iter().filter(|tree| tree.order() == 4);
        let greatest =
            next.map(|tree| method().weighted(&tree, &weights).abs()).fold(0.0, f64::max);
        assert!(greatest > 1e-4, "{greatest}");
    }

    #[test]
    fn the_method_is_stiffly_accurate() {
        // The last stage is the solution: R(∞) = 0, for the estimate too.
        let method = method();
        let weights = method.weights(&solution());
        for (beta, weight) in method.beta[5].iter().zip(&weights) {
            assert!((beta - weight).abs() < 1e-13, "{beta} {weight}");
        }
    }

    #[test]
    fn a_state_that_follows_from_the_one_before_is_the_one_that_its_weights_say() {
        for stage in TABLEAU.chained..6 {
            let mut before = TABLEAU.a[stage - 1];
            before[stage - 1] = 1.0;
            assert_eq!(TABLEAU.a[stage], before);
        }
    }

    #[test]
    fn the_continuous_extension_meets_every_condition_up_to_order_three_within_the_step() {
        let solution = solution();
        let terms: [&[f64]; 3] = [&solution, &EXTENSION[0], &EXTENSION[1]];
        for theta in [0.1, 0.37, 0.5, 0.9] {
            for tree in trees(3) {
                let got = method().extended(&tree, theta, &terms);
                let want = theta.powi(tree.order() as i32) / tree.density();
                assert!((got - want).abs() < 1e-13, "{theta} {tree:?}: {}", got - want);
            }
        }
    }
}
