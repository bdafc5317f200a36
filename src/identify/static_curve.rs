//! The friction curve alone, from rows in which the contact slides: a robust fit.
//!
//! Σ w(r/s) r² → min over the parameters of μ(v), by weighted least squares over and over (IRLS), with Tukey's bisquare
//!
//! w(u) = (1 − (u/4.685)²)² within |u| < 4.685, else 0,  s = 1.4826 median|r|,
//!
//! which loses 5 % of the efficiency under Gaussian noise and forgets what lies far off. The first rounds use Huber's
//! w(u) = min(1, 1.345/|u|), which has no other minima.
//!
//! Source: P. J. Huber, E. M. Ronchetti, "Robust Statistics" (2009), chapter 7; the constants are the usual ones.

use alloc::vec::Vec;
use core::fmt::Debug;
use core::ops::ControlFlow;

use super::log::median;
use super::residuals::{Parameter, Residuals, Scaling, within};
use super::{Fit, IdentifyError, InitialGuess, Settings, least_squares};
use crate::Scalar;
use crate::curve::{
    FrictionCurve, RationalStribeck, RationalStribeckParameters, Stribeck, StribeckParameters,
};
use crate::parameter::ParameterError;
use crate::scalar::lit;

/// Friction in sliding, far enough from the last reversal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlidingPoint {
    /// Speed |v| [m/s].
    pub speed: f64,
    /// Friction coefficient \[–\] against the motion.
    pub coefficient: f64,
}

/// A friction curve with N parameters to be found.
pub trait CurveCandidate<const N: usize>: Debug {
    /// The curve, in any scalar.
    type Curve<T: Scalar>: FrictionCurve<T>;

    /// The parameters and where to look for them.
    fn parameters(&self) -> [Parameter; N];

    /// The curve with these parameters.
    ///
    /// # Errors
    ///
    /// Parameters out of their ranges.
    fn curve<T: Scalar>(&self, values: &[T; N]) -> Result<Self::Curve<T>, ParameterError>;
}

/// The parameters that all Stribeck curves share: μ_d, μ_s − μ_d, v_S, σ2.
pub(super) fn stribeck_parameters(rough: &InitialGuess) -> [Parameter; 4] {
    let InitialGuess {
        static_coefficient,
        dynamic_coefficient,
        stribeck_velocity,
        viscous_friction,
        fastest,
        ..
    } = *rough;
    let size = dynamic_coefficient;
    // Less than a thousandth of μ_d is no drop.
    let excess = within(static_coefficient - size, 2e-3 * size, 20.0 * size);
    let viscous = within(viscous_friction, 0.0, 9.0 * size / fastest);
    let velocity = within(stribeck_velocity, 1.1e-4 * fastest, 90.0 * fastest);
    [
        Parameter::positive("dynamic_coefficient", "", size, 30.0),
        Parameter {
            name: "static_excess",
            unit: "",
            start: excess,
            least: 1e-3 * size,
            most: 30.0 * size,
            scaling: Scaling::Logarithmic,
        },
        Parameter {
            name: "stribeck_velocity",
            unit: "m/s",
            start: velocity,
            least: 1e-4 * fastest,
            most: 100.0 * fastest,
            scaling: Scaling::Logarithmic,
        },
        Parameter {
            name: "viscous_friction",
            unit: "s/m",
            start: viscous,
            least: 0.0,
            most: 10.0 * size / fastest,
            scaling: Scaling::Linear { typical: 0.1 * size / fastest },
        },
    ]
}

/// The [`Stribeck`] curve of a given exponent: dynamic coefficient μ_d, static excess μ_s − μ_d, Stribeck velocity,
/// viscous friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StribeckCurve {
    /// Where to begin.
    pub rough: InitialGuess,
    /// Stribeck exponent δ \[–\].
    pub exponent: f64,
}

impl CurveCandidate<4> for StribeckCurve {
    type Curve<T: Scalar> = Stribeck<T>;

    fn parameters(&self) -> [Parameter; 4] {
        stribeck_parameters(&self.rough)
    }

    fn curve<T: Scalar>(&self, values: &[T; 4]) -> Result<Stribeck<T>, ParameterError> {
        stribeck(values, lit(self.exponent))
    }
}

pub(super) fn stribeck<T: Scalar>(
    &[dynamic_coefficient, excess, stribeck_velocity, viscous_friction]: &[T; 4],
    stribeck_exponent: T,
) -> Result<Stribeck<T>, ParameterError> {
    Stribeck::new(StribeckParameters {
        static_coefficient: dynamic_coefficient + excess,
        dynamic_coefficient,
        stribeck_velocity,
        stribeck_exponent,
        viscous_friction,
    })
}

/// The [`RationalStribeck`] curve, with the parameters of [`StribeckCurve`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RationalCurve {
    /// Where to begin.
    pub rough: InitialGuess,
}

impl CurveCandidate<4> for RationalCurve {
    type Curve<T: Scalar> = RationalStribeck<T>;

    fn parameters(&self) -> [Parameter; 4] {
        stribeck_parameters(&self.rough)
    }

    fn curve<T: Scalar>(
        &self,
        &[dynamic_coefficient, excess, stribeck_velocity, viscous_friction]: &[T; 4],
    ) -> Result<RationalStribeck<T>, ParameterError> {
        RationalStribeck::new(RationalStribeckParameters {
            static_coefficient: dynamic_coefficient + excess,
            dynamic_coefficient,
            stribeck_velocity,
            viscous_friction,
        })
    }
}

/// Weighted distances of points from a curve.
struct Points<'a, C, const N: usize> {
    candidate: &'a C,
    parameters: [Parameter; N],
    points: &'a [SlidingPoint],
    /// √w of each.
    weights: Vec<f64>,
}

impl<C: CurveCandidate<N>, const N: usize> Residuals<N> for Points<'_, C, N> {
    fn parameters(&self) -> [Parameter; N] {
        self.parameters
    }

    fn evaluate<T: Scalar>(
        &self,
        values: &[T; N],
        each: &mut impl FnMut(T),
    ) -> Result<(), ParameterError> {
        let curve = self.candidate.curve(values)?;
        for (point, &weight) in self.points.iter().zip(&self.weights) {
            each((curve.at(lit(point.speed)) - lit(point.coefficient)) * lit(weight));
        }
        Ok(())
    }
}

/// Most points used: of more, every second, third, …
const MOST_POINTS: usize = 4000;

/// A friction curve through sliding data that may have outliers.
///
/// ```
/// use bristle::identify::{InitialGuess, SlidingPoint, StribeckCurve, static_curve};
///
/// // μ = 0.2 + 0.1 exp(−(v/v_S)²) + 2 v with v_S = 10 mm/s, and every tenth point wrong.
/// let points: Vec<SlidingPoint> = (1..200)
///     .map(|i| {
///         let speed = 5e-4 * f64::from(i);
///         let wrong = if i % 10 == 0 { 0.5 } else { 0.0 };
///         SlidingPoint { speed, coefficient: 0.2 + 0.1 * (-(speed / 0.01).powi(2)).exp() + 2.0 * speed + wrong }
///     })
///     .collect();
/// let rough = InitialGuess {
///     static_coefficient: 0.4,
///     dynamic_coefficient: 0.25,
///     stribeck_velocity: 0.03,
///     viscous_friction: 0.1,
///     micro_stiffness: 1e4,
///     micro_damping: 1.0,
///     offset: 0.0,
///     fastest: 0.1,
///     reversals: 1,
/// };
/// let fit = static_curve(&StribeckCurve { rough, exponent: 2.0 }, &points)?;
/// assert!((fit.estimate("stribeck_velocity").unwrap().value - 0.01).abs() < 1e-6);
/// # Ok::<(), bristle::identify::IdentifyError>(())
/// ```
///
/// # Errors
///
/// Fewer than ten points, or one that is not finite; bounds that do not hold the start.
pub fn static_curve<C: CurveCandidate<N>, const N: usize>(
    candidate: &C,
    points: &[SlidingPoint],
) -> Result<Fit<N>, IdentifyError> {
    let usable = |point: &SlidingPoint| point.speed.is_finite() && point.coefficient.is_finite();
    if points.len() < 10 {
        return Err(IdentifyError::TooFewRows { rows: points.len(), least: 10 });
    }
    if let Some((row, point)) = points.iter().enumerate().find(|(_, point)| !usable(point)) {
        let bad_speed = !point.speed.is_finite();
        let (column, value) =
            if bad_speed { ("speed", point.speed) } else { ("coefficient", point.coefficient) };
        return Err(IdentifyError::Row { row, column, value, rule: "be finite" });
    }
    let every = points.len().div_ceil(MOST_POINTS);
    let points: Vec<SlidingPoint> = points.iter().step_by(every).copied().collect();
    let weights = alloc::vec![1.0; points.len()];
    let mut problem =
        Points { candidate, parameters: candidate.parameters(), points: &points, weights };
    // Several starts: a valley in v_S may have others beside it.
    let first = Settings { starts: 6, ..Settings::default() };
    let mut fit = least_squares(&problem, &first, &mut |_| ControlFlow::Continue(()))?;
    for round in 0..20 {
        let curve = candidate.curve(&fit.values())?;
        let off: Vec<f64> =
            points.iter().map(|point| (curve.at(point.speed) - point.coefficient).abs()).collect();
        let spread = 1.4826 * median(&mut off.clone());
        if !(spread > 0.0) {
            break;
        }
        let weight = |off: &f64| {
            let u = off / spread;
            if round < 5 {
                (1.345 / u).min(1.0).sqrt()
            } else {
                (1.0 - (u / 4.685).powi(2)).max(0.0)
            }
        };
        problem.weights = off.iter().map(weight).collect();
        for (parameter, value) in problem.parameters.iter_mut().zip(fit.values()) {
            parameter.start = value;
        }
        let settings = Settings { starts: 1, ..first };
        let next = least_squares(&problem, &settings, &mut |_| ControlFlow::Continue(()))?;
        let changed = |(a, b): (f64, f64)| (a - b).abs() > 1e-6 * (a.abs() + b.abs());
        let moved = fit.values().into_iter().zip(next.values()).any(changed);
        fit = next;
        if round > 5 && !moved {
            break;
        }
    }
    Ok(fit)
}
