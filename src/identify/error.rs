//! Why there is no fit.

use crate::parameter::ParameterError;

/// Why a log or a candidate was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum IdentifyError {
    /// A value of the log that cannot be right.
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
        /// The rows of the time.
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
    /// A value that cannot be right: a setting, the end of a window, or a magnitude that only a
    /// mistake in units explains.
    #[error("{name} is {value}, but must {rule}")]
    Value {
        /// Its name.
        name: &'static str,
        /// The value.
        value: f64,
        /// What it must be.
        rule: &'static str,
    },
    /// The motion never turns back, so that nothing separates the bristle from the curve.
    #[error(
        "the body never turns back by more than {threshold} m (six deviations of the position's \
         noise, at least a thousandth of the travel), but must do so once; its velocity lies \
         between {least} and {most} m/s"
    )]
    NoReversal {
        /// Distance back \[m\] that would count as a reversal.
        threshold: f64,
        /// Least velocity [m/s].
        least: f64,
        /// Largest velocity [m/s].
        most: f64,
    },
    /// No stroke is long enough for the contact to slide.
    #[error(
        "the longest way in one direction is {longest} m, but must be at least {least} m for the \
         contact to slide"
    )]
    NoSliding {
        /// Longest stroke in one direction \[m\].
        longest: f64,
        /// Length needed \[m\].
        least: f64,
    },
    /// The measured friction never changes.
    #[error("friction stays at {value} (over the normal force): does the sensor work?")]
    NoChange {
        /// Its constant value F/p \[–\].
        value: f64,
    },
    /// Over the whole log, friction gives energy to the motion.
    #[error(
        "friction drives the motion: is the sign right? Its work over the normal force is {work} m \
         along a path of {path} m, but must be positive"
    )]
    DrivesMotion {
        /// Work of friction over the normal force \[m\], without the offset.
        work: f64,
        /// Length of the path \[m\].
        path: f64,
    },
    /// A parameter whose start does not lie between its bounds.
    #[error(
        "parameter {name}: start {start} must lie between {least} and {most}, both finite, and \
         above 0 on a logarithmic scale"
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
    /// The candidate refuses the values to start from, or to predict with.
    #[error("the model refuses its values: {0}")]
    Model(#[from] ParameterError),
    /// The model's friction at the values to start from, or to predict with, is not finite.
    #[error("at the given values the model's friction is not finite")]
    NotFinite,
}
