//! From what the user calls a scene to the scene.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{anyhow, bail};
use xxhash_rust::xxh3::Xxh3Default;

use super::args::EnvironmentChoice;
use crate::names::did_you_mean;
use crate::scene::description::{EnvironmentDescription, FilmSize, PixelFilter};
use crate::scene::gltf::{self, MaterialModel};
use crate::scene::mitsuba::read as xml;
use crate::scene::texture::{self, Bitmap, Filter, Wrap};
use crate::scene::{LightSelection, Scene, SceneDescription, SceneOptions};

use super::UsageError;

/// A scene in both forms, and what was decided for the user.
#[derive(Debug)]
pub(crate) struct LoadedScene {
    /// What the file says, completed with the camera and the film that apply.
    pub description: SceneDescription,
    /// Ready for tracing.
    pub scene: Scene,
    /// Sentences for the user.
    pub notes: Vec<String>,
}

/// What the user may decide about a scene.
#[derive(Clone, Debug, Default)]
pub(crate) struct LoadOptions {
    /// Camera by name or number.
    pub camera: Option<String>,
    /// Size of the image instead of the scene's.
    pub film: Option<FilmSize>,
    /// Environment instead of the scene's.
    pub environment: Option<EnvironmentChoice>,
    /// Pixel filter instead of the scene's.
    pub filter: Option<PixelFilter>,
    /// How emitters are chosen.
    pub light_selection: LightSelection,
    /// Values of the parameters of an XML scene.
    pub parameters: Vec<(String, String)>,
    /// What glTF's materials become.
    pub materials: MaterialModel,
}

/// Reads and builds the scene that the user calls `word`: a file, a folder, or the name of a folder in `scenes/`.
///
/// # Errors
/// One line that names the file, the place in it, and what to do.
pub(crate) fn load(word: &Path, options: &LoadOptions) -> anyhow::Result<LoadedScene> {
    let file = find(word)?;
    let mut description = read(&file, options)?;
    if let Some(choice) = &options.environment {
        description.environment = Some(environment(choice)?);
    }
    description.filter = options.filter.unwrap_or(description.filter);
    let scene_options = SceneOptions { film: options.film, light_selection: options.light_selection };
    let (scene, notes) = Scene::build(&description, scene_options)?;
    if description.sensor.is_none() {
        description.sensor = description.framing_camera();
    }
    description.film = Some(scene.sensor().film());
    Ok(LoadedScene { description, scene, notes })
}

/// By its ending: Mitsuba's format, or glTF.
fn read(file: &Path, options: &LoadOptions) -> anyhow::Result<SceneDescription> {
    let camera = options.camera.clone();
    if file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("xml")) {
        let parameters = options.parameters.clone();
        return Ok(xml::read_with(file, &xml::ReadOptions { camera, parameters })?);
    }
    if let Some((name, _)) = options.parameters.first() {
        bail!(UsageError(format!("-D {name}: {} is no .xml file and has no parameters", file.display())));
    }
    Ok(gltf::read_with(file, &gltf::ReadOptions { camera, materials: options.materials })?)
}

fn environment(choice: &EnvironmentChoice) -> anyhow::Result<EnvironmentDescription> {
    Ok(match choice {
        EnvironmentChoice::Constant(radiance) => EnvironmentDescription::Constant(*radiance),
        EnvironmentChoice::Image(file) => {
            let (width, height, texels) = texture::read(file, false)?;
            let name = file.display().to_string();
            let (filter, wrap) = (Filter::Bilinear, [Wrap::Repeat, Wrap::Clamp]);
            let bitmap = Bitmap { name, width, height, texels, filter, wrap }.into();
            EnvironmentDescription::Map { bitmap, scale: 1.0, to_world: glam::DMat3::IDENTITY }
        }
    })
}

/// The notes, one line each on stderr.
pub(crate) fn show(notes: &[String]) {
    for note in notes {
        super::complain("note", note);
    }
}

fn find(word: &Path) -> anyhow::Result<PathBuf> {
    if word.is_dir() {
        return in_folder(word);
    }
    let named = Path::new("scenes").join(word);
    let is_name = word.components().count() == 1;
    if !word.exists() && is_name && named.is_dir() {
        return in_folder(&named);
    }
    if !word.exists() && is_name && word.extension().is_none() {
        let names: Vec<String> = fs::read_dir("scenes")
            .into_iter()
            .flatten()
            .flatten()
            .filter(|entry| entry.path().is_dir())
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .collect();
        let suggestion = did_you_mean(&word.to_string_lossy(), names.iter().map(String::as_str));
        bail!("{}: there is no such file, folder, or folder in scenes/{suggestion}", word.display());
    }
    // The reader tells best what is wrong with a file that is not there.
    Ok(word.to_owned())
}

fn in_folder(folder: &Path) -> anyhow::Result<PathBuf> {
    if let Some(file) =
        ["scene.gltf", "scene.glb", "scene.xml"].iter().map(|name| folder.join(name)).find(|file| file.is_file())
    {
        return Ok(file);
    }
    let entries = fs::read_dir(folder).map_err(|error| anyhow!("{}: cannot be read: {error}", folder.display()))?;
    let is_scene = |file: &PathBuf| file.extension().is_some_and(|e| e == "gltf" || e == "glb" || e == "xml");
    let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).filter(is_scene).collect();
    match (files.pop(), files.is_empty()) {
        (Some(file), true) => Ok(file),
        (Some(_), false) => bail!("{}: holds several scenes and none is called scene.gltf; name one", folder.display()),
        (None, _) => {
            bail!("{}: holds no scene; name a .gltf, .glb or .xml file, or a folder with one", folder.display())
        }
    }
}

/// A number that changes with whatever the image depends on in a scene, so that a render goes on with the same scene only.
pub(crate) fn fingerprint(description: &SceneDescription) -> String {
    let mut hash = Xxh3Default::new();
    for mesh in &description.meshes {
        let normals = mesh.normals.iter().flatten();
        for vector in mesh.positions.iter().chain(normals) {
            vector.to_array().iter().for_each(|x| hash.update(&x.to_le_bytes()));
        }
        mesh.texcoords.iter().flatten().for_each(|uv| uv.to_array().iter().for_each(|x| hash.update(&x.to_le_bytes())));
        mesh.triangles.as_flattened().iter().for_each(|index| hash.update(&index.to_le_bytes()));
        for attribute in &mesh.attributes {
            hash.update(attribute.name.as_bytes());
            attribute.values.iter().for_each(|x| hash.update(&x.to_le_bytes()));
        }
        hash.update(format!("{} {} {};", mesh.normals.is_some(), mesh.positions.len(), mesh.material).as_bytes());
    }
    let SceneDescription { spheres, disks, cylinders, materials, lights, environment, sensor, filter, .. } =
        description;
    hash.update(format!("{spheres:?}{disks:?}{cylinders:?}{materials:?}{lights:?}").as_bytes());
    hash.update(format!("{environment:?}{sensor:?}{filter:?}").as_bytes());
    format!("{:016x}", hash.digest())
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec2};

    use super::*;
    use crate::scene::description::{Attribute, Mesh};

    #[test]
    fn the_fingerprint_changes_with_whatever_textures_depend_on() {
        let mesh = Mesh {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
            texcoords: Some(vec![Vec2::ZERO; 3]),
            attributes: vec![Attribute { name: "a".into(), per_face: true, channels: 1, values: vec![0.5] }],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        let of = |change: &dyn Fn(&mut Mesh)| {
            let mut mesh = mesh.clone();
            change(&mut mesh);
            fingerprint(&SceneDescription { meshes: vec![mesh], ..SceneDescription::default() })
        };
        let same = of(&|_| {});
        assert_eq!(same, of(&|_| {}));
        assert_ne!(same, of(&|mesh| mesh.texcoords = Some(vec![Vec2::X; 3])));
        assert_ne!(same, of(&|mesh| mesh.attributes[0].values[0] = 0.25));
    }
}
