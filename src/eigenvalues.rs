//! Eigenvalues of a small real matrix, on the stack.
//!
//! The rows and columns are brought to similar sizes, the matrix is rotated to Hessenberg form, and
//! shifted QR steps in complex arithmetic split off one eigenvalue after the other.
//!
//! Source: G. H. Golub, C. F. Van Loan, "Matrix Computations", 4th edition (Johns Hopkins, 2013),
//! sections 7.4 and 7.5.

use nalgebra::{Complex, ComplexField, SMatrix};

/// QR steps per eigenvalue; two or three are usual.
const MOST_STEPS: usize = 60;

/// The eigenvalues in no order; `None` if the matrix is not finite or the QR steps do not settle.
pub(crate) fn eigenvalues<const N: usize>(
    matrix: &SMatrix<f64, N, N>,
) -> Option<[Complex<f64>; N]> {
    if !matrix.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    let mut a = balanced(*matrix).map(|entry| Complex::new(entry, 0.0));
    for column in 0..N.saturating_sub(2) {
        for row in column + 2..N {
            let rotation = Rotation::new(a[(column + 1, column)], a[(row, column)]);
            rotation.rows(&mut a, (column + 1, row), 0..N);
            rotation.columns(&mut a, (column + 1, row), 0..N);
        }
    }
    let whole = ComplexField::sqrt(a.iter().map(Complex::norm_sqr).sum::<f64>());
    let mut last = N.saturating_sub(1);
    let mut steps = 0;
    while last > 0 {
        // The block that ends at `last` starts where the entry below the diagonal vanishes.
        let mut first = last;
        while first > 0 {
            let near = length(a[(first, first)]) + length(a[(first - 1, first - 1)]);
            let size = if near > 0.0 { near } else { whole };
            if length(a[(first, first - 1)]) <= f64::EPSILON * size {
                break;
            }
            first -= 1;
        }
        if first == last {
            last -= 1;
            steps = 0;
            continue;
        }
        if steps == MOST_STEPS {
            return None;
        }
        steps += 1;
        let shift = if steps % 10 == 0 {
            // Out of a cycle, by a shift that is none of the matrix's own.
            a[(last, last)] + length(a[(last, last - 1)])
        } else {
            nearest(&a, last)
        };
        step(&mut a, first, last, shift);
    }
    Some(core::array::from_fn(|i| a[(i, i)]))
}

/// One QR step on a diagonal block: A − κI = QR, A ← RQ + κI.
fn step<const N: usize>(
    a: &mut SMatrix<Complex<f64>, N, N>,
    first: usize,
    last: usize,
    shift: Complex<f64>,
) {
    for i in first..=last {
        a[(i, i)] -= shift;
    }
    let mut rotations = [Rotation::NONE; N];
    for (i, rotation) in rotations.iter_mut().enumerate().take(last).skip(first) {
        *rotation = Rotation::new(a[(i, i)], a[(i + 1, i)]);
        rotation.rows(a, (i, i + 1), i..last + 1);
    }
    for (i, rotation) in rotations.iter().enumerate().take(last).skip(first) {
        rotation.columns(a, (i, i + 1), first..i + 2);
    }
    for i in first..=last {
        a[(i, i)] += shift;
    }
}

/// The eigenvalue of the last 2 × 2 block that is nearest to its last entry.
fn nearest<const N: usize>(a: &SMatrix<Complex<f64>, N, N>, last: usize) -> Complex<f64> {
    let (one, other) = (a[(last - 1, last - 1)], a[(last, last)]);
    let coupling = a[(last - 1, last)] * a[(last, last - 1)];
    let half = (one - other) * 0.5;
    let root = ComplexField::sqrt(half * half + coupling);
    let (plus, minus) = (half + root, half - root);
    let far = if plus.norm_sqr() > minus.norm_sqr() { plus } else { minus };
    if far.norm_sqr() == 0.0 { other } else { other - coupling / far }
}

/// A plane rotation that turns (a, b) into (r, 0).
#[derive(Debug, Clone, Copy)]
struct Rotation {
    cosine: Complex<f64>,
    sine: Complex<f64>,
}

impl Rotation {
    const NONE: Self = Self { cosine: Complex::new(1.0, 0.0), sine: Complex::new(0.0, 0.0) };

    fn new(a: Complex<f64>, b: Complex<f64>) -> Self {
        let size = ComplexField::sqrt(a.norm_sqr() + b.norm_sqr());
        if size > 0.0 { Self { cosine: a / size, sine: b / size } } else { Self::NONE }
    }

    /// From the left.
    fn rows<const N: usize>(
        self,
        m: &mut SMatrix<Complex<f64>, N, N>,
        (i, j): (usize, usize),
        columns: core::ops::Range<usize>,
    ) {
        for k in columns {
            let (x, y) = (m[(i, k)], m[(j, k)]);
            m[(i, k)] = self.cosine.conj() * x + self.sine.conj() * y;
            m[(j, k)] = self.cosine * y - self.sine * x;
        }
    }

    /// Its inverse from the right.
    fn columns<const N: usize>(
        self,
        m: &mut SMatrix<Complex<f64>, N, N>,
        (i, j): (usize, usize),
        rows: core::ops::Range<usize>,
    ) {
        for k in rows {
            let (x, y) = (m[(k, i)], m[(k, j)]);
            m[(k, i)] = x * self.cosine + y * self.sine;
            m[(k, j)] = y * self.cosine.conj() - x * self.sine.conj();
        }
    }
}

fn length(z: Complex<f64>) -> f64 {
    z.re.abs() + z.im.abs()
}

/// The matrix in units (powers of two) in which row and column i are of similar size: a micrometre
/// of deflection and 10⁵ Pa then count alike.
fn balanced<const N: usize>(mut a: SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    // Two or three sweeps suffice; a few more for units that are far apart.
    for _ in 0..20 {
        let mut settled = true;
        for i in 0..N {
            let others = (0..N).filter(|&j| j != i);
            let (column, row) =
                others.fold((0.0, 0.0), |(c, r), j| (c + a[(j, i)].abs(), r + a[(i, j)].abs()));
            if !(column > 0.0 && row > 0.0) {
                continue;
            }
            // The power of two next to √(row/column).
            let mut unit = 1.0;
            for _ in 0..1100 {
                if column * unit * unit * 2.0 < row {
                    unit *= 2.0;
                } else if column * unit * unit > row * 2.0 {
                    unit *= 0.5;
                } else {
                    break;
                }
            }
            if column * unit + row / unit < 0.95 * (column + row) {
                settled = false;
                for j in 0..N {
                    a[(j, i)] *= unit;
                    a[(i, j)] /= unit;
                }
            }
        }
        if settled {
            break;
        }
    }
    a
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test panics to fail")]
mod tests {
    use super::*;
    use nalgebra::{Matrix2, Matrix3, Matrix4};

    /// The eigenvalues sorted by imaginary, then real part.
    fn sorted<const N: usize>(matrix: SMatrix<f64, N, N>) -> [Complex<f64>; N] {
        let mut values = eigenvalues(&matrix).unwrap();
        values.sort_by(|a, b| {
            // Real ones have an imaginary part of a few roundings.
            let side = |z: &Complex<f64>| if z.im.abs() > 1e-9 { z.im } else { 0.0 };
            (side(a), a.re).partial_cmp(&(side(b), b.re)).unwrap()
        });
        values
    }

    fn assert_near(got: &[Complex<f64>], want: &[(f64, f64)], tolerance: f64) {
        for (got, want) in got.iter().zip(want) {
            let off = ((got.re - want.0).powi(2) + (got.im - want.1).powi(2)).sqrt();
            assert!(off <= tolerance, "{got} is not {want:?}");
        }
    }

    #[test]
    fn matrices_whose_eigenvalues_are_known_give_them() {
        assert_near(&sorted(SMatrix::<f64, 1, 1>::new(-3.0)), &[(-3.0, 0.0)], 0.0);
        let rotation = Matrix2::new(0.0, 1.0, -1.0, 0.0);
        assert_near(&sorted(rotation), &[(0.0, -1.0), (0.0, 1.0)], 1e-15);
        // A cyclic permutation, on which unshifted QR steps stand still: the cube roots of one.
        let cycle = Matrix3::new(0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0);
        let h = 0.75f64.sqrt();
        assert_near(&sorted(cycle), &[(-0.5, -h), (1.0, 0.0), (-0.5, h)], 1e-14);
        // Companion matrix of (s − 1)(s − 2)(s − 3)(s − 4).
        let companion = Matrix4::new(
            10.0, -35.0, 50.0, -24.0, //
            1.0, 0.0, 0.0, 0.0, //
            0.0, 1.0, 0.0, 0.0, //
            0.0, 0.0, 1.0, 0.0,
        );
        let want = [(1.0, 0.0), (2.0, 0.0), (3.0, 0.0), (4.0, 0.0)];
        // The condition of its eigenvalues is about 1e2.
        assert_near(&sorted(companion), &want, 1e-12);
    }

    #[test]
    fn units_do_not_matter() {
        // s² + 2 s + 5 with the first state in nanometres, the second in gigametres.
        let matrix = Matrix2::new(0.0, 1e18, -5e-18, -2.0);
        assert_near(&sorted(matrix), &[(-1.0, -2.0), (-1.0, 2.0)], 1e-14);
    }

    #[test]
    fn a_matrix_that_is_not_finite_has_no_answer() {
        assert!(eigenvalues(&Matrix2::new(f64::NAN, 0.0, 0.0, 1.0)).is_none());
        assert!(eigenvalues(&Matrix2::new(0.0, f64::INFINITY, 0.0, 1.0)).is_none());
    }
}
