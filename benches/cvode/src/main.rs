//! CVODE on the scenes of the work-precision charts, told and not told of reversals:
//! `cargo run --release --manifest-path benches/cvode/Cargo.toml` (a minute; needs the system's
//! SUNDIALS 6, Debian's `libsundials-dev`; elsewhere `RUSTFLAGS="-L FOLDER"`
//! and `LD_LIBRARY_PATH`).
//!
//! Scenes, reference, counters and the rules of a run are those of `benches/peers`. Prints the
//! least evaluations at each error and leaves `cvode.csv`. What is counted does not depend on the
//! machine.
#![allow(dead_code, unreachable_pub, reason = "most modules are shared")]

#[path = "../../peers/src/counts.rs"]
mod counts;
mod cvode;
#[path = "../../peers/src/field.rs"]
mod field;
#[path = "../../peers/src/measure.rs"]
mod measure;
#[path = "../../work_precision/methods.rs"]
mod methods;
#[path = "../../peers/src/peer/run.rs"]
mod peer;
#[path = "../../work_precision/reference.rs"]
mod reference;
#[path = "../../peers/src/row.rs"]
mod row;
#[path = "../../work_precision/scenes.rs"]
mod scenes;

use std::process::ExitCode;

use bristle::ode::System;
use bristle_charts::{Arguments, Result, println};
use scenes::{Scene, Visitor};

/// Our own crate in the rows of `measure`.
const OURS: &str = "bristle";
/// Scenes of `docs/work-precision.md`, with FrBD.
const SCENES: [&str; 3] = ["S1", "S2_ramp", "S3_5Hz"];

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let about = "CVODE on the paper's experiments";
        let arguments = Arguments::new("cvode", about).parse()?;
        measure::catch_last_words();
        let mut study = Study { rows: Vec::new(), result: Ok(()) };
        scenes::each(&mut study)?;
        study.result?;
        println!("{}", row::save(&study.rows, arguments.out_dir(), "cvode")?.display());
        println!("\n{}", counts::markdown(&study.rows));
        Ok(())
    })
}

struct Study {
    rows: Vec<row::Row>,
    result: Result<()>,
}

impl Visitor for Study {
    fn visit<S: System<f64, N> + Clone, const N: usize>(&mut self, scene: &Scene<S, N>) {
        if scene.model != "frbd" || !SCENES.contains(&scene.name) {
            return;
        }
        let reference = match reference::reference(scene) {
            Ok(reference) => reference,
            Err(error) => return self.result = Err(error.to_string().into()),
        };
        let mut complaints = Vec::new();
        for method in cvode::methods::<S, N>() {
            self.rows.extend(measure::sweep(scene, &method, &reference, &mut complaints).rows);
        }
        for measure::Complaint { row, message } in complaints {
            println!("{} on {}, {}: {message}", row.who(), row.scene, row.setting);
        }
    }
}
