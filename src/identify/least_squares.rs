//! Bounded nonlinear least squares by Levenberg and Marquardt, with exact sensitivities.

use core::ops::ControlFlow;

use nalgebra::{Const, SVector, U1};
use num_dual::DualSVec64;

use super::residuals::{Parameter, Residuals, Scaling};
use super::triangle::Triangle;
use super::uncertainty::assess;
use super::{Fit, IdentifyError, Outcome};

/// How a search is done.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Most iterations of one search.
    pub iterations: usize,
    /// Relative change of the sum of squares below which a search has converged: finite, not negative.
    pub tolerance: f64,
    /// How many searches: the first from the given start, the others from places drawn around it, always the same. None counts
    /// as one.
    pub starts: usize,
}

impl Default for Settings {
    /// A hundred iterations, a change of 10⁻⁹, one start.
    fn default() -> Self {
        Self { iterations: 100, tolerance: 1e-9, starts: 1 }
    }
}

/// Where a search is; handed to the callback after every iteration, which can break it off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress<'a> {
    /// Which search, from zero.
    pub start: usize,
    /// Iterations of this search so far.
    pub iteration: usize,
    /// Root mean square of the residuals.
    pub rmse: f64,
    /// The parameters now.
    pub values: &'a [f64],
}

/// The search variable of a parameter: its logarithm, or its share of the typical magnitude.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis {
    parameter: Parameter,
    pub(super) least: f64,
    pub(super) most: f64,
}

impl Axis {
    fn new(parameter: Parameter) -> Result<Self, IdentifyError> {
        let Parameter { name, start, least, most, scaling, .. } = parameter;
        let ordered = least.is_finite() && most.is_finite() && least <= start && start <= most;
        let positive = match scaling {
            Scaling::Linear { typical } => typical > 0.0 && typical.is_finite(),
            Scaling::Logarithmic => least > 0.0,
        };
        if !(ordered && positive) {
            return Err(IdentifyError::Bounds { name, start, least, most });
        }
        let axis = Self { parameter, least: 0.0, most: 0.0 };
        Ok(Self { least: axis.coordinate(least), most: axis.coordinate(most), ..axis })
    }

    fn coordinate(&self, value: f64) -> f64 {
        match self.parameter.scaling {
            Scaling::Linear { typical } => value / typical,
            Scaling::Logarithmic => value.ln(),
        }
    }

    pub(super) fn value(&self, coordinate: f64) -> f64 {
        match self.parameter.scaling {
            // The bounds to the last digit, where the exponential rounds.
            _ if coordinate <= self.least => self.parameter.least,
            _ if coordinate >= self.most => self.parameter.most,
            Scaling::Linear { typical } => coordinate * typical,
            Scaling::Logarithmic => coordinate.exp(),
        }
    }

    /// Change of the value with its coordinate.
    pub(super) fn slope(&self, coordinate: f64) -> f64 {
        match self.parameter.scaling {
            Scaling::Linear { typical } => typical,
            Scaling::Logarithmic => self.value(coordinate),
        }
    }
}

pub(super) type Point<const N: usize> = SVector<f64, N>;

/// The problem in its search variables.
pub(super) struct Problem<'a, R, const N: usize> {
    residuals: &'a R,
    pub(super) parameters: [Parameter; N],
    pub(super) axes: [Axis; N],
}

impl<'a, R: Residuals<N>, const N: usize> Problem<'a, R, N> {
    fn new(residuals: &'a R) -> Result<Self, IdentifyError> {
        let parameters = residuals.parameters();
        let mut axes =
            [Axis { parameter: Parameter::positive("", "", 1.0, 1.0), least: 0.0, most: 0.0 }; N];
        for (axis, &parameter) in axes.iter_mut().zip(&parameters) {
            *axis = Axis::new(parameter)?;
        }
        Ok(Self { residuals, parameters, axes })
    }

    pub(super) fn values(&self, point: &Point<N>) -> [f64; N] {
        core::array::from_fn(|i| self.axes[i].value(point[i]))
    }

    /// Σ r²; infinite where the model has no answer.
    fn cost(&self, point: &Point<N>) -> f64 {
        let mut cost = 0.0;
        match self.residuals.evaluate(&self.values(point), &mut |r: f64| cost += r * r) {
            Ok(()) if cost.is_finite() => cost,
            _ => f64::INFINITY,
        }
    }

    /// Every residual with its gradient in the search variables; whether all is finite.
    pub(super) fn rows(
        &self,
        point: &Point<N>,
        mut each: impl FnMut(f64, &SVector<f64, N>),
    ) -> bool {
        let values: [DualSVec64<N>; N] = core::array::from_fn(|i| {
            DualSVec64::from_re(self.axes[i].value(point[i])).derivative(i)
        });
        let slopes = SVector::<f64, N>::from_fn(|i, _| self.axes[i].slope(point[i]));
        let mut finite = true;
        let done = self.residuals.evaluate(&values, &mut |r: DualSVec64<N>| {
            let gradient = r.eps.unwrap_generic(Const::<N>, U1).component_mul(&slopes);
            finite &= r.re.is_finite() && gradient.iter().all(|x| x.is_finite());
            each(r.re, &gradient);
        });
        finite && done.is_ok()
    }

    fn triangle(&self, point: &Point<N>) -> Option<Triangle<N>> {
        let mut triangle = Triangle::new();
        self.rows(point, |residual, gradient| triangle.push(*gradient, -residual))
            .then_some(triangle)
    }
}

/// Where a search ended.
struct Search<const N: usize> {
    point: Point<N>,
    cost: f64,
    outcome: Outcome,
    iterations: usize,
}

/// Finds the parameters that make Σ r² least within their bounds.
///
/// Always answers with the best found; [`Fit::outcome`] says why the search ended there. The method is in the module's
/// documentation. As many rows as parameters or fewer are fitted too, but have no standard errors: those are infinite.
///
/// # Errors
///
/// Refuses a [`Settings::tolerance`] that is negative or not finite, bounds that do not hold the start, and a start at which the model has no answer.
pub fn least_squares<R: Residuals<N>, const N: usize>(
    residuals: &R,
    settings: &Settings,
    progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
) -> Result<Fit<N>, IdentifyError> {
    let value = settings.tolerance;
    if !(value.is_finite() && value >= 0.0) {
        let rule = "be finite and not negative";
        return Err(IdentifyError::Setting { name: "tolerance", value, rule });
    }
    let problem = Problem::new(residuals)?;
    let start = Point::from_fn(|i, _| problem.axes[i].coordinate(problem.parameters[i].start));
    // The model's own words, where it refuses.
    residuals.evaluate(&problem.values(&start), &mut |_: f64| ())?;
    if !problem.cost(&start).is_finite() {
        return Err(IdentifyError::NotFinite);
    }
    let mut draw = Draw(1);
    let mut best: Option<Search<N>> = None;
    let mut iterations = 0;
    for number in 0..settings.starts.max(1) {
        let from = if number == 0 {
            start
        } else {
            // Within a factor of 30 around the start, or all of a narrower or linear range.
            Point::from_fn(|i, _| {
                let axis = &problem.axes[i];
                let span = match problem.parameters[i].scaling {
                    Scaling::Logarithmic => 3.4,
                    Scaling::Linear { .. } => axis.most - axis.least,
                };
                let (low, high) =
                    ((start[i] - span).max(axis.least), (start[i] + span).min(axis.most));
                low + (high - low) * draw.next()
            })
        };
        let found = search(&problem, from, settings, number, progress);
        iterations += found.iterations;
        let stopped = found.outcome == Outcome::Stopped;
        if best.as_ref().is_none_or(|best| found.cost < best.cost) {
            best = Some(found);
        }
        if stopped {
            if let Some(best) = &mut best {
                best.outcome = Outcome::Stopped;
            }
            break;
        }
    }
    let best = best.ok_or(IdentifyError::NotFinite)?;
    Ok(assess(&problem, &best.point, best.outcome, iterations))
}

fn search<R: Residuals<N>, const N: usize>(
    problem: &Problem<'_, R, N>,
    from: Point<N>,
    settings: &Settings,
    start: usize,
    progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
) -> Search<N> {
    let mut search = Search {
        point: from,
        cost: problem.cost(&from),
        outcome: Outcome::IterationLimit,
        iterations: 0,
    };
    if !search.cost.is_finite() {
        search.outcome = Outcome::NoDerivative;
        return search;
    }
    let mut scale = SVector::<f64, N>::zeros();
    let (mut damping, mut growth) = (1e-3, 2.0);
    let mut small_steps = 0;
    while search.iterations < settings.iterations {
        search.iterations += 1;
        let Some(triangle) = problem.triangle(&search.point) else {
            search.outcome = Outcome::NoDerivative;
            return search;
        };
        // Marquardt's scaling by the columns, as Moré has it: never to fall. A column of zeros gets a little.
        let norms = triangle.column_norms();
        let floor = norms.max() * 1e-8 + f64::MIN_POSITIVE;
        scale = SVector::from_fn(|i, _| scale[i].max(norms[i]).max(floor));
        // Descent is −Aᵀ r; a parameter at a bound that it pushes against rests.
        let descent = triangle.gradient();
        let axes = &problem.axes;
        let free: [bool; N] = core::array::from_fn(|i| {
            let low = search.point[i] <= axes[i].least && descent[i] <= 0.0;
            let high = search.point[i] >= axes[i].most && descent[i] >= 0.0;
            !(low || high)
        });
        let mut accepted = false;
        for _ in 0..40 {
            let step = triangle.damped(&(scale * f64::sqrt(damping)), &free);
            let mut trial = search.point;
            for i in 0..N {
                // No more than a factor of 5 at a time on a logarithmic scale.
                let limit = match problem.parameters[i].scaling {
                    Scaling::Logarithmic => 1.6,
                    Scaling::Linear { .. } => f64::INFINITY,
                };
                trial[i] =
                    (trial[i] + step[i].clamp(-limit, limit)).clamp(axes[i].least, axes[i].most);
            }
            let taken = trial - search.point;
            if taken.amax() <= 1e-12 {
                search.outcome = Outcome::Converged;
                return search;
            }
            let cost = problem.cost(&trial);
            // What the linear model promises for the step taken, cut or not.
            let promised = 2.0 * descent.dot(&taken) - triangle.image_squared(&taken);
            let gain = (search.cost - cost) / promised.max(f64::MIN_POSITIVE);
            if cost < search.cost {
                let change = (search.cost - cost) / search.cost.max(f64::MIN_POSITIVE);
                small_steps = if change < settings.tolerance { small_steps + 1 } else { 0 };
                search.point = trial;
                search.cost = cost;
                // Nielsen's update.
                damping *= f64::max(1.0 / 3.0, 1.0 - (2.0 * gain.min(1.0) - 1.0).powi(3));
                damping = damping.max(1e-15);
                growth = 2.0;
                accepted = true;
                break;
            }
            damping *= growth;
            growth *= 2.0;
        }
        let rows = triangle.rows.max(1) as f64;
        let values = problem.values(&search.point);
        let now = Progress {
            start,
            iteration: search.iterations,
            rmse: (search.cost / rows).sqrt(),
            values: &values,
        };
        if progress(&now).is_break() {
            search.outcome = Outcome::Stopped;
            return search;
        }
        // Twice in a row, so that one step that a bound has cut short does not end the search.
        if !accepted || small_steps >= 2 || search.cost == 0.0 {
            search.outcome = Outcome::Converged;
            return search;
        }
    }
    search
}

/// Uniform numbers in [0, 1) by the 64-bit linear congruential generator of Knuth (MMIX), upper 53 bits.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}
