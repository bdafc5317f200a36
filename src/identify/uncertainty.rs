//! How well the data tell the parameters at the best fit.

use alloc::collections::VecDeque;
use alloc::vec::Vec;

use nalgebra::{SMatrix, SVector};

use super::least_squares::{Point, Problem};
use super::residuals::{Residuals, within};
use super::triangle::Triangle;
use super::{Estimate, Fit, Identifiability, Outcome, ResidualStatistics, WeakDirection};

/// Share of the largest singular value of the scaled sensitivities below which a direction has no effect: the
/// square root of a rounding leaves half of the digits.
const SINGULAR: f64 = 1.5e-8;

/// Share of a parameter in a direction without effect from which on it is undetermined. Less comes from
/// rounding and from parameters that make up for one another nearly, but not quite.
const SHARE: f64 = 0.03;

/// The fit at a point, with its standard errors.
pub(super) fn assess<R: Residuals<N>, const N: usize>(
    problem: &Problem<'_, R, N>,
    point: &Point<N>,
    outcome: Outcome,
    iterations: usize,
) -> Fit<N> {
    let mut residuals = Vec::new();
    let mut triangle = Triangle::new();
    let smooth = problem.rows(point, |residual, gradient| {
        residuals.push(residual);
        triangle.push(*gradient, -residual);
    });
    let statistics = statistics(&residuals);
    let axes = &problem.axes;
    let pushed = triangle.gradient();
    let fixed: [bool; N] = core::array::from_fn(|i| axes[i].least >= axes[i].most);
    let low: [bool; N] = core::array::from_fn(|i| point[i] <= axes[i].least && pushed[i] <= 0.0);
    let high: [bool; N] = core::array::from_fn(|i| point[i] >= axes[i].most && pushed[i] >= 0.0);
    let free: [bool; N] = core::array::from_fn(|i| !(fixed[i] || low[i] || high[i]));

    // The pseudo-inverse of JᵀJ over the free parameters, and what it leaves out.
    let norms = triangle.column_norms();
    let directions = if smooth { triangle.directions(&free) } else { Vec::new() };
    let largest = directions.first().map_or(0.0, |d| d.0);
    let mut inverse = SMatrix::<f64, N, N>::zeros();
    // Without directions the sensitivities are not finite or all zero, and tell nothing of any parameter.
    let mut undetermined: [bool; N] =
        core::array::from_fn(|i| free[i] && (directions.is_empty() || !(norms[i] > 0.0)));
    let mut weak = Vec::new();
    for (value, direction) in &directions {
        let unscaled =
            SVector::<f64, N>::from_fn(
                |i, _| if norms[i] > 0.0 { direction[i] / norms[i] } else { 0.0 },
            );
        if *value > SINGULAR * largest {
            inverse += unscaled * unscaled.transpose() / (value * value);
            continue;
        }
        for (flag, share) in undetermined.iter_mut().zip(direction.iter()) {
            *flag |= share.abs() > SHARE;
        }
        let mut shares: Vec<(&'static str, f64)> =
            problem.parameters.iter().map(|p| p.name).zip(direction.iter().copied()).collect();
        shares.retain(|(_, share)| share.abs() > SHARE);
        shares.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
        weak.push(WeakDirection { strength: value / largest, shares });
    }

    let meat = scores(problem, point, statistics.window);
    let rows = residuals.len() as f64;
    let spare = rows - N as f64;
    let known = smooth && spare > 0.0;
    let correction = if known { rows / spare } else { 1.0 };
    let covariance = inverse * meat * inverse * correction;
    // A product of three symmetric matrices is one only up to rounding.
    let covariance = (covariance + covariance.transpose()) * 0.5;
    // Where few rows tell a parameter, the sum over scores is itself uncertain, and too small on the average.
    let variance = statistics.rmse.powi(2) * rows
        / statistics.effective_rows.max(f64::MIN_POSITIVE)
        * correction;
    // Ask for what is finite: `max` would make a zero of what is not a number.
    let root =
        |square: f64| if square.is_finite() { square.max(0.0).sqrt() } else { f64::INFINITY };
    let spread = |i: usize| root(covariance[(i, i)]);
    let deviation = |i: usize| spread(i).max(root(variance * inverse[(i, i)]));
    let correlation = SMatrix::from_fn(|i, j| {
        let scale = spread(i) * spread(j);
        if i == j {
            1.0
        } else if known && scale > 0.0 && scale.is_finite() && !undetermined[i] && !undetermined[j]
        {
            within(covariance[(i, j)] / scale, -1.0, 1.0)
        } else {
            f64::NAN
        }
    });
    let estimates = core::array::from_fn(|i| {
        let parameter = problem.parameters[i];
        let value = axes[i].value(point[i]);
        let standard_error = if !free[i] {
            f64::NAN
        } else if undetermined[i] || !known {
            f64::INFINITY
        } else {
            deviation(i) * axes[i].slope(point[i])
        };
        let verdict = if fixed[i] {
            Identifiability::Fixed
        } else if low[i] {
            Identifiability::AtLowerBound
        } else if high[i] {
            Identifiability::AtUpperBound
        } else if undetermined[i] || !smooth {
            Identifiability::Undetermined
        } else if standard_error <= value.abs() {
            Identifiability::Determined
        } else {
            Identifiability::Uncertain
        };
        Estimate { parameter, value, standard_error, verdict }
    });
    Fit { estimates, correlation, residuals: statistics, weak, outcome, iterations }
}

fn statistics(residuals: &[f64]) -> ResidualStatistics {
    let rows = residuals.len();
    let count = rows.max(1) as f64;
    let mean = residuals.iter().sum::<f64>() / count;
    let squares: f64 = residuals.iter().map(|r| r * r).sum();
    let variance: f64 = residuals.iter().map(|r| (r - mean) * (r - mean)).sum();
    let pairs = residuals.iter().zip(residuals.iter().skip(1));
    let next: f64 = pairs.map(|(a, b)| (a - mean) * (b - mean)).sum();
    let longest = (rows / 10).max(1);
    let time = correlation_time(residuals.iter().map(|r| r - mean).collect()).max(1.0);
    ResidualStatistics {
        rows,
        rmse: (squares / count).sqrt(),
        mean,
        largest: residuals.iter().fold(0.0, |most, r| f64::max(most, r.abs())),
        correlation: if variance > 0.0 { next / variance } else { 0.0 },
        effective_rows: count / time,
        // Bartlett's weights lose a share of about (correlation time)/window of the variance.
        window: ((10.0 * time) as usize).clamp(1, longest),
    }
}

/// Lags that are summed row by row: enough for a correlation time of 400 rows, and for every log of 20 000 rows.
const LAGS: usize = 2000;

/// Rows in a block, where more lags are needed.
const BLOCK: usize = 10;

/// τ = 1 + 2 Σ ρ of deviations from their mean, summed to five τ (Sokal's window), at most over a tenth of the rows.
///
/// Where 2000 lags do not reach, the deviations are averaged in blocks of ten, whose mean has the same variance:
/// τ σ²/n = τ_b σ_b²/(n/10). So the time it takes grows with the number of rows, not with its square.
fn correlation_time(mut deviations: Vec<f64>) -> f64 {
    let mut factor = 1.0;
    loop {
        let variance: f64 = deviations.iter().map(|d| d * d).sum();
        if !(variance > 0.0) {
            return factor;
        }
        let longest = (deviations.len() / 10).max(1);
        let (mut time, mut lag) = (1.0_f64, 0);
        while lag < longest.min(LAGS) && (lag as f64) < 5.0 * time {
            lag += 1;
            let pairs = deviations.iter().zip(deviations.iter().skip(lag));
            time += 2.0 * pairs.map(|(a, b)| a * b).sum::<f64>() / variance;
        }
        if lag == longest || !((lag as f64) < 5.0 * time) {
            return factor * time;
        }
        let rows = deviations.len() as f64;
        let mean = |block: &[f64]| block.iter().sum::<f64>() / BLOCK as f64;
        deviations = deviations.chunks_exact(BLOCK).map(mean).collect();
        let of_blocks: f64 = deviations.iter().map(|d| d * d).sum();
        // Sums of squares over their numbers are the variances.
        factor *= BLOCK as f64 * (of_blocks / deviations.len() as f64) / (variance / rows);
    }
}

/// Newey and West's Σ Σ w(s − t) gₜ gₛᵀ with gₜ = Jₜᵀ rₜ and Bartlett's weights 1 − |lag|/window, as the mean of
/// the squares of all sums of `window` scores in a row, which is the same and needs no more memory than the window.
fn scores<R: Residuals<N>, const N: usize>(
    problem: &Problem<'_, R, N>,
    point: &Point<N>,
    window: usize,
) -> SMatrix<f64, N, N> {
    let mut recent: VecDeque<SVector<f64, N>> = VecDeque::with_capacity(window);
    let mut sum = SVector::<f64, N>::zeros();
    let mut meat = SMatrix::<f64, N, N>::zeros();
    let mut add = |score: SVector<f64, N>| {
        if recent.len() == window
            && let Some(oldest) = recent.pop_front()
        {
            sum -= oldest;
        }
        recent.push_back(score);
        sum += score;
        meat += sum * sum.transpose();
    };
    problem.rows(point, |residual, gradient| add(gradient * residual));
    (1..window).for_each(|_| add(SVector::zeros()));
    meat / window as f64
}
