//! The two walks: sequences of vertices with the densities of both directions.

use glam::DVec3;
use pathspace::measure::{Area, Density, Jacobian, SolidAngle};
use pathspace::path::{Edge, Roulette, Vertex};
use pathspace::sampler::{Random, Tracer};
use pathspace::scene::bsdf::{LobeDensity, Side};
use pathspace::scene::sensor::Pixel;
use pathspace::scene::{EmitterId, Scattered, Scene};
use pathspace::spectrum::Rgb;

/// A vertex of a walk.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WalkVertex {
    pub vertex: Vertex,
    /// Unit direction to the walk's vertex before; at the first one, along the walk's first edge.
    pub back: DVec3,
    /// f/p of the walk up to here.
    pub throughput: Rgb,
    /// `dσ / dA` from here to the walk's vertex before.
    pub back_to_area: Jacobian<SolidAngle, Area>,
    /// Density of this vertex in this walk, roulette included.
    pub forward: Density<Area>,
    /// Density of this vertex in a walk from the other end that comes through the next two, without roulette.
    pub reverse: Density<Area>,
    /// What that walk's roulette decides by at the next vertex, the largest channel.
    pub reverse_energy: f64,
    /// The walk went on by a Dirac lobe.
    pub dirac: bool,
    /// Connections to it can succeed.
    pub connects: bool,
    /// How the walk went on.
    pub onward: Option<Onward>,
}

/// How a walk leaves a vertex.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Onward {
    pub direction: DVec3,
    /// Distance to the next vertex; infinite without one.
    pub length: f64,
    /// f/p of the walk at the next vertex.
    pub throughput: Rgb,
    /// Density of the direction, roulette included.
    pub density: LobeDensity,
}

impl Onward {
    /// The density of `next`, a point in this direction.
    pub fn area_density(&self, at: &Vertex, edge: &Edge, next: &Vertex) -> Density<Area> {
        match self.density {
            LobeDensity::Finite(density) => density * edge.solid_angle_to_area(next),
            LobeDensity::Dirac(density) => {
                let (cos_at, cos_next) = (at.abs_cos(edge.direction), next.abs_cos(edge.direction));
                density * Jacobian::projected_to_area(cos_at, cos_next, edge.length_squared)
            }
        }
    }
}

impl WalkVertex {
    #[inline]
    fn new(scene: &Scene, vertex: Vertex, back: DVec3, throughput: Rgb, forward: Density<Area>) -> Self {
        let connects = !vertex.scatters() || scene.has_finite(&vertex);
        Self {
            vertex,
            back,
            back_to_area: Jacobian::solid_angle_to_area(0.0, 1.0),
            throughput,
            forward,
            reverse: Density::ZERO,
            reverse_energy: 1.0,
            dirac: false,
            connects,
            onward: None,
        }
    }
}

/// How far walks go.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    pub roulette: Roulette,
    /// Most vertices of a walk.
    pub vertices: usize,
    /// Look beyond the last vertex too, for what the edge from it passes.
    pub look_on: bool,
}

/// Draws x_k, x_{k−1}, … for a pixel.
pub(crate) fn from_sensor(
    tracer: &mut Tracer<'_>,
    random: &mut Random,
    pixel: Pixel,
    limits: Limits,
    walk: &mut Vec<WalkVertex>,
) {
    let scene = tracer.scene();
    let (xk, direction) = scene.sensor().sample(scene, pixel, random);
    let density = scene.sensor().density(&xk, direction);
    walk.clear();
    // Walks are drawn in proportion to the pixel's importance.
    let response = Rgb::grey(scene.sensor().response());
    walk.push(WalkVertex::new(scene, xk, direction, response, density.position));
    let first = onward(direction, response, LobeDensity::Finite(density.direction));
    extend(tracer, random, Side::Sensor, limits, first, walk);
}

/// Draws x_0, x_1, …; the first vertex's throughput lacks the emission, which depends on where the path goes.
pub(crate) fn from_emitter(
    tracer: &mut Tracer<'_>,
    random: &mut Random,
    limits: Limits,
    walk: &mut Vec<WalkVertex>,
) -> EmitterId {
    let scene = tracer.scene();
    let id = scene.choose_emitter(random.uniform());
    let emitter = scene.emitter(id);
    let sample = emitter.sample_emission(scene.accel(), random.uniform5());
    let (x0, direction) = (sample.vertex, sample.direction);
    let density = emitter.emission_density(&x0, direction);
    let position = scene.emitter_probability(id).value() * density.position;
    walk.clear();
    walk.push(WalkVertex::new(scene, x0, direction, Rgb::WHITE / position.value(), position));
    let emitted = emitter.emission(scene, &x0, direction) * (x0.abs_cos(direction) / density.direction.value());
    let throughput = walk[0].throughput * emitted;
    if !throughput.is_black() {
        let first = onward(direction, throughput, LobeDensity::Finite(density.direction));
        extend(tracer, random, Side::Emitter, limits, first, walk);
    }
    id
}

fn onward(direction: DVec3, throughput: Rgb, density: LobeDensity) -> Onward {
    Onward { direction, length: f64::INFINITY, throughput, density }
}

fn extend(
    tracer: &mut Tracer<'_>,
    random: &mut Random,
    side: Side,
    limits: Limits,
    first: Onward,
    walk: &mut Vec<WalkVertex>,
) {
    let scene = tracer.scene();
    let mut step = first;
    while walk.len() < limits.vertices || limits.look_on {
        let last = walk.len() - 1;
        let at = walk[last].vertex;
        let Some(next) = tracer.trace(&at, step.direction) else {
            walk[last].onward = Some(step);
            return;
        };
        let edge = Edge::between(&at, &next);
        step.length = edge.length_squared.sqrt();
        walk[last].onward = Some(step);
        if walk.len() == limits.vertices {
            return;
        }
        let forward = step.area_density(&at, &edge, &next);
        let mut vertex = WalkVertex::new(scene, next, -step.direction, step.throughput, forward);
        vertex.back_to_area = edge.reversed().solid_angle_to_area(&at);
        walk.push(vertex);
        if !next.scatters() || (walk.len() == limits.vertices && !limits.look_on) {
            return;
        }
        let Some(sample) = scene.sample_scatter(&next, side, -step.direction, random.uniform3()) else { return };
        let weight = sample.weight(&next);
        let (to_emitter, to_sensor) = side.by_role(-step.direction, sample.to);
        let scale = scene.radiance_scale(&next, to_emitter, to_sensor);
        let energy = || if side == Side::Sensor { weight / scale } else { weight };
        let edges = walk.len() as u32 - 1;
        let survival = limits.roulette.survival(edges, energy, energy);
        if survival <= 0.0 || (survival < 1.0 && random.uniform() >= survival) {
            return;
        }
        note_reverse(scene, side, &sample, scale, walk);
        let density = match sample.density {
            LobeDensity::Finite(density) => LobeDensity::Finite(density * survival),
            LobeDensity::Dirac(density) => LobeDensity::Dirac(density * survival),
        };
        step = onward(sample.to, step.throughput * weight * (1.0 / survival), density);
    }
}

/// Remembers, at the vertex before the last, how a walk from the other end would come to it.
fn note_reverse(scene: &Scene, side: Side, sample: &Scattered, scale: f64, walk: &mut [WalkVertex]) {
    let [.., before, at] = walk else { return };
    at.dirac = sample.is_dirac();
    let cos_at = at.vertex.abs_cos(at.back);
    let weight = if at.dirac {
        let other = match side {
            Side::Sensor => Side::Emitter,
            Side::Emitter => Side::Sensor,
        };
        let density = scene.scatter_dirac_density(&at.vertex, other, sample.to, at.back);
        before.reverse = density * Jacobian::projected_to_solid_angle(cos_at) * at.back_to_area;
        sample.value / density.value()
    } else {
        let density = scene.scatter_density(&at.vertex, sample.to, at.back);
        before.reverse = density * at.back_to_area;
        sample.value * (cos_at / density.value())
    };
    before.reverse_energy = if side == Side::Emitter { weight / scale } else { weight }.max_component();
}
