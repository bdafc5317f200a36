//! Friction curves: the friction coefficient μ of steady sliding over the sliding velocity.
//!
//! | curve | μ(v) | take it if |
//! |---|---|---|
//! | [`Coulomb`] | μ_d + σ2\|v\| | friction does not fall with the speed |
//! | [`Stribeck`] | μ_d + (μ_s − μ_d) e^(−(\|v\|/v_S)^δ) + σ2\|v\| | nothing else is known |
//! | [`RationalStribeck`] | μ_d + (μ_s − μ_d)/(1 + (v/v_S)²) + σ2\|v\| | exp is too slow |
//! | [`Tabulated`] | monotone cubic through measured points | a measured curve fits no formula |
//! | [`Asymmetric`] | one curve for each direction | a gearbox or seal has two frictions |
//! | [`AnyCurve`] | one of these | it is chosen at run time |
//! | [`FunctionCurve`] | a function of the speed | you have a formula of your own |
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | v | sliding velocity | m/s |
//! | μ_s, μ_d | static and dynamic friction coefficient | – |
//! | v_S, δ | Stribeck velocity (63 % of the fall, rational: 50 %) and exponent | m/s, – |
//! | σ2 | viscous friction per unit normal force | s/m |
//!
//! A curve is what a constant velocity measures: F = p μ(v). It goes into a model of
//! [`Bristle`](crate::Bristle), which adds what friction does while the velocity changes. By itself
//! it is enough where the velocity hardly changes: [`FrictionCurve::at`].

mod any;
mod asymmetric;
mod coulomb;
mod function;
#[cfg(feature = "alloc")]
mod own;
mod rational_stribeck;
mod stribeck;
mod tabulated;
mod valley;

use core::fmt::Debug;

pub use any::AnyCurve;
pub use asymmetric::Asymmetric;
pub use coulomb::{Coulomb, CoulombParameters};
pub use function::FunctionCurve;
#[cfg(feature = "alloc")]
pub use own::OwnCurve;
pub use rational_stribeck::{RationalStribeck, RationalStribeckParameters};
pub use stribeck::{Stribeck, StribeckParameters};
pub use tabulated::{Cubic, Knot, Tabulated};

use crate::regularisation::Regularisation;
use crate::{Bounds, Branch, Scalar, Sliding};

/// The friction coefficient of steady sliding, μ(v) > 0 \[–\].
///
/// A curve is evaluated on any [`Branch`]. On a locked one the speed can become negative during a
/// trial step: there the curve continues smoothly, or evenly where |v|^δ has no smooth
/// continuation. A NaN there only shortens the step, so take |v| of a logarithm or near a pole.
///
/// A curve of your own takes two methods, [`FrictionCurve::coefficient_and_slope`] and
/// [`FrictionCurve::bounds`]; with a closure and constant bounds it is a [`FunctionCurve`]. The
/// other methods are claims; their defaults claim nothing:
///
/// | method | default | a claim is needed for |
/// |---|---|---|
/// | `is_even` | `false` | odd symmetry of the force ([`Law`](crate::Law)) |
/// | `viscous_friction`, `with_less_viscous_friction` | 0 | classical [`LuGre`](crate::LuGre) |
/// | `least_slope` | `None` | [`ImplicitBristle`](crate::ImplicitBristle) |
/// | `slope_at_rest` | the slope just above rest | a curve whose slope differs by direction |
///
/// ```
/// use bristle::{Bounds, Sliding};
/// use bristle::curve::FrictionCurve;
///
/// /// μ = 0.1 + 0.02 ln(1 + |v|/v₀): rises with the logarithm of the speed.
/// #[derive(Debug, Clone)]
/// struct Logarithmic { reference_speed: f64 }
///
/// impl FrictionCurve<f64> for Logarithmic {
///     fn coefficient_and_slope(&self, sliding: Sliding<f64>) -> (f64, f64) {
///         let coefficient = 0.1 + 0.02 * (sliding.speed() / self.reference_speed).ln_1p();
///         let slope = 0.02 / (self.reference_speed + sliding.speed());
///         (coefficient, slope * sliding.direction())
///     }
///
///     fn bounds(&self, fastest: f64) -> Bounds<f64> {
///         Bounds { min: 0.1, max: self.at(fastest) }
///     }
///
///     fn is_even(&self) -> bool {
///         true
///     }
/// }
///
/// let curve = Logarithmic { reference_speed: 1e-3 };
/// assert_eq!(curve.at(0.0), 0.1);
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a friction curve",
    note = "build one from parameters, e.g. by `Stribeck::new(parameters)?`"
)]
pub trait FrictionCurve<T: Scalar>: Debug + Clone {
    /// The friction coefficient μ(v) \[–\], as models ask for it. Override it where the slope costs
    /// extra.
    #[inline]
    fn coefficient(&self, sliding: Sliding<T>) -> T {
        self.coefficient_and_slope(sliding).0
    }

    /// The friction coefficient \[–\] and its slope dμ/dv [s/m], which Jacobians and linearisations
    /// need.
    ///
    /// The slope is taken with respect to the *signed* velocity: for a curve of the speed it is the
    /// slope over the speed times [`Sliding::direction`].
    fn coefficient_and_slope(&self, sliding: Sliding<T>) -> (T, T);

    /// The range of μ over all velocities with |v| ≤ `fastest` [m/s], which is zero or positive and
    /// may be infinite. The limits of deflection and force follow from it: |z| ≤ max μ/σ0,
    /// |F| ≤ p max μ.
    fn bounds(&self, fastest: T) -> Bounds<T>;

    /// The friction coefficient μ \[–\] at a plain velocity [m/s]: for you, where
    /// [`FrictionCurve::coefficient`] is for models.
    fn at(&self, velocity: T) -> T {
        self.coefficient(Sliding::from(velocity))
    }

    /// σ2 [s/m], the coefficient of a viscous part σ2|v| within μ: the curve without it is still
    /// positive everywhere. Zero if no such part is known.
    ///
    /// A curve that overrides it overrides [`FrictionCurve::with_less_viscous_friction`], too.
    #[doc(alias = "sigma2")]
    fn viscous_friction(&self) -> T {
        T::zero()
    }

    /// The curve less a part σ|v| of its viscous friction, 0 ≤ σ ≤ σ2 [s/m]: for a model such as
    /// classical LuGre, which has that part outside the bristle.
    #[must_use]
    fn with_less_viscous_friction(&self, part: T) -> Self {
        let _ = part;
        self.clone()
    }

    /// The curve without its viscous part σ2|v|.
    #[must_use]
    fn without_viscous_friction(&self) -> Self {
        self.with_less_viscous_friction(self.viscous_friction())
    }

    /// The slope dμ/d|v| [s/m] just above rest; of two directions, the lesser. μ(v) is
    /// differentiable at v = 0 only if this slope is zero.
    fn slope_at_rest(&self) -> T {
        self.coefficient_and_slope(Branch::Forward.of(T::zero())).1
    }

    /// A lower bound [s/m] of the slope dμ/d|v| at all speeds, and close to its least value:
    /// negative for a curve that falls, −∞ if it falls infinitely steeply. `None` if not known.
    ///
    /// The implicit bristle has a single answer at every state if and only if σ1 plus this bound is
    /// positive, see [`ImplicitBristle`](crate::ImplicitBristle).
    fn least_slope(&self) -> Option<T> {
        None
    }

    /// A number [s/m] that μ(v)/|v|_ε does not fall below for |v| ≤ `fastest` [m/s]. The relaxation
    /// rate of FrBD, σ0|v|_ε/(σ1|v|_ε + μ), is at most σ0/(σ1 + this number).
    fn least_secant<E: Regularisation<T>>(&self, regularisation: &E, fastest: T) -> T {
        let over_range = self.bounds(fastest).min / regularisation.speed(Sliding::from(fastest));
        // μ ≥ dry + σ2|v| ≥ σ2|v|_ε, provided that the dry part covers σ2(|v|_ε − |v|).
        let viscous = self.viscous_friction();
        let dry = self.without_viscous_friction().bounds(fastest).min;
        let covered = viscous * regularisation.speed_at_rest() <= dry;
        if covered { over_range.larger(viscous) } else { over_range }
    }

    /// Whether μ(−v) = μ(v) for every v. `false` unless it is known. A model needs it for the law
    /// [`OddSymmetry`](crate::Law::OddSymmetry).
    fn is_even(&self) -> bool {
        false
    }
}
