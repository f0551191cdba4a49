//! `summary.csv`: what the rows say of each scene and method.
//!
//! Squared errors are interpolated over time as straight lines in logarithms, `log MSE` over `log t`, within the
//! checkpoints of a render and never beyond them; over seeds they are averaged as `mean MSE`.

use std::path::Path;

use serde::Serialize;

use super::error::ReportError;
use super::rows::{Row, write_table};
use super::statistics::fitted_slope;

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

/// One line of `summary.csv`; columns stand in the order of the fields, a missing value is an empty cell.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SummaryRow {
    /// Name of the scene.
    pub scene: String,
    /// Name of the method.
    pub method: String,
    /// The program that ran it.
    pub renderer: String,
    /// Number of seeds.
    pub seeds: usize,
    /// Samples per pixel and second of rendering at the last checkpoint, mean over seeds \[1/s\].
    pub spp_per_second: Option<f64>,
    /// The time at which errors are compared \[s\]: the last at which most methods can be compared with the base.
    pub equal_time: Option<f64>,
    /// Mean over seeds of the MSE at the equal time; missing where the method has no checkpoints on both sides of it.
    pub mse: Option<f64>,
    /// Its root.
    pub rmse: Option<f64>,
    /// Mean over seeds of relMSE at the equal time.
    pub relmse: Option<f64>,
    /// Standard deviation over seeds of the RMSE at the equal time, relative to its mean; missing below two seeds.
    pub rmse_spread: Option<f64>,
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
    /// The method that others are compared with: the first of Mitsuba, else the first.
    pub base: String,
    /// Slope of log RMSE over log time, mean over seeds of each one's line of least squares; −1/2 for independent samples
    /// of finite variance.
    pub slope: Option<f64>,
    /// Its standard error: from the spread over seeds, or for one seed from the residuals, which is too small because
    /// checkpoints of one render share their samples.
    pub slope_error: Option<f64>,
    /// Mean over seeds of the mean ratio at the last checkpoint.
    pub mean_ratio: Option<f64>,
    /// Sum over seeds of what was not finite at the last checkpoint.
    pub invalid: u64,
}

/// Times \[s\] in ascending order with a value at each.
type Curve = Vec<(f64, f64)>;

/// All renders of one method on one scene.
struct Group<'a> {
    scene: &'a str,
    method: &'a str,
    renderer: &'a str,
    /// Rows of each seed, ascending in time.
    seeds: Vec<Vec<&'a Row>>,
}

impl<'a> Group<'a> {
    /// One curve per seed, of the checkpoints at which `value` is positive.
    fn curves(&self, value: impl Fn(&Row) -> Option<f64>) -> Vec<Curve> {
        let usable = |row: &&Row| Some((row.render_seconds, value(row)?)).filter(|&(time, v)| time > 0.0 && v > 0.0);
        self.seeds.iter().map(|rows| rows.iter().filter_map(usable).collect()).collect()
    }

    fn last_rows(&self) -> impl Iterator<Item = &'a Row> + '_ {
        self.seeds.iter().filter_map(|rows| rows.last().copied())
    }

    /// The time that every seed has reached.
    fn last_time(&self) -> Option<f64> {
        let ends = self.curves(|row| row.mse).into_iter().map(|curve| curve.last().map(|&(time, _)| time));
        ends.collect::<Option<Vec<f64>>>()?.into_iter().reduce(f64::min)
    }
}

/// The value at a time by interpolation in logarithms; `None` outside the curve.
fn interpolate(curve: &[(f64, f64)], time: f64) -> Option<f64> {
    let after = curve.partition_point(|&(t, _)| t < time);
    let &(t1, v1) = curve.get(after)?;
    if t1 == time {
        return Some(v1);
    }
    let &(t0, v0) = curve.get(after.checked_sub(1)?)?;
    let share = libm::log(time / t0) / libm::log(t1 / t0);
    Some(v0 * libm::exp(share * libm::log(v1 / v0)))
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// The sample standard deviation.
fn deviation(values: &[f64]) -> Option<f64> {
    let mean = mean(values).filter(|_| values.len() > 1)?;
    Some((values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (values.len() - 1) as f64).sqrt())
}

/// Values of all seeds at a time; `None` unless every seed has one.
fn at(curves: &[Curve], time: f64) -> Option<Vec<f64>> {
    curves.iter().map(|curve| interpolate(curve, time)).collect()
}

/// When the mean over seeds first falls to the target; outside the times that all seeds share, a bound.
fn time_to_reach(curves: &[Curve], target: f64) -> Option<(f64, Bound)> {
    // The last time that all seeds have reached counts, whether or not it is one of the first seed's.
    let end = curves.iter().filter_map(|curve| curve.last()).map(|&(time, _)| time).fold(f64::INFINITY, f64::min);
    let times = curves.first()?.iter().map(|&(time, _)| time).filter(|&time| time < end).chain([end]);
    let pooled: Curve = times.filter_map(|time| Some((time, mean(&at(curves, time)?)?))).collect();
    let after = pooled.iter().position(|&(_, value)| value <= target);
    match after {
        None => pooled.last().map(|&(time, _)| (time, Bound::After)),
        Some(0) if pooled[0].1 == target => Some((pooled[0].0, Bound::At)),
        Some(0) => Some((pooled[0].0, Bound::Before)),
        Some(after) => {
            let ((t0, v0), (t1, v1)) = (pooled[after - 1], pooled[after]);
            let share = libm::log(target / v0) / libm::log(v1 / v0);
            Some((t0 * libm::exp(share * libm::log(t1 / t0)), Bound::At))
        }
    }
}

fn slope(curves: &[Curve]) -> (Option<f64>, Option<f64>) {
    let in_logarithms = |curve: &Curve| curve.iter().map(|&(t, v)| (libm::log(t), 0.5 * libm::log(v))).collect();
    let lines: Vec<_> =
        curves.iter().filter_map(|curve| fitted_slope(&Vec::from_iter::<Curve>(in_logarithms(curve)))).collect();
    let slopes: Vec<f64> = lines.iter().map(|&(slope, _)| slope).collect();
    let error = match lines.as_slice() {
        [(_, error)] => *error,
        _ => deviation(&slopes).map(|deviation| deviation / (slopes.len() as f64).sqrt()),
    };
    (mean(&slopes), error)
}

/// Groups in order of first appearance.
fn groups(rows: &[Row]) -> Vec<Group<'_>> {
    let mut groups: Vec<Group<'_>> = Vec::new();
    for row in rows {
        let key = (row.scene.as_str(), row.method.as_str(), row.renderer.as_str());
        let group = match groups.iter_mut().find(|group| (group.scene, group.method, group.renderer) == key) {
            Some(group) => group,
            None => {
                groups.push(Group { scene: key.0, method: key.1, renderer: key.2, seeds: Vec::new() });
                let last = groups.len() - 1;
                &mut groups[last]
            }
        };
        match group.seeds.iter_mut().find(|rows| rows[0].seed == row.seed) {
            Some(rows) => rows.push(row),
            None => group.seeds.push(vec![row]),
        }
    }
    for rows in groups.iter_mut().flat_map(|group| &mut group.seeds) {
        rows.sort_by(|a, b| a.render_seconds.total_cmp(&b.render_seconds));
    }
    groups
}

/// The time at which most methods can be compared with the base, and the latest such.
fn equal_time(groups: &[&Group<'_>], base: &Group<'_>) -> Option<f64> {
    let covers = |group: &Group<'_>, time: f64| at(&group.curves(|row| row.mse), time).is_some();
    let rank = |time: f64| (covers(base, time), groups.iter().filter(|group| covers(group, time)).count());
    let candidates = groups.iter().filter_map(|group| group.last_time());
    candidates.max_by(|&a, &b| rank(a).cmp(&rank(b)).then(a.total_cmp(&b)))
}

/// One line per scene and method, in the order of their first rows.
#[must_use]
pub fn summarise(rows: &[Row]) -> Vec<SummaryRow> {
    let all = groups(rows);
    let mut scenes: Vec<&str> = Vec::new();
    for group in &all {
        if !scenes.contains(&group.scene) {
            scenes.push(group.scene);
        }
    }
    let of_scene = |scene: &str| all.iter().filter(|group| group.scene == scene).collect::<Vec<_>>();
    scenes.into_iter().flat_map(|scene| summarise_scene(&of_scene(scene))).collect()
}

fn summarise_scene(groups: &[&Group<'_>]) -> Vec<SummaryRow> {
    let Some(base) = groups.iter().find(|group| group.method.starts_with("mitsuba")).or(groups.first()) else {
        return Vec::new();
    };
    let time = equal_time(groups, base);
    let target = time.and_then(|time| mean(&at(&base.curves(|row| row.mse), time)?));
    let row = |group: &Group<'_>| {
        let curves = group.curves(|row| row.mse);
        let at_time = time.and_then(|time| at(&curves, time));
        let roots: Vec<f64> = at_time.iter().flatten().map(|mse| mse.sqrt()).collect();
        let mse = at_time.as_deref().and_then(mean);
        let reached = target.and_then(|target| time_to_reach(&curves, target));
        let (slope, slope_error) = slope(&curves);
        let speed = |row: &Row| Some(row.spp as f64 / row.render_seconds).filter(|speed| speed.is_finite());
        SummaryRow {
            scene: group.scene.to_owned(),
            method: group.method.to_owned(),
            renderer: group.renderer.to_owned(),
            seeds: group.seeds.len(),
            spp_per_second: mean(&group.last_rows().filter_map(speed).collect::<Vec<_>>()),
            equal_time: time,
            mse,
            rmse: mse.map(f64::sqrt),
            relmse: time.and_then(|time| mean(&at(&group.curves(|row| row.relmse), time)?)),
            rmse_spread: deviation(&roots).zip(mean(&roots)).map(|(deviation, mean)| deviation / mean),
            target_rmse: target.map(f64::sqrt),
            time_to_target: reached.map(|(time, _)| time),
            time_bound: reached.map(|(_, bound)| bound),
            efficiency: mse.zip(time).map(|(mse, time)| 1.0 / (mse * time)),
            relative_efficiency: mse.zip(target).map(|(mse, target)| target / mse),
            base: base.method.to_owned(),
            slope,
            slope_error,
            mean_ratio: mean(&group.last_rows().filter_map(|row| row.mean_ratio).collect::<Vec<_>>()),
            invalid: group.last_rows().map(|row| row.invalid).sum(),
        }
    };
    groups.iter().map(|group| row(group)).collect()
}

/// Writes `summary.csv`; atomically.
///
/// # Errors
/// When the file cannot be written.
pub fn write_summary(path: &Path, summary: &[SummaryRow]) -> Result<(), ReportError> {
    write_table(path, summary)
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
        assert!((found / expected - 1.0).abs() < 1e-12, "{found} instead of {expected}");
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
        assert_eq!(path.rmse_spread, None);
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
    fn seeds_are_averaged_and_their_spread_is_told() {
        let rows = [render("path", 1, 1.0, &[1.0, 8.0]), render("path", 2, 9.0, &[1.0, 16.0])].concat();
        let summary = summarise(&rows);
        assert_eq!((summary.len(), summary[0].seeds, summary[0].equal_time), (1, 2, Some(8.0)));
        close(summary[0].mse, 5.0 / 8.0);
        // RMSE of the seeds 1 : 3, so mean 2 and standard deviation √2.
        close(summary[0].rmse_spread, 0.5 * 2.0_f64.sqrt());
        close(summary[0].slope, -0.5);
        assert!(summary[0].slope_error.unwrap() < 1e-12);
    }

    #[test]
    fn rows_without_reference_or_with_zero_error_leave_cells_empty() {
        let mut rows = render("path", 1, 1.0, &[1.0, 8.0]);
        rows.iter_mut().for_each(|row| row.mse = None);
        rows.extend(render("exact", 1, 0.0, &[1.0, 8.0]));
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("summary.csv");
        let summary = summarise(&rows);
        assert!(summary.iter().all(|row| row.mse.is_none() && row.slope.is_none() && row.time_to_target.is_none()));
        write_summary(&path, &summary).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.starts_with("scene,method,renderer,seeds,spp_per_second,equal_time,mse,rmse,relmse,rmse_spread,"));
        assert_eq!(text.lines().count(), 3);
        assert!(summarise(&[]).is_empty());
    }
}
