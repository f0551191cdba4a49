//! Files that are either whole or not there.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use tempfile::NamedTempFile;

use super::accumulator::Film;
use super::error::FileError;
use super::exr::{NamedLayer, write_exr};
use super::image::Image;
use super::png::write_png;

/// What made an image: written into its metadata and kept with a film's state.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RenderInfo {
    /// Name of the scene.
    pub scene: String,
    /// Name of the integrator.
    pub integrator: String,
    /// All settings that the image depends on, as a JSON value.
    pub settings: serde_json::Value,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Time spent rendering \[s\], without loading and output.
    pub render_seconds: f64,
    /// Processor time of all threads spent rendering \[s\].
    pub cpu_seconds: f64,
    /// Version of the program.
    pub version: String,
}

/// Formats of finished images, told by the ending of the file's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputFormat {
    /// OpenEXR: linear, in single precision, with all layers and metadata.
    Exr,
    /// PNG: tone-mapped to eight bits, for looking.
    Png,
}

impl OutputFormat {
    /// By the ending of `path`, `.exr` or `.png` in any case.
    ///
    /// # Errors
    /// For any other ending.
    pub fn from_path(path: &Path) -> Result<Self, FileError> {
        let ending = path.extension().map(std::ffi::OsStr::to_ascii_lowercase);
        match ending.as_ref().and_then(|ending| ending.to_str()) {
            Some("exr") => Ok(Self::Exr),
            Some("png") => Ok(Self::Png),
            _ => Err(FileError::Ending { path: path.to_owned() }),
        }
    }
}

/// Writes the film's mean in the format that the ending of `path` asks for. Its layers and `info` go into EXR files only,
/// `exposure` \[stops\] acts on PNG files only.
///
/// # Errors
/// When the ending is unknown, or the file cannot be written.
pub fn write_image(path: &Path, film: &Film, info: &RenderInfo, exposure: f64) -> Result<(), FileError> {
    let mean = film.mean_image();
    match OutputFormat::from_path(path)? {
        OutputFormat::Png => write_png(path, &mean, exposure),
        OutputFormat::Exr => {
            let named = |name: String, image: Image| NamedLayer { name, image };
            let with_error = |name: String, mean: Image, error: Option<Image>| {
                let error = error.map(|image| named(format!("{name}.standard_error"), image));
                std::iter::once(named(name, mean)).chain(error)
            };
            let own = film.standard_error_image().map(|image| named("standard_error".to_owned(), image));
            let kept = film.layers().into_iter();
            let kept = kept.flat_map(|layers| layers.layers().into_iter().map(move |layer| (layers, layer)));
            let kept = kept.flat_map(|(layers, layer)| {
                with_error(layer.to_string(), layers.mean_image(layer), layers.standard_error_image(layer))
            });
            let listing = film.layers().map(|layers| serde_json::to_string(&layers.listing())).transpose();
            let listing = listing.map_err(|error| FileError::Write { path: path.to_owned(), source: error.into() })?;
            let texts: Vec<_> = listing.map(|listing| ("layers", listing)).into_iter().collect();
            write_exr(path, &mean, own.into_iter().chain(kept), info, film.passes(), &texts)
        }
    }
}

/// Tells before a long computation whether `path` can be written after it: its folder exists and takes a new file, and
/// it is not itself a folder. Leaves nothing behind.
///
/// # Errors
/// When it cannot.
pub fn check_writable(path: &Path) -> Result<(), FileError> {
    temporary_beside(path).map(drop)
}

/// Writes a file through `write` such that `path` holds either all of it or what it held before, even when the disk is
/// full or the program ends midway: a temporary file in the same folder is written, flushed to the disk, and renamed.
///
/// # Errors
/// When the folder is missing or anything fails on the way.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>,
) -> Result<(), FileError> {
    let failed = |source| FileError::Write { path: path.to_owned(), source };
    let temporary = temporary_beside(path)?;
    let mut writer = BufWriter::new(temporary.as_file());
    write(&mut writer).and_then(|()| writer.flush()).map_err(failed)?;
    drop(writer);
    temporary.as_file().sync_all().map_err(failed)?;
    temporary.persist(path).map_err(|error| failed(error.error))?;
    // The rename itself reaches the disk with the folder; where folders cannot be synced, it does so later.
    if let Ok(folder) = File::open(folder_of(path)) {
        let _ = folder.sync_all();
    }
    Ok(())
}

fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
        _ => PathBuf::from("."),
    }
}

fn temporary_beside(path: &Path) -> Result<NamedTempFile, FileError> {
    if path.is_dir() || path.file_name().is_none() {
        return Err(FileError::IsFolder { path: path.to_owned() });
    }
    let folder = folder_of(path);
    match fs::metadata(&folder) {
        Ok(metadata) if metadata.is_dir() => {}
        _ => return Err(FileError::NoFolder { path: path.to_owned(), folder }),
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(".pathspace-").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // Temporary files are private by default; this one becomes an ordinary file, subject to the user's mask.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(&folder).map_err(|source| FileError::Write { path: path.to_owned(), source })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ending_decides_the_format_and_others_are_refused_with_the_valid_ones() {
        assert_eq!(OutputFormat::from_path(Path::new("a/b.EXR")).unwrap(), OutputFormat::Exr);
        assert_eq!(OutputFormat::from_path(Path::new("b.png")).unwrap(), OutputFormat::Png);
        for name in ["b", "b.jpg", ".exr", "exr"] {
            let message = OutputFormat::from_path(Path::new(name)).unwrap_err().to_string();
            assert!(message.contains(".exr") && message.contains(".png") && !message.contains('\n'), "{message}");
        }
    }

    #[test]
    fn paths_that_cannot_be_written_are_told_beforehand_and_nothing_is_left_behind() {
        let folder = tempfile::tempdir().unwrap();
        check_writable(&folder.path().join("new.exr")).unwrap();
        assert!(matches!(check_writable(folder.path()), Err(FileError::IsFolder { .. })));
        let missing = folder.path().join("no/such/folder.exr");
        assert!(matches!(check_writable(&missing), Err(FileError::NoFolder { .. })));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn a_failed_write_keeps_the_old_file_and_leaves_no_other() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("state.film");
        write_atomically(&path, |file| file.write_all(b"old")).unwrap();
        let result = write_atomically(&path, |file| {
            file.write_all(b"half of the new")?;
            Err(io::Error::from(io::ErrorKind::StorageFull))
        });
        let message = result.unwrap_err().to_string();
        assert!(message.contains("state.film") && !message.contains('\n'), "{message}");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
