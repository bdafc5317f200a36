//! Coulomb friction with a viscous part.

use crate::curve::FrictionCurve;
use crate::parameter::{Checked, Named};
use crate::{Bounds, Scalar, Sliding};

/// Parameters of [`Coulomb`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct CoulombParameters<T> {
    /// Dynamic friction coefficient μ_d \[–\], positive.
    #[doc(alias = "mu_d")]
    pub dynamic_coefficient: T,
    /// Viscous friction σ2 [s/m], zero or positive.
    #[doc(alias = "sigma2")]
    pub viscous_friction: T,
}

/// Coulomb friction with a viscous part, μ(v) = μ_d + σ2|v|: friction that does not fall with the
/// speed, or of which one number is known. The symbols are those of [`CoulombParameters`].
///
/// ```
/// use bristle::curve::{Coulomb, CoulombParameters, FrictionCurve};
///
/// let parameters = CoulombParameters { dynamic_coefficient: 0.3, viscous_friction: 0.1 };
/// let curve = Coulomb::new(parameters)?;
/// assert_eq!(curve.coefficient((-2.0).into()), 0.5);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coulomb<T> {
    pub(crate) dynamic: T,
    pub(crate) viscous: T,
}

impl<T: Scalar> Coulomb<T> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range.
    pub fn new(parameters: CoulombParameters<T>) -> Checked<Self> {
        Ok(Self {
            dynamic: Named("dynamic_coefficient", parameters.dynamic_coefficient).positive()?,
            viscous: Named("viscous_friction", parameters.viscous_friction).non_negative()?,
        })
    }

    /// The parameters, as they were given.
    pub fn parameters(&self) -> CoulombParameters<T> {
        CoulombParameters { dynamic_coefficient: self.dynamic, viscous_friction: self.viscous }
    }
}

impl<T: Scalar> FrictionCurve<T> for Coulomb<T> {
    #[inline]
    fn coefficient_and_slope(&self, sliding: Sliding<T>) -> (T, T) {
        (self.dynamic + self.viscous * sliding.speed(), self.viscous * sliding.direction())
    }

    fn bounds(&self, fastest: T) -> Bounds<T> {
        // Without a viscous part 0·∞ would make the bound of all speeds NaN.
        let rise = if self.viscous == T::zero() { T::zero() } else { self.viscous * fastest };
        Bounds { min: self.dynamic, max: self.dynamic + rise }
    }

    fn viscous_friction(&self) -> T {
        self.viscous
    }

    fn with_less_viscous_friction(&self, part: T) -> Self {
        Self { viscous: self.viscous - part, ..*self }
    }

    fn is_even(&self) -> bool {
        true
    }

    fn least_slope(&self) -> Option<T> {
        Some(self.viscous)
    }
}
