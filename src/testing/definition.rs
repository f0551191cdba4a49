//! The proof of a fast integrator: every term it gives equals what the definition says of its path.

use crate::estimator::{Combination, Integrator, RecordedTerm};
use crate::film::ReplayKey;
use crate::scene::Scene;
use crate::wide::Wide;

/// What comparing a term with the definition gave.
#[derive(Clone, Debug, Default)]
pub struct Comparison {
    /// Terms compared.
    pub terms: usize,
    /// The largest relative difference of a value, with the term that has it.
    pub value: (f64, Option<RecordedTerm>),
    /// The largest difference of a weight, with the term that has it.
    pub weight: (f64, Option<RecordedTerm>),
    /// Edges of paths that the visibility test denies.
    pub hidden: usize,
    /// The largest deviation from one of the sum of the weights of all techniques for a path.
    pub partition: f64,
}

/// Draws `passes` samples in every pixel and compares each term with the combination that the integrator claims to equal.
#[must_use]
pub fn compare(
    integrator: &dyn Integrator,
    combination: &Combination,
    scene: &Scene,
    seed: u64,
    passes: u64,
) -> Comparison {
    let mut comparison = Comparison::default();
    for term in replay_all(integrator, scene, seed, passes) {
        let _ = comparison.add(combination, scene, &term);
    }
    comparison
}

/// The terms of `passes` samples in every pixel.
pub fn replay_all<'a>(
    integrator: &'a dyn Integrator,
    scene: &'a Scene,
    seed: u64,
    passes: u64,
) -> impl Iterator<Item = RecordedTerm> + 'a {
    let film = scene.sensor().film();
    let pixels = move || (0..film.height).flat_map(move |y| (0..film.width).map(move |x| (x, y)));
    let keys = (0..passes).flat_map(move |sample| pixels().map(move |pixel| ReplayKey { seed, sample, pixel }));
    keys.flat_map(move |key| integrator.replay(scene, key))
}

impl Comparison {
    /// Compares one more term. Gives the number of the sampler that has drawn its path, and `n_i p_i` of all of them; `None`
    /// where no sampler can have drawn it.
    pub fn add(
        &mut self,
        combination: &Combination,
        scene: &Scene,
        recorded: &RecordedTerm,
    ) -> Option<(usize, Vec<Wide>)> {
        let RecordedTerm { term, path } = recorded;
        let edges = path.edges() as u32;
        let densities = combination.densities(scene, path);
        let drawn_by = |&i: &usize| {
            let technique = combination.samplers[i].technique(edges) == term.technique && !densities[i].is_zero();
            technique && term.sampler.is_none_or(|sampler| sampler as usize == i)
        };
        self.terms += 1;
        self.hidden += path.vertices().windows(2).filter(|e| !scene.visible(&e[0], &e[1])).count();
        let Some(i) = (0..densities.len()).find(drawn_by) else {
            keep_worst(&mut self.value, f64::INFINITY, recorded);
            return None;
        };
        let weights: Vec<f64> = (0..densities.len()).map(|j| combination.weight(&densities, j)).collect();
        self.partition = self.partition.max((weights.iter().sum::<f64>() - 1.0).abs());
        let contribution = scene.contribution(path).filter(|c| c.pixel == term.pixel);
        let value = contribution.map_or(f64::NAN, |c| {
            let ours = term.value.to_array();
            let theirs = combination.estimate(&c, edges, &densities, i).to_array();
            let difference = ours.iter().zip(theirs).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            difference / term.value.max_component().max(f64::MIN_POSITIVE)
        });
        keep_worst(&mut self.value, value, recorded);
        keep_worst(&mut self.weight, (weights[i] - term.weight).abs(), recorded);
        Some((i, densities))
    }
}

/// Keeps the larger deviation with its term; NaN is the largest of all.
fn keep_worst(worst: &mut (f64, Option<RecordedTerm>), deviation: f64, term: &RecordedTerm) {
    let deviation = if deviation.is_nan() { f64::INFINITY } else { deviation };
    if deviation > worst.0 {
        *worst = (deviation, Some(term.clone()));
    }
}
