//! A pressure that is linear from knot to knot.
//!
//! On a piece from ξ = a of width w, with p = p₀(1 − t) + p₁ t at ξ = a + w t,
//!
//! ∫ p e^(−sξ) dξ = w e^(−sa) (p₀(ψ₀ − ψ₁) + p₁ψ₁)(sw),
//! ∫ p (1 − e^(−κξ)) dξ = w ((1 − e^(−κa))(p₀ + p₁)/2 + e^(−κa) κw (p₀(χ₀ − χ₁) + p₁χ₁)(0, κw)),
//!
//! sums of positive terms, with the moments ψ and χ of a decaying and of a rising profile.

use nalgebra::{Complex, ComplexField};

use super::{Pressure, without_rolling};
use crate::Scalar;
use crate::parameter::{self, ParameterError};
use crate::rolling::moments::{complex_decaying, decaying, rising};
use crate::scalar::lit;

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
    /// Two at the same place are a jump.
    knots: [PressureKnot<T>; N],
}

impl<T: Scalar, const N: usize> TabulatedPressure<T, N> {
    /// A pressure through the knots.
    ///
    /// # Errors
    ///
    /// Names the knot whose place does not increase or whose pressure is negative; refuses a first
    /// knot that is not at 0, a last one that is not at 1, and fewer than two.
    pub fn new(knots: [PressureKnot<T>; N]) -> Result<Self, ParameterError> {
        parameter::count("knots", N, 2)?;
        for (index, knot) in knots.iter().enumerate() {
            let place = match index + 1 {
                end if end == N => parameter::exactly("place", knot.place, T::one()),
                _ => parameter::below("place", knot.place, "the outlet", T::one()),
            };
            parameter::component(index, place)?;
            parameter::component(index, parameter::non_negative("pressure", knot.pressure))?;
        }
        parameter::abscissas("place", knots.iter().map(|knot| knot.place))?;
        Ok(Self { knots })
    }

    /// The knots.
    pub fn knots(&self) -> &[PressureKnot<T>; N] {
        &self.knots
    }

    /// Start, width and the two pressures of each piece that has a width.
    fn pieces(&self) -> impl Iterator<Item = (T, T, T, T)> + '_ {
        self.knots.windows(2).filter_map(|pair| match pair {
            [a, b] if b.place > a.place => {
                Some((a.place, b.place - a.place, a.pressure, b.pressure))
            }
            _ => None,
        })
    }

    /// ∫ p e^(−sξ) dξ, with the moments ψ₀ and ψ₁ of a number of its kind.
    fn faded<C>(&self, rate: C, moments: impl Fn(C) -> [C; 2]) -> C
    where
        C: ComplexField<RealField = T>,
    {
        self.pieces().fold(C::zero(), |sum, (from, width, start, end)| {
            let [flat, tilted] = moments(rate.clone().scale(width));
            let within = (flat - tilted.clone()).scale(start) + tilted.scale(end);
            sum + ((-rate.clone().scale(from)).exp() * within).scale(width)
        })
    }
}

/// Parameters of [`TabulatedPressure::trapezoidal`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrapezoidalParameters<T> {
    /// Part of the patch over which the pressure rises from zero \[–\]; 0 for a pressure that
    /// starts at the inlet with its full height.
    pub rising_part: T,
    /// Part of the patch over which it falls to zero \[–\]; 0 for one that keeps its full height up
    /// to the outlet. The two parts together are at most 1.
    pub falling_part: T,
    /// Pressure between the two [N/m], positive.
    pub plateau: T,
}

impl<T: Scalar> TabulatedPressure<T, 4> {
    /// The pressure that rises linearly over a first part of the patch, is constant, and falls
    /// linearly over a last part. The tyres of lorries come close to it. With two parts of ½ it is
    /// a triangle.
    ///
    /// ```
    /// use bristle::rolling::{Pressure, TabulatedPressure, TrapezoidalParameters};
    ///
    /// let pressure = TabulatedPressure::trapezoidal(TrapezoidalParameters {
    ///     rising_part: 0.1,
    ///     falling_part: 0.3,
    ///     plateau: 50e3_f64, // N/m
    /// })?;
    /// assert!((pressure.at(0.05) - 25e3).abs() < 1e-9);
    /// assert!((pressure.total() - 40e3).abs() < 1e-9);
    /// # Ok::<(), bristle::ParameterError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range, and `falling_part` if the two parts are more
    /// than the patch.
    pub fn trapezoidal(parameters: TrapezoidalParameters<T>) -> Result<Self, ParameterError> {
        let TrapezoidalParameters { rising_part, falling_part, plateau } = parameters;
        let plateau = parameter::positive("plateau", plateau)?;
        let rising = parameter::non_negative("rising_part", rising_part)?;
        let rising = parameter::at_most("rising_part", rising, "the whole patch", T::one())?;
        let falling = parameter::non_negative("falling_part", falling_part)?;
        let left = T::one() - rising;
        let falling = parameter::at_most("falling_part", falling, "what is left", left)?;
        // 1 − (1 − x) can be a rounding above or below x.
        let end = crate::bounds::larger(T::one() - falling, rising);
        let knot = |place, pressure| PressureKnot { place, pressure };
        let (zero, one) = (T::zero(), T::one());
        Ok(Self {
            knots: [knot(zero, zero), knot(rising, plateau), knot(end, plateau), knot(one, zero)],
        })
    }
}

impl<T: Scalar, const N: usize> Pressure<T> for TabulatedPressure<T, N> {
    fn at_and_slope(&self, place: T) -> (T, T) {
        let mut answer = (T::zero(), T::zero());
        for (from, width, start, end) in self.pieces() {
            if !(place < from) || !(from > T::zero()) {
                let slope = (end - start) / width;
                let t = (place - from) / width;
                answer = (start * (T::one() - t) + end * t, slope);
            }
        }
        answer
    }

    fn next_knot(&self, place: T) -> Option<T> {
        self.knots.iter().map(|knot| knot.place).find(|&knot| knot > place && knot < T::one())
    }

    fn total(&self) -> T {
        self.pieces()
            .fold(T::zero(), |sum, (_, width, start, end)| sum + width * (start + end) * lit(0.5))
    }

    fn rise(&self, decay: T) -> T {
        self.pieces().fold(T::zero(), |sum, (from, width, start, end)| {
            let steepness = decay * width;
            // Of pieces that the profile has settled before, or at once.
            let settled = width * (start + end) * lit(0.5);
            if without_rolling(steepness) {
                return sum + settled;
            }
            let left = (-decay * from).exp();
            let [flat, tilted] = rising::<T, 2>(T::zero(), steepness);
            let within = start * (flat - tilted) + end * tilted;
            sum - (-decay * from).exp_m1() * settled + left * width * steepness * within
        })
    }

    fn remaining(&self, decay: T) -> T {
        if without_rolling(decay) {
            return T::zero();
        }
        self.faded(decay, decaying)
    }

    fn lever(&self, decay: T) -> T {
        if without_rolling(decay) {
            return T::zero();
        }
        self.pieces().fold(T::zero(), |sum, (from, width, start, end)| {
            let [flat, tilted, bent] = decaying::<T, 3>(decay * width);
            let within = start * (flat - tilted) + end * tilted;
            let moment = start * (tilted - bent) + end * bent;
            sum + (-decay * from).exp() * width * (from * within + width * moment)
        })
    }

    fn transform(&self, rate: Complex<T>) -> Complex<T> {
        self.faded(rate, complex_decaying)
    }
}
