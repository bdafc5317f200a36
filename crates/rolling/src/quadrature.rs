//! Gauss quadrature, between the knots of a pressure and across the boundary layers of a profile.
//!
//! Every integral over a part of the patch that has no closed form is taken here.

use nalgebra::{Complex, ComplexField};

use super::Pressure;
use bristle::Scalar;
use bristle::scalar::{lit, to_f64};

/// Least number of panels from one knot of a pressure to the next.
const PANELS: usize = 16;

/// Calls `visit` with places t ∈ (0, 1) and weights of a quadrature that is exact to rounding for
/// polynomials up to degree 15 times factors that decay by up to e^(−steepness) from either end.
pub(super) fn integrate<T: Scalar>(steepness: T, visit: impl FnMut(T, T)) {
    integrate_in(4, steepness, visit);
}

/// As [`integrate`], for integrands that are smooth on the scale of 1/`panels`.
pub(super) fn integrate_in<T: Scalar>(panels: usize, steepness: T, mut visit: impl FnMut(T, T)) {
    const LAYER: usize = 24;
    if steepness < lit(2.0 * PANEL * LAYER as f64) {
        evenly((T::zero(), T::one()), enough(panels, steepness), &mut visit);
    } else {
        // e^(−48) is below a rounding: nothing steep is left between the two layers.
        let layer = lit::<T>(PANEL * LAYER as f64) / steepness;
        evenly((T::zero(), layer), LAYER, &mut visit);
        evenly((layer, T::one() - layer), panels, &mut visit);
        evenly((T::one() - layer, T::one()), LAYER, &mut visit);
    }
}

/// As [`integrate_in`] with a factor e^(−st), Re s ≥ 0, which may be a wave that nothing damps. The
/// work grows with |s|; beyond 2 097 152 the weights are NaN.
fn integrate_wave<T: Scalar>(panels: usize, rate: Complex<T>, mut visit: impl FnMut(T, T)) {
    const MOST: usize = 1 << 20;
    let size = rate.modulus();
    if rate.re >= rate.im.abs() {
        integrate_in(panels, size, visit);
    } else if size < lit(PANEL * MOST as f64) {
        evenly((T::zero(), T::one()), enough(panels, size), &mut visit);
    } else {
        visit(T::zero(), T::nan());
    }
}

/// Exponents up to this fall into one panel: eight points miss e^(−2t) by 2e-18.
const PANEL: f64 = 2.0;

fn enough<T: Scalar>(panels: usize, steepness: T) -> usize {
    panels.max(to_f64((steepness / lit(PANEL)).ceil()) as usize)
}

/// As [`integrate`], with five points where they are enough: for a polynomial of at most the fourth
/// degree times e^(−steepness t), which they miss by less than 4e-13 · 5040 steepness⁶ of its
/// largest value.
pub(super) fn integrate_gentle<T: Scalar>(
    degree: usize,
    steepness: T,
    mut visit: impl FnMut(T, T),
) {
    if degree <= 4 && steepness <= lit(0.1) {
        for (place, weight) in GAUSS_5 {
            visit(lit(place), lit(weight));
        }
    } else {
        integrate(steepness, visit);
    }
}

/// Calls `visit` with places ξ and p(ξ) × weight of a quadrature over the patch that resolves a
/// factor e^(−sξ), and a kink at one place.
pub(super) fn weigh<T: Scalar, P: Pressure<T>>(
    pressure: &P,
    kink: Option<T>,
    rate: Complex<T>,
    mut visit: impl FnMut(T, T),
) {
    between_knots(pressure, kink, |from, width| {
        integrate_wave(PANELS, rate.scale(width), |t, weight| {
            let place = from + width * t;
            visit(place, pressure.at(place) * (weight * width));
        });
    });
}

/// Calls `visit` with the start and the width of each smooth piece of a pressure, which one more
/// kink may divide.
pub(super) fn between_knots<T: Scalar, P: Pressure<T>>(
    pressure: &P,
    kink: Option<T>,
    mut visit: impl FnMut(T, T),
) {
    let mut from = T::zero();
    while from < T::one() {
        let to = from.larger(pressure.next_knot(from).unwrap_or_else(T::one));
        let to = kink.filter(|&kink| kink > from).map_or(to, |kink| to.smaller(kink));
        if !(to > from) {
            break;
        }
        visit(from, to - from);
        from = to;
    }
}

/// Gauss panels of equal width.
pub(super) fn evenly<T: Scalar>((from, to): (T, T), panels: usize, visit: &mut impl FnMut(T, T)) {
    let width = (to - from) / lit(panels as f64);
    for number in 0..panels {
        let start = from + lit::<T>(number as f64) * width;
        for (place, weight) in GAUSS_8 {
            visit(start + width * lit(place), width * lit(weight));
        }
    }
}

/// Gauss–Legendre quadrature with five points on [0, 1] (M. Abramowitz and I. A. Stegun, "Handbook
/// of Mathematical Functions", table 25.4, moved).
const GAUSS_5: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_094_54),
    (0.230_765_344_947_158_45, 0.239_314_335_249_683_23),
    (0.5, 0.284_444_444_444_444_44),
    (0.769_234_655_052_841_6, 0.239_314_335_249_683_23),
    (0.953_089_922_969_332, 0.118_463_442_528_094_54),
];

/// The rule with eight points.
const GAUSS_8: [(f64, f64); 8] = [
    (0.019_855_071_751_231_884, 0.050_614_268_145_188_13),
    (0.101_666_761_293_186_63, 0.111_190_517_226_687_24),
    (0.237_233_795_041_835_5, 0.156_853_322_938_943_64),
    (0.408_282_678_752_175_1, 0.181_341_891_689_180_99),
    (0.591_717_321_247_824_9, 0.181_341_891_689_180_99),
    (0.762_766_204_958_164_5, 0.156_853_322_938_943_64),
    (0.898_333_238_706_813_4, 0.111_190_517_226_687_24),
    (0.980_144_928_248_768_1, 0.050_614_268_145_188_13),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::moments::{complex_decaying, decaying, phi1};

    #[test]
    fn the_gauss_points_integrate_every_power_up_to_fifteen() {
        for power in 0..16 {
            let sum: f64 = GAUSS_8.iter().map(|(place, weight)| weight * place.powi(power)).sum();
            // Eight terms.
            assert!((sum * f64::from(power + 1) - 1.0).abs() < 2e-15, "{power}");
        }
    }

    #[test]
    fn quadrature_resolves_decays_from_either_end() {
        for steepness in [0.0, 1.0, 10.0, 95.0, 97.0, 1e3, 1e9] {
            let (mut from_start, mut from_end, mut power) = (0.0, 0.0, 0.0);
            integrate(steepness, |t: f64, weight| {
                from_start += weight * (-steepness * t).exp();
                from_end += weight * (-steepness * (1.0 - t)).exp();
                power += weight * t.powi(11);
            });
            let want = phi1(steepness);
            // 1 − t is off by a rounding of 1, times the steepness.
            let phase = 1e-16 * steepness;
            assert!((from_start / want - 1.0).abs() < 2e-15, "{steepness}");
            assert!((from_end / want - 1.0).abs() < 2e-15 + phase, "{steepness}");
            assert!((power * 12.0 - 1.0).abs() < 2e-15, "{steepness}");
        }
    }

    #[test]
    fn five_points_are_used_where_they_are_enough_and_there_only() {
        for (degree, steepness, points) in [
            (0, 0.1, 5),
            (4, 0.0, 5),
            (4, 0.1, 5),
            (5, 0.0, 32),
            (5, 0.1, 32),
            (9, 0.1, 32),
            (4, 0.101, 32),
            (4, 0.9, 32),
        ] {
            let (mut sum, mut count) = (0.0, 0);
            integrate_gentle(degree, steepness, |t: f64, weight| {
                count += 1;
                sum += weight * t.powi(degree as i32) * (-steepness * t).exp();
            });
            assert_eq!(count, points, "{degree}, {steepness}");
            let want = decaying::<f64, 12>(steepness)[degree];
            // Five points miss t¹⁰ by (5!)⁴/(11 (10!)²) = 1.4e-6, which t⁴ e^(−0.1t) holds a
            // 0.1⁶/6! = 1.4e-9 of; beside roundings.
            let off: f64 = sum - want;
            assert!(off.abs() < 2e-15 + 3e-16, "{degree}, {steepness}: {off:e}");
        }
    }

    #[test]
    fn quadrature_resolves_waves() {
        for (re, im) in [(0.0, 5.0), (0.0, 5000.0), (300.0, 400.0), (400.0, 300.0), (1e6, 1e3)] {
            let x = Complex::new(re, im);
            let mut sum = Complex::new(0.0, 0.0);
            integrate_wave(4, x, |t: f64, weight| sum += (-x.scale(t)).exp().scale(weight));
            let want = complex_decaying::<f64, 1>(x)[0];
            // Rounding of the phase and of up to 20 000 terms.
            assert!((sum - want).modulus() < 1e-14, "{x}");
        }
        let mut sum = 0.0;
        integrate_wave(4, Complex::new(0.0, 1e9), |_, weight: f64| sum += weight);
        assert!(sum.is_nan());
    }
}
