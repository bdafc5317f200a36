//! The search: from the inverse criterion over segments of growing length.
//!
//! Each stage starts where the one before ended. The inverse criterion comes first; stiffness and
//! Stribeck velocity, which it hardly sees, are then tried over four decades by the first
//! segments. Before each stage the sensitivity of the position is looked at, in ranges of the
//! position per unit of a search variable. Where it exceeds a bound, as in stick-slip, the
//! segments end earlier.

use alloc::vec::Vec;
use core::ops::ControlFlow;

use super::Loss;
use super::criteria::{Criterion, Data, Errors};
use super::friction::Friction;
use super::joint::{Joint, Table};
use super::judge::judge;
use super::log::DriveLog;
use super::report::JointFit;
use super::smooth::{Smoothed, smooth};
use super::start::{Guess, guess};
use crate::least_squares::minimise;
use crate::log::{median, quantile};
use crate::problem::{Objective, Problem};
use crate::{Estimate, Fit, Outcome, Parameter, Remark};
use bristle::parameter::{self, ParameterError};

/// Settings of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Lengths of the segments \[s\] that are fitted one after the other, growing; infinite for
    /// whole logs. The last one decides. Empty for a thirtieth and a sixth of the longest log, and
    /// whole logs.
    pub horizons: Vec<f64>,
    /// Length of the segments of the reported criterion \[s\]; `None` for a tenth of the longest
    /// log.
    pub segment: Option<f64>,
    /// Longest step of a simulation \[s\], positive.
    pub step: f64,
    /// What is minimised in the last stage.
    pub loss: Loss,
    /// Most runs with derivatives over all stages. Where they end a search, the result is marked
    /// [`Outcome::RunLimit`].
    pub gradient_runs: usize,
    /// Relative change of the sum of squares below which a stage has converged.
    pub tolerance: f64,
    /// Largest change of the position, over its range, per unit of a search variable (a factor of
    /// e of a positive parameter).
    pub largest_sensitivity: f64,
}

impl Default for Settings {
    /// Steps of 1 ms, squares, a hundred runs, a change of 10⁻⁶, a sensitivity of 5.
    fn default() -> Self {
        Self {
            horizons: Vec::new(),
            segment: None,
            step: 1e-3,
            loss: Loss::Squares,
            gradient_runs: 100,
            tolerance: 1e-6,
            largest_sensitivity: 5.0,
        }
    }
}

/// State of a search, passed to the callback after every iteration. The callback can stop the
/// search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress<'a> {
    /// Number of the candidate, from zero.
    pub candidate: usize,
    /// Length of the segments \[s\]; zero for the inverse criterion.
    pub horizon: f64,
    /// Runs with derivatives of this candidate so far.
    pub gradient_runs: usize,
    /// Root mean square of the residuals \[rad\], of the inverse criterion [N m].
    pub rmse: f64,
    /// The parameters now.
    pub values: &'a [f64],
}

/// Most runs with derivatives of the inverse criterion.
const INVERSE_RUNS: usize = 20;
/// Factors by which the start of a parameter is tried.
const FACTORS: [f64; 7] = [0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0];
/// Parameters that are tried.
const TRIED: [&str; 2] = ["micro_stiffness", "stribeck_velocity"];
/// Most rounds of weights of a robust loss.
const ROUNDS: usize = 5;
/// Share of the rows whose sensitivity must be bearable; that of the others may be a hundred times
/// as large.
const NEARLY_ALL: f64 = 0.95;
/// That of the others may be as many times as large; rows beyond it do not count for the standard
/// errors.
const RARE: f64 = 100.0;
/// Most halvings of the segments.
const HALVINGS: usize = 8;

/// Finds inertia, friction and the other parameters of a joint from logs of drive and position.
///
/// The logs `held_out` are not fitted: their errors are reported beside those of the others.
/// Parameters that each log has for itself are there those of the log of the same number, beyond it
/// the mean.
///
/// # Errors
///
/// Refuses no logs, a joint with unknown names, a drive without a start of its constants, a drive
/// whose sign or unit is not that of the position, and starts at which the model has no answer.
pub fn fit(
    joint: &Joint,
    friction: &Friction,
    fitted: &[DriveLog],
    held_out: &[DriveLog],
    settings: &Settings,
    progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
) -> Result<JointFit, ParameterError> {
    fit_number(0, joint, friction, fitted, held_out, settings, None, progress)
}

/// [`fit`] of a candidate with a number, also from the parameters of a simpler one.
#[expect(clippy::too_many_arguments, reason = "those of `fit`, and two of `compare`")]
pub(super) fn fit_number(
    candidate: usize,
    joint: &Joint,
    friction: &Friction,
    fitted: &[DriveLog],
    held_out: &[DriveLog],
    settings: &Settings,
    simpler: Option<&JointFit>,
    progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
) -> Result<JointFit, ParameterError> {
    parameter::count("logs", fitted.len(), 1)?;
    for (i, &horizon) in settings.horizons.iter().enumerate() {
        let rule = "be positive; it may be infinite";
        parameter::component(i, parameter::stated("horizons", horizon, horizon > 0.0, rule))?;
    }
    if let Some(segment) = settings.segment {
        parameter::positive("segment", segment)?;
    }
    parameter::positive("step", settings.step)?;
    parameter::positive("largest_sensitivity", settings.largest_sensitivity)?;
    let smoothed: Vec<Vec<Smoothed>> = fitted.iter().map(smooth).collect();
    let guess = guess(joint, fitted, &smoothed)?;
    let mut table = joint.table(friction, &guess, fitted.len())?;
    let start = table.clone();
    let duration = fitted.iter().map(duration).fold(0.0, f64::max);
    let horizons = match settings.horizons.as_slice() {
        [] => alloc::vec![duration / 30.0, duration / 6.0, f64::INFINITY],
        given => given.to_vec(),
    };
    let mut runs = 0;
    let mut remarks = Vec::new();
    let mut horizon = 0.0;
    let mut found: Option<Fit> = None;
    let stages = core::iter::once(None).chain(horizons.iter().copied().map(Some));
    for (stage, asked) in stages.enumerate() {
        let data = Data { logs: fitted, smoothed: &smoothed };
        let table_now = table.clone();
        let mut errors = Errors {
            joint,
            friction,
            table: &table_now,
            data,
            constants: guess.constants,
            fastest: guess.fastest,
            step: settings.step,
            largest_gradient: f64::INFINITY,
            criterion: Criterion::Inverse,
            weights: Vec::new(),
        };
        let last = stage == horizons.len();
        if let Some(asked) = asked {
            let length = if asked >= duration { f64::INFINITY } else { asked };
            errors.criterion = Criterion::Segments(length);
            errors.largest_gradient = RARE * settings.largest_sensitivity * guess.range;
            if let Some(simpler) = simpler {
                start_from(&errors, &mut table, simpler);
            }
            try_starts(&errors, &mut table, &start);
            let (borne, looked) = bearable(&mut errors, &table, &guess, settings, duration)?;
            runs += looked;
            if last && borne < length {
                remarks.push(Remark::Shortened { asked: length.min(duration), fitted: borne });
            }
            horizon = borne;
        }
        // Every search ends with one more run, for the standard errors.
        let left = |runs: usize| settings.gradient_runs.saturating_sub(runs + 1);
        let iterations = match asked {
            None => left(runs).min(INVERSE_RUNS),
            Some(_) => left(runs) / (horizons.len() + 1 - stage).max(1),
        };
        if iterations == 0
            && let Some(found) = &mut found
        {
            found.outcome = Outcome::RunLimit;
            break;
        }
        let tolerance = if last { settings.tolerance } else { 100.0 * settings.tolerance };
        let least = crate::Settings { iterations, tolerance, starts: 1 };
        let mut minimise = |errors: &Errors<'_>, least: &crate::Settings| {
            let before = runs;
            let mut watch = |now: &crate::Progress<'_>| {
                let &crate::Progress { iteration, rmse, values, .. } = now;
                let gradient_runs = before + iteration;
                progress(&Progress { candidate, horizon, gradient_runs, rmse, values })
            };
            let fit = minimise(errors, &table.parameters, least, &mut watch)?;
            table.start_from(&fit.values());
            runs += fit.iterations + 1;
            Ok::<_, ParameterError>((fit, left(runs)))
        };
        let (mut next, mut rest) = minimise(&errors, &least)?;
        let rounds = if last && settings.loss != Loss::Squares { ROUNDS } else { 0 };
        for _ in 0..rounds {
            if rest == 0 || next.outcome == Outcome::Stopped {
                break;
            }
            errors.weights.clear();
            errors.weights = settings.loss.weights(&errors, &next.values());
            (next, rest) = minimise(&errors, &crate::Settings { iterations: rest, ..least })?;
        }
        let stopped = next.outcome == Outcome::Stopped;
        found = Some(next);
        if stopped {
            break;
        }
    }
    let Some(mut fit) = found else {
        return Err(parameter::refused("gradient_runs", 0.0, parameter::Rule::Count { least: 1 }));
    };
    if fit.outcome == Outcome::IterationLimit {
        fit.outcome = Outcome::RunLimit;
    }
    table.number(&mut fit.estimates);
    fit.remarks.extend(remarks);
    let segment = settings.segment.unwrap_or(0.1 * duration);
    let mut result = JointFit::new(joint, friction, table, &guess, fit, settings.step);
    result.gradient_runs = runs;
    result.horizon = horizon;
    result.segment = segment;
    result.score(fitted, held_out)?;
    judge(&mut result, fitted, &smoothed);
    Ok(result)
}

/// From the first row of a log to the last \[s\].
fn duration(log: &DriveLog) -> f64 {
    log.time.last().zip(log.time.first()).map_or(0.0, |(last, first)| last - first)
}

/// Σ r².
fn cost(errors: &Errors<'_>, values: &[f64]) -> f64 {
    let mut cost = 0.0;
    match errors.evaluate(values, &mut |r: f64| cost += r * r) {
        Ok(()) if cost.is_finite() => cost,
        _ => f64::INFINITY,
    }
}

/// Values of parameters with which a model is nearly the one without them.
const NEUTRAL: [(&str, f64); 5] = [
    ("micro_damping", 0.0),
    ("motor_load_factor", 0.02),
    ("external_load_factor", 0.02),
    ("breakaway_excess", 0.01),
    ("backward_ratio", 1.0),
];

/// Starts from the parameters of a simpler candidate if that is better, with the others as they are
/// or nearly without effect.
fn start_from(errors: &Errors<'_>, table: &mut Table, simpler: &JointFit) {
    let now: Vec<f64> = table.parameters.iter().map(|parameter| parameter.start).collect();
    let with = |neutral: bool| -> Vec<f64> {
        let places = table.parameters.iter().zip(&table.logs);
        let value = |(parameter, log): (&Parameter, &Option<usize>)| {
            let same = |e: &&Estimate| e.parameter.name == parameter.name && e.log == *log;
            // One that was fixed in the simpler candidate says nothing.
            let searched = |e: &&Estimate| e.parameter.least < e.parameter.most;
            let found = simpler.fit.estimates.iter().find(|e| same(e) && searched(e));
            let without = NEUTRAL.iter().find(|(name, _)| neutral && *name == parameter.name);
            let value = found.map(|e| e.value).or(without.map(|(_, value)| *value));
            value.map_or(parameter.start, |v| v.max(parameter.least).min(parameter.most))
        };
        places.map(value).collect()
    };
    let starts = [now, with(false), with(true)].map(|values| (cost(errors, &values), values));
    if let Some((_, best)) = starts.iter().min_by(|a, b| a.0.total_cmp(&b.0)) {
        table.start_from(best);
    }
}

/// Takes the best of several starts for the parameters that the inverse criterion hardly sees.
fn try_starts(errors: &Errors<'_>, table: &mut Table, start: &Table) {
    let mut values: Vec<f64> = table.parameters.iter().map(|parameter| parameter.start).collect();
    let mut best = cost(errors, &values);
    for (i, parameter) in start.parameters.iter().enumerate() {
        if !TRIED.contains(&parameter.name) || parameter.least >= parameter.most {
            continue;
        }
        for factor in FACTORS {
            let value = (parameter.start * factor).clamp(parameter.least, parameter.most);
            let before = values.get(i).copied().unwrap_or(value);
            values.iter_mut().skip(i).take(1).for_each(|place| *place = value);
            let reached = cost(errors, &values);
            if reached < best {
                best = reached;
            } else {
                values.iter_mut().skip(i).take(1).for_each(|place| *place = before);
            }
        }
    }
    table.start_from(&values);
}

/// Halves the segments until the sensitivities are bearable. Returns their length and the number of
/// runs with derivatives that it took.
fn bearable(
    errors: &mut Errors<'_>,
    table: &Table,
    guess: &Guess,
    settings: &Settings,
    duration: f64,
) -> Result<(f64, usize), ParameterError> {
    let Criterion::Segments(mut length) = errors.criterion else { return Ok((0.0, 0)) };
    let most = settings.largest_sensitivity * guess.range;
    for runs in 1..=HALVINGS {
        let problem = Problem::new(errors, &table.parameters)?;
        let rows = problem.rows(&problem.start());
        let mut sizes: Vec<f64> = rows.iter().map(|(_, gradient)| gradient.amax()).collect();
        if rows.finite
            && quantile(&mut sizes, NEARLY_ALL) <= most
            && quantile(&mut sizes, 1.0) <= RARE * most
        {
            return Ok((length, runs));
        }
        length = 0.5 * length.min(duration);
        errors.criterion = Criterion::Segments(length);
    }
    Ok((length, HALVINGS))
}

impl Loss {
    /// Square roots of the weights of all residuals at a point.
    fn weights(self, errors: &Errors<'_>, values: &[f64]) -> Vec<f64> {
        let mut sizes = Vec::new();
        if errors.evaluate(values, &mut |r: f64| sizes.push(r.abs())).is_err() {
            return Vec::new();
        }
        let spread = 1.4826 * median(&mut sizes.clone());
        if !(spread > 0.0) {
            return Vec::new();
        }
        sizes.iter().map(|size| self.weight(size / spread)).collect()
    }
}
