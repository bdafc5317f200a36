//! Friction of a gear: it grows with the torques through the gear, and differs between driving and
//! being driven.
//!
//! p = s (p0 + |k_m τ_m − k_e τ_e|),  T = P μ_b(v, z; p/P) + s_B B v
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | τ_m | motor torque, positive along v > 0 | N m |
//! | τ_e | external torque, positive along v > 0: gravity and load, no inertia | N m |
//! | v | angular velocity of the joint | rad/s |
//! | z | deflection of the bristle | rad |
//! | p | load of the gear: its normal force in units of torque | N m |
//! | P | reference load, at which stiffness and damping were measured | N m |
//! | p0 | load of an idle gear: preload of teeth, seals and bearings | N m |
//! | k_m, k_e | how much of the motor torque and of the external torque loads the gear | – |
//! | μ_b | virtual friction coefficient of the [`Bristle`] under the friction scale p/P | – |
//! | B | drag: viscous friction beside the load | N m s/rad |
//! | s, s_B | scales of friction and drag, set while it runs: temperature, wear | – |
//! | T | friction torque on the joint, against v > 0 | N m |
//!
//! Where motor and load pull against each other, as in lifting or holding, their parts of p add up.
//! The load changes from step to step as [`Contact::reload`](bristle::Contact::reload) says:
//! stiffness P σ0 and damping P σ1 stay, the friction p μ(v) follows. So a joint that is held
//! stands still while the torques vary, and the friction is passive whatever they do.
//!
//! Only the products p0 μ, k_m μ, k_e μ and P σ0 can be identified from measurements: fix one of
//! them, μ_d = 1 or k_m = 1.
//!
//! # Driving and being driven
//!
//! In steady motion with friction coefficient μ and speed |v| the loss beside the load is
//! c = s p0 μ + s_B B |v|. With μ for s μ:
//!
//! | | balance | efficiency |
//! |---|---|---|
//! | driving | τ_m (1 − μ k_m) = \|τ_e\| (1 + μ k_e) + c | \|τ_e\|/τ_m |
//! | being driven, the motor brakes | \|τ_m\| (1 + μ k_m) = τ_e (1 − μ k_e) − c | \|τ_m\|/τ_e |
//!
//! From μ k_e ≥ 1 on no external torque moves the gear: it is *self-locking*. From μ k_m ≥ 1 on no
//! motor torque moves it against a load: it jams. [`GearFriction::driving_torque`]
//! and [`GearFriction::braking_torque`] solve the balances,
//! [`GearFriction::audit`] prints them.
//!
//! Source: the load law covers the friction models M1 to M4 of G. Duclusaud, G. Passault, V.
//! Padois, O. Ly, "Extended friction models for the physics simulation of servo actuators" (arXiv
//! 2410.08650); the balances follow from it.

use core::fmt::Debug;

use bristle::companion::{Companion, CompanionStep, CompletedStep};
use bristle::parameter::{Checked, Named};
use bristle::rheology::Deflection;
use bristle::{Bristle, Contact, LoadChange, Reloaded, Scalar, Surface};

/// The torques through a gear, positive along v > 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GearTorques<T> {
    /// Motor torque τ_m [N m], at the joint.
    pub motor: T,
    /// External torque τ_e [N m]: gravity, load; no inertia.
    pub external: T,
}

/// How the load of a gear follows from the torques through it. A number is a load that does not
/// depend on them.
///
/// ```
/// use bristle_joint::{GearTorques, LoadLaw};
///
/// /// The load grows with the square of the motor torque.
/// #[derive(Debug, Clone)]
/// struct Quadratic { base: f64, factor: f64 }
///
/// impl LoadLaw<f64> for Quadratic {
///     fn load(&self, torques: GearTorques<f64>) -> f64 {
///         self.base + self.factor * torques.motor * torques.motor
///     }
/// }
/// ```
pub trait LoadLaw<T: Scalar>: Debug + Clone {
    /// The load p [N m]; zero or positive for every finite torque.
    fn load(&self, torques: GearTorques<T>) -> T;
}

/// A load that does not depend on the torques.
impl<T: Scalar> LoadLaw<T> for T {
    #[inline]
    fn load(&self, _torques: GearTorques<T>) -> T {
        *self
    }
}

/// Parameters of [`TorqueLoad`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct TorqueLoadParameters<T> {
    /// Load p0 of an idle gear [N m], zero or positive.
    #[doc(alias = "p0")]
    pub idle_load: T,
    /// How much of the motor torque loads the gear, k_m \[–\], zero or positive.
    #[doc(alias = "k_m")]
    pub motor_share: T,
    /// How much of the external torque loads the gear, k_e \[–\], zero or positive.
    #[doc(alias = "k_e")]
    pub external_share: T,
}

/// The load p = p0 + |k_m τ_m − k_e τ_e|.
///
/// ```
/// use bristle_joint::{GearTorques, LoadLaw, TorqueLoad, TorqueLoadParameters};
///
/// let parameters =
///     TorqueLoadParameters { idle_load: 2.0, motor_share: 1.0, external_share: 0.6 };
/// let load = TorqueLoad::new(parameters)?;
/// // Lifting: motor and load pull against each other.
/// assert_eq!(load.load(GearTorques { motor: 3.0, external: -5.0 }), 8.0);
/// // Accelerating downwards they pull together.
/// assert_eq!(load.load(GearTorques { motor: -3.0, external: -5.0 }), 2.0);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TorqueLoad<T> {
    parameters: TorqueLoadParameters<T>,
}

impl<T: Scalar> TorqueLoad<T> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Refuses a parameter that is negative or not finite.
    pub fn new(parameters: TorqueLoadParameters<T>) -> Checked<Self> {
        Named("idle_load", parameters.idle_load).non_negative()?;
        Named("motor_share", parameters.motor_share).non_negative()?;
        Named("external_share", parameters.external_share).non_negative()?;
        Ok(Self { parameters })
    }

    /// The parameters.
    pub fn parameters(&self) -> TorqueLoadParameters<T> {
        self.parameters
    }

    /// k_m τ_m − k_e τ_e [N m], at whose zero the load has a kink.
    #[inline]
    pub fn difference(&self, torques: GearTorques<T>) -> T {
        self.parameters.motor_share * torques.motor
            - self.parameters.external_share * torques.external
    }
}

impl<T: Scalar> LoadLaw<T> for TorqueLoad<T> {
    #[inline]
    fn load(&self, torques: GearTorques<T>) -> T {
        self.parameters.idle_load + self.difference(torques).abs()
    }
}

/// Parameters of [`GearFriction`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct GearFrictionParameters<T, M, L> {
    /// Friction model, with angles: μ \[–\], σ0 [1/rad], σ1 and σ2 [s/rad], v_S [rad/s].
    pub friction: M,
    /// How the load follows from the torques: [`TorqueLoad`], a number, or a law of your own.
    pub load: L,
    /// Reference load P [N m], positive: the one at which stiffness and damping were measured. A
    /// stiffness p σ0 that followed the load when it was fitted belongs to the load p of the
    /// stuck gear in those measurements.
    pub reference_load: T,
    /// Drag B [N m s/rad], zero or positive.
    pub drag: T,
    /// Speed [rad/s] up to which the deflection is limited, zero or positive, see
    /// [`Contact::companion`](bristle::Contact::companion).
    pub fastest: T,
}

/// The friction of a gear: a model under a load that follows the torques, and a drag.
///
/// Over one step it is a source and a damper, as a [`Companion`] is. A motor of
/// 3 N m that lifts a load of 2 N m, in steps of 1 ms:
///
/// ```
/// use bristle::companion::VelocityHistory;
/// use bristle::curve::{Stribeck, StribeckParameters};
/// use bristle_joint::{
///     GearFriction, GearFrictionParameters, GearTorques, LoadedDeflection, TorqueLoad,
///     TorqueLoadParameters,
/// };
/// use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
/// use bristle::FrBd;
///
/// let curve = Stribeck::new(StribeckParameters {
///     static_coefficient: 0.15,
///     dynamic_coefficient: 0.1,
///     stribeck_velocity: 0.05, // rad/s
///     stribeck_exponent: 1.0,
///     viscous_friction: 0.0,
/// })?;
/// let bristle =
///     KelvinVoigt::new(KelvinVoigtParameters { micro_stiffness: 300.0, micro_damping: 1.0 })?;
/// let load = TorqueLoad::new(TorqueLoadParameters {
///     idle_load: 2.0,
///     motor_share: 1.0,
///     external_share: 0.6,
/// })?;
/// let friction = FrBd::new(curve, bristle);
/// let reference_load = 2.0; // N m: the stiffness was measured on the idle gear
/// let gear = GearFriction::new(GearFrictionParameters {
///     friction,
///     load,
///     reference_load,
///     drag: 0.05,
///     fastest: 5.0,
/// })?;
///
/// let (inertia, h) = (0.02, 1e-3); // kg m², s
/// let (mut v, mut z) = (0.0, LoadedDeflection::none());
/// let mut history = VelocityHistory::new(0.0);
/// for _ in 0..2000 {
///     let torques = GearTorques { motor: 3.0, external: -2.0 }; // N m, at the middle of the step
///     let step = gear.step(torques, history.predict(), z, h)?;
///     // J (v₁ − v)/h = τ_m + τ_e − bias − damping v̄ with v₁ = 2 v̄ − v
///     let momentum = 2.0 * inertia / h;
///     let mean = (momentum * v + torques.motor + torques.external - step.bias())
///         / (momentum + step.damping());
///     (v, z) = (2.0 * mean - v, step.commit(mean).deflection);
///     history.push(v);
/// }
/// // 3 − 2 = 0.1 (2 + 3 + 0.6 · 2) + 0.05 v
/// assert!((v - 7.6_f64).abs() < 0.1);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
///
/// An arm of n joints is one linear solve, of `Arm` in `bristle-mechanism`: it takes the loads
/// ([`GearFriction::load`]) and companions of the [contact](GearFriction::contact); the drag
/// belongs in its `Link::damping` (example `arm`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GearFriction<T, M, L> {
    /// Under the reference load.
    companion: Companion<T, M>,
    law: L,
    drag: T,
    friction_scale: T,
    drag_scale: T,
}

impl<T: Scalar, M: Bristle<T>, L: LoadLaw<T>> GearFriction<T, M, L> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Refuses a reference load that is not positive, a drag or a fastest speed that is negative or
    /// not finite, and a law whose load without torques is.
    pub fn new(parameters: GearFrictionParameters<T, M, L>) -> Checked<Self> {
        let GearFrictionParameters { friction, load: law, reference_load, drag, fastest } =
            parameters;
        let zero = T::zero();
        Named("load", law.load(GearTorques { motor: zero, external: zero })).non_negative()?;
        let reference_load = Named("reference_load", reference_load).positive()?;
        Ok(Self {
            companion: friction.under_load(reference_load)?.companion(fastest)?,
            law,
            drag: Named("drag", drag).non_negative()?,
            friction_scale: T::one(),
            drag_scale: T::one(),
        })
    }

    /// The parameters, without the scales.
    pub fn parameters(&self) -> GearFrictionParameters<T, M, L> {
        let (friction, load) = (self.model().clone(), self.law.clone());
        GearFrictionParameters {
            friction,
            load,
            reference_load: self.contact().reference_load(),
            drag: self.drag,
            fastest: self.companion.fastest(),
        }
    }

    /// The contact under the reference load: its stored energy is that of the gear, and
    /// [`Contact::response_under`] the [load](GearFriction::load) its friction.
    pub fn contact(&self) -> &Contact<T, M> {
        self.companion.contact()
    }

    /// The friction model.
    pub fn model(&self) -> &M {
        self.contact().model()
    }

    /// The load law.
    pub fn law(&self) -> &L {
        &self.law
    }

    /// The load p [N m] under given torques, with the scale s.
    #[inline]
    pub fn load(&self, torques: GearTorques<T>) -> T {
        self.friction_scale * self.law.load(torques)
    }

    /// The drag s_B B [N m s/rad].
    #[inline]
    pub fn drag(&self) -> T {
        self.drag_scale * self.drag
    }

    /// The scale s of the friction \[–\].
    pub fn friction_scale(&self) -> T {
        self.friction_scale
    }

    /// The scale s_B of the drag \[–\].
    pub fn drag_scale(&self) -> T {
        self.drag_scale
    }

    /// Sets the scale s of the friction \[–\], zero or positive; 1 at the beginning. The next step
    /// counts it as a change of the load: the stiffness stays.
    ///
    /// # Errors
    ///
    /// Refuses a scale that is negative or not finite; nothing has changed.
    #[inline]
    pub fn set_friction_scale(&mut self, scale: T) -> Checked<()> {
        self.friction_scale = Named("friction_scale", scale).non_negative()?;
        Ok(())
    }

    /// Sets the scale s_B of the drag \[–\], zero or positive; 1 at the beginning.
    ///
    /// # Errors
    ///
    /// Refuses a scale that is negative or not finite; nothing has changed.
    #[inline]
    pub fn set_drag_scale(&mut self, scale: T) -> Checked<()> {
        self.drag_scale = Named("drag_scale", scale).non_negative()?;
        Ok(())
    }

    /// The source and the damper that stand for friction and drag over a step of length h ≥ 0
    /// \[s\], from the torques and a velocity v\* [rad/s] predicted for its middle and a deflection
    /// with its load. NaN for h < 0.
    ///
    /// # Errors
    ///
    /// Refuses torques whose load is negative or not finite.
    #[inline]
    pub fn step(
        &self,
        torques: GearTorques<T>,
        predicted_velocity: T,
        before: LoadedDeflection<T, M::Deflection>,
        duration: T,
    ) -> Checked<GearStep<T, M::Deflection>> {
        let load = Named("load", self.load(torques)).non_negative()?;
        let change = LoadChange { before: before.load, after: load };
        let contact = self.contact();
        let Reloaded { deflection, dissipated } =
            contact.reloaded(change, predicted_velocity, before.deflection);
        let surface = Surface::scaled(predicted_velocity, load / contact.reference_load());
        Ok(GearStep {
            friction: self.companion.step(surface, deflection, duration),
            load,
            drag: self.drag(),
            duration,
            slipped: dissipated,
        })
    }
}

impl<T: Scalar, M: Bristle<T>> GearFriction<T, M, TorqueLoad<T>> {
    /// Numerator and denominator of the motor torque of steady motion, with signed friction:
    /// against an external torque it adds, in the sense 1, and with it, −1, it takes away.
    ///
    /// τ_m (1 − μ k_m) = τ_e (1 + μ k_e) + μ p0 + s_B B |v|
    fn balance(&self, velocity: T, external_torque: T, sense: T) -> (T, T) {
        let TorqueLoadParameters { idle_load, motor_share, external_share } = self.law.parameters;
        let friction = self.friction_scale * self.model().stationary_coefficient(velocity).abs();
        let (friction, drag) = (sense * friction, sense * (self.drag() * velocity.abs()));
        let needed = external_torque.abs() * (T::one() + friction * external_share)
            + (friction * idle_load + drag);
        (needed, T::one() - friction * motor_share)
    }

    /// The motor torque [N m] that drives the gear steadily at a velocity [rad/s] against an
    /// external torque of so many N m; both without their signs. `None` for a gear that jams,
    /// μ k_m ≥ 1.
    pub fn driving_torque(&self, velocity: T, external_torque: T) -> Option<T> {
        let (needed, passed) = self.balance(velocity, external_torque, T::one());
        (passed > T::zero()).then(|| needed / passed)
    }

    /// The motor torque [N m] that brakes the gear while an external torque of so many N m drives
    /// it steadily at a velocity [rad/s]; both without their signs. `None` where friction holds the
    /// external torque: always for a self-locking gear, μ k_e ≥ 1.
    pub fn braking_torque(&self, velocity: T, external_torque: T) -> Option<T> {
        let (left, passed) = self.balance(velocity, external_torque, -T::one());
        let braking = left / passed;
        (braking >= T::zero()).then_some(braking)
    }
}

/// The deflection of the bristle of a gear, and the load that held it: what a caller keeps from
/// step to step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadedDeflection<T, D = T> {
    /// Deflection z \[rad\].
    pub deflection: D,
    /// Load p [N m] of the last step, zero before the first. Where the load falls from it below
    /// what the bristle carries, the bristle slips back.
    pub load: T,
}

impl<T: Scalar, D: Deflection<T>> LoadedDeflection<T, D> {
    /// An undeflected bristle before the first step.
    pub fn none() -> Self {
        Self { deflection: D::fill(T::zero()), load: T::zero() }
    }
}

/// Friction and drag of a gear over one step: mean torque = bias + damping·v̄.
#[must_use]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GearStep<T: Scalar, D: Deflection<T> = T> {
    friction: CompanionStep<T, D>,
    load: T,
    drag: T,
    duration: T,
    /// Energy dissipated by slipping back when the load changed.
    slipped: T,
}

impl<T: Scalar, D: Deflection<T>> GearStep<T, D> {
    /// Mean friction torque [N m] if the mean velocity is zero.
    #[inline]
    pub fn bias(&self) -> T {
        self.friction.bias()
    }

    /// Increase of the mean torque with the mean velocity [N m s/rad], zero or positive, with the
    /// drag.
    #[inline]
    pub fn damping(&self) -> T {
        self.friction.damping() + self.drag
    }

    /// Mean torque [N m] of friction and drag at a mean velocity v̄ [rad/s], against v̄ > 0.
    #[inline]
    pub fn torque(&self, mean_velocity: T) -> T {
        self.bias() + self.damping() * mean_velocity
    }

    /// Ends the step with the mean velocity v̄ [rad/s] that the mechanism has found. The drag, and
    /// the energy dissipated by the change of the load, are in the account.
    #[inline]
    pub fn commit(&self, mean_velocity: T) -> CompletedStep<T, LoadedDeflection<T, D>> {
        let done = self.friction.commit(mean_velocity);
        let drag = self.drag * mean_velocity;
        let lost = drag * mean_velocity * self.duration;
        CompletedStep {
            deflection: LoadedDeflection { deflection: done.deflection, load: self.load },
            force: done.force + drag,
            work: done.work + lost,
            stored: done.stored - self.slipped,
            dissipated: done.dissipated + lost + self.slipped,
        }
    }
}
