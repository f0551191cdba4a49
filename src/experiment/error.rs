//! Why an experiment cannot be made.

use thiserror::Error;

use crate::estimator::{RegistryError, SettingsError};
use crate::film::{FileError, FilmError};
use crate::report::ReportError;
use crate::scene::mitsuba::ExportError;

/// Why an experiment cannot be made.
#[derive(Debug, Error)]
pub enum ExperimentError {
    /// What was asked for makes no sense.
    #[error("{0}")]
    Usage(String),
    /// An integrator or its settings.
    #[error(transparent)]
    Registry(#[from] RegistryError),
    /// A setting of another renderer.
    #[error("method {method}: {error}")]
    Setting {
        /// The method.
        method: String,
        /// What is wrong.
        error: SettingsError,
    },
    /// A scene cannot be compared as asked.
    #[error("{0}")]
    Scene(String),
    /// The user has ended it before anything ran.
    #[error("{0}")]
    Stopped(String),
    /// A file cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// A table or array.
    #[error(transparent)]
    Report(#[from] ReportError),
    /// A film.
    #[error(transparent)]
    Film(#[from] FilmError),
    /// A scene that cannot be given to another renderer.
    #[error(transparent)]
    Export(#[from] ExportError),
}

impl ExperimentError {
    /// The user asked for what there is not, as opposed to files that are wrong.
    #[must_use]
    pub fn is_usage(&self) -> bool {
        matches!(self, Self::Usage(_) | Self::Registry(_) | Self::Setting { .. })
    }
}
