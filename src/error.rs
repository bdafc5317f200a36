//! One error into which the others convert.

use crate::number::{Number, decimal};
use crate::ode::{Failure, StopReason};
use crate::parameter::ParameterError;
use crate::scalar::Scalar;

/// Any error of this crate: each of them converts into it by `?`. For a function that both builds
/// models and integrates; one that only builds returns a [`ParameterError`].
///
/// ```
/// use bristle::ode::{self, Output};
/// use bristle::scene::MassSpringDamper;
/// use bristle::{Bristle, Dahl, DahlParameters, paper};
///
/// fn position(load: f64) -> Result<f64, bristle::Error> {
///     let parameters = DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: 5e3 };
///     let friction = Dahl::new(parameters)?;
///     let rig = MassSpringDamper::new(paper::stick_slip_rig(friction.under_load(load)?))?;
///     let run = ode::solve(&rig, 0.0..1.0, rig.at_rest(), 1e-6, Output::Steps)?;
///     Ok(run.states().last().map_or(0.0, |state| state[0]))
/// }
/// assert!(position(1.0).is_ok());
/// let refused = position(-1.0).unwrap_err();
/// assert!(refused.to_string().starts_with("normal_force is -1, but must"));
/// ```
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A parameter was refused, before anything ran.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// An integration ended before its time. Its state and its trajectory so far are in the
    /// [`Failure`] that it returned, and are dropped here.
    #[error("integration stopped at t = {} s: {reason}", Number(*time))]
    Integration {
        /// The last time reached \[s\].
        time: f64,
        /// Why it stopped.
        #[source]
        reason: StopReason,
    },
}

impl<T: Scalar, const N: usize> From<Failure<T, N>> for Error {
    fn from(failure: Failure<T, N>) -> Self {
        match failure.reason {
            StopReason::Refused(refused) => Self::Parameter(refused),
            reason => Self::Integration { time: decimal(failure.time), reason },
        }
    }
}

#[cfg(feature = "alloc")]
impl<T: Scalar, const N: usize> From<alloc::boxed::Box<Failure<T, N>>> for Error {
    fn from(failure: alloc::boxed::Box<Failure<T, N>>) -> Self {
        (*failure).into()
    }
}
