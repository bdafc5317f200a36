//! The search: from the inverse criterion over segments of growing length.
//!
//! Each stage starts where the one before ended. The inverse criterion comes first; stiffness and
//! Stribeck velocity, which it hardly sees, are then tried over four decades by the first
//! segments. Before each stage the sensitivity of the position is looked at, in ranges of the
//! position per unit of a search variable. Where it exceeds a bound, as in stick-slip, the
//! segments end earlier.
//!
//! The last stage is searched from there and from the results of candidates that this one contains
//! (`ladder`), and the better end is kept.

use core::f64::consts::TAU;
use core::ops::ControlFlow;

use super::Loss;
use super::criteria::{Errors, INVERSE, WHOLE};
use super::friction::Friction;
use super::joint::{Joint, Model};
use super::judge::judge;
use super::ladder::{off_neutral, starts, tried};
use super::log::DriveLog;
use super::report::{ExpectedError, JointFit};
use super::start::guess;
use crate::least_squares::{Found, PROBES, minimise};
use crate::log::{quantile, span};
use crate::problem::{Objective, Problem, begin_at};
use crate::uncertainty::assess;
use crate::{Parameter, Remark, SearchOutcome, SearchProgress, SearchSettings};
use bristle::parameter::{Checked, Named, ParameterError};

/// How the parameters of a joint are searched.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Lengths of the segments \[s\] that are fitted one after the other, growing; infinite for
    /// whole logs. The last one decides; it may be zero, for the inverse criterion. Empty for a
    /// thirtieth and a sixth of the longest log, and then whole logs; or, where a drive is noisy,
    /// the length that promises the least errors of the parameters, see [`JointFit::expected`].
    pub horizons: Vec<f64>,
    /// Longest step of a simulation \[s\], positive.
    pub step: f64,
    /// What is minimised in the last stage.
    pub loss: Loss,
    /// Most runs with derivatives over all stages and starts, also those of the simpler candidates
    /// that a fit starts from. Where they end a search, the result is marked
    /// [`SearchOutcome::RunLimit`].
    pub gradient_runs: usize,
    /// Relative change of the sum of squares below which a stage has converged.
    pub tolerance: f64,
    /// Largest change of the position, over its range, per unit of a search variable (a factor of
    /// e of a positive parameter).
    pub largest_sensitivity: f64,
}

impl Default for Settings {
    /// Steps of 1 ms, squares, 200 runs, a change of 10⁻⁵, a sensitivity of 5.
    ///
    /// One standard error changes the squares by their share of one independent row: of a thousand
    /// such rows, by a hundred times as much as the tolerance.
    fn default() -> Self {
        Self {
            horizons: Vec::new(),
            step: 1e-3,
            loss: Loss::Squares,
            gradient_runs: 200,
            tolerance: 1e-5,
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

impl<'a> Progress<'a> {
    /// That of a search over segments of a length, after so many runs with derivatives.
    pub(super) fn of(now: &SearchProgress<'a>, horizon: f64, before: usize) -> Self {
        let &SearchProgress { iteration, rmse, values, .. } = now;
        Self { candidate: 0, horizon, gradient_runs: before + iteration, rmse, values }
    }
}

/// Most runs with derivatives of a stage before the last.
const COARSE_RUNS: usize = 20;
/// Most runs with derivatives from each of two starts, after which the better one goes on.
const CHALLENGE_RUNS: usize = 10;
/// Most rounds of weights of a robust loss.
const ROUNDS: usize = 5;
/// Share of the rows whose sensitivity must be bearable; that of the others may be a hundred times
/// as large.
const NEARLY_ALL: f64 = 0.95;
/// That of the others may be as many times as large; rows beyond it do not count for the standard
/// errors.
pub(super) const RARE: f64 = 100.0;
/// Most steps between two rows. A log of 10 Hz takes half as many of 1 ms; what takes more is a log
/// in milliseconds, or better served by longer steps.
const MOST_STEPS: f64 = 200.0;
/// Most halvings of the segments.
const HALVINGS: usize = 8;

impl Settings {
    /// Refuses lengths, steps and bounds that are not positive, and steps that are far too short
    /// for the rows of these logs.
    fn check(&self, logs: [&[DriveLog]; 2]) -> Checked<()> {
        ParameterError::of_components(&self.horizons, |&it| {
            Named("horizons", it).stated(it >= 0.0, "not be negative; it may be infinite")
        })?;
        Named("step", self.step).positive()?;
        Named("tolerance", self.tolerance).non_negative()?;
        for log in logs.into_iter().flatten() {
            let least = log.usual_step() / MOST_STEPS;
            let row = "a 200th of the median time from row to row (is the time in s?)";
            Named("step", self.step).at_least(row, least)?;
        }
        Named("largest_sensitivity", self.largest_sensitivity).positive().map(drop)
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
) -> Checked<JointFit> {
    let mut stopped = false;
    let mut watch = |now: &Progress<'_>| {
        stopped = stopped || progress(now).is_break();
        if stopped { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let (mut rungs, mut left) = (Vec::<JointFit>::new(), settings.gradient_runs);
    let smaller = friction.rungs();
    let limited = |gradient_runs| Settings { gradient_runs, ..settings.clone() };
    for (number, rung) in smaller.iter().enumerate() {
        let settings = limited(left / (smaller.len() + 2 - number));
        let contained: Vec<_> = rungs.iter().collect();
        let fit = fit_candidate(joint, rung, [fitted, &[]], &settings, &contained, &mut watch)?;
        left = left.saturating_sub(fit.gradient_runs);
        rungs.push(fit);
    }
    let (contained, logs) = (rungs.iter().collect::<Vec<_>>(), [fitted, held_out]);
    let last = fit_candidate(joint, friction, logs, &limited(left), &contained, &mut watch)?;
    let run_limit = settings.gradient_runs;
    Ok(JointFit { gradient_runs: run_limit - left + last.gradient_runs, run_limit, ..last })
}

/// [`fit_joint`], also from the results of candidates that this one contains.
pub(super) fn fit_candidate(
    joint: &Joint,
    friction: &Friction,
    [fitted, held_out]: [&[DriveLog]; 2],
    settings: &Settings,
    contained: &[&JointFit],
    progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
) -> Checked<JointFit> {
    Named("logs", fitted.len()).count(1)?;
    settings.check([fitted, held_out])?;
    let guess = guess(joint, fitted)?;
    let model = Model { step: settings.step, ..joint.model(friction, &guess, fitted)? };
    let duration = fitted.iter().map(|log| span(&log.time)).fold(0.0, f64::max);
    let mut stages = Stages {
        errors: Errors::new(&model, fitted, INVERSE),
        settings,
        duration,
        range: guess.range,
        parameters: model.parameters.clone(),
        runs: 0,
        shortened: None,
        stopped: false,
        expected: Vec::new(),
        noise: None,
        own: None,
        progress,
    };
    let found = stages.all(contained)?;
    let problem = Problem::new(&stages.errors, &stages.parameters)?;
    let mut fit = assess(&problem, &found, stages.errors.largest_gradient);
    stages.know_noise(&mut fit)?;
    fit.remarks.extend(stages.shortened);
    for (estimate, &log) in fit.estimates.iter_mut().zip(&model.of_logs) {
        estimate.log = log;
        if estimate.parameter.name == "hanging_angle" && joint.given("hanging_angle").is_none() {
            // The same within half a turn.
            estimate.value -= TAU * (estimate.value / TAU).round();
        }
    }
    let values = fit.values();
    let predicted = model.as_measured(values.clone());
    let held_out = (!held_out.is_empty()).then(|| model.scores(&predicted, held_out));
    let mut result = JointFit {
        friction: *friction,
        fit,
        horizon: stages.errors.length,
        expected: stages.expected,
        noise: stages.noise,
        fitted: model.scores(&values, fitted)?,
        held_out: held_out.transpose()?,
        gradient_runs: stages.runs + 1,
        run_limit: settings.gradient_runs,
        model,
    };
    judge(&mut result, fitted);
    Ok(result)
}

/// The stages of a fit, and how far they are.
pub(super) struct Stages<'a> {
    /// The residuals of this stage.
    pub(super) errors: Errors<'a>,
    pub(super) settings: &'a Settings,
    /// Length of the longest log \[s\].
    pub(super) duration: f64,
    /// Range of positions \[rad\].
    pub(super) range: f64,
    /// With the starts of the next stage.
    pub(super) parameters: Vec<Parameter>,
    /// Runs with derivatives so far.
    pub(super) runs: usize,
    shortened: Option<Remark>,
    /// Whether the callback has stopped the fit between two searches.
    pub(super) stopped: bool,
    /// The lengths that were compared.
    pub(super) expected: Vec<ExpectedError>,
    /// Root mean square of the residuals that noise explains.
    pub(super) noise: Option<f64>,
    /// Where the stages from the logs have ended, if the last one begins elsewhere.
    own: Option<Vec<f64>>,
    progress: &'a mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
}

impl Stages<'_> {
    /// The inverse criterion, then segments of growing length.
    fn all(&mut self, contained: &[&JointFit]) -> Checked<Found> {
        let horizons = match self.settings.horizons.as_slice() {
            [] => vec![self.duration / 30.0, self.duration / 6.0, WHOLE],
            given => given.to_vec(),
        };
        let mut found = self.minimise(self.left().min(COARSE_RUNS), false)?;
        for (stage, &asked) in horizons.iter().enumerate() {
            let last = stage + 1 == horizons.len();
            let stopped = found.outcome == SearchOutcome::Stopped
                || self.segments(asked, [stage == 0, last], contained)?.is_break();
            let iterations = self.left() / (2 * (horizons.len() - stage) - 1);
            if stopped || iterations == 0 {
                // The best of the starts, if any was better; at the limit of its runs.
                let best = self.minimise(0, false)?;
                let outcome = if stopped { SearchOutcome::Stopped } else { best.outcome };
                return Ok(Found { outcome, ..best });
            }
            let coarse = iterations.min(COARSE_RUNS);
            found = if last { self.last()? } else { self.minimise(coarse, false)? };
        }
        Ok(found)
    }

    /// The last stage, and the rounds of a robust loss.
    fn last(&mut self) -> Checked<Found> {
        let mut found = None;
        if let Some(own) = self.own.take() {
            // A few runs from both, and on from the better one.
            let runs = CHALLENGE_RUNS.min(self.left() / 3);
            let mut best = self.minimise(runs, true)?;
            if best.outcome != SearchOutcome::Stopped {
                begin_at(&mut self.parameters, &own);
                let other = self.minimise(runs, true)?;
                best = if other.cost < best.cost { other } else { best };
                begin_at(&mut self.parameters, &best.values);
            }
            found = Some(best).filter(|found| found.outcome != SearchOutcome::RunLimit);
        }
        let mut found = found.map_or_else(|| self.minimise(self.left(), true), Ok)?;
        let rounds = if self.settings.loss == Loss::Squares { 0 } else { ROUNDS };
        for _ in 0..rounds {
            if self.left() == 0 || found.outcome == SearchOutcome::Stopped {
                break;
            }
            self.errors.weights.clear();
            let logs = self.errors.by_log(&found.values)?;
            let sizes: Vec<f64> = logs.iter().flatten().map(|r| r.abs()).collect();
            let mut weights = self.settings.loss.weights(&sizes).into_iter();
            let ours = |rows: &Vec<f64>| weights.by_ref().take(rows.len()).collect();
            self.errors.weights = logs.iter().map(ours).collect();
            found = self.minimise(self.left(), true)?;
        }
        Ok(found)
    }

    /// Goes on with segments of a length, or of one that can be borne, from the best start.
    fn segments(
        &mut self,
        asked: f64,
        [first, last]: [bool; 2],
        contained: &[&JointFit],
    ) -> Checked<ControlFlow<()>> {
        let length = if asked >= self.duration { WHOLE } else { asked };
        let most = self.settings.largest_sensitivity * self.range;
        self.errors.length = length;
        self.errors.largest_gradient = if length > 0.0 { RARE * most } else { f64::INFINITY };
        if first {
            off_neutral(&mut self.parameters);
        }
        let contained = if last { contained } else { &[] };
        if (first || !contained.is_empty()) && self.try_starts(contained).is_break() {
            return Ok(ControlFlow::Break(()));
        }
        if last && self.settings.horizons.is_empty() {
            self.compare_lengths()?;
            if self.stopped || self.errors.length < length && self.try_starts(contained).is_break()
            {
                return Ok(ControlFlow::Break(()));
            }
        }
        let length = self.errors.length;
        for _ in 0..HALVINGS {
            self.runs += 1;
            if length == INVERSE || self.is_bearable(most)? {
                break;
            }
            if self.ask().is_break() {
                return Ok(ControlFlow::Break(()));
            }
            self.errors.length = 0.5 * self.errors.length.min(self.duration);
        }
        let fitted = self.errors.length;
        if last && fitted < length {
            self.shortened = Some(Remark::Shortened { asked: length.min(self.duration), fitted });
        }
        Ok(ControlFlow::Continue(()))
    }

    /// Takes the best of several starts for the parameters that the inverse criterion hardly sees.
    /// With candidates that this one contains, it takes the best of theirs, and keeps its own for a
    /// second search.
    fn try_starts(&mut self, contained: &[&JointFit]) -> ControlFlow<()> {
        let model = self.errors.model;
        let ended = contained.iter().flat_map(|&fit| {
            [false, true].map(|undamped| {
                let values = model.begun(fit, [false, undamped]);
                (self.errors.cost(&values), values, fit)
            })
        });
        let least = ended.min_by(|a, b| a.0.total_cmp(&b.0));
        self.own = least.is_some().then(|| starts(&self.parameters));
        let begun = least.as_ref().map(|(_, _, fit)| model.begun(fit, [true, false]));
        let begun = begun.unwrap_or_else(|| starts(&self.parameters));
        begin_at(&mut self.parameters, &begun);
        let mut best = least.map_or((f64::INFINITY, Vec::new()), |least| (least.0, least.1));
        for values in core::iter::once(begun).chain(tried(&self.parameters)) {
            let cost = self.errors.cost(&values);
            // Where no start has an answer, the search says so.
            if cost < best.0 || best.1.is_empty() {
                best = (cost, values);
            }
            begin_at(&mut self.parameters, &best.1);
            self.ask()?;
        }
        ControlFlow::Continue(())
    }

    /// Whether the fit goes on, between two searches.
    pub(super) fn ask(&mut self) -> ControlFlow<()> {
        let (horizon, gradient_runs) = (self.errors.length, self.runs);
        let (candidate, rmse, values) = (0, f64::NAN, &starts(&self.parameters));
        let progress = Progress { candidate, horizon, gradient_runs, rmse, values };
        let goes_on = (self.progress)(&progress);
        self.stopped |= goes_on.is_break();
        goes_on
    }

    /// Runs that are left, but for the one with which every search ends: for the standard errors.
    fn left(&self) -> usize {
        self.settings.gradient_runs.saturating_sub(self.runs + 1)
    }

    /// A search from the parameters of the last one, in the last stage or a coarse one before.
    fn minimise(&mut self, iterations: usize, last: bool) -> Checked<Found> {
        let (probes, tolerance) = if last { (PROBES, 1.0) } else { (0, 10.0) };
        let tolerance = tolerance * self.settings.tolerance;
        let (before, horizon) = (self.runs, self.errors.length);
        let mut watch =
            |now: &SearchProgress<'_>| (self.progress)(&Progress::of(now, horizon, before));
        let settings = SearchSettings { iterations, tolerance, starts: 1 };
        let found = minimise(&self.errors, &self.parameters, &settings, probes, &mut watch)?;
        begin_at(&mut self.parameters, &found.values);
        self.runs += found.iterations;
        Ok(found)
    }

    /// Whether the gradients of nearly all rows keep below a size, and those of the others below a
    /// hundred times as much.
    fn is_bearable(&self, most: f64) -> Checked<bool> {
        let problem = Problem::new(&self.errors, &self.parameters)?;
        let rows = problem.rows(&problem.start);
        let mut sizes: Vec<f64> = rows.rows.iter().map(|(_, gradient)| gradient.amax()).collect();
        let usual = quantile(&mut sizes, NEARLY_ALL) <= most;
        Ok(rows.finite && usual && quantile(&mut sizes, 1.0) <= RARE * most)
    }
}
