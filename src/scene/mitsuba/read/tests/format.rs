//! Parameters, references, transforms, colours.

use glam::{DMat4, DVec3, DVec4};

use super::super::number::vector;
use super::super::spectrum::{Role, Spectrum};
use super::super::tree;
use super::{bsdf, read_text, scene, scene_with};
use crate::scene::description::{BsdfDescription, LightKind};
use crate::spectrum::Rgb;

fn position(scene: &crate::scene::SceneDescription) -> DVec3 {
    match scene.lights[0].kind {
        LightKind::Point { position, .. } => position,
        _ => panic!("no point light"),
    }
}

/// Where a transform takes the origin, by the light that stands there.
fn moved(operations: &str) -> DVec3 {
    position(&scene(&format!(
        "<emitter type=\"point\"><transform name=\"to_world\">{operations}</transform></emitter>"
    )))
}

#[test]
fn parameters_come_from_the_command_line_else_from_defaults() {
    let body = "<default name=\"x\" value=\"1\"/><default name=\"xy\" value=\"2\"/>\
        <emitter type=\"point\"><point name=\"position\" x=\"$x\" y=\"$xy\" z=\"$x$x\"/></emitter>";
    assert_eq!(position(&scene(body)), DVec3::new(1.0, 2.0, 11.0));
    let other = scene_with(body, &[("x", "3")]);
    assert_eq!(position(&other), DVec3::new(3.0, 2.0, 33.0));
    let recorded: Vec<_> = other.parameters.iter().map(|(name, value)| format!("{name}={value}")).collect();
    assert_eq!(recorded, ["x=3", "xy=2"]);
}

#[test]
fn a_backslash_keeps_a_dollar() {
    let scene = scene("<shape type=\"sphere\" id=\"\\$a\"/>");
    assert_eq!(scene.spheres[0].name, "$a");
}

#[test]
fn references_may_come_before_what_they_refer_to_and_aliases_name_it_twice() {
    let scene = scene(
        "<shape type=\"sphere\"><ref id=\"later\"/></shape><shape type=\"sphere\"><ref name=\"bsdf\" id=\"other\"/></shape>\
         <bsdf type=\"diffuse\" id=\"later\"><rgb name=\"reflectance\" value=\"0.1 0.2 0.3\"/></bsdf>\
         <alias id=\"later\" as=\"other\"/>",
    );
    assert_eq!(scene.materials.len(), 1);
    assert_eq!(scene.materials[0].name, "later");
    let expected = BsdfDescription::Diffuse { reflectance: Rgb::new(0.1, 0.2, 0.3).into() };
    assert_eq!(scene.materials[0].bsdf, expected);
}

#[test]
fn transforms_apply_one_after_the_other() {
    assert_eq!(moved("<translate x=\"1\" y=\"2\"/><scale value=\"2\"/>"), DVec3::new(2.0, 4.0, 0.0));
    assert_eq!(moved("<scale value=\"2, 3, 4\"/><translate value=\"1 2 3\"/>"), DVec3::new(1.0, 2.0, 3.0));
    let turned = moved("<translate x=\"1\"/><rotate z=\"1\" angle=\"90\"/>");
    assert!(turned.distance(DVec3::Y) < 1e-15, "{turned}");
    // Mitsuba 3.9.1 does not normalise the axis.
    let long = moved("<translate x=\"1\"/><rotate x=\"1\" y=\"2\" angle=\"30\"/>");
    assert!(long.distance(DVec3::new(1.0, 0.267_949_192, -1.0)) < 1e-9, "{long}");
    let by_nine = moved("<translate x=\"1\"/><matrix value=\"1 0 0  2 0 0  3 0 0\"/>");
    assert_eq!(by_nine, DVec3::new(1.0, 2.0, 3.0));
    let by_sixteen = moved("<matrix value=\"1 0 0 5 0 1 0 6 0 0 1 7 0 0 0 1\"/>");
    assert_eq!(by_sixteen, DVec3::new(5.0, 6.0, 7.0));
}

#[test]
fn lookat_has_x_to_the_left() {
    let element = tree::parse(
        b"<transform><lookat origin=\"1,2,3\" target=\"1,2,13\" up=\"0 1 0\"/></transform>",
        &std::sync::Arc::from(std::path::Path::new("a.xml")),
    );
    let matrix = super::super::transform::compose(&element.expect("it is XML"), &mut Default::default())
        .expect("it is a transform");
    assert_eq!(matrix, DMat4::from_cols(DVec4::X, DVec4::Y, DVec4::Z, DVec4::new(1.0, 2.0, 3.0, 1.0)));
}

#[test]
fn old_files_are_upgraded_as_mitsuba_does() {
    let text = "<scene version=\"0.6.0\"><shape type=\"sphere\"><transform name=\"toWorld\"><translate x=\"4\"/></transform>\
        <bsdf type=\"dielectric\"><float name=\"intIOR\" value=\"1.7\"/><float name=\"extIOR\" value=\"1.1\"/></bsdf></shape>\
        <shape type=\"sphere\"><bsdf type=\"diffuse\"><texture name=\"diffuseReflectance\" type=\"checkerboard\">\
        <float name=\"uscale\" value=\"3\"/><float name=\"voffset\" value=\"2\"/></texture></bsdf></shape></scene>";
    let scene = read_text(text, &[]).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(scene.spheres[0].centre, DVec3::new(4.0, 0.0, 0.0));
    assert_eq!(scene.materials[0].bsdf, BsdfDescription::dielectric(1.7, 1.1));
    let BsdfDescription::Diffuse { reflectance } = &scene.materials[1].bsdf else { panic!("not diffuse") };
    let Some(crate::scene::texture::Texture::Checkerboard { to_uv, .. }) = reflectance.texture() else {
        panic!("no checkerboard")
    };
    assert_eq!(to_uv.transform_point2(glam::DVec2::ONE), glam::DVec2::new(3.0, 3.0));
}

#[test]
fn colours_have_their_forms() {
    let reflectance = |element: &str| match bsdf(&format!("<bsdf type=\"diffuse\">{element}</bsdf>")) {
        BsdfDescription::Diffuse { reflectance } => *reflectance.constant().expect("a constant"),
        _ => panic!("not diffuse"),
    };
    assert_eq!(reflectance("<rgb name=\"reflectance\" value=\"0.25\"/>"), Rgb::grey(0.25));
    assert_eq!(reflectance("<float name=\"reflectance\" value=\"0.25\"/>"), Rgb::grey(0.25));
    assert_eq!(reflectance("<spectrum name=\"reflectance\" value=\"0.25\"/>"), Rgb::grey(0.25));
    assert_eq!(reflectance("<rgb name=\"reflectance\" value=\"#3300ff\"/>"), Rgb::new(0.2, 0.0, 1.0));
    let srgb = reflectance("<srgb name=\"reflectance\" value=\"#80ffff\"/>");
    assert!((srgb.r - 0.215_860_500).abs() < 1e-8, "{srgb:?}");
    let object =
        "<spectrum type=\"srgb\" name=\"reflectance\"><rgb name=\"color\" value=\"0.1, 0.2, 0.3\"/></spectrum>";
    assert_eq!(reflectance(object), Rgb::new(0.1, 0.2, 0.3));
    let uniform = "<spectrum type=\"uniform\" name=\"reflectance\"><float name=\"value\" value=\"0.5\"/></spectrum>";
    assert_eq!(reflectance(uniform), Rgb::grey(0.5));
}

/// Numbers of Mitsuba 3.9.1, `scalar_rgb`.
#[test]
fn spectra_become_the_colours_that_mitsuba_makes_of_them() {
    let element = tree::parse(b"<spectrum/>", &std::sync::Arc::from(std::path::Path::new("a.xml"))).expect("XML");
    let pairs = Spectrum::from_pairs("400:0.2, 500:0.9, 600:0.4, 700:0.1", &element.place()).expect("pairs");
    let near = |spectrum: &Spectrum, role, expected: [f64; 3]| {
        let rgb = spectrum.rgb(role).to_array();
        let off = rgb.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-6, "{rgb:?} instead of {expected:?}");
    };
    near(&pairs, Role::Share, [0.195_079_01, 0.728_061_5, 0.569_967_3]);
    near(&pairs, Role::Emission, [0.281_913_76, 0.690_227_57, 0.507_869_66]);
    near(&Spectrum::Uniform(2.0), Role::Emission, [2.409_587_9, 1.896_582, 1.817_832_1]);
    assert_eq!(vector("1 2 3", &element.place()).expect("three"), DVec3::new(1.0, 2.0, 3.0));
}

#[test]
fn included_files_are_read_as_if_they_stood_there() {
    let folder = tempfile::tempdir().expect("a folder");
    let below = folder.path().join("parts");
    std::fs::create_dir(&below).expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("a file");
    write(
        "scene.xml",
        "<scene version=\"3.0.0\"><default name=\"r\" value=\"2\"/><include filename=\"parts/a.xml\"/></scene>",
    );
    write("parts/a.xml", "<scene version=\"0.6.0\"><include filename=\"b.xml\"/></scene>");
    write("parts/b.xml", "<shape version=\"3.0.0\" type=\"sphere\"><float name=\"radius\" value=\"$r\"/></shape>");
    let scene = super::super::read(&folder.path().join("scene.xml")).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(scene.spheres[0].radius, 2.0);
}
