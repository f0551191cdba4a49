use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use super::error::ExportError;
use super::material::Materials;
use super::xml::Element;
use super::{light, ply, sensor, shape};
use crate::scene::description::{FilmSize, Mesh, SceneDescription, ShapeIndex};
use crate::scene::texture::Parameter;

/// What the XML file says beyond the scene. A run of Mitsuba may override the integrator and the number of samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExportOptions {
    /// Size of the image in pixels.
    pub film: FilmSize,
    /// Longest path in edges, Mitsuba's `max_depth`; `None` is unlimited.
    pub max_length: Option<u32>,
    /// Length in edges from which Mitsuba's Russian roulette may end a path, at least 1.
    pub rr_depth: u32,
    /// Samples per pixel.
    pub spp: u32,
}

impl Default for ExportOptions {
    /// 256 × 256 pixels, any length, and Mitsuba's own start of Russian roulette.
    fn default() -> Self {
        Self { film: FilmSize { width: 256, height: 256 }, max_length: None, rr_depth: 5, spp: 64 }
    }
}

/// Writes `scene.xml`, `meshes/*.ply` and `textures/*` into `folder`, which is created where it does not exist, and returns the path
/// of the XML file.
///
/// Quantities keep their unit: radiance, intensity and irradiance are written as linear RGB, which Mitsuba's RGB variants
/// use as they are. Vertices are rounded to single precision.
///
/// # Errors
/// Where a file cannot be written, the scene has no camera or refers to what it does not have, or asks for what Mitsuba
/// cannot render: pixels that are not square under a perspective camera, a reflectance outside `[0, 1]`.
pub fn export(scene: &SceneDescription, options: &ExportOptions, folder: &Path) -> Result<PathBuf, ExportError> {
    let integrator = Element::plugin("integrator", "path")
        .integer("max_depth", options.max_length.map_or(-1, i64::from))
        .integer("rr_depth", i64::from(options.rr_depth));
    let mut root = Element::new("scene").with("version", "3.0.0").child(integrator);
    let (sensor, place) = sensor::sensor(scene, options)?;
    let mut sensor = Some(sensor);
    if place.is_none() {
        root = root.children(sensor.take());
    }
    let mut attached =
        |shape: Element, index: ShapeIndex| shape.children(if place == Some(index) { sensor.take() } else { None });
    let mut materials = Materials::new(scene);
    for (index, material) in scene.materials.iter().enumerate() {
        root = root.child(materials.element(material)?.with("id", material_id(index)));
    }

    let meshes = scene.meshes.iter().enumerate().filter(|(_, mesh)| !mesh.triangles.is_empty());
    let files: Vec<_> = meshes.map(|(index, mesh)| (index, mesh_file(index, mesh), mesh)).collect();
    for (index, file, mesh) in &files {
        check_mesh(scene, mesh)?;
        let shape = Element::plugin("shape", "ply")
            .string("filename", file)
            .boolean("face_normals", mesh.normals.is_none())
            .boolean("flip_tex_coords", false);
        let shape = attached(shape, ShapeIndex::Mesh(*index));
        root =
            root.child(with_material(scene, &mut materials, shape, mesh.material, &format!("mesh '{}'", mesh.name))?);
    }
    let SceneDescription { spheres, disks, cylinders, .. } = scene;
    let spheres = spheres.iter().enumerate();
    let spheres = spheres.map(|(i, s)| (ShapeIndex::Sphere(i), "sphere", &s.name, s.material, shape::sphere(s)));
    let disks = disks.iter().enumerate();
    let disks = disks.map(|(i, d)| (ShapeIndex::Disk(i), "disk", &d.name, d.material, shape::disk(d)));
    let cylinders = cylinders.iter().enumerate();
    let cylinders =
        cylinders.map(|(i, c)| (ShapeIndex::Cylinder(i), "cylinder", &c.name, c.material, shape::cylinder(c)));
    for (index, kind, name, material, shape) in spheres.chain(disks).chain(cylinders) {
        let shape = attached(shape, index);
        root = root.child(with_material(scene, &mut materials, shape, material, &format!("{kind} '{name}'"))?);
    }
    for light in &scene.lights {
        root = root.child(light::light(scene, light, materials.images())?);
    }
    if let Some(environment) = &scene.environment {
        root = root.child(light::environment(scene, environment, materials.images())?);
    }

    let mesh_folder = folder.join("meshes");
    fs::create_dir_all(&mesh_folder).map_err(ExportError::io(&mesh_folder))?;
    for (_, file, mesh) in &files {
        let path = folder.join(file);
        ply::write(&path, mesh).map_err(ExportError::io(&path))?;
    }
    materials.write_images(folder)?;
    let path = folder.join("scene.xml");
    let mut out = BufWriter::new(File::create(&path).map_err(ExportError::io(&path))?);
    root.write_document(&mut out).and_then(|()| out.flush()).map_err(ExportError::io(&path))?;
    Ok(path)
}

fn material_id(index: usize) -> String {
    format!("material_{index}")
}

/// A file name that any system takes, whatever the mesh is called.
fn mesh_file(index: usize, mesh: &Mesh) -> String {
    let name: String = mesh.name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).take(40).collect();
    format!("meshes/{index:04}_{name}.ply")
}

/// A shape with the material that it refers to and what that emits.
fn with_material(
    scene: &SceneDescription,
    materials: &mut Materials<'_>,
    shape: Element,
    index: usize,
    place: &str,
) -> Result<Element, ExportError> {
    let Some(material) = scene.materials.get(index) else {
        let problem = format!("refers to material {index}, but there are {}", scene.materials.len());
        return Err(ExportError::invalid(&scene.name, place, problem));
    };
    let shape = shape.child(Element::new("ref").with("id", material_id(index)));
    if !material.emits() {
        return Ok(shape);
    }
    let place = format!("material '{}'", material.name);
    let emitter = Element::plugin("emitter", "area");
    Ok(shape.child(match &material.emission {
        Parameter::Constant(radiance) => {
            light::check_power(scene, &place, *radiance)?;
            emitter.rgb("radiance", *radiance)
        }
        Parameter::Texture(texture) => {
            emitter.child(materials.images().element(texture, true, "radiance", scene, &place)?)
        }
    }))
}

fn check_mesh(scene: &SceneDescription, mesh: &Mesh) -> Result<(), ExportError> {
    let vertices = mesh.positions.len();
    let problem = if mesh.normals.as_ref().is_some_and(|normals| normals.len() != vertices) {
        "has another number of normals than of vertices; give one normal per vertex"
    } else if mesh.texcoords.as_ref().is_some_and(|texcoords| texcoords.len() != vertices) {
        "has another number of texture coordinates than of vertices; give one pair per vertex"
    } else if mesh.triangles.as_flattened().iter().any(|&index| index as usize >= vertices) {
        "has a triangle with a vertex that does not exist; correct its indices"
    } else if mesh.positions.iter().any(|position| !position.as_vec3().is_finite()) {
        "has a position that is no single-precision number; correct or rescale it"
    } else {
        return Ok(());
    };
    Err(ExportError::invalid(&scene.name, format!("mesh '{}'", mesh.name), problem))
}
