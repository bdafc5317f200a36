//! The number type everything is generic over.

use nalgebra::RealField;

/// A real number the models and integrators can compute with: `f32`, `f64`, or any other
/// [`RealField`] that can be copied, such as the dual numbers of automatic differentiation.
pub trait Scalar: RealField + Copy {
    /// Infinity, in any scalar type: the fastest speed of a law that holds at every velocity.
    #[inline(always)]
    fn unlimited() -> Self {
        Self::one() / Self::zero()
    }

    /// Not a number, in any scalar type: what a model answers where it has no answer.
    #[inline(always)]
    fn nan() -> Self {
        Self::zero() / Self::zero()
    }

    /// The smaller of two numbers; NaN if the first is.
    #[inline]
    fn smaller(self, other: Self) -> Self {
        if other < self { other } else { self }
    }

    /// The larger of two numbers; NaN if the first is.
    #[inline]
    fn larger(self, other: Self) -> Self {
        if other > self { other } else { self }
    }
}

impl<T: RealField + Copy> Scalar for T {}

/// A literal of the scalar type, `lit(0.5)`, in code that is generic over it.
#[inline(always)]
pub fn lit<T: Scalar>(value: f64) -> T {
    nalgebra::convert(value)
}

/// The value as `f64`, for error messages and step-size control.
#[inline(always)]
pub fn to_f64<T: Scalar>(value: T) -> f64 {
    value.to_subset_unchecked()
}

/// Whether a value is zero. Of a dual number that asks for the value alone, where `==` would ask
/// for its derivatives too.
#[inline(always)]
pub fn is_zero<T: Scalar>(value: T) -> bool {
    value <= T::zero() && value >= T::zero()
}
