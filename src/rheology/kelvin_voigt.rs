//! A spring and a dashpot side by side: F/p = σ0 z + σ1 ż. With σ1 = 0 it is a spring alone.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | σ0 | normalised micro-stiffness | 1/m |
//! | σ1 | normalised micro-damping | s/m |
//!
//! Both may depend on the sliding velocity. A varying σ1 ≥ 0 never hurts passivity; a varying σ0
//! can destroy it.
//!
//! Source: Romano et al. (arXiv 2602.09429), section III-A.

use super::{ElementBounds, Elements, VelocityLaw};
use crate::parameter::{Named, ParameterError};
use crate::rheology::Rheology;
use crate::{Scalar, Sliding};

/// Parameters of [`KelvinVoigt`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct KelvinVoigtParameters<K, D> {
    /// Normalised micro-stiffness σ0 [1/m], positive: a number, or a law of the velocity.
    #[doc(alias = "sigma0")]
    pub micro_stiffness: K,
    /// Normalised micro-damping σ1 [s/m], zero or positive: a number, or a law of the velocity.
    #[doc(alias = "sigma1")]
    pub micro_damping: D,
}

/// A spring and a dashpot side by side, F/p = σ0 z + σ1 ż; with σ1 = 0 a spring alone.
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
pub struct KelvinVoigt<T, K = T, D = T> {
    stiffness: K,
    damping: D,
    /// The stiffness at rest, that of the stored energy.
    storage: T,
}

impl<T: Scalar, K: VelocityLaw<T>, D: VelocityLaw<T>> KelvinVoigt<T, K, D> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range.
    pub fn new(parameters: KelvinVoigtParameters<K, D>) -> Result<Self, ParameterError> {
        let KelvinVoigtParameters { micro_stiffness, micro_damping } = parameters;
        micro_stiffness.bounds().positive("micro_stiffness")?;
        micro_damping.bounds().non_negative("micro_damping")?;
        let at_rest = micro_stiffness.value(Sliding::from(T::zero()));
        let storage = Named("micro_stiffness", at_rest).positive()?;
        Ok(Self { stiffness: micro_stiffness, damping: micro_damping, storage })
    }

    /// The parameters, as they were given.
    pub fn parameters(&self) -> KelvinVoigtParameters<K, D> {
        let (micro_stiffness, micro_damping) = (self.stiffness.clone(), self.damping.clone());
        KelvinVoigtParameters { micro_stiffness, micro_damping }
    }
}

impl<T: Scalar, K: VelocityLaw<T>, D: VelocityLaw<T>> Rheology<T> for KelvinVoigt<T, K, D> {
    type Deflection = T;

    #[inline(always)]
    fn elements_and_slopes(&self, sliding: Sliding<T>) -> (Elements<T>, Elements<T>) {
        let (stiffness, stiffness_slope) = self.stiffness.value_and_slope(sliding);
        let (damping, damping_slope) = self.damping.value_and_slope(sliding);
        (
            Elements { stiffness, decay: T::zero(), damping },
            Elements { stiffness: stiffness_slope, decay: T::zero(), damping: damping_slope },
        )
    }

    #[inline(always)]
    fn storage_stiffness(&self) -> T {
        self.storage
    }

    fn bounds(&self) -> ElementBounds<T> {
        let even = self.stiffness.is_even() && self.damping.is_even();
        ElementBounds::elastic(self.stiffness.bounds(), self.damping.bounds(), even)
    }
}
