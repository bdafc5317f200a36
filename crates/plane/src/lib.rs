//! Bristles of several axes: a block pushed in a plane, a finger that twists, a wheel that steers.
//!
//! The friction obeys maximum dissipation on an ellipsoid of friction with the semi-axes μᵢ = aᵢ μ,
//! frozen at the rigid velocity v ∈ ℝᴺ. With a Kelvin–Voigt bristle on each axis,
//!
//! żᵢ = −λᵢ zᵢ + rᵢ vᵢ,   Fᵢ/p = c₀ᵢ zᵢ + c₂ᵢ vᵢ,
//!
//! λᵢ = σ0ᵢ n/gᵢ,  rᵢ = aᵢ² μ/gᵢ,  c₀ᵢ = σ0ᵢ rᵢ,  c₂ᵢ = σ1ᵢ rᵢ,  gᵢ = aᵢ² μ + σ1ᵢ n.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | v, z | sliding velocity, bristle deflection, one component for each axis | m/s, m |
//! | s = ‖v‖ | sliding speed, where the friction curve μ is taken | m/s |
//! | n = ‖(aᵢ vᵢ)‖_ε | weighted speed, regularised | m/s |
//! | aᵢ | friction ratio of axis i: its friction over the curve | – |
//! | σ0ᵢ, σ1ᵢ | stiffness and damping of the bristle of axis i | 1/m, s/m |
//! | p, F | normal force; friction force, against the motion: m v̇ = … − F | N |
//!
//! The axes meet in the numbers μ and n alone. Given these, each axis is a scalar model, a
//! [`FrBd`](bristle::FrBd) whose curve is aᵢ² μ and whose |v|_ε is n. So the rates, forces, exact
//! and passive steps of each axis are those of the scalar model, and with one axis of ratio 1 they
//! are the scalar model's to the last bit. All coefficients depend on n/μ alone: one evaluation of
//! each axis and the gradient of n/μ give the derivatives with respect to all velocities.
//!
//! # What is guaranteed
//!
//! * Dissipation: F·v − Ẇ = p(‖M(v − ż)‖²/(μ n) + Σ σ1ᵢ żᵢ²) ≥ 0 with M = diag(μᵢ) and
//!   W = ½ p Σ σ0ᵢ zᵢ², for every anisotropy, every curve and any number of axes.
//! * Box: |zᵢ| ≤ aᵢ max μ/σ0ᵢ and |Fᵢ| ≤ p aᵢ max μ are never left from inside.
//! * Ellipsoid: Σ (σ0ᵢ zᵢ/aᵢ)² ≤ max μ² is never left if all relaxation rates are equal.
//! * Steady sliding: Fᵢ = p μ aᵢ² vᵢ/n, opposite to v if all aᵢ are equal.
//!
//! All of it holds for a normal force that varies, too, told by [`PlaneContact::reload`].
//!
//! It holds where neither μ nor σ1ᵢ n overflows or underflows: take it for speeds from 1e-100 to
//! 1e100 m/s (`f32`: 1e-18 to 1e15) and at rest. Far above, the force is NaN; far below, only
//! the box holds.
//!
//! Two scalar contacts at right angles do not give this: at 45° they resist with √2 times the
//! friction of one.
//!
//! # Rotation as an axis
//!
//! A contact that spins at ω [rad/s] about its normal takes R ω [m/s] as an axis; the torque is R
//! times the force of that axis. [`DiscPressure::spin_radius`] gives R. The limit surface, the set
//! of all forces and torques of steady sliding, is then an ellipsoid. That of a disc differs from
//! it by a few per cent; [`Footprint`] sums over the points of a patch. With R = 0 there is no
//! torque: leave the axis out, because its mass J/R² would be infinite.
//!
//! Source: the construction of Romano et al. (arXiv 2602.09429), section II, with the ellipsoid of
//! friction for the scalar curve; W. D. Howe, M. R. Cutkosky, "Practical force-motion models for
//! sliding manipulation", Int. J. Robotics Research 15 (1996), for the ellipsoidal limit surface.
#![no_std]
#![cfg_attr(docsrs, feature(doc_cfg))]

#[cfg(feature = "alloc")]
extern crate alloc;

mod body;
mod companion;
mod contact;
mod footprint;
mod frbd;
mod limit_surface;
mod lugre;
mod pushes;
#[cfg(feature = "alloc")]
mod support;
mod surface;

use core::fmt::Debug;

use nalgebra::SVector;
#[cfg(feature = "serde")]
mod serialisation;

pub use body::{PlaneBody, PlaneBodyParameters};
pub use companion::{PlaneCompanion, PlaneCompanionStep};
pub use contact::{LinearisedPlane, PlaneContact, Turned};
pub use footprint::{
    DiscPressure, Footprint, FootprintCompanion, FootprintPoint, FootprintStep, LimitEllipsoid,
};
pub use frbd::PlaneFrBd;
pub use limit_surface::{FrictionEllipsoid, LimitSurfaceError, SlidingTwist};
pub use lugre::PlaneLuGre;
pub use pushes::{EllipsoidFamily, EllipsoidFit, Push};
#[cfg(feature = "alloc")]
pub use support::Support;
pub use surface::AxisSurface;

use bristle::parameter::Checked;
use bristle::rheology::KelvinVoigt;
use bristle::{Bristle, Law, Scalar};

/// The bristle of one axis, and its share of the friction.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
#[cfg_attr(feature = "serde", serde(bound(deserialize = "T: Scalar + serde::Deserialize<'de>")))]
#[cfg_attr(feature = "serde", serde(bound(serialize = "T: Scalar + serde::Serialize")))]
pub struct Axis<T> {
    /// Friction aᵢ of this axis over the friction curve \[–\], positive.
    pub friction_ratio: T,
    /// The bristle: σ0ᵢ, σ1ᵢ.
    pub bristle: KelvinVoigt<T>,
}

/// A friction model of N axes per unit normal force: at a velocity, a scalar model for each axis.
///
/// [`PlaneBristle::under_load`] adds the normal force and with it forces, steps and energies.
pub trait PlaneBristle<T: Scalar, const N: usize>: Debug + Clone {
    /// What one axis is at a given velocity.
    type Axis: Bristle<T, Deflection = T>;

    /// The model of each axis at a velocity [m/s], to be evaluated at that axis's component.
    fn axes(&self, velocity: &SVector<T, N>) -> [Self::Axis; N];

    /// The models with derivatives, which they all have through one number u(v): the axes, whose
    /// [slopes](Bristle::affine_and_slopes) are with respect to u, and the gradient ∂u/∂vⱼ. Every
    /// coefficient c has ∂cᵢ/∂vⱼ = (∂cᵢ/∂u)(∂u/∂vⱼ). At v = 0 the derivatives depend on the
    /// direction; a gradient of zero stands for them.
    fn axes_and_slopes(&self, velocity: &SVector<T, N>) -> ([Self::Axis; N], SVector<T, N>);

    /// The stiffness σ0ᵢ [1/m] of each axis in the stored energy W = ½ p Σ σ0ᵢ zᵢ².
    fn storage_stiffness(&self) -> SVector<T, N>;

    /// The limits that theorems give for speeds ‖v‖ ≤ `fastest` [m/s], which may be infinite.
    fn limits(&self, fastest: T) -> PlaneLimits<T, N>;

    /// Whether the model obeys a law by a theorem, with F·v and the box of
    /// [`PlaneBristle::limits`] for their scalar counterparts.
    fn obeys(&self, law: Law) -> bool;

    /// Puts the model under a normal force p \[N\], zero or positive.
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite.
    fn under_load(self, normal_force: T) -> Checked<PlaneContact<T, Self, N>> {
        PlaneContact::new(self, normal_force)
    }
}

/// Limits of a [`PlaneBristle`] for a range of speeds, per unit normal force. `None` where there is
/// no theorem, or only an infinite limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneLimits<T: Scalar, const N: usize> {
    /// Bristles that start with |zᵢ| ≤ this \[m\] on every axis stay there.
    pub deflection: Option<SVector<T, N>>,
    /// Within these deflections |Fᵢ|/p never exceeds this \[–\].
    pub coefficient: Option<SVector<T, N>>,
    /// Upper bound of the relaxation rates of all axes [1/s].
    pub relaxation_rate: Option<T>,
    /// Whether the deflection stays within the ellipsoid with these semi-axes, too, and with it the
    /// force, if that has limits: so it is if the relaxation rates of all axes are equal.
    pub ellipsoid: bool,
}

impl<T: Scalar, const N: usize> PlaneLimits<T, N> {
    /// What bristles carry over what the surface holds under a friction scale s \[–\]: the norm of
    /// σ0ᵢ zᵢ over aᵢ s max μ where the ellipsoid is kept, its largest component elsewhere; zero
    /// without a limit.
    pub fn utilisation(&self, deflection: &SVector<T, N>, scale: T) -> T {
        let Some(most) = self.deflection else { return T::zero() };
        let shares = deflection.zip_map(&most, |z, most| (z / (scale * most)).abs());
        if self.ellipsoid { shares.norm() } else { shares.max() }
    }
}

/// A length; NaN for a negative one.
fn length<T: Scalar>(length: T) -> T {
    if length >= T::zero() { length } else { T::nan() }
}

/// The README's program compiles and runs.
#[cfg(all(doctest, feature = "alloc"))]
#[doc = include_str!("../README.md")]
struct Readme;

/// So do those of the page.
#[cfg(all(doctest, feature = "alloc"))]
#[doc = include_str!("../docs/plane.md")]
struct Page;
