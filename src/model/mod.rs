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

use crate::parameter::ParameterError;
use crate::rheology::Deflection;
use crate::scalar::{is_zero, lit};
use crate::{Contact, LoadChange, Scalar, Surface};

/// A dynamic friction model per unit normal force: the bristle deflection z \[m\] as state, the
/// sliding velocity v as input, the virtual friction coefficient μ_b = F/p \[–\] as output.
///
/// Every model of this crate is affine in z at a given velocity (see [`Affine`]):
///
/// ż = −λ(v) z + r(v) v,  μ_b = c₀(v) z + c₂(v) v.
///
/// A model of your own writes down four things: these coefficients, their slopes, the deflection of
/// steady sliding and the stiffness in its stored energy. Contacts, companions, scenes and batches
/// need no more. What asks for a form, a law or a limit gets a pessimistic answer until you give
/// one: a patch and an observer ask for [`Form::OfVelocity`], an observer also for the laws
/// [`Secant`](Law::Secant) and [`Passivity`](Law::Passivity).
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
///
/// The velocity comes as a [`Surface`], with the scale of the friction: a plain number or a
/// [`Sliding`](crate::Sliding) on a locked branch stand for a scale of one.
/// [`Bristle::under_load`] adds the normal force, for forces in newtons and energies in joules.
pub trait Bristle<T: Scalar>: Debug + Clone {
    /// The state: a scalar, or a vector for a bristle with internal states.
    type Deflection: Deflection<T>;

    /// The four coefficients at a velocity. They depend on the deflection only where a model
    /// switches with it (elasto-plastic) or solves for it (the implicit bristle).
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

    /// The stationary deflection of steady sliding at a velocity, z_ss = sgn_ε(v) μ(v)/σ0 \[m\]; of
    /// several springs, their stretches.
    fn stationary(&self, surface: impl Into<Surface<T>>) -> Self::Deflection;

    /// The stiffness [1/m] of each spring in the stored energy W = ½ p Σ Kᵢ xᵢ².
    fn storage_stiffness(&self) -> Self::Deflection;

    /// The friction scale s = p/P \[–\] from which on several rates fit, if there is one (an
    /// implicit bristle has one). Steps stay passive there, but the response under such a load is
    /// NaN, so that a solver stops at once.
    fn folding_scale(&self) -> Option<T> {
        None
    }

    /// What the coefficients depend on. What works with some forms only asks this: an observer when
    /// it is built, a patch in every motion. The default promises nothing.
    fn form(&self) -> Form {
        Form::Switched
    }

    /// A name for reports and refusals.
    fn name(&self) -> &'static str {
        "an unnamed model (see Bristle::name)"
    }

    /// The friction coefficient μ_b \[–\] of steady sliding at a velocity.
    fn stationary_coefficient(&self, surface: impl Into<Surface<T>>) -> T {
        let surface = surface.into();
        self.coefficient(surface, self.stationary(surface))
    }

    /// Whether this model, with its parameters, obeys a law by one of the theorems cited at
    /// [`Law`]. A "no" mostly means a counterexample; it may also mean that the theorem's
    /// conditions are not met, or cannot be told (closures, say), without the law being broken.
    fn obeys(&self, law: Law) -> bool {
        let _ = law;
        false
    }

    /// The limits that the model's theorems give for velocities with |v| ≤ `fastest` (which may
    /// be infinite; without its sign, and nothing is promised for NaN). By default there are none.
    fn limits(&self, fastest: T) -> Limits<T> {
        let _ = fastest;
        Limits { deflection: None, coefficient: None, relaxation_rate: None }
    }

    /// The parameters and bounds of the model for speeds up to `fastest` [m/s]. An audit needs
    /// them; an observer by position takes σ1 from them, and what compensates a viscous term
    /// outside the bristle takes σ2. `None` for a model that does not expose them (then σ2 counts
    /// as zero), or a speed that is negative or not finite.
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

    /// The virtual friction coefficient μ_b = F/p \[–\].
    #[inline]
    fn coefficient(&self, surface: impl Into<Surface<T>>, deflection: Self::Deflection) -> T {
        let surface = surface.into();
        self.affine(surface, deflection).coefficient(surface.velocity(), deflection)
    }

    /// Rate and coefficient with all their partial derivatives. By default those of coefficients
    /// that do not depend on z: a model of another [`Form`] adds ∂λ/∂z and the others.
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

    /// Rate and coefficient of steady sliding with all their partial derivatives.
    ///
    /// There ∂ż/∂v = −λ' z + r' v + r is a difference of terms of order one, of which (|v|_ε/g)(μ
    /// sgn_ε)' is left, and its sign decides whether small motions grow. A model that can write
    /// that down does; else a difference of a few roundings of its terms counts as zero.
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

    /// The largest friction coefficient \[–\] that the surface holds at speeds up to |v|, in the
    /// direction of `carried`, the coefficient Σ Kᵢ xᵢ \[–\] that the springs carry now. If they
    /// carry more after the load has fallen, the bristle slips back
    /// ([`Contact::reload`](crate::Contact::reload)). By default from the limit of the deflection
    /// up to that speed; without one, the larger of those of steady sliding at |v| and at rest.
    fn holding_coefficient(&self, surface: Surface<T>, carried: T) -> T {
        let stiffness = self.storage_stiffness();
        if let Some(most) = self.limits(surface.velocity()).deflection {
            return surface.apply(stiffness.inner_product(Self::Deflection::fill(most)));
        }
        surface.largest_up_to(carried, |surface| {
            stiffness.inner_product(self.stationary(surface)).abs()
        })
    }

    /// What is left of a deflection after a `change` of the load, on the surface under the new one,
    /// see [`Contact::reload`](crate::Contact::reload). By default the tip slips: every stretch
    /// shifts alike.
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

    /// The exact step of length h ≥ 0 \[s\] at a held velocity [m/s].
    ///
    /// An elasto-plastic model's α is frozen at the beginning of the step. The implicit bristle's
    /// tip is followed, see [`ImplicitBristle`](crate::ImplicitBristle).
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

    /// Puts the model under a normal force p \[N\], zero or positive.
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite.
    fn under_load(self, normal_force: T) -> Result<Contact<T, Self>, ParameterError> {
        Contact::new(self, normal_force)
    }
}

/// What the coefficients of a model depend on besides parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Form {
    /// The velocity alone: at a velocity rate and force are affine in the deflection.
    OfVelocity,
    /// The deflection, too: it switches them, as in an elasto-plastic bristle. A step freezes them.
    Switched,
    /// The deflection, too: they are solved for, as in the implicit bristle.
    Solved,
}

/// Deflection rate and virtual friction coefficient at one instant, with their partial derivatives.
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
    /// The derivatives of a model whose coefficients depend on the velocity alone.
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

/// Bounds of a model for a range of velocities, proved by theorems, per unit normal force. Those of
/// a contact are [`ContactLimits`](crate::ContactLimits). `None` where a model has no such theorem,
/// or only an infinite limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits<T> {
    /// A bristle that starts with |z| ≤ this \[m\] stays there. (An elasto-plastic one whose α is
    /// frozen over a step can overshoot by |v| h; to cut it back only lowers the stored energy.)
    pub deflection: Option<T>,
    /// Within the deflection limit, |F|/p never exceeds this \[–\]. With
    /// a bristle of several springs, which has no deflection limit: in every run from rest, all
    /// stretches zero.
    pub coefficient: Option<T>,
    /// An upper bound of the relaxation rate λ [1/s]; of several springs, of every eigenvalue. It
    /// need not be met: FrBD's takes the least μ of the range at its fastest speed, and lies above
    /// the largest λ where the curve has risen again.
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
