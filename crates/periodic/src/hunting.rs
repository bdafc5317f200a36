//! Does a loop hunt?
//!
//! Three questions, in the order of their cost:
//!
//! * Small motions about rest, stuck on the bristles, and motions so large that friction hardly
//!   counts: both linear. If large motions grow, no start that is large enough comes to rest.
//! * Where motions from given starts end: simulated.
//! * The cycle, if a start ends in one: by [`Shooting`], to its multipliers.
//!
//! A *slip* is a way from one reversal to the next that is long beside the deflection at breakaway.
//! With integral action a stuck mass creeps towards its target, and the force on it changes, with
//! the time constant τ = (p σ0 + K_P + k)/K_I: what does not slip within 3 τ stays (k is the
//! stiffness of the spring). A motion hunts if its slips have left the cycle as it is to 1 %, three
//! times in a row. A simulation goes on beyond its duration until either is known.
//!
//! A sampled controller holds its force between samples. Its state jumps there, and with it the
//! derivatives of a run: see [`Shooting::sampled`]. Sampled loops are simulated by passive
//! companion steps; their rest and their cycles are solved for, too, with multipliers.

use core::fmt;
use core::num::NonZero;
use std::thread;

use bristle::Bristle;
use bristle::companion::VelocityHistory;
use bristle::number::Number;
use bristle::ode::{Automatic, Direction, Event, Solver, StopReason, System, Tolerances};
use bristle::parameter::Named;
use nalgebra::{SMatrix, SVector};

use crate::{
    Answer, ControlLoop, ControlLoopParameters, Guess, Multiplier, Orbit, PeriodicError, Pid,
    Shooting,
};

/// A cycle that a simulation ends in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HuntingCycle {
    /// Half of the way between the largest and the smallest position \[m\].
    pub amplitude: f64,
    /// Period \[s\].
    pub period: f64,
}

/// Where a motion ends.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Outcome {
    /// It comes to rest: it has not slipped for three time constants of the mass on its bristles
    /// under integral action, nor for three periods of its swing.
    Rests,
    /// It slips to and fro in a cycle, the last one as measured: to 10⁻² or better, unless it never
    /// repeats itself so well.
    Hunts(HuntingCycle),
    /// It leaves a thousand times its start, and the position error at breakaway.
    Grows,
}

impl Outcome {
    /// Whether two cycles are the same to a share of their amplitude and period.
    fn is_near(&self, other: &Self, share: f64) -> bool {
        let (Self::Hunts(one), Self::Hunts(other)) = (self, other) else { return false };
        let near = |a: f64, b: f64| (a - b).abs() <= share * b.abs();
        near(one.amplitude, other.amplitude) && near(one.period, other.period)
    }
}

/// After so many slips in a row that leave the cycle as it is, to 10⁻⁴, it is known.
const ENOUGH: u32 = 6;

/// After so many slips in a row that leave the cycle as it is, to 1 %, it is one.
const REPEATED: u32 = 3;

/// What has not slipped for so many time constants rests.
const QUIET: f64 = 3.0;

/// A simulation goes on for so many times that beyond its duration, at most.
const LONGER: f64 = 5.0;

/// A slip is longer than so many deflections at breakaway.
const SLIP: f64 = 5.0;

/// A motion that goes farther than so many times its start grows.
const FAR: f64 = 1e3;

/// The slips of a motion, told of its positions and velocities as they come.
struct Slips {
    /// The least way of a slip \[m\].
    least: f64,
    /// The farthest position that does not count as growing \[m\].
    far: f64,
    /// Where the motion last turned \[m\], and its direction since.
    turn: f64,
    direction: f64,
    /// The last slips, the latest first.
    last: [Option<Slip>; 12],
    /// The cycle that they are part of, and how many slips in a row have left it as it is, to 10⁻⁴
    /// and to 10⁻².
    cycle: Outcome,
    unchanged: [u32; 2],
    /// What has not slipped for so long rests \[s\].
    wait: f64,
    /// No motion is at rest before \[s\].
    duration: f64,
}

/// Where a slip begins and ends \[m\], and when it ends \[s\].
#[derive(Clone, Copy)]
struct Slip {
    start: f64,
    end: f64,
    time: f64,
}

impl Slips {
    /// When a simulation stops \[s\], whatever it has come to.
    fn end(&self) -> f64 {
        self.duration + LONGER * self.wait
    }

    /// Takes a point of the motion. Answers where it ends, once that is known.
    fn push(&mut self, time: f64, position: f64, velocity: f64) -> Option<Outcome> {
        if velocity * self.direction < 0.0 {
            let start = self.turn;
            if (position - start).abs() > self.least {
                self.last.rotate_right(1);
                self.last[0] = Some(Slip { start, end: position, time });
                let cycle = self.outcome();
                for (count, share) in self.unchanged.iter_mut().zip([1e-4, 1e-2]) {
                    *count = if cycle.is_near(&self.cycle, share) { *count + 1 } else { 0 };
                }
                self.cycle = cycle;
            }
            self.turn = position;
        }
        if velocity != 0.0 {
            self.direction = velocity;
        }
        if !(position.abs() <= self.far) {
            return Some(Outcome::Grows);
        }
        let [exactly, about] = self.unchanged;
        if exactly >= ENOUGH || time >= self.duration && about >= REPEATED {
            return Some(self.cycle);
        }
        let quiet = time - self.last[0].map_or(0.0, |slip| slip.time);
        (time >= self.duration && quiet >= self.wait).then_some(Outcome::Rests)
    }

    /// The cycle of the last slips; at rest before there are two.
    fn outcome(&self) -> Outcome {
        let slips: Vec<Slip> = self.last.iter().flatten().copied().collect();
        let [last, before, earlier @ ..] = &slips[..] else { return Outcome::Rests };
        // Of the earlier slips the latest that is about as like the last one as any.
        let unlike = |it: &Slip| (it.start - last.start).abs() + (it.end - last.end).abs();
        let least = earlier.iter().map(unlike).fold(f64::INFINITY, f64::min);
        let alike = earlier.iter().find(|it| unlike(it) <= 2.0 * least + self.least);
        let period = last.time - alike.unwrap_or(before).time;
        let cycle = slips.iter().take_while(|it| last.time - it.time < period);
        let places = cycle.flat_map(|it| [it.start, it.end]);
        let most = places.clone().fold(f64::NEG_INFINITY, f64::max);
        let least = places.fold(f64::INFINITY, f64::min);
        Outcome::Hunts(HuntingCycle { amplitude: 0.5 * (most - least), period })
    }
}

impl<M: Bristle<f64, Deflection = f64>> ControlLoopParameters<M> {
    /// Where the motion from rest at a distance from the target \[m\] ends: a simulation over a
    /// duration \[s\], and longer if by then it is not known.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range, and why a simulation stopped.
    pub fn outcome(&self, start: f64, duration: f64) -> Answer<Outcome> {
        match self.states() {
            4 => ControlLoop::new(self.clone())?.outcome(start, duration),
            5 => ControlLoop::filtered(self.clone())?.outcome(start, duration),
            _ => ControlLoop::sampled(self.clone())?.outcome(start, duration),
        }
    }

    /// The slips of a motion from rest at a distance from the target \[m\], over a duration \[s\].
    fn slips(&self, start: f64, duration: f64) -> Slips {
        let [deflection, force] = self.breakaway();
        let far = FAR * start.abs().max(force / self.controller.proportional);
        let stiffness = self.controller.proportional + self.mechanism.spring_stiffness;
        let creep = (force / deflection + stiffness) / self.controller.integral;
        let creep = if self.controller.integral > 0.0 { creep } else { 0.0 };
        Slips {
            least: SLIP * deflection,
            far,
            turn: start,
            direction: 0.0,
            last: [None; 12],
            cycle: Outcome::Rests,
            unchanged: [0; 2],
            wait: QUIET * self.swing().max(creep),
            duration,
        }
    }

    /// How many states its loop has.
    fn states(&self) -> usize {
        let Pid { sample_time, filter_time, .. } = self.controller;
        if sample_time > 0.0 { 6 } else { 4 + usize::from(filter_time > 0.0) }
    }
}

/// Tolerance of the steps of a simulation, over the scales: cycles then have four digits.
const TOLERANCE: f64 = 1e-5;

impl<M: Bristle<f64, Deflection = f64>, const N: usize> ControlLoop<M, N> {
    /// [`ControlLoopParameters::outcome`]
    fn outcome(&self, start: f64, duration: f64) -> Answer<Outcome> {
        Named("start", start).finite()?;
        Named("duration", duration).positive()?;
        let mut slips = self.parameters().slips(start, duration);
        if let Some(samples) = self.samples() {
            let mut known = None;
            sampled(self, samples, start, slips.end(), |time, x, v| {
                known = slips.push(time, x, v);
                known.is_some()
            })?;
            return Ok(known.unwrap_or_else(|| slips.outcome()));
        }
        let tolerances = Tolerances::scaled(TOLERANCE, self.scales())?;
        let solver = Solver::adaptive(Automatic, tolerances).with_most_steps(10_000_000);
        let mut run = solver.begin(self, 0.0..slips.end(), self.displaced(start))?;
        loop {
            let step = match run.advance() {
                Ok(Some(step)) => step,
                Ok(None) => return Ok(slips.outcome()),
                Err(failure) => {
                    let is_lost = matches!(failure.reason, StopReason::NotFinite { .. });
                    let grows = is_lost && self.abscissas()?.1 > 0.0;
                    return if grows { Ok(Outcome::Grows) } else { Err(failure.into()) };
                }
            };
            if let Some(known) = slips.push(step.end_time(), step.end()[0], step.end()[1]) {
                return Ok(known);
            }
        }
    }

    /// [`hunting`]
    fn report(&self, starts: &[f64], duration: f64) -> Answer<HuntingReport> {
        let ends = |&start: &f64| Ok((start, self.outcome(start, duration)?));
        let outcomes: Vec<_> = starts.iter().map(ends).collect::<Answer<_>>()?;
        let hunts = |it: &&(f64, Outcome)| matches!(it.1, Outcome::Hunts(_));
        let start = outcomes.iter().find(hunts).map(|it| it.0);
        let orbit = start.map(|start| hunting_orbit(self, start, duration));
        let (samples, (rest_abscissa, large_abscissa)) = (self.samples(), self.abscissas()?);
        let cycle = orbit.map(|orbit| {
            let (orbit, mut search) = (orbit?, Shooting::default().cyclic(None, self.scales())?);
            search.samples = samples;
            let flow = search.of(self).flow((0.0, orbit.start), orbit.period)?;
            let places = flow.steps.iter().map(|step| step.1[0]);
            let most = places.clone().fold(orbit.start[0], f64::max);
            let amplitude = 0.5 * (most - places.fold(orbit.start[0], f64::min));
            Ok((HuntingCycle { amplitude, period: orbit.period }, orbit.transverse()))
        });
        let is_free = orbit.is_some_and(|orbit| orbit.is_ok_and(|orbit| !orbit.forced));
        let is_quasi_periodic = samples.is_some() && is_free;
        Ok(HuntingReport { rest_abscissa, large_abscissa, outcomes, cycle, is_quasi_periodic })
    }
}

/// Longest companion step of a sampled loop \[s\], over the time constant of the mass on its
/// bristles.
const COMPANION_STEP: f64 = 0.25;

/// Companion steps of a simulation, at most: they take some ten seconds.
const MOST_STEPS: u64 = 50_000_000;

/// The states of a sampled loop after a duration \[s\] from rest at a distance from the target
/// \[m\], or at the sample after an observer of time, position and velocity says so.
fn sampled<M: Bristle<f64, Deflection = f64>, const N: usize>(
    system: &ControlLoop<M, N>,
    (sample_time, jump): (f64, SMatrix<f64, N, N>),
    start: f64,
    duration: f64,
    mut stops: impl FnMut(f64, f64, f64) -> bool,
) -> Answer<SVector<f64, N>> {
    let ControlLoopParameters { contact, mechanism, .. } = system.parameters();
    let friction = contact.clone().companion(0.0)?;
    let stiffness = contact.model().storage_stiffness() * contact.reference_load();
    let longest = COMPANION_STEP * (mechanism.mass / stiffness).sqrt();
    let parts = (sample_time / longest).ceil().max(1.0);
    let h = sample_time / parts;
    let mut state = system.displaced(start);
    let mut history = VelocityHistory::new(0.0);
    let samples = (duration / sample_time).ceil() as u64;
    for sample in 0..samples {
        if sample >= MOST_STEPS / parts as u64 {
            return Err(PeriodicError::TooManySteps);
        }
        state = jump * state;
        let mut stopped = false;
        for part in 0..parts as u32 {
            let (x, v, control) = (state[0], state[1], state[5]);
            let step = friction.step(history.predict(), state[2], h);
            // Spring and damper at the middle of the step, implicitly.
            let spring = mechanism.viscous_damping + 0.5 * h * mechanism.spring_stiffness;
            let inertia = 2.0 * mechanism.mass / h;
            let force = control - mechanism.spring_stiffness * x - step.bias();
            let mean = (inertia * v + force) / (inertia + spring + step.damping());
            (state[0], state[1]) = (x + h * mean, 2.0 * mean - v);
            state[2] = step.commit(mean).deflection;
            history.push(state[1]);
            let time = sample as f64 * sample_time + f64::from(part + 1) * h;
            stopped = stopped || stops(time, state[0], state[1]);
        }
        if stopped {
            break;
        }
    }
    Ok(state)
}

/// What a loop does, from [`hunting`].
#[derive(Debug, Clone, PartialEq)]
pub struct HuntingReport {
    /// Largest real part [1/s] of the motions of the mass on its bristles about rest with an
    /// undeflected bristle: below zero if rest is stable. Of a sampled loop ln |μ|/h, with the
    /// multipliers μ over a sample time h.
    pub rest_abscissa: f64,
    /// Largest real part [1/s] of the motions of the loop without friction: above zero if large
    /// motions grow. Of a sampled loop as above.
    pub large_abscissa: f64,
    /// Where the motions from the given starts \[m\] end.
    pub outcomes: Vec<(f64, Outcome)>,
    /// The cycle in which the first start ends that hunts, exactly, with its multipliers but the
    /// one that is 1; or why it was not found, as if the simulation has not come close to it. That
    /// of a sampled loop is found as [`Shooting::sampled`] says. None if no start hunts.
    pub cycle: Option<Answer<(HuntingCycle, Vec<Multiplier>)>>,
    /// Whether the cycle of a sampled loop is no whole number of samples long. It is quasi-periodic
    /// then, and its multipliers are those of the samples next to a period.
    pub is_quasi_periodic: bool,
}

impl HuntingReport {
    /// Whether any of the starts hunts or grows.
    pub fn hunts(&self) -> bool {
        self.outcomes.iter().any(|(_, outcome)| *outcome != Outcome::Rests)
    }
}

impl fmt::Display for HuntingReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let verdict = |abscissa: f64, [below, above]: [&'static str; 2]| match abscissa {
            0.0 => "neutral",
            below_zero if below_zero < 0.0 => below,
            _ => above,
        };
        let (rest, large) = (self.rest_abscissa, self.large_abscissa);
        let (stable, die_out) =
            (verdict(rest, ["stable", "UNSTABLE"]), verdict(large, ["die out", "GROW"]));
        writeln!(f, "rest           {stable}, slowest at {rest:.4e} 1/s")?;
        writeln!(f, "large motions  {die_out}, at {large:.4e} 1/s")?;
        for (start, outcome) in &self.outcomes {
            write!(f, "from {} m", Number(*start))?;
            match outcome {
                Outcome::Rests => writeln!(f, "  rests")?,
                Outcome::Grows => writeln!(f, "  GROWS")?,
                Outcome::Hunts(cycle) => writeln!(f, "  HUNTS, {cycle}")?,
            }
        }
        let (cycle, multipliers) = match &self.cycle {
            Some(Ok((cycle, multipliers))) => (cycle, multipliers),
            Some(Err(why)) => return writeln!(f, "its cycle      not found: {why}"),
            None => return Ok(()),
        };
        let slowest = multipliers.first().filter(|it| !it.is_neutral());
        let slowest = slowest.map_or(0.0, |it| it.log_modulus);
        let stable = verdict(slowest, ["stable", "unstable"]);
        let quasi = if self.is_quasi_periodic { "quasi-periodic, " } else { "" };
        writeln!(f, "its cycle      {cycle}, {quasi}{stable}: multiplier {:.6}", slowest.exp())
    }
}

impl fmt::Display for HuntingCycle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "±{:.4e} m with a period of {:.6} s", self.amplitude, self.period)
    }
}

/// Reports whether a loop hunts: rest, large motions, and where motions from rest at given
/// distances from the target \[m\] end, simulated over a duration \[s\] and longer if by then that
/// is not known. Amplitude and period of a simulated cycle are good to 10⁻², of the exact one to
/// 10⁻⁷.
///
/// # Errors
///
/// Names the parameter that is out of its range, and why a simulation stopped.
pub fn hunting<M: Bristle<f64, Deflection = f64>>(
    parameters: &ControlLoopParameters<M>,
    starts: &[f64],
    duration: f64,
) -> Answer<HuntingReport> {
    Named("starts", starts.len()).count(1)?;
    match parameters.states() {
        4 => ControlLoop::new(parameters.clone())?.report(starts, duration),
        5 => ControlLoop::filtered(parameters.clone())?.report(starts, duration),
        _ => ControlLoop::sampled(parameters.clone())?.report(starts, duration),
    }
}

/// After so many periods a sampled motion has come close to its cycle.
const SETTLED: f64 = 100.0;

/// The cycle that the motion from rest at a distance from the target \[m\] approaches within a
/// duration \[s\]: a start of which [`hunting`] says that it hunts. That of a sampled loop is
/// entered where the mass sticks: a tenth of a period after a slip.
///
/// # Errors
///
/// [`PeriodicError::DoesNotRepeat`] if the motion rests, [`PeriodicError::Grows`] if it grows; else
/// as [`Shooting::settle`] and [`Shooting::free`], of a sampled loop as [`Shooting::sampled`].
pub fn hunting_orbit<M: Bristle<f64, Deflection = f64>, const N: usize>(
    system: &ControlLoop<M, N>,
    start: f64,
    duration: f64,
) -> Answer<Orbit<N>> {
    let HuntingCycle { period, .. } = match system.outcome(start, duration)? {
        Outcome::Hunts(cycle) => cycle,
        Outcome::Rests => return Err(PeriodicError::DoesNotRepeat),
        Outcome::Grows => return Err(PeriodicError::Grows),
    };
    let shooting = Shooting::default();
    let Some(samples) = system.samples() else {
        let position = |_: f64, state: &SVector<f64, N>| state[0];
        let target = Event { function: &position, direction: Direction::Rising, stops: false };
        let guess = shooting.settle(system, system.displaced(start), duration, &target)?;
        return shooting.free(system, guess);
    };
    if SETTLED * period > MOST_STEPS as f64 * samples.0 {
        return Err(PeriodicError::TooManySteps);
    }
    let mut slips = system.parameters().slips(start, duration);
    let state = sampled(system, samples, start, 2.0 * SETTLED * period, |time, x, v| {
        slips.push(time, x, v);
        let slip = slips.last[0].map_or(time, |slip| slip.time);
        time > SETTLED * period && time - slip > 0.1 * period
    })?;
    let Outcome::Hunts(HuntingCycle { period, .. }) = slips.outcome() else {
        return Err(PeriodicError::DoesNotRepeat);
    };
    shooting.sampled(system, samples, Guess { state, period })
}

/// Where the motions of loops with two gains end, row by row of `down`: `outcome[j][i]` is that at
/// `across[i]`, `down[j]`. On all processors.
///
/// # Errors
///
/// As [`ControlLoopParameters::outcome`], of the first point that fails.
pub fn hunting_map<M: Bristle<f64, Deflection = f64>>(
    control_loop: impl Fn(f64, f64) -> ControlLoopParameters<M> + Sync,
    [across, down]: [&[f64]; 2],
    start: f64,
    duration: f64,
) -> Answer<Vec<Vec<Outcome>>> {
    let workers = thread::available_parallelism().map_or(1, NonZero::get);
    let row = |&second: &f64| -> Answer<Vec<Outcome>> {
        across.iter().map(|&first| control_loop(first, second).outcome(start, duration)).collect()
    };
    let mut rows: Vec<(usize, Answer<Vec<Outcome>>)> = thread::scope(|scope| {
        // Neighbouring rows cost alike.
        let rows = |worker: usize| {
            let mine = down.iter().enumerate().skip(worker).step_by(workers);
            mine.map(|(index, second)| (index, row(second))).collect::<Vec<_>>()
        };
        let others: Vec<_> = (1..workers).map(|worker| scope.spawn(move || rows(worker))).collect();
        let mut all = rows(0);
        for other in others {
            all.extend(other.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        }
        all
    });
    rows.sort_by_key(|(index, _)| *index);
    rows.into_iter().map(|(_, row)| row).collect()
}
