//! Is the truth within the noise?

use crate::film::Moments;
use crate::report::statistics::Welch;
use crate::testing::verify::TailIndex;

use super::cell::{Cell, Verdict};

/// Probability that a report on faultless methods has a failure.
pub const SIGNIFICANCE: f64 = 1e-3;

/// Probability with which a detectable bias is found.
pub const POWER: f64 = 0.9;

/// A bias that is larger must be seen, or nothing is said.
const COARSEST: f64 = 0.1;

/// Pixels of passes that are not black: fewer say nothing.
const FEWEST: usize = 50;

/// What Welch's tail tells of few outliers that make up all of the variance.
const FEW_OUTLIERS: f64 = 0.3;

/// A relative standard error below this is that of rounding, of which outliers say nothing.
const ROUNDING: f64 = 1e-7;

/// Deviation of a weight's sum from one, and of a term from its definition, that is none.
const WEIGHTS: f64 = 1e-9;
const DEFINITION: f64 = 1e-6;

/// Of the normal distribution, for intervals of 95 %.
const QUANTILE: f64 = 1.96;

/// What was sampled of a cell, by whatever program.
#[derive(Clone, Debug, Default)]
pub(super) struct Sampled {
    /// Independent estimates less the truth, or less what they are paired with.
    pub errors: Moments,
    /// What these are compared with where it is uncertain itself, of mean zero.
    pub against: Moments,
    /// The estimates themselves.
    pub estimates: Moments,
    /// Pixels of passes that are not black, where they are known.
    pub values: Option<Vec<f64>>,
    /// The largest pixel of a pass.
    pub largest: f64,
    /// Pixels of all passes.
    pub draws: u64,
    /// NaN or infinite contributions or pixels.
    pub invalid: u64,
    /// Negative ones.
    pub negative: u64,
    /// Largest deviation of weights and terms from their definition.
    pub definition: Option<(f64, f64)>,
    /// Relative error of the truth.
    pub tolerance: f64,
    /// Light is as rare as it is at the tame value.
    pub alike: bool,
    /// Estimates are paired with those of the tame value: where few of them went other ways, their errors are outliers.
    pub paired: bool,
}

/// Fills in what the samples say of a cell whose truth is set. `tests` is the number of all cells.
pub(super) fn judge(cell: &mut Cell, mut sampled: Sampled, tests: usize) {
    let truth = cell.truth.unwrap_or(f64::NAN);
    let scale = if truth == 0.0 { 1.0 } else { truth.abs() };
    let exact = Moments { count: sampled.errors.count, ..Moments::default() };
    let welch = Welch::new(&sampled.errors, if sampled.against.count > 0 { &sampled.against } else { &exact });
    let level = SIGNIFICANCE / tests.max(1) as f64;
    // No event in N draws has a probability above ln(1/level)/N. Light that was never found, and is no brighter than the
    // brightest that was, may be missing; there is no such excuse for too much light.
    let unseen = libm::log(1.0 / level) * sampled.largest / sampled.draws.max(1) as f64;
    let missing = if welch.difference < 0.0 { unseen } else { 0.0 };
    let tolerance = sampled.tolerance * scale + missing;
    let tail = sampled.values.as_deref_mut().and_then(TailIndex::of);
    let lit = sampled.values.as_ref().map_or(usize::MAX, Vec::len);
    let detectable = welch.detectable(level, POWER, sampled.tolerance * scale + unseen) / scale;
    cell.estimate = Some(sampled.estimates.mean);
    cell.difference = Some(welch.difference / scale);
    cell.interval = Some(QUANTILE * welch.standard_error / scale);
    cell.z = (welch.standard_error > 0.0).then(|| welch.statistic(tolerance));
    cell.detectable = Some(detectable);
    cell.tail_index = tail.map(|tail| tail.alpha).filter(|alpha| alpha.is_finite());
    cell.invalid = Some(sampled.invalid);
    cell.negative = Some(sampled.negative);
    (cell.weights, cell.definition) = sampled.definition.unzip();
    let differs = welch.p_value(tolerance) < level;
    let (weights, definition) = sampled.definition.unwrap_or_default();
    let noisy = welch.standard_error > ROUNDING * scale;
    (cell.verdict, cell.details) = if sampled.invalid + sampled.negative > 0 {
        (Verdict::Fails, format!("{} values are no number, {} are negative", sampled.invalid, sampled.negative))
    } else if !sampled.estimates.is_finite() {
        (Verdict::Fails, "the mean is no number".into())
    } else if weights > WEIGHTS {
        (Verdict::Fails, format!("weights add up to 1 ± {weights:.0e}"))
    } else if definition > DEFINITION {
        (Verdict::Fails, format!("a term is off its definition by {definition:.0e}"))
    } else if truth == 0.0 && lit == 0 {
        (Verdict::Holds, String::new())
    } else if lit < FEWEST && !sampled.alike {
        (Verdict::Noise, format!("light was found {lit} times"))
    } else if let Some(tail) = tail.filter(|tail| noisy && tail.is_infinite()) {
        (Verdict::Noise, format!("no variance in sight: tail index {:.1}", tail.alpha))
    } else if noisy && welch.tail > FEW_OUTLIERS && (differs || !sampled.paired) {
        (Verdict::Noise, "a few outliers make up the variance".into())
    } else if differs {
        (Verdict::Fails, format!("off by {:+.2e} of the truth", welch.difference / scale))
    } else if detectable > COARSEST {
        (Verdict::Noise, format!("a bias of {:.0} % would not be seen", 100.0 * detectable))
    } else {
        (Verdict::Holds, String::new())
    };
}

/// Where others find all light in a cell, samples alone do not tell light that is too rare for a method from light that it
/// loses: nothing is said of one that finds a small part.
pub(super) fn too_rare(cell: &mut Cell) {
    let share = 1.0 + cell.difference.unwrap_or(0.0);
    let right = cell.weights.unwrap_or(0.0) <= WEIGHTS && cell.definition.unwrap_or(0.0) <= DEFINITION;
    let possible = cell.invalid == Some(0) && cell.negative == Some(0) && right;
    if cell.verdict == Verdict::Fails && possible && (0.0..1.0 - COARSEST).contains(&share) {
        cell.verdict = Verdict::Noise;
        cell.details = format!("{:.0} % of the light that others find: the rest is too rare", 100.0 * share);
    }
}
