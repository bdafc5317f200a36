//! Values between equidistant nodes: high order where the profile is smooth, no oscillation where
//! it is not.
//!
//! Between two nodes the value is that of the polynomial through up to six nodes. Where the data
//! rise or fall, over the cell and its two neighbours, it is cut to lie between the two nodes; at
//! an extremum it is not. An inlet has no neighbour outside: there the data are continued as they
//! are bent inside, since an extremum enters where the slip reverses.
//!
//! Source: the idea of such limits is A. Suresh, H. T. Huynh, "Accurate monotonicity-preserving
//! schemes with Runge–Kutta time stepping", Journal of Computational Physics 136 (1997), 83–99.

use bristle::Scalar;
use bristle::scalar::{is_zero, lit};

/// Most nodes of a polynomial.
pub(super) const MOST: usize = 6;

/// The nodes of the polynomial for a cell: first and count. Six in the middle, four at the ends.
#[inline]
pub(super) fn stencil(cells: usize, cell: usize) -> (usize, usize) {
    if cells < 3 {
        (0, cells + 1)
    } else if cell >= 2 && cell + 3 <= cells {
        (cell - 2, 6)
    } else {
        (cell.saturating_sub(1).min(cells - 3), 4)
    }
}

/// Weights of the nodes 0 … count − 1 at a place measured in cells.
#[inline]
pub(super) fn lagrange<T: Scalar>(place: T, count: usize) -> [T; MOST] {
    let mut weights = [T::zero(); MOST];
    for (k, weight) in weights.iter_mut().enumerate().take(count) {
        let (mut product, mut scale) = (T::one(), 1.0);
        for m in (0..count).filter(|&m| m != k) {
            product *= place - lit(m as f64);
            scale *= k as f64 - m as f64;
        }
        *weight = product * lit(1.0 / scale);
    }
    weights
}

/// The polynomial of one part of a cell, kept for the next cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct Interpolation<T> {
    part: T,
    /// Where the weights hold: offset of the cell in its stencil, and count.
    kind: (usize, usize),
    weights: [T; MOST],
}

impl<T: Scalar> Interpolation<T> {
    /// For the part θ ∈ [0, 1] of a cell.
    #[inline]
    pub(super) fn new(part: T) -> Self {
        Self { part, kind: (0, 0), weights: [T::zero(); MOST] }
    }

    /// The value in a cell. `values` holds at least two.
    #[inline]
    pub(super) fn at(&mut self, values: &[T], cell: usize) -> T {
        let cells = values.len().saturating_sub(1);
        let (first, count) = stencil(cells, cell);
        let kind = (cell - first.min(cell), count);
        if self.kind != kind {
            self.kind = kind;
            self.weights = lagrange(self.part + lit(kind.0 as f64), count);
        }
        let around = values.get(first..).unwrap_or(&[]);
        let sum = (around.iter().zip(&self.weights).take(count))
            .fold(T::zero(), |sum, (&value, &weight)| sum + weight * value);
        limited(values, cell, sum)
    }
}

/// A value in a cell, cut to the values at its two nodes unless there is an extremum near.
#[inline]
fn limited<T: Scalar>(values: &[T], cell: usize, value: T) -> T {
    let (Some(&here), Some(&next)) = (values.get(cell), values.get(cell + 1)) else { return value };
    let around = values.get(cell.saturating_sub(1)..).unwrap_or(&[]);
    let (mut rises, mut falls) = (false, false);
    for pair in around.windows(2).take(cell.min(1) + 2) {
        if let [a, b] = pair {
            rises |= b > a;
            falls |= b < a;
        }
    }
    // At an inlet, where bristles enter undeflected, an extremum may have entered with them.
    let outside = match *values {
        [a, b, c, d, ..] if cell == 0 && is_zero(a) => before(b, c, d),
        [.., d, c, b, a] if cell + 2 == values.len() && is_zero(a) => -before(b, c, d),
        _ => T::zero(),
    };
    rises |= outside > T::zero();
    falls |= outside < T::zero();
    if rises && falls { value } else { cut(value, here.smaller(next), here.larger(next)) }
}

/// How much the data 0, b, c, d would rise over the cell before them if they were bent there as
/// they are behind: by the lesser of two second differences, by none where these differ in sign.
#[inline]
fn before<T: Scalar>(b: T, c: T, d: T) -> T {
    let (first, second) = ((c - b) - b, (d - c) - (c - b));
    let bend = if (first > T::zero()) != (second > T::zero()) {
        T::zero()
    } else if first.abs() < second.abs() {
        first
    } else {
        second
    };
    b - bend
}

/// A value cut to a range; NaN stays NaN.
#[inline(always)]
pub(super) fn cut<T: Scalar>(value: T, low: T, high: T) -> T {
    value.larger(low).smaller(high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    fn between(values: &[f64], cell: usize, part: f64) -> f64 {
        Interpolation::new(part).at(values, cell)
    }

    #[test]
    fn polynomials_as_high_as_the_stencil_are_met_away_from_extrema() {
        for cells in 1..12 {
            for cell in 0..cells {
                let (_, count) = stencil(cells, cell);
                // Rising on the grid and bent the same way: nothing is cut.
                let f = |x: f64| (x + 2.0).powi(count as i32 - 1);
                let values: Vec<f64> = (0..=cells).map(|i| f(i as f64)).collect();
                for part in [0.0, 0.1, 0.5, 0.83, 1.0] {
                    let (got, want) = (between(&values, cell, part), f(cell as f64 + part));
                    // A few roundings of terms some ten times as large.
                    assert!((got - want).abs() < 1e-13 * f(12.0), "{cells} {cell} {part}");
                }
            }
        }
    }

    #[test]
    fn a_smooth_extremum_is_not_cut() {
        // The error of the polynomial through six nodes falls by 64 when the cells are halved.
        let error = |cells: usize| {
            let width = 1.0 / cells as f64;
            let f = |x: f64| (7.0 * x + 0.3).sin();
            let values: Vec<f64> = (0..=cells).map(|i| f(i as f64 * width)).collect();
            (2..cells - 2)
                .map(|i| (between(&values, i, 0.4) - f((i as f64 + 0.4) * width)).abs())
                .fold(0.0, f64::max)
        };
        let ratio = error(40) / error(80);
        assert!((50.0..80.0).contains(&ratio), "{ratio}");
    }

    #[test]
    fn an_extremum_beside_an_inlet_is_not_cut() {
        // Of parabolas whose tops lie in the first half of the cell at either end.
        for top in [0.05, 0.2, 0.49] {
            let f = |x: f64| x * (2.0 * top - x);
            let forward: Vec<f64> = (0..8).map(|i| f(f64::from(i))).collect();
            let backward: Vec<f64> = forward.iter().rev().copied().collect();
            for part in [0.01, top, 0.6] {
                let want = f(part);
                for got in [between(&forward, 0, part), between(&backward, 6, 1.0 - part)] {
                    assert!((got - want).abs() < 1e-14, "{top} {part}: {got}, not {want}");
                }
            }
        }
    }

    #[test]
    fn rising_data_stay_between_their_neighbours() {
        let rows: [&[f64]; 5] = [
            &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0],
            &[0.0, 1e-6, 1.0, 1.1, 30.0, 31.0, 31.0, 31.5],
            &[0.0, 0.1, 10.0, 11.0],
            &[0.0, 3.0, 3.1],
            &[-1.0, 4.0],
        ];
        for row in rows {
            for cell in 0..row.len() - 1 {
                for part in [0.0, 0.01, 0.3, 0.5, 0.9, 1.0] {
                    let value = between(row, cell, part);
                    assert!(value >= row[cell] && value <= row[cell + 1], "{row:?} {cell} {part}");
                }
            }
        }
    }
}
