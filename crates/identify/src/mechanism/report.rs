//! The result of a fit, and the model that the crate runs.

use core::fmt;
use std::collections::BTreeMap;

use super::criteria::{Errors, INVERSE, WHOLE};
use super::friction::{Friction, Gear, GearParameters};
use super::joint::{INITIAL, Joint, Model, Term, input};
use super::log::{DriveLog, Source};
use crate::Fit;
use bristle::number::Number;
use bristle::parameter::{Checked, Named, ParameterError};
use bristle_joint::{GearFriction, JointInput, JointInputValue, JointMotion};

/// Errors by one criterion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Score {
    /// Root mean square.
    pub rmse: f64,
    /// Mean size.
    pub mean_absolute: f64,
    /// Root mean square over that of the torque of the motor, of positions over the standard
    /// deviation of the motion \[–\].
    pub relative: f64,
}

impl Score {
    /// Of residuals, and of the sum of squares to which they are compared; NaN where there is none.
    fn of<'a>(residuals: impl Iterator<Item = &'a f64> + Clone, whole: f64) -> Self {
        let count = residuals.clone().count() as f64;
        let squares: f64 = residuals.clone().map(|r| r * r).sum();
        let sizes: f64 = residuals.map(|r| r.abs()).sum();
        let relative = (squares / whole).sqrt();
        Self { rmse: (squares / count).sqrt(), mean_absolute: sizes / count, relative }
    }
}

/// Errors by two criteria.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scores {
    /// Of the equation of motion [N m].
    pub inverse: Score,
    /// Of the position over whole logs \[rad\].
    pub simulated: Score,
}

/// What a length of the segments leads one to expect of the standard errors, see
/// [`JointFit::expected`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExpectedError {
    /// Length of the segments \[s\], infinite for whole logs.
    pub length: f64,
    /// Geometric mean of the expected errors of all parameters over that of the best length \[–\].
    pub ratio: f64,
}

/// Errors on a group of logs.
#[derive(Debug, Clone, PartialEq)]
pub struct GroupScores {
    /// On all of them together.
    pub all: Scores,
    /// Log by log.
    pub each: Vec<Scores>,
}

/// The parameters of a joint and its friction, from [`fit_joint`](super::fit_joint). Prints as a
/// table.
#[derive(Debug, Clone)]
pub struct JointFit {
    /// The candidate.
    pub friction: Friction,
    /// Its parameters with standard errors, what the data say of them, and how the search ended.
    /// [`Fit::rmse`] is that of the least squares; of a noisy drive the values are those without
    /// the bias that its noise gives them.
    pub fit: Fit,
    /// Length of the segments \[s\] that were fitted last; infinite for whole logs, zero for the
    /// inverse criterion.
    pub horizon: f64,
    /// Lengths of the last segments that were compared, by the errors of the parameters which the
    /// noise of drive and position leads one to expect: the best one was fitted. Empty where the
    /// lengths were given, or no drive is noisy: the last ones are then whole logs.
    pub expected: Vec<ExpectedError>,
    /// Root mean square of the residuals that the noise of drive and position explains, if there
    /// is any. The rest is the model's, and may be in the parameters.
    pub noise: Option<f64>,
    /// Errors on the logs that were fitted.
    pub fitted: GroupScores,
    /// Errors on the logs held out.
    pub held_out: Option<GroupScores>,
    /// Runs with derivatives, of all starts.
    pub gradient_runs: usize,
    /// Most runs: [`Settings::gradient_runs`](super::Settings::gradient_runs).
    pub run_limit: usize,
    pub(super) model: Model,
}

impl Model {
    /// Errors on logs over segments of a length, on all logs together, then log by log; NaN where
    /// the model has no answer.
    pub(super) fn errors(
        &self,
        values: &[f64],
        logs: &[DriveLog],
        length: f64,
    ) -> (Score, Vec<Score>) {
        let errors = Errors::new(self, logs, length);
        let parts = errors.by_log(values).unwrap_or_else(|_| vec![Vec::new(); logs.len()]);
        let wholes = logs.iter().enumerate().map(|(i, log)| errors.whole(i, log, values));
        let all = Score::of(parts.iter().flatten(), wholes.clone().sum());
        let each = parts.iter().zip(wholes).map(|(ours, whole)| Score::of(ours.iter(), whole));
        (all, each.collect())
    }

    /// Errors by both criteria.
    pub(super) fn scores(&self, values: &[f64], logs: &[DriveLog]) -> Checked<GroupScores> {
        self.check(logs)?;
        let [inverse, simulated] = [INVERSE, WHOLE].map(|length| self.errors(values, logs, length));
        let both = |(inverse, simulated)| Scores { inverse, simulated };
        let each = inverse.1.into_iter().zip(simulated.1).map(both);
        Ok(GroupScores { all: both((inverse.0, simulated.0)), each: each.collect() })
    }

    /// Refuses logs of a drive whose constants are not among the parameters.
    fn check(&self, logs: &[DriveLog]) -> Checked<()> {
        let has = |name| self.parameters.iter().any(|parameter| parameter.name == name);
        let (constant, resistance) = (has("torque_constant"), has("resistance"));
        let is_ours = |log: &DriveLog| {
            (constant || log.source == Source::Torque) && (resistance || !log.source.is_electric())
        };
        let foreign = ParameterError::chosen("an electric drive", "this fit takes logs of torque");
        if logs.iter().all(is_ours) { Ok(()) } else { Err(foreign) }
    }
}

impl JointFit {
    /// The value of a parameter by its name; of those that each log has for itself, the mean.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.model.value(&self.fit.values(), usize::MAX, name)
    }

    /// Number of parameters that were searched, but for the states in which logs begin.
    pub fn searched(&self) -> usize {
        let parameters = self.fit.estimates.iter().map(|estimate| estimate.parameter);
        parameters.filter(|p| p.least < p.most && !INITIAL.contains(&p.name)).count()
    }

    /// The position \[rad\] at every row of a log, simulated from the first on.
    ///
    /// # Errors
    ///
    /// Refuses a log of a drive that the fit has no constants of, and a simulation that is not
    /// finite.
    pub fn simulate(&self, log: &DriveLog) -> Checked<Vec<f64>> {
        let errors = self.residuals(log, WHOLE)?;
        let positions: Vec<f64> = log.position.iter().zip(errors).map(|(x, e)| x + e).collect();
        ParameterError::of_components(&positions, |&x| Named("simulated position", x).finite())?;
        Ok(positions)
    }

    /// What is left of the equation of motion at every row of a log [N m], from its smoothed
    /// derivatives.
    ///
    /// # Errors
    ///
    /// Refuses a log of a drive that the fit has no constants of.
    pub fn torque_errors(&self, log: &DriveLog) -> Checked<Vec<f64>> {
        self.residuals(log, INVERSE)
    }

    /// Residuals row by row; zero at the first row of a simulation.
    fn residuals(&self, log: &DriveLog, length: f64) -> Checked<Vec<f64>> {
        let logs = core::slice::from_ref(log);
        self.model.check(logs)?;
        let values = self.model.as_measured(self.fit.values());
        let errors = Errors::new(&self.model, logs, length).by_log(&values)?;
        let mut errors = errors.into_iter().flatten();
        let (mut rows, first) = (vec![0.0; log.time.len()], usize::from(length != INVERSE));
        let pieces = log.pieces().into_iter().filter(|piece| piece.len() > 1);
        for row in pieces.flat_map(|piece| piece.skip(first)) {
            rows[row] = errors.next().unwrap_or(f64::NAN);
        }
        Ok(rows)
    }

    /// The joint with these parameters, for simulations and control. Parameters that each log has
    /// for itself are their means.
    ///
    /// # Errors
    ///
    /// None for the parameters that were found.
    pub fn model(&self) -> Checked<JointModel> {
        let names = self.model.joint.terms.iter().flat_map(Term::names).chain(&OF_JOINT);
        let found = names.filter_map(|&name| Some((name.to_owned(), self.value(name)?)));
        let gear = self.friction.gear(|name| self.value(name), self.model.fastest)?;
        Ok(JointModel { parameters: found.collect(), gear })
    }
}

/// Parameters of the joint beside those of terms and gear.
const OF_JOINT: [&str; 5] = ["inertia", "torque_constant", "resistance", "duty_exponent", "delay"];

/// A joint as it was identified. What logs [know](super::KnownLoad) of their loads is not in it.
///
/// With the feature `serde` it is written to a file and read again.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct JointModel {
    /// Values by the [names](super#names-of-the-parameters) of all parameters but those of the
    /// gear, with those of your own terms.
    pub parameters: BTreeMap<String, f64>,
    /// Friction and drag of the gear.
    pub gear: GearParameters<f64>,
}

impl JointModel {
    /// The friction of the gear, for [`GearedJoint`](bristle_joint::GearedJoint) or steps of your
    /// own.
    ///
    /// # Errors
    ///
    /// Refuses a drag that was changed to be negative or not finite.
    pub fn gear(&self) -> Checked<Gear<f64>> {
        GearFriction::new(self.gear.clone())
    }

    /// The torques of all terms, the external torque of a
    /// [`GearedJoint`](bristle_joint::GearedJoint). A file has their parameters, and the joint
    /// their functions.
    ///
    /// # Errors
    ///
    /// Refuses a joint without exactly the terms of this model.
    pub fn external(&self, joint: &Joint) -> Checked<ExternalTorque> {
        let value = |&name: &&'static str| {
            let found = self.parameters.get(name).copied();
            found.ok_or_else(|| ParameterError::chosen(name, "a model has the terms of its fit"))
        };
        let names = joint.terms.iter().flat_map(Term::names);
        let values = names.map(value).collect::<Result<Vec<_>, _>>()?;
        let of_terms = self.parameters.keys().filter(|name| !OF_JOINT.contains(&name.as_str()));
        Named("parameters of terms", values.len()).count(of_terms.count())?;
        Ok(ExternalTorque { terms: joint.terms.clone(), values })
    }
}

/// The torques of the terms of a joint as they were found, from [`JointModel::external`].
#[derive(Debug, Clone)]
pub struct ExternalTorque {
    terms: Vec<Term>,
    values: Vec<f64>,
}

impl JointInput<f64> for ExternalTorque {
    fn at(&self, JointMotion { angle, velocity, .. }: JointMotion<f64>) -> JointInputValue<f64> {
        input(Term::sum(&self.terms, &self.values, 0.0, angle, velocity))
    }
}

/// What a length of segments is called.
pub(super) fn over(length: f64) -> String {
    match length {
        f64::INFINITY => "whole logs".into(),
        0.0 => "torques".into(),
        length => format!("{:.3} s", Number(length)),
    }
}

impl fmt::Display for JointFit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "friction: {}", self.friction)?;
        writeln!(f, "{}", self.fit)?;
        write!(f, "fitted over {}", over(self.horizon))?;
        let Self { gradient_runs, run_limit, .. } = self;
        writeln!(f, ", {gradient_runs} runs with derivatives of at most {run_limit}")?;
        if let Some(noise) = self.noise {
            let (noise, share) = (Number(noise), Number(self.fit.rmse / noise));
            write!(
                f,
                "residuals are {share:.2} times the {noise:.2} that the noise of drive and "
            )?;
            let more = ": the rest is the model's, and may be in the parameters";
            writeln!(f, "position explains{}", if share.0 > 2.0 { more } else { "" })?;
        }
        if !self.expected.is_empty() {
            write!(f, "by the noise of drive and position, relative standard errors over")?;
            for ExpectedError { length, ratio } in &self.expected {
                write!(f, " {} {:.3},", over(*length), Number(*ratio))?;
            }
            writeln!(f, " the length of the least is fitted")?;
        }
        let [torque, length] = ["N", "m"].map(|unit| self.model.joint.unit(unit));
        writeln!(f, "rmse (mean size, relative)  {torque:26} {length}, whole logs")?;
        let fitted = ("fitted", "log", Some(&self.fitted));
        for (name, what, group) in [fitted, ("held out", "held-out log", self.held_out.as_ref())] {
            let Some(GroupScores { all, each }) = group else { continue };
            writeln!(f, "{name:27} {:26} {}", all.inverse, all.simulated)?;
            for (log, scores) in each.iter().enumerate().filter(|_| each.len() > 1) {
                let name = format!("  {what} {log}");
                writeln!(f, "{name:27} {:26} {}", scores.inverse, scores.simulated)?;
            }
        }
        Ok(())
    }
}

impl fmt::Display for Score {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (rmse, mean) = (Number(self.rmse), Number(self.mean_absolute));
        f.pad(&format!("{rmse:.3} ({mean:.3}, {:.1} %)", 100.0 * self.relative))
    }
}
