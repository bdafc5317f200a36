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

use crate::Scalar;
use crate::rheology::{Deflection, HeldWeights};

/// The four coefficients of a model at one velocity, or their derivatives with respect to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Affine<T: Scalar, D: Deflection<T> = T> {
    /// Relaxation rate λ [1/s]; a matrix for a bristle with internal states.
    #[doc(alias = "lambda")]
    pub relaxation: D::Relaxation,
    /// Drive r \[–\], of each spring.
    pub drive: D,
    /// Stiffness c₀ [1/m].
    #[doc(alias = "c0")]
    pub stiffness: D,
    /// Damping c₂ [s/m].
    #[doc(alias = "c2")]
    pub damping: T,
}

impl<T: Scalar, D: Deflection<T>> Affine<T, D> {
    /// Nothing: no rate and no force.
    pub fn none() -> Self {
        let zero = D::fill(T::zero());
        let relaxation = D::relaxation(zero, zero);
        Self { relaxation, drive: zero, stiffness: zero, damping: T::zero() }
    }

    /// ż = −λ z + r v [m/s].
    #[inline(always)]
    pub fn rate(&self, velocity: T, deflection: D) -> D {
        self.drive * velocity - D::relax(self.relaxation, deflection)
    }

    /// μ_b = c₀ z + c₂ v \[–\].
    #[inline(always)]
    pub fn coefficient(&self, velocity: T, deflection: D) -> T {
        self.stiffness.inner_product(deflection) + self.damping * velocity
    }

    /// Dissipated power per unit normal force [m/s], μ_b v − Ẇ/p, for the stored energy
    /// W/p = ½ Σ Kᵢ xᵢ².
    #[inline]
    pub fn dissipation(&self, storage_stiffness: D, velocity: T, deflection: D) -> T {
        // Multiplied out, so that c₀ − K r, which vanishes for every FrBD model, can cancel first.
        let weighted = storage_stiffness.scaled_by(deflection);
        weighted.inner_product(D::relax(self.relaxation, deflection))
            + (self.stiffness - storage_stiffness.scaled_by(self.drive)).inner_product(deflection)
                * velocity
            + self.damping * velocity * velocity
    }

    /// The exact step of length h ≥ 0 \[s\] at a held velocity, with these coefficients frozen. NaN
    /// for a negative length.
    #[inline]
    pub fn hold(&self, velocity: T, deflection: D, duration: T) -> HeldStep<T, D> {
        let (weights, drive) = (self.weights(forwards(duration)), self.drive * velocity);
        let end = weights.end(deflection, drive);
        let mean = weights.mean(deflection, drive);
        HeldStep {
            deflection: end,
            end_coefficient: self.coefficient(velocity, end),
            mean_coefficient: self.coefficient(velocity, mean),
        }
    }

    /// The weights with which a step of length h ≥ 0 \[s\] makes the deflection at its end, and
    /// its mean, of that at the beginning and of the drive r v, with these coefficients frozen
    /// ([`HeldWeights`](crate::rheology::HeldWeights)): z₁ = e^(−λh) z₀ + h φ1(λh) r v, with
    /// φ1(x) = (1 − e⁻ˣ)/x.
    #[inline]
    pub fn weights(&self, duration: T) -> D::Weights {
        D::weights(self.relaxation, duration)
    }
}

impl<T: Scalar> Affine<T> {
    /// These numbers times a factor. Of derivatives by s, times ds/dv, they are those by v: the
    /// chain rule.
    pub fn times(&self, slope: T) -> Self {
        Self {
            relaxation: self.relaxation * slope,
            drive: self.drive * slope,
            stiffness: self.stiffness * slope,
            damping: self.damping * slope,
        }
    }
}

/// A length of a step; NaN for a negative one: a bristle cannot be run backwards, what it has
/// forgotten would grow.
#[inline(always)]
pub(super) fn forwards<T: Scalar>(duration: T) -> T {
    if duration >= T::zero() { duration } else { T::nan() }
}

/// The result of an exact step at a held velocity, from [`Bristle::hold`](crate::Bristle::hold).
#[must_use]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeldStep<T, D = T> {
    /// Deflection at the end of the step \[m\].
    pub deflection: D,
    /// Friction coefficient at the end of the step \[–\].
    pub end_coefficient: T,
    /// Friction coefficient averaged over the step \[–\].
    pub mean_coefficient: T,
}

#[cfg(test)]
mod tests {
    use super::Affine;
    use crate::rheology::HeldWeights as _;
    use approx::assert_relative_eq;

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
