//! The climb: candidates from the cheapest on, each tried on a short pilot, until one is good enough.

use alloc::vec::Vec;

use super::report::{
    Choice, Evidence, FidelityError, Integrator, Norm, Plan, Quantity, Rung, Tolerance, Trial,
    Verdict,
};

/// Evaluations that a pilot may always spend.
const FREE_EVALUATIONS: f64 = 2000.0;
/// Share of a full run at the top rung that it may spend.
const PILOT_SHARE: f64 = 0.05;
/// What a measured error must stay below, as a share of the tolerance: the pilot sees some instants, not
/// all, and its reference has an error of its own, which is added.
const MARGIN: f64 = 0.85;
/// The same where every answer of the scene was looked at: the error of the reference is added already.
const SEEN_MARGIN: f64 = 0.97;
/// The same for an error that was not seen but foreseen from longer steps.
const FORESEEN: f64 = 0.4;
/// A tested step that is not at least this much better than the one before is held up by the model.
const STALLED: f64 = 0.8;
/// Error of the reference, as a share of the tolerance.
pub(super) const ACCURACY: f64 = 0.05;
/// Instants of a first look at a period.
const COARSE: usize = 24;
/// Λ after which a disturbance is taken to be forgotten: e^−14 = 8e-7 of it are left.
const FORGOTTEN: f64 = 14.0;
/// Errors that may be so much larger where the pilot does not look are not measured by it.
const MOST_HIDDEN: f64 = 3.0;
/// Steps, in place of one, that tell whether a model does at all.
const FINE: usize = 32;
/// Steps between two answers up to which a reference above FrBD may stall: until they tell when a tip breaks away.
const SETTLING: usize = 8;
/// Most steps between two answers.
const MOST_SUBSTEPS: usize = 1 << 12;
/// The same of a plan that is carried out: a look with shorter steps tells whether a model does at all, and is
/// among the trials.
pub(super) const MOST_STEPS: usize = 256 * MOST_SUBSTEPS;

/// When a scene wants answers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Instants {
    /// Time between two answers [s].
    pub(super) interval: f64,
    /// Number of answers.
    pub(super) count: usize,
    /// Answers in a period, if the scene repeats itself.
    pub(super) period: Option<usize>,
    /// After so many answers, one period of which is the last, nothing new comes: a scene that forgets all.
    pub(super) settled: Option<usize>,
}

impl Instants {
    /// What the pilot looks at: two periods, or everything.
    pub(super) fn window(&self) -> usize {
        if let Some(settled) = self.settled {
            return if settled < self.count { settled } else { self.count };
        }
        match self.period {
            Some(period) if 2 * period < self.count => 2 * period,
            _ => self.count,
        }
    }
}

/// An answer, and what the scene remembers, both in the unit of the answer.
#[derive(Debug, Clone, Copy)]
pub(super) struct Output {
    pub(super) value: f64,
    pub(super) memory: f64,
    /// By how much the value may be another one by the last digits of the velocity alone.
    pub(super) spread: f64,
}

/// A grid of the pilot: an answer each so many intervals, with so many steps in between.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pace {
    pub(super) stride: usize,
    pub(super) substeps: usize,
}

/// What a rung was found to cost and to give.
pub(super) struct Run {
    pub(super) outputs: Vec<Output>,
    pub(super) evaluations: f64,
}

/// The reference on the pilot's grid.
pub(super) struct Trace {
    pub(super) run: Run,
    /// Error of the reference itself.
    pub(super) uncertainty: f64,
    /// Runs of the reference that it was found by, if they are candidates too.
    pub(super) known: Option<Known>,
}

/// Runs at one stride: with so many steps each.
pub(super) struct Known {
    pub(super) runs: Vec<(Integrator, usize, Vec<Output>)>,
}

/// A bound on the lowest rung's error at each instant, what is forgotten in the window, what it cost.
pub(super) struct Bound {
    pub(super) errors: Option<Vec<f64>>,
    /// Λ from the start to each instant: e^−Λ of a disturbance is left.
    pub(super) relaxation: Vec<f64>,
    /// The largest relaxation rate met [1/s].
    pub(super) fastest_rate: f64,
    pub(super) evidence: Evidence,
    pub(super) cache: Cache,
    pub(super) evaluations: f64,
}

/// What the first look at the instants of the pilot leaves for later: at each stride the lumped model's
/// force by its memory, the force without it, and the force of the lowest rung.
#[derive(Debug, Clone, Default)]
pub(super) struct Cache {
    pub(super) stride: usize,
    pub(super) entries: Vec<Cached>,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Cached {
    pub(super) by_memory: f64,
    pub(super) without: f64,
    pub(super) lowest: f64,
    pub(super) spread: f64,
    /// Whether much may happen within the stride before it that neither of its ends shows.
    pub(super) steep: bool,
}

impl Cached {
    /// The answer of the lumped model with a memory.
    pub(super) fn with(&self, memory: f64) -> Output {
        Output { value: self.by_memory * memory + self.without, memory, spread: 0.0 }
    }
}

impl Cache {
    /// The entry for an answer after so many intervals.
    pub(super) fn at(&self, intervals: usize) -> Option<&Cached> {
        if self.stride == 0 || !intervals.is_multiple_of(self.stride) {
            return None;
        }
        self.entries.get((intervals / self.stride).checked_sub(1)?)
    }
}

/// A way to answer.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    pub(super) rung: Rung,
    pub(super) integrator: Integrator,
    /// Whether this is the reference, true but for its steps.
    pub(super) top: bool,
    /// Weighted right-hand sides for each step, and for each answer.
    pub(super) step_weight: f64,
    pub(super) answer_weight: f64,
    /// Evaluations of the friction model for each step, and for each answer.
    pub(super) step_evaluations: f64,
    pub(super) answer_evaluations: f64,
    /// The order at which its error falls with the step at best.
    pub(super) order: f64,
}

impl Candidate {
    /// Of an answer after so many steps.
    pub(super) fn weight(&self, substeps: usize) -> f64 {
        self.step_weight * substeps as f64 + self.answer_weight
    }

    /// Of an answer after so many steps.
    pub(super) fn evaluations(&self, substeps: usize) -> f64 {
        self.step_evaluations * substeps as f64 + self.answer_evaluations
    }
}

/// What can be climbed.
pub(super) trait Climb {
    fn instants(&self) -> Instants;
    /// The unit of the tolerance.
    fn scale(&self) -> f64;
    /// What an answer may be off by roundings.
    fn roundings(&self) -> f64;
    /// Instants that a pilot can look at, as a share of the evaluations that it may spend.
    fn looks(&self) -> f64;
    /// The same for a scene that forgets so fast that wider looks would miss what happens between them.
    fn most_looks(&self) -> f64 {
        self.looks()
    }
    /// Whether instants after each so many answers tell what the velocity does up to the last of so many answers.
    fn shows(&self, stride: usize, answers: usize) -> bool;
    /// What a run would take, if that is known: what the pilot has looked at already costs nothing.
    fn price(&self, plan: &Candidate, pace: Pace) -> Option<f64> {
        let _ = (plan, pace);
        None
    }
    /// Candidates from the cheapest to the dearest; the last are the reference's.
    fn candidates(&self) -> Vec<Candidate>;
    /// Bound along so many strides.
    fn bound(&self, stride: usize, strides: usize) -> Result<Bound, FidelityError>;
    /// A rung over so many strides, an answer after each.
    fn run(
        &self,
        plan: &Candidate,
        pace: Pace,
        strides: usize,
        cache: &Cache,
    ) -> Result<Run, FidelityError>;
    /// The reference, with an error of about so much, at the price of so many evaluations at most.
    fn trace(
        &self,
        stride: usize,
        strides: usize,
        norm: Norm,
        accuracy: f64,
        budget: f64,
        cache: &Cache,
    ) -> Result<Trace, FidelityError>;
}

/// Strides that divide each other and the window, the widest first, one last.
fn strides(instants: &Instants, window: usize) -> Vec<usize> {
    let mut chain = Vec::new();
    // Phases of a period are compared with each other.
    let whole = instants.period.filter(|period| *period < window);
    let mut stride = whole.unwrap_or_else(|| {
        let mut power = 1;
        while 2 * power <= window {
            power *= 2;
        }
        power
    });
    // The large factors first, so that the last strides lie close to each other.
    let mut factors = Vec::new();
    let (mut rest, mut prime) = (stride, 2);
    while rest > 1 {
        if rest.is_multiple_of(prime) {
            rest /= prime;
            factors.push(prime);
        } else if prime * prime > rest {
            prime = rest;
        } else {
            prime += 1;
        }
    }
    chain.push(stride);
    for factor in factors.iter().rev() {
        stride /= factor;
        chain.push(stride);
    }
    chain
}

/// How far off a run is.
struct Errors<'a> {
    norm: Norm,
    instants: &'a Instants,
    window: usize,
    /// Where the window is one period and a part of the next: answers of that part.
    tail: Option<usize>,
    relaxation: f64,
    /// By how much an error between the instants looked at may exceed the one at the instant after it.
    hidden: f64,
}

impl Errors<'_> {
    /// The norm of errors at equally spaced instants of the window.
    fn norm(&self, stride: usize, errors: &[f64]) -> f64 {
        let largest = errors.iter().fold(0.0_f64, |most, e| if *e <= most { most } else { *e });
        if self.norm == Norm::Greatest || !largest.is_finite() {
            return largest * self.hidden;
        }
        let mean = |part: &[f64]| {
            let sum: f64 = part.iter().map(|e| e * e).sum();
            sum / part.len().max(1) as f64
        };
        let norm = match self.instants.period {
            Some(period)
                if self.instants.settled.is_some() && self.window < self.instants.count =>
            {
                // The beginning once, and its last period again and again: the last time in part, where it errs most.
                let beginning = errors.len().saturating_sub(period / stride);
                let (first, last) = errors.split_at(beginning);
                let sum = |part: &[f64]| part.iter().map(|e| e * e).sum::<f64>();
                let rest = (self.instants.count - beginning * stride) as f64 / period as f64;
                let all = sum(first) + ceil(rest) * sum(last);
                root(all * stride as f64 / self.instants.count as f64)
            }
            Some(period) if self.tail.is_some() => {
                // What follows is the tail and then again the first period behind its own start.
                let (first, tail) = errors.split_at((period / stride).min(errors.len()));
                let later = first.get(tail.len()..).unwrap_or(&[]);
                let sum: f64 = tail.iter().chain(later).map(|e| e * e).sum();
                let (first, last) = (mean(first), sum / first.len().max(1) as f64);
                self.over_periods(first, last, period)
            }
            Some(period) if self.window < self.instants.count => {
                // Any period may be the worse one; and the last may be cut short where it errs most.
                let half = (period / stride).min(errors.len());
                let (first, last) = errors.split_at(half);
                self.over_periods(mean(first), mean(last), period)
            }
            _ => root(mean(errors)),
        };
        norm * self.hidden
    }

    /// The root mean square over all periods from the mean squares of the first and of a later one. What the
    /// later ones still change is `drift`.
    fn over_periods(&self, first: f64, later: f64, period: usize) -> f64 {
        let periods = self.instants.count as f64 / period as f64;
        let first = if first > later { first } else { later };
        root((first + (ceil(periods) - 1.0) * later) / periods)
    }

    /// What a difference of memories may still grow to in the periods that the pilot does not see: each
    /// adds what the last one seen did, as far as it is not forgotten.
    fn drift(&self, stride: usize, memory: impl Fn(usize) -> f64) -> f64 {
        let Some(period) = self.instants.period else { return 0.0 };
        let settled = self.tail.is_some() || self.instants.settled.is_some();
        if self.window >= self.instants.count || settled {
            return 0.0;
        }
        let at = |answers: usize| memory(answers / stride - 1);
        let change = at(2 * period) - at(period);
        let change = if change < 0.0 { -change } else { change };
        let kept = nalgebra::ComplexField::exp(-0.5 * self.relaxation);
        let rest = ceil(self.instants.count as f64 / period as f64) - 2.0;
        // Half as much again: two models forget at slightly different rates.
        let geometric = 1.5 * kept / (1.0 - kept);
        change * if geometric < rest { geometric } else { rest }
    }
}

/// One line for each plan: what was found last.
fn note(trials: &mut Vec<Trial>, trial: Trial) {
    let name = |plan: &Plan| (plan.rung, plan.integrator, plan.substeps);
    trials.retain(|other| name(&other.plan) != name(&trial.plan));
    trials.push(trial);
}

/// By how much what decays by a relaxation may have been larger before.
fn hides(relaxation: f64) -> f64 {
    super::exp(if relaxation < 40.0 { relaxation } else { 40.0 })
}

/// By what share the lumped model and one of a constant coefficient and no damping may differ: in the coefficient
/// μ, and in the drive r = μ/g.
fn difference(cache: &Cache) -> f64 {
    let (mut least, mut most, mut drive) = (f64::INFINITY, 0.0_f64, 1.0_f64);
    for entry in &cache.entries {
        let force = if entry.lowest < 0.0 { -entry.lowest } else { entry.lowest };
        // At v = 0 the curve has no sign, and no force.
        if force > 0.0 {
            least = if force < least { force } else { least };
            most = if force > most { force } else { most };
        }
        drive = if entry.by_memory < drive { entry.by_memory } else { drive };
    }
    if most > 0.0 && drive > 0.0 { most / least - 1.0 + 1.0 / drive - 1.0 } else { 1.0 }
}

fn root(value: f64) -> f64 {
    nalgebra::ComplexField::sqrt(value)
}

fn ceil(value: f64) -> f64 {
    nalgebra::ComplexField::ceil(value)
}

/// Finds the cheapest plan that meets the tolerance.
pub(super) fn choose<S: Climb>(
    scene: &S,
    tolerance: Tolerance,
    most_evaluations: Option<f64>,
) -> Result<Choice, FidelityError> {
    let instants = scene.instants();
    let looks = scene.looks();
    let (mut window, mut tail) = (instants.window(), None);
    let allowed = tolerance.share * scene.scale();
    let candidates = scene.candidates();
    let top = candidates.iter().filter(|c| c.top).map(|c| c.evaluations(1));
    let top = top.fold(f64::INFINITY, f64::min);
    let share = PILOT_SHARE * top * instants.count as f64;
    let default = if share > FREE_EVALUATIONS { share } else { FREE_EVALUATIONS };
    let budget = most_evaluations.unwrap_or(default);
    let mut spent = 0.0;
    // Where a period forgets what came before, one will do, and the beginning of the next.
    let repeats = instants.period.filter(|period| *period < window && instants.settled.is_none());
    if let Some(period) = repeats {
        let chain = strides(&instants, window);
        let coarse = chain.iter().find(|stride| {
            **stride == 1 || period / **stride >= COARSE && scene.shows(**stride, period)
        });
        let affordable = |stride: &usize| (period / stride) as f64 <= scene.most_looks() * budget;
        if let Some(stride) = coarse.copied().filter(affordable) {
            let bound = scene.bound(stride, period / stride)?;
            spent += bound.evaluations;
            let forgotten = bound.relaxation.iter().position(|relaxation| *relaxation >= FORGOTTEN);
            let all = bound.relaxation.last().copied().unwrap_or(0.0);
            if let Some(index) = forgotten.filter(|_| all >= 2.0 * FORGOTTEN) {
                let answers = (index + 2) * stride;
                if period + answers < window {
                    tail = Some(answers);
                    window = period + answers;
                }
            }
        }
    }
    let chain = strides(&instants, window);
    let within = |stride: usize| match instants.settled {
        // The last period whole.
        Some(_) => window.div_ceil(stride).min(instants.count / stride),
        None => window / stride,
    };
    let mut trials = Vec::new();
    let seconds = instants.interval;
    let plan = |candidate: &Candidate, pace: Pace| Plan {
        rung: candidate.rung,
        integrator: candidate.integrator,
        step: instants.interval / pace.substeps as f64,
        substeps: pace.substeps,
        cost_rate: candidate.weight(pace.substeps) / seconds,
    };
    // The finest stride that fits, or finer: phases of a period are compared with each other, so that one of many
    // answers and few factors has few strides; and what happens between two instants of a pilot must show.
    let fits = |stride: usize, looks: f64| (window / stride) as f64 <= looks * budget;
    let cycle = instants.period.map_or(window, |period| period.min(window));
    let shows = |stride: usize| {
        let answers = window.max(within(stride) * stride);
        stride == 1 || cycle / stride >= COARSE && scene.shows(stride, answers)
    };
    let finest = chain.partition_point(|stride| fits(*stride, looks)).saturating_sub(1);
    let mut stride = chain.iter().skip(finest).copied().find(|s| shows(*s)).unwrap_or(1);
    if !fits(stride, scene.most_looks()) {
        return Err(FidelityError::PilotTooShort {
            needed: spent + (window / stride) as f64 / looks,
            allowed: budget,
        });
    }
    let finest = scene.roundings();
    if let Some(top) = candidates.last().filter(|_| ACCURACY * allowed < finest) {
        let plan = plan(top, Pace { stride: 1, substeps: 1 });
        let error = finest / ACCURACY;
        let quantity = Quantity::Force;
        return Err(FidelityError::OutOfReach {
            quantity,
            allowed,
            error,
            plan,
            evaluations: spent,
        });
    }

    // What costs nothing but the curve at some instants: a bound.
    let mut bound = scene.bound(stride, within(stride))?;
    spent += bound.evaluations;
    let between = |rate: f64, stride: usize| rate * instants.interval * (stride - 1) as f64;
    while hides(between(bound.fastest_rate, stride)) > MOST_HIDDEN {
        let finer = chain.iter().copied().find(|finer| *finer < stride && shows(*finer));
        let Some(finer) = finer.filter(|finer| fits(*finer, scene.most_looks())) else { break };
        stride = finer;
        bound = scene.bound(stride, within(stride))?;
        spent += bound.evaluations;
    }
    let count = within(stride);
    let window = if instants.settled.is_some() { count * stride } else { window };
    let finish =
        |plan: Plan, error: f64, verdict: Verdict, trials: Vec<Trial>, spent: f64| Choice {
            quantity: Quantity::Force,
            plan,
            error,
            verdict,
            evidence: bound.evidence,
            tolerance,
            allowed,
            trials,
            pilot_evaluations: spent,
            pilot_budget: budget,
            seen: window as f64 / instants.count as f64,
        };
    // A run of the reference beside what was spent.
    let at_least = || budget + top * count as f64;
    let hidden = hides(between(bound.fastest_rate, stride));
    let margin = if window >= instants.count && stride == 1 { SEEN_MARGIN } else { MARGIN };
    let errors = Errors {
        norm: tolerance.norm,
        instants: &instants,
        window,
        tail,
        relaxation: bound.relaxation.last().copied().unwrap_or(0.0),
        hidden,
    };
    if hidden > MOST_HIDDEN {
        return Err(FidelityError::PilotTooShort {
            needed: window as f64 / looks,
            allowed: budget,
        });
    }
    let one = Pace { stride, substeps: 1 };
    if let (Some(bounds), Some(lowest)) = (&bound.errors, candidates.first()) {
        let error = errors.norm(stride, bounds);
        let drift = errors.drift(stride, |index| bounds.get(index).copied().unwrap_or(f64::NAN));
        let error = error + drift;
        let met = error <= allowed;
        let plan = plan(lowest, one);
        note(&mut trials, Trial { plan, error, verdict: Verdict::Proved, met });
        if met {
            return Ok(finish(plan, error, Verdict::Proved, trials, spent));
        }
    }

    // The reference, once.
    let rest = 0.9 * (budget - spent);
    if !(rest > 0.0) {
        return Err(FidelityError::PilotTooShort { needed: at_least(), allowed: budget });
    }
    let trace = scene
        .trace(stride, count, tolerance.norm, ACCURACY * allowed, rest, &bound.cache)
        .map_err(|error| match error {
            // Of its own part.
            FidelityError::PilotTooShort { needed, .. } => {
                FidelityError::PilotTooShort { needed: spent + needed / 0.9, allowed: budget }
            }
            other => other,
        })?;
    spent += trace.run.evaluations;
    // Nothing can be measured with a reference that is not known any better.
    if !(trace.uncertainty <= 0.5 * margin * allowed) {
        return Err(FidelityError::PilotTooShort { needed: at_least(), allowed: budget });
    }
    // While the reference itself still wanders from period to period it comes to states that the pilot has not
    // seen, and another model errs there by its share of the way: as far as coefficients and drives differ.
    let wander = errors.drift(stride, |index| {
        trace.run.outputs.get(index).map_or(f64::NAN, |output| output.memory)
    });
    let away = wander * if trace.known.is_some() { difference(&bound.cache) } else { 1.0 };
    let farthest = 2.0 * scene.scale();
    let measure = |run: &Run, pace: Pace, top: bool| {
        // Instants that both have.
        let (own, theirs) = if pace.stride >= stride {
            (1, pace.stride / stride)
        } else {
            (stride / pace.stride, 1)
        };
        let pairs: Vec<(Output, Output)> = run
            .outputs
            .iter()
            .skip(own - 1)
            .step_by(own)
            .zip(trace.run.outputs.iter().skip(theirs - 1).step_by(theirs))
            .map(|(a, b)| (*a, *b))
            .collect();
        let off: Vec<f64> = pairs
            .iter()
            .map(|(a, b)| {
                let off = a.value - b.value;
                a.spread + if off < 0.0 { -off } else { off }
            })
            .collect();
        let wide = pace.stride.max(stride);
        let drift = errors
            .drift(wide, |index| pairs.get(index).map_or(f64::NAN, |(a, b)| a.memory - b.memory));
        // NaN is no error to be content with.
        let error = errors.norm(wide, &off) + drift + if top { 0.0 } else { away };
        // No two forces are farther apart than both ends of their range.
        let error = if error > farthest { farthest } else { error };
        let missed = run.outputs.is_empty() || off.is_empty() || off.iter().any(|e| e.is_nan());
        if missed { f64::INFINITY } else { error }
    };

    // The runs that made the reference are on offer already.
    let mut ready: Option<(Plan, f64)> = None;
    if let Some(known) = &trace.known {
        for (integrator, substeps, outputs) in &known.runs {
            let same = |c: &&Candidate| c.top && c.integrator == *integrator;
            let Some(candidate) = candidates.iter().find(same) else { continue };
            let run = Run { outputs: outputs.clone(), evaluations: 0.0 };
            let error = measure(&run, one, candidate.top) + trace.uncertainty;
            // Steps of the same length on every interval.
            let shorter = substeps.div_ceil(stride);
            let plan = plan(candidate, Pace { stride: 1, substeps: shorter });
            let met = error <= margin * allowed;
            note(&mut trials, Trial { plan, error, verdict: Verdict::Measured, met });
            let cheaper =
                ready.is_none_or(|(other, _): (Plan, f64)| plan.cost_rate < other.cost_rate);
            if met && cheaper {
                ready = Some((plan, error));
            }
        }
    }

    let mut ways: Vec<Way> = candidates
        .iter()
        .map(|candidate| {
            let same = chain.iter().position(|s| *s == stride).unwrap_or(0);
            // Two trials tell a model that does not fit from steps that are too long.
            let priced = scene.price(candidate, one).is_some();
            let first = if candidate.top || candidate.rung.is_memoryless() || priced {
                same
            } else {
                same.saturating_sub(1)
            };
            let known = trials.iter().rev().find(|trial| {
                let plan = &trial.plan;
                trace.known.is_some()
                    && candidate.top
                    && (plan.rung, plan.integrator, plan.substeps)
                        == (candidate.rung, candidate.integrator, 1)
            });
            let mut way = Way {
                doubtful: priced && !candidate.top && !candidate.rung.is_memoryless(),
                candidate: *candidate,
                place: first,
                pace: pace_at(&chain, first),
                last: None,
            };
            if let Some(trial) = known {
                // It was tried at this stride.
                way.last = Some((way.pace, trial.error));
                way = next_way(way, &chain, margin * allowed);
            }
            way
        })
        .collect();
    let mut best: Option<(Plan, f64)> = None;
    let mut guess: Option<(Plan, f64)> = None;
    // Whether anything was left untried for want of means.
    let mut cut = false;
    loop {
        // The cheapest way that is still open; of two at one price, the simpler.
        let cost = |way: &Way| way.candidate.weight(way.pace.substeps);
        let mut next: Option<usize> = None;
        for (index, way) in ways.iter().enumerate() {
            let cheaper =
                next.and_then(|n| ways.get(n)).is_none_or(|other| cost(way) < cost(other));
            if cheaper {
                next = Some(index);
            }
        }
        let Some((index, mut way)) = next.and_then(|n| ways.get(n).map(|way| (n, *way))) else {
            break;
        };
        let rate = plan(&way.candidate, way.pace).cost_rate;
        if ready.is_some_and(|(other, _)| other.cost_rate <= rate) {
            break;
        }
        let strides = window / way.pace.stride;
        // The force of an answer is mostly known already.
        let known = way.candidate.rung != Rung::Reference && way.pace.stride >= stride;
        let answer = if known { 0.0 } else { way.candidate.answer_evaluations };
        let steps = way.candidate.step_evaluations * way.pace.substeps as f64;
        // Collocation splits steps at reversals.
        let splits = 8.0 * bound.evidence.reversals as f64 * steps.min(1.0);
        let expected = scene
            .price(&way.candidate, way.pace)
            .unwrap_or(strides as f64 * (steps + answer) + splits);
        if way.pace.substeps > MOST_SUBSTEPS {
            ways.remove(index);
            continue;
        }
        if spent + expected > budget {
            // Nothing left to try it with.
            cut = true;
            if ready.is_some() {
                ways.remove(index);
                continue;
            }
            // What the last trial says of this step, at first order: no
            // method here falls slower, even across reversals.
            let Some((pace, error)) = way.last else {
                ways.remove(index);
                continue;
            };
            let step = |p: Pace| p.stride as f64 / p.substeps as f64;
            let mut target = way.pace;
            let mut foreseen = error * step(target) / step(pace);
            while foreseen > FORESEEN * allowed && target.substeps <= MOST_SUBSTEPS {
                target = if target.stride > 1 {
                    Pace { stride: 1, substeps: 1 }
                } else {
                    Pace { stride: 1, substeps: target.substeps * 2 }
                };
                foreseen = error * step(target) / step(pace);
            }
            let converging = way.candidate.top;
            if converging && foreseen <= FORESEEN * allowed {
                let plan = plan(&way.candidate, target);
                if guess.is_none_or(|(other, _): (Plan, f64)| plan.cost_rate < other.cost_rate) {
                    guess = Some((plan, foreseen));
                }
            }
            ways.remove(index);
            continue;
        }
        if way.doubtful {
            let fine = Pace { substeps: FINE * way.pace.substeps, ..way.pace };
            let run = scene.run(&way.candidate, fine, strides, &bound.cache)?;
            spent += run.evaluations;
            let error = measure(&run, fine, false) + trace.uncertainty;
            let own = Pace { stride: 1, substeps: (fine.substeps / fine.stride).max(1) };
            let plan = plan(&way.candidate, own);
            let met = error <= margin * allowed;
            note(&mut trials, Trial { plan, error, verdict: Verdict::Measured, met });
            if met {
                if let Some(entry) = ways.get_mut(index) {
                    entry.doubtful = false;
                }
            } else {
                if best.is_none_or(|(_, least)| error < least) {
                    best = Some((plan, error));
                }
                ways.remove(index);
            }
            continue;
        }
        let run = scene.run(&way.candidate, way.pace, strides, &bound.cache)?;
        spent += run.evaluations;
        let error = measure(&run, way.pace, way.candidate.top) + trace.uncertainty;
        let plan = plan(&way.candidate, way.pace);
        let met = error <= margin * allowed;
        // A coarse look tells what fails, not what will do: errors may hide between its instants.
        let met = met && way.pace.stride <= stride;
        note(&mut trials, Trial { plan, error, verdict: Verdict::Measured, met });
        if met {
            return Ok(finish(plan, error, Verdict::Measured, trials, spent));
        }
        if best.is_none_or(|(_, least)| error < least) {
            best = Some((plan, error));
        }
        let stalled = match way.last {
            Some((_, before)) => error > margin * allowed && !(error <= STALLED * before),
            None => false,
        };
        // The reference is only ever held up by roundings, or by what a coarse step skips: where a look is
        // only taken where it matters, going on is cheap.
        let cheap = scene.price(&way.candidate, way.pace).is_some();
        let patience = if way.candidate.rung == Rung::Reference { SETTLING } else { 1 };
        let settling = way.candidate.top && way.pace.substeps <= patience;
        let hopeless = way.candidate.rung.is_memoryless() || (stalled && !cheap && !settling);
        if hopeless {
            ways.remove(index);
            continue;
        }
        way.last = Some((way.pace, error));
        if let Some(entry) = ways.get_mut(index) {
            *entry = next_way(way, &chain, margin * allowed);
        }
    }
    if let Some((plan, error)) = ready {
        return Ok(finish(plan, error, Verdict::Measured, trials, spent));
    }
    if let Some((plan, error)) = guess {
        let verdict = Verdict::Extrapolated;
        note(&mut trials, Trial { plan, error, verdict, met: true });
        return Ok(finish(plan, error, verdict, trials, spent));
    }
    if cut {
        return Err(FidelityError::PilotTooShort { needed: at_least(), allowed: budget });
    }
    let (plan, error) =
        best.ok_or(FidelityError::PilotTooShort { needed: window as f64 * top, allowed: budget })?;
    let quantity = Quantity::Force;
    Err(FidelityError::OutOfReach { quantity, allowed, error, plan, evaluations: spent })
}

/// A candidate with the step to try next, and what the last one gave.
#[derive(Debug, Clone, Copy)]
struct Way {
    /// Whether it is not known yet that the model does, with steps however short.
    doubtful: bool,
    candidate: Candidate,
    place: usize,
    pace: Pace,
    last: Option<(Pace, f64)>,
}

/// Down the strides to one, then up the substeps by powers of two.
fn pace_at(chain: &[usize], place: usize) -> Pace {
    match chain.get(place) {
        Some(stride) => Pace { stride: *stride, substeps: 1 },
        None => {
            let halvings = (place + 1 - chain.len()).min(20);
            Pace { stride: 1, substeps: 1 << halvings }
        }
    }
}

/// The step to try after one that missed: past those that would miss even if the error fell as fast as it can.
fn next_way(way: Way, chain: &[usize], enough: f64) -> Way {
    let step = |pace: Pace| pace.stride as f64 / pace.substeps as f64;
    let mut place = way.place + 1;
    let mut pace = pace_at(chain, place);
    if let Some((last, error)) = way.last {
        let falls = |pace: Pace| {
            let ratio: f64 = step(pace) / step(last);
            error * nalgebra::ComplexField::powf(ratio, way.candidate.order)
        };
        while last.stride == 1
            && falls(pace) > enough
            && step(last) < 8.0 * step(pace)
            && pace.substeps < MOST_SUBSTEPS
        {
            place += 1;
            pace = pace_at(chain, place);
        }
    }
    Way { place, pace, ..way }
}
