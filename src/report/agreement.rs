//! Are two converged images the same in expectation?
//!
//! A pass is an independent unbiased estimate of the image, so two methods that estimate the same image have the same
//! mean over passes in every block of pixels. Tested are the mean of each block and channel, and the luminance of the
//! whole image, by Welch's t-test with a correction for skewed passes. Half of the significance goes to the image; the
//! other half is shared by the blocks after Holm (1979), which holds whatever the dependence between them.
//!
//! A t-test says nothing where rare paths carry much of the image. With k equal outliers making up a block's variance the
//! skewness of its mean is 1/√k, so blocks of large skewness, and those in which one pass carries much of the sum, are
//! *heavy-tailed*. They are left out together with their eight neighbours: rare paths that show in one block may be
//! those that the next has missed, and a block that misses them looks harmless and wrong. When too much is left out, or
//! what is left could not have shown a difference of the stated size, the verdict is *undecided*.

use std::fmt;

use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use crate::film::{BlockStatistics, FilmError, Moments};

use super::statistics::{Welch, holm};

/// What counts as different, as heavy-tailed, and as enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AgreementSettings {
    /// Probability of the verdict *differ* for images that are the same in expectation.
    pub significance: f64,
    /// Probability with which the stated detectable differences are found.
    pub power: f64,
    /// Relative difference of means that counts as none: renderers in single precision round.
    pub tolerance: f64,
    /// Below so many passes of either method nothing is decided.
    pub smallest_passes: u64,
    /// A block is heavy-tailed when one pass contributes more than this share of its sum.
    pub largest_share: f64,
    /// A block is heavy-tailed when either method gives the difference of means more than this skewness. At the default,
    /// 6 equal outliers are too few; where about as many are expected and a block may see none, too many others see too
    /// few to reach a verdict at all.
    pub largest_skewness: f64,
    /// Nothing is decided when more than this share of the blocks is left out.
    pub largest_left_out: f64,
    /// *Agree* needs that this relative difference of the whole image's mean would have been detected.
    pub image_limit: f64,
    /// *Agree* needs that this relative difference of a block would have been detected, in half of the blocks.
    pub block_limit: f64,
}

impl Default for AgreementSettings {
    fn default() -> Self {
        Self {
            significance: 1e-3,
            power: 0.9,
            tolerance: 1e-5,
            smallest_passes: 16,
            largest_share: 0.2,
            largest_skewness: 0.4,
            largest_left_out: 0.25,
            image_limit: 0.02,
            block_limit: 0.1,
        }
    }
}

/// What the test says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// No difference was found, and one of the stated size would have been.
    Agree,
    /// At least one mean differs.
    Differ,
    /// Nothing can be said.
    Undecided(Doubt),
}

/// Why nothing can be said.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Doubt {
    /// A method has too few passes.
    FewPasses,
    /// A method produced values that are not finite.
    NotFinite,
    /// Too many blocks, or the image as a whole, are heavy-tailed.
    HeavyTails,
    /// A difference of the stated size could have gone unnoticed.
    LowPower,
}

/// One test of two means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanTest {
    /// `t`: the difference of means over its standard error, method a less method b.
    pub t: f64,
    /// P-value, adjusted for the number of tests.
    pub p_value: f64,
    /// Difference of means over the average of both.
    pub relative_difference: f64,
    /// Standard error of the relative difference.
    pub relative_error: f64,
    /// Relative difference that would have been found with the stated power.
    pub detectable: f64,
}

/// The block and channel with the smallest p-value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorstBlock {
    /// Column and row of the block, from the top left.
    pub block: (usize, usize),
    /// Channel: 0 red, 1 green, 2 blue.
    pub channel: usize,
    /// Its test.
    pub test: MeanTest,
}

/// The outcome for two methods.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agreement {
    /// What the test says.
    pub verdict: Verdict,
    /// Blocks that were tested.
    pub tested: usize,
    /// Blocks that were left out for heavy tails, their own or a neighbour's.
    pub left_out: usize,
    /// Tests of a block and channel that found a difference.
    pub differing: usize,
    /// The test of the whole image's luminance.
    pub image: MeanTest,
    /// The tested block and channel with the smallest p-value; `None` when no block was tested.
    pub worst: Option<WorstBlock>,
    /// Relative difference of a block that would have been found with the stated power: the median over tested blocks and
    /// channels that are not black in both.
    pub block_detectable: f64,
    /// The power that the detectable differences refer to.
    pub power: f64,
}

impl Agreement {
    /// Tests whether methods `a` and `b`, rendering the same scene with independent random numbers, have the same
    /// expectation. Passes may differ in number and in samples per pass.
    ///
    /// # Errors
    /// When the two differ in size or mask.
    pub fn test(a: &BlockStatistics, b: &BlockStatistics, settings: &AgreementSettings) -> Result<Self, FilmError> {
        Self::test_with((a, b), (a, b), settings)
    }

    /// The same where `(a, b)` count some of the blocks only, and `all` are their statistics over more: what is heavy-tailed
    /// in a block that does not count casts doubt on its neighbours and on the image too.
    ///
    /// # Errors
    /// When sizes or masks differ.
    pub fn test_with(
        (a, b): (&BlockStatistics, &BlockStatistics),
        all: (&BlockStatistics, &BlockStatistics),
        settings: &AgreementSettings,
    ) -> Result<Self, FilmError> {
        if a.grid() != b.grid() || all.0.grid() != all.1.grid() || a.grid().len() != all.0.grid().len() {
            return Err(FilmError::Incompatible);
        }
        let (tested, left_out) = choose_blocks(a, all, settings);
        let level = 0.5 * settings.significance;
        let pair = |block: usize, channel: usize| (&a.blocks()[block][channel], &b.blocks()[block][channel]);
        let places: Vec<(usize, usize)> = tested.iter().flat_map(|&block| [0, 1, 2].map(|c| (block, c))).collect();
        let block_level = level / places.len().max(1) as f64;
        let mut tests: Vec<MeanTest> =
            places.iter().map(|&(block, channel)| mean_test(pair(block, channel), block_level, settings)).collect();
        let adjusted = holm(&tests.iter().map(|test| test.p_value).collect::<Vec<_>>());
        let worst = (0..tests.len())
            .min_by(|&i, &j| {
                let (first, second) = (&tests[i], &tests[j]);
                first.p_value.total_cmp(&second.p_value).then(second.t.abs().total_cmp(&first.t.abs()))
            })
            .map(|index| {
                let (block, channel) = places[index];
                let columns = a.grid().columns();
                let test = MeanTest { p_value: adjusted[index], ..tests[index] };
                WorstBlock { block: (block % columns, block / columns), channel, test }
            });
        tests.retain(|test| test.detectable > 0.0);
        let mut agreement = Self {
            verdict: Verdict::Agree,
            tested: tested.len(),
            left_out,
            differing: adjusted.iter().filter(|&&p_value| p_value <= level).count(),
            image: mean_test((&a.image()[3], &b.image()[3]), level, settings),
            worst,
            block_detectable: median(tests.iter().map(|test| test.detectable).collect()).unwrap_or(0.0),
            power: settings.power,
        };
        let all_is_heavy = is_heavy((&all.0.image()[3], &all.1.image()[3]), settings);
        agreement.verdict = agreement.decide(a, b, all_is_heavy, settings);
        Ok(agreement)
    }

    fn decide(
        &self,
        a: &BlockStatistics,
        b: &BlockStatistics,
        all_is_heavy: bool,
        settings: &AgreementSettings,
    ) -> Verdict {
        let image = (&a.image()[3], &b.image()[3]);
        if a.passes().min(b.passes()) < settings.smallest_passes.max(2) {
            return Verdict::Undecided(Doubt::FewPasses);
        }
        if !(image.0.is_finite() && image.1.is_finite()) {
            return Verdict::Undecided(Doubt::NotFinite);
        }
        let left_out = self.left_out as f64 > settings.largest_left_out * (self.left_out + self.tested) as f64;
        if left_out || self.tested == 0 {
            return Verdict::Undecided(Doubt::HeavyTails);
        }
        let image_is_heavy = is_heavy(image, settings);
        let image_differs = !image_is_heavy && self.image.p_value <= 0.5 * settings.significance;
        if self.differing > 0 || (image_differs && !all_is_heavy) {
            return Verdict::Differ;
        }
        if image_is_heavy || image_differs {
            return Verdict::Undecided(Doubt::HeavyTails);
        }
        if self.image.detectable <= settings.image_limit && self.block_detectable <= settings.block_limit {
            Verdict::Agree
        } else {
            Verdict::Undecided(Doubt::LowPower)
        }
    }
}

/// Whether several renders of one method with different seeds scatter as their passes do: the two-sided p-value of the
/// F-test of the variance between renders against that within, of the image's luminance. A small one says that passes
/// are not independent, or that seeds repeat each other. `None` below two renders of two passes, or without variance.
#[must_use]
pub fn between_seeds_p_value(renders: &[BlockStatistics]) -> Option<f64> {
    let mut pooled = Moments::default();
    let mut within = 0.0;
    for render in renders {
        pooled.merge(&render.image()[3]);
        within += render.image()[3].second;
    }
    let between_freedom = renders.len().checked_sub(1)? as f64;
    let within_freedom = pooled.count.checked_sub(renders.len() as u64)? as f64;
    let distribution = FisherSnedecor::new(between_freedom, within_freedom).ok()?;
    let ratio = (pooled.second - within).max(0.0) / between_freedom / (within / within_freedom);
    ratio.is_finite().then(|| (2.0 * distribution.cdf(ratio).min(distribution.sf(ratio))).min(1.0))
}

fn mean_test((a, b): (&Moments, &Moments), level: f64, settings: &AgreementSettings) -> MeanTest {
    let welch = Welch::new(a, b);
    let scale = 0.5 * (a.mean + b.mean).abs();
    let tolerance = settings.tolerance * scale;
    let relative = |value: f64| if value == 0.0 { 0.0 } else { value / scale };
    MeanTest {
        t: welch.statistic(tolerance),
        p_value: welch.p_value(tolerance),
        relative_difference: relative(welch.difference),
        relative_error: relative(welch.standard_error),
        detectable: relative(welch.detectable(level, settings.power, tolerance)),
    }
}

fn is_heavy((a, b): (&Moments, &Moments), settings: &AgreementSettings) -> bool {
    let share = |m: &Moments| m.largest > settings.largest_share * m.count as f64 * m.mean.abs();
    share(a) || share(b) || Welch::new(a, b).tail > settings.largest_skewness
}

/// The blocks to test, those that count in `a`, and how many others are left out for heavy tails in `all`.
fn choose_blocks(
    a: &BlockStatistics,
    all: (&BlockStatistics, &BlockStatistics),
    settings: &AgreementSettings,
) -> (Vec<usize>, usize) {
    let grid = a.grid();
    let counts = |block: &usize| grid.pixels()[*block] > 0;
    let heavy: Vec<bool> = (0..grid.len())
        .map(|block| {
            let channels = all.0.blocks()[block].iter().zip(&all.1.blocks()[block]);
            all.0.grid().pixels()[block] > 0 && channels.into_iter().any(|pair| is_heavy(pair, settings))
        })
        .collect();
    let (columns, rows) = (grid.columns(), grid.rows());
    let near_heavy = |block: &usize| {
        let (x, y) = (block % columns, block / columns);
        let row_range = y.saturating_sub(1)..(y + 2).min(rows);
        row_range.into_iter().any(|y| heavy[y * columns..][x.saturating_sub(1)..(x + 2).min(columns)].contains(&true))
    };
    let (left_out, tested): (Vec<_>, Vec<_>) = (0..grid.len()).filter(counts).partition(near_heavy);
    (tested, left_out.len())
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let half = values.len() / 2;
    match values.len() {
        0 => None,
        length if length % 2 == 1 => Some(values[half]),
        _ => Some(0.5 * (values[half - 1] + values[half])),
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Agree => "agree",
            Self::Differ => "differ",
            Self::Undecided(Doubt::FewPasses) => "undecided (too few passes)",
            Self::Undecided(Doubt::NotFinite) => "undecided (values that are not finite)",
            Self::Undecided(Doubt::HeavyTails) => "undecided (too heavy-tailed)",
            Self::Undecided(Doubt::LowPower) => "undecided (too little power)",
        })
    }
}

/// One line with the verdict, what it rests on, and its power.
impl fmt::Display for Agreement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}: image mean {:+.3} % ± {:.3} %",
            self.verdict,
            100.0 * self.image.relative_difference,
            100.0 * self.image.relative_error
        )?;
        if let Some(worst) = &self.worst {
            let (x, y) = worst.block;
            let channel = ["red", "green", "blue"][worst.channel.min(2)];
            write!(f, "; worst block ({x}, {y}) {channel}: t = {:.1}, p = {:.2e}", worst.test.t, worst.test.p_value)?;
        }
        write!(
            f,
            "; {} blocks tested, {} left out; found with probability {}: {:.2} % of the image, {:.1} % of a block",
            self.tested,
            self.left_out,
            self.power,
            100.0 * self.image.detectable,
            100.0 * self.block_detectable
        )
    }
}

#[cfg(test)]
#[path = "agreement_tests.rs"]
mod tests;
