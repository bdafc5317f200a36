//! A pressure chosen at run time.

use nalgebra::Complex;

#[cfg(feature = "alloc")]
use super::FunctionPressure;
use super::{PolynomialExponential, Pressure};
use bristle::Scalar;
#[cfg(feature = "alloc")]
use bristle::signal::{Polyline, Vertex};

/// A pressure chosen at run time, with the numbers of the type that it holds to the last bit.
///
/// Steady rolling, its linearisation and `Grid` take it. The exact reduction takes the
/// [`PolynomialExponential`] that it holds.
///
/// ```
/// use bristle_rolling::{AnyPressure, PolynomialExponential, Pressure};
///
/// let pressure: AnyPressure<f64> = PolynomialExponential::parabolic().into();
/// assert_eq!(pressure.at(0.5), 1.5);
/// ```
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "serde", serde(bound(deserialize = "T: Scalar + serde::Deserialize<'de>")))]
#[cfg_attr(feature = "serde", serde(bound(serialize = "T: Scalar + serde::Serialize")))]
#[non_exhaustive]
pub enum AnyPressure<T> {
    /// c₀ e^(−aξ): constant for a = 0.
    Exponential(PolynomialExponential<T, 1>),
    /// e^(−aξ) (c₀ + c₁ ξ + c₂ ξ²): parabolic with c = 0, 6, −6 and a = 0.
    Quadratic(PolynomialExponential<T, 3>),
    /// e^(−aξ) Σ cₖ ξᵏ of up to 12 coefficients, filled up with zeros.
    Polynomial(PolynomialExponential<T, 12>),
    /// Straight lines between any number of measured points.
    #[cfg(feature = "alloc")]
    Polyline(FunctionPressure<T, Polyline<alloc::vec::Vec<Vertex<T>>>>),
}

/// Calls a function of the pressure.
macro_rules! of_the_pressure {
    ($self:ident, $pressure:ident => $answer:expr) => {
        match $self {
            AnyPressure::Exponential($pressure) => $answer,
            AnyPressure::Quadratic($pressure) => $answer,
            AnyPressure::Polynomial($pressure) => $answer,
            #[cfg(feature = "alloc")]
            AnyPressure::Polyline($pressure) => $answer,
        }
    };
}

impl<T: Scalar> Pressure<T> for AnyPressure<T> {
    fn at(&self, place: T) -> T {
        of_the_pressure!(self, pressure => pressure.at(place))
    }

    fn at_and_slope(&self, place: T) -> (T, T) {
        of_the_pressure!(self, pressure => pressure.at_and_slope(place))
    }

    fn next_knot(&self, place: T) -> Option<T> {
        of_the_pressure!(self, pressure => pressure.next_knot(place))
    }

    fn total(&self) -> T {
        of_the_pressure!(self, pressure => pressure.total())
    }

    fn rise(&self, decay: T) -> T {
        of_the_pressure!(self, pressure => pressure.rise(decay))
    }

    fn remaining(&self, decay: T) -> T {
        of_the_pressure!(self, pressure => pressure.remaining(decay))
    }

    fn lever(&self, decay: T) -> T {
        of_the_pressure!(self, pressure => pressure.lever(decay))
    }

    fn transform(&self, rate: Complex<T>) -> Complex<T> {
        of_the_pressure!(self, pressure => pressure.transform(rate))
    }

    fn transform_slope(&self, from: T, to: Complex<T>) -> Complex<T> {
        of_the_pressure!(self, pressure => pressure.transform_slope(from, to))
    }
}

impl<T> From<PolynomialExponential<T, 1>> for AnyPressure<T> {
    fn from(pressure: PolynomialExponential<T, 1>) -> Self {
        Self::Exponential(pressure)
    }
}

impl<T> From<PolynomialExponential<T, 3>> for AnyPressure<T> {
    fn from(pressure: PolynomialExponential<T, 3>) -> Self {
        Self::Quadratic(pressure)
    }
}

impl<T> From<PolynomialExponential<T, 12>> for AnyPressure<T> {
    fn from(pressure: PolynomialExponential<T, 12>) -> Self {
        Self::Polynomial(pressure)
    }
}

#[cfg(feature = "alloc")]
impl<T> From<FunctionPressure<T, Polyline<alloc::vec::Vec<Vertex<T>>>>> for AnyPressure<T> {
    fn from(pressure: FunctionPressure<T, Polyline<alloc::vec::Vec<Vertex<T>>>>) -> Self {
        Self::Polyline(pressure)
    }
}
