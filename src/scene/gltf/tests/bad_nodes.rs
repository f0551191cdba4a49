use serde_json::{Value, json};

use super::{assert_refused, assert_unsupported, read_bytes, read_json, triangle};

fn with_nodes(nodes: Value, roots: Value) -> Value {
    let mut json = triangle();
    json["nodes"] = nodes;
    json["scenes"] = json!([{"nodes": roots}]);
    json
}

#[test]
fn cycles_are_refused_wherever_they_are() {
    let ring = json!([{"children": [1]}, {"children": [2]}, {"children": [0]}, {"mesh": 0}]);
    assert_refused(&with_nodes(ring, json!([3])), &["is its own descendant"]);
    assert_refused(&with_nodes(json!([{"children": [0]}, {}]), json!([1])), &["nodes[0]", "is its own descendant"]);
    assert_refused(&with_nodes(json!([{"children": [1]}, {"children": [1]}]), json!([0])), &["nodes[1]", "both"]);
}

#[test]
fn nodes_have_one_parent_and_roots_none() {
    let shared = json!([{"children": [2]}, {"children": [2]}, {"name": "Lamp"}]);
    assert_refused(&with_nodes(shared, json!([0, 1])), &["nodes[2] \"Lamp\"", "child of both nodes[0] and nodes[1]"]);
    assert_refused(&with_nodes(json!([{"children": [1]}, {}]), json!([0, 1])), &["nodes[1]", "root"]);
    assert_refused(&with_nodes(json!([{"mesh": 0}]), json!([0, 0])), &["nodes[0]", "twice"]);
}

#[test]
fn deep_hierarchies_are_walked_without_recursion() {
    const DEPTH: usize = 100_000;
    let mut nodes: Vec<Value> =
        (1..DEPTH).map(|child| json!({"children": [child], "translation": [1, 0, 0]})).collect();
    nodes.push(json!({"mesh": 0}));
    let scene = read_json(&with_nodes(json!(nodes), json!([0]))).unwrap();
    assert_eq!(scene.meshes[0].positions[0].x, (DEPTH - 1) as f64);
}

#[test]
fn transforms_that_overflow_are_refused() {
    // A single number beyond f32 is refused by the JSON reader, so ten together go beyond f64.
    let mut nodes: Vec<_> = (1..10).map(|child| json!({"children": [child], "scale": [1e38, 1, 1]})).collect();
    nodes.push(json!({"mesh": 0, "scale": [1e38, 1, 1]}));
    assert_refused(&with_nodes(json!(nodes), json!([0])), &["nodes[", "not finite"]);
    let huge = with_nodes(json!([{"mesh": 0}]), json!([0]))
        .to_string()
        .replace("\"mesh\":0", "\"mesh\":0,\"scale\":[1e999,1,1]");
    assert!(read_bytes("a.gltf", huge.as_bytes()).is_err());
}

#[test]
fn transforms_that_are_none_are_refused() {
    let projective = json!([{"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0.5, 0, 0, 0, 1]}]);
    assert_refused(&with_nodes(projective, json!([0])), &["nodes[0]", "affine"]);
    assert_refused(&with_nodes(json!([{"mesh": 0, "rotation": [0, 0, 0, 0]}]), json!([0])), &["nodes[0]", "rotation"]);
}

#[test]
fn skins_and_morph_targets_are_refused_by_name() {
    let mut json = with_nodes(json!([{"mesh": 0, "skin": 0}]), json!([0]));
    json["skins"] = json!([{"joints": [0]}]);
    assert_unsupported(&json, &["skins", "nodes[0]"]);
    let mut json = triangle();
    json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": 0}]);
    json["meshes"][0]["weights"] = json!([0.0]);
    assert!(read_json(&json).is_ok());
    json["nodes"][0]["weights"] = json!([0.5]);
    assert_unsupported(&json, &["morph targets", "nodes[0]"]);
}

#[test]
fn animations_are_ignored_with_a_warning() {
    let mut json = triangle();
    json["animations"] = json!([{"channels": [], "samplers": []}]);
    assert!(read_json(&json).unwrap().warnings[0].contains("animations are ignored"));
}

#[test]
fn names_with_line_breaks_leave_the_message_one_line() {
    let json = with_nodes(json!([{"mesh": 0, "name": "a\nb", "rotation": [0, 0, 0, 0]}]), json!([0]));
    assert_refused(&json, &["nodes[0]"]);
}
