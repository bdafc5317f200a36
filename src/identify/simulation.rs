//! The simulation error: a model that sees only the motion, compared with the measured friction.

use alloc::vec::Vec;
use core::ops::ControlFlow;

use super::initial_guess::bulk;
use super::log::FEWEST;
use super::residuals::{Parameter, Residuals, within};
use super::{Candidate, Fit, IdentifyError, InitialGuess, Log, Progress, Settings, least_squares};
use crate::parameter::ParameterError;
use crate::scalar::lit;
use crate::{Bristle, Scalar};

/// How a model is run along a log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Simulation {
    /// Time \[s\] at the beginning that is left out, until the bristle has forgotten its initial
    /// deflection. Not negative.
    pub settle: f64,
    /// Exact steps per row, at least one. One is enough unless the model freezes a coefficient over
    /// a step, as the elasto-plastic one does.
    pub substeps: usize,
}

impl Default for Simulation {
    /// Every row counts, one step each.
    fn default() -> Self {
        Self { settle: 0.0, substeps: 1 }
    }
}

/// The residuals of a candidate along a log.
struct Along<'a, C, const N: usize> {
    candidate: &'a C,
    parameters: [Parameter; N],
    log: &'a Log,
    simulation: Simulation,
    /// Initial friction coefficient: the first row, cut to the range of nearly all rows. Otherwise
    /// the search would bend the whole curve to reach one bad row.
    first: f64,
}

impl<'a, C: Candidate<N>, const N: usize> Along<'a, C, N> {
    /// Checks the settings, and that enough rows are left.
    fn new(
        candidate: &'a C,
        parameters: [Parameter; N],
        log: &'a Log,
        simulation: Simulation,
    ) -> Result<Self, IdentifyError> {
        let Simulation { settle, substeps } = simulation;
        if !(settle.is_finite() && settle >= 0.0) {
            let rule = "be finite and not negative";
            return Err(IdentifyError::Value { name: "settle", value: settle, rule });
        }
        if substeps == 0 {
            let rule = "be at least 1";
            return Err(IdentifyError::Value { name: "substeps", value: 0.0, rule });
        }
        let (low, high) = bulk(&mut log.coefficient.clone());
        let first = within(log.coefficient.first().copied().unwrap_or(0.0), low, high);
        let along = Self { candidate, parameters, log, simulation, first };
        let counts_from = along.counts_from();
        let rows = log.time.iter().filter(|&&time| time >= counts_from).count();
        let least = FEWEST.max(N + 1);
        if rows < least {
            return Err(IdentifyError::TooFewRows { rows, least });
        }
        Ok(along)
    }

    /// The time \[s\] from which rows count.
    fn counts_from(&self) -> f64 {
        self.log.time.first().copied().unwrap_or(0.0) + self.simulation.settle
    }

    /// Passes the model's friction coefficient at every row to `each`, with the residual if the row
    /// counts.
    fn run<T: Scalar>(
        &self,
        values: &[T; N],
        mut each: impl FnMut(T, Option<T>),
    ) -> Result<(), ParameterError> {
        let model = self.candidate.model(values)?;
        let offset = self.candidate.offset(values);
        let Log { time, held, velocity, coefficient } = self.log;
        let counts_from = self.counts_from();
        let substeps = self.simulation.substeps;
        let count = 1.0 / substeps as f64;
        // The deflection that gives the first measured friction at rest. Slow sliding carries no
        // more than `carried`: a first row beyond that is an error of the sensor, not a stretched
        // bristle.
        let first: T = lit(self.first);
        let rest = T::zero();
        let forward = crate::Branch::Forward.of(rest);
        let full = model.stationary(forward);
        let carried = model.coefficient(forward, full);
        let one = T::one();
        let mut deflection = full * within((first - offset) / carried, -one, one);
        let mut before: Option<f64> = None;
        let rows = time.iter().zip(held).zip(velocity).zip(coefficient);
        for (((&time, &held), &velocity), &measured) in rows {
            if let Some(before) = before {
                let duration = lit((time - before) * count);
                for _ in 0..substeps {
                    deflection = model.hold(lit(held), deflection, duration).deflection;
                }
            }
            before = Some(time);
            let friction = model.coefficient(lit::<T>(velocity), deflection) + offset;
            each(friction, (time >= counts_from).then(|| friction - lit(measured)));
        }
        Ok(())
    }
}

impl<C: Candidate<N>, const N: usize> Residuals<N> for Along<'_, C, N> {
    fn parameters(&self) -> [Parameter; N] {
        self.parameters
    }

    fn evaluate<T: Scalar>(
        &self,
        values: &[T; N],
        each: &mut impl FnMut(T),
    ) -> Result<(), ParameterError> {
        self.run(values, |_, residual| residual.into_iter().for_each(&mut *each))
    }
}

/// Finds the parameters of a candidate with the least simulation error along a log.
///
/// It takes starting values from [`InitialGuess::of`] and calls [`least_squares`].
///
/// ```
/// use bristle::identify::{
///     self, FrBdFit, Log, LogParameters, Motion, Progress, Settings, Simulation,
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
///     motion: Motion::Velocity(&velocity),
///     friction: &force,
///     normal_force: Some(&vec![10.0; time.len()]),
/// })?;
///
/// let (simulation, settings) = (Simulation::default(), Settings::default());
/// let mut go_on = |_: &Progress<'_>| ControlFlow::Continue(());
/// let fit = identify::fit(&FrBdFit, &log, simulation, &settings, &mut go_on)?;
/// println!("{fit}");
/// let stiffness = fit.estimate("micro_stiffness").unwrap();
/// assert!((stiffness.value - 1e4).abs() < 1.0);
/// # Ok::<(), bristle::Error>(())
/// ```
///
/// # Errors
///
/// Those of [`InitialGuess::of`] and [`fit_from`].
pub fn fit<C: Candidate<N>, const N: usize>(
    candidate: &C,
    log: &Log,
    simulation: Simulation,
    settings: &Settings,
    progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
) -> Result<Fit<N>, IdentifyError> {
    let parameters = candidate.parameters(&InitialGuess::of(log)?);
    fit_from(candidate, parameters, log, simulation, settings, progress)
}

/// As [`fit`], with your own starts and bounds.
///
/// # Errors
///
/// Refuses bounds that do not contain the start, a start that the model refuses, no
/// [`Simulation::substeps`], and a [`Simulation::settle`] that is negative or not finite or leaves
/// fewer than 20 rows or no more rows than parameters; and what [`least_squares`] refuses.
pub fn fit_from<C: Candidate<N>, const N: usize>(
    candidate: &C,
    parameters: [Parameter; N],
    log: &Log,
    simulation: Simulation,
    settings: &Settings,
    progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
) -> Result<Fit<N>, IdentifyError> {
    let along = Along::new(candidate, parameters, log, simulation)?;
    least_squares(&along, settings, progress)
}

/// A simulation of data that the fit has not seen.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Prediction {
    /// The model's friction coefficient \[–\] at every row.
    pub coefficients: Vec<f64>,
    /// Root mean square of model minus data over the rows that count.
    pub rmse: f64,
    /// Work of the model's friction along the log, over the normal force \[m\].
    pub work: f64,
    /// Work of the measured friction along the log, over the normal force \[m\].
    pub measured_work: f64,
}

/// Runs a candidate along a log and compares: how well does a fit predict data that it has not
/// seen?
///
/// # Errors
///
/// Refuses values that the model refuses or for which its friction is not finite, and settings that
/// [`fit_from`] refuses.
pub fn predict<C: Candidate<N>, const N: usize>(
    candidate: &C,
    values: &[f64; N],
    log: &Log,
    simulation: Simulation,
) -> Result<Prediction, IdentifyError> {
    let parameters = values.map(|start| Parameter::positive("", "", start, 1.0));
    let along = Along::new(candidate, parameters, log, simulation)?;
    let mut coefficients = Vec::with_capacity(log.len());
    let (mut squares, mut rows) = (0.0, 0.0);
    along.run(values, |model: f64, residual| {
        coefficients.push(model);
        squares += residual.map_or(0.0, |r| r * r);
        rows += if residual.is_some() { 1.0 } else { 0.0 };
    })?;
    if !coefficients.iter().all(|mu| mu.is_finite()) {
        return Err(IdentifyError::NotFinite);
    }
    let (work, measured_work) = (log.work(&coefficients), log.work(&log.coefficient));
    Ok(Prediction { coefficients, rmse: f64::sqrt(squares / rows), work, measured_work })
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use crate::identify::{ElastoPlasticFit, FrBdFit, LogParameters, MaxwellFit, Motion};
    use num_dual::DualSVec64;

    /// Dual numbers against central differences, row by row.
    fn sensitivities<C: Candidate<N>, const N: usize>(candidate: &C, values: [f64; N]) {
        let time: Vec<f64> = (0..400).map(|i| 2e-3 * f64::from(i)).collect();
        let velocity: Vec<f64> =
            time.iter().map(|t| 0.03 * (9.0 * t).sin() + 0.004 * (70.0 * t).sin()).collect();
        let friction: Vec<f64> = velocity.iter().map(|v| 0.25 * (v / 1e-3).tanh()).collect();
        let motion = Motion::Velocity(&velocity);
        let log = Log::new(LogParameters {
            time: &time,
            motion,
            friction: &friction,
            normal_force: None,
        })
        .unwrap();
        let parameters = values.map(|start| Parameter::positive("", "", start, 2.0));
        let along = Along {
            candidate,
            parameters,
            log: &log,
            simulation: Simulation { settle: 0.0, substeps: 2 },
            first: log.coefficient[0],
        };
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
        sensitivities(&MaxwellFit, [0.2, 0.1, 0.01, 0.8, 6e3, 4.0, 4e3, 0.02, 0.01]);
        sensitivities(&ElastoPlasticFit, [0.2, 0.1, 0.01, 0.8, 6e3, 8.0, 0.7, 0.01]);
    }
}
