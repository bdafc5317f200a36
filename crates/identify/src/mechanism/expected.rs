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

use super::criteria::Errors;
use super::log::DriveLog;
use super::smooth::{SmoothedLog, smooth};
use crate::Parameter;
use crate::initial_guess::noise;
use crate::least_squares::Draw;
use crate::log::{pairs, quantile};
use crate::problem::{Objective, Point, Problem};
use crate::uncertainty::Determinacy;
use bristle::parameter::ParameterError;

/// Standard deviation of the noise of a drive: three quarters of the third differences of Gaussian
/// noise of deviation s are below 1.15 √20 s. Zero for a command.
pub(super) fn drive_noise(log: &DriveLog) -> f64 {
    let two = pairs(&log.drive).zip(log.drive.iter().skip(2).zip(log.drive.iter().skip(3)));
    let bends = two.map(|((a, b), (c, d))| (d - a - 3.0 * (c - b)).abs());
    let size = quantile(&mut bends.collect::<Vec<f64>>(), 0.75) / (1.15 * f64::sqrt(20.0));
    if log.noisy { size } else { 0.0 }
}

/// A log with more noise; that of the position is at most of a size.
fn noisier(log: &DriveLog, most: f64, draw: &mut Draw) -> DriveLog {
    let mut more = |column: &[f64], size: f64| -> Vec<f64> {
        column.iter().map(|value| value + size * draw.gauss()).collect()
    };
    let drive = more(&log.drive, drive_noise(log));
    let position = more(&log.position, most.min(noise(&log.position) / 6.0));
    DriveLog { drive, position, ..log.clone() }
}

/// Expected errors of the search variables at the starts of the parameters, if the sensitivities
/// are finite and nothing stops in between, from so many draws. Noise of the position is at most of a size.
pub(super) fn expected(
    errors: &Errors<'_>,
    parameters: &[Parameter],
    most: f64,
    draws: usize,
    ask: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<Option<Point>, ParameterError> {
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
                    }
                }
            },
        )?;
        if ask().is_break() {
            return Ok(None);
        }
        let moved = &inverse * score;
        squares += moved.component_mul(&moved) / draws as f64;
    }
    Ok(Some(squares.map(f64::sqrt)))
}
