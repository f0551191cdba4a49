//! `path_bsdf`: path tracing by BSDF sampling alone, the plainest estimator of the rendering equation (Kajiya 1986).
//!
//! A path of k edges is drawn by the walk from the sensor that ends on an emitter by chance, technique s = 0. Lights without
//! a surface are never met.

use pathspace::estimator::{Combination, Entry, Estimator, Heuristic, Integrator, Settings, SettingsError, Sink, Term};
use pathspace::path::{Path, Roulette, Technique};
use pathspace::sampler::{Random, Tracer};
use pathspace::scene::Scene;
use pathspace::scene::bsdf::Side;
use pathspace::scene::emitter::Emitter;
use pathspace::scene::sensor::Pixel;
use pathspace::spectrum::Rgb;
use pathspace_walks::{Fixed, Walks};

/// For the registry.
pub const ENTRY: Entry = Entry {
    name: "path_bsdf",
    summary: "path tracing by BSDF sampling only: emitters are met by chance",
    build: |settings| Ok(Box::new(BsdfPathTracer::new(settings)?) as Box<dyn Integrator>),
};

/// The integrator and its settings.
#[derive(Clone, Copy, Debug)]
pub struct BsdfPathTracer {
    /// Longest path in edges.
    pub max_length: u32,
    /// How walks end.
    pub roulette: Roulette,
}

impl BsdfPathTracer {
    /// From the user's settings.
    ///
    /// # Errors
    /// Where one makes no sense.
    pub fn new(settings: &mut Settings) -> Result<Self, SettingsError> {
        let (max_length, roulette) = settings.walk(Roulette::Throughput { start: 5, long: Roulette::LONG })?;
        Ok(Self { max_length, roulette })
    }
}

impl Estimator for BsdfPathTracer {
    type Scratch = ();

    fn misses(&self, scene: &Scene) -> Option<String> {
        let unmet = scene.emitters().iter().any(|emitter| !emitter.can_be_hit());
        unmet.then(|| "no walk meets a point, spot or directional light".into())
    }

    fn definition(&self, _longest: u32) -> Option<Combination> {
        let sampler = Walks::shared(Fixed::Emitter(0), self.roulette);
        Some(Combination::of(vec![sampler], Heuristic::Balance, self.max_length))
    }

    fn sample<S: Sink>(&self, tracer: &mut Tracer<'_>, random: &mut Random, pixel: Pixel, (): &mut (), sink: &mut S) {
        let scene = tracer.scene();
        let (xk, mut direction) = scene.sensor().sample(scene, pixel, random);
        let (mut throughput, mut energy) = (Rgb::grey(scene.sensor().response()), Rgb::WHITE);
        let mut history = if S::RECORDS { vec![(xk, false)] } else { Vec::new() };
        let mut previous = xk;
        for edges in 1..=self.max_length {
            let Some(vertex) = tracer.trace(&previous, direction) else { return };
            if let Some(id) = vertex.emitter() {
                let value = throughput * scene.emitter(id).emission(scene, &vertex, -direction);
                let technique = Technique { s: 0, t: edges + 1 };
                if !value.is_black() {
                    sink.add(Term { pixel, value, technique, weight: 1.0, sampler: None }, || {
                        Path::new([(vertex, false)].into_iter().chain(history.iter().rev().copied()))
                    });
                }
            }
            if !vertex.scatters() {
                return;
            }
            let Some(next) = scene.sample_scatter(&vertex, Side::Sensor, -direction, random.uniform3()) else { return };
            let weight = next.weight(&vertex);
            let local = weight / scene.radiance_scale(&vertex, next.to, -direction);
            energy *= local;
            let survival = self.roulette.survival(edges, || local, || energy);
            if survival <= 0.0 || (survival < 1.0 && random.uniform() >= survival) {
                return;
            }
            throughput *= weight / survival;
            energy *= 1.0 / survival;
            if S::RECORDS {
                history.push((vertex, next.is_dirac()));
            }
            (previous, direction) = (vertex, next.to);
        }
    }

    fn supports(&self, scene: &Scene) -> Result<(), String> {
        if scene.emitters().iter().any(Emitter::can_be_hit) {
            Ok(())
        } else {
            Err("the scene has no emitter that a walk can meet, only point, spot or directional lights: use `path`"
                .into())
        }
    }
}
