//! Candidates: models with parameters to be found. Two are ready: FrBD with a Stribeck curve, and
//! such a bristle that yields.

use core::fmt::Debug;
use core::num::NonZero;

use super::InitialGuess;
use super::residuals::Parameter;
use super::static_curve::{EXPONENT, stribeck, stribeck_parameters};
use bristle::curve::Stribeck;
use bristle::parameter::Checked;
use bristle::regularisation::Unregularised;
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{Bristle, ElastoPlastic, FrBd, Scalar};

/// A friction model with N parameters to be found. Implement it for a model of your own:
///
/// ```
/// use bristle_identify::{Candidate, InitialGuess, Parameter};
/// use bristle::{Dahl, DahlParameters, ParameterError, Scalar};
///
/// /// Dahl's model.
/// #[derive(Debug)]
/// struct DahlFit;
///
/// impl Candidate<2> for DahlFit {
///     type Model<T: Scalar> = Dahl<T>;
///
///     fn parameters(&self, guess: &InitialGuess) -> [Parameter; 2] {
///         [
///             Parameter::positive("dynamic_coefficient", "", guess.dynamic_coefficient, 10.0),
///             Parameter::positive("micro_stiffness", "1/m", guess.micro_stiffness, 100.0),
///         ]
///     }
///
///     fn model<T: Scalar>(
///         &self,
///         &[dynamic_coefficient, micro_stiffness]: &[T; 2],
///     ) -> Result<Dahl<T>, ParameterError> {
///         Dahl::new(DahlParameters { dynamic_coefficient, micro_stiffness })
///     }
/// }
/// ```
pub trait Candidate<const N: usize>: Debug {
    /// The model, in any scalar.
    type Model<T: Scalar>: Bristle<T>;

    /// The parameters, with starts and bounds around an initial guess.
    fn parameters(&self, guess: &InitialGuess) -> [Parameter; N];

    /// The model with these parameters.
    ///
    /// # Errors
    ///
    /// Parameters out of their ranges.
    fn model<T: Scalar>(&self, values: &[T; N]) -> Checked<Self::Model<T>>;

    /// Exact steps per row of a log: more than one for a model that freezes a coefficient over a
    /// step, where rows lie far apart.
    fn substeps(&self) -> NonZero<u32> {
        NonZero::<u32>::MIN
    }

    /// Offset of the force sensor over the normal force \[–\], added to the friction coefficient:
    /// zero, or one of the parameters.
    fn offset<T: Scalar>(&self, _values: &[T; N]) -> T {
        T::zero()
    }
}

/// [`FrBd`] with a [`Stribeck`] curve (δ = 2) and a [`KelvinVoigt`] bristle.
///
/// Six parameters: μ_d, μ_s − μ_d, v_S, σ2, σ0, σ1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FrBdFit;

impl Candidate<6> for FrBdFit {
    type Model<T: Scalar> = FrBd<Stribeck<T>, KelvinVoigt<T>>;

    fn parameters(&self, guess: &InitialGuess) -> [Parameter; 6] {
        let [dynamic, excess, velocity, viscous] = stribeck_parameters(guess);
        let stiffness = Parameter::positive("micro_stiffness", "1/m", guess.micro_stiffness, 100.0);
        let start = guess.micro_damping;
        let damping = Parameter::scaled("micro_damping", "s/m", start, 0.0..=1e3 * start, start);
        [dynamic, excess, velocity, viscous, stiffness, damping]
    }

    fn model<T: Scalar>(
        &self,
        &[dynamic, excess, velocity, viscous, micro_stiffness, micro_damping]: &[T; 6],
    ) -> Checked<Self::Model<T>> {
        let bristle = KelvinVoigt::new(KelvinVoigtParameters { micro_stiffness, micro_damping })?;
        let curve = stribeck(&[dynamic, excess, velocity, viscous], EXPONENT)?;
        Ok(FrBd::new(curve, bristle))
    }
}

/// [`ElastoPlastic`] FrBD, whose bristle is elastic up to a stick limit z_b, and an offset of the
/// force sensor: for loops with straight flanks and a sharp knee.
///
/// Eight parameters: those of [`FrBdFit`], then the stick share z_b σ0/μ_d, below one, and the
/// offset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ElastoPlasticFit {
    /// Exact steps per row, because a step freezes the elastic share of the sliding. More than one
    /// where the velocity changes much from row to row.
    pub substeps: NonZero<u32>,
}

impl Default for ElastoPlasticFit {
    /// One step per row.
    fn default() -> Self {
        Self { substeps: NonZero::<u32>::MIN }
    }
}

impl Candidate<8> for ElastoPlasticFit {
    type Model<T: Scalar> = ElastoPlastic<Stribeck<T>, KelvinVoigt<T>, Unregularised, T>;

    fn parameters(&self, guess: &InitialGuess) -> [Parameter; 8] {
        let [a, b, c, d, e, f] = FrBdFit.parameters(guess);
        // At a share of one the knee would be a corner.
        let share = Parameter::scaled("stick_share", "", 0.5, 1e-3..=0.99, 0.5);
        // Of any size: the middle between both directions, and twice the friction about it.
        let (start, size) = (guess.offset, 2.0 * guess.dynamic_coefficient);
        let bounds = start - size..=start + size;
        let offset = Parameter::scaled("offset", "", start, bounds, 0.05 * size);
        [a, b, c, d, e, f, share, offset]
    }

    fn model<T: Scalar>(&self, values: &[T; 8]) -> Checked<Self::Model<T>> {
        let &[dynamic, excess, velocity, viscous, stiffness, damping, share, _] = values;
        let frbd = FrBdFit.model(&[dynamic, excess, velocity, viscous, stiffness, damping])?;
        ElastoPlastic::new(*frbd.curve(), *frbd.rheology(), share * dynamic / stiffness)
    }

    fn substeps(&self) -> NonZero<u32> {
        self.substeps
    }

    fn offset<T: Scalar>(&self, &[.., offset]: &[T; 8]) -> T {
        offset
    }
}
