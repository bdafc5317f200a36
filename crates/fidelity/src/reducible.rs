//! Which model of one spring stands below a model.

use super::cost;
use bristle::curve::FrictionCurve;
use bristle::parameter::ParameterError;
use bristle::regularisation::Regularisation;
use bristle::rheology::{Deflection, KelvinVoigt, KelvinVoigtParameters, Rheology};
use bristle::scalar::is_zero;
use bristle::{AnyBristle, Bristle, ElastoPlastic, Form, FrBd, ImplicitBristle, LuGre, Scalar};

/// A model that can be the reference of a [`KnownVelocity`](super::KnownVelocity): FrBD with any
/// bristle, LuGre and elasto-plastic FrBD of one spring, the implicit bristle, or your own model.
pub trait Reducible<T: Scalar>: Bristle<T> {
    /// A model of one spring.
    type Lumped: Bristle<T, Deflection = T>;

    /// The model of one spring below this one, or this model itself if it has one spring.
    ///
    /// Below FrBD with any bristle it is FrBD with the same curve and one spring and one dashpot
    /// side by side, those that answer a small oscillation of the angular frequency ω [rad/s] as
    /// the bristle does: σ0 = G'(ω), σ1 = G''(ω)/ω.
    ///
    /// # Errors
    ///
    /// Refuses a stiffness or a damping that is out of range.
    fn lumped(&self, angular_frequency: T) -> Result<Self::Lumped, ParameterError>;

    /// Whether this model is that one already.
    fn is_lumped(&self) -> bool;

    /// The cost of an exact step and of the force after it, in evaluations of FrBD with one spring.
    fn costs(&self) -> (f64, f64) {
        match (self.form(), Self::Deflection::SPRINGS) {
            (Form::Solved, _) => (cost::IMPLICIT_HOLD, cost::IMPLICIT_FORCE),
            (_, 1) => (cost::HOLD, cost::FORCE),
            _ => (cost::MATRIX_HOLD, cost::FORCE),
        }
    }
}

impl<T: Scalar, C: FrictionCurve<T>, R: Rheology<T>, E: Regularisation<T>> Reducible<T>
    for FrBd<C, R, E>
{
    type Lumped = FrBd<C, KelvinVoigt<T>, E>;

    fn lumped(&self, angular_frequency: T) -> Result<Self::Lumped, ParameterError> {
        let modulus = self.rheology().complex_modulus(angular_frequency);
        let bristle = KelvinVoigt::new(KelvinVoigtParameters {
            micro_stiffness: modulus.re,
            micro_damping: modulus.im / angular_frequency,
        })?;
        Ok(FrBd::new(self.curve().clone(), bristle).regularised(self.regularisation().clone()))
    }

    fn is_lumped(&self) -> bool {
        let bounds = self.rheology().bounds();
        R::Deflection::SPRINGS == 1
            && is_zero(bounds.decay.max)
            && bounds.stiffness.is_constant()
            && bounds.damping.is_constant()
    }
}

/// FrBD on the same spring and dashpot, which is one step of linearisation away.
impl<T: Scalar, C: FrictionCurve<T>> Reducible<T> for ImplicitBristle<C, T> {
    type Lumped = FrBd<C, KelvinVoigt<T>>;

    fn lumped(&self, _: T) -> Result<Self::Lumped, ParameterError> {
        Ok(FrBd::new(self.curve().clone(), *self.rheology()))
    }

    fn is_lumped(&self) -> bool {
        false
    }
}

/// A model of one spring stands below itself, at the cost of FrBD.
macro_rules! of_one_spring {
    ($model:ident) => {
        impl<T: Scalar, C, R, E> Reducible<T> for $model<C, R, E, T>
        where
            Self: Bristle<T, Deflection = T>,
        {
            type Lumped = Self;

            fn lumped(&self, _angular_frequency: T) -> Result<Self, ParameterError> {
                Ok(self.clone())
            }

            fn is_lumped(&self) -> bool {
                true
            }
        }
    };
}
of_one_spring!(LuGre);
of_one_spring!(ElastoPlastic);

/// That of the model it holds.
impl<T: Scalar> Reducible<T> for AnyBristle<T> {
    type Lumped = Self;

    fn lumped(&self, angular_frequency: T) -> Result<Self, ParameterError> {
        Ok(match self {
            Self::FrBd(model) => Self::FrBd(model.lumped(angular_frequency)?),
            Self::Maxwell(model) => Self::FrBd(model.lumped(angular_frequency)?),
            Self::Implicit(model) => model.lumped(angular_frequency)?.into(),
            _ => self.clone(),
        })
    }

    fn is_lumped(&self) -> bool {
        match self {
            Self::FrBd(model) => model.is_lumped(),
            Self::Maxwell(_) | Self::Implicit(_) => false,
            _ => true,
        }
    }
}
