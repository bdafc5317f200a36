//! Rheology: the springs and dashpots of a bristle.
//!
//! Every bristle of this crate is a set of springs Kᵢ side by side, each alone or in series with a
//! dashpot of its own, and one dashpot d beside them all. With p \[N\] here and in this module for
//! the load under which they were measured, the reference load P of a [`Contact`](crate::Contact),
//!
//! ẋᵢ = ż − aᵢ xᵢ,  F/p = Σ Kᵢ xᵢ + d ż
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | z | deflection of the bristle | m |
//! | xᵢ | stretch of spring i: the state of the bristle | m |
//! | Kᵢ | normalised stiffness of spring i | 1/m |
//! | aᵢ = Kᵢ/ηᵢ | decay rate of its stretch, with the series dashpot ηᵢ; zero without one | 1/s |
//! | d | normalised damping of the dashpot beside the springs | s/m |
//!
//! A bristle in which every spring has a series dashpot *creeps*: under a steady force it yields
//! without end, at the rate ż = φ F/p with the fluidity φ = 1/(d + Σ Kᵢ/aᵢ).
//!
//! # Types in signatures
//!
//! A bristle's state is a [`Deflection`]: a number, or an `SVector` for several springs. That is
//! all a bristle of your own names ([`Rheology`]). Code that is generic over the state also meets
//! its relaxation matrix ([`DiagonalPlusRankOne`] for several springs), its exact step
//! ([`HeldWeights`]: [`Weights`] for one, [`Modes`] for several), and its place among the states
//! of a system ([`States`]).

mod deflection;
mod generalised_maxwell;
mod kelvin_voigt;
mod maxwell;
mod modes;
mod weights;
mod zener;

use core::fmt::Debug;

pub use deflection::{Deflection, DiagonalPlusRankOne, HeldWeights, States};
pub use generalised_maxwell::{GeneralisedMaxwell, GeneralisedMaxwellParameters, MaxwellArm};
pub use kelvin_voigt::{KelvinVoigt, KelvinVoigtParameters};
pub use maxwell::{Maxwell, MaxwellParameters};
pub use modes::Modes;
pub use weights::Weights;
pub use zener::ZenerParameters;

use nalgebra::Complex;

use crate::scalar::is_zero;
use crate::{Bounds, Scalar, Sliding};

/// The numbers of a bristle at one sliding velocity, per unit normal force: ẋᵢ = ż − aᵢ xᵢ,
/// F/p = Σ Kᵢ xᵢ + d ż. Or their derivatives with respect to the velocity. This is what a
/// [`Rheology`] gives to a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Elements<T, D = T> {
    /// Stiffness Kᵢ of each spring [1/m].
    pub stiffness: D,
    /// Decay rate aᵢ of each spring's stretch [1/s]: its stiffness over its series dashpot, or
    /// zero without one.
    pub decay: D,
    /// Damping d of the dashpot beside the springs [s/m].
    pub damping: T,
}

impl<T: Scalar, D: Deflection<T>> Elements<T, D> {
    /// Whether every spring has a dashpot in series, so that the bristle yields without end.
    #[inline]
    pub fn creeps(&self) -> bool {
        let mut creeps = true;
        let _ = self.decay.each(|a| {
            creeps &= !is_zero(a);
            a
        });
        creeps
    }

    /// The fluidity φ = 1/(d + Σ Kᵢ/aᵢ) [m/s]: the rate ż at which a bristle that creeps yields
    /// under a steady friction coefficient of one. Zero for one that does not creep.
    #[inline]
    pub fn fluidity(&self) -> T {
        if self.creeps() {
            let series = self.decay.each(|a| T::one() / a);
            T::one() / (self.damping + self.stiffness.inner_product(series))
        } else {
            T::zero()
        }
    }

    /// The stretches \[m\] under a steady friction coefficient μ_b \[–\] (signed): μ_b/K for one
    /// spring. Of steady sliding, or to begin a run from a given force.
    #[inline]
    pub fn stationary(&self, coefficient: T) -> D {
        if self.creeps() {
            let rate = coefficient * self.fluidity();
            self.decay.each(|a| rate / a)
        } else {
            // Springs with a dashpot have relaxed; the others share the load at a common stretch.
            let held = self.decay.each(|a| if is_zero(a) { T::one() } else { T::zero() });
            held * (coefficient / self.stiffness.inner_product(held))
        }
    }
}

/// Ranges of the [`Elements`] of a bristle over all velocities, for the theorems on deflection,
/// force and passivity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElementBounds<T> {
    /// Range of the total stiffness Σ Kᵢ [1/m]; for a single spring that is σ0.
    pub stiffness: Bounds<T>,
    /// Range of the decay rates aᵢ over all springs [1/s].
    pub decay: Bounds<T>,
    /// Range of the damping d of the dashpot beside the springs [s/m].
    pub damping: Bounds<T>,
    /// Whether no decay rate depends on the velocity.
    pub constant_decay: bool,
    /// Whether every element takes equal values at v and −v.
    pub even: bool,
}

impl<T: Scalar> ElementBounds<T> {
    /// Of springs without series dashpots.
    pub(crate) fn elastic(stiffness: Bounds<T>, damping: Bounds<T>) -> Self {
        let decay = Bounds::constant(T::zero());
        Self { stiffness, decay, damping, constant_decay: true, even: true }
    }
}

/// The springs and dashpots of a bristle: the law between its deflection z, the rate ż and the
/// force.
///
/// The friction model puts the bristle in series with the sliding surface. That is the *secant law*
/// F/p = (μ(v)/|v|_ε)(v − ż) of the FrBD family, under which every passive bristle gives a passive
/// friction model. For that the stiffness of the springs should be constant; dashpots may depend on
/// the velocity.
///
/// | bristle | springs | steady sliding | take it if |
/// |---|---|---|---|
/// | [`KelvinVoigt`] | one | on the curve | nothing else is known |
/// | [`Maxwell`] | one, behind a dashpot | creeps | a steady force moves a body without end |
/// | [`zener`] | two, one behind a dashpot | on the curve | a held force relaxes to a part |
/// | [`GeneralisedMaxwell`] | N, some behind dashpots | either | moduli are measured |
///
/// [`zener`]: GeneralisedMaxwell::zener
///
/// # Energy
///
/// With v_s = v − ż the velocity at which the tip slides, and W = ½ p Σ Kᵢ xᵢ²,
///
/// F v − Ẇ = F v_s + p d ż² + p Σ aᵢ Kᵢ xᵢ²,  F v_s = p (|v|_ε/μ)(F/p)²,
///
/// for every state: no term is negative. (From F v − Ẇ = F v_s + F ż − Ẇ.)
///
/// # A bristle of your own
///
/// It takes three methods. Claims in [`ElementBounds`] are taken on trust; if a range is not known,
/// give zero to infinity, and `false` for what is not certain: laws that need it are then refused.
/// The paper's σ0(v) and σ1(v) are written so, each with its slope; here σ1(v):
///
/// ```
/// use bristle::rheology::{ElementBounds, Elements, Rheology};
/// use bristle::{Bounds, Sliding};
///
/// /// A spring whose dashpot stiffens with the speed: d = η √(1 + (v/v₀)²).
/// #[derive(Debug, Clone)]
/// struct Stiffening { stiffness: f64, damping: f64, reference_velocity: f64 }
///
/// impl Rheology<f64> for Stiffening {
///     type Deflection = f64;
///
///     fn elements_and_slopes(&self, sliding: Sliding<f64>) -> (Elements<f64>, Elements<f64>) {
///         let u = sliding.velocity() / self.reference_velocity;
///         let root = (1.0 + u * u).sqrt();
///         let slope = self.damping * u / (root * self.reference_velocity);
///         (
///             Elements { stiffness: self.stiffness, decay: 0.0, damping: self.damping * root },
///             Elements { stiffness: 0.0, decay: 0.0, damping: slope },
///         )
///     }
///
///     fn storage_stiffness(&self) -> f64 {
///         self.stiffness
///     }
///
///     fn bounds(&self) -> ElementBounds<f64> {
///         ElementBounds {
///             stiffness: Bounds::constant(self.stiffness),
///             decay: Bounds::constant(0.0),
///             damping: Bounds { min: self.damping, max: f64::INFINITY },
///             constant_decay: true,
///             even: true,
///         }
///     }
/// }
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a bristle",
    note = "build one from parameters, e.g. by `KelvinVoigt::new(parameters)?`"
)]
pub trait Rheology<T: Scalar>: Debug + Clone {
    /// The stretches of the springs: the scalar `T` for one, an `SVector<T, N>` for several.
    type Deflection: Deflection<T>;

    /// The elements at a sliding velocity. Override it where the slopes cost extra.
    #[inline(always)]
    fn elements(&self, sliding: Sliding<T>) -> Elements<T, Self::Deflection> {
        self.elements_and_slopes(sliding).0
    }

    /// The elements and their derivatives with respect to the signed velocity: zero for constant
    /// elements.
    fn elements_and_slopes(
        &self,
        sliding: Sliding<T>,
    ) -> (Elements<T, Self::Deflection>, Elements<T, Self::Deflection>);

    /// The constant stiffness Kᵢ [1/m] of each spring in the stored energy W = ½ p Σ Kᵢ xᵢ². Of a
    /// stiffness that varies, the one that the energy is to be counted with.
    fn storage_stiffness(&self) -> Self::Deflection;

    /// Ranges of the elements over all velocities, on which the limits and laws of a model rest.
    fn bounds(&self) -> ElementBounds<T>;

    /// The complex modulus G\* = G' + iG'' [1/m] at rest, at an angular frequency ω ≥ 0 [rad/s], to
    /// compare a bristle with a measured response:
    ///
    /// G\*(iω) = Σ Kᵢ iω/(aᵢ + iω) + iω d.
    ///
    /// A stuck bristle answers a small oscillation z = Re ẑ e^(iωt) with F/p = Re G\* ẑ e^(iωt).
    /// The real part is the storage modulus G', in phase with the deflection; at ω = 0 it is the
    /// static stiffness. The imaginary part is the loss modulus G'': the work lost per period is
    /// π p G'' ẑ².
    #[doc(alias = "storage modulus")]
    #[doc(alias = "loss modulus")]
    fn complex_modulus(&self, angular_frequency: T) -> Complex<T> {
        let (one, omega) = (T::one(), angular_frequency);
        let Elements { stiffness, decay, damping } = self.elements(Sliding::from(T::zero()));
        // ω²/(a² + ω²) and aω/(a² + ω²), with squares of numbers up to one only.
        let part = |a: T| {
            let (ratio, slow) = if omega < a { (omega / a, true) } else { (a / omega, false) };
            let inverse = one / (one + ratio * ratio);
            match (is_zero(a), slow) {
                (true, _) => (one, T::zero()),
                (_, true) => (ratio * ratio * inverse, ratio * inverse),
                _ => (inverse, ratio * inverse),
            }
        };
        Complex::new(
            stiffness.inner_product(decay.each(|a| part(a).0)),
            stiffness.inner_product(decay.each(|a| part(a).1)) + omega * damping,
        )
    }
}
