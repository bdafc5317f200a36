//! The result of a fit, and the model that the crate runs.

use core::fmt;

use super::criteria::{Criterion, Errors};
use super::friction::Friction;
use super::joint::Model;
use super::log::{DriveLog, Source};
use super::plant::Plant;
use super::smooth::{SmoothedLog, smooth};
use crate::Fit;
use bristle::AnyBristle;
use bristle::number::Number;
use bristle::parameter::{self, ParameterError};
use bristle_joint::{GearFriction, GearFrictionParameters, Gravity, TorqueLoad};

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

/// The parameters of a joint and its friction, from [`fit`](super::fit()). Prints as a table.
#[derive(Debug, Clone)]
pub struct JointFit {
    /// The candidate.
    pub friction: Friction,
    /// Its parameters with standard errors, what the data say of them, and how the search ended.
    pub fit: Fit,
    /// Length of the segments \[s\] that were fitted last; infinite for whole logs, zero for the
    /// inverse criterion.
    pub horizon: f64,
    /// Length of the segments of the reported criterion \[s\].
    pub segment: f64,
    /// Errors on the logs that were fitted.
    pub fitted: Scores,
    /// Errors on the logs held out.
    pub held_out: Option<Scores>,
    /// Errors on each log that was fitted.
    pub fitted_logs: Vec<Scores>,
    /// Errors on each log held out.
    pub held_out_logs: Vec<Scores>,
    /// Runs with derivatives.
    pub gradient_runs: usize,
    pub(super) model: Model,
}

impl JointFit {
    /// With the lengths of the segments that were fitted last and are reported, and no errors yet.
    pub(super) fn new(
        model: Model,
        fit: Fit,
        [horizon, segment]: [f64; 2],
        gradient_runs: usize,
    ) -> Self {
        let none = Score { rmse: f64::NAN, mean_absolute: f64::NAN };
        Self {
            friction: model.friction,
            fit,
            horizon,
            segment,
            fitted: Scores { inverse: none, segments: none, simulated: none },
            held_out: None,
            fitted_logs: Vec::new(),
            held_out_logs: Vec::new(),
            gradient_runs,
            model,
        }
    }

    /// The value of a parameter by its name; of those that each log has for itself, the mean.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.model.table.value(&self.fit.values(), usize::MAX, name)
    }

    /// Number of parameters that were searched.
    pub fn searched(&self) -> usize {
        self.model.table.searched()
    }

    /// The residuals of logs by a criterion, log by log and part by part.
    pub(super) fn residuals(
        &self,
        logs: &[SmoothedLog<'_>],
        criterion: Criterion,
    ) -> Result<Vec<Vec<Vec<f64>>>, ParameterError> {
        Errors::new(&self.model, logs, criterion).by_log(&self.fit.values())
    }

    /// Errors on logs by a criterion, on all of them and log by log; NaN where the model has no
    /// answer.
    pub(super) fn by_log(
        &self,
        logs: &[SmoothedLog<'_>],
        criterion: Criterion,
    ) -> (Score, Vec<Score>) {
        let parts = self.residuals(logs, criterion);
        let parts = parts.unwrap_or_else(|_| vec![Vec::new(); logs.len()]);
        let all = Score::of(parts.iter().flatten().flatten());
        (all, parts.iter().map(|ours| Score::of(ours.iter().flatten())).collect())
    }

    /// Takes the errors on the logs that were fitted and on those held out.
    pub(super) fn score(
        &mut self,
        fitted: &[SmoothedLog<'_>],
        held_out: &[DriveLog],
    ) -> Result<(), ParameterError> {
        (self.fitted, self.fitted_logs) = self.scores(fitted)?;
        if !held_out.is_empty() {
            let held_out: Vec<_> = held_out.iter().map(smooth).collect();
            let (all, each) = self.scores(&held_out)?;
            (self.held_out, self.held_out_logs) = (Some(all), each);
        }
        Ok(())
    }

    /// Errors by all three criteria, on all logs and log by log.
    fn scores(&self, logs: &[SmoothedLog<'_>]) -> Result<(Scores, Vec<Scores>), ParameterError> {
        self.check(logs)?;
        let segments = [self.segment, f64::INFINITY].map(Criterion::Segments);
        let by = [Criterion::Inverse, segments[0], segments[1]].map(|c| self.by_log(logs, c));
        let scores = |of: &dyn Fn(&(Score, Vec<Score>)) -> Score| {
            let [inverse, segments, simulated] = by.each_ref().map(of);
            Scores { inverse, segments, simulated }
        };
        let each = (0..logs.len()).map(|log| scores(&|(_, each)| each[log])).collect();
        Ok((scores(&|(all, _)| *all), each))
    }

    /// Refuses logs of a drive that the fit has no constants of.
    fn check(&self, logs: &[SmoothedLog<'_>]) -> Result<(), ParameterError> {
        let lacks = |name| self.value(name).is_none();
        let (constant, resistance) = (lacks("torque_constant"), lacks("resistance"));
        let is_foreign = |source: &Source| {
            constant && *source != Source::Torque || resistance && source.is_electric()
        };
        if logs.iter().any(|smoothed| is_foreign(&smoothed.log.source)) {
            return Err(parameter::chosen("an electric drive", "this fit takes logs of torque"));
        }
        Ok(())
    }

    /// The position \[rad\] at every row of a log, simulated from the first on.
    ///
    /// # Errors
    ///
    /// Refuses a log of a drive that the fit has no constants of, and a simulation that is not
    /// finite.
    pub fn simulate(&self, log: &DriveLog) -> Result<Vec<f64>, ParameterError> {
        let smoothed = [smooth(log)];
        self.check(&smoothed)?;
        let mut positions = log.position.clone();
        let parts = self.residuals(&smoothed, Criterion::Segments(f64::INFINITY))?;
        let pieces = log.pieces().into_iter().filter(|piece| piece.len() > 1);
        for (piece, errors) in pieces.zip(parts.iter().flatten()) {
            for (row, &error) in piece.skip(1).zip(errors) {
                parameter::component(row, parameter::finite("simulated position", error))?;
                positions.iter_mut().skip(row).take(1).for_each(|x| *x += error);
            }
        }
        Ok(positions)
    }

    /// The mechanism of a log.
    pub(super) fn plant<'a>(
        &'a self,
        smoothed: &'a SmoothedLog<'_>,
        number: usize,
    ) -> Result<Plant<'a, f64>, ParameterError> {
        Plant::new(&self.model, smoothed, number, &self.fit.values())
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
    pub gear: GearFrictionParameters<f64, AnyBristle<f64>, TorqueLoad<f64>>,
}

impl JointModel {
    /// The friction of the gear, for [`GearedJoint`](bristle_joint::GearedJoint) or steps of your
    /// own.
    ///
    /// # Errors
    ///
    /// Refuses a drag that was changed to be negative or not finite.
    pub fn gear(
        &self,
    ) -> Result<GearFriction<f64, AnyBristle<f64>, TorqueLoad<f64>>, ParameterError> {
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
        writeln!(f, ", {} runs with derivatives", self.gradient_runs)?;
        let segment = Number(self.segment);
        writeln!(
            f,
            "rmse (mean size)  torque [N m]       {segment:.3} s [rad]     whole logs [rad]"
        )?;
        let mut row = |name: &str, scores: &Scores| {
            write!(f, "{name:15}")?;
            for Score { rmse, mean_absolute } in [scores.inverse, scores.segments, scores.simulated]
            {
                write!(f, " {:>9.4} ({:>8.4})", Number(rmse), Number(mean_absolute))?;
            }
            writeln!(f)
        };
        let groups = [
            ("fitted", Some(&self.fitted), &self.fitted_logs),
            ("held out", self.held_out.as_ref(), &self.held_out_logs),
        ];
        for (name, all, logs) in groups {
            all.iter().try_for_each(|scores| row(name, scores))?;
            for (number, scores) in logs.iter().enumerate().filter(|_| logs.len() > 1) {
                row(&format!("  log {number}"), scores)?;
            }
        }
        Ok(())
    }
}
