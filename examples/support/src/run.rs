//! The `main` of every example: an error becomes one line and an exit code.

use std::error::Error;
use std::io::{Write, stderr, stdout};
use std::process::ExitCode;

use crate::ArgumentError;

/// Runs an example. Exit code 0 after success and after `--help`, 2 after a misused argument, 1 after any other error,
/// which is told in one line on the standard error stream.
pub fn run(example: impl FnOnce() -> Result<(), Box<dyn Error>>) -> ExitCode {
    let Err(error) = example() else { return ExitCode::SUCCESS };
    // A closed stream (`example --help | head -1`) is nobody's mistake, so a failed write is ignored here.
    match error.downcast_ref::<ArgumentError>() {
        Some(ArgumentError::Help(usage)) => {
            let _ = write!(stdout(), "{usage}");
            ExitCode::SUCCESS
        }
        misuse => {
            let line = error.to_string().lines().map(str::trim).collect::<Vec<_>>().join(" ");
            let _ = writeln!(stderr(), "error: {line}");
            ExitCode::from(if misuse.is_some() { 2 } else { 1 })
        }
    }
}
