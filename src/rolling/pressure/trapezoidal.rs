//! A pressure that rises, stays and falls.

use super::linear::linear_pressure;
use super::{Pressure, PressureKnot};
use crate::Scalar;
use crate::parameter::{self, ParameterError};

/// Parameters of [`Trapezoidal`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrapezoidalParameters<T> {
    /// Part of the patch over which the pressure rises from zero \[–\]; 0 for a pressure that is there
    /// from the inlet on.
    pub rising_part: T,
    /// Part of the patch over which it falls to zero \[–\]; 0 for one that stays up to the outlet. The
    /// two together are at most 1.
    pub falling_part: T,
    /// Pressure between the two [N/m], positive.
    pub plateau: T,
}

/// The pressure that rises linearly over a first part of the patch, is constant, and falls linearly
/// over a last part. Lorries' tyres come close to it; with both parts ½ it is a triangle.
///
/// ```
/// use bristle::rolling::{Pressure, Trapezoidal, TrapezoidalParameters};
///
/// let pressure = Trapezoidal::new(TrapezoidalParameters {
///     rising_part: 0.1,
///     falling_part: 0.3,
///     plateau: 50e3_f64, // N/m
/// })?;
/// assert!((pressure.at(0.05) - 25e3).abs() < 1e-9);
/// assert!((pressure.total() - 40e3).abs() < 1e-9);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trapezoidal<T> {
    knots: [PressureKnot<T>; 4],
}

impl<T: Scalar> Trapezoidal<T> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range, and `falling_part` if the two parts are more than
    /// the patch.
    pub fn new(parameters: TrapezoidalParameters<T>) -> Result<Self, ParameterError> {
        let TrapezoidalParameters { rising_part, falling_part, plateau } = parameters;
        let plateau = parameter::positive("plateau", plateau)?;
        let rising = parameter::non_negative("rising_part", rising_part)?;
        let rising = parameter::at_most("rising_part", rising, "the whole patch", T::one())?;
        let falling = parameter::non_negative("falling_part", falling_part)?;
        let left = T::one() - rising;
        let falling = parameter::at_most("falling_part", falling, "what is left", left)?;
        let knot = |place, pressure| PressureKnot { place, pressure };
        let end = T::one() - falling;
        // 1 − (1 − x) can be a rounding above or below x.
        let end = if end < rising { rising } else { end };
        Ok(Self {
            knots: [
                knot(T::zero(), T::zero()),
                knot(rising, plateau),
                knot(end, plateau),
                knot(T::one(), T::zero()),
            ],
        })
    }
}

impl<T: Scalar> Pressure<T> for Trapezoidal<T> {
    linear_pressure!();
}
