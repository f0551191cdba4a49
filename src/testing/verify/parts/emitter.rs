//! Emitters: their choice, the first edge of their walks, and points drawn for a given vertex.

use glam::DVec3;

use crate::path::{Edge, Vertex};
use crate::sampler::Random;
use crate::scene::Scene;
use crate::scene::emitter::{Emitter, infinite_vertex};
use crate::scene::{EmitterId, Surfaces};
use crate::warp;

use super::super::report::Check;
use super::counting::{Claim, discrete};

/// Emitters are chosen as often as they claim.
pub(super) fn choice(scene: &Scene, place: &str, n: u32, random: &mut Random) -> Check {
    let mut counts = vec![0_u32; scene.emitters().len()];
    for _ in 0..n {
        counts[scene.choose_emitter(random.uniform()).0 as usize] += 1;
    }
    let outcomes: Vec<(u32, f64)> =
        (0..).zip(counts).map(|(id, count)| (count, scene.emitter_probability(EmitterId(id)).value())).collect();
    discrete("light choice", place, &format!("{} emitters", outcomes.len()), &outcomes, n)
}

/// Points of an emitter, uniform by area: what its own samplers are counted against.
enum Points {
    Surface(Surfaces),
    Infinite { id: EmitterId, radius: f64 },
}

impl Points {
    fn new(scene: &Scene, id: EmitterId) -> Option<Self> {
        match scene.emitter(id) {
            Emitter::Mesh(_) | Emitter::Shape(_) => {
                scene.surfaces()?.restricted(scene, |vertex| vertex.emitter() == Some(id)).map(Self::Surface)
            }
            Emitter::Environment(light) => Some(Self::Infinite { id, radius: light.sphere_radius }),
            Emitter::Directional(light) => Some(Self::Infinite { id, radius: light.sphere_radius }),
            Emitter::EnvironmentMap(light) => Some(Self::Infinite { id, radius: light.sphere_radius }),
            Emitter::Point(_) | Emitter::Spot(_) | Emitter::Projector(_) => None,
        }
    }

    fn sample(&self, scene: &Scene, random: &mut Random) -> Vertex {
        match self {
            Self::Surface(surfaces) => surfaces.sample(scene, random.uniform3()),
            Self::Infinite { id, radius } => {
                let outwards = warp::uniform_sphere(random.uniform2());
                infinite_vertex(*id, outwards * *radius, *radius)
            }
        }
    }

    fn density(&self) -> f64 {
        match self {
            Self::Surface(surfaces) => surfaces.density().value(),
            Self::Infinite { radius, .. } => warp::UNIFORM_SPHERE_DENSITY.value() / (radius * radius),
        }
    }
}

/// Eighths of space around a point.
fn octant(vector: DVec3) -> usize {
    usize::from(vector.x > 0.0) + 2 * usize::from(vector.y > 0.0) + 4 * usize::from(vector.z > 0.0)
}

/// The first edge of walks, and x_0 drawn for the points `seen_from`.
pub(super) fn checks(
    scene: &Scene,
    id: EmitterId,
    seen_from: &[DVec3],
    place: &str,
    n: u32,
    random: &mut Random,
) -> Vec<Check> {
    let emitter = scene.emitter(id);
    let what = format!("'{}'", scene.emitter_name(id));
    let points = Points::new(scene, id);
    let middle = emitter.sample_emission(scene.accel(), [0.5; 5]).vertex.position;
    let mut checks = vec![first_edge(scene, emitter, points.as_ref(), middle, place, &what, n, random)];
    // Of points and parallel light there is nothing to draw.
    let drawn = emitter.is_surface() || emitter.is_environment();
    for &x1 in seen_from.iter().filter(|_| drawn) {
        let Some(points) = &points else { continue };
        let what = format!("{what} seen from {x1:.2}");
        let claim = Claim {
            draw: &|random| Some(emitter.sample_direct(scene.accel(), x1, random.uniform3())?.vertex),
            density: &|x0: &Vertex| {
                emitter.direct_density(scene.accel(), x1, x0, &Edge::from_to(x1, x0.position)).value()
            },
            reference: &|random| points.sample(scene, random),
            reference_density: &|_| points.density(),
            cell: &|x0| 8 * octant(x0.position - middle) + octant(2.0 * (x0.position - middle) - (x1 - middle) * 0.1),
        };
        checks.push(claim.check("direct light", place, &what, n, random));
    }
    checks
}

#[expect(clippy::too_many_arguments, reason = "one of a kind")]
fn first_edge(
    scene: &Scene,
    emitter: &Emitter,
    points: Option<&Points>,
    middle: DVec3,
    place: &str,
    what: &str,
    n: u32,
    random: &mut Random,
) -> Check {
    let parallel = match emitter {
        Emitter::Directional(light) => Some(light.direction),
        _ => None,
    };
    let fixed = emitter.sample_emission(scene.accel(), [0.5; 5]).vertex;
    let claim = Claim {
        draw: &|random| {
            let sample = emitter.sample_emission(scene.accel(), random.uniform5());
            Some((sample.vertex, sample.direction))
        },
        density: &|(x0, direction)| {
            // Emission leaves to the front.
            if x0.normal != DVec3::ZERO && x0.normal.dot(*direction) <= 0.0 {
                return 0.0;
            }
            let density = emitter.emission_density(x0, *direction);
            density.position.value() * density.direction.value()
        },
        reference: &|random| {
            let direction = parallel.unwrap_or_else(|| warp::uniform_sphere(random.uniform2()));
            (points.map_or(fixed, |points| points.sample(scene, random)), direction)
        },
        reference_density: &|_| {
            let direction = if parallel.is_some() { 1.0 } else { warp::UNIFORM_SPHERE_DENSITY.value() };
            points.map_or(1.0, Points::density) * direction
        },
        cell: &|(x0, direction)| {
            let axis = if x0.normal == DVec3::ZERO { DVec3::Z } else { x0.normal };
            let height = (axis.dot(*direction).clamp(-1.0, 1.0) * 4.0 + 4.0).min(7.0) as usize;
            (octant(x0.position - middle) * 8 + octant(*direction)) * 8 + height
        },
    };
    claim.check("first edge", place, what, n, random)
}
