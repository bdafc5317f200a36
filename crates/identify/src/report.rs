//! The result of a fit.

use core::fmt;

use nalgebra::DMatrix;

use super::Parameter;
use bristle::number::{Number, Units};

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
    /// Its standard error is small, but the model does not explain the log: the parameter of a
    /// model that is not that of the log.
    Unexplained,
}

impl Identifiability {
    /// That of a value with a standard error.
    pub(super) fn of(value: f64, error: f64) -> Self {
        if error <= value.abs() { Self::Determined } else { Self::Uncertain }
    }
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
            Identifiability::Unexplained => "of a model that does not explain the log",
        })
    }
}

/// A parameter that was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Its name, unit, bounds and start.
    pub parameter: Parameter,
    /// Number of the log, from zero, of a parameter that each log has for itself.
    pub log: Option<usize>,
    /// The best value.
    pub value: f64,
    /// Standard error in the unit of the parameter. Infinite if the parameter is undetermined, or
    /// if there are no more rows than parameters. NaN if it is fixed or at a bound; the errors of
    /// the others then hold for that bound.
    pub standard_error: f64,
    /// How well the data determine it.
    pub verdict: Identifiability,
}

/// Why a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum SearchOutcome {
    /// No step lowers the sum of squares noticeably, nor does a change of one parameter by 5 %, and
    /// the gradient is small.
    Converged,
    /// No step lowers the sum of squares, although its gradient says that one should, or changes of
    /// one parameter by 5 % keep lowering it: the best point found is no minimum.
    Stalled,
    /// The limit of iterations was reached, `iterations` of
    /// [`SearchSettings`](super::SearchSettings::iterations), or that of runs with derivatives,
    /// `gradient_runs` of [`mechanism::Settings`](super::mechanism::Settings::gradient_runs).
    RunLimit,
    /// The callback stopped the search.
    Stopped,
    /// At the best point the model has no finite sensitivities.
    NoDerivative,
}

impl fmt::Display for SearchOutcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            SearchOutcome::Converged => "converged",
            SearchOutcome::Stalled => "NOT CONVERGED: stalled short of the minimum",
            SearchOutcome::RunLimit => {
                "NOT CONVERGED: runs used up: raise `iterations` or `gradient_runs`"
            }
            SearchOutcome::Stopped => "NOT CONVERGED: broken off",
            SearchOutcome::NoDerivative => "NOT CONVERGED: no finite sensitivities",
        })
    }
}

/// What speaks against taking estimates for what their names say.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Remark {
    /// Not friction alone: an equation of motion with a mass, a spring and Coulomb friction
    /// explains most of what the friction model leaves over, as it does where the column of
    /// friction is the torque of a motor. Use [`mechanism`](super::mechanism) for those.
    LooksLikeMotorTorque {
        /// Share of the squares of the residuals that it explains \[–\].
        explained: f64,
    },
    /// One load only: the external torque hardly changes, or none is modelled or measured, so that
    /// factors of the load cannot be told from a constant friction: a
    /// [`Term`](super::mechanism::Term) may be missing. They are marked undetermined.
    OneLoad,
    /// The ratio of both directions has run to its bound beside a constant torque: the log does not
    /// tell them apart. Offset and Coulomb torque are marked undetermined.
    OffsetOrDirection,
    /// The model does not explain a log: the errors of the position are larger than a third of the
    /// standard deviation of the motion. No parameter is determined then.
    Unexplained {
        /// Number of the log, from zero.
        log: usize,
        /// Root mean square of the errors over the segments that were fitted, over the standard
        /// deviation of the position there \[–\].
        error: f64,
    },
    /// The errors of the position over a whole log that was held out are larger than a third of the
    /// standard deviation of its motion: another unit or sign, another machine, or stick-slip,
    /// which no model follows for long.
    NotPredicted {
        /// Number of the log among those held out, from zero.
        log: usize,
        /// Root mean square of the errors over the standard deviation of the position \[–\].
        error: f64,
    },
    /// A log held out that moves by less than 3 % of the fitted log that moves most, as one that
    /// stands still does by counts of its encoder: that it is predicted says little.
    HardlyMoves {
        /// Number of the log among those held out, from zero.
        log: usize,
    },
    /// The errors of the position over a whole log that was fitted are larger than a third of the
    /// standard deviation of its motion, while those over the segments that were fitted are not:
    /// small errors add up, as of an axis that nothing holds in its place, or a slip comes late.
    OffAsWhole {
        /// Number of the log, from zero.
        log: usize,
        /// Root mean square of the errors over the standard deviation of the position \[–\].
        error: f64,
    },
    /// The motion is so sensitive to the parameters that simulations over the length asked for say
    /// nothing: shorter ones were fitted. Stick-slip has such a motion. So has a log that is too
    /// short, or moves too little, for its parameters: the search then begins far from them.
    Shortened {
        /// Length asked for \[s\].
        asked: f64,
        /// Length fitted \[s\].
        fitted: f64,
    },
    /// Rows whose residuals depend so much on the parameters that they say nothing of their
    /// accuracy, as after a slip that is about to happen: they are left out of residuals and
    /// standard errors.
    RowsTooSensitive {
        /// Number of rows.
        rows: usize,
    },
    /// A log has gaps; simulations start anew after each.
    Gaps {
        /// Number of the log, from zero.
        log: usize,
        /// Number of gaps.
        count: usize,
    },
    /// A log begins in motion, and the state there is not searched.
    BeginsInMotion {
        /// Number of the log, from zero.
        log: usize,
    },
    /// A log stands still most of its time. What friction holds there is anything up to its limit,
    /// decided by motions below a count of the encoder, and noise of the drive makes the simulated
    /// joint creep: other torques can take the place of friction, as a larger gravity that hangs
    /// where the log stands, by many standard errors. Fit the moves alone, each a log.
    MostlyAtRest {
        /// Number of the log, from zero.
        log: usize,
    },
    /// The controller of a log is at its limit all along: its goal and gain do not count.
    Saturated {
        /// Number of the log, from zero.
        log: usize,
    },
    /// A pendulum that turns so far: degrees taken for radians?
    ManyTurns {
        /// Number of the log, from zero.
        log: usize,
        /// Range of its positions \[rad\].
        range: f64,
    },
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::LooksLikeMotorTorque { explained } => write!(
                f,
                "NOT FRICTION ALONE: position and acceleration explain {:.0} % of the residuals; \
                 is the column the torque of a motor?",
                100.0 * explained
            ),
            Self::OneLoad => f.write_str(
                "ONE LOAD ONLY: factors of the load are not told from constant friction; \
                 is a `Term` missing?",
            ),
            Self::OffsetOrDirection => f.write_str(
                "OFFSET OR DIRECTION: backward_ratio is at its bound beside offset_torque; \
                 leave one of them out",
            ),
            Self::Unexplained { log, error } => write!(
                f,
                "log {log}: THIS MODEL DOES NOT EXPLAIN THE LOG: its errors are {:.0} % of the \
                 motion over the segments that were fitted; if there are others, fit each log \
                 alone, for one wrong log spoils all",
                100.0 * error
            ),
            Self::NotPredicted { log, error } => write!(
                f,
                "held-out log {log} IS NOT PREDICTED: the errors are {:.0} % of its motion",
                100.0 * error
            ),
            Self::HardlyMoves { log } => {
                write!(f, "held-out log {log} hardly moves: it tells nothing of larger motions")
            }
            Self::OffAsWhole { log, error } => {
                let size = 100.0 * error;
                write!(f, "log {log}, simulated as a whole, is off by {size:.0} % of the motion")
            }
            Self::Shortened { asked, fitted } => write!(
                f,
                "TOO SENSITIVE over {:.3} s: fitted over {:.3} s. Stick-slip, or a log too short \
                 for these parameters",
                Number(asked),
                Number(fitted)
            ),
            Self::RowsTooSensitive { rows } => {
                write!(f, "{rows} rows are too sensitive: left out of residuals and errors")
            }
            Self::Gaps { log, count } => {
                write!(f, "log {log} has {count} gaps: simulations start anew after each")
            }
            Self::BeginsInMotion { log } => {
                write!(f, "log {log} begins in motion: `DriveLog::in_motion` searches its state")
            }
            Self::MostlyAtRest { log } => {
                write!(f, "log {log} mostly stands still, which tells little: fit its moves alone")
            }
            Self::Saturated { log } => write!(f, "log {log}: the duty is at its limit all along"),
            Self::ManyTurns { log, range } => {
                write!(f, "log {log}: a pendulum that turns by {:.1} rad; degrees?", Number(range))
            }
        }
    }
}

/// The best parameters found, and what the data say of them. Prints as a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The parameters.
    pub estimates: Vec<Estimate>,
    /// Correlation of their errors on the scale of the search; NaN where there is no standard
    /// error.
    pub correlation: DMatrix<f64>,
    /// Number of residuals.
    pub rows: usize,
    /// Root mean square of the residuals.
    pub rmse: f64,
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
    /// What speaks against taking the estimates for what their names say.
    pub remarks: Vec<Remark>,
    /// Why the search ended.
    pub outcome: SearchOutcome,
    /// Iterations of all starts together.
    pub iterations: usize,
}

impl Fit {
    /// The best values.
    pub fn values(&self) -> Vec<f64> {
        self.estimates.iter().map(|estimate| estimate.value).collect()
    }

    /// The best values as an array, of as many parameters as were fitted: NaN beyond them.
    pub fn array<const N: usize>(&self) -> [f64; N] {
        core::array::from_fn(|i| self.estimates.get(i).map_or(f64::NAN, |estimate| estimate.value))
    }

    /// A parameter by its name; of those that each log has for itself, that of the first.
    pub fn estimate(&self, name: &str) -> Option<&Estimate> {
        self.estimates.iter().find(|estimate| estimate.parameter.name == name)
    }

    /// The units of a joint in place of those of a slide, in the table: 1/rad, s/rad, rad/s. For a
    /// log of angles, angular velocities and torques.
    #[must_use]
    pub fn in_units(mut self, units: Units) -> Self {
        for estimate in &mut self.estimates {
            estimate.parameter.unit = units.of(estimate.parameter.unit);
        }
        self
    }
}

/// The name of a parameter, with the number of the log whose own it is.
fn label(parameter: &Parameter, log: Option<usize>) -> String {
    log.map_or_else(|| parameter.name.into(), |log| format!("{}[{log}]", parameter.name))
}

impl fmt::Display for Fit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "parameter                     value   std. error  unit  verdict")?;
        for Estimate { parameter, log, value, standard_error, verdict } in &self.estimates {
            let unit = if parameter.unit.is_empty() { "–" } else { parameter.unit };
            let (name, value) = (label(parameter, *log), Number(*value));
            write!(f, "{name:22} {value:>12.5} ")?;
            match Number(*standard_error) {
                Number(nan) if nan.is_nan() => write!(f, "{:>12}", "–")?,
                error => write!(f, "{error:>12.5}")?,
            }
            writeln!(f, "  {unit:5} {verdict}")?;
        }
        for shares in &self.weak {
            write!(f, "no effect on the data:")?;
            for (name, share) in shares {
                write!(f, " {share:+.2} {name}")?;
            }
            writeln!(f, " (in units of each one's own effect)")?;
        }
        for (j, b) in self.estimates.iter().enumerate() {
            for (i, a) in self.estimates.iter().enumerate().take(j) {
                let correlation = self.correlation.get((i, j)).copied().unwrap_or(f64::NAN);
                if correlation.abs() > 0.9 {
                    let [a, b] = [a, b].map(|it| label(&it.parameter, it.log));
                    writeln!(f, "correlated: {a} and {b}, {correlation:+.3}")?;
                }
            }
        }
        self.remarks.iter().try_for_each(|remark| writeln!(f, "{remark}"))?;
        let rmse = Number(self.rmse);
        let Self { rows, effective_rows, neighbour_correlation, .. } = self;
        write!(f, "residuals: rmse {rmse:.5}; {rows} rows ")?;
        write!(f, "worth {effective_rows:.0} independent ones ")?;
        writeln!(f, "(correlation of neighbours {neighbour_correlation:.2})")?;
        write!(f, "{}, {} iterations", self.outcome, self.iterations)
    }
}
