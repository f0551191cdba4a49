//! What the fuzz targets have in common: files that scenes may name, and what holds for every mesh that is read.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use pathspace::scene::SceneDescription;
use pathspace::scene::mesh_file::{MeshFormat, MeshOptions, read_bytes};
use tempfile::TempDir;

/// One triangle.
const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                   element face 1\nproperty list uchar int vertex_index\nend_header\n0 0 0 1 0 0 0 1 0\n3 0 1 2\n";

/// A PNG of one grey pixel.
const PNG: [u8; 67] = [
    0x89, 0x50, 0x4E, 0x47, 0x0D, 0x0A, 0x1A, 0x0A, 0x00, 0x00, 0x00, 0x0D, 0x49, 0x48, 0x44, 0x52, 0x00, 0x00, 0x00,
    0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x00, 0x00, 0x00, 0x00, 0x3A, 0x7E, 0x9B, 0x55, 0x00, 0x00, 0x00, 0x0A, 0x49,
    0x44, 0x41, 0x54, 0x78, 0x9C, 0x63, 0x68, 0x00, 0x00, 0x00, 0x82, 0x00, 0x81, 0x77, 0xCD, 0x72, 0xB6, 0x00, 0x00,
    0x00, 0x00, 0x49, 0x45, 0x4E, 0x44, 0xAE, 0x42, 0x60, 0x82,
];

static FOLDER: LazyLock<TempDir> = LazyLock::new(|| {
    let folder = tempfile::tempdir().expect("there is room for temporary files");
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).expect("it can be written");
    write("a.obj", OBJ.as_bytes());
    write("a.ply", PLY.as_bytes());
    write("a.png", &PNG);
    write("a.xml", b"<scene version='3.0.0'><bsdf type='diffuse' id='included'/></scene>");
    write("a.spd", b"400 0.5\n700 1\n");
    write("a.bin", &[0; 256]);
    folder
});

/// Where a scene of this name lies, among `a.obj`, `a.ply`, `a.png`, `a.xml`, `a.spd` and `a.bin`.
pub fn path(name: &str) -> PathBuf {
    FOLDER.path().join(name)
}

/// Reads a mesh; what is read must hold together.
pub fn mesh(bytes: &[u8], format: MeshFormat, flip_tex_coords: bool) {
    let Ok(mesh) = read_bytes(bytes, Path::new("a"), format, &MeshOptions { flip_tex_coords }) else { return };
    let vertices = mesh.positions.len();
    assert!(mesh.positions.iter().all(|p| p.is_finite()));
    assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < vertices));
    assert!(mesh.normals.is_none_or(|all| all.len() == vertices && all.iter().all(|n| n.is_finite())));
    assert!(mesh.texcoords.is_none_or(|all| all.len() == vertices && all.iter().all(|t| t.is_finite())));
    for attribute in &mesh.attributes {
        let count = if attribute.per_face { mesh.triangles.len() } else { vertices };
        assert_eq!(attribute.values.len(), count * attribute.channels);
    }
}

/// What every scene that is read keeps.
pub fn scene(scene: &SceneDescription) {
    for mesh in &scene.meshes {
        let vertices = mesh.positions.len();
        assert!(mesh.material < scene.materials.len());
        assert!(mesh.positions.iter().all(|p| p.is_finite()));
        assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < vertices));
        assert!(mesh.normals.as_ref().is_none_or(|all| all.len() == vertices));
        assert!(mesh.texcoords.as_ref().is_none_or(|all| all.len() == vertices));
    }
}
