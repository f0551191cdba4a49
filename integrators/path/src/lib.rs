//! `path`: unidirectional path tracing with next-event estimation and multiple importance sampling (Kajiya 1986; Veach 1997,
//! chapter 9).
//!
//! A path of k edges is drawn by two techniques: s = 0, where the walk from the sensor hits the emitter by chance, and s = 1,
//! where a point of an emitter is drawn for the walk's last vertex.

use std::iter;

use glam::DVec3;
use pathspace::estimator::{Combination, Entry, Estimator, Heuristic, Integrator, Settings, SettingsError, Sink, Term};
use pathspace::measure::{Area, Density, SolidAngle};
use pathspace::path::{Edge, Path, Roulette, Technique, Vertex};
use pathspace::sampler::{Random, Tracer};
use pathspace::scene::Scene;
use pathspace::scene::bsdf::{LobeDensity, Side};
use pathspace::scene::sensor::Pixel;
use pathspace::spectrum::Rgb;
use pathspace_walks::{Fixed, Walks};

/// For the registry.
pub const ENTRY: Entry = Entry {
    name: "path",
    summary: "path tracing from the sensor, with next-event estimation and MIS",
    build: |settings| Ok(Box::new(PathTracer::new(settings)?) as Box<dyn Integrator>),
};

/// The integrator and its settings.
#[derive(Clone, Copy, Debug)]
pub struct PathTracer {
    /// Longest path in edges.
    pub max_length: u32,
    /// How walks end.
    pub roulette: Roulette,
    /// How the two techniques share a path.
    pub heuristic: Heuristic,
}

impl PathTracer {
    /// From the user's settings.
    ///
    /// # Errors
    /// Where one makes no sense.
    pub fn new(settings: &mut Settings) -> Result<Self, SettingsError> {
        let (max_length, roulette) = settings.walk(Roulette::Throughput { start: 5, long: Roulette::LONG })?;
        Ok(Self { max_length, roulette, heuristic: settings.heuristic()? })
    }
}

/// The walk from the sensor.
struct Walk<'a, S> {
    pixel: Pixel,
    /// f/p of the walk so far.
    throughput: Rgb,
    /// The sensor's response and the radiance's η² in it, which roulette is not to see.
    scale: f64,
    /// x_k … with their Dirac marks, where the sink records.
    history: Vec<(Vertex, bool)>,
    sink: &'a mut S,
}

impl<S: Sink> Walk<'_, S> {
    /// Adds the path that ends with `rest` (nearest to the walk first).
    #[inline(always)]
    fn add<const N: usize>(&mut self, value: Rgb, edges: u32, s: u32, weight: f64, rest: [Vertex; N]) {
        let technique = Technique { s, t: edges + 1 - s };
        let history = &self.history;
        self.sink.add(Term { pixel: self.pixel, value, technique, weight, sampler: None }, || {
            let rest = rest.into_iter().rev().map(|v| (v, false));
            Path::new(rest.chain(history.iter().rev().copied()))
        });
    }
}

/// How the walk came to its present vertex.
struct Arrival {
    from: Vertex,
    direction: DVec3,
    /// Density of that direction with roulette; `None` where next-event estimation could not have drawn the vertex.
    density: Option<Density<SolidAngle>>,
}

impl Estimator for PathTracer {
    type Scratch = ();

    fn definition(&self, _longest: u32) -> Option<Combination> {
        let samplers = [0, 1].map(|s| Walks::shared(Fixed::Emitter(s), self.roulette));
        Some(Combination::of(samplers.into(), self.heuristic, self.max_length))
    }

    fn sample<S: Sink>(&self, tracer: &mut Tracer<'_>, random: &mut Random, pixel: Pixel, (): &mut (), sink: &mut S) {
        let scene = tracer.scene();
        let (xk, direction) = scene.sensor().sample(scene, pixel, random);
        let response = scene.sensor().response();
        let throughput = Rgb::grey(response);
        let mut walk = Walk { pixel, throughput, scale: response, history: Vec::new(), sink };
        if S::RECORDS {
            walk.history.push((xk, false));
        }
        let mut arrival = Arrival { from: xk, direction, density: None };
        for edges in 1..=self.max_length {
            let Some(vertex) = tracer.trace(&arrival.from, arrival.direction) else { return };
            self.add_emission(scene, &mut walk, &arrival, &vertex, edges);
            if !vertex.scatters() || edges == self.max_length {
                return;
            }
            if scene.has_finite(&vertex) {
                self.add_direct_light(tracer, random, &mut walk, &arrival, &vertex, edges);
            }
            let Some((direction, density)) = self.scatter(scene, random, &mut walk, &arrival, &vertex, edges) else {
                return;
            };
            arrival = Arrival { from: vertex, direction, density };
        }
    }
}

impl PathTracer {
    /// s = 0: the walk has met an emitter.
    #[inline]
    fn add_emission<S: Sink>(&self, scene: &Scene, walk: &mut Walk<'_, S>, arrival: &Arrival, x0: &Vertex, edges: u32) {
        let Some(id) = x0.emitter() else { return };
        let emission = scene.emitter(id).emission(scene, x0, -arrival.direction);
        if emission.is_black() {
            return;
        }
        let weight = arrival.density.map_or(1.0, |density| {
            let edge = Edge::between(&arrival.from, x0);
            let by_chance = density * edge.solid_angle_to_area(x0);
            let direct = self.direct_density(scene, &arrival.from, x0, &edge);
            self.heuristic.weight(iter::empty(), iter::once(direct / by_chance))
        });
        walk.add(walk.throughput * emission * weight, edges, 0, weight, [*x0]);
    }

    /// s = 1: an emitter's point is drawn for the walk's vertex.
    #[inline]
    fn add_direct_light<S: Sink>(
        &self,
        tracer: &mut Tracer<'_>,
        random: &mut Random,
        walk: &mut Walk<'_, S>,
        arrival: &Arrival,
        x1: &Vertex,
        edges: u32,
    ) {
        let scene = tracer.scene();
        let id = scene.choose_emitter(random.uniform());
        let emitter = scene.emitter(id);
        let Some(direct) = emitter.sample_direct(scene.accel(), x1.position, random.uniform3()) else { return };
        let x0 = direct.vertex;
        let edge = Edge::between(x1, &x0);
        let emission = emitter.emission(scene, &x0, -edge.direction);
        if emission.is_black() {
            return;
        }
        let (to_emitter, to_sensor) = (edge.direction, -arrival.direction);
        let scattered = scene.scatter(x1, to_emitter, to_sensor);
        if scattered.is_black() {
            return;
        }
        let density = scene.emitter_probability(id).value() * direct.density;
        let weight = if emitter.can_be_hit() {
            let by_chance = scene.scatter_density(x1, to_sensor, to_emitter);
            let weight = || scattered * (x1.abs_cos(to_emitter) / by_chance.value());
            let scale = || scene.radiance_scale(x1, to_emitter, to_sensor);
            let local = || weight() / scale();
            let survival = self.roulette.survival(edges, local, || walk.throughput * weight() / (walk.scale * scale()));
            let by_chance = by_chance * survival * edge.solid_angle_to_area(&x0);
            self.heuristic.weight(iter::once(by_chance / density), iter::empty())
        } else {
            1.0
        };
        let value = walk.throughput * scattered * emission * (edge.geometry(x1, &x0) * weight / density.value());
        if !value.is_black() && tracer.visible(x1, &x0) {
            walk.add(value, edges + 1, 1, weight, [*x1, x0]);
        }
    }

    /// Draws the walk's next direction with its density, and whether there is one.
    #[inline]
    fn scatter<S: Sink>(
        &self,
        scene: &Scene,
        random: &mut Random,
        walk: &mut Walk<'_, S>,
        arrival: &Arrival,
        vertex: &Vertex,
        edges: u32,
    ) -> Option<(DVec3, Option<Density<SolidAngle>>)> {
        let to_sensor = -arrival.direction;
        let scattered = scene.sample_scatter(vertex, Side::Sensor, to_sensor, random.uniform3())?;
        let weight = scattered.weight(vertex);
        let scale = scene.radiance_scale(vertex, scattered.to, to_sensor);
        walk.throughput *= weight;
        walk.scale *= scale;
        let survival = self.roulette.survival(edges, || weight / scale, || walk.throughput / walk.scale);
        if survival < 1.0 {
            if random.uniform() >= survival {
                return None;
            }
            walk.throughput *= 1.0 / survival;
        }
        if S::RECORDS {
            walk.history.push((*vertex, scattered.is_dirac()));
        }
        let density = match scattered.density {
            LobeDensity::Finite(density) => Some(density * survival),
            LobeDensity::Dirac(_) => None,
        };
        Some((scattered.to, density))
    }

    /// The density with which next-event estimation draws x_0 for x_1.
    #[inline]
    fn direct_density(&self, scene: &Scene, x1: &Vertex, x0: &Vertex, edge: &Edge) -> Density<Area> {
        let Some(id) = x0.emitter() else { return Density::ZERO };
        scene.emitter_probability(id).value() * scene.emitter(id).direct_density(scene.accel(), x1.position, x0, edge)
    }
}
