//! One algebra under all models: at a given velocity each is affine in the deflection.
//!
//! ż   = −λ(v) z + r(v) v
//! μ_b =  c₀(v) z + c₂(v) v
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | λ | relaxation rate | 1/s |
//! | r | drive | – |
//! | c₀ | stiffness | 1/m |
//! | c₂ | damping | s/m |
//!
//! Held velocity: with x = λh and φ1(x) = (1 − e⁻ˣ)/x, φ2(x) = (1 − φ1(x))/x,
//!
//! z(h) = e⁻ˣ z + φ1 h r v,  mean of z over the step = φ1 z + φ2 h r v,
//!
//! exact for every h ≥ 0, and for λ = 0 where z grows as r v t.

use crate::scalar::lit;
use crate::{Deflection, Scalar};

/// The four coefficients of a model at one velocity, or their derivatives with respect to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Affine<T: Scalar, D: Deflection<T> = T> {
    /// Relaxation rate λ [1/s]; a matrix for a bristle with internal states.
    #[doc(alias = "lambda")]
    pub relaxation: D::Relaxation,
    /// Drive r \[–\].
    pub drive: T,
    /// Stiffness c₀ [1/m].
    #[doc(alias = "c0")]
    pub stiffness: D,
    /// Damping c₂ [s/m].
    #[doc(alias = "c2")]
    pub damping: T,
}

impl<T: Scalar, D: Deflection<T>> Affine<T, D> {
    /// ż = −λ z + r v [m/s].
    #[inline(always)]
    pub fn rate(&self, velocity: T, deflection: D) -> D {
        D::fill(self.drive * velocity) - D::relax(self.relaxation, deflection)
    }

    /// μ_b = c₀ z + c₂ v \[–\].
    #[inline(always)]
    pub fn coefficient(&self, velocity: T, deflection: D) -> T {
        self.stiffness.dot(deflection) + self.damping * velocity
    }

    /// Dissipated power per unit normal force [m/s], μ_b v − Ẇ/p, for the stored energy
    /// W/p = ½ Σ Kᵢ xᵢ².
    #[inline]
    pub fn dissipation(&self, storage_stiffness: D, velocity: T, deflection: D) -> T {
        // Multiplied out, so that c₀ − K r, which vanishes for every FrBD model, can cancel first.
        let weighted = storage_stiffness.scaled_by(deflection);
        weighted.dot(D::relax(self.relaxation, deflection))
            + (self.stiffness - storage_stiffness * self.drive).dot(deflection) * velocity
            + self.damping * velocity * velocity
    }
}

/// What happens over a step during which the velocity is held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hold<T> {
    /// Deflection at the end of the step \[m\].
    pub deflection: T,
    /// Friction coefficient (or force, from a [`Contact`](crate::Contact)) at the end of the step.
    pub end: T,
    /// Friction coefficient (or force) averaged over the step: v times its integral is the work.
    pub mean: T,
}

impl<T: Scalar> Affine<T> {
    /// The exact step of length h ≥ 0 \[s\] at a held velocity, with these coefficients frozen.
    #[inline]
    pub fn hold(&self, velocity: T, deflection: T, duration: T) -> Hold<T> {
        let x = self.relaxation * duration;
        let (decay, phi1, phi2) = relaxed(x);
        let (end, mean) = if x < T::one() {
            let driven = self.drive * velocity * duration;
            (decay * deflection + phi1 * driven, phi1 * deflection + phi2 * driven)
        } else {
            // The same by way of the stationary deflection, which no length of step overflows.
            let stationary = self.drive * velocity / self.relaxation;
            let towards = |weight: T| weight * deflection + (T::one() - weight) * stationary;
            (towards(decay), towards(phi1))
        };
        Hold {
            deflection: end,
            end: self.coefficient(velocity, end),
            mean: self.coefficient(velocity, mean),
        }
    }
}

/// e⁻ˣ, φ1(x) = (1 − e⁻ˣ)/x and φ2(x) = (1 − φ1(x))/x without loss of digits.
#[inline]
fn relaxed<T: Scalar>(x: T) -> (T, T, T) {
    if x < lit(0.5) && x > lit(-0.5) {
        // φ2 = Σ (−x)ᵏ/(k + 2)!, cut below 2e-17; the others follow from it without cancellation.
        // Even and odd powers apart, so that the two sums do not wait for each other.
        const EVEN: [f64; 7] = [
            1.0 / 2.0,
            1.0 / 24.0,
            1.0 / 720.0,
            1.0 / 40_320.0,
            1.0 / 3_628_800.0,
            1.0 / 479_001_600.0,
            1.0 / 87_178_291_200.0,
        ];
        const ODD: [f64; 6] = [
            1.0 / 6.0,
            1.0 / 120.0,
            1.0 / 5040.0,
            1.0 / 362_880.0,
            1.0 / 39_916_800.0,
            1.0 / 6_227_020_800.0,
        ];
        let w = x * x;
        let even = EVEN.iter().rev().fold(T::zero(), |sum, &c| lit::<T>(c) + w * sum);
        let odd = ODD.iter().rev().fold(T::zero(), |sum, &c| lit::<T>(c) + w * sum);
        let phi2 = even - x * odd;
        let phi1 = T::one() - x * phi2;
        (T::one() - x * phi1, phi1, phi2)
    } else {
        let decay = (-x).exp();
        let phi1 = (T::one() - decay) / x;
        (decay, phi1, (T::one() - phi1) / x)
    }
}

#[cfg(test)]
mod tests {
    use super::relaxed;
    use approx::assert_relative_eq;

    #[test]
    fn the_series_and_the_closed_form_agree_where_they_meet() {
        // Just above the switch at ½ the closed form loses less than two digits; below it the series
        // loses none.
        let closed = |x: f64| {
            let phi1 = -(-x).exp_m1() / x;
            ((-x).exp(), phi1, (1.0 - phi1) / x)
        };
        for x in [0.3, 0.4, 0.499_999_999, 0.5, 0.7, 3.0, 50.0, 1e6, -0.4] {
            let (got, want) = (relaxed(x), closed(x));
            for (got, want) in [(got.0, want.0), (got.1, want.1), (got.2, want.2)] {
                assert_relative_eq!(got, want, max_relative = 2e-15);
            }
        }
        assert_eq!(relaxed(0.0), (1.0, 1.0, 0.5));
    }
}
