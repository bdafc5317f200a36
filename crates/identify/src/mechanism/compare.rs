//! Comparison of candidates by logs that were left out: no more model than the data carries.
//!
//! Each log, or each fourth of them, is predicted by a search over the others, which begins at the
//! result of all; of a single log, each third of its rows by the two others. The score of a
//! candidate is the mean square e² of the position over what was left out, simulated over segments
//! of one length, the shortest over which a candidate was fitted: another length has other errors.
//! It is cut into windows, ten in each log.
//!
//! Named is the candidate with the fewest parameters whose squares exceed those of the best by no
//! more than one standard error of the difference, with the errors s/√n of n windows: that of
//! paired windows, or that of two means apart, √(s₁² + s₂²), whichever is larger. Pairs are to be
//! independent of each other, and are not where the windows of a log share an error of the
//! parameters. A search that has not converged says nothing of its candidate, which is then neither
//! the best nor named.
//!
//! Logs that are held out take no part in this: their errors are those of a prediction.
//!
//! Source: L. Breiman, J. H. Friedman, R. A. Olshen, C. J. Stone, "Classification and Regression
//! Trees" (1984), section 3.4.3.

use core::cell::Cell;
use core::fmt;
use core::ops::ControlFlow;

use super::criteria::{Errors, WHOLE};
use super::fit::{Progress, Settings, fit_candidate, fit_joint};
use super::friction::Friction;
use super::joint::Joint;
use super::log::DriveLog;
use super::report::{JointFit, over};
use crate::least_squares::minimise;
use crate::problem::begin_at;
use crate::{SearchOutcome, SearchProgress, SearchSettings};
use bristle::number::Number;
use bristle::parameter::{Checked, Named, ParameterError};

/// Windows in each log.
const WINDOWS: usize = 10;
/// Parts of a single log.
const PARTS: usize = 3;
/// Most searches without a part of the logs.
const FOLDS: usize = 4;

/// Candidates and their errors on logs that were not fitted, from [`compare`]. Prints as a table.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// The candidates that were fitted.
    pub fits: Vec<JointFit>,
    /// Candidates that were refused, and why.
    pub refused: Vec<(Friction, ParameterError)>,
    /// Mean square of the position of logs that were left out \[rad²\], of the torque [N² m²] where
    /// that was fitted, and its standard error, for each candidate; NaN where its search has not
    /// converged.
    pub left_out: Vec<[f64; 2]>,
    /// Place of the candidate with the least of them.
    pub best: Option<usize>,
    /// Place of the simplest of these within one standard error of it.
    pub simplest: Option<usize>,
}

/// Fits all candidates to the logs `fitted`, and names the simplest one that predicts each of them
/// from the others as well as the best. Each candidate is started from the logs and from those
/// before it that it contains, and its search never ends above them: put the simpler ones first.
///
/// The logs `held_out` are predicted, and take no part in the choice. The callback can stop: only
/// candidates that were predicted by then can be named.
///
/// # Errors
///
/// Refuses no candidate. If [`fit_joint`](super::fit_joint) refuses all candidates, the first
/// reason.
pub fn compare(
    joint: &Joint,
    candidates: &[Friction],
    fitted: &[DriveLog],
    held_out: &[DriveLog],
    settings: &Settings,
    progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
) -> Checked<Comparison> {
    Named("candidates", candidates.len()).count(1)?;
    let (mut fits, mut refused) = (Vec::<JointFit>::new(), Vec::new());
    let stopped = Cell::new(false);
    let mut tell = |candidate, now: &Progress<'_>| {
        let goes_on = progress(&Progress { candidate, ..*now });
        stopped.set(goes_on.is_break());
        goes_on
    };
    for (candidate, friction) in candidates.iter().enumerate() {
        let contained: Vec<_> =
            fits.iter().filter(|fit| friction.contains(&fit.friction)).collect();
        let mut watch = |now: &Progress<'_>| tell(candidate, now);
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
        if stopped.get() {
            break;
        }
    }
    if let (true, Some((_, error))) = (fits.is_empty(), refused.first()) {
        return Err(*error);
    }
    let length = shortest(&fits);
    let mut squares = vec![Vec::new(); fits.len()];
    for (candidate, (fit, squares)) in fits.iter().zip(&mut squares).enumerate() {
        let mut watch = |now: &Progress<'_>| tell(candidate, now);
        if converged(&fit) && !stopped.get() {
            *squares = squares_left_out(fit, fitted, length, settings, &mut watch)?;
        }
    }
    let left_out: Vec<_> = squares.iter().map(|squares| mean_and_error(squares)).collect();
    let [best, simplest] = named(&fits, &squares, &left_out);
    Ok(Comparison { fits, refused, left_out, best, simplest })
}

fn converged(fit: &&JointFit) -> bool {
    fit.fit.outcome == SearchOutcome::Converged
}

/// The length over which candidates are compared.
fn shortest(fits: &[JointFit]) -> f64 {
    fits.iter().filter(converged).map(|fit| fit.horizon).fold(f64::INFINITY, f64::min)
}

/// The places of the best candidate and of the simplest one that is as good.
fn named(fits: &[JointFit], squares: &[Vec<f64>], left_out: &[[f64; 2]]) -> [Option<usize>; 2] {
    let known = || left_out.iter().enumerate().filter(|(_, [mean, _])| mean.is_finite());
    let Some((best, [_, own])) = known().min_by(|a, b| a.1[0].total_cmp(&b.1[0])) else {
        return [None; 2];
    };
    let near = known().filter(|&(place, [_, theirs])| {
        let pairs = squares[place].iter().zip(&squares[best]);
        let more: Vec<f64> = pairs.map(|(ours, best)| ours - best).collect();
        let [mean, error] = mean_and_error(&more);
        mean <= error.max(own.hypot(*theirs))
    });
    let simplest = near.map(|(place, _)| place).min_by_key(|&p| (fits[p].searched(), p));
    [Some(best), simplest]
}

/// Mean squares of the position window by window, simulated over segments of a length, each of a
/// log that was left out; none where a search was stopped, or the model has no answer.
fn squares_left_out(
    fit: &JointFit,
    logs: &[DriveLog],
    horizon: f64,
    settings: &Settings,
    progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
) -> Checked<Vec<f64>> {
    let mut errors = Errors::new(&fit.model, logs, horizon);
    let mut parameters = fit.model.parameters.clone();
    begin_at(&mut parameters, &fit.fit.values());
    let (iterations, tolerance) = (settings.gradient_runs, 10.0 * settings.tolerance);
    let search = SearchSettings { iterations, tolerance, starts: 1 };
    let (mut gradient_runs, mut squares) = (fit.gradient_runs, Vec::new());
    let parts = if logs.len() == 1 { PARTS } else { 1 };
    let folds = FOLDS.min(logs.len() * parts);
    let rows: Vec<usize> = errors.by_log(&fit.fit.values())?.iter().map(Vec::len).collect();
    for out in 0..folds {
        let weights = |inside: bool| -> Vec<Vec<f64>> {
            let of_log = |(log, &rows): (usize, &usize)| {
                let is_out = |row| (log + row * parts / rows) % folds == out;
                (0..rows).map(|row| f64::from(u8::from(is_out(row) == inside))).collect()
            };
            rows.iter().enumerate().map(of_log).collect()
        };
        errors.weights = weights(false);
        let mut watch =
            |now: &SearchProgress<'_>| progress(&Progress::of(now, horizon, gradient_runs));
        let found = minimise(&errors, &parameters, &search, 0, &mut watch)?;
        gradient_runs += found.iterations;
        errors.weights = weights(true);
        let values = fit.model.without(found.values, |log| parts == 1 && log % folds == out);
        let (Ok(left), false) = (errors.by_log(&values), found.outcome == SearchOutcome::Stopped)
        else {
            return Ok(Vec::new());
        };
        for (residuals, weights) in left.iter().zip(&errors.weights) {
            let ours = residuals.iter().zip(weights).filter(|(_, weight)| **weight > 0.0);
            let ours: Vec<f64> = ours.map(|(r, _)| r * r).collect();
            let length = ours.len().div_ceil(WINDOWS).max(1);
            squares.extend(ours.chunks(length).map(|w| w.iter().sum::<f64>() / w.len() as f64));
        }
    }
    Ok(squares)
}

/// The mean of values and its standard error; NaN where there is none.
fn mean_and_error(values: &[f64]) -> [f64; 2] {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
    [mean, (squares / (count * (count - 1.0))).sqrt()]
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
        let length = self.fits.first().map_or("", |fit| fit.model.joint.unit("m"));
        let one = shortest(&self.fits);
        let said = |length| if one < WHOLE { format!(", {}", over(length)) } else { String::new() };
        let (whole, others) = (said(WHOLE), said(one));
        write!(f, "| {length}: rmse (mean size, relative) | free | over | fitted{whole} |")?;
        write!(f, " each by the others{others} | held out{whole} | search |")?;
        writeln!(f, "\n|---|---|---|---|---|---|---|")?;
        for (i, (fit, [square, error])) in self.fits.iter().zip(&self.left_out).enumerate() {
            let (name, free, root) = (fit.friction, fit.searched(), square.sqrt());
            let (left_out, error) = (Number(root), Number(0.5 * error / root));
            let (length, fitted) = (over(fit.horizon), fit.fitted.all.simulated);
            write!(f, "| {name} | {free} | {length} | {fitted} |")?;
            if root.is_nan() {
                write!(f, " – | ")?;
            } else {
                write!(f, " {left_out:.2} ± {error:.1} | ")?;
            }
            fit.held_out.iter().try_for_each(|scores| write!(f, "{}", scores.all.simulated))?;
            let best = if self.best == Some(i) { ", best" } else { "" };
            let simplest = if self.simplest == Some(i) { ", **named**" } else { "" };
            writeln!(f, " | {}{best}{simplest} |", fit.fit.outcome)?;
        }
        for (friction, error) in &self.refused {
            writeln!(f, "| {friction} | refused: {error} |")?;
        }
        let Some(named) = self.named() else {
            return writeln!(f, "\nno search has converged: no candidate is named");
        };
        write!(f, "\nnamed, the simplest within one standard error of the best:\n{named}")
    }
}
