use serde_json::json;

use super::{File, TRIANGLE, assert_refused, assert_unsupported, message, read, read_bytes, read_json, triangle};
use crate::scene::error::SceneError;

/// A binary file of a JSON chunk and perhaps a binary one.
pub(super) fn glb(json: &[u8], bin: Option<&[u8]>) -> Vec<u8> {
    let mut chunks = Vec::new();
    for (kind, data, pad) in [(b"JSON", Some(json), b' '), (b"BIN\0", bin, 0)] {
        let Some(data) = data else { continue };
        let mut data = data.to_vec();
        data.resize(data.len().next_multiple_of(4), pad);
        chunks.extend((data.len() as u32).to_le_bytes());
        chunks.extend(kind);
        chunks.extend(data);
    }
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((chunks.len() as u32 + 12).to_le_bytes());
    bytes.extend(chunks);
    bytes
}

/// The triangle as a binary file.
fn triangle_glb() -> Vec<u8> {
    let mut json = triangle();
    json["buffers"][0].as_object_mut().unwrap().remove("uri");
    let bytes: Vec<u8> = TRIANGLE.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    glb(json.to_string().as_bytes(), Some(&bytes))
}

#[test]
fn binary_files_hold_their_buffer() {
    let scene = read_bytes("a.glb", &triangle_glb()).unwrap();
    assert_eq!(scene.meshes[0].positions.len(), 3);
    let mut with_more = triangle_glb();
    with_more.extend(b"\x04\0\0\0WHAT1234");
    let length = with_more.len() as u32;
    with_more[8..12].copy_from_slice(&length.to_le_bytes());
    assert!(read_bytes("a.glb", &with_more).is_ok(), "chunks of unknown types are skipped");
}

#[test]
fn every_truncation_of_a_binary_file_is_refused() {
    let whole = triangle_glb();
    for length in 0..whole.len() {
        let text = message(read_bytes("a.glb", &whole[..length]));
        assert!(text.contains("a.glb: "), "{text}");
    }
}

#[test]
fn wrong_lengths_in_the_chunks_are_refused() {
    let whole = triangle_glb();
    for (at, value) in [(8, 3_u32), (8, u32::MAX), (12, u32::MAX), (12, 4), (4, 1)] {
        let mut bytes = whole.clone();
        bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        message(read_bytes("a.glb", &bytes));
    }
}

#[test]
fn missing_files_and_folders_are_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    let missing = read(&folder.path().join("no.gltf"));
    assert!(matches!(missing, Err(SceneError::NotFound { .. })));
    assert!(message(missing).contains("no.gltf: there is no such file"));
    let directory = read(folder.path());
    assert!(matches!(directory, Err(SceneError::Unreadable { .. })));
    message(directory);
}

#[test]
fn other_kinds_of_files_are_not_gltf() {
    let noise: Vec<u8> = (0..997_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    let others: [&[u8]; 9] = [
        b"",
        b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR",
        &noise,
        b"[1, 2, 3]",
        b"{}",
        br#"{"name": "package", "version": "1.0.0"}"#,
        br#"{"asset": {"version": "2.0"}, "nodes": [{"#,
        b"{\xff\xfe}",
        b"<scene version=\"3.0.0\"/>",
    ];
    for bytes in others {
        let result = read_bytes("a.gltf", bytes);
        assert!(matches!(result, Err(SceneError::NotGltf { .. })), "{bytes:?}: {result:?}");
        message(result);
    }
}

#[test]
fn json_of_the_wrong_shape_names_its_line() {
    assert_refused(&json!({"asset": {"version": "2.0"}, "nodes": {"a": 1}}), &["line 1 column", "expected a sequence"]);
    assert_refused(&json!({"asset": {"version": "2.0"}, "accessors": [{"count": -1}]}), &["line 1 column"]);
    let deep = format!("{}{}", "{\"extras\":".repeat(100_000), "}".repeat(100_000));
    message(read_bytes("a.gltf", deep.as_bytes()));
}

#[test]
fn other_versions_and_extensions_are_refused_by_name() {
    let mut json = triangle();
    json["asset"]["version"] = json!("1.0");
    assert_unsupported(&json, &["glTF files of version \"1.0\""]);
    let mut json = triangle();
    json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    assert_unsupported(&json, &["KHR_draco_mesh_compression", "extensionsRequired[0]"]);
    let mut json = triangle();
    json["extensionsUsed"] = json!(["EXT_meshopt_compression"]);
    assert!(read_json(&json).unwrap().warnings[0].contains("EXT_meshopt_compression is ignored"));
}

#[test]
fn buffers_are_files_beside_the_scene() {
    let bytes: Vec<u8> = TRIANGLE.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("outside.bin"), &bytes).unwrap();
    let inside = folder.path().join("scene");
    std::fs::create_dir_all(inside.join("data")).unwrap();
    std::fs::write(inside.join("data/a b.bin"), &bytes).unwrap();
    let path = inside.join("scene.gltf");
    let with_uri = |uri: &str| {
        let mut json = triangle();
        json["buffers"][0]["uri"] = json!(uri);
        std::fs::write(&path, json.to_string()).unwrap();
        read(&path)
    };
    assert_eq!(with_uri("data/a%20b.bin").unwrap().name, "scene");
    let absolute = folder.path().join("outside.bin");
    for uri in ["../outside.bin", "%2e%2e/outside.bin", "data/../../outside.bin", absolute.to_str().unwrap()] {
        let text = message(with_uri(uri));
        assert!(text.contains("leads out of the scene's folder"), "{text}");
    }
    assert!(message(with_uri("none.bin")).contains("none.bin cannot be read"));
    assert!(message(with_uri("http://example.org/a.bin")).contains("http: addresses are not supported"));
    assert!(message(with_uri("a%2.bin")).contains("no valid URI"));
    assert!(message(with_uri("data:application/octet-stream;base64,AA*A")).contains("base64 is broken"));
    std::fs::write(inside.join("short.bin"), &bytes[..20]).unwrap();
    assert!(message(with_uri("short.bin")).contains("buffers[0]: is truncated: 36 bytes are promised, there are 20"));
}

#[test]
fn accessors_stay_inside_their_views_and_views_inside_their_buffers() {
    let mut json = triangle();
    json["accessors"][0]["count"] = json!(4);
    assert_refused(&json, &["accessors[0]", "end at byte 48 of a buffer view of 36"]);
    for count in [4_000_000_000_u64, u64::MAX] {
        json["accessors"][0]["count"] = json!(count);
        assert_refused(&json, &["accessors[0]"]);
    }
    json["accessors"][0]["count"] = json!(0);
    assert_refused(&json, &["no elements"]);
    let mut json = triangle();
    json["accessors"][0]["byteOffset"] = json!(u64::MAX);
    assert_refused(&json, &["accessors[0]"]);
    let mut json = triangle();
    json["bufferViews"][0]["byteLength"] = json!(40);
    assert_refused(&json, &["bufferViews[0] ends at byte 40 of a buffer of 36"]);
    json["bufferViews"][0]["byteOffset"] = json!(u64::MAX);
    assert_refused(&json, &["bufferViews[0]"]);
    let mut json = triangle();
    json["bufferViews"][0]["byteStride"] = json!(4);
    assert_refused(&json, &["cannot be 4 bytes apart"]);
    let mut json = triangle();
    json["accessors"][0]["type"] = json!("VEC2");
    assert_refused(&json, &["has 2 components where 3 are needed"]);
}

#[test]
fn implicit_zeros_cannot_ask_for_all_memory() {
    let mut file = File::default();
    let indices = file.indices(&[0]);
    let values = file.vectors(&[[1.0, 2.0, 3.0]]);
    let positions = file.accessor(json!({
        "componentType": super::F32, "count": 4_000_000_000_u64, "type": "VEC3",
        "sparse": {"count": 1, "indices": {"bufferView": indices, "componentType": super::U16}, "values": {"bufferView": values}},
    }));
    assert_refused(&file.finish_with(json!({"attributes": {"POSITION": positions}})), &["4000000000 elements"]);
}

#[test]
fn indices_that_lead_nowhere_are_refused_with_their_place() {
    for (pointer, place) in [
        ("/nodes/0/mesh", "nodes[0].mesh"),
        ("/scenes/0/nodes/0", "scenes[0].nodes[0]"),
        ("/accessors/0/bufferView", "accessors[0].bufferView"),
        ("/bufferViews/0/buffer", "bufferViews[0].buffer"),
        ("/meshes/0/primitives/0/attributes/POSITION", "meshes[0].primitives[0].attributes"),
    ] {
        let mut json = triangle();
        *json.pointer_mut(pointer).unwrap() = json!(7);
        assert_refused(&json, &[place]);
    }
    let mut file = File::default();
    let positions = file.vectors(&TRIANGLE);
    let indices = file.indices(&[0, 1, 3]);
    let json = file.finish_with(json!({"attributes": {"POSITION": positions}, "indices": indices}));
    assert_refused(&json, &["meshes[0].primitives[0].indices", "index 3 at 2 is out of range, there are 3 vertices"]);
}

#[test]
fn triangles_need_three_corners() {
    for (mode, count) in [(4, 2), (4, 4), (5, 2), (6, 1)] {
        let mut file = File::default();
        let positions = file.vectors(&TRIANGLE);
        let indices = file.indices(&[0, 1, 2, 0][..count]);
        let json = file.finish_with(json!({"attributes": {"POSITION": positions}, "indices": indices, "mode": mode}));
        assert_refused(&json, &["meshes[0].primitives[0]", "whole triangles"]);
    }
}

#[test]
fn positions_that_are_no_numbers_are_refused() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut file = File::default();
        let positions = file.vectors(&[TRIANGLE[0], TRIANGLE[1], [0.0, bad, 0.0]]);
        let json = file.finish_with(json!({"attributes": {"POSITION": positions}}));
        assert_refused(&json, &["meshes[0].primitives[0].POSITION", "vertex 2"]);
    }
}
