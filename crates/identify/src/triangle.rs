//! Linear least squares row by row: the triangular factor of all rows so far, by Givens rotations.

use nalgebra::{DMatrix, DVector};

/// The factors R and Qᵀb of a tall least-squares problem A x ≈ b, whose rows are not stored.
///
/// Unlike the normal equations AᵀA, it does not square the condition number.
pub(super) struct Triangle {
    factor: DMatrix<f64>,
    right: DVector<f64>,
}

impl Triangle {
    /// No rows yet, for so many unknowns.
    pub(super) fn new(unknowns: usize) -> Self {
        Self { factor: DMatrix::zeros(unknowns, unknowns), right: DVector::zeros(unknowns) }
    }

    /// Number of unknowns.
    fn unknowns(&self) -> usize {
        self.right.len()
    }

    /// Adds the row aᵀx ≈ b; the row is used up.
    pub(super) fn push(&mut self, row: &mut DVector<f64>, mut right: f64) {
        for i in 0..self.unknowns() {
            let length = (self.factor[(i, i)].powi(2) + row[i].powi(2)).sqrt();
            // Squares of small numbers may be zero.
            if row[i] == 0.0 || length == 0.0 {
                continue;
            }
            let (cos, sin) = (self.factor[(i, i)] / length, row[i] / length);
            self.factor[(i, i)] = length;
            let turn = |above: &mut f64, below: &mut f64| {
                (*above, *below) = (cos * *above + sin * *below, cos * *below - sin * *above);
            };
            for j in i + 1..self.unknowns() {
                turn(&mut self.factor[(i, j)], &mut row[j]);
            }
            turn(&mut self.right[i], &mut right);
        }
    }

    /// Aᵀb.
    pub(super) fn gradient(&self) -> DVector<f64> {
        self.factor.tr_mul(&self.right)
    }

    /// The length of each column of A.
    pub(super) fn column_norms(&self) -> DVector<f64> {
        DVector::from_fn(self.unknowns(), |j, _| self.factor.column(j).norm())
    }

    /// |A x|².
    pub(super) fn image_squared(&self, x: &DVector<f64>) -> f64 {
        (&self.factor * x).norm_squared()
    }

    /// The x that minimises |A x − b|² + |D x|² with D diagonal, with x zero in every component
    /// that is not `free`.
    pub(super) fn damped(&self, diagonal: &DVector<f64>, free: &[bool]) -> DVector<f64> {
        let mut both = Self::new(self.unknowns());
        let damping = DMatrix::from_diagonal(diagonal);
        let rows = self.factor.row_iter().zip(self.right.iter().copied());
        for (row, right) in rows.chain(damping.row_iter().map(|row| (row, 0.0))) {
            let entries = row.iter().zip(free).map(|(&x, &free)| if free { x } else { 0.0 });
            both.push(&mut DVector::from_iterator(self.unknowns(), entries), right);
        }
        // A row that stayed empty leaves its component zero.
        for i in 0..self.unknowns() {
            if both.factor[(i, i)] == 0.0 {
                both.factor[(i, i)] = 1.0;
            }
        }
        let solved = both.factor.solve_upper_triangular(&both.right);
        solved.unwrap_or_else(|| DVector::zeros(self.unknowns()))
    }

    /// Singular values, largest first, and right singular vectors of A, its free columns scaled to
    /// length one. Columns that are zero or not free are left out: their entries are zero.
    pub(super) fn directions(&self, free: &[bool]) -> Vec<(f64, DVector<f64>)> {
        let norms = self.column_norms();
        let free = free.iter().zip(&norms).map(|(&free, &norm)| free && norm > 0.0);
        let kept: Vec<usize> = free.enumerate().filter_map(|(j, kept)| kept.then_some(j)).collect();
        let scaled = DMatrix::from_fn(self.unknowns(), kept.len(), |i, j| {
            self.factor[(i, kept[j])] / norms[kept[j]]
        });
        if kept.is_empty() || scaled.iter().any(|x| !x.is_finite()) {
            return Vec::new();
        }
        let svd = scaled.svd(false, true);
        let rows = svd.v_t.iter().flat_map(|v| v.row_iter());
        let directions = svd.singular_values.iter().zip(rows).map(|(&value, row)| {
            let mut direction = DVector::zeros(self.unknowns());
            kept.iter().zip(row.iter()).for_each(|(&j, &entry)| direction[j] = entry);
            (value, direction)
        });
        directions.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::Triangle;
    use nalgebra::dvector;

    /// The rows (1, x) ≈ y of four points: the line through them is y = 0.9 + 1.4 x by hand.
    fn line() -> Triangle {
        let mut triangle = Triangle::new(2);
        for (x, y) in [(0.0, 1.0), (1.0, 2.0), (2.0, 4.0), (3.0, 5.0)] {
            triangle.push(&mut dvector![1.0, x], y);
        }
        triangle
    }

    #[test]
    fn rows_pushed_one_by_one_give_the_line_through_the_points() {
        let x = line().damped(&dvector![0.0, 0.0], &[true, true]);
        assert!((&x - dvector![0.9, 1.4]).amax() < 1e-14, "{x}");
        // Without the slope, the mean.
        let x = line().damped(&dvector![0.0, 0.0], &[true, false]);
        assert!((&x - dvector![3.0, 0.0]).amax() < 1e-14, "{x}");
    }

    #[test]
    fn damping_adds_to_the_normal_equations() {
        // (AᵀA + D²) x = Aᵀb with AᵀA = (4, 6; 6, 14), Aᵀb = (12, 25) and D² = (1, 4): det = 5·18 −
        // 36 = 54.
        let x = line().damped(&dvector![1.0, 2.0], &[true, true]);
        let want = dvector![(12.0 * 18.0 - 6.0 * 25.0) / 54.0, (5.0 * 25.0 - 6.0 * 12.0) / 54.0];
        assert!((&x - want).amax() < 1e-14, "{x}");
        assert!((line().gradient() - dvector![12.0, 25.0]).amax() < 1e-13);
        assert!((line().image_squared(&dvector![1.0, 1.0]) - 30.0).abs() < 1e-13);
    }

    #[test]
    fn a_combination_without_effect_is_found() {
        let mut triangle = Triangle::new(2);
        for x in [1.0, 2.0, 3.0] {
            triangle.push(&mut dvector![x, 10.0 * x], 1.0);
        }
        let directions = triangle.directions(&[true, true]);
        let (weakest, direction) = (directions[1].0, &directions[1].1);
        assert!(weakest < 1e-14 && (direction[0] + direction[1]).abs() < 1e-14, "{directions:?}");
    }

    #[test]
    fn a_column_of_zeros_is_left_out() {
        let mut triangle = Triangle::new(2);
        triangle.push(&mut dvector![3.0, 1e-200], 1.0);
        assert_eq!(
            triangle.damped(&dvector![0.0, 1e-200], &[true, true]),
            dvector![1.0 / 3.0, 0.0]
        );
        let mut triangle = Triangle::new(2);
        triangle.push(&mut dvector![3.0, 0.0], 1.0);
        let directions = triangle.directions(&[true, true]);
        assert_eq!((directions.len(), directions[0].0), (1, 1.0), "{directions:?}");
        assert_eq!(directions[0].1.map(f64::abs), dvector![1.0, 0.0], "{directions:?}");
    }
}
