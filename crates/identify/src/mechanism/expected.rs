//! Errors of the parameters that the noise of drive and position alone leads to one to expect.
//!
//! δ = −(JᵀJ)⁻¹ Jᵀ (r' − r),  s² = ⟨δ²⟩
//!
//! with the residuals r' of logs to whose drives and positions noise of the same size has been
//! added once more, several times. A noisy drive moves a simulated position the farther, the longer
//! it is simulated, and a short segment begins at a position and a velocity that are not known
//! well: in between is the length over which s is least.
//!
//! Noise of the drive moves the simulated position by an amount that depends on the parameters: the
//! least squares prefer a mechanism that moves less by it, which is a bias. As much noise again
//! moves the parameters as far again, on average over draws of both signs, by which all that is of
//! first order cancels:
//!
//! q ← q − ⟨δ'⟩,  δ' = −(J'ᵀJ')⁻¹ J'ᵀ r'
//!
//! Sources: the bootstrap with a linear estimator, B. Efron, R. J. Tibshirani, "An Introduction to
//! the Bootstrap" (1993), section 7.3; the noise from third differences of the column;
//! extrapolation to no noise, J. R. Cook, L. A. Stefanski, "Simulation-extrapolation estimation in
//! parametric measurement error models", Journal of the American Statistical Association 89 (1994),
//! 1314–1328.

use super::criteria::{Errors, WHOLE};
use super::fit::Stages;
use super::joint::INITIAL;
use super::log::DriveLog;
use super::report::ExpectedError;
use super::smooth::smoothed;
use crate::initial_guess::noise;
use crate::least_squares::Draw;
use crate::log::quantile;
use crate::problem::{Point, Problem, Rows, begin_at};
use crate::uncertainty::Determinacy;
use crate::{Estimate, Fit, Identifiability, Parameter, SearchOutcome};
use bristle::Scalar;
use bristle::parameter::Checked;

/// Lengths of the last segments that are compared where a drive is noisy, over that of the longest
/// log.
const SHARES: [f64; 4] = [1.0 / 27.0, 1.0 / 9.0, 1.0 / 3.0, 1.0];
/// Draws of noise for a length, the same ones for all lengths; and for the standard errors, whose
/// root mean square is then known to 13 %.
const DRAWS: [usize; 2] = [8, 32];
/// Pairs of opposite draws for the bias.
const PAIRS: usize = 4;

/// Standard deviation of the noise of a drive: three quarters of the third differences of Gaussian
/// noise of deviation s are below 1.15 √20 s. Zero for a command.
fn drive_noise(log: &DriveLog) -> f64 {
    let bends = log.drive.windows(4).map(|u| (u[3] - u[0] - 3.0 * (u[2] - u[1])).abs());
    let size = quantile(&mut bends.collect::<Vec<f64>>(), 0.75) / (1.15 * f64::sqrt(20.0));
    if log.noisy { size } else { 0.0 }
}

fn is_command(logs: &[DriveLog]) -> bool {
    logs.iter().all(|log| drive_noise(log) == 0.0)
}

/// Logs with more noise of a sign; that of the position is at most of a size. An encoder that
/// stands still keeps its error.
fn noisier(logs: &[DriveLog], [most, sign]: [f64; 2], draw: &mut Draw) -> Vec<DriveLog> {
    let one = |log: &DriveLog| {
        let of_position = sign * most.min(noise(&log.position) / 6.0);
        let of_drive = sign * drive_noise(log);
        let drive = log.drive.iter().map(|value| value + of_drive * draw.gauss()).collect();
        let mut error = of_position * draw.gauss();
        let moved = |(row, &x): (usize, &f64)| {
            let mut near = log.position.iter().skip(row.saturating_sub(1)).take(3);
            if !near.all(|y| *y == x) {
                error = of_position * draw.gauss();
            }
            x + error
        };
        let position = log.position.iter().enumerate().map(moved).collect();
        smoothed(DriveLog { drive, position, ..log.clone() })
    };
    logs.iter().map(one).collect()
}

/// The rows of the start and what they determine, if the sensitivities are finite.
fn linear(problem: &Problem<'_, Errors<'_>>) -> Option<(Rows, Determinacy)> {
    let rows = problem.rows(&problem.start);
    let determined = Determinacy::of(problem, &problem.start, &rows);
    rows.finite.then_some((rows, determined))
}

impl Stages<'_> {
    /// Compares lengths of the last segments, if a drive is noisy, and takes that of the least
    /// errors.
    pub(super) fn compare_lengths(&mut self) -> Checked<()> {
        if is_command(self.errors.logs) {
            return Ok(());
        }
        for share in SHARES {
            let length = if share == 1.0 { WHOLE } else { share * self.duration };
            self.errors.length = length;
            self.runs += 1;
            let Some((sizes, _)) = self.errors_by_noise(f64::INFINITY, DRAWS[0])? else { continue };
            let sizes = sizes.iter().zip(&self.parameters);
            let counts = |(x, p): &(&f64, &Parameter)| **x > 0.0 && !INITIAL.contains(&p.name);
            let logarithms: Vec<_> = sizes.filter(counts).map(|(x, _)| x.ln()).collect();
            let mean = logarithms.iter().sum::<f64>() / logarithms.len() as f64;
            self.expected.push(ExpectedError { length, ratio: mean.exp() });
        }
        let least = self.expected.iter().min_by(|a, b| a.ratio.total_cmp(&b.ratio)).copied();
        self.expected.iter_mut().zip(least.iter().cycle()).for_each(|(e, l)| e.ratio /= l.ratio);
        self.errors.length = least.map_or(WHOLE, |e| e.length);
        Ok(())
    }

    /// Expected errors of the search variables at the starts of the parameters, and the mean square
    /// of the residuals that noise leaves, if the sensitivities are finite and nothing stops in
    /// between, from so many draws. Noise of the position is at most of a size.
    fn errors_by_noise(&mut self, most: f64, draws: usize) -> Checked<Option<(Point, f64)>> {
        let (errors, parameters) = (self.errors.clone(), self.parameters.clone());
        let problem = Problem::new(&errors, &parameters)?;
        let Some((rows, Determinacy { inverse, .. })) = linear(&problem) else { return Ok(None) };
        let (mut squares, mut draw) = (Point::zeros(parameters.len()), Draw::new());
        let (values, mut noise, mut count) = (problem.values(&problem.start), 0.0, 0.0);
        for _ in 0..draws {
            let noisy = noisier(errors.logs, [most, 1.0], &mut draw);
            let residuals = Errors { logs: &noisy, ..errors.clone() }.by_log(&values)?;
            let mut score = Point::zeros(parameters.len());
            for (r, (before, gradient)) in residuals.iter().flatten().zip(&rows.rows) {
                // A row beyond says nothing of the accuracy.
                if gradient.amax() <= errors.largest_gradient {
                    score.axpy(r - before, gradient, 1.0);
                    (noise, count) = (noise + (r - before) * (r - before), count + 1.0);
                }
            }
            if self.ask().is_break() {
                return Ok(None);
            }
            let moved = &inverse * &score;
            noise -= score.dot(&moved);
            squares += moved.component_mul(&moved) / draws as f64;
        }
        Ok(Some((squares.map(f64::sqrt), noise / count)))
    }

    /// By how much as much noise again moves the search variables on average, that of the position
    /// at most of a size; nothing for commands.
    fn bias(&mut self, most: f64) -> Checked<Option<Point>> {
        let (errors, mut draw) = (self.errors.clone(), Draw::new());
        let mut sum = Point::zeros(self.parameters.len());
        if self.stopped || is_command(errors.logs) {
            return Ok(None);
        }
        for _ in 0..PAIRS {
            let before = draw.clone();
            for sign in [1.0, -1.0] {
                draw = before.clone();
                let noisy = noisier(errors.logs, [most, sign], &mut draw);
                let errors = Errors { logs: &noisy, ..errors.clone() };
                let found = linear(&Problem::new(&errors, &self.parameters)?);
                let (Some((_, found)), false) = (found, self.ask().is_break()) else {
                    return Ok(None);
                };
                sum += found.inverse * found.descent / (2 * PAIRS) as f64;
            }
        }
        Ok(Some(sum))
    }

    /// Standard errors are those that noise of drive and position leads one to expect, and those
    /// of the residuals as far as noise does not explain them: s² + (1 − 2 σ_n²/σ²)₊ s_r². It is
    /// twice the squares σ_n² that noise leaves, because those of a simulated log scatter as much.
    pub(super) fn know_noise(&mut self, fit: &mut Fit) -> Checked<()> {
        if fit.outcome == SearchOutcome::Stopped {
            return Ok(());
        }
        let values = fit.values();
        begin_at(&mut self.parameters, &values);
        let sizes = self.errors_by_noise(fit.rmse, DRAWS[1])?;
        let bias = self.bias(fit.rmse)?;
        if self.stopped {
            fit.outcome = SearchOutcome::Stopped;
        }
        let Some((sizes, noise)) = sizes else { return Ok(()) };
        self.noise = Some(noise.sqrt()).filter(|noise| *noise > 0.0);
        let unexplained = (1.0 - 2.0 * noise / (fit.rmse * fit.rmse)).max(0.0);
        let problem = Problem::new(&self.errors, &self.parameters)?;
        let slopes = problem.slopes(&values);
        if let Some(bias) = bias {
            // A linear step says little beyond a standard error.
            let bias = bias.zip_map(&sizes, |bias, size| bias.larger(-size).smaller(size));
            let values = problem.values(&problem.within(|i| problem.start[i] - bias[i]));
            fit.estimates.iter_mut().zip(values).for_each(|(e, value)| e.value = value);
        }
        for ((estimate, size), slope) in fit.estimates.iter_mut().zip(&sizes).zip(slopes) {
            let Estimate { value, standard_error, verdict, .. } = estimate;
            if matches!(verdict, Identifiability::Determined | Identifiability::Uncertain) {
                *standard_error = (unexplained.sqrt() * *standard_error).hypot(size * slope);
                *verdict = Identifiability::of(*value, *standard_error);
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
    fn an_encoder_that_stands_still_keeps_its_error() {
        let time: Vec<f64> = (0..200).map(|i| 5e-3 * f64::from(i)).collect();
        // Half a second at rest, then at a third of a count from row to row.
        let position: Vec<f64> =
            (0..200).map(|i| (f64::from(i - 100).max(0.0) / 3.0).round()).collect();
        let torque = vec![0.0; 200];
        let new = DriveLogParameters::new(&time, &position, Drive::Torque(&torque));
        let log = DriveLog::new(new).unwrap();
        let noisy = noisier(&[log], [f64::INFINITY, 1.0], &mut Draw::new());
        let errors: Vec<f64> =
            noisy[0].position.iter().zip(&position).map(|(noisy, x)| noisy - x).collect();
        let changes = |rows: core::ops::Range<usize>| {
            rows.filter(|&row| errors[row] != errors[row - 1]).count()
        };
        // A count lasts three rows, of which the middle one sees no change.
        assert!(errors[0] != 0.0 && changes(1..100) == 0 && changes(105..195) > 45, "{errors:?}");
    }
}
