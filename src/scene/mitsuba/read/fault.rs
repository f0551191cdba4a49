//! Errors and warnings of the reader: each knows its file, line and element.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::scene::error::SceneError;

/// Where something stands in the scene's files.
#[derive(Clone, Debug)]
pub(super) struct Place {
    pub file: Arc<Path>,
    pub line: u32,
    /// `<float name="alpha">`.
    pub element: Arc<str>,
}

/// What is wrong, where, and what to do.
#[derive(Clone, Debug)]
pub(super) struct Fault(SceneError);

pub(super) type Result<T> = std::result::Result<T, Fault>;

impl Fault {
    pub(super) fn new(place: &Place, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self(SceneError::InXml {
            file: place.file.to_path_buf(),
            line: place.line,
            element: place.element.to_string(),
            problem: problem.into(),
            remedy: remedy.into(),
        })
    }

    /// A fault of the whole file, or of something that has no element.
    pub(super) fn of_file(file: &Path, place: &str, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self(SceneError::Invalid {
            file: file.into(),
            place: place.into(),
            problem: problem.into(),
            remedy: remedy.into(),
        })
    }

    pub(super) fn unreadable(file: PathBuf, error: &std::io::Error) -> Self {
        Self(match error.kind() {
            std::io::ErrorKind::NotFound => SceneError::NotFound { file },
            _ => SceneError::Unreadable { file, cause: error.to_string() },
        })
    }
}

impl From<Fault> for SceneError {
    fn from(fault: Fault) -> Self {
        fault.0
    }
}

/// What is read differently from what the file says, or not at all; each place once.
#[derive(Clone, Debug, Default)]
pub(super) struct Warnings(Vec<String>);

impl Warnings {
    pub(super) fn add(&mut self, place: &Place, text: impl AsRef<str>) {
        let sentence = format!("{}:{}: {}: {}", place.file.display(), place.line, place.element, text.as_ref());
        if !self.0.contains(&sentence) {
            self.0.push(sentence);
        }
    }

    pub(super) fn into_sentences(self) -> Vec<String> {
        self.0
    }
}
