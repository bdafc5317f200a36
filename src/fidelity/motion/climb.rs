//! The climb of a mechanism: what costs nothing first, then a pilot, and else the reference under error control.

use alloc::vec::Vec;

use super::super::report::{
    Choice, Evidence, FidelityError, Integrator, Norm, Plan, Rung, Tolerance, Trial, Verdict,
};
use super::machine::{Run, Sample};
use super::{Motion, Way};
use crate::scalar::to_f64;
use crate::signal::Signal;
use crate::{Bristle, Law, Scalar};

/// Evaluations that a pilot may always spend.
const FREE_EVALUATIONS: f64 = 2000.0;
/// Share of a full run of the reference that it may spend.
const PILOT_SHARE: f64 = 0.05;
/// What a measured error must stay below, as a share of the tolerance.
const MARGIN: f64 = 0.8;
/// Share of the tolerance within which two runs of the reference have to agree before the tighter one counts as true.
const AGREED: f64 = 0.3;
/// Share of its means that the pilot spends on the first run of the reference: the second takes a third more.
const FIRST: f64 = 0.3;
/// Share of that difference that is taken for the error of the tighter one, whose tolerance is a tenth.
const TIGHTER: f64 = 0.5;
/// How much tighter error control is asked for than the error allowed where no pilot can tell. Positions: some four times the worst
/// of the work-precision charts. Velocities and forces jump in between the ends of steps: tuning found one force at thirty times that was missed.
const SAFETY: f64 = 300.0;
const SAFETY_OF_FAST: f64 = 1000.0;
/// A step that is not at least this much better than one four times as long is held up by the model.
const STALLED: f64 = 0.6;
/// The same where the reference itself is not known but to converge.
const CAUTIOUS: f64 = 0.5;
/// A difference this small, as a share of the tolerance, has converged.
const SMALL: f64 = 0.02;
/// Share of the window that error control has to have seen to vouch for longer steps.
const LEAST_SEEN: f64 = 0.02;
/// Error of a run in times its tolerance that is not held against a friction model's energy balance.
const LOOSE: f64 = 30.0;
/// Looser error control loses whole slips, and two such runs may agree on that.
const LEAST_DIGITS: u8 = 4;
/// Periods that the pilot looks at.
const PERIODS: usize = 3;
/// By how much drifts of later periods may exceed those seen.
const LATER: f64 = 1.5;
/// Most steps between two answers.
const MOST_SUBSTEPS: usize = 1 << 14;

/// The pilot's means.
struct Purse {
    spent: f64,
    budget: f64,
}

impl Purse {
    fn rest(&self) -> f64 {
        self.budget - self.spent
    }
}

/// What the applied force says before anything is run.
struct Survey {
    /// The largest of it \[N\].
    largest: f64,
    /// √(2E) that it can have given the mass by each answer \[√J\]: of a passive contact no more.
    gained: Vec<f64>,
}

fn root(value: f64) -> f64 {
    nalgebra::ComplexField::sqrt(value)
}

fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

pub(super) fn choose<T, M, D, F>(
    scene: &Motion<T, M, D, F>,
    tolerance: Tolerance,
    most_evaluations: Option<f64>,
) -> Result<Choice, FidelityError>
where
    T: Scalar,
    M: Bristle<T, Deflection = T>,
    D: Signal<T>,
    F: Signal<T>,
{
    let climb = Climb { scene, tolerance, allowed: tolerance.share * to_f64(scene.scale) };
    climb.choose(most_evaluations)
}

struct Climb<'a, T: Scalar, M, D, F> {
    scene: &'a Motion<T, M, D, F>,
    tolerance: Tolerance,
    allowed: f64,
}

impl<T, M, D, F> Climb<'_, T, M, D, F>
where
    T: Scalar,
    M: Bristle<T, Deflection = T>,
    D: Signal<T>,
    F: Signal<T>,
{
    fn choose(&self, most_evaluations: Option<f64>) -> Result<Choice, FidelityError> {
        let scene = self.scene;
        let mut purse = Purse { spent: 0.0, budget: most_evaluations.unwrap_or(FREE_EVALUATIONS) };
        let survey = self.survey();
        let mut trials = Vec::new();
        if let Some(error) = self.stuck_bound(&survey) {
            let way = Way { rung: Rung::StaticCurve, integrator: Integrator::Implicit };
            let met = error <= self.allowed;
            let plan = scene.plan(way, 1, super::weight::SLIDE);
            trials.push(Trial { plan, error, verdict: Verdict::Proved, met });
            if met {
                let none = Evidence {
                    slowest: 0.0,
                    fastest: 0.0,
                    reversals: 0,
                    lag: 0.0,
                    presliding: f64::INFINITY,
                    stuck_share: 1.0,
                    relaxation: 0.0,
                    transits: None,
                };
                return Ok(self.finish(plan, error, Verdict::Proved, none, trials, &purse, 0));
            }
        }
        let window = match scene.period {
            Some(period) if PERIODS * period < scene.answers => PERIODS * period,
            _ => scene.answers,
        };

        // The reference at two tolerances, until they agree.
        let mut digits = self.first_digits();
        let most_digits = scene.most_digits();
        let mut last = self.adaptive(digits, window, FIRST * purse.rest())?;
        purse.spent += last.evaluations;
        self.check_energy(&last, digits, &survey)?;
        if most_evaluations.is_none() {
            // A full run of the reference is known now, or foreseen.
            let all = last.evaluations * scene.answers as f64 / last.samples.len().max(1) as f64;
            purse.budget = larger(purse.budget, PILOT_SHARE * all);
            if last.samples.len() < window && FIRST * purse.rest() > 1.5 * last.evaluations {
                last = self.adaptive(digits, window, FIRST * purse.rest())?;
                purse.spent += last.evaluations;
                self.check_energy(&last, digits, &survey)?;
            }
        }
        if last.samples.len() < window {
            if let Some(choice) = self.by_agreement(&last, window, &mut trials, &mut purse)? {
                return Ok(choice);
            }
            return self.rest_on_error_control(digits, &last, trials, purse);
        }
        let (truth, uncertainty, mut best) = loop {
            let tighter = digits + 1;
            if tighter > most_digits {
                let plan = self.adaptive_plan(digits, &last);
                return Err(FidelityError::OutOfReach {
                    quantity: scene.quantity,
                    allowed: self.allowed,
                    error: trials.last().map_or(f64::INFINITY, |trial| trial.error),
                    plan,
                    evaluations: purse.spent,
                });
            }
            if 1.2 * last.evaluations > purse.rest() {
                if let Some(choice) = self.by_agreement(&last, window, &mut trials, &mut purse)? {
                    return Ok(choice);
                }
                return self.rest_on_error_control(digits, &last, trials, purse);
            }
            let run = self.adaptive(tighter, window, purse.rest())?;
            purse.spent += run.evaluations;
            if run.samples.len() < window {
                return self.rest_on_error_control(digits, &last, trials, purse);
            }
            let error = self.error(&last, &run);
            let plan = self.adaptive_plan(digits, &last);
            let met = error <= AGREED * self.allowed;
            trials.push(Trial { plan, error, verdict: Verdict::Measured, met });
            if met {
                break (run, TIGHTER * error, (plan, error));
            }
            digits = tighter;
            last = run;
        };
        self.check_energy(&truth, digits, &survey)?;
        if self.balances(&truth) {
            // Error control would have to be told to shake it.
            return Err(FidelityError::PilotTooShort {
                needed: 10.0 * purse.spent,
                allowed: purse.budget,
            });
        }
        if window < scene.answers && !self.is_settled(&truth) {
            return self.rest_on_error_control(digits, &last, trials, purse);
        }

        // What is cheaper than that.
        for way in Motion::<T, M, D, F>::ways() {
            self.try_steps(way, &truth, uncertainty, &mut purse, &mut trials, &mut best)?;
        }
        let evidence = self.evidence(&truth);
        Ok(self.finish(best.0, best.1, Verdict::Measured, evidence, trials, &purse, window))
    }

    /// Tries a rung with shorter and shorter steps, until it will do or costs more than what is known to do.
    fn try_steps(
        &self,
        way: Way,
        truth: &Run,
        uncertainty: f64,
        purse: &mut Purse,
        trials: &mut Vec<Trial>,
        best: &mut (Plan, f64),
    ) -> Result<(), FidelityError> {
        let scene = self.scene;
        let window = truth.samples.len();
        let interval = to_f64(scene.interval);
        let mut substeps = 1_usize;
        let mut before: Option<(usize, f64)> = None;
        while substeps <= MOST_SUBSTEPS {
            let expected = Motion::<T, M, D, F>::step_cost(way) * substeps as f64 / interval;
            // Sliding less than all the time the static curve is cheaper than that.
            let least = if way.rung == Rung::StaticCurve {
                super::weight::SLIDE * substeps as f64 / interval
            } else {
                expected
            };
            let forces = if scene.quantity == super::Quantity::Force { window } else { 0 };
            if least >= best.0.cost_rate || (window * substeps + forces) as f64 > purse.rest() {
                break;
            }
            let run = scene.run(way, substeps, window, f64::INFINITY)?;
            purse.spent += run.evaluations;
            let error = self.error(&run, truth) + uncertainty;
            let plan = scene.plan(way, substeps, run.cost / window as f64);
            let met = error <= MARGIN * self.allowed;
            trials.push(Trial { plan, error, verdict: Verdict::Measured, met });
            if met {
                if plan.cost_rate < best.0.cost_rate {
                    *best = (plan, error);
                }
                break;
            }
            if let Some((fewer, worse)) = before {
                if substeps >= 4 * fewer && !(error <= STALLED * worse) {
                    break;
                }
                if substeps >= 4 * fewer {
                    before = Some((substeps, error));
                }
            } else {
                before = Some((substeps, error));
            }
            // No method here is better than second order.
            let ratio = root(error / self.allowed);
            substeps *= if ratio >= 8.0 { 4 } else { 2 };
        }
        Ok(())
    }

    #[allow(clippy::too_many_arguments, reason = "each is a field of the answer")]
    fn finish(
        &self,
        plan: Plan,
        error: f64,
        verdict: Verdict,
        evidence: Evidence,
        trials: Vec<Trial>,
        purse: &Purse,
        window: usize,
    ) -> Choice {
        Choice {
            quantity: self.scene.quantity,
            plan,
            error,
            verdict,
            evidence,
            tolerance: self.tolerance,
            allowed: self.allowed,
            trials,
            pilot_evaluations: purse.spent,
            pilot_budget: purse.budget,
            seen: window as f64 / self.scene.answers as f64,
        }
    }

    fn adaptive(&self, digits: u8, answers: usize, most: f64) -> Result<Run, FidelityError> {
        let way = Way { rung: Rung::Reference, integrator: Integrator::Adaptive { digits } };
        self.scene.run(way, 1, answers, most)
    }

    fn adaptive_plan(&self, digits: u8, run: &Run) -> Plan {
        let way = Way { rung: Rung::Reference, integrator: Integrator::Adaptive { digits } };
        let answers = run.samples.len().max(1) as f64;
        self.scene.plan(way, 1, run.cost / answers)
    }

    /// What the tolerance is in the unit in which error control counts.
    fn relative(&self, furthest: f64) -> f64 {
        use super::Quantity;
        let scales = &self.scene.scales;
        let unit = match self.scene.quantity {
            Quantity::Force => to_f64(self.scene.dry.breakaway),
            Quantity::Position => larger(to_f64(scales[0]), furthest),
            Quantity::Velocity => larger(to_f64(scales[1]), furthest),
        };
        self.allowed / unit
    }

    fn first_digits(&self) -> u8 {
        let relative = self.relative(0.0);
        digits_of(relative).clamp(LEAST_DIGITS, self.scene.most_digits() - 1)
    }

    /// Where error control cannot see all of the window: passive steps of three lengths that converge over all of it, and to
    /// what error control has seen. Cheaper rungs are compared with the finest.
    fn by_agreement(
        &self,
        prefix: &Run,
        window: usize,
        trials: &mut Vec<Trial>,
        purse: &mut Purse,
    ) -> Result<Option<Choice>, FidelityError> {
        let scene = self.scene;
        let part = prefix.samples.len();
        let way = Way { rung: Rung::Reference, integrator: Integrator::Companion };
        let answer = if scene.quantity == super::Quantity::Force { 2.0 } else { 1.0 };
        let size = window as f64;
        if (part as f64) < LEAST_SEEN * size || size * (1.0 + 2.0 * answer) > purse.rest() {
            return Ok(None);
        }
        let mut runs: Vec<(usize, Run)> = Vec::new();
        let (mut substeps, mut agreed) = (1_usize, None);
        let mut before = f64::INFINITY;
        while size * (substeps as f64 + answer - 1.0) <= purse.rest() {
            let run = scene.run(way, substeps, window, f64::INFINITY)?;
            purse.spent += run.evaluations;
            if let Some((_, coarser)) = runs.last() {
                let off = self.error(coarser, &run);
                let converges = off <= 0.5 * before || off <= SMALL * self.allowed;
                let enough = runs.len() >= 2 || off <= SMALL * self.allowed;
                if off <= 0.1 * self.allowed && converges && enough {
                    agreed = Some(off);
                }
                before = off;
            }
            runs.push((substeps, run));
            if agreed.is_some() {
                break;
            }
            substeps *= 2;
        }
        let (Some(off), Some((_, finest))) = (agreed, runs.last()) else { return Ok(None) };
        let seen = self.error_of(&finest.samples, &prefix.samples);
        if !(seen <= 0.2 * self.allowed) || (window < scene.answers && !self.is_settled(finest)) {
            return Ok(None);
        }
        // What the finest may still be off by.
        let uncertainty = larger(2.0 * off, seen);
        let still = Way { rung: Rung::StaticCurve, integrator: Integrator::Implicit };
        let mut all: Vec<(Way, usize, &Run)> =
            runs.iter().map(|(substeps, run)| (way, *substeps, run)).collect();
        let rest;
        if size * answer <= purse.rest() {
            rest = scene.run(still, 1, window, f64::INFINITY)?;
            purse.spent += rest.evaluations;
            all.push((still, 1, &rest));
        }
        let mut best: Option<(Plan, f64)> = None;
        for (way, substeps, run) in all {
            let error = self.error(run, finest) + uncertainty;
            let plan = scene.plan(way, substeps, run.cost / size);
            let met = error <= CAUTIOUS * self.allowed;
            trials.push(Trial { plan, error, verdict: Verdict::Extrapolated, met });
            if met && best.is_none_or(|(other, _)| plan.cost_rate < other.cost_rate) {
                best = Some((plan, error));
            }
        }
        let Some((plan, error)) = best else { return Ok(None) };
        let evidence = self.evidence(finest);
        let trials = core::mem::take(trials);
        Ok(Some(self.finish(plan, error, Verdict::Extrapolated, evidence, trials, purse, window)))
    }

    /// Where no pilot is long enough: the reference, with a tolerance tighter by a factor, and by what two runs over the
    /// part that was seen differ, had their difference grown ever since.
    fn rest_on_error_control(
        &self,
        digits: u8,
        run: &Run,
        mut trials: Vec<Trial>,
        mut purse: Purse,
    ) -> Result<Choice, FidelityError> {
        let scene = self.scene;
        let seen = |sample: &Sample| match scene.quantity {
            super::Quantity::Velocity => sample.velocity,
            _ => sample.position,
        };
        let furthest = run.samples.iter().fold(0.0, |most, s| larger(most, seen(s).abs_value()));
        let safety =
            if scene.quantity == super::Quantity::Position { SAFETY } else { SAFETY_OF_FAST };
        let mut tight = digits_of(self.relative(furthest) / safety).max(LEAST_DIGITS + 1);
        let part = run.samples.len();
        let own = trials.iter().rev().find(|trial| trial.verdict == Verdict::Measured);
        let mut measured = own.map(|trial| trial.error);
        if measured.is_none() && part > 0 && 1.1 * run.evaluations < purse.rest() {
            let tighter = (digits + 1).min(scene.most_digits());
            let other = self.adaptive(tighter, part, purse.rest())?;
            purse.spent += other.evaluations;
            let short = Run { samples: run.samples.clone(), evaluations: 0.0, cost: 0.0 };
            measured = Some(self.error(&short, &other));
        }
        match measured {
            Some(error) => {
                // An error that grows with time, three times as fast; local errors are ε^(2/3) of what is asked for.
                let growth = 3.0 * scene.answers as f64 / part.max(1) as f64;
                let excess = growth * error / (0.3 * self.allowed);
                let more = 1.5 * nalgebra::ComplexField::log10(larger(excess, 1.0));
                let needed = digits.saturating_add(nalgebra::ComplexField::ceil(more) as u8);
                tight = tight.max(needed);
            }
            None if part == 0 => tight += 1,
            None => {}
        }
        let plan = self.adaptive_plan(tight, run);
        if tight > scene.most_digits() || self.may_slip_late() {
            return Err(FidelityError::PilotTooShort {
                needed: 2.0 * run.evaluations * scene.answers as f64 / part.max(1) as f64,
                allowed: purse.budget,
            });
        }
        let error = self.allowed;
        trials.push(Trial { plan, error, verdict: Verdict::Estimated, met: true });
        let evidence = self.evidence(run);
        Ok(self.finish(plan, error, Verdict::Estimated, evidence, trials, &purse, part))
    }

    /// Whether a spring may lead the mass along unstable sliding: there a slow start forgets no error, but multiplies it until
    /// it slips, and no tolerance that is not checked over all of the scene says when.
    fn may_slip_late(&self) -> bool {
        let scene = self.scene;
        let breakaway = to_f64(scene.dry.breakaway);
        let damping = to_f64(scene.machine.mechanism.viscous_damping);
        let normal_force = to_f64(scene.contact.normal_force());
        let falls = scene
            .contact
            .model()
            .anatomy(T::one())
            .is_none_or(|made| to_f64(made.least_slope) * normal_force + damping < 0.0);
        let pulled = scene.machine.mechanism.spring_stiffness > T::zero();
        pulled && falls && self.survey().largest > 0.9 * breakaway
    }

    /// The difference of two runs in the norm of the tolerance, followed to the end of the scene.
    fn error(&self, run: &Run, truth: &Run) -> f64 {
        self.error_of(&run.samples, &truth.samples)
    }

    fn error_of(&self, run: &[Sample], truth: &[Sample]) -> f64 {
        let scene = self.scene;
        let off: Vec<f64> =
            run.iter().zip(truth).map(|(a, b)| scene.value(a) - scene.value(b)).collect();
        if off.is_empty() || off.iter().any(|e| !e.is_finite()) {
            return f64::INFINITY;
        }
        let largest = off.iter().fold(0.0, |most, e| larger(most, e.abs_value()));
        let norm = match self.tolerance.norm {
            Norm::Greatest => largest,
            Norm::RootMeanSquare => root(off.iter().map(|e| e * e).sum::<f64>() / off.len() as f64),
        };
        let Some(period) = scene.period.filter(|_| off.len() < scene.answers) else {
            return norm;
        };
        // The worst of the periods seen, and what each further one adds.
        let change = |nth: usize| {
            let now = off.iter().skip(nth * period).take(period);
            let before = off.iter().skip((nth - 1) * period);
            now.zip(before).fold(0.0, |most, (a, b)| larger(most, (a - b).abs_value()))
        };
        let drift = larger(change(1), change(2));
        let rest = scene.answers as f64 / period as f64 - PERIODS as f64;
        let worst = match self.tolerance.norm {
            Norm::Greatest => norm,
            // The mean of a period may hide in that of three.
            Norm::RootMeanSquare => norm * root(PERIODS as f64),
        };
        worst + LATER * drift * rest
    }

    /// Whether a periodic scene has come to repeat itself: what its velocity and its deflection still
    /// change by from period to period cannot add up to much.
    fn is_settled(&self, run: &Run) -> bool {
        let scene = self.scene;
        let Some(period) = scene.period else { return true };
        let rest = scene.answers as f64 / period as f64 - PERIODS as f64;
        let settles = |of: &dyn Fn(&Sample) -> f64, least: f64| {
            let size = run.samples.iter().fold(least, |most, s| larger(most, of(s).abs_value()));
            let change = |nth: usize| {
                let now = run.samples.iter().skip(nth * period).take(period);
                let before = run.samples.iter().skip((nth - 1) * period);
                now.zip(before).fold(0.0, |most, (a, b)| larger(most, (of(a) - of(b)).abs_value()))
            };
            let (first, second) = (change(1), change(2));
            let ratio = if first > 0.0 { second / first } else { 0.0 };
            let geometric = if ratio < 0.9 { ratio / (1.0 - ratio) } else { f64::INFINITY };
            let further = if geometric < rest { geometric } else { rest };
            second * further <= 0.05 * size
        };
        settles(&|s| s.velocity, 0.0) && settles(&|s| s.deflection, 0.0)
    }

    /// What the applied force can have done by each answer. d√(2E)/dt ≤ |f + k (y − x₀)|/√m for a passive contact,
    /// E = ½ m v² + ½ k (x − x₀)² + W.
    fn survey(&self) -> Survey {
        let scene = self.scene;
        let machine = &scene.machine;
        let mass = to_f64(machine.mechanism.mass);
        let interval = to_f64(scene.interval);
        let z = match scene.start {
            super::Start::Undeflected => 0.0,
            super::Start::Steady => to_f64(scene.contact.stationary(machine.velocity)),
        };
        let springs = to_f64(scene.contact.model().storage_stiffness())
            * to_f64(scene.contact.normal_force());
        let start = to_f64(machine.velocity);
        let mut gained = root(mass * start * start + springs * z * z);
        let mut all = Vec::with_capacity(scene.answers);
        let at = |place: f64| {
            to_f64(machine.applied(scene.interval * crate::scalar::lit(place))).abs_value()
        };
        let mut before = at(0.0);
        let mut largest = before;
        for index in 0..scene.answers {
            let (middle, end) = (at(index as f64 + 0.5), at(index as f64 + 1.0));
            // The larger end of each half.
            let (first, second) = (larger(before, middle), larger(middle, end));
            gained += 0.5 * interval * (first + second) / root(mass);
            largest = larger(largest, larger(first, second));
            all.push(gained);
            before = end;
        }
        Survey { largest, gained: all }
    }

    /// A bound on the error of true rest, where the static curve cannot but rest.
    fn stuck_bound(&self, survey: &Survey) -> Option<f64> {
        let scene = self.scene;
        let machine = &scene.machine;
        let at_rest = crate::scalar::is_zero(machine.velocity)
            && survey.largest <= to_f64(scene.dry.breakaway)
            && scene.contact.model().obeys(Law::Passivity);
        if !at_rest || scene.quantity == super::Quantity::Force {
            return None;
        }
        let mass = to_f64(machine.mechanism.mass);
        let stiffness = to_f64(machine.mechanism.spring_stiffness);
        let interval = to_f64(scene.interval);
        let (mut way, mut error, mut squares) = (0.0, 0.0_f64, 0.0);
        for gained in &survey.gained {
            let speed = gained / root(mass);
            way += interval * speed;
            let spring = gained / root(stiffness);
            let off = match scene.quantity {
                super::Quantity::Velocity => speed,
                _ if spring < way => spring,
                _ => way,
            };
            error = larger(error, off);
            squares += off * off;
        }
        Some(match self.tolerance.norm {
            Norm::Greatest => error,
            Norm::RootMeanSquare => root(squares / survey.gained.len() as f64),
        })
    }

    /// Whether the mass holds more energy than it can have got.
    fn check_energy(&self, run: &Run, digits: u8, survey: &Survey) -> Result<(), FidelityError> {
        let scene = self.scene;
        let mechanism = &scene.machine.mechanism;
        let springs = to_f64(scene.contact.model().storage_stiffness())
            * to_f64(scene.contact.normal_force());
        let (mass, stiffness) = (to_f64(mechanism.mass), to_f64(mechanism.spring_stiffness));
        let tolerance = nalgebra::ComplexField::powi(10.0_f64, -i32::from(digits));
        let slack = LOOSE * tolerance * root(mass) * to_f64(scene.scales[1]) + 1e-150;
        for (index, (sample, gained)) in run.samples.iter().zip(&survey.gained).enumerate() {
            let Sample { position: x, velocity: v, deflection: z, .. } = *sample;
            let energy = 0.5 * (mass * v * v + stiffness * x * x + springs * z * z);
            // A hundredth for what lies between answers, and what errors of the run may seem to add.
            let most = 1.01 * gained + slack;
            let limit = 0.5 * most * most;
            if !(energy <= limit) {
                let time = to_f64(scene.interval) * (index + 1) as f64;
                return Err(FidelityError::GainsEnergy { time, energy, limit });
            }
        }
        Ok(())
    }

    /// Whether a run slides steadily where that is unstable: on the falling part of the curve, for longer than the motion takes to
    /// leave. Long steps of an L-stable method hold it there.
    fn balances(&self, run: &Run) -> bool {
        let scene = self.scene;
        let contact = &scene.contact;
        let mechanism = &scene.machine.mechanism;
        let (mass, damping) = (to_f64(mechanism.mass), to_f64(mechanism.viscous_damping));
        let breakaway = to_f64(scene.scales[2]);
        let mut in_a_row = 0;
        let mut looks = 0;
        for (before, now) in run.samples.iter().zip(run.samples.iter().skip(1)) {
            let even =
                (now.velocity - before.velocity).abs_value() <= 0.02 * now.velocity.abs_value();
            let still = (now.deflection - before.deflection).abs_value() <= 0.02 * breakaway;
            if !(even && still && now.velocity != 0.0) || looks > LOOKS {
                in_a_row = 0;
                continue;
            }
            looks += 1;
            let at = |v: f64| to_f64(contact.stationary_force(crate::scalar::lit::<T>(v)));
            let v = now.velocity;
            let slope = (at(1.01 * v) - at(0.99 * v)) / (0.02 * v) + damping;
            // Some e-foldings between two answers: nothing stays there that long.
            in_a_row = if -slope / mass * to_f64(scene.interval) > 1.0 { in_a_row + 1 } else { 0 };
            if in_a_row >= 2 {
                return true;
            }
        }
        false
    }

    /// What kind of a scene the reference found.
    fn evidence(&self, run: &Run) -> Evidence {
        let scene = self.scene;
        let model = scene.contact.model();
        let breakaway = to_f64(scene.scales[2]);
        let (mut slowest, mut fastest) = (f64::INFINITY, 0.0);
        let (mut reversals, mut stuck) = (0, 0_usize);
        let (mut way, mut longest, mut from) = (0.0, 0.0, 0.0);
        let (mut lag, mut relaxation) = (0.0, 0.0);
        let mut direction = 0.0;
        let interval = to_f64(scene.interval);
        let stride = run.samples.len().div_ceil(LOOKS).max(1);
        for (index, sample) in run.samples.iter().enumerate() {
            let speed = sample.velocity.abs_value();
            slowest = if speed < slowest { speed } else { slowest };
            fastest = larger(fastest, speed);
            if sample.velocity * direction < 0.0 {
                reversals += 1;
                way = 0.0;
            }
            if sample.velocity != 0.0 {
                direction = sample.velocity;
            }
            way += (sample.position - from).abs_value();
            from = sample.position;
            longest = larger(longest, way);
            if way < breakaway {
                stuck += 1;
            }
            if index % stride == 0 {
                let v: T = crate::scalar::lit(sample.velocity);
                let z = to_f64(model.stationary(v));
                lag = larger(lag, (sample.deflection - z).abs_value() / breakaway);
                relaxation += stride as f64
                    * interval
                    * to_f64(
                        model.affine(v.into(), crate::scalar::lit(sample.deflection)).relaxation,
                    );
            }
        }
        Evidence {
            slowest,
            fastest,
            reversals,
            lag,
            presliding: breakaway / longest,
            stuck_share: stuck as f64 / run.samples.len().max(1) as f64,
            relaxation,
            transits: None,
        }
    }
}

/// Instants at which the evidence looks at the curve.
const LOOKS: usize = 32;

/// Decimals of a relative tolerance.
fn digits_of(relative: f64) -> u8 {
    let digits = nalgebra::ComplexField::ceil(-nalgebra::ComplexField::log10(relative));
    if digits > 200.0 {
        200
    } else if digits > 0.0 {
        digits as u8
    } else {
        0
    }
}

/// |x|, which has no name without the standard library.
trait AbsoluteValue {
    fn abs_value(self) -> f64;
}

impl AbsoluteValue for f64 {
    fn abs_value(self) -> f64 {
        if self < 0.0 { -self } else { self }
    }
}
