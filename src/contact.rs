//! A friction model under a normal force, constant or not.

use crate::parameter::{Checked, Named};
use crate::rheology::Deflection;
use crate::scalar::{is_zero, lit};
use crate::{Affine, Bristle, Linearised, Scalar, Surface};

/// A friction model M under a normal force: the friction element of a mechanism, with forces in
/// newtons and energies in joules.
///
/// F = P μ_b,  W = ½ P Σ Kᵢ xᵢ²
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | F | friction force on the body, positive against v > 0: m v̇ = … − F | N |
/// | μ_b | virtual friction coefficient of the model, [`Bristle::coefficient`] | – |
/// | p | normal force | N |
/// | P | reference load, under which stiffness and damping were measured | N |
/// | s = p/P | friction scale, by which the load multiplies the friction curve in μ_b | – |
/// | xᵢ, Kᵢ | stretch of spring i, its stiffness; beside a dashpot z and σ0 | m, 1/m |
/// | W | energy stored in the bristles | J |
///
/// **If the load is constant, forget P and s:** [`Bristle::under_load`] makes P = p and s = 1.
///
/// Where a method takes `impl Into<Surface<T>>`, pass the velocity v: a plain number [m/s], or in
/// an [`ode::System`](crate::ode::System) the `branch.of(v)` of the solver.
///
/// Velocities may be as large as parameters, 1e100 m/s (`f32`: 1e15). Far beyond, where σ1|v|,
/// σ0|v|/μ or a regularised |v| overflows, forces and steps are not finite.
///
/// # A normal force that varies
///
/// Stiffness and damping stay those of the reference load P; the load p scales the friction curve
/// by s = p/P. For [`FrBd`](crate::FrBd):
///
/// F = P (σ0 z + σ1 ż),  ż = (s μ(v) v − σ0 |v| z)/(σ1 |v| + s μ(v))
///
/// Only [`LuGre`](crate::LuGre)'s damping follows the load, p σ1 and p σ2: with P σ1 the σ2 that
/// passivity needs would grow as 1/s.
///
/// The stored energy does not depend on p, so that a passive model stays passive for every p(t),
/// and a body that is held stands still while the grip varies. Steady sliding is p μ(v). When the
/// load falls below what a stuck bristle carries, the bristle slips back.
///
/// | method | take it if |
/// |---|---|
/// | [`reload`] | you make steps, and what is held must stand still: the usual case |
/// | [`reloaded`] | the same, but the contact serves many bristles, each with a load |
/// | [`change_load`] | the same, but one load bears on several deflections |
/// | [`renew`] | asperities come and go: bristles that enter a rolling contact |
/// | [`renew_load`] | the same, with several deflections |
/// | [`response_under`] | you make no steps: an `ode::System` has p(t) or p(x) |
///
/// The first three keep P. `reload` and `reloaded` return the deflection, kept as far as the
/// surface holds it, and the energy lost; `reloaded` leaves the contact as it is, and you keep the
/// load. `change_load`, as of a footprint or a patch, returns the [`LoadChange`], which you apply
/// to each deflection.
///
/// `renew` and `renew_load` let the stiffness follow the load: P becomes the new load. The force is
/// kept while the load rises, the deflection while it falls.
///
/// [`reload`]: Contact::reload
/// [`reloaded`]: Contact::reloaded
/// [`change_load`]: Contact::change_load
/// [`renew`]: Contact::renew
/// [`renew_load`]: Contact::renew_load
/// [`response_under`]: Contact::response_under
///
/// A load that is constant, but is not the one under which σ0 was measured, needs none of these:
/// give the other one once, by [`Contact::measured_at`].
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
    /// p
    normal_force: T,
    /// P
    reference_load: T,
    /// s = p/P
    #[cfg_attr(feature = "serde", serde(skip))]
    scale: T,
}

/// Deflection rate and friction force at one instant, from [`Contact::response`]:
/// F = P (c₀ z + c₂ v), with the reference load P (for a constant load the normal force) and the
/// coefficients of [`Affine`]. In a mechanism of your own z is a state with the rate ż, and
/// m v̇ = … − F: [`ode::System`](crate::ode::System) has an example.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactResponse<T, D = T> {
    /// Deflection rate ż [m/s]; of several springs, and of one that creeps, the rates of the
    /// stretches xᵢ.
    pub rate: D,
    /// Friction force F \[N\], positive against v > 0.
    pub force: T,
}

/// A [`ContactResponse`] with its partial derivatives: for the Jacobian of a mechanism of your own.
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

/// The result of a step at a held velocity, from [`Contact::hold`].
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

/// The result of a change of the normal force, from [`Contact::reload`], [`Contact::reloaded`] or
/// [`Contact::renew`].
#[must_use = "the deflection has changed with the load"]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reloaded<T, D = T> {
    /// Deflection under the new normal force \[m\].
    pub deflection: D,
    /// Energy \[J\] that the slip dissipates, or that leaves with the asperities where the contact
    /// is renewed: zero or positive, no work of the mechanism.
    pub dissipated: T,
}

/// A change of the normal force from p to p', from [`Contact::change_load`] or
/// [`Contact::renew_load`], or written down for [`Contact::reloaded`]. Where one load bears on
/// several deflections (a footprint, a patch), ask it what is left of each:
///
/// | method | after | you know |
/// |---|---|---|
/// | [`kept_by`](LoadChange::kept_by) | `change_load` | the model and the coefficient K·x |
/// | [`kept`](LoadChange::kept) | `change_load` | the utilisation |
/// | [`renewed`](LoadChange::renewed) | `renew_load` | nothing more: all keep the same share |
///
/// The springs of the model carry K·x. The utilisation is the carried coefficient divided by the
/// one that is held; over the axes of a plane it is the norm of these.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadChange<T> {
    /// The normal force p before \[N\].
    pub before: T,
    /// The normal force p' after \[N\].
    pub after: T,
}

impl<T: Scalar> LoadChange<T> {
    /// The share \[–\] that is left of what the bristles carry, min(1, max(1/γ, p'/p)), where the
    /// `utilisation` γ \[–\] is what they carry, divided by what the surface holds under the new
    /// load. All is left if the load rises, nothing without a load. Multiply a single deflection by
    /// it.
    #[inline]
    pub fn kept(&self, utilisation: T) -> T {
        let Self { before, after } = *self;
        // Also where nothing over nothing is carried.
        if is_zero(after) {
            return T::zero();
        }
        if after >= before || utilisation <= T::one() {
            return T::one();
        }
        // Of an infinite utilisation nothing is held.
        (T::one() / utilisation).larger(after / before)
    }

    /// The share \[–\] that is left of K·x = Σ Kᵢ xᵢ \[–\], which the springs of a model have
    /// `carried`: [`LoadChange::kept`] with γ = |K·x| over the [`Bristle::holding_coefficient`] of
    /// the `surface` after the change, that is of the velocity with the scale p'/P
    /// ([`Surface::scaled`]). Multiply the deflection of a single spring by it. Do not multiply
    /// several stretches: they all shift by the same length, see [`Contact::reloaded`].
    #[inline]
    pub fn kept_by<M: Bristle<T>>(&self, model: &M, surface: Surface<T>, carried: T) -> T {
        if self.after >= self.before {
            return T::one();
        }
        if is_zero(self.after) || is_zero(carried) {
            return self.kept(T::zero());
        }
        // At rest the curve is cheap, and mostly enough.
        let at_rest = Surface::scaled(T::zero(), surface.scale());
        if carried.abs() <= model.holding_coefficient(at_rest, carried)
            && surface.velocity().is_finite()
        {
            return T::one();
        }
        self.kept(carried.abs() / model.holding_coefficient(surface, carried))
    }

    /// By renewal, the share \[–\] of each deflection that is kept, min(1, p/p'), and the share of
    /// the stored energy that leaves, |p' − p|/max(p, p').
    #[inline]
    pub fn renewed(&self) -> (T, T) {
        let Self { before, after } = *self;
        if is_zero(before) || is_zero(after) {
            (T::zero(), T::one())
        } else if after > before {
            (before / after, (after - before) / after)
        } else {
            (T::one(), (before - after) / before)
        }
    }
}

impl<T: Scalar, M> Contact<T, M> {
    /// A model under a normal force p \[N\], zero or positive, which is also the reference load P:
    /// the same as [`Bristle::under_load`]. A contact made under no load has no P; give it one by
    /// [`Contact::measured_at`] before it is loaded.
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite.
    pub fn new(model: M, normal_force: T) -> Checked<Self> {
        let normal_force = Named("normal_force", normal_force).non_negative()?;
        Ok(Self { model, reference_load: normal_force, normal_force, scale: T::one() })
    }

    /// The contact whose stiffness and damping [1/m, s/m] were measured under another load P \[N\]
    /// than its normal force p: the bristles have P σ0 [N/m] and P σ1 [N s/m] (LuGre's p σ1, see
    /// [`Contact`]), and the friction is p μ(v). Call it once, after [`Bristle::under_load`].
    ///
    /// # Errors
    ///
    /// Refuses a reference load that is not positive and finite.
    pub fn measured_at(self, reference_load: T) -> Checked<Self> {
        let reference_load = Named("reference_load", reference_load).positive()?;
        let mut contact = Self { reference_load, ..self };
        contact.scale = contact.scale_under(contact.normal_force);
        Ok(contact)
    }

    /// The friction model.
    pub fn model(&self) -> &M {
        &self.model
    }

    /// The normal force p \[N\].
    pub fn normal_force(&self) -> T {
        self.normal_force
    }

    /// The reference load P \[N\], at which stiffness and damping were measured.
    pub fn reference_load(&self) -> T {
        self.reference_load
    }

    /// The friction scale s = p/P \[–\].
    pub fn friction_scale(&self) -> T {
        self.scale
    }

    /// Another model under the same normal force and reference load: for instance with its curve in
    /// an [`AnyCurve`](crate::curve::AnyCurve), or with the curve of one axis of a planar contact.
    #[inline]
    pub fn with_model<N>(&self, model: N) -> Contact<T, N> {
        let Self { reference_load, normal_force, scale, .. } = *self;
        Contact { model, reference_load, normal_force, scale }
    }

    /// Changes the normal force to p' \[N\], zero or positive, and leaves the deflections to you:
    /// for several under one load, see [`LoadChange`]. [`Contact::reload`] does both for one.
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite, and a positive one on a contact that
    /// has no reference load; the contact is as it was.
    #[inline]
    pub fn change_load(&mut self, normal_force: T) -> Checked<LoadChange<T>> {
        let after = Named("normal_force", normal_force).non_negative()?;
        if after > T::zero() {
            let given = self.reference_load > T::zero();
            let rule = "be given by `measured_at` before a contact made under no load is loaded";
            Named("reference_load", self.reference_load).stated(given, rule)?;
        }
        let before = self.normal_force;
        (self.normal_force, self.scale) = (after, self.scale_under(after));
        Ok(LoadChange { before, after })
    }

    /// Changes the normal force by renewal to p' \[N\], zero or positive, which becomes the
    /// reference load, too, and leaves the deflections to you ([`LoadChange::renewed`]).
    /// [`Contact::renew`] does both for one.
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite; the contact is as it was.
    #[inline]
    pub fn renew_load(&mut self, normal_force: T) -> Checked<LoadChange<T>> {
        let after = Named("normal_force", normal_force).non_negative()?;
        // The energy is that of the stiffness at the reference load.
        let before = self.reference_load;
        (self.normal_force, self.reference_load, self.scale) = (after, after, T::one());
        Ok(LoadChange { before, after })
    }

    /// The friction scale under a normal force.
    #[inline]
    fn scale_under(&self, normal_force: T) -> T {
        let constant = normal_force == self.reference_load;
        if constant { T::one() } else { normal_force / self.reference_load }
    }
}

impl<T: Scalar, M: Bristle<T>> Contact<T, M> {
    /// Changes the normal force to p' \[N\], zero or positive, before a step. Returns what is left
    /// of a deflection, and the energy that is dissipated.
    ///
    /// A deflection that the surface still holds stays as it is. If the load falls below what the
    /// bristle carries, the bristle slips back, and of the force of its springs the share min(1,
    /// max(1/γ, p'/p)) is left. Here γ = |Σ Kᵢ xᵢ|/(s' B) is what they carry, divided by what the
    /// surface holds under the new scale s' = p'/P, and B \[–\] is the largest μ up to the speed of
    /// `velocity` [m/s]. Without a load nothing is left.
    ///
    /// For steps under a load that varies, take the load at the middle of each step, and the
    /// velocity that is predicted for it: the errors of deflections are then of second order in its
    /// length, and so are those of mean forces, unless the load falls faster than a sliding bristle
    /// relaxes.
    ///
    /// ```
    /// use bristle::{Bristle, Dahl, DahlParameters};
    ///
    /// let dahl = DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: 1e4 };
    /// let mut grip = Dahl::new(dahl)?.under_load(10.0)?; // N, holds 5 N
    /// let part = 3e-5; // m: 3 N
    /// // It keeps its place and its force under 7 N as under 20 N …
    /// assert_eq!(grip.reload(7.0, 0.0, part)?.deflection, part);
    /// assert_eq!(grip.reload(20.0, 0.0, part)?.deflection, part);
    /// assert_eq!(grip.force(0.0, part), 3.0);
    /// // … and slips under 2 N, which hold 1 N.
    /// let slipped = grip.reload(2.0, 0.0, part)?;
    /// assert!((grip.force(0.0, slipped.deflection) - 1.0_f64).abs() < 1e-15);
    /// assert!(slipped.dissipated > 0.0);
    /// # Ok::<(), bristle::ParameterError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite, and a positive one on a contact that
    /// has no reference load; the contact is as it was. A velocity that is NaN gives NaN where the
    /// load falls.
    #[doc(alias = "set_normal_force")]
    #[inline]
    pub fn reload(
        &mut self,
        normal_force: T,
        velocity: T,
        deflection: M::Deflection,
    ) -> Checked<Reloaded<T, M::Deflection>> {
        let change = self.change_load(normal_force)?;
        Ok(self.reloaded(change, velocity, deflection))
    }

    /// As [`Contact::reload`], for a contact that many bristles share and that stays as it is. You
    /// keep the load of each beside its deflection, and pass it with the velocity: a [`Surface`]
    /// under the scale load/p, where p is the normal force of this contact.
    ///
    /// ```
    /// use bristle::{Bristle, Dahl, DahlParameters, LoadChange, Surface};
    ///
    /// let dahl = DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: 1e4 };
    /// let shared = Dahl::new(dahl)?.under_load(10.0)?; // N
    /// // One grain of many: its load falls from 10 N to 2 N, which hold 1 N of its 3 N.
    /// let (velocity, deflection) = (0.0, 3e-5); // m/s, m
    /// let change = LoadChange { before: 10.0, after: 2.0 };
    /// let grain = shared.reloaded(change, velocity, deflection);
    /// let surface = Surface::scaled(velocity, change.after / shared.normal_force());
    /// assert!((shared.force(surface, grain.deflection) - 1.0_f64).abs() < 1e-15);
    /// # Ok::<(), bristle::ParameterError>(())
    /// ```
    #[inline]
    pub fn reloaded(
        &self,
        change: LoadChange<T>,
        velocity: T,
        deflection: M::Deflection,
    ) -> Reloaded<T, M::Deflection> {
        let surface = Surface::scaled(velocity, self.scale_under(change.after));
        let left = self.model.held(change, surface, deflection);
        // ½ P K (x − x')(x + x')
        let half = self.model.storage_stiffness() * (lit::<T>(0.5) * self.reference_load);
        let dissipated = half.scaled_by(deflection - left).inner_product(deflection + left);
        Reloaded { deflection: left, dissipated }
    }

    /// Changes the normal force to p' \[N\], zero or positive, by *renewal*: the stiffness follows
    /// the load, because asperities come into contact unstretched and leave with their energy. What
    /// is left of a deflection x is x' = x min(1, p/p'). p' becomes the reference load, too.
    ///
    /// This is what happens to bristles that enter a rolling contact. A body that is held creeps
    /// under a load that varies: each rise from p to p' takes the share 1 − p/p' of the deflection.
    /// For what is held take [`Contact::reload`]. In steps, the x that you keep belongs to the load
    /// p at the middle of the last step; at another time t it is x min(1, p/p(t)).
    ///
    /// ```
    /// use bristle::{Bristle, Dahl, DahlParameters};
    ///
    /// let dahl = DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: 1e4 };
    /// let mut contact = Dahl::new(dahl)?.under_load(1.0)?; // N
    /// let pulled = contact.renew(8.0, 4e-6)?;
    /// assert_eq!(pulled.deflection, 0.5e-6); // it keeps its force while the load rises,
    /// let released = contact.renew(1.0, pulled.deflection)?;
    /// assert_eq!(released.deflection, 0.5e-6); // and its deflection while the load falls.
    /// assert!(pulled.dissipated > 0.0 && released.dissipated > 0.0);
    /// # Ok::<(), bristle::ParameterError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite; the contact is as it was.
    #[inline]
    pub fn renew(
        &mut self,
        normal_force: T,
        deflection: M::Deflection,
    ) -> Checked<Reloaded<T, M::Deflection>> {
        let stored = self.stored_energy(deflection);
        let (kept, lost) = self.renew_load(normal_force)?.renewed();
        Ok(Reloaded { deflection: deflection * kept, dissipated: lost * stored })
    }

    /// The velocity with the friction scale s = p/P of this load: what [`Contact::model`] has to be
    /// given if you call its methods yourself. The methods of the contact do that for you. A scale
    /// that you pass is multiplied by s, such as one for wear or temperature.
    #[inline(always)]
    pub fn surface(&self, surface: impl Into<Surface<T>>) -> Surface<T> {
        surface.into().rescaled(self.scale)
    }

    /// The coefficients λ, r, c₀, c₂ of the model at a velocity under this load; see [`Affine`] for
    /// when to take them. Multiply by the reference load: F = P (c₀ z + c₂ v). Without a load all
    /// are zero.
    #[inline(always)]
    pub fn affine(
        &self,
        surface: impl Into<Surface<T>>,
        deflection: M::Deflection,
    ) -> Affine<T, M::Deflection> {
        let surface = self.surface(surface);
        if is_zero(surface.scale()) {
            return Affine::none();
        }
        self.model.affine(surface, deflection)
    }

    /// The deflection rate ż [m/s].
    #[inline]
    pub fn rate(&self, surface: impl Into<Surface<T>>, deflection: M::Deflection) -> M::Deflection {
        self.response(surface, deflection).rate
    }

    /// The friction force F \[N\], positive against v > 0.
    #[inline]
    pub fn force(&self, surface: impl Into<Surface<T>>, deflection: M::Deflection) -> T {
        self.response(surface, deflection).force
    }

    /// [`Bristle::switching_function`] under this load. Under another one, p, that of the
    /// [model](Contact::model) on [`Surface::scaled`] by p over the reference load.
    #[inline(always)]
    pub fn switching_function(
        &self,
        surface: impl Into<Surface<T>>,
        deflection: M::Deflection,
    ) -> Option<T> {
        self.model.switching_function(self.surface(surface), deflection)
    }

    /// Rate and force at once, which costs as much as either: for the right-hand side of a
    /// mechanism.
    #[inline(always)]
    pub fn response(
        &self,
        surface: impl Into<Surface<T>>,
        deflection: M::Deflection,
    ) -> ContactResponse<T, M::Deflection> {
        let surface = surface.into();
        let (affine, velocity) = (self.affine(surface, deflection), surface.velocity());
        ContactResponse {
            rate: affine.rate(velocity, deflection),
            force: self.reference_load * affine.coefficient(velocity, deflection),
        }
    }

    /// Rate and force under a normal force p \[N\] that varies, at one instant: for a
    /// [`System`](crate::ode::System) of your own whose load is a function of time or state.
    ///
    /// The stiffness is that of the reference load, and the rate of p does not matter. The rate is
    /// ż = −λ z + r v under the scale s = p/P. Where the load has fallen below what a stuck bristle
    /// carries, the force is that which the surface holds: F = P (c₀ κ z + c₂ v) with
    /// κ = min(1, s B/|K·z|), B as in [`Contact::reload`]. The deflection stays, so the force comes
    /// back with the load. `reload` takes it away for good, so that the two differ however short
    /// the steps are: with `reload` a grip that slips in each dip of its load slips farther. Which
    /// of them a real grip follows is not known; where the load never falls below what is carried
    /// they agree.
    ///
    /// κ < 1 also where no load has fallen: a bristle that has adapted to fast sliding, with
    /// viscous friction that lifts μ above its static value, carries more than the surface holds
    /// once it slides slowly. The force is then below that of [`Contact::response`].
    ///
    /// ```
    /// use bristle::{Bristle, Dahl, DahlParameters};
    ///
    /// let dahl = DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: 1e4 };
    /// let friction = Dahl::new(dahl)?.under_load(2.0)?; // N
    /// let (v, z) = (0.0, 1e-5); // stuck, with 0.2 N
    /// for (load, force) in [(2.0, 0.2), (5.0, 0.2), (0.2, 0.1)] {
    ///     assert!((friction.response_under(load, v, z).force - force as f64).abs() < 1e-15);
    /// }
    /// # Ok::<(), bristle::ParameterError>(())
    /// ```
    ///
    /// NaN for a negative normal force, without a reference load, and for an implicit bristle from
    /// its [fold](Bristle::folding_scale) on. The rate of Dahl and LuGre grows as 1/p while they
    /// slide: a run ends where p becomes zero.
    #[inline]
    pub fn response_under(
        &self,
        normal_force: T,
        surface: impl Into<Surface<T>>,
        deflection: M::Deflection,
    ) -> ContactResponse<T, M::Deflection> {
        let scale = self.scale_under(normal_force);
        let fits = self.model.folding_scale().is_none_or(|fold| scale < fold);
        let normal_force = if normal_force >= T::zero() && fits { normal_force } else { T::nan() };
        let surface = surface.into().rescaled(self.scale_under(normal_force));
        let affine = if is_zero(surface.scale()) {
            Affine::none()
        } else {
            self.model.affine(surface, deflection)
        };
        let velocity = surface.velocity();
        // As if a load without end had fallen to this one.
        let change = LoadChange { before: T::unlimited(), after: normal_force };
        let held = self.model.held(change, surface, deflection);
        ContactResponse {
            rate: affine.rate(velocity, deflection),
            force: self.reference_load * affine.coefficient(velocity, held),
        }
    }

    /// Rate and force at any state with all their partial derivatives, see [`Bristle::linearised`].
    #[inline]
    pub fn linearised(
        &self,
        surface: impl Into<Surface<T>>,
        deflection: M::Deflection,
    ) -> LinearisedContact<T, M::Deflection> {
        let surface = surface.into();
        if is_zero(self.scale) {
            let none = Affine::none();
            return self.loaded(Linearised::new(&none, &none, surface.velocity(), deflection));
        }
        self.loaded(self.model.linearised(self.surface(surface), deflection))
    }

    /// Rate and force of steady sliding with all their partial derivatives, without cancellation,
    /// see [`Bristle::steady_linearised`].
    pub fn steady_linearised(
        &self,
        surface: impl Into<Surface<T>>,
    ) -> LinearisedContact<T, M::Deflection> {
        self.loaded(self.model.steady_linearised(self.surface(surface)))
    }

    #[inline]
    fn loaded(
        &self,
        linearised: Linearised<T, M::Deflection>,
    ) -> LinearisedContact<T, M::Deflection> {
        let load = self.reference_load;
        LinearisedContact {
            rate: linearised.rate,
            force: load * linearised.coefficient,
            rate_by_deflection: linearised.rate_by_deflection,
            rate_by_velocity: linearised.rate_by_velocity,
            force_by_deflection: linearised.coefficient_by_deflection * load,
            force_by_velocity: load * linearised.coefficient_by_velocity,
        }
    }

    /// The stationary deflection of steady sliding at a velocity, z_ss = sgn_ε(v) s μ(v)/σ0 \[m\],
    /// with sgn_ε(v) = v/|v|_ε and, in LuGre, g for μ; see [`Bristle::stationary`].
    pub fn stationary(&self, surface: impl Into<Surface<T>>) -> M::Deflection {
        self.model.stationary(self.surface(surface))
    }

    /// The friction force \[N\] of steady sliding at a velocity.
    pub fn stationary_force(&self, surface: impl Into<Surface<T>>) -> T {
        if is_zero(self.scale) {
            return T::zero();
        }
        self.reference_load * self.model.stationary_coefficient(self.surface(surface))
    }

    /// The energy stored in the bristles, W = ½ P Σ Kᵢ xᵢ² \[J\], with the stiffness Kᵢ [1/m]
    /// ([`Bristle::storage_stiffness`]) and the stretch xᵢ \[m\] of each spring: for a single
    /// spring ½ P σ0 z². It depends on the reference load P and not on the normal force p.
    pub fn stored_energy(&self, deflection: M::Deflection) -> T {
        let weighted = self.model.storage_stiffness().scaled_by(deflection);
        lit::<T>(0.5) * self.reference_load * weighted.inner_product(deflection)
    }

    /// The dissipated power F v − Ẇ \[W\]: never negative for a passive model.
    pub fn dissipated_power(&self, surface: impl Into<Surface<T>>, deflection: M::Deflection) -> T {
        let surface = surface.into();
        let stiffness = self.model.storage_stiffness();
        let affine = self.affine(surface, deflection);
        self.reference_load * affine.dissipation(stiffness, surface.velocity(), deflection)
    }

    /// The limits that the model's theorems give for velocities with |v| ≤ `fastest` [m/s], at this
    /// load, for deflections within its limit: after the load has fallen, reload first.
    pub fn limits(&self, fastest: T) -> ContactLimits<T> {
        let limits = self.model.limits(fastest);
        let constant = self.scale == T::one();
        ContactLimits {
            deflection: limits.deflection.map(|most| most * self.scale),
            force: limits.coefficient.map(|mu| mu * self.normal_force),
            // A smaller load lets the bristle relax faster.
            relaxation_rate: limits.relaxation_rate.filter(|_| constant),
        }
    }

    /// The exact step of length h ≥ 0 \[s\] at a held velocity [m/s] (zero-order hold): for a
    /// velocity that is measured or prescribed, sample by sample. NaN for a negative length.
    ///
    /// If your simulation computes its velocity from this force, use [`Contact::companion`], which
    /// is stable for any step, or keep h below the largest stable step of bristle-analysis
    /// (`step_limits::largest_step`). For a free mass m without damper or spring the limit is the
    /// smaller of 2σ1/σ0 and m/(σ1 P) \[s\]. A damper or spring changes it. Without any damping no
    /// step is stable. Beyond the limit a stuck mass slides under forces far below breakaway, with
    /// plausible numbers. The impulse on a mass is h times the mean force.
    ///
    /// The α of an elasto-plastic model is frozen at the beginning of the step. The tip of an
    /// [`ImplicitBristle`](crate::ImplicitBristle) is followed.
    ///
    /// For a further scale, of wear or of temperature, call [`Bristle::hold`] of the model with
    /// [`Contact::surface`] and multiply the coefficients by the reference load.
    #[doc(alias = "zero-order hold")]
    #[inline]
    pub fn hold(
        &self,
        velocity: T,
        deflection: M::Deflection,
        duration: T,
    ) -> HeldContact<T, M::Deflection> {
        let hold = if is_zero(self.scale) {
            Affine::none().hold(velocity, deflection, duration)
        } else {
            self.model.hold(self.surface(velocity), deflection, duration)
        };
        HeldContact {
            deflection: hold.deflection,
            end_force: self.reference_load * hold.end_coefficient,
            mean_force: self.reference_load * hold.mean_coefficient,
        }
    }
}
