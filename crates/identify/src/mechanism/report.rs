//! The result of a fit, and the model that the crate runs.

use core::fmt;

use super::criteria::{Criterion, Errors};
use super::friction::{Friction, Gear, GearParameters};
use super::joint::Model;
use super::log::{DriveLog, Source};
use super::smooth::{SmoothedLog, smooth};
use crate::Fit;
use bristle::number::Number;
use bristle::parameter::{Named, ParameterError};
use bristle_joint::{GearFriction, Gravity};

/// Errors by one criterion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Score {
    /// Root mean square.
    pub rmse: f64,
    /// Mean size.
    pub mean_absolute: f64,
}

impl Score {
    /// Of residuals; NaN where there is none.
    pub(super) fn of<'a>(residuals: impl Iterator<Item = &'a f64> + Clone) -> Self {
        let count = residuals.clone().count() as f64;
        let squares: f64 = residuals.clone().map(|r| r * r).sum();
        let sizes: f64 = residuals.map(|r| r.abs()).sum();
        Self { rmse: (squares / count).sqrt(), mean_absolute: sizes / count }
    }
}

/// Errors by all three criteria.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scores {
    /// Of the equation of motion [N m].
    pub inverse: Score,
    /// Of the position over segments \[rad\].
    pub segments: Score,
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
    pub fit: Fit,
    /// Length of the segments \[s\] that were fitted last; infinite for whole logs, zero for the
    /// inverse criterion.
    pub horizon: f64,
    /// Lengths of the last segments that were compared, by the errors of the parameters which the
    /// noise of drive and position leads one to expect: the longest one that is nearly the best was
    /// fitted. Empty where the lengths were given, or no drive is noisy: the last ones are then
    /// whole logs.
    pub expected: Vec<ExpectedError>,
    /// Length of the segments of the reported criterion \[s\].
    pub segment: f64,
    /// Errors on the logs that were fitted.
    pub fitted: GroupScores,
    /// Errors on the logs held out.
    pub held_out: Option<GroupScores>,
    /// Runs with derivatives, of all starts.
    pub gradient_runs: usize,
    /// Most runs: [`Settings::gradient_runs`](super::Settings::gradient_runs).
    pub run_limit: usize,
    /// The simpler candidate from whose result the search has ended best; none if that was from the
    /// logs.
    pub origin: Option<Friction>,
    pub(super) model: Model,
}

impl Model {
    /// Errors on logs by a criterion, on all of them together, then log by log; NaN where the model
    /// has no answer.
    pub(super) fn errors(
        &self,
        values: &[f64],
        logs: &[SmoothedLog<'_>],
        criterion: Criterion,
    ) -> Vec<Score> {
        let parts = Errors::new(self, logs, criterion).by_log(values);
        let parts = parts.unwrap_or_else(|_| vec![Vec::new(); logs.len()]);
        let all = Score::of(parts.iter().flatten().flatten());
        let each = parts.iter().map(|ours| Score::of(ours.iter().flatten()));
        core::iter::once(all).chain(each).collect()
    }

    /// Errors by all three criteria, with segments of a length.
    pub(super) fn scores(
        &self,
        values: &[f64],
        logs: &[SmoothedLog<'_>],
        segment: f64,
    ) -> Result<GroupScores, ParameterError> {
        self.check(logs)?;
        let segments = [segment, f64::INFINITY].map(Criterion::Segments);
        let by = [Criterion::Inverse, segments[0], segments[1]];
        let by = by.map(|criterion| self.errors(values, logs, criterion));
        let scores = |row: usize| {
            let [inverse, segments, simulated] = by.each_ref().map(|scores| scores[row]);
            Scores { inverse, segments, simulated }
        };
        Ok(GroupScores { all: scores(0), each: (1..=logs.len()).map(scores).collect() })
    }

    /// Refuses logs of a drive whose constants are not among the parameters.
    fn check(&self, logs: &[SmoothedLog<'_>]) -> Result<(), ParameterError> {
        let lacks = |name| !self.table.parameters.iter().any(|parameter| parameter.name == name);
        let (constant, resistance) = (lacks("torque_constant"), lacks("resistance"));
        let is_foreign = |source: &Source| {
            constant && *source != Source::Torque || resistance && source.is_electric()
        };
        if logs.iter().any(|smoothed| is_foreign(&smoothed.log.source)) {
            return Err(ParameterError::chosen(
                "an electric drive",
                "this fit takes logs of torque",
            ));
        }
        Ok(())
    }
}

impl JointFit {
    /// The value of a parameter by its name; of those that each log has for itself, the mean.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.model.table.value(&self.fit.values(), usize::MAX, name)
    }

    /// Number of parameters that were searched.
    pub fn searched(&self) -> usize {
        let estimates = self.fit.estimates.iter();
        estimates.filter(|e| e.parameter.least < e.parameter.most).count()
    }

    /// The position \[rad\] at every row of a log, simulated from the first on.
    ///
    /// # Errors
    ///
    /// Refuses a log of a drive that the fit has no constants of, and a simulation that is not
    /// finite.
    pub fn simulate(&self, log: &DriveLog) -> Result<Vec<f64>, ParameterError> {
        let smoothed = [smooth(log)];
        self.model.check(&smoothed)?;
        let mut positions = log.position.clone();
        let whole = Errors::new(&self.model, &smoothed, Criterion::Segments(f64::INFINITY));
        let parts = whole.by_log(&self.fit.values())?;
        let pieces = log.pieces().into_iter().filter(|piece| piece.len() > 1);
        for (piece, errors) in pieces.zip(parts.iter().flatten()) {
            for (row, &error) in piece.skip(1).zip(errors) {
                ParameterError::of_component(row, Named("simulated position", error).finite())?;
                positions.iter_mut().skip(row).take(1).for_each(|x| *x += error);
            }
        }
        Ok(positions)
    }

    /// The joint with these parameters, for simulations and control. Parameters that each log has
    /// for itself are their means; terms of your own are not in it.
    ///
    /// # Errors
    ///
    /// None for the parameters that were found.
    pub fn model(&self) -> Result<JointModel, ParameterError> {
        let of = |name| self.value(name).unwrap_or(0.0);
        Ok(JointModel {
            inertia: of("inertia"),
            torque_constant: self.value("torque_constant"),
            resistance: self.value("resistance"),
            duty_exponent: self.value("duty_exponent"),
            gravity: self.value("gravity_torque").map(|horizontal_torque| Gravity {
                horizontal_torque,
                hanging_angle: of("hanging_angle"),
            }),
            offset_torque: of("offset_torque"),
            spring_rate: of("spring_rate"),
            gear: self.friction.gear(|name| self.value(name), self.model.fastest)?,
        })
    }
}

/// A joint as it was identified. What logs [know](super::KnownLoad) of their loads is not in it.
///
/// With the feature `serde` it is written to a file and read again.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct JointModel {
    /// Moment of inertia [kg m²].
    pub inertia: f64,
    /// Torque constant [N m/A], if the drive has one.
    pub torque_constant: Option<f64>,
    /// Resistance \[Ω\], if the drive has one.
    pub resistance: Option<f64>,
    /// Exponent of the duty \[–\], if it was searched.
    pub duty_exponent: Option<f64>,
    /// Gravity, if the joint has that term.
    pub gravity: Option<Gravity<f64>>,
    /// Constant torque on the load side [N m].
    pub offset_torque: f64,
    /// Rate of a spring on the load side [N m/rad].
    pub spring_rate: f64,
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
    pub fn gear(&self) -> Result<Gear<f64>, ParameterError> {
        GearFriction::new(self.gear.clone())
    }
}

impl fmt::Display for JointFit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "friction: {}", self.friction)?;
        writeln!(f, "{}", self.fit)?;
        match self.horizon {
            f64::INFINITY => write!(f, "fitted: positions of whole logs")?,
            0.0 => write!(f, "fitted: torques")?,
            _ => write!(f, "fitted: positions over segments of {:.3} s", Number(self.horizon))?,
        }
        let Self { gradient_runs, run_limit, .. } = self;
        write!(f, ", {gradient_runs} runs with derivatives of at most {run_limit}, best ")?;
        match self.origin {
            Some(simpler) => writeln!(f, "from the result of {simpler}")?,
            None => writeln!(f, "from the logs")?,
        }
        if !self.expected.is_empty() {
            write!(f, "by the noise of drive and position, relative standard errors over")?;
            for ExpectedError { length, ratio } in &self.expected {
                match length {
                    &f64::INFINITY => write!(f, " whole logs {:.3},", Number(*ratio))?,
                    _ => write!(f, " {:.3} s {:.3},", Number(*length), Number(*ratio))?,
                }
            }
            writeln!(f, " the longest that is nearly the least is fitted")?;
        }
        let segment = Number(self.segment);
        write!(f, "rmse (mean size)  torque [N m]       {segment:.3} s [rad] ")?;
        writeln!(f, "    whole logs [rad]")?;
        let mut row = |name: &str, scores: &Scores| {
            write!(f, "{name:15}")?;
            for score in [scores.inverse, scores.segments, scores.simulated] {
                let (rmse, mean) = (Number(score.rmse), Number(score.mean_absolute));
                write!(f, " {rmse:>9.4} ({mean:>8.4})")?;
            }
            writeln!(f)
        };
        let groups = [("fitted", Some(&self.fitted)), ("held out", self.held_out.as_ref())];
        for (name, GroupScores { all, each }) in
            groups.into_iter().filter_map(|(name, group)| Some((name, group?)))
        {
            row(name, all)?;
            for (number, scores) in each.iter().enumerate().filter(|_| each.len() > 1) {
                row(&format!("  log {number}"), scores)?;
            }
        }
        Ok(())
    }
}
