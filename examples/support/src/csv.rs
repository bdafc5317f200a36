//! Comma-separated tables: a header, then rows of text columns followed by number columns.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::file::{FileError, create_folder};
use crate::number::shortest;

/// A table that is being written. Call [`Csv::finish`] at the end: only then is it known to be complete on the disk.
#[derive(Debug)]
#[must_use = "a table is complete only after `finish`"]
pub struct Csv {
    path: PathBuf,
    columns: usize,
    file: BufWriter<File>,
}

/// Why a table could not be written.
#[derive(Debug, thiserror::Error)]
pub enum CsvError {
    /// The file could not be created or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// A row does not match the header.
    #[error("{}: a row has {given} cells, the header {columns}", path.display())]
    Columns {
        /// The table.
        path: PathBuf,
        /// Cells in the row.
        given: usize,
        /// Names in the header.
        columns: usize,
    },
}

impl Csv {
    /// Creates `folder/name.csv` (and the folder) and writes the line of column names.
    pub fn create(folder: impl AsRef<Path>, name: &str, columns: &[&str]) -> Result<Csv, CsvError> {
        let folder = folder.as_ref();
        create_folder(folder)?;
        let path = folder.join(format!("{name}.csv"));
        let file = File::create(&path).map_err(FileError::at("create", &path))?;
        let mut table = Csv { path, columns: columns.len(), file: BufWriter::new(file) };
        table.row(columns, &[])?;
        Ok(table)
    }

    /// Writes a row: the text columns first, then the numbers, in the order of the header.
    ///
    /// Numbers read back to the same bits; a missing one is written as `f64::NAN`.
    pub fn row(&mut self, texts: &[&str], numbers: &[f64]) -> Result<(), CsvError> {
        let given = texts.len() + numbers.len();
        if given != self.columns {
            return Err(CsvError::Columns {
                path: self.path.clone(),
                given,
                columns: self.columns,
            });
        }
        let texts = texts.iter().map(|text| quoted(text));
        let mut line =
            texts.chain(numbers.iter().map(|&value| shortest(value))).collect::<Vec<_>>().join(",");
        line.push('\n');
        Ok(self.file.write_all(line.as_bytes()).map_err(FileError::at("write", &self.path))?)
    }

    /// Writes what is still in memory and returns the path of the file.
    pub fn finish(mut self) -> Result<PathBuf, CsvError> {
        self.file.flush().map_err(FileError::at("write", &self.path))?;
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

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(test: &str) -> PathBuf {
        std::env::temp_dir().join(format!("bristle-csv-{}-{test}", std::process::id()))
    }

    #[test]
    fn a_table_has_a_header_and_rows_of_text_and_numbers() -> Result<(), Box<dyn std::error::Error>>
    {
        let folder = folder("rows");
        let mut table = Csv::create(&folder, "table", &["model", "t", "x"])?;
        table.row(&["a, \"b\""], &[0.1, 1e-9])?;
        assert!(matches!(
            table.row(&["a"], &[0.1]),
            Err(CsvError::Columns { given: 2, columns: 3, .. })
        ));
        let path = table.finish()?;
        assert_eq!(std::fs::read_to_string(path)?, "model,t,x\n\"a, \"\"b\"\"\",0.1,1e-9\n");
        Ok(std::fs::remove_dir_all(folder)?)
    }

    #[test]
    fn a_file_in_the_place_of_the_folder_is_named() -> Result<(), Box<dyn std::error::Error>> {
        let blocker = folder("blocked");
        std::fs::write(&blocker, "")?;
        let message =
            Csv::create(&blocker, "table", &["t"]).map(|_| ()).map_err(|error| error.to_string());
        let expected =
            format!("cannot create the folder {}: a file stands there", blocker.display());
        assert_eq!(message, Err(expected));
        Ok(std::fs::remove_file(blocker)?)
    }
}
