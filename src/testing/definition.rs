//! The proof of a fast integrator: every term it gives equals what the definition says of its path.

use crate::estimator::{Estimator, RecordedTerm, Recorder};
use crate::sampler::Tracer;
use crate::scene::sensor::Pixel;
use crate::wide::Wide;

pub use crate::estimator::Definition;

/// What comparing a term with the definition gave.
#[derive(Clone, Debug)]
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

impl Definition<'_> {
    /// Draws `passes` samples in every pixel and compares each term with the definition.
    #[must_use]
    pub fn compare<E: Estimator>(&self, estimator: &E, seed: u64, passes: u64) -> Comparison {
        let film = self.scene.sensor().film();
        let mut comparison =
            Comparison { terms: 0, value: (0.0, None), weight: (0.0, None), hidden: 0, partition: 0.0 };
        let mut scratch = E::Scratch::default();
        for sample in 0..passes {
            for (x, y) in (0..film.height).flat_map(|y| (0..film.width).map(move |x| (x, y))) {
                let pixel = Pixel { x, y };
                let mut recorder = Recorder::default();
                let mut random = crate::estimator::driver::random_of(self.scene, seed, pixel, sample);
                estimator.sample(&mut Tracer::new(self.scene), &mut random, pixel, &mut scratch, &mut recorder);
                recorder.terms.into_iter().for_each(|term| self.compare_term(&mut comparison, &term));
            }
        }
        comparison
    }

    fn compare_term(&self, comparison: &mut Comparison, recorded: &RecordedTerm) {
        let RecordedTerm { term, path } = recorded;
        let densities = self.densities(path);
        let i = term.technique.s as usize;
        let weight = self.weight(&densities, i);
        let total: f64 = (0..densities.len()).map(|j| self.weight(&densities, j)).sum();
        comparison.partition = comparison.partition.max((total - 1.0).abs());
        let contribution = self.scene.contribution(path);
        let value = contribution.filter(|c| c.pixel == term.pixel).map_or(f64::NAN, |c| {
            let estimate = |f: f64| (Wide::new(f * weight) / densities[i]).to_f64();
            let (ours, theirs) = (term.value.to_array(), c.value.to_array().map(estimate));
            let difference = ours.iter().zip(theirs).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            difference / term.value.max_component().max(f64::MIN_POSITIVE)
        });
        comparison.terms += 1;
        comparison.hidden += path.vertices().windows(2).filter(|e| !self.scene.visible(&e[0], &e[1])).count();
        let weight_difference = (weight - term.weight).abs();
        keep_worst(&mut comparison.value, value, recorded);
        keep_worst(&mut comparison.weight, weight_difference, recorded);
    }
}

/// Keeps the larger deviation with its term; NaN is the largest of all.
fn keep_worst(worst: &mut (f64, Option<RecordedTerm>), deviation: f64, term: &RecordedTerm) {
    let deviation = if deviation.is_nan() { f64::INFINITY } else { deviation };
    if deviation > worst.0 {
        *worst = (deviation, Some(term.clone()));
    }
}
