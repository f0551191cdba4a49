//! Primitives: from accessors to triangles in the coordinates of their node.

use glam::{DAffine3, DVec3, Vec2};
use gltf::json::Index;
use gltf::json::mesh::{Mode, Primitive as JsonPrimitive, Semantic};
use gltf::json::validation::Checked;

use super::accessor::Accessors;
use super::document::Document;
use super::fault::{Fault, place};
use super::material;
use super::tally::Tally;
use super::texture::{COLOURS, coordinates_name};
use crate::scene::description::Attribute;

/// The triangles of a primitive in object space.
#[derive(Clone, Debug)]
pub(super) struct Primitive {
    /// Where in the file, for messages.
    pub place: String,
    pub positions: Vec<DVec3>,
    pub normals: Option<Vec<DVec3>>,
    /// The set of texture coordinates that the material's tangents follow, where the material has textures.
    pub texcoords: Option<Vec<Vec2>>,
    /// The other sets that it asks for, and the colours of the vertices.
    pub attributes: Vec<Attribute>,
    pub triangles: Vec<[u32; 3]>,
    /// Index of the glTF material.
    pub material: Option<usize>,
}

/// How texture coordinates lie on a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Handedness {
    /// Images are not mirrored: v runs to the right of u, seen from the front.
    Plain,
    /// Somewhere they are.
    Mixed,
}

impl Primitive {
    /// The primitive has colours at its vertices.
    pub(super) fn has_colours(&self) -> bool {
        self.attributes.iter().any(|attribute| attribute.name == COLOURS)
    }

    /// How its texture coordinates lie once a transform has moved it.
    pub(super) fn handedness(&self, world: &DAffine3) -> Handedness {
        let mirrors = world.matrix3.determinant() < 0.0;
        let plain = |texcoords: &Vec<Vec2>| {
            self.triangles.iter().all(|corners| {
                let [a, b, c] = corners.map(|i| texcoords[i as usize].as_dvec2());
                let area = (b - a).perp_dot(c - a);
                if mirrors { area >= 0.0 } else { area <= 0.0 }
            })
        };
        if self.texcoords.as_ref().is_none_or(plain) { Handedness::Plain } else { Handedness::Mixed }
    }
}

/// Reads the primitives of a mesh that have a surface.
pub(super) fn read_mesh(
    document: &Document,
    accessors: &Accessors<'_>,
    mesh: usize,
    tally: &mut Tally,
) -> Result<Vec<Primitive>, Fault> {
    let found = &accessors.root.meshes[mesh];
    let mut primitives = Vec::new();
    for (number, primitive) in found.primitives.iter().enumerate() {
        let here = format!("{}.primitives[{number}]", place("meshes", mesh, found.name.as_deref()));
        primitives.extend(read(document, accessors, primitive, here, tally)?);
    }
    Ok(primitives)
}

fn read(
    document: &Document,
    accessors: &Accessors<'_>,
    primitive: &JsonPrimitive,
    place: String,
    tally: &mut Tally,
) -> Result<Option<Primitive>, Fault> {
    let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).map(Index::value);
    let Some(positions) = attribute(Semantic::Positions) else {
        tally.without_positions += 1;
        return Ok(None);
    };
    let Checked::Valid(mode) = primitive.mode else {
        return Err(Fault::invalid(place, "its mode is unknown", EXPORT_AGAIN));
    };
    if matches!(mode, Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
        tally.points_and_lines += 1;
        return Ok(None);
    }
    let positions = accessors.vectors::<3>(positions, &format!("{place}.POSITION"))?;
    let positions: Vec<DVec3> = positions.into_iter().map(DVec3::from).collect();
    if let Some(bad) = positions.iter().position(|p| !p.is_finite()) {
        let problem = format!("vertex {bad} is at {}", positions[bad]);
        return Err(Fault::invalid(format!("{place}.POSITION"), problem, "remove the vertex or export again"));
    }
    let normals = match attribute(Semantic::Normals) {
        Some(normals) => {
            let normals = accessors.vectors::<3>(normals, &format!("{place}.NORMAL"))?;
            if normals.len() != positions.len() {
                let problem = format!("{} normals for {} vertices", normals.len(), positions.len());
                return Err(Fault::invalid(place, problem, EXPORT_AGAIN));
            }
            Some(normals.into_iter().map(DVec3::from).collect())
        }
        None => None,
    };
    let material = primitive.material.as_ref().map(Index::value);
    let vertices = positions.len();
    let mut texcoords = None;
    let mut attributes = Vec::new();
    for (number, set) in material::coordinate_sets(document, material).into_iter().enumerate() {
        let found = u32::try_from(set).ok().and_then(|set| attribute(Semantic::TexCoords(set)));
        let values = match found {
            Some(accessor) => coordinates(accessors, accessor, vertices, &format!("{place}.TEXCOORD_{set}"))?,
            None => {
                tally.without_coordinates += 1;
                vec![Vec2::ZERO; vertices]
            }
        };
        if number == 0 {
            texcoords = Some(values);
        } else {
            let values = values.iter().flat_map(|uv| [uv.x, uv.y, 0.0]).collect();
            attributes.push(Attribute { name: coordinates_name(set), per_face: false, channels: 3, values });
        }
    }
    if let Some(accessor) = attribute(Semantic::Colors(0)) {
        attributes.extend(colours(accessors, accessor, vertices, &format!("{place}.COLOR_0"))?);
    }
    let indices = match &primitive.indices {
        Some(indices) => accessors.indices(indices.value(), &format!("{place}.indices"))?,
        None => (0..positions.len() as u64).map(|i| i as u32).collect(),
    };
    if let Some(bad) = indices.iter().position(|&index| index as usize >= positions.len()) {
        let problem =
            format!("index {} at {bad} is out of range, there are {} vertices", indices[bad], positions.len());
        return Err(Fault::invalid(format!("{place}.indices"), problem, EXPORT_AGAIN));
    }
    let triangles = triangles(mode, &indices, &place)?;
    Ok(Some(compact(Primitive { place, positions, normals, texcoords, attributes, triangles, material })))
}

const EXPORT_AGAIN: &str = "correct the file or export it again";

fn coordinates(accessors: &Accessors<'_>, accessor: usize, vertices: usize, user: &str) -> Result<Vec<Vec2>, Fault> {
    let values = accessors.vectors::<2>(accessor, user)?;
    check_length(values.len(), vertices, user)?;
    Ok(values.into_iter().map(|[u, v]| Vec2::new(u as f32, v as f32)).collect())
}

/// Colours of the vertices; `None` where all are white, which exporters add unasked.
fn colours(
    accessors: &Accessors<'_>,
    accessor: usize,
    vertices: usize,
    user: &str,
) -> Result<Option<Attribute>, Fault> {
    let channels = accessors.width(accessor, user)?;
    let values: Vec<f64> = if channels == 4 {
        accessors.vectors::<4>(accessor, user)?.into_iter().flatten().collect()
    } else {
        accessors.vectors::<3>(accessor, user)?.into_iter().flatten().collect()
    };
    let channels = if channels == 4 { 4 } else { 3 };
    check_length(values.len() / channels, vertices, user)?;
    if values.iter().all(|&value| value == 1.0) {
        return Ok(None);
    }
    let values = values.into_iter().map(|value| value as f32).collect();
    Ok(Some(Attribute { name: COLOURS.into(), per_face: false, channels, values }))
}

fn check_length(found: usize, vertices: usize, user: &str) -> Result<(), Fault> {
    if found == vertices {
        return Ok(());
    }
    Err(Fault::invalid(user, format!("{found} values for {vertices} vertices"), EXPORT_AGAIN))
}

/// The corners of every triangle, counter-clockwise from the front (glTF 2.0, section 3.7.2.1).
fn triangles(mode: Mode, indices: &[u32], place: &str) -> Result<Vec<[u32; 3]>, Fault> {
    let whole = if mode == Mode::Triangles { indices.len().is_multiple_of(3) } else { indices.len() >= 3 };
    if !whole {
        let problem = format!("{} corners do not make whole triangles", indices.len());
        return Err(Fault::invalid(place, problem, EXPORT_AGAIN));
    }
    Ok(match mode {
        Mode::TriangleStrip => {
            let corners = indices.windows(3).enumerate();
            corners.map(|(i, v)| if i % 2 == 0 { [v[0], v[1], v[2]] } else { [v[0], v[2], v[1]] }).collect()
        }
        Mode::TriangleFan => indices[1..].windows(2).map(|v| [v[0], v[1], indices[0]]).collect(),
        _ => indices.chunks_exact(3).map(|v| [v[0], v[1], v[2]]).collect(),
    })
}

/// Leaves out vertices that no triangle uses: primitives often share one array.
fn compact(primitive: Primitive) -> Primitive {
    let mut number = vec![None; primitive.positions.len()];
    let mut kept = Vec::new();
    let mut renumbered = |old: u32| {
        *number[old as usize].get_or_insert_with(|| {
            kept.push(old as usize);
            kept.len() as u32 - 1
        })
    };
    let triangles = primitive.triangles.iter().map(|corners| corners.map(&mut renumbered)).collect();
    let positions = kept.iter().map(|&old| primitive.positions[old]).collect();
    let normals = primitive.normals.map(|normals| kept.iter().map(|&old| normals[old]).collect());
    let texcoords = primitive.texcoords.map(|texcoords| kept.iter().map(|&old| texcoords[old]).collect());
    let pick = |attribute: Attribute| {
        let values = kept.iter().flat_map(|&old| attribute.value(old).to_vec()).collect();
        Attribute { values, ..attribute }
    };
    let attributes = primitive.attributes.into_iter().map(pick).collect();
    Primitive { positions, normals, texcoords, attributes, triangles, ..primitive }
}
