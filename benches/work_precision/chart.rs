//! Work over precision: one figure a scene, one panel a friction model.

use std::path::{Path, PathBuf};

use bristle_charts::{Figure, Marker, Panel, Stroke};

use crate::row::{NO_ANSWER, Row};

/// The errors that are shown. There are no numbers in the last decade: there are the marks of runs
/// that failed.
const ERRORS: std::ops::RangeInclusive<f64> = 1e-15..=100.0;
const FAILED_AT: f64 = 35.0;
/// `ode::solve`, as the rows name it.
const AUTOMATIC: &str = "solve";
/// Smaller errors than this are shown here: the reference is no better.
const EXACT: f64 = 2e-15;

/// Writes a figure for every scene in some rows.
pub fn draw(folder: &Path, prefix: &str, rows: &[Row]) -> bristle_charts::Result<Vec<PathBuf>> {
    let methods = distinct(rows.iter().map(|row| row.method));
    let scenes = distinct(rows.iter().map(|row| row.scene));
    scenes.into_iter().map(|scene| figure(folder, prefix, rows, scene, &methods)).collect()
}

fn figure(
    folder: &Path,
    prefix: &str,
    rows: &[Row],
    scene: &str,
    methods: &[&str],
) -> bristle_charts::Result<PathBuf> {
    let rows: Vec<&Row> = rows.iter().filter(|row| row.scene == scene).collect();
    // Both panels have the same axes, so that the models can be compared too.
    let times = || rows.iter().map(|row| row.seconds).filter(|time| *time > 0.0);
    let least = times().fold(f64::INFINITY, f64::min);
    let most = times().fold(0.0, f64::max);
    let mut figure = Figure::new(900, 500)
        .title(format!(
            "CPU time over error of every method on scene {}",
            scene.replace('_', " ").replace("Hz", " Hz")
        ))
        .note("Triangles, if any: runs that failed or were wrong by ten scales of the scene.")
        .columns(2);
    for model in distinct(rows.iter().map(|row| row.model)) {
        let title = format!(
            "{}, {}",
            scene.replace('_', " ").replace("Hz", " Hz"),
            if model == "frbd" { "FrBD" } else { "LuGre" }
        );
        let mut panel = Panel::new("error over the scale of the scene (–)", "CPU time t (s)")
            .title(title)
            .log_x()
            .log_y()
            .x_range(ERRORS)
            .vertical(NO_ANSWER, "failed");
        if least < most {
            panel = panel.y_range(0.7 * least..=1.4 * most);
        }
        for (index, method) in methods.iter().enumerate() {
            let own = || rows.iter().filter(|row| row.model == model && row.method == *method);
            let place = |row: &&Row| (row.error.max(EXACT), row.seconds);
            // A failure breaks the line.
            let line = own().map(|row| if row.fails() { (f64::NAN, f64::NAN) } else { place(row) });
            let failed = own().filter(|row| row.fails()).map(|row| (FAILED_AT, row.seconds));
            let bold = *method == AUTOMATIC;
            let name = if bold { "ode::solve" } else { *method };
            let stroke = Stroke::nth(index).width(if bold { 3.5 } else { 1.2 });
            // Triangles are for failures.
            let marker = [Marker::Disc, Marker::Square, Marker::Diamond][index % 3];
            let symbol = stroke.colour.marked(marker).size(4.5);
            panel = panel.marked_line(name, stroke, symbol, line).points(
                "",
                stroke.colour.marked(Marker::Triangle).size(7.0),
                failed,
            );
        }
        figure = figure.panel(panel);
    }
    figure.save(folder, &format!("{prefix}_{scene}"))
}

/// Each word once, in the order of appearance.
fn distinct<'a>(words: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut seen = Vec::new();
    for word in words {
        if !seen.contains(&word) {
            seen.push(word);
        }
    }
    seen
}
