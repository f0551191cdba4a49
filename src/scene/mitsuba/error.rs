use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Why a scene could not be written for Mitsuba.
#[derive(Debug, Error)]
pub enum ExportError {
    /// A file or folder could not be written.
    #[error("{}: cannot be written ({source}); choose a folder that can", path.display())]
    Io {
        /// What was to be written.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// Mitsuba has no way to say this.
    #[error("{scene}: {place}: Mitsuba cannot render {what}; {remedy}")]
    Unsupported {
        /// Name of the scene.
        scene: String,
        /// Which part of it.
        place: String,
        /// What that part asks for.
        what: String,
        /// What to change.
        remedy: String,
    },
    /// The description contradicts itself or holds a value that cannot be right.
    #[error("{scene}: {place}: {problem}")]
    Invalid {
        /// Name of the scene.
        scene: String,
        /// Which part of it.
        place: String,
        /// What is wrong with it, and the remedy.
        problem: String,
    },
}

impl ExportError {
    pub(super) fn io(path: &Path) -> impl FnOnce(io::Error) -> Self {
        move |source| Self::Io { path: path.to_owned(), source }
    }

    pub(super) fn unsupported(
        scene: &str,
        place: impl Into<String>,
        what: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self::Unsupported { scene: scene.to_owned(), place: place.into(), what: what.into(), remedy: remedy.into() }
    }

    pub(super) fn invalid(scene: &str, place: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::Invalid { scene: scene.to_owned(), place: place.into(), problem: problem.into() }
    }
}
