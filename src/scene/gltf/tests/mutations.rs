//! Files that are wrong in ways that nobody thought of: whatever they hold, the answer is a scene or one line.

use std::path::Path;

use serde_json::{Value, json};

use super::bad_files::glb;
use super::{F32, File, TRIANGLE, U16, message};
use crate::scene::description::SceneDescription;
use crate::scene::error::SceneError;
use crate::scene::gltf::{ReadOptions, from_bytes};

/// Reads without the detour over the disk: there are thousands of files here.
fn read_bytes(bytes: &[u8]) -> Result<SceneDescription, SceneError> {
    from_bytes(bytes, Path::new("a.gltf"), &ReadOptions::default())
}

fn read_json(json: &Value) -> Result<SceneDescription, SceneError> {
    read_bytes(json.to_string().as_bytes())
}

/// A file with something of everything.
fn rich() -> Value {
    let mut file = File::default();
    let base = file.vectors(&TRIANGLE);
    let targets = file.indices(&[1]);
    let indices = file.indices(&[0, 1, 2]);
    let normals = file.vectors(&[[0.0, 0.6, 0.8]; 3]);
    let positions = file.accessor(json!({
        "bufferView": base, "byteOffset": 0, "componentType": F32, "count": 3, "type": "VEC3", "normalized": false,
        "sparse": {
            "count": 1,
            "indices": {"bufferView": targets, "componentType": U16, "byteOffset": 0},
            "values": {"bufferView": normals, "byteOffset": 12},
        },
    }));
    let instances = file.vectors(&[[0.0, 0.0, 1.0], [0.0, 0.0, 2.0]]);
    let attributes = json!({"POSITION": positions, "NORMAL": normals});
    file.finish(json!({
        "scene": 0,
        "scenes": [{"nodes": [0], "extras": {"pathspace": {
            "environment": [1, 1, 1], "film": {"width": 4, "height": 4}, "render": {"max_length": 3},
            "reference": {"enclosure": {"emission": [1, 1, 1], "reflectance": [0.5, 0.5, 0.5]}},
        }}}],
        "nodes": [
            {"name": "root", "children": [1, 2, 3, 4], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1]},
            {"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": instances}}}},
            {"camera": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1]},
            {"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [0, 0, 3]},
            {"extras": {"pathspace": {"sphere": {"radius": 1, "material": "glass"}}}},
        ],
        "meshes": [{"primitives": [{"attributes": attributes, "indices": indices, "material": 0, "mode": 4}]}],
        "materials": [
            {"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 1], "metallicFactor": 1, "roughnessFactor": 1},
             "emissiveFactor": [1, 1, 1], "doubleSided": true, "alphaMode": "MASK", "alphaCutoff": 0.5,
             "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 3}}},
            {"name": "glass", "extras": {"pathspace": {"bsdf": {"type": "dielectric", "interior_ior": 1.5}}}},
        ],
        "cameras": [{
            "type": "perspective", "perspective": {"yfov": 0.7, "aspectRatio": 1, "znear": 0.1},
            "extras": {"pathspace": {"lens": {"aperture_radius": 1, "focus_distance": 2}}},
        }],
        "extensions": {"KHR_lights_punctual": {"lights": [{
            "type": "spot", "color": [1, 1, 1], "intensity": 2, "range": 9,
            "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.2},
        }]}},
    }))
}

/// Pointers to every value inside.
fn pointers(value: &Value, here: &str, all: &mut Vec<String>) {
    let mut step = |key: &str, inner: &Value| {
        let there = format!("{here}/{key}");
        all.push(there.clone());
        pointers(inner, &there, all);
    };
    match value {
        Value::Array(items) => items.iter().enumerate().for_each(|(i, inner)| step(&i.to_string(), inner)),
        Value::Object(entries) => entries.iter().for_each(|(key, inner)| step(key, inner)),
        _ => {}
    }
}

#[test]
fn no_value_in_the_json_can_cause_more_than_an_error() {
    let whole = rich();
    let scene = read_json(&whole).unwrap();
    assert_eq!((scene.meshes.len(), scene.spheres.len(), scene.lights.len()), (2, 1, 1));
    let mut all = Vec::new();
    pointers(&whole, "", &mut all);
    let values = json!([null, -1, 0, 1, 7, 0.5, 1e300, -1e300, u32::MAX, u64::MAX, "", "x", [], {}, [[]], true]);
    let mut refused = 0;
    for pointer in &all {
        for value in values.as_array().unwrap() {
            let mut changed = whole.clone();
            *changed.pointer_mut(pointer).unwrap() = value.clone();
            if let Err(error) = read_json(&changed) {
                message(Err(error));
                refused += 1;
            }
        }
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        let mut changed = whole.clone();
        if let Some(object) = changed.pointer_mut(parent).and_then(Value::as_object_mut) {
            object.remove(key);
            if let Err(error) = read_json(&changed) {
                message(Err(error));
            }
        }
    }
    assert!(refused > 10 * all.len(), "{refused} of {} changes are refused", all.len() * 16);
}

#[test]
fn no_byte_in_a_binary_file_can_cause_more_than_an_error() {
    let mut json = super::triangle();
    json["buffers"][0].as_object_mut().unwrap().remove("uri");
    let bin: Vec<u8> = TRIANGLE.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    let whole = glb(json.to_string().as_bytes(), Some(&bin));
    assert!(read_bytes(&whole).is_ok());
    for at in 0..whole.len() {
        for value in [0, 0x7f, 0xff, b'9', b'"', whole[at] ^ 1] {
            let mut changed = whole.clone();
            changed[at] = value;
            if let Err(error) = read_bytes(&changed) {
                message(Err(error));
            }
        }
    }
}
