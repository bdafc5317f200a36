//! W, row by row: which coordinates a contact rubs against, and with which factors.

use crate::mechanism::Structure;
use bristle::Scalar;
use bristle::parameter::{Checked, Named, ParameterError, Rule};
use bristle::scalar::lit;

/// The contacts of a mechanism: of each the coordinates that move it, and their factors.
///
/// s = Σ factor · v of each coordinate. Arrays, slices and vectors of such pairs
/// serve. One of your own must give the same answers always:
///
/// ```
/// use bristle_mechanism::Rows;
///
/// let rows: [&[(usize, f64)]; 2] = [&[(0, 1.0)], &[(1, 1.0), (0, -1.0)]];
/// assert_eq!((rows.contacts(), rows.row(1).len()), (2, 2)); // the second rubs on the first body
/// ```
pub trait Rows<T> {
    /// The number of contacts.
    fn contacts(&self) -> usize;

    /// The coordinates that move a contact, and their factors; none for a contact that is not
    /// there.
    fn row(&self, contact: usize) -> &[(usize, T)];
}

/// What can be seen as a slice of rows.
macro_rules! rows {
    ($(#[$attribute:meta])* [$($generics:tt)*] $rows:ty) => {
        $(#[$attribute])*
        impl<T, Q: AsRef<[(usize, T)]>, $($generics)*> Rows<T> for $rows {
            #[inline]
            fn contacts(&self) -> usize {
                self.len()
            }

            #[inline]
            fn row(&self, contact: usize) -> &[(usize, T)] {
                self.get(contact).map_or(&[], Q::as_ref)
            }
        }
    };
}
rows!([const K: usize] [Q; K]);
rows!([] & [Q]);
rows!(
    #[cfg(feature = "alloc")]
    [] alloc::vec::Vec<Q>
);

/// W x of one contact: of a long row in four sums, so that no sum waits for the one before.
#[inline(always)]
pub(crate) fn along<T: Scalar>(row: &[(usize, T)], x: &[T]) -> T {
    let term =
        |&(place, factor): &(usize, T)| x.get(place).map_or_else(T::zero, |&value| factor * value);
    if let [first, rest @ ..] = row
        && rest.len() < 4
    {
        return rest.iter().fold(term(first), |sum, pair| sum + term(pair));
    }
    let mut sums = [T::zero(); 4];
    for four in row.chunks(4) {
        for (sum, pair) in sums.iter_mut().zip(four) {
            *sum += term(pair);
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

/// v ← v + Wᵀ s of one contact.
#[inline(always)]
pub(crate) fn spread<T: Scalar>(row: &[(usize, T)], by: T, into: &mut [T]) {
    for &(place, factor) in row {
        if let Some(sum) = into.get_mut(place) {
            *sum += factor * by;
        }
    }
}

/// Refuses a contact on nothing, on a coordinate that is not there, and factors that are not
/// finite. In a band, two coordinates that lie farther apart than its half-width.
pub(crate) fn check<T: Scalar>(
    rows: &impl Rows<T>,
    structure: Structure,
    coordinates: usize,
) -> Checked<()> {
    let reach = match structure {
        Structure::Banded { half_bandwidth } => half_bandwidth,
        _ => coordinates,
    };
    let of_contact = |contact: usize| {
        let (mut largest, mut first, mut last) = (T::zero(), coordinates, 0);
        for &(place, factor) in rows.row(contact) {
            let coordinate = Named("coordinate of contact", lit::<T>(place as f64));
            let limit = Rule::Below { other: "coordinates", limit: coordinates as f64 };
            coordinate.check(place < coordinates, limit)?;
            let factor = Named("factor of contact", factor).finite()?.abs();
            largest = largest.larger(factor);
            if factor > T::zero() {
                (first, last) = (first.min(place), last.max(place));
            }
        }
        let largest = Named("largest factor of contact", largest);
        largest.stated(largest.1 > T::zero(), "be positive: the contact rubs on nothing")?;
        let apart = last - first;
        let distance = Named("distance of the coordinates of contact", lit::<T>(apart as f64));
        let rule = Rule::AtMost { other: "half_bandwidth", limit: reach as f64 };
        distance.check(apart <= reach, rule)
    };
    ParameterError::of_components(0..rows.contacts(), of_contact)
}
