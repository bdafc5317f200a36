//! One run of one method on one scene, as a line of the table.

use std::path::{Path, PathBuf};

use bristle_charts::Csv;

/// The status of a run that reached the end.
pub(crate) const OK: &str = "ok";

/// The status of a run that reached the end with an error of [`NO_ANSWER`] or more.
pub(crate) const WRONG: &str = "wrong";
/// From here on an answer is none, in the scene's scale.
pub(crate) const NO_ANSWER: f64 = 10.0;

/// What one setting of one method cost, and what it achieved.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Row {
    /// The scene's name.
    pub(crate) scene: String,
    /// `frbd` or `lugre`.
    pub(crate) model: String,
    /// The crate that integrated.
    pub(crate) crate_: String,
    /// Its method.
    pub(crate) method: String,
    /// What was asked of it: `rtol=1e-6`.
    pub(crate) setting: String,
    /// Largest error over the output samples, in the scene's scale; only of runs that reached the
    /// end.
    pub(crate) error: Option<f64>,
    /// CPU time [s], the least of several runs.
    pub(crate) cpu_s: f64,
    /// Evaluations of the right-hand side.
    pub(crate) rhs_evals: u64,
    /// Evaluations of the Jacobian.
    pub(crate) jac_evals: u64,
    /// Accepted steps, as far as the crate tells.
    pub(crate) steps: u64,
    /// Rejected steps, as far as the crate tells.
    pub(crate) rejected: u64,
    /// [`OK`], [`WRONG`], or a short word for the failure.
    pub(crate) status: String,
}

impl Row {
    /// `crate/method`.
    pub(crate) fn who(&self) -> String {
        format!("{}/{}", self.crate_, self.method)
    }

    /// The error of a run that counts.
    pub(crate) fn achieved(&self) -> Option<f64> {
        self.error.filter(|error| self.status == OK && error.is_finite())
    }
}

/// Writes `folder/name.csv`.
pub(crate) fn save(rows: &[Row], folder: &Path, name: &str) -> bristle_charts::Result<PathBuf> {
    const COLUMNS: [&str; 11] = [
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
    let mut table = Csv::create(folder, name, &COLUMNS)?;
    for row in rows {
        let who = row.who();
        let numbers = [
            row.error.map_or_else(|| "NaN".to_owned(), |error| format!("{error:e}")),
            format!("{:e}", row.cpu_s),
            row.rhs_evals.to_string(),
            row.jac_evals.to_string(),
            row.steps.to_string(),
            row.rejected.to_string(),
        ];
        let mut cells = vec![&*row.scene, &row.model, &who, &row.setting];
        cells.extend(numbers.iter().map(String::as_str));
        cells.push(&row.status);
        // All as texts: a `Csv` row has its numbers last, this one its status.
        table.row(&cells, &[])?;
    }
    table.finish()
}

/// Reads what [`save`] wrote.
pub(crate) fn read(path: &Path) -> bristle_charts::Result<Vec<Row>> {
    let text = std::fs::read_to_string(path)?;
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let &[scene, model, who, setting, error, cpu_s, rates, jacobians, steps, rejected, status] =
            &cells[..]
        else {
            return None;
        };
        let (crate_, method) = who.split_once('/')?;
        Some(Row {
            scene: scene.to_owned(),
            model: model.to_owned(),
            crate_: crate_.to_owned(),
            method: method.to_owned(),
            setting: setting.to_owned(),
            error: Some(error.parse().ok()?).filter(|error: &f64| !error.is_nan()),
            cpu_s: cpu_s.parse().ok()?,
            rhs_evals: rates.parse().ok()?,
            jac_evals: jacobians.parse().ok()?,
            steps: steps.parse().ok()?,
            rejected: rejected.parse().ok()?,
            status: status.to_owned(),
        })
    };
    let rows: Option<Vec<Row>> = text.lines().skip(1).map(row).collect();
    rows.ok_or_else(|| format!("{}: not a table of this program", path.display()).into())
}
