//! Integrators with a bug, in their terms or in what they claim.

use std::ops::RangeInclusive;
use std::sync::Arc;

use pathspace::estimator::{Combination, Control, Integrator, Method, RecordedTerm};
use pathspace::film::{Film, ReplayKey};
use pathspace::path::{Path, Technique};
use pathspace::sampler::{PathSampler, Random, Tracer};
use pathspace::scene::Scene;
use pathspace::scene::sensor::Pixel;
use pathspace::spectrum::Rgb;
use pathspace::wide::Wide;

/// What a bug does to a term.
pub type Bug = fn(&Scene, &Combination, &mut RecordedTerm);

/// A factor on the density that a sampler claims.
pub type Claim = fn(&Scene, &Path) -> f64;

/// An integrator with a bug, in its terms or in what it claims.
pub struct Buggy {
    pub inner: Method,
    pub bug: Bug,
    /// Factor on the density that its samplers claim.
    pub claim: Option<Claim>,
    /// The image lacks what a replay shows.
    pub forgetful: bool,
}

impl Integrator for Buggy {
    fn render(&self, scene: &Scene, seed: u64, film: &mut Film, control: &mut dyn Control) {
        let size = scene.sensor().film();
        loop {
            let passes = control.next_passes(film);
            if passes == 0 {
                return;
            }
            for _ in 0..passes {
                let mut pass = vec![Rgb::BLACK; (size.width * size.height) as usize];
                for pixel in (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y))) {
                    let key = ReplayKey { seed, sample: film.passes(), pixel };
                    for RecordedTerm { term, .. } in self.replay(scene, key) {
                        let index = term.pixel.y * size.width + term.pixel.x;
                        if let Some(pixel) = pass.get_mut(index as usize)
                            && !(self.forgetful && term.technique.s == 1)
                        {
                            *pixel += term.value;
                        }
                    }
                }
                film.add_pass(&pass).expect("the pass has the film's size");
            }
        }
    }

    fn replay(&self, scene: &Scene, key: ReplayKey) -> Vec<RecordedTerm> {
        let definition = self.inner.integrator.definition(5).expect("what ships has one");
        let mut terms = self.inner.integrator.replay(scene, key);
        terms.iter_mut().for_each(|term| (self.bug)(scene, &definition, term));
        terms.retain(|term| term.term.weight != f64::NEG_INFINITY);
        terms
    }

    fn definition(&self, longest: u32) -> Option<Combination> {
        let mut definition = self.inner.integrator.definition(longest)?;
        if let Some(factor) = self.claim {
            let wrong = |inner: Arc<dyn PathSampler>| Arc::new(Overstated { inner, factor }) as Arc<dyn PathSampler>;
            definition.samplers = definition.samplers.into_iter().map(wrong).collect();
        }
        Some(definition)
    }

    fn supports(&self, scene: &Scene) -> Result<(), String> {
        self.inner.integrator.supports(scene)
    }
}

/// A sampler that claims another density than it has.
#[derive(Debug)]
struct Overstated {
    inner: Arc<dyn PathSampler>,
    factor: Claim,
}

impl PathSampler for Overstated {
    fn sample(
        &self,
        lengths: RangeInclusive<u32>,
        tracer: &mut Tracer<'_>,
        random: &mut Random,
        pixel: Pixel,
        give: &mut dyn FnMut(Path),
    ) {
        self.inner.sample(lengths, tracer, random, pixel, give);
    }

    fn density(&self, scene: &Scene, path: &Path) -> Wide {
        self.inner.density(scene, path) * (self.factor)(scene, path)
    }

    fn count(&self, scene: &Scene) -> f64 {
        self.inner.count(scene)
    }

    fn technique(&self, edges: u32) -> Technique {
        self.inner.technique(edges)
    }
}
