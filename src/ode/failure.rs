//! Why a run ended before its time.

use core::fmt;

use super::Statistics;
use super::storage::States;
use crate::number::Number;
use crate::{ParameterError, Scalar};

/// Why an integration stopped.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StopReason {
    /// An argument of the run was refused.
    #[error(transparent)]
    Refused(#[from] ParameterError),
    /// The right-hand side is not finite, however short the step. That of an implicit bristle is
    /// none beyond its [fold](crate::Bristle::folding_scale), that of any contact under a load that
    /// is negative or not a number.
    #[error("component {component} of the right-hand side or of the state is not finite")]
    NotFinite {
        /// The first component that is not.
        component: usize,
    },
    /// A sliding velocity is not finite, however short the step.
    #[error("the sliding velocity of contact {contact} is not finite")]
    VelocityNotFinite {
        /// The first contact for which it is not.
        contact: usize,
    },
    /// The tolerances, or a fixed step, ask for steps that no longer advance the time.
    ///
    /// Where the tolerances are loose, suspect the system: `sliding_velocities` of another sign
    /// than `rate` gives to [`Branch::of`](crate::Branch::of), a right-hand side that jumps, or a
    /// bristle that is deflected under a load of zero: LuGre's and Dahl's relax infinitely fast
    /// there, FrBD's unless σ1 > 0.
    #[error("the step falls below {smallest:e} s, the smallest that still advances the time")]
    StepTooSmall {
        /// The smallest step that advances the time.
        smallest: f64,
    },
    /// A sliding direction reverses again and again without progress in time, as it does where
    /// the right-hand side jumps at zero velocity.
    #[error("sliding contact {contact} reverses without progress")]
    EndlessReversals {
        /// The contact.
        contact: usize,
    },
    /// The errors of the steps have grown, as they do at breakaway, to more than the tolerances of
    /// the solution allow. [`Solver::solve`](super::Solver::solve) then starts again with tighter
    /// ones for its steps. A run that hands out its steps cannot: hold its steps to tolerances of
    /// their own, by [`Solver::adaptive`](super::Solver::adaptive).
    #[error(
        "the estimated error of the solution is up to {:.1} times what the tolerances allow",
        .times + 0.05
    )]
    ErrorsGrow {
        /// The estimated error over what is allowed.
        times: f64,
    },
    /// [`System::linearised`](super::System::linearised) gives derivatives that are not those of
    /// [`System::rate`](super::System::rate), at several points in a row.
    #[error("the derivatives of component {component} are not those of its rate: see linearised")]
    WrongDerivative {
        /// The first component for which they are not.
        component: usize,
    },
    /// The steps to be stored need more memory than there is, or than a gibibyte: ask for samples,
    /// [`Output::Uniform`](super::Output::Uniform).
    #[cfg(feature = "alloc")]
    #[error("{steps} steps are more than can be stored: ask for samples instead")]
    TooMuchToStore {
        /// The steps stored.
        steps: usize,
    },
    /// The limit on the number of steps is used up.
    #[error("the limit of {limit} steps is used up")]
    TooManySteps {
        /// The limit.
        limit: u64,
    },
}

/// A run that ended before its time: why, when and where.
#[derive(Clone, PartialEq)]
pub struct Failure<T: Scalar, V: States<T>> {
    /// Why it stopped.
    pub reason: StopReason,
    /// The last time reached \[s\].
    pub time: T,
    /// The state there.
    pub state: V,
    /// Counts of its steps and evaluations.
    pub statistics: Statistics,
    /// The trajectory until then, of a run that stores its solution.
    #[cfg(feature = "alloc")]
    pub trajectory: Option<alloc::boxed::Box<super::trajectory::Trajectory<T, V>>>,
}

impl<T: Scalar, V: States<T>> Failure<T, V> {
    pub(crate) fn new(reason: StopReason, (time, state): (T, V), statistics: Statistics) -> Self {
        #[cfg(feature = "alloc")]
        return Self { reason, time, state, statistics, trajectory: None };
        #[cfg(not(feature = "alloc"))]
        Self { reason, time, state, statistics }
    }

    /// A run that did not start.
    pub(crate) fn refused(error: ParameterError, time: T, state: V) -> Self {
        Self::new(StopReason::Refused(error), (time, state), Statistics::default())
    }
}

impl<T: Scalar, V: States<T>> fmt::Display for Failure<T, V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.reason {
            StopReason::Refused(refused) => write!(f, "the integration did not start: {refused}"),
            reason => write!(f, "integration stopped at t = {} s: {reason}", Number::of(self.time)),
        }
    }
}

/// Says why in words, because `main` prints an error in this way, and of a trajectory how long it
/// is.
impl<T: Scalar, V: States<T>> fmt::Debug for Failure<T, V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut debug = f.debug_struct("Failure");
        debug.field("why", &format_args!("{self}")).field("state", &self.state);
        debug.field("statistics", &format_args!("{}", self.statistics));
        #[cfg(feature = "alloc")]
        if let Some(trajectory) = &self.trajectory {
            debug.field("trajectory", &format_args!("{} states", trajectory.states().len()));
        }
        debug.finish()
    }
}

impl<T: Scalar, V: States<T>> core::error::Error for Failure<T, V> {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        Some(&self.reason)
    }
}
