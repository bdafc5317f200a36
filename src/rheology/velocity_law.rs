//! A stiffness or damping that is constant or depends on the sliding velocity.

use core::fmt::{self, Debug};

use crate::{Bounds, Scalar, Sliding};

/// A stiffness or damping as a function of the sliding velocity. A plain number is a constant;
/// [`VelocityDependent`] wraps a function.
pub trait VelocityLaw<T: Scalar>: Debug + Clone {
    /// The value at a velocity.
    #[inline(always)]
    fn value(&self, sliding: Sliding<T>) -> T {
        self.value_and_slope(sliding).0
    }

    /// The value and its derivative with respect to the signed velocity.
    fn value_and_slope(&self, sliding: Sliding<T>) -> (T, T);

    /// Range of the values over all velocities.
    fn bounds(&self) -> Bounds<T>;

    /// Whether the value at −v is known to be that at v.
    fn is_even(&self) -> bool {
        false
    }
}

impl<T: Scalar> VelocityLaw<T> for T {
    #[inline(always)]
    fn value_and_slope(&self, _sliding: Sliding<T>) -> (T, T) {
        (*self, T::zero())
    }

    fn bounds(&self) -> Bounds<T> {
        Bounds::constant(*self)
    }

    fn is_even(&self) -> bool {
        true
    }
}

/// A stiffness or damping given by a function of the sliding velocity.
///
/// [`VelocityDependent::of_speed`] takes a function of the speed, [`VelocityDependent::new`] one
/// that distinguishes the directions. The bounds are taken on trust; the theorems on deflection and
/// force use them.
///
/// ```
/// use bristle::Bounds;
/// use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters, VelocityDependent};
///
/// // Micro-damping that vanishes in fast sliding, σ1(v) = 60 exp(−(v/v_d)²), v_d = 0.1 m/s.
/// let micro_damping = VelocityDependent::of_speed(
///     |speed: f64| {
///         let u = speed / 0.1;
///         let damping = 60.0 * (-u * u).exp();
///         (damping, -2.0 * u / 0.1 * damping)
///     },
///     Bounds { min: 0.0, max: 60.0 },
/// );
/// let bristle = KelvinVoigt::new(KelvinVoigtParameters { micro_stiffness: 1e4, micro_damping })?;
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Clone, Copy)]
pub struct VelocityDependent<T, F> {
    function: F,
    bounds: Bounds<T>,
    even: bool,
}

impl<T: Scalar, F: Fn(Sliding<T>) -> (T, T)> VelocityDependent<T, F> {
    /// A law from a function of the sliding velocity, which answers the value and its derivative
    /// with respect to the signed velocity, and the range of its values.
    pub fn new(function: F, bounds: Bounds<T>) -> Self {
        Self { function, bounds, even: false }
    }
}

impl VelocityDependent<(), ()> {
    /// A law from a function of the speed |v|, which answers the value and its derivative with
    /// respect to the speed, and the range of its values.
    ///
    /// The function must stay smooth for slightly negative speeds, where a solver's trial step has
    /// overshot a reversal.
    pub fn of_speed<T: Scalar>(
        function: impl Fn(T) -> (T, T) + Clone,
        bounds: Bounds<T>,
    ) -> VelocityDependent<T, impl Fn(Sliding<T>) -> (T, T) + Clone> {
        let function = move |sliding: Sliding<T>| {
            let (value, slope) = function(sliding.speed());
            (value, slope * sliding.direction())
        };
        VelocityDependent { function, bounds, even: true }
    }
}

impl<T: Debug, F> Debug for VelocityDependent<T, F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("VelocityDependent").field("bounds", &self.bounds).finish_non_exhaustive()
    }
}

impl<T: Scalar, F: Fn(Sliding<T>) -> (T, T) + Clone> VelocityLaw<T> for VelocityDependent<T, F> {
    #[inline]
    fn value_and_slope(&self, sliding: Sliding<T>) -> (T, T) {
        (self.function)(sliding)
    }

    fn bounds(&self) -> Bounds<T> {
        self.bounds
    }

    fn is_even(&self) -> bool {
        self.even
    }
}
