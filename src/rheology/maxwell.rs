//! A spring and a dashpot in series: F/p = K x = η(ż − ẋ).
//!
//! ẋ = ż − (K/η) x,  F/p = K x
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | x | stretch of the spring, the state | m |
//! | z | deflection of the bristle: spring and dashpot together | m |
//! | K | normalised stiffness | 1/m |
//! | η | normalised damping of the dashpot in series | s/m |
//!
//! Under a steady force such a bristle creeps. In steady sliding the dashpot is a further
//! resistance in series with the surface,
//!
//! F_ss = p v/(|v|_ε/μ + 1/η),
//!
//! below the friction curve. The bounds of a single spring hold: from any state within them,
//! |x| ≤ max μ/K and |F| ≤ p max μ.
//!
//! F v − Ẇ = F v_s + p (K²/η) x²,  W = ½ p K x².
//!
//! Source: derived from the secant law of the models of Romano et al. (arXiv 2602.09429); their
//! authors' own viscoelastic bristles are in arXiv 2601.13799.

use super::{ElementBounds, Elements, VelocityLaw};
use crate::parameter::{self, ParameterError};
use crate::rheology::Rheology;
use crate::scalar::lit;
use crate::{Bounds, Scalar, Sliding};

/// Parameters of [`Maxwell`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MaxwellParameters<T, S = T> {
    /// Normalised stiffness K [1/m], positive.
    pub micro_stiffness: T,
    /// Normalised damping η [s/m] of the dashpot in series, positive: a number, or a law of the
    /// velocity.
    #[doc(alias = "eta")]
    pub series_damping: S,
}

/// A spring and a dashpot in series: a bristle that creeps.
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
pub struct Maxwell<T, S = T> {
    stiffness: T,
    series_damping: S,
}

impl<T: Scalar, S: VelocityLaw<T>> Maxwell<T, S> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range.
    pub fn new(parameters: MaxwellParameters<T, S>) -> Result<Self, ParameterError> {
        let MaxwellParameters { micro_stiffness, series_damping } = parameters;
        let stiffness = parameter::positive("micro_stiffness", micro_stiffness)?;
        series_damping.bounds().positive("series_damping")?;
        Ok(Self { stiffness, series_damping })
    }
}

/// The decay rate K/η(v) [1/s] of a spring behind a dashpot.
#[inline]
pub(super) fn decay<T: Scalar>(
    stiffness: T,
    dashpot: &impl VelocityLaw<T>,
    sliding: Sliding<T>,
) -> T {
    stiffness / dashpot.value(sliding)
}

/// Checks the fastest decay rate K/η of a spring beside others. The modes of the step separate
/// coinciding springs by 1e-60 of the fastest rate (1e-17 for `f32`), which must remain negligible
/// over any run.
pub(super) fn check_decay<T: Scalar>(decay: T) -> Result<(), ParameterError> {
    let single = T::default_epsilon() > lit(1e-10);
    let limit: T = lit(if single { 1e10 } else { 1e50 });
    let name = "stiffness over series_damping";
    parameter::at_most(name, decay, "the fastest decay of an arm [1/s]", limit).map(drop)
}

/// The decay rate, and its derivative with respect to the signed velocity.
#[inline]
pub(super) fn decay_and_slope<T: Scalar>(
    stiffness: T,
    dashpot: &impl VelocityLaw<T>,
    sliding: Sliding<T>,
) -> (T, T) {
    let (damping, slope) = dashpot.value_and_slope(sliding);
    let decay = stiffness / damping;
    (decay, -decay * slope / damping)
}

/// Range of the decay rate over all velocities.
pub(super) fn decay_bounds<T: Scalar>(stiffness: T, dashpot: &impl VelocityLaw<T>) -> Bounds<T> {
    let bounds = dashpot.bounds();
    Bounds { min: stiffness / bounds.max, max: stiffness / bounds.min }
}

impl<T: Scalar, S: VelocityLaw<T>> Rheology<T> for Maxwell<T, S> {
    type Deflection = T;

    #[inline]
    fn elements(&self, sliding: Sliding<T>) -> Elements<T> {
        Elements {
            stiffness: self.stiffness,
            decay: decay(self.stiffness, &self.series_damping, sliding),
            damping: T::zero(),
        }
    }

    #[inline]
    fn elements_and_slopes(&self, sliding: Sliding<T>) -> (Elements<T>, Elements<T>) {
        let (decay, slope) = decay_and_slope(self.stiffness, &self.series_damping, sliding);
        (
            Elements { stiffness: self.stiffness, decay, damping: T::zero() },
            Elements { stiffness: T::zero(), decay: slope, damping: T::zero() },
        )
    }

    #[inline(always)]
    fn storage_stiffness(&self) -> T {
        self.stiffness
    }

    fn bounds(&self) -> ElementBounds<T> {
        ElementBounds {
            stiffness: Bounds::constant(self.stiffness),
            decay: decay_bounds(self.stiffness, &self.series_damping),
            damping: Bounds::constant(T::zero()),
            constant_decay: self.series_damping.bounds().is_constant(),
            even: self.series_damping.is_even(),
        }
    }
}
