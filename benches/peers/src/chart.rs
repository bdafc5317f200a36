//! The work–precision chart of a scene, CPU time over achieved error: a panel for each friction
//! model, `ode::solve` bold, our single methods and the methods of every other crate in one colour.

use std::path::{Path, PathBuf};

use crate::support::{Colour, Figure, Marker, Panel, Result, Stroke};

use crate::row::{OK, Row};

/// Axis of errors: what lies outside says nothing about a method.
const FINEST: f64 = 1e-13;
const COARSEST: f64 = 1e2;
/// Where runs are marked that have no error because they failed.
const FAILED: f64 = 20.0;

/// Writes `folder/NAME.svg` for the rows of one scene.
pub(crate) fn save(rows: &[&Row], folder: &Path, name: &str) -> Result<PathBuf> {
    let mut figure = Figure::new(900, 520)
        .title(format!("{}: CPU time over error", name.replace('_', " ")))
        .note("Diamonds: runs that failed. A line is one method over its tolerances.")
        .columns(2);
    for model in distinct(rows.iter().map(|row| &row.model)) {
        let here: Vec<&&Row> = rows.iter().filter(|row| row.model == *model).collect();
        let mut panel = Panel::new("largest error over all samples / scale", "CPU time t / s")
            .title(if model == "frbd" { "FrBD" } else { "LuGre" })
            .log_x()
            .log_y()
            .x_range(FINEST..=COARSEST)
            .vertical(FAILED, "failed");
        let methods = distinct(here.iter().map(|row| &row.method));
        // `ode::solve` comes last, on top of the others.
        let automatic = |method: &&&String| method.as_str() == "solve";
        let others = methods.iter().filter(|method| !automatic(method));
        for method in others.chain(methods.iter().filter(automatic)) {
            for crate_ in distinct(here.iter().map(|row| &row.crate_)) {
                let own = || here.iter().filter(|r| r.method == **method && r.crate_ == *crate_);
                let reached: Vec<(f64, f64)> = own()
                    .filter_map(|r| Some((r.achieved()?.clamp(FINEST, COARSEST), r.cpu_s)))
                    .collect();
                let failed = own().filter(|row| row.status != OK).map(|row| (FAILED, row.cpu_s));
                let (name, stroke) = look(crate_, method);
                let mark = stroke.colour.marked(Marker::Diamond);
                panel = panel
                    .marked_line(
                        &name,
                        stroke,
                        stroke.colour.marked(Marker::Disc).size(4.0),
                        &reached,
                    )
                    .points("", mark.size(7.0), failed.collect::<Vec<_>>());
            }
        }
        figure = figure.panel(panel);
    }
    figure.save(folder, name)
}

/// The name of a method in the legend, and its stroke.
fn look(crate_: &str, method: &str) -> (String, Stroke) {
    match (crate_, method) {
        (crate::OURS, "solve") => ("ode::solve".to_owned(), Colour::Blue.width(3.5)),
        (crate::OURS, _) => ("our single methods".to_owned(), Colour::Sky.width(1.0)),
        ("differential-equations", _) => (crate_.to_owned(), Colour::Orange.width(1.0)),
        ("diffsol", _) => (crate_.to_owned(), Colour::Green.width(1.0)),
        ("ivp", _) => (crate_.to_owned(), Colour::Purple.width(1.0)),
        _ => (crate_.to_owned(), Colour::Grey.width(1.0)),
    }
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
