//! The search: from the inverse criterion over segments of growing length.
//!
//! Each stage starts where the one before ended. The inverse criterion comes first; stiffness and
//! Stribeck velocity, which it hardly sees, are then tried over four decades by the first
//! segments. Before each stage the sensitivity of the position is looked at, in ranges of the
//! position per unit of a search variable. Where it exceeds a bound, as in stick-slip, the
//! segments end earlier.

use core::ops::ControlFlow;

use super::Loss;
use super::criteria::{Criterion, Errors};
use super::friction::Friction;
use super::joint::{Joint, Model};
use super::judge::judge;
use super::log::DriveLog;
use super::report::JointFit;
use super::smooth::{SmoothedLog, smooth};
use super::start::guess;
use crate::least_squares::minimise;
use crate::log::{quantile, span};
use crate::problem::{Objective, Problem};
use crate::{Estimate, Fit, Parameter, Remark, SearchOutcome, SearchProgress, SearchSettings};
use bristle::parameter::{Named, ParameterError};

/// How the parameters of a joint are searched.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Lengths of the segments \[s\] that are fitted one after the other, growing; infinite for
    /// whole logs. The last one decides. Empty for a thirtieth and a sixth of the longest log, and
    /// whole logs.
    pub horizons: Vec<f64>,
    /// Longest step of a simulation \[s\], positive.
    pub step: f64,
    /// What is minimised in the last stage.
    pub loss: Loss,
    /// Most runs with derivatives over all stages. Where they end a search, the result is marked
    /// [`SearchOutcome::RunLimit`].
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
            step: 1e-3,
            loss: Loss::Squares,
            gradient_runs: 100,
            tolerance: 1e-6,
            largest_sensitivity: 5.0,
        }
    }
}

/// How far the fit of a joint is, passed to the callback after nearly every run over the logs. The
/// callback can stop the fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress<'a> {
    /// Number of the candidate, from zero.
    pub candidate: usize,
    /// Length of the segments \[s\]; zero for the inverse criterion.
    pub horizon: f64,
    /// Runs with derivatives of this candidate so far.
    pub gradient_runs: usize,
    /// Root mean square of the residuals \[rad\], of the inverse criterion [N m]; NaN while the
    /// starts of a stage are tried.
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
/// Most steps between two rows. A log of 10 Hz takes half as many of 1 ms; what takes more is a log
/// in milliseconds, or better served by longer steps.
const MOST_STEPS: f64 = 200.0;
/// Most halvings of the segments.
const HALVINGS: usize = 8;

/// Length of the segments of the reported criterion over that of the longest log.
const REPORTED: f64 = 0.1;

impl Settings {
    /// Refuses lengths, steps and bounds that are not positive, and steps that are far too short
    /// for the rows of these logs.
    fn check(&self, logs: [&[DriveLog]; 2]) -> Result<(), ParameterError> {
        for (i, &horizon) in self.horizons.iter().enumerate() {
            let rule = "be positive; it may be infinite";
            ParameterError::of_component(
                i,
                Named("horizons", horizon).stated(horizon > 0.0, rule),
            )?;
        }
        Named("step", self.step).positive()?;
        Named("tolerance", self.tolerance).non_negative()?;
        for log in logs.into_iter().flatten() {
            let least = log.usual_step() / MOST_STEPS;
            let row = "a 200th of the median time from row to row (is the time in s?)";
            Named("step", self.step).at_least(row, least)?;
        }
        Named("largest_sensitivity", self.largest_sensitivity).positive()?;
        Ok(())
    }
}

/// Finds inertia, friction and the other parameters of a joint from logs of drive and position.
///
/// The logs `held_out` are not fitted: their errors are reported beside those of the others.
/// Parameters that each log has for itself are there those of the log of the same number, beyond it
/// the mean.
///
/// # Errors
///
/// Refuses steps below a 200th of the median time from row to row, which a log in milliseconds
/// would take for hours. Refuses no logs, a joint with unknown names, a drive without a start of
/// its constants, a drive whose sign or unit is not that of the position, and starts at which the
/// model has no answer.
pub fn fit_joint(
    joint: &Joint,
    friction: &Friction,
    fitted: &[DriveLog],
    held_out: &[DriveLog],
    settings: &Settings,
    progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
) -> Result<JointFit, ParameterError> {
    fit_candidate(joint, friction, [fitted, held_out], settings, None, progress)
}

/// [`fit_joint`], also from the parameters of a simpler candidate.
pub(super) fn fit_candidate(
    joint: &Joint,
    friction: &Friction,
    [fitted, held_out]: [&[DriveLog]; 2],
    settings: &Settings,
    simpler: Option<&JointFit>,
    progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
) -> Result<JointFit, ParameterError> {
    Named("logs", fitted.len()).count(1)?;
    settings.check([fitted, held_out])?;
    let logs: Vec<SmoothedLog<'_>> = fitted.iter().map(smooth).collect();
    let guess = guess(joint, &logs)?;
    let table = joint.table(friction, &guess, fitted.len())?;
    let (fastest, step) = (guess.fastest, settings.step);
    let model = Model { joint: joint.clone(), friction: *friction, table, fastest, step };
    let duration = fitted.iter().map(|log| span(&log.time)).fold(0.0, f64::max);
    let mut stages = Stages {
        errors: Errors::new(&model, &logs, Criterion::Inverse),
        settings,
        duration,
        range: guess.range,
        parameters: model.table.parameters.clone(),
        runs: 0,
        shortened: None,
        progress,
    };
    let mut fit = stages.all(simpler)?;
    let (runs, horizon) = (stages.runs, stages.horizon());
    fit.remarks.extend(stages.shortened);
    if fit.outcome == SearchOutcome::IterationLimit {
        fit.outcome = SearchOutcome::RunLimit;
    }
    for (estimate, &log) in fit.estimates.iter_mut().zip(&model.table.logs) {
        estimate.log = log;
    }
    let (values, segment) = (fit.values(), REPORTED * duration);
    let unseen: Vec<SmoothedLog<'_>> = held_out.iter().map(smooth).collect();
    let held_out = (!unseen.is_empty()).then(|| model.scores(&values, &unseen, segment));
    let mut result = JointFit {
        friction: *friction,
        fit,
        horizon,
        segment,
        fitted: model.scores(&values, &logs, segment)?,
        held_out: held_out.transpose()?,
        gradient_runs: runs,
        model,
    };
    judge(&mut result, &logs);
    Ok(result)
}

/// The stages of a fit, and how far they are.
struct Stages<'a> {
    /// The residuals of this stage.
    errors: Errors<'a>,
    settings: &'a Settings,
    /// Length of the longest log \[s\].
    duration: f64,
    /// Range of positions \[rad\].
    range: f64,
    /// With the starts of the next stage.
    parameters: Vec<Parameter>,
    /// Runs with derivatives so far.
    runs: usize,
    shortened: Option<Remark>,
    progress: &'a mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
}

impl Stages<'_> {
    /// The inverse criterion, then segments of growing length.
    fn all(&mut self, simpler: Option<&JointFit>) -> Result<Fit, ParameterError> {
        let horizons = match self.settings.horizons.as_slice() {
            [] => vec![self.duration / 30.0, self.duration / 6.0, f64::INFINITY],
            given => given.to_vec(),
        };
        let coarse = 100.0 * self.settings.tolerance;
        let mut found = self.minimise(self.left().min(INVERSE_RUNS), coarse)?;
        for (stage, &asked) in horizons.iter().enumerate() {
            if found.outcome == SearchOutcome::Stopped {
                break;
            }
            let last = stage + 1 == horizons.len();
            if self.segments(asked, last, simpler)?.is_break() {
                found.outcome = SearchOutcome::Stopped;
                break;
            }
            let iterations = self.left() / (horizons.len() - stage);
            if iterations == 0 {
                found.outcome = SearchOutcome::RunLimit;
                break;
            }
            let tolerance = if last { self.settings.tolerance } else { coarse };
            found = self.minimise(iterations, tolerance)?;
            let rounds = if last && self.settings.loss != Loss::Squares { ROUNDS } else { 0 };
            for _ in 0..rounds {
                if self.left() == 0 || found.outcome == SearchOutcome::Stopped {
                    break;
                }
                self.errors.weights.clear();
                let mut sizes = Vec::new();
                self.errors.evaluate(&found.values(), &mut |r: f64| sizes.push(r.abs()))?;
                self.errors.weights = self.settings.loss.weights(&sizes);
                found = self.minimise(self.left(), tolerance)?;
            }
        }
        Ok(found)
    }

    /// Goes on with segments of a length, or of one that can be borne, from the best start.
    fn segments(
        &mut self,
        asked: f64,
        last: bool,
        simpler: Option<&JointFit>,
    ) -> Result<ControlFlow<()>, ParameterError> {
        let length = if asked >= self.duration { f64::INFINITY } else { asked };
        let most = self.settings.largest_sensitivity * self.range;
        self.errors.criterion = Criterion::Segments(length);
        self.errors.largest_gradient = RARE * most;
        if let Some(simpler) = simpler {
            start_from(&self.errors, &mut self.parameters, simpler);
        }
        if self.try_starts().is_break() {
            return Ok(ControlFlow::Break(()));
        }
        for _ in 0..HALVINGS {
            self.runs += 1;
            if is_bearable(&self.errors, &self.parameters, most)? {
                break;
            }
            if self.ask().is_break() {
                return Ok(ControlFlow::Break(()));
            }
            let half = 0.5 * self.horizon().min(self.duration);
            self.errors.criterion = Criterion::Segments(half);
        }
        let fitted = self.horizon();
        if last && fitted < length {
            self.shortened = Some(Remark::Shortened { asked: length.min(self.duration), fitted });
        }
        Ok(ControlFlow::Continue(()))
    }

    /// Takes the best of several starts for the parameters that the inverse criterion hardly sees.
    fn try_starts(&mut self) -> ControlFlow<()> {
        let mut values = starts(&self.parameters);
        let mut best = self.errors.cost(&values);
        for (i, parameter) in self.parameters.clone().iter().enumerate() {
            if !TRIED.contains(&parameter.name) || parameter.least >= parameter.most {
                continue;
            }
            for factor in FACTORS {
                let mut moved = values.clone();
                let value = (parameter.start * factor).clamp(parameter.least, parameter.most);
                moved.iter_mut().skip(i).take(1).for_each(|place| *place = value);
                let reached = self.errors.cost(&moved);
                if reached < best {
                    (best, values) = (reached, moved);
                }
                self.ask()?;
            }
        }
        begin_at(&mut self.parameters, &values);
        ControlFlow::Continue(())
    }

    /// Whether the fit goes on, between two searches.
    fn ask(&mut self) -> ControlFlow<()> {
        let (horizon, gradient_runs) = (self.horizon(), self.runs);
        let (candidate, rmse, values) = (0, f64::NAN, &starts(&self.parameters));
        (self.progress)(&Progress { candidate, horizon, gradient_runs, rmse, values })
    }

    /// Length of the segments \[s\]; zero for the inverse criterion.
    fn horizon(&self) -> f64 {
        if let Criterion::Segments(length) = self.errors.criterion { length } else { 0.0 }
    }

    /// Runs that are left, but for the one with which every search ends: for the standard errors.
    fn left(&self) -> usize {
        self.settings.gradient_runs.saturating_sub(self.runs + 1)
    }

    /// A search from the parameters of the last one.
    fn minimise(&mut self, iterations: usize, tolerance: f64) -> Result<Fit, ParameterError> {
        let (before, horizon) = (self.runs, self.horizon());
        let mut watch = |now: &SearchProgress<'_>| {
            let &SearchProgress { iteration, rmse, values, .. } = now;
            let gradient_runs = before + iteration;
            (self.progress)(&Progress { candidate: 0, horizon, gradient_runs, rmse, values })
        };
        let settings = SearchSettings { iterations, tolerance, starts: 1 };
        let fit = minimise(&self.errors, &self.parameters, &settings, &mut watch)?;
        begin_at(&mut self.parameters, &fit.values());
        self.runs += fit.iterations + 1;
        Ok(fit)
    }
}

/// Where parameters start.
fn starts(parameters: &[Parameter]) -> Vec<f64> {
    parameters.iter().map(|parameter| parameter.start).collect()
}

/// Takes values as the starts of parameters.
fn begin_at(parameters: &mut [Parameter], values: &[f64]) {
    for (parameter, &value) in parameters.iter_mut().zip(values) {
        parameter.start = value;
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
fn start_from(errors: &Errors<'_>, parameters: &mut [Parameter], simpler: &JointFit) {
    let now = starts(parameters);
    let with = |neutral: bool| -> Vec<f64> {
        let places = parameters.iter().zip(&errors.model.table.logs);
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
    let starts = [now, with(false), with(true)].map(|values| (errors.cost(&values), values));
    if let Some((_, best)) = starts.iter().min_by(|a, b| a.0.total_cmp(&b.0)) {
        begin_at(parameters, best);
    }
}

/// Whether the gradients of nearly all rows keep below a size, and those of the others below a
/// hundred times as much.
fn is_bearable(
    errors: &Errors<'_>,
    parameters: &[Parameter],
    most: f64,
) -> Result<bool, ParameterError> {
    let problem = Problem::new(errors, parameters)?;
    let rows = problem.rows(&problem.start);
    let mut sizes: Vec<f64> = rows.rows.iter().map(|(_, gradient)| gradient.amax()).collect();
    let usual = quantile(&mut sizes, NEARLY_ALL) <= most;
    Ok(rows.finite && usual && quantile(&mut sizes, 1.0) <= RARE * most)
}
