//! The work–precision chart of a scene: CPU time over achieved error.

use std::path::{Path, PathBuf};

use crate::support::{Figure, Marker, Panel, Stroke, Symbol};

use crate::row::{OK, Row};

/// Axis of errors: what lies outside says nothing about a method.
const FINEST: f64 = 1e-13;
const COARSEST: f64 = 1e2;
/// Where runs are marked that have no error because they failed.
const FAILED: f64 = 20.0;

/// Writes `folder/NAME.svg` for the rows of one scene and model. `everyone` gives each method the
/// same look in all charts.
pub(crate) fn save(
    rows: &[&Row],
    everyone: &[String],
    folder: &Path,
    name: &str,
) -> crate::support::Result<PathBuf> {
    let mut panel = Panel::new("largest error over all samples / scale", "CPU time / s")
        .title(name.replace('_', " "))
        .log_x()
        .log_y()
        .x_range(FINEST..=COARSEST)
        .vertical(FAILED, "failed");
    for (index, who) in everyone.iter().enumerate() {
        let of_method = || rows.iter().filter(|row| row.who() == *who);
        let reached: Vec<(f64, f64)> = of_method()
            .filter_map(|row| Some((row.achieved()?.clamp(FINEST, COARSEST), row.cpu_s)))
            .collect();
        let failed: Vec<(f64, f64)> =
            of_method().filter(|row| row.status != OK).map(|row| (FAILED, row.cpu_s)).collect();
        if !reached.is_empty() {
            let width = if who.starts_with(crate::OURS) { 3.0 } else { 1.2 };
            let stroke = Stroke::nth(index).width(width);
            let symbol = Symbol::nth(index).size(5.0);
            panel = panel.line(who, stroke, &reached).points(who, symbol, &reached);
        }
        let mark = Symbol::nth(index).size(8.0);
        panel = panel.points("", Symbol { marker: Marker::Diamond, ..mark }, &failed);
    }
    Figure::new(900, 760).panel(panel).save(folder, name)
}
