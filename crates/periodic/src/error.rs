//! Why there is no answer.

use bristle::ParameterError;
use bristle::number::Number;
use bristle::ode::{Failure, StopReason};

/// Why a periodic motion was not found.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PeriodicError {
    /// A parameter was refused.
    #[error(transparent)]
    Refused(#[from] ParameterError),
    /// A run over a period ended before its time.
    #[error("the run over a period stopped at t = {} s: {reason}", Number(*time))]
    Run {
        /// Time reached \[s\].
        time: f64,
        /// Why.
        reason: StopReason,
    },
    /// The limit on the steps of all runs of a search is used up.
    #[error("the runs need more steps than Shooting::most_steps allows")]
    TooManySteps,
    /// The cycle whose border was asked for is not stable.
    #[error("the cycle near the guess is not stable")]
    Unstable,
    /// The system gives no derivatives, which the multipliers are made of.
    #[error("the system gives no derivatives: write its `linearised`")]
    NoDerivatives,
    /// Newton's method did not converge: there is no periodic motion near the guess.
    #[error(
        "no periodic motion near the guess: after {iterations} iterations the next correction is \
         {} of the scales",
        Number(*correction)
    )]
    NotConverged {
        /// Iterations taken.
        iterations: usize,
        /// The last correction, over the scales of the states and the period.
        correction: f64,
    },
    /// The motion has shrunk to a point: an equilibrium, not a cycle.
    #[error("the motion has shrunk to an equilibrium: there is no cycle near the guess")]
    Equilibrium,
    /// A simulation did not come back near where it was.
    #[error(
        "the motion does not repeat within the run: it comes to rest, it grows, or the run is too \
         short"
    )]
    DoesNotRepeat,
    /// The motion of a loop grows.
    #[error("the motion grows beyond all bounds")]
    Grows,
}

impl<const N: usize> From<Failure<f64, N>> for PeriodicError {
    fn from(failure: Failure<f64, N>) -> Self {
        match failure.reason {
            StopReason::Refused(refused) => Self::Refused(refused),
            StopReason::TooManySteps { .. } => Self::TooManySteps,
            reason => Self::Run { time: failure.time, reason },
        }
    }
}
