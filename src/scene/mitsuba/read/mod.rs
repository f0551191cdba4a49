//! The reader of Mitsuba's scene format, `.xml` of the versions 3, 2, and 0.5 and 0.6 where the meaning is clear.
//!
//! It takes a file as Mitsuba 3.9.1 does in its RGB variants: the same defaults, the same order of transforms, the same
//! colours for spectra, the same normals for meshes without. Everything is in world coordinates, composed in double
//! precision. What would change the image and is not supported is refused with its line; what cannot, or is read
//! differently, becomes a warning.
//!
//! # Limits
//! Files that a scene names lie in its folder or below. Documents have no types and no entities of their own, at most 64
//! nested elements, 15 nested and 1000 included files, and 256 MiB in all. Instances are copies of their group's
//! triangles, 20 million at most.

mod bsdf;
mod document;
mod emitter;
mod fault;
mod files;
mod fov;
mod ior;
mod mesh;
mod node;
mod number;
mod parameters;
mod props;
mod reader;
mod sensor;
mod shape;
mod spectrum;
mod tables;
#[cfg(test)]
mod tests;
mod texture;
mod transform;
mod tree;
mod upgrade;

use std::path::Path;

use self::document::Document;
use self::fault::{Fault, Result};
use self::files::Files;
use self::parameters::Parameters;
use self::reader::Reader;
use crate::scene::description::SceneDescription;
use crate::scene::error::SceneError;

/// Choices that the file leaves open.
#[derive(Clone, Debug, Default)]
pub struct ReadOptions {
    /// The camera, by its id or its number among the sensors; `None` takes the first.
    pub camera: Option<String>,
    /// Values of the file's parameters by name, which override its defaults.
    pub parameters: Vec<(String, String)>,
}

/// Reads a scene with its first camera; without a camera `sensor` is `None`.
///
/// # Errors
/// The file is missing, is no scene, contradicts itself, or needs what is not supported; see [`SceneError`].
pub fn read(path: &Path) -> std::result::Result<SceneDescription, SceneError> {
    read_with(path, &ReadOptions::default())
}

/// Reads a scene.
///
/// # Errors
/// As [`read`], and where there is no such camera or parameter.
pub fn read_with(path: &Path, options: &ReadOptions) -> std::result::Result<SceneDescription, SceneError> {
    let bytes = Files::new(path).read_xml(path)?;
    from_bytes(&bytes, path, options)
}

/// Reads a scene from the bytes of its file; `path` is where the files that it names are looked for.
///
/// # Errors
/// As [`read_with`].
pub fn from_bytes(
    bytes: &[u8],
    path: &Path,
    options: &ReadOptions,
) -> std::result::Result<SceneDescription, SceneError> {
    Ok(scene(bytes, path, options)?)
}

fn scene(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<SceneDescription> {
    let document = Document::read(bytes, path, Parameters::new(&options.parameters))?;
    if let Some((name, suggestion)) = document.parameters.unused() {
        let problem = format!("it has no parameter {name:?}{suggestion}");
        return Err(Fault::of_file(path, "-D", problem, "give a value to a parameter that the file uses"));
    }
    let scene = Reader::new(&document).run(options.camera.as_deref())?;
    let parameters = document.parameters.known();
    Ok(SceneDescription { name: name_of(path), source: path.into(), parameters, ..scene })
}

/// The file's name without its ending; the folder's for a file called `scene`.
fn name_of(path: &Path) -> String {
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let folder = path.parent().and_then(Path::file_name).filter(|_| stem == "scene");
    folder.map_or(stem, |folder| folder.to_string_lossy().into_owned())
}
