use glam::{Vec2, Vec3};

use super::{OBJ, read, read_with};
use crate::scene::mesh_file::MeshFormat::Obj;

#[test]
fn corners_that_are_alike_are_one_vertex_in_the_order_of_the_faces() {
    let mesh = read(OBJ.as_bytes(), Obj);
    let triangles = [[0, 1, 2], [0, 2, 3], [1, 4, 2], [5, 6, 7]];
    assert_eq!(mesh.triangles, triangles);
    assert_eq!(mesh.positions[4], Vec3::new(2.0, 0.5, -0.25));
    assert_eq!(mesh.positions[5], mesh.positions[2]);
    let (normals, texcoords) = (mesh.normals.unwrap(), mesh.texcoords.unwrap());
    assert_eq!((normals[0], normals[5]), (Vec3::new(0.0, 0.0, 2.0), Vec3::new(0.6, 0.0, 0.8)));
    assert_eq!(texcoords[..3], [Vec2::ZERO, Vec2::new(1.0, 0.25), Vec2::ONE]);
    assert_eq!(texcoords[5], Vec2::ZERO);
    let flipped = read_with(OBJ.as_bytes(), Obj, true).unwrap().texcoords.unwrap();
    assert_eq!(flipped[..3], [Vec2::Y, Vec2::new(1.0, 0.75), Vec2::X]);
    assert_eq!(flipped[5], Vec2::ZERO);
}

#[test]
fn what_no_corner_names_is_not_there() {
    let mesh = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvt 0 0\nf 3 2 1", Obj);
    assert_eq!((mesh.normals, mesh.texcoords, mesh.triangles), (None, None, vec![[0, 1, 2]]));
    assert_eq!(mesh.positions, [Vec3::Y, Vec3::X, Vec3::ZERO]);
}

#[test]
fn indices_count_back_and_lines_go_on() {
    let text = "v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nvn 0 0 1\r\nf -3//-1 \\\r\n -2//-1 -1//-1 # all\r\nv 1 1 0\r\nf 2 \\\n4\\\n3\r\n";
    let mesh = read(text.as_bytes(), Obj);
    assert_eq!(mesh.triangles, [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(mesh.positions[3..], [Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y]);
    assert_eq!(mesh.normals.unwrap()[2..4], [Vec3::Z, Vec3::ZERO]);
}

#[test]
fn short_faces_and_empty_files_are_no_triangles() {
    let mesh = read(b"v 0 0 0\nv 1 0 0\nf 1\nf 1 2\nf\nl 1 2\np 1", Obj);
    assert!(mesh.triangles.is_empty());
    assert_eq!(mesh.positions.len(), 2);
    assert_eq!(read(b"", Obj).positions.len(), 0);
    assert_eq!(read(b"\xff\xfe \x00\n#", Obj).positions.len(), 0);
}

#[test]
fn normals_that_are_no_directions_count_as_none() {
    let mesh = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvn nan 0 1\nvt inf 0\nf 1/1/1 2/1/1 3/1/1", Obj);
    assert_eq!((mesh.normals.unwrap()[0], mesh.texcoords.unwrap()[0]), (Vec3::ZERO, Vec2::ZERO));
}

/// 20 000 corners of one vertex, all with other texture coordinates: each is found at once.
#[test]
fn many_corners_of_a_vertex_take_no_time() {
    let mut text = String::from("v 0 0 0\n");
    for i in 0..20_000 {
        text += &format!("vt {i} 0\nf 1/{0} 1/1 1/{0}\n", i + 1);
    }
    let mesh = read(text.as_bytes(), Obj);
    assert_eq!((mesh.positions.len(), mesh.triangles.len()), (20_000, 20_000));
}
