//! A bristle of several axes under a normal force: forces in newtons, energies in joules.
//!
//! Fᵢ = p μ_bᵢ,  W = ½ p Σ σ0ᵢ zᵢ²

use nalgebra::{SMatrix, SVector};

use super::PlaneBristle;
use bristle::parameter::Checked;
use bristle::scalar::{is_zero, lit};
use bristle::{
    Bristle, Contact, ContactResponse, HeldContact, LoadChange, Reloaded, Scalar, Surface,
};

/// A model of N axes under a normal force. Its methods are those of [`Contact`], with a vector for
/// the velocity, the deflection and the force.
///
/// ```
/// use bristle::curve::Stribeck;
/// use bristle::nalgebra::Vector2;
/// use bristle::paper;
/// use bristle_plane::{Axis, PlaneBristle, PlaneFrBd};
/// use bristle::rheology::KelvinVoigt;
///
/// let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
/// let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
/// // A ski: a tenth of the friction along it.
/// let [along, across] = [0.1, 1.0].map(|friction_ratio| Axis { friction_ratio, bristle });
/// let ski = PlaneFrBd::new(curve, [along, across])?.under_load(400.0)?; // N
/// // One exact step of 1 ms, held at 0.2 and 0.1 m/s, from rest.
/// let step = ski.hold(&Vector2::new(0.2, 0.1), &Vector2::zeros(), 1e-3);
/// assert!(step.mean_force.x < 0.1 * step.mean_force.y);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(transparent))]
#[cfg_attr(
    feature = "serde",
    serde(bound(deserialize = "T: Scalar + serde::Deserialize<'de>, M: serde::Deserialize<'de>"))
)]
pub struct PlaneContact<T, M, const N: usize> {
    contact: Contact<T, M>,
}

/// Rate and force of a [`PlaneContact`] at one instant, with their partial derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearisedPlane<T: Scalar, const N: usize> {
    /// Deflection rate ż [m/s].
    pub rate: SVector<T, N>,
    /// Friction force F \[N\].
    pub force: SVector<T, N>,
    /// ∂żᵢ/∂zᵢ [1/s]; all others are zero.
    pub rate_by_deflection: SVector<T, N>,
    /// ∂żᵢ/∂vⱼ \[–\].
    pub rate_by_velocity: SMatrix<T, N, N>,
    /// ∂Fᵢ/∂zᵢ [N/m]; all others are zero.
    pub force_by_deflection: SVector<T, N>,
    /// ∂Fᵢ/∂vⱼ [N s/m].
    pub force_by_velocity: SMatrix<T, N, N>,
}

/// The result of [`PlaneContact::turn`].
#[must_use = "the deflection has been turned"]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turned<T: Scalar, const N: usize> {
    /// The turned deflection \[m\].
    pub deflection: SVector<T, N>,
    /// Change of the stored energy \[J\], which the mechanism that turns the contact supplies. Zero
    /// for equal stiffnesses in the turned plane, NaN if the deflection is not finite.
    pub supplied: T,
}

impl<T: Scalar, M: PlaneBristle<T, N>, const N: usize> PlaneContact<T, M, N> {
    /// A model under a normal force p \[N\], zero or positive.
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite.
    pub fn new(model: M, normal_force: T) -> Checked<Self> {
        Ok(Self { contact: Contact::new(model, normal_force)? })
    }

    /// Changes the normal force to p' \[N\], zero or positive, before a step. Returns what is left
    /// of a deflection, and the energy that is dissipated, see [`Contact::reload`]: if the load
    /// falls below what the bristles carry at the `velocity` [m/s], they slip back in the direction
    /// of the deflection.
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite; the contact is as it was.
    #[inline]
    pub fn reload(
        &mut self,
        normal_force: T,
        velocity: &SVector<T, N>,
        deflection: &SVector<T, N>,
    ) -> Checked<Reloaded<T, SVector<T, N>>> {
        let change = self.contact.change_load(normal_force)?;
        Ok(self.held(change, velocity, deflection))
    }

    /// Changes the normal force; a deflection has to follow by [`PlaneContact::held`].
    pub(crate) fn change_load(&mut self, normal_force: T) -> Checked<LoadChange<T>> {
        self.contact.change_load(normal_force)
    }

    /// What the surface still holds of a deflection after a change of the load.
    pub(crate) fn held(
        &self,
        change: LoadChange<T>,
        velocity: &SVector<T, N>,
        deflection: &SVector<T, N>,
    ) -> Reloaded<T, SVector<T, N>> {
        if change.after >= change.before {
            return Reloaded { deflection: *deflection, dissipated: T::zero() };
        }
        let limits = self.model().limits(velocity.norm());
        let kept = change.kept(limits.utilisation(deflection, self.contact.friction_scale()));
        let dissipated = self.stored_energy(deflection) * (T::one() - kept) * (T::one() + kept);
        Reloaded { deflection: deflection * kept, dissipated }
    }

    /// Changes the normal force by renewal, see [`Contact::renew`].
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite; the contact is as it was.
    #[inline]
    pub fn renew(
        &mut self,
        normal_force: T,
        deflection: &SVector<T, N>,
    ) -> Checked<Reloaded<T, SVector<T, N>>> {
        let stored = self.stored_energy(deflection);
        let (kept, lost) = self.contact.renew_load(normal_force)?.renewed();
        Ok(Reloaded { deflection: deflection * kept, dissipated: lost * stored })
    }

    /// Rate and force under a normal force p \[N\] that varies, at one instant, see
    /// [`Contact::response_under`].
    pub fn response_under(
        &self,
        normal_force: T,
        velocity: &SVector<T, N>,
        deflection: &SVector<T, N>,
    ) -> ContactResponse<SVector<T, N>> {
        let mut loaded = self.clone();
        if loaded.change_load(normal_force).is_err() {
            let none = SVector::repeat(T::nan());
            return ContactResponse { rate: none, force: none };
        }
        let limits = self.model().limits(velocity.norm());
        let utilisation = limits.utilisation(deflection, loaded.contact.friction_scale());
        let excess = if utilisation > T::one() { utilisation } else { T::one() };
        let [rate, force] = loaded
            .each(velocity, deflection, |axis, v, z| [axis.rate(v, z), axis.force(v, z / excess)]);
        ContactResponse { rate, force }
    }

    /// The friction model.
    pub fn model(&self) -> &M {
        self.contact.model()
    }

    /// The normal force p \[N\].
    pub fn normal_force(&self) -> T {
        self.contact.normal_force()
    }

    /// The contact whose stiffness and damping belong to another load, see
    /// [`Contact::measured_at`].
    ///
    /// # Errors
    ///
    /// Refuses a reference load that is not positive and finite.
    pub fn measured_at(self, reference_load: T) -> Checked<Self> {
        Ok(Self { contact: self.contact.measured_at(reference_load)? })
    }

    /// Each axis at a velocity [m/s]: a scalar contact, to be evaluated at that axis's component.
    #[inline(always)]
    pub fn axes(&self, velocity: &SVector<T, N>) -> [Contact<T, M::Axis>; N] {
        self.model().axes(velocity).map(|axis| self.contact.with_model(axis))
    }

    /// The deflection rate ż [m/s].
    #[inline]
    pub fn rate(&self, velocity: &SVector<T, N>, deflection: &SVector<T, N>) -> SVector<T, N> {
        self.response(velocity, deflection).rate
    }

    /// The friction force F \[N\] on the body: m v̇ = … − F.
    #[inline]
    pub fn force(&self, velocity: &SVector<T, N>, deflection: &SVector<T, N>) -> SVector<T, N> {
        self.response(velocity, deflection).force
    }

    /// Rate and force at once.
    #[inline(always)]
    pub fn response(
        &self,
        velocity: &SVector<T, N>,
        deflection: &SVector<T, N>,
    ) -> ContactResponse<SVector<T, N>> {
        let [rate, force] = self.each(velocity, deflection, |axis, v, z| {
            let ContactResponse { rate, force } = axis.response(v, z);
            [rate, force]
        });
        ContactResponse { rate, force }
    }

    /// Some numbers of each axis, from its velocity and deflection, as vectors.
    #[inline(always)]
    fn each<const K: usize>(
        &self,
        velocity: &SVector<T, N>,
        deflection: &SVector<T, N>,
        of: impl Fn(&Contact<T, M::Axis>, T, T) -> [T; K],
    ) -> [SVector<T, N>; K] {
        let mut all = [SVector::zeros(); K];
        for (i, axis) in self.axes(velocity).iter().enumerate() {
            let numbers = of(axis, velocity[i], deflection[i]);
            all.iter_mut().zip(numbers).for_each(|(vector, number)| vector[i] = number);
        }
        all
    }

    /// Rate and force with all their partial derivatives.
    #[inline(always)]
    pub fn linearised(
        &self,
        velocity: &SVector<T, N>,
        deflection: &SVector<T, N>,
    ) -> LinearisedPlane<T, N> {
        let (p, zeros) = (self.contact.reference_load(), SVector::zeros());
        let mut linearised = LinearisedPlane {
            rate: zeros,
            force: zeros,
            rate_by_deflection: zeros,
            rate_by_velocity: SMatrix::zeros(),
            force_by_deflection: zeros,
            force_by_velocity: SMatrix::zeros(),
        };
        let scale = self.contact.friction_scale();
        if is_zero(scale) {
            return linearised;
        }
        let (axes, gradient) = self.model().axes_and_slopes(velocity);
        let (mut rate_slope, mut force_slope) = (zeros, zeros);
        for i in 0..N {
            let (v, z) = (velocity[i], deflection[i]);
            let (affine, slopes) = axes[i].affine_and_slopes(Surface::scaled(v, scale), z);
            linearised.rate[i] = affine.rate(v, z);
            linearised.force[i] = p * affine.coefficient(v, z);
            linearised.rate_by_deflection[i] = -affine.relaxation;
            linearised.force_by_deflection[i] = affine.stiffness * p;
            linearised.rate_by_velocity[(i, i)] = affine.drive;
            linearised.force_by_velocity[(i, i)] = affine.damping;
            (rate_slope[i], force_slope[i]) = (slopes.rate(v, z), slopes.coefficient(v, z));
        }
        linearised.rate_by_velocity += rate_slope * gradient.transpose();
        linearised.force_by_velocity += force_slope * gradient.transpose();
        linearised.force_by_velocity *= p;
        linearised
    }

    /// The deflection of steady sliding at a velocity, aᵢ² s μ vᵢ/(σ0ᵢ n) \[m\]; zero at rest.
    pub fn stationary(&self, velocity: &SVector<T, N>) -> SVector<T, N> {
        let [stationary] = self.each(velocity, velocity, |axis, v, _| [axis.stationary(v)]);
        stationary
    }

    /// The friction force \[N\] of steady sliding at a velocity; zero at rest.
    pub fn stationary_force(&self, velocity: &SVector<T, N>) -> SVector<T, N> {
        let [force] = self.each(velocity, velocity, |axis, v, _| [axis.stationary_force(v)]);
        force
    }

    /// The stored energy W = ½ P Σ σ0ᵢ zᵢ² \[J\], with the reference load P.
    pub fn stored_energy(&self, deflection: &SVector<T, N>) -> T {
        let weighted = self.model().storage_stiffness().component_mul(deflection);
        lit::<T>(0.5) * self.contact.reference_load() * weighted.dot(deflection)
    }

    /// The dissipated power F·v − Ẇ \[W\]: never negative for a passive model.
    pub fn dissipated_power(&self, velocity: &SVector<T, N>, deflection: &SVector<T, N>) -> T {
        let [power] = self.each(velocity, deflection, |axis, v, z| [axis.dissipated_power(v, z)]);
        power.iter().fold(T::zero(), |sum, &power| sum + power)
    }

    /// The exact step of length h ≥ 0 \[s\] at a held velocity [m/s] (zero-order hold); NaN for a
    /// negative length. See [`Contact::hold`] for where it serves and where it does not.
    #[doc(alias = "zero-order hold")]
    #[inline(always)]
    pub fn hold(
        &self,
        velocity: &SVector<T, N>,
        deflection: &SVector<T, N>,
        duration: T,
    ) -> HeldContact<SVector<T, N>> {
        let [deflection, end_force, mean_force] = self.each(velocity, deflection, |axis, v, z| {
            let held = axis.hold(v, z, duration);
            [held.deflection, held.end_force, held.mean_force]
        });
        HeldContact { deflection, end_force, mean_force }
    }

    /// Turns the bristles by an angle \[rad\] about the normal, from the first axis towards the
    /// second: z ← R z.
    ///
    /// It is for a body that carries its bristles along as it turns, against the axes in which
    /// velocities and deflections are given. If these axes turn and the bristles do not, give the
    /// opposite angle. Velocities in axes that the body carries need neither. With one axis nothing
    /// turns.
    pub fn turn(&self, deflection: &SVector<T, N>, angle: T) -> Turned<T, N> {
        let stiffness = self.model().storage_stiffness();
        let mut turned = *deflection;
        let mut supplied = T::zero();
        if let ([x, y, ..], [k, l, ..]) = (turned.as_mut_slice(), stiffness.as_slice()) {
            let (sin, cos) = angle.sin_cos();
            (*x, *y) = (cos * *x - sin * *y, sin * *x + cos * *y);
            // What is not finite has no energy: the difference is NaN.
            if k != l || turned.iter().any(|z| !z.is_finite()) {
                supplied = self.stored_energy(&turned) - self.stored_energy(deflection);
            }
        }
        Turned { deflection: turned, supplied }
    }
}
