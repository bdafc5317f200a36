//! The search: the reference settles, then every other level is measured against it.

use alloc::vec::Vec;

use super::report::{Choice, FidelityError, Trial, Verdict};
use super::scene::{Level, MOST_STEPS, Plan, Refinement, Run, Scene};
use crate::parameter::{self, ParameterError, Rule};

/// In which sense an error is small.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Norm {
    /// The largest error of any answer.
    Greatest,
    /// The root of the mean square over all answers.
    RootMeanSquare,
}

impl Norm {
    /// The distance between two runs; NaN if an answer is not finite.
    fn distance(self, a: &Run, b: &Run) -> f64 {
        if a.answers.len() != b.answers.len() {
            return f64::NAN;
        }
        let off = a.answers.iter().zip(&b.answers).map(|(a, b)| (a - b).abs());
        match self {
            // Not `f64::max`, which passes over NaN.
            Norm::Greatest => off.fold(0.0, |most, off| if off <= most { most } else { off }),
            Norm::RootMeanSquare => {
                let sum: f64 = off.map(|off| off * off).sum();
                nalgebra::ComplexField::sqrt(sum / a.answers.len() as f64)
            }
        }
    }
}

/// The error allowed, and what the search for a plan may cost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// In which sense the error is small.
    pub norm: Norm,
    /// The error allowed, in the unit of the scene's quantity.
    pub error: f64,
    /// What the search may cost, in evaluations of FrBD with one spring.
    pub budget: f64,
}

/// A search of this cost takes about a second: one evaluation takes some 10 ns.
const BUDGET: f64 = 1e8;

impl Tolerance {
    /// Every answer is within this error, in the unit of the scene's quantity.
    pub const fn at_every_answer(error: f64) -> Self {
        Self { norm: Norm::Greatest, error, budget: BUDGET }
    }

    /// The root of the mean square error of all answers is within this, in the unit of the scene's
    /// quantity.
    pub const fn root_mean_square(error: f64) -> Self {
        Self { norm: Norm::RootMeanSquare, error, budget: BUDGET }
    }
}

/// Runs of the reference have settled when they differ by no more than this part of the error
/// allowed: small beside it, so that what is measured against them is the error of the others.
const SETTLED: f64 = 0.1;

/// Steps from one answer to the next from which on the agreement of two runs counts. Runs with one
/// and two steps agree about every force that repeats itself twice from answer to answer.
const FIRST_STEPS: u32 = 8;

/// Steps of such a run over the whole scene, at least, for where answers are few, much may happen
/// between two of them. They take some 50 µs.
const FEWEST_STEPS: usize = 4096;

/// Finds the cheapest plan whose answers are within a tolerance of the reference.
///
/// # Errors
///
/// Refuses a tolerance or a budget that is not positive and a scene without levels or answers, and
/// passes on why a run stopped. A reference that does not settle within the budget is
/// [`FidelityError::Undetermined`].
pub fn choose<S: Scene + ?Sized>(scene: &S, tolerance: Tolerance) -> Result<Choice, FidelityError> {
    parameter::positive("tolerance.error", tolerance.error)?;
    parameter::positive("tolerance.budget", tolerance.budget)?;
    let levels = scene.levels();
    let (&level, others) = levels.split_last().ok_or_else(|| none("levels"))?;
    let mut search = Search { scene, tolerance, spent: 0.0 };
    let reference = search.settle(level)?;
    let own = search.coarsest(level, &reference)?;
    let mut best = own;
    let mut trials = Vec::with_capacity(levels.len());
    for &level in others {
        let trial = search.measure(level, &reference, best.cost)?;
        // Of plans that cost the same the one of the simplest model.
        let tied = best.plan.level == own.plan.level && trial.cost <= best.cost;
        if trial.verdict == Verdict::Enough && (tied || trial.cost < best.cost) {
            best = trial;
        }
        trials.push(trial);
    }
    trials.push(own);
    for trial in &mut trials {
        trial.physics = scene.physics(&trial.plan);
    }
    Ok(Choice {
        plan: best.plan,
        evaluations: best.evaluations,
        cost: best.cost,
        error: best.error,
        tolerance,
        trials,
        reference: Plan { level, steps: reference.steps },
        uncertainty: reference.uncertainty,
        search_cost: search.spent,
        quantity: scene.quantity(),
        interval: scene.interval(),
    })
}

fn none(name: &'static str) -> ParameterError {
    ParameterError { name, component: None, value: 0.0, rule: Rule::Count { least: 1 } }
}

/// A reference that has settled.
struct Reference {
    /// Its runs with 1, 2, 4 … steps from one answer to the next.
    coarser: Vec<Run>,
    /// The last and finest run.
    run: Run,
    steps: u32,
    /// By how much the last two runs differ.
    uncertainty: f64,
    /// Steps from which on the agreement of two runs counts.
    first_steps: u32,
}

struct Search<'a, S: ?Sized> {
    scene: &'a S,
    tolerance: Tolerance,
    spent: f64,
}

impl<S: Scene + ?Sized> Search<'_, S> {
    fn run(&mut self, level: Level, steps: u32) -> Result<Run, FidelityError> {
        let run = self.scene.run(&Plan { level, steps })?;
        self.spent += run.cost;
        Ok(run)
    }

    /// By how much two runs differ, and whether that is little enough for a settled reference.
    fn compare(&self, a: &Run, b: &Run) -> (f64, bool) {
        let difference = self.tolerance.norm.distance(a, b);
        (difference, difference <= SETTLED * self.tolerance.error)
    }

    /// Doubles the steps of the reference until two runs agree, and a third one with them that has
    /// about twice as many steps again, but an odd number: what two runs step over in the same way
    /// (a force whose period divides all their steps) the third one meets.
    fn settle(&mut self, level: Level) -> Result<Reference, FidelityError> {
        let (mut coarser, mut steps) = (Vec::<Run>::new(), 1_u32);
        loop {
            let run = self.run(level, steps)?;
            let answers = run.answers.len();
            let fewest = FEWEST_STEPS.checked_div(answers).ok_or_else(|| none("answers"))?;
            let first_steps = FIRST_STEPS.max(fewest as u32);
            if level.refinement == Refinement::Memoryless {
                let coarser = alloc::vec![run.clone()];
                return Ok(Reference { coarser, run, steps, uncertainty: 0.0, first_steps });
            }
            let finer = 2 * steps + 3;
            let left = self.tolerance.budget - self.spent;
            let affordable = 2.0 * run.cost <= left && finer <= MOST_STEPS;
            let (mut difference, agreed) =
                coarser.last().map_or((f64::NAN, false), |coarser| self.compare(coarser, &run));
            if agreed && steps >= 2 * first_steps && affordable {
                let last = self.run(level, finer)?;
                let (uncertainty, confirmed) = self.compare(&run, &last);
                if confirmed {
                    coarser.push(run);
                    let (run, steps) = (last, finer);
                    return Ok(Reference { coarser, run, steps, uncertainty, first_steps });
                }
                difference = uncertainty;
            }
            if !affordable {
                return self.undetermined(difference, steps);
            }
            coarser.push(run);
            steps *= 2;
        }
    }

    fn undetermined<R>(&self, difference: f64, steps: u32) -> Result<R, FidelityError> {
        let (quantity, allowed) = (self.scene.quantity(), self.tolerance.error);
        Err(FidelityError::Undetermined { quantity, difference, allowed, steps })
    }

    /// What a run is worth.
    fn trial(&self, plan: Plan, run: &Run, reference: &Reference) -> Trial {
        let error = self.tolerance.norm.distance(run, &reference.run);
        // The reference may be off in the same direction.
        let enough = error + reference.uncertainty <= self.tolerance.error;
        let verdict = if enough { Verdict::Enough } else { Verdict::NotEnough };
        let (evaluations, cost) = (run.evaluations, run.cost);
        Trial { plan, evaluations, cost, error, verdict, physics: None }
    }

    /// The coarsest run of the reference itself that is good enough: the last of them is.
    fn coarsest(&self, level: Level, reference: &Reference) -> Result<Trial, FidelityError> {
        for (doublings, run) in reference.coarser.iter().enumerate() {
            let trial = self.trial(Plan { level, steps: 1 << doublings }, run, reference);
            if trial.verdict == Verdict::Enough {
                return Ok(trial);
            }
        }
        // Only if it is memoryless, and its answers are not finite.
        self.undetermined(f64::NAN, 1)
    }

    /// Doubles the steps of a level until it is good enough, settles on something else, or would
    /// cost more than the best plan so far.
    fn measure(
        &mut self,
        level: Level,
        reference: &Reference,
        best: f64,
    ) -> Result<Trial, FidelityError> {
        let (mut steps, mut agreements, mut before) = (1, 0, None::<Run>);
        loop {
            let run = self.run(level, steps)?;
            let trial = self.trial(Plan { level, steps }, &run, reference);
            if trial.verdict == Verdict::Enough || level.refinement == Refinement::Memoryless {
                return Ok(trial);
            }
            // The cost is affine in the number of steps.
            let mut next = run.cost;
            if let Some(before) = &before {
                next += 2.0 * (run.cost - before.cost);
                let agreed = steps > reference.first_steps && self.compare(before, &run).1;
                agreements = if agreed { agreements + 1 } else { 0 };
            }
            // Three runs agree: what is left is the model's own.
            if agreements == 2 {
                return Ok(trial);
            }
            if !(next < best) || steps == MOST_STEPS {
                return Ok(Trial { verdict: Verdict::TooDear, ..trial });
            }
            before = Some(run);
            steps *= 2;
        }
    }
}
