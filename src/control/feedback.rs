//! Compensation from the measured position, without chatter around zero velocity.
//!
//! A bristle is moved by distance, not by time: along a displacement Δx at speed s
//!
//! dz/dx = r(s) − sgn(Δx) (λ(s)/s) z,
//!
//! which is the exact step of length |Δx|/s at the velocity s sgn Δx. The compensator takes Δx from the encoder, exact and
//! with its quantisation, and only the speed at which the curve is read from a filter:
//!
//! F̂ = p (K z + σ2 v_f),  or with the micro-damping  F̂ = p (c₀(v_f) z + c₂(v_f) v_f)
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | Δx | measured displacement since the last good sample | m |
//! | v_f, s | filtered velocity, and its modulus | m/s |
//! | z | deflection | m |
//! | λ, r, c₀, c₂ | coefficients of the model, see [`Affine`](crate::Affine) | 1/s, –, 1/m, s/m |
//! | K, p | stiffness of the stored energy, normal force | 1/m, N |
//! | σ2 | viscous friction outside the bristle, of classical LuGre | s/m |
//! | q | size of one encoder count | m |
//!
//! At rest Δx is zero, and z and the elastic force stay as they are, to the last bit. An encoder that flickers by a count moves z
//! by no more than q (r + K|z|/g) ≤ q (1 + max μ/min μ), at any sample time, where a sign would switch the whole friction:
//! see [`FeedbackCompensator::step_per_count`]. That takes an exact modulus: a regularised model creeps, and has no such bound. The micro-damping force σ1 ż has no such limit but its own
//! size, for it follows the velocity; so it is left out unless asked for, and then takes the filtered velocity. In steady
//! sliding it is zero anyway.
//!
//! The estimate of two compensators of one model that see the same displacements converges whatever they started from:
//! their difference obeys dz̃/dx = −sgn(Δx)(λ/s) z̃. This needs no gain, and no knowledge of the controller. What
//! the feedback does to the loop is that of a negative stiffness: over-compensation by ε leaves −ε K p, which the controller
//! must outweigh with a stiffness of its own, or the loop hunts around its target.

use super::output::{Compensation, Outlet, OutputParameters};
use super::path::along;
use super::velocity_from_position::{VelocityFromPosition, VelocityFromPositionParameters};
use crate::parameter::ParameterError;
use crate::scalar::is_zero;
use crate::{Bristle, Contact, Scalar};

/// What becomes of the micro-damping force σ1 ż.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MicroDamping {
    /// It is left out, and stays in the mechanism, where it damps.
    #[default]
    Uncompensated,
    /// It is compensated with the filtered velocity.
    Filtered,
}

/// Parameters of a [`FeedbackCompensator`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeedbackParameters<T, M> {
    /// Friction under its normal force.
    pub contact: Contact<T, M>,
    /// Sample time h and time constant τ \[s\] of the velocity's filter, and the fastest speed \[m/s\].
    pub velocity: VelocityFromPositionParameters<T>,
    /// Whether the micro-damping force is compensated too.
    pub damping: MicroDamping,
    /// Share and limit.
    pub output: OutputParameters<T>,
}

/// Compensation driven by the measured displacement.
///
/// ```
/// use bristle::control::{
///     MicroDamping, FeedbackCompensator, FeedbackParameters, OutputParameters, VelocityFromPositionParameters,
/// };
/// use bristle::{Bristle, Dahl, DahlParameters};
///
/// let friction = Dahl::new(DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: 1e4 })?;
/// let mut compensator = FeedbackCompensator::new(FeedbackParameters {
///     contact: friction.under_load(20.0)?,
///     velocity: VelocityFromPositionParameters { sample_time: 1e-3, time_constant: 5e-3, fastest: 1.0, count: 0.0 },
///     damping: MicroDamping::Uncompensated,
///     output: OutputParameters { share: 1.0, largest_force: 15.0 },
/// })?;
/// // Ten counts of 1 µm, then a flicker of one count at rest: at most 0.4 N instead of twice 10 N.
/// let bound = compensator.step_per_count(1e-6).unwrap_or(0.0);
/// compensator.step(0.0);
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
    contact: Contact<T, M>,
    encoder: VelocityFromPosition<T>,
    damping: MicroDamping,
    /// σ2 of the term outside the bristle
    viscous: T,
    deflection: T,
    outlet: Outlet<T>,
}

impl<T: Scalar, M: Bristle<T, Deflection = T>> FeedbackCompensator<T, M> {
    /// Checks the parameters; the bristle is undeflected, and the first sample says where the mechanism is.
    ///
    /// # Errors
    ///
    /// Refuses a sample time or a largest force that is not positive, and a time constant or a share that is negative
    /// or not finite.
    pub fn new(parameters: FeedbackParameters<T, M>) -> Result<Self, ParameterError> {
        let FeedbackParameters { contact, velocity, damping, output } = parameters;
        let viscous =
            contact.model().characteristics(T::one()).map_or(T::zero(), |a| a.viscous_friction);
        Ok(Self {
            encoder: VelocityFromPosition::new(velocity)?,
            outlet: Outlet::new(output)?,
            contact,
            damping,
            viscous,
            deflection: T::zero(),
        })
    }

    /// The force for the coming sample, from a measured position \[m\].
    ///
    /// After samples that were refused the bristle follows the whole displacement since the last good one.
    #[inline]
    pub fn step(&mut self, position: T) -> Compensation<T> {
        let good = self.encoder.push(position).is_some();
        self.follow(good)
    }

    /// The force for the coming sample, from a displacement \[m\] since the last call: for `f32`, a difference of counts times the
    /// size of one. The compensator itself remembers displacements that it refused, see [`VelocityFromPosition::advance`]: after a glitch
    /// and the way back from it the bristle has followed the mechanism.
    #[inline]
    pub fn advance(&mut self, displacement: T) -> Compensation<T> {
        let good = self.encoder.advance(displacement).is_some();
        self.follow(good)
    }

    /// Moves the bristle, or refuses the sample.
    #[inline]
    fn follow(&mut self, good: bool) -> Compensation<T> {
        if !good {
            return self.outlet.refuse();
        }
        let model = self.contact.model();
        let (velocity, secant) = (self.encoder.filtered(), self.encoder.secant());
        let deflection = along(model, secant, velocity, self.deflection)
            .hold(secant, self.deflection, self.encoder.sample_time())
            .deflection;
        let coefficient = match self.damping {
            MicroDamping::Uncompensated => {
                model.storage_stiffness() * deflection + self.viscous * velocity
            }
            MicroDamping::Filtered => model.coefficient(velocity, deflection),
        };
        let force = self.contact.normal_force() * coefficient;
        if !(deflection.is_finite() && force.is_finite()) {
            return self.outlet.refuse();
        }
        self.deflection = deflection;
        self.outlet.give(force, deflection)
    }

    /// The most that an encoder which flickers by one count q \[m\] at rest moves the force \[N\] from one sample to the next:
    /// s p q (K (1 + max μ/min μ) + 2 σ2 w/h), with the weight w = h/(τ + h) of a new velocity in the filter. The first
    /// part is the elastic force's, at any velocity up to the fastest; the second, of classical LuGre only, that of the filtered velocity, which
    /// one count up and one down move by 2 w q/h at most.
    ///
    /// `None` where there is no such bound: for a model that does not tell what it is made of, whose damping is compensated
    /// too, or that is regularised, for its relaxation rate does not vanish with the velocity: per distance it has no limit; and for a
    /// count that is no finite number.
    ///
    /// Choose the encoder, or a share of the stiffness, so that the actuator bears it.
    pub fn step_per_count(&self, count: T) -> Option<T> {
        let model = self.contact.model();
        let fastest = self.encoder.fastest();
        let characteristics = model.characteristics(fastest)?;
        let stiffness = model.storage_stiffness();
        let most = model.limits(fastest).deflection? * stiffness;
        let ratio = most / characteristics.dry_coefficient.min;
        let viscous = self.viscous * self.encoder.weight() / self.encoder.sample_time();
        let per_metre = stiffness * (T::one() + ratio) + viscous + viscous;
        let step = self.outlet.share() * self.contact.normal_force() * per_metre * count.abs();
        let bounded =
            self.damping == MicroDamping::Uncompensated && is_zero(characteristics.speed_at_rest);
        (bounded && step.is_finite()).then_some(step)
    }

    /// The answer to the last sample.
    pub fn last(&self) -> Compensation<T> {
        self.outlet.last()
    }

    /// The contact.
    pub fn contact(&self) -> &Contact<T, M> {
        &self.contact
    }

    /// The filtered velocity [m/s].
    pub fn velocity(&self) -> T {
        self.encoder.filtered()
    }

    /// Begins anew with an undeflected bristle; the next sample says where the mechanism is.
    pub fn reset(&mut self) {
        self.encoder.reset();
        self.deflection = T::zero();
        self.outlet.reset(T::zero());
    }
}
