//! The work–precision chart of a scene, CPU time over achieved error: a panel for each friction
//! model. `ode::solve` is bold. A line is the lower envelope of all runs of one crate: the best of
//! its methods at each error; every run is a small mark.

use std::path::{Path, PathBuf};

use crate::ratio::envelope;
use bristle_charts::{Colour, Figure, Marker, Panel, Result};

use crate::row::{OK, Row};

/// Axis of errors: what lies outside says nothing about a method.
const FINEST: f64 = 1e-13;
const COARSEST: f64 = 1e2;
/// Where runs are marked that have no error because they failed.
const FAILED: f64 = 20.0;

/// The method of our own that is drawn by itself.
const AUTOMATIC: &str = "solve";

/// The crates in the order of the legend; an underscore in a name is no subscript.
const CRATES: [(&str, &str, Colour, Marker); 5] = [
    ("differential-equations", "differential-equations", Colour::Orange, Marker::Square),
    ("diffsol", "diffsol", Colour::Green, Marker::Triangle),
    ("ivp", "ivp", Colour::Purple, Marker::Diamond),
    ("ode_solvers", r"ode\_solvers", Colour::Black, Marker::Square),
    (crate::OURS, "bristle, the best single method", Colour::Sky, Marker::Disc),
];

/// What the short name of a scene stands for.
fn spelt_out(scene: &str) -> String {
    let what = match scene.get(..2) {
        Some("S1") => "stick-slip",
        Some("S2") => "valve",
        Some("S3") => "pre-sliding",
        Some("S4") => "frictional lag",
        Some("S5") => "block in a plane",
        _ => return scene.to_owned(),
    };
    format!("{what}{}", scene.get(2..).unwrap_or_default())
}

/// Writes `folder/NAME.svg` for the rows of one scene.
pub(crate) fn save(rows: &[&Row], folder: &Path, name: &str) -> Result<PathBuf> {
    let scene = rows.first().map_or("", |row| &row.scene).replace('_', " ").replace("Hz", " Hz");
    let scene = spelt_out(&scene);
    let mut figure = Figure::new(900, 520)
        .title(format!("{scene}: CPU time over error of this crate and of four others"))
        .note(
            "A line: the best of all methods of a crate, and of ode::solve. A small mark: one run. \
             Marks at “failed”: failed runs. Errors below 10⁻¹³ are drawn at 10⁻¹³.",
        )
        .columns(2);
    let times = || rows.iter().map(|row| row.cpu_s).filter(|time| *time > 0.0);
    let least = times().fold(f64::INFINITY, f64::min);
    let most = times().fold(0.0, f64::max);
    for model in distinct(rows.iter().map(|row| &row.model)) {
        let here = || rows.iter().copied().filter(|row| row.model == *model);
        let title = format!("{scene}, {}", if model == "frbd" { "FrBD" } else { "LuGre" });
        let mut panel = Panel::new("error over the scale of the scene (–)", "CPU time t (s)")
            .title(title)
            .log_x()
            .log_y()
            .x_range(FINEST..=COARSEST)
            .vertical(FAILED, "failed");
        if least < most {
            panel = panel.y_range(0.7 * least..=1.4 * most);
        }
        let place = |error: f64, row: &Row| (error.clamp(FINEST, COARSEST), row.cpu_s);
        let reached = |row: &Row| Some(place(row.achieved()?, row));
        for (crate_, label, colour, marker) in CRATES {
            let own = || here().filter(|row| row.crate_ == crate_ && row.method != AUTOMATIC);
            let failed = own().filter(|row| row.status != OK).map(|row| (FAILED, row.cpu_s));
            let best = envelope(own()).into_iter().map(|(error, row)| place(error, row));
            panel = panel
                .points(
                    "",
                    colour.marked(marker).size(2.5),
                    own().filter_map(reached).collect::<Vec<_>>(),
                )
                .points("", colour.marked(marker).size(7.0), failed.collect::<Vec<_>>())
                .marked_line(
                    label,
                    colour.width(2.0),
                    colour.marked(marker).size(5.0),
                    best.collect::<Vec<_>>(),
                );
        }
        let own = here().filter(|row| (&*row.crate_, &*row.method) == (crate::OURS, AUTOMATIC));
        let solve: Vec<&Row> = own.collect();
        let disc = Colour::Blue.marked(Marker::Disc);
        panel = panel.points("", disc.size(2.5), solve.iter().copied().filter_map(reached));
        let best = envelope(solve.into_iter()).into_iter().map(|(error, row)| place(error, row));
        figure = figure.panel(panel.marked_line(
            "ode::solve",
            Colour::Blue.width(3.5),
            disc.size(5.0),
            best,
        ));
    }
    figure.save(folder, name)
}

/// Each word once, in the order of appearance.
fn distinct<'a>(words: impl Iterator<Item = &'a String>) -> Vec<&'a String> {
    let mut seen = Vec::new();
    for word in words {
        if !seen.contains(&word) {
            seen.push(word);
        }
    }
    seen
}
