//! The range of a velocity-dependent quantity.

use crate::scalar::Scalar;

/// Smallest and largest value of a quantity over a range of velocities.
///
/// The theorems on friction models speak of such ranges: the deflection of a bristle, for
/// instance, never exceeds the largest friction coefficient over its stiffness. You give one for a
/// curve or a bristle of your own ([`FunctionCurve`](crate::curve::FunctionCurve),
/// [`ElementBounds`](crate::rheology::ElementBounds)), and read one from
/// [`FrictionCurve::bounds`](crate::curve::FrictionCurve::bounds).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Bounds<T> {
    /// Smallest value.
    pub min: T,
    /// Largest value; infinite if the quantity grows without limit.
    pub max: T,
}

impl<T: Scalar> Bounds<T> {
    /// The range of a quantity that does not vary.
    pub fn constant(value: T) -> Self {
        Self { min: value, max: value }
    }

    /// The smallest range that holds both, as of two directions of sliding.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.smaller(other.min), max: self.max.larger(other.max) }
    }

    /// Whether the quantity is constant, as some theorems need of a stiffness.
    pub fn is_constant(&self) -> bool {
        self.min == self.max
    }
}
