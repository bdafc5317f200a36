//! Folders and files, with errors that name the path.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// A folder or file that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot {task} {}: {reason}", path.display())]
pub struct FileError {
    /// What was tried: `create the folder`, `write`.
    pub task: &'static str,
    /// Where.
    pub path: PathBuf,
    /// What the operating system said.
    pub reason: io::Error,
}

impl FileError {
    /// Turns an [`io::Error`] into one that says what was tried and where: `.map_err(FileError::at("write", path))`.
    pub(crate) fn at(task: &'static str, path: &Path) -> impl FnOnce(io::Error) -> FileError {
        move |reason| FileError { task, path: path.to_path_buf(), reason }
    }
}

/// Creates `folder` and the folders above it, unless they exist.
pub(crate) fn create_folder(folder: &Path) -> Result<(), FileError> {
    let made = match folder.metadata() {
        Ok(found) if !found.is_dir() => {
            Err(io::Error::new(io::ErrorKind::AlreadyExists, "a file stands there"))
        }
        _ => fs::create_dir_all(folder),
    };
    made.map_err(FileError::at("create the folder", folder))
}
