//! Rheology: what a bristle is made of.

mod deflection;
mod generalised_kelvin_voigt;
mod generalised_maxwell;
mod kelvin_voigt;
mod maxwell;
mod modes;
mod spring;
mod velocity_law;
mod weights;
mod zener;

use core::fmt::Debug;

pub use deflection::{Deflection, DiagonalPlusRankOne, States};
pub use generalised_kelvin_voigt::{
    GeneralisedKelvinVoigt, GeneralisedKelvinVoigtParameters, KelvinVoigtElement,
};
pub use generalised_maxwell::{GeneralisedMaxwell, GeneralisedMaxwellParameters, MaxwellArm};
pub use kelvin_voigt::{KelvinVoigt, KelvinVoigtParameters};
pub use maxwell::{Maxwell, MaxwellParameters};
pub use modes::Modes;
pub use spring::{Spring, SpringParameters};
pub use velocity_law::{VelocityDependent, VelocityLaw};
pub use weights::Weights;
pub(crate) use weights::relaxed;
pub use zener::{Zener, ZenerParameters};

use crate::scalar::is_zero;
use crate::{Bounds, Scalar, Sliding};

/// The elements of a bristle at one sliding velocity, per unit normal force.
///
/// Springs Kᵢ in parallel, each in series with a dashpot that lets its stretch xᵢ decay, and one
/// dashpot d beside them all:
///
/// ẋᵢ = ż − aᵢ xᵢ,  F/p = Σ Kᵢ xᵢ + d ż.
///
/// With aᵢ = 0 a spring has no dashpot in series and xᵢ is the deflection z itself: that is the
/// spring and the Kelvin–Voigt bristle. Springs with aᵢ > 0 make Maxwell, Zener and generalised
/// Maxwell bristles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Elements<T, D = T> {
    /// Spring stiffness Kᵢ [1/m].
    pub stiffness: D,
    /// Decay rate aᵢ of each spring's stretch [1/s]: its stiffness over its series dashpot.
    pub decay: D,
    /// Damping d [s/m] of the dashpot beside the springs.
    pub damping: T,
}

/// What a bristle is made of, as a law between its deflection z, the rate ż and the force.
///
/// The friction model puts it in series with the sliding surface: that is the *secant law*
/// F/p = (μ(v)/|v|_ε)(v − ż) of the FrBD family, under which every passive bristle gives a passive
/// friction model. The springs' stiffness should be constant for that; dashpots may depend on the
/// velocity.
///
/// | bristle | springs | in steady sliding |
/// |---|---|---|
/// | [`Spring`], [`KelvinVoigt`] | one | on the curve |
/// | [`Maxwell`] | one, behind a dashpot | creeps |
/// | [`Zener`] | two, one behind a dashpot | on the curve |
/// | [`GeneralisedMaxwell`] | N side by side, each with or without a dashpot in series | on the curve, or creeps |
/// | [`GeneralisedKelvinVoigt`] | N in a row, each with a dashpot beside it | on the curve |
///
/// # Energy
///
/// With v_s = v − ż the velocity at which the tip slides, and W = ½ p Σ Kᵢ xᵢ²,
///
/// F v − Ẇ = F v_s + p d ż² + p Σ aᵢ Kᵢ xᵢ²,  F v_s = p (|v|_ε/μ)(F/p)²,
///
/// for every state: no term is negative. (From F v − Ẇ = F v_s + F ż − Ẇ.)
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a bristle",
    note = "parameters become a bristle by `KelvinVoigt::new(parameters)?`, `Zener::new(parameters)?` …"
)]
pub trait Rheology<T: Scalar>: Debug + Clone {
    /// The stretches of the springs: the scalar itself for one, a vector for several.
    type Deflection: Deflection<T>;

    /// The elements at a sliding velocity.
    fn elements(&self, sliding: Sliding<T>) -> Elements<T, Self::Deflection>;

    /// The elements and their derivatives with respect to the signed velocity.
    fn elements_and_slopes(
        &self,
        sliding: Sliding<T>,
    ) -> (Elements<T, Self::Deflection>, Elements<T, Self::Deflection>);

    /// The deflection under a steady friction coefficient (signed) while sliding at v.
    fn stationary(&self, sliding: Sliding<T>, coefficient: T) -> Self::Deflection;

    /// Whether the bristle yields for ever under a steady force: every spring has a dashpot in
    /// series. Then steady sliding stays below the friction curve.
    fn creeps(&self) -> bool {
        false
    }

    /// The rate ż [m/s] at which the bristle yields under a steady coefficient of one: for a bristle
    /// that [creeps](Rheology::creeps) the reciprocal of the sum of its dashpots, else zero.
    fn fluidity(&self, sliding: Sliding<T>) -> T {
        let _ = sliding;
        T::zero()
    }

    /// The constant stiffness [1/m] of each spring in the stored energy W = ½ p Σ Kᵢ xᵢ².
    fn storage_stiffness(&self) -> Self::Deflection;

    /// Range of the stiffness Σ Kᵢ [1/m] of all springs together over all velocities; of a single
    /// spring that is σ0.
    fn stiffness_bounds(&self) -> Bounds<T>;

    /// Range of the decay rates aᵢ [1/s] over all springs and velocities. If not given, nothing is
    /// promised.
    fn decay_bounds(&self) -> Bounds<T> {
        Bounds { min: T::zero(), max: T::one() / T::zero() }
    }

    /// Range of the damping d [s/m] of the dashpot beside the springs over all velocities.
    fn damping_bounds(&self) -> Bounds<T>;

    /// Whether every element takes the same value at v and at −v.
    fn is_even(&self) -> bool;

    /// Whether no decay rate depends on the velocity.
    fn has_constant_decay(&self) -> bool {
        false
    }

    /// Whether the bristle has one spring only, with a dashpot in series or without: the theorems on
    /// deflection and force speak of such a one, whatever its state. Of several springs those with a
    /// dashpot can relax to a force above the friction curve's, from a prepared state.
    fn is_single_spring(&self) -> bool {
        false
    }

    /// The complex modulus G\* = G' + iG'' [1/m] at rest, at an angular frequency ω ≥ 0 [rad/s]:
    ///
    /// G\*(iω) = Σ Kᵢ iω/(aᵢ + iω) + iω d,
    ///
    /// with which a stuck bristle answers a small oscillation: z = Re ẑ e^(iωt) has F/p = Re G\* ẑ e^(iωt).
    /// At ω = 0 it is the static stiffness.
    #[doc(alias = "storage modulus")]
    #[doc(alias = "loss modulus")]
    fn complex_modulus(&self, angular_frequency: T) -> ComplexModulus<T> {
        let (one, omega) = (T::one(), angular_frequency);
        let Elements { stiffness, decay, damping } = self.elements(Sliding::from(T::zero()));
        // ω²/(a² + ω²) and aω/(a² + ω²) with squares of numbers up to one only.
        let part = |a: T| {
            if is_zero(a) {
                (one, T::zero())
            } else if omega < a {
                let ratio = omega / a;
                let inverse = one / (one + ratio * ratio);
                (ratio * ratio * inverse, ratio * inverse)
            } else {
                let ratio = a / omega;
                let inverse = one / (one + ratio * ratio);
                (inverse, ratio * inverse)
            }
        };
        ComplexModulus {
            storage: stiffness.dot(decay.each(|a| part(a).0)),
            loss: stiffness.dot(decay.each(|a| part(a).1)) + omega * damping,
        }
    }
}

/// The complex modulus of a bristle at one frequency, see [`Rheology::complex_modulus`].
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ComplexModulus<T> {
    /// Storage modulus G' [1/m]: what is in phase with the deflection.
    pub storage: T,
    /// Loss modulus G'' [1/m]: what is a quarter of a period ahead of it. The work lost per period is
    /// π p G'' ẑ².
    pub loss: T,
}
