//! Sizes and places far from one.

use std::path::Path;

use base64::prelude::{BASE64_STANDARD, Engine as _};
use glam::DVec3;

use super::super::case::{Case, Stage, Subject};
use super::case;
use super::scenery::{FILM, FLOOR, floor, floor_mean, isotropic, moved, scaled, unit_enclosure};
use crate::scene::SceneDescription;
use crate::scene::description::Sphere;
use crate::spectrum::Rgb;
use crate::testing::scenes::{cabinet, diffuse, pinhole, rectangle};

pub(super) fn cases() -> Vec<Case> {
    let new = |name, sweep: (&'static str, &[f64]), stage| case("scale", name, sweep, Subject::Scene(stage));
    vec![
        new("small scene", ("scale", &[1.0, 1e-3, 1e-6, 1e-9]), |scale| {
            Stage::as_tame(scaled(cabinet(FILM), scale), 1.0)
        })
        .about("all materials and lights under a thin lens, everything scaled: the same image"),
        new("large scene", ("scale", &[1.0, 1e3, 1e6, 1e9]), |scale| {
            Stage::as_tame(scaled(cabinet(FILM), scale), 1.0)
        })
        .about("the same, the other way"),
        new("far away", ("distance over size", &[0.0, 1e2, 1e4, 1e6, 1e7]), |distance| {
            Stage::as_tame(moved(cabinet(FILM), DVec3::new(0.6, -0.64, 0.48) * 2.0 * distance), 1.0)
        })
        .about("the same, moved: the same image"),
        new("by a parent node", ("distance over size", &[0.0, 1e2, 1e4, 1e6, 1e7]), by_a_parent)
            .about("a closed box and its camera below a node of a glTF file that moves them far away: L = 1"),
        new("small beside large", ("size", &[1.0, 1e-2, 1e-4, 1e-6]), small_beside_large)
            .about("a floor under a ball lamp, beside a black wall 1000 times as large as the lamp's height at size one: E = Φ cos θ / (4π r²)"),
        new("small in a box", ("size", &[1e-1, 1e-3, 1e-6, 1e-9]), |size| {
            let mut scene = unit_enclosure(0.5);
            scene.spheres.push(Sphere::new("grain", DVec3::new(0.1, 0.05, -0.2), 0.2 * size, 0));
            let from = DVec3::new(0.1, 0.05, -0.2) + DVec3::new(0.3, 0.2, 0.9) * size;
            scene.sensor = Some(pinhole(from, DVec3::new(0.1, 0.05, -0.2), 12.0));
            Stage::new(scene, 1.0)
        })
        .about("a grain of dust before a camera in the closed box: L = 1"),
        new("huge surroundings", ("radius", &[10.0, 1e3, 1e6, 1e9, 1e12]), huge_surroundings)
            .about("a convex diffuse ball inside an emitting sphere: L = albedo"),
    ]
}

/// The children's own places are small, and lose nothing by the parent's: transforms are composed in double precision.
fn by_a_parent(distance: f64) -> Stage {
    let corners = (0..8_u8).flat_map(|i| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { -1.0_f32 } else { 1.0 }));
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    // The inside is the front.
    let indices = faces.iter().flat_map(|&[a, b, c, d]: &[u16; 4]| [a, c, b, a, d, c]);
    let bytes: Vec<u8> = corners.flat_map(f32::to_le_bytes).chain(indices.flat_map(u16::to_le_bytes)).collect();
    let uri = format!("data:application/octet-stream;base64,{}", BASE64_STANDARD.encode(&bytes));
    let place = DVec3::new(1.2, -1.28, 0.96) * distance;
    let diffuse = serde_json::json!({"type": "diffuse", "reflectance": [0.5, 0.5, 0.5]});
    let document = serde_json::json!({
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [
            {"translation": place.to_array(), "children": [1, 2]},
            {"mesh": 0},
            {"camera": 0, "translation": [0.3, 0.1, 0.8], "rotation": [0.0, 0.6, 0.0, 0.8]},
        ],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}],
        "materials": [{"emissiveFactor": [0.5, 0.5, 0.5], "extras": {"pathspace": {"bsdf": diffuse}}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": [-1, -1, -1], "max": [1, 1, 1]},
            {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 96},
            {"buffer": 0, "byteOffset": 96, "byteLength": 72},
        ],
        "buffers": [{"byteLength": bytes.len(), "uri": uri}],
    });
    let text = document.to_string();
    let read = crate::scene::gltf::from_bytes(text.as_bytes(), Path::new("box.gltf"), &Default::default());
    let scene = SceneDescription { film: Some(FILM), ..read.expect("the text is a scene") };
    Stage::new(scene, 1.0)
}

fn small_beside_large(size: f64) -> Stage {
    const FLUX: f64 = 1.0;
    let (lamp, radius) = (DVec3::new(0.2, 0.1, 1.5), 0.2);
    let mut scene = floor();
    scene.materials.push(diffuse("lamp", Rgb::BLACK, emission_of_ball(FLUX, radius)));
    scene.spheres.push(Sphere::new("lamp", lamp, radius, 1));
    let mut scene = scaled(scene, size);
    scene.materials.push(diffuse("wall", Rgb::BLACK, Rgb::BLACK));
    scene.meshes.push(rectangle("wall", DVec3::new(3.0, -10.0, -10.0), DVec3::Y * 1000.0, DVec3::Z * 1000.0, 2));
    Stage { alike: true, ..Stage::new(scene, floor_mean(20, |at| isotropic(FLUX, lamp, at))) }
}

/// The radiance of a ball that shines the flux Φ: `Φ / (π · 4π r²)`.
pub(super) fn emission_of_ball(flux: f64, radius: f64) -> Rgb {
    let pi = std::f64::consts::PI;
    Rgb::grey(flux / (4.0 * pi * pi * radius * radius))
}

fn huge_surroundings(radius: f64) -> Stage {
    let around = Sphere { inward: true, ..Sphere::new("around", DVec3::ZERO, radius, 1) };
    let scene = SceneDescription {
        name: "surroundings".into(),
        spheres: vec![Sphere::new("ball", DVec3::ZERO, 0.5, 0), around],
        materials: vec![diffuse("ball", Rgb::grey(FLOOR), Rgb::BLACK), diffuse("around", Rgb::BLACK, Rgb::WHITE)],
        sensor: Some(pinhole(DVec3::new(0.0, 0.5, 1.5), DVec3::ZERO, 10.0)),
        film: Some(FILM),
        ..SceneDescription::default()
    };
    Stage::new(scene, FLOOR)
}
