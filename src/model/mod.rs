//! Friction models: how the deflection of a bristle evolves and what force it gives.

mod affine;
mod any;
mod characteristics;
mod dahl;
mod elasto_plastic;
mod frbd;
mod implicit;
mod law;
mod lugre;
#[cfg(feature = "alloc")]
mod own;

use core::fmt::Debug;

pub use affine::{Affine, HeldStep};
pub use any::AnyBristle;
pub use characteristics::Characteristics;
pub use dahl::{Dahl, DahlParameters};
pub use elasto_plastic::ElastoPlastic;
pub use frbd::FrBd;
pub use implicit::ImplicitBristle;
pub use law::Law;
pub use lugre::LuGre;
#[cfg(feature = "alloc")]
pub use own::OwnModel;

use crate::parameter::Checked;
use crate::rheology::Deflection;
use crate::scalar::{is_zero, lit};
use crate::{Contact, LoadChange, Scalar, Surface};

/// A dynamic friction model per unit load: the bristle deflection z \[m\] as state, the sliding
/// velocity v [m/s] as input, the virtual friction coefficient μ_b \[–\] as output. The friction
/// force is P μ_b with the reference load P \[N\], which is the normal force if that is constant:
/// [`Bristle::under_load`] makes a [`Contact`], with forces in newtons and energies in joules.
///
/// Every model of this crate can be written as (see [`Affine`])
///
/// ż = −λ z + r v,  μ_b = c₀ z + c₂ v
///
/// with coefficients of v alone or, in two of the models, of v and z ([`Form`]).
///
/// The symbols μ, σ0, σ1, σ2 of the methods below are those of [`FrBd`]. They are *normalised*, per
/// unit of P: of a stiffness k [N/m], a damping c [N s/m] and a friction force F_C \[N\] given
/// under the load P take σ0 = k/P, σ1 = c/P and μ = F_C/P. With P = 1 N they are the same numbers.
/// A contact that carries the force F at rest begins at the deflection z = F/(P σ0).
///
/// | model | take it if |
/// |---|---|
/// | [`FrBd`] | no other row applies: passive, force bounded by the curve, one state |
/// | [`LuGre`] | its parameters or figures are given; it can create energy at high speed |
/// | [`Dahl`] | two parameters are all you have: friction that does not fall with the speed |
/// | [`ElastoPlastic`] | a force that varies below breakaway must not move the body |
/// | [`ImplicitBristle`] | you study the force balance itself, at several times the cost |
/// | [`AnyBristle`] | the choice is made at run time |
///
/// # Velocity, scale and branch
///
/// Where a method takes `impl Into<Surface<T>>`, pass the velocity: a plain number [m/s]. Two
/// things may come with it:
///
/// - A *scale* s \[–\] ([`Surface::scaled`]): the load over the reference load at which the
///   stiffness was measured. It multiplies the friction curve, μ → s μ, and not the stiffness. A
///   [`Contact`] sets it; a plain number has s = 1.
/// - A *locked branch* ([`Branch`](crate::Branch)): a solver that knows the direction of sliding
///   replaces |v| by +v or −v, which has no kink at v = 0. In a trial step beyond the reversal the
///   speed is then negative. A plain number is on no locked branch.
///
/// # A model of your own
///
/// It writes down four things: the coefficients, their slopes, the deflection of steady sliding and
/// the stiffness in its stored energy. Contacts, companions and scenes need no more. What asks for
/// a form, a law or a limit gets a pessimistic answer until you give one: a patch, a batch and an
/// observer ask for [`Form::OfVelocity`], an observer also for the laws [`Secant`](Law::Secant) and
/// [`Passivity`](Law::Passivity). Each value of a friction curve goes through [`Surface::apply`],
/// which scales it.
///
/// ```
/// use bristle::{Affine, Bristle, Form, Law, Surface};
///
/// /// Dahl's model on a surface whose friction rises with the speed, μ (1 + |v|/v₀).
/// #[derive(Debug, Clone)]
/// struct Rising { coefficient: f64, reference_speed: f64, stiffness: f64 }
///
/// impl Bristle<f64> for Rising {
///     type Deflection = f64;
///
///     fn affine(&self, surface: Surface<f64>, _: f64) -> Affine<f64> {
///         // On a locked branch |v| goes on below zero: take a power of it from its size.
///         let rise = 1.0 + surface.speed().abs() / self.reference_speed;
///         let friction = surface.apply(self.coefficient * rise);
///         let relaxation = self.stiffness * surface.speed() / friction;
///         Affine { relaxation, drive: 1.0, stiffness: self.stiffness, damping: 0.0 }
///     }
///
///     fn affine_and_slopes(&self, surface: Surface<f64>, z: f64) -> (Affine<f64>, Affine<f64>) {
///         let affine = self.affine(surface, z);
///         let rise = 1.0 + surface.speed().abs() / self.reference_speed;
///         // d(|v|/(1 + |v|/v₀))/dv = sgn v/(1 + |v|/v₀)²
///         let friction = surface.apply(self.coefficient * rise * rise);
///         let relaxation = self.stiffness * surface.direction() / friction;
///         (affine, Affine { relaxation, drive: 0.0, stiffness: 0.0, damping: 0.0 })
///     }
///
///     fn stationary(&self, surface: impl Into<Surface<f64>>) -> f64 {
///         let surface = surface.into();
///         let rise = 1.0 + surface.speed().abs() / self.reference_speed;
///         surface.direction() * surface.apply(self.coefficient * rise) / self.stiffness
///     }
///
///     fn storage_stiffness(&self) -> f64 {
///         self.stiffness
///     }
///
///     fn form(&self) -> Form {
///         Form::OfVelocity
///     }
///
///     // λ ≥ 0, r = 1 and c₀ = K: F v − Ẇ = p K λ z². And F/p = (μ/|v|)(v − ż).
///     fn obeys(&self, law: Law) -> bool {
///         matches!(law, Law::SteadySliding | Law::Secant | Law::Passivity)
///     }
/// }
///
/// let friction = Rising { coefficient: 0.2, reference_speed: 1.0, stiffness: 1e4 };
/// let contact = friction.under_load(10.0)?; // N
/// assert!((contact.hold(0.5, 0.0, 1.0).end_force - 3.0).abs() < 1e-12);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
pub trait Bristle<T: Scalar>: Debug + Clone {
    /// The state \[m\]: the scalar z, or the vector of the stretches xᵢ of several springs.
    type Deflection: Deflection<T>;

    /// The four coefficients λ, r, c₀, c₂ at a velocity. They depend on the deflection only in the
    /// forms [`Form::Switched`] and [`Form::Solved`].
    fn affine(
        &self,
        surface: Surface<T>,
        deflection: Self::Deflection,
    ) -> Affine<T, Self::Deflection>;

    /// The four coefficients and their derivatives with respect to the signed velocity.
    fn affine_and_slopes(
        &self,
        surface: Surface<T>,
        deflection: Self::Deflection,
    ) -> (Affine<T, Self::Deflection>, Affine<T, Self::Deflection>);

    /// The stationary deflection of steady sliding at a velocity, z_ss = sgn_ε(v) s μ(v)/σ0 \[m\],
    /// with sgn_ε(v) = v/|v|_ε (sgn v without a regularisation) and, in [`LuGre`], its g for μ. A
    /// bristle of several springs gives the stretch of each, one that creeps F_ss/(P K).
    fn stationary(&self, surface: impl Into<Surface<T>>) -> Self::Deflection;

    /// The stiffness Kᵢ [1/m] of each spring in the stored energy W = ½ P Σ Kᵢ xᵢ², with the
    /// reference load P \[N\] and the stretches xᵢ \[m\]. A Kelvin–Voigt bristle
    /// has K = σ0 and x = z.
    fn storage_stiffness(&self) -> Self::Deflection;

    /// The friction scale s = p/P \[–\] from which on the force balance has several solutions.
    /// Only an [`ImplicitBristle`] over a falling curve has one: the load scales the curve, and
    /// where s μ falls by more than σ1 [s/m], several velocities of the tip carry the same force.
    /// Keep the load below it. From it on steps are still passive, but [`Contact::response_under`]
    /// is NaN, so that a solver stops.
    fn folding_scale(&self) -> Option<T> {
        None
    }

    /// What the coefficients depend on, see [`Form`] for who asks. The default,
    /// [`Form::Switched`], promises nothing.
    fn form(&self) -> Form {
        Form::Switched
    }

    /// A name for reports and refusals.
    fn name(&self) -> &'static str {
        "an unnamed model (see Bristle::name)"
    }

    /// The virtual friction coefficient μ_b \[–\] of steady sliding at a velocity, signed: the
    /// F_ss/P of [`Law::SteadySliding`] for a model that obeys it.
    fn stationary_coefficient(&self, surface: impl Into<Surface<T>>) -> T {
        let surface = surface.into();
        self.coefficient(surface, self.stationary(surface))
    }

    /// Whether a theorem cited at [`Law`] proves that this model, with its parameters, obeys a law.
    /// A "no" mostly means that there is a counterexample. It may also mean that the conditions of
    /// the theorem are not met or not known (of a closure, say).
    fn obeys(&self, law: Law) -> bool {
        let _ = law;
        false
    }

    /// The limits of deflection, force and relaxation rate that the model's theorems give for
    /// velocities with |v| ≤ |`fastest`| [m/s], which may be infinite. By default, and for NaN,
    /// there are none.
    fn limits(&self, fastest: T) -> Limits<T> {
        let _ = fastest;
        Limits { deflection: None, coefficient: None, relaxation_rate: None }
    }

    /// The parameters σ0, σ1, σ2, μ_s, μ_d of the model, with bounds of them over all velocities,
    /// and the least slope of its curve at speeds up to `fastest` [m/s]. `None` for a model that
    /// does not give them, which is the default, and for a speed that is negative or not finite.
    /// Without them
    ///
    /// - an observer with [`Injection::Position`](crate::control::Injection::Position), which needs
    ///   σ1, is refused; with `Injection::Velocity` only models with LuGre's coefficients need
    ///   them;
    /// - a [`FeedbackCompensator`](crate::control::FeedbackCompensator) takes σ2 as zero, and has
    ///   no `step_per_count`;
    /// - an audit of bristle-analysis leaves most of its rows open.
    fn characteristics(&self, fastest: T) -> Option<Characteristics<T>> {
        let _ = fastest;
        None
    }

    /// The deflection rate ż [m/s].
    #[inline]
    fn rate(
        &self,
        surface: impl Into<Surface<T>>,
        deflection: Self::Deflection,
    ) -> Self::Deflection {
        let surface = surface.into();
        self.affine(surface, deflection).rate(surface.velocity(), deflection)
    }

    /// The virtual friction coefficient μ_b = F/P \[–\], the force over the reference load: F/p
    /// only where s = 1.
    #[inline]
    fn coefficient(&self, surface: impl Into<Surface<T>>, deflection: Self::Deflection) -> T {
        let surface = surface.into();
        self.affine(surface, deflection).coefficient(surface.velocity(), deflection)
    }

    /// Rate and coefficient at any state with all their partial derivatives: for the Jacobian of an
    /// implicit method, or the poles of a stuck body. By default those of coefficients that do not
    /// depend on z: a model of another [`Form`] adds ∂λ/∂z and the others.
    #[inline]
    fn linearised(
        &self,
        surface: impl Into<Surface<T>>,
        deflection: Self::Deflection,
    ) -> Linearised<T, Self::Deflection> {
        let surface = surface.into();
        let (affine, slopes) = self.affine_and_slopes(surface, deflection);
        Linearised::new(&affine, &slopes, surface.velocity(), deflection)
    }

    /// [`Bristle::linearised`] at the deflection of steady sliding, without its cancellation: for
    /// the poles and the transfer function of small motions about steady sliding.
    ///
    /// There ∂ż/∂v = −λ' z + r' v + r is a difference of terms of order one. What is left of it,
    /// for FrBD (|v|_ε/g)(μ sgn_ε)', is small, and its sign decides whether small motions grow. A
    /// model that can write that down does; else a difference of a few roundings counts as zero.
    fn steady_linearised(&self, surface: impl Into<Surface<T>>) -> Linearised<T, Self::Deflection> {
        let surface = surface.into();
        let velocity = surface.velocity();
        let deflection = self.stationary(surface);
        let linearised = self.linearised(surface, deflection);
        let (affine, slopes) = self.affine_and_slopes(surface, deflection);
        let relaxed = <Self::Deflection as Deflection<T>>::relax(slopes.relaxation, deflection);
        let rate_terms =
            relaxed.largest() + (slopes.drive * velocity).largest() + affine.drive.largest();
        let coefficient_terms = slopes.stiffness.inner_product(deflection).abs()
            + (slopes.damping * velocity).abs()
            + affine.damping.abs();
        Linearised {
            rate_by_velocity: linearised.rate_by_velocity.each(|x| cleared(x, rate_terms)),
            coefficient_by_velocity: cleared(linearised.coefficient_by_velocity, coefficient_terms),
            ..linearised
        }
    }

    /// The largest friction coefficient s B \[–\] that the surface holds: its scale times the
    /// largest μ at speeds up to |v|, in the direction of `carried`, the coefficient Σ Kᵢ xᵢ \[–\]
    /// that the springs carry now. Only a load that varies asks for it: a bristle that carries more
    /// slips back ([`Contact::reload`], [`Contact::response_under`]). By default it comes from the
    /// limit of the deflection up to that speed; without one, it is the larger of steady sliding at
    /// |v| and at rest.
    fn holding_coefficient(&self, surface: Surface<T>, carried: T) -> T {
        let stiffness = self.storage_stiffness();
        if let Some(most) = self.limits(surface.velocity()).deflection {
            return surface.apply(stiffness.inner_product(Self::Deflection::fill(most)));
        }
        surface.largest_up_to(carried, |surface| {
            stiffness.inner_product(self.stationary(surface)).abs()
        })
    }

    /// What is left of a deflection after a `change` of the load, on the `surface` under the new
    /// load. [`Contact::reload`] asks this; call that. A model of your own overrides it only if its
    /// bristle slips back in another way, and must not raise Σ Kᵢ xᵢ². By default the tip slips:
    /// every stretch shifts by the same length, until of Σ Kᵢ xᵢ the share
    /// [`LoadChange::kept_by`] is left.
    #[inline]
    fn held(
        &self,
        change: LoadChange<T>,
        surface: Surface<T>,
        deflection: Self::Deflection,
    ) -> Self::Deflection {
        let stiffness = self.storage_stiffness();
        let carried = stiffness.inner_product(deflection);
        let kept = change.kept_by(self, surface, carried);
        if Self::Deflection::SPRINGS == 1 || kept == T::one() || is_zero(change.after) {
            deflection * kept
        } else {
            let total = stiffness.inner_product(Self::Deflection::fill(T::one()));
            deflection - Self::Deflection::fill(carried * (T::one() - kept) / total)
        }
    }

    /// The step of length h ≥ 0 \[s\] at a held velocity [m/s], exact for [`Form::OfVelocity`]; see
    /// [`Form`] for the others and [`Contact::hold`] for when to take it.
    #[inline]
    fn hold(
        &self,
        surface: impl Into<Surface<T>>,
        deflection: Self::Deflection,
        duration: T,
    ) -> HeldStep<T, Self::Deflection> {
        let surface = surface.into();
        self.affine(surface, deflection).hold(surface.velocity(), deflection, duration)
    }

    /// A quantity that passes zero where rate and force have a kink beside v = 0, such as what
    /// exceeds the friction of a tip that sticks: see
    /// [`ode::System::switching_functions`](crate::ode::System::switching_functions). `None` for a
    /// model that is smooth on a branch.
    #[inline]
    fn switching_function(&self, surface: Surface<T>, deflection: Self::Deflection) -> Option<T> {
        let _ = (surface, deflection);
        None
    }

    /// Puts the model under a normal force p \[N\], zero or positive.
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite.
    fn under_load(self, normal_force: T) -> Checked<Contact<T, Self>> {
        Contact::new(self, normal_force)
    }
}

/// What the coefficients λ, r, c₀, c₂ of a model depend on beside its parameters. It decides how
/// accurate a step is, and who takes the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Form {
    /// The coefficients depend on the velocity alone: FrBD, LuGre, Dahl. At a held velocity rate
    /// and force are affine in the deflection, so [`Bristle::hold`] is exact and a companion step
    /// is of second order. Nothing refuses a model for this form.
    OfVelocity,
    /// The coefficients depend on the deflection, too, which switches them, as the α of
    /// [`ElastoPlastic`]. A step freezes them at its beginning, so `hold` and
    /// [`Companion::step`](crate::companion::Companion::step) are of first order;
    /// [`Companion::step_about`](crate::companion::Companion::step_about) freezes them at a
    /// predicted deflection and is of second order. Observers, patches and batches refuse the
    /// model; feed-forward and feedback compensators, contacts and scenes take it.
    Switched,
    /// The coefficients are the solution of an equation in the deflection, as in
    /// [`ImplicitBristle`]. Its `hold` follows the solution through the step; companion steps
    /// freeze it, as with [`Form::Switched`]. The same things refuse the model.
    Solved,
}

/// Deflection rate and virtual friction coefficient at one instant, with their partial derivatives:
/// small changes are δż = (∂ż/∂z) δz + (∂ż/∂v) δv and δμ_b likewise. [`LinearisedContact`] has the
/// force in newtons; take that one in a mechanism.
///
/// [`LinearisedContact`]: crate::LinearisedContact
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Linearised<T: Scalar, D: Deflection<T> = T> {
    /// Deflection rate ż [m/s].
    pub rate: D,
    /// Virtual friction coefficient μ_b \[–\].
    pub coefficient: T,
    /// ∂ż/∂z [1/s], with the sign: a relaxing bristle has a negative one.
    pub rate_by_deflection: D::Relaxation,
    /// ∂ż/∂v \[–\].
    pub rate_by_velocity: D,
    /// ∂μ_b/∂z [1/m].
    pub coefficient_by_deflection: D,
    /// ∂μ_b/∂v [s/m].
    pub coefficient_by_velocity: T,
}

impl<T: Scalar, D: Deflection<T>> Linearised<T, D> {
    /// The derivatives of a model whose coefficients depend on the velocity alone, from the two
    /// results of [`Bristle::affine_and_slopes`]: for a [`Bristle::linearised`] of your own.
    #[inline]
    pub fn new(affine: &Affine<T, D>, slopes: &Affine<T, D>, velocity: T, deflection: D) -> Self {
        Self {
            rate: affine.rate(velocity, deflection),
            coefficient: affine.coefficient(velocity, deflection),
            rate_by_deflection: -affine.relaxation,
            rate_by_velocity: slopes.rate(velocity, deflection) + affine.drive,
            coefficient_by_deflection: affine.stiffness,
            coefficient_by_velocity: slopes.coefficient(velocity, deflection) + affine.damping,
        }
    }
}

/// Bounds of a model for a range of velocities, proved by theorems, without the load. Those of
/// a contact are [`ContactLimits`](crate::ContactLimits). `None` where a model has no such theorem,
/// or only an infinite limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits<T> {
    /// A bristle that starts with |z| ≤ this \[m\] stays there. (An elasto-plastic one whose α is
    /// frozen over a step can overshoot by |v| h; to cut it back only lowers the stored energy.)
    pub deflection: Option<T>,
    /// |F|/p never exceeds this \[–\] while the deflection is within its limit. The deflection of
    /// several springs has no limit: then this holds in runs that begin with all stretches at zero.
    pub coefficient: Option<T>,
    /// An upper bound of the relaxation rate λ [1/s]; with several springs λ is a matrix, and this
    /// bounds its largest eigenvalue. λ may stay well below it: FrBD's bound takes the least μ of
    /// the range at the fastest speed. It also bounds the decay −∂ż/∂z of a disturbance, but for
    /// [`ElastoPlastic`], whose α switches more steeply: see [`Linearised::rate_by_deflection`].
    pub relaxation_rate: Option<T>,
}

impl<T: Scalar> Limits<T> {
    /// The limits of a model for speeds up to `fastest`, without its sign; none for NaN.
    fn up_to(fastest: T, of: impl FnOnce(T) -> Self) -> Self {
        let fastest = fastest.abs();
        if fastest >= T::zero() {
            of(fastest)
        } else {
            Self { deflection: None, coefficient: None, relaxation_rate: None }
        }
    }
}

/// A difference, unless it is a few roundings of the terms it is made of: then zero.
fn cleared<T: Scalar>(difference: T, terms: T) -> T {
    let rounding = lit::<T>(16.0) * T::default_epsilon() * terms;
    if rounding.is_finite() && difference.abs() <= rounding { T::zero() } else { difference }
}

/// A limit, unless it is infinite or not a number.
pub(crate) fn finite<T: Scalar>(limit: T) -> Option<T> {
    limit.is_finite().then_some(limit)
}
