//! `summary.csv`: what the rows say of each scene, method and kind of machine.
//!
//! Errors are means over seeds, at checkpoints that all seeds have, and straight lines in logarithms, `log MSE` over `log t`,
//! between them, and no more than a tenth of the time beyond. Intervals are Student's in logarithms, by the jackknife over seeds (see [`super::interval`]).

use serde::Serialize;

use super::curves::{Group, Point, Resampled, error_at, groups, slope};
use super::interval::{Estimate, Jackknifed};
use super::metric::Metric;
use super::rows::{Row, SCHEMA};

/// Where the time to reach an error lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Bound {
    /// Between two checkpoints, interpolated.
    #[serde(rename = "=")]
    At,
    /// Before the first checkpoint: the time is an upper bound.
    #[serde(rename = "<")]
    Before,
    /// After the last checkpoint: the time is a lower bound.
    #[serde(rename = ">")]
    After,
}

/// One line of `summary.csv`; columns stand in the order of the fields, a missing value is an empty cell. Ends of intervals are
/// of 95 %.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SummaryRow {
    /// Version of the table.
    pub schema: u32,
    /// Name of the scene.
    pub scene: String,
    /// Name of the method.
    pub method: String,
    /// The program that ran it.
    pub renderer: String,
    /// See [`Row::hardware`].
    pub hardware: String,
    /// Number of seeds.
    pub seeds: usize,
    /// Samples per pixel and second of rendering at the last checkpoint, mean over seeds \[1/s\].
    pub spp_per_second: Option<f64>,
    /// Processor seconds per second of rendering at the last checkpoint: below the threads where others used the machine.
    pub cpu_per_second: Option<f64>,
    /// The time at which errors are compared \[s\]: the last at which most methods can be compared with the base.
    pub equal_time: Option<f64>,
    /// Mean over seeds of the MSE at the equal time; missing where the method has no checkpoints on both sides of it.
    pub mse: Option<f64>,
    /// Its lower end.
    pub mse_low: Option<f64>,
    /// Its upper end.
    pub mse_high: Option<f64>,
    /// Root of the MSE.
    pub rmse: Option<f64>,
    /// Mean over seeds of relMSE at the equal time.
    pub relmse: Option<f64>,
    /// Its lower end.
    pub relmse_low: Option<f64>,
    /// Its upper end.
    pub relmse_high: Option<f64>,
    /// MAPE at the equal time.
    pub mape: Option<f64>,
    /// SMAPE at the equal time.
    pub smape: Option<f64>,
    /// Trimmed MSE at the equal time.
    pub trimmed_mse: Option<f64>,
    /// Trimmed relMSE at the equal time.
    pub trimmed_relmse: Option<f64>,
    /// ꟻLIP at the equal time.
    pub flip: Option<f64>,
    /// The RMSE of the base method at the equal time.
    pub target_rmse: Option<f64>,
    /// Time at which the mean MSE first falls to the target's \[s\].
    pub time_to_target: Option<f64>,
    /// Whether that time is interpolated or a bound.
    pub time_bound: Option<Bound>,
    /// Efficiency `1 / (MSE · time)` at the equal time \[1/(radiance² s)\].
    pub efficiency: Option<f64>,
    /// Efficiency over that of the base method.
    pub relative_efficiency: Option<f64>,
    /// Its lower end.
    pub relative_low: Option<f64>,
    /// Its upper end.
    pub relative_high: Option<f64>,
    /// The method that others are compared with: the first of Mitsuba, else the first.
    pub base: String,
    /// Slope of log RMSE over log time, of the line of least squares through the checkpoints; −1/2 for independent samples of
    /// finite variance.
    pub slope: Option<f64>,
    /// Its lower end; missing for one seed.
    pub slope_low: Option<f64>,
    /// Its upper end.
    pub slope_high: Option<f64>,
    /// Mean over seeds of the mean ratio at the last checkpoint.
    pub mean_ratio: Option<f64>,
    /// Mean over pixels of the squared difference between expectation and reference, from the last images of all seeds, with
    /// their noise and the reference's taken off: it varies around 0 where there is no bias.
    pub bias2: Option<f64>,
    /// Its standard error, from the spread over pixels: too large where the bias is not the same everywhere.
    pub bias2_error: Option<f64>,
    /// Mean over pixels of the variance of one seed's last image.
    pub variance: Option<f64>,
    /// At the last checkpoint an error is smaller than the reference's noise; missing where that is not known.
    pub below_reference_noise: Option<bool>,
    /// Sum over seeds of what was not finite at the last checkpoint.
    pub invalid: u64,
    /// Sum over seeds of contributions that were negative where the weighting promises none.
    pub negative: Option<u64>,
}

/// A method with its curves.
struct Summed<'a> {
    group: &'a Group<'a>,
    mse: Resampled,
    relmse: Resampled,
}

impl<'a> Summed<'a> {
    fn new(group: &'a Group<'a>) -> Self {
        Self { group, mse: group.resampled(Metric::Mse), relmse: group.resampled(Metric::Relmse) }
    }

    fn mse_at(&self, seconds: f64) -> Option<f64> {
        error_at(&self.mse.mean, seconds)
    }

    /// The last time at which there is an error of all seeds.
    fn last_time(&self) -> Option<f64> {
        self.mse.mean.iter().rev().find(|point| point.error > 0.0).map(|point| point.seconds)
    }
}

fn log_at(curve: &Resampled, seconds: Option<f64>) -> Option<Jackknifed> {
    curve.jackknife(|curve| error_at(curve, seconds?).map(libm::log))
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// When the error first falls to the target; outside the curve, a bound.
fn time_to_reach(curve: &[Point], target: f64) -> Option<(f64, Bound)> {
    match curve.iter().position(|point| point.error <= target) {
        None => curve.last().map(|point| (point.seconds, Bound::After)),
        Some(0) if curve[0].error == target => Some((curve[0].seconds, Bound::At)),
        Some(0) => Some((curve[0].seconds, Bound::Before)),
        Some(after) => {
            let (left, right) = (&curve[after - 1], &curve[after]);
            let share = libm::log(target / left.error) / libm::log(right.error.max(f64::MIN_POSITIVE) / left.error);
            Some((left.seconds * libm::exp(share * libm::log(right.seconds / left.seconds)), Bound::At))
        }
    }
}

/// The time at which most methods can be compared with the base, and the latest such.
fn equal_time(all: &[Summed<'_>], base: &Summed<'_>) -> Option<f64> {
    let covers = |method: &Summed<'_>, time: f64| method.mse_at(time).is_some();
    let rank = |time: f64| (covers(base, time), all.iter().filter(|method| covers(method, time)).count());
    let candidates = all.iter().filter_map(Summed::last_time);
    candidates.max_by(|&a, &b| rank(a).cmp(&rank(b)).then(a.total_cmp(&b)))
}

/// One line per scene, method and kind of machine, in the order of their first rows.
#[must_use]
pub fn summarise(rows: &[Row]) -> Vec<SummaryRow> {
    groups(rows).chunk_by(|a, b| a.scene == b.scene).flat_map(summarise_scene).collect()
}

fn summarise_scene(groups: &[Group<'_>]) -> Vec<SummaryRow> {
    let all: Vec<Summed<'_>> = groups.iter().map(Summed::new).collect();
    let Some(base) = all.iter().find(|method| method.group.method.starts_with("mitsuba")).or(all.first()) else {
        return Vec::new();
    };
    let time = equal_time(&all, base);
    let target = time.and_then(|time| base.mse_at(time));
    all.iter().map(|method| summarise_method(method, base, time, target)).collect()
}

fn summarise_method(own: &Summed<'_>, base: &Summed<'_>, time: Option<f64>, target: Option<f64>) -> SummaryRow {
    let group = own.group;
    let at = |metric: Metric| time.and_then(|time| error_at(&group.resampled(metric).mean, time));
    let interval = |estimate: Option<Jackknifed>| estimate.and_then(|found| found.exponential().interval).unzip();
    let mse = time.and_then(|time| own.mse_at(time));
    let (mse_low, mse_high) = interval(log_at(&own.mse, time));
    let (relmse_low, relmse_high) = interval(log_at(&own.relmse, time));
    let gain = log_at(&base.mse, time).zip(log_at(&own.mse, time)).map(|(base, own)| base.minus(own));
    let (relative_low, relative_high) = interval(gain.filter(|_| !std::ptr::eq(own, base)));
    let reached = target.and_then(|target| time_to_reach(&own.mse.mean, target));
    // Of the RMSE: half of the MSE's.
    let slope = own.mse.jackknife(|curve| slope(curve).map(|slope| 0.5 * slope)).map(Jackknifed::estimate);
    let (slope_low, slope_high) = slope.and_then(|Estimate { interval, .. }| interval).unzip();
    let last = |of: &dyn Fn(&Row) -> Option<f64>| mean(&group.last_rows().filter_map(of).collect::<Vec<_>>());
    let finite = |value: f64| Some(value).filter(|value| value.is_finite());
    let noisy: Option<Vec<bool>> = group.last_rows().map(|row| row.below_reference_noise).collect();
    SummaryRow {
        schema: SCHEMA,
        scene: group.scene.to_owned(),
        method: group.method.to_owned(),
        renderer: group.last_rows().next().map_or_else(String::new, |row| row.renderer.clone()),
        hardware: group.hardware.to_owned(),
        seeds: group.seeds.len(),
        spp_per_second: last(&|row| finite(row.spp as f64 / row.render_seconds)),
        cpu_per_second: last(&|row| finite(row.cpu_seconds? / row.render_seconds)),
        equal_time: time,
        mse,
        mse_low,
        mse_high,
        rmse: mse.map(f64::sqrt),
        relmse: at(Metric::Relmse),
        relmse_low,
        relmse_high,
        mape: at(Metric::Mape),
        smape: at(Metric::Smape),
        trimmed_mse: at(Metric::TrimmedMse),
        trimmed_relmse: at(Metric::TrimmedRelmse),
        flip: at(Metric::Flip),
        target_rmse: target.map(f64::sqrt),
        time_to_target: reached.map(|(time, _)| time),
        time_bound: reached.map(|(_, bound)| bound),
        efficiency: mse.zip(time).map(|(mse, time)| 1.0 / (mse * time)),
        relative_efficiency: mse.zip(target).map(|(mse, target)| target / mse),
        relative_low,
        relative_high,
        base: base.group.method.to_owned(),
        slope: slope.map(|slope| slope.value),
        slope_low,
        slope_high,
        mean_ratio: last(&|row| row.mean_ratio),
        bias2: None,
        bias2_error: None,
        variance: None,
        below_reference_noise: noisy.map(|noisy| noisy.contains(&true)),
        invalid: group.last_rows().map(|row| row.invalid).sum(),
        negative: group.last_rows().map(|row| row.negative).sum(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A method of efficiency `1/constant`, exactly `MSE = constant / t`, at the given times.
    pub(in crate::report) fn render(method: &str, seed: u64, constant: f64, times: &[f64]) -> Vec<Row> {
        let row = |(index, &time): (usize, &f64)| Row {
            scene: "box".into(),
            method: method.into(),
            seed,
            checkpoint: index as u32,
            spp: (10.0 * time) as u64,
            render_seconds: time,
            mse: Some(constant / time),
            relmse: Some(2.0 * constant / time),
            mean_ratio: Some(1.0),
            ..Row::default()
        };
        times.iter().enumerate().map(row).collect()
    }

    fn close(found: Option<f64>, expected: f64) {
        let found = found.unwrap_or(f64::NAN);
        assert!((found / expected - 1.0).abs() < 1e-9, "{found} instead of {expected}");
    }

    #[test]
    fn exact_curves_give_exact_efficiencies_times_and_slopes() {
        let rows =
            [render("path", 1, 3.0, &[1.0, 5.0, 25.0]), render("mitsuba:path", 1, 12.0, &[0.5, 2.0, 10.0, 20.0])]
                .concat();
        let summary = summarise(&rows);
        let (path, mitsuba) = (&summary[0], &summary[1]);
        assert_eq!((path.base.as_str(), path.equal_time), ("mitsuba:path", Some(20.0)));
        close(path.rmse, (3.0_f64 / 20.0).sqrt());
        close(path.relmse, 6.0 / 20.0);
        close(path.efficiency, 1.0 / 3.0);
        close(path.relative_efficiency, 4.0);
        close(path.time_to_target, 5.0);
        close(path.slope, -0.5);
        close(path.spp_per_second, 10.0);
        close(mitsuba.relative_efficiency, 1.0);
        close(mitsuba.time_to_target, 20.0);
        assert_eq!((path.mse_low, path.slope_low, path.relative_low), (None, None, None));
    }

    #[test]
    fn nothing_is_extrapolated() {
        let rows = [
            render("mitsuba:path", 1, 4.0, &[1.0, 10.0]),
            render("early", 1, 400.0, &[0.1, 0.5]),
            render("late", 1, 0.001, &[20.0, 40.0]),
            render("slow", 1, 400.0, &[1.0, 20.0]),
            render("fast", 1, 0.1, &[1.0, 20.0]),
        ]
        .concat();
        let summary = summarise(&rows);
        assert_eq!(summary[0].equal_time, Some(10.0));
        assert!(summary[1..3].iter().all(|row| row.rmse.is_none() && row.relative_efficiency.is_none()));
        let reached: Vec<_> = summary.iter().map(|row| (row.time_to_target, row.time_bound)).collect();
        assert_eq!(reached[1], (Some(0.5), Some(Bound::After)));
        assert_eq!(reached[2], (Some(20.0), Some(Bound::Before)));
        assert_eq!(reached[3], (Some(20.0), Some(Bound::After)));
        assert_eq!(reached[4], (Some(1.0), Some(Bound::Before)));
    }

    #[test]
    fn seeds_are_averaged_and_their_spread_makes_intervals() {
        let times = [1.0, 4.0, 16.0];
        let rows =
            [render("path", 1, 1.0, &times), render("path", 2, 9.0, &times), render("other", 1, 5.0, &times)].concat();
        let summary = summarise(&rows);
        assert_eq!((summary.len(), summary[0].seeds, summary[0].equal_time), (2, 2, Some(16.0)));
        close(summary[0].mse, 5.0 / 16.0);
        // Means without one seed are 9 and 1: the jackknife's standard error of the logarithm is ln 9 / 2, and Student's quantile
        // at one degree of freedom 12.706.
        close(summary[0].mse_high, 5.0 / 16.0 * libm::exp(12.706_204_736 * 0.5 * libm::log(9.0)));
        close(summary[0].slope, -0.5);
        assert!(
            (summary[0].slope_high.unwrap() + 0.5).abs() < 1e-9 && (summary[0].slope_low.unwrap() + 0.5).abs() < 1e-9
        );
        close(summary[1].relative_efficiency, 1.0);
    }

    #[test]
    fn rows_without_reference_or_with_zero_error_leave_cells_empty() {
        let mut rows = render("path", 1, 1.0, &[1.0, 8.0]);
        rows.iter_mut().for_each(|row| row.mse = None);
        rows.extend(render("exact", 1, 0.0, &[1.0, 8.0]));
        let summary = summarise(&rows);
        assert!(summary.iter().all(|row| row.mse.is_none() && row.slope.is_none() && row.time_to_target.is_none()));
        assert!(summarise(&[]).is_empty());
    }
}
