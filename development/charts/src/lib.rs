//! What the examples and benches need around the physics: command-line [arguments](Arguments),
//! [tables](Csv), [charts](Figure), [progress](Progress) and [times](Stopwatch). Nothing here knows
//! of friction.
//!
//! ```no_run
//! use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Rule, println};
//!
//! fn main() -> std::process::ExitCode {
//!     bristle_charts::run(|| {
//!         let arguments = Arguments::new("decay", "A transient that dies out")
//!             .number("end", 10.0, "s", "end of the simulated time")
//!             .must_be(Rule::Positive)
//!             .parse()?;
//!         let end = arguments.number("end");
//!         let curve: Vec<(f64, f64)> =
//!             (0..=1000).map(|i| 1e-3 * end * f64::from(i)).map(|t| (t, (-t).exp())).collect();
//!         let mut table = Csv::create(arguments.out_dir(), "decay", &["t", "x"])?;
//!         for &(t, x) in &curve {
//!             table.row(&[], &[t, x])?;
//!         }
//!         table.finish()?;
//!         let panel = Panel::new("time t (s)", "position x (m)").line("", Colour::Blue, &curve);
//!         let figure = Figure::new(640, 400).title("A transient that dies out").panel(panel);
//!         println!("{}", figure.save(arguments.out_dir(), "decay")?.display());
//!         Ok(())
//!     })
//! }
//! ```
//!
//! This [`println!`] survives a closed pipe.
#![allow(missing_docs, missing_debug_implementations, reason = "for the examples alone")]

mod arguments;
mod axis;
mod chart;
mod draw;
mod lines;
mod stopwatch;
mod table;
#[cfg(test)]
mod tests;

use std::error::Error;
use std::fmt;
use std::fs;
use std::io::{ErrorKind, IsTerminal, Write, stderr, stdout};
use std::path::Path;
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

pub use arguments::{Arguments, Rule, Values};
pub use chart::{Colour, Figure, HeatMap, Marker, Panel, Stroke, Symbol};
pub use stopwatch::Stopwatch;
pub use table::{Csv, read_columns, read_names};

/// What every function here returns that may fail; errors name the file or option and the reason.
pub type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// The `main` of every example. Exit code 0 after success and `--help`, 2 after a misused argument,
/// 1 after any other error, which is reported in one line on the standard error stream. Output that
/// could not be written (a full disk) is such an error; a closed pipe is not.
pub fn run(example: impl FnOnce() -> Result<()>) -> ExitCode {
    let mut ended = example();
    if let Err(error) = &ended
        && let Some(arguments::Unusable::Help(usage)) = error.downcast_ref()
    {
        say(format_args!("{usage}"));
        ended = Ok(());
    }
    note(stdout().flush());
    let unwritten = LOST.lock().ok().and_then(|mut lost| lost.take());
    if let (Ok(()), Some(reason)) = (&ended, unwritten) {
        ended = Err(format!("cannot write to the standard output: {reason}").into());
    }
    let Err(error) = ended else { return ExitCode::SUCCESS };
    let line = error.to_string().lines().map(str::trim).collect::<Vec<_>>().join(" ");
    let _ = writeln!(stderr(), "error: {line}");
    ExitCode::from(if error.is::<arguments::Unusable>() { 2 } else { 1 })
}

/// The first error of the standard output.
static LOST: Mutex<Option<std::io::Error>> = Mutex::new(None);

/// Prints; an error is kept for the end of [`run`].
pub fn say(text: fmt::Arguments<'_>) {
    if SHOWN.swap(false, Ordering::Relaxed) {
        let _ = write!(stderr(), "\r\x1b[K");
    }
    note(stdout().write_fmt(text));
}

/// Keeps the first error, unless it is that the reader has left.
fn note(written: std::io::Result<()>) {
    if let Err(error) = written
        && error.kind() != ErrorKind::BrokenPipe
        && let Ok(mut lost) = LOST.lock()
    {
        lost.get_or_insert(error);
    }
}

/// Prints like that of the standard library, but a closed pipe (`example | head -1`) is no error,
/// and any other one lets the example go on, leave its files and fail at its end.
#[macro_export]
macro_rules! print {
    ($($text:tt)*) => { $crate::say(format_args!($($text)*)) };
}

/// [`print!`] with the end of a line.
#[macro_export]
macro_rules! println {
    () => { $crate::say(format_args!("\n")) };
    ($($text:tt)*) => { $crate::say(format_args!("{}\n", format_args!($($text)*))) };
}

/// Tells on a terminal how many of the parts of a long computation are done.
#[derive(Debug)]
pub struct Progress {
    what: &'static str,
    parts: usize,
    done: usize,
}

impl Progress {
    /// Begins a computation of `parts` parts.
    pub fn new(what: &'static str, parts: usize) -> Progress {
        let progress = Progress { what, parts, done: 0 };
        progress.show();
        progress
    }

    /// Another part is done.
    pub fn step(&mut self) {
        self.done += 1;
        self.show();
    }

    /// So many parts are done.
    pub fn reach(&mut self, done: usize) {
        self.done = done;
        self.show();
    }

    fn show(&self) {
        if stderr().is_terminal() {
            let is_over = self.done >= self.parts;
            let end = if is_over { "\r\x1b[K" } else { "" };
            let _ = write!(stderr(), "\r{}: {} of {}{end}", self.what, self.done, self.parts);
            SHOWN.store(!is_over, Ordering::Relaxed);
        }
    }
}

/// Whether the line of a [`Progress`] is on the terminal.
static SHOWN: AtomicBool = AtomicBool::new(false);

/// One of the ways that an example compares: as it is named in the table and drawn in the chart.
#[derive(Debug, Clone, Copy)]
pub struct Way<S> {
    pub scheme: S,
    pub name: &'static str,
    pub label: &'static str,
    pub colour: Colour,
    pub marker: Marker,
}

impl<S> Way<S> {
    pub const fn new(
        scheme: S,
        name: &'static str,
        label: &'static str,
        colour: Colour,
        marker: Marker,
    ) -> Self {
        Self { scheme, name, label, colour, marker }
    }
}

/// Random numbers, nearly Gaussian, of mean zero and variance one; in every run the same.
pub fn noise() -> impl FnMut() -> f64 {
    let mut seed = 1_u64;
    move || {
        let mut uniform = || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        // The sum of twelve uniform numbers, less its mean, has a variance of one.
        (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    }
}

/// Creates `folder` and the folders above it, unless they exist.
fn create_folder(folder: &Path) -> Result<()> {
    match fs::create_dir_all(folder) {
        Ok(()) => Ok(()),
        Err(_) if folder.exists() => {
            Err(format!("cannot create the folder {}: it is a file", folder.display()).into())
        }
        Err(error) => Err(at("create the folder", folder)(error)),
    }
}

/// Turns an error of the operating system into one that says what was tried and where.
fn at(task: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Box<dyn Error> {
    move |reason| format!("cannot {task} {}: {reason}", path.display()).into()
}

/// The shorter of the plain and the exponent form; both read back to the same bits.
fn shortest(value: f64) -> String {
    let (plain, exponent) = (format!("{value}"), format!("{value:e}"));
    if exponent.len() < plain.len() { exponent } else { plain }
}
