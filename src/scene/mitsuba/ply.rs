//! Triangle meshes as binary PLY files.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use glam::DVec3;

use crate::scene::description::Mesh;

/// Writes positions, and normals where there are any, in single precision, little-endian.
pub(super) fn write(path: &Path, mesh: &Mesh) -> io::Result<()> {
    let mut out = BufWriter::new(File::create(path)?);
    let normals = if mesh.normals.is_some() { "property float nx\nproperty float ny\nproperty float nz\n" } else { "" };
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\n\
         element vertex {}\nproperty float x\nproperty float y\nproperty float z\n{normals}\
         element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        mesh.positions.len(),
        mesh.triangles.len()
    )?;
    for (i, &position) in mesh.positions.iter().enumerate() {
        write_vector(&mut out, position)?;
        if let Some(normals) = &mesh.normals {
            write_vector(&mut out, normals[i])?;
        }
    }
    for triangle in &mesh.triangles {
        out.write_all(&[3])?;
        triangle.iter().try_for_each(|index| out.write_all(&index.to_le_bytes()))?;
    }
    out.flush()
}

fn write_vector(out: &mut impl Write, vector: DVec3) -> io::Result<()> {
    vector.as_vec3().to_array().iter().try_for_each(|value| out.write_all(&value.to_le_bytes()))
}
