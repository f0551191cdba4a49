//! No ray passes through a closed mesh, wherever it meets it: at corners, on edges, and within a few ulps of them.

mod meshes;

use glam::DVec3;
use pathspace::geometry::Ray;
use pathspace::sampler::Random;
use pathspace::scene::PrimitiveId;
use pathspace::scene::accel::{Accel, Triangle};
use pathspace::warp::{uniform_sphere, uniform_triangle};
use rayon::prelude::*;

use meshes::Mesh;

/// A mesh put somewhere.
struct Case {
    mesh: Mesh,
    accel: Accel,
    /// Where the mesh's origin is.
    middle: DVec3,
    /// Of a ball around the middle that is inside.
    inner: f64,
    /// Of one that holds the mesh.
    outer: f64,
    /// The largest distance that rays start at, over the outer radius.
    far: f64,
}

impl Case {
    fn new(mut mesh: Mesh, size: DVec3, middle: DVec3, far: f64) -> Self {
        mesh.assert_closed();
        // The inner ball is squeezed with the mesh; rounding at the new place moves planes by less than a tenth.
        let inner = 0.9 * mesh.inner_radius() * size.min_element();
        for position in &mut mesh.positions {
            *position = middle + *position * size;
        }
        let outer = mesh.positions.iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
        let triangle = |i: u32| Triangle { corners: mesh.triangles[i as usize].map(|i| mesh.positions[i]), shape: 0 };
        let accel = Accel::build(mesh.triangles.len(), triangle, &[]).0;
        Self { mesh, accel, middle, inner, outer, far }
    }

    /// A point to aim at: a corner, one on an edge, in a triangle, or a few ulps beside.
    fn target(&self, random: &mut Random) -> DVec3 {
        let [triangle, kind, beside] = random.uniform3();
        let triangle = self.mesh.triangles[(triangle * self.mesh.triangles.len() as f64) as usize];
        let [a, b, c] = triangle.map(|i| self.mesh.positions[i]);
        let target = match (kind * 8.0) as u32 {
            0..=2 => a,
            3 => 0.5 * (a + b),
            4..=6 => a + (b - a) * random.uniform(),
            _ => {
                let [_, v, w] = uniform_triangle(random.uniform2());
                a + (b - a) * v + (c - a) * w
            }
        };
        if beside < 0.5 { target } else { nudged(target, random) }
    }

    /// A point of the inner ball; often its middle, or one with coordinates of the target.
    fn inside(&self, target: DVec3, random: &mut Random) -> DVec3 {
        let [kind, axis, share] = random.uniform3();
        let axis = (3.0 * axis) as usize;
        let mut point = self.middle;
        match (kind * 4.0) as u32 {
            0 => {
                // A ray along an axis through the target, if that leads past the middle.
                point = target;
                point[axis] = self.middle[axis];
            }
            1 => point[axis] = target[axis],
            2 => point += uniform_sphere(random.uniform2()) * (self.inner * share),
            _ => {}
        }
        if point.distance(self.middle) <= self.inner { point } else { self.middle }
    }
}

fn nudged(point: DVec3, random: &mut Random) -> DVec3 {
    let nudge = |x: f64, u: f64| {
        let ulps = (u * 9.0) as i32 - 4;
        (0..ulps.abs()).fold(x, |x, _| if ulps < 0 { x.next_down() } else { x.next_up() })
    };
    let [u, v, w] = random.uniform3();
    DVec3::new(nudge(point.x, u), nudge(point.y, v), nudge(point.z, w))
}

/// Small meshes are asked without a tree, the larger ones with.
fn cases() -> Vec<Case> {
    let generators: [fn() -> Mesh; 8] = [
        || meshes::icosphere(0),
        || meshes::icosphere(3),
        || meshes::star(0),
        || meshes::star(3),
        || meshes::globe(4, 8),
        || meshes::globe(24, 48),
        || meshes::crate_of_slivers(0),
        || meshes::crate_of_slivers(5),
    ];
    let place = DVec3::new(-1234.567, 890.123, 4321.0987);
    let placements = [
        (DVec3::ONE, DVec3::ZERO, 4.0),
        (DVec3::splat(1e-3), place, 1e6),
        (DVec3::splat(1e9), DVec3::ZERO, 16.0),
        (DVec3::splat(1e-9), place * 1e-9, 16.0),
        (DVec3::new(1.0, 1e-6, 0.37), DVec3::X, 1e3),
    ];
    let each = |generate: fn() -> Mesh| placements.map(|(size, at, far)| Case::new(generate(), size, at, far));
    generators.into_iter().flat_map(each).collect()
}

/// One of each five queries: from inside; from outside towards an inner point; the segment between both, and the longer one
/// beyond it; from inside along a nudged direction.
fn leak(case: &Case, random: &mut Random) -> Option<String> {
    let target = case.target(random);
    let inside = case.inside(target, random);
    let out = (target - inside).normalize();
    let distance = 2.0 * case.outer * libm::pow(case.far, random.uniform());
    // Half of them on the exact line, as far as it can be written.
    let outside = if random.uniform() < 0.5 { inside + out * distance } else { target + (target - inside) };
    let outside = if outside.distance(case.middle) > 1.001 * case.outer { outside } else { inside + out * distance };
    let none = PrimitiveId::NONE;
    let met = |origin: DVec3, direction: DVec3| case.accel.closest(&Ray::new(origin, direction), none).is_some();
    let what = if !met(inside, out) {
        "from inside"
    } else if !met(inside, nudged(out, random)) {
        "from inside, nudged"
    } else if !met(outside, (target - outside).normalize()) && met_inner_ball(case, outside, target) {
        "from outside"
    } else if !case.accel.occluded(inside, none, outside, none) {
        "segment"
    } else if !case.accel.occluded(inside, none, inside + (outside - inside) * 1.5, none) {
        "longer segment"
    } else {
        return None;
    };
    Some(format!("{} of {} m: {what}: {inside:?} {target:?} {outside:?}", case.mesh.name, case.outer))
}

/// Rounding far outside may turn the line past the inside.
fn met_inner_ball(case: &Case, outside: DVec3, target: DVec3) -> bool {
    let direction = (target - outside).normalize();
    let to_middle = case.middle - outside;
    (to_middle - direction * to_middle.dot(direction)).length() < case.inner
}

/// Queries for each point aimed at.
const QUERIES: u64 = 5;
/// Points in a part of the work.
const PART: u64 = 10_000;

fn no_leak_in(queries: u64) {
    let start = std::time::Instant::now();
    let cases = cases();
    let parts = queries.div_ceil(QUERIES * PART * cases.len() as u64);
    let work: Vec<(usize, u64)> = (0..cases.len()).flat_map(|case| (0..parts).map(move |part| (case, part))).collect();
    let leaks: Vec<String> = work
        .par_iter()
        .flat_map_iter(|&(case, part)| {
            let mut random = Random::new(17, case as u64, part);
            let leaks: Vec<String> = (0..PART).filter_map(|_| leak(&cases[case], &mut random)).collect();
            leaks
        })
        .collect();
    let rays = work.len() as u64 * PART * QUERIES;
    println!("{rays} rays, {} leaks, {:.1} s", leaks.len(), start.elapsed().as_secs_f64());
    assert!(leaks.is_empty(), "{} of {rays} leak: {:#?}", leaks.len(), &leaks[..leaks.len().min(5)]);
}

#[test]
fn no_ray_leaks() {
    no_leak_in(4_000_000);
}

/// `cargo test --release -p pathspace --test properties -- --ignored --nocapture billion`
#[test]
#[ignore = "takes minutes"]
fn no_ray_of_a_billion_leaks() {
    no_leak_in(1_000_000_000);
}
