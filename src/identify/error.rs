//! Why there is no fit.

use crate::parameter::ParameterError;

/// Why a log or a candidate was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum IdentifyError {
    /// A value of the log that cannot be.
    #[error("row {row}: {column} is {value}, but must {rule}")]
    Row {
        /// The row, from zero.
        row: usize,
        /// The column.
        column: &'static str,
        /// The value.
        value: f64,
        /// What it must be.
        rule: &'static str,
    },
    /// A column shorter or longer than that of the time.
    #[error("{column} has {length} rows, but must have as many as time, {rows}")]
    Lengths {
        /// The column.
        column: &'static str,
        /// Its rows.
        length: usize,
        /// Those of the time.
        rows: usize,
    },
    /// Too little data.
    #[error("{rows} rows are too few, there must be at least {least}")]
    TooFewRows {
        /// Rows given.
        rows: usize,
        /// Rows needed.
        least: usize,
    },
    /// A magnitude that a slip of units makes.
    #[error("{quantity} is {value}, but must {rule}")]
    Implausible {
        /// What.
        quantity: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        rule: &'static str,
    },
    /// A setting of the search, the simulation or a window that cannot be.
    #[error("{name} is {value}, but must {rule}")]
    Setting {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        rule: &'static str,
    },
    /// The body never turns round, so that nothing tells the bristle from the curve.
    #[error(
        "the body never turns back by more than {threshold} m (six deviations of the position's noise, at least a thousandth of the travel), but must do so once; its velocity lies between {least} and {most} m/s"
    )]
    NoReversal {
        /// Way back \[m\] that would count.
        threshold: f64,
        /// Least velocity [m/s].
        least: f64,
        /// Largest velocity [m/s].
        most: f64,
    },
    /// The friction follows the motion elastically all the time.
    #[error(
        "the longest way in one direction is {longest} m, but must be at least {least} m for the contact to slide"
    )]
    NoSliding {
        /// Longest way in one direction \[m\].
        longest: f64,
        /// What it takes \[m\].
        least: f64,
    },
    /// The force sensor tells nothing.
    #[error("friction stays at {value} (over the normal force): does the sensor work?")]
    NoChange {
        /// Where it stays: F/p \[–\].
        value: f64,
    },
    /// Friction that gives energy to the motion, over the whole log.
    #[error(
        "friction drives the motion: is the sign right? Its work over the normal force is {work} m along a path of {path} m, but must be positive"
    )]
    DrivesMotion {
        /// Work of friction over the normal force \[m\], without the offset.
        work: f64,
        /// Length of the path \[m\].
        path: f64,
    },
    /// A parameter of the candidate without a start between its bounds.
    #[error(
        "parameter {name}: start {start} must lie between {least} and {most}, both finite, and above 0 on a logarithmic scale"
    )]
    Bounds {
        /// Name of the parameter.
        name: &'static str,
        /// Its start.
        start: f64,
        /// Lower bound.
        least: f64,
        /// Upper bound.
        most: f64,
    },
    /// The candidate refuses its values: those to start from, or to predict with.
    #[error("the model refuses its values: {0}")]
    Model(#[from] ParameterError),
    /// The model's answer at the values to start from, or to predict with, is not a number.
    #[error("at the given values the model's friction is not finite")]
    NotFinite,
}
