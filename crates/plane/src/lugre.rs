//! LuGre on several axes, for comparison.
//!
//! żᵢ = vᵢ − σ0ᵢ n/(aᵢ² g) zᵢ,   Fᵢ/p = σ0ᵢ zᵢ + σ1ᵢ żᵢ + σ2 vᵢ
//!
//! with the symbols of the [module](super) and g the friction curve at ‖v‖.

use nalgebra::SVector;

use super::{Axis, AxisSurface, PlaneBristle, PlaneFrBd, PlaneLimits};
use bristle::curve::FrictionCurve;
use bristle::parameter::{Checked, Named};
use bristle::regularisation::{Regularisation, Unregularised};
use bristle::rheology::KelvinVoigt;
use bristle::{Law, LuGre, Scalar};

/// LuGre with Kelvin–Voigt bristles on N axes:
///
/// żᵢ = vᵢ − σ0ᵢ n/(aᵢ² g) zᵢ,   Fᵢ/p = σ0ᵢ zᵢ + σ1ᵢ żᵢ + σ2 vᵢ.
///
/// In the [classical](PlaneLuGre::classical) model g is the friction curve without its viscous part
/// σ2 s. With the viscous part inside g the term σ2 vᵢ is absent: give
/// [`PlaneLuGre::with_viscous_friction`] the whole curve and σ2 = 0.
///
/// The deflections keep to their box. The force has no limit, and no theorem of passivity is known
/// unless σ1 = 0 on every axis: prefer [`PlaneFrBd`], unless results must match another program's.
///
/// Source: the LuGre model of Canudas de Wit et al. (see [`LuGre`]) with the ellipsoid of friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneLuGre<C, T, const N: usize, E = Unregularised> {
    /// The FrBD model of the curve g, with which it shares springs and steady deflection.
    pub(crate) frbd: PlaneFrBd<C, T, N, E>,
    /// σ2 of the term outside g
    viscous: T,
}

impl<T: Scalar, C: FrictionCurve<T>, const N: usize> PlaneLuGre<C, T, N> {
    /// The classical model: the viscous part of the curve, if it has one, stands outside g as
    /// σ2 vᵢ.
    ///
    /// # Errors
    ///
    /// Refuses a friction ratio outside 1e-100 … 1e100 (`f32`: 1e-18 … 1e15), and names its axis.
    pub fn classical(curve: C, axes: [Axis<T>; N]) -> Checked<Self> {
        let inside = curve.without_viscous_friction();
        let viscous = curve.viscous_friction() - inside.viscous_friction();
        Ok(Self { frbd: PlaneFrBd::new(inside, axes)?, viscous })
    }

    /// The model of a curve g, taken as it is, and a viscous friction σ2 [s/m] outside it.
    ///
    /// # Errors
    ///
    /// Refuses a viscous friction that is negative or not finite, and a friction ratio outside
    /// 1e-100 … 1e100 (`f32`: 1e-18 … 1e15), of which it names the axis.
    pub fn with_viscous_friction(
        curve: C,
        axes: [Axis<T>; N],
        viscous_friction: T,
    ) -> Checked<Self> {
        let viscous = Named("viscous_friction", viscous_friction).non_negative()?;
        Ok(Self { frbd: PlaneFrBd::new(curve, axes)?, viscous })
    }
}

impl<T: Scalar, C, const N: usize, E> PlaneLuGre<C, T, N, E> {
    /// The viscous friction σ2 [s/m] outside g.
    pub fn viscous_friction(&self) -> T {
        self.viscous
    }

    /// The model with another regularisation of the weighted speed.
    pub fn regularised<F>(self, regularisation: F) -> PlaneLuGre<C, T, N, F> {
        PlaneLuGre { frbd: self.frbd.regularised(regularisation), viscous: self.viscous }
    }

    /// Whether no bristle is damped and nothing viscous stands outside g: then the model is the
    /// undamped FrBD one.
    fn is_undamped(&self) -> bool {
        self.viscous == T::zero() && self.frbd.is_undamped()
    }
}

impl<T, C, E, const N: usize> PlaneBristle<T, N> for PlaneLuGre<C, T, N, E>
where
    T: Scalar,
    C: FrictionCurve<T>,
    E: Regularisation<T>,
{
    type Axis = LuGre<AxisSurface<T>, KelvinVoigt<T>, AxisSurface<T>, T>;

    #[inline(always)]
    fn axes(&self, velocity: &SVector<T, N>) -> [Self::Axis; N] {
        self.frbd.axes(velocity).map(|axis| LuGre::of_frbd(axis, self.viscous))
    }

    #[inline(always)]
    fn axes_and_slopes(&self, velocity: &SVector<T, N>) -> ([Self::Axis; N], SVector<T, N>) {
        let (axes, gradient) = self.frbd.axes_and_slopes(velocity);
        (axes.map(|axis| LuGre::of_frbd(axis, self.viscous)), gradient)
    }

    #[inline]
    fn storage_stiffness(&self) -> SVector<T, N> {
        self.frbd.storage_stiffness()
    }

    fn limits(&self, fastest: T) -> PlaneLimits<T, N> {
        let limits = self.frbd.limits_with(fastest, T::zero());
        PlaneLimits { coefficient: limits.coefficient.filter(|_| self.is_undamped()), ..limits }
    }

    fn obeys(&self, law: Law) -> bool {
        match law {
            Law::SteadySliding | Law::OddSymmetry => true,
            Law::Secant | Law::BoundedForce => self.is_undamped(),
            // F·v − Ẇ = p Σ (σ0 λ z² + σ2 v²).
            Law::Passivity => self.frbd.is_undamped(),
            Law::BoundedDeflection => self.limits(T::one()).deflection.is_some(),
            Law::BoundedRelaxation => self.limits(T::unlimited()).relaxation_rate.is_some(),
            _ => false,
        }
    }
}
