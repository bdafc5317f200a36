//! A spring and a dashpot in series.

use super::{ElementBounds, Elements};
use crate::parameter::{Checked, Named};
use crate::rheology::Rheology;
use crate::{Bounds, Scalar, Sliding};

/// Parameters of [`Maxwell`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct MaxwellParameters<T> {
    /// Normalised stiffness K [1/m] of the spring, positive.
    pub micro_stiffness: T,
    /// Normalised damping η [s/m] of the dashpot in series, positive.
    #[doc(alias = "eta")]
    pub series_damping: T,
}

/// A spring and a dashpot in series: a bristle that creeps. Take it if the body yields without end
/// under a steady force; if it yields and then stays, take
/// [Zener](super::GeneralisedMaxwell::zener).
///
/// ẋ = ż − (K/η) x,  F/p = K x = η (ż − ẋ)
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | x | stretch of the spring, the state | m |
/// | z | deflection of the bristle: spring and dashpot together | m |
/// | F, p | force of the bristle, normal force | N |
/// | K | normalised stiffness | 1/m |
/// | η | normalised damping of the dashpot in series | s/m |
///
/// In steady sliding the dashpot is a further resistance in series with the surface,
/// F_ss = p v/(|v|_ε/μ + 1/η), below the friction curve: under a steady force F < p μ a body creeps
/// at v = (F/(p η))/(1 − F/(p μ)) [m/s]. The bounds of a single spring hold: from any state within
/// them, |x| ≤ max μ/K and |F| ≤ p max μ.
///
/// Source: derived from the secant law of the models of Romano et al. (arXiv 2602.09429); their
/// authors' own viscoelastic bristles are in arXiv 2601.13799.
///
/// ```
/// use bristle::{Bristle, FrBd, Law, paper};
/// use bristle::curve::Stribeck;
/// use bristle::rheology::{Maxwell, MaxwellParameters};
///
/// let bristle = Maxwell::new(MaxwellParameters { micro_stiffness: 1e4, series_damping: 200.0 })?;
/// let friction = FrBd::new(Stribeck::new(paper::STICK_SLIP_CURVE)?, bristle);
/// // At 1 mm/s the surface alone would carry μ = 1.49503; with the dashpot in series the
/// // coefficient is 1e-3/(1/1495.0 + 1/200).
/// let creeping = friction.stationary_coefficient(1e-3_f64);
/// assert!((creeping - 0.176_402).abs() < 1e-5);
/// assert!(friction.obeys(Law::Passivity) && !friction.obeys(Law::SteadySliding));
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Maxwell<T>(MaxwellParameters<T>);

impl<T: Scalar> Maxwell<T> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range.
    pub fn new(parameters: MaxwellParameters<T>) -> Checked<Self> {
        Named("micro_stiffness", parameters.micro_stiffness).positive()?;
        Named("series_damping", parameters.series_damping).positive()?;
        Ok(Self(parameters))
    }

    /// The parameters, as they were given.
    pub fn parameters(&self) -> MaxwellParameters<T> {
        self.0
    }
}

impl<T: Scalar> Rheology<T> for Maxwell<T> {
    type Deflection = T;

    #[inline(always)]
    fn elements_and_slopes(&self, _: Sliding<T>) -> (Elements<T>, Elements<T>) {
        let MaxwellParameters { micro_stiffness: stiffness, series_damping } = self.0;
        let none = Elements { stiffness: T::zero(), decay: T::zero(), damping: T::zero() };
        (Elements { stiffness, decay: stiffness / series_damping, ..none }, none)
    }

    #[inline(always)]
    fn storage_stiffness(&self) -> T {
        self.0.micro_stiffness
    }

    fn bounds(&self) -> ElementBounds<T> {
        let MaxwellParameters { micro_stiffness, series_damping } = self.0;
        let [stiffness, decay, damping] =
            [micro_stiffness, micro_stiffness / series_damping, T::zero()].map(Bounds::constant);
        ElementBounds { decay, ..ElementBounds::elastic(stiffness, damping) }
    }
}
