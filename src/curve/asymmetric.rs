//! A separate friction curve for each direction of motion.

use crate::curve::FrictionCurve;
use crate::{Bounds, Scalar, Sliding};

/// A friction curve made of two, one for each direction of sliding: for a gearbox or a seal whose
/// friction forwards and backwards differs.
///
/// At v = 0 on the free branch the forward curve holds. If the two differ there, μ jumps at the
/// reversal, but the bristle's rate and force stay continuous: they depend on μ only where |v| > 0
/// (for an exact modulus of the velocity, ε = 0).
///
/// ```
/// use bristle::curve::{Asymmetric, Coulomb, CoulombParameters, FrictionCurve};
///
/// let coulomb = |dynamic_coefficient| {
///     Coulomb::new(CoulombParameters { dynamic_coefficient, viscous_friction: 0.0 })
/// };
/// let gearbox = Asymmetric { forward: coulomb(0.20)?, backward: coulomb(0.25)? };
/// assert_eq!(gearbox.coefficient((-1.0).into()), 0.25);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Asymmetric<F, B> {
    /// Curve for v > 0.
    pub forward: F,
    /// Curve for v < 0.
    pub backward: B,
}

impl<T: Scalar, F: FrictionCurve<T>, B: FrictionCurve<T>> FrictionCurve<T> for Asymmetric<F, B> {
    #[inline]
    fn coefficient_and_slope(&self, sliding: Sliding<T>) -> (T, T) {
        if sliding.direction() < T::zero() {
            self.backward.coefficient_and_slope(sliding)
        } else {
            self.forward.coefficient_and_slope(sliding)
        }
    }

    fn bounds(&self, fastest: T) -> Bounds<T> {
        self.forward.bounds(fastest).union(self.backward.bounds(fastest))
    }

    fn slope_at_rest(&self) -> T {
        self.forward.slope_at_rest().smaller(self.backward.slope_at_rest())
    }

    fn viscous_friction(&self) -> T {
        // The part that both directions share.
        self.forward.viscous_friction().smaller(self.backward.viscous_friction())
    }

    fn with_less_viscous_friction(&self, part: T) -> Self {
        Self {
            forward: self.forward.with_less_viscous_friction(part),
            backward: self.backward.with_less_viscous_friction(part),
        }
    }

    fn least_slope(&self) -> Option<T> {
        Some((self.forward.least_slope()?).smaller(self.backward.least_slope()?))
    }
}
