//! Albedos by both programs' own samples: the same, whatever the law by which each draws, Dirac lobes included.

use glam::DVec3;
use serde::Deserialize;
use statrs::distribution::{ContinuousCDF, Normal};

use crate::path::Vertex;
use crate::sampler::Random;
use crate::scene::Scene;
use crate::scene::bsdf::Side;

use super::case::Case;
use super::images::{POWER, SIGNIFICANCE};
use super::row::{ParityRow, Verdict};

/// Our samples.
const SAMPLES: u32 = 10_000;

/// `Σ f |cos θ| / p` over n samples, by n.
#[derive(Debug, Deserialize)]
pub(super) struct Albedo {
    #[serde(deserialize_with = "super::points::vector")]
    from: DVec3,
    mean: [f64; 3],
    error: [f64; 3],
}

/// The comparison of all albedos of a case, of which the largest difference by its standard error counts.
#[derive(Debug, Default)]
pub(super) struct Albedos {
    tests: u32,
    largest: f64,
    difference: f64,
    error: f64,
    what: String,
    errors: Vec<f64>,
}

impl Albedos {
    /// `rounding` is the relative difference that single precision may make.
    pub(super) fn add(&mut self, scene: &Scene, vertex: &Vertex, albedo: &Albedo, rounding: f64, seed: u64) {
        let mut random = Random::new(seed, 1, u64::from(self.tests));
        let (mut sum, mut squares) = ([0.0; 3], [0.0; 3]);
        for _ in 0..SAMPLES {
            let sample = scene.sample_scatter(vertex, Side::Sensor, albedo.from, random.uniform3());
            let weight = sample.map_or([0.0; 3], |sample| sample.weight(vertex).to_array());
            for c in 0..3 {
                sum[c] += weight[c];
                squares[c] += weight[c] * weight[c];
            }
        }
        let n = f64::from(SAMPLES);
        for c in 0..3 {
            let mean = sum[c] / n;
            let variance = (squares[c] / n - mean * mean).max(0.0) / (n - 1.0);
            let difference = mean - albedo.mean[c];
            let scale = 0.5 * (mean + albedo.mean[c]);
            let error = (variance + albedo.error[c] * albedo.error[c]).sqrt();
            let z = (difference.abs() - rounding * scale).max(0.0) / error.max(f64::MIN_POSITIVE);
            self.tests += 1;
            if scale > 0.0 {
                self.errors.push(error / scale);
            }
            if z >= self.largest && scale > 0.0 {
                (self.largest, self.difference, self.error) = (z, difference / scale, error / scale);
                self.what = format!(
                    "at {} from {}: ours {mean:.5}, Mitsuba's {:.5}",
                    vertex.position + scene.centre(),
                    albedo.from,
                    albedo.mean[c]
                );
            }
        }
    }

    pub(super) fn row(mut self, case: &Case, cases: usize) -> Option<ParityRow> {
        let tests = f64::from(self.tests) * cases as f64;
        self.errors.sort_by(f64::total_cmp);
        let median = *self.errors.get(self.errors.len() / 2)?;
        let limit = -Normal::standard().inverse_cdf(0.25 * SIGNIFICANCE / tests);
        let verdict = if self.largest <= limit { Verdict::Agree } else { Verdict::Differ };
        let detectable = (limit + Normal::standard().inverse_cdf(POWER)) * median;
        let details =
            format!("{} albedos; furthest, at {:.1} standard errors: {}", self.tests, self.largest.min(1e6), self.what);
        Some(ParityRow {
            difference: Some(self.difference),
            interval: Some(1.96 * self.error),
            detectable: Some(detectable),
            power: Some(POWER),
            values: Some(self.tests as usize),
            ..ParityRow::new(&case.name, "albedo", verdict, details)
        })
    }
}
