//! What a fit answers.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt;

use nalgebra::SMatrix;

use super::Parameter;

/// What the data tell about a parameter, near the minimum that was found: of another, lower one it knows nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Identifiability {
    /// Its standard error is smaller than its value.
    Determined,
    /// Its standard error is larger than its value: it cannot be told from zero, or not to a factor of some three.
    Uncertain,
    /// It can change, alone or together with others, without any effect on the residuals that finite sensitivities show.
    Undetermined,
    /// The data would have it lower than its bound.
    AtLowerBound,
    /// The data would have it higher than its bound.
    AtUpperBound,
    /// Both its bounds are one: it was not looked for.
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

/// A parameter that was looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// What was looked for, and where.
    pub parameter: Parameter,
    /// The best value.
    pub value: f64,
    /// Standard error in the unit of the parameter. Infinite if it is undetermined, or if there are no more rows than
    /// parameters; NaN if it is fixed or at a bound: those of the others then hold for that bound.
    pub standard_error: f64,
    /// What the data tell about it.
    pub verdict: Identifiability,
}

/// The differences between model and data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResidualStatistics {
    /// How many.
    pub rows: usize,
    /// Root mean square.
    pub rmse: f64,
    /// Mean.
    pub mean: f64,
    /// Largest magnitude.
    pub largest: f64,
    /// Correlation of each with the next: near zero for noise, near one for what the model cannot do.
    pub correlation: f64,
    /// How many independent ones tell as much: rows over the correlation time 1 + 2 Σ ρ.
    pub effective_rows: f64,
    /// Rows over which correlation is accounted for in the standard errors.
    pub window: usize,
}

/// A combination of parameters without any effect on the residuals.
#[derive(Debug, Clone, PartialEq)]
pub struct WeakDirection {
    /// Its effect over that of the strongest one.
    pub strength: f64,
    /// Which parameters have a share in it, the largest first, in units of each one's own effect.
    pub shares: Vec<(&'static str, f64)>,
}

/// Why a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Outcome {
    /// No step lowers the sum of squares noticeably.
    Converged,
    /// The iterations were used up.
    IterationLimit,
    /// The callback broke off.
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

/// The best parameters found, and what the data tell about them. Prints as a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit<const N: usize> {
    /// The parameters.
    pub estimates: [Estimate; N],
    /// Correlation of their errors (on the scale of the search); NaN beside one that has no standard error.
    pub correlation: SMatrix<f64, N, N>,
    /// What is left.
    pub residuals: ResidualStatistics,
    /// Combinations that the data do not tell.
    pub weak: Vec<WeakDirection>,
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

    /// A parameter by name.
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

/// Five digits, with an exponent where it is shorter.
struct Digits(f64);

impl fmt::Display for Digits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        let text = if self.0.is_nan() {
            String::from("–")
        } else if self.0.is_infinite() {
            String::from("∞")
        } else if size == 0.0 || (1e-3..1e6).contains(&size) {
            // As many decimals as leave five digits.
            let decimals =
                [1e4, 1e3, 1e2, 1e1, 1.0, 1e-1, 1e-2].iter().position(|&limit| size >= limit);
            let decimals = if size == 0.0 { 0 } else { decimals.unwrap_or(7) };
            format!("{:.decimals$}", self.0)
        } else {
            format!("{:.4e}", self.0)
        };
        f.pad(&text)
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
            let (value, error) = (Digits(*value), Digits(*standard_error));
            writeln!(f, "{:22} {value:>12} {error:>12}  {unit:5} {verdict}", parameter.name)?;
        }
        for WeakDirection { shares, .. } in &self.weak {
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
        let ResidualStatistics { rows, rmse, mean, largest, correlation, effective_rows, .. } =
            self.residuals;
        writeln!(
            f,
            "residuals: rmse {}, mean {}, largest {}; {rows} rows that tell as much as {effective_rows:.0} independent ones (next to next {correlation:.2})",
            Digits(rmse),
            Digits(mean),
            Digits(largest)
        )?;
        write!(f, "{}, {} iterations", self.outcome, self.iterations)
    }
}
