//! A bristle dragged at a known velocity, and the rungs below it.

use alloc::vec::Vec;

use super::ladder::{
    self, Cache, Cached, Candidate, Instants, MOST_STEPS, Output, Pace, Run, Trace,
};
use super::pilot::Pilot;
use super::report::{Choice, FidelityError, Integrator, Norm, Plan, Rung, Tolerance};
use super::{Reducible, weight};
use crate::exponential::Exponential;
use crate::ode::{Failure, StopReason};
use crate::parameter::{self, ParameterError, Rule};
use crate::rheology::Deflection;
use crate::scalar::{is_zero, lit, to_f64};
use crate::signal::Signal;
use crate::{Bristle, Contact, Dahl, DahlParameters, Scalar};

/// How the bristle begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Start {
    /// Undeflected.
    #[default]
    Undeflected,
    /// As it is in steady sliding at the first velocity.
    Steady,
}

/// Parameters of [`History`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HistoryParameters<T, M, V> {
    /// The model to be replaced by a cheaper one, under its normal force.
    pub contact: Contact<T, M>,
    /// Sliding velocity v(t) [m/s], from t = 0 on.
    pub velocity: V,
    /// Time between two answers Δ \[s\]: the friction force is wanted at Δ, 2Δ, …
    pub interval: T,
    /// Number of answers, 8 to 10⁹.
    pub answers: usize,
    /// Answers in one period, 8 to 10⁹, if the velocity repeats itself: v(t + period·Δ) = v(t). The pilot then looks
    /// at two periods only. These two are compared; for the rest it is taken at your word.
    pub period: Option<usize>,
    /// How the bristle begins.
    pub start: Start,
}

/// A friction force wanted at equal intervals along a known velocity.
///
/// ```
/// use bristle::fidelity::{History, HistoryParameters, Norm, Rung, Start, Tolerance};
/// use bristle::signal::{Sine, SineParameters};
/// use bristle::{Bristle, FrBd, paper};
/// use bristle::curve::Stribeck;
/// use bristle::rheology::KelvinVoigt;
///
/// let friction = FrBd::new(
///     Stribeck::new(paper::STICK_SLIP_CURVE)?,
///     KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?,
/// );
/// let scene = |mean, amplitude| {
///     let velocity = SineParameters { mean, amplitude, frequency: 1.0, phase: 0.0 };
///     History::new(HistoryParameters {
///         contact: friction.under_load(1.0)?,
///         velocity: Sine::new(velocity)?,
///         interval: 0.01_f64,
///         answers: 1000,
///         period: Some(100),
///         start: Start::Steady,
///     })
/// };
/// let percent = Tolerance { norm: Norm::Greatest, share: 0.01 };
/// // Sliding on at 0.1 m/s the bristle never falls behind the curve. In pre-sliding it is all there is.
/// assert_eq!(scene(0.1, 0.05)?.choose(percent)?.plan.rung, Rung::StaticCurve);
/// assert_eq!(scene(0.0, 1e-4)?.choose(percent)?.plan.rung, Rung::Dahl);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct History<T: Scalar, M: Reducible<T>, V> {
    pub(super) contact: Contact<T, M>,
    pub(super) lumped: Contact<T, M::Lumped>,
    pub(super) dahl: Contact<T, Dahl<T>>,
    pub(super) is_lumped: bool,
    pub(super) velocity: V,
    pub(super) instants: Instants,
    pub(super) interval: T,
    pub(super) start: Start,
    /// p μ(0) \[N\].
    pub(super) breakaway: T,
    /// p max μ over the velocities met \[N\].
    pub(super) scale: T,
    /// The largest speed met [m/s].
    pub(super) fastest: T,
}

impl<T: Scalar, M: Reducible<T>, V: Signal<T>> History<T, M, V> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Refuses an interval or a normal force that is not positive, fewer than 8 answers or more than 10⁹ in all or in a period, a velocity that is
    /// not finite at the answers of the first two periods or not the same in both, and a model whose lumped one is out of range.
    pub fn new(parameters: HistoryParameters<T, M, V>) -> Result<Self, ParameterError> {
        let HistoryParameters { contact, velocity, interval, answers, period, start } = parameters;
        let interval = parameter::positive("interval", interval)?;
        count("answers", answers)?;
        if let Some(period) = period {
            count("period", period)?;
        }
        let normal_force = parameter::positive("normal_force", contact.normal_force())?;
        let instants =
            Instants { interval: to_f64(interval), count: answers, period, settled: None };
        // At which frequency the velocity moves: its root-mean-square rate over that of itself.
        let window = instants.window();
        let (mut rates, mut squares, mut fastest) = (T::zero(), T::zero(), T::zero());
        let mut last = parameter::finite("velocity", velocity.value(T::zero()))?;
        for index in 1..=window {
            let now = velocity.value(interval * lit(index as f64));
            let now = parameter::finite("velocity", now)?;
            rates += (now - last) * (now - last);
            squares += now * now;
            fastest = crate::bounds::larger(fastest, now.abs());
            last = now;
        }
        if let Some(period) = period.filter(|period| window == 2 * period) {
            // What roundings of the time make of a velocity, and no more.
            let rounding = crate::bounds::larger(lit(1e-6), T::default_epsilon() * lit(4096.0));
            for index in 0..=period {
                let at = |index: usize| velocity.value(interval * lit(index as f64));
                let (before, now) = (at(index), at(index + period));
                if !((now - before).abs() <= rounding * fastest) {
                    let (component, value) = (Some(index + period), to_f64(now));
                    let rule = Rule::Periodic { before: to_f64(before) };
                    return Err(ParameterError { name: "velocity", component, value, rule });
                }
            }
        }
        let slowest = T::one() / (interval * lit(answers as f64));
        let frequency = if squares > T::zero() {
            crate::bounds::larger((rates / squares).sqrt() / interval, slowest)
        } else {
            slowest
        };
        let lumped = contact.model().lumped(frequency)?;
        let is_lumped = contact.model().is_lumped();
        let model = &lumped;
        let breakaway = parameter::positive(
            "breakaway force",
            normal_force
                * model
                    .limits(T::zero())
                    .deflection
                    .map_or(T::zero(), |limit| limit * model.storage_stiffness()),
        )?;
        let scale = model.limits(fastest).coefficient.map_or(breakaway, |mu| mu * normal_force);
        // The constant coefficient that is right on average.
        let mut sum = T::zero();
        let some = (window / 64).max(1);
        let mut terms = 0.0;
        for index in (1..=window).step_by(some) {
            let now = velocity.value(interval * lit(index as f64));
            // Of the curve beside v = 0 where it is 0: that one has no sign.
            let now = if is_zero(now) { T::default_epsilon() } else { now };
            sum += model.stationary_coefficient(now).abs();
            terms += 1.0;
        }
        let dahl = Dahl::new(DahlParameters {
            dynamic_coefficient: sum / lit(terms),
            micro_stiffness: model.storage_stiffness(),
        })?
        .under_load(normal_force)?;
        let lumped = lumped.under_load(normal_force)?;
        Ok(Self {
            contact,
            lumped,
            dahl,
            is_lumped,
            velocity,
            instants,
            interval,
            start,
            breakaway,
            scale,
            fastest,
        })
    }

    /// The largest steady friction force at the velocities met, p max μ \[N\], the unit of tolerances. No force of
    /// FrBD exceeds it.
    pub fn force_scale(&self) -> T {
        self.scale
    }

    /// Finds the cheapest plan that meets a tolerance.
    ///
    /// The pilot costs no more than 2000 evaluations of the friction model, as [`Choice::pilot_evaluations`] counts them, or a
    /// twentieth of a full run of the reference if that is more.
    ///
    /// # Errors
    ///
    /// Refuses a share that is not positive, and says what the best is if no rung meets it, or what
    /// a pilot would need.
    pub fn choose(&self, tolerance: Tolerance) -> Result<Choice, FidelityError> {
        parameter::positive("share", tolerance.share)?;
        ladder::choose(&Pilot::new(self), tolerance, None)
    }

    /// The same with another limit on what the pilot may cost [evaluations of the friction model].
    ///
    /// # Errors
    ///
    /// As [`History::choose`].
    pub fn choose_within(
        &self,
        tolerance: Tolerance,
        most_evaluations: f64,
    ) -> Result<Choice, FidelityError> {
        parameter::positive("share", tolerance.share)?;
        let most = parameter::positive("most_evaluations", most_evaluations)?;
        ladder::choose(&Pilot::new(self), tolerance, Some(most))
    }

    /// Every plan with one step between two answers, from the cheapest rung on: what [`History::choose`]
    /// chooses from, with shorter steps where they are needed.
    pub fn plans(&self) -> Vec<Plan> {
        let candidates = self.candidates();
        candidates.iter().map(|candidate| self.plan(candidate, 1)).collect()
    }

    /// A plan with so many steps between two answers, 1 to 2²⁰.
    #[must_use]
    pub fn with_substeps(&self, plan: Plan, substeps: usize) -> Plan {
        let substeps = substeps.clamp(1, MOST_STEPS);
        let candidates = self.candidates();
        let same = |c: &&Candidate| (c.rung, c.integrator) == (plan.rung, plan.integrator);
        candidates.iter().find(same).map_or(plan, |candidate| self.plan(candidate, substeps))
    }

    fn plan(&self, candidate: &Candidate, substeps: usize) -> Plan {
        Plan {
            rung: candidate.rung,
            integrator: candidate.integrator,
            step: self.instants.interval / substeps as f64,
            substeps,
            cost_rate: candidate.weight(substeps) / self.instants.interval,
        }
    }

    /// Carries a plan out: the friction force \[N\] at every answer.
    ///
    /// # Errors
    ///
    /// Refuses a plan that is not one of this scene's or takes no step or more than 2²⁰ from one answer to the next, and a
    /// velocity that leads to a force that is not finite; says why a run stopped.
    pub fn forces(&self, plan: Plan) -> Result<Vec<T>, FidelityError> {
        let count = self.instants.count;
        let candidates = self.candidates();
        let same = |c: &&Candidate| (c.rung, c.integrator) == (plan.rung, plan.integrator);
        let candidate = candidates
            .iter()
            .find(same)
            .ok_or(FidelityError::NoSuchPlan { rung: plan.rung, integrator: plan.integrator })?;
        let pace = Pace { stride: 1, substeps: steps(plan)? };
        let run = self.run(candidate, pace, count, &Cache::default())?;
        finite(plan.rung, &run, self.instants, |answer| {
            parameter::finite("velocity", self.velocity.value(self.time(answer, 1)))
        })
    }

    pub(super) fn time(&self, index: usize, stride: usize) -> T {
        self.interval * lit((index * stride) as f64)
    }

    pub(super) fn initial<N: Bristle<T>>(&self, model: &N) -> N::Deflection {
        match self.start {
            Start::Undeflected => N::Deflection::fill(T::zero()),
            Start::Steady => model.stationary(self.velocity.value(T::zero())),
        }
    }

    /// The output of the lumped model, with what is known of it already, and the evaluations that it took.
    fn known(&self, cache: &Cache, intervals: usize, z: T) -> (Output, f64) {
        let contact = &self.lumped;
        match cache.at(intervals) {
            Some(cached) => {
                let springs = contact.model().storage_stiffness() * contact.normal_force();
                let memory = to_f64(springs * z);
                (
                    Output {
                        value: cached.by_memory * memory + cached.without,
                        memory,
                        spread: 0.0,
                    },
                    0.0,
                )
            }
            None => {
                let v = self.velocity.value(self.interval * lit(intervals as f64));
                (Self::output(contact, v, z), 1.0)
            }
        }
    }

    pub(super) fn output<N: Bristle<T>>(contact: &Contact<T, N>, v: T, z: N::Deflection) -> Output {
        let springs = contact.model().storage_stiffness();
        Output {
            value: to_f64(contact.force(v, z)),
            memory: to_f64(springs.dot(z) * contact.normal_force()),
            spread: 0.0,
        }
    }

    /// Holds at the velocity in the middle of each step.
    fn hold<N: Bristle<T>>(
        &self,
        contact: &Contact<T, N>,
        pace: Pace,
        strides: usize,
    ) -> Vec<Output> {
        let mut z = self.initial(contact.model());
        let step = self.interval * lit(pace.stride as f64 / pace.substeps as f64);
        let mut outputs = Vec::with_capacity(strides);
        for index in 0..strides {
            let start = self.time(index, pace.stride);
            for substep in 0..pace.substeps {
                let middle = self.velocity.value(start + step * lit(substep as f64 + 0.5));
                z = contact.model().hold(middle, z, step).deflection;
            }
            let v = self.velocity.value(self.time(index + 1, pace.stride));
            outputs.push(Self::output(contact, v, z));
        }
        outputs
    }

    /// The same for the lumped model, with what is known of its forces.
    fn hold_lumped(&self, pace: Pace, strides: usize, cache: &Cache) -> Run {
        let model = self.lumped.model();
        let mut z = self.initial(model);
        let step = self.interval * lit(pace.stride as f64 / pace.substeps as f64);
        let mut evaluations = (strides * pace.substeps) as f64;
        let mut outputs = Vec::with_capacity(strides);
        for index in 0..strides {
            let start = self.time(index, pace.stride);
            for substep in 0..pace.substeps {
                let middle = self.velocity.value(start + step * lit(substep as f64 + 0.5));
                z = model.hold(middle, z, step).deflection;
            }
            let (output, extra) = self.known(cache, (index + 1) * pace.stride, z);
            evaluations += extra;
            outputs.push(output);
        }
        Run { outputs, evaluations }
    }

    fn collocate(&self, pace: Pace, strides: usize, cache: &Cache) -> Result<Run, FidelityError> {
        let whole = Stretch { from: 0, to: strides, stride: pace.stride };
        let start = self.initial(self.lumped.model());
        let (deflections, mut evaluations) = self.deflections::<3>(whole, pace.substeps, start)?;
        let mut outputs = Vec::with_capacity(strides);
        for (index, z) in deflections.into_iter().enumerate() {
            let (output, extra) = self.known(cache, (index + 1) * pace.stride, z);
            evaluations += extra;
            outputs.push(output);
        }
        Ok(Run { outputs, evaluations })
    }

    /// The lumped model's deflections after each stride of a stretch, by collocation with S nodes, and the evaluations
    /// that they took. Answers are ends of steps: in between dense output has an error of its own.
    pub(super) fn deflections<const S: usize>(
        &self,
        stretch: Stretch,
        substeps: usize,
        start: T,
    ) -> Result<(Vec<T>, f64), FidelityError> {
        let Stretch { from, to, stride } = stretch;
        let span = self.time(from, stride)..self.time(to, stride);
        let step = self.interval * lit(stride as f64 / substeps as f64);
        let mut deflections = Vec::with_capacity(to - from);
        let statistics = Exponential::<S>
            .fixed(step)?
            .sample(&self.lumped, &self.velocity, span, start, to - from + 1, |_, z| {
                deflections.push(z);
            })
            .map_err(|failure| self.stopped(&failure))?;
        deflections.remove(0);
        Ok((deflections, statistics.evaluations as f64))
    }

    /// A rung over so many strides, an answer after each, with what is known of the answers.
    pub(super) fn run(
        &self,
        plan: &Candidate,
        pace: Pace,
        strides: usize,
        cache: &Cache,
    ) -> Result<Run, FidelityError> {
        if plan.rung == Rung::StaticCurve && pace.stride == cache.stride {
            let output = |cached: &Cached| Output {
                value: cached.lowest,
                memory: 0.0,
                spread: cached.spread,
            };
            return Ok(Run {
                outputs: cache.entries.iter().map(output).collect(),
                evaluations: 0.0,
            });
        }
        let evaluations = strides as f64 * plan.evaluations(pace.substeps);
        let outputs = match (plan.rung, plan.integrator) {
            (Rung::StaticCurve, _) => (1..=strides)
                .map(|index| {
                    let v = self.velocity.value(self.time(index, pace.stride));
                    let value = to_f64(self.contact.stationary_force(v));
                    Output { value, memory: 0.0, spread: 0.0 }
                })
                .collect(),
            (Rung::Dahl, _) => self.hold(&self.dahl, pace, strides),
            (Rung::FrBd, Integrator::Collocation) => {
                return self.collocate(pace, strides, cache);
            }
            (Rung::FrBd, _) => return Ok(self.hold_lumped(pace, strides, cache)),
            _ => self.hold(&self.contact, pace, strides),
        };
        Ok(Run { outputs, evaluations })
    }

    pub(super) fn candidates(&self) -> Vec<Candidate> {
        let top = self.is_lumped;
        let mut candidates = alloc::vec![
            Candidate {
                rung: Rung::StaticCurve,
                integrator: Integrator::Evaluation,
                top: false,
                step_weight: 0.0,
                answer_weight: weight::CURVE,
                step_evaluations: 0.0,
                answer_evaluations: 1.0,
                order: 0.0,
            },
            Candidate {
                rung: Rung::Dahl,
                integrator: Integrator::Hold,
                top: false,
                step_weight: weight::DAHL_HOLD,
                answer_weight: 0.0,
                step_evaluations: 1.0,
                answer_evaluations: 0.0,
                order: 2.0,
            },
            Candidate {
                rung: Rung::FrBd,
                integrator: Integrator::Hold,
                top,
                step_weight: weight::HOLD,
                answer_weight: weight::FORCE,
                step_evaluations: 1.0,
                answer_evaluations: 1.0,
                order: 2.0,
            },
            Candidate {
                rung: Rung::FrBd,
                integrator: Integrator::Collocation,
                top,
                step_weight: weight::COLLOCATION,
                answer_weight: weight::FORCE,
                step_evaluations: 3.0,
                answer_evaluations: 1.0,
                order: 5.0,
            },
        ];
        if !top {
            let (step_weight, answer_weight) = self.contact.model().weights();
            candidates.push(Candidate {
                rung: Rung::Reference,
                integrator: Integrator::Hold,
                top: true,
                step_weight,
                answer_weight,
                step_evaluations: 1.0,
                answer_evaluations: 1.0,
                order: 2.0,
            });
        }
        candidates
    }

    fn stopped(&self, failure: &Failure<T, 1>) -> FidelityError {
        let rung = Rung::FrBd;
        FidelityError::Stopped { rung, time: to_f64(failure.time), reason: failure.reason }
    }
}

/// Most answers, of a scene or of a period: eleven days at 1 kHz. Sums of two are in range everywhere.
const MOST_ANSWERS: usize = 1_000_000_000;

/// A number of answers.
pub(super) fn count(name: &'static str, value: usize) -> Result<(), ParameterError> {
    between(name, value, 8, MOST_ANSWERS).map(drop)
}

fn between(
    name: &'static str,
    value: usize,
    least: usize,
    most: usize,
) -> Result<usize, ParameterError> {
    if (least..=most).contains(&value) {
        return Ok(value);
    }
    let rule = Rule::CountBetween { least, most };
    Err(ParameterError { name, component: None, value: value as f64, rule })
}

/// The steps of a plan that is carried out.
pub(super) fn steps(plan: Plan) -> Result<usize, ParameterError> {
    between("plan.substeps", plan.substeps, 1, MOST_STEPS)
}

/// The answers of a run, all finite; else why not, where a look at the velocity of an answer tells.
pub(super) fn finite<T: Scalar, U>(
    rung: Rung,
    run: &Run,
    instants: Instants,
    velocity: impl Fn(usize) -> Result<U, ParameterError>,
) -> Result<Vec<T>, FidelityError> {
    let answer = |(index, output): (usize, &Output)| {
        if output.value.is_finite() {
            return Ok(lit(output.value));
        }
        velocity(index + 1)
            .map_err(|error| ParameterError { component: Some(index + 1), ..error })?;
        let time = instants.interval * (index + 1) as f64;
        Err(FidelityError::Stopped { rung, time, reason: StopReason::NotFinite { component: 0 } })
    };
    run.outputs.iter().enumerate().map(answer).collect()
}

/// A part of the pilot's grid: from after so many strides until after so many.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stretch {
    pub(super) from: usize,
    pub(super) to: usize,
    pub(super) stride: usize,
}

/// How much less accurate a reference of second order may be than one of high order, where accuracy is cheap.
const LOOSEST: f64 = 5.0;

impl<T: Scalar, M: Reducible<T>, V: Signal<T>> History<T, M, V> {
    /// The reference with half the step until it no longer changes.
    pub(super) fn trace_by_halving(
        &self,
        (stride, strides): (usize, usize),
        norm: Norm,
        accuracy: f64,
        budget: f64,
        steep: bool,
    ) -> Result<Trace, FidelityError> {
        let price = |substeps: usize| (strides * (substeps + 1)) as f64;
        let mut substeps = 1;
        let mut outputs = self.hold(&self.contact, Pace { stride, substeps }, strides);
        let mut evaluations = price(1);
        let mut uncertainty = f64::INFINITY;
        // Where much happens within a stride, two runs may both step over it.
        while (uncertainty > LOOSEST * accuracy || steep && substeps < 8)
            && evaluations + price(2 * substeps) <= budget
        {
            substeps *= 2;
            let finer = self.hold(&self.contact, Pace { stride, substeps }, strides);
            evaluations += price(substeps);
            let pairs = finer.iter().zip(&outputs);
            let off = pairs.map(|(a, b)| {
                let difference = a.value - b.value;
                difference * difference
            });
            // At first order the finer one is as far from the truth as from the coarser one.
            uncertainty = nalgebra::ComplexField::sqrt(match norm {
                Norm::Greatest => off.fold(0.0, |most: f64, e| if e <= most { most } else { e }),
                Norm::RootMeanSquare => off.sum::<f64>() / strides as f64,
            });
            outputs = finer;
        }
        if steep && substeps < 8 {
            uncertainty = f64::INFINITY;
        }
        Ok(Trace { run: Run { outputs, evaluations }, uncertainty, known: None })
    }
}
