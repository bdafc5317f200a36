//! CPU time over error: one panel a friction model, under the parabolic pressure.

use std::path::{Path, PathBuf};

use bristle_charts::{Figure, Marker, Panel, Stroke};

use crate::transient::{Row, SOLVERS};

pub(crate) fn draw(folder: &Path, rows: &[Row]) -> bristle_charts::Result<PathBuf> {
    let rows: Vec<&Row> = rows.iter().filter(|row| row.pressure == "parabolic").collect();
    let most = rows.iter().map(|row| row.seconds).fold(0.0, f64::max);
    let least = rows.iter().map(|row| row.seconds).fold(f64::INFINITY, f64::min);
    let mut figure = Figure::new(900, 470)
        .title("CPU time over error of all solvers of a contact patch")
        .columns(2);
    for (model, title) in [("frbd", "FrBD"), ("lugre", "LuGre")] {
        let mut panel = Panel::new("greatest error of F/F_z (–)", "CPU time (s)")
            .title(format!("{title}, tyre transient, parabolic pressure"))
            .log_x()
            .log_y()
            .x_range(1e-15..=1e-1)
            .y_range(0.6 * least..=1.6 * most);
        for (index, solver) in SOLVERS.iter().enumerate() {
            let own: Vec<(f64, f64)> = rows
                .iter()
                .filter(|row| row.model == model && row.solver == *solver)
                .map(|row| (row.error.max(1.5e-15), row.seconds))
                .collect();
            let stroke = Stroke::nth(index);
            let marker = [Marker::Disc, Marker::Square, Marker::Diamond][index % 3];
            let symbol = stroke.colour.marked(marker).size(4.5);
            panel = panel.marked_line(solver, stroke, symbol, own);
        }
        figure = figure.panel(panel);
    }
    figure.save(folder, "rolling_contact")
}
