//! A bristle dragged at a known velocity, and the rungs below it.

use alloc::vec::Vec;

use super::ladder::{
    self, Bound, Cache, Cached, Candidate, Climb, Instants, Known, Output, Pace, Run, Trace,
};
use super::report::{Choice, Evidence, FidelityError, Integrator, Norm, Plan, Rung, Tolerance};
use super::{Reducible, weight};
use crate::exponential::Exponential;
use crate::ode::Failure;
use crate::parameter::{self, ParameterError, Rule};
use crate::scalar::{is_zero, lit, to_f64};
use crate::signal::Signal;
use crate::{Bristle, Contact, Dahl, DahlParameters, Deflection, Scalar, Sliding};

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
    /// Number of answers, at least 8.
    pub answers: usize,
    /// Answers in one period, at least 8, if the velocity repeats itself: v(t + period·Δ) = v(t). The pilot then looks
    /// at two periods only. It is taken at your word.
    pub period: Option<usize>,
    /// How the bristle begins.
    pub start: Start,
}

/// A friction force wanted at equal intervals along a known velocity.
///
/// ```
/// use bristle::fidelity::{History, HistoryParameters, Norm, Rung, Start, Tolerance};
/// use bristle::signal::{Sine, SineParameters};
/// use bristle::{Bristle, FrBd, KelvinVoigt, Stribeck, paper};
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
    contact: Contact<T, M>,
    lumped: Contact<T, M::Lumped>,
    dahl: Contact<T, Dahl<T>>,
    is_lumped: bool,
    velocity: V,
    instants: Instants,
    interval: T,
    start: Start,
    /// p μ(0) \[N\].
    breakaway: T,
    /// p max μ over the velocities met \[N\].
    scale: T,
    /// The largest speed met [m/s].
    fastest: T,
}

impl<T: Scalar, M: Reducible<T>, V: Signal<T>> History<T, M, V> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Refuses an interval or a normal force that is not positive, fewer than 8 answers in all or in a period, a velocity that is
    /// not finite at the answers of the first two periods, and a model whose lumped one is out of range.
    pub fn new(parameters: HistoryParameters<T, M, V>) -> Result<Self, ParameterError> {
        let HistoryParameters { contact, velocity, interval, answers, period, start } = parameters;
        let interval = parameter::positive("interval", interval)?;
        count("answers", answers)?;
        if let Some(period) = period {
            count("period", period)?;
        }
        let normal_force = parameter::positive("normal_force", contact.normal_force())?;
        let instants = Instants { interval: to_f64(interval), count: answers, period };
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
    /// The pilot costs no more than 2000 weighted right-hand sides, or a twentieth of a full run of the
    /// reference if that is more.
    ///
    /// # Errors
    ///
    /// Refuses a share that is not positive, and says what the best is if no rung meets it, or what
    /// a pilot would need.
    pub fn choose(&self, tolerance: Tolerance) -> Result<Choice, FidelityError> {
        parameter::positive("share", tolerance.share)?;
        ladder::choose(self, tolerance, None)
    }

    /// The same with another limit on what the pilot may cost [weighted right-hand sides].
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
        ladder::choose(self, tolerance, Some(most))
    }

    /// Every plan with one step between two answers, from the cheapest rung on: what [`History::choose`]
    /// chooses from, with shorter steps where they are needed.
    pub fn plans(&self) -> Vec<Plan> {
        let candidates = self.candidates();
        candidates.iter().map(|candidate| self.plan(candidate, 1)).collect()
    }

    /// A plan with so many steps between two answers.
    #[must_use]
    pub fn with_substeps(&self, plan: Plan, substeps: usize) -> Plan {
        let substeps = substeps.max(1);
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
    /// Refuses a plan that is not one of this scene's; says why a run stopped.
    pub fn forces(&self, plan: Plan) -> Result<Vec<T>, FidelityError> {
        let count = self.instants.count;
        let candidates = self.candidates();
        let same = |c: &&Candidate| (c.rung, c.integrator) == (plan.rung, plan.integrator);
        let candidate = candidates.iter().find(same).ok_or(ParameterError {
            name: "plan.rung",
            component: None,
            value: plan.substeps as f64,
            rule: Rule::AtMost { other: "the number of rungs of this scene", limit: 0.0 },
        })?;
        let pace = Pace { stride: 1, substeps: plan.substeps.max(1) };
        let run = self.run(candidate, pace, count, &Cache::default())?;
        Ok(run.outputs.iter().map(|output| lit(output.value)).collect())
    }

    fn time(&self, index: usize, stride: usize) -> T {
        self.interval * lit((index * stride) as f64)
    }

    fn initial<N: Bristle<T>>(&self, model: &N) -> N::Deflection {
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

    fn output<N: Bristle<T>>(contact: &Contact<T, N>, v: T, z: N::Deflection) -> Output {
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
    fn deflections<const S: usize>(
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

    fn stopped(&self, failure: &Failure<T, 1>) -> FidelityError {
        let rung = Rung::FrBd;
        FidelityError::Stopped { rung, time: to_f64(failure.time), reason: failure.reason }
    }
}

/// At least 8.
pub(super) fn count(name: &'static str, value: usize) -> Result<(), ParameterError> {
    if value >= 8 {
        return Ok(());
    }
    Err(ParameterError {
        name,
        component: None,
        value: value as f64,
        rule: Rule::Count { least: 8 },
    })
}

impl<T: Scalar, M: Reducible<T>, V: Signal<T>> Climb for History<T, M, V> {
    fn instants(&self) -> Instants {
        self.instants
    }

    fn scale(&self) -> f64 {
        to_f64(self.scale)
    }

    fn roundings(&self) -> f64 {
        // Some for each step of a pilot, added up.
        64.0 * to_f64(T::default_epsilon()) * to_f64(self.scale)
    }

    fn looks(&self) -> f64 {
        if self.is_lumped {
            // One evaluation for the bound, three for the reference, one for the held steps.
            0.18
        } else {
            // One; and a step and the force, and two steps and the force.
            0.14
        }
    }

    fn candidates(&self) -> Vec<Candidate> {
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

    fn bound(&self, stride: usize, strides: usize) -> Result<Bound, FidelityError> {
        let step = self.interval * lit(stride as f64);
        let contact = &self.lumped;
        let model = contact.model();
        let at = |index: usize| {
            let v = self.velocity.value(self.time(index, stride));
            let affine = model.affine(Sliding::from(v), T::zero());
            // z_ss = r v/λ, without a division by zero.
            (v, affine, model.stationary(v))
        };
        let breakaway = self.breakaway / (model.storage_stiffness() * contact.normal_force());
        let (mut v, affine, mut steady) = at(0);
        let mut rate = affine.relaxation;
        let springs = model.storage_stiffness();
        let mut entries = Vec::with_capacity(strides);
        let mut error = (self.initial(model) - steady).abs();
        let mut errors = Vec::with_capacity(strides);
        let mut relaxation = T::zero();
        let (mut relaxations, mut fastest_rate) = (Vec::with_capacity(strides), rate);
        let (mut slowest, mut fastest) = (v.abs(), v.abs());
        let (mut lag, mut reversals, mut stuck) = (T::zero(), 0, 0_usize);
        // The way slid in the direction of now, and the longest.
        let (mut way, mut longest) = (T::zero(), T::zero());
        let mut direction = v;
        for index in 1..=strides {
            let (next_v, affine, next_steady) = at(index);
            let (next_rate, stiffness) = (affine.relaxation, affine.stiffness);
            let lowest_force = if self.is_lumped {
                contact.normal_force() * affine.coefficient(next_v, next_steady)
            } else {
                self.contact.stationary_force(next_v)
            };
            // A velocity that is zero but for roundings has either sign, sooner or later.
            let nearly = next_v.abs() <= self.fastest * lit(1e-9);
            let speeds = (v.abs(), next_v.abs());
            let (slow, fast) = if speeds.0 < speeds.1 { speeds } else { (speeds.1, speeds.0) };
            let turned = !(v * next_v > T::zero());
            let uneven = turned || slow < fast * lit(0.5);
            let relaxes = crate::bounds::larger(rate, next_rate) * step > lit(0.3);
            let varies = (next_steady - steady).abs() > breakaway * lit(0.05);
            let steep = uneven && relaxes && varies;
            // Answers between the instants looked at, just after a reversal or the start.
            let unseen = stride > 1 && (turned || index == 1);
            let spread = if nearly || unseen { self.scale + lowest_force.abs() } else { T::zero() };
            entries.push(Cached {
                by_memory: to_f64(stiffness / springs),
                without: to_f64(contact.normal_force() * affine.damping * next_v),
                lowest: to_f64(lowest_force),
                spread: to_f64(spread),
                steep,
            });
            // Between two velocities of one sign the rate is taken to lie between theirs, and z_ss to
            // vary by no more than from one to the other.
            let turns = !(v * next_v > T::zero());
            let lowest = if turns { T::zero() } else { crate::bounds::smaller(rate, next_rate) };
            let change = (next_steady - steady).abs();
            error = error * (-lowest * step).exp() + change;
            errors.push(to_f64(stiffness * error * contact.normal_force() + spread));
            relaxation += (rate + next_rate) * lit(0.5) * step;
            relaxations.push(to_f64(relaxation));
            fastest_rate = crate::bounds::larger(fastest_rate, next_rate);
            lag = crate::bounds::larger(lag, change / (step * next_rate * breakaway));
            slowest = crate::bounds::smaller(slowest, next_v.abs());
            fastest = crate::bounds::larger(fastest, next_v.abs());
            if direction * next_v < T::zero() {
                reversals += 1;
                way = T::zero();
                slowest = T::zero();
            }
            if !is_zero(next_v) {
                direction = next_v;
            }
            way += next_v.abs() * step;
            longest = crate::bounds::larger(longest, way);
            if way < breakaway {
                stuck += 1;
            }
            (v, rate, steady) = (next_v, next_rate, next_steady);
        }
        let periods = match self.instants.period {
            Some(period) => (strides * stride) as f64 / period as f64,
            None => 1.0,
        };
        let evidence = Evidence {
            slowest: to_f64(slowest),
            fastest: to_f64(fastest),
            reversals,
            lag: to_f64(lag),
            presliding: to_f64(breakaway / longest),
            stuck_share: stuck as f64 / strides as f64,
            relaxation: to_f64(relaxation) / periods,
        };
        Ok(Bound {
            errors: self.is_lumped.then_some(errors),
            relaxation: relaxations,
            fastest_rate: to_f64(fastest_rate),
            evidence,
            cache: Cache { stride, entries },
            evaluations: strides as f64 + 1.0,
        })
    }

    fn run(
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

    fn trace(
        &self,
        stride: usize,
        strides: usize,
        norm: Norm,
        accuracy: f64,
        budget: f64,
        cache: &Cache,
    ) -> Result<Trace, FidelityError> {
        if !self.is_lumped {
            let steep = cache.entries.iter().any(|cached| cached.steep);
            return self.trace_by_halving((stride, strides), norm, accuracy, budget, steep);
        }
        // With three nodes a step, and held: of orders five and two, and both end at the answers.
        let whole = Stretch { from: 0, to: strides, stride };
        let start = self.initial(self.lumped.model());
        let (mut fine, mut evaluations) = self.deflections::<3>(whole, 1, start)?;
        let held = self.hold_lumped(Pace { stride, substeps: 1 }, strides, cache);
        evaluations += held.evaluations;
        let springs = self.lumped.model().storage_stiffness() * self.lumped.normal_force();
        let off = |a: T, b: T| to_f64((a - b).abs() * springs);
        let mut known = Vec::new();
        let coarse = held.outputs.iter().map(|output| output.memory);
        let mut pairs: Vec<f64> =
            fine.iter().zip(coarse).map(|(a, b)| (to_f64(*a * springs) - b).abs()).collect();
        let enough = LOOSER * accuracy;
        // Two runs that both step over what happens agree on nothing.
        for (pair, cached) in pairs.iter_mut().zip(&cache.entries) {
            if cached.steep {
                *pair = f64::INFINITY;
            }
        }
        let outputs = |deflections: &[T], evaluations: &mut f64| -> Vec<Output> {
            let known = deflections.iter().enumerate().map(|(index, z)| {
                let (output, extra) = self.known(cache, (index + 1) * stride, *z);
                *evaluations += extra;
                output
            });
            known.collect()
        };
        known.push((Integrator::Hold, 1, held.outputs));
        known.push((Integrator::Collocation, 1, outputs(&fine, &mut evaluations)));
        // Where they differ, two nodes a step (far better than held ones in fast sliding), and then shorter steps
        // until they no longer make a difference.
        let mut substeps = 1;
        let mut nodes = 2;
        loop {
            let stretches = stretches(&pairs, enough, stride);
            let steps: usize = stretches.iter().map(|s| (s.to - s.from) * substeps).sum();
            let price = (nodes * steps + 12 * stretches.len()) as f64;
            if stretches.is_empty() || substeps > 4096 || evaluations + price > budget {
                break;
            }
            for stretch in &stretches {
                let start = match stretch.from.checked_sub(1).and_then(|last| fine.get(last)) {
                    Some(z) => *z,
                    None => start,
                };
                let (other, more) = if nodes == 2 {
                    self.deflections::<2>(*stretch, substeps, start)?
                } else {
                    self.deflections::<3>(*stretch, substeps, start)?
                };
                evaluations += more;
                let places = fine.iter_mut().zip(&mut pairs).skip(stretch.from);
                for ((z, pair), other) in places.zip(other) {
                    if nodes == 3 || pair.is_finite() {
                        *pair = off(*z, other);
                    }
                    if nodes == 3 {
                        *z = other;
                    }
                }
            }
            if nodes == 3 {
                let outputs = outputs(&fine, &mut evaluations);
                known.push((Integrator::Collocation, substeps, outputs));
            }
            nodes = 3;
            substeps *= 8;
        }
        let worst = pairs.iter().fold(0.0, |most: f64, e| if *e <= most { most } else { *e });
        let uncertainty = worst / LOOSER;
        let run = Run { outputs: outputs(&fine, &mut evaluations), evaluations };
        let known = Known { runs: known };
        Ok(Trace { run, uncertainty, known: Some(known) })
    }
}

/// A part of the pilot's grid: from after so many strides until after so many.
#[derive(Debug, Clone, Copy)]
struct Stretch {
    from: usize,
    to: usize,
    stride: usize,
}

/// The parts of a pilot's grid in which two runs differ by more than is allowed.
fn stretches(pairs: &[f64], enough: f64, stride: usize) -> Vec<Stretch> {
    let mut stretches: Vec<Stretch> = Vec::new();
    for (index, pair) in pairs.iter().enumerate() {
        if *pair <= enough {
            continue;
        }
        match stretches.last_mut() {
            Some(last) if last.to == index => last.to = index + 1,
            _ => stretches.push(Stretch { from: index, to: index + 1, stride }),
        }
    }
    stretches
}

/// How much less accurate a reference of second order may be than one of high order, where accuracy is cheap.
const LOOSEST: f64 = 5.0;

/// A run of one order is at least so many times as good as its difference from one of lower order.
const LOOSER: f64 = 8.0;

impl<T: Scalar, M: Reducible<T>, V: Signal<T>> History<T, M, V> {
    /// The reference with half the step until it no longer changes.
    fn trace_by_halving(
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
