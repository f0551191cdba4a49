//! What can be wrong with a scene file, each told in one line.

use std::path::{Path, PathBuf};

use thiserror::Error;

/// Why a scene could not be read. Every message is one line, `FILE: place: what is wrong; what to do`.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum SceneError {
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
    /// The file is of some other kind.
    #[error("{}: is not glTF: {}; give a .gltf or .glb file of glTF 2.0", line(file), plain(problem))]
    NotGltf {
        /// The path as given.
        file: PathBuf,
        /// What speaks against it.
        problem: String,
    },
    /// The file is of the right kind, but what it says cannot be.
    #[error("{}: {}: {}; {}", line(file), plain(place), plain(problem), plain(remedy))]
    Invalid {
        /// The path as given.
        file: PathBuf,
        /// Where in the file, as a path in its JSON.
        place: String,
        /// What is wrong.
        problem: String,
        /// What to do.
        remedy: String,
    },
    /// The file is valid but needs something that does not exist here yet.
    #[error("{}: {}: {} are not supported yet; {}", line(file), plain(place), plain(feature), plain(remedy))]
    Unsupported {
        /// The path as given.
        file: PathBuf,
        /// Where in the file, as a path in its JSON.
        place: String,
        /// Name of the missing feature, in the plural.
        feature: String,
        /// What to do.
        remedy: String,
    },
    /// An XML file says what cannot be, or needs what does not exist here.
    #[error("{}:{line}: {}: {}; {}", self::line(file), plain(element), plain(problem), plain(remedy))]
    InXml {
        /// The file, which may be one that the scene includes.
        file: PathBuf,
        /// Its line, from 1 on.
        line: u32,
        /// The element, `<float name="alpha">`.
        element: String,
        /// What is wrong.
        problem: String,
        /// What to do.
        remedy: String,
    },
}

fn line(file: &Path) -> String {
    plain(&file.display().to_string())
}

/// Names from a file may hold line breaks, a message may not.
fn plain(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}
