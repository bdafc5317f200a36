//! Comparison of candidates on logs that were not fitted: no more model than the data carries.
//!
//! The score of a candidate is the mean square e² of the simulated position over the logs held
//! out. Cut into windows, ten in each log, it has a standard error s/√n, with the deviation s of
//! the n windows. Among the candidates within one standard error of the best, the one with the
//! fewest parameters is named. A search that has not converged says nothing of its candidate, which
//! is then neither the best nor named.
//!
//! Source: L. Breiman, J. H. Friedman, R. A. Olshen, C. J. Stone, "Classification and Regression
//! Trees" (1984), section 3.4.3.

use core::fmt;
use core::ops::ControlFlow;

use super::criteria::{Criterion, Errors};
use super::fit::{Progress, Settings, fit_candidate, fit_joint};
use super::friction::Friction;
use super::joint::Joint;
use super::log::DriveLog;
use super::report::{JointFit, Score};
use super::smooth::{SmoothedLog, smooth};
use crate::SearchOutcome;
use bristle::number::Number;
use bristle::parameter::{Named, ParameterError, Rule};

/// Windows in each log.
const WINDOWS: usize = 10;

/// Candidates and their errors on logs that were not fitted, from [`compare`]. Prints as a table.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// The candidates that were fitted.
    pub fits: Vec<JointFit>,
    /// Candidates that were refused, and why.
    pub refused: Vec<(Friction, ParameterError)>,
    /// Place of the candidate with the least error on the logs held out, among those whose search
    /// has converged.
    pub best: Option<usize>,
    /// Place of the simplest of these within one standard error of it.
    pub simplest: Option<usize>,
    /// Standard error of the best mean square \[rad²\]; NaN if no search has converged.
    pub standard_error: f64,
}

/// Fits all candidates to the logs `fitted`, and names the simplest one that predicts the logs
/// `held_out` as well as the best. Each candidate is started from the logs and from those before it
/// that it contains, and never ends above them: put the simpler ones first.
///
/// The callback can stop: the candidates so far are compared.
///
/// # Errors
///
/// Refuses no candidate and no logs held out. If [`fit_joint`](super::fit_joint) refuses all
/// candidates, the first reason.
pub fn compare(
    joint: &Joint,
    candidates: &[Friction],
    fitted: &[DriveLog],
    held_out: &[DriveLog],
    settings: &Settings,
    progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
) -> Result<Comparison, ParameterError> {
    Named("candidates", candidates.len()).count(1)?;
    Named("logs held out", held_out.len()).count(1)?;
    let (mut fits, mut refused) = (Vec::<JointFit>::new(), Vec::new());
    for (candidate, friction) in candidates.iter().enumerate() {
        let contained = fits.iter().filter(|fit| friction.contains(&fit.friction));
        let contained: Vec<_> = contained.collect();
        let mut watch = |now: &Progress<'_>| progress(&Progress { candidate, ..*now });
        let found = if contained.is_empty() {
            fit_joint(joint, friction, fitted, held_out, settings, &mut watch)
        } else {
            let logs = [fitted, held_out];
            fit_candidate(joint, friction, logs, settings, &contained, &mut watch)
        };
        match found {
            Ok(fit) => fits.push(fit),
            Err(error) => refused.push((*friction, error)),
        }
        if fits.last().is_some_and(|fit| fit.fit.outcome == SearchOutcome::Stopped) {
            break;
        }
    }
    let smoothed: Vec<_> = held_out.iter().map(smooth).collect();
    if fits.is_empty() {
        let none = Named("candidates", 0.0).refused(Rule::Count { least: 1 });
        return Err(refused.first().map_or(none, |(_, error)| *error));
    }
    // Mean square and standard error, number of parameters, and place of each.
    let converged = fits.iter().enumerate();
    let converged = converged.filter(|(_, fit)| fit.fit.outcome == SearchOutcome::Converged);
    let score = |(place, fit): (usize, &JointFit)| {
        let (mean, error) = mean_and_error(&windows(fit, &smoothed));
        (mean, error, fit.searched(), place)
    };
    let scores: Vec<_> = converged.map(score).collect();
    let best = scores.iter().min_by(|a, b| a.0.total_cmp(&b.0));
    let standard_error = best.map_or(f64::NAN, |best| best.1);
    let near = scores.iter().filter(|s| best.is_some_and(|best| s.0 <= best.0 + best.1));
    let simplest = near.min_by(|a, b| a.2.cmp(&b.2).then(a.0.total_cmp(&b.0)));
    let [best, simplest] = [best, simplest].map(|score| score.map(|score| score.3));
    Ok(Comparison { fits, refused, best, simplest, standard_error })
}

/// Mean squares of the errors of whole logs, window by window.
fn windows(fit: &JointFit, logs: &[SmoothedLog<'_>]) -> Vec<f64> {
    let mut squares = Vec::new();
    let whole = Errors::new(&fit.model, logs, Criterion::Segments(f64::INFINITY));
    let parts = whole.by_log(&fit.fit.values());
    for part in parts.iter().flatten().flatten() {
        let length = part.len().div_ceil(WINDOWS).max(1);
        let mean = |window: &[f64]| window.iter().map(|r| r * r).sum::<f64>() / length as f64;
        squares.extend(part.chunks(length).map(mean));
    }
    squares
}

/// The mean of values and its standard error; infinite where a value is not finite or there is
/// none.
fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
    let error = (squares / (count * (count - 1.0))).sqrt();
    let known = mean.is_finite() && error.is_finite();
    (if mean.is_finite() { mean } else { f64::INFINITY }, if known { error } else { 0.0 })
}

impl Comparison {
    /// The simplest candidate within one standard error of the best; none where no search has
    /// converged.
    pub fn named(&self) -> Option<&JointFit> {
        self.fits.get(self.simplest?)
    }
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:20} free  fitted on   on these: rmse (mean size)", "whole logs [rad]")?;
        writeln!(f, "   held out: rmse (mean size)   search")?;
        for (i, fit) in self.fits.iter().enumerate() {
            let over = match fit.horizon {
                f64::INFINITY => "whole logs".into(),
                0.0 => "torques".into(),
                length => format!("{:.3} s", Number(length)),
            };
            write!(f, "{:20} {:>4} {over:>10}", fit.friction, fit.searched())?;
            for scores in [&fit.fitted, fit.held_out.as_ref().unwrap_or(&fit.fitted)] {
                let Score { rmse, mean_absolute } = scores.all.simulated;
                let (rmse, mean) = (Number(rmse), Number(mean_absolute));
                write!(f, "   {rmse:>13.4} ({mean:>9.4})")?;
            }
            let mark = match [self.simplest, self.best].map(|place| place == Some(i)) {
                [true, true] => "  <- best and simplest",
                [true, false] => "  <- simplest within one standard error",
                [false, true] => "  <- best",
                [false, false] => "",
            };
            writeln!(f, "   {}{mark}", fit.fit.outcome)?;
        }
        for (friction, error) in &self.refused {
            writeln!(f, "{friction:20} refused: {error}")?;
        }
        match self.named() {
            Some(named) => write!(f, "\n{named}"),
            None => writeln!(f, "\nno search has converged: no candidate is named"),
        }
    }
}
