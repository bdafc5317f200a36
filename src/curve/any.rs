//! A friction curve chosen at run time.

#[cfg(feature = "alloc")]
use alloc::{boxed::Box, vec::Vec};

#[cfg(feature = "alloc")]
use super::{Asymmetric, Cubic, OwnCurve, Tabulated};
use super::{Coulomb, FrictionCurve, RationalStribeck, Stribeck};
use crate::{Bounds, Scalar, Sliding};

/// A friction curve chosen at run time, by a configuration file for instance: one of the curves of
/// this crate, with their numbers to the last bit, or with `alloc` one of your own.
///
/// ```
/// use bristle::curve::{AnyCurve, Coulomb, CoulombParameters, FrictionCurve, Stribeck};
/// use bristle::{ParameterError, paper};
///
/// fn named(name: &str) -> Result<AnyCurve<f64>, ParameterError> {
///     Ok(match name {
///         "stribeck" => Stribeck::new(paper::STICK_SLIP_CURVE)?.into(),
///         _ => {
///             let (dynamic_coefficient, viscous_friction) = (1.0, 0.0);
///             Coulomb::new(CoulombParameters { dynamic_coefficient, viscous_friction })?.into()
///         }
///     })
/// }
/// assert_eq!(named("stribeck")?.at(0.0), 1.5);
/// assert_eq!(named("coulomb")?.at(0.0), 1.0);
/// # Ok::<(), ParameterError>(())
/// ```
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum AnyCurve<T: Scalar> {
    /// μ_d + σ2|v|.
    Coulomb(Coulomb<T>),
    /// μ_d + (μ_s − μ_d) e^(−(|v|/v_S)^δ) + σ2|v|.
    Stribeck(Stribeck<T>),
    /// μ_d + (μ_s − μ_d)/(1 + (v/v_S)²) + σ2|v|.
    RationalStribeck(RationalStribeck<T>),
    /// A monotone cubic through any number of points.
    #[cfg(feature = "alloc")]
    Tabulated(Tabulated<Vec<Cubic<T>>>),
    /// One curve for each direction.
    #[cfg(feature = "alloc")]
    Asymmetric(Box<Asymmetric<AnyCurve<T>, AnyCurve<T>>>),
    /// A curve of your own, see [`AnyCurve::own`].
    #[cfg(feature = "alloc")]
    #[cfg_attr(feature = "serde", serde(skip))]
    Own(OwnCurve<T>),
}

/// Calls a function of the curve.
macro_rules! of_the_curve {
    ($self:ident, $curve:ident => $answer:expr) => {
        match $self {
            AnyCurve::Coulomb($curve) => $answer,
            AnyCurve::Stribeck($curve) => $answer,
            AnyCurve::RationalStribeck($curve) => $answer,
            #[cfg(feature = "alloc")]
            AnyCurve::Tabulated($curve) => $answer,
            #[cfg(feature = "alloc")]
            AnyCurve::Asymmetric($curve) => $answer,
            #[cfg(feature = "alloc")]
            AnyCurve::Own($curve) => $answer,
        }
    };
}

impl<T: Scalar> FrictionCurve<T> for AnyCurve<T> {
    #[inline(always)]
    fn coefficient(&self, sliding: Sliding<T>) -> T {
        match self {
            Self::Coulomb(curve) => curve.coefficient(sliding),
            Self::Stribeck(curve) => curve.coefficient(sliding),
            Self::RationalStribeck(curve) => curve.coefficient(sliding),
            #[cfg(feature = "alloc")]
            _ => {
                let (velocity, speed, direction) = sliding.parts();
                self.allocated(velocity, speed, direction)
            }
        }
    }

    #[inline(always)]
    fn coefficient_and_slope(&self, sliding: Sliding<T>) -> (T, T) {
        match self {
            Self::Coulomb(curve) => curve.coefficient_and_slope(sliding),
            Self::Stribeck(curve) => curve.coefficient_and_slope(sliding),
            Self::RationalStribeck(curve) => curve.coefficient_and_slope(sliding),
            #[cfg(feature = "alloc")]
            _ => {
                let (velocity, speed, direction) = sliding.parts();
                self.allocated_and_slope(velocity, speed, direction)
            }
        }
    }

    fn with_less_viscous_friction(&self, part: T) -> Self {
        of_the_curve!(self, curve => curve.with_less_viscous_friction(part).into())
    }

    passed_on! { of_the_curve:
        bounds(fastest: T) -> Bounds<T>;
        viscous_friction() -> T;
        slope_at_rest() -> T;
        least_slope() -> Option<T>;
        is_even() -> bool;
    }
}

#[cfg(feature = "alloc")]
impl<T: Scalar, F: Into<AnyCurve<T>>, B: Into<AnyCurve<T>>> From<Asymmetric<F, B>> for AnyCurve<T> {
    fn from(curve: Asymmetric<F, B>) -> Self {
        let (forward, backward) = (curve.forward.into(), curve.backward.into());
        Self::Asymmetric(Box::new(Asymmetric { forward, backward }))
    }
}

#[cfg(feature = "alloc")]
impl<T: Scalar> AnyCurve<T> {
    /// A curve of your own, behind a pointer.
    ///
    /// ```
    /// use bristle::Bounds;
    /// use bristle::curve::{AnyCurve, FrictionCurve, FunctionCurve};
    ///
    /// let rising = |speed: f64| (0.1 + speed, 1.0);
    /// let bounds = Bounds { min: 0.1, max: f64::INFINITY };
    /// let curve = AnyCurve::own(FunctionCurve::new(rising, bounds)?);
    /// assert_eq!(curve.at(0.3), 0.4);
    /// # Ok::<(), bristle::ParameterError>(())
    /// ```
    pub fn own(curve: impl FrictionCurve<T> + Send + Sync + 'static) -> Self {
        Self::Own(OwnCurve::new(curve))
    }

    /// μ(v) of the curves behind a pointer: a call, so that the others are inlined. It takes the
    /// parts of a [`Sliding`], which would be passed in memory, and all other uses wait for it.
    #[inline(never)]
    fn allocated(&self, velocity: T, speed: T, direction: T) -> T {
        let sliding = Sliding::from_parts(velocity, speed, direction);
        of_the_curve!(self, curve => curve.coefficient(sliding))
    }

    /// μ(v) of the curves behind a pointer, and its slope.
    #[inline(never)]
    fn allocated_and_slope(&self, velocity: T, speed: T, direction: T) -> (T, T) {
        let sliding = Sliding::from_parts(velocity, speed, direction);
        of_the_curve!(self, curve => curve.coefficient_and_slope(sliding))
    }
}

holds! { AnyCurve:
    Coulomb(Coulomb<T>)
    Stribeck(Stribeck<T>)
    RationalStribeck(RationalStribeck<T>)
    #[cfg(feature = "alloc")]
    Tabulated(Tabulated<Vec<Cubic<T>>>)
    #[cfg(feature = "alloc")]
    Own(OwnCurve<T>)
}
