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
pub(super) const FEWEST_LIT: usize = 50;

/// What Welch's tail tells of few outliers that make up all of the variance.
const FEW_OUTLIERS: f64 = 0.3;

/// A relative standard error below this is that of rounding, of which outliers say nothing.
const ROUNDING: f64 = 1e-7;

/// Few outliers matter where more of them would: as large as those seen, they are part of the detectable bias.
const FINE: f64 = 0.01;

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
    } else if lit < FEWEST_LIT && !sampled.alike {
        (Verdict::Noise, format!("light was found {lit} times"))
    } else if let Some(tail) = tail.filter(|tail| noisy && tail.is_infinite()) {
        (Verdict::Noise, format!("no variance in sight: tail index {:.1}", tail.alpha))
    } else if noisy && welch.tail > FEW_OUTLIERS && (differs || detectable > FINE && !sampled.paired) {
        (Verdict::Noise, "a few outliers make up the variance".into())
    } else if differs {
        (Verdict::Fails, format!("off by {:+.2e} of the truth", welch.difference / scale))
    } else if detectable > COARSEST {
        (Verdict::Noise, format!("a bias of {:.0} % would not be seen", 100.0 * detectable))
    } else {
        (Verdict::Holds, String::new())
    };
}

/// Samples alone do not tell light that is too rare for a method from light that it loses: nothing is said of one that finds a
/// small part, unless light is as rare for all.
pub(super) fn too_rare(cell: &mut Cell) {
    let share = 1.0 + cell.difference.unwrap_or(0.0);
    let right = cell.weights.unwrap_or(0.0) <= WEIGHTS && cell.definition.unwrap_or(0.0) <= DEFINITION;
    let possible = cell.invalid == Some(0) && cell.negative == Some(0) && right;
    if cell.verdict == Verdict::Fails && possible && (0.0..1.0 - COARSEST).contains(&share) {
        cell.verdict = Verdict::Noise;
        cell.details = format!("{:.0} % of the light was found: the rest is too rare, or lost", 100.0 * share);
    }
}

#[cfg(test)]
mod tests {
    use super::super::case::{Case, Exact, Subject};
    use super::*;
    use crate::sampler::Random;

    fn case() -> Case {
        let subject = Subject::Number(|_| Exact { estimate: 1.0, truth: 1.0, tolerance: 0.0 });
        Case { group: "g", name: "n", parameter: "p", values: vec![1.0, 2.0], about: "", limit: None, subject }
    }

    /// 500 passes of 48 pixels, each a number below two drawn with the chance, of mean one but for a bias.
    fn verdict(chance: f64, bias: f64, change: impl Fn(&mut Sampled)) -> Cell {
        let mut random = Random::new(4, 0, 0);
        let mut sampled = Sampled { values: Some(Vec::new()), tolerance: 1e-9, ..Sampled::default() };
        for _ in 0..500 {
            let mut pixel = || if random.uniform() < chance { 2.0 * random.uniform() / chance } else { 0.0 };
            let pixels: Vec<f64> = (0..48).map(|_| (1.0 + bias) * pixel()).collect();
            let pass = pixels.iter().sum::<f64>() / 48.0;
            sampled.largest = pixels.iter().copied().fold(sampled.largest, f64::max);
            sampled.values.as_mut().unwrap().extend(pixels.iter().filter(|&&x| x > 0.0));
            sampled.estimates.push(pass);
            sampled.errors.push(pass - 1.0);
            sampled.draws += 48;
        }
        change(&mut sampled);
        let mut cell = Cell { truth: Some(1.0), ..Cell::of(&case(), 2.0, "m") };
        judge(&mut cell, sampled, 1000);
        cell
    }

    #[test]
    fn a_bias_that_is_said_to_be_detectable_is_detected_and_none_is_not() {
        let cell = verdict(1.0, 0.0, |_| ());
        assert_eq!(cell.verdict, Verdict::Holds, "{}", cell.details);
        let detectable = cell.detectable.unwrap();
        assert!(detectable < 0.04, "{detectable}");
        for bias in [1.2 * detectable, -1.2 * detectable] {
            assert_eq!(verdict(1.0, bias, |_| ()).verdict, Verdict::Fails, "{bias}");
        }
    }

    #[test]
    fn what_is_hardly_ever_seen_says_nothing() {
        assert_eq!(verdict(1e-3, 0.0, |_| ()).verdict, Verdict::Noise);
        assert_eq!(verdict(0.0, 0.0, |_| ()).verdict, Verdict::Noise);
        // Where light is as rare as it ever was, none at all is a failure.
        assert_eq!(verdict(0.0, 0.0, |sampled| sampled.alike = true).verdict, Verdict::Fails);
    }

    #[test]
    fn impossible_values_and_wrong_weights_are_never_excused() {
        let changes: [fn(&mut Sampled); 5] = [
            |sampled| sampled.invalid = 1,
            |sampled| sampled.negative = 1,
            |sampled| sampled.definition = Some((1e-6, 0.0)),
            |sampled| sampled.definition = Some((0.0, 1e-3)),
            |sampled| sampled.estimates.push(f64::NAN),
        ];
        for change in changes {
            let mut cell = verdict(1e-3, 0.0, change);
            assert_eq!(cell.verdict, Verdict::Fails);
            too_rare(&mut cell);
            assert_eq!(cell.verdict, Verdict::Fails, "{}", cell.details);
        }
    }

    #[test]
    fn only_a_large_part_of_the_light_can_be_too_rare() {
        let lost = |bias: f64| {
            let mut cell = verdict(1.0, bias, |_| ());
            too_rare(&mut cell);
            cell.verdict
        };
        assert_eq!(lost(-0.5), Verdict::Noise);
        assert_eq!(lost(-0.07), Verdict::Fails);
        assert_eq!(lost(0.5), Verdict::Fails);
    }
}
