//! Primitives: from accessors to triangles in the coordinates of their node.

use glam::DVec3;
use gltf::json::Index;
use gltf::json::mesh::{Mode, Primitive as JsonPrimitive, Semantic};
use gltf::json::validation::Checked;

use super::accessor::Accessors;
use super::fault::{Fault, place};
use super::tally::Tally;

/// The triangles of a primitive in object space.
#[derive(Clone, Debug)]
pub(super) struct Primitive {
    /// Where in the file, for messages.
    pub place: String,
    pub positions: Vec<DVec3>,
    pub normals: Option<Vec<DVec3>>,
    pub triangles: Vec<[u32; 3]>,
    /// Index of the glTF material.
    pub material: Option<usize>,
}

/// Reads the primitives of a mesh that have a surface.
pub(super) fn read_mesh(accessors: &Accessors<'_>, mesh: usize, tally: &mut Tally) -> Result<Vec<Primitive>, Fault> {
    let found = &accessors.root.meshes[mesh];
    let mut primitives = Vec::new();
    for (number, primitive) in found.primitives.iter().enumerate() {
        let here = format!("{}.primitives[{number}]", place("meshes", mesh, found.name.as_deref()));
        primitives.extend(read(accessors, primitive, here, tally)?);
    }
    Ok(primitives)
}

fn read(
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
    if let Some(colours) = attribute(Semantic::Colors(0)) {
        refuse_colours(accessors, colours, &place)?;
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
    let material = primitive.material.as_ref().map(Index::value);
    Ok(Some(compact(Primitive { place, positions, normals, triangles, material })))
}

const EXPORT_AGAIN: &str = "correct the file or export it again";

/// White colours multiply by one; exporters add them unasked.
fn refuse_colours(accessors: &Accessors<'_>, colours: usize, place: &str) -> Result<(), Fault> {
    let user = format!("{place}.COLOR_0");
    let white = if accessors.width(colours, &user)? == 4 {
        accessors.vectors::<4>(colours, &user)?.iter().all(|colour| *colour == [1.0; 4])
    } else {
        accessors.vectors::<3>(colours, &user)?.iter().all(|colour| *colour == [1.0; 3])
    };
    if white {
        return Ok(());
    }
    Err(Fault::unsupported(user, "vertex colours", "export without them, or split the mesh by material"))
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
    Primitive { positions, normals, triangles, ..primitive }
}
