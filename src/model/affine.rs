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
        let (weights, drive) = (self.weights(duration), self.drive * velocity);
        let end = weights.end(deflection, drive);
        let mean = weights.mean(deflection, drive);
        Hold {
            deflection: end,
            end: self.coefficient(velocity, end),
            mean: self.coefficient(velocity, mean),
        }
    }

    /// What a step of length h ≥ 0 \[s\] makes of a deflection, with these coefficients frozen.
    #[inline]
    pub(crate) fn weights(&self, duration: T) -> Weights<T> {
        let exponent = self.relaxation * duration;
        let (decay, phi1, phi2) = relaxed(exponent);
        let (end_by_drive, mean_by_drive) = if exponent < T::one() {
            (phi1 * duration, phi2 * duration)
        } else {
            // The same by way of the stationary deflection, which no length of step overflows.
            let inverse = T::one() / self.relaxation;
            ((T::one() - decay) * inverse, (T::one() - phi1) * inverse)
        };
        Weights { exponent, decay, end_by_drive, phi1, mean_by_drive }
    }
}

/// A step of ż = −λz + u with λ and u = r v held: both its end and its mean are linear in the deflection
/// z at its start and in u.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Weights<T> {
    /// x = λh
    exponent: T,
    /// e⁻ˣ
    decay: T,
    /// φ1 h \[s\]
    end_by_drive: T,
    /// φ1
    phi1: T,
    /// φ2 h \[s\]
    mean_by_drive: T,
}

impl<T: Scalar> Weights<T> {
    /// Deflection at the end of the step.
    #[inline(always)]
    pub(crate) fn end(&self, deflection: T, drive: T) -> T {
        self.decay * deflection + self.end_by_drive * drive
    }

    /// Deflection averaged over the step.
    #[inline(always)]
    pub(crate) fn mean(&self, deflection: T, drive: T) -> T {
        self.phi1 * deflection + self.mean_by_drive * drive
    }

    /// λ ∫ z² dt over the step \[m²\], from the deflection's mean and its change Δz: both terms of
    ///
    /// x z̄² + ½ L(x/2) Δz²,  L(y) = coth y − 1/y (Langevin's function)
    ///
    /// are squares, so that no rounding makes it negative.
    #[inline]
    pub(crate) fn relaxed_square(&self, mean: T, change: T) -> T {
        let x = self.exponent;
        let spread = if x < lit(0.5) {
            // Σ B₂ₙ xᵏ/(2n)! with k = 2n − 1 and Bernoulli's numbers, cut below 3e-16 of the first.
            const SERIES: [f64; 7] = [
                1.0 / 12.0,
                -1.0 / 720.0,
                1.0 / 30_240.0,
                -1.0 / 1_209_600.0,
                1.0 / 47_900_160.0,
                -691.0 / 1_307_674_368_000.0,
                1.0 / 74_724_249_600.0,
            ];
            x * SERIES.iter().rev().fold(T::zero(), |sum, &c| lit::<T>(c) + x * x * sum)
        } else {
            let one = T::one();
            (lit::<T>(0.5) * (one + self.decay) - self.phi1) / (one - self.decay)
        };
        x * mean * mean + spread * change * change
    }
}

/// e⁻ˣ, φ1(x) = (1 − e⁻ˣ)/x and φ2(x) = (1 − φ1(x))/x without loss of digits.
#[inline]
pub(crate) fn relaxed<T: Scalar>(x: T) -> (T, T, T) {
    if x < lit(0.5) && x > lit(-0.5) {
        // φ2 = Σ (−x)ᵏ/(k + 2)!, cut below 2e-17; the others follow from it without cancellation.
        // Even and odd powers apart and in pairs, so that the sums do not wait for each other.
        const EVEN: [[f64; 2]; 3] = [
            [1.0 / 2.0, 1.0 / 24.0],
            [1.0 / 720.0, 1.0 / 40_320.0],
            [1.0 / 3_628_800.0, 1.0 / 479_001_600.0],
        ];
        const LAST_EVEN: f64 = 1.0 / 87_178_291_200.0;
        const ODD: [[f64; 2]; 3] = [
            [1.0 / 6.0, 1.0 / 120.0],
            [1.0 / 5040.0, 1.0 / 362_880.0],
            [1.0 / 39_916_800.0, 1.0 / 6_227_020_800.0],
        ];
        let w = x * x;
        let w2 = w * w;
        let w4 = w2 * w2;
        let pair = |pair: [f64; 2]| lit::<T>(pair[0]) + w * lit::<T>(pair[1]);
        let [e0, e1, e2] = EVEN;
        let even = (pair(e0) + w2 * pair(e1)) + w4 * (pair(e2) + w2 * lit::<T>(LAST_EVEN));
        let [o0, o1, o2] = ODD;
        let odd = (pair(o0) + w2 * pair(o1)) + w4 * pair(o2);
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
    use super::{Affine, relaxed};
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

    #[test]
    fn the_relaxed_square_is_the_integral_of_a_decay_and_of_a_rise() {
        // ½ coth(x/2) − 1/x to 17 digits by mpmath.
        const SPREADS: [(f64, f64); 8] = [
            (1e-9, 8.333_333_333_333_333_3e-11),
            (0.1, 8.331_944_775_049_624e-3),
            (0.4375, 3.634_255_496_795_637_8e-2),
            (0.5, 4.149_408_253_679_828_4e-2),
            (0.75, 6.192_180_106_901_018_2e-2),
            (3.0, 2.190_623_631_579_226_2e-1),
            (40.0, 4.75e-1),
            (1e6, 4.999_99e-1),
        ];
        for (x, spread) in SPREADS {
            let step = Affine { relaxation: x, drive: 1.0, stiffness: 1.0, damping: 0.0 };
            // The closed form loses less than two digits above ½.
            let (got, want) = (step.weights(1.0).relaxed_square(0.0, 1.0), spread);
            assert_relative_eq!(got, want, max_relative = 2e-14);
            // Free decay from z = 1: λ∫e^(−2λt) dt = (1 − e^(−2x))/2.
            let weights = step.weights(1.0);
            let (end, mean) = (weights.end(1.0, 0.0), weights.mean(1.0, 0.0));
            let want = -0.5 * (-2.0 * x).exp_m1();
            assert_relative_eq!(
                weights.relaxed_square(mean, end - 1.0),
                want,
                max_relative = 2e-14
            );
        }
        let still = Affine { relaxation: 0.0, drive: 1.0, stiffness: 1.0, damping: 0.0 };
        assert_eq!(still.weights(1.0).relaxed_square(1.0, 1.0), 0.0);
    }
}
