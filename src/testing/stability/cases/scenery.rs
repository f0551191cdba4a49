//! What scenes of cases are made of.

use glam::{DVec2, DVec3};

use crate::scene::SceneDescription;
use crate::scene::description::{BsdfDescription, FilmSize, Light, LightKind, Projection, SensorDescription};
use crate::spectrum::Rgb;
use crate::testing::scenes::{diffuse, enclosure, material, pinhole, rectangle};

use super::super::truth::square_mean;

/// Few pixels: the mean of the image is what is looked at.
pub(in super::super) const FILM: FilmSize = FilmSize { width: 8, height: 6 };

/// Width over height.
pub(super) const ASPECT: f64 = 4.0 / 3.0;

/// The closed diffuse box in which L = 1: emission 1 − ρ.
pub(super) fn unit_enclosure(albedo: f64) -> SceneDescription {
    enclosure(Rgb::grey(1.0 - albedo), Rgb::grey(albedo), FILM)
}

/// One surface of a model under a camera, in a constant environment of radiance one.
pub(super) fn sample_in_furnace(bsdf: BsdfDescription, camera: SensorDescription) -> SceneDescription {
    SceneDescription {
        name: "sample".into(),
        meshes: vec![rectangle("sample", DVec3::new(-2.0, -2.0, 0.0), DVec3::X * 4.0, DVec3::Y * 4.0, 0)],
        materials: vec![material("sample", bsdf, Rgb::BLACK)],
        environment: Some(Rgb::WHITE.into()),
        sensor: Some(camera),
        film: Some(FILM),
        ..SceneDescription::default()
    }
}

/// A camera that sees a part of the plane z = 0 at an angle.
pub(super) fn slanted_camera() -> SensorDescription {
    pinhole(DVec3::new(0.6, 0.0, 0.8), DVec3::ZERO, 40.0)
}

/// Albedo of the [`floor`].
pub(super) const FLOOR: f64 = 0.5;

/// Half the height of what is seen of the [`floor`].
pub(super) const SEEN: f64 = 0.375;

/// A diffuse floor in the plane z = 0, of which a camera above sees the part of `|x| < 0.5`, `|y| < 0.375`. What lights it
/// reflects nothing.
pub(super) fn floor() -> SceneDescription {
    let fov = 2.0 * libm::atan(SEEN).to_degrees();
    SceneDescription {
        name: "floor".into(),
        meshes: vec![rectangle("floor", DVec3::new(-2.0, -2.0, 0.0), DVec3::X * 4.0, DVec3::Y * 4.0, 0)],
        materials: vec![diffuse("floor", Rgb::grey(FLOOR), Rgb::BLACK)],
        sensor: Some(pinhole(DVec3::Z, DVec3::ZERO, fov)),
        film: Some(FILM),
        ..SceneDescription::default()
    }
}

/// The mean radiance of the floor in its image, of the irradiance at a point of it.
pub(super) fn floor_mean(nodes: u32, irradiance: impl Fn(DVec3) -> f64) -> f64 {
    let at = |p: DVec2| irradiance(DVec3::new(SEEN * ASPECT * p.x, SEEN * p.y, 0.0));
    FLOOR / std::f64::consts::PI * square_mean(nodes, at)
}

/// `Φ cos θ / (4π r²)`: the irradiance of the floor by what shines the flux Φ alike in all directions.
pub(super) fn isotropic(flux: f64, from: DVec3, at: DVec3) -> f64 {
    let way = from - at;
    let d2 = way.length_squared();
    flux / (4.0 * std::f64::consts::PI) * way.z / (d2 * d2.sqrt())
}

/// A point light.
pub(super) fn point_light(position: DVec3, intensity: f64) -> Light {
    Light { name: "point".into(), kind: LightKind::Point { position, intensity: Rgb::grey(intensity) } }
}

/// The scene, everything in it `factor` times as large. Radiance stays.
pub(super) fn scaled(mut scene: SceneDescription, factor: f64) -> SceneDescription {
    let positions = scene.meshes.iter_mut().flat_map(|mesh| &mut mesh.positions);
    positions.for_each(|p| *p *= factor);
    for sphere in &mut scene.spheres {
        sphere.centre *= factor;
        sphere.radius *= factor;
    }
    for light in &mut scene.lights {
        match &mut light.kind {
            LightKind::Point { position, intensity } | LightKind::Spot { position, intensity, .. } => {
                *position *= factor;
                *intensity *= factor * factor;
            }
            LightKind::Directional { .. } | LightKind::Projector { .. } => {}
        }
    }
    if let Some(camera) = &mut scene.sensor {
        camera.position *= factor;
        match &mut camera.projection {
            Projection::Perspective { lens: Some(lens), .. } => {
                lens.aperture_radius *= factor;
                lens.focus_distance *= factor;
            }
            Projection::Orthographic { half_width, half_height } => {
                *half_width *= factor;
                *half_height *= factor;
            }
            _ => {}
        }
    }
    scene
}

/// The scene, everything in it moved.
pub(super) fn moved(mut scene: SceneDescription, by: DVec3) -> SceneDescription {
    scene.meshes.iter_mut().flat_map(|mesh| &mut mesh.positions).for_each(|p| *p += by);
    scene.spheres.iter_mut().for_each(|sphere| sphere.centre += by);
    for light in &mut scene.lights {
        match &mut light.kind {
            LightKind::Point { position, .. }
            | LightKind::Spot { position, .. }
            | LightKind::Projector { position, .. } => *position += by,
            LightKind::Directional { .. } => {}
        }
    }
    if let Some(camera) = &mut scene.sensor {
        camera.position += by;
    }
    scene
}
