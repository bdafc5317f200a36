//! A friction model under a normal force: forces in newtons, energies in joules.
//!
//! F = p μ_b,  W = ½ p Σ Kᵢ xᵢ²
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | p | normal force | N |
//! | F | friction force on the body, positive against v > 0: m v̇ = … − F | N |
//! | W | energy stored in the bristles | J |

use crate::parameter::{self, ParameterError};
use crate::rheology::Deflection;
use crate::scalar::lit;
use crate::{Bristle, Linearised, Scalar, Sliding};

/// A friction model M under a normal force: the friction element of a mechanism.
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
pub struct Contact<T, M> {
    model: M,
    normal_force: T,
}

/// Deflection rate and friction force at one instant.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactResponse<T, D = T> {
    /// Deflection rate ż [m/s].
    pub rate: D,
    /// Friction force F \[N\], positive against v > 0.
    pub force: T,
}

/// A [`ContactResponse`] with its partial derivatives.
#[non_exhaustive]
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
#[non_exhaustive]
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
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactLimits<T> {
    /// Upper bound of |z| \[m\], see [`Limits::deflection`](crate::Limits::deflection).
    pub deflection: Option<T>,
    /// Upper bound of |F| \[N\], see [`Limits::coefficient`](crate::Limits::coefficient).
    pub force: Option<T>,
    /// Upper bound of λ [1/s], see [`Limits::relaxation_rate`](crate::Limits::relaxation_rate).
    pub relaxation_rate: Option<T>,
}

impl<T: Scalar, M: Bristle<T>> Contact<T, M> {
    /// A model under a normal force p \[N\], zero or positive.
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite.
    pub fn new(model: M, normal_force: T) -> Result<Self, ParameterError> {
        let normal_force = parameter::non_negative("normal_force", normal_force)?;
        Ok(Self { model, normal_force })
    }

    /// The contact under another normal force \[N\], zero or positive.
    ///
    /// A change of the normal force by Δp does the work ½ Δp Σ Kᵢ xᵢ² on the bristles, which an
    /// energy balance has to count.
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite.
    pub fn with_normal_force(self, normal_force: T) -> Result<Self, ParameterError> {
        Self::new(self.model, normal_force)
    }

    /// The friction model.
    pub fn model(&self) -> &M {
        &self.model
    }

    /// The normal force p \[N\].
    pub fn normal_force(&self) -> T {
        self.normal_force
    }

    /// The deflection rate ż [m/s].
    #[inline]
    pub fn rate(&self, sliding: impl Into<Sliding<T>>, deflection: M::Deflection) -> M::Deflection {
        self.model.rate(sliding, deflection)
    }

    /// The friction force F \[N\], positive against v > 0.
    #[inline]
    pub fn force(&self, sliding: impl Into<Sliding<T>>, deflection: M::Deflection) -> T {
        self.normal_force * self.model.coefficient(sliding, deflection)
    }

    /// Rate and force at once.
    #[inline]
    pub fn response(
        &self,
        sliding: impl Into<Sliding<T>>,
        deflection: M::Deflection,
    ) -> ContactResponse<T, M::Deflection> {
        let sliding = sliding.into();
        let affine = self.model.affine(sliding, deflection);
        ContactResponse {
            rate: affine.rate(sliding.velocity(), deflection),
            force: self.normal_force * affine.coefficient(sliding.velocity(), deflection),
        }
    }

    /// Rate and force with all their partial derivatives.
    #[inline]
    pub fn linearised(
        &self,
        sliding: impl Into<Sliding<T>>,
        deflection: M::Deflection,
    ) -> LinearisedContact<T, M::Deflection> {
        self.loaded(self.model.linearised(sliding, deflection))
    }

    /// Rate and force of steady sliding with all their partial derivatives, see
    /// [`Bristle::steady_linearised`].
    pub fn steady_linearised(
        &self,
        sliding: impl Into<Sliding<T>>,
    ) -> LinearisedContact<T, M::Deflection> {
        self.loaded(self.model.steady_linearised(sliding))
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
    pub fn stationary(&self, sliding: impl Into<Sliding<T>>) -> M::Deflection {
        self.model.stationary(sliding)
    }

    /// The friction force \[N\] of steady sliding at a velocity.
    pub fn stationary_force(&self, sliding: impl Into<Sliding<T>>) -> T {
        self.normal_force * self.model.stationary_coefficient(sliding)
    }

    /// The energy stored in the bristles, W = ½ p Σ Kᵢ xᵢ² \[J\].
    pub fn stored_energy(&self, deflection: M::Deflection) -> T {
        let weighted = self.model.storage_stiffness().scaled_by(deflection);
        lit::<T>(0.5) * self.normal_force * weighted.dot(deflection)
    }

    /// The dissipated power F v − Ẇ \[W\]: never negative for a passive model.
    pub fn dissipated_power(&self, sliding: impl Into<Sliding<T>>, deflection: M::Deflection) -> T {
        let sliding = sliding.into();
        let affine = self.model.affine(sliding, deflection);
        let stiffness = self.model.storage_stiffness();
        self.normal_force * affine.dissipation(stiffness, sliding.velocity(), deflection)
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
