//! Mesh files of all kinds, written here or found beside the repository.

mod bad_files;
mod by_mitsuba;
mod mutations;
mod obj;
mod ply;
mod serialized;

use std::path::Path;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use std::io::Write;

use super::{MeshData, MeshFormat, MeshOptions, read_bytes};

const OBJ: &str = "# a square, a triangle that shares an edge, and what is passed over
mtllib none.mtl
o thing
v 0 0 0
v 1 0 0 0.5 0.5 0.5
v 1 1 0
v\t0 1 0
v 2e0 .5 -0.25
vt 0 0
vt 1 0.25
vt 1 1 0
vt 0 1
vn 0 0 2
vn 0.6 0 0.8
g one
usemtl stone
s 1
f 1/1/1 2/2/1 3/3/1 4/4/1
f 2/2/1 5/1/2 3/3/1
f 3//2 4//2 1//2
";

fn read(bytes: &[u8], format: MeshFormat) -> MeshData {
    read_with(bytes, format, false).unwrap()
}

fn read_with(bytes: &[u8], format: MeshFormat, flip_tex_coords: bool) -> Result<MeshData, String> {
    let name = match format {
        MeshFormat::Obj => "a.obj",
        MeshFormat::Ply => "a.ply",
        MeshFormat::Serialized { .. } => "a.serialized",
    };
    let mesh = read_bytes(bytes, Path::new(name), format, &MeshOptions { flip_tex_coords });
    mesh.map_err(|error| error.to_string()).inspect(check).inspect_err(|error| {
        assert!(error.starts_with(&format!("{name}: ")) && error.contains("; "), "{error}");
        assert!(!error.contains('\n') && error.len() < 400, "{error}");
    })
}

/// What every mesh that is read keeps.
fn check(mesh: &MeshData) {
    let vertices = mesh.positions.len();
    assert!(mesh.positions.iter().all(|p| p.is_finite()));
    assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < vertices));
    if let Some(normals) = &mesh.normals {
        assert!(normals.len() == vertices && normals.iter().all(|n| n.is_finite()));
    }
    if let Some(texcoords) = &mesh.texcoords {
        assert!(texcoords.len() == vertices && texcoords.iter().all(|t| t.is_finite()));
    }
    for attribute in &mesh.attributes {
        let count = if attribute.per_face { mesh.triangles.len() } else { vertices };
        assert_eq!(attribute.values.len(), count * attribute.channels);
    }
}

/// A PLY file in text: the properties of vertices and faces besides positions and corners, rows of both.
fn ply(vertex: &str, vertices: &[&str], face: &str, faces: &[&str]) -> String {
    let properties =
        |of: &str| of.split(", ").filter(|p| !p.is_empty()).fold(String::new(), |all, p| all + "property " + p + "\n");
    format!(
        "ply\nformat ascii 1.0\ncomment none\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n{}\
         element face {}\nproperty list uchar int vertex_indices\n{}end_header\n{}\n{}\n",
        vertices.len(),
        properties(vertex),
        faces.len(),
        properties(face),
        vertices.join("\n"),
        faces.join("\n"),
    )
}

/// A serialized mesh: two triangles of a square with normals and texture coordinates.
fn serialized(version: u16, double: bool, corner: f64) -> Vec<u8> {
    let mut data = Vec::new();
    let flags: u32 = 0x1 | 0x2 | 0x8 | if double { 0x2000 } else { 0x1000 };
    data.extend(flags.to_le_bytes());
    if version == 4 {
        data.extend(b"square\0");
    }
    data.extend(4_u64.to_le_bytes());
    data.extend(2_u64.to_le_bytes());
    let mut number = |x: f64| match double {
        true => data.extend(x.to_le_bytes()),
        false => data.extend((x as f32).to_le_bytes()),
    };
    [0.0, 0.0, 0.1, 1.0, 0.0, 0.1, 1.0, corner, 0.1, 0.0, 1.0, 0.1].into_iter().for_each(&mut number);
    [0.0, 0.0, 1.0].repeat(3).into_iter().chain([0.6, 0.0, 0.8]).for_each(&mut number);
    [0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.75].into_iter().for_each(&mut number);
    [0.5; 12].into_iter().for_each(&mut number);
    for index in [0_u32, 1, 2, 0, 2, 3] {
        data.extend(index.to_le_bytes());
    }
    let mut file = [0x041C_u16.to_le_bytes(), version.to_le_bytes()].concat();
    file.extend(packed(&data));
    file
}

fn packed(data: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(data).unwrap();
    encoder.finish().unwrap()
}

/// Several meshes in a file, with the dictionary.
fn library(version: u16, meshes: &[Vec<u8>]) -> Vec<u8> {
    let mut file = Vec::new();
    let mut dictionary = Vec::new();
    for mesh in meshes {
        match version {
            3 => dictionary.extend((file.len() as u32).to_le_bytes()),
            _ => dictionary.extend((file.len() as u64).to_le_bytes()),
        }
        file.extend(mesh);
    }
    file.extend(dictionary);
    file.extend((meshes.len() as u32).to_le_bytes());
    file
}
