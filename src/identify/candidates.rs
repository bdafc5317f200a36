//! Ready candidates: FrBD with a Stribeck curve and bristles of growing richness.

use super::InitialGuess;
use super::residuals::{Candidate, Parameter, Scaling};
use super::static_curve::{stribeck, stribeck_parameters};
use crate::curve::Stribeck;
use crate::parameter::ParameterError;
use crate::regularisation::Unregularised;
use crate::rheology::{
    GeneralisedMaxwell, GeneralisedMaxwellParameters, KelvinVoigt, KelvinVoigtParameters,
    MaxwellArm,
};
use crate::scalar::lit;
use crate::{ElastoPlastic, ElastoPlasticParameters, FrBd, Scalar};

/// Stribeck exponent of the ready candidates.
const EXPONENT: f64 = 2.0;

fn micro_stiffness(rough: &InitialGuess) -> Parameter {
    Parameter::positive("micro_stiffness", "1/m", rough.micro_stiffness, 100.0)
}

fn micro_damping(rough: &InitialGuess) -> Parameter {
    let typical = rough.micro_damping;
    Parameter {
        name: "micro_damping",
        unit: "s/m",
        start: typical,
        least: 0.0,
        most: 1e3 * typical,
        scaling: Scaling::Linear { typical },
    }
}

fn offset(rough: &InitialGuess) -> Parameter {
    let size = rough.dynamic_coefficient;
    Parameter {
        name: "offset",
        unit: "",
        start: 0.0,
        least: -size,
        most: size,
        scaling: Scaling::Linear { typical: 0.1 * size },
    }
}

fn kelvin_voigt<T: Scalar>(
    micro_stiffness: T,
    micro_damping: T,
) -> Result<KelvinVoigt<T>, ParameterError> {
    KelvinVoigt::new(KelvinVoigtParameters { micro_stiffness, micro_damping })
}

/// [`FrBd`] with a [`Stribeck`] curve (δ = 2) and a [`KelvinVoigt`] bristle: μ_d, μ_s − μ_d, v_S, σ2, σ0, σ1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FrBdFit;

impl Candidate<6> for FrBdFit {
    type Model<T: Scalar> = FrBd<Stribeck<T>, KelvinVoigt<T>>;

    fn parameters(&self, rough: &InitialGuess) -> [Parameter; 6] {
        let [dynamic, excess, velocity, viscous] = stribeck_parameters(rough);
        [dynamic, excess, velocity, viscous, micro_stiffness(rough), micro_damping(rough)]
    }

    fn model<T: Scalar>(
        &self,
        &[dynamic, excess, velocity, viscous, s0, s1]: &[T; 6],
    ) -> Result<Self::Model<T>, ParameterError> {
        Ok(FrBd::new(
            stribeck(&[dynamic, excess, velocity, viscous], lit(EXPONENT))?,
            kelvin_voigt(s0, s1)?,
        ))
    }
}

/// FrBD whose bristle has a second spring that relaxes: a [`GeneralisedMaxwell`] bristle of a spring σ0, an arm of
/// stiffness K₁ and relaxation time τ, and σ1 beside them; and an offset of the force sensor. The nine parameters are
/// those of [`FrBdFit`], then K₁, τ and the offset. With σ1 at its lower bound, zero, it is [`Zener`](crate::rheology::Zener)'s.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MaxwellFit;

impl Candidate<9> for MaxwellFit {
    type Model<T: Scalar> = FrBd<Stribeck<T>, GeneralisedMaxwell<T, 2>>;

    fn parameters(&self, rough: &InitialGuess) -> [Parameter; 9] {
        let [a, b, c, d, e, f] = FrBdFit.parameters(rough);
        // The time in which the breakaway distance is slid: faster it is a spring, slower it is gone.
        let time = rough.dynamic_coefficient / (rough.micro_stiffness * rough.fastest);
        let stiffness =
            Parameter::positive("relaxing_stiffness", "1/m", 0.3 * rough.micro_stiffness, 300.0);
        [
            a,
            b,
            c,
            d,
            e,
            f,
            stiffness,
            Parameter::positive("relaxation_time", "s", time, 1e3),
            offset(rough),
        ]
    }

    fn model<T: Scalar>(&self, values: &[T; 9]) -> Result<Self::Model<T>, ParameterError> {
        let &[dynamic, excess, velocity, viscous, s0, s1, k1, time, _] = values;
        let bristle = GeneralisedMaxwell::new(GeneralisedMaxwellParameters {
            arms: [
                MaxwellArm { stiffness: s0, series_damping: None },
                MaxwellArm { stiffness: k1, series_damping: Some(k1 * time) },
            ],
            micro_damping: s1,
        })?;
        Ok(FrBd::new(stribeck(&[dynamic, excess, velocity, viscous], lit(EXPONENT))?, bristle))
    }

    fn offset<T: Scalar>(&self, &[.., offset]: &[T; 9]) -> T {
        offset
    }
}

/// [`ElastoPlastic`] FrBD: a bristle that is elastic up to a stick limit z_b, for loops with straight flanks and a sharp
/// knee; and an offset of the force sensor. The eight parameters are those of [`FrBdFit`], then the stick share
/// z_b σ0/μ_d, below one, and the offset. Give it [`Simulation::substeps`](super::Simulation) where rows lie far apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ElastoPlasticFit;

impl Candidate<8> for ElastoPlasticFit {
    type Model<T: Scalar> = ElastoPlastic<Stribeck<T>, KelvinVoigt<T>, Unregularised, T>;

    fn parameters(&self, rough: &InitialGuess) -> [Parameter; 8] {
        let [a, b, c, d, e, f] = FrBdFit.parameters(rough);
        let share = Parameter {
            name: "stick_share",
            unit: "",
            start: 0.5,
            least: 1e-3,
            most: 0.99, // at one the knee would be a corner
            scaling: Scaling::Linear { typical: 0.5 },
        };
        [a, b, c, d, e, f, share, offset(rough)]
    }

    fn model<T: Scalar>(&self, values: &[T; 8]) -> Result<Self::Model<T>, ParameterError> {
        let &[dynamic, excess, velocity, viscous, s0, s1, share, _] = values;
        ElastoPlastic::new(ElastoPlasticParameters {
            curve: stribeck(&[dynamic, excess, velocity, viscous], lit(EXPONENT))?,
            rheology: kelvin_voigt(s0, s1)?,
            stick_limit: share * dynamic / s0,
        })
    }

    fn offset<T: Scalar>(&self, &[.., offset]: &[T; 8]) -> T {
        offset
    }
}
