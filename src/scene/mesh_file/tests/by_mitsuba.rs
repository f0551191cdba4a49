//! The same files read by Mitsuba itself, where it is installed.

use std::path::{Path, PathBuf};
use std::process::Command;

use glam::Vec3;
use serde_json::Value;

use super::{OBJ, library, ply, serialized};
use crate::scene::description::Attribute;
use crate::scene::mesh_file::MeshFormat::{self, Obj, Ply, Serialized};
use crate::scene::mesh_file::{MeshData, MeshOptions, read};

const SCRIPT: &str = "
import json, sys
import mitsuba
mitsuba.set_variant('scalar_rgb')
mitsuba.set_log_level(mitsuba.LogLevel.Error)
for path in sys.argv[1:]:
    name, _, index = path.partition('@')
    shape = {'type': name.rsplit('.', 1)[1], 'filename': name}
    if index:
        shape['shape_index'] = int(index)
    mesh = mitsuba.load_dict(shape)
    parameters = mitsuba.traverse(mesh)
    keys = [key for key, _ in parameters if key == 'faces' or key.startswith(('vertex_', 'face_'))]
    values = {key: [float(x) for x in parameters[key]] for key in keys if len(parameters[key])}
    print(json.dumps({'normals': mesh.has_vertex_normals(), **values}))
";

/// Python with Mitsuba; a test without it says so and passes.
fn python() -> Option<PathBuf> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR")).join(".venv/bin/python");
    let python = std::env::var_os("PATHSPACE_PYTHON").map_or(here, PathBuf::from);
    let check = Command::new(&python).args(["-c", "import mitsuba"]).output();
    let found = check.is_ok_and(|output| output.status.success());
    if !found {
        eprintln!("skipped: Mitsuba is not installed; run scripts/setup");
    }
    found.then_some(python)
}

/// What Mitsuba reads from files; a number after @ is the index of the shape.
fn by_mitsuba(python: &Path, files: &[String]) -> Vec<Value> {
    let output = Command::new(python).args(["-c", SCRIPT]).args(files).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let lines = String::from_utf8(output.stdout).unwrap();
    lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

fn floats(value: &Value) -> Vec<f32> {
    value.as_array().into_iter().flatten().map(|x| x.as_f64().unwrap() as f32).collect()
}

fn agree(file: &str, ours: &MeshData, theirs: &Value) {
    let flat = |vectors: &[Vec3]| vectors.iter().flat_map(Vec3::to_array).collect::<Vec<f32>>();
    assert_eq!(flat(&ours.positions), floats(&theirs["vertex_positions"]), "{file}");
    let triangles: Vec<f32> = ours.triangles.iter().flatten().map(|&i| i as f32).collect();
    assert_eq!(triangles, floats(&theirs["faces"]), "{file}");
    let texcoords: Vec<f32> = ours.texcoords.iter().flatten().flat_map(glam::Vec2::to_array).collect();
    assert_eq!(texcoords, floats(&theirs["vertex_texcoords"]), "{file}");
    if let Some(normals) = &ours.normals {
        for (i, (ours, theirs)) in normals.iter().zip(floats(&theirs["vertex_normals"]).chunks(3)).enumerate() {
            let theirs = Vec3::from_slice(theirs);
            assert!((ours.normalize() - theirs).length() < 1e-6, "{file}: normal {i}: {ours} {theirs}");
        }
    }
    let known = ["vertex_positions", "vertex_normals", "vertex_texcoords"];
    let theirs = theirs.as_object().unwrap();
    let others = theirs.keys().filter(|key| key.contains('_') && !known.contains(&key.as_str()));
    assert_eq!(others.count(), ours.attributes.len(), "{file}: {:?}", theirs.keys());
    for Attribute { name, channels, values, .. } in &ours.attributes {
        let theirs = floats(&theirs[name]);
        assert_eq!(values.len(), theirs.len(), "{file}: {name} has {channels} channels");
        // Mitsuba computes the curve of sRGB in single precision.
        let differ = |(a, b): (&f32, &f32)| (a - b).abs() > 5e-6 * b.abs();
        assert!(!values.iter().zip(&theirs).any(differ), "{file}: {name}: {values:?} {theirs:?}");
    }
}

/// Writes the files, reads them on both sides, compares.
fn compare(files: &[(&str, Vec<u8>, MeshFormat)]) {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let names: Vec<String> = (files.iter())
        .map(|(name, bytes, format)| {
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).unwrap();
            match format {
                Serialized { shape_index } => format!("{}@{shape_index}", path.display()),
                _ => path.display().to_string(),
            }
        })
        .collect();
    for ((name, _, format), theirs) in files.iter().zip(by_mitsuba(&python, &names)) {
        let options = MeshOptions { flip_tex_coords: *format == Obj };
        agree(name, &read(&folder.path().join(name), *format, &options).unwrap(), &theirs);
    }
}

#[test]
fn obj_agrees() {
    // Corners without texture coordinates have any in Mitsuba 3.9.
    let all = OBJ.replace("f 3//2 4//2 1//2", "f 3/1/2 4/1/2 1/4/2");
    let plain = b"v 0 0 0\nv 1 0 0.1\nv 0 1 0\nf 3 2 1\n".to_vec();
    compare(&[("all.obj", all.into(), Obj), ("plain.obj", plain, Obj)]);
}

#[test]
fn ply_agrees() {
    let rows = ["0 0 0", "1 0 0", "0.1 1 1e-3"];
    let corners = ["3 0 1 2"];
    let mut files: Vec<(String, Vec<u8>)> = Vec::new();
    for kind in ["char", "uchar", "short", "ushort", "int", "uint", "long", "ulong", "half", "float", "double"] {
        let rows: Vec<String> = rows
            .iter()
            .zip([[0, 1, 90], [127, 5, 6], [100, 12, 33]])
            .map(|(row, [r, g, b])| format!("{row} {r} {g} {b}"))
            .collect();
        let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
        let text = ply(&format!("{kind} red, {kind} green, {kind} blue"), &rows, "", &corners);
        files.push((format!("{kind}.ply"), text.into()));
    }
    let rows = ["0 0 0 0 0 1 0.5 0.25 1 2 3 9", "1 0 0 0 0.6 0.8 0 1 4 5 6 9", "0.1 1 1e-3 1 0 0 1 0 7 8 9 9"];
    let vertex = "float nx, float ny, float nz, float s, float t, float foo_x, double foo_y, float foo_z, float q";
    let text = ply(vertex, &rows, "float id_0, uchar r, uchar g, uchar b", &["3 0 1 2 5 1 2 3", "3 2 1 0 6 4 5 6"]);
    files.push(("attributes.ply".into(), text.into()));
    let mut binary =
        b"ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty float x\nproperty double y\nproperty float z\n\
        element face 1\nproperty list int ushort vertex_index\nend_header\n"
            .to_vec();
    for x in [0.0_f32, 1.0, 2.5] {
        binary.extend([&x.to_be_bytes()[..], &f64::from(x * x).to_be_bytes(), &0.1_f32.to_be_bytes()].concat());
    }
    binary.extend([0, 0, 0, 3, 0, 0, 0, 1, 0, 2]);
    files.push(("binary.ply".into(), binary));
    let files: Vec<_> = files.iter().map(|(name, bytes)| (name.as_str(), bytes.clone(), Ply)).collect();
    compare(&files);
}

#[test]
fn serialized_agrees() {
    let file = |version| library(version, &[serialized(version, false, 1.0), serialized(version, true, 2.0)]);
    let at = |shape_index| Serialized { shape_index };
    compare(&[
        ("three.serialized", file(3), at(0)),
        ("three.serialized", file(3), at(1)),
        ("four.serialized", file(4), at(0)),
        ("four.serialized", file(4), at(1)),
    ]);
}

#[test]
fn files_from_elsewhere_agree() {
    let given = std::env::var_os("PATHSPACE_SHARED").map(PathBuf::from);
    let beside = ["../shared", "../../shared"].map(|relative| Path::new(env!("CARGO_MANIFEST_DIR")).join(relative));
    let models =
        given.into_iter().chain(beside).map(|folder| folder.join("scenes/mitsuba/bitterli-veach-bidir/models"));
    let Some(folder) = models.into_iter().find(|folder| folder.is_dir()) else {
        eprintln!("skipped: there is no folder of shared scenes (PATHSPACE_SHARED can name it)");
        return;
    };
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "obj"));
    paths.sort();
    let meshes: Vec<MeshData> =
        paths.iter().map(|path| read(path, Obj, &MeshOptions { flip_tex_coords: true }).unwrap()).collect();
    assert!(meshes.len() == 12 && meshes.iter().all(|mesh| !mesh.triangles.is_empty()));
    let Some(python) = python() else { return };
    let names: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
    for ((name, ours), theirs) in names.iter().zip(&meshes).zip(by_mitsuba(&python, &names)) {
        agree(name, ours, &theirs);
    }
}
