//! Symmetric band matrices: products, and L D Lᵀ in place.
//!
//! A matrix of half-width b is stored row by row, of row i the entries of columns i − b … i, so
//! that the diagonal is last: b = 0 is a diagonal matrix, b = n − 1 a dense one. Entries before
//! column 0 are never read.

use bristle::Scalar;
use bristle::scalar::is_zero;

/// Σ aₖ bₖ.
#[inline(always)]
fn dot<T: Scalar>(a: &[T], b: &[T]) -> T {
    a.iter().zip(b).fold(T::zero(), |sum, (&a, &b)| sum + a * b)
}

/// The place of entry (i, j), j ≤ i, of a matrix with rows of so many entries.
#[inline(always)]
pub(crate) fn place(width: usize, i: usize, j: usize) -> usize {
    // Rows of a user's own may name any coordinate.
    width.wrapping_mul(i.wrapping_add(1)).wrapping_sub(1 + (i - j))
}

/// y ← y − A x − B u, both of one width.
#[inline(always)]
pub(crate) fn subtract_products<T: Scalar>(
    width: usize,
    [a, b]: [&[T]; 2],
    [x, u]: [&[T]; 2],
    y: &mut [T],
) {
    match width {
        1 => {
            let terms = a.iter().zip(x).zip(b.iter().zip(u));
            for (y, ((&a, &x), (&b, &u))) in y.iter_mut().zip(terms) {
                *y -= a * x + b * u;
            }
        }
        2 => subtract_wide(2, [a, b], [x, u], y),
        _ => subtract_wide(width, [a, b], [x, u], y),
    }
}

#[inline(always)]
fn subtract_wide<T: Scalar>(width: usize, [a, b]: [&[T]; 2], [x, u]: [&[T]; 2], y: &mut [T]) {
    let reach = width - 1;
    for (i, rows) in a.chunks_exact(width).zip(b.chunks_exact(width)).enumerate() {
        let (first, here) = (i.saturating_sub(reach), [x[i], u[i]]);
        let (above, from) = y.split_at_mut(i);
        let mut sum = rows.0[reach] * here[0] + rows.1[reach] * here[1];
        let entries = rows.0[first + reach - i..].iter().zip(&rows.1[first + reach - i..]);
        let before = x[first..i].iter().zip(&u[first..i]);
        for ((y, (&a, &b)), (&x, &u)) in above[first..].iter_mut().zip(entries).zip(before) {
            sum += a * x + b * u;
            *y -= a * here[0] + b * here[1];
        }
        from[0] -= sum;
    }
}

/// xᵀ A x.
pub(crate) fn quadratic<T: Scalar>(width: usize, matrix: &[T], x: &[T]) -> T {
    let reach = width - 1;
    let mut total = T::zero();
    for (i, row) in matrix.chunks_exact(width).enumerate() {
        let first = i.saturating_sub(reach);
        let beside = dot(&row[first + reach - i..reach], &x[first..i]);
        total += (row[reach] * x[i] + beside + beside) * x[i];
    }
    total
}

/// A = L D Lᵀ in place, L with a unit diagonal, 1/D on the diagonal. Each row is handed out as it
/// is finished: its number, the row of L D (the pivot last), and 1/pivot.
#[inline(always)]
fn factor_wide<T: Scalar>(width: usize, matrix: &mut [T], mut done: impl FnMut(usize, &[T], T)) {
    let reach = width - 1;
    for i in 0..matrix.len() / width {
        let (above, from) = matrix.split_at_mut(i * width);
        let row = &mut from[..width];
        let first = i.saturating_sub(reach);
        for j in first..i {
            let other = &above[j * width..][..width];
            let known = dot(&row[first + reach - i..j + reach - i], &other[first + reach - j..]);
            row[j + reach - i] -= known;
        }
        let mut pivot = row[reach];
        for j in first..i {
            let scaled = row[j + reach - i];
            pivot -= scaled * (scaled * above[j * width + reach]);
        }
        row[reach] = pivot;
        let reciprocal = T::one() / pivot;
        done(i, &row[first + reach - i..], reciprocal);
        for j in first..i {
            row[j + reach - i] *= above[j * width + reach];
        }
        row[reach] = reciprocal;
    }
}

/// A = L D Lᵀ in place. Hands out each pivot.
#[inline(always)]
pub(crate) fn factor<T: Scalar>(width: usize, matrix: &mut [T], mut pivot: impl FnMut(usize, T)) {
    factor_wide(width, matrix, |i, row, _| {
        if let Some(&last) = row.last() {
            pivot(i, last);
        }
    });
}

/// A = L D Lᵀ in place, and x ← A⁻¹ x.
#[inline(always)]
pub(crate) fn factor_and_solve<T: Scalar>(width: usize, matrix: &mut [T], x: &mut [T]) {
    if width == 2 {
        return solve_tridiagonal(matrix.as_chunks_mut().0, x);
    }
    factor_wide(width, matrix, |i, row, reciprocal| {
        let (above, from) = x.split_at_mut(i);
        let known = dot(row, &above[i + 1 - row.len()..]);
        from[0] = (from[0] - known) * reciprocal;
    });
    back(width, matrix, x);
}

/// x ← A⁻¹ x of a tridiagonal matrix, which is lost: from both ends to the middle and back, so that
/// the divisions of one half do not wait for those of the other.
#[inline(always)]
fn solve_tridiagonal<T: Scalar>(rows: &mut [[T; 2]], x: &mut [T]) {
    let half = rows.len() / 2;
    let ((above, rest), (x_above, x_rest)) = (rows.split_at_mut(half), x.split_at_mut(half));
    let (Some((centre, below)), Some((x_centre, x_below))) =
        (rest.split_first_mut(), x_rest.split_first_mut())
    else {
        return;
    };
    above.first_mut().unwrap_or(centre)[0] = T::zero();
    // Of the row before 1/pivot and x/pivot.
    let eliminate = |beside: T, last: [T; 2], row: &mut [T; 2], x: &mut T| {
        row[1] = T::one() / (row[1] - beside * beside * last[0]);
        *x = (*x - beside * last[1]) * row[1];
        [row[1], *x]
    };
    let [mut top, mut bottom] = [[T::zero(); 2]; 2];
    let mut beside = T::zero();
    let mut lower = below.iter_mut().zip(&mut *x_below).rev();
    for (row, x) in above.iter_mut().zip(&mut *x_above) {
        top = eliminate(row[0], top, row, x);
        if let Some((row, x)) = lower.next() {
            bottom = eliminate(beside, bottom, row, x);
            beside = row[0];
        }
    }
    centre[1] -= beside * beside * bottom[0];
    *x_centre -= beside * bottom[1];
    let [_, mut up] = eliminate(centre[0], top, centre, x_centre);
    let (mut down, mut beside) = (up, centre[0]);
    let mut lower = below.iter().zip(x_below);
    for (row, x) in above.iter().zip(x_above).rev() {
        *x -= row[1] * beside * up;
        (up, beside) = (*x, row[0]);
        if let Some((row, x)) = lower.next() {
            *x -= row[1] * row[0] * down;
            down = *x;
        }
    }
}

/// x ← A⁻¹ x with the factors of A.
#[inline(always)]
pub(crate) fn solve<T: Scalar>(width: usize, factors: &[T], x: &mut [T]) {
    match width {
        1 => {
            for (x, &reciprocal) in x.iter_mut().zip(factors) {
                *x *= reciprocal;
            }
        }
        2 => solve_wide(2, factors, x),
        _ => solve_wide(width, factors, x),
    }
}

#[inline(always)]
fn solve_wide<T: Scalar>(width: usize, factors: &[T], x: &mut [T]) {
    let reach = width - 1;
    for (i, row) in factors.chunks_exact(width).enumerate() {
        let first = i.saturating_sub(reach);
        let known = dot(&row[first + reach - i..reach], &x[first..i]);
        x[i] -= known;
    }
    for (x, row) in x.iter_mut().zip(factors.chunks_exact(width)) {
        *x *= row[reach];
    }
    back(width, factors, x);
}

/// x ← L⁻ᵀ x.
#[inline(always)]
fn back<T: Scalar>(width: usize, factors: &[T], x: &mut [T]) {
    let reach = width - 1;
    for (i, row) in factors.chunks_exact(width).enumerate().rev() {
        let first = i.saturating_sub(reach);
        let (above, from) = x.split_at_mut(i);
        let found = from[0];
        for (x, &factor) in above[first..].iter_mut().zip(&row[first + reach - i..]) {
            *x -= factor * found;
        }
    }
}

/// A x = b of a full matrix without pivoting, both in place: for I + G D with G = Gᵀ ≥ 0 and D ≥ 0
/// diagonal, which is similar to I + √D G √D, so that every pivot is at least 1.
#[inline(always)]
pub(crate) fn eliminate<T: Scalar>(matrix: &mut [T], x: &mut [T]) {
    let size = x.len();
    for k in 0..size {
        let (above, below) = matrix.split_at_mut((k + 1) * size);
        let pivot_row = &above[k * size..];
        // No chunks: their count would be an integer division.
        for i in k + 1..size {
            let row = &mut below[(i - k - 1) * size..][..size];
            let factor = row[k] / pivot_row[k];
            if !is_zero(factor) {
                for (a, &b) in row[k + 1..].iter_mut().zip(&pivot_row[k + 1..]) {
                    *a -= factor * b;
                }
                x[i] -= factor * x[k];
            }
        }
    }
    for k in (0..size).rev() {
        let row = &matrix[k * size..][..size];
        let known = dot(&row[k + 1..], &x[k + 1..]);
        x[k] = (x[k] - known) / row[k];
    }
}
