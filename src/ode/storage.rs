//! States and matrices of a size known when the program is compiled, or when it runs, and the sums
//! over them: in one order, so that both give the same bits.

use core::fmt::Debug;
use core::ops::{Index, IndexMut};

use nalgebra::{Const, Dyn, MatrixView, SMatrix};

use super::growth::MANY;
use super::step::{Contacts, Few};
use crate::Scalar;

/// Values in a row, columns one after the other.
pub(crate) trait Entries<X>: Clone + Debug {
    /// So many values.
    fn filled(count: usize, value: X) -> Self;

    /// The values.
    fn entries(&self) -> &[X];

    /// The values, to be changed.
    fn entries_mut(&mut self) -> &mut [X];
}

macro_rules! entries {
    ([$($of:tt)*] $storage:ty, |$count:pat_param, $value:ident| $filled:expr) => {
        impl<$($of)*> Entries<X> for $storage {
            #[inline(always)]
            fn filled($count: usize, $value: X) -> Self {
                $filled
            }

            #[inline(always)]
            fn entries(&self) -> &[X] {
                self.as_slice()
            }

            #[inline(always)]
            fn entries_mut(&mut self) -> &mut [X] {
                self.as_mut_slice()
            }
        }
    };
}
entries!([X: nalgebra::Scalar + Copy, const R: usize, const C: usize] SMatrix<X, R, C>,
    |_, value| Self::from_element(value));
entries!([X: Copy + Debug, const K: usize] [X; K], |_, value| [value; K]);
// Not by `vec!`: to ask an allocator for zeros takes longer than to write them.
#[cfg(feature = "alloc")]
entries!([X: Copy + Debug] alloc::vec::Vec<X>, |count, value| {
    core::iter::repeat_n(value, count).collect()
});

/// The states of a system: an `SVector<T, N>`, or a `Vec<T>` of a size known at run time.
pub(crate) trait States<T: Scalar>:
    Entries<T> + Index<usize, Output = T> + IndexMut<usize> + PartialEq
{
    /// A square matrix over them.
    type Matrix: Entries<T>;
    /// A number for each.
    type Numbers: Entries<usize>;

    /// Some of the contacts of a system with such states.
    type Contacts: Contacts;

    /// As many states, from a function of their places.
    fn like(&self, entry: impl FnMut(usize) -> T) -> Self;

    /// As many states, from those of both.
    fn with(&self, other: &Self, entry: impl Fn(T, T) -> T) -> Self;

    /// The bytes it has on the heap.
    #[cfg(feature = "alloc")]
    fn on_heap(&self) -> usize {
        0
    }

    /// How many.
    #[inline(always)]
    fn count(&self) -> usize {
        self.entries().len()
    }

    /// The square matrix of zeros over them.
    #[inline(always)]
    fn matrix(&self) -> Self::Matrix {
        Self::Matrix::filled(self.count() * self.count(), T::zero())
    }

    /// Whether all are finite.
    #[inline]
    fn is_finite(&self) -> bool {
        self.entries().iter().all(|value| value.is_finite())
    }

    /// The largest magnitude of these over a scale.
    #[inline]
    fn over(&self, scale: &Self) -> T {
        largest(self.entries().iter().zip(scale.entries()).map(|(&value, &scale)| value / scale))
    }
}

/// The largest magnitude.
#[inline]
pub(super) fn largest<T: Scalar>(values: impl Iterator<Item = T>) -> T {
    let sizes = values.map(|value| value.abs());
    sizes.reduce(|most, size| if most >= size { most } else { size }).unwrap_or(T::zero())
}

impl<T: Scalar, const N: usize> States<T> for nalgebra::SVector<T, N> {
    type Matrix = SMatrix<T, N, N>;
    type Numbers = nalgebra::SVector<usize, N>;
    type Contacts = Few;

    #[inline(always)]
    fn like(&self, mut entry: impl FnMut(usize) -> T) -> Self {
        Self::from_fn(|i, _| entry(i))
    }

    #[inline(always)]
    fn with(&self, other: &Self, entry: impl Fn(T, T) -> T) -> Self {
        self.zip_map(other, entry)
    }
}

#[cfg(feature = "alloc")]
impl<T: Scalar> States<T> for alloc::vec::Vec<T> {
    type Matrix = Self;
    type Numbers = alloc::vec::Vec<usize>;
    type Contacts = alloc::collections::BTreeSet<usize>;

    #[inline]
    fn like(&self, entry: impl FnMut(usize) -> T) -> Self {
        (0..self.len()).map(entry).collect()
    }

    #[inline]
    fn with(&self, other: &Self, entry: impl Fn(T, T) -> T) -> Self {
        self.iter().zip(other).map(|(&one, &other)| entry(one, other)).collect()
    }

    fn on_heap(&self) -> usize {
        size_of_val(&self[..])
    }
}

/// Values made of those at the same places of two others.
#[inline(always)]
pub(super) fn of_both<T: Copy, C: Entries<T>>(one: &C, other: &C, entry: impl Fn(T, T) -> T) -> C {
    let mut made = one.clone();
    for (made, &other) in made.entries_mut().iter_mut().zip(other.entries()) {
        *made = entry(*made, other);
    }
    made
}

/// The columns of a matrix with so many rows.
#[inline(always)]
pub(super) fn columns<T>(matrix: &[T], rows: usize) -> core::slice::ChunksExact<'_, T> {
    matrix.chunks_exact(rows.max(1))
}

/// So many values of each vector: a loop over as many of them needs no further checks.
#[inline(always)]
pub(super) fn slices<T: Scalar, V: States<T>, const S: usize>(
    count: usize,
    vectors: [&V; S],
) -> [&[T]; S] {
    vectors.map(|vector| &vector.entries()[..count])
}

/// The product of a square matrix of so many rows with columns: the vectors of the matrix, each
/// times an entry, added in their order.
#[inline(always)]
pub(super) fn product<T: Scalar, C: Entries<T>>(rows: usize, matrix: &[T], with: &C) -> C {
    let mut answer = C::filled(with.entries().len(), T::zero());
    product_to(rows, matrix, with, &mut answer);
    answer
}

/// Such a product, written over as many columns.
#[inline(always)]
pub(super) fn product_to<T: Scalar, C: Entries<T>>(
    rows: usize,
    matrix: &[T],
    with: &C,
    to: &mut C,
) {
    let rows = rows.max(1);
    to.entries_mut().fill(T::zero());
    let sums = to.entries_mut().chunks_exact_mut(rows);
    for (sum, factors) in sums.zip(columns(with.entries(), rows)) {
        if rows < MANY { add(sum, matrix, factors) } else { add_many(sum, matrix, factors) }
    }
}

/// Adds the columns of a matrix, each times a factor, in their order.
#[inline(always)]
fn add<T: Scalar>(sum: &mut [T], matrix: &[T], factors: &[T]) {
    for (column, &factor) in columns(matrix, sum.len()).zip(factors) {
        for (sum, &entry) in sum.iter_mut().zip(column) {
            *sum += entry * factor;
        }
    }
}

/// The same, five at once, for then the sum is read and written less often; compiled once.
#[inline(never)]
fn add_many<T: Scalar>(sum: &mut [T], matrix: &[T], factors: &[T]) {
    let (rows, fives) = (sum.len(), factors.chunks_exact(5));
    let (fewer, left) = (fives.remainder(), factors.len() - factors.len() % 5);
    for (five, factor) in columns(matrix, 5 * rows).zip(fives) {
        let [a, b, c, d, e] = core::array::from_fn(|k| &five[k * rows..][..rows]);
        for i in 0..rows {
            let first = ((sum[i] + a[i] * factor[0]) + b[i] * factor[1]) + c[i] * factor[2];
            sum[i] = (first + d[i] * factor[3]) + e[i] * factor[4];
        }
    }
    add(sum, &matrix[left * rows..], fewer);
}

/// Eliminates state k of a square matrix of so many rows by its pivot, of which the inverse is
/// given: below it the multipliers.
#[inline(always)]
pub(super) fn eliminate<T: Scalar>(
    states: usize,
    matrix: &mut [T],
    k: usize,
    inverse: impl Fn(T) -> T,
) {
    let (known, rest) = matrix.split_at_mut((k + 1) * states);
    let column = &mut known[k * states..(k + 1) * states];
    let inverse = inverse(column[k]);
    column[k] = inverse;
    column[k + 1..].iter_mut().for_each(|entry| *entry *= inverse);
    for j in 0..states - 1 - k {
        let other = &mut rest[j * states..(j + 1) * states];
        let row = other[k];
        for (entry, &multiplier) in other[k + 1..].iter_mut().zip(&column[k + 1..]) {
            *entry -= multiplier * row;
        }
    }
}

/// Solves for a column by factors: below the diagonal the multipliers, on it the reciprocal pivots.
#[inline(always)]
pub(super) fn substitute<T: Scalar>(factors: &[T], x: &mut [T]) {
    let states = x.len();
    for (j, column) in columns(factors, states).enumerate() {
        let known = x[j];
        for (x, &multiplier) in x[j + 1..].iter_mut().zip(&column[j + 1..]) {
            *x -= multiplier * known;
        }
    }
    for i in (0..states).rev() {
        for j in i + 1..states {
            let above = x[j];
            x[i] -= factors[j * states + i] * above;
        }
        x[i] *= factors[i * states + i];
    }
}

/// The root of the sum of all squares: in the order of nalgebra's, which has one for four rows.
pub(super) fn euclidean<T: Scalar>(rows: usize, matrix: &[T]) -> T {
    let columns = Dyn(matrix.len() / rows.max(1));
    match rows {
        4 => MatrixView::from_slice_generic(matrix, Const::<4>, columns).norm(),
        _ => MatrixView::from_slice_generic(matrix, Dyn(rows), columns).norm(),
    }
}
