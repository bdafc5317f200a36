//! How well the data tell the parameters at the best fit.

use alloc::collections::VecDeque;
use alloc::vec::Vec;

use nalgebra::{SMatrix, SVector};

use super::least_squares::{Point, Problem};
use super::residuals::Residuals;
use super::triangle::Triangle;
use super::{Estimate, Fit, Outcome, ResidualStatistics, Verdict, WeakDirection};

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
    let low: [bool; N] = core::array::from_fn(|i| point[i] <= axes[i].least && pushed[i] <= 0.0);
    let high: [bool; N] = core::array::from_fn(|i| point[i] >= axes[i].most && pushed[i] >= 0.0);
    let free: [bool; N] = core::array::from_fn(|i| !(low[i] || high[i]));

    // The pseudo-inverse of JᵀJ over the free parameters, and what it leaves out.
    let norms = triangle.column_norms();
    let directions = if smooth { triangle.directions(&free) } else { Vec::new() };
    let largest = directions.first().map_or(0.0, |d| d.0);
    let mut inverse = SMatrix::<f64, N, N>::zeros();
    let mut undetermined: [bool; N] = core::array::from_fn(|i| free[i] && !(norms[i] > 0.0));
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
    let correction = if spare > 0.0 { rows / spare } else { f64::INFINITY };
    let covariance = inverse * meat * inverse * correction;
    // Where few rows tell a parameter, the sum over scores is itself uncertain, and too small on the average.
    let variance = statistics.rmse.powi(2) * rows
        / statistics.effective_rows.max(f64::MIN_POSITIVE)
        * correction;
    let spread = |i: usize| covariance[(i, i)].max(0.0).sqrt();
    let deviation = |i: usize| spread(i).max((variance * inverse[(i, i)].max(0.0)).sqrt());
    let correlation = SMatrix::from_fn(|i, j| {
        let scale = spread(i) * spread(j);
        if i == j {
            1.0
        } else if scale > 0.0 && !undetermined[i] && !undetermined[j] {
            covariance[(i, j)] / scale
        } else {
            f64::NAN
        }
    });
    let estimates = core::array::from_fn(|i| {
        let parameter = problem.parameters[i];
        let value = axes[i].value(point[i]);
        let standard_error = if !free[i] {
            f64::NAN
        } else if undetermined[i] || !smooth {
            f64::INFINITY
        } else {
            deviation(i) * axes[i].slope(point[i])
        };
        let verdict = if low[i] {
            Verdict::AtLowerBound
        } else if high[i] {
            Verdict::AtUpperBound
        } else if undetermined[i] || !smooth {
            Verdict::Undetermined
        } else if standard_error <= value.abs() {
            Verdict::Determined
        } else {
            Verdict::Uncertain
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
    let correlation = |lag: usize| {
        let pairs = residuals.iter().zip(residuals.iter().skip(lag));
        let product: f64 = pairs.map(|(a, b)| (a - mean) * (b - mean)).sum();
        if variance > 0.0 { product / variance } else { 0.0 }
    };
    // Sokal's window: the sum ends where it is five correlation times long.
    let longest = (rows / 10).max(1);
    let (mut time, mut lag) = (1.0_f64, 0);
    while lag < longest && (lag as f64) < 5.0 * time {
        lag += 1;
        time += 2.0 * correlation(lag);
    }
    let time = time.max(1.0);
    ResidualStatistics {
        rows,
        rmse: (squares / count).sqrt(),
        mean,
        largest: residuals.iter().fold(0.0, |most, r| f64::max(most, r.abs())),
        correlation: correlation(1),
        effective_rows: count / time,
        // Bartlett's weights lose a share of about (correlation time)/window of the variance.
        window: ((10.0 * time) as usize).clamp(1, longest),
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
