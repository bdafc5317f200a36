//! Classical LuGre on several axes, for comparison.

use nalgebra::SVector;

use super::frbd::{Speeds, largest};
use super::{Axis, PlaneBristle, PlaneLimits};
use crate::curve::FrictionCurve;
use crate::parameter::ParameterError;
use crate::regularisation::Unregularised;
use crate::{Affine, Scalar, Sliding};

/// Classical LuGre with Kelvin–Voigt bristles on N axes:
///
/// żᵢ = vᵢ − σ0ᵢ n/(aᵢ² g) zᵢ,   Fᵢ/p = σ0ᵢ zᵢ + σ1ᵢ żᵢ + σ2 vᵢ,
///
/// with g the friction curve without its viscous part σ2 s. Its force has no bound, its relaxation
/// rate has none either, and no theorem of passivity is known: prefer
/// [`PlaneFrBd`](super::PlaneFrBd) unless results must match another program's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneLuGre<C, T, const N: usize> {
    dry: C,
    viscous: T,
    axes: [Axis<T>; N],
}

impl<T: Scalar, C: FrictionCurve<T>, const N: usize> PlaneLuGre<C, T, N> {
    /// The model of a friction curve over the speed ‖v‖ and a bristle on each axis.
    ///
    /// # Errors
    ///
    /// Refuses a friction ratio or stiffness that is not positive, and a negative damping.
    pub fn classical(curve: C, axes: [Axis<T>; N]) -> Result<Self, ParameterError> {
        for axis in axes {
            axis.checked()?;
        }
        let viscous = curve.viscous_friction();
        Ok(Self { dry: curve.without_viscous_friction(), viscous, axes })
    }
}

impl<T, C, const N: usize> PlaneBristle<T, N> for PlaneLuGre<C, T, N>
where
    T: Scalar,
    C: FrictionCurve<T>,
{
    #[inline]
    fn affine(&self, velocity: &SVector<T, N>) -> [Affine<T>; N] {
        let (speed, weighted) = Speeds::of(&self.axes, &Unregularised, velocity);
        let g = self.dry.coefficient(Sliding::from(speed));
        self.axes.map(|axis| {
            let share = axis.friction_ratio * axis.friction_ratio * g;
            let relaxation = axis.micro_stiffness * weighted / share;
            Affine {
                relaxation,
                drive: T::one(),
                stiffness: axis.micro_stiffness - axis.micro_damping * relaxation,
                damping: axis.micro_damping + self.viscous,
            }
        })
    }

    fn affine_and_slopes(&self, velocity: &SVector<T, N>) -> ([Affine<T>; N], [[Affine<T>; N]; N]) {
        let speeds = Speeds::with_slopes(&self.axes, &Unregularised, velocity);
        let (g, slope) = self.dry.coefficient_and_slope(Sliding::from(speeds.speed));
        let slopes = self.axes.map(|axis| {
            let square = axis.friction_ratio * axis.friction_ratio;
            core::array::from_fn(|j| {
                let turn =
                    speeds.weighted_slope[j] * g - speeds.weighted * slope * speeds.speed_slope[j];
                let relaxation = axis.micro_stiffness * turn / (square * g * g);
                Affine {
                    relaxation,
                    drive: T::zero(),
                    stiffness: -axis.micro_damping * relaxation,
                    damping: T::zero(),
                }
            })
        });
        (self.affine(velocity), slopes)
    }

    fn axes(&self) -> &[Axis<T>; N] {
        &self.axes
    }

    fn limits(&self, fastest: T) -> PlaneLimits<T, N> {
        let deflection = largest(&self.dry, fastest).map(|g| {
            SVector::from_fn(|i, _| g * self.axes[i].friction_ratio / self.axes[i].micro_stiffness)
        });
        PlaneLimits { deflection, ..PlaneLimits::none() }
    }

    fn is_passive(&self) -> bool {
        false
    }
}
