//! `curves.csv`: errors over time, means over seeds with bands.

use serde::Serialize;

use super::interval::{self, Jackknifed};
use super::metric::Metric;
use super::rows::{Row, SCHEMA};
use super::statistics::fitted_slope;

/// All renders of one method on one scene, on like machines.
pub(super) struct Group<'a> {
    pub scene: &'a str,
    pub method: &'a str,
    pub hardware: &'a str,
    /// Rows of each seed, by checkpoint.
    pub seeds: Vec<Vec<&'a Row>>,
}

/// Means over seeds at a checkpoint that all of them have.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub checkpoint: u32,
    pub seconds: f64,
    pub spp: f64,
    /// See [`Metric::of`].
    pub error: f64,
    pub below_noise: Option<bool>,
}

/// Groups in order of first appearance, scene by scene.
pub(super) fn groups(rows: &[Row]) -> Vec<Group<'_>> {
    let mut groups: Vec<Group<'_>> = Vec::new();
    for row in rows {
        let key = (row.scene.as_str(), row.method.as_str(), row.hardware.as_str());
        let known = groups.iter().position(|group| (group.scene, group.method, group.hardware) == key);
        let group = known.unwrap_or_else(|| {
            groups.push(Group { scene: key.0, method: key.1, hardware: key.2, seeds: Vec::new() });
            groups.len() - 1
        });
        let seeds = &mut groups[group].seeds;
        match seeds.iter_mut().find(|rows| rows[0].seed == row.seed) {
            Some(rows) => rows.push(row),
            None => seeds.push(vec![row]),
        }
    }
    for rows in groups.iter_mut().flat_map(|group| &mut group.seeds) {
        rows.sort_by_key(|row| row.checkpoint);
    }
    let mut scenes: Vec<&str> = Vec::new();
    for group in &groups {
        if !scenes.contains(&group.scene) {
            scenes.push(group.scene);
        }
    }
    groups.sort_by_key(|group| scenes.iter().position(|&scene| scene == group.scene));
    groups
}

impl<'a> Group<'a> {
    pub fn last_rows(&self) -> impl Iterator<Item = &'a Row> + '_ {
        self.seeds.iter().filter_map(|rows| rows.last().copied())
    }

    /// The mean over some of the seeds.
    fn curve(&self, metric: Metric, seeds: &[usize]) -> Vec<Point> {
        let Some((&first, others)) = seeds.split_first() else { return Vec::new() };
        let n = seeds.len() as f64;
        let point = |row: &Row| {
            let mut sums = Point {
                checkpoint: row.checkpoint,
                seconds: row.render_seconds / n,
                spp: row.spp as f64 / n,
                error: metric.of(row)? / n,
                below_noise: row.below_reference_noise,
            };
            for &seed in others {
                let rows = &self.seeds[seed];
                let row = rows[rows.binary_search_by_key(&row.checkpoint, |row| row.checkpoint).ok()?];
                sums.seconds += row.render_seconds / n;
                sums.spp += row.spp as f64 / n;
                sums.error += metric.of(row)? / n;
                sums.below_noise = sums.below_noise.zip(row.below_reference_noise).map(|(a, b)| a | b);
            }
            (sums.seconds > 0.0 && sums.error.is_finite()).then_some(sums)
        };
        self.seeds[first].iter().filter_map(|row| point(row)).collect()
    }

    /// The mean over all seeds, and without each of them.
    pub fn resampled(&self, metric: Metric) -> Resampled {
        let all: Vec<usize> = (0..self.seeds.len()).collect();
        let without = |left_out: &usize| {
            let others: Vec<usize> = all.iter().copied().filter(|seed| seed != left_out).collect();
            self.curve(metric, &others)
        };
        Resampled { mean: self.curve(metric, &all), without: all.iter().map(without).collect() }
    }
}

/// A curve, as it is over all seeds and would be without each of them.
pub(super) struct Resampled {
    pub mean: Vec<Point>,
    without: Vec<Vec<Point>>,
}

impl Resampled {
    /// A number that a curve gives, with its standard error.
    pub fn jackknife(&self, number: impl Fn(&[Point]) -> Option<f64>) -> Option<Jackknifed> {
        let without: Vec<_> = self.without.iter().map(|curve| number(curve)).collect();
        Jackknifed::new(number(&self.mean), &without)
    }

    /// Without the points that `keep` refuses.
    pub fn filtered(mut self, keep: impl Fn(&Point) -> bool) -> Self {
        self.mean.retain(&keep);
        self.without.iter_mut().for_each(|curve| curve.retain(&keep));
        self
    }
}

/// Lines go on so far beyond the ends of a curve: the last times of seeds differ a little, and so do those of means over some of them.
const BEYOND: f64 = 1.1;

/// The error at a time, by a straight line in logarithms between the two checkpoints next to it; `None` outside the curve, and
/// where it is not positive.
pub(super) fn error_at(curve: &[Point], seconds: f64) -> Option<f64> {
    let (first, last) = (curve.first()?, curve.last()?);
    if seconds * BEYOND < first.seconds || seconds > last.seconds * BEYOND {
        return None;
    }
    let after = curve.partition_point(|point| point.seconds < seconds).clamp(1, curve.len().max(2) - 1);
    let (left, right) = (&curve[after - 1], curve.get(after).unwrap_or(last));
    let share = match libm::log(right.seconds / left.seconds) {
        0.0 => 0.0,
        length => libm::log(seconds / left.seconds) / length,
    };
    let positive = left.error > 0.0 && right.error > 0.0;
    positive.then(|| left.error * libm::exp(share * libm::log(right.error / left.error)))
}

/// Slope of the line of least squares through log error over log time.
pub(super) fn slope(curve: &[Point]) -> Option<f64> {
    let positive = curve.iter().filter(|point| point.error > 0.0);
    let points: Vec<(f64, f64)> = positive.map(|point| (libm::log(point.seconds), libm::log(point.error))).collect();
    fitted_slope(&points).map(|(slope, _)| slope)
}

/// One line of `curves.csv`: a metric at a checkpoint, over all seeds that a method ran with on like machines.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CurveRow {
    /// Version of the table.
    pub schema: u32,
    /// Name of the scene.
    pub scene: String,
    /// Name of the method.
    pub method: String,
    /// See [`Row::hardware`].
    pub hardware: String,
    /// The column of `rows.csv`.
    pub metric: &'static str,
    /// The checkpoint, which all seeds have.
    pub checkpoint: u32,
    /// Number of seeds.
    pub seeds: usize,
    /// Mean of the rendering time \[s\].
    pub seconds: f64,
    /// Mean of the samples per pixel.
    pub spp: f64,
    /// Mean of the error, for `rmse` the root of the mean MSE.
    pub error: f64,
    /// Lower end of its 95 % interval; missing for one seed, and where an error is not positive.
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
    /// In one of the seeds the error is smaller than the reference's noise; missing where that is not known.
    pub below_reference_noise: Option<bool>,
}

/// The curves of all methods.
#[must_use]
pub fn curves(rows: &[Row], metrics: &[Metric]) -> Vec<CurveRow> {
    let mut lines = Vec::new();
    for group in groups(rows) {
        for &metric in metrics {
            lines.extend(group.resampled(metric).mean.into_iter().filter_map(|point| line(&group, metric, &point)));
        }
    }
    lines
}

fn line(group: &Group<'_>, metric: Metric, point: &Point) -> Option<CurveRow> {
    let at = |rows: &Vec<&Row>| metric.of(rows.iter().find(|row| row.checkpoint == point.checkpoint)?);
    let errors = group.seeds.iter().map(at).collect::<Option<Vec<f64>>>()?;
    let estimate = interval::mean(&errors)?;
    let error = metric.shown(estimate.value);
    error.is_finite().then(|| CurveRow {
        schema: SCHEMA,
        scene: group.scene.into(),
        method: group.method.into(),
        hardware: group.hardware.into(),
        metric: metric.name(),
        checkpoint: point.checkpoint,
        seeds: group.seeds.len(),
        seconds: point.seconds,
        spp: point.spp,
        error,
        low: estimate.interval.map(|(low, _)| metric.shown(low)),
        high: estimate.interval.map(|(_, high)| metric.shown(high)),
        below_reference_noise: point.below_noise,
    })
}
