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

use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Result, println, read_columns};
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
                let text = std::fs::read_to_string(path).map_err(unread)?;
                (path, with_curves(&text, path.parent().unwrap_or(path))?)
            }
        };
        let refused = |refusal| format!("{}{refusal}", path.display());
        let setup = read(&text).map_err(refused)?;
        let table = setup.run().map_err(refused)?;
        let setup = toml::Value::try_from(&setup)?;
        let file = path.file_name().unwrap_or_default().display();
        let about = format!("{file}: {}", model(&setup).unwrap_or_default());

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
        println!("\n{}", chart(&name, &about, &table).save(arguments.out_dir(), &name)?.display());
        Ok(())
    })
}

/// The text with the rows of a CSV file where a curve names one, `tabulated = "FILE"`: in the same
/// line, so that a refusal finds its place.
fn with_curves(text: &str, folder: &Path) -> Result<String> {
    let named = text.split_once("tabulated = \"").and_then(|(before, rest)| {
        let (file, after) = rest.split_once('"')?;
        Some((before, file, after))
    });
    let Some((before, file, after)) = named else { return Ok(text.to_owned()) };
    let columns = read_columns(&folder.join(file), "speed=1,coefficient=2")?;
    let rows = columns[0].1.iter().zip(&columns[1].1);
    let rows: String =
        rows.map(|(v, mu)| format!("{{ speed = {v:?}, coefficient = {mu:?} }}, ")).collect();
    Ok(format!("{before}tabulated = [{rows}]{}", with_curves(after, folder)?))
}

/// The name of the first friction model of a file.
fn model(value: &toml::Value) -> Option<String> {
    let table = value.as_table()?;
    let named = ["model", "friction"].into_iter().find_map(|key| table.get(key)?.as_table());
    let first = named.and_then(|model| model.keys().next().cloned());
    first.or_else(|| table.values().find_map(model))
}

/// Every column over time.
fn chart(name: &str, about: &str, table: &Table) -> Figure {
    let rows = table.columns.len().div_ceil(2);
    let mut figure = Figure::new(900, 60 + 270 * u32::try_from(rows).unwrap_or(1))
        .title(format!("{name}: every column of the table over time"))
        .note(about.replace('_', r"\_"))
        .columns(2);
    for (index, &(_, label, factor)) in table.columns.iter().enumerate() {
        let curve: Vec<(f64, f64)> =
            table.rows.iter().map(|row| (row[0], factor * row[index + 1])).collect();
        figure = figure.panel(Panel::new("time t (s)", label).line("", Colour::Blue, curve));
    }
    figure
}
