//! Compensation from the measured position, without chatter around zero velocity.
//!
//! A bristle that does not creep is moved by distance, not by time: along a displacement Δx
//!
//! dz/dx = r − sgn(Δx) (λ/|v_f|) z,
//!
//! which is the exact step of length |Δx|/|v_f| at the velocity |v_f| sgn Δx. The compensator takes
//! Δx from the encoder, with its quantisation, and only the speed |v_f| at which the curve is read
//! from a filter:
//!
//! F̂ = P K z + p σ2 v_f,  or with the micro-damping  F̂ = P (c₀(v_f) z + c₂(v_f) v_f)
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | Δx | measured displacement since the last good sample | m |
//! | v_f | filtered velocity | m/s |
//! | z | deflection | m |
//! | λ, r, c₀, c₂ | coefficients of the model, see [`Affine`](crate::Affine) | 1/s, –, 1/m, s/m |
//! | K | stiffness of the stored energy | 1/m |
//! | p, P | normal force; reference load, p if that is constant | N |
//! | σ2 | viscous friction outside the bristle, of classical LuGre | s/m |
//! | q | size of one encoder count | m |
//!
//! At rest Δx is zero, and z and the elastic force do not change. An encoder that flickers by
//! one count moves z by at most q (r + (λ/|v_f|) |z|) ≤ q (1 + max μ/min μ), at any sample time,
//! where a sign would switch the whole friction: see [`FeedbackCompensator::step_per_count`]. This
//! needs an exact modulus. A regularised model creeps, and has no such bound.
//!
//! The micro-damping force σ1 ż follows the velocity and has no such bound either. It is left out
//! by default; with [`MicroDamping::Filtered`] it is computed from the filtered velocity. In steady
//! sliding it is zero.
//!
//! Two compensators of one model that see the same displacements converge from any initial
//! deflection: their difference obeys dz̃/dx = −sgn(Δx) (λ/|v_f|) z̃. This needs no gain and no
//! knowledge of the controller.
//!
//! A bristle that creeps ([`Maxwell`](crate::rheology::Maxwell)) yields at rest, by time. Here it
//! does not, so that its force at a standstill is too large: take feed-forward for it.
//!
//! In the loop, feedback acts as a negative stiffness: over-compensation by ε leaves −ε P K, and so
//! does a model that is too stiff. The controller must outweigh it with a stiffness of its own, or
//! the loop hunts around its target.

use super::output::{Compensation, Output, OutputParameters};
use super::velocity_from_position::{
    MotionSample, VelocityFromPosition, VelocityFromPositionParameters, along,
};
use crate::parameter::Checked;
use crate::scalar::is_zero;
use crate::{Bristle, Contact, Scalar};

/// Whether a [`FeedbackCompensator`] compensates the micro-damping force σ1 ż too. In steady
/// sliding ż is zero, and both choices give the same force.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum MicroDamping {
    /// F̂ = P K z + p σ2 v_f: σ1 ż stays in the mechanism, where it damps the stuck axis. Begin
    /// with this. The force at rest changes by a bounded step for each encoder count, see
    /// [`FeedbackCompensator::step_per_count`].
    #[default]
    Uncompensated,
    /// F̂ = P (c₀(v_f) z + c₂(v_f) v_f): the whole force of the model, with ż computed from the
    /// filtered velocity v_f. A little better at reversals. Each count then adds a force of the
    /// order of η P σ1 q/(τ + h), with the share η and the time constant τ of the filter: take it
    /// if that is quiet enough.
    Filtered,
}

/// Parameters of a [`FeedbackCompensator`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct FeedbackParameters<T: Scalar, M> {
    /// Friction under its normal force.
    pub contact: Contact<T, M>,
    /// The encoder: sample time, filter of the velocity, fastest speed, size of a count.
    pub velocity: VelocityFromPositionParameters<T>,
    /// Whether the micro-damping force is compensated too.
    pub damping: MicroDamping,
    /// Share η and largest force.
    pub output: OutputParameters<T>,
}

/// Compensation driven by the measured displacement: η F̂, with the friction F̂ of a bristle
/// that is moved by the encoder's Δx. At rest the force stays as it is, whatever the noise of a
/// velocity would be. For an encoder with ten counts or more in the elastic displacement μ_s/σ0.
///
/// ```
/// use bristle::control::{
///     MicroDamping, FeedbackCompensator, FeedbackParameters, OutputParameters,
///     VelocityFromPositionParameters,
/// };
/// use bristle::{Bristle, Dahl, DahlParameters};
///
/// let friction = Dahl::new(DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: 1e4 })?;
/// let mut compensator = FeedbackCompensator::new(FeedbackParameters {
///     contact: friction.under_load(20.0)?,
///     velocity: VelocityFromPositionParameters {
///         sample_time: 1e-3,
///         time_constant: 5e-3,
///         fastest: 1.0,
///         count: 0.0,
///     },
///     damping: MicroDamping::Uncompensated,
///     output: OutputParameters { share: 1.0, largest_force: 15.0 },
/// })?;
/// // Ten counts of 1 µm, then a flicker of one count at rest: at most 0.4 N instead of twice 10 N.
/// let bound = compensator.step_per_count(1e-6).unwrap_or(0.0);
/// let _ = compensator.step(0.0);
/// let mut force = compensator.step(10e-6).force;
/// for count in [10, 11, 10, 11, 10] {
///     let now = compensator.step(1e-6 * f64::from(count)).force;
///     assert!((now - force).abs() <= bound && bound < 0.401);
///     force = now;
/// }
/// assert!(force > 1.5 && force < 2.0);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeedbackCompensator<T, M> {
    encoder: VelocityFromPosition<T>,
    damping: MicroDamping,
    /// σ2 of the term outside the bristle.
    viscous: T,
    output: Output<T, M>,
}

impl<T: Scalar, M: Bristle<T, Deflection = T>> FeedbackCompensator<T, M> {
    /// Checks the parameters. The bristle starts undeflected, and the first sample is the initial
    /// position.
    ///
    /// # Errors
    ///
    /// Refuses a sample time, a fastest speed or a largest force that is not positive, a time
    /// constant or a count that is negative or not finite, and a share outside 0 … 2.
    pub fn new(parameters: FeedbackParameters<T, M>) -> Checked<Self> {
        let FeedbackParameters { contact, velocity, damping, output } = parameters;
        let viscous =
            contact.model().characteristics(T::one()).map_or(T::zero(), |a| a.viscous_friction);
        Ok(Self {
            encoder: VelocityFromPosition::new(velocity)?,
            output: Output::new(contact, output)?,
            damping,
            viscous,
        })
    }

    /// The force for the coming sample, from a measured position \[m\].
    ///
    /// After refused samples the bristle follows the whole displacement since the last good one.
    #[inline]
    pub fn step(&mut self, position: T) -> Compensation<T> {
        let sample = self.encoder.step(position);
        self.follow(sample)
    }

    /// The force for the coming sample, from a displacement \[m\] since the last call: in `f32`, a
    /// difference of counts times the size of a count.
    ///
    /// The compensator remembers the displacements that it refused, see
    /// [`VelocityFromPosition::advance`]: after a glitch and the way back from it the bristle has
    /// followed the mechanism.
    #[inline]
    pub fn advance(&mut self, displacement: T) -> Compensation<T> {
        let sample = self.encoder.advance(displacement);
        self.follow(sample)
    }

    /// Moves the bristle, or refuses the sample.
    #[inline]
    fn follow(&mut self, sample: Option<MotionSample<T>>) -> Compensation<T> {
        let Some(MotionSample { velocity, secant, .. }) = sample else {
            return self.output.refuse();
        };
        let (contact, duration) = (&self.output.contact, self.encoder.sample_time);
        let before = self.output.last.deflection;
        let deflection =
            along(contact, secant, velocity, before).hold(secant, before, duration).deflection;
        let force = match self.damping {
            MicroDamping::Uncompensated => {
                let viscous = contact.surface(velocity).apply(self.viscous);
                let elastic = contact.model().storage_stiffness() * deflection;
                contact.reference_load() * (elastic + viscous * velocity)
            }
            MicroDamping::Filtered => contact.force(velocity, deflection),
        };
        self.output.answer(force, velocity, deflection)
    }

    /// Upper bound of the change of the force \[N\] from one sample to the next if the encoder
    /// flickers by one count q \[m\] at rest: η q (P K (1 + max μ/min μ) + 2 p σ2/(τ + h)), with
    /// the share η, the sample time h and the time constant τ of the filter.
    ///
    /// The first part comes from the elastic force, at any velocity up to the fastest. The second,
    /// of classical LuGre only, comes from the filtered velocity, which one count up and one count
    /// down change by at most 2 q/(τ + h).
    ///
    /// `None` where no such bound exists: for a model that gives no characteristics, with
    /// compensated micro-damping, for a regularised model and one that creeps (whose relaxation
    /// per distance has no limit), and for a count that is not finite.
    ///
    /// Choose the encoder, or a smaller stiffness, so that the actuator tolerates this force.
    pub fn step_per_count(&self, count: T) -> Option<T> {
        let model = self.output.contact.model();
        let fastest = self.encoder.fastest;
        let characteristics = model.characteristics(fastest)?;
        let stiffness = model.storage_stiffness();
        let most = model.limits(fastest).deflection? * stiffness;
        let ratio = most / characteristics.dry_coefficient.min;
        let viscous = self.output.contact.surface(T::zero()).apply(self.viscous);
        let viscous = viscous * self.encoder.weight / self.encoder.sample_time;
        let per_metre = stiffness * (T::one() + ratio) + viscous + viscous;
        let step =
            self.output.share * self.output.contact.reference_load() * per_metre * count.abs();
        let by_distance = is_zero(characteristics.speed_at_rest) && !characteristics.creeps;
        let bounded = self.damping == MicroDamping::Uncompensated && by_distance;
        (bounded && step.is_finite()).then_some(step)
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

    /// Takes other parameters between two samples: another model, load, share or limit. Deflection,
    /// position, velocity and the last answer are kept.
    ///
    /// The deflection stays as it is: with another stiffness the elastic force jumps by the ratio
    /// of the two, and the stored energy with it. For a load that varies see
    /// [`FeedbackCompensator::reload`], which is passive.
    ///
    /// # Errors
    ///
    /// Those of [`FeedbackCompensator::new`]; nothing has changed.
    ///
    /// ```
    /// # use bristle::control::{
    /// #     MicroDamping, FeedbackCompensator, FeedbackParameters, OutputParameters,
    /// #     VelocityFromPositionParameters,
    /// # };
    /// # use bristle::curve::{AnyCurve, Coulomb, CoulombParameters, Stribeck};
    /// # use bristle::rheology::KelvinVoigt;
    /// # use bristle::{AnyBristle, Bristle, FrBd, ParameterError, paper};
    /// // A model chosen at run time, and another one when the joint has warmed up.
    /// let friction = |curve: AnyCurve<f64>| -> Result<AnyBristle<f64>, ParameterError> {
    ///     Ok(FrBd::new(curve, KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?).into())
    /// };
    /// let cold = Stribeck::new(paper::STICK_SLIP_CURVE)?;
    /// let warm = CoulombParameters { dynamic_coefficient: 1.2, viscous_friction: 0.0 };
    /// let parameters = FeedbackParameters {
    ///     contact: friction(cold.into())?.under_load(1.0)?,
    ///     // …
    /// #     velocity: VelocityFromPositionParameters {
    /// #         sample_time: 1e-3, time_constant: 5e-3, fastest: 1.0, count: 0.0,
    /// #     },
    /// #     damping: MicroDamping::Uncompensated,
    /// #     output: OutputParameters { share: 1.0, largest_force: 15.0 },
    /// };
    /// let mut compensator = FeedbackCompensator::new(parameters.clone())?;
    /// let _ = compensator.step(0.0);
    /// let before = compensator.step(5e-5).deflection;
    /// let contact = friction(Coulomb::new(warm)?.into())?.under_load(1.0)?;
    /// compensator.change(FeedbackParameters { contact, ..parameters })?;
    /// assert_eq!(compensator.step(5e-5).deflection, before); // it has not moved
    /// # Ok::<(), ParameterError>(())
    /// ```
    pub fn change(&mut self, parameters: FeedbackParameters<T, M>) -> Checked<()> {
        let new = Self::new(parameters)?;
        let (encoder, output) = (new.encoder.after(&self.encoder), new.output.after(&self.output));
        *self = Self { encoder, output, ..new };
        Ok(())
    }

    /// The contact, with its model and its present load.
    pub fn contact(&self) -> &Contact<T, M> {
        &self.output.contact
    }

    /// The filtered velocity v_f [m/s], at which the curve is read.
    pub fn velocity(&self) -> T {
        self.encoder.velocity()
    }

    /// Back to the beginning: an undeflected bristle; the next sample is the initial position.
    pub fn reset(&mut self) {
        self.encoder.reset();
        self.output.reset();
    }
}
