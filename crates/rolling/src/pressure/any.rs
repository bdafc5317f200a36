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
/// let pressure: AnyPressure<f64> = AnyPressure::Quadratic(PolynomialExponential::parabolic());
/// assert_eq!(pressure.at(0.5), 1.5);
/// ```
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum AnyPressure<T: Scalar> {
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

/// Passes methods on to the pressure.
macro_rules! passed_on {
    ($($name:ident($($argument:ident: $type:ty),*) -> $answer:ty;)*) => {
        $(fn $name(&self, $($argument: $type),*) -> $answer {
            match self {
                Self::Exponential(pressure) => pressure.$name($($argument),*),
                Self::Quadratic(pressure) => pressure.$name($($argument),*),
                Self::Polynomial(pressure) => pressure.$name($($argument),*),
                #[cfg(feature = "alloc")]
                Self::Polyline(pressure) => pressure.$name($($argument),*),
            }
        })*
    };
}

impl<T: Scalar> Pressure<T> for AnyPressure<T> {
    passed_on! {
        at(place: T) -> T;
        at_and_slope(place: T) -> (T, T);
        next_knot(place: T) -> Option<T>;
        total() -> T;
        rise(decay: T) -> T;
        remaining(decay: T) -> T;
        lever(decay: T) -> T;
        transform(rate: Complex<T>) -> Complex<T>;
        transform_slope(from: T, to: Complex<T>) -> Complex<T>;
    }
}
