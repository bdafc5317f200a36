//! Solvers of a patch, and the way from answer to answer with one of them.
//!
//! A patch forgets all that is more than a transit old: where two answers lie further apart, what is between
//! is not rolled through but for the last transit before the second.

use alloc::boxed::Box;
use alloc::vec::Vec;
use core::fmt::Debug;
use core::ops::Range;

use crate::parameter::{self, ParameterError, Rule};
use crate::rolling::{
    ExactPatch, Grid, Motion, MotionOverTime, Patch, PatchParameters, PolynomialExponential,
    Pressure, RateDependent, Segment,
};
use crate::scalar::{lit, to_f64};
use crate::signal::Signal;
use crate::{Affine, Scalar};

/// What a step of [`Scheme::Gauss`] crosses at most of the patch: more would be divided by
/// [`ExactPatch::follow`] itself, unseen.
const LONGEST: f64 = 0.25;
/// Transits in one step that are rolled through where the last one was not found, for a jump of the transport velocity.
const MOST_TRANSITS: f64 = 1e4;
/// Most segments that a patch is given memory for; beyond it narrow ones are merged.
const MOST_SEGMENTS: f64 = 20_000.0;

/// How a patch is stepped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scheme {
    /// The motion of the middle, held.
    Held,
    /// Fourth order, with the motion at two Gauss points.
    Gauss,
}

/// A patch in motion.
pub(super) trait Roll<T, S, W> {
    fn hold(&mut self, motion: Motion<T>, duration: T) -> Result<(), ParameterError>;
    fn follow(
        &mut self,
        motion: &MotionOverTime<S, W>,
        span: Range<T>,
    ) -> Result<(), ParameterError>;
    /// L ∫ p z dξ [N m]
    fn gathered(&self) -> T;
    /// What has to be crossed besides the patch itself until nothing is left of what was \[–\].
    fn beyond(&self) -> f64;
}

impl<T, M, S, W, const N: usize> Roll<T, S, W> for ExactPatch<T, M, N, Vec<Segment<T, N>>>
where
    T: Scalar,
    M: RateDependent<T>,
    S: Signal<T>,
    W: Signal<T>,
{
    fn hold(&mut self, motion: Motion<T>, duration: T) -> Result<(), ParameterError> {
        ExactPatch::hold(self, motion, duration).map(drop)
    }

    fn follow(
        &mut self,
        motion: &MotionOverTime<S, W>,
        span: Range<T>,
    ) -> Result<(), ParameterError> {
        self.roll_along(motion, span)
    }

    fn gathered(&self) -> T {
        ExactPatch::gathered(self)
    }

    fn beyond(&self) -> f64 {
        // Distances are summed up in another order here.
        1e-3
    }
}

/// The exact reduction under a pressure that it has no moments of: by quadrature over the profile.
struct Weighed<'a, T: Scalar, M, P> {
    exact: ExactPatch<T, M, 1, Vec<Segment<T, 1>>>,
    pressure: &'a P,
}

impl<T, M, P, S, W> Roll<T, S, W> for Weighed<'_, T, M, P>
where
    T: Scalar,
    M: RateDependent<T>,
    P: Pressure<T>,
    S: Signal<T>,
    W: Signal<T>,
{
    fn hold(&mut self, motion: Motion<T>, duration: T) -> Result<(), ParameterError> {
        self.exact.hold(motion, duration).map(drop)
    }

    fn follow(
        &mut self,
        motion: &MotionOverTime<S, W>,
        span: Range<T>,
    ) -> Result<(), ParameterError> {
        self.exact.roll_along(motion, span)
    }

    fn gathered(&self) -> T {
        self.exact.gathered_under(self.pressure)
    }

    fn beyond(&self) -> f64 {
        1e-3
    }
}

impl<T, M, S, W> Roll<T, S, W> for Grid<T, M>
where
    T: Scalar,
    M: RateDependent<T>,
    S: Signal<T>,
    W: Signal<T>,
{
    fn hold(&mut self, motion: Motion<T>, duration: T) -> Result<(), ParameterError> {
        self.step(motion, duration).map(drop)
    }

    fn follow(
        &mut self,
        motion: &MotionOverTime<S, W>,
        span: Range<T>,
    ) -> Result<(), ParameterError> {
        let middle = (span.start + span.end) * lit(0.5);
        self.step(at(motion, middle), span.end - span.start).map(drop)
    }

    fn gathered(&self) -> T {
        let nodes = self.weights().iter().zip(self.deflections());
        nodes.fold(T::zero(), |sum, (&weight, &deflection)| sum + weight * deflection)
    }

    fn beyond(&self) -> f64 {
        // Interpolation reaches some cells further.
        3.0 / self.cells() as f64
    }
}

/// A patch with bristles as they are in steady rolling, or undeflected, with memory for so many segments.
pub(super) type Build<T, M, P, S, W> =
    for<'a> fn(
        &'a Patch<T, M, P>,
        usize,
        Option<Motion<T>>,
    ) -> Result<Box<dyn Roll<T, S, W> + 'a>, ParameterError>;

pub(super) fn exact<T, M, S, W, const N: usize>(
    patch: &Patch<T, M, PolynomialExponential<T, N>>,
    segments: usize,
    settled: Option<Motion<T>>,
) -> Result<Box<dyn Roll<T, S, W> + '_>, ParameterError>
where
    T: Scalar,
    M: RateDependent<T>,
    S: Signal<T>,
    W: Signal<T>,
{
    let mut exact = patch.clone().exact_in(segments)?;
    if let Some(motion) = settled {
        exact.settle(motion)?;
    }
    Ok(Box::new(exact))
}

pub(super) fn weighed<T, M, P, S, W>(
    patch: &Patch<T, M, P>,
    segments: usize,
    settled: Option<Motion<T>>,
) -> Result<Box<dyn Roll<T, S, W> + '_>, ParameterError>
where
    T: Scalar,
    M: RateDependent<T>,
    P: Pressure<T>,
    S: Signal<T>,
    W: Signal<T>,
{
    // Under a pressure of one, so that what multiplies it is that of the patch.
    let constant = Patch::new(PatchParameters {
        model: patch.model().clone(),
        length: patch.length(),
        pressure: PolynomialExponential::constant(),
    })?;
    let normal_force = constant.normal_force() * patch.load();
    let mut exact = constant.carrying(normal_force)?.exact_in(segments)?;
    if let Some(motion) = settled {
        exact.settle(motion)?;
    }
    Ok(Box::new(Weighed { exact, pressure: patch.pressure() }))
}

pub(super) fn grid<T, M, P, S, W>(
    patch: &Patch<T, M, P>,
    cells: usize,
    settled: Option<Motion<T>>,
) -> Result<Box<dyn Roll<T, S, W> + '_>, ParameterError>
where
    T: Scalar,
    M: RateDependent<T>,
    P: Pressure<T>,
    S: Signal<T>,
    W: Signal<T>,
{
    let mut grid = Grid::new(patch, cells)?;
    if let Some(motion) = settled {
        let steady = patch.steady(motion)?;
        grid = grid.with_profile(|place| steady.deflection(place))?;
    }
    Ok(Box::new(grid))
}

/// The motion at a time.
pub(super) fn at<T: Scalar, S: Signal<T>, W: Signal<T>>(
    motion: &MotionOverTime<S, W>,
    time: T,
) -> Motion<T> {
    Motion {
        slip_velocity: motion.slip_velocity.value(time),
        rolling_speed: motion.rolling_speed.value(time),
    }
}

/// From answer to answer.
#[derive(Debug, Clone, Copy)]
pub(super) struct Walk<'a, T, S, W> {
    pub(super) motion: &'a MotionOverTime<S, W>,
    /// L [m]
    pub(super) length: T,
    /// Time between two answers [s].
    pub(super) interval: T,
    /// Steps between two answers, or in a transit if that is shorter.
    pub(super) substeps: usize,
    pub(super) scheme: Scheme,
}

/// What a walk has come to.
#[derive(Debug, Clone, Default)]
pub(super) struct Walked<T> {
    /// L ∫ p z dξ [N m] at each answer.
    pub(super) gathered: Vec<T>,
    /// Evaluations of the friction model.
    pub(super) evaluations: f64,
}

impl<T: Scalar, S: Signal<T>, W: Signal<T>> Walk<'_, T, S, W> {
    /// Rolls to each of the answers in their order; those that are left out must not matter.
    pub(super) fn go(
        &self,
        roll: &mut dyn Roll<T, S, W>,
        answers: impl Iterator<Item = usize>,
    ) -> Result<Walked<T>, ParameterError> {
        let mut walked = Walked { gathered: Vec::new(), evaluations: 0.0 };
        let mut now = T::zero();
        for answer in answers {
            let end = self.interval * lit(answer as f64);
            let start = self.transit(end, now, roll.beyond()).unwrap_or(now);
            let steps = self.substeps.saturating_mul(self.parts(start..end)?);
            let step = (end - start) / lit(steps as f64);
            for index in 0..steps {
                let from = start + step * lit(index as f64);
                let to = if index + 1 == steps { end } else { from + step };
                match self.scheme {
                    Scheme::Held => {
                        roll.hold(at(self.motion, from + step * lit(0.5)), to - from)?;
                        walked.evaluations += 1.0;
                    }
                    Scheme::Gauss => {
                        roll.follow(self.motion, from..to)?;
                        walked.evaluations += 2.0;
                    }
                }
            }
            now = end;
            walked.gathered.push(roll.gathered());
        }
        Ok(walked)
    }

    /// Into how many parts a step is divided that crosses much of the patch.
    fn parts(&self, span: Range<T>) -> Result<usize, ParameterError> {
        if self.scheme == Scheme::Held {
            return Ok(1);
        }
        let distance = self.distance(&span, 4) / lit(self.substeps as f64);
        let duration = (span.end - span.start) / lit(self.substeps as f64);
        let distance = parameter::non_negative("rolling_speed", distance)?;
        let most = lit(MOST_TRANSITS);
        if distance > most {
            let value = to_f64(distance / duration);
            let other = "what crosses the patch ten thousand times in a step";
            let rule = Rule::AtMost { other, limit: to_f64(most / duration) };
            return Err(ParameterError { name: "rolling_speed", component: None, value, rule });
        }
        Ok(parts(to_f64(distance)))
    }

    /// ∫V dt by so many midpoints.
    fn distance(&self, span: &Range<T>, points: usize) -> T {
        let step = (span.end - span.start) / lit(points as f64);
        (0..points).fold(T::zero(), |sum, index| {
            let time = span.start + step * lit(index as f64 + 0.5);
            sum + self.motion.rolling_speed.value(time) / self.length * step
        })
    }

    /// From when on a transit is over at `end`, if that is after `earliest`, as the steps see it.
    pub(super) fn transit(&self, end: T, earliest: T, beyond: f64) -> Option<T> {
        let points = match self.scheme {
            Scheme::Held => self.substeps,
            Scheme::Gauss => 4 * self.substeps,
        };
        let least = lit::<T>(1.0 + beyond);
        let mut duration = least * self.length / self.motion.rolling_speed.value(end);
        for _ in 0..8 {
            let start = end - duration;
            if !(duration > T::zero() && start > earliest) {
                return None;
            }
            let distance = self.distance(&(start..end), points);
            if distance >= least && distance <= least * lit(1.1) {
                return Some(start);
            }
            duration *= least * lit(1.0 + 1e-9) / distance;
            if distance < least && least < distance * lit(1.1) {
                // Close to it from below: from above is wanted.
                duration *= lit(1.02);
            }
        }
        None
    }
}

/// Equal parts, none longer than what the queue of an exact patch takes at once.
pub(super) fn parts(distance: f64) -> usize {
    let parts = nalgebra::ComplexField::ceil(distance / LONGEST * (1.0 - 1e-9));
    if parts > 1.0 { parts as usize } else { 1 }
}

/// Segments with which steps of length h are all kept apart.
pub(super) fn segments(slowest_transport: f64, step: f64) -> usize {
    let transit = 2.0 + 1.0 / (slowest_transport * step);
    (if transit < MOST_SEGMENTS { transit } else { MOST_SEGMENTS }) as usize + 8
}

/// The force of what is gathered.
pub(super) fn force<T: Scalar>(affine: &Affine<T>, gathered: T, normal_force: T, slip: T) -> T {
    affine.stiffness * gathered + normal_force * (affine.damping * slip)
}
