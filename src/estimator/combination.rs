//! Multiple importance sampling over any samplers, by the densities of whole paths.

use std::ops::RangeInclusive;
use std::sync::Arc;

use crate::path::{Contribution, Path, WalkRules};
use crate::sampler::{PathSampler, Random, Tracer};
use crate::scene::Scene;
use crate::scene::sensor::Pixel;
use crate::spectrum::Rgb;
use crate::wide::Wide;

use super::heuristic::Heuristic;
use super::integrator::Estimator;
use super::lengths::Lengths;
use super::settings::{Settings, SettingsError};
use super::sink::{Sink, Term};

/// Estimates `Σ_i Σ_j w_i(x̄_ij) f(x̄_ij) / (n_i p_i(x̄_ij))` with the definition of f and of each sampler's p_i.
///
/// It evaluates everything anew for each path: as slow as general. Fast integrators are tested against it.
#[derive(Clone, Debug)]
pub struct Combination {
    /// The samplers.
    pub samplers: Vec<Arc<dyn PathSampler>>,
    /// How they share a path.
    pub heuristic: Heuristic,
    /// How lengths are estimated.
    pub lengths: Lengths,
    /// Longest path in edges.
    pub max_length: u32,
}

impl Combination {
    /// Of these samplers, with the user's settings.
    ///
    /// # Errors
    /// Where a setting makes no sense, or samples would never end.
    pub fn new(samplers: Vec<Arc<dyn PathSampler>>, settings: &mut Settings) -> Result<Self, SettingsError> {
        let heuristic = if samplers.len() > 1 { settings.heuristic()? } else { Heuristic::Balance };
        let combination =
            Self { lengths: Lengths::new(settings)?, max_length: settings.max_length()?, heuristic, samplers };
        let endless = combination.lengths.apart() || combination.samplers.iter().any(|sampler| !sampler.ends());
        if endless && combination.max_length == u32::MAX && !combination.lengths.ends() {
            return Err(Settings::wrong(
                "max_length",
                "none",
                "a longest length, or terms=single or up_to: it would never end",
            ));
        }
        Ok(combination)
    }

    /// Of these samplers, all lengths up to the longest from each sample.
    #[must_use]
    pub fn of(samplers: Vec<Arc<dyn PathSampler>>, heuristic: Heuristic, max_length: u32) -> Self {
        Self { samplers, heuristic, lengths: Lengths::Together, max_length }
    }

    /// `n_i p_i(x̄)` of all samplers.
    #[must_use]
    pub fn densities(&self, scene: &Scene, path: &Path) -> Vec<Wide> {
        self.samplers.iter().map(|sampler| sampler.density(scene, path) * sampler.count(scene)).collect()
    }

    /// How walks end, where all its samplers that walk agree on it.
    #[must_use]
    pub fn rules(&self) -> Option<WalkRules> {
        let mut rules = self.samplers.iter().filter_map(|sampler| sampler.rules());
        let first = rules.next()?;
        rules.all(|other| other == first).then_some(first)
    }

    /// `w_i(x̄)`, given all `n_j p_j(x̄)`; zero where `p_i` is.
    #[must_use]
    pub fn weight(&self, densities: &[Wide], i: usize) -> f64 {
        if densities[i].is_zero() {
            return 0.0;
        }
        let ratio = |j: usize| (densities[j] / densities[i]).to_f64();
        self.heuristic.weight((0..i).map(ratio), (i + 1..densities.len()).map(ratio))
    }

    /// The estimate from a path that sampler i has drawn: `w_i f / (n_i p_i)`, over the probability that its length is
    /// estimated at all.
    #[must_use]
    pub fn estimate(&self, f: &Contribution, edges: u32, densities: &[Wide], i: usize) -> Rgb {
        let scale = self.weight(densities, i) / self.lengths.probability(edges);
        f.over(densities[i], scale)
    }

    /// Draws one sample of every sampler for `pixel` and gives the paths that light takes: seen by a pixel, neither black nor
    /// hidden.
    pub fn draw(&self, tracer: &mut Tracer<'_>, random: &mut Random, pixel: Pixel, take: &mut dyn FnMut(Draw)) {
        let lengths = self.lengths.draw(self.max_length, random);
        let mut draw = |i: usize, lengths: RangeInclusive<u32>, random: &mut Random| {
            // Each path at once: a walk has as many as it has vertices, and together their square.
            let mut between = Tracer::new(tracer.scene());
            let give = &mut |path| self.seen(&mut between, i, path).into_iter().for_each(&mut *take);
            self.samplers[i].sample(lengths, tracer, random, pixel, give);
            tracer.count(between.rays());
        };
        for i in 0..self.samplers.len() {
            if self.lengths.apart() {
                lengths.clone().for_each(|length| draw(i, length..=length, random));
            } else if !lengths.is_empty() {
                draw(i, lengths.clone(), random);
            }
        }
    }

    fn seen(&self, tracer: &mut Tracer<'_>, sampler: usize, path: Path) -> Option<Draw> {
        let scene = tracer.scene();
        let contribution = scene.contribution(&path).filter(|c| !c.is_black())?;
        let visible = path.vertices().windows(2).all(|edge| tracer.visible(&edge[0], &edge[1]));
        visible.then(|| Draw { sampler, densities: self.densities(scene, &path), path, contribution })
    }
}

/// A path that a sampler of a [`Combination`] has drawn, with all that a weight can depend on.
#[derive(Clone, Debug)]
pub struct Draw {
    /// The number of the sampler.
    pub sampler: usize,
    /// The path x̄.
    pub path: Path,
    /// The pixel that sees it and f(x̄), not black.
    pub contribution: Contribution,
    /// `n_j p_j(x̄)` of all samplers.
    pub densities: Vec<Wide>,
}

impl Estimator for Combination {
    type Scratch = ();

    fn sample<S: Sink>(&self, tracer: &mut Tracer<'_>, random: &mut Random, pixel: Pixel, (): &mut (), sink: &mut S) {
        self.draw(tracer, random, pixel, &mut |draw| {
            let Draw { sampler: i, path, contribution, densities } = draw;
            let edges = path.edges() as u32;
            let weight = self.weight(&densities, i);
            let value = self.estimate(&contribution, edges, &densities, i);
            let technique = self.samplers[i].technique(edges);
            let term = Term { pixel: contribution.pixel, value, technique, weight, sampler: Some(i as u32) };
            sink.add(term, || Some(path));
        });
    }

    fn definition(&self, _longest: u32) -> Option<Combination> {
        Some(self.clone())
    }

    /// A sampler alone has to find all light. What several find together is for their author to know: it depends on the
    /// paths that light takes through the scene.
    fn supports(&self, scene: &Scene) -> Result<(), String> {
        match &self.samplers[..] {
            [alone] => alone.covers(scene),
            _ => Ok(()),
        }
    }
}
