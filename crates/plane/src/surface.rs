//! The surface at one velocity: the two numbers in which the axes meet, the friction coefficient
//! μ(s) at the speed s = ‖v‖ and the weighted speed n = ‖(aᵢ vᵢ)‖_ε, and what each axis feels of
//! them.

use nalgebra::SVector;

use super::Axis;
use bristle::curve::FrictionCurve;
use bristle::regularisation::Regularisation;
use bristle::scalar::is_zero;
use bristle::{Bounds, Branch, Scalar, Sliding};

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
        if is_zero(self.speed) { T::zero() } else { sliding.velocity() / self.speed }
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

/// A length as a velocity: it has one direction only.
#[inline(always)]
fn sliding<T: Scalar>(length: T) -> Sliding<T> {
    Branch::Forward.of(length)
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
    let speed = regularisation.speed(sliding(norm(&weighted(axes, velocity))));
    let coefficient = curve.coefficient(sliding(norm(velocity)));
    let zero = T::zero();
    let shared = AxisSurface { coefficient, coefficient_slope: zero, speed, speed_slope: zero };
    axes.map(|axis| shared.under(axis.friction_ratio))
}

/// The surface under each axis with its derivatives with respect to a number u, and ∂u/∂vⱼ.
///
/// The coefficients of an axis depend on n/μ alone. So u is n with μ held, and of μ the gradient of
/// u takes the part −(n/μ) ∂μ/∂vⱼ. With one axis u is ±v, and the slopes are those of the scalar
/// model.
#[inline(always)]
pub(super) fn surfaces_and_slopes<T, C, E, const N: usize>(
    (curve, regularisation): (&C, &E),
    axes: &[Axis<T>; N],
    velocity: &SVector<T, N>,
) -> ([AxisSurface<T>; N], SVector<T, N>)
where
    T: Scalar,
    C: FrictionCurve<T>,
    E: Regularisation<T>,
{
    let weighted = weighted(axes, velocity);
    let (length, weighted_length) = (norm(velocity), norm(&weighted));
    let (speed, speed_slope) = regularisation.speed_and_slope(sliding(weighted_length));
    let (coefficient, coefficient_slope) = curve.coefficient_and_slope(sliding(length));
    let gradient: SVector<T, N> = unit(velocity, length);
    let mut shared = AxisSurface { coefficient, coefficient_slope, speed, speed_slope };
    if let [axis] = axes.as_slice() {
        shared.speed_slope *= axis.friction_ratio;
        return (axes.map(|axis| shared.under(axis.friction_ratio)), gradient);
    }
    (shared.coefficient_slope, shared.speed_slope) = (T::zero(), T::one());
    let by_length = speed / coefficient * coefficient_slope;
    let weighted = unit(&weighted, weighted_length);
    let gradient = SVector::from_fn(|i, _| {
        axes[i].friction_ratio * speed_slope * weighted[i] - by_length * gradient[i]
    });
    (axes.map(|axis| shared.under(axis.friction_ratio)), gradient)
}

/// The unit vector of a vector of this length; zero of zero.
#[inline(always)]
fn unit<T: Scalar, const N: usize>(x: &SVector<T, N>, length: T) -> SVector<T, N> {
    x / if is_zero(length) { T::unlimited() } else { length }
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
