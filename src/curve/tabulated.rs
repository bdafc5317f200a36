//! A friction curve through measured points.

use core::fmt::Debug;

use crate::curve::FrictionCurve;
use crate::parameter::{Checked, Named, ParameterError};
use crate::scalar::lit;
use crate::{Bounds, Scalar, Sliding};

/// One measured point of a [`Tabulated`] curve.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Knot<T> {
    /// Speed |v| [m/s].
    pub speed: T,
    /// Friction coefficient μ \[–\] of steady sliding at that speed.
    pub coefficient: T,
}

/// A friction curve through measured points, by monotone cubic interpolation: for measured friction
/// that no formula fits. A point that is an outlier makes a bump: smooth noisy measurements before.
///
/// Between the knots (sᵢ, μᵢ) [m/s, –] it is the cubic Hermite interpolant whose slopes are the
/// weighted harmonic mean of the neighbouring secants, or zero where these change sign. So it is
/// continuously differentiable, monotone between any two knots, and has its extremes at knots.
///
/// Source: F. N. Fritsch, J. Butland, "A method for constructing local monotone piecewise cubic
/// interpolants", SIAM Journal on Scientific and Statistical Computing 5 (1984), 300–304. The slope
/// at rest is the three-point one, limited as in C. B. Moler, "Numerical Computing with MATLAB"
/// (SIAM, 2004), section 3.4; that at the last knot is the slope of the last secant, or zero if it
/// falls.
///
/// The storage S is an array ([`Tabulated::new`]) or, for a table of unknown length, a `Vec`
/// (`Tabulated::from_slice`).
///
/// Beyond the last knot the curve goes on straight: with the slope of the last two knots if they
/// rise, level if they fall (so that it stays positive). To slightly negative speeds, where a
/// solver's trial step has overshot a reversal, the first cubic is continued.
///
/// Source: F. N. Fritsch, J. Butland, "A method for constructing local monotone piecewise cubic
/// interpolants", SIAM Journal on Scientific and Statistical Computing 5 (1984), 300–304. The slope
/// at rest is the three-point one, limited as in C. B. Moler, "Numerical Computing with MATLAB"
/// (SIAM, 2004), section 3.4.
///
/// ```
/// use bristle::curve::{FrictionCurve, Knot, Tabulated};
///
/// let measured = [(0.0, 0.42), (0.01, 0.35), (0.1, 0.30), (1.0, 0.33)];
/// let curve = Tabulated::new(measured.map(|(speed, coefficient)| Knot { speed, coefficient }))?;
/// assert_eq!(curve.coefficient(0.1.into()), 0.30);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tabulated<S> {
    /// The cubic that starts at each knot; the last one is the straight line beyond.
    cubics: S,
}

/// What a [`Tabulated`] curve stores of each knot: the cubic from there to the next one. It is
/// public because the type of a curve names it, `Tabulated<[Cubic<f64>; 4]>`.
///
/// μ(s) = c₀ + x (c₁ + x (c₂ + x c₃)) with x = s − start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cubic<T> {
    start: T,
    coefficients: [T; 4],
}

impl<T: Scalar> Cubic<T> {
    #[inline]
    fn value(&self, speed: T) -> T {
        let [c0, c1, c2, c3] = self.coefficients;
        let x = speed - self.start;
        c0 + x * (c1 + x * (c2 + x * c3))
    }

    #[inline]
    fn slope(&self, speed: T) -> T {
        let [_, c1, c2, c3] = self.coefficients;
        let x = speed - self.start;
        c1 + x * (lit::<T>(2.0) * c2 + x * lit::<T>(3.0) * c3)
    }
}

impl<T: Scalar, const N: usize> Tabulated<[Cubic<T>; N]> {
    /// A curve through the knots of an array.
    ///
    /// # Errors
    ///
    /// Names the knot whose speed does not increase or whose coefficient is not positive, a first
    /// knot that is not at rest, or a table of fewer than two knots.
    pub fn new(knots: [Knot<T>; N]) -> Checked<Self> {
        check(&knots)?;
        Ok(Self { cubics: core::array::from_fn(|i| cubic_from(&knots, knots[i], i)) })
    }
}

#[cfg(feature = "alloc")]
impl<T: Scalar> Tabulated<alloc::vec::Vec<Cubic<T>>> {
    /// A curve through any number of knots, such as the rows of a file.
    ///
    /// ```
    /// use bristle::curve::{FrictionCurve, Knot, Tabulated};
    ///
    /// let file = "0,0.42\n0.01,0.35\n0.1,0.30\n";
    /// let mut knots = Vec::new();
    /// for line in file.lines() {
    ///     let (speed, coefficient) = line.split_once(',').ok_or("two columns, please")?;
    ///     knots.push(Knot { speed: speed.parse()?, coefficient: coefficient.parse()? });
    /// }
    /// let curve = Tabulated::from_slice(&knots)?;
    /// assert_eq!(curve.at(0.01), 0.35);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Those of [`Tabulated::new`].
    pub fn from_slice(knots: &[Knot<T>]) -> Checked<Self> {
        check(knots)?;
        let cubics = knots.iter().enumerate().map(|(i, &knot)| cubic_from(knots, knot, i));
        Ok(Self { cubics: cubics.collect() })
    }
}

impl<S> Tabulated<S> {
    /// The knots, as they were given.
    pub fn knots<T: Scalar>(&self) -> impl ExactSizeIterator<Item = Knot<T>>
    where
        S: AsRef<[Cubic<T>]>,
    {
        self.cubics.as_ref().iter().map(|&Cubic { start, coefficients: [coefficient, ..] }| Knot {
            speed: start,
            coefficient,
        })
    }

    /// The cubic that holds at a speed: the last one that does not start beyond it, or the first.
    /// At most log2 N comparisons.
    #[inline]
    fn cubic<T: Scalar>(&self, speed: T) -> Cubic<T>
    where
        S: AsRef<[Cubic<T>]>,
    {
        let cubics = self.cubics.as_ref();
        let started = cubics.partition_point(|cubic| cubic.start <= speed);
        // There are two at least.
        let nowhere = Cubic { start: T::zero(), coefficients: [T::nan(); 4] };
        cubics.get(started.saturating_sub(1)).copied().unwrap_or(nowhere)
    }
}

fn check<T: Scalar>(knots: &[Knot<T>]) -> Checked<()> {
    Named("knots", knots.len()).count(2)?;
    let mut previous = None;
    ParameterError::of_components(knots, |knot| {
        let speed = Named("speed", knot.speed);
        let before = previous.replace(knot.speed);
        before.map_or_else(|| speed.exactly(T::zero()), |before| speed.increasing(before))
    })?;
    ParameterError::of_components(knots, |it| Named("coefficient", it.coefficient).positive())?;
    for (index, (slope, spacing)) in (0..).map_while(|i| secant(knots, i)).enumerate() {
        ParameterError::of_component(index + 1, Named("slope", slope).finite())?;
        ParameterError::of_component(index + 1, Named("spacing", spacing).positive())?;
    }
    Ok(())
}

/// The secant of interval i (from knot i to knot i + 1) and its width; `None` from the last knot
/// on.
fn secant<T: Scalar>(knots: &[Knot<T>], i: usize) -> Option<(T, T)> {
    let [from, to] = knots.get(i..)?.first_chunk()?;
    let width = to.speed - from.speed;
    Some(((to.coefficient - from.coefficient) / width, width))
}

/// The slope of the curve at knot i.
fn slope<T: Scalar>(knots: &[Knot<T>], i: usize) -> T {
    let two: T = lit(2.0);
    let before = i.checked_sub(1).and_then(|before| secant(knots, before));
    match (before, secant(knots, i)) {
        (None, None) => T::zero(),
        (None, Some(near)) => secant(knots, 1).map_or(near.0, |next| end_slope(near, next)),
        // The curve goes on beyond with this slope: the secant, which a reader of the table
        // expects.
        (Some((last, _)), None) => last,
        (Some((before, h0)), Some((after, h1))) if before * after > T::zero() => {
            let (w0, w1) = (two * h1 + h0, h1 + two * h0);
            (w0 + w1) / (w0 / before + w1 / after)
        }
        _ => T::zero(),
    }
}

/// Three-point slope at rest from the secants of the first and the second interval, limited so that
/// the first interval stays monotone.
fn end_slope<T: Scalar>((near, h0): (T, T), (next, h1): (T, T)) -> T {
    let two: T = lit(2.0);
    let three: T = lit(3.0);
    let slope = ((two * h0 + h1) * near - h0 * next) / (h0 + h1);
    if slope * near <= T::zero() {
        T::zero()
    } else if near * next <= T::zero() && slope.abs() > three * near.abs() {
        three * near
    } else {
        slope
    }
}

/// The cubic from knot i to the next, or the straight line beyond the last.
fn cubic_from<T: Scalar>(knots: &[Knot<T>], knot: Knot<T>, i: usize) -> Cubic<T> {
    let Knot { speed: start, coefficient } = knot;
    // Beyond the last knot a falling curve is continued level, so it must arrive level.
    let slope_at = |i: usize| {
        let slope = slope(knots, i);
        let last = secant(knots, i).is_none();
        if last && slope < T::zero() { T::zero() } else { slope }
    };
    let d0 = slope_at(i);
    let Some((secant, width)) = secant(knots, i) else {
        return Cubic { start, coefficients: [coefficient, d0, T::zero(), T::zero()] };
    };
    let d1 = slope_at(i + 1);
    let c2 = (lit::<T>(3.0) * secant - lit::<T>(2.0) * d0 - d1) / width;
    let c3 = (d0 + d1 - lit::<T>(2.0) * secant) / (width * width);
    Cubic { start, coefficients: [coefficient, d0, c2, c3] }
}

impl<T: Scalar, S: AsRef<[Cubic<T>]> + Debug + Clone> FrictionCurve<T> for Tabulated<S> {
    #[inline]
    fn coefficient_and_slope(&self, sliding: Sliding<T>) -> (T, T) {
        let cubic = self.cubic(sliding.speed());
        (cubic.value(sliding.speed()), cubic.slope(sliding.speed()) * sliding.direction())
    }

    fn bounds(&self, fastest: T) -> Bounds<T> {
        let last = self.cubic(fastest);
        let [c0, c1, c2, c3] = last.coefficients;
        // Beyond the last knot the curve is straight; taken as a cubic, infinity would be NaN, and
        // so would infinity times a level slope.
        let straight = c2 == T::zero() && c3 == T::zero();
        let value = match (straight, c1 == T::zero()) {
            (true, true) => c0,
            (true, false) => c0 + c1 * (fastest - last.start),
            (false, _) => last.value(fastest),
        };
        let knots = self.cubics.as_ref().iter().take_while(|cubic| cubic.start <= fastest);
        let first = Bounds::constant(self.cubic(T::zero()).coefficients[0]);
        let of_knots = knots.map(|cubic| Bounds::constant(cubic.coefficients[0]));
        of_knots.fold(first, Bounds::union).union(Bounds::constant(value))
    }

    fn is_even(&self) -> bool {
        true
    }

    fn least_slope(&self) -> Option<T> {
        // Of each parabola: at its ends, which are knots, and at its lowest point.
        let cubics = self.cubics.as_ref();
        let mut least = cubics.last()?.coefficients[1];
        for (cubic, next) in cubics.iter().zip(cubics.iter().skip(1)) {
            let end = next.start;
            least = least.smaller(cubic.slope(cubic.start).smaller(cubic.slope(end)));
            let [_, _, c2, c3] = cubic.coefficients;
            let lowest = cubic.start - c2 / (lit::<T>(3.0) * c3);
            if c3 > T::zero() && lowest > cubic.start && lowest < end {
                least = least.smaller(cubic.slope(lowest));
            }
        }
        Some(least)
    }
}
