//! A polynomial times an exponential: p(ξ) = e^(−aξ) Σ cₖ ξᵏ. The pressures of the paper, constant,
//! exponential and parabolic, are cases of it.
//!
//! Source: Romano et al. (arXiv 2602.09429), section IV-A.

use nalgebra::Complex;

use super::Pressure;
use crate::moments::{complex_decaying, decaying, rising};
use bristle::Scalar;
use bristle::parameter::{Checked, Named, ParameterError, Rule};
use bristle::scalar::{is_zero, lit, to_f64};

/// Parameters of [`PolynomialExponential`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
#[cfg_attr(feature = "serde", serde(bound(deserialize = "T: serde::Deserialize<'de>")))]
#[cfg_attr(feature = "serde", serde(bound(serialize = "T: serde::Serialize")))]
pub struct PolynomialExponentialParameters<T, const N: usize> {
    /// Coefficients c₀ … c_{N−1} [N/m] of 1, ξ, ξ², …: 1 to 12 of them.
    #[cfg_attr(feature = "serde", serde(with = "bristle::serialisation::array"))]
    pub coefficients: [T; N],
    /// Decay a \[–\], between −50 and 50.
    pub decay: T,
}

/// The pressure e^(−aξ) Σ cₖ ξᵏ with N coefficients.
///
/// ```
/// use bristle_rolling::{PolynomialExponential, Pressure};
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
    /// [`Patch::under_load`](crate::Patch::under_load).
    pub fn constant() -> Self {
        Self { coefficients: [T::one()], decay: T::zero() }
    }

    /// Exponential pressure p₀ e^(−aξ) with ∫₀¹ p dξ = 1 N/m.
    ///
    /// # Errors
    ///
    /// Refuses a decay outside −50 … 50.
    pub fn exponential(decay: T) -> Checked<Self> {
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

fn admissible<T: Scalar>(decay: T) -> Checked<T> {
    const MOST: f64 = 50.0;
    Named("decay", decay).between(-MOST, MOST)
}

/// More would lose their digits to each other.
const MOST_COEFFICIENTS: usize = 12;

/// A place in [0, 1] where Σ cₖ ξᵏ is negative by more than the rounding of its coefficients.
///
/// On an interval a polynomial lies between the least and the largest of its Bernstein
/// coefficients, of which the first and the last are its values at the ends. They come closer to
/// it by a factor of four each time the interval is halved (G. Farin, "Curves and Surfaces for
/// CAGD", 5th ed., 2002, chapters 5 and 6).
fn negative_place<T: Scalar, const N: usize>(coefficients: &[T; N]) -> Option<f64> {
    let power = coefficients.map(to_f64);
    let size = power.iter().fold(0.0, |sum, &c| if c < 0.0 { sum - c } else { sum + c });
    // b_j = Σ_{k ≤ j} cₖ C(j, k)/C(n, k)
    let degree = N.saturating_sub(1);
    let bernstein = core::array::from_fn::<f64, N, _>(|j| {
        let (mut share, mut sum) = (1.0, 0.0);
        for (k, c) in power.iter().enumerate().take(j + 1) {
            sum += c * share;
            share *= (j - k) as f64 / (degree.max(k + 1) - k) as f64;
        }
        sum
    });
    let noise = 64.0 * to_f64(T::default_epsilon()) * size;
    negative_within(bernstein, (0.0, 1.0), -noise, 40)
}

/// Such a place on an interval, of which `halvings` are left before no polynomial of these
/// coefficients can be further below `least` than rounding.
fn negative_within<const N: usize>(
    bernstein: [f64; N],
    (from, to): (f64, f64),
    least: f64,
    halvings: usize,
) -> Option<f64> {
    if bernstein.iter().all(|&b| b >= least) {
        return None;
    }
    if bernstein.first().is_some_and(|&b| b < least) {
        return Some(from);
    }
    if bernstein.last().is_some_and(|&b| b < least) {
        return Some(to);
    }
    if halvings == 0 {
        return None;
    }
    // De Casteljau: the coefficients of both halves.
    let (mut left, mut right) = (bernstein, bernstein);
    for level in 1..N {
        for j in (level..N).rev() {
            left[j] = 0.5 * (left[j - 1] + left[j]);
        }
        for j in 0..N - level {
            right[j] = 0.5 * (right[j] + right[j + 1]);
        }
    }
    let middle = 0.5 * (from + to);
    negative_within(left, (from, middle), least, halvings - 1)
        .or_else(|| negative_within(right, (middle, to), least, halvings - 1))
}

impl<T: Scalar, const N: usize> PolynomialExponential<T, N> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Names the coefficient or the decay that is out of its range; refuses a pressure that is
    /// negative somewhere in the patch, and more coefficients than 12 or none.
    pub fn new(parameters: PolynomialExponentialParameters<T, N>) -> Checked<Self> {
        let PolynomialExponentialParameters { coefficients, decay } = parameters;
        Named("coefficients", N).count_between(1, MOST_COEFFICIENTS)?;
        ParameterError::of_components(&coefficients, |&it| Named("coefficients", it).finite())?;
        let pressure = Self { coefficients, decay: admissible(decay)? };
        if let Some(place) = negative_place(&coefficients) {
            let rule = Rule::NonNegativeAt { place };
            return Err(Named("pressure", pressure.at(lit(place))).refused(rule));
        }
        Ok(pressure)
    }

    /// This pressure with zeros for its highest coefficients, K in all. With one zero
    /// [`ExactPatch::moment`](crate::ExactPatch::moment) takes a fixed number of
    /// operations. K below N or above 12 does not compile.
    ///
    /// ```
    /// use bristle_rolling::{PolynomialExponential, Pressure};
    ///
    /// let parabola = PolynomialExponential::<f64, 3>::parabolic().padded::<4>();
    /// assert_eq!(parabola.parameters().coefficients, [0.0, 6.0, -6.0, 0.0]);
    /// assert_eq!(parabola.total(), 1.0);
    /// ```
    pub fn padded<const K: usize>(self) -> PolynomialExponential<T, K> {
        const { assert!(N <= K && K <= MOST_COEFFICIENTS, "K lies between N and 12") };
        let coefficient = |k: usize| self.coefficients.get(k).copied().unwrap_or_else(T::zero);
        PolynomialExponential { coefficients: core::array::from_fn(coefficient), decay: self.decay }
    }

    /// The parameters, as they were given.
    pub fn parameters(&self) -> PolynomialExponentialParameters<T, N> {
        PolynomialExponentialParameters { coefficients: self.coefficients, decay: self.decay }
    }

    /// The decay a \[–\].
    pub fn decay(&self) -> T {
        self.decay
    }

    /// Σ cₖ mₖ
    #[inline]
    pub(crate) fn weigh(&self, moments: &[T; N]) -> T {
        self.coefficients.iter().zip(moments).fold(T::zero(), |sum, (&c, &m)| sum + c * m)
    }

    /// The number of coefficients up to the last that is not zero.
    #[inline]
    pub(crate) fn terms(&self) -> usize {
        self.coefficients.iter().rposition(|&c| !is_zero(c)).map_or(0, |last| last + 1)
    }

    /// Σ cₖ mₖ and Σ cₖ mₖ₊₁, if no moment is missing.
    pub(crate) fn weigh_next(&self, moments: &[T; N]) -> Option<(T, T)> {
        let complete = self.coefficients.last().is_some_and(|&last| is_zero(last));
        let next = self.coefficients.iter().zip(moments.iter().skip(1));
        let next = next.fold(T::zero(), |sum, (&c, &m)| sum + c * m);
        complete.then(|| (self.weigh(moments), next))
    }

    /// ∫₀¹ e^(−xt) ∫ p(ξ + t d) z dξ dt, from the moments mₖ = ∫ ξᵏ e^(−aξ) z dξ: what bristles
    /// meet that move on by a distance d and decay meanwhile by e⁻ˣ.
    #[inline]
    pub(crate) fn weigh_on_the_way(&self, moments: &[T; N], distance: T, exponent: T) -> T {
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
        if decay > T::one().larger(self.decay) {
            // Little enough remains for the difference.
            return self.total() - self.remaining(decay);
        }
        // 1 − e^(−κξ) = κ ξ φ1(κξ)
        decay * self.weigh(&rising(self.decay, decay))
    }

    fn remaining(&self, decay: T) -> T {
        self.weigh(&decaying(self.decay + decay))
    }

    fn lever(&self, decay: T) -> T {
        let moments = decaying::<T, { MOST_COEFFICIENTS + 1 }>(self.decay + decay);
        self.weigh(&core::array::from_fn(|k| moments[k + 1]))
    }

    fn transform(&self, rate: Complex<T>) -> Complex<T> {
        let moments = complex_decaying::<T, N>(rate + Complex::from(self.decay));
        self.coefficients.iter().zip(moments).map(|(&c, moment)| moment.scale(c)).sum()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::panic, reason = "a test panics to fail")]
    extern crate std;
    use super::*;
    use std::format;

    fn refused<const N: usize>(coefficients: [f64; N]) -> Option<ParameterError> {
        let parameters = PolynomialExponentialParameters { coefficients, decay: 2.0 };
        PolynomialExponential::new(parameters).err()
    }

    #[test]
    fn a_pressure_that_touches_zero_passes() {
        assert_eq!(refused([0.0, 6.0, -6.0]), None);
        assert_eq!(refused([0.0]), None);
        // (ξ − 0.3)² and (ξ − 0.7)⁴, whose coefficients are rounded.
        assert_eq!(refused([0.09, -0.6, 1.0]), None);
        let c = 0.7_f64;
        assert_eq!(refused([c.powi(4), -4.0 * c.powi(3), 6.0 * c * c, -4.0 * c, 1.0]), None);
        // ξ(1 − ξ)⁹: zero ten times over.
        let binomials = [1.0, -9.0, 36.0, -84.0, 126.0, -126.0, 84.0, -36.0, 9.0, -1.0];
        let mut coefficients = [0.0; 11];
        coefficients[1..].copy_from_slice(&binomials);
        assert_eq!(refused(coefficients), None);
        let single =
            PolynomialExponentialParameters { coefficients: [0.09_f32, -0.6, 1.0], decay: 0.0 };
        assert!(PolynomialExponential::new(single).is_ok());
    }

    #[test]
    fn a_pressure_that_dips_below_zero_is_refused_with_the_place() {
        // (ξ − 0.3)² − 10⁻⁸, which no coarse sampling sees.
        let error = refused([0.09 - 1e-8, -0.6, 1.0]).unwrap();
        let Rule::NonNegativeAt { place } = error.rule else { panic!("{error}") };
        assert!((place - 0.3).abs() < 1e-4, "{place}");
        assert!(error.name == "pressure" && error.value < 0.0);
        let error = refused([1.0, -2.0]).unwrap();
        assert_eq!(error.rule, Rule::NonNegativeAt { place: 1.0 });
        assert_eq!(
            format!("{}", refused([-1.0]).unwrap()),
            "pressure is -1, but must be zero or positive at ξ = 0"
        );
    }

    #[test]
    fn counts_and_numbers_out_of_range_are_refused() {
        let rule = Rule::CountBetween { least: 1, most: 12 };
        assert_eq!(refused([1.0; 13]).unwrap().rule, rule);
        assert_eq!(refused([]).unwrap().rule, rule);
        assert_eq!(refused([1.0; 12]), None);
        assert_eq!(refused([1.0, f64::NAN]).unwrap().component, Some(1));
        assert_eq!(PolynomialExponential::exponential(51.0).unwrap_err().name, "decay");
        assert_eq!(PolynomialExponential::exponential(f64::NAN).unwrap_err().name, "decay");
    }
}
