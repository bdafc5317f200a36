//! Which simpler models stand below a model.

use crate::curve::FrictionCurve;
use crate::parameter::ParameterError;
use crate::regularisation::Regularisation;
use crate::rheology::{Deflection, KelvinVoigt, KelvinVoigtParameters, Rheology};
use crate::scalar::is_zero;
use crate::{Bristle, FrBd, ImplicitBristle, Scalar};

/// A model that can stand at the top of the ladder of a [`History`](super::History): it knows the lumped FrBD
/// model below it.
pub trait Reducible<T: Scalar>: Bristle<T> {
    /// A model of one spring.
    type Lumped: Bristle<T, Deflection = T>;

    /// FrBD with the same curve and one spring and one dashpot side by side, those that answer a small oscillation
    /// of the angular frequency ω [rad/s] as this bristle does: σ0 = G'(ω), σ1 = G''(ω)/ω.
    ///
    /// # Errors
    ///
    /// Refuses a stiffness or a damping that is out of range.
    fn lumped(&self, angular_frequency: T) -> Result<Self::Lumped, ParameterError>;

    /// Whether this model is that one already.
    fn is_lumped(&self) -> bool;

    /// Weighted right-hand sides [–] of one step of the reference, and of the force after it.
    fn weights(&self) -> (f64, f64);
}

impl<T, C, R, E> Reducible<T> for FrBd<C, R, E>
where
    T: Scalar,
    C: FrictionCurve<T>,
    R: Rheology<T>,
    E: Regularisation<T>,
{
    type Lumped = FrBd<C, KelvinVoigt<T>, E>;

    fn lumped(&self, angular_frequency: T) -> Result<Self::Lumped, ParameterError> {
        let modulus = self.rheology().complex_modulus(angular_frequency);
        let bristle = KelvinVoigt::new(KelvinVoigtParameters {
            micro_stiffness: modulus.storage,
            micro_damping: modulus.loss / angular_frequency,
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

    fn weights(&self) -> (f64, f64) {
        if R::Deflection::SPRINGS == 1 {
            (super::weight::HOLD, super::weight::FORCE)
        } else {
            (super::weight::MATRIX_HOLD, super::weight::FORCE)
        }
    }
}

/// FrBD on the same spring and dashpot, which is one step of linearisation away.
impl<T, C, E> Reducible<T> for ImplicitBristle<C, E, T>
where
    T: Scalar,
    C: FrictionCurve<T>,
    E: Regularisation<T>,
{
    type Lumped = FrBd<C, KelvinVoigt<T>, E>;

    fn lumped(&self, _: T) -> Result<Self::Lumped, ParameterError> {
        let lumped = FrBd::new(self.curve().clone(), *self.rheology());
        Ok(lumped.regularised(self.regularisation().clone()))
    }

    fn is_lumped(&self) -> bool {
        false
    }

    fn weights(&self) -> (f64, f64) {
        (super::weight::SOLVED_HOLD, super::weight::SOLVED_FORCE)
    }
}
