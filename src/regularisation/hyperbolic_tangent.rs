//! The hyperbolic-tangent regularisation.

use crate::parameter::{Checked, Named};
use crate::regularisation::Regularisation;
use crate::scalar::lit;
use crate::{Scalar, Sliding};

/// The hyperbolic-tangent regularisation, sgn_ε(v) = tanh(v/v_t), |v|_ε = v coth(v/v_t).
///
/// The most common smoothing of Coulomb friction in multibody codes; v_t [m/s] is the velocity at
/// which 76 % of the friction is reached, and |0|_ε = v_t. See E. Pennestrì, V. Rossi, P. Salvini,
/// P. P. Valentini, "Review and comparison of dry friction force models", Nonlinear Dynamics 83
/// (2016), 1785–1801.
///
/// ```
/// use bristle::regularisation::{HyperbolicTangent, Regularisation};
///
/// let regularisation = HyperbolicTangent::new(1e-3)?;
/// assert_eq!(regularisation.speed(0.0.into()), 1e-3);
/// assert_eq!(regularisation.sign(2e-3.into()), 2f64.tanh());
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HyperbolicTangent<T> {
    threshold: T,
}

impl<T: Scalar> HyperbolicTangent<T> {
    /// Takes the threshold velocity v_t > 0 [m/s].
    ///
    /// # Errors
    ///
    /// Refuses a v_t that is not positive.
    pub fn new(threshold_velocity: T) -> Checked<Self> {
        Ok(Self { threshold: Named("threshold_velocity", threshold_velocity).positive()? })
    }

    /// The threshold velocity v_t [m/s].
    pub fn threshold_velocity(&self) -> T {
        self.threshold
    }
}

/// The hyperbolic tangent, which is ±1 to rounding long before the exponentials of which some
/// scalars make it overflow.
#[inline]
fn tanh<T: Scalar>(u: T) -> T {
    let saturated: T = lit(20.0);
    if u > saturated {
        T::one()
    } else if u < -saturated {
        -T::one()
    } else {
        u.tanh()
    }
}

impl<T: Scalar> Regularisation<T> for HyperbolicTangent<T> {
    #[inline]
    fn speed(&self, sliding: Sliding<T>) -> T {
        let u = sliding.velocity() / self.threshold;
        if u * u < lit(1e-8) {
            // u coth u = 1 + u²/3 − u⁴/45 + …
            let w = u * u;
            self.threshold * (T::one() + w * (lit::<T>(1.0 / 3.0) - w / lit(45.0)))
        } else {
            sliding.velocity() / tanh(u)
        }
    }

    #[inline]
    fn speed_and_slope(&self, sliding: Sliding<T>) -> (T, T) {
        let u = sliding.velocity() / self.threshold;
        // d(u coth u)/du = coth u − u/sinh² u, which cancels near rest: up to |u| = 0.35 its
        // series Σ 4ⁿ B₂ₙ/(2n)! · 2n u^(2n−1), cut at 2e-17.
        let w = u * u;
        let slope = if w < lit(0.1225) {
            const SERIES: [f64; 9] = [
                2.0 / 3.0,
                -4.0 / 45.0,
                4.0 / 315.0,
                -8.0 / 4725.0,
                4.0 / 18_711.0,
                -5528.0 / 212_837_625.0,
                8.0 / 2_606_175.0,
                -57_872.0 / 162_820_783_125.0,
                175_468.0 / 4_331_032_831_125.0,
            ];
            u * SERIES.iter().rev().fold(T::zero(), |sum, &c| sum * w + lit(c))
        } else {
            let coth = T::one() / tanh(u);
            // 1/sinh² = coth² − 1, written with exp so that it neither cancels nor overflows.
            let decay = (-lit::<T>(2.0) * u.abs()).exp();
            let rest = T::one() - decay;
            coth - u * lit(4.0) * decay / (rest * rest)
        };
        (self.speed(sliding), slope)
    }

    #[inline]
    fn sign(&self, sliding: Sliding<T>) -> T {
        tanh(sliding.velocity() / self.threshold)
    }

    #[inline]
    fn sign_and_slope(&self, sliding: Sliding<T>) -> (T, T) {
        let sign = self.sign(sliding);
        let decay = (-lit::<T>(2.0) * (sliding.velocity() / self.threshold).abs()).exp();
        let sum = T::one() + decay;
        // 1/cosh² without the cancellation of 1 − tanh².
        (sign, lit::<T>(4.0) * decay / (sum * sum * self.threshold))
    }

    fn speed_at_rest(&self) -> T {
        self.threshold
    }
}
