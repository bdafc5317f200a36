//! A contact patch along a known motion, and the rungs below it.

use alloc::boxed::Box;
use alloc::vec::Vec;

use super::history::{Start, count, finite, steps};
use super::ladder::{
    self, Bound, Cache, Candidate, Climb, Instants, Known, MOST_STEPS, Output, Pace, Run, Trace,
};
use super::look::{Look, Looks};
use super::report::{Choice, FidelityError, Integrator, Norm, Plan, Rung, Tolerance};
use super::walk::{self, Build, Roll, Scheme, Walk, Walked};
use super::{between, weight};
use crate::Scalar;
use crate::parameter::{self, ParameterError};
use crate::rolling::{
    Motion, MotionOverTime, Patch, PolynomialExponential, Pressure, RateDependent,
};
use crate::scalar::{lit, to_f64};
use crate::signal::Signal;

/// Instants from which the unit of the tolerance and the mean motion are taken.
const SAMPLES: usize = 64;
/// Cells of the grids on offer.
const CELLS: [usize; 4] = [24, 96, 384, 1536];
/// A run is at least so many times as good as its difference from one of a lower order …
const BETTER: f64 = 8.0;
/// … and as its difference from one of the second order with steps twice as long.
const HALVED: f64 = 2.0;
/// Most steps that the reference of a pilot takes from one answer to the next.
const FINEST: usize = 1 << 10;

/// Parameters of [`RollingHistory`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RollingHistoryParameters<T, M, P, S, W> {
    /// The patch to be replaced by a cheaper model, carrying its normal force.
    pub patch: Patch<T, M, P>,
    /// Slip velocity v(t) [m/s] and rolling speed U(t) [m/s] from t = 0 on.
    pub motion: MotionOverTime<S, W>,
    /// Time between two answers Δ \[s\]: the friction force is wanted at Δ, 2Δ, …
    pub interval: T,
    /// Number of answers, 8 to 10⁹.
    pub answers: usize,
    /// Answers in one period, 8 to 10⁹, if both velocities repeat themselves. The pilot then looks at the first transit of
    /// the patch and one period. It is taken at your word.
    pub period: Option<usize>,
    /// How the bristles begin.
    pub start: Start,
}

/// The friction force of a patch wanted at equal intervals along a known motion.
///
/// ```
/// use bristle::fidelity::{Norm, RollingHistory, RollingHistoryParameters, Rung, Start, Tolerance};
/// use bristle::rolling::{MotionOverTime, Patch, PatchParameters, PolynomialExponential};
/// use bristle::signal::{Constant, Sine, SineParameters};
/// use bristle::{FrBd, paper};
/// use bristle::curve::Stribeck;
/// use bristle::rheology::KelvinVoigt;
///
/// let tyre = Patch::new(PatchParameters {
///     model: FrBd::new(Stribeck::new(paper::TYRE_CURVE)?, KelvinVoigt::new(paper::TYRE_BRISTLE)?),
///     length: paper::TYRE_LENGTH,
///     pressure: PolynomialExponential::parabolic(),
/// })?
/// .carrying(4000.0)?; // N
/// let scene = |frequency: f64| {
///     let slip = SineParameters { mean: 0.2, amplitude: 0.2, frequency, phase: 0.0 };
///     RollingHistory::new(RollingHistoryParameters {
///         patch: tyre,
///         // Rolling at 16 m/s: 160 transits a second.
///         motion: MotionOverTime {
///             slip_velocity: Sine::new(slip)?,
///             rolling_speed: Constant::new(16.0)?,
///         },
///         interval: 0.01 / frequency,
///         answers: 1000,
///         period: Some(100),
///         start: Start::Steady,
///     })
/// };
/// let percent = Tolerance { norm: Norm::Greatest, share: 0.01 };
/// // Slow steering follows the slip curve. With half a transit in a period, the patch itself is needed.
/// assert_eq!(scene(0.2)?.choose(percent)?.plan.rung, Rung::SlipCurve);
/// assert_eq!(scene(320.0)?.choose(percent)?.plan.rung, Rung::Patch);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct RollingHistory<T: Scalar, M, P, S, W> {
    pub(super) patch: Patch<T, M, P>,
    pub(super) motion: MotionOverTime<S, W>,
    instants: Instants,
    interval: T,
    pub(super) start: Start,
    /// Largest steady force \[N\] of the instants sampled.
    scale: T,
    /// Largest speed \[m/s\] among them.
    fastest: T,
    /// The relaxation length over that of the patch \[–\].
    relaxation: T,
    /// Smallest, mean and largest transport velocity [1/s] at the instants of the pilot.
    transport: (f64, f64, f64),
    /// The exact reduction, if the pressure allows for it.
    exact: Option<Build<T, M, P, S, W>>,
}

impl<T, M, S, W, const N: usize> RollingHistory<T, M, PolynomialExponential<T, N>, S, W>
where
    T: Scalar,
    M: RateDependent<T>,
    S: Signal<T>,
    W: Signal<T>,
{
    /// Checks the parameters. The top of the ladder is the exact reduction, [`ExactPatch`](crate::rolling::ExactPatch).
    ///
    /// # Errors
    ///
    /// Refuses an interval or a normal force that is not positive, fewer than 8 answers or more than 10⁹ in all or in a period, and at the
    /// answers that the pilot looks at, a velocity that is not finite and a transport velocity below zero.
    pub fn new(
        parameters: RollingHistoryParameters<T, M, PolynomialExponential<T, N>, S, W>,
    ) -> Result<Self, ParameterError> {
        Self::build(parameters, Some(walk::exact))
    }
}

impl<T, M, P, S, W> RollingHistory<T, M, P, S, W>
where
    T: Scalar,
    M: RateDependent<T>,
    P: Pressure<T>,
    S: Signal<T>,
    W: Signal<T>,
{
    /// The same under any pressure: the top of the ladder is a [`Grid`](crate::rolling::Grid), whose cells are part of the plan.
    ///
    /// # Errors
    ///
    /// As [`RollingHistory::new`].
    pub fn on_grid(
        parameters: RollingHistoryParameters<T, M, P, S, W>,
    ) -> Result<Self, ParameterError> {
        Self::build(parameters, None)
    }

    fn build(
        parameters: RollingHistoryParameters<T, M, P, S, W>,
        exact: Option<Build<T, M, P, S, W>>,
    ) -> Result<Self, ParameterError> {
        let RollingHistoryParameters { patch, motion, interval, answers, period, start } =
            parameters;
        let interval = parameter::positive("interval", interval)?;
        count("answers", answers)?;
        if let Some(period) = period {
            count("period", period)?;
        }
        parameter::positive("normal_force", patch.normal_force())?;
        let at = |index: usize| patch.forward(walk::at(&motion, interval * lit(index as f64)));
        // Every answer after a first transit remembers nothing of the start.
        let mut last = at(0)?.transport;
        let (mut crossed, mut transit) = (T::zero(), None);
        let (mut slowest, mut most, mut sum) = (last, last, T::zero());
        let mut window = answers;
        let mut index = 0;
        while index < window {
            index += 1;
            let next = at(index)?.transport;
            let least = crate::bounds::smaller(last, next);
            crossed += least * interval;
            if transit.is_none() && crossed >= lit(1.0 + 4.0e-3) {
                transit = Some(index);
                window = period.map_or(answers, |period| (index + period).min(answers));
            }
            slowest = crate::bounds::smaller(slowest, next);
            most = crate::bounds::larger(most, next);
            sum += next;
            last = next;
        }
        let settled = match (transit, period) {
            (Some(transit), Some(period)) => Some(transit + period),
            _ => None,
        };
        let instants = Instants { interval: to_f64(interval), count: answers, period, settled };
        let looks = Looks::new(&patch, &motion);
        let mut fastest = T::zero();
        let (mut scale, mut speed, mut transport, mut terms) =
            (T::zero(), T::zero(), T::zero(), 0.0);
        for index in (0..=window).step_by((window / SAMPLES).max(1)) {
            let look = looks.at(interval * lit(index as f64))?;
            scale = crate::bounds::larger(scale, look.force.abs());
            speed += look.slip.abs();
            fastest = crate::bounds::larger(fastest, look.slip.abs());
            transport += look.transport;
            terms += 1.0;
        }
        if !(scale > T::zero()) {
            // Nothing slips: the most that could be.
            let model = patch.model();
            let coefficient = model.limits(T::zero()).coefficient.unwrap_or_else(T::one);
            scale = patch.normal_force() * coefficient;
        }
        let scale = parameter::positive("largest steady force", scale)?;
        let mean = Motion {
            slip_velocity: speed / lit(terms),
            rolling_speed: patch.length() * transport / lit(terms),
        };
        let relaxation = relaxation(&patch, mean);
        let transport = (to_f64(slowest), to_f64(sum) / window as f64, to_f64(most));
        Ok(Self {
            patch,
            motion,
            instants,
            interval,
            start,
            scale,
            fastest,
            relaxation,
            transport,
            exact,
        })
    }

    /// The largest steady friction force at some sixty instants of what the pilot looks at \[N\], the unit of tolerances; of a
    /// patch that does not slip F_z max μ.
    pub fn force_scale(&self) -> T {
        self.scale
    }

    /// The relaxation length ς \[m\] of the rung [`Rung::RelaxationLength`].
    #[doc(alias = "sigma")]
    pub fn relaxation_length(&self) -> T {
        self.relaxation * self.patch.length()
    }

    /// Finds the cheapest plan that meets a tolerance.
    ///
    /// The pilot costs no more than 2000 evaluations of the friction model, or a twentieth of those of a full run of the
    /// patch itself if that is more.
    ///
    /// # Errors
    ///
    /// Refuses a share that is not positive, and says what the best is if no rung meets it, or what a pilot would need.
    pub fn choose(&self, tolerance: Tolerance) -> Result<Choice, FidelityError> {
        parameter::positive("share", tolerance.share)?;
        ladder::choose(self, tolerance, None).map(|choice| self.true_steps(choice))
    }

    /// The same with another limit on what the pilot may cost \[evaluations of the friction model\].
    ///
    /// # Errors
    ///
    /// As [`RollingHistory::choose`].
    pub fn choose_within(
        &self,
        tolerance: Tolerance,
        most_evaluations: f64,
    ) -> Result<Choice, FidelityError> {
        parameter::positive("share", tolerance.share)?;
        let most = parameter::positive("most_evaluations", most_evaluations)?;
        ladder::choose(self, tolerance, Some(most)).map(|choice| self.true_steps(choice))
    }

    /// Every plan with one step between two answers, from the cheapest rung on: what [`RollingHistory::choose`] chooses
    /// from, with shorter steps where they are needed.
    pub fn plans(&self) -> Vec<Plan> {
        self.candidates().iter().map(|candidate| self.plan(candidate, 1)).collect()
    }

    /// A plan with so many steps between two answers (or within the last transit before an answer, if that is shorter), 1 to 2²⁰.
    #[must_use]
    pub fn with_substeps(&self, plan: Plan, substeps: usize) -> Plan {
        let found = self.candidate(plan);
        found.map_or(plan, |candidate| self.plan(&candidate, substeps.clamp(1, MOST_STEPS)))
    }

    fn candidate(&self, plan: Plan) -> Option<Candidate> {
        let same = |c: &Candidate| (c.rung, c.integrator) == (plan.rung, plan.integrator);
        self.candidates().into_iter().find(same)
    }

    fn plan(&self, candidate: &Candidate, substeps: usize) -> Plan {
        self.true_step(Plan {
            rung: candidate.rung,
            integrator: candidate.integrator,
            step: self.instants.interval / substeps as f64,
            substeps,
            cost_rate: candidate.weight(substeps) / self.instants.interval,
        })
    }

    /// Steps are no longer than the interval's part that matters.
    fn true_step(&self, plan: Plan) -> Plan {
        if plan.rung != Rung::Patch {
            return plan;
        }
        let (span, parts) = self.span(plan.integrator);
        Plan { step: span / (parts * plan.substeps) as f64, ..plan }
    }

    fn true_steps(&self, choice: Choice) -> Choice {
        let mut choice = choice;
        choice.plan = self.true_step(choice.plan);
        for trial in &mut choice.trials {
            trial.plan = self.true_step(trial.plan);
        }
        choice
    }

    /// The part of an interval that matters \[s\], and into how many parts a step is divided there.
    fn span(&self, integrator: Integrator) -> (f64, usize) {
        let (interval, mean) = (self.instants.interval, self.transport.1);
        let span = if interval * mean > 1.0 { 1.0 / mean } else { interval };
        (span, if integrator == Integrator::Gauss { self.parts(interval) } else { 1 })
    }

    /// Into how many parts the fourth order divides a step of this length \[s\], or the transit within it.
    fn parts(&self, step: f64) -> usize {
        let distance = self.transport.2 * step;
        walk::parts(1.002 * if distance < 1.0 { distance } else { 1.0 })
    }

    /// Carries a plan out: the friction force \[N\] at every answer.
    ///
    /// # Errors
    ///
    /// Refuses a plan that is not one of this scene's or takes no step or more than 2²⁰ from one answer to the next, and a
    /// motion that is not finite, rolls backwards or crosses the patch many thousand times at any of its steps.
    pub fn forces(&self, plan: Plan) -> Result<Vec<T>, FidelityError> {
        let candidate = self
            .candidate(plan)
            .ok_or(FidelityError::NoSuchPlan { rung: plan.rung, integrator: plan.integrator })?;
        let pace = Pace { stride: 1, substeps: steps(plan)? };
        let run = self.run(&candidate, pace, self.instants.count, &Cache::default())?;
        finite(plan.rung, &run, self.instants, |answer| {
            self.patch.forward(walk::at(&self.motion, self.time(answer)))
        })
    }

    fn looks_at(&self, time: T) -> Result<Look<T>, ParameterError> {
        Looks::new(&self.patch, &self.motion).at(time)
    }

    pub(super) fn time(&self, intervals: usize) -> T {
        self.interval * lit(intervals as f64)
    }

    /// The largest speed met [m/s].
    pub(super) fn fastest(&self) -> T {
        self.fastest
    }

    /// Periods in so many intervals; of what does not repeat itself, one.
    pub(super) fn periods(&self, intervals: usize) -> f64 {
        self.instants.period.map_or(1.0, |period| intervals as f64 / period as f64)
    }

    fn settled(&self) -> Option<Motion<T>> {
        (self.start == Start::Steady).then(|| walk::at(&self.motion, T::zero()))
    }

    /// A patch with room for steps of some length.
    fn roll(
        &self,
        integrator: Integrator,
        step: f64,
    ) -> Result<Box<dyn Roll<T, S, W> + '_>, ParameterError> {
        let settled = self.settled();
        if let Integrator::Grid { cells } = integrator {
            return walk::grid(&self.patch, cells, settled);
        }
        let segments = walk::segments(self.transport.0, step);
        (self.exact.unwrap_or(walk::weighed))(&self.patch, segments, settled)
    }

    fn walk(&self, integrator: Integrator, pace: Pace) -> Walk<'_, T, S, W> {
        let scheme = if integrator == Integrator::Gauss { Scheme::Gauss } else { Scheme::Held };
        let interval = self.interval * lit(pace.stride as f64);
        Walk {
            motion: &self.motion,
            length: self.patch.length(),
            interval,
            substeps: pace.substeps,
            scheme,
        }
    }

    /// The patch itself at some answers, counted in strides.
    fn rolled(
        &self,
        integrator: Integrator,
        pace: Pace,
        answers: impl Iterator<Item = usize>,
    ) -> Result<Walked<T>, ParameterError> {
        let parts = self.span(integrator).1;
        let step = self.instants.interval * pace.stride as f64 / (pace.substeps * parts) as f64;
        let mut roll = self.roll(integrator, step)?;
        self.walk(integrator, pace).go(roll.as_mut(), answers)
    }

    /// The force of what is gathered after so many intervals, and the evaluations that it took.
    fn output(
        &self,
        cache: &Cache,
        intervals: usize,
        gathered: T,
    ) -> Result<(Output, f64), ParameterError> {
        let (value, evaluations) = match cache.at(intervals) {
            Some(cached) => (cached.by_memory * to_f64(gathered) + cached.without, 0.0),
            None => {
                let slip = parameter::finite(
                    "slip_velocity",
                    self.motion.slip_velocity.value(self.time(intervals)),
                )?;
                let affine = self.patch.model().at_velocity(slip);
                let force = walk::force(&affine, gathered, self.patch.normal_force(), slip);
                (to_f64(force), 1.0)
            }
        };
        Ok((Output { value, memory: value, spread: 0.0 }, evaluations))
    }

    fn outputs(&self, cache: &Cache, stride: usize, gathered: &[T]) -> Result<Run, ParameterError> {
        let mut outputs = Vec::with_capacity(gathered.len());
        let mut evaluations = 0.0;
        for (index, gathered) in gathered.iter().enumerate() {
            let (output, more) = self.output(cache, (index + 1) * stride, *gathered)?;
            evaluations += more;
            outputs.push(output);
        }
        Ok(Run { outputs, evaluations })
    }

    /// Ḟ = −(V/ς)(F − F_ss), with F_ss taken to run straight from one step's end to the other's and V held at its middle.
    fn relax(&self, pace: Pace, strides: usize, cache: &Cache) -> Result<Run, ParameterError> {
        let first = self.looks_at(T::zero())?;
        let mut evaluations = 1.0;
        let mut steady = first.force;
        let mut force = match self.start {
            Start::Steady => steady,
            Start::Undeflected => {
                walk::force(&first.affine, T::zero(), self.patch.normal_force(), first.slip)
            }
        };
        let step = self.interval * lit(pace.stride as f64 / pace.substeps as f64);
        let mut outputs = Vec::with_capacity(strides);
        for index in 0..strides {
            let start = self.time(index * pace.stride);
            for substep in 1..=pace.substeps {
                let last = substep == pace.substeps;
                let known = if last { cache.at((index + 1) * pace.stride) } else { None };
                let end = start + step * lit(substep as f64);
                let next = match known {
                    Some(cached) => lit(cached.lowest),
                    None => {
                        evaluations += 1.0;
                        self.looks_at(end)?.force
                    }
                };
                let middle = self.motion.rolling_speed.value(end - step * lit(0.5));
                let middle =
                    parameter::non_negative("rolling_speed", middle)? / self.patch.length();
                let (kept, lag, _) = crate::rheology::relaxed(middle * step / self.relaxation);
                force = next - lag * (next - steady) + kept * (force - steady);
                steady = next;
            }
            let value = to_f64(force);
            outputs.push(Output { value, memory: value, spread: 0.0 });
        }
        Ok(Run { outputs, evaluations })
    }
}

/// The relaxation length of small changes of slip about a motion, over the length of the patch; where that is none (a
/// falling slip curve, dashpots that answer at once), of those about v = 0.
fn relaxation<T, M, P>(patch: &Patch<T, M, P>, mean: Motion<T>) -> T
where
    T: Scalar,
    M: RateDependent<T>,
    P: Pressure<T>,
{
    let about = |slip_velocity: T| {
        let motion = Motion { slip_velocity, ..mean };
        // A phase of a thousandth in a transit: slow.
        let slow = mean.rolling_speed / patch.length() * lit(1e-3);
        let response = patch.linearised(motion).ok()?.by_slip_velocity(slow);
        let length = -response.im / (lit::<T>(1e-3) * response.re);
        // No bristle remembers more than a transit.
        (length > lit(1e-6) && length < T::one()).then_some(length)
    };
    about(mean.slip_velocity).or_else(|| about(T::zero())).unwrap_or_else(|| lit(1.0 / 3.0))
}

impl<T, M, P, S, W> Climb for RollingHistory<T, M, P, S, W>
where
    T: Scalar,
    M: RateDependent<T>,
    P: Pressure<T>,
    S: Signal<T>,
    W: Signal<T>,
{
    fn instants(&self) -> Instants {
        self.instants
    }

    fn scale(&self) -> f64 {
        to_f64(self.scale)
    }

    fn roundings(&self) -> f64 {
        64.0 * to_f64(T::default_epsilon()) * to_f64(self.scale)
    }

    fn looks(&self) -> f64 {
        // One or two evaluations for the slip curve, one for held steps, two for the fourth order or shorter held ones; and
        // some to spare.
        0.16
    }

    fn shows(&self, stride: usize, answers: usize) -> bool {
        let at = |answer: usize| walk::at(&self.motion, self.time(answer));
        between::shows(stride, answers, |answer| to_f64(at(answer).slip_velocity))
            && between::shows(stride, answers, |answer| to_f64(at(answer).rolling_speed))
    }

    fn candidates(&self) -> Vec<Candidate> {
        let candidate = |rung, integrator, top| Candidate {
            rung,
            integrator,
            top,
            step_weight: 0.0,
            answer_weight: 0.0,
            step_evaluations: 0.0,
            answer_evaluations: 0.0,
            order: 2.0,
        };
        let mut candidates = alloc::vec![
            Candidate {
                answer_weight: weight::SLIP_CURVE,
                answer_evaluations: 1.0,
                ..candidate(Rung::SlipCurve, Integrator::Evaluation, false)
            },
            Candidate {
                step_weight: weight::SLIP_CURVE + weight::RELAXATION,
                step_evaluations: 1.0,
                ..candidate(Rung::RelaxationLength, Integrator::Ramp, false)
            },
        ];
        let patch = |integrator, step_weight| Candidate {
            step_weight,
            answer_weight: weight::PATCH_FORCE,
            step_evaluations: 1.0,
            answer_evaluations: 1.0,
            ..candidate(Rung::Patch, integrator, true)
        };
        if self.exact.is_some() {
            let parts = self.span(Integrator::Gauss).1 as f64;
            candidates.push(patch(Integrator::Hold, weight::PATCH_HOLD));
            candidates.push(Candidate {
                step_evaluations: 2.0 * parts,
                order: 4.0,
                ..patch(Integrator::Gauss, parts * weight::PATCH_GAUSS)
            });
        } else {
            for cells in CELLS {
                let weight = weight::GRID_STEP + weight::GRID_CELL * cells as f64;
                candidates.push(patch(Integrator::Grid { cells }, weight));
            }
        }
        candidates
    }

    fn bound(&self, stride: usize, strides: usize) -> Result<Bound, FidelityError> {
        super::look::bound(self, stride, strides).map_err(FidelityError::from)
    }

    fn run(
        &self,
        plan: &Candidate,
        pace: Pace,
        strides: usize,
        cache: &Cache,
    ) -> Result<Run, FidelityError> {
        match plan.rung {
            Rung::SlipCurve => {
                let mut run = Run { outputs: Vec::with_capacity(strides), evaluations: 0.0 };
                for index in 1..=strides {
                    let intervals = index * pace.stride;
                    let value = match cache.at(intervals) {
                        Some(cached) => cached.lowest,
                        None => {
                            run.evaluations += 1.0;
                            to_f64(self.looks_at(self.time(intervals))?.force)
                        }
                    };
                    let spread = cache.at(intervals).map_or(0.0, |cached| cached.spread);
                    run.outputs.push(Output { value, memory: value, spread });
                }
                Ok(run)
            }
            Rung::RelaxationLength => Ok(self.relax(pace, strides, cache)?),
            _ => {
                let walked = self.rolled(plan.integrator, pace, 1..=strides)?;
                let mut run = self.outputs(cache, pace.stride, &walked.gathered)?;
                run.evaluations += walked.evaluations;
                Ok(run)
            }
        }
    }

    fn trace(
        &self,
        stride: usize,
        strides: usize,
        _norm: Norm,
        accuracy: f64,
        budget: f64,
        cache: &Cache,
    ) -> Result<Trace, FidelityError> {
        let pace = |substeps| Pace { stride, substeps };
        let first = self.rolled(Integrator::Hold, pace(1), 1..=strides)?;
        let mut evaluations = first.evaluations;
        let parts = self.parts(self.instants.interval * stride as f64);
        // Where a transit is no more than a few answers, it takes many steps of fourth order, and few answers are in need of
        // it; each can be refined by itself.
        let long = parts > 1;
        let (integrator, substeps) =
            if long { (Integrator::Hold, 2) } else { (Integrator::Gauss, 1) };
        let second = self.rolled(integrator, pace(substeps), 1..=strides)?;
        evaluations += second.evaluations;
        let better = if long { HALVED } else { BETTER };
        let mut fine = second.gathered.clone();
        let off = |a: T, b: T, index: usize| {
            let by = cache.at((index + 1) * stride).map_or(f64::INFINITY, |c| c.by_memory);
            let off = by * to_f64((a - b).abs());
            // NaN is no small difference.
            if off.is_nan() { f64::INFINITY } else { off }
        };
        let mut errors: Vec<f64> = (fine.iter().zip(&first.gathered).enumerate())
            .map(|(index, (a, b))| off(*a, *b, index) / better)
            .collect();
        // Two runs that both step over what happens agree on nothing.
        for (error, cached) in errors.iter_mut().zip(&cache.entries) {
            if cached.steep {
                *error = f64::INFINITY;
            }
        }
        let mut runs = alloc::vec![
            (Integrator::Hold, 1, first.gathered),
            (integrator, substeps, second.gathered),
        ];
        let mut substeps = if long { 1 } else { 2 };
        loop {
            let again: Vec<usize> = (errors.iter().zip(1..))
                .filter(|(error, _)| !(**error <= accuracy))
                .map(|(_, answer)| answer)
                .collect();
            let met = again.is_empty();
            let answers = if long { again } else { (1..=strides).collect() };
            let price = (2 * parts * answers.len() * substeps) as f64;
            if met || evaluations + price > budget || substeps > FINEST {
                break;
            }
            let finer = self.rolled(Integrator::Gauss, pace(substeps), answers.iter().copied())?;
            evaluations += finer.evaluations;
            for (answer, gathered) in answers.iter().zip(&finer.gathered) {
                let index = answer - 1;
                if let (Some(fine), Some(error)) = (fine.get_mut(index), errors.get_mut(index)) {
                    // A first one of fourth order in place of an unknown error is not known any better.
                    let unknown = long && substeps == 1 && !error.is_finite();
                    let difference = off(*fine, *gathered, index) / BETTER;
                    *error = if unknown { f64::INFINITY } else { difference };
                    *fine = *gathered;
                }
            }
            if answers.len() == strides {
                runs.push((Integrator::Gauss, substeps, finer.gathered));
            }
            substeps *= 2;
        }
        let uncertainty =
            errors.iter().fold(0.0, |most: f64, e| if *e <= most { most } else { *e });
        let mut run = self.outputs(cache, stride, &fine)?;
        run.evaluations += evaluations;
        let known = if self.exact.is_some() {
            let mut known = Vec::with_capacity(runs.len());
            for (integrator, substeps, gathered) in runs {
                known.push((integrator, substeps, self.outputs(cache, stride, &gathered)?.outputs));
            }
            Some(Known { runs: known })
        } else {
            None
        };
        Ok(Trace { run, uncertainty, known })
    }
}
