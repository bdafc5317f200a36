//! A polynomial times an exponential: p(ξ) = e^(−aξ) Σ cₖ ξᵏ. The pressures of the paper, constant,
//! exponential and parabolic, are cases of it.
//!
//! Source: Romano et al. (arXiv 2602.09429), section IV-A.

use nalgebra::Complex;

use super::Pressure;
use crate::Scalar;
use crate::parameter::{self, ParameterError, Rule};
use crate::rolling::integrals::{complex_decaying, decaying, rising};
use crate::scalar::{is_zero, lit, to_f64};

/// Parameters of [`PolynomialExponential`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PolynomialExponentialParameters<T, const N: usize> {
    /// Coefficients c₀ … c_{N−1} [N/m] of 1, ξ, ξ², …: 1 to 12 of them.
    pub coefficients: [T; N],
    /// Decay a \[–\], between −50 and 50.
    pub decay: T,
}

/// The pressure e^(−aξ) Σ cₖ ξᵏ with N coefficients.
///
/// ```
/// use bristle::rolling::{PolynomialExponential, Pressure};
///
/// let parabola = PolynomialExponential::parabolic();
/// assert_eq!(parabola.total(), 1.0);
/// assert_eq!(parabola.at(0.5), 1.5);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PolynomialExponential<T, const N: usize> {
    coefficients: [T; N],
    decay: T,
}

impl<T: Scalar> PolynomialExponential<T, 1> {
    /// Constant pressure with ∫₀¹ p dξ = 1 N/m; for another one see
    /// [`Patch::carrying`](crate::rolling::Patch::carrying).
    pub fn constant() -> Self {
        Self { coefficients: [T::one()], decay: T::zero() }
    }

    /// Exponential pressure p₀ e^(−aξ) with ∫₀¹ p dξ = 1 N/m.
    ///
    /// # Errors
    ///
    /// Refuses a decay outside −50 … 50.
    pub fn exponential(decay: T) -> Result<Self, ParameterError> {
        let decay = admissible(decay)?;
        Ok(Self { coefficients: [T::one() / decaying::<T, 1>(decay)[0]], decay })
    }
}

impl<T: Scalar> PolynomialExponential<T, 3> {
    /// Parabolic pressure 6 ξ(1 − ξ), with ∫₀¹ p dξ = 1 N/m.
    pub fn parabolic() -> Self {
        Self { coefficients: [T::zero(), lit(6.0), lit(-6.0)], decay: T::zero() }
    }
}

fn admissible<T: Scalar>(decay: T) -> Result<T, ParameterError> {
    const MOST: f64 = 50.0;
    if decay >= lit(-MOST) && decay <= lit(MOST) {
        Ok(decay)
    } else {
        let rule = Rule::Magnitude { most: MOST };
        Err(ParameterError { name: "decay", component: None, value: to_f64(decay), rule })
    }
}

impl<T: Scalar, const N: usize> PolynomialExponential<T, N> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Names the coefficient or the decay that is out of its range; refuses a pressure that is negative
    /// somewhere in the patch, and more coefficients than 12 or none.
    pub fn new(parameters: PolynomialExponentialParameters<T, N>) -> Result<Self, ParameterError> {
        let PolynomialExponentialParameters { coefficients, decay } = parameters;
        if N == 0 || N > 12 {
            let rule = Rule::Count { least: 1 };
            return Err(ParameterError {
                name: "coefficients",
                component: None,
                value: N as f64,
                rule,
            });
        }
        for (index, &coefficient) in coefficients.iter().enumerate() {
            parameter::component(index, parameter::finite("coefficients", coefficient))?;
        }
        Ok(Self { coefficients, decay: admissible(decay)? })
    }

    /// The coefficients c₀ … c_{N−1} [N/m].
    pub fn coefficients(&self) -> &[T; N] {
        &self.coefficients
    }

    /// The decay a \[–\].
    pub fn decay(&self) -> T {
        self.decay
    }

    /// Σ cₖ mₖ
    #[inline]
    pub(in crate::rolling) fn weigh(&self, moments: &[T; N]) -> T {
        self.coefficients.iter().zip(moments).fold(T::zero(), |sum, (&c, &m)| sum + c * m)
    }

    /// ∫₀¹ e^(−xt) ∫ p(ξ + t d) z dξ dt, from the moments mₖ = ∫ ξᵏ e^(−aξ) z dξ: what bristles meet that move on
    /// by a distance d and decay meanwhile by e⁻ˣ.
    #[inline]
    pub(in crate::rolling) fn weigh_on_the_way(
        &self,
        moments: &[T; N],
        distance: T,
        exponent: T,
    ) -> T {
        // (ξ + t d)ᵏ = Σ (k over j) ξᵏ⁻ʲ (t d)ʲ
        let mut along: [T; N] = decaying(exponent + self.decay * distance);
        let mut power = T::one();
        for moment in &mut along {
            *moment *= power;
            power *= distance;
        }
        let mut sum = T::zero();
        for (k, &coefficient) in self.coefficients.iter().enumerate() {
            let (mut binomial, mut inner) = (1.0, T::zero());
            for (j, (&along, &moment)) in
                along.iter().zip(moments.iter().take(k + 1).rev()).enumerate()
            {
                inner += lit::<T>(binomial) * along * moment;
                binomial *= (k - j) as f64 / (j + 1) as f64;
            }
            sum += coefficient * inner;
        }
        sum
    }
}

impl<T: Scalar, const N: usize> Pressure<T> for PolynomialExponential<T, N> {
    #[inline]
    fn at(&self, place: T) -> T {
        let value = self.coefficients.iter().rev().fold(T::zero(), |sum, &c| sum * place + c);
        if is_zero(self.decay) { value } else { (-self.decay * place).exp() * value }
    }

    fn at_and_slope(&self, place: T) -> (T, T) {
        let (mut value, mut slope) = (T::zero(), T::zero());
        for &coefficient in self.coefficients.iter().rev() {
            slope = slope * place + value;
            value = value * place + coefficient;
        }
        let weight = (-self.decay * place).exp();
        (weight * value, weight * (slope - self.decay * value))
    }

    fn total(&self) -> T {
        self.weigh(&decaying(self.decay))
    }

    fn rise(&self, decay: T) -> T {
        // (1 − e^(−κξ)) = κ ξ φ1(κξ)
        decay * self.weigh(&rising(self.decay, decay))
    }

    fn transform(&self, rate: Complex<T>) -> Complex<T> {
        let moments = complex_decaying::<T, N>(rate + Complex::from(self.decay));
        let mut sum = Complex::new(T::zero(), T::zero());
        for (&coefficient, moment) in self.coefficients.iter().zip(moments) {
            sum += moment.scale(coefficient);
        }
        sum
    }
}
