//! Errors of the parameters that the noise of drive and position alone leads to one to expect.
//!
//! δ = −(JᵀJ)⁻¹ Jᵀ (r' − r),  s² = ⟨δ²⟩
//!
//! with the residuals r' of logs to whose drives and positions noise of the same size has been
//! added once more, several times. A noisy drive moves a simulated position the farther, the longer
//! it is simulated, and a short segment begins at a position and a velocity that are not known
//! well: in between is the length over which s is least.
//!
//! Source: the bootstrap with a linear estimator, B. Efron, R. J. Tibshirani, "An Introduction to
//! the Bootstrap" (1993), section 7.3; the noise from third differences of the column.

use core::ops::ControlFlow;

use super::criteria::{Criterion, Errors};
use super::fit::Stages;
use super::ladder::begin_at;
use super::log::DriveLog;
use super::report::ExpectedError;
use super::smooth::{SmoothedLog, smooth};
use crate::initial_guess::noise;
use crate::least_squares::Draw;
use crate::log::{pairs, quantile};
use crate::problem::{Objective, Point, Problem};
use crate::uncertainty::Determinacy;
use crate::{Fit, Identifiability, Parameter, SearchOutcome};
use bristle::parameter::ParameterError;

/// Lengths of the last segments that are compared where a drive is noisy, over that of the longest
/// log.
const SHARES: [f64; 4] = [1.0 / 27.0, 1.0 / 9.0, 1.0 / 3.0, 1.0];
/// Draws of noise for a length, the same ones for all lengths; and for the standard errors, whose
/// root mean square is then known to 18 %.
const DRAWS: [usize; 2] = [8, 16];
/// Expected errors over the least ones that are accepted for a longer segment.
const NEARLY_LEAST: f64 = 1.25;
/// Standard deviation of the noise of a drive: three quarters of the third differences of Gaussian
/// noise of deviation s are below 1.15 √20 s. Zero for a command.
fn drive_noise(log: &DriveLog) -> f64 {
    let two = pairs(&log.drive).zip(log.drive.iter().skip(2).zip(log.drive.iter().skip(3)));
    let bends = two.map(|((a, b), (c, d))| (d - a - 3.0 * (c - b)).abs());
    let size = quantile(&mut bends.collect::<Vec<f64>>(), 0.75) / (1.15 * f64::sqrt(20.0));
    if log.noisy { size } else { 0.0 }
}

/// A log with more noise; that of the position is at most of a size. An encoder that stands still
/// has none.
fn noisier(log: &DriveLog, most: f64, draw: &mut Draw) -> DriveLog {
    let (of_drive, of_position) = (drive_noise(log), most.min(noise(&log.position) / 6.0));
    let drive = log.drive.iter().map(|value| value + of_drive * draw.gauss()).collect();
    let moved = |(row, &x): (usize, &f64)| {
        let mut near = log.position.iter().skip(row.saturating_sub(1)).take(3);
        if near.all(|y| *y == x) { x } else { x + of_position * draw.gauss() }
    };
    let position = log.position.iter().enumerate().map(moved).collect();
    DriveLog { drive, position, ..log.clone() }
}

/// Expected errors of the search variables at the starts of the parameters, and the mean square of
/// the residuals that noise leaves, if the sensitivities are finite and nothing stops in between,
/// from so many draws. Noise of the position is at most of a size.
fn expected(
    errors: &Errors<'_>,
    parameters: &[Parameter],
    most: f64,
    draws: usize,
    ask: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<Option<(Point, f64)>, ParameterError> {
    let problem = Problem::new(errors, parameters)?;
    let rows = problem.rows(&problem.start);
    if !rows.finite {
        return Ok(None);
    }
    let linear = rows.linear(parameters.len());
    let resting = problem.resting(&problem.start, &linear.gradient());
    let free: Vec<bool> = resting.iter().map(Option::is_none).collect();
    let norms = linear.column_norms();
    let inverse = Determinacy::of(&linear.directions(&free), &norms, &free, parameters).inverse;
    let (mut squares, mut draw) = (Point::zeros(parameters.len()), Draw::new());
    let (mut noise, mut count) = (0.0, 0.0);
    for _ in 0..draws {
        let noisy: Vec<DriveLog> =
            errors.logs.iter().map(|smoothed| noisier(smoothed.log, most, &mut draw)).collect();
        let logs: Vec<SmoothedLog<'_>> = noisy.iter().map(smooth).collect();
        let (mut score, mut left) = (Point::zeros(parameters.len()), rows.rows.iter());
        Errors { logs: &logs, ..errors.clone() }.evaluate(
            &problem.values(&problem.start),
            &mut |r: f64| {
                if let Some((before, gradient)) = left.next() {
                    // A row beyond says nothing of the accuracy.
                    if gradient.amax() <= errors.largest_gradient {
                        score.axpy(r - before, gradient, 1.0);
                        (noise, count) = (noise + (r - before) * (r - before), count + 1.0);
                    }
                }
            },
        )?;
        if ask().is_break() {
            return Ok(None);
        }
        let moved = &inverse * &score;
        noise -= score.dot(&moved);
        squares += moved.component_mul(&moved) / draws as f64;
    }
    Ok(Some((squares.map(f64::sqrt), noise / count)))
}

impl Stages<'_> {
    /// Compares lengths of the last segments, if a drive is noisy, and takes the longest of those
    /// whose errors are nearly the least: whole logs are what a simulator needs.
    pub(super) fn compare_lengths(&mut self) -> Result<(), ParameterError> {
        self.expected.clear();
        if self.errors.logs.iter().all(|smoothed| drive_noise(smoothed.log) == 0.0) {
            return Ok(());
        }
        let (mut errors, parameters) = (self.errors.clone(), self.parameters.clone());
        for share in SHARES {
            let length = if share == 1.0 { f64::INFINITY } else { share * self.duration };
            errors.criterion = Criterion::Segments(length);
            self.runs += 1;
            let (most, draws) = (f64::INFINITY, DRAWS[0]);
            let sizes = expected(&errors, &parameters, most, draws, &mut || self.ask())?;
            let Some((sizes, _)) = sizes else { continue };
            let logarithms: Vec<_> = sizes.iter().filter(|x| **x > 0.0).map(|x| x.ln()).collect();
            let mean = logarithms.iter().sum::<f64>() / logarithms.len() as f64;
            self.expected.push(ExpectedError { length, ratio: mean.exp() });
        }
        let least = self.expected.iter().map(|e| e.ratio).fold(f64::INFINITY, f64::min);
        self.expected.iter_mut().for_each(|e| e.ratio /= least);
        let near = self.expected.iter().rfind(|e| e.ratio <= NEARLY_LEAST);
        self.errors.criterion = Criterion::Segments(near.map_or(f64::INFINITY, |e| e.length));
        Ok(())
    }

    /// Standard errors are those that noise of drive and position leads one to expect, and those
    /// of the residuals as far as noise does not explain them: s² + (1 − 2 σ_n²/σ²)₊ s_r². It is
    /// twice the squares σ_n² that noise leaves, because those of a simulated log scatter as much.
    pub(super) fn know_noise(&mut self, fit: &mut Fit) -> Result<(), ParameterError> {
        if fit.outcome == SearchOutcome::Stopped || self.horizon() == 0.0 {
            return Ok(());
        }
        let values = fit.values();
        begin_at(&mut self.parameters, &values);
        let (errors, parameters) = (self.errors.clone(), self.parameters.clone());
        let sizes = expected(&errors, &parameters, fit.rmse, DRAWS[1], &mut || self.ask())?;
        if self.stopped {
            fit.outcome = SearchOutcome::Stopped;
        }
        let Some((sizes, noise)) = sizes else { return Ok(()) };
        let unexplained = (1.0 - 2.0 * noise / (fit.rmse * fit.rmse)).max(0.0);
        let slopes = Problem::new(&self.errors, &self.parameters)?.slopes(&values);
        for ((estimate, size), slope) in fit.estimates.iter_mut().zip(&sizes).zip(slopes) {
            let known = [Identifiability::Determined, Identifiability::Uncertain];
            if known.contains(&estimate.verdict) {
                let squares =
                    unexplained * estimate.standard_error.powi(2) + (size * slope).powi(2);
                estimate.standard_error = squares.sqrt();
                let clear = estimate.standard_error <= estimate.value.abs();
                estimate.verdict = known[usize::from(!clear)];
            }
        }
        Ok(())
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use crate::mechanism::{Drive, DriveLogParameters};

    #[test]
    fn an_encoder_that_stands_still_has_no_noise() {
        let time: Vec<f64> = (0..200).map(|i| 5e-3 * f64::from(i)).collect();
        // Half a second at rest, then at a third of a count from row to row.
        let position: Vec<f64> =
            (0..200).map(|i| (f64::from(i - 100).max(0.0) / 3.0).round()).collect();
        let torque = vec![0.0; 200];
        let new = DriveLogParameters::new(&time, &position, Drive::Torque(&torque));
        let log = DriveLog::new(new).unwrap();
        let noisy = noisier(&log, f64::INFINITY, &mut Draw::new());
        let moved = |rows: core::ops::Range<usize>| {
            rows.filter(|&row| noisy.position[row] != log.position[row]).count()
        };
        // A count lasts three rows, of which the middle one sees no change.
        assert!(moved(0..100) == 0 && moved(105..195) > 45, "{:?}", noisy.position);
    }
}
