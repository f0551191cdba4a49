//! Sizes and places far from one.

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

fn small_beside_large(size: f64) -> Stage {
    const FLUX: f64 = 1.0;
    let (lamp, radius) = (DVec3::new(0.2, 0.1, 1.5), 0.2);
    let mut scene = floor();
    scene.materials.push(diffuse("lamp", Rgb::BLACK, emission_of_ball(FLUX, radius)));
    scene.spheres.push(Sphere::new("lamp", lamp, radius, 1));
    let mut scene = scaled(scene, size);
    scene.materials.push(diffuse("wall", Rgb::BLACK, Rgb::BLACK));
    scene.meshes.push(rectangle("wall", DVec3::new(3.0, -10.0, -10.0), DVec3::Y * 1000.0, DVec3::Z * 1000.0, 2));
    Stage::new(scene, floor_mean(20, |at| isotropic(FLUX, lamp, at)))
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
