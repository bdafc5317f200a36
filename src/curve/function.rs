//! A friction curve given by a function of the speed.

use core::fmt;

use crate::curve::FrictionCurve;
use crate::parameter::{Checked, Named};
use crate::{Bounds, Scalar, Sliding};

/// A friction curve given by a closure that returns μ \[–\] and dμ/d|v| [s/m] at a speed |v| [m/s]:
/// for a formula of your own, without a type of your own. Both directions have the same friction.
///
/// The closure must stay positive and smooth for slightly negative speeds too, where a solver's
/// trial step has overshot a reversal. Its bounds are taken on trust: they are what the theorems
/// (deflection, force) and the checks of other parameters use, for every speed.
///
/// ```
/// use bristle::Bounds;
/// use bristle::curve::{FrictionCurve, FunctionCurve};
///
/// let curve = FunctionCurve::new(
///     |speed: f64| {
///         let fall = 0.2 / (1.0 + 10.0 * speed);
///         (0.3 + fall, -fall * 10.0 / (1.0 + 10.0 * speed))
///     },
///     Bounds { min: 0.3, max: 0.5 },
/// )?;
/// assert_eq!(curve.coefficient(0.0.into()), 0.5);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Clone, Copy)]
pub struct FunctionCurve<T, F> {
    function: F,
    bounds: Bounds<T>,
    least_slope: Option<T>,
}

impl<T: Scalar, F: Fn(T) -> (T, T)> FunctionCurve<T, F> {
    /// A curve from a function of the speed and the range of its values.
    ///
    /// # Errors
    ///
    /// Names the bound that is not positive or not in order. The upper bound may be infinite, for a
    /// curve that grows without limit. Then no model of it has a limit of the deflection or of the
    /// force, at any speed: [`Bristle::limits`](crate::Bristle::limits) returns `None`, a companion
    /// step cuts no deflection, and LuGre is passive only where its damping covers every
    /// deflection. The passivity of FrBD needs no bound.
    pub fn new(function: F, bounds: Bounds<T>) -> Checked<Self> {
        Named("bounds.min", bounds.min).positive()?;
        Named("bounds.max", bounds.max).at_least("bounds.min", bounds.min)?;
        Ok(Self { function, bounds, least_slope: None })
    }

    /// The curve with a number [s/m] that its slope dμ/d|v| does not fall below, taken on
    /// trust, see [`FrictionCurve::least_slope`].
    ///
    /// # Errors
    ///
    /// Refuses a number that is not finite.
    pub fn with_least_slope(self, slope: T) -> Checked<Self> {
        Ok(Self { least_slope: Some(Named("least_slope", slope).finite()?), ..self })
    }
}

impl<T: fmt::Debug, F> fmt::Debug for FunctionCurve<T, F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FunctionCurve").field("bounds", &self.bounds).finish_non_exhaustive()
    }
}

impl<T: Scalar, F: Fn(T) -> (T, T) + Clone> FrictionCurve<T> for FunctionCurve<T, F> {
    #[inline]
    fn coefficient_and_slope(&self, sliding: Sliding<T>) -> (T, T) {
        let (coefficient, slope) = (self.function)(sliding.speed());
        (coefficient, slope * sliding.direction())
    }

    fn bounds(&self, _fastest: T) -> Bounds<T> {
        self.bounds
    }

    fn is_even(&self) -> bool {
        true
    }

    fn least_slope(&self) -> Option<T> {
        self.least_slope
    }
}
