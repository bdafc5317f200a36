//! Errors of a linearisation.

use crate::number::Number;
use crate::parameter::ParameterError;

/// Why there is no linearisation, or none of the kind that was asked for.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LinearisationError {
    /// A parameter is out of its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// At rest, with an exact modulus of the velocity, the two sliding directions differ: there is
    /// neither a derivative nor a single stationary deflection.
    #[error(
        "friction has a kink at v = 0; choose a side with Branch::Forward or Branch::Backward, \
         or regularise"
    )]
    Kink,
    /// The deflection that the model states for steady sliding is no equilibrium, as of a
    /// regularised elasto-plastic model.
    #[error(
        "no equilibrium at v = {} m/s: the deflection there changes at {} m/s",
        Number(*velocity), Number(*rate)
    )]
    NoEquilibrium {
        /// Velocity [m/s].
        velocity: f64,
        /// Rate ż [m/s] of the deflection.
        rate: f64,
    },
    /// No steady velocity in the range balances the force.
    #[error(
        "no speed up to {} m/s balances {} N: steady sliding takes {} to {} N",
        Number(*fastest), Number(*force), Number(*least), Number(*most)
    )]
    NoForceBalance {
        /// Applied force \[N\].
        force: f64,
        /// Largest speed searched [m/s].
        fastest: f64,
        /// Least force of steady sliding in the range \[N\].
        least: f64,
        /// Largest force of steady sliding in the range \[N\].
        most: f64,
    },
    /// The static gain is infinite: a pole lies at zero.
    #[error("the linearisation is singular: it has a pole at zero and no static gain")]
    Singular,
    /// Small motions do not die out.
    #[error(
        "small motions do not die out, they go as exp({} t): there is no steady response \
         (`transfer` has G at any s)",
        Number(*abscissa)
    )]
    Unstable {
        /// Largest real part of the poles [1/s].
        abscissa: f64,
    },
    /// A derivative is infinite or not a number, or the eigenvalues of the matrix cannot be found.
    #[error("the linearisation is not finite")]
    NotFinite,
}
