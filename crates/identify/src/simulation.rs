//! The simulation error: a model that sees only the motion, compared with the measured friction.

use core::ops::ControlFlow;

use nalgebra::DVector;

use super::initial_guess::bulk;
use super::log::FEWEST;
use super::residuals::{Parameter, Residuals};
use super::triangle::Triangle;
use super::{Candidate, Fit, Log, Remark, SearchProgress, SearchSettings, least_squares};
use bristle::parameter::{Checked, Named, ParameterError};
use bristle::scalar::lit;
use bristle::{Bristle, Scalar};

/// The residuals of a candidate along a log.
struct Along<'a, C, const N: usize> {
    candidate: &'a C,
    log: &'a Log,
    /// Initial friction coefficient: the first row, cut to the range of nearly all rows. Otherwise
    /// the search would bend the whole curve to reach one bad row.
    first: f64,
}

impl<'a, C: Candidate<N>, const N: usize> Along<'a, C, N> {
    /// Checks that enough rows count for the parameters.
    fn new(candidate: &'a C, log: &'a Log) -> Checked<Self> {
        Named("rows after settling", log.len() - log.settled()).count(FEWEST.max(N + 1))?;
        let (low, high) = bulk(&mut log.coefficient.clone());
        let first = log.coefficient.first().copied().unwrap_or(0.0).larger(low).smaller(high);
        Ok(Self { candidate, log, first })
    }

    /// Passes the model's friction coefficient at every row to `each`.
    fn run<T: Scalar>(&self, values: &[T; N], mut each: impl FnMut(T)) -> Checked<()> {
        let model = self.candidate.model(values)?;
        let offset = self.candidate.offset(values);
        let Log { time, held, velocity, .. } = self.log;
        let substeps = self.candidate.substeps().get();
        let part = 1.0 / f64::from(substeps);
        // The deflection that gives the first measured friction at rest, at most that of slow
        // sliding: a first row beyond that is an error of the sensor, not a stretched bristle.
        let forward = bristle::Branch::Forward.of(T::zero());
        let full = model.stationary(forward);
        let share = (lit::<T>(self.first) - offset) / model.coefficient(forward, full);
        let mut deflection = full * share.larger(-T::one()).smaller(T::one());
        let mut before: Option<f64> = None;
        for ((&time, &held), &velocity) in time.iter().zip(held).zip(velocity) {
            if let Some(before) = before.replace(time) {
                let duration = lit((time - before) * part);
                for _ in 0..substeps {
                    deflection = model.hold(lit::<T>(held), deflection, duration).deflection;
                }
            }
            each(model.coefficient(lit::<T>(velocity), deflection) + offset);
        }
        Ok(())
    }
}

impl<C: Candidate<N>, const N: usize> Residuals<N> for Along<'_, C, N> {
    fn evaluate<T: Scalar>(&self, values: &[T; N], each: &mut impl FnMut(T)) -> Checked<()> {
        let (mut rows, settled) = (self.log.coefficient.iter().enumerate(), self.log.settled());
        self.run(values, |model: T| {
            if let Some((_, &measured)) = rows.next().filter(|(row, _)| *row >= settled) {
                each(model - lit(measured));
            }
        })
    }
}

/// Finds the parameters of a candidate with the least simulation error along a log.
///
/// The starts and bounds are those of [`Candidate::parameters`], or your own.
///
/// ```
/// use bristle_identify as identify;
/// use bristle_identify::{
///     Candidate, FrBdFit, InitialGuess, Log, LogParameters, MeasuredMotion, SearchProgress,
///     SearchSettings,
/// };
/// use bristle::{Bristle, FrBd, paper};
/// use bristle::curve::Stribeck;
/// use bristle::rheology::KelvinVoigt;
/// use core::ops::ControlFlow;
///
/// // A measurement: to and fro with speeds around the Stribeck velocity, rows 0.5 ms apart.
/// let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
/// let friction = FrBd::new(curve, KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?);
/// let (mut time, mut velocity, mut force, mut z) = (vec![], vec![], vec![], 0.0);
/// for i in 0..4000 {
///     let t = 5e-4 * f64::from(i);
///     let v = 0.04 * (6.0 * t).sin() * (1.0 + 0.5 * (2.0 * t).cos());
///     if let Some(&before) = velocity.last() {
///         z = friction.hold(0.5 * (v + before), z, 5e-4).deflection;
///     }
///     time.push(t);
///     velocity.push(v);
///     force.push(10.0 * friction.coefficient(v, z));
/// }
/// let log = Log::new(LogParameters {
///     time: &time,
///     motion: MeasuredMotion::Velocity(&velocity),
///     friction: &force,
///     normal_force: Some(&vec![10.0; time.len()]),
/// })?;
///
/// let parameters = FrBdFit.parameters(&InitialGuess::of(&log)?);
/// let mut go_on = |_: &SearchProgress<'_>| ControlFlow::Continue(());
/// let fit = identify::fit(&FrBdFit, parameters, &log, &SearchSettings::default(), &mut go_on)?;
/// println!("{fit}");
/// let stiffness = fit.estimate("micro_stiffness").unwrap();
/// assert!((stiffness.value - 1e4).abs() < 1.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// Refuses a log in which, after its settling time, fewer than 20 rows are left or no more rows
/// than parameters; and what [`least_squares`] refuses.
pub fn fit<C: Candidate<N>, const N: usize>(
    candidate: &C,
    parameters: [Parameter; N],
    log: &Log,
    settings: &SearchSettings,
    progress: &mut dyn FnMut(&SearchProgress<'_>) -> ControlFlow<()>,
) -> Checked<Fit> {
    let along = Along::new(candidate, log)?;
    let mut fit = least_squares(&along, parameters, settings, progress)?;
    fit.remarks.extend(motor_torque(log, fit.rmse));
    Ok(fit)
}

/// Share of the usual friction that residuals must exceed before another explanation is sought.
const LARGE: f64 = 0.1;
/// Share of their squares that it must explain.
const EXPLAINED: f64 = 0.5;
/// Columns of the equation of motion: a constant, position, velocity, its sign and acceleration.
const COLUMNS: usize = 5;

/// Whether an equation of motion with Coulomb friction, which is linear in its parameters, explains
/// the rows of a log that count better than a friction model with this root mean square.
fn motor_torque(log: &Log, rmse: f64) -> Option<Remark> {
    let positions = log.positions();
    let speed = bulk(&mut log.velocity.iter().map(|v| v.abs()).collect::<Vec<f64>>()).1;
    let around = log.time.windows(3).zip(log.velocity.windows(3));
    let slopes = around.map(|(t, v)| (v[2] - v[0]) / (t[2] - t[0]));
    let accelerations = core::iter::once(0.0).chain(slopes).chain([0.0]);
    let rows = positions.iter().zip(&log.velocity).zip(accelerations).zip(&log.coefficient);
    let rows = rows.skip(log.settled()).map(|(((&x, &v), acceleration), &mu)| {
        ([1.0, x, v, v / (v.abs() + 0.02 * speed), acceleration], mu)
    });
    let mut triangle = Triangle::new(COLUMNS);
    rows.clone().for_each(|(row, mu)| triangle.push(&mut DVector::from_row_slice(&row), mu));
    let found = triangle.damped(&(triangle.column_norms() * 1e-9), &[true; COLUMNS]);
    let (mut left, mut all, mut count) = (0.0, 0.0, 0.0);
    for (row, mu) in rows {
        let model: f64 = row.iter().zip(&found).map(|(x, factor)| x * factor).sum();
        (left, all, count) = (left + (mu - model).powi(2), all + mu * mu, count + 1.0);
    }
    let explained = 1.0 - left / (rmse * rmse * count);
    let wrong = rmse * rmse * count > LARGE * LARGE * all && explained > EXPLAINED;
    wrong.then_some(Remark::LooksLikeMotorTorque { explained })
}

/// The friction coefficient \[–\] of a candidate at every row of a log: how well does a fit predict
/// data that it has not seen? [`Log::rmse`] and [`Log::work`] compare it with the data.
///
/// # Errors
///
/// Refuses another number of values than the model takes, values that it refuses or for which its
/// friction is not finite (with the row), and a log that [`fit`] refuses.
pub fn predict<C: Candidate<N>, const N: usize>(
    candidate: &C,
    values: &[f64],
    log: &Log,
) -> Checked<Vec<f64>> {
    Named("values", values.len()).count_between(N, N)?;
    let values: [f64; N] = core::array::from_fn(|i| values[i]);
    let mut coefficients = Vec::with_capacity(log.len());
    Along::new(candidate, log)?.run(&values, |model: f64| coefficients.push(model))?;
    let finite = |&mu: &f64| Named("friction of the model", mu).finite();
    ParameterError::of_components(&coefficients, finite)?;
    Ok(coefficients)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use crate::{ElastoPlasticFit, FrBdFit, LogParameters, MeasuredMotion};
    use core::num::NonZero;
    use num_dual::DualSVec64;

    /// Dual numbers against central differences, row by row.
    fn sensitivities<C: Candidate<N>, const N: usize>(candidate: &C, values: [f64; N]) {
        let time: Vec<f64> = (0..400).map(|i| 2e-3 * f64::from(i)).collect();
        let velocity: Vec<f64> =
            time.iter().map(|t| 0.03 * (9.0 * t).sin() + 0.004 * (70.0 * t).sin()).collect();
        let friction: Vec<f64> = velocity.iter().map(|v| 0.25 * (v / 1e-3).tanh()).collect();
        let motion = MeasuredMotion::Velocity(&velocity);
        let log = Log::new(LogParameters {
            time: &time,
            motion,
            friction: &friction,
            normal_force: None,
        })
        .unwrap();
        let along = Along { candidate, log: &log, first: log.coefficient[0] };
        let duals: [DualSVec64<N>; N] =
            core::array::from_fn(|i| DualSVec64::from_re(values[i]).derivative(i));
        let mut exact = Vec::new();
        along
            .evaluate(&duals, &mut |r: DualSVec64<N>| {
                exact.push(r.eps.unwrap_generic(nalgebra::Const::<N>, nalgebra::U1));
            })
            .unwrap();
        for i in 0..N {
            let run = |factor: f64| {
                let mut moved = values;
                moved[i] *= factor;
                let mut residuals = Vec::new();
                along.evaluate(&moved, &mut |r: f64| residuals.push(r)).unwrap();
                residuals
            };
            // The error of differences is about h² and ε/h, both 10⁻¹⁰ or so of the sensitivity to
            // ln p, which is up to one; corners of the elasto-plastic α and roots of modes add to
            // it.
            let (up, down) = (run(1.0 + 1e-5), run(1.0 - 1e-5));
            for (row, (up, down)) in up.iter().zip(&down).enumerate() {
                let (difference, dual) = ((up - down) / 2e-5, exact[row][i] * values[i]);
                assert!(
                    (difference - dual).abs() < 1e-6,
                    "{candidate:?}, parameter {i}, row {row}: {difference} {dual}"
                );
            }
        }
    }

    #[test]
    fn sensitivities_are_those_of_the_residuals() {
        sensitivities(&FrBdFit, [0.2, 0.1, 0.01, 0.8, 6e3, 8.0]);
        let elasto_plastic = ElastoPlasticFit { substeps: NonZero::new(2).unwrap() };
        sensitivities(&elasto_plastic, [0.2, 0.1, 0.01, 0.8, 6e3, 8.0, 0.7, 0.01]);
    }
}
