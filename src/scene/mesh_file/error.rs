//! What can be wrong with a mesh file, each told in one line.

use std::path::{Path, PathBuf};

use thiserror::Error;

/// Why a mesh could not be read. Every message is one line, `FILE: place: what is wrong; what to do`.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum MeshError {
    /// There is no such file.
    #[error("{}: there is no such file; check the path", line(file))]
    NotFound {
        /// The path as given.
        file: PathBuf,
    },
    /// The file is there but cannot be read.
    #[error("{}: cannot be read ({}); check that it is a file and that you may read it", line(file), plain(cause))]
    Unreadable {
        /// The path as given.
        file: PathBuf,
        /// What the operating system says.
        cause: String,
    },
    /// What the file says cannot be.
    #[error("{}: {}: {}; {}", line(file), plain(place), plain(problem), plain(remedy))]
    Invalid {
        /// The path as given.
        file: PathBuf,
        /// Where in the file: a line, an element or a byte.
        place: String,
        /// What is wrong.
        problem: String,
        /// What to do.
        remedy: String,
    },
}

/// An error as the readers raise it: they know the place, the caller knows the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Fault {
    pub place: String,
    pub problem: String,
    pub remedy: String,
}

impl Fault {
    pub fn new(place: impl Into<String>, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { place: place.into(), problem: problem.into(), remedy: remedy.into() }
    }

    pub fn in_file(self, file: &Path) -> MeshError {
        let Self { place, problem, remedy } = self;
        MeshError::Invalid { file: file.into(), place, problem, remedy }
    }
}

fn line(file: &Path) -> String {
    plain(&file.display().to_string())
}

/// Names from a file may hold line breaks, a message may not.
fn plain(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}
