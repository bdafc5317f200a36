//! Bristles of several axes: a block pushed in a plane, a finger that twists, a wheel that steers.
//!
//! The friction obeys maximum dissipation on an ellipsoid of friction M = diag(μᵢ), μᵢ = aᵢ μ(s),
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
//! | aᵢ | friction of axis i over the curve | – |
//! | σ0ᵢ, σ1ᵢ | stiffness and damping of the bristle | 1/m, s/m |
//! | p, F | normal force; friction force, which opposes v | N |
//!
//! The axes meet in n and s alone: given those, each axis is a scalar [`Affine`] bristle. With one
//! axis and a₁ = 1 this is [`FrBd`](crate::FrBd) with a Kelvin–Voigt bristle.
//!
//! # What is guaranteed
//!
//! * Dissipation: F·v − Ẇ = p(‖M(v − ż)‖²/N + Σ σ1ᵢ żᵢ²) ≥ 0 with N = μ n and
//!   W = ½ p Σ σ0ᵢ zᵢ², for every anisotropy, every curve and any number of axes.
//! * Box: |zᵢ| ≤ aᵢ max μ/σ0ᵢ and |Fᵢ| ≤ p aᵢ max μ are never left from inside.
//! * Ball: Σ (σ0ᵢ zᵢ/aᵢ)² ≤ max μ² is never left if all relaxation rates are equal.
//! * Steady sliding: Fᵢ = p μ aᵢ² vᵢ/n, opposite to v if all aᵢ are equal.
//!
//! Two scalar contacts at right angles do not give this: at 45° they resist with √2 times the
//! friction of one.
//!
//! # Rotation as an axis
//!
//! A contact that spins at ω [rad/s] about its normal takes R ω [m/s] as an axis; the torque is R
//! times the force of that axis. [`spin_radius_of_disc`] and [`spin_radius_of_hertz_contact`] give
//! R. The limit surface is then an ellipsoid, which is within a few per cent of that of a disc.
//!
//! Source: the construction of Romano et al. (arXiv 2602.09429), section II, with the ellipsoid of
//! friction for the scalar curve; W. D. Howe, M. R. Cutkosky, "Practical force-motion models for
//! sliding manipulation", Int. J. Robotics Research 15 (1996), for the ellipsoidal limit surface.

mod contact;
mod frbd;
mod lugre;

use core::fmt::Debug;

use nalgebra::{SMatrix, SVector};

pub use contact::{
    CompletedPlaneStep, PlaneCompanion, PlaneCompanionStep, PlaneContact, PlaneLimits, Turned,
};
pub use frbd::PlaneFrBd;
pub use lugre::PlaneLuGre;

use crate::parameter::{self, ParameterError};
use crate::scalar::lit;
use crate::{Affine, Scalar};

/// The bristle of one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis<T> {
    /// Friction aᵢ of this axis over the friction curve \[–\], positive.
    pub friction_ratio: T,
    /// Stiffness σ0ᵢ [1/m], positive.
    #[doc(alias = "sigma0")]
    pub micro_stiffness: T,
    /// Damping σ1ᵢ [s/m], zero or positive.
    #[doc(alias = "sigma1")]
    pub micro_damping: T,
}

impl<T: Scalar> Axis<T> {
    fn checked(self) -> Result<Self, ParameterError> {
        parameter::positive("friction_ratio", self.friction_ratio)?;
        parameter::positive("micro_stiffness", self.micro_stiffness)?;
        parameter::non_negative("micro_damping", self.micro_damping)?;
        Ok(self)
    }
}

/// A friction model of N axes per unit normal force, affine in the deflection of each axis.
pub trait PlaneBristle<T: Scalar, const N: usize>: Debug + Clone {
    /// The coefficients of each axis at a velocity [m/s].
    fn affine(&self, velocity: &SVector<T, N>) -> [Affine<T>; N];

    /// The coefficients, and the derivatives of those of axis i with respect to the velocity of
    /// axis j in `slopes[i][j]`. At v = 0 the derivatives depend on the direction; zero stands for
    /// them.
    fn affine_and_slopes(&self, velocity: &SVector<T, N>) -> ([Affine<T>; N], [[Affine<T>; N]; N]);

    /// The bristles.
    fn axes(&self) -> &[Axis<T>; N];

    /// Limits for speeds ‖v‖ ≤ `fastest` [m/s].
    fn limits(&self, fastest: T) -> PlaneLimits<T, N>;

    /// Whether F·v ≥ Ẇ for every state and velocity, by a theorem.
    fn is_passive(&self) -> bool;

    /// Deflection rate ż [m/s].
    fn rate(&self, velocity: &SVector<T, N>, deflection: &SVector<T, N>) -> SVector<T, N> {
        let axes = self.affine(velocity);
        SVector::from_fn(|i, _| axes[i].rate(velocity[i], deflection[i]))
    }

    /// Force per unit normal force F/p \[–\].
    fn coefficient(&self, velocity: &SVector<T, N>, deflection: &SVector<T, N>) -> SVector<T, N> {
        let axes = self.affine(velocity);
        SVector::from_fn(|i, _| axes[i].coefficient(velocity[i], deflection[i]))
    }

    /// Rate and force per unit normal force with all their partial derivatives.
    fn linearised(
        &self,
        velocity: &SVector<T, N>,
        deflection: &SVector<T, N>,
    ) -> LinearisedPlane<T, N> {
        let (axes, slopes) = self.affine_and_slopes(velocity);
        let diagonal = |i, j, value: T| if i == j { value } else { T::zero() };
        LinearisedPlane {
            rate: SVector::from_fn(|i, _| axes[i].rate(velocity[i], deflection[i])),
            coefficient: SVector::from_fn(|i, _| axes[i].coefficient(velocity[i], deflection[i])),
            rate_by_deflection: SVector::from_fn(|i, _| -axes[i].relaxation),
            rate_by_velocity: SMatrix::from_fn(|i, j| {
                slopes[i][j].rate(velocity[i], deflection[i]) + diagonal(i, j, axes[i].drive)
            }),
            coefficient_by_deflection: SVector::from_fn(|i, _| axes[i].stiffness),
            coefficient_by_velocity: SMatrix::from_fn(|i, j| {
                slopes[i][j].coefficient(velocity[i], deflection[i])
                    + diagonal(i, j, axes[i].damping)
            }),
        }
    }

    /// Puts the model under a normal force p \[N\], zero or positive.
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite.
    fn under_load(self, normal_force: T) -> Result<PlaneContact<T, Self, N>, ParameterError> {
        PlaneContact::new(self, normal_force)
    }
}

/// Rate and force of a [`PlaneBristle`], per unit normal force, with their partial derivatives.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearisedPlane<T: Scalar, const N: usize> {
    /// Deflection rate ż [m/s].
    pub rate: SVector<T, N>,
    /// F/p \[–\].
    pub coefficient: SVector<T, N>,
    /// ∂żᵢ/∂zᵢ [1/s]; all others are zero.
    pub rate_by_deflection: SVector<T, N>,
    /// ∂ż/∂v \[–\].
    pub rate_by_velocity: SMatrix<T, N, N>,
    /// ∂(Fᵢ/p)/∂zᵢ [1/m]; all others are zero.
    pub coefficient_by_deflection: SVector<T, N>,
    /// ∂(F/p)/∂v [s/m].
    pub coefficient_by_velocity: SMatrix<T, N, N>,
}

/// The radius R \[m\] that turns the spin of a disc of this radius \[m\], under a uniform pressure,
/// into an axis R ω: its full friction torque is ⅔ of radius times force.
pub fn spin_radius_of_disc<T: Scalar>(radius: T) -> T {
    radius * lit(2.0 / 3.0)
}

/// The radius R \[m\] that turns the spin of a circular Hertz contact of this radius \[m\] into an
/// axis R ω: its full friction torque is 3π/16 of radius times force.
pub fn spin_radius_of_hertz_contact<T: Scalar>(radius: T) -> T {
    radius * lit(3.0 * core::f64::consts::PI / 16.0)
}

/// ‖x‖, without overflow or underflow on the way.
#[inline(always)]
fn norm<T: Scalar, const N: usize>(x: &SVector<T, N>) -> T {
    if N == 1 {
        return x[0].abs();
    }
    let square = x.norm_squared();
    // Squares of components that matter neither overflow nor lose digits within these limits.
    let small = T::default_epsilon() * T::default_epsilon();
    if square > small && square < T::one() / small { square.sqrt() } else { scaled_norm(x) }
}

#[cold]
fn scaled_norm<T: Scalar, const N: usize>(x: &SVector<T, N>) -> T {
    let largest = x.iter().fold(T::zero(), |most, x| if x.abs() <= most { most } else { x.abs() });
    if largest > T::zero() && largest.is_finite() {
        largest * x.map(|x| x / largest).norm_squared().sqrt()
    } else {
        largest
    }
}
