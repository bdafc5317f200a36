//! Eigenvalues of a small real matrix, on the stack.
//!
//! Rows and columns are scaled to similar sizes, reflections bring the matrix to Hessenberg form,
//! and double-shift QR steps split off real eigenvalues and conjugate pairs.
//!
//! Source: G. H. Golub, C. F. Van Loan, "Matrix Computations", 4th edition (Johns Hopkins, 2013),
//! section 7.5.

use nalgebra::{Complex, ComplexField, SMatrix, SVector};

/// QR steps per eigenvalue; two or three are usual.
const MOST_STEPS: usize = 60;

/// The eigenvalues of a matrix, in no order.
///
/// Real eigenvalues have an imaginary part of exactly zero, the others come in exact conjugates.
/// `None` if the matrix is not finite or the QR steps do not converge.
pub(crate) fn eigenvalues<const N: usize>(
    matrix: &SMatrix<f64, N, N>,
) -> Option<[Complex<f64>; N]> {
    let mut values = [Complex::new(0.0, 0.0); N];
    if !matrix.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    // In units of the largest entry squares neither overflow nor vanish.
    let unit = matrix.amax();
    if unit == 0.0 {
        return Some(values);
    }
    let mut a = balanced(matrix / unit);
    for k in 1..N.saturating_sub(1) {
        let below = SVector::from_fn(|i, _| if i < k { 0.0 } else { a[(i, k - 1)] });
        reflect(&mut a, k, below);
    }
    let whole = a.norm();
    let (mut end, mut steps) = (N, 0);
    while let Some(last) = end.checked_sub(1) {
        // The block that ends at `last` starts where the entry below the diagonal vanishes.
        let mut first = last;
        while first > 0 {
            let near = a[(first, first)].abs() + a[(first - 1, first - 1)].abs();
            let size = if near > 0.0 { near } else { whole };
            if a[(first, first - 1)].abs() <= f64::EPSILON * size {
                a[(first, first - 1)] = 0.0;
                break;
            }
            first -= 1;
        }
        if first == last {
            values[last].re = a[(last, last)] * unit;
        } else if first + 1 == last {
            [values[first], values[last]] = pair(&a, last).map(|value| value * unit);
        } else if steps == MOST_STEPS {
            return None;
        } else {
            steps += 1;
            double_step(&mut a, first, last, steps % 10 == 0);
            continue;
        }
        (end, steps) = (first, 0);
    }
    Some(values)
}

/// The eigenvalues of the diagonal 2 × 2 block that ends at `last`.
fn pair<const N: usize>(a: &SMatrix<f64, N, N>, last: usize) -> [Complex<f64>; 2] {
    let (one, other) = (a[(last - 1, last - 1)], a[(last, last)]);
    let coupling = a[(last - 1, last)] * a[(last, last - 1)];
    let half = 0.5 * (one - other);
    let square = half * half + coupling;
    if square < 0.0 {
        let value = Complex::new(other + half, ComplexField::sqrt(-square));
        return [value, value.conj()];
    }
    let far = half + ComplexField::sqrt(square).copysign(half);
    let near = if far == 0.0 { 0.0 } else { -coupling / far };
    [Complex::new(other + far, 0.0), Complex::new(other + near, 0.0)]
}

/// One QR step with two shifts on the diagonal block `first..=last` of at least three rows.
fn double_step<const N: usize>(
    a: &mut SMatrix<f64, N, N>,
    first: usize,
    last: usize,
    exceptional: bool,
) {
    let below = |k: usize| a[(k + 1, k)];
    // Sum and product of the shifts: the eigenvalues of the last 2 × 2 block, or, out of a cycle,
    // numbers of the size of the entries below the diagonal.
    let (sum, product) = if exceptional {
        let size = below(last - 1).abs() + below(last - 2).abs();
        (1.5 * size, size * size)
    } else {
        let (one, other) = (a[(last - 1, last - 1)], a[(last, last)]);
        (one + other, one * other - a[(last - 1, last)] * below(last - 1))
    };
    let (one, next) = (a[(first, first)], a[(first + 1, first + 1)]);
    let mut column = SVector::zeros();
    column[first] = one * (one - sum) + a[(first, first + 1)] * below(first) + product;
    column[first + 1] = below(first) * (one + next - sum);
    column[first + 2] = below(first) * below(first + 1);
    reflect(a, first, column);
    // The entries that this made below the Hessenberg form are chased down.
    for k in first..last - 1 {
        let end = last.min(k + 3);
        let bulge = |i, _| if i > k && i <= end { a[(i, k)] } else { 0.0 };
        reflect(a, k + 1, SVector::from_fn(bulge));
        for i in k + 2..=end {
            a[(i, k)] = 0.0;
        }
    }
}

/// A ← H A H with the reflection H that turns a vector, zero before `start`, into a multiple of the
/// axis `start`.
fn reflect<const N: usize>(a: &mut SMatrix<f64, N, N>, start: usize, vector: SVector<f64, N>) {
    let size = vector.amax();
    if !(size > 0.0) {
        return;
    }
    // H = I − 2 u uᵀ/(uᵀu) with u = x + sgn(x₀)|x| e₀
    let mut u = vector / size;
    u[start] += u.norm().copysign(u[start]);
    let scale = 2.0 / u.norm_squared();
    let columns = u.tr_mul(a) * scale;
    *a -= u * columns;
    let rows = *a * u * scale;
    *a -= rows * u.transpose();
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
            let exponent = 0.5 * (ComplexField::log2(row) - ComplexField::log2(column));
            let unit = ComplexField::powi(2.0, ComplexField::round(exponent) as i32);
            if column * unit + row / unit < 0.95 * (column + row) {
                settled = false;
                a.column_mut(i).scale_mut(unit);
                a.row_mut(i).unscale_mut(unit);
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
