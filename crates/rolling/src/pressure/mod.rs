//! Pressure along a contact patch: normal force per length over the place ξ, 0 at the inlet and 1
//! at the outlet.

mod any;
mod function;
mod polynomial_exponential;

use core::fmt::Debug;

pub use any::AnyPressure;
pub use function::FunctionPressure;
pub use polynomial_exponential::{PolynomialExponential, PolynomialExponentialParameters};

use nalgebra::{Complex, ComplexField};

use super::moments::complex_phi1;
use super::quadrature::weigh;
use bristle::Scalar;
use bristle::scalar::lit;

/// A pressure p(ξ) ≥ 0 [N/m] over 0 ≤ ξ ≤ 1.
///
/// A pressure of your own takes two methods, and a third if it has knots. Its integrals are then
/// taken by Gauss quadrature between the knots, to rounding if it is smooth on the scale of a
/// sixteenth of the way from one knot to the next. Closed forms, where there are any, are faster.
///
/// ```
/// use bristle_rolling::Pressure;
///
/// /// p = 1 + cos(πξ): high at the inlet, zero at the outlet.
/// #[derive(Debug, Clone)]
/// struct Cosine;
///
/// impl Pressure<f64> for Cosine {
///     fn at_and_slope(&self, place: f64) -> (f64, f64) {
///         let (sin, cos) = (std::f64::consts::PI * place).sin_cos();
///         (1.0 + cos, -std::f64::consts::PI * sin)
///     }
///
///     fn total(&self) -> f64 {
///         1.0
///     }
/// }
///
/// // ∫ p e^(−κξ) dξ = (1 − e^(−κ))/κ + κ(1 + e^(−κ))/(κ² + π²)
/// assert!((Cosine.remaining(1.0) - 0.757_965_013_759_627).abs() < 1e-15);
/// ```
pub trait Pressure<T: Scalar>: Debug + Clone {
    /// The pressure [N/m] at a place.
    fn at(&self, place: T) -> T {
        self.at_and_slope(place).0
    }

    /// The pressure and its slope dp/dξ [N/m] at a place; at a knot those just after it (at the
    /// outlet those just before).
    fn at_and_slope(&self, place: T) -> (T, T);

    /// The first place strictly between `place` and the outlet at which the pressure is not smooth.
    fn next_knot(&self, place: T) -> Option<T> {
        let _ = place;
        None
    }

    /// ∫₀¹ p dξ [N/m].
    fn total(&self) -> T;

    /// ∫₀¹ p (1 − e^(−κξ)) dξ [N/m] for κ ≥ 0, which may be infinite, to the last digits however
    /// small κ is.
    fn rise(&self, decay: T) -> T {
        weighed(self, decay, |place| -(-decay * place).exp_m1()).unwrap_or_else(|| self.total())
    }

    /// ∫₀¹ p e^(−κξ) dξ [N/m] for κ ≥ 0, which may be infinite: what [`Pressure::rise`] leaves, to
    /// the last digits however large κ is.
    fn remaining(&self, decay: T) -> T {
        weighed(self, decay, |place| (-decay * place).exp()).unwrap_or_else(T::zero)
    }

    /// ∫₀¹ p ξ e^(−κξ) dξ [N/m] for κ ≥ 0, which may be infinite: the derivative of
    /// [`Pressure::rise`] with respect to κ.
    fn lever(&self, decay: T) -> T {
        weighed(self, decay, |place| place * (-decay * place).exp()).unwrap_or_else(T::zero)
    }

    /// ∫₀¹ p e^(−sξ) dξ [N/m] for a complex s with Re s ≥ 0, to a rounding of [`Pressure::total`].
    ///
    /// By quadrature it is work that grows with |s|, and NaN for waves beyond |s| = 2 097 152.
    fn transform(&self, rate: Complex<T>) -> Complex<T> {
        let mut sum = Complex::new(T::zero(), T::zero());
        weigh(self, None, rate, |place, pressure| {
            sum += (-rate.scale(place)).exp().scale(pressure);
        });
        sum
    }

    /// ∫₀¹ p (e^(−aξ) − e^(−bξ))/(b − a) dξ [N/m] for complex a and b with Re b ≥ Re a ≥ 0 and Im
    /// a = 0: the slope of [`Pressure::transform`] between the two, without its sign, to the last
    /// digits however close they are.
    fn transform_slope(&self, from: T, to: Complex<T>) -> Complex<T> {
        let from = Complex::new(from, T::zero());
        let gap = to - from;
        if gap.modulus() > lit::<T>(0.5) * (T::one() + from.re) {
            return (self.transform(from) - self.transform(to)) / gap;
        }
        let mut sum = Complex::new(T::zero(), T::zero());
        weigh(self, None, to.modulus().into(), |place, pressure| {
            let weight = pressure * place * (-from.re * place).exp();
            sum += complex_phi1(gap.scale(place)).scale(weight);
        });
        sum
    }
}

/// ∫ p f dξ of a function as steep as e^(−κξ); none for an infinite κ, of a patch that slides
/// without rolling.
fn weighed<T: Scalar, P: Pressure<T>>(
    pressure: &P,
    decay: T,
    function: impl Fn(T) -> T,
) -> Option<T> {
    if !decay.is_finite() && decay > T::zero() {
        return None;
    }
    let mut sum = T::zero();
    weigh(pressure, None, decay.into(), |place, pressure| sum += pressure * function(place));
    Some(sum)
}
