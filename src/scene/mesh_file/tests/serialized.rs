use glam::{Vec2, Vec3};

use super::{library, read, serialized};
use crate::scene::mesh_file::MeshFormat::Serialized;

#[test]
fn both_versions_and_precisions_say_the_same() {
    let first = read(&serialized(4, false, 1.0), Serialized { shape_index: 0 });
    assert_eq!(first.positions[2], Vec3::new(1.0, 1.0, 0.1));
    assert_eq!(first.normals.as_ref().unwrap()[3], Vec3::new(0.6, 0.0, 0.8));
    assert_eq!(first.texcoords.as_ref().unwrap()[3], Vec2::new(0.0, 0.75));
    assert_eq!(first.triangles, [[0, 1, 2], [0, 2, 3]]);
    for (version, double) in [(3, false), (3, true), (4, true)] {
        assert_eq!(read(&serialized(version, double, 1.0), Serialized { shape_index: 0 }), first);
    }
}

#[test]
fn the_dictionary_finds_each_of_several() {
    for version in [3, 4] {
        let file = library(version, &[1.0, 2.0, 3.0].map(|corner| serialized(version, corner == 2.0, corner)));
        for shape_index in 0..3 {
            let mesh = read(&file, Serialized { shape_index });
            assert_eq!(mesh.positions[2].y, shape_index as f32 + 1.0);
        }
    }
}
