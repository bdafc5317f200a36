//! FrBD on several axes.

use nalgebra::SVector;

use super::{Axis, PlaneBristle, PlaneLimits, norm};
use crate::curve::FrictionCurve;
use crate::parameter::ParameterError;
use crate::regularisation::{Regularisation, Unregularised};
use crate::rheology::KelvinVoigtParameters;
use crate::scalar::{is_zero, lit, unlimited};
use crate::{Affine, Bounds, Scalar, Sliding};

/// FrBD with Kelvin–Voigt bristles on N axes; the [module](super) has the equations.
///
/// ```
/// use bristle::curve::Stribeck;
/// use bristle::paper;
/// use bristle::plane::{PlaneBristle, PlaneFrBd};
/// use nalgebra::Vector2;
///
/// let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
/// let block = PlaneFrBd::isotropic(curve, paper::STICK_SLIP_BRISTLE)?.under_load(4.0)?; // N
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
    /// Refuses a friction ratio or stiffness that is not positive, and a negative damping.
    pub fn new(curve: C, axes: [Axis<T>; N]) -> Result<Self, ParameterError> {
        for axis in axes {
            axis.checked()?;
        }
        Ok(Self { curve, axes, regularisation: Unregularised })
    }

    /// The model with one bristle for every direction.
    ///
    /// # Errors
    ///
    /// As [`PlaneFrBd::new`].
    pub fn isotropic(
        curve: C,
        bristle: KelvinVoigtParameters<T, T>,
    ) -> Result<Self, ParameterError> {
        let KelvinVoigtParameters { micro_stiffness, micro_damping } = bristle;
        Self::new(curve, [Axis { friction_ratio: T::one(), micro_stiffness, micro_damping }; N])
    }
}

impl<T: Scalar, C: FrictionCurve<T>, const N: usize, E: Regularisation<T>> PlaneFrBd<C, T, N, E> {
    /// The model with another regularisation of the weighted speed.
    pub fn regularised<F>(self, regularisation: F) -> PlaneFrBd<C, T, N, F> {
        PlaneFrBd { curve: self.curve, axes: self.axes, regularisation }
    }

    /// The friction curve.
    pub fn curve(&self) -> &C {
        &self.curve
    }
}

/// The two speeds in which the axes meet, and their derivatives with respect to each velocity.
pub(super) struct Speeds<T: Scalar, const N: usize> {
    /// s = ‖v‖
    pub(super) speed: T,
    pub(super) speed_slope: SVector<T, N>,
    /// n = ‖(aᵢ vᵢ)‖_ε
    pub(super) weighted: T,
    pub(super) weighted_slope: SVector<T, N>,
}

impl<T: Scalar, const N: usize> Speeds<T, N> {
    #[inline(always)]
    pub(super) fn of<E: Regularisation<T>>(
        axes: &[Axis<T>; N],
        regularisation: &E,
        velocity: &SVector<T, N>,
    ) -> (T, T) {
        let weighted = SVector::<T, N>::from_fn(|i, _| axes[i].friction_ratio * velocity[i]);
        (norm(velocity), regularisation.speed(Sliding::from(norm(&weighted))))
    }

    pub(super) fn with_slopes<E: Regularisation<T>>(
        axes: &[Axis<T>; N],
        regularisation: &E,
        velocity: &SVector<T, N>,
    ) -> Self {
        let weighted = SVector::<T, N>::from_fn(|i, _| axes[i].friction_ratio * velocity[i]);
        let (speed, bare) = (norm(velocity), norm(&weighted));
        let (regularised, slope) = regularisation.speed_and_slope(Sliding::from(bare));
        let over = |x: T, length: T| if is_zero(length) { T::zero() } else { x / length };
        Self {
            speed,
            speed_slope: velocity.map(|v| over(v, speed)),
            weighted: regularised,
            weighted_slope: SVector::from_fn(|i, _| {
                slope * axes[i].friction_ratio * over(weighted[i], bare)
            }),
        }
    }
}

impl<T, C, E, const N: usize> PlaneBristle<T, N> for PlaneFrBd<C, T, N, E>
where
    T: Scalar,
    C: FrictionCurve<T>,
    E: Regularisation<T>,
{
    #[inline]
    fn affine(&self, velocity: &SVector<T, N>) -> [Affine<T>; N] {
        let (speed, weighted) = Speeds::of(&self.axes, &self.regularisation, velocity);
        let mu = self.curve.coefficient(Sliding::from(speed));
        self.axes.map(|axis| {
            let share = axis.friction_ratio * axis.friction_ratio * mu;
            let inverse = T::one() / (axis.micro_damping * weighted + share);
            let drive = share * inverse;
            Affine {
                relaxation: axis.micro_stiffness * (weighted * inverse),
                drive,
                stiffness: axis.micro_stiffness * drive,
                damping: axis.micro_damping * drive,
            }
        })
    }

    fn affine_and_slopes(&self, velocity: &SVector<T, N>) -> ([Affine<T>; N], [[Affine<T>; N]; N]) {
        let speeds = Speeds::with_slopes(&self.axes, &self.regularisation, velocity);
        let (mu, slope) = self.curve.coefficient_and_slope(Sliding::from(speeds.speed));
        let slopes = self.axes.map(|axis| {
            let square = axis.friction_ratio * axis.friction_ratio;
            let inverse = T::one() / (axis.micro_damping * speeds.weighted + square * mu);
            // n' μ − n μ', in which (n/g)' and (μ/g)' cancel to one term.
            core::array::from_fn(|j| {
                let turn =
                    speeds.weighted_slope[j] * mu - speeds.weighted * slope * speeds.speed_slope[j];
                let common = square * turn * inverse * inverse;
                let drive = -axis.micro_damping * common;
                Affine {
                    relaxation: axis.micro_stiffness * common,
                    drive,
                    stiffness: axis.micro_stiffness * drive,
                    damping: axis.micro_damping * drive,
                }
            })
        });
        (self.affine(velocity), slopes)
    }

    fn axes(&self) -> &[Axis<T>; N] {
        &self.axes
    }

    fn limits(&self, fastest: T) -> PlaneLimits<T, N> {
        let Some(mu) = largest(&self.curve, fastest) else { return PlaneLimits::none() };
        let limit = |axis: Axis<T>| mu * axis.friction_ratio / axis.micro_stiffness;
        // λᵢ = n/(aᵢ²μ/σ0ᵢ + σ1ᵢ n/σ0ᵢ) is one number if both quotients are.
        let quotients = |axis: &Axis<T>| {
            let square = axis.friction_ratio * axis.friction_ratio;
            (square / axis.micro_stiffness, axis.micro_damping / axis.micro_stiffness)
        };
        let near = |a: T, b: T| (a - b).abs() <= lit::<T>(8.0) * T::default_epsilon() * b.abs();
        let equal = self.axes.windows(2).all(|pair| {
            let ((a, b), (c, d)) = (quotients(&pair[0]), quotients(&pair[1]));
            near(a, c) && near(b, d)
        });
        PlaneLimits {
            deflection: Some(SVector::from_fn(|i, _| limit(self.axes[i]))),
            coefficient: Some(SVector::from_fn(|i, _| mu * self.axes[i].friction_ratio)),
            ellipsoid: equal,
        }
    }

    fn is_passive(&self) -> bool {
        self.curve.bounds(unlimited()).min > T::zero()
    }
}

/// The largest coefficient up to a speed, if it is finite.
pub(super) fn largest<T: Scalar, C: FrictionCurve<T>>(curve: &C, fastest: T) -> Option<T> {
    let Bounds { max, .. } = curve.bounds(fastest.abs());
    max.is_finite().then_some(max)
}
