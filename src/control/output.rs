//! What a compensator gives out: a share of the friction force, within the actuator's limit.

use crate::Scalar;
use crate::parameter::{self, ParameterError};

/// How much of the friction force is compensated, and how much at most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutputParameters<T> {
    /// Share s \[–\] of the model's force that is given out: 1 compensates all of it, 1.2 a fifth too much.
    pub share: T,
    /// Largest force \[N\] that is given out, positive: what the actuator can spare.
    pub largest_force: T,
}

/// The answer to one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Compensation<T> {
    /// Force \[N\] to add to the controller's, over the sample that begins now.
    pub force: T,
    /// Deflection of the model's bristle \[m\] now; zero where there is none.
    pub deflection: T,
    /// Whether the force was cut to the largest one.
    pub saturated: bool,
    /// Samples in a row, up to this one, that were refused: no finite numbers, or too fast. Then the force
    /// is that of the last good sample: let the loop act on it where that lasts.
    pub refused: u32,
}

/// The checked parameters, and the last answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Outlet<T> {
    share: T,
    largest_force: T,
    last: Compensation<T>,
}

impl<T: Scalar> Outlet<T> {
    pub(super) fn new(parameters: OutputParameters<T>) -> Result<Self, ParameterError> {
        Ok(Self {
            share: parameter::non_negative("share", parameters.share)?,
            largest_force: parameter::positive("largest_force", parameters.largest_force)?,
            last: Compensation {
                force: T::zero(),
                deflection: T::zero(),
                saturated: false,
                refused: 0,
            },
        })
    }

    pub(super) fn share(&self) -> T {
        self.share
    }

    /// Says where the bristle is after a sample that is refused though it moved.
    pub(super) fn moved(&mut self, deflection: T) {
        self.last.deflection = deflection;
    }

    pub(super) fn last(&self) -> Compensation<T> {
        self.last
    }

    /// Begins anew.
    pub(super) fn reset(&mut self, deflection: T) {
        self.last = Compensation { force: T::zero(), deflection, saturated: false, refused: 0 };
    }

    /// The answer to a good sample.
    #[inline]
    pub(super) fn give(&mut self, friction: T, deflection: T) -> Compensation<T> {
        let wanted = self.share * friction;
        let (force, saturated) = if wanted > self.largest_force {
            (self.largest_force, true)
        } else if wanted < -self.largest_force {
            (-self.largest_force, true)
        } else {
            (wanted, false)
        };
        self.last = Compensation { force, deflection, saturated, refused: 0 };
        self.last
    }

    /// The answer to a bad sample: the last one again.
    #[cold]
    pub(super) fn refuse(&mut self) -> Compensation<T> {
        self.last.refused = self.last.refused.saturating_add(1);
        self.last
    }
}
