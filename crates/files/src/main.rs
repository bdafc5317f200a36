//! Friction simulated without writing Rust: model, scene and solver from a TOML file.
//!
//! ```sh
//! cargo run --release --features serde --example from_file -- examples/from_file/valve.toml
//! ```
//!
//! Without a file it takes `examples/from_file/stick_slip.toml`. The folder has a file for every
//! scene. Leaves `from_file.csv` and `from_file.svg`: every state over time.

use std::path::Path;
use std::process::ExitCode;

use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, println};
use bristle_files::{Refusal, Table, read};

/// The file that is taken if none is given.
const DEFAULT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/from_file/stick_slip.toml");

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments = Arguments::new("from_file", "Model, scene and solver from a TOML file")
            .file()
            .parse()?;
        let path = arguments.file().unwrap_or(Path::new(DEFAULT));
        let text = std::fs::read_to_string(path)
            .map_err(|error| format!("cannot read {}: {error}", path.display()))?;
        let refused = |refusal| format!("{}{refusal}", path.display());
        let setup = read(&text).map_err(refused)?;
        let run = setup.run().map_err(|error| Refusal::of_run(&text, error.to_string()));
        let table = run.map_err(refused)?;

        let names = table.columns.iter().map(|column| column.0);
        let names: Vec<&str> = std::iter::once("t").chain(names).collect();
        let mut csv = Csv::create(arguments.out_dir(), "from_file", &names)?;
        for row in &table.rows {
            csv.row(&[], row)?;
        }
        csv.finish()?;
        let name = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into());
        println!("{}: {} rows of {}", path.display(), table.rows.len(), names.join(", "));
        if let Some(error) = table.error {
            println!("Half the step changes a state by up to {error:.1e} of its scale.");
        }
        println!();
        println!("{}", chart(&name, &table).save(arguments.out_dir(), "from_file")?.display());
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
