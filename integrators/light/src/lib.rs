//! `light`: light tracing, also called particle tracing (Arvo 1986; Dutré & Willems 1994): the mirror image of path tracing.
//!
//! A path of k edges is drawn by two techniques: t = 1, where a point of the sensor is drawn for the walk's last vertex, and,
//! if the sensor has a lens, t = 0, where the walk passes through it by chance. One walk is drawn for each pixel of the
//! film, n = width · height in all, and each serves whichever pixel sees it.

use std::iter;

use glam::DVec3;
use pathspace::estimator::{Combination, Entry, Estimator, Heuristic, Integrator, Settings, SettingsError, Sink, Term};
use pathspace::measure::{Area, Density, SolidAngle};
use pathspace::path::{Edge, Path, Roulette, Technique, Vertex};
use pathspace::sampler::{Random, Tracer};
use pathspace::scene::bsdf::{LobeDensity, Side};
use pathspace::scene::sensor::Pixel;
use pathspace::scene::{EmitterId, Scene};
use pathspace::spectrum::Rgb;
use pathspace_walks::{Fixed, Walks};

/// For the registry.
pub const ENTRY: Entry = Entry {
    name: "light",
    summary: "light tracing: walks from the emitters, each vertex connected to the sensor",
    build: |settings| Ok(Box::new(LightTracer::new(settings)?) as Box<dyn Integrator>),
};

/// The integrator and its settings.
#[derive(Clone, Copy, Debug)]
pub struct LightTracer {
    /// Longest path in edges.
    pub max_length: u32,
    /// How walks end.
    pub roulette: Roulette,
    /// How the two techniques share a path.
    pub heuristic: Heuristic,
}

impl LightTracer {
    /// From the user's settings.
    ///
    /// # Errors
    /// Where one makes no sense.
    pub fn new(settings: &mut Settings) -> Result<Self, SettingsError> {
        let (max_length, roulette) = settings.walk(Roulette::Throughput { start: 5, long: Roulette::LONG })?;
        Ok(Self { max_length, roulette, heuristic: settings.heuristic()? })
    }
}

/// The walk from an emitter.
struct Walk<'a, S> {
    /// Number of walks that serve the film.
    count: f64,
    /// f/p of the walk so far, the emission included.
    throughput: Rgb,
    /// The same without the emission, for roulette.
    energy: Rgb,
    /// x_0 … with their Dirac marks, where the sink records.
    history: Vec<(Vertex, bool)>,
    sink: &'a mut S,
}

impl<S: Sink> Walk<'_, S> {
    /// Adds the path that ends with `rest` (nearest to the walk first), if a pixel sees it.
    #[inline(always)]
    fn add<const N: usize>(&mut self, technique: Technique, pixel: Pixel, value: Rgb, weight: f64, rest: [Vertex; N]) {
        let history = &self.history;
        self.sink.add(Term { pixel, value: value * (weight / self.count), technique, weight, sampler: None }, || {
            Path::new(history.iter().copied().chain(rest.map(|v| (v, false))))
        });
    }
}

/// How the walk leaves its present vertex.
struct Departure {
    from: Vertex,
    direction: DVec3,
    /// Density of that direction with roulette; `None` where a connection to the sensor could not have drawn the next vertex.
    density: Option<Density<SolidAngle>>,
}

impl Estimator for LightTracer {
    type Scratch = ();

    fn supports(&self, scene: &Scene) -> Result<(), String> {
        if scene.sensor().can_be_connected() {
            Ok(())
        } else {
            Err("light walks cannot reach a sensor that is Dirac in position and direction: use `path` or `bdpt`"
                .into())
        }
    }

    fn misses(&self, scene: &Scene) -> Option<String> {
        let sensor = scene.sensor();
        if sensor.can_be_hit() {
            return None;
        }
        let at_infinity = scene.emitters().iter().any(|emitter| emitter.can_be_hit() && !emitter.is_local());
        let unseen = [
            scene.has_dirac_surfaces().then_some("what mirrors and smooth glass show the camera"),
            (at_infinity && !sensor.has_position()).then_some("the environment behind everything"),
        ];
        let unseen: Vec<&str> = unseen.into_iter().flatten().collect();
        (!unseen.is_empty()).then(|| format!("light walks cannot find {}", unseen.join(" and ")))
    }

    fn definition(&self, _longest: u32) -> Option<Combination> {
        let samplers = [1, 0].map(|t| Walks::shared(Fixed::Sensor(t), self.roulette));
        Some(Combination::of(samplers.into(), self.heuristic, self.max_length))
    }

    fn sample<S: Sink>(&self, tracer: &mut Tracer<'_>, random: &mut Random, _pixel: Pixel, (): &mut (), sink: &mut S) {
        let scene = tracer.scene();
        let film = scene.sensor().film();
        let id = scene.choose_emitter(random.uniform());
        let mut walk = Walk {
            count: f64::from(film.width) * f64::from(film.height),
            throughput: Rgb::WHITE / scene.emitter_probability(id).value(),
            energy: Rgb::WHITE,
            history: Vec::new(),
            sink,
        };
        let emission = scene.emitter(id).sample_emission(scene.accel(), random.uniform5());
        self.add_emission(tracer, random, &mut walk, id, &emission.vertex);
        let Some(mut departure) = self.emit(scene, &mut walk, id, &emission.vertex, emission.direction) else { return };
        for edges in 1..=self.max_length {
            let Some(vertex) = tracer.trace(&departure.from, departure.direction) else {
                self.add_lens_hit(scene, random, &mut walk, &departure, f64::INFINITY, edges);
                return;
            };
            let distance = (vertex.position - departure.from.position).length();
            self.add_lens_hit(scene, random, &mut walk, &departure, distance, edges);
            if !vertex.scatters() || edges == self.max_length {
                return;
            }
            if scene.has_finite(&vertex) {
                self.add_connection(tracer, random, &mut walk, &departure, &vertex, edges);
            }
            let Some((direction, density)) = self.scatter(scene, random, &mut walk, &departure, &vertex, edges) else {
                return;
            };
            departure = Departure { from: vertex, direction, density };
        }
    }
}

impl LightTracer {
    /// s = t = 1: the emitter itself is seen.
    fn add_emission<S: Sink>(
        &self,
        tracer: &mut Tracer<'_>,
        random: &mut Random,
        walk: &mut Walk<'_, S>,
        id: EmitterId,
        x0: &Vertex,
    ) {
        let scene = tracer.scene();
        let (emitter, sensor) = (scene.emitter(id), scene.sensor());
        let Some((x0, xk)) = scene.sample_two(id, x0, random) else { return };
        let density = scene.density_of_two(&x0, &xk) / scene.emitter_probability(id).value();
        let edge = Edge::between(&x0, &xk);
        let Some(importance) = sensor.importance(&xk, -edge.direction) else { return };
        let weight = if sensor.can_be_hit() {
            let by_chance = emitter.emission_density(&x0, edge.direction);
            let by_chance = by_chance.position.value() * (by_chance.direction * edge.solid_angle_to_area(&xk)).value();
            self.heuristic.weight(iter::empty(), iter::once(by_chance / density))
        } else {
            1.0
        };
        let value = walk.throughput
            * emitter.emission(scene, &x0, edge.direction)
            * (edge.geometry(&x0, &xk) * importance.value / density);
        if !value.is_black() && tracer.visible(&x0, &xk) {
            let rest = [x0, xk];
            walk.add(Technique { s: 1, t: 1 }, importance.pixel, value, weight, rest);
        }
    }

    /// Starts the walk.
    fn emit<S: Sink>(
        &self,
        scene: &Scene,
        walk: &mut Walk<'_, S>,
        id: EmitterId,
        x0: &Vertex,
        direction: DVec3,
    ) -> Option<Departure> {
        let emitter = scene.emitter(id);
        let density = emitter.emission_density(x0, direction);
        let weight = x0.abs_cos(direction) / (density.position.value() * density.direction.value());
        walk.throughput *= emitter.emission(scene, x0, direction) * weight;
        if S::RECORDS {
            walk.history.push((*x0, false));
        }
        // The very first edge has its own pair of densities: see `add_lens_hit`.
        (!walk.throughput.is_black()).then_some(Departure { from: *x0, direction, density: Some(density.direction) })
    }

    /// t = 0: the walk passes through the lens on its way.
    fn add_lens_hit<S: Sink>(
        &self,
        scene: &Scene,
        random: &mut Random,
        walk: &mut Walk<'_, S>,
        departure: &Departure,
        t_max: f64,
        edges: u32,
    ) {
        let x = &departure.from;
        let Some(xk) = scene.sensor().crossing(scene, x, departure.direction, t_max, random) else { return };
        if edges == 1 && !x.emitter().is_some_and(|id| scene.emitter(id).can_be_hit()) {
            return;
        }
        let Some(importance) = scene.sensor().importance(&xk, -departure.direction) else { return };
        let edge = Edge::between(x, &xk);
        let weight = departure.density.map_or(1.0, |density| {
            let by_chance = (density * edge.solid_angle_to_area(&xk)).value();
            let connected = self.connection_density(scene, x, &xk, edges);
            self.heuristic.weight(iter::once(connected / by_chance), iter::empty())
        });
        let technique = Technique { s: edges + 1, t: 0 };
        walk.add(technique, importance.pixel, walk.throughput * importance.value, weight, [xk]);
    }

    /// The density of t = 1 for the last vertex, relative to the walk's own up to the one before.
    fn connection_density(&self, scene: &Scene, x: &Vertex, xk: &Vertex, edges: u32) -> f64 {
        match x.emitter() {
            // s = t = 1, where either end may be drawn for the other.
            Some(id) if edges == 1 => {
                let edge = Edge::between(x, xk);
                let position = scene.emitter(id).emission_density(x, edge.direction).position;
                scene.density_of_two(x, xk) / (scene.emitter_probability(id).value() * position.value())
            }
            _ => scene.sensor().direct_density(x, xk).value(),
        }
    }

    /// t = 1: a point of the sensor is drawn for the walk's vertex.
    fn add_connection<S: Sink>(
        &self,
        tracer: &mut Tracer<'_>,
        random: &mut Random,
        walk: &mut Walk<'_, S>,
        departure: &Departure,
        x: &Vertex,
        edges: u32,
    ) {
        let scene = tracer.scene();
        let Some(direct) = scene.sensor().sample_direct(scene, x, random) else { return };
        let xk = direct.vertex;
        let edge = Edge::between(x, &xk);
        let Some(importance) = scene.sensor().importance(&xk, -edge.direction) else { return };
        let (to_emitter, to_sensor) = (-departure.direction, edge.direction);
        let scattered = scene.scatter(x, to_emitter, to_sensor);
        if scattered.is_black() {
            return;
        }
        let density: Density<Area> = direct.density;
        let weight = if scene.sensor().can_be_hit() {
            let by_chance = scene.scatter_density(x, to_emitter, to_sensor);
            let local = || scattered * (x.abs_cos(to_sensor) / by_chance.value());
            let survival = self.roulette.survival(edges, local, || walk.energy * local());
            let by_chance = by_chance * survival * edge.solid_angle_to_area(&xk);
            self.heuristic.weight(iter::empty(), iter::once(by_chance / density))
        } else {
            1.0
        };
        let value = walk.throughput * scattered * (edge.geometry(x, &xk) * importance.value / density.value());
        if !value.is_black() && tracer.visible(x, &xk) {
            walk.add(Technique { s: edges + 1, t: 1 }, importance.pixel, value, weight, [*x, xk]);
        }
    }

    /// Draws the walk's next direction with its density, and whether there is one.
    fn scatter<S: Sink>(
        &self,
        scene: &Scene,
        random: &mut Random,
        walk: &mut Walk<'_, S>,
        departure: &Departure,
        vertex: &Vertex,
        edges: u32,
    ) -> Option<(DVec3, Option<Density<SolidAngle>>)> {
        let scattered = scene.sample_scatter(vertex, Side::Emitter, -departure.direction, random.uniform3())?;
        let local = scattered.weight(vertex);
        let survival = self.roulette.survival(edges, || local, || walk.energy * local);
        if survival <= 0.0 || (survival < 1.0 && random.uniform() >= survival) {
            return None;
        }
        walk.throughput *= local / survival;
        walk.energy *= local / survival;
        if S::RECORDS {
            walk.history.push((*vertex, scattered.is_dirac()));
        }
        let density = match scattered.density {
            LobeDensity::Finite(density) => Some(density * survival),
            LobeDensity::Dirac(_) => None,
        };
        Some((scattered.to, density))
    }
}
