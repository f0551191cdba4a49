use glam::{Vec2, Vec3};

use super::{ply, read, read_with};
use crate::scene::mesh_file::MeshData;
use crate::scene::mesh_file::MeshFormat::Ply;

const SQUARE: [&str; 4] = ["0 0 0", "1 0 0", "1 1 0", "0 1 0.1"];

fn names(mesh: &MeshData) -> Vec<(&str, usize)> {
    mesh.attributes.iter().map(|a| (&*a.name, a.channels)).collect()
}

#[test]
fn polygons_are_fans_and_share_what_their_face_has() {
    let text = ply("", &SQUARE, "float id_0", &["4 0 1 2 3 7", "3 3 2 1 8", "2 0 1 9"]);
    let mesh = read(text.as_bytes(), Ply);
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [3, 2, 1]]);
    assert_eq!(mesh.positions[3], Vec3::new(0.0, 1.0, 0.1));
    assert_eq!(names(&mesh), [("face_id", 1)]);
    assert!(mesh.attributes[0].per_face);
    assert_eq!(mesh.attributes[0].values, [7.0, 7.0, 8.0]);
}

#[test]
fn texture_coordinates_have_three_names() {
    for names in ["float u, float v", "float texture_u, float texture_v", "float s, float t"] {
        let text = ply(names, &["0 0 0 0.25 1", "1 0 0 0 0", "0 1 0 nan 0"], "", &["3 0 1 2"]);
        let read = |flip| read_with(text.as_bytes(), Ply, flip).unwrap().texcoords.unwrap();
        assert_eq!(read(false), [Vec2::new(0.25, 1.0), Vec2::ZERO, Vec2::ZERO]);
        assert_eq!(read(true)[..2], [Vec2::new(0.25, 0.0), Vec2::new(0.0, 1.0)]);
    }
}

#[test]
fn all_encodings_say_the_same() {
    let kinds = ["char", "uchar", "short", "ushort", "int", "uint", "long", "ulong", "half", "float", "double"];
    let values: [&[u8]; 11] = [
        &(-3_i8).to_le_bytes(),
        &[200],
        &(-300_i16).to_le_bytes(),
        &50000_u16.to_le_bytes(),
        &(-70000_i32).to_le_bytes(),
        &3_000_000_000_u32.to_le_bytes(),
        &(-5_i64).to_le_bytes(),
        &(1_u64 << 63).to_le_bytes(),
        &half::f16::from_f32(0.1).to_le_bytes(),
        &0.3_f32.to_le_bytes(),
        &0.7_f64.to_le_bytes(),
    ];
    let text = "-3 200 -300 50000 -70000 3000000000 -5 9223372036854775808 0.1 0.3 0.7";
    let header = |format: &str| {
        let properties: String = kinds.iter().map(|kind| format!("property {kind} {kind}_0\n")).collect();
        format!(
            "ply\nformat {format} 1.0\nelement before 2\nproperty list short float values\nelement nothing 99999999999\n\
             element vertex 1\nproperty list uchar ushort list\n{properties}property double x\nproperty float y\n\
             property short z\nelement face 1\nproperty list int ushort vertex_index\nend_header\n"
        )
    };
    let all_text = read((header("ascii") + "1 0.5\n0\n 2 7 8 " + text + " 1.5 2 -3\n3 0 0 0").as_bytes(), Ply);
    assert_eq!(all_text.positions, [Vec3::new(1.5, 2.0, -3.0)]);
    assert_eq!(all_text.attributes.len(), 11);
    for (format, big) in [("binary_little_endian", false), ("binary_big_endian", true)] {
        let mut file = header(format).into_bytes();
        let mut put = |bytes: &[u8]| {
            let mut bytes = bytes.to_vec();
            if big {
                bytes.reverse();
            }
            file.extend(bytes);
        };
        put(&1_i16.to_le_bytes());
        put(&0.5_f32.to_le_bytes());
        put(&0_i16.to_le_bytes());
        put(&[2]);
        put(&7_u16.to_le_bytes());
        put(&8_u16.to_le_bytes());
        values.iter().for_each(|bytes| put(bytes));
        put(&1.5_f64.to_le_bytes());
        put(&2_f32.to_le_bytes());
        put(&(-3_i16).to_le_bytes());
        put(&3_i32.to_le_bytes());
        (0..3).for_each(|_| put(&0_u16.to_le_bytes()));
        assert_eq!(read(&file, Ply), all_text, "{format}");
    }
}

#[test]
fn attributes_are_named_and_grouped_as_mitsuba_does() {
    type Case<'a> = (&'a str, &'a [(&'a str, usize)], usize);
    let cases: [Case; 14] = [
        ("foo_x foo_y foo_z", &[("vertex_foo", 3)], 0),
        ("foo_r foo_g foo_b", &[("vertex_foo_color", 3)], 0),
        ("foo_1 foo_2 foo_3", &[("vertex_foo", 3)], 0),
        ("foo_0", &[("vertex_foo", 1)], 0),
        ("foo_0 foo_1", &[], 1),
        ("foo_x foo_y foo_z foo_w", &[], 1),
        ("foo_x foo_z foo_y", &[], 1),
        ("r g b a", &[("vertex_color", 4)], 0),
        ("blue red green alpha", &[("vertex_color", 4)], 0),
        ("r g b alpha", &[("vertex_color", 3)], 1),
        ("foo_x foo_y foo_z q bar_0 foo_0", &[("vertex_foo", 3), ("vertex_bar", 1)], 2),
        ("a_0 b_0 a_1", &[("vertex_a", 1), ("vertex_b", 1)], 1),
        ("x_x_0 r foo_ab foo_y", &[("vertex_x_x", 1)], 2),
        ("foo_r foo_g foo_b r g b", &[("vertex_color", 3), ("vertex_foo_color", 3)], 0),
    ];
    for (properties, expected, warnings) in cases {
        let count = properties.split(' ').count();
        let row: Vec<String> = (0..count + 3).map(|i| i.to_string()).collect();
        let properties: Vec<String> = properties.split(' ').map(|p| format!("float {p}")).collect();
        let mesh = read(ply(&properties.join(", "), &[&row.join(" ")], "", &[]).as_bytes(), Ply);
        assert_eq!(
            (names(&mesh), mesh.warnings.len()),
            (expected.to_vec(), warnings),
            "{properties:?}: {:?}",
            mesh.warnings
        );
    }
    let mesh = read(ply("float blue, float red, float green", &["0 0 0 3 1 2"], "", &[]).as_bytes(), Ply);
    assert_eq!(mesh.attributes[0].values, [1.0, 2.0, 3.0]);
}

#[test]
fn normals_need_all_three() {
    assert_eq!(read(ply("float nx, float ny", &["0 0 0 1 2"], "", &[]).as_bytes(), Ply).normals, None);
    let mesh = read(ply("float nx, float ny, short nz", &["0 0 0 1 2 -7"], "", &[]).as_bytes(), Ply);
    assert_eq!(mesh.normals.unwrap(), [Vec3::new(1.0, 2.0, -7.0)]);
}
