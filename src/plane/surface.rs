//! The surface at one velocity: the two numbers in which the axes meet, the friction coefficient
//! μ(s) at the speed s = ‖v‖ and the weighted speed n = ‖(aᵢ vᵢ)‖_ε, and what each axis feels of
//! them.

use nalgebra::SVector;

use super::Axis;
use crate::curve::FrictionCurve;
use crate::regularisation::Regularisation;
use crate::scalar::is_zero;
use crate::{Bounds, Scalar, Sliding};

/// The surface as one axis feels it at one velocity of all axes: a curve whose friction coefficient
/// is the number aᵢ² μ, and a regularisation whose |v|_ε is the number n.
///
/// See the [module](super) for the symbols. Being frozen at one velocity, it knows no others: for
/// limits take those of [`PlaneBristle`](super::PlaneBristle).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisSurface<T> {
    coefficient: T,
    coefficient_slope: T,
    speed: T,
    speed_slope: T,
}

impl<T: Scalar> AxisSurface<T> {
    /// What an axis of this friction ratio feels of the surface of ratio 1.
    #[inline(always)]
    fn under(self, ratio: T) -> Self {
        let square = ratio * ratio;
        Self {
            coefficient: square * self.coefficient,
            coefficient_slope: square * self.coefficient_slope,
            ..self
        }
    }
}

impl<T: Scalar> FrictionCurve<T> for AxisSurface<T> {
    #[inline(always)]
    fn coefficient(&self, _: Sliding<T>) -> T {
        self.coefficient
    }

    #[inline(always)]
    fn coefficient_and_slope(&self, _: Sliding<T>) -> (T, T) {
        (self.coefficient, self.coefficient_slope)
    }

    fn bounds(&self, _: T) -> Bounds<T> {
        Bounds::constant(self.coefficient)
    }
}

impl<T: Scalar> Regularisation<T> for AxisSurface<T> {
    #[inline(always)]
    fn speed(&self, _: Sliding<T>) -> T {
        self.speed
    }

    #[inline(always)]
    fn speed_and_slope(&self, _: Sliding<T>) -> (T, T) {
        (self.speed, self.speed_slope)
    }

    /// vᵢ/n, and zero at rest.
    fn sign(&self, sliding: Sliding<T>) -> T {
        over(sliding.velocity(), self.speed)
    }

    fn speed_at_rest(&self) -> T {
        self.speed
    }
}

/// The weighted velocities aᵢ vᵢ.
#[inline(always)]
fn weighted<T: Scalar, const N: usize>(
    axes: &[Axis<T>; N],
    velocity: &SVector<T, N>,
) -> SVector<T, N> {
    SVector::from_fn(|i, _| axes[i].friction_ratio * velocity[i])
}

/// The surface under each axis, without derivatives.
#[inline(always)]
pub(super) fn surfaces<T, C, E, const N: usize>(
    (curve, regularisation): (&C, &E),
    axes: &[Axis<T>; N],
    velocity: &SVector<T, N>,
) -> [AxisSurface<T>; N]
where
    T: Scalar,
    C: FrictionCurve<T>,
    E: Regularisation<T>,
{
    let speed = regularisation.speed(norm(&weighted(axes, velocity)).into());
    let mu = curve.coefficient(norm(velocity).into());
    let zero = T::zero();
    let shared = AxisSurface { coefficient: mu, coefficient_slope: zero, speed, speed_slope: zero };
    axes.map(|axis| shared.under(axis.friction_ratio))
}

/// The surface under each axis i with its derivatives with respect to the velocity of axis j, in
/// place `[j][i]`.
#[inline(always)]
pub(super) fn surfaces_and_slopes<T, C, E, const N: usize>(
    (curve, regularisation): (&C, &E),
    axes: &[Axis<T>; N],
    velocity: &SVector<T, N>,
) -> [[AxisSurface<T>; N]; N]
where
    T: Scalar,
    C: FrictionCurve<T>,
    E: Regularisation<T>,
{
    let (weighted, bare_speed) = (weighted(axes, velocity), norm(velocity));
    let bare = norm(&weighted);
    let (speed, slope) = regularisation.speed_and_slope(bare.into());
    let (mu, mu_slope) = curve.coefficient_and_slope(bare_speed.into());
    let shared =
        AxisSurface { coefficient: mu, coefficient_slope: mu_slope, speed, speed_slope: slope };
    // Loops, because closures of this size are not inlined.
    let mut rows = [[shared; N]; N];
    let along = axes.iter().zip(velocity.iter().zip(&weighted));
    for (row, (axis, (&v, &weighted))) in rows.iter_mut().zip(along) {
        let along = AxisSurface {
            coefficient_slope: mu_slope * over(v, bare_speed),
            speed_slope: slope * axis.friction_ratio * over(weighted, bare),
            ..shared
        };
        for (surface, axis) in row.iter_mut().zip(axes) {
            *surface = along.under(axis.friction_ratio);
        }
    }
    rows
}

/// A component of a unit vector; zero of none.
#[inline(always)]
fn over<T: Scalar>(component: T, length: T) -> T {
    if is_zero(length) { T::zero() } else { component / length }
}

/// ‖x‖, without overflow or underflow on the way.
#[inline(always)]
pub(super) fn norm<T: Scalar, const N: usize>(x: &SVector<T, N>) -> T {
    if N == 1 {
        return x[0].abs();
    }
    let square = x.norm_squared();
    // Between these, squares of components that matter neither overflow nor lose digits.
    let epsilon = T::default_epsilon();
    let large = T::max_value().unwrap_or_else(|| T::one() / epsilon) * epsilon;
    if square < large && square * large > T::one() { square.sqrt() } else { scaled_norm(x, square) }
}

/// ‖x‖ by way of the largest component.
#[cold]
fn scaled_norm<T: Scalar, const N: usize>(x: &SVector<T, N>, square: T) -> T {
    let largest = x.iter().fold(T::zero(), |most, x| if x.abs() > most { x.abs() } else { most });
    let scaled = largest > T::zero() && largest.is_finite() && square >= T::zero();
    // Zero, infinity and NaN are their own squares.
    if scaled { largest * x.map(|x| x / largest).norm_squared().sqrt() } else { square }
}
