//! The reader of glTF 2.0 files, `.gltf` and `.glb`.
//!
//! It takes a file as light transport understands it. Everything is in world coordinates, composed in double precision
//! from the numbers in the JSON. What glTF cannot say stands in objects called `pathspace` inside `extras`;
//! `scenes/README.md` documents them. What would change the picture and is not supported is refused by name; what is
//! read differently from what the file says becomes a warning.
//!
//! # Conventions
//! - Candela, lux and nit are read as W/sr, W/m² and W/m²/sr, without the factor 683.
//! - A spot's intensity falls off linearly in the angle from the inner to the outer cone, as in Mitsuba.
//! - Surfaces that are not `doubleSided` absorb on the back; emission leaves the front only, always.
//! - Clipping planes of cameras, ranges of lights, tangents and occlusion are ignored: tangents follow texture coordinates.
//!
//! # Materials without extras
//! glTF's own model ([`bsdf::Gltf`](crate::scene::bsdf::Gltf)) with the layers of its extensions, or Mitsuba's `principled`
//! ([`MaterialModel`]). A non-metal without a specular layer is Lambert's; an unlit one emits its colour and reflects nothing;
//! opacity is a mask around the model. Each is read once for every way in which primitives use it: with colours of vertices or
//! without, with images that lie plainly or mirrored.
//!
//! A mesh's own texture coordinates are the set that its material's normal map follows, else the first that a texture asks for;
//! further sets are attributes.

mod accessor;
mod buffers;
mod camera;
mod container;
mod document;
mod exact;
mod extras;
mod fault;
mod hierarchy;
mod instancing;
mod light;
mod material;
mod primitive;
mod sensors;
mod shapes;
mod surface;
mod tally;
#[cfg(test)]
mod tests;
mod texture;

use std::io::ErrorKind;
use std::path::Path;

use serde::{Deserialize, Serialize};

use self::accessor::Accessors;
use self::document::Document;
use self::extras::SceneExtras;
use self::fault::{Fault, place};
use self::material::Materials;
use self::tally::Tally;
use self::texture::Textures;
use crate::scene::description::SceneDescription;
use crate::scene::error::SceneError;

/// Choices that the file leaves open.
#[derive(Clone, Debug, Default)]
pub struct ReadOptions {
    /// The camera, by its name, its node's name, or its number among the scene's cameras; `None` takes the first.
    pub camera: Option<String>,
    /// What materials without extras become.
    pub materials: MaterialModel,
}

/// The model of scattering that glTF's materials become.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MaterialModel {
    /// glTF's own.
    #[default]
    Gltf,
    /// Mitsuba's `principled`, for comparisons with Mitsuba.
    Principled,
}

/// Reads a scene with its first camera; without a camera `sensor` is `None`.
///
/// # Errors
/// The file is missing, is not glTF, contradicts itself, or needs what is not supported; see [`SceneError`].
pub fn read(path: &Path) -> Result<SceneDescription, SceneError> {
    read_with(path, &ReadOptions::default())
}

/// Reads a scene.
///
/// # Errors
/// As [`read`], and where there is no such camera.
pub fn read_with(path: &Path, options: &ReadOptions) -> Result<SceneDescription, SceneError> {
    let bytes = buffers::read_file(path, u64::MAX).map_err(|error| match error.kind() {
        ErrorKind::NotFound => SceneError::NotFound { file: path.into() },
        _ => SceneError::Unreadable { file: path.into(), cause: error.to_string() },
    })?;
    from_bytes(&bytes, path, options)
}

/// Reads a scene from the bytes of its file; `path` is where the files that it names are looked for.
///
/// # Errors
/// As [`read_with`].
pub fn from_bytes(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<SceneDescription, SceneError> {
    let scene = scene(bytes, path, options).map_err(|fault| fault.in_file(path))?;
    Ok(SceneDescription { name: name_of(path), source: path.into(), ..scene })
}

fn scene(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<SceneDescription, Fault> {
    let chunks = container::split(bytes)?;
    let document = Document::parse(chunks.json)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let buffers = buffers::read(&document.root, chunks.bin, folder)?;
    let accessors = Accessors { root: &document.root, buffers: &buffers };

    let mut tally = Tally::default();
    let number = document.root.scene.as_ref().map_or(0, gltf::json::Index::value);
    let nodes = hierarchy::place_nodes(&document, number)?;
    let materials = Materials::new(Textures::new(&document, &accessors, folder), options.materials);
    let shapes = shapes::read(&document, &accessors, &nodes, materials, &mut tally)?;
    let mut lights = Vec::new();
    for placed in &nodes {
        lights.extend(light::read(&document, placed, &mut tally)?);
    }
    let (sensor, film) = match camera::choose(&document, &nodes, options.camera.as_deref(), &mut tally)? {
        Some((sensor, film)) => (Some(sensor), film),
        None => (None, None),
    };
    let scene = document.exact.scenes.get(number);
    let here = place("scenes", number, None);
    let ours: SceneExtras = extras::read(scene.and_then(|s| s.extras.as_ref()), &here)?;
    if !document.root.animations.is_empty() {
        tally.others.push("animations are ignored: the scene is taken as it stands".into());
    }
    for extension in document.ignored_extensions() {
        tally.others.push(format!("the extension {extension} is ignored"));
    }
    let description = SceneDescription {
        meshes: shapes.meshes,
        spheres: shapes.spheres,
        materials: shapes.materials,
        lights,
        environment: ours.environment.map(Into::into),
        sensor,
        film: film.or(ours.film),
        render: ours.render.unwrap_or_default(),
        reference: ours.reference,
        warnings: tally.sentences(),
        ..SceneDescription::default()
    };
    let meters = sensors::read(&ours.sensors, &description, &here)?;
    Ok(SceneDescription { meters, ..description })
}

/// The file's name without its ending; the folder's for a file called `scene`.
fn name_of(path: &Path) -> String {
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let folder = path.parent().and_then(Path::file_name).filter(|_| stem == "scene");
    folder.map_or(stem, |folder| folder.to_string_lossy().into_owned())
}
