//! `agreement.csv`: whether the methods of a scene estimate the same image.

use serde::Serialize;

use crate::film::{BlockGrid, BlockStatistics, FilmError, Image};
use crate::report::agreement::{MeanTest, between_seeds_p_value};
use crate::report::replicas::Replicas;
use crate::report::{Agreement, AgreementSettings, Reference, SCHEMA, Verdict};
use crate::spectrum::Rgb;

use super::run::Finished;

/// A method whose mean is further than so many standard errors from an exact reference differs from it: for a normal
/// distribution once in 16 000 tests.
const EXACT_LIMIT: f64 = 4.0;

/// An exact reference is met only by a mean whose standard error is below this share of it.
const EXACT_ERROR: f64 = 0.01;

/// All finished runs of a method on a scene.
#[derive(Default)]
pub(super) struct Pool {
    renders: Vec<BlockStatistics>,
    restricted: Vec<BlockStatistics>,
    pass_spp: Option<u64>,
    sum: Option<Image>,
    pub spp: u64,
    /// The images of all seeds.
    pub replicas: Replicas,
    seconds: f64,
}

impl Pool {
    /// Adds a run. Passes of another size are no replicates of those before, so their statistics are left out.
    pub fn add(&mut self, run: &Finished) {
        if *self.pass_spp.get_or_insert(run.pass_spp) == run.pass_spp {
            self.renders.push(run.statistics.clone());
            self.restricted.extend(run.restricted.clone());
        }
        let Some(image) = &run.image else { return };
        self.replicas.add(image);
        self.seconds += run.rows.last().map_or(0.0, |row| row.render_seconds);
        let spp = run.rows.last().map_or(0, |row| row.spp);
        let black = || Image { pixels: vec![Rgb::BLACK; image.pixels.len()], ..*image };
        let sum = self.sum.get_or_insert_with(black);
        for (sum, &pixel) in sum.pixels.iter_mut().zip(&image.pixels) {
            *sum += pixel * spp as f64;
        }
        self.spp += spp;
    }

    pub fn is_empty(&self) -> bool {
        self.renders.is_empty()
    }

    /// The mean over all samples of all runs, where there are images.
    pub fn mean_image(&self) -> Option<Image> {
        let sum = self.sum.as_ref()?;
        let pixels = sum.pixels.iter().map(|&sum| sum / self.spp.max(1) as f64).collect();
        Some(Image { pixels, ..*sum })
    }

    /// `1 / (variance · time)` of one seed's image, pixel by pixel; 0 where there is no variance \[1/(radiance² s)\].
    pub fn efficiency_image(&self) -> Option<Image> {
        let variance = self.replicas.variance_image()?;
        let seconds = self.seconds / self.renders.len() as f64;
        let efficiency = |variance: f64| if variance > 0.0 { 1.0 / (variance * seconds) } else { 0.0 };
        Some(Image { pixels: variance.pixels.iter().map(|pixel| pixel.map(efficiency)).collect(), ..variance })
    }

    /// Over all passes of all runs, in all blocks or in those that light methods see.
    fn statistics(&self, restricted: bool) -> Result<Option<BlockStatistics>, FilmError> {
        let renders = if restricted && !self.restricted.is_empty() { &self.restricted } else { &self.renders };
        let Some((first, others)) = renders.split_first() else { return Ok(None) };
        let mut pooled = first.clone();
        others.iter().try_for_each(|other| pooled.merge(other))?;
        Ok(Some(pooled))
    }
}

/// One line of `agreement.csv`; columns stand in the order of the fields. Differences are relative.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AgreementRow {
    /// Version of this table.
    pub schema: u32,
    /// Name of the scene.
    pub scene: String,
    /// Name of the method.
    pub method: String,
    /// The method, or the exact reference, that it is tested against.
    pub against: String,
    /// `agree`, `differ`, or `undecided` with the reason.
    pub verdict: String,
    /// Difference of the whole image's mean luminance.
    pub image_difference: f64,
    /// Its standard error.
    pub image_error: f64,
    /// Difference over standard error.
    pub image_t: f64,
    /// P-value of the image's test; missing for exact references.
    pub image_p: Option<f64>,
    /// Difference of the image that is found with the probability `power`.
    pub image_detectable: Option<f64>,
    /// The same for a block: the median.
    pub block_detectable: Option<f64>,
    /// Blocks that were tested.
    pub blocks_tested: Option<usize>,
    /// Blocks left out for heavy tails.
    pub blocks_left_out: Option<usize>,
    /// Blocks that a light method cannot see, left out of all.
    pub blocks_masked: usize,
    /// Tests of a block and channel that found a difference.
    pub blocks_differing: Option<usize>,
    /// Column of the block with the smallest p-value.
    pub worst_column: Option<usize>,
    /// Its row.
    pub worst_row: Option<usize>,
    /// Its channel, or for exact references that of the image with the largest difference in standard errors.
    pub worst_channel: Option<&'static str>,
    /// Its t.
    pub worst_t: Option<f64>,
    /// Its p-value, corrected for the number of tests.
    pub worst_p: Option<f64>,
    /// Probability with which the detectable differences are found.
    pub power: f64,
    /// Probability of *differ* for methods that agree.
    pub significance: f64,
    /// Passes of the method.
    pub passes: u64,
    /// Passes of the method that it is tested against.
    pub against_passes: Option<u64>,
    /// Whether the method's seeds scatter as its passes do, see [`between_seeds_p_value`].
    pub seeds_p: Option<f64>,
    /// The whole outcome in one line, for people.
    #[serde(skip)]
    pub details: String,
}

impl AgreementRow {
    /// Nothing can be said.
    #[must_use]
    pub fn is_undecided(&self) -> bool {
        self.verdict.starts_with("undecided")
    }

    /// The methods estimate different images.
    #[must_use]
    pub fn differs(&self) -> bool {
        self.verdict == Verdict::Differ.to_string()
    }
}

/// What a rendered reference is called in the column `against`.
pub const REFERENCE: &str = "reference";

const CHANNELS: [&str; 4] = ["red", "green", "blue", "luminance"];

/// Method `a` against method `b`; `masked` where one of them is a light method.
pub(super) fn between(
    names: (&str, &str, &str),
    a: &Pool,
    b: &Pool,
    masked: bool,
) -> Result<Option<AgreementRow>, FilmError> {
    let (Some(ours), Some(theirs)) = (a.statistics(masked)?, b.statistics(masked)?) else { return Ok(None) };
    let (Some(all_ours), Some(all_theirs)) = (a.statistics(false)?, b.statistics(false)?) else { return Ok(None) };
    let passes = theirs.passes();
    let row = tested(names, (&ours, &theirs), (&all_ours, &all_theirs))?;
    Ok(Some(AgreementRow { against_passes: Some(passes), seeds_p: between_seeds_p_value(&a.renders), ..row }))
}

/// A method against a reference of known variance; `None` where that is not known.
pub(super) fn with_reference(
    scene: &str,
    method: &str,
    pool: &Pool,
    reference: &Reference,
    masked: bool,
) -> Result<Option<AgreementRow>, FilmError> {
    let (Some(ours), Some(all_ours)) = (pool.statistics(masked)?, pool.statistics(false)?) else { return Ok(None) };
    let Some(variance) = &reference.variance else { return Ok(None) };
    let of = |grid: &BlockGrid| BlockStatistics::of_reference(grid.clone(), &reference.mean, variance);
    let (theirs, all_theirs) = (of(ours.grid())?, of(all_ours.grid())?);
    let row = tested((scene, method, REFERENCE), (&ours, &theirs), (&all_ours, &all_theirs))?;
    Ok(Some(AgreementRow { seeds_p: between_seeds_p_value(&pool.renders), ..row }))
}

fn tested(
    names: (&str, &str, &str),
    (ours, theirs): (&BlockStatistics, &BlockStatistics),
    all: (&BlockStatistics, &BlockStatistics),
) -> Result<AgreementRow, FilmError> {
    let settings = AgreementSettings::default();
    let test = Agreement::test_with((ours, theirs), all, &settings)?;
    let MeanTest { t, p_value, relative_difference, relative_error, detectable } = test.image;
    let worst = test.worst.as_ref();
    Ok(AgreementRow {
        schema: SCHEMA,
        scene: names.0.into(),
        method: names.1.into(),
        against: names.2.into(),
        verdict: test.verdict.to_string(),
        image_difference: relative_difference,
        image_error: relative_error,
        image_t: t,
        image_p: Some(p_value),
        image_detectable: Some(detectable),
        block_detectable: Some(test.block_detectable),
        blocks_tested: Some(test.tested),
        blocks_left_out: Some(test.left_out),
        blocks_masked: ours.grid().pixels().iter().filter(|&&pixels| pixels == 0).count(),
        blocks_differing: Some(test.differing),
        worst_column: worst.map(|worst| worst.block.0),
        worst_row: worst.map(|worst| worst.block.1),
        worst_channel: worst.map(|worst| CHANNELS[worst.channel.min(2)]),
        worst_t: worst.map(|worst| worst.test.t),
        worst_p: worst.map(|worst| worst.test.p_value),
        power: test.power,
        significance: settings.significance,
        passes: ours.passes(),
        against_passes: None,
        seeds_p: None,
        details: test.to_string(),
    })
}

/// The whole image of a method against an exact radiance: each channel and the luminance.
pub(super) fn with_exact(
    scene: &str,
    method: &str,
    pool: &Pool,
    exact: Rgb,
    masked: bool,
) -> Result<Option<AgreementRow>, FilmError> {
    let Some(statistics) = pool.statistics(masked)? else { return Ok(None) };
    let settings = AgreementSettings::default();
    let [r, g, b] = exact.to_array();
    let values = [r, g, b, exact.luminance()];
    let scores: Vec<(f64, f64, f64)> = statistics
        .image()
        .iter()
        .zip(values)
        .map(|(moments, value)| {
            let (difference, error) = (moments.mean - value, moments.variance_of_mean().sqrt());
            let beyond = (difference.abs() - settings.tolerance * value).max(0.0);
            let t = if beyond > 0.0 { difference.signum() * beyond / error } else { 0.0 };
            (difference / value, error / value, t)
        })
        .collect();
    let worst = (0..4).max_by(|&i, &j| scores[i].2.abs().total_cmp(&scores[j].2.abs())).unwrap_or(3);
    let (difference, error, t) = scores[3];
    let verdict = if scores[worst].2.is_nan() || statistics.passes() < 2 {
        "undecided (values that are not finite)".to_owned()
    } else if scores[worst].2.abs() > EXACT_LIMIT {
        Verdict::Differ.to_string()
    } else if error > EXACT_ERROR {
        "undecided (too little power)".to_owned()
    } else {
        Verdict::Agree.to_string()
    };
    let details = format!(
        "{verdict}: image mean {:+.4} % ± {:.4} % of the exact one; furthest is {}, at {:+.1} standard errors",
        100.0 * difference,
        100.0 * error,
        CHANNELS[worst],
        scores[worst].2
    );
    Ok(Some(AgreementRow {
        schema: SCHEMA,
        scene: scene.into(),
        method: method.into(),
        against: "exact".into(),
        verdict,
        image_difference: difference,
        image_error: error,
        image_t: t,
        image_p: None,
        image_detectable: None,
        block_detectable: None,
        blocks_tested: None,
        blocks_left_out: None,
        blocks_masked: statistics.grid().pixels().iter().filter(|&&pixels| pixels == 0).count(),
        blocks_differing: None,
        worst_column: None,
        worst_row: None,
        worst_channel: Some(CHANNELS[worst]),
        worst_t: Some(scores[worst].2),
        worst_p: None,
        power: settings.power,
        significance: settings.significance,
        passes: statistics.passes(),
        against_passes: None,
        seeds_p: between_seeds_p_value(&pool.renders),
        details,
    }))
}
