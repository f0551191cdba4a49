//! Everything with a surface: meshes and analytic spheres, with the materials that they use.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use glam::{DAffine3, DVec3};
use gltf::json::Index;

use super::accessor::Accessors;
use super::document::Document;
use super::extras::{self, NodeExtras, SphereExtras};
use super::fault::Fault;
use super::hierarchy::{Placed, node_place};
use super::instancing;
use super::material::{Materials, Use};
use super::primitive::{self, Handedness, Primitive};
use super::surface;
use super::tally::Tally;
use crate::scene::description::{Material, Mesh, Sphere};

/// Instances are copied, so that a small file can ask for more than any memory holds.
const MAX_TRIANGLES: usize = 1 << 28;

/// The surfaces of a scene.
pub(super) struct Shapes {
    pub meshes: Vec<Mesh>,
    pub spheres: Vec<Sphere>,
    pub materials: Vec<Material>,
}

/// Reads the surfaces of all nodes.
pub(super) fn read(
    document: &Document,
    accessors: &Accessors<'_>,
    nodes: &[Placed],
    mut materials: Materials<'_>,
    tally: &mut Tally,
) -> Result<Shapes, Fault> {
    let mut meshes = Vec::new();
    let mut spheres = Vec::new();
    let mut known: HashMap<usize, Vec<Primitive>> = HashMap::new();
    let mut triangles = 0;
    for placed in nodes {
        let here = node_place(document, placed.node);
        let ours: NodeExtras = extras::read(document.exact.nodes[placed.node].extras.as_ref(), &here)?;
        if let Some(sphere) = &ours.sphere {
            spheres.push(read_sphere(document, placed, sphere, &mut materials, tally)?);
            continue;
        }
        let Some(mesh) = document.root.nodes[placed.node].mesh.as_ref().map(Index::value) else { continue };
        refuse_deformed(document, placed.node, mesh, &here)?;
        let primitives = match known.entry(mesh) {
            Entry::Occupied(read_before) => read_before.into_mut(),
            Entry::Vacant(new) => new.insert(primitive::read_mesh(document, accessors, mesh, tally)?),
        };
        let transforms = instancing::transforms(document, accessors, placed)?;
        for (instance, world) in transforms.iter().enumerate() {
            for (number, primitive) in primitives.iter().enumerate() {
                triangles += primitive.triangles.len();
                if triangles > MAX_TRIANGLES {
                    let problem = format!("the scene has more than {MAX_TRIANGLES} triangles");
                    return Err(Fault::invalid(here, problem, "draw fewer instances"));
                }
                let Some(surface) = surface::to_world(primitive, world, &here, tally)? else { continue };
                let mut name = mesh_name(document, placed.node, mesh);
                if transforms.len() > 1 {
                    name += &format!("[{instance}]");
                }
                if primitives.len() > 1 {
                    name += &format!(".{number}");
                }
                let (colours, handedness) = (primitive.has_colours(), primitive.handedness(world));
                let of = Use { material: primitive.material, colours, handedness };
                let material = materials.number(of, tally)?;
                let surface::Surface { positions, normals, triangles } = surface;
                let (texcoords, attributes) = (primitive.texcoords.clone(), primitive.attributes.clone());
                meshes.push(Mesh { name, positions, normals, texcoords, attributes, triangles, material });
            }
        }
    }
    Ok(Shapes { meshes, spheres, materials: materials.used })
}

fn mesh_name(document: &Document, node: usize, mesh: usize) -> String {
    let name = document.root.nodes[node].name.as_ref().or(document.root.meshes[mesh].name.as_ref());
    name.cloned().unwrap_or_else(|| format!("node {node}"))
}

/// Skins and morph targets move vertices.
fn refuse_deformed(document: &Document, node: usize, mesh: usize, here: &str) -> Result<(), Fault> {
    let node = &document.root.nodes[node];
    if node.skin.is_some() {
        return Err(Fault::unsupported(here, "skins", "export the mesh in its pose"));
    }
    let mesh = &document.root.meshes[mesh];
    let has_targets = mesh.primitives.iter().any(|primitive| primitive.targets.is_some());
    let weights = node.weights.as_ref().or(mesh.weights.as_ref());
    if has_targets && weights.is_some_and(|weights| weights.iter().any(|&weight| weight != 0.0)) {
        return Err(Fault::unsupported(here, "morph targets", "export the mesh in its pose"));
    }
    Ok(())
}

fn read_sphere(
    document: &Document,
    placed: &Placed,
    sphere: &SphereExtras,
    materials: &mut Materials<'_>,
    tally: &mut Tally,
) -> Result<Sphere, Fault> {
    let owner = node_place(document, placed.node);
    let here = format!("{owner}.extras.pathspace.sphere");
    let Some(scale) = uniform_scale(&placed.world) else {
        let problem = "its node's scale is not uniform, or zero";
        return Err(Fault::invalid(here, problem, "scale all axes alike, or use a mesh"));
    };
    let radius = sphere.radius * scale;
    if !(radius > 0.0 && radius.is_finite()) {
        return Err(Fault::invalid(here, format!("its radius is {radius}"), "make it positive"));
    }
    let node = &document.root.nodes[placed.node];
    let primitive = node.mesh.as_ref().and_then(|mesh| document.root.meshes[mesh.value()].primitives.first());
    let material = match (&sphere.material, primitive) {
        (Some(reference), _) => Some(materials.find(reference, &here)?),
        (None, Some(primitive)) => primitive.material.as_ref().map(Index::value),
        (None, None) => {
            let remedy = "give it `material`, an index or a name, or give its node a mesh that has one";
            return Err(Fault::invalid(here, "has no material", remedy));
        }
    };
    // On a sphere v runs from pole to pole, to the left of u.
    let of = Use { material, colours: false, handedness: Handedness::Mixed };
    let material = materials.number(of, tally)?;
    let name = node.name.clone().unwrap_or_else(|| format!("node {}", placed.node));
    Ok(Sphere::new(name, placed.world.translation, radius, material))
}

/// The factor by which a transform scales all lengths, where it does so up to the rounding of single precision.
fn uniform_scale(world: &DAffine3) -> Option<f64> {
    const TOLERANCE: f64 = 1e-5;
    let axes = [world.matrix3.x_axis, world.matrix3.y_axis, world.matrix3.z_axis];
    let [x, y, z] = axes;
    let lengths = axes.map(DVec3::length);
    let scale = (lengths[0] + lengths[1] + lengths[2]) / 3.0;
    let alike = lengths.iter().all(|length| (length - scale).abs() <= TOLERANCE * scale);
    let square = [x.dot(y), y.dot(z), z.dot(x)].iter().all(|dot| dot.abs() <= TOLERANCE * scale * scale);
    (scale > 0.0 && alike && square).then_some(scale)
}
