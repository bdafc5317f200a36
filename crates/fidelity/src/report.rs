//! The result of the search, as a table.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt;

use super::choose::{SETTLED, Tolerance};
use super::scene::{Level, Quantity};
use bristle::number::{Number, Units};
use bristle::parameter::ParameterError;

/// The result of a level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Verdict {
    /// Its answers are within the tolerance.
    Enough,
    /// They are not, and more steps do not help: it is the model.
    NotEnough,
    /// They are not, and with more steps it would cost more than another level that is enough.
    /// Whether more steps would help is not known.
    TooCostly,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Verdict::Enough => "enough",
            Verdict::NotEnough => "not enough",
            Verdict::TooCostly => "too costly",
        })
    }
}

/// A level with the coarsest steps that are enough, or else the finest that were tried.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trial {
    /// The level.
    pub level: Level,
    /// Steps from one answer to the next.
    pub steps: u32,
    /// Evaluations of the friction model over the scene, counted.
    pub evaluations: u64,
    /// Their cost, in evaluations of FrBD with one spring.
    pub cost: f64,
    /// The error against the reference in the norm of the tolerance, measured at every answer;
    /// NaN if an answer is not finite.
    pub error: f64,
    /// What follows from it.
    pub verdict: Verdict,
    /// A dimensionless number of the scene that bears on this level, with its name.
    pub physics: Option<(&'static str, f64)>,
}

/// The cheapest run that is good enough, and what was measured on the way.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// The level and steps to take.
    pub best: Trial,
    /// The tolerance that was asked for.
    pub tolerance: Tolerance,
    /// Every level, from the cheapest model to the reference.
    pub trials: Vec<Trial>,
    /// Steps from one answer to the next in the finest run of the reference.
    pub reference_steps: u32,
    /// The difference of its last two runs.
    pub uncertainty: f64,
    /// Cost of the search, in evaluations of FrBD with one spring.
    pub search_cost: f64,
    /// The quantity of the scene.
    pub quantity: Quantity,
    /// The time between two answers \[s\].
    pub interval: f64,
}

impl Choice {
    /// The step of a run, as a table shows it.
    fn step(&self, level: Level, steps: u32) -> String {
        let step = Number(self.interval / f64::from(steps));
        level.method.map_or_else(|| String::from("–"), |_| format!("{step:.3} s"))
    }
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (quantity, unit) = self.quantity.name_and_unit();
        let [quantity, unit] = [quantity, unit].map(|word| self.tolerance.units.of(word));
        let Tolerance { error, root_mean_square, .. } = self.tolerance;
        let sense = if root_mean_square { "root mean square" } else { "at every answer" };
        writeln!(f, "{quantity} within {:.3} {unit}, {sense}", Number(error))?;
        if let Some(Trial { level, .. }) = self.trials.last() {
            let (step, off) = (self.step(*level, self.reference_steps), Number(self.uncertainty));
            writeln!(f, "measured against {level}, {step}, which is settled to {off:.3} {unit}\n")?;
        }
        let (mut models, mut methods) = (5, 10);
        for Trial { level, .. } in &self.trials {
            models = models.max(level.model.chars().count());
            methods = methods.max(level.method.map_or(0, |method| method.chars().count()));
        }
        let error = format!("error / {unit}");
        let errors = 12.max(error.len() + 2);
        writeln!(
            f,
            "{:models$}  {:methods$}{:>11}{:>13}{:>8}{:>errors$}  {:10}  physics",
            "model", "method", "step", "evaluations", "cost", error, "verdict",
        )?;
        for Trial { level, steps, evaluations, cost, error, verdict, physics } in &self.trials {
            let (model, method) = (level.model, level.method.unwrap_or("evaluation"));
            let (step, cost, error) = (self.step(*level, *steps), Number(*cost), Number(*error));
            write!(f, "{model:models$}  {method:methods$}{step:>11}{evaluations:>13}")?;
            write!(f, "{cost:>8.3}{error:>errors$.3}  {verdict:10}")?;
            match physics {
                Some((name, value)) => writeln!(f, "  {name} {:.3}", Number(*value))?,
                None => writeln!(f)?,
            }
        }
        write!(f, "\ntake: {}", self.best.level)?;
        if self.best.level.method.is_some() {
            write!(f, ", {}", self.step(self.best.level, self.best.steps))?;
        }
        Ok(())
    }
}

/// What keeps a reference from being one, and what to do.
fn unsettled(unit: &str, (difference, allowed): (f64, f64), (steps, fewest): (u32, u32)) -> String {
    const BUDGET: &str = "give a larger budget, unless roundings decide about this scene";
    if steps < fewest {
        return format!(
            "the inputs of the scene are not resolved, which takes at least {fewest}; give a \
             larger budget, or answers at shorter intervals"
        );
    }
    if difference.is_nan() {
        return format!(
            "the reference has an answer that is not finite, or no second run within the budget; \
             {BUDGET}"
        );
    }
    let (off, most) = (Number(difference), Number(allowed));
    if difference <= SETTLED * allowed {
        return format!(
            "two runs of the reference agree within {off:.3} {unit}, but the budget ends before \
             the finer ones that would confirm it; give a larger budget"
        );
    }
    format!(
        "two runs of the reference differ by {off:.3} {unit}, more than {SETTLED} times the \
         {most:.3} {unit} allowed; {BUDGET}"
    )
}

/// Why there is no answer.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FidelityError {
    /// A number that is out of its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A level that belongs to another scene.
    #[error("this scene has no {0}")]
    NoSuchLevel(Level),
    /// Runs of the reference keep on differing: the scene needs shorter steps than the budget
    /// allows, or roundings decide about it.
    #[error(
        "undetermined: with {steps} steps from one answer to the next {}",
        unsettled(units.of(quantity.name_and_unit().1), (*difference, *allowed), (*steps, *fewest))
    )]
    Undetermined {
        /// The quantity of the scene.
        quantity: Quantity,
        /// By how much the last two runs differ, in its unit; NaN if an answer is not finite, or if
        /// the budget does not allow for two runs.
        difference: f64,
        /// The error allowed.
        allowed: f64,
        /// Steps from one answer to the next in the last run.
        steps: u32,
        /// Those that resolve the inputs of the scene
        /// ([`Scene::fewest_steps`](crate::Scene::fewest_steps)).
        fewest: u32,
        /// In which units it prints.
        units: Units,
    },
    /// The integration behind a run stopped.
    #[error(transparent)]
    Stopped(#[from] bristle::ode::StopReason),
}
