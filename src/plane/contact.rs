//! A bristle of several axes under a normal force, and its passive step inside a mechanism.

use nalgebra::{SMatrix, SVector};

use super::{LinearisedPlane, PlaneBristle};
use crate::companion::CompanionStep;
use crate::parameter::{self, ParameterError};
use crate::scalar::{is_zero, lit, nan};
use crate::{Affine, HeldContact, Scalar};

/// Limits of a [`PlaneBristle`] for a range of speeds. `None` where there is no theorem.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneLimits<T: Scalar, const N: usize> {
    /// |zᵢ| ≤ this \[m\], if it begins so.
    pub deflection: Option<SVector<T, N>>,
    /// |Fᵢ|/p ≤ this \[–\] within the limits of the deflection.
    pub coefficient: Option<SVector<T, N>>,
    /// Whether the deflection also stays within the ellipsoid with these semi-axes.
    pub ellipsoid: bool,
}

impl<T: Scalar, const N: usize> PlaneLimits<T, N> {
    pub(super) fn none() -> Self {
        Self { deflection: None, coefficient: None, ellipsoid: false }
    }
}

/// A model of several axes under a normal force: forces in newtons, energies in joules.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneContact<T, M, const N: usize> {
    model: M,
    normal_force: T,
}

/// A deflection in turned axes.
#[must_use]
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turned<T: Scalar, const N: usize> {
    /// The deflection in the new axes \[m\].
    pub deflection: SVector<T, N>,
    /// Change of the stored energy \[J\], zero for equal stiffnesses in the turned plane. The
    /// mechanism that turns the contact supplies it.
    pub energy_change: T,
}

impl<T: Scalar, M: PlaneBristle<T, N>, const N: usize> PlaneContact<T, M, N> {
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

    /// The deflection rate ż [m/s].
    pub fn rate(&self, velocity: &SVector<T, N>, deflection: &SVector<T, N>) -> SVector<T, N> {
        self.model.rate(velocity, deflection)
    }

    /// The friction force F \[N\]: m v̇ = … − F.
    pub fn force(&self, velocity: &SVector<T, N>, deflection: &SVector<T, N>) -> SVector<T, N> {
        self.model.coefficient(velocity, deflection) * self.normal_force
    }

    /// The force of steady sliding \[N\].
    pub fn stationary_force(&self, velocity: &SVector<T, N>) -> SVector<T, N> {
        self.force(velocity, &self.stationary(velocity))
    }

    /// The deflection of steady sliding, rᵢ vᵢ/λᵢ \[m\]; zero at rest.
    pub fn stationary(&self, velocity: &SVector<T, N>) -> SVector<T, N> {
        let axes = self.model.affine(velocity);
        SVector::from_fn(|i, _| {
            let Affine { relaxation, drive, .. } = axes[i];
            if is_zero(velocity[i]) { T::zero() } else { drive * velocity[i] / relaxation }
        })
    }

    /// Rate, and force in newtons, with all their partial derivatives: a [`LinearisedPlane`] whose
    /// coefficients are multiplied by p.
    pub fn linearised(
        &self,
        velocity: &SVector<T, N>,
        deflection: &SVector<T, N>,
    ) -> LinearisedPlane<T, N> {
        let linearised = self.model.linearised(velocity, deflection);
        LinearisedPlane {
            coefficient: linearised.coefficient * self.normal_force,
            coefficient_by_deflection: linearised.coefficient_by_deflection * self.normal_force,
            coefficient_by_velocity: linearised.coefficient_by_velocity * self.normal_force,
            ..linearised
        }
    }

    /// The stored energy W = ½ p Σ σ0ᵢ zᵢ² \[J\].
    pub fn stored_energy(&self, deflection: &SVector<T, N>) -> T {
        let terms = self.model.axes().iter().zip(deflection.iter());
        let sum = terms.fold(T::zero(), |sum, (axis, &z)| sum + axis.micro_stiffness * z * z);
        lit::<T>(0.5) * self.normal_force * sum
    }

    /// The dissipated power F·v − Ẇ \[W\].
    pub fn dissipated_power(&self, velocity: &SVector<T, N>, deflection: &SVector<T, N>) -> T {
        let affine = self.model.affine(velocity);
        let axes = self.model.axes();
        let power =
            |i: usize| affine[i].dissipation(axes[i].micro_stiffness, velocity[i], deflection[i]);
        self.normal_force * (0..N).fold(T::zero(), |sum, i| sum + power(i))
    }

    /// The exact step of length h ≥ 0 \[s\] at a held velocity: one [`HeldContact`] for each axis.
    #[inline]
    pub fn hold(
        &self,
        velocity: &SVector<T, N>,
        deflection: &SVector<T, N>,
        duration: T,
    ) -> [HeldContact<T>; N] {
        let axes = self.model.affine(velocity);
        core::array::from_fn(|i| {
            let held = axes[i].hold(velocity[i], deflection[i], duration);
            HeldContact {
                deflection: held.deflection,
                end_force: self.normal_force * held.end_coefficient,
                mean_force: self.normal_force * held.mean_coefficient,
            }
        })
    }

    /// A deflection after the contact has turned by `angle` [rad] about its normal, from the old to
    /// the new direction of the first two axes.
    pub fn turn(&self, deflection: &SVector<T, N>, angle: T) -> Turned<T, N> {
        let mut turned = *deflection;
        if N >= 2 {
            let (sin, cos) = angle.sin_cos();
            turned[0] = cos * deflection[0] + sin * deflection[1];
            turned[1] = cos * deflection[1] - sin * deflection[0];
        }
        let stiffness = |axis: usize| self.model.axes().get(axis).map(|axis| axis.micro_stiffness);
        let energy_change = if stiffness(0) == stiffness(1) {
            T::zero()
        } else {
            self.stored_energy(&turned) - self.stored_energy(deflection)
        };
        Turned { deflection: turned, energy_change }
    }

    /// Makes the contact ready for passive steps inside a mechanism, with the deflections' limits
    /// for speeds up to `fastest` [m/s].
    ///
    /// # Errors
    ///
    /// Refuses a speed that is negative or not finite.
    pub fn companion(self, fastest: T) -> Result<PlaneCompanion<T, M, N>, ParameterError> {
        let fastest = parameter::non_negative("fastest", fastest)?;
        let limits = self.model.limits(fastest).deflection;
        let limit = limits.unwrap_or_else(|| SVector::repeat(crate::scalar::unlimited()));
        Ok(PlaneCompanion { contact: self, fastest, limit })
    }
}

/// A [`PlaneContact`] made ready for passive steps, see [`Companion`](crate::companion::Companion).
///
/// ```
/// use bristle::curve::Stribeck;
/// use bristle::paper;
/// use bristle::plane::{PlaneBristle, PlaneFrBd};
/// use nalgebra::Vector2;
///
/// let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
/// let block = PlaneFrBd::isotropic(curve, paper::STICK_SLIP_BRISTLE)?.under_load(1.0)?;
/// let friction = block.companion(1.0)?;
/// let (mass, pull, h) = (1.0, Vector2::new(0.6, 0.8), 1.0 / 60.0); // kg, N, s: below breakaway
/// let (mut v, mut z) = (Vector2::zeros(), Vector2::zeros());
/// for _ in 0..600 {
///     let step = friction.step(&v, &z, h);
///     let mean = step.point_mass(mass, &v, &pull);
///     (v, z) = (2.0 * mean - v, step.commit(&mean).deflection);
/// }
/// assert!(v.norm() < 1e-9);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneCompanion<T: Scalar, M, const N: usize> {
    contact: PlaneContact<T, M, N>,
    fastest: T,
    limit: SVector<T, N>,
}

impl<T: Scalar, M: PlaneBristle<T, N>, const N: usize> PlaneCompanion<T, M, N> {
    /// The contact.
    pub fn contact(&self) -> &PlaneContact<T, M, N> {
        &self.contact
    }

    /// The source and the damper of each axis that stand for the friction over a step of length h ≥
    /// 0 \[s\], from a deflection \[m\] and a velocity [m/s] predicted for the middle of the step.
    #[inline]
    pub fn step(
        &self,
        predicted_velocity: &SVector<T, N>,
        deflection: &SVector<T, N>,
        duration: T,
    ) -> PlaneCompanionStep<T, N> {
        let affine = self.contact.model.affine(predicted_velocity);
        let axes = self.contact.model.axes();
        // Nothing goes back in time.
        let duration = if duration >= T::zero() { duration } else { nan() };
        let fast = !(super::norm(predicted_velocity) <= self.fastest);
        let stationary =
            if fast { self.contact.stationary(predicted_velocity) } else { SVector::zeros() };
        PlaneCompanionStep {
            axes: core::array::from_fn(|i| {
                let bounds = [self.limit[i], deflection[i].abs(), stationary[i].abs()];
                CompanionStep::from_affine(
                    (affine[i], affine[i].weights(duration)),
                    (
                        axes[i].micro_stiffness,
                        bounds.into_iter().fold(T::zero(), crate::bounds::larger),
                    ),
                    None,
                    self.contact.normal_force,
                    (deflection[i], duration),
                )
            }),
        }
    }
}

/// Friction over one step on N axes: F̄ = bias + damping v̄ with a diagonal damping.
#[must_use]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneCompanionStep<T: Scalar, const N: usize> {
    axes: [CompanionStep<T>; N],
}

/// A [`PlaneCompanionStep`] that is done, with work = stored + dissipated up to rounding.
#[must_use]
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompletedPlaneStep<T: Scalar, const N: usize> {
    /// Deflection at the end of the step \[m\].
    pub deflection: SVector<T, N>,
    /// Friction force averaged over the step \[N\].
    pub force: SVector<T, N>,
    /// Work of the mechanism on the friction \[J\], h F̄·v̄.
    pub work: T,
    /// Change of the stored energy \[J\].
    pub stored: T,
    /// Dissipated energy \[J\].
    pub dissipated: T,
}

impl<T: Scalar, const N: usize> PlaneCompanionStep<T, N> {
    /// Mean friction force \[N\] if the mean velocity is zero.
    pub fn bias(&self) -> SVector<T, N> {
        SVector::from_fn(|i, _| self.axes[i].bias())
    }

    /// Diagonal of the damping [N s/m]: zero or positive.
    pub fn damping(&self) -> SVector<T, N> {
        SVector::from_fn(|i, _| self.axes[i].damping())
    }

    /// Mean friction force \[N\] for a mean velocity [m/s].
    pub fn force(&self, mean_velocity: &SVector<T, N>) -> SVector<T, N> {
        SVector::from_fn(|i, _| self.axes[i].force(mean_velocity[i]))
    }

    /// The mean velocity v̄ = (v₀ + v₁)/2 [m/s] of a free mass \[kg\] at a velocity v₀ [m/s], under
    /// this friction and other forces \[N\] averaged over the step. NaN for a negative mass.
    pub fn point_mass(
        &self,
        mass: T,
        velocity: &SVector<T, N>,
        force: &SVector<T, N>,
    ) -> SVector<T, N> {
        SVector::from_fn(|i, _| {
            self.axes[i].point_mass(crate::companion::PointMass {
                mass,
                velocity: velocity[i],
                force: force[i],
                end_weight: lit(0.5),
            })
        })
    }

    /// The mean velocity [m/s] of a body with a mass matrix \[kg\] whose axes are coupled, such as
    /// one that is pushed off its centre. `None` if the matrix is singular.
    pub fn body(
        &self,
        mass: &SMatrix<T, N, N>,
        velocity: &SVector<T, N>,
        force: &SVector<T, N>,
        duration: T,
    ) -> Option<SVector<T, N>> {
        let twice = lit::<T>(2.0) / duration;
        let matrix = mass * twice + SMatrix::from_diagonal(&self.damping());
        matrix
            .try_inverse()
            .map(|inverse| inverse * (mass * velocity * twice + force - self.bias()))
    }

    /// Ends the step with the mean velocity [m/s] that the mechanism has found.
    pub fn commit(&self, mean_velocity: &SVector<T, N>) -> CompletedPlaneStep<T, N> {
        let done: [_; N] = core::array::from_fn(|i| self.axes[i].commit(mean_velocity[i]));
        let sum = |part: fn(&crate::companion::CompletedStep<T>) -> T| {
            done.iter().fold(T::zero(), |sum, step| sum + part(step))
        };
        CompletedPlaneStep {
            deflection: SVector::from_fn(|i, _| done[i].deflection),
            force: SVector::from_fn(|i, _| done[i].force),
            work: sum(|step| step.work),
            stored: sum(|step| step.stored),
            dissipated: sum(|step| step.dissipated),
        }
    }
}
