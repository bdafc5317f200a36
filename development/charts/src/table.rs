//! Comma-separated tables, written and read.

use std::fs::{File, read_to_string};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use super::{Result, at, create_folder, shortest};

/// A table that is being written; it is complete only after [`Csv::finish`].
#[derive(Debug)]
#[must_use = "a table is complete only after `finish`"]
pub struct Csv {
    path: PathBuf,
    columns: usize,
    file: BufWriter<File>,
}

impl Csv {
    /// Creates `folder/name.csv` (and the folder) and writes the line of column names.
    pub fn create(folder: impl AsRef<Path>, name: &str, columns: &[&str]) -> Result<Csv> {
        create_folder(folder.as_ref())?;
        let path = folder.as_ref().join(format!("{name}.csv"));
        let file = BufWriter::new(File::create(&path).map_err(at("create", &path))?);
        let mut table = Csv { path, columns: columns.len(), file };
        table.row(columns, &[])?;
        Ok(table)
    }

    /// Writes a row: the text columns first, then the numbers, in the order of the header.
    /// Numbers read back to the same bits.
    pub fn row(&mut self, texts: &[&str], numbers: &[f64]) -> Result<()> {
        let (given, columns) = (texts.len() + numbers.len(), self.columns);
        if given != columns {
            let path = self.path.display();
            return Err(format!("{path}: a row has {given} cells, the header {columns}").into());
        }
        let cells = texts.iter().map(|text| quoted(text));
        let cells = cells.chain(numbers.iter().map(|&value| shortest(value)));
        let line = cells.collect::<Vec<_>>().join(",");
        writeln!(self.file, "{line}").map_err(at("write", &self.path))
    }

    /// Writes what is still in memory and returns the path of the file.
    pub fn finish(mut self) -> Result<PathBuf> {
        self.file.flush().map_err(at("write", &self.path))?;
        Ok(self.path)
    }
}

/// Quotes a text that would otherwise break the table (RFC 4180).
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

/// Reads columns of a table with tabs, commas, semicolons or blanks between the cells.
///
/// `choice` names the columns, with factors that turn them into SI units and set their signs:
/// `t=1,x=3*1e-3,f=4*-1e-6`. A column is given by its number, or by its name in the first line.
/// Lines that begin with `#` are left out, and so is the first line if it holds no numbers.
pub fn read_columns(path: &Path, choice: &str) -> Result<Vec<(String, Vec<f64>)>> {
    let text = read_to_string(path).map_err(at("read", path))?;
    let names = names(&text);
    let place = |given| chosen(given, &names);
    let chosen = choice.split(',').map(place).collect::<Result<Vec<_>>>()?;
    let mut columns: Vec<_> = chosen.iter().map(|(name, ..)| (name.clone(), Vec::new())).collect();
    for (place, (number, line)) in filled_lines(&text).enumerate() {
        let cells = cells(line);
        let read = |&(_, column, factor): &(String, usize, f64)| {
            let cell = cells.get(column - 1).copied().unwrap_or_default();
            cell.parse().map(|value: f64| value * factor).map_err(|_| (column, cell))
        };
        match chosen.iter().map(read).collect::<std::result::Result<Vec<_>, _>>() {
            Ok(values) => columns.iter_mut().zip(values).for_each(|(c, value)| c.1.push(value)),
            Err(_) if place == 0 => {}
            Err((column, cell)) => {
                let place = format!("{}, line {}", path.display(), number + 1);
                let rule = format!("column {column} must be a number, but is {cell:?}");
                return Err(format!("{place}: {rule}").into());
            }
        }
    }
    Ok(columns)
}

/// The cells of the first line of a table: the names of its columns, if it has any.
pub fn read_names(path: &Path) -> Result<Vec<String>> {
    let text = read_to_string(path).map_err(at("read", path))?;
    Ok(names(&text).into_iter().map(str::to_owned).collect())
}

fn names(text: &str) -> Vec<&str> {
    filled_lines(text).next().map_or_else(Vec::new, |(_, line)| cells(line))
}

/// Lines with their numbers from zero.
fn filled_lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let lines = text.lines().enumerate();
    lines.filter(|(_, line)| !line.starts_with('#') && !line.trim().is_empty())
}

fn cells(line: &str) -> Vec<&str> {
    let separator = ['\t', ';', ','].into_iter().find(|&separator| line.contains(separator));
    match separator {
        Some(separator) => line.split(separator).map(str::trim).collect(),
        None => line.split_whitespace().collect(),
    }
}

/// `x=3*1e-3` or `x=angle*1e-3` as name, column and factor.
fn chosen(given: &str, names: &[&str]) -> Result<(String, usize, f64)> {
    let parsed = given.split_once('=').and_then(|(name, place)| {
        let (column, factor) = place.split_once('*').unwrap_or((place, "1"));
        let factor = factor.trim().parse().ok().filter(|factor: &f64| factor.is_finite())?;
        Some((name.trim().to_owned(), column.trim(), factor))
    });
    let column = |column: &str| match column.parse() {
        Ok(number) => Some(number).filter(|&number: &usize| number >= 1),
        Err(_) => names.iter().position(|&name| name == column).map(|place| place + 1),
    };
    parsed.and_then(|(name, place, factor)| Some((name, column(place)?, factor))).ok_or_else(|| {
        let rule = "must be NAME=COLUMN or NAME=COLUMN*FACTOR, columns counted from 1 or named";
        format!("columns: {given:?} {rule} as in the first line").into()
    })
}
