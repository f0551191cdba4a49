//! What can be wrong with the input of a report.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

use crate::film::{FileError, FilmError};

/// Input that no report can be made from.
#[derive(Debug, Error)]
pub enum ReportError {
    /// Two images cannot be compared.
    #[error("an image of {} × {} pixels cannot be compared with a reference of {} × {}; render it in the same size",
            image.0, image.1, reference.0, reference.1)]
    Size {
        /// Width and height of the image.
        image: (u32, u32),
        /// Width and height of the reference.
        reference: (u32, u32),
    },
    /// The reference holds values that are not finite.
    #[error("{count} pixels of the reference are not finite; make another reference")]
    Reference {
        /// How many pixels.
        count: u64,
    },
    /// Pixels or blocks do not fit together.
    #[error(transparent)]
    Film(#[from] FilmError),
    /// A file cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// A file cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// A table is damaged or has other columns.
    #[error("{}: not a usable table: {what}", path.display())]
    Table {
        /// The file.
        path: PathBuf,
        /// What is wrong, with its line.
        what: String,
    },
    /// An array file is damaged or of a kind that is not read.
    #[error("{}: not a usable array: {what}", path.display())]
    Array {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
}
