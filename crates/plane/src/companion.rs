//! The passive step of a contact of several axes: a source and a damper for each.
//!
//! F̄ᵢ = biasᵢ + dampingᵢ v̄ᵢ
//!
//! With all coefficients frozen at the predicted velocity the axes are scalar contacts, and each
//! takes the scalar [companion step](bristle::companion). So the damping is diagonal, and the
//! energy balance of every axis holds for every prediction and every length of the step.

use nalgebra::SVector;

use super::surface::norm;
use super::{PlaneBristle, PlaneContact};
use bristle::companion::{CompanionStep, CompletedStep, PointMass};
use bristle::parameter::{Checked, Named};
use bristle::{Reloaded, Scalar};

impl<T: Scalar, M: PlaneBristle<T, N>, const N: usize> PlaneContact<T, M, N> {
    /// Prepares the contact for passive steps inside a mechanism, with the limits of its
    /// deflections for speeds ‖v‖ up to `fastest` [m/s]. The speed need not be exact, see
    /// [`Contact::companion`](bristle::Contact::companion).
    ///
    /// # Errors
    ///
    /// Refuses a speed that is negative or not finite.
    pub fn companion(self, fastest: T) -> Checked<PlaneCompanion<T, M, N>> {
        let fastest = Named("fastest", fastest).non_negative()?;
        let limit = self.model().limits(fastest).deflection;
        let limit = limit.unwrap_or_else(|| SVector::repeat(T::unlimited()));
        Ok(PlaneCompanion { contact: self, fastest, limit })
    }
}

/// A [`PlaneContact`] prepared for passive steps inside a mechanism.
/// [`Companion`](bristle::companion::Companion) has the method, its order and what to predict.
///
/// A block of 1 kg that is pulled with 1 N, two thirds of breakaway, at 60 steps a second:
///
/// ```
/// use bristle::companion::PointMass;
/// use bristle::curve::Stribeck;
/// use bristle::nalgebra::Vector2;
/// use bristle::paper;
/// use bristle_plane::{PlaneBristle, PlaneFrBd};
/// use bristle::rheology::KelvinVoigt;
///
/// let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
/// let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
/// let friction = PlaneFrBd::isotropic(curve, bristle).under_load(1.0)?.companion(1.0)?;
/// let (pull, h) = (Vector2::new(0.6, 0.8), 1.0 / 60.0); // N, s
/// let (mut velocity, mut z) = (Vector2::zeros(), Vector2::zeros());
/// for _ in 0..600 {
///     let step = friction.step(&velocity, &z, h);
///     let mean = step.point_mass(PointMass {
///         mass: Vector2::repeat(1.0), // kg, along each axis
///         velocity,
///         force: pull,
///         end_weight: Vector2::repeat(1.0),
///     });
///     (velocity, z) = (mean, step.commit(&mean).deflection);
/// }
/// assert!(velocity.norm() < 1e-12); // it stands
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneCompanion<T: Scalar, M, const N: usize> {
    pub(super) contact: PlaneContact<T, M, N>,
    fastest: T,
    limit: SVector<T, N>,
}

impl<T: Scalar, M: PlaneBristle<T, N>, const N: usize> PlaneCompanion<T, M, N> {
    /// The contact.
    pub fn contact(&self) -> &PlaneContact<T, M, N> {
        &self.contact
    }

    /// Changes the normal force to p' \[N\], zero or positive, before a step: take the load at the
    /// middle of the step, and the velocity predicted for it. See [`PlaneContact::reload`].
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite; the companion is as it was.
    #[inline]
    pub fn reload(
        &mut self,
        normal_force: T,
        predicted_velocity: &SVector<T, N>,
        deflection: &SVector<T, N>,
    ) -> Checked<Reloaded<T, SVector<T, N>>> {
        self.contact.reload(normal_force, predicted_velocity, deflection)
    }

    /// The sources and the dampers that stand for the friction over a step of length h ≥ 0 \[s\],
    /// from a deflection z₀ \[m\] and a velocity v\* [m/s] predicted for the middle of the step.
    /// NaN for h < 0.
    ///
    /// For second order take v\* from one [`VelocityHistory`](bristle::companion::VelocityHistory)
    /// for each axis, and v̄ as the mean of both ends (weight ½). In an engine of semi-implicit
    /// Euler v̄ is the velocity at the end (weight 1), and v\* that at the beginning will do: first
    /// order.
    #[inline(always)]
    pub fn step(
        &self,
        predicted_velocity: &SVector<T, N>,
        deflection: &SVector<T, N>,
        duration: T,
    ) -> PlaneCompanionStep<T, N> {
        // An axis is slow beside its speed limit where the body is fast.
        let fast = norm(predicted_velocity) > self.fastest;
        let fastest = if fast { T::zero() } else { self.fastest };
        // Loops, here and below, because closures of this size are not inlined.
        let mut axes = [CompanionStep::default(); N];
        let inputs = predicted_velocity.iter().zip(deflection).zip(&self.limit);
        let contacts = self.contact.axes(predicted_velocity);
        for ((step, contact), ((&v, &z), &limit)) in axes.iter_mut().zip(contacts).zip(inputs) {
            *step = contact.companion_within(fastest, limit).step(v, z, duration);
        }
        PlaneCompanionStep { axes }
    }
}

/// Friction over one step on N axes, F̄ᵢ = biasᵢ + dampingᵢ v̄ᵢ, and what becomes of the
/// deflections once v̄ is known.
#[must_use]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneCompanionStep<T: Scalar, const N: usize> {
    axes: [CompanionStep<T>; N],
}

/// A step of no contact: what a buffer is filled with.
impl<T: Scalar, const N: usize> Default for PlaneCompanionStep<T, N> {
    fn default() -> Self {
        Self { axes: [CompanionStep::default(); N] }
    }
}

impl<T: Scalar, const N: usize> PlaneCompanionStep<T, N> {
    /// The step of each axis.
    pub fn axes(&self) -> &[CompanionStep<T>; N] {
        &self.axes
    }

    /// Mean friction force \[N\] if the mean velocity is zero.
    #[inline(always)]
    pub fn bias(&self) -> SVector<T, N> {
        SVector::from_fn(|i, _| self.axes[i].bias())
    }

    /// Diagonal of the damping [N s/m]: zero or positive.
    #[inline(always)]
    pub fn damping(&self) -> SVector<T, N> {
        SVector::from_fn(|i, _| self.axes[i].damping())
    }

    /// Mean friction force F̄ \[N\] for a mean velocity v̄ [m/s].
    #[inline(always)]
    pub fn force(&self, mean_velocity: &SVector<T, N>) -> SVector<T, N> {
        SVector::from_fn(|i, _| self.axes[i].force(mean_velocity[i]))
    }

    /// The mean velocity v̄ [m/s] of a free body under this friction and known forces, as
    /// [`CompanionStep::point_mass`]; each axis has its own mass, that of R ω being J/R².
    /// NaN along an axis whose mass is infinite.
    #[inline(always)]
    pub fn point_mass(&self, body: PointMass<SVector<T, N>>) -> SVector<T, N> {
        let PointMass { mass, velocity, force, end_weight } = body;
        SVector::from_fn(|i, _| {
            self.axes[i].point_mass(PointMass {
                mass: mass[i],
                velocity: velocity[i],
                force: force[i],
                end_weight: end_weight[i],
            })
        })
    }

    /// Whether this step dissipates for every deflection and every mean velocity.
    pub fn is_passive(&self) -> bool {
        self.axes.iter().all(CompanionStep::is_passive)
    }

    /// Ends the step with the mean velocity v̄ [m/s] that the mechanism has found.
    #[inline(always)]
    pub fn commit(
        &self,
        mean_velocity: &SVector<T, N>,
    ) -> CompletedStep<T, SVector<T, N>, SVector<T, N>> {
        let ([work, stored, dissipated], zeros) = ([T::zero(); 3], SVector::<T, N>::zeros());
        let mut done = CompletedStep { deflection: zeros, force: zeros, work, stored, dissipated };
        let results = done.deflection.iter_mut().zip(done.force.iter_mut());
        for ((axis, &v), (deflection, force)) in self.axes.iter().zip(mean_velocity).zip(results) {
            let step = axis.commit(v);
            (*deflection, *force) = (step.deflection, step.force);
            done.work += step.work;
            done.stored += step.stored;
            done.dissipated += step.dissipated;
        }
        done
    }
}
