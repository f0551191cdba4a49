use glam::DVec3;
use serde_json::json;

use super::{F32, File, I8, I16, TRIANGLE, U8, U16, U32, assert_refused, corners, read_json};

fn triangle_in_world() -> [DVec3; 3] {
    TRIANGLE.map(|p| DVec3::from(p.map(f64::from)))
}

#[test]
fn triangles_without_indices_are_read_in_order() {
    let scene = read_json(&super::triangle()).unwrap();
    assert_eq!(corners(&scene.meshes[0]), [triangle_in_world()]);
    assert!(scene.meshes[0].normals.is_none() && scene.sensor.is_none());
    assert_eq!(scene.name, "file");
}

#[test]
fn indices_of_every_width_give_the_same_triangle() {
    let order = [2_u32, 0, 1];
    let forms = [
        (U8, order.iter().map(|&i| i as u8).collect::<Vec<_>>()),
        (U16, order.iter().flat_map(|&i| (i as u16).to_le_bytes()).collect()),
        (U32, order.iter().flat_map(|&i| i.to_le_bytes()).collect()),
    ];
    let [a, b, c] = triangle_in_world();
    for (component, bytes) in forms {
        let mut file = File::default();
        let positions = file.vectors(&TRIANGLE);
        let view = file.view(&bytes, None);
        let indices =
            file.accessor(json!({"bufferView": view, "componentType": component, "count": 3, "type": "SCALAR"}));
        let json = file.finish_with(json!({"attributes": {"POSITION": positions}, "indices": indices}));
        assert_eq!(corners(&read_json(&json).unwrap().meshes[0]), [[c, a, b]]);
    }
}

#[test]
fn interleaved_vertices_are_taken_apart() {
    let slanted = [0.0, 0.6, 0.8];
    let mut bytes = Vec::new();
    for position in TRIANGLE {
        bytes.extend(slanted.iter().chain(&position).flat_map(|v: &f32| v.to_le_bytes()));
    }
    let mut file = File::default();
    let view = file.view(&bytes, Some(24));
    let normals = file.accessor(json!({"bufferView": view, "componentType": F32, "count": 3, "type": "VEC3"}));
    let positions =
        file.accessor(json!({"bufferView": view, "byteOffset": 12, "componentType": F32, "count": 3, "type": "VEC3"}));
    let json = file.finish_with(json!({"attributes": {"POSITION": positions, "NORMAL": normals}}));
    let mesh = &read_json(&json).unwrap().meshes[0];
    assert_eq!(corners(mesh), [triangle_in_world()]);
    for normal in mesh.normals.as_ref().unwrap() {
        assert!((*normal - DVec3::new(0.0, 0.6, 0.8)).length() < 1e-7);
    }
}

/// A sparse accessor that puts (0, 1, 0) at element 2, over the given base.
fn sparse(base: Option<&[[f32; 3]]>) -> serde_json::Value {
    let mut file = File::default();
    let mut accessor = json!({"componentType": F32, "count": 3, "type": "VEC3"});
    if let Some(base) = base {
        let plain = file.vectors(base);
        accessor["bufferView"] = file.accessors[plain]["bufferView"].clone();
    }
    let targets = if base.is_some() { vec![2_u16] } else { vec![1, 2] };
    let values = if base.is_some() { &TRIANGLE[2..] } else { &TRIANGLE[1..] };
    let indices = file.indices(&targets);
    let values = file.vectors(values);
    accessor["sparse"] = json!({
        "count": targets.len(),
        "indices": {"bufferView": file.accessors[indices]["bufferView"], "componentType": U16},
        "values": {"bufferView": file.accessors[values]["bufferView"]},
    });
    let positions = file.accessor(accessor);
    file.finish_with(json!({"attributes": {"POSITION": positions}}))
}

#[test]
fn sparse_accessors_replace_elements() {
    let json = sparse(Some(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [9.0, 9.0, 9.0]]));
    assert_eq!(corners(&read_json(&json).unwrap().meshes[0]), [triangle_in_world()]);
}

#[test]
fn sparse_accessors_without_a_base_start_from_zeros() {
    assert_eq!(corners(&read_json(&sparse(None)).unwrap().meshes[0]), [triangle_in_world()]);
}

#[test]
fn sparse_indices_out_of_range_are_refused() {
    let mut json = sparse(None);
    let last = json["accessors"].as_array().unwrap().len() - 1;
    json["accessors"][last]["count"] = json!(2);
    assert_refused(&json, &["sparse", "replaces element 2 of 2"]);
}

#[test]
fn normalised_integers_become_fractions() {
    let bytes = [0_i8, 0, 0, 0, 127, 0, 0, 0, -128, 127, 0, 0].map(i8::cast_unsigned);
    let shorts: Vec<u8> = [0_i16, 0, 0, 0, 32767, 0, 0, 0, -32768, 32767, 0, 0].map(i16::to_le_bytes).concat();
    for (component, bytes, stride) in [(I8, bytes.to_vec(), 4), (I16, shorts, 8)] {
        let mut file = File::default();
        let view = file.view(&bytes, Some(stride));
        let positions = file.accessor(
            json!({"bufferView": view, "componentType": component, "normalized": true, "count": 3, "type": "VEC3"}),
        );
        let json = file.finish_with(json!({"attributes": {"POSITION": positions}}));
        let expected = [DVec3::ZERO, DVec3::X, DVec3::new(-1.0, 1.0, 0.0)];
        assert_eq!(corners(&read_json(&json).unwrap().meshes[0]), [expected]);
    }
}

#[test]
fn unused_vertices_are_left_out() {
    let mut file = File::default();
    let positions = file.vectors(&[[7.0; 3], TRIANGLE[0], [8.0; 3], TRIANGLE[1], TRIANGLE[2]]);
    let indices = file.indices(&[1, 3, 4]);
    let json = file.finish_with(json!({"attributes": {"POSITION": positions}, "indices": indices}));
    let mesh = &read_json(&json).unwrap().meshes[0];
    assert_eq!(mesh.positions, triangle_in_world());
}

/// Strips and fans over a quarter of a disc, all facing +Z.
#[test]
fn strips_and_fans_keep_the_front() {
    let p = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    for (mode, order, last) in [(5, [0, 1, 3, 2], [1, 2, 3]), (6, [0, 1, 2, 3], [2, 3, 0])] {
        let mut file = File::default();
        let positions = file.vectors(&p);
        let indices = file.indices(&order);
        let json = file.finish_with(json!({"attributes": {"POSITION": positions}, "indices": indices, "mode": mode}));
        let triangles = corners(&read_json(&json).unwrap().meshes[0]);
        assert_eq!(triangles.len(), 2);
        assert!(triangles.iter().all(|&t| super::facing(t) == DVec3::Z), "mode {mode}");
        assert_eq!(triangles[1], last.map(|i: usize| DVec3::from(p[i].map(f64::from))), "mode {mode}");
    }
}

#[test]
fn points_and_lines_are_left_out_with_a_warning() {
    for mode in 0..4 {
        let mut json = super::triangle();
        json["meshes"][0]["primitives"][0]["mode"] = json!(mode);
        let scene = read_json(&json).unwrap();
        assert!(scene.meshes.is_empty());
        assert!(scene.warnings[0].contains("1 primitive of points or lines"), "{:?}", scene.warnings);
    }
}

#[test]
fn normals_are_stored_only_where_they_differ_from_the_geometric_ones() {
    for (tilt, kept) in [(1e-6_f32, false), (1e-3, true)] {
        let mut file = File::default();
        let positions = file.vectors(&TRIANGLE);
        let normals = file.vectors(&[[0.0, 0.0, 1.0], [tilt, 0.0, 1.0], [0.0, 0.0, 1.0]]);
        let json = file.finish_with(json!({"attributes": {"POSITION": positions, "NORMAL": normals}}));
        assert_eq!(read_json(&json).unwrap().meshes[0].normals.is_some(), kept);
    }
}

#[test]
fn useless_normals_become_geometric_with_a_warning() {
    let mut file = File::default();
    let positions = file.vectors(&TRIANGLE);
    let normals = file.vectors(&[[0.0, 0.0, 0.0], [f32::NAN, 0.0, 1.0], [0.0, 1.0, 1.0]]);
    let json = file.finish_with(json!({"attributes": {"POSITION": positions, "NORMAL": normals}}));
    let scene = read_json(&json).unwrap();
    let normals = scene.meshes[0].normals.as_ref().unwrap();
    assert_eq!(normals[..2], [DVec3::Z, DVec3::Z]);
    assert!((normals[2] - DVec3::new(0.0, 1.0, 1.0).normalize()).length() < 1e-15);
    assert!(scene.warnings[0].starts_with("2 vertices without a usable normal"), "{:?}", scene.warnings);
}
