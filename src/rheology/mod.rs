//! Rheology: what a bristle is made of.

mod deflection;
mod kelvin_voigt;
mod modes;
mod spring;
mod velocity_law;
mod weights;

use core::fmt::Debug;

pub use deflection::{Decaying, Deflection};
pub use kelvin_voigt::{KelvinVoigt, KelvinVoigtParameters};
pub use modes::Modes;
pub use spring::{Spring, SpringParameters};
pub use velocity_law::{Varying, VelocityLaw};
pub use weights::Weights;

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
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a bristle",
    note = "parameters become a bristle by `KelvinVoigt::new(parameters)?` or `Spring::new(parameters)?`"
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

    /// The constant stiffness [1/m] of each spring in the stored energy W = ½ p Σ Kᵢ xᵢ².
    fn storage_stiffness(&self) -> Self::Deflection;

    /// Range of the static stiffness σ0 [1/m] over all velocities.
    fn stiffness_bounds(&self) -> Bounds<T>;

    /// Range of the damping d [s/m] of the dashpot beside the springs over all velocities.
    fn damping_bounds(&self) -> Bounds<T>;

    /// Whether every element takes the same value at v and at −v.
    fn is_even(&self) -> bool;

    /// Whether the bristle is one spring with no dashpot in series: the theorems on deflection,
    /// force and relaxation rate speak of such a one. A spring behind a dashpot can relax to a
    /// force above the friction curve's, from a prepared state.
    fn is_single_spring(&self) -> bool {
        false
    }
}
