//! A pressure through measured points, linear between them.

use super::Pressure;
use super::linear::linear_pressure;
use crate::Scalar;
use crate::parameter::{self, ParameterError, Rule};

/// One measured point of a [`TabulatedPressure`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PressureKnot<T> {
    /// Place ξ in the patch \[–\], 0 at the inlet and 1 at the outlet.
    pub place: T,
    /// Pressure p [N/m], zero or positive.
    pub pressure: T,
}

/// The pressure through N measured points, linear between them.
///
/// ```
/// use bristle::rolling::{Pressure, PressureKnot, TabulatedPressure};
///
/// let measured = [(0.0, 0.0_f64), (0.2, 900.0), (0.7, 600.0), (1.0, 0.0)];
/// let pressure =
///     TabulatedPressure::new(measured.map(|(place, pressure)| PressureKnot { place, pressure }))?;
/// assert!((pressure.at(0.45) - 750.0).abs() < 1e-9);
/// assert!((pressure.total() - 555.0).abs() < 1e-9);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TabulatedPressure<T, const N: usize> {
    knots: [PressureKnot<T>; N],
}

impl<T: Scalar, const N: usize> TabulatedPressure<T, N> {
    /// A pressure through the knots.
    ///
    /// # Errors
    ///
    /// Names the knot whose place does not increase or whose pressure is negative; refuses a first knot
    /// that is not at 0, a last one that is not at 1, and fewer than two.
    pub fn new(knots: [PressureKnot<T>; N]) -> Result<Self, ParameterError> {
        if N < 2 {
            return Err(ParameterError {
                name: "knots",
                component: None,
                value: N as f64,
                rule: Rule::Count { least: 2 },
            });
        }
        let mut previous = None;
        for (index, knot) in knots.iter().enumerate() {
            let place = match previous {
                None => parameter::exactly("place", knot.place, T::zero()),
                Some(before) => parameter::finite("place", knot.place)
                    .and_then(|place| parameter::increasing("place", place, before))
                    .and_then(|place| match index {
                        last if last + 1 == N => parameter::exactly("place", place, T::one()),
                        _ => parameter::below("place", place, "the outlet", T::one()),
                    }),
            };
            previous = Some(parameter::component(index, place)?);
            parameter::component(index, parameter::non_negative("pressure", knot.pressure))?;
        }
        Ok(Self { knots })
    }

    /// The knots.
    pub fn knots(&self) -> &[PressureKnot<T>; N] {
        &self.knots
    }
}

impl<T: Scalar, const N: usize> Pressure<T> for TabulatedPressure<T, N> {
    linear_pressure!();
}
