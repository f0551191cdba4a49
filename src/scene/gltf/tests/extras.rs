use std::path::PathBuf;

use glam::DVec3;
use serde_json::{Value, json};

use super::{File, assert_refused, read_json, triangle};
use crate::scene::description::{FilmSize, Reference, RenderHints};
use crate::scene::meter::Meter;
use crate::spectrum::Rgb;

fn with_scene_extras(ours: Value) -> Value {
    let mut json = triangle();
    json["scenes"][0]["extras"] = json!({"other": 1, "pathspace": ours});
    json
}

#[test]
fn scenes_say_environment_film_length_and_reference() {
    let scene = read_json(&with_scene_extras(json!({
        "environment": [1, 2, 3],
        "film": {"width": 64, "height": 32},
        "render": {"max_length": 8},
        "reference": {"image": {"file": "reference.exr", "max_length": 8}},
    })))
    .unwrap();
    assert_eq!(scene.environment, Some(Rgb::new(1.0, 2.0, 3.0).into()));
    assert_eq!(scene.film, Some(FilmSize { width: 64, height: 32 }));
    assert_eq!(scene.render, RenderHints { max_length: Some(8) });
    let file = PathBuf::from("reference.exr");
    assert_eq!(scene.reference, Some(Reference::Image { file, max_length: Some(8) }));
}

#[test]
fn sensors_are_read_in_the_order_of_their_names() {
    let scene = read_json(&with_scene_extras(json!({"sensors": {
        "sky": "irradiance:0,0,1:0,0,2",
        "beam": "radiance:1,2,3:1,0,0",
    }})))
    .unwrap();
    let [beam, sky] = &scene.meters[..] else { panic!("{:?}", scene.meters) };
    let (position, direction) = (DVec3::new(1.0, 2.0, 3.0), DVec3::X);
    assert_eq!((beam.name.as_str(), &beam.meter), ("beam", &Meter::Radiance { position, direction }));
    assert_eq!((sky.name.as_str(), &sky.meter), ("sky", &Meter::Irradiance { position: DVec3::Z, normal: DVec3::Z }));
    assert!(read_json(&with_scene_extras(json!({}))).unwrap().meters.is_empty());
}

/// A square of two triangles, not at the origin, is found by the name of its node, with its transform.
#[test]
fn sensors_name_surfaces() {
    let mut file = File::default();
    let positions = file.vectors(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
    let indices = file.indices(&[0, 1, 2, 0, 2, 3]);
    let mut json = file.finish_with(json!({"attributes": {"POSITION": positions}, "indices": indices}));
    json["nodes"] = json!([{"mesh": 0, "name": "pane", "scale": [2, 3, 1], "translation": [0, 0, 5]}]);
    let mut with = |sensor: &str| {
        json["scenes"][0]["extras"] = json!({"pathspace": {"sensors": {"a": sensor}}});
        json.clone()
    };
    let scene = read_json(&with("flux:pane")).unwrap();
    let aim = scene.meters[0].meter.aim(&scene).unwrap();
    assert!((aim.sensor.position - DVec3::new(1.0, 1.5, 5.0)).length() < 1e-5, "{aim:?}");
    assert_eq!((aim.sensor.forward, aim.unit), (DVec3::Z, "W"));
    // A pixel holds the irradiance; the pane has 6 m².
    assert!((aim.scale - 6.0).abs() < 1e-12, "{aim:?}");
    assert_refused(&with("flux:pain"), &["scenes[0].extras.pathspace.sensors.a", "did you mean 'pane'?"]);
    assert_refused(&with("flx:pane"), &["scenes[0].extras.pathspace.sensors.a", "did you mean 'flux'?"]);
}

#[test]
fn unknown_keys_are_refused_with_the_nearest_name() {
    for (ours, words) in [
        (json!({"enviroment": [1, 1, 1]}), ["`enviroment`", "did you mean `environment`?"]),
        (json!({"film": {"width": 8, "hight": 8}}), ["`hight`", "did you mean `height`?"]),
        (json!({"reference": {"picture": {}}}), ["`picture`", "`"]),
    ] {
        assert_refused(&with_scene_extras(ours), &[&words[..], &["scenes[0].extras.pathspace"]].concat());
    }
    for (bsdf, words) in [
        (json!({"type": "difuse", "reflectance": [1, 1, 1]}), ["`difuse`", "did you mean `diffuse`?"]),
        (json!({"type": "diffuse", "reflectence": [1, 1, 1]}), ["`reflectence`", "did you mean `reflectance`?"]),
        (json!({"type": "conductor", "fresnel": {"eta": [1, 1, 1]}}), ["`fresnel`", "specular_tint"]),
        (json!({"reflectance": [1, 1, 1]}), ["missing field `type`", "scenes/README.md"]),
    ] {
        let mut json = triangle();
        json["materials"] = json!([{"name": "paint", "extras": {"pathspace": {"bsdf": bsdf}}}]);
        json["meshes"][0]["primitives"][0]["material"] = json!(0);
        assert_refused(&json, &[&words[..], &["materials[0] \"paint\".extras.pathspace"]].concat());
    }
}

#[test]
fn values_of_the_wrong_kind_are_refused() {
    assert_refused(&with_scene_extras(json!({"environment": [1, 2]})), &["invalid length 2"]);
    assert_refused(&with_scene_extras(json!({"film": {"width": -1, "height": 8}})), &["-1"]);
    assert_refused(&with_scene_extras(json!([])), &["extras.pathspace"]);
}

/// One node with a sphere and the triangle's mesh.
fn with_sphere(sphere: Value, node: Value) -> Value {
    let mut json = triangle();
    json["materials"] = json!([{"name": "a"}, {"name": "b"}]);
    json["meshes"][0]["primitives"][0]["material"] = json!(1);
    json["nodes"] = json!([node]);
    json["nodes"][0]["extras"] = json!({"pathspace": {"sphere": sphere}});
    json
}

#[test]
fn spheres_stand_in_for_their_mesh() {
    let node = json!({"mesh": 0, "name": "ball", "translation": [1, 2, 3], "scale": [-2, 2, 2], "rotation": [0.5, 0.5, 0.5, 0.5]});
    let scene = read_json(&with_sphere(json!({"radius": 1.5}), node)).unwrap();
    assert!(scene.meshes.is_empty());
    let sphere = &scene.spheres[0];
    assert_eq!((sphere.name.as_str(), sphere.centre, sphere.radius), ("ball", DVec3::new(1.0, 2.0, 3.0), 3.0));
    assert_eq!(scene.materials[sphere.material].name, "b");
}

#[test]
fn spheres_name_their_material_by_index_or_name() {
    for material in [json!(0), json!("a")] {
        let scene = read_json(&with_sphere(json!({"radius": 1, "material": material}), json!({}))).unwrap();
        assert_eq!(scene.materials[scene.spheres[0].material].name, "a");
    }
    assert_refused(
        &with_sphere(json!({"radius": 1, "material": "c"}), json!({})),
        &["no material \"c\"", "did you mean"],
    );
    assert_refused(&with_sphere(json!({"radius": 1, "material": 2}), json!({})), &["no material 2"]);
    assert_refused(&with_sphere(json!({"radius": 1}), json!({})), &["has no material"]);
}

#[test]
fn spheres_that_are_none_are_refused() {
    let mesh = |scale: Value| json!({"mesh": 0, "scale": scale});
    assert_refused(&with_sphere(json!({"radius": 1}), mesh(json!([1, 2, 1]))), &["nodes[0]", "not uniform"]);
    assert_refused(&with_sphere(json!({"radius": 1}), mesh(json!([0, 0, 0]))), &["nodes[0]", "zero"]);
    assert_refused(&with_sphere(json!({"radius": -1}), mesh(json!([1, 1, 1]))), &["radius is -1"]);
    assert_refused(&with_sphere(json!({"raduis": 1}), mesh(json!([1, 1, 1]))), &["did you mean `radius`?"]);
}
