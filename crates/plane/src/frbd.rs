//! FrBD on several axes.

use nalgebra::SVector;

use super::surface::{surfaces, surfaces_and_slopes};
use super::{Axis, AxisSurface, PlaneBristle, PlaneLimits};
use bristle::curve::FrictionCurve;
use bristle::parameter::{Checked, Named, ParameterError};
use bristle::regularisation::{Regularisation, Unregularised};
use bristle::rheology::{KelvinVoigt, Rheology};
use bristle::scalar::lit;
use bristle::{FrBd, Law, Scalar};

/// A bristle on the surface that its axis feels.
type AxisFrBd<T> = FrBd<AxisSurface<T>, KelvinVoigt<T>, AxisSurface<T>>;

/// FrBD with Kelvin–Voigt bristles on N axes; the [module](super) has the equations.
///
/// ```
/// use bristle::curve::Stribeck;
/// use bristle::nalgebra::Vector2;
/// use bristle::paper;
/// use bristle_plane::{PlaneBristle, PlaneFrBd};
/// use bristle::rheology::KelvinVoigt;
///
/// let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
/// let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
/// let block = PlaneFrBd::isotropic(curve, bristle).under_load(4.0)?; // N
/// // Sliding steadily at 0.1 m/s, 22.5° off the first axis: the force is opposite to the velocity.
/// let v = Vector2::new(0.1 * 22.5_f64.to_radians().cos(), 0.1 * 22.5_f64.to_radians().sin());
/// let force = block.stationary_force(&v);
/// assert!((force.y / force.x - v.y / v.x).abs() < 1e-12);
/// assert!((force.norm() - 4.0 * 1.004).abs() < 1e-9);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneFrBd<C, T, const N: usize, E = Unregularised> {
    curve: C,
    axes: [Axis<T>; N],
    regularisation: E,
}

impl<T: Scalar, C: FrictionCurve<T>, const N: usize> PlaneFrBd<C, T, N> {
    /// The model of a friction curve over the speed ‖v‖ and a bristle on each axis.
    ///
    /// # Errors
    ///
    /// Refuses a friction ratio outside 1e-100 … 1e100 (`f32`: 1e-18 … 1e15), and names its axis.
    pub fn new(curve: C, axes: [Axis<T>; N]) -> Checked<Self> {
        let positive = |axis: &Axis<T>| Named("friction_ratio", axis.friction_ratio).positive();
        ParameterError::of_components(&axes, positive)?;
        Ok(Self { curve, axes, regularisation: Unregularised })
    }

    /// The model with one bristle for all axes, of friction ratio 1: no direction is special.
    pub fn isotropic(curve: C, bristle: KelvinVoigt<T>) -> Self {
        let axis = Axis { friction_ratio: T::one(), bristle };
        Self { curve, axes: [axis; N], regularisation: Unregularised }
    }
}

impl<T: Scalar, C, const N: usize, E> PlaneFrBd<C, T, N, E> {
    /// Each bristle on the surface that its axis feels.
    #[inline(always)]
    fn on(&self, surfaces: [AxisSurface<T>; N]) -> [AxisFrBd<T>; N] {
        core::array::from_fn(|i| {
            FrBd::new(surfaces[i], self.axes[i].bristle).regularised(surfaces[i])
        })
    }

    /// The model with another regularisation of the weighted speed.
    pub fn regularised<F>(self, regularisation: F) -> PlaneFrBd<C, T, N, F> {
        PlaneFrBd { curve: self.curve, axes: self.axes, regularisation }
    }

    /// The friction curve.
    pub fn curve(&self) -> &C {
        &self.curve
    }

    /// The bristles, with their shares of the friction.
    pub fn bristles(&self) -> &[Axis<T>; N] {
        &self.axes
    }

    /// The regularisation.
    pub fn regularisation(&self) -> &E {
        &self.regularisation
    }

    /// Whether no bristle is damped.
    pub(super) fn is_undamped(&self) -> bool {
        self.axes.iter().all(|axis| axis.bristle.bounds().damping.max == T::zero())
    }
}

impl<T, C, E, const N: usize> PlaneBristle<T, N> for PlaneFrBd<C, T, N, E>
where
    T: Scalar,
    C: FrictionCurve<T>,
    E: Regularisation<T>,
{
    type Axis = AxisFrBd<T>;

    #[inline(always)]
    fn axes(&self, velocity: &SVector<T, N>) -> [Self::Axis; N] {
        let surfaces = surfaces((&self.curve, &self.regularisation), &self.axes, velocity);
        self.on(surfaces)
    }

    #[inline(always)]
    fn axes_and_slopes(&self, velocity: &SVector<T, N>) -> ([Self::Axis; N], SVector<T, N>) {
        let parts = (&self.curve, &self.regularisation);
        let (surfaces, gradient) = surfaces_and_slopes(parts, &self.axes, velocity);
        (self.on(surfaces), gradient)
    }

    #[inline]
    fn storage_stiffness(&self) -> SVector<T, N> {
        SVector::from_fn(|i, _| self.axes[i].bristle.storage_stiffness())
    }

    fn limits(&self, fastest: T) -> PlaneLimits<T, N> {
        self.limits_with(fastest, T::one())
    }

    fn obeys(&self, law: Law) -> bool {
        match law {
            // The curve is taken at the speed, which knows no sign.
            Law::SteadySliding
            | Law::Secant
            | Law::Passivity
            | Law::BoundedForce
            | Law::OddSymmetry => true,
            Law::BoundedDeflection => self.limits(T::one()).deflection.is_some(),
            Law::BoundedRelaxation => self.limits(T::unlimited()).relaxation_rate.is_some(),
            _ => false,
        }
    }
}

impl<T: Scalar, C: FrictionCurve<T>, E: Regularisation<T>, const N: usize> PlaneFrBd<C, T, N, E> {
    /// The limits, with a share of the damping σ1 in g: one, or zero for LuGre's relaxation.
    pub(super) fn limits_with(&self, fastest: T, share: T) -> PlaneLimits<T, N> {
        let fastest = fastest.abs();
        let highest = if fastest >= T::zero() { self.curve.bounds(fastest).max } else { fastest };
        let mu = finite(highest);
        // σ0, σ1 and a².
        let parts = self.axes.each_ref().map(|axis| {
            let damping = share * axis.bristle.bounds().damping.max;
            (axis.bristle.storage_stiffness(), damping, axis.friction_ratio * axis.friction_ratio)
        });
        // μ/n ≥ (least μ/|s|_ε)/max(a, 1), because |a s|_ε ≤ max(a, 1) |s|_ε.
        let steepest = self.axes.iter().fold(T::one(), |a, axis| a.larger(axis.friction_ratio));
        let slope = self.curve.least_secant(&self.regularisation, fastest) / steepest;
        let rates =
            parts.map(|(stiffness, damping, square)| stiffness / (damping + square * slope));
        // λᵢ = n/(μ aᵢ²/σ0ᵢ + n σ1ᵢ/σ0ᵢ) is one number for all axes if both quotients are, to a
        // few roundings.
        let near = |a: T, b: T| (a - b).abs() <= lit::<T>(8.0) * T::default_epsilon() * b.abs();
        let quotients =
            parts.map(|(stiffness, damping, square)| [square / stiffness, damping / stiffness]);
        let alike = |other: &[T; 2]| (0..2).all(|i| near(quotients[0][i], other[i]));
        PlaneLimits {
            deflection: mu.map(|mu| {
                SVector::from_fn(|i, _| {
                    mu * self.axes[i].friction_ratio / self.axes[i].bristle.storage_stiffness()
                })
            }),
            coefficient: mu.map(|mu| SVector::from_fn(|i, _| mu * self.axes[i].friction_ratio)),
            relaxation_rate: finite(
                rates.into_iter().fold(T::zero(), |most, rate| rate.larger(most)),
            ),
            ellipsoid: mu.is_some() && quotients.iter().all(alike),
        }
    }
}

/// A limit, unless it is infinite or not a number.
fn finite<T: Scalar>(limit: T) -> Option<T> {
    limit.is_finite().then_some(limit)
}
