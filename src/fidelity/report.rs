//! What the search answers.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt;

use super::choose::{Norm, Tolerance};
use super::scene::{Level, Plan, Quantity, Refinement};
use crate::parameter::ParameterError;

/// What a level came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Verdict {
    /// Its answers are within the tolerance.
    Enough,
    /// They are not, and more steps do not help: it is the model.
    NotEnough,
    /// They are not, and with more steps it would cost more than another level that is enough.
    TooDear,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Verdict::Enough => "enough",
            Verdict::NotEnough => "not enough",
            Verdict::TooDear => "too dear",
        })
    }
}

/// A level with the coarsest steps that are enough, or else the finest that were tried.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Trial {
    /// The plan.
    pub plan: Plan,
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

/// The cheapest plan that is good enough, and what was measured on the way.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Choice {
    /// The plan.
    pub plan: Plan,
    /// Evaluations of the friction model over the scene, counted.
    pub evaluations: u64,
    /// Their cost, in evaluations of FrBD with one spring.
    pub cost: f64,
    /// The error against the reference, measured at every answer.
    pub error: f64,
    /// What was asked for.
    pub tolerance: Tolerance,
    /// Every level, from the cheapest model to the reference.
    pub trials: Vec<Trial>,
    /// The finest run of the reference.
    pub reference: Plan,
    /// By how much its last two runs differ.
    pub uncertainty: f64,
    /// What the search has cost, in evaluations of FrBD with one spring.
    pub search_cost: f64,
    /// The quantity of the scene.
    pub quantity: Quantity,
    /// The time between two answers \[s\].
    pub interval: f64,
}

/// A number to three digits, with an exponent where it is very small or very large.
struct Three(f64);

impl fmt::Display for Three {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        if !size.is_finite() {
            return f.pad("–");
        }
        if size > 0.0 && !(1e-3..1e5).contains(&size) {
            return f.pad(&format!("{:.2e}", self.0));
        }
        // Digits after the point: two for a number of one digit.
        let before = if size > 0.0 { nalgebra::ComplexField::log10(size) } else { 2.0 };
        let decimals = (2.0 - nalgebra::ComplexField::floor(before)).clamp(0.0, 5.0) as usize;
        f.pad(&format!("{:.decimals$}", self.0))
    }
}

impl Choice {
    /// The step of a plan, as a table shows it.
    fn step(&self, plan: &Plan) -> String {
        match plan.level.refinement {
            Refinement::Memoryless => String::from("–"),
            Refinement::Steps => format!("{} s", Three(self.interval / f64::from(plan.steps))),
            Refinement::ErrorControl => format!("tol {:.0e}", plan.error_control()),
        }
    }
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (quantity, unit) = self.quantity.name_and_unit();
        let sense = match self.tolerance.norm {
            Norm::Greatest => "at every answer",
            Norm::RootMeanSquare => "root mean square",
        };
        writeln!(f, "{quantity} within {} {unit}, {sense}", Three(self.tolerance.error))?;
        let Level { model, method, .. } = self.reference.level;
        let (step, off) = (self.step(&self.reference), Three(self.uncertainty));
        writeln!(
            f,
            "measured against {model}, {method}, {step}, which is settled to {off} {unit}"
        )?;
        let error = format!("error / {unit}");
        writeln!(
            f,
            "\n{:18}{:11}{:>10}{:>12}{:>8}{:>12} {:11}physics",
            "model", "method", "step", "evaluations", "cost", error, "verdict",
        )?;
        for Trial { plan, evaluations, cost, error, verdict, physics } in &self.trials {
            let Level { model, method, .. } = plan.level;
            let (step, cost, error) = (self.step(plan), Three(*cost), Three(*error));
            write!(f, "{model:18}{method:11}{step:>10}{evaluations:>12}{cost:>8}{error:>12} ")?;
            match physics {
                Some((name, value)) => writeln!(f, "{verdict:11}{name} {}", Three(*value))?,
                None => writeln!(f, "{verdict}")?,
            }
        }
        let Level { model, method, refinement } = self.plan.level;
        write!(f, "\ntake: {model}")?;
        if refinement != Refinement::Memoryless {
            write!(f, ", {method}, {}", self.step(&self.plan))?;
        }
        Ok(())
    }
}

/// Why there is no answer.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FidelityError {
    /// A number that is out of its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A plan that belongs to another scene.
    #[error("this scene has no {}, {}", level.model, level.method)]
    NoSuchLevel {
        /// The level of the plan.
        level: Level,
    },
    /// Runs of the reference keep on differing: the scene needs shorter steps than the budget
    /// allows, or roundings decide about it.
    #[error(
        "undetermined: with {steps} steps from one answer to the next the reference still changes \
         by {difference:.2e} {unit} where {allowed:.2e} {unit} are allowed; give a larger budget, \
         unless roundings decide about this scene",
        unit = quantity.name_and_unit().1
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
    },
    /// A run stopped.
    #[error("{}, {} stopped at t = {time} s: {reason}", level.model, level.method)]
    Stopped {
        /// The level.
        level: Level,
        /// The time \[s\].
        time: f64,
        /// Why.
        reason: crate::ode::StopReason,
    },
}
