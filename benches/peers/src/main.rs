//! The scenes of the work-precision charts, integrated by the crates a user would pick otherwise,
//! and by our own methods in the same run:
//! `cargo run --release --manifest-path benches/peers/Cargo.toml` (some minutes, on one thread).
//!
//! Leaves `peers.csv` (every run), `peers_ratio.md` (the best peer over our best at the same
//! error, also printed) and one chart per scene in `target/figures`, or `--out DIR`. Given a
//! `peers.csv`, it draws the charts and the ratios of that run again.
//!
//! What is measured: CPU time of the thread for a whole solution, output at 2001 samples included,
//! the least of several runs; the largest error over the samples; evaluations, counted inside the
//! right-hand side. What is unfair: the peers are general codes that do not know about reversals,
//! which is the point; where a crate's vectors are allocated, small systems like these suffer
//! most; and nobody has tuned more than each crate's documentation proposes (see `peer`).
//!
//! A run is given up after 1.5 s or 30 million evaluations; a method is given up on a scene when
//! that happens, or after three failures in a row. Slow methods are run at whole decades of the
//! tolerance, the others at half ones.

mod chart;
mod counts;
mod field;
mod measure;
mod peer;
mod ratio;
mod row;

// Shared with the bench of our own methods, so that both integrate the same systems and are judged
// by the same solutions.
#[allow(unreachable_pub, reason = "not written for this package alone")]
#[path = "../../work_precision/methods.rs"]
mod methods;
#[allow(unreachable_pub, dead_code, reason = "not written for this package alone")]
#[path = "../../work_precision/reference.rs"]
mod reference;
#[allow(unreachable_pub, reason = "not written for this package alone")]
#[path = "../../work_precision/scenes.rs"]
mod scenes;

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::error::Error;
use std::fs;
use std::process::ExitCode;

use bristle::ode::System;
use bristle_charts::{Arguments, Progress, Rule, println};

use measure::Complaint;
use row::Row;
use scenes::{Scene, Visitor};

/// Our own crate in the rows.
const OURS: &str = "bristle";

/// How often the times of all methods on a scene are taken, one pass after the other.
const PASSES: usize = 2;

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let about = "Work and precision of other crates on the paper's experiments";
        let arguments = Arguments::new("peers", about)
            .count("scene", 0, "only this scene of the list, from 1; 0 for all")
            .must_be(Rule::AtLeast(0.0))
            .file()
            .parse()?;
        let folder = arguments.out_dir();
        if let Some(table) = arguments.file() {
            return draw(&row::read(table)?, folder);
        }
        measure::catch_last_words();

        let mut study = Study {
            only: arguments.count("scene"),
            visited: 0,
            rows: Vec::new(),
            complaints: Vec::new(),
            error: None,
            progress: Progress::new("scenes", scenes::COUNT),
        };
        scenes::each(&mut study)?;
        if let Some(error) = study.error {
            return Err(error);
        }
        let Study { rows, complaints, .. } = study;

        println!("{}", row::save(&rows, folder, "peers")?.display());
        draw(&rows, folder)?;
        tell_failures(&complaints);
        tell_wrong_answers(&rows);
        Ok(())
    })
}

/// Runs everybody on every scene.
struct Study {
    only: usize,
    visited: usize,
    rows: Vec<Row>,
    complaints: Vec<Complaint>,
    error: Option<Box<dyn Error>>,
    progress: Progress,
}

impl Visitor for Study {
    fn visit<S: System<f64, N> + Clone, const N: usize>(&mut self, scene: &Scene<S, N>) {
        self.visited += 1;
        if self.error.is_some() || (self.only != 0 && self.only != self.visited) {
            return self.progress.step();
        }
        let reference = match reference::reference(scene) {
            Ok(reference) => reference,
            Err(error) => {
                let text = format!("reference of {} {}: {error}", scene.name, scene.model);
                return self.error = Some(text.into());
            }
        };
        let complaints = &mut self.complaints;
        let own = methods::all(scene);
        let peers = peer::all::<S, N>();
        let own = own.iter().map(|own| measure::sweep_own(scene, own, &reference, complaints));
        let mut sweeps: Vec<_> = own.collect();
        sweeps.extend(peers.iter().map(|peer| measure::sweep(scene, peer, &reference, complaints)));
        for _ in 1..PASSES {
            sweeps.iter_mut().for_each(measure::Sweep::time_again);
        }
        self.rows.extend(sweeps.into_iter().flat_map(|sweep| sweep.rows));
        self.progress.step();
    }
}

/// Leaves the charts and the ratios.
fn draw(rows: &[Row], folder: &std::path::Path) -> bristle_charts::Result<()> {
    for path in charts(rows, folder)? {
        println!("{}", path.display());
    }
    let table = ratio::markdown(&ratio::compare(rows, OURS), OURS);
    let path = folder.join("peers_ratio.md");
    fs::write(&path, &table).map_err(|error| format!("{}: {error}", path.display()))?;
    println!("{}\n\n{table}\n{}", path.display(), counts::markdown(rows));
    Ok(())
}

fn charts(
    rows: &[Row],
    folder: &std::path::Path,
) -> bristle_charts::Result<Vec<std::path::PathBuf>> {
    let mut scenes: Vec<&str> = Vec::new();
    for row in rows {
        if !scenes.contains(&row.scene.as_str()) {
            scenes.push(&row.scene);
        }
    }
    let chart = |scene: &str| {
        let here: Vec<&Row> = rows.iter().filter(|row| row.scene == scene).collect();
        chart::save(&here, folder, &format!("peers_{scene}"))
    };
    scenes.into_iter().map(chart).collect()
}

/// Prints what the crates said when they failed, each method and word once.
fn tell_failures(complaints: &[Complaint]) {
    let mut kinds: BTreeMap<(String, &str), (usize, &Complaint)> = BTreeMap::new();
    for complaint in complaints {
        let kind = (complaint.row.who(), complaint.row.status.as_str());
        kinds.entry(kind).or_insert((0, complaint)).0 += 1;
    }
    println!("| method | failure | times | for example on | at | it said |");
    println!("|---|---|---|---|---|---|");
    for ((who, word), (times, Complaint { row, message })) in kinds {
        let Row { scene, model, setting, .. } = row;
        let message: String = message.replace(['\n', '|'], " ").chars().take(200).collect();
        println!("| {who} | {word} | {times} | {scene} {model} | {setting} | {message} |");
    }
}

/// Prints who reported success with an error above a tenth of the scale, at which tightest
/// tolerance.
fn tell_wrong_answers(rows: &[Row]) {
    println!("\n| method | successes | of these wrong | tightest of these on | at | error |");
    println!("|---|---|---|---|---|---|");
    let mut everyone: BTreeMap<String, Vec<(f64, &Row)>> = BTreeMap::new();
    for (error, row) in rows.iter().filter_map(|row| Some((row.error?, row))) {
        everyone.entry(row.who()).or_default().push((error, row));
    }
    for (who, successes) in everyone {
        let wrong = || successes.iter().filter(|(error, _)| *error > 0.1);
        // Settings end in their exponent: 1e-7 is tighter than 1e-2.
        let exponent = |row: &Row| row.setting.rsplit('e').next()?.parse::<f64>().ok();
        let tightest = wrong().min_by(|(_, a), (_, b)| {
            exponent(a).partial_cmp(&exponent(b)).unwrap_or(Ordering::Equal)
        });
        if let Some((error, Row { scene, model, setting, .. })) = tightest {
            let (all, wrong) = (successes.len(), wrong().count());
            println!("| {who} | {all} | {wrong} | {scene} {model} | {setting} | {error:.1e} |");
        }
    }
}
