//! Bounded nonlinear least squares by Levenberg and Marquardt, with exact sensitivities.

use core::ops::ControlFlow;

use super::problem::{Counted, Objective, Point, Problem};
use super::residuals::{Parameter, Residuals};
use super::triangle::Triangle;
use super::uncertainty::assess;
use super::{Fit, SearchOutcome};
use bristle::parameter::{Checked, Named, Rule};

/// SearchSettings of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SearchSettings {
    /// Most iterations of one search.
    pub iterations: usize,
    /// Relative change of the sum of squares below which a search has converged: finite, not
    /// negative.
    pub tolerance: f64,
    /// Number of searches: the first from the given start, the others from places drawn around it,
    /// the same ones in every run. Zero counts as one.
    pub starts: usize,
}

impl Default for SearchSettings {
    /// A hundred iterations, a change of 10⁻⁹, one start.
    fn default() -> Self {
        Self { iterations: 100, tolerance: 1e-9, starts: 1 }
    }
}

/// State of a search, passed to the callback after every iteration, every step that was tried in
/// vain and every probe. The callback can stop the search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SearchProgress<'a> {
    /// Number of the search, from zero.
    pub start: usize,
    /// Iterations of this search so far.
    pub iteration: usize,
    /// Root mean square of the residuals.
    pub rmse: f64,
    /// The parameters now.
    pub values: &'a [f64],
}

/// Largest change of a logarithm in one step: a factor of 5, beyond which a linear model says
/// little.
const LONGEST_STEP: f64 = 1.6;
/// Half width of the range of starts on a logarithmic scale: a factor of 30, about one and a half
/// decades, which is how well an initial guess is known.
const START_RANGE: f64 = 3.4;
/// Step of the search variables, all of order one, that is rounding only.
const SMALLEST_STEP: f64 = 1e-12;
/// Most step lengths tried in one iteration. The damping grows by 2, 4, 8, …: long before, the
/// steps are below the smallest one.
const TRIALS: usize = 40;

/// Change of a search variable by which each parameter is probed before a search has converged:
/// 5 % of a positive parameter.
const PROBE: f64 = 0.05;
/// Share of the sum of squares that no probe, and no movement of one parameter along the gradient,
/// may take away from a search that has converged.
pub(super) const NOTICEABLE: f64 = 1e-3;
/// Most times that a search goes on from a better probe.
pub(super) const PROBES: usize = 5;

/// Finds the parameters that minimise Σ r² within their bounds.
///
/// The result is always the best point found; [`Fit::outcome`] says why the search ended there. The
/// module documentation describes the method. A problem with no more rows than parameters is fitted
/// too, but its standard errors are infinite.
///
/// # Errors
///
/// Refuses a [`SearchSettings::tolerance`] that is negative or not finite, bounds that do not
/// contain the start, and a start at which the model has no answer.
pub fn least_squares<R: Residuals<N>, const N: usize>(
    residuals: &R,
    parameters: [Parameter; N],
    settings: &SearchSettings,
    progress: &mut dyn FnMut(&SearchProgress<'_>) -> ControlFlow<()>,
) -> Checked<Fit> {
    let residuals = &Counted(residuals);
    let found = minimise(residuals, &parameters, settings, PROBES, progress)?;
    Ok(assess(&Problem::new(residuals, &parameters)?, &found, f64::INFINITY))
}

/// Where a search has ended.
pub(super) struct Found {
    pub(super) point: Point,
    pub(super) values: Vec<f64>,
    pub(super) cost: f64,
    pub(super) outcome: SearchOutcome,
    pub(super) iterations: usize,
}

/// The search of [`least_squares`], with parameters whose number is known at run time, and so many
/// rounds of probes at most.
pub(super) fn minimise<R: Objective>(
    residuals: &R,
    parameters: &[Parameter],
    settings: &SearchSettings,
    probes: usize,
    progress: &mut dyn FnMut(&SearchProgress<'_>) -> ControlFlow<()>,
) -> Checked<Found> {
    Named("tolerance", settings.tolerance).non_negative()?;
    let problem = &Problem::new(residuals, parameters)?;
    // With the model's own error, if it refuses the start.
    residuals.evaluate(&problem.values(&problem.start), &mut |_: f64| ())?;
    let cost = problem.cost(&problem.start);
    Named("sum of squares at the start", cost).check(cost.is_finite(), Rule::Finite)?;
    let mut search = |number, point| {
        let (cost, outcome) = (problem.cost(&point), SearchOutcome::RunLimit);
        let (iterations, rows) = (0, 1);
        let mut search =
            Search { problem, settings, number, point, cost, outcome, iterations, rows };
        search.run(probes, progress);
        search
    };
    let mut best = search(0, problem.start.clone());
    let mut iterations = best.iterations;
    let mut draw = Draw::new();
    for number in 1..settings.starts {
        if best.outcome == SearchOutcome::Stopped {
            break;
        }
        let place = Point::from_fn(parameters.len(), |i, _| {
            let (start, least, most) = (problem.start[i], problem.least[i], problem.most[i]);
            let logarithmic = parameters.get(i).is_some_and(|p| p.typical.is_none());
            let span = if logarithmic { START_RANGE } else { most - least };
            let (low, high) = ((start - span).max(least), (start + span).min(most));
            low + (high - low) * draw.next()
        });
        let found = search(number, place);
        iterations += found.iterations;
        let stopped = found.outcome == SearchOutcome::Stopped;
        if found.cost < best.cost {
            best = found;
        }
        if stopped {
            best.outcome = SearchOutcome::Stopped;
        }
    }
    let Search { point, cost, outcome, .. } = best;
    Ok(Found { values: problem.values(&point), point, cost, outcome, iterations })
}

/// A search from one place, and where it is.
struct Search<'a, R> {
    problem: &'a Problem<'a, R>,
    settings: &'a SearchSettings,
    number: usize,
    point: Point,
    cost: f64,
    outcome: SearchOutcome,
    iterations: usize,
    /// Number of residuals.
    rows: usize,
}

/// What is asked whether a search goes on.
type Callback<'a> = &'a mut dyn FnMut(&SearchProgress<'_>) -> ControlFlow<()>;

impl<R: Objective> Search<'_, R> {
    /// Goes on while a probe of one parameter finds a better place.
    fn run(&mut self, probes: usize, progress: Callback<'_>) {
        for _ in 0..probes.max(1) {
            self.outcome = self.descend(progress);
            if self.outcome != SearchOutcome::Converged || probes == 0 {
                return;
            }
            match self.probe(progress) {
                ControlFlow::Break(()) => return self.outcome = SearchOutcome::Stopped,
                ControlFlow::Continue(None) => return,
                ControlFlow::Continue(Some((cost, point))) => {
                    (self.point, self.cost) = (point, cost);
                    self.outcome = SearchOutcome::Stalled;
                }
            }
        }
    }

    /// Whether the search goes on.
    fn ask(&self, progress: Callback<'_>) -> ControlFlow<()> {
        let rmse = (self.cost / self.rows.max(1) as f64).sqrt();
        let (start, iteration) = (self.number, self.iterations);
        let values = &self.problem.values(&self.point);
        progress(&SearchProgress { start, iteration, rmse, values })
    }

    /// The best of the points that differ in one parameter, if the difference is noticeable.
    fn probe(&self, progress: Callback<'_>) -> ControlFlow<(), Option<(f64, Point)>> {
        let Self { problem, point: now, .. } = self;
        let (mut best, mut least) = (None, (1.0 - NOTICEABLE) * self.cost);
        for (i, parameter) in problem.parameters.iter().enumerate() {
            let size = parameter.typical.map_or(1.0, |_| now[i].abs().max(1.0));
            for change in [PROBE * size, -PROBE * size] {
                let point = problem.within(|j| now[j] + if i == j { change } else { 0.0 });
                if point == *now {
                    continue;
                }
                let cost = problem.cost(&point);
                if cost < least {
                    (best, least) = (Some((cost, point)), cost);
                }
                self.ask(progress)?;
            }
        }
        ControlFlow::Continue(best)
    }

    /// The method of Levenberg and Marquardt from the present point.
    fn descend(&mut self, progress: Callback<'_>) -> SearchOutcome {
        let problem = self.problem;
        let mut scale = Point::zeros(self.point.len());
        let mut damping = Damping { value: 1e-3, growth: 2.0 };
        let mut small_steps = 0;
        loop {
            if self.iterations == self.settings.iterations {
                return SearchOutcome::RunLimit;
            }
            self.iterations += 1;
            let rows = problem.rows(&self.point);
            if !rows.finite {
                return SearchOutcome::NoDerivative;
            }
            let linear = rows.linear(problem.parameters.len());
            self.rows = rows.rows.len();
            // Marquardt's scaling by the lengths of the columns, which never falls (Moré).
            scale = scale.zip_map(&linear.column_norms(), f64::max);
            let before = self.cost;
            let accepted = match self.step(&linear, &scale, &mut damping, progress) {
                ControlFlow::Break(()) => return SearchOutcome::Stopped,
                ControlFlow::Continue(None) => return SearchOutcome::Converged,
                ControlFlow::Continue(Some(accepted)) => accepted,
            };
            if accepted {
                let change = (before - self.cost) / before;
                small_steps = if change < self.settings.tolerance { small_steps + 1 } else { 0 };
            }
            if self.ask(progress).is_break() {
                return SearchOutcome::Stopped;
            }
            // Twice in a row: one step that a bound has cut short does not end the search.
            if !accepted || small_steps >= 2 || self.cost == 0.0 {
                return SearchOutcome::Converged;
            }
        }
    }

    /// Takes a step that lowers the sum of squares, and says whether there was one; nothing where
    /// all that is left is rounding.
    fn step(
        &mut self,
        linear: &Triangle,
        scale: &Point,
        damping: &mut Damping,
        progress: Callback<'_>,
    ) -> ControlFlow<(), Option<bool>> {
        let problem = self.problem;
        let descent = linear.gradient();
        let free: Vec<bool> =
            problem.resting(&self.point, &descent).iter().map(Option::is_none).collect();
        let longest = |i: usize| {
            if problem.parameters[i].typical.is_none() { LONGEST_STEP } else { f64::INFINITY }
        };
        for _ in 0..TRIALS {
            let step = linear.damped(&(scale * f64::sqrt(damping.value)), &free);
            let trial = problem.within(|i| self.point[i] + step[i].clamp(-longest(i), longest(i)));
            let taken = &trial - &self.point;
            if taken.amax() <= SMALLEST_STEP {
                return ControlFlow::Continue(None);
            }
            let reached = problem.cost(&trial);
            if reached < self.cost {
                // What the linear model predicts for the step taken, whether it was cut or not.
                let predicted = 2.0 * descent.dot(&taken) - linear.image_squared(&taken);
                let gain = (self.cost - reached) / predicted.max(f64::MIN_POSITIVE);
                // Nielsen's update.
                damping.value *= f64::max(1.0 / 3.0, 1.0 - (2.0 * gain.min(1.0) - 1.0).powi(3));
                *damping = Damping { value: damping.value.max(1e-15), growth: 2.0 };
                (self.point, self.cost) = (trial, reached);
                return ControlFlow::Continue(Some(true));
            }
            damping.value *= damping.growth;
            damping.growth *= 2.0;
            self.ask(progress)?;
        }
        ControlFlow::Continue(Some(false))
    }
}

/// Marquardt's damping λ, and the factor of its next rise.
struct Damping {
    value: f64,
    growth: f64,
}

/// Uniform numbers in [0, 1) by Knuth's 64-bit linear congruential generator (MMIX), upper 53 bits.
#[derive(Clone)]
pub(super) struct Draw(u64);

impl Draw {
    pub(super) fn new() -> Self {
        Self(1)
    }

    /// A standard normal number by the method of Box and Muller.
    pub(super) fn gauss(&mut self) -> f64 {
        let size = (-2.0 * (1.0 - self.next()).ln()).sqrt();
        size * (core::f64::consts::TAU * self.next()).cos()
    }

    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}
