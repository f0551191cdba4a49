//! Running the command, and scenes to run it on.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::{Value, json};

/// The command; its working folder is the workspace's, which holds `scenes/`.
pub fn pathspace(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pathspace"));
    command.args(args).current_dir(workspace());
    command
}

pub fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

pub fn run(args: &[&str]) -> Output {
    pathspace(args).output().unwrap()
}

pub fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// Runs it and expects success.
pub fn succeed(args: &[&str]) -> String {
    let output = run(args);
    assert_eq!(output.status.code(), Some(0), "{args:?}: {}", stderr(&output));
    stdout(&output)
}

/// Runs it and expects exactly one line on stderr that says `parts`, nothing on stdout, and this exit code.
pub fn fail(args: &[&str], code: i32, parts: &[&str]) {
    let output = run(args);
    let text = stderr(&output);
    assert_eq!(output.status.code(), Some(code), "{args:?}: {text}");
    assert!(output.stdout.is_empty(), "{args:?}");
    assert_one_line(&text);
    for part in parts {
        assert!(text.contains(part), "{args:?}: '{part}' is missing in: {text}");
    }
}

/// Of the lines that are no notes, exactly one, an error.
pub fn assert_one_line(text: &str) {
    assert!(!text.contains("panicked"), "{text}");
    let lines: Vec<_> = text.lines().filter(|line| !line.starts_with("note: ")).collect();
    assert!(lines.len() == 1 && lines[0].starts_with("error: "), "{text}");
}

/// A folder for one test, and paths in it as text.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn path(&self, name: &str) -> String {
        self.0.path().join(name).to_str().unwrap().to_owned()
    }

    /// Writes a file and returns its path.
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) -> String {
        let path = self.path(name);
        fs::write(&path, content).unwrap();
        path
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.0.path().join(name)).unwrap()
    }

    /// Names of all files in it, sorted.
    pub fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    /// The sums of a film and their squares: a state without its metadata, which hold the time.
    pub fn sums(&self, name: &str) -> Vec<u8> {
        let bytes = self.read(name);
        let header = u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize;
        bytes[8 + header..].to_vec()
    }

    /// A triangle that emits, with a camera, after `change`.
    pub fn scene(&self, change: impl FnOnce(&mut Value, &mut Vec<f32>)) -> String {
        let mut positions: Vec<f32> = vec![-1.0, -1.0, -3.0, 1.0, -1.0, -3.0, 0.0, 1.0, -3.0];
        let mut scene = json!({
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0, 1], "extras": {"pathspace": {"film": {"width": 8, "height": 8}}}}],
            "nodes": [{"mesh": 0}, {"camera": 0}],
            "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
            "materials": [{
                "emissiveFactor": [1, 1, 1],
                "pbrMetallicRoughness": {"metallicFactor": 0},
                // Lambert's, which can be exported.
                "extensions": {"KHR_materials_specular": {"specularFactor": 0}},
            }],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
            "accessors": [
                {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, -3], "max": [1, 1, -3]},
                {"bufferView": 1, "componentType": 5125, "count": 3, "type": "SCALAR"}
            ],
            "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 12}],
            "buffers": [{"uri": "scene.bin", "byteLength": 48}]
        });
        change(&mut scene, &mut positions);
        let index = scene["indices"]
            .take()
            .as_array()
            .map_or(vec![0, 1, 2], |indices| indices.iter().map(|i| i.as_u64().unwrap() as u32).collect());
        scene.as_object_mut().unwrap().remove("indices");
        let bytes =
            positions.iter().flat_map(|x| x.to_le_bytes()).chain(index.iter().flat_map(|i: &u32| i.to_le_bytes()));
        self.write("scene.bin", bytes.collect::<Vec<u8>>());
        self.write("scene.gltf", scene.to_string())
    }
}
