//! Readers of the mesh files that Mitsuba's scenes refer to: OBJ, PLY, and Mitsuba's own serialized meshes.
//!
//! They take a file as Mitsuba 3 does and give what stands in it: transforms, flipped or missing normals are up to the
//! caller. What a header promises is not believed: memory is bounded by the size of the file, or of what it unpacks to.

mod error;
mod obj;
mod ply;
mod serialized;
#[cfg(test)]
mod tests;

use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::Path;

use glam::{Vec2, Vec3};

use super::description::Attribute;
use error::Fault;

pub use error::MeshError;

/// What kind of file it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Wavefront's text format, `.obj`.
    Obj,
    /// The Polygon File Format, text or binary, `.ply`.
    Ply,
    /// Mitsuba's `.serialized`, which may hold several meshes.
    Serialized {
        /// Which of them, from zero.
        shape_index: usize,
    },
}

/// Choices that the file leaves open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MeshOptions {
    /// Read v as 1 − v. Mitsuba's default for OBJ is true, for PLY false; serialized meshes have no such option.
    pub flip_tex_coords: bool,
}

/// A triangle mesh as its file has it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshData {
    /// Vertex positions, all finite.
    pub positions: Vec<Vec3>,
    /// Shading normals, one per vertex, of any length, where the file has them. Zero where it has none for this vertex or
    /// none that is finite.
    pub normals: Option<Vec<Vec3>>,
    /// Texture coordinates, one per vertex, where the file has them. Zero where it has none for this vertex or none
    /// that is finite.
    pub texcoords: Option<Vec<Vec2>>,
    /// Other values at vertices and faces, named as Mitsuba names them: `vertex_color`, `face_id`, …
    pub attributes: Vec<Attribute>,
    /// Vertex indices, each below the number of positions.
    pub triangles: Vec<[u32; 3]>,
    /// Sentences about what is passed over.
    pub warnings: Vec<String>,
}

/// Vertices of larger files might be more than their indices can count.
const MOST_BYTES: usize = 8 << 30;

/// Reads a mesh.
///
/// # Errors
/// The file is missing or breaks the rules of its format; see [`MeshError`].
pub fn read(path: &Path, format: MeshFormat, options: &MeshOptions) -> Result<MeshData, MeshError> {
    let bytes = read_file(path).map_err(|error| match error.kind() {
        ErrorKind::NotFound => MeshError::NotFound { file: path.into() },
        _ => MeshError::Unreadable { file: path.into(), cause: error.to_string() },
    })?;
    read_bytes(&bytes, path, format, options)
}

/// Reads a mesh from the bytes of a file; `path` is for messages.
///
/// # Errors
/// The bytes break the rules of the format; see [`MeshError`].
pub fn read_bytes(bytes: &[u8], path: &Path, format: MeshFormat, options: &MeshOptions) -> Result<MeshData, MeshError> {
    let mesh = if bytes.len() > MOST_BYTES {
        Err(Fault::new("the file", "is larger than 8 GiB", "split the mesh"))
    } else {
        match format {
            MeshFormat::Obj => obj::read(bytes, options.flip_tex_coords),
            MeshFormat::Ply => ply::read(bytes, options.flip_tex_coords),
            MeshFormat::Serialized { shape_index } => serialized::read(bytes, shape_index),
        }
    };
    mesh.map_err(|fault| fault.in_file(path))
}

/// All bytes of a regular file; a pipe or device could go on for ever.
fn read_file(path: &Path) -> io::Result<Vec<u8>> {
    let file = File::open(path)?;
    let metadata = file.metadata()?;
    if !metadata.is_file() {
        return Err(io::Error::other("it is not a regular file"));
    }
    let mut bytes = Vec::with_capacity(usize::try_from(metadata.len()).unwrap_or(0));
    file.take(metadata.len()).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// What is not finite counts as missing.
fn finite_or_zero<const N: usize>(numbers: [f32; N]) -> [f32; N] {
    if numbers.iter().all(|x| x.is_finite()) { numbers } else { [0.0; N] }
}
