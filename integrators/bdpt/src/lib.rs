//! `bdpt`: bidirectional path tracing (Lafortune & Willems 1993; Veach 1997, chapter 10).
//!
//! A walk from an emitter and one from the sensor are drawn for each pixel, and every prefix of the one is connected to every
//! prefix of the other. A path of k edges is drawn by up to k + 2 techniques (s, t), s + t = k + 1, and weighted by the
//! densities of all of them. With s = 1 and t = 1 the end is drawn for its neighbour; with t ≤ 1 the walks from the emitters
//! serve all pixels, so n = width · height of them stand behind each.

mod connect;
mod walk;
mod weight;

use pathspace::estimator::{Combination, Entry, Estimator, Heuristic, Integrator, Settings, SettingsError, Sink};
use pathspace::path::Roulette;
use pathspace::sampler::{Random, Tracer};
use pathspace::scene::sensor::Pixel;
use pathspace_walks::{Fixed, Walks};

use connect::Connector;
use walk::{Limits, WalkVertex};
use weight::Densities;

/// For the registry.
pub const ENTRY: Entry = Entry {
    name: "bdpt",
    summary: "bidirectional path tracing: all techniques (s, t), with MIS",
    build: |settings| Ok(Box::new(Bidirectional::new(settings)?) as Box<dyn Integrator>),
};

/// The integrator and its settings.
#[derive(Clone, Copy, Debug)]
pub struct Bidirectional {
    /// Longest path in edges.
    pub max_length: u32,
    /// How walks end; local, because each walk's densities are evaluated from the other end too.
    pub roulette: Roulette,
    /// How the techniques share a path.
    pub heuristic: Heuristic,
}

impl Bidirectional {
    /// From the user's settings.
    ///
    /// # Errors
    /// Where one makes no sense.
    pub fn new(settings: &mut Settings) -> Result<Self, SettingsError> {
        let (max_length, roulette) = settings.walk(Roulette::Local { start: 3, long: Roulette::LONG_FOR_PAIRS })?;
        if !roulette.is_local() {
            return Err(SettingsError::Value {
                name: "roulette".into(),
                value: "throughput".into(),
                expected: "expected off, fixed or local: bdpt evaluates each walk's densities from the other end too"
                    .into(),
            });
        }
        Ok(Self { max_length, roulette, heuristic: settings.heuristic()? })
    }
}

/// Memory kept from sample to sample.
#[derive(Debug, Default)]
pub struct Scratch {
    emitter_walk: Vec<WalkVertex>,
    sensor_walk: Vec<WalkVertex>,
    densities: Densities,
}

impl Estimator for Bidirectional {
    type Scratch = Scratch;

    fn definition(&self, longest: u32) -> Option<Combination> {
        let kinds = (0..longest).map(Fixed::Emitter).chain([1, 0].map(Fixed::Sensor));
        let samplers = kinds.map(|fixed| Walks::shared(fixed, self.roulette)).collect();
        Some(Combination::of(samplers, self.heuristic, self.max_length))
    }

    fn sample<S: Sink>(
        &self,
        tracer: &mut Tracer<'_>,
        random: &mut Random,
        pixel: Pixel,
        scratch: &mut Scratch,
        sink: &mut S,
    ) {
        let Scratch { emitter_walk, sensor_walk, densities } = scratch;
        let longest = self.max_length as usize;
        let look_on = tracer.scene().sensor().can_be_hit();
        let limits = Limits { roulette: self.roulette, vertices: longest, look_on };
        let emitter = walk::from_emitter(tracer, random, limits, emitter_walk);
        let limits = Limits { roulette: self.roulette, vertices: longest.saturating_add(1), look_on: false };
        walk::from_sensor(tracer, random, pixel, limits, sensor_walk);
        let scene = tracer.scene();
        let film = scene.sensor().film();
        densities.sensor_can_be_hit = scene.sensor().can_be_hit();
        densities.light_walks = f64::from(film.width) * f64::from(film.height);
        let mut connector = Connector {
            tracer,
            random,
            pixel,
            roulette: self.roulette,
            heuristic: self.heuristic,
            emitter,
            y: emitter_walk,
            z: sensor_walk,
            densities,
            sink,
        };
        for t in 2..=connector.z.len() {
            connector.hit_emitter(t);
            let most = connector.y.len().min((longest + 1).saturating_sub(t));
            if most >= 1 {
                connector.direct_light(t);
            }
            for s in 2..=most {
                connector.connect(s, t);
            }
        }
        connector.emitter_to_sensor();
        for s in 2..=connector.y.len() {
            connector.direct_sensor(s);
        }
        for s in 2..=connector.y.len() + 1 {
            connector.hit_sensor(s);
        }
    }
}
