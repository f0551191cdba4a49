use glam::DVec3;
use serde_json::{Value, json};

use super::{File, TRIANGLE, corners, facing, read_json, triangle};

fn close(a: DVec3, b: DVec3) -> bool {
    (a - b).length() < 1e-12
}

fn with_nodes(nodes: Value) -> Value {
    let mut json = triangle();
    json["nodes"] = nodes;
    json
}

#[test]
fn transforms_compose_from_the_root() {
    let nodes = json!([
        {"children": [1], "translation": [1, 2, 3], "rotation": [0, 0, (0.5_f64).sqrt(), (0.5_f64).sqrt()]},
        {"mesh": 0, "scale": [2, 3, 4], "translation": [10, 0, 0]},
    ]);
    let scene = read_json(&with_nodes(nodes)).unwrap();
    let [a, b, c] = corners(&scene.meshes[0])[0];
    assert!(close(a, DVec3::new(1.0, 12.0, 3.0)), "{a}");
    assert!(close(b, DVec3::new(1.0, 14.0, 3.0)), "{b}");
    assert!(close(c, DVec3::new(-2.0, 12.0, 3.0)), "{c}");
}

#[test]
fn numbers_are_read_and_composed_in_double_precision() {
    let nodes = json!([{"children": [1], "translation": [0.1, 0, 0]}, {"mesh": 0, "translation": [0.2, 0, 0]}]);
    let scene = read_json(&with_nodes(nodes)).unwrap();
    assert_eq!(corners(&scene.meshes[0])[0][0].x, 0.1 + 0.2);
}

#[test]
fn matrices_are_column_major() {
    let nodes = json!([{"mesh": 0, "matrix": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1]}]);
    let scene = read_json(&with_nodes(nodes)).unwrap();
    let expected = [DVec3::new(5.0, 6.0, 7.0), DVec3::new(5.0, 7.0, 7.0), DVec3::new(4.0, 6.0, 7.0)];
    assert_eq!(corners(&scene.meshes[0]), [expected]);
}

#[test]
fn a_mirrored_front_stays_the_front() {
    // Mirrored in x, the triangle still faces +Z; mirrored in z, it faces −Z.
    for (scale, front) in [([-1, 1, 1], DVec3::Z), ([1, 1, -1], -DVec3::Z), ([-1, -1, -1], -DVec3::Z)] {
        let scene = read_json(&with_nodes(json!([{"mesh": 0, "scale": scale}]))).unwrap();
        assert_eq!(facing(corners(&scene.meshes[0])[0]), front, "{scale:?}");
    }
}

/// Smooth normals must turn with the surface they belong to, whatever the transform does.
#[test]
fn normals_follow_the_surface_under_any_transform() {
    let normal = [1.0_f32, 2.0, 3.0];
    // The normal of this triangle: it stays at right angles to the edges and on the side of the front.
    let positions = [[0.0, 0.0, 0.0], [2.0, -1.0, 0.0], [3.0, 0.0, -1.0]];
    for scale in [[2, 3, 4], [-2, 3, 4], [2, -3, -4], [-1, -5, -1]] {
        let mut file = File::default();
        let positions = file.vectors(&positions);
        let slanted = file.vectors(&[normal, normal, [0.0, 0.0, 1.0]]);
        let mut json = file.finish_with(json!({"attributes": {"POSITION": positions, "NORMAL": slanted}}));
        json["nodes"] = json!([{"mesh": 0, "scale": scale, "rotation": [0.5, 0.5, 0.5, 0.5]}]);
        let mesh = &read_json(&json).unwrap().meshes[0];
        let [a, b, c] = corners(mesh)[0];
        let vertex = mesh.positions.iter().position(|p| p.length() == 0.0).unwrap();
        let normal = mesh.normals.as_ref().unwrap()[vertex];
        assert!((normal.length() - 1.0).abs() < 1e-14);
        assert!(normal.dot(b - a).abs() < 1e-12 && normal.dot(c - a).abs() < 1e-12, "{scale:?}: {normal}");
        assert!(facing([a, b, c]).dot(normal) > 0.99, "{scale:?}");
    }
}

#[test]
fn a_mesh_is_drawn_once_for_each_of_its_nodes() {
    let nodes =
        json!([{"children": [1, 2]}, {"mesh": 0, "name": "a"}, {"mesh": 0, "name": "b", "translation": [0, 0, 5]}]);
    let scene = read_json(&with_nodes(nodes)).unwrap();
    let names: Vec<&str> = scene.meshes.iter().map(|mesh| mesh.name.as_str()).collect();
    assert_eq!(names, ["a", "b"]);
    assert_eq!(corners(&scene.meshes[1])[0][0].z - corners(&scene.meshes[0])[0][0].z, 5.0);
    assert_eq!(scene.materials.len(), 1);
}

#[test]
fn the_default_scene_is_read_and_else_the_first() {
    let mut json = with_nodes(json!([{"mesh": 0, "name": "first"}, {"mesh": 0, "name": "second"}]));
    json["scenes"] = json!([{"nodes": [0]}, {"nodes": [1]}]);
    assert_eq!(read_json(&json).unwrap().meshes[0].name, "first");
    json["scene"] = json!(1);
    assert_eq!(read_json(&json).unwrap().meshes[0].name, "second");
    let object = json.as_object_mut().unwrap();
    object.remove("scene");
    object.remove("scenes");
    assert_eq!(read_json(&json).unwrap().meshes.len(), 2);
}

#[test]
fn triangles_without_area_are_left_out_and_counted() {
    let mut file = File::default();
    let collinear = [[0.1, 0.1, 0.1], [0.2, 0.2, 0.2], [0.7, 0.7, 0.7]];
    let positions = file.vectors(&[TRIANGLE, collinear].concat());
    let indices = file.indices(&[0, 1, 2, 3, 4, 5, 0, 1, 1]);
    let mut json = file.finish_with(json!({"attributes": {"POSITION": positions}, "indices": indices}));
    json["nodes"] = json!([{"mesh": 0, "rotation": [0.1, 0.2, 0.3, 0.9], "translation": [3, 1, 4]}]);
    let scene = read_json(&json).unwrap();
    assert_eq!(scene.meshes[0].triangles.len(), 1);
    assert!(scene.warnings[0].starts_with("2 triangles of zero area"), "{:?}", scene.warnings);
}

#[test]
fn small_and_distant_triangles_are_kept() {
    let nodes = json!([{"mesh": 0, "scale": [1e-6, 1e-6, 1e-6], "translation": [1000, 1000, 1000]}]);
    assert_eq!(read_json(&with_nodes(nodes)).unwrap().meshes[0].triangles.len(), 1);
}

#[test]
fn nodes_of_zero_scale_draw_nothing() {
    let scene = read_json(&with_nodes(json!([{"mesh": 0, "scale": [0, 0, 0]}]))).unwrap();
    assert!(scene.meshes.is_empty());
    assert!(scene.warnings[0].starts_with("1 triangle of zero area"), "{:?}", scene.warnings);
}

#[test]
fn flattening_keeps_what_still_has_area() {
    let scene = read_json(&with_nodes(json!([{"mesh": 0, "scale": [2, 2, 0]}]))).unwrap();
    assert_eq!(facing(corners(&scene.meshes[0])[0]), DVec3::Z);
}

#[test]
fn instances_of_the_extension_are_placed_below_their_node() {
    let mut file = File::default();
    let positions = file.vectors(&TRIANGLE);
    let translations = file.vectors(&[[0.0, 0.0, 0.0], [0.0, 0.0, 2.0]]);
    let scales = file.vectors(&[[1.0, 1.0, 1.0], [-3.0, 3.0, 3.0]]);
    let mut json = file.finish_with(json!({"attributes": {"POSITION": positions}}));
    let attributes = json!({"TRANSLATION": translations, "SCALE": scales});
    json["nodes"] = json!([{
        "mesh": 0, "translation": [1, 0, 0], "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}},
    }]);
    json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    let scene = read_json(&json).unwrap();
    assert_eq!(scene.meshes.len(), 2);
    let second = corners(&scene.meshes[1])[0];
    assert_eq!(second[0], DVec3::new(1.0, 0.0, 2.0));
    assert_eq!(facing(second), DVec3::Z);
    assert!(second.contains(&DVec3::new(-2.0, 0.0, 2.0)));
}
