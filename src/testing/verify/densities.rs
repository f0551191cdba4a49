//! Samplers draw paths with the densities that they claim.

use crate::estimator::Combination;
use crate::estimator::driver::random_of;
use crate::film::Moments;
use crate::report::statistics::Welch;
use crate::sampler::Tracer;
use crate::scene::Scene;
use crate::scene::sensor::Pixel;
use crate::wide::Wide;

use super::report::{Check, POWER, SIGNIFICANCE};
use super::{Effort, LONGEST};

/// A sampler and a length.
#[derive(Clone, Default)]
struct Tally {
    /// Over passes: paths drawn less paths claimed.
    difference: Moments,
    /// Of the pass in hand.
    pass: f64,
    /// Paths drawn in all passes.
    drawn: f64,
    /// Variance of the difference over all passes if the claim is true and paths are independent.
    variance: f64,
}

/// Fewer paths than this on either side say nothing.
const FEWEST: f64 = 25.0;

/// Sampler i draws `∫ n_i p_i dμ` paths in a pass, its probability of success times its samples. The integral is estimated by
/// the paths of all samplers j together, each counted as `r_i = n_i p_i / Σ_l n_l p_l`: a number between 0 and 1, whatever the
/// densities are. Only paths with f > 0 that nothing hides count, for every sampler.
///
/// If the claim is true, the difference has the variance `Σ r_i (1 − r_i)` over all paths; what was measured may be less
/// where rare paths have not occurred, so the larger of both counts.
///
/// Of the samplers, the first `own` ones are checked.
pub(super) fn check(combination: &Combination, own: usize, scene: &Scene, name: &str, effort: Effort) -> Vec<Check> {
    let mut tallies = vec![vec![Tally::default(); LONGEST as usize]; combination.samplers.len()];
    let passes = effort.passes.div_ceil(2);
    for sample in 0..passes {
        count_pass(combination, scene, effort.seed, sample, &mut tallies);
        for tally in tallies.iter_mut().flatten() {
            tally.difference.push(tally.pass);
            tally.pass = 0.0;
        }
    }
    let lengths = tallies
        .iter()
        .take(own)
        .enumerate()
        .flat_map(|(i, by_length)| by_length.iter().enumerate().map(move |t| (i, t)));
    lengths
        .filter(|(_, (_, tally))| tally.variance >= FEWEST)
        .map(|(i, (k, tally))| {
            let difference = with_variance(tally.difference, tally.variance / passes as f64);
            let welch = Welch::new(&difference, &Moments { count: passes, ..Moments::default() });
            let relative = |x: f64| 100.0 * x * passes as f64 / tally.drawn.max(1.0);
            let technique = combination.samplers[i].technique(k as u32 + 1);
            let found =
                format!("{technique}: {:+.2} ± {:.2} %", relative(welch.difference), relative(welch.standard_error));
            let power = format!("{:.1} %", relative(welch.detectable(SIGNIFICANCE, POWER, 0.0)));
            let check = Check::exact("density", name, false, found, power);
            Check { p_value: Some(welch.p_value(1e-9 * tally.drawn / passes as f64)), ..check }
        })
        .collect()
}

/// The moments with a variance of single numbers of at least so much.
pub(super) fn with_variance(moments: Moments, variance: f64) -> Moments {
    Moments { second: moments.second.max(variance * (moments.count.max(2) - 1) as f64), ..moments }
}

/// Adds one pass of all samplers.
fn count_pass(combination: &Combination, scene: &Scene, seed: u64, sample: u64, tallies: &mut [Vec<Tally>]) {
    let film = scene.sensor().film();
    for (x, y) in (0..film.height).flat_map(|y| (0..film.width).map(move |x| (x, y))) {
        let mut random = random_of(scene, seed, Pixel { x, y }, sample);
        for (i, sampler) in combination.samplers.iter().enumerate() {
            let mut paths = Vec::new();
            let tracer = &mut Tracer::new(scene);
            sampler.sample(1..=LONGEST, tracer, &mut random, Pixel { x, y }, &mut |path| paths.push(path));
            for path in paths {
                let matters = scene.contribution(&path).is_some_and(|f| !f.is_black());
                if !matters || !scene.unobstructed(&path) {
                    continue;
                }
                let k = path.edges() - 1;
                let densities = combination.densities(scene, &path);
                let total = densities.iter().copied().sum::<Wide>();
                tallies[i][k].drawn += 1.0;
                tallies[i][k].pass += 1.0;
                if total.is_zero() {
                    continue;
                }
                for (j, density) in densities.iter().enumerate() {
                    let share = (*density / total).to_f64();
                    tallies[j][k].pass -= share;
                    tallies[j][k].variance += share * (1.0 - share);
                }
            }
        }
    }
}
