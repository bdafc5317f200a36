//! Passive steps for a mechanism: over one step the friction is a force source and a damper.
//!
//! A mass that takes its velocity from a friction force is coupled to a stiff spring whenever it
//! sticks, and an explicit step must resolve the oscillation. A companion step avoids that. The
//! coefficients λ, r, c₀, c₂ of the bristle are frozen at a predicted velocity v\*; its exact step
//! is then affine in the mean velocity of the step v̄ = (v₀ + v₁)/2,
//!
//! z₁ = e⁻ˣ z₀ + φ1 h r v̄,  z̄ = φ1 z₀ + φ2 h r v̄,
//!
//! F̄ = P (c₀ z̄ + c₂ v̄) = bias + damping·v̄,  bias = P c₀ φ1 z₀,  damping = P (c₀ r φ2 h + c₂).
//!
//! In circuit simulation this is called a companion model. The mechanism puts the two numbers into
//! its own update and solves that for its new velocity, often in closed form; the deflection
//! follows. There is no iteration, and no step is too long to be stable.
//!
//! Take it where the velocity follows from the friction force and you choose the steps: a mechanism
//! of your own, a rigid-body engine, hardware in the loop. For a velocity that is known beforehand
//! there are [`Contact::hold`] and [`exponential`](crate::exponential); for steps chosen by an
//! error tolerance, [`ode`](crate::ode).
//!
//! | | call | gives |
//! |---|---|---|
//! | once | [`Contact::companion`] | a [`Companion`] |
//! | each step | [`VelocityHistory::predict`] | v\* |
//! | | [`Companion::step`] | a [`CompanionStep`]: bias and damping |
//! | | your equation of motion; of a free mass, [`CompanionStep::point_mass`] | v̄ |
//! | | [`CompanionStep::commit`] | a [`CompletedStep`]: z₁, F̄ and the energies |
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | h | length of the step | s |
//! | v₀, v₁, v̄ | velocity before and after the step, and mean velocity | m/s |
//! | v\* | velocity predicted for the middle of the step | m/s |
//! | z₀, z₁, z̄ | deflection before and after the step, and averaged over it | m |
//! | x = λh | step in relaxation times; φ1 = (1 − e⁻ˣ)/x, φ2 = (1 − φ1)/x | – |
//! | P, p | reference load, which is the normal force p if that is constant | N |
//! | λ, r, c₀, c₂, K | coefficients and storage stiffness, see [`Affine`] | 1/s, –, 1/m, s/m, 1/m |
//! | F̄ | friction force averaged over the step | N |
//! | W = ½ P K z² | stored energy | J |
//! | D | dissipated energy | J |
//!
//! # Energy
//!
//! Integrated over the step, for every v\*, v̄, h and z₀,
//!
//! h F̄ v̄ = W₁ − W₀ + D,  D = P (K λ∫z² dt + (c₀ − K r) h z̄ v̄ + c₂ h v̄²),
//!
//! λ∫z² dt = x z̄² + ½ L(x/2) (z₁ − z₀)²,  L(y) = coth y − 1/y ≥ 0 for y ≥ 0.
//!
//! FrBD (with a bristle of constant stiffness), Dahl, elasto-plastic FrBD and the implicit bristle
//! (both frozen over the step) have c₀ = K r. Then D is a sum of squares: the step never returns
//! more energy than the bristle had stored, however long the step and however wrong the prediction.
//!
//! With a bristle of several springs, λ is a matrix and z the vector of their stretches. Its modes
//! are orthogonal in W, and in each of them the bristle is a scalar that relaxes. The integral is a
//! sum of such squares, one for each mode, and the above holds unchanged.
//!
//! # LuGre
//!
//! Here r = 1 and c₀ = σ0 − σ1λ, which is negative at high speed. The damping is not: because of x
//! φ2 = 1 − φ1 it is P σ0φ2 h + p (σ1φ1 + σ2). It is computed in this form, the spring apart from
//! the rest, by [`HeldWeights::driven_damping`], which avoids cancellation.
//!
//! LuGre has no such energy balance: c₀ − K r = −σ1λ under the reference load, and D ≥ 0 is certain
//! for steps of every length only where s σ1²λ(v\*) ≤ 4σ0(σ1 + σ2), with the friction scale
//! s = p/P. In the classical model that fails for every v\* that is fast enough;
//! [`CompanionStep::is_passive`] tells for each step. The theorem of its passivity, for
//! σ2 ≥ σ1(μ_s − μ_d)/μ_d, carries over only to steps whose prediction comes true; below that
//! threshold not even those are safe.
//!
//! Source: a consequence of the affine form of the models of Romano et al. (arXiv 2602.09429),
//! section III-A, and of their storage function, Lemma III.2.

use crate::parameter::{Checked, Named};
use crate::rheology::{Deflection, HeldWeights};
use crate::scalar::{is_zero, lit};
use crate::{Affine, Bristle, Contact, Reloaded, Scalar, Surface};

/// A contact prepared for passive steps inside a mechanism.
///
/// Example: a mass pulled by a spring whose end moves, with steps of 10 ms. `RungeKutta4` is
/// unstable in this rig above 18 ms.
///
/// ```
/// use bristle::{Bristle, FrBd, paper};
/// use bristle::companion::VelocityHistory;
/// use bristle::curve::Stribeck;
/// use bristle::rheology::KelvinVoigt;
///
/// let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
/// let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
/// let friction = FrBd::new(curve, bristle).under_load(1.0)?.companion(1.0)?; // N, m/s
/// let (mass, stiffness, drive, h) = (1.0, 2.0, 0.1, 0.01); // kg, N/m, m/s, s
///
/// let (mut x, mut v, mut z) = (0.0, 0.0, 0.0);
/// let mut history = VelocityHistory::new(v);
/// for n in 0..2500 {
///     let step = friction.step(history.predict(), z, h);
///     // m (v₁ − v)/h = k (y − x) − k h v̄/2 − bias − damping v̄ with v₁ = 2 v̄ − v and the end of
///     // the spring y taken at the middle of the step
///     let stretch = drive * h * (f64::from(n) + 0.5) - x;
///     let mean_velocity = (2.0 * mass / h * v + stiffness * stretch - step.bias())
///         / (2.0 * mass / h + 0.5 * h * stiffness + step.damping());
///     z = step.commit(mean_velocity).deflection;
///     (x, v) = (x + h * mean_velocity, 2.0 * mean_velocity - v);
///     history.push(v);
/// }
/// // The mass follows the end of the spring, which is at 2.5 m.
/// assert!(x > 1.5 && x < 2.5 && z.abs() <= 1.5e-4);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
///
/// In an implicit solver of your own, the force on the mechanism is −[`CompanionStep::force`] of
/// the iterate's v̄. Its derivative is constant: −damping with respect to v̄, −damping/2 with
/// respect to v₁. Call [`CompanionStep::commit`] once, with the v̄ found. Several contacts add
/// their dampings to the matrix of the mechanism and their biases to its right-hand side.
///
/// # Accuracy
///
/// Position, velocity and deflection are of second order in h if v\* is the velocity at the middle
/// of the step up to O(h²): from a [`VelocityHistory`], or v₀ + (h/2) a₀ with the acceleration a₀.
/// The latter has half the error where the step resolves the oscillation of a stuck mass on its
/// bristles, ω² = P σ0/m, and misleads where it does not. With v\* = v₀ the step is of first order.
///
/// Solving twice, the second time with `step(v̄, z, h)` of the v̄ found first, costs twice as much
/// and keeps order and balance. In smooth motion of this rig the velocity is about ten times as
/// accurate, where a halved step gives four.
///
/// In a long step the force can exceed the curve, because the frozen coefficients do not respond to
/// a breakaway within the step. In the rig above, with breakaway at 1.481 N and max μ p = 1.5 N:
///
/// | h \[s\] | 0.001 | 0.01 | 0.05 | 0.1 | 0.25 | 0.5 |
/// |---|---|---|---|---|---|---|
/// | largest F̄ \[N\], solved once | 1.48 | 1.49 | 1.52 | 1.58 | 1.74 | 2.00 |
/// | solved twice | 1.48 | 1.48 | 1.51 | 1.55 | 1.66 | 1.83 |
///
/// A stuck mass that is struck oscillates by v₁ ≈ −v₀ in steps much longer than 2/ω and settles
/// slowly. Backward Euler (v̄ = v₁, solved from F̄ = bias + damping·v₁) damps it at once and keeps
/// the balance, which holds for every v̄, but is of first order. Without a [`VelocityHistory`],
/// predict v\* = vₙ after a reversal of the velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Companion<T, M> {
    contact: Contact<T, M>,
    fastest: T,
    /// Limit of |z| up to that speed \[m\]; infinite where the model has none.
    limit: T,
}

impl<T: Scalar, M: Bristle<T>> Companion<T, M> {
    /// The contact, with its model and its present load.
    pub fn contact(&self) -> &Contact<T, M> {
        &self.contact
    }

    /// The speed [m/s] for which the limit of the deflection was computed, as it was given to
    /// [`Contact::companion`]. It is no limit of the velocity.
    pub fn fastest(&self) -> T {
        self.fastest
    }

    /// Changes the normal force to p' \[N\], zero or positive, before a step: take the load at the
    /// middle of the step, and the velocity [m/s] predicted for it. Returns the deflection to begin
    /// the step from, and the energy that is dissipated, see [`Contact::reload`]. It is for what is
    /// held or slides under a load that varies: a grip, a brake.
    ///
    /// With a model whose step keeps its balance, the mechanism never gets more out of the friction
    /// than it has put in, whatever the load does.
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite, and a positive one on a contact that
    /// has no reference load; the companion is as it was.
    #[inline]
    pub fn reload(
        &mut self,
        normal_force: T,
        predicted_velocity: T,
        deflection: M::Deflection,
    ) -> Checked<Reloaded<T, M::Deflection>> {
        self.contact.reload(normal_force, predicted_velocity, deflection)
    }

    /// Changes the normal force by renewal, before a step, see [`Contact::renew`]. It is for
    /// asperities that come and go with the load, as where material passes through the contact.
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite; the companion is as it was.
    #[inline]
    pub fn renew(
        &mut self,
        normal_force: T,
        deflection: M::Deflection,
    ) -> Checked<Reloaded<T, M::Deflection>> {
        self.contact.renew(normal_force, deflection)
    }

    /// The source and the damper that stand for the friction over a step of length h ≥ 0 \[s\],
    /// from a deflection z₀ \[m\] and a velocity v\* [m/s] predicted for the middle of the step.
    /// NaN for h < 0. A scale of the given [`Surface`] counts on top of that of the load.
    #[inline(always)]
    pub fn step(
        &self,
        predicted: impl Into<Surface<T>>,
        deflection: M::Deflection,
        duration: T,
    ) -> CompanionStep<T, M::Deflection> {
        self.frozen_at(predicted.into(), deflection, deflection, duration)
    }

    /// As [`Companion::step`], with the coefficients frozen at a predicted deflection, too: for the
    /// models whose coefficients depend on it, elasto-plastic FrBD and the implicit bristle.
    ///
    /// Frozen at z₀, an elasto-plastic bristle stays elastic throughout the step. A fast body with
    /// a long step then meets a spring where it should slide, and forces far above the curve. With
    /// a prediction for the middle, z\* = z₀ + (h/2) v\* or closer, the bristle has yielded by
    /// then, and the step is of second order:
    ///
    /// ```
    /// use bristle::{Bristle, ElastoPlastic};
    /// use bristle::companion::Prediction;
    /// use bristle::curve::{Coulomb, CoulombParameters};
    /// use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
    ///
    /// let curve =
    ///     Coulomb::new(CoulombParameters { dynamic_coefficient: 0.5, viscous_friction: 0.0 })?;
    /// let bristle =
    ///     KelvinVoigt::new(KelvinVoigtParameters { micro_stiffness: 3e3, micro_damping: 20.0 })?;
    /// let friction = ElastoPlastic::new(curve, bristle, 1e-4)?;
    /// let joint = friction.under_load(10.0)?.companion(5.0)?;
    /// let (velocity, deflection, h) = (1.0, 0.0, 1.0 / 60.0); // a block has just been struck
    /// let elastic = joint.step(velocity, deflection, h).force(velocity);
    /// let middle = Prediction { velocity, deflection: deflection + 0.5 * h * velocity };
    /// let sliding = joint.step_about(middle, deflection, h).force(velocity);
    /// assert!(elastic > 400.0 && sliding < 5.0); // N; μ p = 5 N
    /// # Ok::<(), bristle::ParameterError>(())
    /// ```
    ///
    /// The energy balance holds for every prediction. A [`Surface`] may stand for the velocity, as
    /// in [`Companion::step`].
    #[inline(always)]
    pub fn step_about(
        &self,
        prediction: Prediction<impl Into<Surface<T>>, M::Deflection>,
        deflection: M::Deflection,
        duration: T,
    ) -> CompanionStep<T, M::Deflection> {
        let Prediction { velocity, deflection: about } = prediction;
        self.frozen_at(velocity.into(), about, deflection, duration)
    }

    /// A step with the coefficients of a surface and a deflection.
    #[inline(always)]
    fn frozen_at(
        &self,
        surface: Surface<T>,
        about: M::Deflection,
        deflection: M::Deflection,
        duration: T,
    ) -> CompanionStep<T, M::Deflection> {
        let model = self.contact.model();
        // NaN for a step backwards.
        let duration = if duration >= T::zero() { duration } else { T::nan() };
        let affine = self.contact.affine(surface, about);
        let weights = affine.weights(duration);
        let mut limit =
            self.contact.surface(surface).apply(self.limit).larger(deflection.largest());
        if surface.velocity().abs() > self.fastest {
            limit = limit.larger(self.contact.stationary(surface).largest());
        }
        let (storage_stiffness, normal_force) =
            (model.storage_stiffness(), self.contact.reference_load());
        // P (c₀ z̄ + c₂ v̄) = P K r z̄ + rest. For FrBD c₀ − K r is the difference of two equal
        // numbers.
        let stiffness = affine.stiffness * normal_force;
        let springs = storage_stiffness.scaled_by(affine.drive) * normal_force;
        let excess = stiffness - springs;
        let [bias, rest_bias] = weights.undriven_sums([stiffness, excess], deflection);
        let of_springs = weights.driven_damping(springs, affine.drive, T::zero());
        let mut rest_damping =
            weights.driven_damping(excess, affine.drive, normal_force * affine.damping);
        let mut damping = of_springs + rest_damping;
        if damping < T::zero() {
            // A rounding, where a stiffness varies. Force and dissipation use the same numbers.
            rest_damping -= damping;
            damping = T::zero();
        }
        CompanionStep {
            bias,
            damping,
            rest_bias,
            rest_damping,
            affine,
            weights,
            normal_force,
            storage_stiffness,
            deflection,
            duration,
            limit,
        }
    }
}

impl<T: Scalar, M: Bristle<T>> Contact<T, M> {
    /// Prepares the contact for passive steps inside a mechanism. `fastest` is the speed [m/s] that
    /// the mechanism mostly stays below.
    ///
    /// It sets the limit of the deflection, |z| ≤ max μ/σ0 for FrBD with one spring, with the
    /// largest μ up to that speed ([`Limits::deflection`](crate::Limits::deflection)). A mean
    /// velocity that differs from the predicted one can take the deflection beyond it; a step cuts
    /// it back, which only removes energy. The limit is computed here, once. `fastest` need not be
    /// exact: a step predicted to be faster also allows the stationary deflection of its
    /// prediction, at the cost of one more evaluation of the curve. Zero gives the limit at rest.
    ///
    /// # Errors
    ///
    /// Refuses a speed that is negative or not finite.
    pub fn companion(self, fastest: T) -> Checked<Companion<T, M>> {
        let fastest = Named("fastest", fastest).non_negative()?;
        let limit = self.model().limits(fastest).deflection.unwrap_or_else(T::unlimited);
        Ok(Companion { contact: self, fastest, limit })
    }

    /// As [`Contact::companion`], with a `limit` of |z| \[m\] that is known already. Nothing is
    /// checked.
    ///
    /// It is for a contact that is made anew in each step, such as one axis of a contact in a
    /// plane, where asking the model for its limit would cost as much as the step. Keep that of
    /// `model.limits(fastest).deflection`: that under the reference load, which each step scales
    /// with the load. Infinity is no limit. A step predicted to be faster than `fastest` [m/s] also
    /// allows the stationary deflection of its prediction.
    #[inline]
    pub fn companion_within(self, fastest: T, limit: T) -> Companion<T, M> {
        Companion { contact: self, fastest, limit }
    }
}

/// The middle of a step, as predicted, where [`Companion::step_about`] freezes its coefficients.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prediction<V, D = V> {
    /// Velocity v\* [m/s], or a [`Surface`] with it.
    pub velocity: V,
    /// Deflection z\* \[m\].
    pub deflection: D,
}

/// A free mass over one step: what [`CompanionStep::point_mass`] needs to know.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointMass<T> {
    /// Mass m \[kg\], zero or positive.
    pub mass: T,
    /// Velocity v₀ at the beginning of the step [m/s].
    pub velocity: T,
    /// Sum f of all other forces, averaged over the step \[N\].
    pub force: T,
    /// Weight θ of the velocity v₁ at the end of the step in its displacement h v̄ \[–\]:
    /// v̄ = v₀ + θ (v₁ − v₀), hence v₁ = v₀ + (v̄ − v₀)/θ. It belongs to the integrator of the
    /// mass: ½ for the trapezoidal rule, 1 for semi-implicit Euler, (n + 1)/(2n) for n such
    /// substeps under constant forces. Below ½ the mass can gain energy by the step. With θ = 0, v̄
    /// is v₀ and v₁ = v₀ + h (f − F̄)/m. Outside 0 … 1 the velocity is NaN.
    pub end_weight: T,
}

/// Friction over one step, F̄ = bias + damping·v̄, before the mean velocity v̄ is known.
///
/// Made by [`Companion::step`]. Put [`bias`](Self::bias) and [`damping`](Self::damping) into the
/// equation of motion, solve it for v̄, and give that to [`commit`](Self::commit). A step is plain
/// numbers: it can be solved, discarded or repeated.
///
/// [`coefficients`](Self::coefficients), [`weights`](Self::weights),
/// [`deflection`](Self::deflection) and [`reference_load`](Self::reference_load) are what F̄ and z₁
/// are made of. A loop does not need them; who differentiates a step by friction parameters does
/// (`bristle-mechanism`, for gradients).
#[must_use]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompanionStep<T: Scalar, D: Deflection<T> = T> {
    bias: T,
    damping: T,
    /// Bias and damping beyond P K r z̄.
    rest_bias: T,
    rest_damping: T,
    affine: Affine<T, D>,
    weights: D::Weights,
    normal_force: T,
    storage_stiffness: D,
    deflection: D,
    duration: T,
    limit: T,
}

/// A step of no length without friction, to fill an array before the steps of its contacts are
/// known.
impl<T: Scalar> Default for CompanionStep<T> {
    #[inline(always)]
    fn default() -> Self {
        let zero = T::zero();
        let affine = Affine { relaxation: zero, drive: zero, stiffness: zero, damping: zero };
        Self {
            bias: zero,
            damping: zero,
            rest_bias: zero,
            rest_damping: zero,
            affine,
            weights: affine.weights(zero),
            normal_force: zero,
            storage_stiffness: zero,
            deflection: zero,
            duration: zero,
            limit: zero,
        }
    }
}

impl<T: Scalar, D: Deflection<T>> CompanionStep<T, D> {
    /// The coefficients λ, r, c₀, c₂ as they are frozen over the step: those at v\* (and z\*),
    /// under the present load, per reference load.
    #[inline]
    pub fn coefficients(&self) -> &Affine<T, D> {
        &self.affine
    }

    /// The frozen step as a linear map: [`HeldWeights::end`] of z₀ and the drive r v̄ is the
    /// deflection z₁ before it is cut to its limit, [`HeldWeights::mean`] the mean z̄.
    #[inline]
    pub fn weights(&self) -> &D::Weights {
        &self.weights
    }

    /// The deflection z₀ \[m\] that the step begins from, as it was given to [`Companion::step`]:
    /// after a change of the load that of [`Reloaded`].
    #[inline]
    pub fn deflection(&self) -> D {
        self.deflection
    }

    /// The reference load P \[N\]: F̄ = P (c₀ z̄ + c₂ v̄), W = ½ P K z².
    #[inline]
    pub fn reference_load(&self) -> T {
        self.normal_force
    }

    /// Mean friction force \[N\] if the mean velocity is zero: the spring force of the deflection
    /// z₀ as it relaxes. It goes to the right-hand side of the equation of motion.
    #[inline]
    pub fn bias(&self) -> T {
        self.bias
    }

    /// Increase of the mean friction force with the mean velocity [N s/m], zero or positive. It is
    /// added to the damping of the mechanism.
    #[inline]
    pub fn damping(&self) -> T {
        self.damping
    }

    /// Mean friction force F̄ \[N\] for a mean velocity v̄ [m/s], positive against v̄ > 0.
    #[inline]
    pub fn force(&self, mean_velocity: T) -> T {
        self.bias + self.damping * mean_velocity
    }

    /// The mean velocity v̄ [m/s] of a free mass under this friction and known forces, for a body
    /// without springs or couplings of its own:
    ///
    /// m (v₁ − v₀) = h (f − bias − damping v̄),  v̄ = v₀ + θ (v₁ − v₀)
    ///
    /// Give it to [`CompanionStep::force`] for the force on the mass, −F̄, and to
    /// [`CompanionStep::commit`]. The kinetic energy changes by h (f − F̄) v̄ − (θ − ½) m (v₁ −
    /// v₀)². NaN for m < 0.
    ///
    /// ```
    /// use bristle::{Bristle, FrBd, paper};
    /// use bristle::companion::PointMass;
    /// use bristle::curve::Stribeck;
    /// use bristle::rheology::KelvinVoigt;
    ///
    /// let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
    /// let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
    /// let contact = FrBd::new(curve, bristle).under_load(1.0)?.companion(1.0)?;
    /// let (mut velocity, mut deflection, h) = (0.0, 0.0, 1.0 / 60.0);
    /// for _ in 0..600 {
    ///     let step = contact.step(velocity, deflection, h);
    ///     // 0.75 N is half of breakaway.
    ///     let mass = PointMass { mass: 1.0, velocity, force: 0.75, end_weight: 1.0 };
    ///     let mean = step.point_mass(mass);
    ///     (velocity, deflection) = (mean, step.commit(mean).deflection);
    /// }
    /// assert!(velocity.abs() < 1e-12 && (deflection - 0.75e-4).abs() < 1e-9); // it stands
    /// # Ok::<(), bristle::ParameterError>(())
    /// ```
    #[inline]
    pub fn point_mass(&self, body: PointMass<T>) -> T {
        let PointMass { mass, velocity, force, end_weight } = body;
        let sound = mass >= T::zero() && end_weight >= T::zero() && end_weight <= T::one();
        let mass = if sound { mass } else { T::nan() };
        let pace = end_weight * self.duration;
        (mass * velocity + pace * (force - self.bias)) / (mass + pace * self.damping)
    }

    /// The velocity −bias/damping [m/s] at which the mean force vanishes, if there is any damping.
    /// It is for physics engines whose joint motors take a damping and a target velocity: their
    /// force damping·(target − v) is this friction.
    #[inline]
    pub fn target_velocity(&self) -> Option<T> {
        (self.damping > T::zero()).then(|| -self.bias / self.damping)
    }

    /// Whether a step with these coefficients, however short, dissipates, D ≥ 0, for every
    /// deflection and every mean velocity: (c₀ − K r)² ≤ 4 K λ c₂ at the predicted velocity. Ask it
    /// where the model is LuGre: a `false` says that the friction may feed energy into the
    /// mechanism. (A step of many relaxation times may still dissipate then.)
    ///
    /// It does for FrBD with a bristle of constant stiffness, Dahl, elasto-plastic FrBD and the
    /// implicit bristle. LuGre's
    /// may not at high speed, nor FrBD's with a stiffness that varies. For several springs with a
    /// stiffness that varies it is not known, and the answer is `false`.
    pub fn is_passive(&self) -> bool {
        let Affine { relaxation, drive, stiffness, damping } = self.affine;
        let excess = stiffness - self.storage_stiffness.scaled_by(drive);
        let square = excess.inner_product(excess);
        if is_zero(square) {
            return damping >= T::zero();
        }
        let relaxing = D::relax(relaxation, self.storage_stiffness);
        D::SPRINGS == 1
            && square <= lit::<T>(4.0) * damping * relaxing.inner_product(D::fill(T::one()))
    }

    /// Ends the step with the mean velocity v̄ [m/s] that the mechanism has found. Returns the new
    /// deflection, the force and the energies.
    ///
    /// The deflection is cut to its limit (see [`Contact::companion`]) or to its size before the
    /// step, whichever is larger.
    #[inline(always)]
    pub fn commit(&self, mean_velocity: T) -> CompletedStep<T, D> {
        let Self { affine, weights, deflection: before, duration, .. } = *self;
        let drive = affine.drive * mean_velocity;
        let free = weights.end(before, drive);
        let after = free.within(self.limit);

        let force = self.force(mean_velocity);
        let energy = |from: D, to: D| {
            let half = self.storage_stiffness * (lit::<T>(0.5) * self.normal_force);
            half.scaled_by(to - from).inner_product(to + from)
        };
        // For FrBD the rest is c₂ v̄, and all are squares.
        let rest = self.rest_bias + self.rest_damping * mean_velocity;
        let dissipated = self.normal_force
            * weights.relaxed_energy(self.storage_stiffness, before, drive)
            + rest * (duration * mean_velocity);
        CompletedStep {
            deflection: after,
            force,
            work: duration * force * mean_velocity,
            stored: energy(before, after),
            dissipated: dissipated + energy(after, free),
        }
    }
}

/// What the friction did over one step, once the mechanism had found its mean velocity: the new
/// deflection, the mean force and the energies. From [`CompanionStep::commit`].
///
/// Carry the deflection to the next step. The energies are for a balance of the whole mechanism:
/// work = stored + dissipated. The type F of the force is a number here, and a vector for the
/// contacts of several axes in bristle-plane.
///
/// # Rounding
///
/// The balance holds up to 16 ε times the terms that these energies are sums of, where ε is the
/// rounding of the scalar type.
///
/// For models with c₀ = K r the terms are |work| + W₀ + W₁. (Relative to the work alone the error
/// of short steps has no bound: a step that moves the bristle by less than ε z stores nothing.) For
/// other models P h |v̄| (|c₀ − K r| |z̄| + c₂ |v̄|) is one more term, for LuGre p σ1 h v̄² and p
/// σ1λ h z̄ v̄: in fast sliding these nearly cancel, and can exceed the energies by orders of
/// magnitude.
///
/// Of a bristle of several springs the modes are computed to some hundreds of roundings: in `f32`
/// the balance of one step can be off by 2.5e-4 of the energies, and by more where rates differ by
/// ten decades or a step is 10⁶ relaxation times long.
#[must_use]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompletedStep<T, D = T, F = T> {
    /// Deflection at the end of the step \[m\].
    pub deflection: D,
    /// Friction force averaged over the step \[N\]: its impulse on the mechanism is −F̄ h.
    pub force: F,
    /// Work of the mechanism on the friction \[J\], h F̄ v̄.
    pub work: T,
    /// Change of the stored energy \[J\], W₁ − W₀.
    pub stored: T,
    /// Dissipated energy \[J\]: D, and the energy that the limit of the deflection has cut off.
    /// Where c₀ = K r it is a sum of squares, so that no rounding makes it negative.
    pub dissipated: T,
}

/// Predicts the velocity v\* for [`Companion::step`] from the last two velocities of a mechanism
/// with steps of equal length: the extrapolation to the middle of the next step,
///
/// v\* = 1.5 vₙ − 0.5 vₙ₋₁,  but v\* = vₙ after a step in which the velocity changed its sign.
///
/// Without the exception a step too long for the oscillation of a stuck mass feeds it: a body that
/// should stand on a slope creeps by millimetres a second for ever. A reversal costs one prediction
/// of first order, which keeps the run of second order.
///
/// ```
/// use bristle::companion::VelocityHistory;
///
/// let mut history = VelocityHistory::new(0.0);
/// history.push(0.2);
/// assert_eq!(history.predict(), 1.5 * 0.2);
/// history.push(-0.1);
/// assert_eq!(history.predict(), -0.1);
/// history = VelocityHistory::new(-0.5); // an impact
/// assert_eq!(history.predict(), -0.5);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VelocityHistory<T> {
    last: T,
    change: T,
}

impl<T: Scalar> VelocityHistory<T> {
    /// Begins with a constant velocity [m/s]. Begin again after a jump of the velocity, such as an
    /// impact. At a kink of the velocity (a jump of the acceleration, as at a reversal) go on with
    /// [`push`](Self::push): one prediction is then off by half a step times the jump, which keeps
    /// the run of second order.
    pub fn new(velocity: T) -> Self {
        Self { last: velocity, change: T::zero() }
    }

    /// The velocity v\* [m/s] at the middle of the next step.
    #[inline]
    pub fn predict(&self) -> T {
        self.last + lit::<T>(0.5) * self.change
    }

    /// Takes the velocity [m/s] at the end of a step.
    #[inline]
    pub fn push(&mut self, velocity: T) {
        let reversed = velocity * self.last < T::zero();
        let change = if reversed { T::zero() } else { velocity - self.last };
        *self = Self { last: velocity, change };
    }
}
