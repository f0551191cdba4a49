//! Long paths: series that hardly converge, and light that is found late.

use glam::DVec3;

use super::super::case::{Case, Stage, Subject};
use super::case;
use super::scenery::{ASPECT, FILM, unit_enclosure};
use crate::scene::SceneDescription;
use crate::scene::description::{BsdfDescription, ConductorFresnel};
use crate::spectrum::Rgb;
use crate::testing::scenes::{cuboid, diffuse, material, pinhole, rectangle};

pub(super) fn cases() -> Vec<Case> {
    let new = |name, sweep: (&'static str, &[f64]), stage| case("stiff", name, sweep, Subject::Scene(stage));
    vec![
        new("white enclosure", ("1 - albedo", &[0.5, 0.1, 1e-2, 1e-3, 1e-4]), |absorbed| {
            Stage::new(unit_enclosure(1.0 - absorbed), 1.0)
        })
        .about("closed diffuse box of emission 1 - albedo: L = 1; paths have 1/(1 - albedo) vertices"),
        new("mirror enclosure", ("1 - reflectance", &[0.5, 0.1, 1e-2, 1e-3, 1e-4]), mirror_enclosure)
            .about("closed box of emitting mirrors: L = emission/(1 - reflectance) = 1"),
        new("parallel mirrors", ("gap over width", &[1.0, 0.1, 1e-2, 1e-3, 1e-4]), parallel_mirrors)
            .about("between two lossless mirrors in a constant environment: L = 1, after about width/gap reflections"),
        new("total reflection", ("index", &[1.1, 1.2, 1.5, 2.0, 10.0, 100.0]), glass_cube)
            .about("out of the corner of a glass cube in a constant environment: L = index² as long as light gets out, then 0: paths are trapped for ever"),
        new("glass panes", ("panes", &[1.0, 10.0, 100.0, 1000.0]), panes)
            .about("through lossless panes in a constant environment: L = 1"),
        new("periscope", ("mirrors", &[1.0, 4.0, 20.0, 100.0]), periscope)
            .about("a lamp seen by way of mirrors of reflectance 0.99 each: L = 0.99^mirrors"),
    ]
}

fn mirror(reflectance: f64) -> BsdfDescription {
    BsdfDescription::conductor(ConductorFresnel::Tint { specular_tint: Rgb::grey(reflectance) })
}

fn mirror_enclosure(absorbed: f64) -> Stage {
    let mut scene = unit_enclosure(0.5);
    scene.materials = vec![material("wall", mirror(1.0 - absorbed), Rgb::grey(absorbed))];
    Stage::new(scene, 1.0)
}

fn parallel_mirrors(gap: f64) -> Stage {
    let z = 0.5 * gap;
    let meshes = vec![
        rectangle("below", DVec3::new(-0.5, -0.5, -z), DVec3::X, DVec3::Y, 0),
        rectangle("above", DVec3::new(-0.5, -0.5, z), DVec3::Y, DVec3::X, 0),
    ];
    Stage::new(
        furnace(meshes, mirror(1.0), pinhole(DVec3::new(0.1, 0.05, 0.1 * gap), DVec3::new(1.0, 0.3, 0.0), 60.0)),
        1.0,
    )
}

/// A scene of one material in a constant environment.
fn furnace(
    meshes: Vec<crate::scene::description::Mesh>,
    bsdf: BsdfDescription,
    camera: crate::scene::description::SensorDescription,
) -> SceneDescription {
    SceneDescription {
        name: "furnace".into(),
        meshes,
        materials: vec![material("everything", bsdf, Rgb::BLACK)],
        environment: Some(Rgb::WHITE.into()),
        sensor: Some(camera),
        film: Some(FILM),
        ..SceneDescription::default()
    }
}

/// Components of a direction change their sign by reflection and nothing else: light gets out where the largest passes a face.
fn glass_cube(index: f64) -> Stage {
    let cube = cuboid("cube", DVec3::splat(-1.0), DVec3::ONE, false, 0);
    let camera = pinhole(DVec3::new(0.1, 0.2, 0.3), DVec3::new(1.1, 1.2, 1.3), 10.0);
    let critical = (1.0 - 1.0 / (index * index)).sqrt();
    let radiance = |direction: DVec3| if direction.abs().max_element() > critical { index * index } else { 0.0 };
    let truth = super::super::truth::image_mean(&camera, ASPECT, radiance);
    Stage::new(furnace(vec![cube], BsdfDescription::dielectric(index, 1.0), camera), truth)
}

fn panes(count: f64) -> Stage {
    let pane = |i: u32| {
        let z = f64::from(i) / count;
        cuboid("pane", DVec3::new(-0.5, -0.5, -z - 0.5 / count), DVec3::new(0.5, 0.5, -z), false, 0)
    };
    let camera = pinhole(DVec3::new(0.05, 0.02, 0.3), DVec3::new(0.0, 0.0, -1.0), 30.0);
    let panes = (0..count as u32).map(pane).collect();
    Stage::new(furnace(panes, BsdfDescription::dielectric(1.5, 1.0), camera), 1.0)
}

/// A staircase of mirrors at 45°, one unit apart, and a lamp behind the last.
fn periscope(mirrors: f64) -> Stage {
    let count = mirrors as u32;
    let mut meshes = Vec::new();
    let mut at = DVec3::X;
    let mut heading = DVec3::X;
    for _ in 0..count {
        let next = if heading == DVec3::X { DVec3::Y } else { DVec3::X };
        let normal = (next - heading).normalize();
        let along = DVec3::Z.cross(normal);
        meshes.push(rectangle("mirror", at - along * 0.3 - DVec3::Z * 0.3, along * 0.6, DVec3::Z * 0.6, 0));
        heading = next;
        at += heading;
    }
    let across = DVec3::Z.cross(heading);
    // Faces the light's way back.
    meshes.push(rectangle("lamp", at + across * 0.3 - DVec3::Z * 0.3, across * -0.6, DVec3::Z * 0.6, 1));
    let fov = (0.2 / (mirrors + 1.0)).to_degrees();
    let scene = SceneDescription {
        name: "periscope".into(),
        meshes,
        materials: vec![material("mirror", mirror(0.99), Rgb::BLACK), diffuse("lamp", Rgb::BLACK, Rgb::WHITE)],
        sensor: Some(pinhole(DVec3::ZERO, DVec3::X, fov)),
        film: Some(FILM),
        ..SceneDescription::default()
    };
    Stage::new(scene, libm::pow(0.99, mirrors))
}
