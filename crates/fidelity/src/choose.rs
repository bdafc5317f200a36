//! The search: the reference settles, then every other level is measured against it.

use alloc::vec::Vec;

use super::report::{Choice, FidelityError, Trial, Verdict};
use super::scene::{Level, MOST_STEPS, Run, Scene};
use bristle::Units;
use bristle::parameter::{Named, ParameterError, Rule};

/// The error allowed, and what the search for the cheapest run may cost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// The error allowed, in the unit of the scene's quantity.
    pub error: f64,
    /// Whether that is the root of the mean square over all answers; else no answer may exceed it.
    pub root_mean_square: bool,
    /// What the search may cost, in evaluations of FrBD with one spring; 1e8 by default: a second,
    /// or a few with what the signals of the scene cost.
    pub budget: f64,
    /// In which units the result prints.
    pub units: Units,
}

/// A search of this cost takes a second or a few: one evaluation takes some 10 ns, and a sine in
/// the scene as much again for each of its values.
const BUDGET: f64 = 1e8;

impl Tolerance {
    /// Every answer is within this error, in the unit of the scene's quantity.
    pub const fn at_every_answer(error: f64) -> Self {
        Self { error, root_mean_square: false, budget: BUDGET, units: Units::Translation }
    }

    /// The root of the mean square error of all answers is within this, in the unit of the scene's
    /// quantity.
    pub const fn root_mean_square(error: f64) -> Self {
        Self { root_mean_square: true, ..Self::at_every_answer(error) }
    }

    /// The error is of a joint: an angle, an angular velocity or a torque, printed as such.
    #[must_use]
    pub const fn in_units(self, units: Units) -> Self {
        Self { units, ..self }
    }

    /// The distance between two runs; NaN if an answer is not finite.
    fn distance(&self, a: &Run, b: &Run) -> f64 {
        if a.answers.len() != b.answers.len() {
            return f64::NAN;
        }
        let off = a.answers.iter().zip(&b.answers).map(|(a, b)| (a - b).abs());
        if self.root_mean_square {
            let sum: f64 = off.map(|off| off * off).sum();
            return nalgebra::ComplexField::sqrt(sum / a.answers.len() as f64);
        }
        // Not `f64::max`, which passes over NaN.
        off.fold(0.0, |most, off| if off > most || off.is_nan() { off } else { most })
    }
}

/// Runs of the reference have settled when they differ by no more than this part of the error
/// allowed: small beside it, so that what is measured against them is the error of the others.
pub(super) const SETTLED: f64 = 0.1;

/// Steps from one answer to the next from which on the agreement of two runs counts. Runs with one
/// and two steps agree about every force that repeats itself twice from answer to answer.
const FIRST_STEPS: u32 = 8;

/// Steps of such a run over the whole scene, at least, for where answers are few, much may happen
/// between two of them. They take some 50 µs.
const FEWEST_STEPS: usize = 4096;

/// Finds the cheapest level and steps whose answers are within a tolerance of the reference.
///
/// # Errors
///
/// Refuses a tolerance or a budget that is not positive and a scene without levels or answers, and
/// passes on why a run stopped. A reference that does not settle within the budget is
/// [`FidelityError::Undetermined`].
pub fn choose<S: Scene + ?Sized>(scene: &S, tolerance: Tolerance) -> Result<Choice, FidelityError> {
    Named("tolerance.error", tolerance.error).positive()?;
    Named("tolerance.budget", tolerance.budget).positive()?;
    let levels = scene.levels();
    let (&level, others) = levels.split_last().ok_or_else(|| none("levels"))?;
    let mut search = Search { scene, tolerance, fewest: scene.fewest_steps(), spent: 0.0 };
    let reference = search.settle(level)?;
    let own = search.measure(level, &reference, f64::INFINITY)?;
    if own.verdict != Verdict::Enough {
        return search.undetermined(own.error, own.steps);
    }
    let mut best = own;
    let mut trials = Vec::with_capacity(levels.len());
    for &level in others {
        let trial = search.measure(level, &reference, best.cost)?;
        // Of runs that cost the same the one of the simplest model.
        let tied = best.level == own.level && trial.cost <= best.cost;
        if trial.verdict == Verdict::Enough && (tied || trial.cost < best.cost) {
            best = trial;
        }
        trials.push(trial);
    }
    trials.push(own);
    for trial in trials.iter_mut().chain([&mut best]) {
        trial.physics = scene.physics(trial.level, trial.steps);
    }
    Ok(Choice {
        best,
        tolerance,
        trials,
        reference_steps: reference.steps,
        uncertainty: reference.uncertainty,
        search_cost: search.spent,
        quantity: scene.quantity(),
        interval: scene.interval(),
    })
}

fn none(name: &'static str) -> ParameterError {
    Named(name, 0.0).refused(Rule::Count { least: 1 })
}

/// A reference that has settled.
struct Reference {
    /// The last and finest run.
    run: Run,
    steps: u32,
    /// By how much the last two runs differ.
    uncertainty: f64,
}

struct Search<'a, S: ?Sized> {
    scene: &'a S,
    tolerance: Tolerance,
    /// [`Scene::fewest_steps`].
    fewest: u32,
    spent: f64,
}

impl<S: Scene + ?Sized> Search<'_, S> {
    fn run(&mut self, level: Level, steps: u32) -> Result<Run, FidelityError> {
        let run = self.scene.run(level, steps)?;
        self.spent += run.cost;
        if run.answers.is_empty() { Err(none("answers").into()) } else { Ok(run) }
    }

    /// Steps from which on the agreement of two runs with so many answers counts.
    fn first_steps(&self, run: &Run) -> u32 {
        let fewest = FEWEST_STEPS.checked_div(run.answers.len()).unwrap_or(FEWEST_STEPS);
        FIRST_STEPS.max(fewest as u32).max(self.fewest)
    }

    /// By how much two runs differ, and whether that is little enough for a settled reference.
    fn compare(&self, a: &Run, b: &Run) -> (f64, bool) {
        let difference = self.tolerance.distance(a, b);
        (difference, difference <= SETTLED * self.tolerance.error)
    }

    /// Doubles the steps of the reference until two runs agree, and a third one with them that has
    /// about twice as many steps again, but an odd number: what two runs step over in the same way
    /// (a force whose period divides all their steps) the third one meets.
    fn settle(&mut self, level: Level) -> Result<Reference, FidelityError> {
        let (mut before, mut steps) = (None::<Run>, 1_u32);
        loop {
            let run = self.run(level, steps)?;
            let finer = 2 * steps + 3;
            let left = self.tolerance.budget - self.spent;
            // Also the first run whose agreement counts, at a cost that is affine in the steps.
            let ahead = f64::max(2.0, f64::from(self.fewest) / f64::from(steps));
            let affordable = ahead * run.cost <= left && finer.max(self.fewest) <= MOST_STEPS;
            let (mut difference, agreed) =
                before.map_or((f64::NAN, false), |before| self.compare(&before, &run));
            if agreed && steps / 2 >= self.first_steps(&run) && affordable {
                let last = self.run(level, finer)?;
                let (uncertainty, confirmed) = self.compare(&run, &last);
                if confirmed {
                    return Ok(Reference { run: last, steps: finer, uncertainty });
                }
                difference = uncertainty;
            }
            if !affordable {
                return self.undetermined(difference, steps);
            }
            before = Some(run);
            steps *= 2;
        }
    }

    fn undetermined<R>(&self, difference: f64, steps: u32) -> Result<R, FidelityError> {
        let Tolerance { error: allowed, units, .. } = self.tolerance;
        let (quantity, fewest) = (self.scene.quantity(), self.fewest);
        Err(FidelityError::Undetermined { quantity, difference, allowed, steps, fewest, units })
    }

    /// Doubles the steps of a level until it is good enough, settles on something else, or would
    /// cost more than the best run so far.
    fn measure(
        &mut self,
        level: Level,
        reference: &Reference,
        best: f64,
    ) -> Result<Trial, FidelityError> {
        let (mut steps, mut agreements, mut before) = (1, 0, None::<Run>);
        loop {
            let run = self.run(level, steps)?;
            let error = self.tolerance.distance(&run, &reference.run);
            // The reference may be off in the same direction.
            let enough = error + reference.uncertainty <= self.tolerance.error;
            // The cost is affine in the number of steps.
            let mut next = run.cost;
            if let Some(before) = &before {
                next += 2.0 * (run.cost - before.cost);
                let agreed = steps > self.first_steps(&run) && self.compare(before, &run).1;
                agreements = if agreed { agreements + 1 } else { 0 };
            }
            let verdict = if enough {
                Verdict::Enough
            } else if level.method.is_none() || agreements == 2 {
                // Three runs agree: what is left is the model's own.
                Verdict::NotEnough
            } else if !(next < best) || steps == MOST_STEPS {
                Verdict::TooCostly
            } else {
                before = Some(run);
                steps *= 2;
                continue;
            };
            let (evaluations, cost) = (run.evaluations, run.cost);
            return Ok(Trial { level, steps, evaluations, cost, error, verdict, physics: None });
        }
    }
}
