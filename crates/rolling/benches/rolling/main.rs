//! The cost of a rolling patch, and its work over precision: the command is
//! `cargo bench -p bristle-rolling --bench rolling`.
//!
//! (a) [Cost](cost): the amortised step of the exact reduction over that of a lumped contact, in
//! one run, by the number of segments in the patch.
//!
//! (b) [Work over precision](transient) on the example `tyre_transient`: every solver of a patch,
//! both models, three pressures. The error is the greatest one of F/F_z over 100 samples, against
//! quadrature of the characteristics.
//!
//! Leaves `rolling_contact.csv` and `rolling_contact.svg`; `--out DIR` says where, `--cost` stops
//! after (a).
//!
//! Read times as ratios within one run of this bench. What is unfair: the velocities are known and
//! smooth, so that the fourth order pays; the patch is uniform, without which there is no exact
//! reduction; and the grids get steps that suit them, one cell at a time for the semi-Lagrangian
//! one, a Courant number of 0.9 upwind.

#[path = "../../tests/rolling/characteristics.rs"]
mod characteristics;
mod chart;
mod cost;
mod transient;
mod upwind;

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let mut out = PathBuf::from("target/figures");
        let mut cost_alone = false;
        let mut words = std::env::args().skip(1);
        while let Some(word) = words.next() {
            match word.as_str() {
                "--bench" => {} // `cargo bench` adds this on its own
                "--cost" => cost_alone = true,
                "--out" => out = words.next().ok_or("--out needs a folder")?.into(),
                _ => return Err("usage: rolling [--cost] [--out DIR]".into()),
            }
        }
        let begin = Instant::now();
        cost::report()?;
        if cost_alone {
            return Ok(());
        }
        let rows = transient::measure()?;
        transient::summary(&rows);
        println!("{}", transient::write(&out, &rows)?.display());
        println!("{}", chart::draw(&out, &rows)?.display());
        println!("{:.0} s", begin.elapsed().as_secs_f64());
        Ok(())
    })
}
