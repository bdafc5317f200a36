//! Elements from a measured record: the force over a slow motion back and forth.
//!
//! F/p = f₀ + Σ σᵢ xᵢ,  xᵢ' = clamp(xᵢ + Δx, ±ℓᵢ)
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | Δx | displacement from row to row | m |
//! | xᵢ | deflection of element i after a row | m |
//! | σᵢ, ℓᵢ | stiffness and yield length of element i | 1/m, m |
//! | f₀ | zero of the force measurement over the normal force | – |
//!
//! For given yield lengths the deflections follow from the motion alone, and the force is linear in
//! σᵢ ≥ 0 and f₀: non-negative least squares, with one minimum.

use bristle::Scalar;
use bristle::nalgebra::{SMatrix, SVector};
use bristle::parameter::{Checked, Named, ParameterError};

use crate::Element;
use crate::non_negative::minimise;
use crate::virgin::{elements, increasing};

/// A row of a measured record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordPoint<T> {
    /// Displacement \[m\].
    pub displacement: T,
    /// Friction force over normal force \[–\].
    pub coefficient: T,
    /// Weight \[–\] of the row in the sum of squares; a row of weight zero only tells the motion.
    pub weight: T,
}

/// What [`fit`] found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordFit<T, const N: usize> {
    /// The elements, those with a stiffness of zero included.
    pub elements: [Element<T>; N],
    /// Zero f₀ \[–\] of the force measurement over the normal force.
    pub offset: T,
}

/// The elements with given yield lengths \[m\], increasing, and the offset that come closest to a
/// record in the weighted sum of squares.
///
/// The elements are unstretched at the first row. If the contact was not, give no weight to the
/// rows before the first turn that follows a stroke of twice the largest yield length: there the
/// elements have forgotten what was before.
///
/// # Errors
///
/// Names the row or the yield length that is out of its range. Refuses a record without weight.
pub fn fit<T: Scalar, const N: usize>(
    record: &[RecordPoint<T>],
    yield_lengths: [T; N],
) -> Checked<RecordFit<T, N>> {
    increasing(&yield_lengths)?;
    let lengths = SVector::<T, N>::from(yield_lengths);
    // Sums of the weights w, of w x, w F/p, w x xᵀ and w x F/p.
    let (mut weights, mut forces) = (T::zero(), T::zero());
    let mut deflections = SVector::<T, N>::zeros();
    let (mut matrix, mut right) = (SMatrix::<T, N, N>::zeros(), SVector::<T, N>::zeros());
    let mut x = SVector::<T, N>::zeros();
    let mut before = record.first().map_or_else(T::zero, |point| point.displacement);
    for (i, point) in record.iter().enumerate() {
        let finite = Named("record.displacement", point.displacement).finite();
        let finite = finite.and(Named("record.coefficient", point.coefficient).finite());
        let weight = finite.and(Named("record.weight", point.weight).non_negative());
        let weight = ParameterError::of_component(i, weight)?;
        x = x.zip_map(&lengths, |x, length| {
            (x + (point.displacement - before)).larger(-length).smaller(length)
        });
        before = point.displacement;
        weights += weight;
        forces += weight * point.coefficient;
        deflections += x * weight;
        matrix += x * x.transpose() * weight;
        right += x * (weight * point.coefficient);
    }
    let weights = Named("sum of record.weight", weights).positive()?;
    let (mean, force) = (deflections / weights, forces / weights);
    let matrix = matrix - mean * deflections.transpose();
    let stiffness = minimise(&matrix, &(right - mean * forces));
    let offset = force - stiffness.dot(&mean);
    Ok(RecordFit { elements: elements(stiffness, yield_lengths), offset })
}
