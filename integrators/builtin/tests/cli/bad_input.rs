//! Every bad input ends with one line that says what to do, and never with a panic.

use std::fs;

use serde_json::{Value, json};

use crate::support::{Folder, fail, run, stderr};

/// Renders the changed scene, whose error must say `parts`.
fn refuses(change: impl FnOnce(&mut Value, &mut Vec<f32>), parts: &[&str]) {
    let folder = Folder::new();
    let scene = folder.scene(change);
    fail(&["render", &scene, "-o", &folder.path("a.exr"), "--spp", "1"], 1, parts);
    assert_eq!(folder.names(), ["scene.bin", "scene.gltf"], "nothing is left behind");
}

#[test]
fn the_scene_that_the_others_spoil_renders() {
    let folder = Folder::new();
    let scene = folder.scene(|_, _| ());
    crate::support::succeed(&["render", &scene, "-o", &folder.path("a.exr"), "--spp", "1"]);
}

#[test]
fn a_missing_file_and_a_missing_name() {
    let folder = Folder::new();
    let output = folder.path("a.exr");
    fail(&["render", &folder.path("none.gltf"), "-o", &output], 1, &["none.gltf: there is no such file"]);
    fail(&["render", "cornel_box", "-o", &output], 1, &["did you mean 'cornell_box'?"]);
    fail(&["render", &folder.path(""), "-o", &output], 1, &["holds no scene"]);
    fail(&["export", "cornel_box", &output], 1, &["did you mean 'cornell_box'?"]);
}

#[test]
fn a_file_that_is_not_gltf() {
    let folder = Folder::new();
    for (name, content) in [("a.gltf", &b"P6 3 3 255\n"[..]), ("a.glb", b""), ("a.gltf", b"{}"), ("a.txt", b"<scene/>")]
    {
        let scene = folder.write(name, content);
        fail(&["render", &scene, "-o", &folder.path("a.exr")], 1, &[name, "is not glTF"]);
    }
}

#[test]
fn a_truncated_buffer() {
    let folder = Folder::new();
    let scene = folder.scene(|_, _| ());
    fs::write(folder.path("scene.bin"), [0; 20]).unwrap();
    fail(&["render", &scene, "-o", &folder.path("a.exr")], 1, &["scene.gltf: buffers[0]", "is truncated"]);
}

#[test]
fn positions_that_are_not_numbers() {
    refuses(|_, positions| positions[4] = f32::NAN, &["scene.gltf: meshes[0]"]);
    refuses(|_, positions| positions[4] = f32::INFINITY, &["scene.gltf: meshes[0]"]);
}

#[test]
fn an_emitter_without_area() {
    refuses(|_, positions| positions.copy_within(0..6, 3), &["scene.gltf: "]);
}

#[test]
fn no_camera_and_nothing_to_frame() {
    refuses(
        |scene, _| {
            scene["scenes"][0] = json!({"nodes": [0], "extras": {"pathspace": {"environment": [1, 1, 1]}}});
            scene["nodes"] = json!([{}]);
        },
        &["scene.gltf: ", "camera"],
    );
}

#[test]
fn no_light() {
    refuses(
        |scene, _| scene["materials"][0]["emissiveFactor"] = json!([0, 0, 0]),
        &["scene.gltf: no light", "emission"],
    );
}

#[test]
fn only_lights_that_the_integrator_cannot_meet() {
    let folder = Folder::new();
    let scene = folder.scene(|scene, _| {
        scene["materials"][0]["emissiveFactor"] = json!([0, 0, 0]);
        scene["extensionsUsed"] = json!(["KHR_lights_punctual"]);
        scene["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
        scene["nodes"][1]["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
    });
    fail(&["render", &scene, "-i", "path_bsdf", "-o", &folder.path("a.exr")], 1, &["scene.gltf: ", "use `path`"]);
}

#[test]
fn unknown_integrators_and_settings() {
    let folder = Folder::new();
    let output = folder.path("a.exr");
    let with =
        |integrator: &str, parts: &[&str]| fail(&["render", "enclosure", "-i", integrator, "-o", &output], 2, parts);
    with("pth", &["unknown integrator 'pth'", "did you mean 'path'?"]);
    with("path:heuristik=balance", &["did you mean 'heuristic'?"]);
    with("path:heuristic=best", &["balance, power, maximum or cutoff"]);
    with("path:heuristic", &["write key=value"]);
    fail(&["render", "enclosure", "-i", "path:max_length=3", "--max-length", "4", "-o", &output], 2, &["contradicts"]);
}

#[test]
fn outputs_that_cannot_be_written() {
    let folder = Folder::new();
    let to = |output: &str, parts: &[&str]| fail(&["render", "enclosure", "-o", output], 1, parts);
    to(&folder.path("no/a.exr"), &["no/a.exr", "does not exist"]);
    to(&folder.path("a.jpg"), &["a.jpg", ".exr", ".png"]);
    to(&folder.path(""), &["folder"]);
    to("/proc/a.exr", &["/proc/a.exr", "cannot be written"]);
    let image = folder.path("a.exr");
    fail(&["render", "enclosure", "-o", &image, "--state", &folder.path("no/a.film")], 1, &["no/a.film"]);
    fail(&["render", "enclosure", "-o", &image, "--state", &folder.path("scene.bin")], 2, &["must end with .film"]);
    let blocked = folder.write("blocked", "");
    fail(&["export", "enclosure", &blocked], 1, &["blocked", "cannot be written"]);
}

#[test]
fn a_film_without_pixels_or_with_too_many() {
    let folder = Folder::new();
    let output = folder.path("a.exr");
    fail(&["render", "enclosure", "--film", "0x0", "-o", &output], 1, &["0×0 pixels", "between 1 and 65535"]);
    fail(&["render", "enclosure", "--film", "65535x65535", "-o", &output], 1, &["65535"]);
    refuses(|scene, _| scene["scenes"][0]["extras"]["pathspace"]["film"]["width"] = json!(0), &["scene.gltf: ", "0"]);
}

#[test]
fn indices_out_of_range() {
    refuses(|scene, _| scene["indices"] = json!([0, 1, 3]), &["scene.gltf: meshes[0]", "3"]);
    refuses(|scene, _| scene["nodes"][0]["mesh"] = json!(7), &["scene.gltf: nodes[0]"]);
}

#[test]
fn nodes_in_a_circle() {
    let circle = |scene: &mut Value, _: &mut Vec<f32>| {
        scene["nodes"] = json!([{"mesh": 0, "children": [2]}, {"camera": 0}, {"children": [0]}]);
    };
    refuses(circle, &["scene.gltf: nodes["]);
}

#[test]
fn a_camera_that_is_not_there_and_a_pixel_outside() {
    let folder = Folder::new();
    let output = folder.path("a.exr");
    fail(&["render", "cornell_box", "--camera", "7", "-o", &output], 1, &["camera"]);
    fail(&["render", "cornell_box", "--replay", "0:256,0:0"], 2, &["256,0", "255,255"]);
}

#[test]
fn command_lines_that_make_no_sense() {
    for args in [
        &["rendr"][..],
        &["render"],
        &["render", "enclosure"],
        &["render", "enclosure", "-o", "a.exr", "--spp", "0"],
        &["render", "enclosure", "-o", "a.exr", "--seconds", "-1"],
        &["render", "enclosure", "-o", "a.exr", "--seconds", "nan"],
        &["render", "enclosure", "-o", "a.exr", "--max-length", "0"],
        &["render", "enclosure", "-o", "a.exr", "--film", "12"],
        &["render", "enclosure", "-o", "a.exr", "--spp", "1", "--seconds", "1"],
        &["render", "enclosure", "--replay", "1:2"],
    ] {
        let output = run(args);
        assert_eq!(output.status.code(), Some(2), "{args:?}");
        assert!(stderr(&output).starts_with("error: ") || args.len() == 1, "{args:?}: {}", stderr(&output));
    }
}
