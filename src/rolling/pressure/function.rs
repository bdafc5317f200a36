//! A pressure given by a function of the place.

use core::fmt;

use super::Pressure;
use crate::Scalar;
use crate::parameter::{self, ParameterError, Rule};
use crate::rolling::quadrature::weigh;
use crate::scalar::to_f64;

/// A pressure given by a closure that answers p and dp/dξ at a place ξ, and K places at which it
/// is not smooth.
///
/// Its integrals are taken by Gauss quadrature: to rounding if it is smooth on the scale of a
/// sixteenth of the way from one knot to the next.
///
/// ```
/// use bristle::rolling::{FunctionPressure, Pressure};
/// use std::f64::consts::PI;
///
/// // Hertz: a cylinder on a plane.
/// let arch = FunctionPressure::new(
///     |place: f64| ((PI * place).sin(), PI * (PI * place).cos()),
///     [],
/// )?;
/// assert!((arch.total() - 2.0 / PI).abs() < 1e-15);
///
/// // Measured: straight lines between points.
/// use bristle::signal::{Polyline, Signal, Vertex};
///
/// let points = [(0.0, 0.0), (0.2, 900.0), (0.7, 600.0), (1.0, 0.0)];
/// let lines = Polyline::new(points.map(|(time, value)| Vertex { time, value }))?;
/// let measured = FunctionPressure::new(|place: f64| lines.value_and_rate(place), [0.2, 0.7])?;
/// assert!((measured.total() - 555.0).abs() < 1e-12);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Clone, Copy)]
pub struct FunctionPressure<T, F, const K: usize = 0> {
    function: F,
    knots: [T; K],
    total: T,
}

impl<T: Scalar, F: Fn(T) -> (T, T) + Clone, const K: usize> FunctionPressure<T, F, K> {
    /// A pressure from a function of the place and the places at which it is not smooth.
    ///
    /// At a knot the function should answer with what holds just after it. It is looked at at the
    /// 128 places of a quadrature from each knot to the next, and at the ends; in between it is
    /// taken on trust.
    ///
    /// # Errors
    ///
    /// Names the knot that is not larger than the one before or not inside the patch; refuses a
    /// function that is negative, not finite, or has no finite slope where it is looked at.
    pub fn new(function: F, knots: [T; K]) -> Result<Self, ParameterError> {
        let mut previous = T::zero();
        for (index, &knot) in knots.iter().enumerate() {
            let place = parameter::finite("knots", knot)
                .and_then(|knot| parameter::increasing("knots", knot, previous))
                .and_then(|knot| parameter::below("knots", knot, "the outlet", T::one()));
            previous = parameter::component(index, place)?;
        }
        let mut pressure = Self { function, knots, total: T::zero() };
        let mut refused = None;
        let mut look = |place: T| {
            let (value, slope) = pressure.at_and_slope(place);
            let checked = parameter::finite("pressure", value)
                .and_then(|_| parameter::finite("the pressure's slope", slope))
                .and_then(|_| {
                    let rule = Rule::NonNegativeAt { place: to_f64(place) };
                    parameter::check("pressure", value, value >= T::zero(), rule)
                });
            if let (Err(error), None) = (checked, refused) {
                refused = Some(error);
            }
        };
        look(T::zero());
        look(T::one());
        let mut total = T::zero();
        weigh(&pressure, T::zero().into(), |place, weighted| {
            look(place);
            total += weighted;
        });
        if let Some(error) = refused {
            return Err(error);
        }
        pressure.total = total;
        Ok(pressure)
    }
}

impl<T: fmt::Debug, F, const K: usize> fmt::Debug for FunctionPressure<T, F, K> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FunctionPressure")
            .field("knots", &self.knots)
            .field("total", &self.total)
            .finish_non_exhaustive()
    }
}

impl<T: Scalar, F: Fn(T) -> (T, T) + Clone, const K: usize> Pressure<T>
    for FunctionPressure<T, F, K>
{
    fn at_and_slope(&self, place: T) -> (T, T) {
        (self.function)(place)
    }

    fn next_knot(&self, place: T) -> Option<T> {
        self.knots.iter().copied().find(|&knot| knot > place)
    }

    fn total(&self) -> T {
        self.total
    }
}
