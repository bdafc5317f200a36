//! How well the data determine the parameters at the best fit.

use nalgebra::DMatrix;

use super::least_squares::{Found, NOTICEABLE};
use super::log::pairs;
use super::problem::{Objective, Point, Problem, Rows};
use super::residuals::Parameter;
use super::{Estimate, Fit, Identifiability, Remark, SearchOutcome};
use bristle::Scalar;

/// Singular values of the scaled sensitivities below this share of the largest have no effect: √ε,
/// with which half of the digits are left.
const SINGULAR: f64 = 1.5e-8;

/// A parameter with this share of a direction without effect is undetermined. Smaller shares come
/// from rounding, and from parameters that nearly make up for one another.
const SHARE: f64 = 0.03;

/// Movement of a search variable along its own gradient that is rounding, whatever it changes.
const SETTLED: f64 = 1e-6;

/// The fit at a point, with its standard errors. Beyond a size of its gradient in the search
/// variables a row says nothing of the accuracy of the parameters: a linear model of it would hold
/// for no change that is worth a name.
pub(super) fn assess<R: Objective>(problem: &Problem<'_, R>, found: &Found, largest: f64) -> Fit {
    let &Found { ref point, outcome, iterations, .. } = found;
    let mut rows = problem.rows(point);
    let all = rows.rows.len();
    rows.rows.retain(|(_, gradient)| !(gradient.amax() > largest));
    let dropped = all - rows.rows.len();
    let residuals: Vec<f64> = rows.rows.iter().map(|(residual, _)| *residual).collect();
    let series = Series::of(&residuals);
    let determined = Determinacy::of(problem, point, &rows);
    let Determinacy { descent, norms, resting, .. } = &determined;

    // A parameter that could still go down its gradient, noticeably.
    let goes_on = |((&gradient, &norm), rests): ((&f64, &f64), &Option<_>)| {
        let share = gradient * gradient / (norm * norm * series.squares);
        rests.is_none() && share > NOTICEABLE && gradient.abs() > SETTLED * norm * norm
    };
    let stalled = descent.iter().zip(norms).zip(resting).any(goes_on);
    let converged = outcome == SearchOutcome::Converged;
    let outcome = if converged && stalled { SearchOutcome::Stalled } else { outcome };

    let (errors, correlation) = determined.accuracy(&rows, &series);
    let values = problem.values(point);
    let slopes = problem.slopes(&values);
    let estimate = |(i, &parameter): (usize, &Parameter)| {
        let value = values[i];
        let (verdict, standard_error) = match resting[i] {
            Some(rests) => (rests, f64::NAN),
            None if determined.undetermined[i] || !rows.finite => {
                (Identifiability::Undetermined, f64::INFINITY)
            }
            None => {
                let error = errors[i] * slopes[i];
                (Identifiability::of(value, error), error)
            }
        };
        Estimate { parameter, log: None, value, standard_error, verdict }
    };
    let too_sensitive = Remark::RowsTooSensitive { rows: dropped };
    Fit {
        estimates: problem.parameters.iter().enumerate().map(estimate).collect(),
        correlation,
        rows: residuals.len(),
        rmse: series.rmse,
        neighbour_correlation: series.neighbour_correlation,
        effective_rows: residuals.len() as f64 / series.time,
        window: series.window,
        weak: determined.weak,
        remarks: (dropped > 0).then_some(too_sensitive).into_iter().collect(),
        outcome,
        iterations,
    }
}

/// The residuals as a series in time.
struct Series {
    squares: f64,
    rmse: f64,
    neighbour_correlation: f64,
    /// Correlation time [rows].
    time: f64,
    /// Rows over which scores are added.
    window: usize,
}

impl Series {
    fn of(residuals: &[f64]) -> Self {
        let count = residuals.len().max(1) as f64;
        let mean = residuals.iter().sum::<f64>() / count;
        let deviations: Vec<f64> = residuals.iter().map(|r| r - mean).collect();
        let around: f64 = deviations.iter().map(|d| d * d).sum();
        let next: f64 = pairs(&deviations).map(|(a, b)| a * b).sum();
        let squares: f64 = residuals.iter().map(|r| r * r).sum();
        let time = correlation_time(deviations).max(1.0);
        Self {
            squares,
            rmse: (squares / count).sqrt(),
            neighbour_correlation: if around > 0.0 { next / around } else { 0.0 },
            time,
            // Bartlett's weights lose about (correlation time)/window of the variance: a tenth.
            window: ((10.0 * time) as usize).clamp(1, (residuals.len() / 10).max(1)),
        }
    }
}

/// What the sensitivities determine of the parameters, and what not.
pub(super) struct Determinacy {
    /// The pseudo-inverse of JᵀJ over the directions with an effect.
    pub(super) inverse: DMatrix<f64>,
    undetermined: Vec<bool>,
    /// The directions without an effect.
    weak: Vec<Vec<(&'static str, f64)>>,
    /// −Jᵀ r.
    pub(super) descent: Point,
    /// The lengths of the columns.
    norms: Point,
    resting: Vec<Option<Identifiability>>,
}

impl Determinacy {
    /// That of rows at a point.
    pub(super) fn of<R: Objective>(problem: &Problem<'_, R>, point: &Point, rows: &Rows) -> Self {
        let (parameters, width) = (problem.parameters, problem.parameters.len());
        let linear = rows.linear(width);
        let (descent, norms) = (linear.gradient(), linear.column_norms());
        let resting = problem.resting(point, &descent);
        let free: Vec<bool> = resting.iter().map(Option::is_none).collect();
        let directions = if rows.finite { linear.directions(&free) } else { Vec::new() };
        let largest = directions.first().map_or(0.0, |d| d.0);
        let mut inverse = DMatrix::<f64>::zeros(width, width);
        // Without directions the sensitivities are not finite or all zero, and determine no
        // parameter.
        let mut undetermined: Vec<bool> = (free.iter().zip(&norms))
            .map(|(&free, &norm)| free && (directions.is_empty() || !(norm > 0.0)))
            .collect();
        let mut weak = Vec::new();
        for (value, direction) in &directions {
            if *value > SINGULAR * largest {
                // A column of zeros has no share in any direction.
                let unscaled =
                    direction.zip_map(&norms, |x, norm| if norm > 0.0 { x / norm } else { x });
                inverse += &unscaled * unscaled.transpose() / (value * value);
                continue;
            }
            let has_share = |&share: &f64| share.abs() > SHARE;
            undetermined.iter_mut().zip(direction).for_each(|(flag, x)| *flag |= has_share(x));
            let names = parameters.iter().map(|parameter| parameter.name);
            let shares = names.zip(direction.iter().copied());
            let mut shares: Vec<_> = shares.filter(|(_, share)| has_share(share)).collect();
            shares.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
            weak.push(shares);
        }
        Self { inverse, undetermined, weak, descent, norms, resting }
    }

    /// The standard errors of the search variables, and their correlation.
    fn accuracy(&self, rows: &Rows, series: &Series) -> (Vec<f64>, DMatrix<f64>) {
        let Self { inverse, undetermined, .. } = self;
        let (count, width) = (rows.rows.len(), undetermined.len());
        let known = rows.finite && count > width;
        let correction = if known { count as f64 / (count - width) as f64 } else { 1.0 };
        let covariance = inverse * scores(rows, width, series.window) * inverse * correction;
        // Rounding leaves the product of three symmetric matrices slightly unsymmetric.
        let covariance = (&covariance + covariance.transpose()) * 0.5;
        // Where few rows determine a parameter, the sum over scores is uncertain, and too small on
        // average.
        let variance = series.rmse * series.rmse * series.time * correction;
        // `max` alone would turn NaN into zero.
        let root =
            |square: f64| if square.is_finite() { square.max(0.0).sqrt() } else { f64::INFINITY };
        let spread = |i: usize| root(covariance[(i, i)]);
        let larger = |i: usize| spread(i).max(root(variance * inverse[(i, i)]));
        let errors = (0..width).map(|i| if known { larger(i) } else { f64::INFINITY }).collect();
        let correlation = DMatrix::from_fn(width, width, |i, j| {
            let scale = spread(i) * spread(j);
            let sound = known && scale > 0.0 && scale.is_finite();
            if i == j {
                1.0
            } else if sound && !undetermined[i] && !undetermined[j] {
                (covariance[(i, j)] / scale).larger(-1.0).smaller(1.0)
            } else {
                f64::NAN
            }
        });
        (errors, correlation)
    }
}

/// Lags that are summed row by row: enough for a correlation time of 400 rows, and for every log of
/// up to 20 000 rows.
const LAGS: usize = 2000;

/// Rows in a block, where more lags are needed.
const BLOCK: usize = 10;

/// τ = 1 + 2 Σ ρ of deviations from their mean, summed to five τ (Sokal's window), at most over a
/// tenth of the rows.
///
/// Where 2000 lags do not suffice, the deviations are averaged in blocks of ten. The mean of the
/// blocks has the variance of the mean of the rows, τ σ²/n = τ_b σ_b²/(n/10). The time needed
/// therefore grows with the number of rows, not with its square.
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
        // A variance is the sum of squares over its number.
        factor *= BLOCK as f64 * (of_blocks / deviations.len() as f64) / (variance / rows);
    }
}

/// Newey and West's Σ Σ w(s − t) gₜ gₛᵀ with gₜ = Jₜᵀ rₜ and Bartlett's weights 1 − |lag|/window.
///
/// It equals the mean of the squares of all sums of `window` consecutive scores.
fn scores(rows: &Rows, width: usize, window: usize) -> DMatrix<f64> {
    let mut sum = Point::zeros(width);
    let mut meat = DMatrix::<f64>::zeros(width, width);
    for row in 0..rows.rows.len() + window - 1 {
        let oldest = row.checked_sub(window).and_then(|row| rows.rows.get(row));
        oldest.into_iter().for_each(|(r, gradient)| sum.axpy(-r, gradient, 1.0));
        rows.rows.get(row).into_iter().for_each(|(r, gradient)| sum.axpy(*r, gradient, 1.0));
        meat.ger(1.0, &sum, &sum, 1.0);
    }
    meat / window as f64
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    /// Residuals x − k, and one that hardly any x can explain.
    struct Exploding;

    impl Objective for Exploding {
        fn evaluate<T: bristle::Scalar>(
            &self,
            values: &[T],
            each: &mut impl FnMut(T),
        ) -> Result<(), bristle::ParameterError> {
            let lit = bristle::scalar::lit::<T>;
            let [x, y] = [0, 1].map(|i| values.get(i).copied().unwrap_or_else(T::zero));
            (0..30).for_each(|k| each(x + y * lit(f64::from(k)) - lit(f64::from(k % 7))));
            each((x - lit(3.0)) * lit(1e12));
            Ok(())
        }
    }

    #[test]
    fn a_row_with_an_exploded_gradient_says_nothing_of_the_accuracy() {
        let parameter = |name, start| Parameter {
            name,
            unit: "",
            start,
            least: -10.0,
            most: 10.0,
            typical: Some(1.0),
        };
        let parameters = [parameter("x", 3.0), parameter("y", 0.01)];
        let assessed = |largest| {
            let problem = Problem::new(&Exploding, &parameters).unwrap();
            let (outcome, iterations) = (SearchOutcome::RunLimit, 0);
            let (point, cost, values) = (problem.start.clone(), 0.0, vec![]);
            assess(&problem, &Found { values, point, cost, outcome, iterations }, largest)
        };
        // Beside 10¹² the others fall below half of the digits.
        let (all, kept) = (assessed(f64::INFINITY), assessed(1e6));
        assert!((all.rows, kept.rows) == (31, 30), "{all} {kept}");
        assert!(all.remarks.is_empty());
        assert_eq!(kept.remarks, [Remark::RowsTooSensitive { rows: 1 }]);
        // σ/√n of the mean of 30 numbers between −3 and 3, and a slope beside it.
        let error = kept.estimates[0].standard_error;
        assert!(error > 0.1 && error < 2.0, "{kept}");
        assert!(all.estimates[0].standard_error < 1e-6, "{all}");
    }

    #[test]
    fn rows_repeated_ten_times_correlate_for_ten_times_as_many() {
        // An autoregressive process of correlation time (1 + φ)/(1 − φ) = 66 rows, driven by
        // uniform noise from a congruential generator.
        let (mut state, mut value) = (1_u32, 0.0);
        let once: Vec<f64> = (0..2100)
            .map(|_| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                value = 0.97 * value + f64::from(state) / f64::from(u32::MAX) - 0.5;
                value
            })
            .collect();
        let repeated: Vec<f64> = once.iter().flat_map(|&row| [row; BLOCK]).collect();
        // 2000 lags do not reach five times 660 rows; the blocks are the rows before repetition.
        let (one, ten) = (correlation_time(once), correlation_time(repeated));
        assert!(one > 0.2 * LAGS as f64 / BLOCK as f64, "{one}");
        // Sums of 21 000 roundings.
        assert!((ten / (BLOCK as f64 * one) - 1.0).abs() < 1e-9, "{ten} of {one}");
    }
}
