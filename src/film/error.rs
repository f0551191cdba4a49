//! What can be wrong with a film or with a file that holds one.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

/// Pixels that do not fit together.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum FilmError {
    /// No pixels, or more than fit into memory.
    #[error(
        "an image of {width} × {height} pixels cannot be rendered; both sides must be at least 1 and their product \
             at most 2^28"
    )]
    Size {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// A buffer has another number of pixels, or of blocks, than the film.
    #[error("{found} {what} where {expected} were expected")]
    Count {
        /// What was counted.
        what: &'static str,
        /// What the film has.
        expected: usize,
        /// What was given.
        found: usize,
    },
    /// Two films, or their blocks, differ in size or mask.
    #[error("films of different size or mask cannot be put together; render both with the same film settings")]
    Incompatible,
    /// Layers would take more memory than they may.
    #[error(
        "{layers} layers of {width} × {height} pixels need {:.3} GiB at {passes} samples per pixel, and {:.3} GiB are allowed",
        gibibytes(*needed),
        gibibytes(*limit)
    )]
    LayerMemory {
        /// Layers of images, without those of standard errors.
        layers: usize,
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// Passes with the one that did not fit.
        passes: u64,
        /// Bytes for all of them.
        needed: u64,
        /// Bytes allowed.
        limit: u64,
    },
}

fn gibibytes(bytes: u64) -> f64 {
    bytes as f64 / f64::from(1 << 30)
}

/// A file that cannot be read, written or understood.
#[derive(Debug, Error)]
pub enum FileError {
    /// The system refused to write.
    #[error("{}: cannot be written: {source}; any earlier version of the file is kept", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// The system refused to read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// The folder that should hold the file is missing.
    #[error("{}: the folder '{}' does not exist; make it first or choose another", path.display(), folder.display())]
    NoFolder {
        /// The file.
        path: PathBuf,
        /// Its folder.
        folder: PathBuf,
    },
    /// The path is a folder.
    #[error("{}: is a folder; give the name of a file", path.display())]
    IsFolder {
        /// The path.
        path: PathBuf,
    },
    /// The ending of an image's name says no known format.
    #[error("{}: unknown image format; the name must end with .exr (linear, all layers) or .png (for looking)", path.display())]
    Ending {
        /// The file.
        path: PathBuf,
    },
    /// The film state is damaged or is something else.
    #[error("{}: not a usable film state: {what}; restore a copy or render anew", path.display())]
    State {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// The film state was written by another version of this library.
    #[error("{}: film state of format {found}, and this version reads format {expected}; render anew", path.display())]
    Version {
        /// The file.
        path: PathBuf,
        /// The file's format.
        found: u64,
        /// The one that can be read.
        expected: u64,
    },
    /// The EXR file is damaged, or is none, or holds no colours.
    #[error("{}: not a usable EXR image: {what}", path.display())]
    Exr {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// A layer cannot be written under its name.
    #[error("{}: layer '{layer}' cannot be written: {what}", path.display())]
    Layer {
        /// The file.
        path: PathBuf,
        /// The layer's name.
        layer: String,
        /// What is wrong.
        what: &'static str,
    },
}
