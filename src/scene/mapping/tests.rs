//! Analytic shapes against Mitsuba.

use glam::{DAffine3, DMat3, DVec3};

use crate::path::{Vertex, VertexKind};
use crate::scene::description::{Cylinder, Disk, FilmSize, Light, LightKind, Sphere};
use crate::scene::{PrimitiveId, SceneDescription};
use crate::spectrum::Rgb;
use crate::testing::scenes;

/// Rays at unit shapes under random transforms, mirrored ones among them, and what `ray_intersect` of Mitsuba 3.9.1
/// (`scalar_rgb`) says of them: kind, sides, the columns of the transform, origin, direction, distance, texture coordinates,
/// normal and tangents.
const ANSWERS: &str = include_str!("mitsuba.txt");

fn scene(kind: &str, to_world: &DAffine3, flip_normals: bool) -> SceneDescription {
    let mut scene = SceneDescription {
        materials: vec![scenes::diffuse("grey", Rgb::grey(0.5), Rgb::BLACK)],
        sensor: Some(scenes::pinhole(DVec3::Z * 4.0, DVec3::ZERO, 40.0)),
        film: Some(FilmSize { width: 1, height: 1 }),
        ..SceneDescription::default()
    };
    let kind_of_light = LightKind::Point { position: DVec3::ZERO, intensity: Rgb::WHITE };
    scene.lights.push(Light { name: "light".into(), kind: kind_of_light });
    match kind {
        "sphere" => scene.spheres.push(Sphere::transformed(kind, to_world, flip_normals, 0)),
        "disk" => scene.disks.push(Disk::transformed(kind, to_world, flip_normals, 0)),
        _ => scene.cylinders.push(Cylinder::transformed(kind, to_world, flip_normals, 0)),
    }
    scene
}

/// Mitsuba computes in single precision: the tolerance is 200 of its units in the last place, of the largest number in play.
#[test]
fn distance_normal_texture_coordinates_and_tangents_are_those_of_mitsuba() {
    let mut seen = [0; 2];
    for line in ANSWERS.lines() {
        let (words, numbers): (Vec<_>, Vec<_>) = line.split(' ').partition(|word| word.parse::<f64>().is_err());
        let numbers: Vec<f64> = numbers.iter().map(|word| word.parse().expect("a number")).collect();
        let vector = |i: usize| DVec3::from_slice(&numbers[i..]);
        let to_world = DAffine3 { matrix3: DMat3::from_cols(vector(0), vector(3), vector(6)), translation: vector(9) };
        seen[usize::from(to_world.matrix3.determinant() < 0.0)] += 1;
        let scene = scenes::build(&scene(words[0], &to_world, words[1] == "flipped"));
        let (origin, direction) = (vector(12) - scene.centre(), vector(15).normalize());
        let kind = VertexKind::Sensor { zeta: 0.0, primitive: PrimitiveId::NONE };
        let start = Vertex { position: origin, normal: DVec3::ZERO, shading_normal: DVec3::ZERO, kind };
        let hit = scene.trace(&start, direction).unwrap_or_else(|| panic!("{line}: nothing is hit"));
        let (frame, at) = scene.surface_point(&hit);
        let [along_u, along_v] = at.tangents.map(|tangent| frame.to_world(tangent));
        let distance = (hit.position - origin).length();
        let found = [
            [distance, at.uv.x, at.uv.y].to_vec(),
            [hit.normal, along_u, along_v].iter().flat_map(DVec3::to_array).collect::<Vec<_>>(),
        ]
        .concat();
        for (i, (found, expected)) in found.iter().zip(&numbers[18..]).enumerate() {
            let scale = if i < 6 { 1.0 + distance } else { 10.0 };
            assert!((found - expected).abs() < 200.0 * 6e-8 * scale, "{line}\nnumber {i}: {found}, not {expected}");
        }
    }
    assert!(seen.iter().all(|&n| n >= 12), "{seen:?} upright and mirrored");
}
