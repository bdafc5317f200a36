//! What all compensators share: their output.

use crate::parameter::{Checked, Named};
use crate::rheology::Deflection;
use crate::{Bristle, Contact, Scalar};

/// How a compensator turns its estimate F̂ \[N\] of the friction into the force that it gives out:
/// η F̂, cut to ± `largest_force`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct OutputParameters<T> {
    /// Share η \[–\] of the model's force that is given out: 1 compensates all of it, 1.2 a fifth
    /// too much. Between 0 and 2: at 2 the friction is turned around. Begin with 0.9.
    pub share: T,
    /// Largest force \[N\] that is given out, positive: what the actuator can spare beside the
    /// controller. Begin with half of the actuator's rated force.
    pub largest_force: T,
}

/// The answer of a compensator to one sample: the force, and what the loop should know of it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use = "the force has to be added to the controller's"]
pub struct Compensation<T> {
    /// Force η F̂ \[N\] to add to the controller's, over the sample that begins now: positive
    /// against a friction that brakes v > 0.
    pub force: T,
    /// Deflection of the model's bristle \[m\], for a chart or a monitor: at this sample, in
    /// feed-forward at the end of the coming one.
    pub deflection: T,
    /// Whether the force was cut to the largest one. Stop the controller's integral meanwhile.
    pub saturated: bool,
    /// Number of samples in a row, up to this one, that were refused: not finite, or too fast. The
    /// force is then that of the last good sample. If this lasts, ramp the force down and stop.
    pub refused: u32,
}

/// What all compensators share: the contact, the checked parameters, the velocity of the last good
/// sample, and the last answer, which also keeps the deflection of the bristle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Output<T, M> {
    pub(super) contact: Contact<T, M>,
    pub(super) share: T,
    largest_force: T,
    velocity: T,
    pub(super) last: Compensation<T>,
}

impl<T: Scalar, M: Bristle<T, Deflection = T>> Output<T, M> {
    pub(super) fn new(contact: Contact<T, M>, parameters: OutputParameters<T>) -> Checked<Self> {
        Ok(Self {
            contact,
            velocity: T::zero(),
            share: Named("share", parameters.share).between(0.0, 2.0)? + T::zero(),
            largest_force: Named("largest_force", parameters.largest_force).positive()?,
            last: Self::start(),
        })
    }

    /// Back to the beginning: an undeflected bristle.
    pub(super) fn reset(&mut self) {
        (self.velocity, self.last) = (T::zero(), Self::start());
    }

    /// Changes the normal force, at the velocity of the last good sample.
    #[inline]
    pub(super) fn reload(&mut self, normal_force: T) -> Checked<()> {
        let deflection = self.last.deflection;
        self.last.deflection =
            self.contact.reload(normal_force, self.velocity, deflection)?.deflection;
        Ok(())
    }

    /// This output going on after another: with its last answer, within the largest force.
    pub(super) fn after(self, before: &Self) -> Self {
        let Compensation { force, saturated, .. } = before.last;
        let saturated = saturated || force.abs() > self.largest_force;
        let force = force.within(self.largest_force);
        let last = Compensation { force, saturated, ..before.last };
        Self { last, velocity: before.velocity, ..self }
    }

    fn start() -> Compensation<T> {
        let zero = T::zero();
        Compensation { force: zero, deflection: zero, saturated: false, refused: 0 }
    }

    /// The answer to a good sample, unless the model's numbers are not finite.
    #[inline]
    pub(super) fn answer(&mut self, friction: T, velocity: T, deflection: T) -> Compensation<T> {
        if !(friction.is_finite() && deflection.is_finite()) {
            return self.refuse();
        }
        let wanted = self.share * friction;
        let saturated = wanted.abs() > self.largest_force;
        let force = wanted.within(self.largest_force);
        self.velocity = velocity;
        self.last = Compensation { force, deflection, saturated, refused: 0 };
        self.last
    }

    /// The answer to a bad sample: the last force again.
    #[cold]
    pub(super) fn refuse(&mut self) -> Compensation<T> {
        self.last.refused = self.last.refused.saturating_add(1);
        self.last
    }

    /// The answer to a bad sample whose displacement is known: the last force, a new deflection.
    #[cold]
    pub(super) fn refuse_and_move(&mut self, deflection: T) -> Compensation<T> {
        if deflection.is_finite() {
            self.last.deflection = deflection;
        }
        self.refuse()
    }
}
