//! How accurate each state shall be.

use core::marker::PhantomData;

use nalgebra::ComplexField;

use super::controller::rough_power;
use super::storage::States;
use crate::Scalar;
use crate::parameter::{Checked, Named, ParameterError};
use crate::scalar::{lit, to_f64};

/// Smallest relative tolerance over the rounding ε of the scalar type. The sums of one step round
/// by a few ε, which no shorter step makes smaller.
const LEAST: f64 = 10.0;

/// Largest relative tolerance: a coarser answer is none.
const MOST: f64 = 0.1;

/// How loose the steps of a method may be where nothing is known of the growth of errors: with
/// coarser ones a slip is missed without an error to show it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ToleranceRange {
    /// The tolerance of a solution that a run aims at.
    pub(super) aim: f64,
    /// The least part of an estimated error of a tight step that its error is taken to be.
    part: f64,
}

impl ToleranceRange {
    /// Of the single methods.
    pub(crate) const SINGLE: Self = Self { aim: 1e-4, part: 1.0 };
    /// Of the Rosenbrock methods. Their estimate is the error of a solution of an order lower than
    /// theirs, and with short steps far too large: at 1e-10, 20 to 1 000 times over a floor.
    pub(crate) const ROSENBROCK: Self = Self { part: 0.1, ..Self::SINGLE };
    /// Of [`Automatic`](super::Automatic): its steps are those of a Rosenbrock method where the
    /// system is stiff and of order eight elsewhere, and miss less. With steps twice as loose three
    /// of eight thousand answers on drawn scenes were far off.
    pub(crate) const AUTOMATIC: Self = Self { aim: 2e-4, part: 1.0 };

    /// The part of an estimate of an order q, with a tolerance ε of the step, that is taken to be
    /// its error: ten times ε^(1/q), which is about the step over the time in which states change.
    pub(super) fn part_of_estimate(&self, tolerance: f64, order: u8) -> f64 {
        if self.part == 1.0 {
            return 1.0;
        }
        let short = 10.0 * rough_power(tolerance, 1.0 / f64::from(order));
        short.clamp(self.part, 1.0)
    }
}

/// The tolerance of a step over that of the solution, where nothing is known of the growth of
/// errors: in stick-slip they often grow a thousandfold.
const OF_STEP: f64 = 2.5e-4;

/// Finest relative tolerance of a step over the rounding ε, unless a finer one is asked for.
const FINEST: f64 = 30.0;

/// Largest estimated error of a solution over its tolerance, of up to three states. Tolerances hold
/// in the root mean square, so that of N states one may have √N times as much.
const ACCEPTED: f64 = 12.0;

/// Roundings that grow as errors of steps do, a thousandfold and more, are accepted, too.
const ROUNDINGS: f64 = 4e3 * FINEST;

/// But no more than so many tolerances.
const MOST_ACCEPTED: f64 = 300.0;

/// Tolerances of a solution, per component: |errorᵢ| ≤ absoluteᵢ + relativeᵢ |xᵢ|, in the
/// root mean square over the components.
///
/// States of a friction problem differ by many orders of magnitude (a deflection of 10⁻⁶ m beside
/// a pressure of 10⁵ Pa): one absolute tolerance for all of them is always wrong for some.
///
/// ```
/// use bristle::ode::Tolerances;
/// use bristle::nalgebra::Vector3;
///
/// // Position, velocity, bristle deflection: 1e-8 of their typical magnitudes.
/// let tolerances = Tolerances::scaled(1e-8, Vector3::new(1.0, 0.1, 1e-4))?;
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerances<T, V> {
    relative: V,
    absolute: V,
    scalar: PhantomData<T>,
}

impl<T: Scalar, V: States<T>> Tolerances<T, V> {
    /// Relative tolerances \[–\] and absolute ones, in the unit of each state; all positive.
    ///
    /// # Errors
    ///
    /// Names the component that is not positive, and a relative tolerance that the rounding of the
    /// scalar type would exceed: below 10 ε, that is 2·10⁻¹⁵ in `f64` and 1.2·10⁻⁶ in `f32`.
    pub fn new(relative: V, absolute: V) -> Checked<Self> {
        ParameterError::of_components(relative.entries(), |&value| check("relative", value))?;
        let positive = |&value: &T| Named("absolute", value).positive();
        ParameterError::of_components(absolute.entries(), positive)?;
        Ok(Self { relative, absolute, scalar: PhantomData })
    }

    /// A relative tolerance for every state, and the same fraction of its typical magnitude as
    /// the absolute one. [`System::scales`](super::System::scales) gives the magnitudes.
    ///
    /// # Errors
    ///
    /// Refuses a tolerance or a scale that is not positive, and a tolerance below 10 ε.
    pub fn scaled(relative: T, scales: V) -> Checked<Self> {
        check("relative", relative)?;
        let positive = |&scale: &T| Named("scales", scale).positive();
        ParameterError::of_components(scales.entries(), positive)?;
        Self::new(scales.like(|_| relative), scales.like(|i| scales[i] * relative))
    }

    /// The largest of the relative tolerances.
    pub(super) fn largest(&self) -> f64 {
        self.relative.entries().iter().fold(0.0, |most, &part| f64::max(most, to_f64(part)))
    }

    /// The relative error that a solution with these tolerances aims at.
    pub(super) fn aim(&self, range: ToleranceRange) -> f64 {
        self.largest().min(range.aim)
    }

    /// The largest estimated error of a solution over these tolerances of its steps, by its aim.
    pub(super) fn most_growth(&self, aim: f64) -> f64 {
        let roundings = f64::min(ROUNDINGS * to_f64(T::default_epsilon()), MOST_ACCEPTED * aim);
        let alone = ComplexField::sqrt(f64::max(self.relative.count() as f64 / 3.0, 1.0));
        (ACCEPTED * alone * aim).max(roundings) / self.largest()
    }

    /// The tolerances of one step, of these of the solution and its aim.
    pub(super) fn of_a_step(self, aim: f64) -> Self {
        self.times(aim / self.largest() * OF_STEP).unwrap_or(self)
    }

    /// So many times these, or no less than rounding allows; none if little is left to gain.
    pub(super) fn times(&self, times: f64) -> Option<Self> {
        let finest = FINEST * to_f64(T::default_epsilon());
        let least =
            self.relative.entries().iter().fold(1.0, |least, &part| f64::min(least, to_f64(part)));
        let times = times.max((finest / least).min(1.0));
        if times <= 1.0 && times > 0.5 {
            return None;
        }
        let part: T = lit(times);
        let of = |tolerance: &V| tolerance.like(|i| tolerance[i] * part);
        let (relative, absolute) = (of(&self.relative), of(&self.absolute));
        Some(Self { relative, absolute, scalar: PhantomData })
    }

    /// The absolute tolerance of each state.
    pub fn absolute(&self) -> &V {
        &self.absolute
    }

    /// The relative tolerance of each state.
    pub fn relative(&self) -> &V {
        &self.relative
    }

    /// The error allowed each state where it is found.
    #[inline]
    pub(super) fn at(&self, state: &V) -> V {
        let mut allowed = state.clone();
        let tolerances = self.absolute.entries().iter().zip(self.relative.entries());
        for (x, (&absolute, &relative)) in allowed.entries_mut().iter_mut().zip(tolerances) {
            *x = absolute + relative * x.abs();
        }
        allowed
    }
}

/// Checks a relative tolerance.
pub(super) fn check<T: Scalar>(name: &'static str, relative: T) -> Checked<T> {
    Named(name, relative).between(LEAST * to_f64(T::default_epsilon()), MOST)
}
