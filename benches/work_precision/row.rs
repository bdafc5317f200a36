//! One measured point, and the table of all of them.

use std::path::{Path, PathBuf};

use bristle_charts::Csv;

use crate::methods::Cost;

/// One method with one setting on one scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// The scene.
    pub scene: &'static str,
    /// The friction model.
    pub model: &'static str,
    /// The method.
    pub method: &'static str,
    /// Its relative tolerance, or its step \[s\].
    pub setting: f64,
    /// Greatest error of the judged component over all samples, over its scale; NaN where a run
    /// ended early or went astray to NaN.
    pub error: f64,
    /// Shortest time of a run \[s\].
    pub seconds: f64,
    /// What it cost.
    pub cost: Cost,
    /// Why it failed, if it did.
    pub failure: Option<String>,
}

/// From here on an answer is none: an error of ten times what is judged.
pub const NO_ANSWER: f64 = 10.0;

impl Row {
    /// Whether there is no answer: the run failed, or ended with an error beyond all bounds.
    pub fn fails(&self) -> bool {
        self.failure.is_some() || !(self.error < NO_ANSWER)
    }

    /// `ok`, `wrong` for a success reported with an error beyond all bounds, or why it failed.
    pub fn status(&self) -> &str {
        match &self.failure {
            Some(reason) => reason,
            None if self.fails() => "wrong",
            None => "ok",
        }
    }
}

/// Writes `folder/name.csv`.
pub fn write(folder: &Path, name: &str, rows: &[Row]) -> bristle_charts::Result<PathBuf> {
    let columns = [
        "scene",
        "model",
        "method",
        "setting",
        "error",
        "cpu_s",
        "rhs_evals",
        "jac_evals",
        "steps",
        "rejected",
        "status",
    ];
    let mut table = Csv::create(folder, name, &columns)?;
    for row in rows {
        let floats = [row.setting, row.error, row.seconds].map(|value| format!("{value:e}"));
        let Cost { rates, jacobians, steps, rejected } = row.cost;
        let counts = [rates, jacobians, steps, rejected].map(|count| count.to_string());
        let cells = [row.scene, row.model, row.method].into_iter();
        let cells = cells.chain(floats.iter().chain(&counts).map(String::as_str));
        table.row(&cells.chain([row.status()]).collect::<Vec<_>>(), &[])?;
    }
    table.finish()
}
