//! A pressure given by a function of the place.

use super::Pressure;
use crate::quadrature::weigh;
use bristle::Scalar;
use bristle::parameter::{Checked, Named, Rule};
use bristle::scalar::to_f64;
use bristle::signal::Signal;

/// A pressure given by a [`Signal`] that is read over the place ξ instead of the time: a function
/// that answers p and dp/dξ, or straight lines between measured points.
///
/// Its integrals are taken by Gauss quadrature: to rounding if it is smooth on the scale of a
/// sixteenth of the way from one kink to the next.
///
/// ```
/// use bristle_rolling::{FunctionPressure, Pressure};
/// use bristle::signal::{Function, Polyline, Vertex};
/// use std::f64::consts::PI;
///
/// // Hertz: a cylinder on a plane. It has no kinks.
/// let arch = Function::new(|place: f64| ((PI * place).sin(), PI * (PI * place).cos()), []);
/// assert!((FunctionPressure::new(arch)?.total() - 2.0 / PI).abs() < 1e-15);
///
/// // Measured.
/// let points = [(0.0, 0.0_f64), (0.2, 900.0), (0.7, 600.0), (1.0, 0.0)];
/// let lines = Polyline::new(points.map(|(time, value)| Vertex { time, value }))?;
/// assert!((FunctionPressure::new(lines)?.total() - 555.0).abs() < 1e-12);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FunctionPressure<T, S> {
    function: S,
    total: T,
}

impl<T: Scalar, S: Signal<T>> FunctionPressure<T, S> {
    /// A pressure from a function of the place.
    ///
    /// It is looked at at the 128 places of a quadrature from each kink to the next, and at the
    /// ends; in between it is taken on trust.
    ///
    /// # Errors
    ///
    /// Refuses a function that is negative, not finite, or has no finite slope where it is looked
    /// at.
    pub fn new(function: S) -> Checked<Self> {
        let pressure = Self { function, total: T::zero() };
        let look = |place: T| {
            let (value, slope) = pressure.at_and_slope(place);
            Named("pressure", value).finite()?;
            Named("the pressure's slope", slope).finite()?;
            let rule = Rule::NonNegativeAt { place: to_f64(place) };
            Named("pressure", value).check(value >= T::zero(), rule)
        };
        let (mut answer, mut total) = (look(T::zero()).and_then(|_| look(T::one())), T::zero());
        weigh(&pressure, None, T::zero().into(), |place, weighted| {
            answer = answer.and_then(|_| look(place));
            total += weighted;
        });
        answer?;
        Ok(Self { total, ..pressure })
    }

    /// The function of the place.
    pub fn function(&self) -> &S {
        &self.function
    }
}

impl<T: Scalar, S: Signal<T>> Pressure<T> for FunctionPressure<T, S> {
    fn at_and_slope(&self, place: T) -> (T, T) {
        self.function.value_and_rate(place)
    }

    fn next_knot(&self, place: T) -> Option<T> {
        self.function.next_kink(place, T::one())
    }

    fn total(&self) -> T {
        self.total
    }
}
