//! The solver along a known velocity: its settings, and the output of a run.

use core::ops::Range;

use nalgebra::Vector1;

use crate::ode::{Failure, Statistics, StepControl};
use crate::parameter::{Checked, Named};
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
    pub fn with_largest_step(mut self, largest: T) -> Checked<Self> {
        self.control.largest_step = Some(Named("largest_step", largest).positive()?);
        Ok(self)
    }

    /// A limit on the number of trial steps, 10⁸ if not given.
    #[must_use]
    pub fn with_most_steps(mut self, most: u64) -> Self {
        self.control.most_steps = most;
        self
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
        let spacing = (span.end - span.start) / lit((samples - 1) as f64);
        let time = |index: usize| span.start + spacing * lit(index as f64);
        let mut times = (1..samples - 1).map(time).chain([span.end]).peekable();
        observer(span.start, deflection);
        while let Some(step) = run.advance()? {
            while let Some(time) = times.next_if(|&time| time <= step.end_time()) {
                observer(time, step.at(time));
            }
        }
        // A span of no length has no steps.
        times.for_each(|time| observer(time, run.deflection()));
        Ok(run.statistics())
    }
}
