//! A Stribeck curve without an exponential, for loops that cannot afford one.
//!
//! μ(v) = μ_d + (μ_s − μ_d)/(1 + (v/v_S)²) + σ2|v|
//!
//! with the symbols of [`Stribeck`](crate::curve::Stribeck). It falls like the one with δ = 2 at
//! first and approaches the dynamic coefficient more slowly.
//!
//! Source: D. P. Hess, A. Soom, "Friction at a lubricated line contact operating at oscillating
//! sliding velocities", Journal of Tribology 112 (1990), 147–152.

use super::valley::Valley;
use crate::curve::FrictionCurve;
use crate::parameter::{self, ParameterError};
use crate::scalar::lit;
use crate::{Bounds, Scalar, Sliding};

/// Parameters of [`RationalStribeck`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RationalStribeckParameters<T> {
    /// Static friction coefficient μ_s \[–\], at least the dynamic one.
    #[doc(alias = "mu_s")]
    pub static_coefficient: T,
    /// Dynamic friction coefficient μ_d \[–\], positive.
    #[doc(alias = "mu_d")]
    pub dynamic_coefficient: T,
    /// Stribeck velocity v_S [m/s], positive: half of the drop is done there.
    #[doc(alias = "v_S")]
    pub stribeck_velocity: T,
    /// Viscous friction σ2 [s/m], zero or positive.
    #[doc(alias = "sigma2")]
    pub viscous_friction: T,
}

/// A Stribeck curve without an exponential, μ(v) = μ_d + (μ_s − μ_d)/(1 + (v/v_S)²) + σ2|v|.
///
/// ```
/// use bristle::curve::{FrictionCurve, RationalStribeck, RationalStribeckParameters};
///
/// let curve = RationalStribeck::new(RationalStribeckParameters {
///     static_coefficient: 0.6_f32,
///     dynamic_coefficient: 0.2,
///     stribeck_velocity: 0.5,
///     viscous_friction: 0.0,
/// })?;
/// assert!((curve.coefficient(0.5.into()) - 0.4).abs() < 1e-7);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RationalStribeck<T> {
    pub(crate) dynamic: T,
    /// μ_s − μ_d
    pub(crate) drop: T,
    /// 1/v_S
    pub(crate) inverse_velocity: T,
    pub(crate) viscous: T,
}

impl<T: Scalar> RationalStribeck<T> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range, or a static coefficient below the dynamic
    /// one.
    pub fn new(parameters: RationalStribeckParameters<T>) -> Result<Self, ParameterError> {
        let dynamic = parameter::positive("dynamic_coefficient", parameters.dynamic_coefficient)?;
        let static_ = parameter::positive("static_coefficient", parameters.static_coefficient)?;
        parameter::at_least("static_coefficient", static_, "dynamic_coefficient", dynamic)?;
        let velocity = parameter::positive("stribeck_velocity", parameters.stribeck_velocity)?;
        Ok(Self {
            dynamic,
            drop: static_ - dynamic,
            inverse_velocity: T::one() / velocity,
            viscous: parameter::non_negative("viscous_friction", parameters.viscous_friction)?,
        })
    }
}

impl<T: Scalar> FrictionCurve<T> for RationalStribeck<T> {
    #[inline]
    fn coefficient(&self, sliding: Sliding<T>) -> T {
        let u = sliding.speed() * self.inverse_velocity;
        self.dynamic + self.drop / (T::one() + u * u) + self.viscous * sliding.speed()
    }

    #[inline]
    fn coefficient_and_slope(&self, sliding: Sliding<T>) -> (T, T) {
        let u = sliding.speed() * self.inverse_velocity;
        let decay = T::one() / (T::one() + u * u);
        let fall = self.drop * decay * (u + u) * decay * self.inverse_velocity;
        (
            self.dynamic + self.drop * decay + self.viscous * sliding.speed(),
            (self.viscous - fall) * sliding.direction(),
        )
    }

    fn bounds(&self, fastest: T) -> Bounds<T> {
        let velocity = T::one() / self.inverse_velocity;
        let decay = |u: T| T::one() / (T::one() + u * u);
        let valley = Valley {
            value: |u: T| {
                let viscous =
                    if self.viscous == T::zero() { T::zero() } else { self.viscous * u * velocity };
                self.dynamic + self.drop * decay(u) + viscous
            },
            steepness: |u: T| (u + u) * decay(u) * decay(u),
        };
        // 2u/(1+u²)² is largest where 1 + u² = 4u².
        let steepest = lit::<T>(1.0 / 3.0).sqrt();
        valley.bounds(
            fastest * self.inverse_velocity,
            steepest,
            self.viscous * velocity / self.drop,
        )
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
        // 2u/(1+u²)² = (3/8)√3 at u² = 1/3.
        let steepest = lit::<T>(0.375) * lit::<T>(3.0).sqrt();
        Some(self.viscous - self.drop * self.inverse_velocity * steepest)
    }
}
