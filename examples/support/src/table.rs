//! Tables of numbers that others have written: columns by place, with a factor.

use std::fs::read_to_string;
use std::path::{Path, PathBuf};

use crate::file::FileError;

/// Why a table or the choice of its columns was refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TableError {
    /// The file could not be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// A choice that is not `name=column` or `name=column*factor`.
    #[error("columns: {given:?} must be NAME=COLUMN or NAME=COLUMN*FACTOR, columns counted from 1")]
    Choice {
        /// What was given.
        given: String,
    },
    /// A cell that is missing or not a number.
    #[error("{}, line {line}: column {column} must be a number, but is {cell:?}", path.display())]
    Cell {
        /// The table.
        path: PathBuf,
        /// Line in the file, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What stands there; empty if nothing.
        cell: String,
    },
}

/// Reads columns of a table with tabs, commas, semicolons or blanks between the cells.
///
/// `choice` names them, with factors that turn them into SI units and set their signs: `t=1,x=3*1e-3,f=4*-1e-6`. Answers each
/// name with its column. Lines that begin with `#` are left out, and the first if it holds no number where one is due.
pub fn read_columns(path: &Path, choice: &str) -> Result<Vec<(String, Vec<f64>)>, TableError> {
    let text = read_to_string(path).map_err(FileError::at("read", path))?;
    let mut columns = choice.split(',').map(chosen).collect::<Result<Vec<_>, _>>()?;
    let lines = text
        .lines()
        .enumerate()
        .filter(|(_, line)| !line.starts_with('#') && !line.trim().is_empty());
    for (place, (number, line)) in lines.enumerate() {
        let separator = ['\t', ';', ','].into_iter().find(|&separator| line.contains(separator));
        let cells: Vec<&str> = match separator {
            Some(separator) => line.split(separator).map(str::trim).collect(),
            None => line.split_whitespace().collect(),
        };
        let read = |&(_, column, factor, _): &(String, usize, f64, Vec<f64>)| {
            let cell = cells.get(column - 1).copied().unwrap_or_default();
            cell.parse().map(|value: f64| value * factor).map_err(|_| (column, cell.to_owned()))
        };
        match columns.iter().map(read).collect::<Result<Vec<_>, _>>() {
            Ok(values) => {
                columns.iter_mut().zip(values).for_each(|(column, value)| column.3.push(value))
            }
            Err(_) if place == 0 => {}
            Err((column, cell)) => {
                return Err(TableError::Cell {
                    path: path.to_path_buf(),
                    line: number + 1,
                    column,
                    cell,
                });
            }
        }
    }
    Ok(columns.into_iter().map(|(name, _, _, values)| (name, values)).collect())
}

/// `x=3*1e-3` as name, column, factor and a place for the values.
fn chosen(given: &str) -> Result<(String, usize, f64, Vec<f64>), TableError> {
    let parsed = given.split_once('=').and_then(|(name, place)| {
        let (column, factor) = place.split_once('*').unwrap_or((place, "1"));
        let (column, factor): (usize, f64) =
            (column.trim().parse().ok()?, factor.trim().parse().ok()?);
        (column >= 1 && factor.is_finite())
            .then(|| (name.trim().to_owned(), column, factor, Vec::new()))
    });
    parsed.ok_or_else(|| TableError::Choice { given: given.to_owned() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with_table<A>(name: &str, text: &str, then: impl FnOnce(&Path) -> A) -> std::io::Result<A> {
        let path =
            std::env::temp_dir().join(format!("bristle-table-{}-{name}", std::process::id()));
        std::fs::write(&path, text)?;
        let answer = then(&path);
        std::fs::remove_file(&path)?;
        Ok(answer)
    }

    #[test]
    fn columns_are_chosen_scaled_and_turned() -> std::io::Result<()> {
        let read =
            with_table("tabs", "Time [s]\tForce [uN]\n# by hand\n0\t5\n0.5\t-6\n", |path| {
                read_columns(path, "t=1,f=2*-0.25").map_err(|error| error.to_string())
            })?;
        let expected = vec![("t".to_owned(), vec![0.0, 0.5]), ("f".to_owned(), vec![-1.25, 1.5])];
        assert_eq!(read, Ok(expected));
        Ok(())
    }

    #[test]
    fn a_bad_cell_is_named_by_line_and_column() -> std::io::Result<()> {
        let refused = with_table("cell", "0,1\n1,one\n", |path| {
            read_columns(path, "t=1,f=2").map(|_| ()).map_err(|error| error.to_string())
        })?;
        assert!(
            refused.clone().is_err_and(
                |text| text.ends_with("line 2: column 2 must be a number, but is \"one\"")
            ),
            "{refused:?}"
        );
        Ok(())
    }

    #[test]
    fn a_choice_needs_a_name_a_column_and_a_number() {
        for given in ["t", "t=0", "t=1*", "t=1*NaN", "=x"] {
            assert!(matches!(chosen(given), Err(TableError::Choice { .. })), "{given}");
        }
    }
}
