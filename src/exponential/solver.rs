//! The solver along a known velocity: its settings, and the output of a run.

use core::ops::Range;

use nalgebra::Vector1;

use super::run::CollocationRun;
use crate::ode::{Failure, Statistics, StepControl};
use crate::parameter::{Named, ParameterError};
use crate::scalar::lit;
use crate::signal::Signal;
use crate::{Bristle, Contact, Scalar};

/// Exponential collocation with its step control. Made by
/// [`Exponential::adaptive`](super::Exponential::adaptive) and
/// [`Exponential::fixed`](super::Exponential::fixed).
///
/// ```
/// use bristle::exponential::Exponential;
/// use bristle::signal::{Sine, SineParameters};
/// use bristle::{Bristle, FrBd, paper};
/// use bristle::curve::Stribeck;
/// use bristle::rheology::KelvinVoigt;
///
/// let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
/// let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
/// let contact = FrBd::new(curve, bristle).under_load(1.0)?;
/// let sine = SineParameters { mean: 0.0, amplitude: 0.01, frequency: 25.0, phase: 0.0 };
/// let velocity = Sine::new(sine)?;
///
/// let solver = Exponential::<5>.adaptive(1e-8)?;
/// let mut largest = 0.0;
/// solver.sample(&contact, &velocity, 0.0..0.2, 0.0, 201, |_time, deflection: f64| {
///     largest = f64::max(largest, deflection.abs());
/// })?;
/// assert!(largest < 1.5e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CollocationSolver<T, const S: usize> {
    pub(super) control: StepControl<T>,
    /// Tolerance of adaptive steps, as a part of the deflection at breakaway.
    pub(super) tolerance: Option<T>,
}

impl<T: Scalar, const S: usize> CollocationSolver<T, S> {
    /// A limit on the length of adaptive steps \[s\]. Fixed steps ignore it.
    ///
    /// A periodic velocity needs one if a step could skip whole periods of it.
    ///
    /// # Errors
    ///
    /// Refuses a limit that is not positive.
    pub fn with_largest_step(mut self, largest: T) -> Result<Self, ParameterError> {
        self.control.largest_step = Some(Named("largest_step", largest).positive()?);
        Ok(self)
    }

    /// A limit on the number of trial steps, 10⁸ if not given.
    #[must_use]
    pub fn with_most_steps(mut self, most: u64) -> Self {
        self.control.most_steps = most;
        self
    }

    /// Starts a run over a time span \[s\] from a deflection \[m\], to be stepped by hand.
    ///
    /// # Errors
    ///
    /// Refuses a time or a deflection that is not finite, a span that ends before it starts, and a
    /// fixed step that does not advance the time.
    pub fn begin<'a, M: Bristle<T, Deflection = T>, V: Signal<T>>(
        &self,
        contact: &'a Contact<T, M>,
        velocity: &'a V,
        span: Range<T>,
        deflection: T,
    ) -> Result<CollocationRun<'a, T, M, V, S>, Failure<T, 1>> {
        let checked = Named("span.start", span.start)
            .finite()
            .and_then(|start| Named("span.end", span.end).at_least("span.start", start))
            .and_then(|end| Named("span.end", end).finite())
            .and_then(|_| Named("deflection", deflection).finite());
        let state = Vector1::new(deflection);
        checked.map_err(|error| Failure::refused(error, span.start, state))?;
        CollocationRun::new(self, contact, velocity, span, deflection)
    }

    /// Runs over a time span \[s\] from a deflection \[m\], and hands over time and deflection at
    /// so many times, at least 2, evenly spaced and including both ends.
    ///
    /// The model's limit of the deflection is kept at the ends of steps. Between those of long
    /// fixed steps the dense output may exceed it by a part of what the deflection varies.
    ///
    /// # Errors
    ///
    /// Refuses what [`CollocationSolver::begin`] refuses, and fewer than 2 samples; says why a run
    /// ended before its time. The samples before that have been handed over.
    pub fn sample<M: Bristle<T, Deflection = T>, V: Signal<T>>(
        &self,
        contact: &Contact<T, M>,
        velocity: &V,
        span: Range<T>,
        deflection: T,
        samples: usize,
        mut observer: impl FnMut(T, T),
    ) -> Result<Statistics, Failure<T, 1>> {
        let refused = |few| Failure::refused(few, span.start, Vector1::new(deflection));
        Named("samples", samples).count(2).map_err(refused)?;
        let mut run = self.begin(contact, velocity, span.clone(), deflection)?;
        let last = samples - 1;
        let spacing = (span.end - span.start) / lit(last as f64);
        let time_of = |index: usize| {
            if index == last { span.end } else { span.start + spacing * lit(index as f64) }
        };
        observer(span.start, deflection);
        let mut index = 1;
        while let Some(step) = run.advance()? {
            while index <= last && time_of(index) <= step.end_time() {
                observer(time_of(index), step.at(time_of(index)));
                index += 1;
            }
        }
        // A span of no length has no steps.
        for index in index..=last {
            observer(time_of(index), run.deflection());
        }
        Ok(run.statistics())
    }
}
