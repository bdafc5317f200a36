//! The coefficients of a model at one velocity, and their exact step.

use crate::Scalar;
use crate::rheology::{Deflection, HeldWeights};

/// The four coefficients of a model at one velocity, or their derivatives with respect to it.
///
/// With the deflection z \[m\] and the velocity v [m/s] every model of this crate is
///
/// ż   = −λ z + r v
///
/// μ_b =  c₀ z + c₂ v
///
/// | model | relaxation rate λ [1/s] | drive r \[–\] | stiffness c₀ [1/m] | damping c₂ [s/m] |
/// |---|---|---|---|---|
/// | FrBD, g = σ1\|v\|_ε + μ | σ0\|v\|_ε/g | μ/g | σ0 r | σ1 r |
/// | elasto-plastic, g = ασ1\|v\|_ε + μ | ασ0\|v\|_ε/g | μ/g | σ0 r | σ1 r |
/// | LuGre, g its curve | σ0\|v\|_ε/g | 1 | σ0 − σ1 λ | σ1 + σ2 |
/// | Dahl | σ0\|v\|/μ_d | 1 | σ0 | 0 |
/// | implicit, with k = \|v_s\|/μ(v_s) | σ0 k r | 1/(1 + σ1 k) | σ0 r | σ1 r |
///
/// The coefficients depend on v alone, but for the plasticity α(z, v) and the velocity v_s of the
/// implicit bristle's tip, which depend on z, too. There λ z is no more than the relaxing part of
/// ż: a disturbance decays at −∂ż/∂z.
///
/// The table is for a spring beside a dashpot; several springs have a vector r and c₀ and a matrix
/// λ, and one that creeps has λ = K|v|_ε/μ + K/η ([`Maxwell`](crate::rheology::Maxwell)). Under a
/// friction scale s read s μ for μ; in LuGre s g, s σ1 and s σ2. The symbols are those of the
/// models.
///
/// The coefficients give the step of length h \[s\] at a held velocity, exact for every h ≥ 0: with
/// x = λh, φ1(x) = (1 − e⁻ˣ)/x and φ2(x) = (1 − φ1(x))/x,
///
/// z(h) = e⁻ˣ z + φ1 h r v,  mean of z over the step = φ1 z + φ2 h r v.
///
/// Who calls [`Contact::hold`](crate::Contact::hold), `response` or `companion` does not need them.
/// Take them (from [`Contact::affine`](crate::Contact::affine)) for an observer or a solver of your
/// own that wants rate and force as linear functions of z, and write them for a model of your own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Affine<T: Scalar, D: Deflection<T> = T> {
    /// Relaxation rate λ [1/s]; a matrix for a bristle of several springs.
    #[doc(alias = "lambda")]
    pub relaxation: D::Relaxation,
    /// Drive r \[–\], one number for each spring.
    pub drive: D,
    /// Stiffness c₀ [1/m].
    #[doc(alias = "c0")]
    pub stiffness: D,
    /// Damping c₂ [s/m].
    #[doc(alias = "c2")]
    pub damping: T,
}

impl<T: Scalar, D: Deflection<T>> Affine<T, D> {
    /// All four zero, so no rate and no force: the coefficients of a contact without a load.
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

    /// Dissipated power per reference load [m/s], μ_b v − d/dt ½ Σ Kᵢ xᵢ², with the storage
    /// stiffness Kᵢ [1/m] and the stretches xᵢ \[m\] (for a single spring σ0 and z).
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

    /// The step of length h ≥ 0 \[s\] as a linear map, that is e⁻ˣ, φ1 h and φ2 h
    /// ([`HeldWeights`](crate::rheology::HeldWeights)). [`Affine::hold`] is enough for one
    /// deflection at a known velocity. Take the weights if v is still unknown (the step is linear
    /// in it), if several deflections share them, or for the energy dissipated in the step.
    #[inline]
    pub fn weights(&self, duration: T) -> D::Weights {
        D::weights(self.relaxation, duration)
    }
}

impl<T: Scalar> Affine<T> {
    /// These numbers times a factor: the chain rule. If they are derivatives with respect to some
    /// y(v), then `times(dy/dv)` gives the derivatives with respect to v.
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

/// The result of a step at a held velocity, from [`Bristle::hold`](crate::Bristle::hold), per
/// reference load. [`HeldContact`](crate::HeldContact) has the force in newtons, F = P μ_b.
#[must_use]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeldStep<T, D = T> {
    /// Deflection z(h) at the end of the step \[m\]; of several springs, their stretches xᵢ.
    pub deflection: D,
    /// Virtual friction coefficient μ_b at the end of the step \[–\].
    pub end_coefficient: T,
    /// μ_b averaged over the step \[–\]: it gives the impulse and the work.
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
