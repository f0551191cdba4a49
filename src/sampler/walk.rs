//! Walks as bare sequences of vertices, for samplers that leave densities to the definition.

use glam::DVec3;

use crate::path::{Roulette, Vertex};
use crate::scene::EmitterId;
use crate::scene::bsdf::Side;
use crate::scene::sensor::Pixel;
use crate::spectrum::Rgb;

use super::{Random, Tracer};

/// What a walk draws.
#[derive(Clone, Debug, Default)]
pub struct Walk {
    /// Its vertices in the order of their drawing, each with whether the walk left it by a Dirac lobe.
    pub vertices: Vec<(Vertex, bool)>,
    /// The rays that leave them: unit direction, and distance of what is met \[m\], infinite for nothing.
    pub rays: Vec<(DVec3, f64)>,
}

/// x_k, x_{k−1}, … for a pixel, up to `vertices` of them.
#[must_use]
pub fn walk_from_sensor(
    tracer: &mut Tracer<'_>,
    random: &mut Random,
    pixel: Pixel,
    roulette: Roulette,
    vertices: usize,
) -> Walk {
    let (xk, direction) = tracer.scene().sensor().sample(tracer.scene(), pixel, random);
    walk_on(tracer, random, Side::Sensor, roulette, vertices, (xk, direction))
}

/// x_0, x_1, …, up to `vertices` of them, from an emitter that is chosen by the scene.
#[must_use]
pub fn walk_from_emitter(
    tracer: &mut Tracer<'_>,
    random: &mut Random,
    roulette: Roulette,
    vertices: usize,
) -> (EmitterId, Walk) {
    let scene = tracer.scene();
    let id = scene.choose_emitter(random.uniform());
    let first = scene.emitter(id).sample_emission(scene.accel(), random.uniform5());
    (id, walk_on(tracer, random, Side::Emitter, roulette, vertices, (first.vertex, first.direction)))
}

fn walk_on(
    tracer: &mut Tracer<'_>,
    random: &mut Random,
    side: Side,
    roulette: Roulette,
    vertices: usize,
    (first, mut direction): (Vertex, DVec3),
) -> Walk {
    let scene = tracer.scene();
    let mut walk = Walk { vertices: vec![(first, false)], rays: Vec::new() };
    let mut energy = Rgb::WHITE;
    let mut at = first;
    while walk.vertices.len() < vertices {
        let next = tracer.trace(&at, direction);
        walk.rays.push((direction, next.map_or(f64::INFINITY, |next| (next.position - at.position).length())));
        let Some(vertex) = next else { break };
        walk.vertices.push((vertex, false));
        if walk.vertices.len() == vertices || !vertex.scatters() {
            break;
        }
        let Some(scattered) = scene.sample_scatter(&vertex, side, -direction, random.uniform3()) else { break };
        let (to_emitter, to_sensor) = side.by_role(-direction, scattered.to);
        let scale = match side {
            Side::Sensor => scene.radiance_scale(&vertex, to_emitter, to_sensor),
            Side::Emitter => 1.0,
        };
        let local = scattered.weight(&vertex) / scale;
        energy *= local;
        let survival = roulette.survival(walk.vertices.len() as u32 - 1, || local, || energy);
        if survival < 1.0 && random.uniform() >= survival {
            break;
        }
        energy *= 1.0 / survival;
        if let Some((_, dirac)) = walk.vertices.last_mut() {
            *dirac = scattered.is_dirac();
        }
        (at, direction) = (vertex, scattered.to);
    }
    walk
}
