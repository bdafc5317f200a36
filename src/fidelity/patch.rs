//! A contact patch along a known motion.

use alloc::vec::Vec;

use super::scene::{Clock, Level, Plan, Run, Scene, Start};
use super::{FidelityError, cost};
use crate::Scalar;
use crate::bounds::smaller;
use crate::parameter::{self, ParameterError};
use crate::rolling::{Motion, Patch, PolynomialExponential, RateDependent};
use crate::scalar::{lit, to_f64};
use crate::signal::Signal;

impl Level {
    /// The steady force at the motion of the instant: no memory.
    pub const SLIP_CURVE: Self = Self::memoryless("slip curve");
    /// A force that follows the slip curve over a relaxation length ς, Ḟ = −(U/ς)(F − F_ss): each
    /// step exact for U held and F_ss straight.
    pub const RELAXATION_LENGTH: Self = Self::stepped("relaxation length", "exact ramp");
    /// The patch itself; each step exact for the motion in its middle
    /// ([`ExactPatch::step`](crate::rolling::ExactPatch::step)). Steps lead to an answer from the
    /// last transit before it on, or from the answer before if that is later.
    pub const PATCH: Self = Self::stepped("patch", "exact hold");
}

/// Parameters of [`PatchScene`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PatchSceneParameters<T, M, const N: usize, S, W> {
    /// The patch under its normal force.
    pub patch: Patch<T, M, PolynomialExponential<T, N>>,
    /// Slip velocity v(t) and rolling speed U(t) ≥ 0 [m/s], from t = 0 on.
    pub motion: Motion<S, W>,
    /// Time between two answers Δ \[s\]: the friction force is wanted at Δ, 2Δ, …
    pub interval: T,
    /// Number of answers, up to a million.
    pub answers: usize,
    /// How the bristles begin.
    pub start: Start,
}

/// The friction force of a contact patch at equal intervals along a known motion.
///
/// ```
/// use bristle::curve::Stribeck;
/// use bristle::fidelity::{Level, PatchScene, PatchSceneParameters, Start, Tolerance, choose};
/// use bristle::rheology::KelvinVoigt;
/// use bristle::rolling::{Motion, Patch, PatchParameters, PolynomialExponential};
/// use bristle::signal::{Constant, Sine, SineParameters};
/// use bristle::{FrBd, paper};
///
/// let tyre = Patch::new(PatchParameters {
///     model: FrBd::new(Stribeck::new(paper::TYRE_CURVE)?, KelvinVoigt::new(paper::TYRE_BRISTLE)?),
///     length: paper::TYRE_LENGTH,
///     pressure: PolynomialExponential::parabolic(),
/// })?
/// .carrying(4000.0)?; // N
/// let scene = |frequency: f64| {
///     let slip = SineParameters { mean: 0.2, amplitude: 0.2, frequency, phase: 0.0 };
///     PatchScene::new(PatchSceneParameters {
///         patch: tyre,
///         motion: Motion {
///             slip_velocity: Sine::new(slip)?,
///             rolling_speed: Constant::new(16.0)?,
///         },
///         interval: 0.01 / frequency,
///         answers: 1000,
///         start: Start::Steady,
///     })
/// };
/// let tolerance = Tolerance::at_every_answer(20.0); // N, some 1 % of the largest force
/// // Slow steering follows the slip curve. With half a transit in a period it takes the patch.
/// assert_eq!(choose(&scene(0.2)?, tolerance)?.plan.level, Level::SLIP_CURVE);
/// assert_eq!(choose(&scene(320.0)?, tolerance)?.plan.level, Level::PATCH);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct PatchScene<T, M, const N: usize, S, W> {
    patch: Patch<T, M, PolynomialExponential<T, N>>,
    motion: Motion<S, W>,
    clock: Clock<T>,
    start: Start,
    /// Relaxation length \[m\].
    relaxation_length: T,
}

/// Segments that a patch gets memory for, some megabytes; narrower ones are merged.
const SEGMENTS: usize = 20_000;

impl<T: Scalar, M: RateDependent<T>, const N: usize, S: Signal<T>, W: Signal<T>>
    PatchScene<T, M, N, S, W>
{
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Refuses an interval or a normal force that is not positive, no answers or more than a
    /// million, and at an answer a velocity that is not finite and a rolling speed below zero.
    pub fn new(parameters: PatchSceneParameters<T, M, N, S, W>) -> Result<Self, ParameterError> {
        let PatchSceneParameters { patch, motion, interval, answers, start } = parameters;
        let clock = Clock::new(interval, answers)?;
        parameter::positive("normal_force", patch.normal_force())?;
        let (mut slip, mut rolling) = (T::zero(), T::zero());
        for answer in 0..=answers {
            let Motion { slip_velocity, rolling_speed } = at(&motion, clock.time(answer));
            slip += parameter::finite("slip_velocity", slip_velocity)?.abs();
            rolling += parameter::non_negative("rolling_speed", rolling_speed)?;
        }
        let count = lit(1.0 + answers as f64);
        let mean = Motion { slip_velocity: slip / count, rolling_speed: rolling / count };
        let relaxation_length = relaxation_length(&patch, mean);
        Ok(Self { patch, motion, clock, start, relaxation_length })
    }

    /// The relaxation length ς \[m\] of [`Level::RELAXATION_LENGTH`]: −U Im G/(ω Re G) for ω → 0 of
    /// the frequency response G from v to F ([`Patch::linearised`]) at the mean |v| and U of the
    /// scene, which to first order in ω is the lag of the patch. Where that is not between nothing
    /// and the length of the patch, about v = 0.
    #[doc(alias = "sigma")]
    pub fn relaxation_length(&self) -> T {
        self.relaxation_length
    }

    fn at(&self, time: T) -> Motion<T> {
        at(&self.motion, time)
    }

    fn next_kink(&self, from: T, to: T) -> Option<T> {
        let Motion { slip_velocity, rolling_speed } = &self.motion;
        let kinks = [slip_velocity.next_kink(from, to), rolling_speed.next_kink(from, to)];
        crate::signal::first_between(kinks.into_iter().flatten(), from, to)
    }

    fn slip_curve(&self, run: &mut Run) -> Result<(), FidelityError> {
        for time in self.clock.times() {
            run.answers.push(to_f64(self.patch.steady(self.at(time))?.force));
            run.count(1, cost::SLIP_CURVE);
        }
        Ok(())
    }

    fn lag(&self, steps: u32, run: &mut Run) -> Result<(), FidelityError> {
        let mut target = self.patch.steady(self.at(T::zero()))?.force;
        let mut force = if self.start == Start::Steady { target } else { T::zero() };
        let (mut last, mut now) = (T::zero(), T::zero());
        for time in self.clock.times() {
            Clock::each_step(
                (last, time),
                steps,
                |from, to| self.next_kink(from, to),
                |h, look| {
                    now += h;
                    let steady = self.patch.steady(self.at(smaller(now, time)))?.force;
                    // φ1 = (1 − e⁻ˣ)/x: the mean of e⁻ˢ over the step.
                    let x = self.motion.rolling_speed.value(look) * h / self.relaxation_length;
                    let phi1 = if x > T::zero() { -(-x).exp_m1() / x } else { T::one() };
                    force = steady - (steady - target) * phi1 + (force - target) * (-x).exp();
                    target = steady;
                    run.count(1, cost::SLIP_CURVE + cost::LAG);
                    Ok(())
                },
            )?;
            run.answers.push(to_f64(force));
            (last, now) = (time, time);
        }
        Ok(())
    }

    fn patch(&self, steps: u32, run: &mut Run) -> Result<(), FidelityError> {
        let mut patch = self.patch.clone().exact_in(SEGMENTS)?;
        if self.start == Start::Steady {
            patch.settle(self.at(T::zero()))?;
        }
        let mut last = T::zero();
        for time in self.clock.times() {
            let span = (self.last_transit(last, time, steps)?, time);
            Clock::each_step(
                span,
                steps,
                |from, to| self.next_kink(from, to),
                |step, look| {
                    patch.step(self.at(look), step)?;
                    run.count(1, cost::PATCH);
                    Ok(())
                },
            )?;
            run.answers.push(to_f64(patch.force(self.motion.slip_velocity.value(time))));
            run.count(1, cost::PATCH_FORCE);
            last = time;
        }
        Ok(())
    }

    /// Where the steps that lead to an answer begin. The patch forgets all that is more than a
    /// transit old: if the answer before is much longer ago than that, at half as much again before
    /// this one, provided that the way since, as far as so many steps tell, is a transit.
    fn last_transit(&self, before: T, end: T, steps: u32) -> Result<T, FidelityError> {
        let length = self.patch.length();
        let from = end - length * lit(1.5) / self.motion.rolling_speed.value(end);
        if !(from > before) {
            return Ok(before);
        }
        let mut way = T::zero();
        Clock::each_step(
            (from, end),
            steps + 3,
            |_, _| None,
            |step, look| {
                way += self.motion.rolling_speed.value(look) * step;
                Ok(())
            },
        )?;
        // A tenth to spare for what the speed does between the looks.
        Ok(if way > length * lit(1.1) { from } else { before })
    }
}

fn at<T: Scalar, S: Signal<T>, W: Signal<T>>(motion: &Motion<S, W>, time: T) -> Motion<T> {
    let (slip, rolling) = (motion.slip_velocity.value(time), motion.rolling_speed.value(time));
    Motion { slip_velocity: slip, rolling_speed: rolling }
}

fn relaxation_length<T: Scalar, M: RateDependent<T>, const N: usize>(
    patch: &Patch<T, M, PolynomialExponential<T, N>>,
    mean: Motion<T>,
) -> T {
    let length = patch.length();
    let about = |slip_velocity: T| {
        // A phase of a thousandth in a transit: slow, and far above roundings even in f32.
        let slow = lit::<T>(1e-3) * mean.rolling_speed / length;
        let response = patch.linearised(Motion { slip_velocity, ..mean }).ok()?;
        let response = response.by_slip_velocity(slow);
        let lag = -response.im * mean.rolling_speed / (slow * response.re);
        (lag > T::zero() && lag < length).then_some(lag)
    };
    // That of a constant pressure in adhesion.
    let third = length / lit(3.0);
    about(mean.slip_velocity).or_else(|| about(T::zero())).unwrap_or(third)
}

impl<T: Scalar, M: RateDependent<T>, const N: usize, S: Signal<T>, W: Signal<T>> Scene
    for PatchScene<T, M, N, S, W>
{
    fn levels(&self) -> Vec<Level> {
        alloc::vec![Level::SLIP_CURVE, Level::RELAXATION_LENGTH, Level::PATCH]
    }

    fn interval(&self) -> f64 {
        to_f64(self.clock.interval)
    }

    fn run(&self, plan: &Plan) -> Result<Run, FidelityError> {
        let (steps, mut run) = (plan.checked(&self.levels())?, Run::default());
        match plan.level {
            Level::SLIP_CURVE => self.slip_curve(&mut run),
            Level::RELAXATION_LENGTH => self.lag(steps, &mut run),
            _ => self.patch(steps, &mut run),
        }?;
        Ok(run)
    }

    /// Of the slip curve the lag: the change of the steady force in one transit over the largest
    /// steady force. Of the relaxation length that length over the length of the patch. Of the
    /// patch the share of the time in which no bristle relaxes on its way through it: it adheres.
    fn physics(&self, plan: &Plan) -> Option<(&'static str, f64)> {
        let (length, count) = (self.patch.length(), self.clock.answers as f64);
        let steady = |time| self.patch.steady(self.at(time)).map_or(0.0, |s| to_f64(s.force));
        let mut last = steady(T::zero());
        let (mut change, mut largest, mut adhering) = (0.0_f64, last.abs(), 0_u32);
        for time in self.clock.times() {
            let Motion { slip_velocity, rolling_speed } = self.at(time);
            let now = steady(time);
            let transits = self.interval() * to_f64(rolling_speed / length);
            change = change.max((now - last).abs() / transits);
            largest = largest.max(now.abs());
            let relaxation = self.patch.model().at_velocity(slip_velocity).relaxation;
            adhering += u32::from(relaxation * length < rolling_speed);
            last = now;
        }
        Some(match plan.level {
            Level::SLIP_CURVE => ("lag", (change / largest).min(2.0)),
            Level::RELAXATION_LENGTH => ("ς/L", to_f64(self.relaxation_length / length)),
            _ => ("adhering", f64::from(adhering) / count),
        })
    }
}
