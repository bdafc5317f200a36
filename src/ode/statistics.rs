//! Counts of steps and evaluations of a run.

use core::fmt;

/// Counts of the steps, evaluations and reversals of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Statistics {
    /// Accepted steps.
    pub steps: u64,
    /// Rejected trial steps, including those cut at a reversal, and all steps of a run that was
    /// started again with tighter ones.
    pub rejected: u64,
    /// Evaluations of the right-hand side.
    pub evaluations: u64,
    /// Evaluations of the Jacobian. An explicit method takes them only to estimate the error of the
    /// solution.
    pub jacobians: u64,
    /// Reversals of a sliding direction at which a step was split.
    pub reversals: u64,
}

impl Statistics {
    /// These counts after others of a run that was started again: its steps are rejected ones.
    #[cfg(feature = "alloc")]
    pub(super) fn after(mut self, before: &Self) -> Self {
        self.rejected += before.rejected + before.steps;
        self.evaluations += before.evaluations;
        self.jacobians += before.jacobians;
        self
    }
}

impl fmt::Display for Statistics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { steps, rejected, evaluations, jacobians, reversals } = self;
        write!(
            f,
            "{steps} steps, {rejected} rejected, {evaluations} evaluations, \
             {jacobians} Jacobians, {reversals} reversals"
        )
    }
}
