use glam::DVec3;
use serde_json::{Value, json};

use super::{assert_refused, read_bytes, read_json, triangle};
use crate::scene::description::{FilmSize, Lens, LightKind, Projection, SceneDescription};
use crate::scene::gltf::{ReadOptions, read_with};
use crate::spectrum::Rgb;

fn with_camera(camera: Value, node: Value) -> Value {
    let mut json = triangle();
    json["cameras"] = json!([camera]);
    json["nodes"] = json!([{"mesh": 0}, node]);
    json["nodes"][1]["camera"] = json!(0);
    json["scenes"][0]["nodes"] = json!([0, 1]);
    json
}

fn perspective() -> Value {
    json!({"type": "perspective", "perspective": {"yfov": 0.7, "aspectRatio": 1.5, "znear": 0.1}})
}

#[test]
fn perspective_cameras_look_along_minus_z() {
    let scene = read_json(&with_camera(perspective(), json!({"name": "Eye", "translation": [1, 2, 3]}))).unwrap();
    let sensor = scene.sensor.unwrap();
    assert_eq!((sensor.position, sensor.forward, sensor.up), (DVec3::new(1.0, 2.0, 3.0), -DVec3::Z, DVec3::Y));
    assert_eq!(sensor.projection, Projection::Perspective { vertical_fov: 0.7, aspect: Some(1.5), lens: None });
    assert_eq!(sensor.name, "Eye");
}

#[test]
fn orthographic_cameras_give_half_sizes() {
    let camera = json!({"type": "orthographic", "orthographic": {"xmag": 2.0, "ymag": 0.5, "znear": 0.1, "zfar": 10}});
    let sensor = read_json(&with_camera(camera, json!({}))).unwrap().sensor.unwrap();
    assert_eq!(sensor.projection, Projection::Orthographic { half_width: 2.0, half_height: 0.5 });
}

#[test]
fn scale_and_shear_do_not_reach_the_camera() {
    let half = 0.5_f64.sqrt();
    let mut json = with_camera(perspective(), json!({"rotation": [0, 0, half, half], "scale": [2, 1, 7]}));
    json["nodes"]
        .as_array_mut()
        .unwrap()
        .push(json!({"children": [1], "scale": [1, 5, 3], "rotation": [0.6, 0, 0, 0.8]}));
    json["scenes"][0]["nodes"] = json!([0, 2]);
    let sensor = read_json(&json).unwrap().sensor.unwrap();
    assert!((sensor.forward.length() - 1.0).abs() < 1e-14 && (sensor.up.length() - 1.0).abs() < 1e-14);
    assert!(sensor.forward.dot(sensor.up).abs() < 1e-14);
    // Turning by 2 asin 0.6 around x takes −Z to (0, 0.96, −0.28); the parent's scale comes before its turn.
    assert!((sensor.forward - DVec3::new(0.0, 0.96, -0.28)).length() < 1e-12, "{}", sensor.forward);
}

#[test]
fn cameras_can_be_chosen_by_name_or_number() {
    let mut json = with_camera(perspective(), json!({"name": "near"}));
    json["nodes"].as_array_mut().unwrap().push(json!({"camera": 0, "name": "far", "translation": [0, 0, 9]}));
    json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gltf");
    std::fs::write(&path, json.to_string()).unwrap();
    let name = |camera: Option<&str>| {
        let options = ReadOptions { camera: camera.map(String::from), ..ReadOptions::default() };
        read_with(&path, &options).map(|scene| (scene.sensor.unwrap().name, scene.warnings))
    };
    let (first, warnings) = name(None).unwrap();
    assert_eq!(first, "near");
    assert!(warnings[0].contains("\"far\""), "{warnings:?}");
    assert_eq!(name(Some("far")).unwrap(), ("far".to_string(), vec![]));
    assert_eq!(name(Some("1")).unwrap().0, "far");
    let error = name(Some("fer")).unwrap_err().to_string();
    assert!(error.contains("did you mean \"far\"?"), "{error}");
    assert!(name(Some("2")).is_err());
}

#[test]
fn the_cameras_film_overrides_the_scenes() {
    let mut json = with_camera(perspective(), json!({}));
    json["scenes"][0]["extras"] = json!({"pathspace": {"film": {"width": 8, "height": 9}}});
    assert_eq!(read_json(&json).unwrap().film, Some(FilmSize { width: 8, height: 9 }));
    json["cameras"][0]["extras"] = json!({"pathspace": {"film": {"width": 5, "height": 6}, "lens": {"aperture_radius": 0.5, "focus_distance": 4}}});
    let scene = read_json(&json).unwrap();
    assert_eq!(scene.film, Some(FilmSize { width: 5, height: 6 }));
    let Projection::Perspective { lens, .. } = scene.sensor.unwrap().projection else { panic!("not perspective") };
    assert_eq!(lens, Some(Lens { aperture_radius: 0.5, focus_distance: 4.0 }));
}

#[test]
fn impossible_cameras_are_refused() {
    for (fov, aspect, word) in [(0.0, 1.0, "yfov"), (3.2, 1.0, "yfov"), (1.0, -1.0, "aspectRatio")] {
        let camera = json!({"type": "perspective", "perspective": {"yfov": fov, "aspectRatio": aspect, "znear": 0.1}});
        assert_refused(&with_camera(camera, json!({})), &["cameras[0]", word]);
    }
    assert_refused(&with_camera(perspective(), json!({"scale": [0, 0, 0]})), &["nodes[1]", "direction"]);
}

fn with_light(light: Value, node: Value) -> SceneDescription {
    let mut json = triangle();
    json["extensions"] = json!({"KHR_lights_punctual": {"lights": [light]}});
    json["extensionsRequired"] = json!(["KHR_lights_punctual"]);
    json["nodes"] = json!([node]);
    json["nodes"][0]["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
    read_json(&json).unwrap()
}

#[test]
fn point_lights_take_candela_as_watt_per_steradian() {
    let light = json!({"type": "point", "intensity": 10, "color": [0.1, 0.2, 0.4], "name": "bulb", "range": 3});
    let scene = with_light(light, json!({"translation": [1, 2, 3], "scale": [5, 5, 5]}));
    let expected = LightKind::Point { position: DVec3::new(1.0, 2.0, 3.0), intensity: Rgb::new(1.0, 2.0, 4.0) };
    assert_eq!((scene.lights[0].name.as_str(), &scene.lights[0].kind), ("bulb", &expected));
    assert!(scene.warnings[0].contains("1 light with a range"), "{:?}", scene.warnings);
}

#[test]
fn spots_and_suns_shine_along_minus_z() {
    let turned = json!({"rotation": [-0.5_f64.sqrt(), 0, 0, 0.5_f64.sqrt()]});
    let scene = with_light(json!({"type": "spot", "spot": {"outerConeAngle": 0.5}}), turned.clone());
    let LightKind::Spot { direction, intensity, inner_angle, outer_angle, .. } = scene.lights[0].kind else {
        panic!("not a spot")
    };
    assert!((direction + DVec3::Y).length() < 1e-15, "{direction}");
    assert_eq!((intensity, inner_angle, outer_angle), (Rgb::WHITE, 0.0, 0.5));
    let scene = with_light(json!({"type": "directional", "intensity": 3}), turned);
    let LightKind::Directional { direction, irradiance } = scene.lights[0].kind else { panic!("not directional") };
    assert!((direction + DVec3::Y).length() < 1e-15, "{direction}");
    assert_eq!(irradiance, Rgb::grey(3.0));
}

#[test]
fn lights_that_do_not_exist_are_refused() {
    let mut json = triangle();
    json["nodes"][0]["extensions"] = json!({"KHR_lights_punctual": {"light": 4}});
    assert_refused(&json, &["nodes[0]"]);
    json["extensions"] =
        json!({"KHR_lights_punctual": {"lights": [{"type": "spot", "spot": {"outerConeAngle": 2.0}}]}});
    json["nodes"][0]["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
    assert_refused(&json, &["KHR_lights_punctual.lights[0]", "cone"]);
}

#[test]
fn a_scene_without_surfaces_is_a_scene() {
    let scene = read_bytes("empty.glb", &super::bad_files::glb(br#"{"asset":{"version":"2.0"}}"#, None)).unwrap();
    assert!(scene.meshes.is_empty() && scene.sensor.is_none() && scene.warnings.is_empty());
}
