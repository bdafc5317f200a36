//! The result of a fit.

use alloc::vec::Vec;
use core::fmt;

use nalgebra::SMatrix;

use super::Parameter;
use crate::number::Number;

/// How well the data determine a parameter, near the minimum that was found. Other minima are not
/// examined.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Identifiability {
    /// Its standard error is smaller than its value.
    Determined,
    /// Its standard error is larger than its value: it cannot be distinguished from zero, or is
    /// known only to a factor of about three.
    Uncertain,
    /// It can change, alone or together with others, without any effect on the residuals.
    Undetermined,
    /// The data ask for less than its lower bound.
    AtLowerBound,
    /// The data ask for more than its upper bound.
    AtUpperBound,
    /// Its bounds are equal: it was not searched.
    Fixed,
}

impl fmt::Display for Identifiability {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Identifiability::Determined => "determined",
            Identifiability::Uncertain => "UNCERTAIN: standard error above value",
            Identifiability::Undetermined => "UNDETERMINED by these data",
            Identifiability::AtLowerBound => "AT ITS LOWER BOUND",
            Identifiability::AtUpperBound => "AT ITS UPPER BOUND",
            Identifiability::Fixed => "fixed",
        })
    }
}

/// A parameter that was found.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Estimate {
    /// Its name, unit, bounds and start.
    pub parameter: Parameter,
    /// The best value.
    pub value: f64,
    /// Standard error in the unit of the parameter. Infinite if the parameter is undetermined, or
    /// if there are no more rows than parameters. NaN if it is fixed or at a bound; the errors of
    /// the others then hold for that bound.
    pub standard_error: f64,
    /// How well the data determine it.
    pub verdict: Identifiability,
}

/// Why a search ended. (Of a batch's step see [`batch::Outcome`](crate::batch::Outcome).)
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Outcome {
    /// No step lowers the sum of squares noticeably.
    Converged,
    /// The limit of iterations was reached.
    IterationLimit,
    /// The callback stopped the search.
    Stopped,
    /// At the best point the model has no finite sensitivities.
    NoDerivative,
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Outcome::Converged => "converged",
            Outcome::IterationLimit => "NOT CONVERGED: iterations used up",
            Outcome::Stopped => "NOT CONVERGED: broken off",
            Outcome::NoDerivative => "NOT CONVERGED: no finite sensitivities",
        })
    }
}

/// The best parameters found, and what the data say of them. Prints as a table.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Fit<const N: usize> {
    /// The parameters.
    pub estimates: [Estimate; N],
    /// Correlation of their errors on the scale of the search; NaN where there is no standard
    /// error.
    pub correlation: SMatrix<f64, N, N>,
    /// Number of residuals.
    pub rows: usize,
    /// Root mean square of the residuals.
    pub rmse: f64,
    /// Mean of the residuals.
    pub mean: f64,
    /// Largest magnitude of a residual.
    pub largest: f64,
    /// Correlation of each residual with the next: near zero for noise, near one for errors of the
    /// model.
    pub neighbour_correlation: f64,
    /// Number of independent rows with the same information: rows over the correlation time 1 + 2 Σ
    /// ρ of the residuals.
    pub effective_rows: f64,
    /// Number of rows over which the standard errors account for correlation.
    pub window: usize,
    /// Combinations of parameters without any effect on the residuals: the names with their shares,
    /// the largest first, in units of each one's own effect.
    pub weak: Vec<Vec<(&'static str, f64)>>,
    /// Why the search ended.
    pub outcome: Outcome,
    /// Iterations of all starts together.
    pub iterations: usize,
}

impl<const N: usize> Fit<N> {
    /// The best values.
    pub fn values(&self) -> [f64; N] {
        self.estimates.map(|estimate| estimate.value)
    }

    /// A parameter by its name.
    pub fn estimate(&self, name: &str) -> Option<&Estimate> {
        self.estimates.iter().find(|estimate| estimate.parameter.name == name)
    }

    /// Whether every parameter is determined, or fixed.
    pub fn is_determined(&self) -> bool {
        let known =
            |verdict| matches!(verdict, Identifiability::Determined | Identifiability::Fixed);
        self.estimates.iter().all(|estimate| known(estimate.verdict))
    }
}

impl<const N: usize> fmt::Display for Fit<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{:22} {:>12} {:>12}  {:5} verdict",
            "parameter", "value", "std. error", "unit"
        )?;
        for Estimate { parameter, value, standard_error, verdict } in &self.estimates {
            let unit = if parameter.unit.is_empty() { "–" } else { parameter.unit };
            let (value, error) = (Number(*value), Number(*standard_error));
            writeln!(f, "{:22} {value:>12.5} {error:>12.5}  {unit:5} {verdict}", parameter.name)?;
        }
        for shares in &self.weak {
            write!(f, "no effect on the data:")?;
            for (name, share) in shares {
                write!(f, " {share:+.2} {name}")?;
            }
            writeln!(f, " (in units of each one's own effect)")?;
        }
        for i in 0..N {
            for j in i + 1..N {
                let correlation = self.correlation[(i, j)];
                if correlation.abs() > 0.9 {
                    let [a, b] = [i, j].map(|k| self.estimates[k].parameter.name);
                    writeln!(f, "correlated: {a} and {b}, {correlation:+.3}")?;
                }
            }
        }
        let [rmse, mean, largest] = [self.rmse, self.mean, self.largest].map(Number);
        let Self { rows, effective_rows, neighbour_correlation, .. } = self;
        write!(f, "residuals: rmse {rmse:.5}, mean {mean:.5}, largest {largest:.5}; {rows} rows ")?;
        write!(f, "worth {effective_rows:.0} independent ones ")?;
        writeln!(f, "(correlation of neighbours {neighbour_correlation:.2})")?;
        write!(f, "{}, {} iterations", self.outcome, self.iterations)
    }
}
