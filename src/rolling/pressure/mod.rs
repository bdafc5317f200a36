//! Pressure along a contact patch: normal force per length over the place ξ, 0 at the inlet and 1 at the
//! outlet.

mod polynomial_exponential;

use core::fmt::Debug;

pub use polynomial_exponential::{PolynomialExponential, PolynomialExponentialParameters};

use nalgebra::Complex;

use crate::Scalar;

/// A pressure p(ξ) ≥ 0 [N/m] over 0 ≤ ξ ≤ 1.
pub trait Pressure<T: Scalar>: Debug + Clone {
    /// The pressure [N/m] at a place.
    fn at(&self, place: T) -> T;

    /// The pressure and its slope dp/dξ [N/m] at a place; at a knot those just after it (at the outlet
    /// those just before).
    fn at_and_slope(&self, place: T) -> (T, T);

    /// The first place strictly between `place` and the outlet at which the pressure is not smooth.
    fn next_knot(&self, place: T) -> Option<T> {
        let _ = place;
        None
    }

    /// ∫₀¹ p dξ [N/m].
    fn total(&self) -> T;

    /// ∫₀¹ p (1 − e^(−κξ)) dξ [N/m] for κ ≥ 0, to the last digits however small κ is.
    fn rise(&self, decay: T) -> T;

    /// ∫₀¹ p e^(−sξ) dξ [N/m] for a complex s with Re s ≥ 0.
    fn transform(&self, rate: Complex<T>) -> Complex<T>;
}
