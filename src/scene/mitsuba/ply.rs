//! Triangle meshes as binary PLY files.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use glam::DVec3;

use crate::scene::description::{Attribute, Mesh};

/// Writes positions, and normals, texture coordinates and attributes where there are any, in single precision,
/// little-endian.
pub(super) fn write(path: &Path, mesh: &Mesh) -> io::Result<()> {
    let mut out = BufWriter::new(File::create(path)?);
    let normals = if mesh.normals.is_some() { "property float nx\nproperty float ny\nproperty float nz\n" } else { "" };
    let texcoords = if mesh.texcoords.is_some() { "property float u\nproperty float v\n" } else { "" };
    let per_vertex = || mesh.attributes.iter().filter(|attribute| !attribute.per_face);
    let per_face = || mesh.attributes.iter().filter(|attribute| attribute.per_face);
    let (of_vertices, of_faces) = (properties(per_vertex()), properties(per_face()));
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\n\
         element vertex {}\nproperty float x\nproperty float y\nproperty float z\n{normals}{texcoords}{of_vertices}\
         element face {}\nproperty list uchar uint vertex_indices\n{of_faces}end_header\n",
        mesh.positions.len(),
        mesh.triangles.len()
    )?;
    for (i, &position) in mesh.positions.iter().enumerate() {
        write_vector(&mut out, position)?;
        if let Some(normals) = &mesh.normals {
            write_vector(&mut out, normals[i])?;
        }
        if let Some(texcoords) = &mesh.texcoords {
            write_numbers(&mut out, &texcoords[i].to_array())?;
        }
        per_vertex().try_for_each(|attribute| write_numbers(&mut out, attribute.value(i)))?;
    }
    for (i, triangle) in mesh.triangles.iter().enumerate() {
        out.write_all(&[3])?;
        triangle.iter().try_for_each(|index| out.write_all(&index.to_le_bytes()))?;
        per_face().try_for_each(|attribute| write_numbers(&mut out, attribute.value(i)))?;
    }
    out.flush()
}

fn write_vector(out: &mut impl Write, vector: DVec3) -> io::Result<()> {
    write_numbers(out, &vector.as_vec3().to_array())
}

fn write_numbers(out: &mut impl Write, numbers: &[f32]) -> io::Result<()> {
    numbers.iter().try_for_each(|value| out.write_all(&value.to_le_bytes()))
}

/// Mitsuba reads `NAME_r`, `NAME_g`, … as the attribute NAME.
fn properties<'a>(attributes: impl Iterator<Item = &'a Attribute>) -> String {
    let of = |attribute: &Attribute| {
        let name = &attribute.name;
        let line = |i: usize| format!("property float {name}_{}\n", ["r", "g", "b", "a"][i]);
        (0..attribute.channels.min(4)).map(line).collect::<String>()
    };
    attributes.map(of).collect()
}
