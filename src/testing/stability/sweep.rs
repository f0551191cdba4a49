//! A case by one method, value by value.

use std::time::{Duration, Instant};

use crate::estimator::Integrator;
use crate::film::Moments;
use crate::scene::Scene;

use super::Effort;
use super::case::{Case, Stage, Truth};
use super::cases::FILM;
use super::cell::{Cell, Verdict};
use super::judge::{Sampled, judge};
use super::measure::{FEWEST_PASSES, LONGEST, Measured, definition};
use super::run::Run;

/// Exponents of rays over the parameter that make a law: below, nothing grows; above, it is a jump.
const GROWS: std::ops::Range<f64> = 0.3..3.0;

/// Where the first pass is foretold to take so many times the rays of other cells, it is not even tried.
const TRIED: f64 = 100.0;

/// For what rays do not tell: the time for a cell, with the effort of a quick run.
const TIME_LIMIT: Duration = Duration::from_secs(60);

/// A case by a method.
pub(super) struct Sweep {
    pub label: String,
    pub cells: Vec<Cell>,
    /// Passes of the tame value.
    tame: Vec<f64>,
    /// Values and their rays per sample.
    rays: Vec<(f64, f64)>,
}

impl Sweep {
    pub fn new(label: &str) -> Self {
        Self { label: label.to_owned(), cells: Vec::new(), tame: Vec::new(), rays: Vec::new() }
    }

    /// The next value.
    #[allow(clippy::too_many_arguments, reason = "all that a cell is made of")]
    pub fn cell(
        &mut self,
        case: &Case,
        value: f64,
        stage: &Stage,
        scene: &Scene,
        integrator: &dyn Integrator,
        run: &Run<'_>,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Cell {
        let cell = Cell::of(case, value, &self.label);
        let blind = integrator.supports(scene).err().or_else(|| integrator.misses(scene));
        if let Some(details) = blind {
            return Cell { verdict: Verdict::Blind, details, ..cell };
        }
        if let Some((expected, law)) = self.expected_rays(case, value)
            && expected * f64::from(FILM.width * FILM.height) > TRIED * run.effort.rays as f64
        {
            return Cell {
                verdict: Verdict::Slow,
                details: format!("{expected:.0e} rays a sample expected{law}"),
                ..cell
            };
        }
        let limit = TIME_LIMIT.mul_f64(run.effort.patience / Effort::QUICK.patience);
        let start = Instant::now();
        let ends = || stop() || start.elapsed() > limit;
        let mut measured = Measured::new(integrator, scene, run.effort, &ends);
        let short = run.registry.build(&self.label, &[("max_length", LONGEST.to_string())]);
        measured.definition =
            short.ok().and_then(|short| definition(short.integrator.as_ref(), scene, run.effort.seed));
        self.rays.push((value, measured.rays_per_sample()));
        let cell = self.measured(cell, stage, &measured, run.tests());
        if (measured.passes.len() as u64) < FEWEST_PASSES {
            let law = self.law(case).map_or_else(String::new, |(_, law)| law);
            let (rays, seconds) = (measured.rays_per_sample(), measured.seconds / measured.samples().max(1) as f64);
            let details = format!("{rays:.0e} rays and {seconds:.1e} s a sample{law}");
            return Cell { verdict: Verdict::Slow, details, ..cell };
        }
        cell
    }

    fn measured(&mut self, mut cell: Cell, stage: &Stage, measured: &Measured, tests: usize) -> Cell {
        if self.tame.is_empty() {
            self.tame.clone_from(&measured.passes);
        }
        let paired = matches!(stage.truth, Truth::Tame(_));
        let largest = measured.values.iter().copied().fold(0.0, f64::max);
        let mut sampled = Sampled {
            estimates: measured.moments(),
            values: (!paired).then(|| measured.values.clone()),
            largest,
            draws: measured.samples(),
            tolerance: stage.tolerance,
            paired,
            alike: stage.alike,
            invalid: measured.counters.invalid,
            negative: measured.counters.negative,
            definition: measured.definition,
            ..Sampled::default()
        };
        let pairs = |factor: f64| measured.passes.iter().zip(&self.tame).map(move |(a, b)| a - factor * b);
        match stage.truth {
            Truth::Value(value) => {
                sampled.errors = Moments { mean: sampled.estimates.mean - value, ..sampled.estimates };
                cell.truth = Some(value);
            }
            Truth::Tame(factor) => {
                pairs(factor).for_each(|error| sampled.errors.push(error));
                (sampled.largest, sampled.draws) = (sampled.errors.largest, sampled.errors.count);
                cell.truth = Some(factor * self.tame.iter().sum::<f64>() / self.tame.len() as f64);
            }
        }
        let samples = measured.samples();
        let mean = sampled.estimates.mean;
        let variance = sampled.estimates.variance() * measured.pixels as f64 / (mean * mean);
        judge(&mut cell, sampled, tests);
        cell.passes = Some(measured.passes.len() as u64);
        cell.samples = Some(samples);
        cell.variance = Some(variance).filter(|variance| variance.is_finite());
        cell.firefly = (mean > 0.0).then(|| largest / mean);
        cell.seconds_per_sample = Some(measured.seconds / samples.max(1) as f64);
        cell.rays_per_sample = Some(measured.rays_per_sample());
        let tame = self.cells.first().unwrap_or(&cell).clone();
        let growth = |now: Option<f64>, tame: Option<f64>| now.zip(tame).map(|(now, tame)| now / tame);
        cell.variance_growth = growth(cell.variance, tame.variance).filter(|growth| growth.is_finite());
        cell.time_growth = growth(cell.seconds_per_sample, tame.seconds_per_sample);
        cell
    }

    /// The exponent of rays over the parameter between the last two values, in numbers and in words.
    fn law(&self, case: &Case) -> Option<(f64, String)> {
        let exponent = exponent(&self.rays).filter(|exponent| GROWS.contains(&exponent.abs()))?;
        Some((exponent, format!(", growing as ({})^{exponent:.1}", case.parameter)))
    }

    /// Rays of a sample, and the law that foretells them, where nothing speaks against it.
    fn expected_rays(&self, case: &Case, value: f64) -> Option<(f64, String)> {
        let (now, law) = self.law(case)?;
        let &(last, rays) = self.rays.last()?;
        let before = exponent(&self.rays[..self.rays.len() - 1]);
        let steady = before.is_none_or(|before| (0.5..2.0).contains(&(now / before)));
        steady.then(|| (rays * libm::pow(value / last, now), law))
    }
}

/// `log(y₂/y₁) / log(x₂/x₁)` of the last two points (x, y).
fn exponent(points: &[(f64, f64)]) -> Option<f64> {
    let [.., (x1, y1), (x2, y2)] = *points else { return None };
    Some(libm::log(y2 / y1) / libm::log(x2 / x1)).filter(|exponent| exponent.is_finite())
}
