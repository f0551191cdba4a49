//! Both images of a case: the same in expectation?

use std::path::Path;

use anyhow::anyhow;

use crate::estimator::{Control, Registry};
use crate::film::exr::read_exr;
use crate::film::{BlockGrid, BlockStatistics, Film, Image, RenderInfo, write_image};
use crate::report::npy::{Array, read_npy};
use crate::report::{Agreement, AgreementSettings, Verdict as Tested};
use crate::scene::Scene;
use crate::spectrum::Rgb;

use crate::cli::interrupt;

use super::ParityArgs;
use super::case::Case;
use super::row::{ParityRow, Verdict};

/// Probability that a report on faultless renderers has a failure; half of it for images, half for albedos.
pub(super) const SIGNIFICANCE: f64 = 1e-3;

/// Probability with which the detectable differences are found.
pub(super) const POWER: f64 = 0.9;

/// Our samples per pixel, where the effort is one; with --full.
const SPP: [u64; 2] = [1024, 4096];

/// Light paths for each sample: few come to the camera.
const LIGHT_PATHS: u64 = 8;

/// Films of a single pixel have so many passes at most.
const MOST_PASSES: u64 = 1 << 19;

/// Relative difference of the mean that is allowed to an independent image.
const INDEPENDENT: f64 = 0.03;

/// Of the normal distribution, for intervals of 95 %.
const QUANTILE: f64 = 1.96;

/// Ours and Mitsuba's integrators. The last are for --full.
const PAIRS: [(&str, &str); 3] = [("path", "path"), ("light", "ptracer"), ("bdpt", "path")];

/// Compares all pairs of integrators that there are images of.
pub(super) fn compare(
    registry: &Registry,
    scene: &Scene,
    case: &Case,
    folder: &Path,
    args: &ParityArgs,
    cases: usize,
) -> anyhow::Result<Vec<ParityRow>> {
    let pairs = if args.full { &PAIRS[..] } else { &PAIRS[..2] };
    let has = |theirs: &str| case.integrators.iter().any(|name| name == theirs);
    let pairs: Vec<_> = pairs.iter().filter(|(_, theirs)| has(theirs)).collect();
    let tests = cases * PAIRS.len();
    let significance = 0.5 * SIGNIFICANCE / tests as f64;
    let settings = AgreementSettings { significance, power: POWER, ..AgreementSettings::default() };
    let size = scene.sensor().film();
    let mut rows = Vec::new();
    for &&(ours, theirs) in &pairs {
        let comparison = format!("{ours}/{theirs}");
        let path = folder.join(format!("mitsuba-{theirs}.npy"));
        let passes = read_npy(&path)?;
        if passes.shape.get(1..) != Some(&[size.height as usize, size.width as usize, 3]) {
            let what = format!("Mitsuba's image is {:?}, ours {} x {}", &passes.shape, size.width, size.height);
            rows.push(ParityRow::new(&case.name, comparison, Verdict::Differ, what));
            continue;
        }
        let mask = mask(size.width, size.height, case.border);
        let their_statistics = statistics(&passes, size.width, size.height, &mask)?;
        let film = render(registry, scene, ours, case, args, mask)?;
        write_image(&folder.join(format!("ours-{ours}.exr")), &film, &RenderInfo::default(), 0.0)?;
        if let (Some(path), "path") = (&case.independent, ours) {
            rows.push(against_independent(case, &film.mean_image(), path)?);
        }
        let test = Agreement::test(film.block_statistics(), &their_statistics, &settings)?;
        rows.push(row(&case.name, comparison, &test));
    }
    Ok(rows)
}

fn row(feature: &str, comparison: String, test: &Agreement) -> ParityRow {
    let verdict = match test.verdict {
        Tested::Agree => Verdict::Agree,
        Tested::Differ => Verdict::Differ,
        Tested::Undecided(_) => Verdict::Undecided,
    };
    ParityRow {
        difference: Some(test.image.relative_difference),
        interval: Some(QUANTILE * test.image.relative_error),
        detectable: Some(test.image.detectable),
        block_detectable: Some(test.block_detectable),
        power: Some(test.power),
        blocks_differing: Some(test.differing),
        ..ParityRow::new(feature, comparison, verdict, test.to_string())
    }
}

/// The mean of our image and of one by a third renderer, which may have other conventions for what is hidden in noise.
fn against_independent(case: &Case, ours: &Image, path: &Path) -> anyhow::Result<ParityRow> {
    let theirs = read_exr(path)?.mean().luminance();
    let difference = ours.mean().luminance() / theirs - 1.0;
    let verdict = if difference.abs() < INDEPENDENT { Verdict::Agree } else { Verdict::Differ };
    let details = format!("the mean is {:+.2} % of that of {}", 100.0 * difference, path.display());
    let comparison = path.file_stem().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    Ok(ParityRow { difference: Some(difference), ..ParityRow::new(&case.name, comparison, verdict, details) })
}

/// Pixels that count: all but the border.
fn mask(width: u32, height: u32, border: u32) -> Vec<bool> {
    let inside = |at: u32, size: u32| at >= border && at + border < size;
    (0..height).flat_map(|y| (0..width).map(move |x| inside(x, width) && inside(y, height))).collect()
}

fn statistics(passes: &Array, width: u32, height: u32, mask: &[bool]) -> anyhow::Result<BlockStatistics> {
    let mut statistics = BlockStatistics::new(BlockGrid::new(width, height, Some(mask))?);
    for pass in passes.data.chunks_exact(3 * mask.len()) {
        let pixels = pass.chunks_exact(3).map(|c| Rgb::new(c[0], c[1], c[2])).collect();
        statistics.add_pass(&Image::new(width, height, pixels)?.block_means(Some(mask))?)?;
    }
    Ok(statistics)
}

fn render(
    registry: &Registry,
    scene: &Scene,
    integrator: &str,
    case: &Case,
    args: &ParityArgs,
    mask: Vec<bool>,
) -> anyhow::Result<Film> {
    let method = registry.build(integrator, &[("max_length", case.max_depth.to_string())])?;
    let size = scene.sensor().film();
    let mut film = Film::new(size.width, size.height, Some(mask))?;
    let light_paths = if integrator == "light" { LIGHT_PATHS } else { 1 };
    // Samples of bdpt take long, and have less noise.
    let more = args.full && integrator != "bdpt";
    let mut left = Passes((SPP[usize::from(more)] * case.effort * light_paths).min(MOST_PASSES));
    method.integrator.render(scene, args.seed, &mut film, &mut left);
    if interrupt::requested() {
        return Err(anyhow!("interrupted"));
    }
    Ok(film)
}

/// So many are left.
struct Passes(u64);

impl Control for Passes {
    fn next_passes(&mut self, _: &Film) -> u64 {
        /// Between two looks at the user's wishes.
        const BATCH: u64 = 64;
        let next = if interrupt::requested() { 0 } else { self.0.min(BATCH) };
        self.0 -= next;
        next
    }
}
