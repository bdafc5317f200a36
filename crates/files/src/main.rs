//! Friction simulated without writing Rust: model, scene and solver from a TOML file.
//!
//! ```sh
//! cargo run --release -p bristle-files -- crates/files/examples/valve.toml
//! ```
//!
//! Without a file it takes `stick_slip.toml`. The folder has a file for every scene. Leaves
//! `valve.csv` and `valve.svg`, under the name of the file: every state over time.

use std::path::Path;
use std::process::ExitCode;

use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, println};
use bristle_files::{Table, read};

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let about = "Simulates the friction scene of a TOML FILE [default: stick_slip.toml]";
        let arguments = Arguments::new("bristle", about).file().parse()?;
        let (path, text) = match arguments.file() {
            None => {
                (Path::new("stick_slip.toml"), include_str!("../examples/stick_slip.toml").into())
            }
            Some(path) => {
                let unread = |error| format!("cannot read {}: {error}", path.display());
                (path, std::fs::read_to_string(path).map_err(unread)?)
            }
        };
        let table = read(&text).and_then(|setup| setup.run());
        let table = table.map_err(|refusal| format!("{}{refusal}", path.display()))?;

        let name = path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy();
        let columns = table.columns.iter().map(|column| column.0);
        let columns: Vec<&str> = std::iter::once("t").chain(columns).collect();
        let mut csv = Csv::create(arguments.out_dir(), &name, &columns)?;
        for row in &table.rows {
            csv.row(&[], row)?;
        }
        csv.finish()?;
        println!("{}: {} rows of {}", path.display(), table.rows.len(), columns.join(", "));
        if let Some(error) = table.error {
            println!("Half the step changes a state by up to {error:.1e} of its scale.");
        }
        println!("\n{}", chart(&name, &table).save(arguments.out_dir(), &name)?.display());
        Ok(())
    })
}

/// Every column over time.
fn chart(name: &str, table: &Table) -> Figure {
    let rows = table.columns.len().div_ceil(2);
    let mut figure = Figure::new(900, 60 + 270 * u32::try_from(rows).unwrap_or(1))
        .title(format!("{name}: every column of the table over time"))
        .columns(2);
    for (index, &(_, label, factor)) in table.columns.iter().enumerate() {
        let curve: Vec<(f64, f64)> =
            table.rows.iter().map(|row| (row[0], factor * row[index + 1])).collect();
        figure = figure.panel(Panel::new("time t (s)", label).line("", Colour::Blue, curve));
    }
    figure
}
