//! Elements from a virgin curve: the force over the first loading of an unstretched contact.
//!
//! F/p = Σ σᵢ min(x, ℓᵢ)
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | x | displacement, slow, from an unstretched contact | m |
//! | σᵢ, ℓᵢ | stiffness and yield length of element i | 1/m, m |
//!
//! The curve is piecewise linear and its slope falls at each ℓᵢ by σᵢ: [`bends`]. For given yield
//! lengths it is linear in the stiffnesses: [`fit`]. All loops follow by Masing's rules: after a
//! reversal the curve is the virgin one, doubled in both directions, until it meets an older
//! branch.

use bristle::Scalar;
use bristle::nalgebra::{SMatrix, SVector};
use bristle::parameter::{Checked, Named, ParameterError};
use bristle::scalar::lit;

use crate::Element;
use crate::non_negative::minimise;

/// A measured point of a virgin curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VirginPoint<T> {
    /// Displacement x \[m\] from the unstretched contact.
    pub deflection: T,
    /// Friction force over normal force \[–\].
    pub coefficient: T,
}

/// The virgin curve Σ σᵢ min(x, ℓᵢ) \[–\] of elements at a displacement x ≥ 0 \[m\].
pub fn coefficient<T: Scalar>(elements: &[Element<T>], deflection: T) -> T {
    elements.iter().fold(T::zero(), |sum, element| {
        sum + element.stiffness * deflection.smaller(element.yield_length)
    })
}

/// The elements of a piecewise-linear curve that bends at each of its points, begins at zero and is
/// level after the last: it is met exactly if its last coefficient is that of the friction curve at
/// rest. Otherwise every yield length is scaled to it.
///
/// # Errors
///
/// Names the point that is not positive, not above the one before, or that the curve bends upwards
/// at: elements that yield cannot stiffen. Take [`fit`] for noisy points.
pub fn bends<T: Scalar, const N: usize>(points: &[VirginPoint<T>; N]) -> Checked<[Element<T>; N]> {
    let mut before = VirginPoint { deflection: T::zero(), coefficient: T::zero() };
    let mut slopes = [T::zero(); N];
    for (i, (&point, slope)) in points.iter().zip(&mut slopes).enumerate() {
        ParameterError::of_component(i, checked(&point, before.deflection))?;
        let rise =
            (point.coefficient - before.coefficient) / (point.deflection - before.deflection);
        (*slope, before) = (rise, point);
    }
    let mut elements =
        points.map(|point| Element { stiffness: T::zero(), yield_length: point.deflection });
    for (i, element) in elements.iter_mut().enumerate() {
        let next = slopes.get(i + 1).copied().unwrap_or_else(T::zero);
        let rounding = lit::<T>(16.0) * T::default_epsilon() * slopes[i].abs();
        let next = if (slopes[i] - next).abs() <= rounding { slopes[i] } else { next };
        let slope = Named("slope of the points up to it", slopes[i]);
        let concave = slope.at_least("the slope after it", next);
        element.stiffness = ParameterError::of_component(i, concave)? - next;
    }
    Ok(elements)
}

/// The elements with given yield lengths \[m\], increasing, that come closest to measured points
/// in the sum of squares: non-negative least squares, with one minimum.
///
/// Elements that the points do not ask for get a stiffness of zero. The points need not be in
/// order. A yield length beyond the largest deflection cannot be told from another one there: give
/// one such at most.
///
/// # Errors
///
/// Names the point or the yield length that is out of its range. Refuses no points.
pub fn fit<T: Scalar, const N: usize>(
    points: &[VirginPoint<T>],
    yield_lengths: [T; N],
) -> Checked<[Element<T>; N]> {
    increasing(&yield_lengths)?;
    Named("points", points.len()).count(1)?;
    let (mut matrix, mut right) = (SMatrix::<T, N, N>::zeros(), SVector::<T, N>::zeros());
    ParameterError::of_components(points, |point| checked(point, T::zero()))?;
    for point in points {
        let row = SVector::<T, N>::from_fn(|i, _| point.deflection.smaller(yield_lengths[i]));
        matrix += row * row.transpose();
        right += row * point.coefficient;
    }
    Ok(elements(minimise(&matrix, &right), yield_lengths))
}

pub(crate) fn elements<T: Scalar, const N: usize>(
    stiffness: SVector<T, N>,
    yield_lengths: [T; N],
) -> [Element<T>; N] {
    core::array::from_fn(|i| Element { stiffness: stiffness[i], yield_length: yield_lengths[i] })
}

pub(crate) fn increasing<T: Scalar>(yield_lengths: &[T]) -> Checked<()> {
    Named("yield_lengths", yield_lengths.len()).count(1)?;
    let mut before = T::zero();
    ParameterError::of_components(yield_lengths, |&length| {
        let length = Named("yield_lengths", length);
        length.positive()?;
        length.increasing(core::mem::replace(&mut before, length.1))
    })
}

fn checked<T: Scalar>(point: &VirginPoint<T>, before: T) -> Checked<T> {
    let deflection = Named("points.deflection", point.deflection);
    let increasing = deflection.positive().and(deflection.increasing(before));
    increasing.and(Named("points.coefficient", point.coefficient).non_negative())
}
