//! A spring and a dashpot side by side.

use super::{ElementBounds, Elements};
use crate::parameter::{Checked, Named};
use crate::rheology::Rheology;
use crate::{Bounds, Scalar, Sliding};

/// Parameters of [`KelvinVoigt`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct KelvinVoigtParameters<T> {
    /// Normalised micro-stiffness σ0 [1/m], positive: μ_s over the elastic displacement before
    /// breakaway.
    #[doc(alias = "sigma0")]
    pub micro_stiffness: T,
    /// Normalised micro-damping σ1 [s/m], zero or positive. It damps a stuck body, with the damping
    /// ratio ½ σ1 √(P/(σ0 m)) for a mass m under the reference load P, and has no effect in steady
    /// sliding.
    #[doc(alias = "sigma1")]
    pub micro_damping: T,
}

/// A spring and a dashpot side by side: the bristle of the paper and of LuGre. Take it unless the
/// contact creeps or relaxes.
///
/// F/p = σ0 z + σ1 ż
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | z | deflection, the state | m |
/// | F, p | force of the bristle, normal force | N |
/// | σ0, σ1 | normalised micro-stiffness, micro-damping; with σ1 = 0 a spring alone | 1/m, s/m |
///
/// If they shall depend on the velocity, write a [`Rheology`] of your own. A varying σ1 ≥ 0 never
/// hurts passivity; a varying σ0 can destroy it.
///
/// Source: Romano et al. (arXiv 2602.09429), section III-A.
///
/// ```
/// use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
///
/// let bristle = KelvinVoigt::new(KelvinVoigtParameters {
///     micro_stiffness: 1e4,
///     micro_damping: 64.5,
/// })?;
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KelvinVoigt<T>(KelvinVoigtParameters<T>);

impl<T: Scalar> KelvinVoigt<T> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range.
    pub fn new(parameters: KelvinVoigtParameters<T>) -> Checked<Self> {
        Ok(Self(KelvinVoigtParameters {
            micro_stiffness: Named("micro_stiffness", parameters.micro_stiffness).positive()?,
            micro_damping: Named("micro_damping", parameters.micro_damping).non_negative()?,
        }))
    }

    /// The parameters, as they were given.
    pub fn parameters(&self) -> KelvinVoigtParameters<T> {
        self.0
    }
}

impl<T: Scalar> Rheology<T> for KelvinVoigt<T> {
    type Deflection = T;

    #[inline(always)]
    fn elements_and_slopes(&self, _: Sliding<T>) -> (Elements<T>, Elements<T>) {
        let KelvinVoigtParameters { micro_stiffness: stiffness, micro_damping: damping } = self.0;
        let none = Elements { stiffness: T::zero(), decay: T::zero(), damping: T::zero() };
        (Elements { stiffness, damping, ..none }, none)
    }

    #[inline(always)]
    fn storage_stiffness(&self) -> T {
        self.0.micro_stiffness
    }

    fn bounds(&self) -> ElementBounds<T> {
        let KelvinVoigtParameters { micro_stiffness, micro_damping } = self.0;
        ElementBounds::elastic(Bounds::constant(micro_stiffness), Bounds::constant(micro_damping))
    }
}
