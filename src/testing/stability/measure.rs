//! Runs a method on a scene and watches each pass.

use std::time::Instant;

use crate::estimator::{Control, Integrator};
use crate::film::{Counters, Film, Moments};
use crate::scene::Scene;
use crate::spectrum::Rgb;
use crate::testing::definition::Comparison;

use super::Effort;
use super::judge::FEWEST_LIT;

/// Fewer passes say nothing about their variance.
pub(super) const FEWEST_PASSES: u64 = 32;

/// A cell whose fewest passes take this many times the rays of others is given up after the first.
const TOO_LONG: f64 = 40.0;

/// Bias that is to be detectable where more passes make it so, and in how many standard errors that is.
const TARGET: f64 = 0.08;
const ERRORS: f64 = 7.0;

/// How many of the brightest pixels may be missing.
const UNSEEN: f64 = 17.0;

/// Paths longer than this are not compared with the definition: it takes the square of the length, and so do the paths of all
/// terms of a sample.
pub(super) const LONGEST: u32 = 16;

/// So many terms are compared with the definition.
const TERMS: usize = 200;

/// Samples that are drawn again for that.
const REPLAYS: u64 = 20;

/// What was drawn.
#[derive(Clone, Debug, Default)]
pub(super) struct Measured {
    /// Mean luminance of each pass.
    pub passes: Vec<f64>,
    /// Luminance of each pixel of each pass that is not black.
    pub values: Vec<f64>,
    /// Pixels of the film.
    pub pixels: u64,
    pub counters: Counters,
    /// Of one thread \[s\].
    pub seconds: f64,
    /// Deviations of the weights' sum and of the terms, where there is a definition of these paths.
    pub definition: Option<(f64, f64)>,
}

impl Measured {
    /// Draws passes until they are enough, or `stop` is told.
    pub fn new(integrator: &dyn Integrator, scene: &Scene, effort: Effort, stop: &dyn Fn() -> bool) -> Self {
        let size = scene.sensor().film();
        let mut film = Film::new(size.width, size.height, None).expect("stages have pixels");
        let mut watch = Watch { effort, stop, before: Vec::new(), passes: None, measured: Self::default() };
        let start = Instant::now();
        integrator.render(scene, effort.seed, &mut film, &mut watch);
        let mut measured = watch.measured;
        measured.seconds = start.elapsed().as_secs_f64();
        measured.pixels = u64::from(size.width) * u64::from(size.height);
        measured.counters = film.counters.clone();
        // Differences of sums leave a trace of rounding in pixels that were black.
        let threshold = 1e-9 * measured.values.iter().copied().fold(0.0, f64::max);
        measured.values.retain(|&value| value > threshold);
        measured
    }

    /// Over passes.
    pub fn moments(&self) -> Moments {
        let mut moments = Moments::default();
        self.passes.iter().for_each(|&pass| moments.push(pass));
        moments
    }

    pub fn samples(&self) -> u64 {
        self.passes.len() as u64 * self.pixels
    }

    pub fn rays_per_sample(&self) -> f64 {
        self.counters.rays as f64 / self.samples().max(1) as f64
    }
}

struct Watch<'a> {
    effort: Effort,
    stop: &'a dyn Fn() -> bool,
    /// Sum of each pixel before the last pass.
    before: Vec<Rgb>,
    /// How many are drawn, once it is known.
    passes: Option<u64>,
    measured: Measured,
}

impl Watch<'_> {
    /// Decided once, after the first stage, so that the mean of all passes does not depend on when they end (Stein 1945).
    fn needed(&self, film: &Film) -> u64 {
        let moments = self.measured.moments();
        let values = &self.measured.values;
        let largest = values.iter().copied().fold(0.0, f64::max);
        let lit = values.iter().filter(|&&value| value > 1e-9 * largest).count();
        let error = moments.variance_of_mean().sqrt() / moments.mean;
        let unseen = UNSEEN * largest / (values.len() as f64 * moments.mean);
        let factor = (2.0 * ERRORS * error / TARGET).powi(2).max(2.0 * unseen / TARGET).max(1.0);
        let affordable = film.counters.rays as f64 * factor <= self.effort.patience * self.effort.rays as f64;
        let passes = film.passes();
        if lit >= FEWEST_LIT && affordable { (passes as f64 * factor).ceil() as u64 } else { passes }
    }
}

impl Control for Watch<'_> {
    fn next_passes(&mut self, film: &Film) -> u64 {
        let passes = film.passes();
        if passes > 0 {
            let sums: Vec<Rgb> = film.mean_image().pixels.iter().map(|&mean| mean * passes as f64).collect();
            self.before.resize(sums.len(), Rgb::BLACK);
            let values = sums.iter().zip(&self.before).map(|(&now, &before)| (now - before).luminance());
            let first = self.measured.values.len();
            self.measured.values.extend(values);
            let pass = &self.measured.values[first..];
            self.measured.passes.push(pass.iter().sum::<f64>() / pass.len() as f64);
            self.before = sums;
        }
        let rays = self.effort.rays;
        if self.passes.is_none() && passes >= FEWEST_PASSES && film.counters.rays >= rays {
            self.passes = Some(self.needed(film));
        }
        let enough = self.passes.is_some_and(|needed| passes >= needed);
        let expected = film.counters.rays as f64 * FEWEST_PASSES as f64 / passes.max(1) as f64;
        let too_long = expected > TOO_LONG * rays as f64;
        u64::from(!(enough || too_long || (self.stop)()))
    }
}

/// Compares the first terms of an integrator, of paths of at most [`LONGEST`] edges, with the definition: the largest deviations
/// of the weights' sum and of a term.
pub(super) fn definition(integrator: &dyn Integrator, scene: &Scene, seed: u64) -> Option<(f64, f64)> {
    let combination = integrator.definition(LONGEST)?;
    let mut comparison = Comparison::default();
    let size = scene.sensor().film();
    let pixels = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y)));
    let keys = (0..).flat_map(|sample| pixels.clone().map(move |pixel| crate::film::ReplayKey { seed, sample, pixel }));
    for key in keys.take(REPLAYS as usize) {
        for term in integrator.replay(scene, key) {
            if comparison.terms < TERMS {
                let _ = comparison.add(&combination, scene, &term);
            }
        }
    }
    let deviation = comparison.value.0.max(comparison.weight.0);
    (comparison.terms > 0).then_some((comparison.partition, deviation))
}
