//! Small files written by the tests themselves, and files of other people where they are at hand.
#![allow(clippy::unwrap_used, clippy::needless_pass_by_value)]

mod accessors;
mod bad_files;
mod bad_nodes;
mod cameras_and_lights;
mod extras;
mod materials;
mod mutations;
mod principled;
mod samples;
mod textures;
mod transforms;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;
use serde_json::{Value, json};

use super::read;
use crate::scene::description::{Mesh, SceneDescription};
use crate::scene::error::SceneError;

const U8: u32 = 5121;
const U16: u32 = 5123;
const U32: u32 = 5125;
const I8: u32 = 5120;
const I16: u32 = 5122;
const F32: u32 = 5126;

/// A file under construction, with one buffer.
#[derive(Default)]
struct File {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl File {
    /// Adds a buffer view and gives its index.
    fn view(&mut self, data: &[u8], stride: Option<usize>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut view = json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": data.len()});
        if let Some(stride) = stride {
            view["byteStride"] = json!(stride);
        }
        self.bytes.extend(data);
        self.views.push(view);
        self.views.len() - 1
    }

    /// Adds an accessor and gives its index.
    fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Adds an array of vectors in single precision and gives the index of its accessor.
    fn vectors<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let view = self.view(&values.iter().flatten().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>(), None);
        let kind = ["", "SCALAR", "VEC2", "VEC3", "VEC4"][N];
        self.accessor(json!({"bufferView": view, "componentType": F32, "count": values.len(), "type": kind}))
    }

    /// Adds indices of 16 bits and gives the index of their accessor.
    fn indices(&mut self, values: &[u16]) -> usize {
        let view = self.view(&values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>(), None);
        self.accessor(json!({"bufferView": view, "componentType": U16, "count": values.len(), "type": "SCALAR"}))
    }

    /// The finished file with its buffer as a data URI; `rest` holds nodes, meshes and so on.
    fn finish(self, rest: Value) -> Value {
        let mut json = json!({
            "asset": {"version": "2.0"},
            "buffers": [{
                "byteLength": self.bytes.len(),
                "uri": format!("data:application/octet-stream;base64,{}", STANDARD.encode(&self.bytes)),
            }],
            "bufferViews": self.views,
            "accessors": self.accessors,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
        });
        for (key, value) in rest.as_object().unwrap() {
            json[key] = value.clone();
        }
        json
    }

    /// The file with one mesh of one primitive.
    fn finish_with(self, primitive: Value) -> Value {
        self.finish(json!({"meshes": [{"primitives": [primitive]}]}))
    }
}

const TRIANGLE: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// A file with one triangle, whose front faces +Z.
fn triangle() -> Value {
    let mut file = File::default();
    let positions = file.vectors(&TRIANGLE);
    file.finish_with(json!({"attributes": {"POSITION": positions}}))
}

/// Writes a file into an empty folder and reads it.
fn read_bytes(name: &str, bytes: &[u8]) -> Result<SceneDescription, SceneError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    read(&path)
}

fn read_json(json: &Value) -> Result<SceneDescription, SceneError> {
    read_bytes("file.gltf", json.to_string().as_bytes())
}

/// The corners of the triangles in order.
fn corners(mesh: &Mesh) -> Vec<[DVec3; 3]> {
    mesh.triangles.iter().map(|corners| corners.map(|i| mesh.positions[i as usize])).collect()
}

/// The unit normal that the winding of a triangle gives it.
fn facing([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize()
}

/// The error as a user sees it, after checking that it is one line that begins with the file.
fn message(result: Result<SceneDescription, SceneError>) -> String {
    let error = result.unwrap_err();
    let text = error.to_string();
    assert_eq!(text.lines().count(), 1, "{text}");
    let remedy = text.rsplit("; ").next().unwrap();
    assert!(text.contains(": ") && text.contains("; ") && remedy.len() > 5, "{text}");
    text
}

#[track_caller]
fn assert_refused(json: &Value, words: &[&str]) {
    let text = message(read_json(json));
    for word in words {
        assert!(text.contains(word), "{word:?} is not in {text}");
    }
}

#[track_caller]
fn assert_unsupported(json: &Value, words: &[&str]) {
    assert!(matches!(read_json(json), Err(SceneError::Unsupported { .. })), "{:?}", read_json(json));
    assert_refused(json, words);
}
