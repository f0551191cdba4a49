//! Visibility is symmetric, and agrees with the rays that walks have traced.

use pathspace::path::Vertex;
use pathspace::sampler::Random;
use pathspace::scene::Scene;
use pathspace::scene::description::FilmSize;
use pathspace::scene::sensor::Pixel;
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
