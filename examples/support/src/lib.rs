//! What an example needs around the physics: command-line [arguments](Arguments), [CSV](Csv) files and [charts](Figure).
//!
//! It knows nothing of friction. An example reads its options, simulates, writes one table and one figure of its own name:
//!
//! ```no_run
//! # use bristle_example_support as support;
//! use support::{Arguments, Colour, Csv, Figure, Panel, Rule};
//!
//! fn main() -> std::process::ExitCode {
//!     support::run(|| {
//!         let arguments = Arguments::new("decay", "A transient that dies out")
//!             .number("end", 10.0, "s", "end of the simulated time").must_be(Rule::Positive)
//!             .count("samples", 1001, "points of the curve").must_be(Rule::AtLeast(2.0))
//!             .parse()?;
//!         let samples = arguments.count("samples");
//!         let step = arguments.number("end") / (samples - 1) as f64;
//!         let curve: Vec<(f64, f64)> = (0..samples).map(|i| i as f64 * step).map(|t| (t, (-t).exp())).collect();
//!
//!         let mut table = Csv::create(arguments.out_dir(), "decay", &["model", "t", "x"])?;
//!         for &(t, x) in &curve {
//!             table.row(&["exponential"], &[t, x])?;
//!         }
//!         table.finish()?;
//!
//!         let panel = Panel::new("time t / s", "position x / m").line("exponential", Colour::Blue, &curve);
//!         let path = Figure::new(640, 400).panel(panel).save(arguments.out_dir(), "decay")?;
//!         println!("{}", path.display());
//!         Ok(())
//!     })
//! }
//! ```

mod arguments;
mod chart;
mod csv;
mod file;
mod number;
mod run;
mod table;

pub use arguments::{ArgumentError, Arguments, Rule, Values};
pub use chart::{
    Colour, ColourMap, Dash, Figure, FigureError, HeatMap, Marker, Panel, Stroke, Symbol,
};
pub use csv::{Csv, CsvError};
pub use file::FileError;
pub use run::run;
pub use table::{TableError, read_columns};
