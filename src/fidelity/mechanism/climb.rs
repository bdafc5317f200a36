//! The climb of a mechanism: what costs nothing first, then a pilot and a second opinion, and else the reference under
//! tightened error control.

use alloc::vec::Vec;

use super::super::report::{
    Choice, Evidence, FidelityError, Integrator, Norm, Plan, Rung, Tolerance, Trial, Verdict,
};
use super::machine::{NO_LIMIT, Run, Sample};
use super::{MechanismHistory, Quantity, Way};
use crate::scalar::to_f64;
use crate::signal::Signal;
use crate::{Bristle, Scalar};

/// Evaluations that a pilot may always spend.
const FREE_EVALUATIONS: f64 = 2000.0;
/// Share of a full run of the reference that it may spend.
const PILOT_SHARE: f64 = 0.05;
/// What a measured error must stay below, as a share of the tolerance.
const MARGIN: f64 = 0.8;
/// Share of the tolerance within which two runs of the reference have to agree before the tighter one counts as true.
const AGREED: f64 = 0.3;
/// The same of error control and passive steps, which have nothing in common but the model.
const CONCORD: f64 = 0.25;
/// Share of its means after which the pilot gives the first run of the reference up, unless it looks like being done by the second.
const FIRST: f64 = 0.3;
const FIRST_AT_MOST: f64 = 0.97;
/// Share of its means that the static curve may take before all else: at rest it takes none.
const STILL_AT_MOST: f64 = 0.3;
/// What the next digit of error control costs, in the last: a third more at most.
const NEXT_DIGIT: f64 = 1.35;
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
/// Differences of steps of several lengths, and of them and the static curve, that pass.
const AGREE: f64 = 0.1;
/// A difference this small, as a share of the tolerance, has converged.
const SMALL: f64 = 0.02;
/// Share of the window that error control has to have seen to vouch for longer steps.
const LEAST_SEEN: f64 = 0.02;
/// Growth of errors by this factor is within what is measured anyway.
const MUCH: f64 = 10.0;
/// What an error that has grown must stay below, as a share of the tolerance.
const GROWN: f64 = 0.1;
/// Share of the tolerance that may be used where a periodic scene does not yet repeat itself.
const UNSETTLED: f64 = 0.25;
/// Looser error control loses whole slips: something else has to agree with it.
const LEAST_DIGITS: u8 = 5;
/// Where it begins.
const FIRST_DIGITS: u8 = 2;
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

/// Runs over the whole window with steps of fixed length, and how many between two answers.
type Others = Vec<(Way, usize, Run)>;

/// Evaluations after which the first run of the reference is given up, unless it goes on so well as to be done before the second.
fn first(purse: &Purse) -> (f64, f64) {
    (FIRST * purse.rest(), FIRST_AT_MOST * purse.rest())
}

pub(super) fn root(value: f64) -> f64 {
    nalgebra::ComplexField::sqrt(value)
}

pub(super) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

pub(super) fn choose<T, M, D, F>(
    scene: &MechanismHistory<T, M, D, F>,
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

pub(super) struct Climb<'a, T: Scalar, M, D, F> {
    pub(super) scene: &'a MechanismHistory<T, M, D, F>,
    pub(super) tolerance: Tolerance,
    pub(super) allowed: f64,
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
        let mut window = match scene.period {
            Some(period) if PERIODS * period < scene.answers => PERIODS * period,
            _ => scene.answers,
        };

        // The reference under error control, until a tighter tolerance or steps of another method agree with it.
        let mut runs = Others::new();
        let [still, _, passive] = MechanismHistory::<T, M, D, F>::ways();
        if window as f64 * (1.0 + self.of_an_answer()) <= STILL_AT_MOST * purse.rest() {
            self.is_run(still, 1, window, &mut runs, &mut purse)?;
        }
        let mut digits = self.first_digits();
        let mut last = self.adaptive(digits, window, first(&purse))?;
        purse.spent += last.evaluations;
        self.check_energy(&last, digits, &survey)?;
        if most_evaluations.is_none() {
            // A full run of the reference is known now, or foreseen.
            let all = last.evaluations * scene.answers as f64 / last.samples.len().max(1) as f64;
            purse.budget = larger(purse.budget, PILOT_SHARE * all);
            if last.samples.len() < window && FIRST * purse.rest() > 1.5 * last.evaluations {
                last = self.adaptive(digits, window, first(&purse))?;
                purse.spent += last.evaluations;
                self.check_energy(&last, digits, &survey)?;
            }
        }
        if window < scene.answers && last.samples.len() == window && !self.is_settled(&last) {
            // All of the scene, if there are means.
            let whole = last.evaluations * scene.answers as f64 / window as f64;
            if whole + scene.answers as f64 <= purse.rest() {
                window = scene.answers;
                runs.clear();
                last = self.adaptive(digits, window, (purse.rest(), purse.rest()))?;
                purse.spent += last.evaluations;
                self.check_energy(&last, digits, &survey)?;
            }
        }
        if last.samples.len() < window {
            let found = self.by_agreement(&last, window, &mut runs, &mut trials, &mut purse)?;
            if let Some(choice) = found {
                return Ok(choice);
            }
            return self.rest_on_error_control(digits, &last, trials, purse);
        }
        let grows = self.growth(&last);
        let relative = self.relative(0.0).min(1.0);
        let mut least = 0;
        if grows > MUCH {
            if !(grows * to_f64(T::default_epsilon()) <= GROWN * relative) {
                return Err(FidelityError::Undetermined { factor: grows });
            }
            // Fewer digits say nothing of when it slips.
            least = digits_of(GROWN * relative / grows).min(scene.most_digits() - 1);
        }
        let mut substeps = 1_usize;
        let mut looked = 0;
        let (uncertainty, mut best) = loop {
            let tight = digits >= least;
            let by_digits = NEXT_DIGIT * last.evaluations;
            // Those that were run before.
            if tight && looked < runs.len() {
                let mut least_off = f64::INFINITY;
                for (way, n, run) in runs.iter().skip(looked) {
                    let off = self.error(run, &last);
                    least_off = if off < least_off { off } else { least_off };
                    if way.rung == Rung::Reference && off > CONCORD * self.allowed {
                        substeps = n * jump(off / (CONCORD * self.allowed));
                    }
                }
                looked = runs.len();
                if least_off <= CONCORD * self.allowed {
                    let plan = self.adaptive_plan(digits, &last);
                    let error = least_off;
                    trials.push(Trial { plan, error, verdict: Verdict::Measured, met: true });
                    break (0.5 * error, (plan, error));
                }
            }
            let (way, n) = if runs.is_empty() { (still, 1) } else { (passive, substeps) };
            let by_steps = window as f64 * (n as f64 + self.of_an_answer());
            // What is left must do for another digit, if it does now.
            let reserve = if by_digits > purse.rest() { 0.0 } else { by_digits };
            let sooner = n == 1 || by_steps <= by_digits || reserve == 0.0;
            if tight && sooner && by_steps + reserve <= purse.rest() {
                self.is_run(way, n, window, &mut runs, &mut purse)?;
                continue;
            }
            let tighter = most_of(most_of(digits + 1, least), LEAST_DIGITS);
            if tighter > scene.most_digits() {
                let plan = self.adaptive_plan(digits, &last);
                return Err(FidelityError::OutOfReach {
                    quantity: scene.quantity,
                    allowed: self.allowed,
                    error: trials.last().map_or(f64::INFINITY, |trial| trial.error),
                    plan,
                    evaluations: purse.spent,
                });
            }
            if by_digits > purse.rest() {
                let found = self.by_agreement(&last, window, &mut runs, &mut trials, &mut purse)?;
                if let Some(choice) = found {
                    return Ok(choice);
                }
                return self.rest_on_error_control(digits, &last, trials, purse);
            }
            let run = self.adaptive(tighter, window, (purse.rest(), purse.rest()))?;
            purse.spent += run.evaluations;
            if run.samples.len() < window {
                return self.rest_on_error_control(digits, &last, trials, purse);
            }
            let error = self.error(&last, &run);
            let plan = self.adaptive_plan(digits, &last);
            let met = error <= AGREED * self.allowed && tight;
            trials.push(Trial { plan, error, verdict: Verdict::Measured, met });
            digits = tighter;
            last = run;
            if met {
                break (TIGHTER * error, (plan, error));
            }
            looked = 0;
        };
        let truth = last;
        self.check_energy(&truth, digits, &survey)?;
        let mut strict = 1.0;
        if window < scene.answers && !self.is_settled(&truth) {
            strict = UNSETTLED;
            if best.1 > strict * self.allowed {
                return self.rest_on_error_control(digits, &truth, trials, purse);
            }
        }

        // What is cheaper than that.
        for way in MechanismHistory::<T, M, D, F>::ways().into_iter().rev() {
            let known = (&truth, runs.as_slice(), uncertainty, strict);
            self.try_steps(way, known, &mut purse, &mut trials, &mut best)?;
        }
        let evidence = self.evidence(&truth);
        Ok(self.finish(best.0, best.1, Verdict::Measured, evidence, trials, &purse, window))
    }

    /// Evaluations that the friction force takes at an answer.
    fn of_an_answer(&self) -> f64 {
        if self.scene.quantity == Quantity::Force { 1.0 } else { 0.0 }
    }

    /// Tries a rung with shorter and shorter steps, until it will do or costs more than what is known to do.
    fn try_steps(
        &self,
        way: Way,
        (truth, runs, uncertainty, strict): (&Run, &[(Way, usize, Run)], f64, f64),
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
            let expected =
                MechanismHistory::<T, M, D, F>::step_cost(way) * substeps as f64 / interval;
            // Sliding less than all the time the static curve is cheaper than that.
            let least = if way.rung == Rung::StaticCurve {
                super::weight::SLIDE * substeps as f64 / interval
            } else {
                expected
            };
            let seen = runs.iter().find(|(other, n, _)| *n == substeps && *other == way);
            let dear = window as f64 * (substeps as f64 + self.of_an_answer()) > purse.rest();
            if least >= best.0.cost_rate || (seen.is_none() && dear) {
                break;
            }
            let fresh;
            let run = match seen {
                Some((_, _, run)) => run,
                None => {
                    fresh = scene.run(way, substeps, window, NO_LIMIT)?;
                    purse.spent += fresh.evaluations;
                    &fresh
                }
            };
            let error = self.error(run, truth) + uncertainty;
            let plan = scene.plan(way, substeps, run.cost / window as f64);
            let met = error <= strict * MARGIN * self.allowed;
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
            substeps *= jump(error / (MARGIN * self.allowed));
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

    fn adaptive(&self, digits: u8, answers: usize, most: (f64, f64)) -> Result<Run, FidelityError> {
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
        digits_of(relative).clamp(FIRST_DIGITS, self.scene.most_digits() - 1)
    }

    /// Where error control cannot see all of the window, or not twice: passive steps of two or three lengths that converge over all
    /// of it, or agree with the static curve, and with what error control has seen. Cheaper rungs are compared with the finest.
    fn by_agreement(
        &self,
        prefix: &Run,
        window: usize,
        runs: &mut Others,
        trials: &mut Vec<Trial>,
        purse: &mut Purse,
    ) -> Result<Option<Choice>, FidelityError> {
        let scene = self.scene;
        let [still, _, passive] = MechanismHistory::<T, M, D, F>::ways();
        let size = window as f64;
        if (prefix.samples.len() as f64) < LEAST_SEEN * size {
            return Ok(None);
        }
        let (mut substeps, mut before) = (1_usize, f64::INFINITY);
        let off = loop {
            if !self.is_run(passive, substeps, window, runs, purse)? {
                return Ok(None);
            }
            let of = |way: Way, n: usize| {
                runs.iter().find(|(other, m, _)| *other == way && *m == n).map(|(_, _, run)| run)
            };
            if let (Some(coarse), Some(fine)) = (of(passive, substeps / 2), of(passive, substeps)) {
                let off = self.error(coarse, fine);
                let converges = off <= 0.5 * before || off <= SMALL * self.allowed;
                before = off;
                if off <= AGREE * self.allowed && converges {
                    if substeps >= 4 || off <= SMALL * self.allowed {
                        break off;
                    }
                    if self.is_run(still, 1, window, runs, purse)? {
                        let by_curve = runs
                            .iter()
                            .find(|(way, n, _)| *way == still && *n == 1)
                            .and_then(|(_, _, curve)| {
                                let fine = runs
                                    .iter()
                                    .find(|(w, n, _)| *w == passive && *n == substeps)?;
                                Some(self.error(curve, &fine.2))
                            });
                        if by_curve.is_some_and(|other| other <= AGREE * self.allowed) {
                            break off;
                        }
                    }
                }
            }
            substeps *= 2;
        };
        self.is_run(still, 1, window, runs, purse)?;
        let finest = runs.iter().find(|(way, n, _)| *way == passive && *n == substeps);
        let Some((_, _, finest)) = finest else { return Ok(None) };
        let seen = self.error_of(&finest.samples, &prefix.samples);
        if !(seen <= 0.2 * self.allowed) || (window < scene.answers && !self.is_settled(finest)) {
            return Ok(None);
        }
        // What the finest may still be off by.
        let uncertainty = larger(2.0 * off, seen);
        let mut best: Option<(Plan, f64)> = None;
        for (way, n, run) in runs.iter() {
            let error = self.error(run, finest) + uncertainty;
            let plan = scene.plan(*way, *n, run.cost / size);
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

    /// Runs steps of a fixed length over the window, unless they are known or cost too much: whether they are known now.
    fn is_run(
        &self,
        way: Way,
        substeps: usize,
        window: usize,
        runs: &mut Others,
        purse: &mut Purse,
    ) -> Result<bool, FidelityError> {
        if runs.iter().any(|(other, n, _)| *other == way && *n == substeps) {
            return Ok(true);
        }
        if window as f64 * (substeps as f64 + self.of_an_answer()) > purse.rest() {
            return Ok(false);
        }
        let run = self.scene.run(way, substeps, window, NO_LIMIT)?;
        purse.spent += run.evaluations;
        runs.push((way, substeps, run));
        Ok(true)
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
            Quantity::Velocity => sample.velocity,
            _ => sample.position,
        };
        let furthest = run.samples.iter().fold(0.0, |most, s| larger(most, seen(s).abs_value()));
        let safety = if scene.quantity == Quantity::Position { SAFETY } else { SAFETY_OF_FAST };
        let mut tight = digits_of(self.relative(furthest) / safety).max(LEAST_DIGITS);
        let part = run.samples.len();
        let own = trials.iter().rev().find(|trial| trial.verdict == Verdict::Measured);
        let mut measured = own.map(|trial| trial.error);
        if measured.is_none() && part > 0 && 1.1 * run.evaluations < purse.rest() {
            let tighter = (digits + 1).min(scene.most_digits());
            let other = self.adaptive(tighter, part, (purse.rest(), purse.rest()))?;
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
            .characteristics(T::one())
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
        let (first, second) = (change(1), change(2));
        let rest = scene.answers as f64 / period as f64 - PERIODS as f64;
        // What dies out from period to period adds no more than a geometric series; all else goes on as it is.
        let ratio = if first > 0.0 { larger(second / first, 0.5) } else { 1.0 };
        let geometric = if ratio < 0.9 { ratio / (1.0 - ratio) } else { f64::INFINITY };
        let further =
            if geometric < rest { second * geometric } else { larger(first, second) * rest };
        let worst = match self.tolerance.norm {
            Norm::Greatest => norm,
            // The mean of a period may hide in that of three.
            Norm::RootMeanSquare => off
                .chunks(period)
                .map(|part| root(part.iter().map(|e| e * e).sum::<f64>() / part.len() as f64))
                .fold(0.0, larger),
        };
        worst + LATER * further
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
}

/// The larger number of digits.
fn most_of(a: u8, b: u8) -> u8 {
    if a > b { a } else { b }
}

/// By how much more steps an error of so many times what is allowed asks for: no method here is better than second order.
fn jump(ratio: f64) -> usize {
    if ratio > 100.0 {
        8
    } else if ratio > 8.0 {
        4
    } else {
        2
    }
}

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
pub(super) trait AbsoluteValue {
    fn abs_value(self) -> f64;
}

impl AbsoluteValue for f64 {
    fn abs_value(self) -> f64 {
        if self < 0.0 { -self } else { self }
    }
}
