//! The friction curve alone, from rows in which the contact slides: a robust fit.
//!
//! Σ w(r/s) r² → min over the parameters of μ(v), by iteratively reweighted least squares (IRLS)
//! with Tukey's bisquare, see [`mechanism::Loss`](super::mechanism::Loss), from the plain fit on.
//! Gross outliers among the slowest points look like a static excess to the plain fit: the first
//! weighted one searches from several places, too.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | r | difference between the curve and a measured friction coefficient | – |
//! | s | robust estimate of the standard deviation of r | – |
//! | u, w | r/s, weight | – |
//!
//! Source: P. J. Huber, E. M. Ronchetti, "Robust Statistics" (2009), chapter 7; the constants are
//! the usual ones.

use core::ops::ControlFlow;

use super::initial_guess::{InitialGuess, SlidingPoint};
use super::log::quantile;
use super::problem::begin_at;
use super::residuals::{Parameter, Residuals};
use super::robust::Loss;
use super::{Fit, Log, SearchProgress, SearchSettings, least_squares};
use bristle::Scalar;
use bristle::curve::{FrictionCurve, Stribeck, StribeckParameters};
use bristle::parameter::{Checked, Named, ParameterError};
use bristle::scalar::lit;

/// Fewest points of a curve: its four parameters, and as many again to judge them by.
const FEWEST_POINTS: usize = 10;
/// Most points used. Of more, every second, third, … is taken: neighbours in time tell the same.
const MOST_POINTS: usize = 4000;
/// Most rounds. Weights settle by a factor of a few in each.
const ROUNDS: usize = 20;
/// Relative change of the parameters below which the weights have settled.
const SETTLED: f64 = 1e-6;
/// Searches for the first fit and for the first without its outliers: a valley in v_S may have
/// others beside it.
const STARTS: usize = 6;

/// The parameters that all Stribeck curves share: μ_d, μ_s − μ_d, v_S, σ2.
///
/// The bounds are so wide that data which determine a parameter do not reach them: a decade and a
/// half around μ_d, an excess from nothing (a thousandth) to 30 times μ_d, v_S over six decades
/// around the speeds seen, and a viscous force up to ten times μ_d at the largest speed.
pub(super) fn stribeck_parameters(guess: &InitialGuess) -> [Parameter; 4] {
    let (size, fastest) = (guess.dynamic_coefficient, guess.fastest);
    let viscosity = size / fastest;
    let excess = guess.static_coefficient - size;
    let (velocity, viscous) = (guess.stribeck_velocity, guess.viscous_friction);
    // A start at a bound could rest there.
    let inside = |name, unit, start: f64, least: f64, most: f64, typical| {
        let start = start.larger(1.1 * least).smaller(0.9 * most);
        Parameter { typical, ..Parameter::logarithmic(name, unit, start, least..=most) }
    };
    [
        Parameter::positive("dynamic_coefficient", "", size, 30.0),
        inside("static_excess", "", excess, 1e-3 * size, 30.0 * size, None),
        inside("stribeck_velocity", "m/s", velocity, 1e-4 * fastest, 1e2 * fastest, None),
        inside("viscous_friction", "s/m", viscous, 0.0, 10.0 * viscosity, Some(0.1 * viscosity)),
    ]
}

/// The usual Stribeck exponent δ.
pub(super) const EXPONENT: f64 = 2.0;

/// The [`Stribeck`] curve of these parameters.
pub(super) fn stribeck<T: Scalar>(
    &[dynamic_coefficient, excess, stribeck_velocity, viscous_friction]: &[T; 4],
    stribeck_exponent: f64,
) -> Checked<Stribeck<T>> {
    Stribeck::new(StribeckParameters {
        static_coefficient: dynamic_coefficient + excess,
        dynamic_coefficient,
        stribeck_velocity,
        stribeck_exponent: lit(stribeck_exponent),
        viscous_friction,
    })
}

/// Weighted distances of points from a curve.
struct Points<'a> {
    exponent: f64,
    points: &'a [SlidingPoint],
    /// √w of each.
    weights: Vec<f64>,
}

impl Residuals<4> for Points<'_> {
    fn evaluate<T: Scalar>(&self, values: &[T; 4], each: &mut impl FnMut(T)) -> Checked<()> {
        let curve = stribeck(values, self.exponent)?;
        for (point, &weight) in self.points.iter().zip(&self.weights) {
            each((curve.at(lit(point.speed)) - lit(point.coefficient)) * lit(weight));
        }
        Ok(())
    }
}

impl InitialGuess {
    /// A robust fit of the [`Stribeck`] curve of an exponent δ \[–\] through sliding data that may
    /// have outliers, from the start of this guess.
    ///
    /// ```
    /// use bristle_identify::{InitialGuess, SlidingPoint};
    ///
    /// // μ = 0.2 + 0.1 exp(−(v/v_S)²) + 2 v with v_S = 10 mm/s, and every tenth point wrong.
    /// let points: Vec<SlidingPoint> = (1..200)
    ///     .map(|i| {
    ///         let speed = 5e-4 * f64::from(i);
    ///         let wrong = if i % 10 == 0 { 0.5 } else { 0.0 };
    ///         let fall = 0.1 * (-(speed / 0.01).powi(2)).exp();
    ///         SlidingPoint { speed, coefficient: 0.2 + fall + 2.0 * speed + wrong }
    ///     })
    ///     .collect();
    /// let guess = InitialGuess {
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
    /// let fit = guess.static_curve(2.0, &points)?;
    /// assert!((fit.estimate("stribeck_velocity").unwrap().value - 0.01).abs() < 1e-6);
    /// // Had the points been of a joint:
    /// let joint = fit.in_units(bristle::Units::Rotation);
    /// assert_eq!(joint.estimate("stribeck_velocity").unwrap().parameter.unit, "rad/s");
    /// # Ok::<(), bristle::ParameterError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Refuses a Stribeck exponent out of its range, fewer than ten points, a point that is not
    /// finite, and bounds that do not contain the start.
    pub fn static_curve(&self, stribeck_exponent: f64, points: &[SlidingPoint]) -> Checked<Fit> {
        Named("points", points.len()).count(FEWEST_POINTS)?;
        ParameterError::of_components(points, |point| {
            Named("speed", point.speed).finite()?;
            Named("coefficient", point.coefficient).finite()
        })?;
        let every = points.len().div_ceil(MOST_POINTS);
        let points: Vec<SlidingPoint> = points.iter().step_by(every).copied().collect();
        let mut parameters = stribeck_parameters(self);
        let (exponent, weights) = (stribeck_exponent, vec![1.0; points.len()]);
        let mut problem = Points { exponent, points: &points, weights };
        let mut settings = SearchSettings { starts: STARTS, ..SearchSettings::default() };
        let mut go_on = |_: &SearchProgress<'_>| ControlFlow::Continue(());
        let mut fit = least_squares(&problem, parameters, &settings, &mut go_on)?;
        for _ in 0..ROUNDS {
            let curve = stribeck(&fit.array(), exponent)?;
            let distance = |point: &SlidingPoint| (curve.at(point.speed) - point.coefficient).abs();
            problem.weights = Loss::Tukey.weights(&points.iter().map(distance).collect::<Vec<_>>());
            if problem.weights.is_empty() {
                break;
            }
            begin_at(&mut parameters, &fit.values());
            let next = least_squares(&problem, parameters, &settings, &mut go_on)?;
            settings.starts = 1;
            let changed = |(a, b): (f64, f64)| (a - b).abs() > SETTLED * (a.abs() + b.abs());
            let settled = !fit.values().into_iter().zip(next.values()).any(changed);
            fit = next;
            if settled {
                break;
            }
        }
        Ok(fit)
    }

    /// A guess from a look at a log, with a robust fit of the curve where the speeds allow one.
    ///
    /// # Errors
    ///
    /// As [`InitialGuess::with_points`].
    pub fn of(log: &Log) -> Checked<Self> {
        let (guess, points) = Self::with_points(log)?;
        // Speeds that lie within a factor of two do not determine how friction depends on them.
        let mut speeds: Vec<f64> = points.iter().map(|point| point.speed).collect();
        let vary = quantile(&mut speeds, 0.9) > 2.0 * quantile(&mut speeds, 0.1);
        let fit = vary.then(|| guess.static_curve(EXPONENT, &points).ok()).flatten();
        let Some(fit) = fit else { return Ok(guess) };
        let [dynamic_coefficient, excess, stribeck_velocity, viscous_friction] = fit.array();
        Ok(Self {
            static_coefficient: dynamic_coefficient + excess,
            dynamic_coefficient,
            // Beyond the largest speed nothing determines the curve.
            stribeck_velocity: stribeck_velocity.min(guess.fastest),
            viscous_friction,
            ..guess
        })
    }
}
