//! Periodic motions by shooting.
//!
//! x(t₀ + T) = x(t₀), by Newton's method with the derivatives of the run; T is given, or found.
//! The equations are in `segments`.
//!
//! Source: A. H. Nayfeh, B. Balachandran, "Applied Nonlinear Dynamics" (Wiley, 1995), section 5.4.

use core::cell::Cell;

use bristle::ode::{Event, Occurrence, System};
use bristle::parameter::{Checked, Named, ParameterError};
use nalgebra::{SMatrix, SVector};

use crate::multipliers::without_one;
use crate::segments::{Cyclic, Running, solve};
use crate::{Answer, Multiplier, PeriodicError};

/// How periodic motions are looked for.
///
/// ```
/// use bristle::{Bristle, FrBd, curve::Stribeck, paper, rheology::KelvinVoigt};
/// use bristle::ode::{Direction, Event};
/// use bristle::nalgebra::Vector3;
/// use bristle_periodic::{DrivenMass, Shooting};
///
/// let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
/// let contact = FrBd::new(Stribeck::new(paper::STICK_SLIP_CURVE)?, bristle).under_load(1.0)?;
/// let rig = paper::stick_slip_rig(contact);
/// let rig = DrivenMass::new(contact, rig.mechanism, rig.drive_velocity)?;
/// // Once a cycle the slipping mass becomes as fast as the end of the spring.
/// let overtakes = |_: f64, state: &Vector3<f64>| state[1] - 0.1;
/// let overtakes = Event { function: &overtakes, direction: Direction::Rising, stops: false };
/// let shooting = Shooting::default();
/// let guess = shooting.settle(&rig, rig.at_rest(), 40.0, &overtakes)?;
/// let cycle = shooting.free(&rig, guess)?;
/// assert!((cycle.period - 7.639267).abs() < 1e-6 && cycle.is_stable());
/// # Ok::<(), bristle_periodic::PeriodicError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shooting {
    /// Tolerance of a step of the runs, relative to the scales of the states.
    pub tolerance: f64,
    /// Iterations of Newton's method, at most.
    pub most_iterations: usize,
    /// Steps of all runs of a search, or of a branch, at most; where derivatives are taken, half
    /// time constants of the quickest motion count, too.
    pub most_steps: u64,
    /// Segments of a period, a hundred at most, each with a start that is looked for (multiple
    /// shooting). One is enough unless the motion forgets its start and then magnifies what is
    /// left of it.
    pub segments: usize,
}

impl Default for Shooting {
    /// Steps to 10⁻¹², which leaves nine digits or more of a period, 30 iterations, 10⁷ steps, and
    /// one segment.
    fn default() -> Self {
        Self { tolerance: 1e-12, most_iterations: 30, most_steps: 10_000_000, segments: 1 }
    }
}

/// Where a periodic motion may be, and how long it may last.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guess<const N: usize> {
    /// A state on it.
    pub state: SVector<f64, N>,
    /// The period \[s\].
    pub period: f64,
}

/// A periodic motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Orbit<const N: usize> {
    /// The time t₀ of `start` \[s\]; of a motion whose system does not depend on time, zero.
    pub start_time: f64,
    /// The state at t₀.
    pub start: SVector<f64, N>,
    /// Period T \[s\].
    pub period: f64,
    /// Whether the period was given (by an input, or as a multiple of its period), or found.
    pub forced: bool,
    /// By decreasing modulus. Of a motion whose period was found one is 1: it has no phase to
    /// return to.
    pub multipliers: [Multiplier; N],
}

impl<const N: usize> Orbit<N> {
    /// Whether small disturbances die out: no multiplier is neutral, nor larger.
    pub fn is_stable(&self) -> bool {
        self.transverse().iter().all(|it| it.log_modulus < 0.0 && !it.is_neutral())
    }

    /// The multipliers of disturbances across the motion: all but the 1 of a period that was found.
    pub fn transverse(&self) -> Vec<Multiplier> {
        if self.forced { self.multipliers.to_vec() } else { without_one(&self.multipliers) }
    }

    /// The motion of which this is the first half, with its mirror image as the second.
    pub(crate) fn doubled(self) -> Self {
        let multipliers = self.multipliers.map(Multiplier::squared);
        Self { period: 2.0 * self.period, multipliers, ..self }
    }

    /// This motion as a guess for one nearby.
    pub fn guess(&self) -> Guess<N> {
        Guess { state: self.start, period: self.period }
    }
}

impl Shooting {
    /// The motion that repeats with a given period T \[s\] under inputs that do, near a state at
    /// the time `start_time`. T may be a multiple of the period of the inputs.
    ///
    /// # Errors
    ///
    /// Says why there is none: a refused parameter, a run that stopped, Newton's method that did
    /// not converge.
    pub fn forced<S: System<f64, N, K>, const N: usize, const K: usize>(
        &self,
        system: &S,
        (start_time, period): (f64, f64),
        guess: SVector<f64, N>,
    ) -> Answer<Orbit<N>> {
        let cyclic = self.cyclic(Some(start_time), system.scales())?;
        cyclic.of(system).close(self.most_iterations, Guess { state: guess, period })
    }

    /// The cycle of a system without inputs, near a guess; its period is found, too.
    ///
    /// # Errors
    ///
    /// As [`Shooting::forced`]; [`PeriodicError::Equilibrium`] if the cycle shrinks to a point.
    pub fn free<S: System<f64, N, K>, const N: usize, const K: usize>(
        &self,
        system: &S,
        guess: Guess<N>,
    ) -> Answer<Orbit<N>> {
        let cyclic = self.cyclic(None, system.scales())?;
        cyclic.of(system).close(self.most_iterations, guess)
    }

    /// The cycle of a system with a controller that samples: every h seconds, first at the start,
    /// the state x jumps to J x (what the controller computes, and the force it holds from there
    /// on). The derivatives jump by J, too.
    ///
    /// A cycle of a whole number of samples repeats: it is [`forced`](Orbit::forced), with all of
    /// its multipliers. Any other is quasi-periodic, its samples never fall on the same places
    /// again. Then the orbit is free, and closes but for the part of a sample that is left over,
    /// along the change over a sample; its multipliers are those of the samples next to a period,
    /// one of them near 1 because the phase drifts. They vary along the motion, by a share of about
    /// h/T.
    ///
    /// # Errors
    ///
    /// As [`Shooting::free`].
    pub fn sampled<S: System<f64, N, K>, const N: usize, const K: usize>(
        &self,
        system: &S,
        (sample_time, jump): (f64, SMatrix<f64, N, N>),
        guess: Guess<N>,
    ) -> Answer<Orbit<N>> {
        Named("sample_time", sample_time).positive()?;
        jump.iter().try_for_each(|&entry| Named("jump", entry).finite().map(drop))?;
        let search = |forced: Option<f64>, most_iterations: usize, guess: Guess<N>| {
            let settings = Self { segments: 1, ..*self };
            let mut cyclic = settings.cyclic(forced, system.scales())?;
            cyclic.samples = Some((sample_time, jump));
            cyclic.of(system).close(most_iterations, guess)
        };
        let any = search(None, self.most_iterations, guess)?;
        let period = (any.period / sample_time).round() * sample_time;
        let whole = search(Some(0.0), FEW, Guess { state: any.start, period });
        let apart = |it: &Orbit<N>| (it.start - any.start).component_div(&system.scales()).norm();
        Ok(whole.ok().filter(|it| apart(it) < NEAR).unwrap_or(any))
    }

    /// What is looked for: a motion that is forced and begins at a time, or a free one.
    pub(crate) fn cyclic<const N: usize>(
        &self,
        forced: Option<f64>,
        scales: SVector<f64, N>,
    ) -> Checked<Cyclic<N>> {
        let least = 10.0 * f64::EPSILON;
        Named("tolerance", self.tolerance).at_least("ten roundings", least)?;
        Named("tolerance", self.tolerance).at_most("a tenth", 0.1)?;
        Named("most_iterations", self.most_iterations).count(1)?;
        Named("segments", self.segments).count_between(1, MOST_SEGMENTS)?;
        ParameterError::of_components(&scales, |&scale| Named("scales", scale).positive())?;
        Ok(Cyclic {
            tolerance: self.tolerance,
            scales,
            left: Cell::new(self.most_steps),
            samples: None,
            count: self.segments,
            start_time: forced.unwrap_or(0.0),
            forced: forced.is_some(),
            sign: 1.0,
        })
    }

    /// A guess for [`Shooting::free`]: simulates over a duration \[s\], and takes the last passage
    /// through an event (a sliding velocity that rises through some value, for instance) with the
    /// time since the earlier passage nearest to it.
    ///
    /// # Errors
    ///
    /// [`PeriodicError::DoesNotRepeat`] if there are no two passages alike; else as the run.
    pub fn settle<S: System<f64, N, K>, const N: usize, const K: usize>(
        &self,
        system: &S,
        start: SVector<f64, N>,
        duration: f64,
        section: &Event<'_, f64, N>,
    ) -> Answer<Guess<N>> {
        // A guess need not be exact.
        let cyclic = Cyclic { tolerance: 1e-9, ..self.cyclic(None, system.scales())? };
        Named("duration", duration).positive()?;
        let section = Event { stops: false, ..*section };
        let run = cyclic.of(system).run((0.0, start), duration, &[section])?;
        let (last, earlier) = run.events().split_last().ok_or(PeriodicError::DoesNotRepeat)?;
        let apart =
            |it: &Occurrence<f64, N>| (it.state - last.state).component_div(&cyclic.scales).norm();
        let least = earlier.iter().map(apart).fold(f64::INFINITY, f64::min);
        // Of the earlier passages the latest that is nearly as near as any.
        let alike = earlier.iter().rev().find(|it| apart(it) <= 2.0 * least + 1e-4);
        let period = last.time - alike.map_or(f64::NAN, |it| it.time);
        // A motion that repeated until a while ago has come to rest.
        let goes_on = least < 1.0 && duration - last.time < 2.0 * period;
        goes_on.then_some(Guess { state: last.state, period }).ok_or(PeriodicError::DoesNotRepeat)
    }
}

impl<S: System<f64, N, K>, const N: usize, const K: usize> Running<'_, S, N, K> {
    /// The motion near a guess.
    fn close(&self, most_iterations: usize, guess: Guess<N>) -> Answer<Orbit<N>> {
        let cyclic = self.cyclic;
        let mut segments = self.cut(guess)?;
        let mut newton = Newton::new(most_iterations, CLOSE);
        // A forced motion may stand still.
        let least = if cyclic.forced { 1.0 } else { SMALLEST };
        loop {
            let found = self.equations(&mut segments)?;
            let correction = solve(found.matrix, &found.right)?;
            if newton.is_over(correction.norm())? {
                if !(cyclic.forced || found.extent > SMALLEST) {
                    return Err(PeriodicError::Equilibrium);
                }
                return cyclic.orbit(&segments, &found.flows);
            }
            // A correction must not exceed half of the motion.
            let share = (0.5 * found.extent.max(least) / correction.norm()).min(1.0);
            cyclic.correct(&mut segments, &(correction * share));
        }
    }
}

/// The equations of more segments would take minutes, as the cube of their number.
const MOST_SEGMENTS: usize = 100;

/// A cycle of a whole number of samples is that of nearly the same period if it is this near, over
/// the scales; it is looked for in so many iterations.
const NEAR: f64 = 1e-2;
const FEW: usize = 10;

/// An orbit that goes less far than this, over the scales, is a point.
pub(crate) const SMALLEST: f64 = 1e-6;

/// A correction below this, over the scales, is none; one below the second that no longer shrinks
/// is of roundings.
const CLOSE: (f64, f64) = (1e-10, 1e-7);

/// The progress of Newton's method.
pub(crate) struct Newton {
    most: usize,
    /// A correction below the first is not made; those below the second that no longer shrink are
    /// roundings.
    close: (f64, f64),
    done: usize,
    last: f64,
}

impl Newton {
    pub(crate) fn new(most: usize, close: (f64, f64)) -> Self {
        Self { most, close, done: 0, last: f64::INFINITY }
    }

    /// Whether a correction is the last one: it need not be made.
    pub(crate) fn is_over(&mut self, correction: f64) -> Answer<bool> {
        let stands = correction < self.close.1 && correction > 0.5 * self.last;
        if correction < self.close.0 || stands {
            return Ok(true);
        }
        (self.done, self.last) = (self.done + 1, correction);
        if self.done >= self.most || !correction.is_finite() {
            return Err(PeriodicError::NotConverged { iterations: self.done, correction });
        }
        Ok(false)
    }
}
