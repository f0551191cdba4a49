//! Emitters without a shape, cameras and films.

use glam::{DVec2, DVec3};

use super::super::{ReadOptions, from_bytes};
use super::{document, refusal, scene};
use crate::scene::description::{
    EnvironmentDescription, FilmSize, LightKind, PixelFilter, Projection, ShapeIndex, Target,
};
use crate::spectrum::Rgb;

#[test]
fn lights_have_mitsubas_defaults() {
    let scene = scene(
        "<emitter type=\"point\"/><emitter type=\"spot\"/><emitter type=\"directional\"/><emitter type=\"constant\"/>",
    );
    let kinds: Vec<_> = scene.lights.into_iter().map(|light| light.kind).collect();
    assert_eq!(kinds[0], LightKind::Point { position: DVec3::ZERO, intensity: Rgb::WHITE });
    let spot = LightKind::Spot {
        position: DVec3::ZERO,
        direction: DVec3::Z,
        intensity: Rgb::WHITE,
        inner_angle: 15.0_f64.to_radians(),
        outer_angle: 20.0_f64.to_radians(),
    };
    assert_eq!(kinds[1], spot);
    assert_eq!(kinds[2], LightKind::Directional { direction: DVec3::Z, irradiance: Rgb::WHITE });
    assert_eq!(scene.environment, Some(EnvironmentDescription::Constant(Rgb::WHITE)));
}

fn fov(inner: &str) -> f64 {
    let film =
        "<film type=\"hdrfilm\"><integer name=\"width\" value=\"200\"/><integer name=\"height\" value=\"100\"/></film>";
    let scene = scene(&format!("<sensor type=\"perspective\">{inner}{film}</sensor>"));
    match scene.sensor.expect("a camera").projection {
        Projection::Perspective { vertical_fov, .. } => (0.5 * vertical_fov).tan(),
        _ => panic!("no perspective"),
    }
}

#[test]
fn fields_of_view_lie_along_their_axis() {
    let along =
        |axis: &str| fov(&format!("<float name=\"fov\" value=\"90\"/><string name=\"fov_axis\" value=\"{axis}\"/>"));
    for (axis, half_height) in
        [("x", 0.5), ("larger", 0.5), ("y", 1.0), ("smaller", 1.0), ("diagonal", 1.0 / 5.0_f64.sqrt())]
    {
        assert!((along(axis) - half_height).abs() < 1e-12, "{axis}: {}", along(axis));
    }
    // 43.27 mm of diagonal seen from 50 mm.
    assert!((fov("") - 43.266_615_3 / 100.0 / 5.0_f64.sqrt()).abs() < 1e-9);
}

#[test]
fn films_have_a_size_a_crop_and_a_filter() {
    let film =
        |inner: &str| scene(&format!("<sensor type=\"perspective\"><film type=\"hdrfilm\">{inner}</film></sensor>"));
    let plain = film("");
    assert_eq!(plain.film, Some(FilmSize { width: 768, height: 576 }));
    assert_eq!(plain.filter, PixelFilter::Gaussian { stddev: 0.5 });
    let cropped = film(
        "<integer name=\"width\" value=\"100\"/><integer name=\"height\" value=\"50\"/>\
         <integer name=\"crop_width\" value=\"10\"/><integer name=\"crop_height\" value=\"20\"/>\
         <integer name=\"crop_offset_x\" value=\"30\"/><integer name=\"crop_offset_y\" value=\"25\"/><rfilter type=\"tent\"/>",
    );
    assert_eq!(cropped.film, Some(FilmSize { width: 10, height: 20 }));
    assert_eq!(cropped.filter, PixelFilter::Tent { radius: 1.0 });
    assert_eq!(cropped.sensor.expect("a camera").window, [DVec2::new(0.3, 0.5), DVec2::new(0.4, 0.9)]);
}

#[test]
fn cameras_are_chosen_by_id_or_number() {
    let two = "<sensor type=\"perspective\" id=\"a\"/><sensor type=\"orthographic\" id=\"b\">\
        <transform name=\"to_world\"><scale x=\"3\" y=\"3\"/></transform></sensor>";
    let choose = |camera: &str| {
        let options = ReadOptions { camera: Some(camera.into()), parameters: Vec::new() };
        from_bytes(document(two).as_bytes(), "a.xml".as_ref(), &options)
            .map(|scene| scene.sensor.expect("a camera"))
            .map_err(|error| error.to_string())
    };
    assert_eq!(choose("a").expect("the first").name, "a");
    assert_eq!(choose("b"), choose("1"));
    let second = choose("1").expect("the second");
    assert_eq!(second.projection, Projection::Orthographic { half_width: 3.0, half_height: 3.0 * 576.0 / 768.0 });
    assert!(choose("c").expect_err("there is none").contains("no sensor is called \"c\""));
}

#[test]
fn meters_sit_on_shapes_or_look_from_far_away() {
    let film = "<film type=\"hdrfilm\"/>";
    let on_disk = scene(&format!(
        "<shape type=\"disk\"/><shape type=\"disk\"><sensor type=\"irradiancemeter\">{film}</sensor></shape>"
    ));
    let projection = on_disk.sensor.expect("a meter").projection;
    assert_eq!(projection, Projection::Surface { shape: ShapeIndex::Disk(1) });
    let distant = |target: &str| {
        let direction = "<vector name=\"direction\" value=\"0 0 -2\"/>";
        let sensor = scene(&format!("<sensor type=\"distant\">{direction}{target}{film}</sensor>")).sensor;
        let sensor = sensor.expect("a sensor");
        assert_eq!(sensor.forward, -DVec3::Z);
        match sensor.projection {
            Projection::Distant { target } => target,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(distant(""), Target::Scene);
    assert_eq!(distant("<point name=\"target\" value=\"1 2 3\"/>"), Target::Point(DVec3::new(1.0, 2.0, 3.0)));
    let rectangle = "<shape type=\"rectangle\" name=\"target\"><transform name=\"to_world\"><scale value=\"2\"/></transform></shape>";
    let expected = Target::Parallelogram { centre: DVec3::ZERO, u: DVec3::X * 2.0, v: DVec3::Y * 2.0 };
    assert_eq!(distant(rectangle), expected);
    let ray = scene(
        "<sensor type=\"radiancemeter\"><point name=\"origin\" value=\"1\"/><vector name=\"direction\" value=\"0 3 0\"/></sensor>",
    );
    let ray = ray.sensor.expect("a meter");
    assert_eq!((ray.position, ray.forward, ray.projection), (DVec3::ONE, DVec3::Y, Projection::Ray));
}

#[test]
fn integrators_say_how_long_paths_may_be() {
    let longest = |inner: &str| scene(&format!("<integrator type=\"path\">{inner}</integrator>")).render.max_length;
    assert_eq!(longest("<integer name=\"max_depth\" value=\"7\"/><integer name=\"rr_depth\" value=\"9\"/>"), Some(7));
    assert_eq!(longest("<integer name=\"max_depth\" value=\"-1\"/>"), None);
    assert_eq!(longest(""), None);
    let unknown = scene("<integrator type=\"photonmapper\"><integer name=\"photons\" value=\"7\"/></integrator>");
    assert!(
        unknown.warnings[0].starts_with("room/scene.xml:2: <integrator type=\"photonmapper\">"),
        "{:?}",
        unknown.warnings
    );
}

#[test]
fn cameras_that_scale_or_mirror_are_refused() {
    let with = |operation: &str| {
        format!("<sensor type=\"perspective\"><transform name=\"to_world\">{operation}</transform></sensor>")
    };
    assert!(refusal(&with("<scale value=\"2\"/>")).contains("scales a camera"));
    assert!(refusal(&with("<scale x=\"-1\"/>")).contains("mirrors the image"));
    let turned = scene(&with("<rotate y=\"1\" angle=\"180\"/>")).sensor.expect("a camera");
    assert!(turned.forward.distance(-DVec3::Z) < 1e-15 && turned.up == DVec3::Y, "{turned:?}");
}
