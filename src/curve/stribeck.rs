//! The Stribeck curve.

use super::RationalStribeckParameters;
use super::valley::Valley;
use crate::curve::FrictionCurve;
use crate::parameter::{Checked, Named};
use crate::scalar::{is_zero, lit};
use crate::{Bounds, Branch, Scalar, Sliding};

/// Parameters of [`Stribeck`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct StribeckParameters<T> {
    /// Static friction coefficient μ_s \[–\], at least the dynamic one.
    #[doc(alias = "mu_s")]
    pub static_coefficient: T,
    /// Dynamic friction coefficient μ_d \[–\], positive.
    #[doc(alias = "mu_d")]
    pub dynamic_coefficient: T,
    /// Stribeck velocity v_S [m/s], positive: 63 % of the fall is done there.
    #[doc(alias = "v_S")]
    pub stribeck_velocity: T,
    /// Stribeck exponent δ \[–\], between 0.1 and 100. Take 2 if it was not measured; 1 falls at
    /// once from rest. Both need no power function.
    #[doc(alias = "delta")]
    pub stribeck_exponent: T,
    /// Viscous friction σ2 [s/m], zero or positive.
    #[doc(alias = "sigma2")]
    pub viscous_friction: T,
}

/// The Stribeck curve, μ(v) = μ_d + (μ_s − μ_d) exp(−(|v|/v_S)^δ) + σ2|v|: friction that falls from
/// its static to its dynamic value as sliding sets in, and rises again with viscosity. Take it
/// unless you know better.
///
/// The symbols are those of [`StribeckParameters`]. The curve is continuously differentiable only
/// for δ > 1 and, with σ2 > 0, away from v = 0.
///
/// Source: Romano et al. (arXiv 2602.09429), section II-B, the generalised Coulomb curve with
/// μ_v = σ2|v|.
///
/// At exactly v = 0 with δ < 1 the one-sided slope is infinite; the slope reported there is that
/// of the viscous part alone.
///
/// ```
/// use bristle::curve::{FrictionCurve, Stribeck, StribeckParameters};
///
/// let curve = Stribeck::new(StribeckParameters {
///     static_coefficient: 1.5,
///     dynamic_coefficient: 1.0,
///     stribeck_velocity: 0.01,
///     stribeck_exponent: 2.0,
///     viscous_friction: 0.04,
/// })?;
/// assert_eq!(curve.coefficient(0.0.into()), 1.5);
/// assert_eq!(curve.coefficient(0.25.into()), 1.01);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stribeck<T> {
    pub(crate) valley: Valley<T>,
    /// δ
    pub(crate) exponent: T,
    /// Power w beyond which (μ_s − μ_d) exp(−w) is less than a rounding of μ_d.
    negligible: T,
}

impl<T: Scalar> Stribeck<T> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range, or a static coefficient below the dynamic
    /// one.
    pub fn new(parameters: StribeckParameters<T>) -> Checked<Self> {
        let valley = Valley::new(RationalStribeckParameters {
            static_coefficient: parameters.static_coefficient,
            dynamic_coefficient: parameters.dynamic_coefficient,
            stribeck_velocity: parameters.stribeck_velocity,
            viscous_friction: parameters.viscous_friction,
        })?;
        let exponent =
            Named("stribeck_exponent", parameters.stribeck_exponent).between(0.1, 100.0)?;
        Ok(Self {
            valley,
            exponent,
            // Without a drop this is −∞, and the exponential is never needed.
            negligible: (lit::<T>(4.0) * valley.drop
                / (T::default_epsilon() * valley.given.dynamic_coefficient))
                .ln(),
        })
    }

    /// The parameters, as they were given.
    pub fn parameters(&self) -> StribeckParameters<T> {
        StribeckParameters {
            static_coefficient: self.valley.given.static_coefficient,
            dynamic_coefficient: self.valley.given.dynamic_coefficient,
            stribeck_velocity: self.valley.given.stribeck_velocity,
            stribeck_exponent: self.exponent,
            viscous_friction: self.valley.given.viscous_friction,
        }
    }

    /// exp(−w), without the exponential where the curve cannot tell: most of a stick-slip run lies
    /// there, with sticking well below and slipping far above the Stribeck velocity.
    #[inline(always)]
    fn decay(&self, w: T) -> T {
        if w > self.negligible {
            T::zero()
        } else if w < lit(1e-3) && w > lit(-1e-3) {
            // The series is cut at w⁶/720 < 2e-21.
            let fifth = T::one() - w * lit(0.2);
            let fourth = T::one() - w * lit(0.25) * fifth;
            let third = T::one() - w * lit(1.0 / 3.0) * fourth;
            T::one() - w * (T::one() - w * lit(0.5) * third)
        } else {
            (-w).exp()
        }
    }

    /// The scaled speed u at which the steepness δ u^(δ−1) exp(−u^δ) is largest: u^δ = (δ−1)/δ; for
    /// δ ≤ 1 at rest. There it has no finite value for δ < 1, so searches start next to rest.
    fn steepest(&self) -> T {
        let exponent = self.exponent;
        if exponent == T::one() {
            T::zero()
        } else if exponent > T::one() {
            ((exponent - T::one()) / exponent).powf(T::one() / exponent)
        } else {
            T::default_epsilon()
        }
    }

    /// The power w = |u|^δ of the scaled speed u, and dw/du. Exponents of one and two need no power
    /// function.
    #[inline(always)]
    fn power(&self, u: T) -> (T, T) {
        if self.exponent == lit(2.0) {
            (u * u, u + u)
        } else if self.exponent == T::one() {
            // u itself, not |u|: the smooth continuation to speeds of the wrong sign.
            (u, T::one())
        } else {
            self.general_power(u)
        }
    }

    /// |u|^δ for any exponent. A function of its own: inlined, the compiler takes the power of
    /// every u and then selects.
    #[inline(never)]
    fn general_power(&self, u: T) -> (T, T) {
        if is_zero(u) {
            return (T::zero(), T::zero());
        }
        let w = u.abs().powf(self.exponent);
        (w, self.exponent * w / u)
    }
}

impl<T: Scalar> FrictionCurve<T> for Stribeck<T> {
    #[inline(always)]
    fn coefficient(&self, sliding: Sliding<T>) -> T {
        let (w, _) = self.power(sliding.speed() * self.valley.inverse_velocity);
        // The exponential, which takes longest, last.
        self.valley.given.dynamic_coefficient
            + self.valley.given.viscous_friction * sliding.speed()
            + self.valley.drop * self.decay(w)
    }

    #[inline(always)]
    fn coefficient_and_slope(&self, sliding: Sliding<T>) -> (T, T) {
        let (w, w_slope) = self.power(sliding.speed() * self.valley.inverse_velocity);
        let stribeck = self.valley.drop * self.decay(w);
        // The power's slope may overflow where the exponential has vanished.
        let fall = if stribeck == T::zero() { stribeck } else { stribeck * w_slope };
        let slope = self.valley.given.viscous_friction - fall * self.valley.inverse_velocity;
        (
            self.valley.given.dynamic_coefficient
                + self.valley.given.viscous_friction * sliding.speed()
                + stribeck,
            slope * sliding.direction(),
        )
    }

    fn bounds(&self, fastest: T) -> Bounds<T> {
        let decay_and_steepness = |u: T| {
            let (w, slope) = self.power(u);
            let decay = self.decay(w);
            (decay, slope * decay)
        };
        self.valley.bounds(fastest, decay_and_steepness, self.steepest())
    }

    fn slope_at_rest(&self) -> T {
        if self.exponent < T::one() && self.valley.drop > T::zero() {
            // Of which the slope at rest itself says nothing.
            return -T::unlimited();
        }
        self.coefficient_and_slope(Branch::Forward.of(T::zero())).1
    }

    fn viscous_friction(&self) -> T {
        self.valley.given.viscous_friction
    }

    fn with_less_viscous_friction(&self, part: T) -> Self {
        Self { valley: self.valley.with_less_viscous_friction(part), ..*self }
    }

    fn is_even(&self) -> bool {
        true
    }

    fn least_slope(&self) -> Option<T> {
        if is_zero(self.valley.drop) {
            return Some(self.valley.given.viscous_friction);
        }
        if self.exponent < T::one() {
            // δ u^(δ−1) exp(−u^δ) grows without limit towards rest.
            return Some(-T::unlimited());
        }
        let (w, slope) = self.power(self.steepest());
        let steepness = slope * (-w).exp();
        Some(
            self.valley.given.viscous_friction
                - self.valley.drop * self.valley.inverse_velocity * steepness,
        )
    }
}
