//! Cells that another program has rendered.

use crate::film::Moments;

use super::case::{Case, Stage, Truth};
use super::cell::{Cell, Verdict};
use super::judge::{Sampled, judge, too_rare};

/// What single precision loses in sums of some thousand samples: no less is asked of it.
const SINGLE_PRECISION: f64 = 2e-4;

/// Independent passes of an image by another program.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct External {
    /// Mean luminance of each; NaN where it is none.
    pub passes: Vec<f64>,
    /// Samples per pixel of each.
    pub spp: u64,
    /// Pixels of the image.
    pub pixels: u64,
    /// Pixels of all passes that are NaN or infinite.
    pub nonfinite: u64,
    /// Those that are negative.
    pub negative: u64,
    /// The largest of them.
    pub largest: f64,
    /// Of a pixel's sample \[s\].
    pub seconds_per_sample: f64,
}

impl External {
    fn moments(&self) -> Moments {
        let mut moments = Moments::default();
        self.passes.iter().for_each(|&pass| moments.push(pass));
        moments
    }
}

impl Cell {
    /// A value of a case by another program. `tame` are its passes for the tame value, and its cell. `tests` is the number of
    /// all cells.
    #[must_use]
    pub fn external(
        case: &Case,
        value: f64,
        method: &str,
        stage: &Stage,
        told: &External,
        tame: Option<(&External, &Self)>,
        tests: usize,
    ) -> Self {
        let mut cell = Cell::of(case, value, method);
        let estimates = told.moments();
        let (truth, against) = match stage.truth {
            Truth::Value(truth) => (truth, Moments::default()),
            Truth::Tame(factor) => {
                let tame = tame.map_or(estimates, |(tame, _)| tame.moments());
                let second = tame.second * factor * factor;
                (factor * tame.mean, Moments { second, third: 0.0, mean: 0.0, ..tame })
            }
        };
        cell.truth = Some(truth);
        let sampled = Sampled {
            errors: Moments { mean: estimates.mean - truth, ..estimates },
            against,
            estimates,
            invalid: told.nonfinite,
            negative: told.negative,
            largest: told.largest,
            draws: told.passes.len() as u64 * told.pixels,
            tolerance: stage.tolerance.max(SINGLE_PRECISION),
            alike: stage.alike,
            values: estimates.mean.eq(&0.0).then(Vec::new),
            ..Sampled::default()
        };
        judge(&mut cell, sampled, tests);
        if !stage.alike && tame.is_some() {
            too_rare(&mut cell);
        }
        let samples = told.passes.len() as u64 * told.spp * told.pixels;
        let variance = estimates.variance() * (told.spp * told.pixels) as f64 / (estimates.mean * estimates.mean);
        cell.passes = Some(told.passes.len() as u64);
        cell.samples = Some(samples);
        cell.variance = Some(variance).filter(|variance| variance.is_finite());
        cell.firefly = (estimates.mean > 0.0).then(|| told.largest / estimates.mean);
        cell.seconds_per_sample = Some(told.seconds_per_sample);
        let growth = |now: Option<f64>, tame: Option<f64>| now.zip(tame).map(|(now, tame)| now / tame);
        let tame = tame.map_or(&cell, |(_, tame)| tame).clone();
        cell.variance_growth = growth(cell.variance, tame.variance).filter(|growth| growth.is_finite());
        cell.time_growth = growth(cell.seconds_per_sample, tame.seconds_per_sample);
        cell
    }

    /// A value of a case by another program that gave no numbers.
    #[must_use]
    pub fn without_numbers(case: &Case, value: f64, method: &str, verdict: Verdict, details: String) -> Self {
        Self { verdict, details, ..Cell::of(case, value, method) }
    }
}
