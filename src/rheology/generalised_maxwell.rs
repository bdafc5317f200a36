//! Springs side by side, each alone or behind a dashpot, and one dashpot beside them all.

use core::hint::black_box;

use nalgebra::SVector;

use super::{ElementBounds, Elements};
use crate::parameter::{Checked, Named, ParameterError};
use crate::rheology::Rheology;
use crate::scalar::lit;
use crate::{Bounds, Scalar, Sliding};

/// One arm of a [`GeneralisedMaxwell`] bristle: a spring, alone (a *static* arm) or behind a
/// dashpot. Behind one its force relaxes within the time ηᵢ/Kᵢ \[s\].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct MaxwellArm<T> {
    /// Normalised stiffness Kᵢ [1/m] of the spring, positive.
    pub stiffness: T,
    /// Normalised damping ηᵢ [s/m] of the dashpot in series, positive; none makes the
    /// arm static.
    #[doc(alias = "eta")]
    pub series_damping: Option<T>,
}

impl<T: Scalar> MaxwellArm<T> {
    /// Checks stiffness and damping under the names they have in a bristle, and the fastest decay
    /// rate K/η of a spring beside others. The modes of the step separate coinciding springs by
    /// 1e-60 of the fastest rate (1e-17 for `f32`), which must remain negligible over any run.
    pub(super) fn check(&self, stiffness: &'static str, damping: &'static str) -> Checked<()> {
        Named(stiffness, self.stiffness).positive()?;
        if let Some(value) = self.series_damping {
            Named(damping, value).positive()?;
        }
        let single = T::default_epsilon() > lit(1e-10);
        let limit: T = lit(if single { 1e10 } else { 1e50 });
        let (name, what) = ("stiffness over series_damping", "the fastest decay of an arm [1/s]");
        Named(name, self.decay()).at_most(what, limit).map(drop)
    }

    /// The decay rate K/η [1/s], zero without a dashpot. A missing one is hidden from the
    /// optimiser, which would divide by the bytes in its place and drop the result: as a subnormal
    /// number they cost 150 cycles.
    #[inline(always)]
    pub(super) fn decay(&self) -> T {
        let dashpot = self.series_damping.as_ref().map(black_box);
        dashpot.map_or(T::zero(), |&damping| self.stiffness / damping)
    }
}

/// Parameters of [`GeneralisedMaxwell`], with its symbols.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
#[cfg_attr(feature = "serde", serde(bound(deserialize = "T: serde::Deserialize<'de>")))]
#[cfg_attr(feature = "serde", serde(bound(serialize = "T: serde::Serialize")))]
pub struct GeneralisedMaxwellParameters<T, const N: usize> {
    /// The arms, one at least. Their order is that of the state.
    #[cfg_attr(feature = "serde", serde(with = "crate::serialisation::array"))]
    pub arms: [MaxwellArm<T>; N],
    /// Normalised damping d [s/m] of the dashpot beside all arms, zero or positive.
    #[doc(alias = "sigma1")]
    pub micro_damping: T,
}

/// Springs side by side, each alone or behind a dashpot, and one dashpot beside them all. Take it
/// for a contact that relaxes at more than one rate, or whose moduli were measured over frequency.
///
/// ẋᵢ = ż − (Kᵢ/ηᵢ) xᵢ,  F/p = Σ Kᵢ xᵢ + d ż
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | xᵢ | stretch of the spring of arm i: the state is their vector | m |
/// | z | deflection of the bristle, common to all arms | m |
/// | F, p | force of the bristle, normal force | N |
/// | Kᵢ | normalised stiffness of the spring of arm i | 1/m |
/// | ηᵢ | normalised damping of the dashpot in series with it; none in a static arm | s/m |
/// | d | normalised damping of the dashpot beside all arms | s/m |
///
/// Every passive bristle of linear springs and dashpots is equivalent to one of these. A spring k₁
/// in a row with a spring k₂ beside a dashpot η is [`GeneralisedMaxwell::zener`] with K₀ = s k₂,
/// K₁ = s k₁ and the dashpot s² η, s = k₁/(k₁ + k₂).
///
/// With a static arm it slides on the friction curve, F_ss = p μ sgn_ε; without one it creeps,
/// F_ss = p v/(|v|_ε/μ + 1/(Σηᵢ + d)). In any run from rest (all xᵢ = 0) the force stays within the
/// curve, |F| ≤ p max μ over the velocities met. From a *prepared* state it can exceed it: of two
/// springs stretched against each other, the one behind a dashpot relaxes.
///
/// # Arms from measured moduli
///
/// A table of storage and loss moduli G'(ωₖ), G''(ωₖ) [1/m] over angular frequencies ωₖ [rad/s]
/// gives the arms without iteration: choose relaxation times τᵢ = ηᵢ/Kᵢ \[s\], one or two a decade
/// over 1/ωₖ. With these, both moduli
///
/// G'(ω) = K₀ + Σ Kᵢ (ωτᵢ)²/(1 + (ωτᵢ)²),  G''(ω) = Σ Kᵢ ωτᵢ/(1 + (ωτᵢ)²) + d ω
///
/// are linear in K₀, Kᵢ and d. Solve by least squares, each row divided by the measured modulus.
/// Leave out an arm whose Kᵢ comes out negative and solve again; then ηᵢ = Kᵢτᵢ. Relaxation times
/// within a factor of three of each other cannot be told apart by noisy data.
///
/// Source: derived from the secant law of the models of Romano et al. (arXiv 2602.09429); their
/// authors' own viscoelastic bristles are in arXiv 2601.13799.
///
/// ```
/// use bristle::rheology::{GeneralisedMaxwell, GeneralisedMaxwellParameters, MaxwellArm, Rheology};
///
/// // A static spring and two that relax within 1 ms and 1 s.
/// let bristle = GeneralisedMaxwell::new(GeneralisedMaxwellParameters {
///     arms: [
///         MaxwellArm { stiffness: 1e4, series_damping: None },
///         MaxwellArm { stiffness: 2e4, series_damping: Some(20.0) },
///         MaxwellArm { stiffness: 5e3, series_damping: Some(5e3) },
///     ],
///     micro_damping: 1.0,
/// })?;
/// // Soft where it has time, stiff where it has not.
/// assert!((bristle.complex_modulus(1e-3_f64).re - 1e4).abs() < 1.0);
/// assert!((bristle.complex_modulus(1e6_f64).re - 3.5e4).abs() < 1.0);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GeneralisedMaxwell<T, const N: usize>(pub(super) GeneralisedMaxwellParameters<T, N>);

impl<T: Scalar, const N: usize> GeneralisedMaxwell<T, N> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range, and the arm. Refuses a bristle without arms,
    /// and an arm with a decay rate Kᵢ/ηᵢ above 10⁵⁰ 1/s (for `f32` 10¹⁰ 1/s), which no step can
    /// tell from an instant: leave it out.
    pub fn new(parameters: GeneralisedMaxwellParameters<T, N>) -> Checked<Self> {
        let GeneralisedMaxwellParameters { arms, micro_damping } = parameters;
        Named("arms", N).count(1)?;
        let [stiffness, damping] = ["arms.stiffness", "arms.series_damping"];
        ParameterError::of_components(&arms, |arm| arm.check(stiffness, damping))?;
        let micro_damping = Named("micro_damping", micro_damping).non_negative()?;
        Ok(Self(GeneralisedMaxwellParameters { arms, micro_damping }))
    }

    /// The arms, in the order of the state.
    pub fn arms(&self) -> &[MaxwellArm<T>; N] {
        &self.0.arms
    }

    /// The parameters, as they were given.
    pub fn parameters(&self) -> GeneralisedMaxwellParameters<T, N> {
        self.0
    }
}

impl<T: Scalar, const N: usize> Rheology<T> for GeneralisedMaxwell<T, N> {
    type Deflection = SVector<T, N>;

    #[inline(always)]
    fn elements_and_slopes(
        &self,
        _: Sliding<T>,
    ) -> (Elements<T, SVector<T, N>>, Elements<T, SVector<T, N>>) {
        let decay = SVector::from_fn(|i, _| self.0.arms[i].decay());
        let none =
            Elements { stiffness: SVector::zeros(), decay: SVector::zeros(), damping: T::zero() };
        (
            Elements { stiffness: self.storage_stiffness(), decay, damping: self.0.micro_damping },
            none,
        )
    }

    #[inline]
    fn storage_stiffness(&self) -> SVector<T, N> {
        SVector::from_fn(|i, _| self.0.arms[i].stiffness)
    }

    fn bounds(&self) -> ElementBounds<T> {
        let decay = self.0.arms.iter().map(|arm| Bounds::constant(arm.decay()));
        let decay = decay.reduce(Bounds::union).unwrap_or(Bounds::constant(T::zero()));
        let [stiffness, damping] =
            [self.storage_stiffness().sum(), self.0.micro_damping].map(Bounds::constant);
        ElementBounds { decay, ..ElementBounds::elastic(stiffness, damping) }
    }
}
