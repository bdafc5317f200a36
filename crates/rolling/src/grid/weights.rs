//! The force of a profile known at nodes: ∫ p(ξ) f(ξ) dξ = Σ wᵢ fᵢ with wᵢ = ∫ p(ξ) ℓᵢ(ξ) dξ.
//!
//! ℓᵢ is 1 at its node and 0 at the others, a polynomial of degree 5 in each cell and 3 in the two
//! at each end. However steep or kinked the pressure is, it enters exactly; the error, of fifth
//! order, is that of the interpolation of f. Weights below zero would let the stored energy be
//! negative: where one comes out so, its cells are interpolated linearly instead, with an error of
//! second order there.

use alloc::vec;
use alloc::vec::Vec;

use super::super::Pressure;
use super::interpolation::{lagrange, stencil};
use crate::quadrature::evenly;
use bristle::Scalar;
use bristle::parameter::{Checked, Named, ParameterError};
use bristle::scalar::lit;

/// Eight points integrate e^(−3t) on 0 … 1 to rounding, and no pressure of this crate is steeper
/// than e^(−50ξ).
const WIDEST: f64 = 1.0 / 16.0;

/// Attempts to be rid of negative weights before all cells are linear. One is the rule.
const ATTEMPTS: usize = 8;

/// The weights of the nodes, all ≥ 0.
///
/// Refuses a pressure that is negative or not finite, and names the cell.
pub(super) fn weights<T: Scalar, P: Pressure<T>>(pressure: &P, cells: usize) -> Checked<Vec<T>> {
    let mut linear = vec![false; cells];
    for _ in 0..ATTEMPTS {
        let weights = attempted(pressure, &linear)?;
        if !weights.iter().any(|&weight| weight < T::zero()) {
            return Ok(weights);
        }
        for (node, _) in weights.iter().enumerate().filter(|(_, weight)| **weight < T::zero()) {
            let around = linear.iter_mut().skip(node.saturating_sub(3)).take(6);
            around.for_each(|linear| *linear = true);
        }
    }
    attempted(pressure, &vec![true; cells])
}

fn attempted<T: Scalar, P: Pressure<T>>(pressure: &P, linear: &[bool]) -> Checked<Vec<T>> {
    let cells = linear.len();
    let width = T::one() / lit(cells as f64);
    let mut weights = vec![T::zero(); cells + 1];
    for (cell, &linear) in linear.iter().enumerate() {
        let (first, count) = if linear { (cell, 2) } else { stencil(cells, cell) };
        let edge = |i: usize| lit::<T>(i as f64) * width;
        let (mut from, end) = (edge(cell), edge(cell + 1));
        while from < end {
            let to = (from + lit(WIDEST)).smaller(end);
            let knot = pressure.next_knot(from).filter(|&knot| knot > from);
            let to = knot.map_or(to, |knot| to.smaller(knot));
            let mut checked = Ok(T::zero());
            evenly((from, to), 1, &mut |place, share| {
                let load = pressure.at(place);
                checked = checked.and_then(|_| Named("pressure", load).non_negative());
                let polynomials = lagrange(place / width - lit(first as f64), count);
                let nodes = weights.iter_mut().skip(first).zip(polynomials).take(count);
                nodes.for_each(|(weight, l)| *weight += load * share * l);
            });
            ParameterError::of_component(cell, checked)?;
            from = to;
        }
    }
    Ok(weights)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test panics to fail")]
mod tests {
    use super::*;
    use crate::{FunctionPressure, PolynomialExponential};
    use bristle::signal::{Polyline, Vertex};

    #[test]
    fn the_weights_are_positive_and_carry_the_pressure() {
        for cells in [1, 2, 3, 4, 5, 6, 7, 12, 50, 333] {
            let check = |weights: Vec<f64>| {
                assert!(weights.iter().all(|&weight| weight >= 0.0), "{cells}: {weights:?}");
                // As many roundings as nodes.
                let sum = weights.iter().sum::<f64>();
                assert!((sum - 1.0).abs() < 1e-13, "{cells}: {sum}");
            };
            check(weights(&PolynomialExponential::constant(), cells).unwrap());
            check(weights(&PolynomialExponential::parabolic(), cells).unwrap());
            for decay in [-50.0, -3.0, 0.1, 50.0] {
                let steep = PolynomialExponential::exponential(decay).unwrap();
                check(weights(&steep, cells).unwrap());
            }
        }
    }

    #[test]
    fn a_pressure_with_kinks_within_the_cells_enters_exactly() {
        // The mean and the first moment of 1 at the edges, 3 at ξ = 0.3 and 0.5 at ξ = 0.41.
        let points = [(0.0, 1.0), (0.3, 3.0), (0.41, 0.5), (1.0, 1.0)];
        let vertices = points.map(|(time, value)| Vertex { time, value });
        let kinked = FunctionPressure::new(Polyline::new(vertices).unwrap()).unwrap();
        let (mut mean, mut moment) = (0.0, 0.0);
        for pair in points.windows(2) {
            let [(a, p), (b, q)] = [pair[0], pair[1]];
            mean += 0.5 * (b - a) * (p + q);
            moment += (b - a) * (p * (2.0 * a + b) + q * (a + 2.0 * b)) / 6.0;
        }
        for cells in [1, 3, 7, 20] {
            let weights: Vec<f64> = weights(&kinked, cells).unwrap();
            let first = |(i, weight): (usize, &f64)| weight * i as f64 / cells as f64;
            let found = weights.iter().enumerate().map(first).sum::<f64>();
            assert!((weights.iter().sum::<f64>() - mean).abs() < 1e-14, "{cells}");
            assert!((found - moment).abs() < 1e-14, "{cells}: {found} {moment}");
        }
    }

    #[test]
    fn the_error_of_a_smooth_integral_falls_with_the_fifth_power() {
        // ∫₀¹ 6ξ(1 − ξ) cos(5ξ) dξ in closed form.
        let exact = {
            // With c(ξ) = cos(5ξ), two integrations by parts.
            let (s, c) = (5f64.sin(), 5f64.cos());
            6.0 * (-(1.0 + c) / 25.0 + 2.0 * s / 125.0)
        };
        let error = |cells: usize| {
            let weights: Vec<f64> = weights(&PolynomialExponential::parabolic(), cells).unwrap();
            let f = |i: usize| (5.0 * i as f64 / cells as f64).cos();
            (weights.iter().enumerate().map(|(i, w)| w * f(i)).sum::<f64>() - exact).abs()
        };
        let (coarse, fine) = (error(40), error(80));
        assert!(fine < 1e-8 && coarse > 24.0 * fine, "{coarse:e} {fine:e}");
    }
}
