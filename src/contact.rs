//! A friction model under a normal force: forces in newtons, energies in joules.
//!
//! F = p μ_b,  W = ½ p Σ Kᵢ xᵢ²
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | p | normal force | N |
//! | F | friction force on the body, positive against v > 0: m v̇ = … − F | N |
//! | W | energy stored in the bristles | J |
//!
//! # A normal force that varies
//!
//! With the deflection kept, a rise of the normal force would do the work ½ Δp Σ Kᵢ xᵢ² on the
//! bristles, which nothing in a mechanism supplies: a contact that is deflected under a small load
//! and released under a large one would be an engine. In a real contact asperities that come into
//! contact come unstretched, and those that leave take their energy with them. On a change of the
//! normal force from p to p' ([`Contact::reload`]), for each spring,
//!
//! x' = x min(1, p/p'),  W' = W min(p, p')/max(p, p') ≤ W.
//!
//! Along a smooth p(t) ([`Load`], [`Bristle::response_under`](crate::Bristle::response_under))
//!
//! ẋ = (ẋ of the model) − (max(ṗ, 0)/p) x,
//!
//! where the dashpot beside the springs follows the model's part alone. A passive model stays
//! passive for every p(t) ≥ 0: F v − Ẇ is the dissipation of the model plus ½ |ṗ| Σ Kᵢ xᵢ².
//!
//! A stuck bristle keeps its force while the load rises and the ratio F/p while it falls, as in the
//! theory of Cattaneo, Mindlin and Deresiewicz. The limits of deflection and force hold for every
//! p(t), too.
//!
//! A load that oscillates makes a stuck body creep, as vibration does: each rise from p to p' and
//! back takes the share 1 − p/p' of the deflection, which the body has to make up for.
//!
//! Source: R. D. Mindlin, H. Deresiewicz, "Elastic spheres in contact under varying oblique
//! forces", Journal of Applied Mechanics 20 (1953), for the stuck bristle; the energy is derived
//! here.

use crate::parameter::{self, ParameterError};
use crate::rheology::Deflection;
use crate::scalar::{is_zero, lit, nan};
use crate::{Bristle, Linearised, Scalar, Surface};

/// A friction model M under a normal force: the friction element of a mechanism.
///
/// Velocities may be as large as parameters, 1e100 m/s (`f32`: 1e15). Far beyond, where σ1|v|,
/// σ0|v|/μ or a regularised |v| overflows, forces and steps are not finite.
///
/// ```
/// use bristle::{Bristle, Dahl, DahlParameters};
///
/// let friction = Dahl::new(DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: 1e4 })?;
/// let contact = friction.under_load(20.0)?;
/// // One step of a control loop at 1 kHz: 0.1 m/s for 1 ms, from rest.
/// let step = contact.hold(0.1, 0.0, 1e-3);
/// assert!(step.end_force < 10.0 && step.mean_force < step.end_force);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Contact<T, M> {
    model: M,
    normal_force: T,
}

/// Deflection rate and friction force at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactResponse<T, D = T> {
    /// Deflection rate ż [m/s].
    pub rate: D,
    /// Friction force F \[N\], positive against v > 0.
    pub force: T,
}

/// A [`ContactResponse`] with its partial derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearisedContact<T: Scalar, D: Deflection<T> = T> {
    /// Deflection rate ż [m/s].
    pub rate: D,
    /// Friction force F \[N\].
    pub force: T,
    /// ∂ż/∂z [1/s].
    pub rate_by_deflection: D::Relaxation,
    /// ∂ż/∂v \[–\].
    pub rate_by_velocity: D,
    /// ∂F/∂z [N/m].
    pub force_by_deflection: D,
    /// ∂F/∂v [N s/m].
    pub force_by_velocity: T,
}

/// The result of an exact step at a held velocity, from [`Contact::hold`].
#[must_use]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeldContact<T, D = T> {
    /// Deflection at the end of the step \[m\].
    pub deflection: D,
    /// Friction force at the end of the step \[N\]: what a sensor would read.
    pub end_force: T,
    /// Friction force averaged over the step \[N\]: h times it is the impulse, v h times it the
    /// work.
    pub mean_force: T,
}

/// Bounds of a contact for a range of velocities, proved by theorems, from [`Contact::limits`].
/// `None` where the model has no such theorem, or only an infinite limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactLimits<T> {
    /// Upper bound of |z| \[m\], see [`Limits::deflection`](crate::Limits::deflection).
    pub deflection: Option<T>,
    /// Upper bound of |F| \[N\], see [`Limits::coefficient`](crate::Limits::coefficient).
    pub force: Option<T>,
    /// Upper bound of λ [1/s], see [`Limits::relaxation_rate`](crate::Limits::relaxation_rate).
    pub relaxation_rate: Option<T>,
}

/// The result of a change of the normal force, from [`Contact::reload`].
#[must_use = "the deflection has changed with the load"]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reloaded<T, D = T> {
    /// Deflection under the new normal force \[m\].
    pub deflection: D,
    /// Energy \[J\] that left with the asperities, zero or positive: dissipated, no work of the
    /// mechanism.
    pub dissipated: T,
}

/// A normal force that varies, at one instant: for systems whose load is a function of time or
/// state, see [`Bristle::response_under`](crate::Bristle::response_under).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Load<T> {
    /// Normal force p \[N\], zero or positive.
    pub normal_force: T,
    /// Its rate of change ṗ along the motion [N/s].
    pub rate: T,
}

impl<T: Scalar> Load<T> {
    /// What the asperities that come into contact add to the rate of a deflection \[m/s\]:
    /// −(max(ṗ, 0)/p) x for each spring. Infinite where p = 0, ṗ > 0 and x ≠ 0: a contact that
    /// touches again has lost its deflection. NaN for a negative normal force.
    #[inline]
    pub fn renewal<D: Deflection<T>>(&self, deflection: D) -> D {
        let Self { normal_force, rate } = *self;
        let zero = T::zero();
        let pace = if !(normal_force >= zero) {
            nan()
        } else if rate > zero {
            rate / normal_force
        } else {
            // Zero, or NaN.
            rate * zero
        };
        let touches = pace > zero && !pace.is_finite();
        deflection.each(|x| if touches && is_zero(x) { x } else { -pace * x })
    }
}

/// What a change of the load from p to p' leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadChange<T> {
    /// The share of each deflection that is kept, min(1, p/p').
    pub kept: T,
    /// The share of the stored energy that leaves, |p' − p|/max(p, p').
    pub lost: T,
}

impl<T: Scalar> LoadChange<T> {
    /// From one valid normal force to another.
    #[inline]
    pub fn new(from: T, to: T) -> Self {
        let zero = T::zero();
        if is_zero(from) || is_zero(to) {
            return Self { kept: zero, lost: T::one() };
        }
        if to > from {
            Self { kept: from / to, lost: (to - from) / to }
        } else {
            Self { kept: T::one(), lost: (from - to) / from }
        }
    }
}

impl<T: Scalar, M> Contact<T, M> {
    /// A model under a normal force p \[N\], zero or positive.
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite.
    pub fn new(model: M, normal_force: T) -> Result<Self, ParameterError> {
        let normal_force = parameter::non_negative("normal_force", normal_force)?;
        Ok(Self { model, normal_force })
    }

    /// The friction model.
    pub fn model(&self) -> &M {
        &self.model
    }

    /// The normal force p \[N\].
    pub fn normal_force(&self) -> T {
        self.normal_force
    }

    /// Another model under the same normal force.
    #[inline]
    pub fn with_model<N>(&self, model: N) -> Contact<T, N> {
        Contact { model, normal_force: self.normal_force }
    }

    /// Changes the normal force to p' \[N\] and returns what a deflection has to follow, for a
    /// contact of your own that is made of others; see [`Contact::reload`].
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite; the contact is as it was.
    #[inline]
    pub fn change_load(&mut self, normal_force: T) -> Result<LoadChange<T>, ParameterError> {
        let normal_force = parameter::non_negative("normal_force", normal_force)?;
        let change = LoadChange::new(self.normal_force, normal_force);
        self.normal_force = normal_force;
        Ok(change)
    }
}

impl<T: Scalar, M: Bristle<T>> Contact<T, M> {
    /// Changes the normal force to p' \[N\], zero or positive. Returns the deflection that is left
    /// of the given one, x' = x min(1, p/p'), and the energy that left with it.
    ///
    /// With p = 0 or p' = 0 the bristles forget: x' = 0. At p = 0 a step still moves the
    /// deflection, without force or energy; the next change discards it.
    ///
    /// For steps under a load that varies, take the load at the middle of each step and change it
    /// before the step: forces averaged over a step are then of second order in its length. The
    /// stored x belongs to the load at the last middle; at the time t at the end of that step it
    /// is x min(1, p/p(t)) with the contact's p. Read raw it is of first order.
    ///
    /// ```
    /// use bristle::{Bristle, Dahl, DahlParameters};
    ///
    /// let dahl = DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: 1e4 };
    /// let mut contact = Dahl::new(dahl)?.under_load(1.0)?; // N
    /// let pulled = contact.reload(8.0, 4e-6)?;
    /// assert_eq!(pulled.deflection, 0.5e-6); // it keeps its force while the load rises,
    /// let released = contact.reload(1.0, pulled.deflection)?;
    /// assert_eq!(released.deflection, 0.5e-6); // and its deflection while the load falls.
    /// assert!(pulled.dissipated > 0.0 && released.dissipated > 0.0);
    /// # Ok::<(), bristle::ParameterError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite; the contact is as it was.
    #[doc(alias = "set_normal_force")]
    #[inline]
    pub fn reload(
        &mut self,
        normal_force: T,
        deflection: M::Deflection,
    ) -> Result<Reloaded<T, M::Deflection>, ParameterError> {
        let stored = self.stored_energy(deflection);
        let change = self.change_load(normal_force)?;
        Ok(Reloaded { deflection: deflection * change.kept, dissipated: change.lost * stored })
    }

    /// The deflection rate ż [m/s].
    #[inline]
    pub fn rate(&self, surface: impl Into<Surface<T>>, deflection: M::Deflection) -> M::Deflection {
        self.model.rate(surface, deflection)
    }

    /// The friction force F \[N\], positive against v > 0.
    #[inline]
    pub fn force(&self, surface: impl Into<Surface<T>>, deflection: M::Deflection) -> T {
        self.normal_force * self.model.coefficient(surface, deflection)
    }

    /// Rate and force at once.
    #[inline(always)]
    pub fn response(
        &self,
        surface: impl Into<Surface<T>>,
        deflection: M::Deflection,
    ) -> ContactResponse<T, M::Deflection> {
        let surface = surface.into();
        let affine = self.model.affine(surface, deflection);
        ContactResponse {
            rate: affine.rate(surface.velocity(), deflection),
            force: self.normal_force * affine.coefficient(surface.velocity(), deflection),
        }
    }

    /// Rate and force with all their partial derivatives.
    #[inline]
    pub fn linearised(
        &self,
        surface: impl Into<Surface<T>>,
        deflection: M::Deflection,
    ) -> LinearisedContact<T, M::Deflection> {
        self.loaded(self.model.linearised(surface, deflection))
    }

    /// Rate and force of steady sliding with all their partial derivatives, see
    /// [`Bristle::steady_linearised`].
    pub fn steady_linearised(
        &self,
        surface: impl Into<Surface<T>>,
    ) -> LinearisedContact<T, M::Deflection> {
        self.loaded(self.model.steady_linearised(surface))
    }

    #[inline]
    fn loaded(
        &self,
        linearised: Linearised<T, M::Deflection>,
    ) -> LinearisedContact<T, M::Deflection> {
        LinearisedContact {
            rate: linearised.rate,
            force: self.normal_force * linearised.coefficient,
            rate_by_deflection: linearised.rate_by_deflection,
            rate_by_velocity: linearised.rate_by_velocity,
            force_by_deflection: linearised.coefficient_by_deflection * self.normal_force,
            force_by_velocity: self.normal_force * linearised.coefficient_by_velocity,
        }
    }

    /// The stationary deflection of steady sliding at a velocity, z_ss = sgn_ε(v) μ(v)/σ0 \[m\].
    pub fn stationary(&self, surface: impl Into<Surface<T>>) -> M::Deflection {
        self.model.stationary(surface)
    }

    /// The friction force \[N\] of steady sliding at a velocity.
    pub fn stationary_force(&self, surface: impl Into<Surface<T>>) -> T {
        self.normal_force * self.model.stationary_coefficient(surface)
    }

    /// The energy stored in the bristles, W = ½ p Σ Kᵢ xᵢ² \[J\].
    pub fn stored_energy(&self, deflection: M::Deflection) -> T {
        let weighted = self.model.storage_stiffness().scaled_by(deflection);
        lit::<T>(0.5) * self.normal_force * weighted.inner_product(deflection)
    }

    /// The dissipated power F v − Ẇ \[W\]: never negative for a passive model.
    pub fn dissipated_power(&self, surface: impl Into<Surface<T>>, deflection: M::Deflection) -> T {
        let surface = surface.into();
        let affine = self.model.affine(surface, deflection);
        let stiffness = self.model.storage_stiffness();
        self.normal_force * affine.dissipation(stiffness, surface.velocity(), deflection)
    }

    /// The limits that the model's theorems give for velocities with |v| ≤ `fastest` [m/s].
    pub fn limits(&self, fastest: T) -> ContactLimits<T> {
        let limits = self.model.limits(fastest);
        ContactLimits {
            deflection: limits.deflection,
            force: limits.coefficient.map(|mu| mu * self.normal_force),
            relaxation_rate: limits.relaxation_rate,
        }
    }

    /// The exact step of length h ≥ 0 \[s\] at a held velocity [m/s] (zero-order hold); NaN for a
    /// negative length.
    ///
    /// If your simulation computes its velocity from this force, use [`Contact::companion`], which
    /// is stable for any step, or keep h below
    /// [`stability::largest_step`](crate::stability::largest_step) with
    /// [`Scheme::ExactHold`](crate::stability::Scheme::ExactHold). For a free mass m without damper
    /// or spring the limit is the smaller of 2σ1/σ0 and m/(σ1 p) \[s\]. A damper or spring changes
    /// it. Without any damping no step is stable. Beyond the limit a stuck mass slides under forces
    /// far below breakaway, with plausible numbers. The impulse on a mass is h times the mean
    /// force.
    ///
    /// The α of an elasto-plastic model is frozen at the beginning of the step. The tip of an
    /// [`ImplicitBristle`](crate::ImplicitBristle) is followed.
    #[doc(alias = "zero-order hold")]
    #[inline]
    pub fn hold(
        &self,
        velocity: T,
        deflection: M::Deflection,
        duration: T,
    ) -> HeldContact<T, M::Deflection> {
        let hold = self.model.hold(velocity, deflection, duration);
        HeldContact {
            deflection: hold.deflection,
            end_force: self.normal_force * hold.end_coefficient,
            mean_force: self.normal_force * hold.mean_coefficient,
        }
    }
}
