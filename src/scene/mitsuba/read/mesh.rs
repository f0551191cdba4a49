//! Meshes: rectangles, cubes and files, with the normals that Mitsuba gives them.

use std::path::PathBuf;

use glam::{DMat3, DMat4, DVec3, Vec2, Vec3};

use super::document::Document;
use super::fault::{Fault, Result, Warnings};
use super::props::Props;
use crate::scene::description::Attribute;
use crate::scene::mesh_file::{self, MeshData, MeshFormat, MeshOptions};

/// A mesh without its material.
#[derive(Clone, Debug)]
pub(super) struct Local {
    pub positions: Vec<DVec3>,
    pub normals: Option<Vec<DVec3>>,
    pub texcoords: Option<Vec<Vec2>>,
    pub attributes: Vec<Attribute>,
    pub triangles: Vec<[u32; 3]>,
}

impl Local {
    /// Transformed; `flip` turns its front around. Under a transform that mirrors, the front stays where normals point if
    /// they are turned `as_normals`; otherwise where the order of the corners says, as in Mitsuba 3.9.1 for meshes
    /// whose file or use has no normals.
    pub(super) fn placed(mut self, to_world: &DMat4, flip: bool, as_normals: bool) -> Self {
        if *to_world != DMat4::IDENTITY {
            self.positions.iter_mut().for_each(|p| *p = to_world.transform_point3(*p));
        }
        if let Some(normals) = &mut self.normals {
            let matrix = DMat3::from_mat4(*to_world).inverse().transpose();
            let sign = if flip { -1.0 } else { 1.0 };
            normals.iter_mut().for_each(|n| *n = (matrix * *n).try_normalize().unwrap_or(DVec3::ZERO) * sign);
        }
        if (as_normals && to_world.determinant() < 0.0) != flip {
            self.triangles.iter_mut().for_each(|[a, _, c]| std::mem::swap(a, c));
        }
        self
    }

    /// Normals of all vertices: the mean of those of the triangles around, by the angles that these have there (Thürmer
    /// and Wüthrich 1998).
    fn smooth(&mut self) {
        let mut sums = vec![DVec3::ZERO; self.positions.len()];
        for triangle in &self.triangles {
            let p = triangle.map(|i| self.positions[i as usize]);
            let Some(normal) = (p[1] - p[0]).cross(p[2] - p[0]).try_normalize() else { continue };
            for k in 0..3 {
                let (to_next, to_last) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
                let angle = libm::atan2(to_next.cross(to_last).length(), to_next.dot(to_last));
                sums[triangle[k] as usize] += normal * angle;
            }
        }
        self.normals = Some(sums.into_iter().map(|sum| sum.try_normalize().unwrap_or(DVec3::X)).collect());
    }
}

/// The square from (−1, −1) to (1, 1) in the plane z = 0, its front on the side of +z.
pub(super) fn rectangle(props: &Props<'_>, to_world: &DMat4) -> Result<Local> {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
    let local = Local {
        positions: corners.map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec(),
        normals: None,
        texcoords: Some([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(u, v)| Vec2::new(u, v)).to_vec()),
        attributes: Vec::new(),
        triangles: vec![[1, 2, 0], [1, 3, 2]],
    };
    flat(local, props, to_world)
}

/// The cube from (−1, −1, −1) to (1, 1, 1).
pub(super) fn cube(props: &Props<'_>, to_world: &DMat4) -> Result<Local> {
    // Corner c has bit k of c for the sign of axis k. Four a side.
    let corners = [1, 5, 4, 0, 3, 2, 6, 7, 1, 3, 7, 5, 5, 7, 6, 4, 4, 6, 2, 0, 3, 1, 0, 2];
    let sign = |c: i32, bit: i32| if c & bit == 0 { -1.0 } else { 1.0 };
    let side = [(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)];
    let local = Local {
        positions: corners.map(|c| DVec3::new(sign(c, 1), sign(c, 2), sign(c, 4))).to_vec(),
        normals: None,
        texcoords: Some((0..24).map(|i| side[i % 4]).map(|(u, v)| Vec2::new(u, v)).collect()),
        attributes: Vec::new(),
        triangles: (0..6).flat_map(|s| [[4 * s, 4 * s + 1, 4 * s + 2], [4 * s + 3, 4 * s, 4 * s + 2]]).collect(),
    };
    flat(local, props, to_world)
}

/// All its faces are flat, with or without normals at the vertices.
fn flat(local: Local, props: &Props<'_>, to_world: &DMat4) -> Result<Local> {
    props.ignore(&["face_normals"]);
    Ok(local.placed(to_world, props.boolean_or("flip_normals", false)?, true))
}

/// A mesh from a file.
pub(super) fn file(document: &Document, props: &Props<'_>, to_world: &DMat4, warnings: &mut Warnings) -> Result<Local> {
    let (format, flip_v) = match props.node.plugin.as_str() {
        "obj" => (MeshFormat::Obj, true),
        "ply" => (MeshFormat::Ply, false),
        _ => {
            let number = props.integer("shape_index")?.unwrap_or(0);
            let Ok(shape_index) = usize::try_from(number) else {
                return Err(props.fault("shape_index", "is negative".into(), "count from 0".into()));
            };
            (MeshFormat::Serialized { shape_index }, false)
        }
    };
    let flip_tex_coords = match format {
        MeshFormat::Serialized { .. } => false,
        _ => props.boolean_or("flip_tex_coords", flip_v)?,
    };
    let Some(name) = props.text("filename")? else { return Err(props.wrong("has no filename", "name a mesh")) };
    let place = props.get("filename").map_or(&props.node.place, |property| &property.place);
    let path: PathBuf = document.files.find(name, place)?;
    let data = mesh_file::read(&path, format, &MeshOptions { flip_tex_coords }).map_err(|error| {
        let text = error.to_string();
        let (problem, remedy) = text.rsplit_once("; ").unwrap_or((&text, "export the mesh again"));
        Fault::new(place, problem, remedy)
    })?;
    let face_normals = props.boolean_or("face_normals", false)?;
    let flip = props.boolean_or("flip_normals", false)?;
    for warning in &data.warnings {
        warnings.add(place, warning);
    }
    let MeshData { positions, normals, texcoords, attributes, triangles, .. } = data;
    let normals = normals.filter(|_| !face_normals);
    let missing = normals.is_none() && !face_normals;
    let local = Local {
        positions: positions.into_iter().map(Vec3::as_dvec3).collect(),
        normals: normals.map(|normals| normals.into_iter().map(Vec3::as_dvec3).collect()),
        texcoords,
        attributes,
        triangles,
    };
    let authored = local.normals.is_some();
    let mut local = local.placed(to_world, flip, authored);
    if missing {
        local.smooth();
    }
    if local.positions.iter().any(|p| !p.is_finite()) {
        return Err(props.fault(
            "to_world",
            "leads to positions that are not finite".into(),
            "use smaller numbers".into(),
        ));
    }
    Ok(local)
}
