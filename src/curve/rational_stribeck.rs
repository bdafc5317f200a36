//! A Stribeck curve without an exponential.

use super::valley::Valley;
use crate::curve::FrictionCurve;
use crate::parameter::Checked;
use crate::scalar::lit;
use crate::{Bounds, Scalar, Sliding};

/// Parameters of [`RationalStribeck`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
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

/// A Stribeck curve without an exponential, for loops that cannot afford one:
///
/// μ(v) = μ_d + (μ_s − μ_d)/(1 + (v/v_S)²) + σ2|v|
///
/// with the symbols of [`RationalStribeckParameters`]. At first it falls like a
/// [`Stribeck`](super::Stribeck) curve with δ = 2, then it approaches μ_d more slowly: at v_S half
/// of the fall is done, at 3 v_S nine tenths.
///
/// Source: D. P. Hess, A. Soom, "Friction at a lubricated line contact operating at oscillating
/// sliding velocities", Journal of Tribology 112 (1990), 147–152.
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
pub struct RationalStribeck<T>(Valley<T>);

impl<T: Scalar> RationalStribeck<T> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range, or a static coefficient below the dynamic
    /// one.
    pub fn new(parameters: RationalStribeckParameters<T>) -> Checked<Self> {
        Valley::new(parameters).map(Self)
    }

    /// The parameters, as they were given.
    pub fn parameters(&self) -> RationalStribeckParameters<T> {
        self.0.given
    }
}

impl<T: Scalar> FrictionCurve<T> for RationalStribeck<T> {
    #[inline]
    fn coefficient_and_slope(&self, sliding: Sliding<T>) -> (T, T) {
        let u = sliding.speed() * self.0.inverse_velocity;
        let rise = T::one() + u * u;
        let stribeck = self.0.drop / rise;
        let fall = stribeck / rise * (u + u) * self.0.inverse_velocity;
        (
            self.0.given.dynamic_coefficient
                + stribeck
                + self.0.given.viscous_friction * sliding.speed(),
            (self.0.given.viscous_friction - fall) * sliding.direction(),
        )
    }

    fn bounds(&self, fastest: T) -> Bounds<T> {
        // 2u/(1+u²)² is largest where 1 + u² = 4u².
        let steepest = lit::<T>(1.0 / 3.0).sqrt();
        let decay_and_steepness = |u: T| {
            let decay = T::one() / (T::one() + u * u);
            (decay, (u + u) * decay * decay)
        };
        self.0.bounds(fastest, decay_and_steepness, steepest)
    }

    fn viscous_friction(&self) -> T {
        self.0.given.viscous_friction
    }

    fn with_less_viscous_friction(&self, part: T) -> Self {
        Self(self.0.with_less_viscous_friction(part))
    }

    fn is_even(&self) -> bool {
        true
    }

    fn least_slope(&self) -> Option<T> {
        // 2u/(1+u²)² = (3/8)√3 at u² = 1/3.
        let steepest = lit::<T>(0.375) * lit::<T>(3.0).sqrt();
        Some(self.0.given.viscous_friction - self.0.drop * self.0.inverse_velocity * steepest)
    }
}
