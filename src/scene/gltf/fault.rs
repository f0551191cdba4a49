//! Errors as the inner modules raise them: they know the place, the caller knows the file.

use std::path::Path;

use crate::scene::error::SceneError;

/// What is wrong, and where in the file.
#[derive(Clone, Debug)]
pub(super) enum Fault {
    /// The file is of some other kind.
    NotGltf(String),
    /// The file contradicts itself or the glTF specification.
    Invalid { place: String, problem: String, remedy: String },
    /// The file is valid but needs something that does not exist here yet; `feature` is a plural.
    Unsupported { place: String, feature: String, remedy: String },
}

impl Fault {
    pub(super) fn invalid(place: impl Into<String>, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::Invalid { place: place.into(), problem: problem.into(), remedy: remedy.into() }
    }

    pub(super) fn unsupported(place: impl Into<String>, feature: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::Unsupported { place: place.into(), feature: feature.into(), remedy: remedy.into() }
    }

    pub(super) fn in_file(self, file: &Path) -> SceneError {
        let file = file.to_path_buf();
        match self {
            Self::NotGltf(problem) => SceneError::NotGltf { file, problem },
            Self::Invalid { place, problem, remedy } => SceneError::Invalid { file, place, problem, remedy },
            Self::Unsupported { place, feature, remedy } => SceneError::Unsupported { file, place, feature, remedy },
        }
    }
}

/// `nodes[3] "Lamp"`: where in the file, by index and, where there is one, by name.
pub(super) fn place(array: &str, index: usize, name: Option<&str>) -> String {
    match name {
        Some(name) => format!("{array}[{index}] {name:?}"),
        None => format!("{array}[{index}]"),
    }
}
