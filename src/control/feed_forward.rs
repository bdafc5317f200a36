//! Compensation from the reference: the friction that the mechanism has if it follows the
//! reference.
//!
//! z ← exact step of the bristle at v_ref over h,  force given out: η F̄
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | v_ref | mean velocity of the reference over the coming sample | m/s |
//! | h | sample time | s |
//! | z | deflection of the bristle | m |
//! | F̄ | friction force averaged over that sample | N |
//! | η | share that is compensated | – |
//!
//! No measurement enters, so that nothing can chatter, hunt or become unstable through it, at any
//! share and sample time. In return it does not notice that the mechanism is stuck or elsewhere,
//! and it needs a model that fits.

use super::output::{Compensation, Output, OutputParameters};
use crate::parameter::{Checked, Named};
use crate::{Bristle, Contact, Scalar};

/// Parameters of a [`FeedForwardCompensator`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct FeedForwardParameters<T: Scalar, M> {
    /// Friction under its normal force.
    pub contact: Contact<T, M>,
    /// Sample time h \[s\], positive.
    pub sample_time: T,
    /// Speed \[m/s\] that no reference exceeds, positive: a faster one is refused as a fault.
    pub fastest: T,
    /// Share η and largest force.
    pub output: OutputParameters<T>,
}

/// Compensation driven by the velocity of the reference: η F̄, with the friction F̄ that the
/// axis will have over the coming sample if it follows its reference. For axes that do, or whose
/// encoder is too coarse for a [`FeedbackCompensator`](super::FeedbackCompensator).
///
/// ```
/// use bristle::control::{FeedForwardCompensator, FeedForwardParameters, OutputParameters};
/// use bristle::{Bristle, Dahl, DahlParameters};
///
/// let friction = Dahl::new(DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: 1e4 })?;
/// let mut compensator = FeedForwardCompensator::new(FeedForwardParameters {
///     contact: friction.under_load(20.0)?,
///     sample_time: 1e-3,
///     fastest: 1.0,
///     output: OutputParameters { share: 1.0, largest_force: 15.0 },
/// })?;
/// let mut force = 0.0_f64;
/// for _ in 0..100 {
///     force = compensator.step(0.01).force;
/// }
/// assert!((force - 10.0).abs() < 1e-6);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeedForwardCompensator<T, M> {
    sample_time: T,
    fastest: T,
    output: Output<T, M>,
}

impl<T: Scalar, M: Bristle<T, Deflection = T>> FeedForwardCompensator<T, M> {
    /// Checks the parameters. The bristle starts undeflected.
    ///
    /// # Errors
    ///
    /// Refuses a sample time, a fastest speed or a largest force that is not positive, and a share
    /// outside 0 … 2.
    pub fn new(parameters: FeedForwardParameters<T, M>) -> Checked<Self> {
        Ok(Self {
            sample_time: Named("sample_time", parameters.sample_time).positive()?,
            fastest: Named("fastest", parameters.fastest).positive()?,
            output: Output::new(parameters.contact, parameters.output)?,
        })
    }

    /// The force for the coming sample, from the reference's mean velocity over it [m/s].
    #[inline]
    pub fn step(&mut self, reference_velocity: T) -> Compensation<T> {
        if !(reference_velocity.abs() <= self.fastest) {
            return self.output.refuse();
        }
        let deflection = self.output.last.deflection;
        let held = self.output.contact.hold(reference_velocity, deflection, self.sample_time);
        self.output.answer(held.mean_force, reference_velocity, held.deflection)
    }

    /// Changes the normal force \[N\], zero or positive, before a sample: that at its middle, as
    /// measured or computed. A deflection that it no longer holds is cut, see
    /// [`Contact::reload`].
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite; nothing has changed.
    #[inline]
    pub fn reload(&mut self, normal_force: T) -> Checked<()> {
        self.output.reload(normal_force)
    }

    /// Takes other parameters between two samples: another model, load, share or limit. The
    /// deflection and the last answer are kept.
    ///
    /// The deflection stays as it is: with another stiffness the elastic force jumps by the ratio
    /// of the two, and the stored energy with it. For a load that varies see
    /// [`FeedForwardCompensator::reload`], which is passive.
    ///
    /// # Errors
    ///
    /// Those of [`FeedForwardCompensator::new`]; nothing has changed.
    pub fn change(&mut self, parameters: FeedForwardParameters<T, M>) -> Checked<()> {
        let new = Self::new(parameters)?;
        *self = Self { output: new.output.after(&self.output), ..new };
        Ok(())
    }

    /// The contact, with its model and its present load.
    pub fn contact(&self) -> &Contact<T, M> {
        &self.output.contact
    }

    /// Back to the beginning: an undeflected bristle.
    pub fn reset(&mut self) {
        self.output.reset();
    }
}
