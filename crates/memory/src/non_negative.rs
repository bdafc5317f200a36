//! Least squares with unknowns that are zero or positive.
//!
//! min ½ xᵀ G x − bᵀ x,  x ≥ 0
//!
//! with a symmetric positive definite G: one minimum. Unknowns enter the free set one by one, where
//! the gradient promises most, and leave it where their solution would turn negative.
//!
//! Source: C. L. Lawson, R. J. Hanson, "Solving Least Squares Problems", Prentice-Hall 1974,
//! chapter 23, on normal equations as R. Bro, S. De Jong, "A fast non-negativity-constrained least
//! squares algorithm", Journal of Chemometrics 11 (1997), 393–401.

use bristle::Scalar;
use bristle::nalgebra::{SMatrix, SVector};
use bristle::scalar::lit;

/// The minimum. Entries that are held are exactly zero, and so are those of columns that the free
/// ones make up.
pub(crate) fn minimise<T: Scalar, const N: usize>(
    matrix: &SMatrix<T, N, N>,
    right: &SVector<T, N>,
) -> SVector<T, N> {
    // In units in which the diagonal is one; zero, where there is nothing to choose.
    let unit = SVector::<T, N>::from_fn(|i, _| {
        let diagonal = matrix[(i, i)];
        if diagonal > T::zero() { T::one() / diagonal.sqrt() } else { T::zero() }
    });
    let matrix = SMatrix::from_fn(|i, j| matrix[(i, j)] * unit[i] * unit[j]);
    let right = right.component_mul(&unit);
    let rounding = lit::<T>(64.0) * T::default_epsilon() * right.amax();
    let (mut free, mut barred) = ([false; N], [false; N]);
    let mut x = SVector::<T, N>::zeros();
    // As many passes as unknowns are usual; the bound ends a cycle made by roundings.
    for _ in 0..10 * N {
        let gradient = right - matrix * x;
        let candidates = (0..N).filter(|&i| !free[i] && !barred[i] && gradient[i] > rounding);
        let steepest = candidates.reduce(|a, b| if gradient[b] > gradient[a] { b } else { a });
        let Some(entering) = steepest else { break };
        free[entering] = true;
        loop {
            let Some(solution) = solved(&matrix, &right, &free) else {
                (free[entering], barred[entering]) = (false, true);
                break;
            };
            // The unknown that reaches zero first on the way.
            let reached = (0..N).filter(|&i| free[i] && !(solution[i] > T::zero()));
            let steps = reached.map(|i| (x[i] / (x[i] - solution[i]), i));
            let Some((step, leaving)) = steps.reduce(|a, b| if b.0 < a.0 { b } else { a }) else {
                x = solution;
                break;
            };
            x += (solution - x) * step;
            (x[leaving], free[leaving]) = (T::zero(), false);
            barred[leaving] |= leaving == entering;
        }
    }
    x.component_mul(&unit)
}

/// The solution with the unknowns that are not free at zero.
fn solved<T: Scalar, const N: usize>(
    matrix: &SMatrix<T, N, N>,
    right: &SVector<T, N>,
    free: &[bool; N],
) -> Option<SVector<T, N>> {
    let kept = SMatrix::<T, N, N>::from_fn(|i, j| {
        let value = if free[i] && free[j] { matrix[(i, j)] } else { T::zero() };
        if i == j && !free[i] { T::one() } else { value }
    });
    let right = SVector::<T, N>::from_fn(|i, _| if free[i] { right[i] } else { T::zero() });
    kept.cholesky().map(|factor| factor.solve(&right))
}
