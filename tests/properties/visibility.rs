//! Visibility is symmetric, and agrees with the rays that walks have traced.

use glam::DVec3;
use pathspace::path::Vertex;
use pathspace::sampler::Random;
use pathspace::scene::description::{Cylinder, Disk, FilmSize};
use pathspace::scene::sensor::Pixel;
use pathspace::scene::{Scene, SceneDescription};
use pathspace::spectrum::Rgb;
use pathspace::testing::scenes;
use pathspace::warp;

const FILM: FilmSize = FilmSize { width: 64, height: 64 };

/// Vertices of walks through a scene, with whether the one before it lies at the other end of a ray.
fn walk(scene: &Scene, vertices: usize) -> Vec<(Vertex, bool)> {
    let mut random = Random::new(11, 0, 0);
    let mut found: Vec<(Vertex, bool)> = Vec::new();
    while found.len() < vertices {
        let pixel = Pixel { x: (random.uniform() * 64.0) as u32, y: (random.uniform() * 64.0) as u32 };
        let (mut at, mut direction) = scene.sensor().sample(scene, pixel, &mut random);
        let mut traced = false;
        for _ in 0..6 {
            let Some(next) = scene.trace(&at, direction).filter(Vertex::scatters) else { break };
            found.push((next, traced));
            traced = true;
            at = next;
            direction = warp::uniform_sphere(random.uniform2());
        }
    }
    found
}

#[test]
fn both_directions_agree() {
    for scene in [scenes::cabinet(FILM), scenes::terrace(FILM), scenes::lanterns(FILM)] {
        let scene = scenes::build(&scene);
        let vertices = walk(&scene, 20_000);
        let mut hidden = 0;
        for pair in vertices.windows(7) {
            let (a, b) = (&pair[0].0, &pair[6].0);
            assert_eq!(scene.visible(a, b), scene.visible(b, a), "{a:?} {b:?}");
            hidden += u32::from(!scene.visible(a, b));
        }
        assert!(hidden > 1000, "only {hidden} pairs are hidden");
    }
}

/// 2 · 10⁶ edges: at a rate of 10⁻⁹ one would be denied in five hundred runs of this test.
#[test]
fn traced_edges_are_visible() {
    for scene in [scenes::cabinet(FILM), scenes::lanterns(FILM)] {
        let scene = scenes::build(&scene);
        let vertices = walk(&scene, 1_000_000);
        for edge in vertices.windows(2).filter(|edge| edge[1].1) {
            assert!(scene.visible(&edge[0].0, &edge[1].0), "{edge:?}");
        }
    }
}

/// A tin of a cylinder and two disks: in 10⁶ bounces no ray gets out.
#[test]
fn nothing_leaves_through_seams_of_analytic_shapes() {
    let base = DVec3::new(0.3, -0.4, 0.2);
    let axis = DVec3::new(0.5, 1.1, -0.7);
    let meridian = axis.normalize().any_orthonormal_vector();
    let across = axis.normalize().cross(meridian);
    let radius = 0.8;
    let disk = |centre: DVec3, flipped: bool| Disk {
        name: "end".into(),
        centre,
        axes: [meridian * radius, across * radius],
        flipped,
        material: 0,
    };
    let wall =
        Cylinder { name: "wall".into(), base, axis, radius, meridian, clockwise: false, inward: true, material: 0 };
    let scene = SceneDescription {
        materials: vec![scenes::diffuse("tin", Rgb::grey(0.5), Rgb::WHITE)],
        disks: vec![disk(base, false), disk(base + axis, true)],
        cylinders: vec![wall],
        sensor: Some(scenes::pinhole(base + axis * 0.5, base + axis * 0.5 + DVec3::X, 60.0)),
        film: Some(FILM),
        ..SceneDescription::default()
    };
    let scene = scenes::build(&scene);
    let mut random = Random::new(12, 0, 0);
    let (mut at, mut direction) = scene.sensor().sample(&scene, Pixel { x: 0, y: 0 }, &mut random);
    for bounce in 0..1_000_000 {
        let next = scene.trace(&at, direction).unwrap_or_else(|| panic!("bounce {bounce}: {at:?} along {direction}"));
        at = next;
        direction = warp::uniform_sphere(random.uniform2());
        direction *= direction.dot(at.normal).signum();
    }
}
