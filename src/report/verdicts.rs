//! `verdicts.csv`: for each pair of methods, how much less time the one needs for the same error.
//!
//! The error at which they are compared is the smallest that both reach with a checkpoint to spare. With T(e) the time at which
//! the mean over seeds first falls to e, by straight lines in logarithms, the verdict is on `T_other(e) / T_method(e)`: the
//! logarithms of the times are jackknifed over seeds, at a fixed e, and their difference has Student's interval with the
//! degrees of freedom of Welch and Satterthwaite. `tests/properties/coverage.rs` measures how often it holds the true ratio.

use serde::Serialize;

use super::curves::{Group, Point, Resampled, error_at, groups, slope};
use super::interval::{Estimate, Jackknifed};
use super::metric::Metric;
use super::rows::{Row, SCHEMA};
use super::table::number;

/// Where some of the seeds do not reach the error, their curve is continued to so many times its last time.
const REACH: f64 = 4.0;

/// One line of `verdicts.csv`, a pair of methods and a metric.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VerdictRow {
    /// Version of the table.
    pub schema: u32,
    /// Name of the scene.
    pub scene: String,
    /// See [`Row::hardware`]; times of unlike machines are not compared.
    pub hardware: String,
    /// The metric.
    pub metric: &'static str,
    /// The method that needs less time, as far as is seen.
    pub method: String,
    /// The method that needs more.
    pub other: String,
    /// Number of seeds, the smaller of both.
    pub seeds: usize,
    /// The error at which they are compared.
    pub target_error: Option<f64>,
    /// Time of the other over time of the method.
    pub time_ratio: Option<f64>,
    /// Lower end of its 95 % interval.
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
    /// The same in words.
    pub verdict: String,
    /// The first time at which the order of their errors changes, seen at 95 % before and after \[s\].
    pub crossing_seconds: Option<f64>,
}

impl VerdictRow {
    /// The interval leaves no doubt about which is faster.
    #[must_use]
    pub fn is_decided(&self) -> bool {
        self.low.is_some_and(|low| low > 1.0)
    }
}

/// A method with what is true of its curve: not below the noise of the reference, and positive, so that it has a logarithm.
struct Side<'a> {
    group: &'a Group<'a>,
    curve: Resampled,
}

/// All pairs of methods that ran on a scene with like machines.
#[must_use]
pub fn verdicts(rows: &[Row], metrics: &[Metric]) -> Vec<VerdictRow> {
    let groups = groups(rows);
    let mut verdicts = Vec::new();
    for scene in groups.chunk_by(|a, b| a.scene == b.scene) {
        for &metric in metrics {
            let true_of = |point: &Point| point.below_noise != Some(true) && point.error > 0.0;
            let side = |group| Side { group, curve: Group::resampled(group, metric).filtered(true_of) };
            let sides: Vec<Side<'_>> = scene.iter().map(side).collect();
            for (i, a) in sides.iter().enumerate() {
                let alike = |b: &&Side<'_>| b.group.hardware == a.group.hardware;
                verdicts.extend(sides[i + 1..].iter().filter(alike).map(|b| verdict(a, b, metric)));
            }
        }
    }
    verdicts
}

/// The logarithm of the first time at which a curve falls to an error. Beyond its ends it is continued with its slope, for
/// replicas, within bounds.
fn log_time(curve: &[Point], error: f64) -> Option<f64> {
    let (first, last) = (curve.first()?, curve.last()?);
    let continued = |end: &Point| {
        let slope = slope(curve).filter(|&slope| slope < -0.1).unwrap_or(-0.1);
        let log = libm::log(error / end.error) / slope;
        (log.abs() <= libm::log(REACH)).then(|| libm::log(end.seconds) + log)
    };
    match curve.iter().position(|point| point.error <= error) {
        None => continued(last),
        Some(0) => continued(first),
        Some(after) => {
            let (left, right) = (&curve[after - 1], &curve[after]);
            let share = libm::log(error / left.error) / libm::log(right.error / left.error);
            Some(libm::log(left.seconds) + share * libm::log(right.seconds / left.seconds))
        }
    }
}

/// The smallest error that a curve reaches with a checkpoint to spare, where it has as many.
fn reached(curve: &[Point]) -> Option<f64> {
    let known = if curve.len() > 2 { &curve[..curve.len() - 1] } else { curve };
    known.iter().map(|point| point.error).reduce(f64::min)
}

enum Comparison {
    /// Logarithm of the second's time over the first's.
    Ratio(f64, Jackknifed),
    /// At least this ratio, of the second's time over the first's.
    AtLeast(f64, f64),
    None,
}

fn compared(a: &Side<'_>, b: &Side<'_>) -> Comparison {
    let (first, second) = (&a.curve.mean, &b.curve.mean);
    let Some(error) = reached(first).zip(reached(second)).map(|(a, b)| a.max(b)) else {
        return Comparison::None;
    };
    let starts = [first[0], second[0]];
    let time = |side: &Side<'_>| side.curve.jackknife(|curve| log_time(curve, error));
    if starts[0].error > error && starts[1].error > error {
        return match (time(b), time(a)) {
            (Some(slower), Some(faster)) => Comparison::Ratio(error, slower.minus(faster)),
            _ => Comparison::None,
        };
    }
    // One of them has less error from its first checkpoint on.
    let early = usize::from(starts[0].error > starts[1].error);
    let late = [second, first][early];
    let bound = log_time(late, error).map(|log| libm::exp(log) / starts[early].seconds);
    match bound.filter(|&bound| bound > 1.0) {
        Some(bound) => Comparison::AtLeast(error, if early == 0 { bound } else { 1.0 / bound }),
        None => Comparison::None,
    }
}

fn verdict(a: &Side<'_>, b: &Side<'_>, metric: Metric) -> VerdictRow {
    let comparison = compared(a, b);
    let a_is_faster = match &comparison {
        Comparison::Ratio(_, log) => log.value >= 0.0,
        Comparison::AtLeast(_, bound) => *bound >= 1.0,
        Comparison::None => true,
    };
    let crossing_seconds = crossing(&a.curve, &b.curve);
    let (a, b) = (a.group, b.group);
    let (faster, slower) = if a_is_faster { (a, b) } else { (b, a) };
    let mut row = VerdictRow {
        schema: SCHEMA,
        scene: a.scene.into(),
        hardware: a.hardware.into(),
        metric: metric.name(),
        method: faster.method.into(),
        other: slower.method.into(),
        seeds: a.seeds.len().min(b.seeds.len()),
        target_error: None,
        time_ratio: None,
        low: None,
        high: None,
        verdict: format!("{} and {} reach no common {metric}", faster.method, slower.method),
        crossing_seconds,
    };
    match comparison {
        Comparison::Ratio(error, log) => {
            let log = Jackknifed { value: log.value.abs(), ..log };
            let Estimate { value, interval } = log.exponential();
            (row.target_error, row.time_ratio) = (Some(metric.shown(error)), Some(value));
            (row.low, row.high) = interval.unzip();
            row.verdict = in_words(&row, metric, value);
        }
        Comparison::AtLeast(error, bound) => {
            let bound = bound.max(1.0 / bound);
            row.target_error = Some(metric.shown(error));
            row.low = Some(bound);
            let bound = number(bound);
            row.verdict = format!(
                "{} needs at least {bound} times less time than {} for the same {metric}",
                row.method, row.other
            );
        }
        Comparison::None => {}
    }
    row
}

fn in_words(row: &VerdictRow, metric: Metric, ratio: f64) -> String {
    let (method, other, ratio) = (&row.method, &row.other, number(ratio));
    match (row.low, row.high) {
        (Some(low), Some(high)) if low > 1.0 => {
            let (low, high) = (number(low), number(high));
            format!("{method} needs {ratio} times less time than {other} for the same {metric}, 95 % [{low}, {high}]")
        }
        (Some(low), Some(high)) => {
            let (low, high) = (number(low), number(high));
            format!("no difference seen between {method} and {other}: {ratio} times, 95 % [{low}, {high}]")
        }
        _ => format!(
            "{method} needs {ratio} times less time than {other} for the same {metric}, by one seed: no interval"
        ),
    }
}

/// Where the order of the errors changes for the first time; both orders are seen at 95 %.
fn crossing(a: &Resampled, b: &Resampled) -> Option<f64> {
    let mut times: Vec<f64> = a.mean.iter().chain(&b.mean).map(|point| point.seconds).collect();
    times.sort_by(f64::total_cmp);
    let gap = |time: f64| Some(libm::log(error_at(&a.mean, time)?) - libm::log(error_at(&b.mean, time)?));
    // Before it: the last time at which the sign is seen, and the sign.
    let mut seen: Option<(usize, f64)> = None;
    for (index, &time) in times.iter().enumerate() {
        let log = |curve: &Resampled| curve.jackknife(|curve| error_at(curve, time).map(libm::log));
        let Some(gap_here) = log(a).zip(log(b)).map(|(a, b)| a.minus(b).estimate()) else { continue };
        let Some((low, high)) = gap_here.interval.filter(|&(low, high)| low * high > 0.0) else { continue };
        let sign = (low + high).signum();
        match seen {
            Some((before, earlier)) if earlier != sign => {
                let change = |pair: &[f64]| {
                    let (left, right) = (gap(pair[0])?, gap(pair[1])?);
                    let share = left / (left - right);
                    (left.signum() == earlier && right.signum() == sign)
                        .then(|| pair[0] * libm::exp(share * libm::log(pair[1] / pair[0])))
                };
                return times[before..=index].windows(2).find_map(change);
            }
            _ => seen = Some((index, sign)),
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// MSE `constant · time^slope` at checkpoints of 1, 2, 4, … s, a seed being off by a factor.
    fn render(method: &str, constant: f64, slope: f64, seeds: &[f64]) -> Vec<Row> {
        let mut rows = Vec::new();
        for (seed, factor) in seeds.iter().enumerate() {
            rows.extend((0..8).map(|checkpoint| {
                let seconds = libm::exp2(f64::from(checkpoint));
                Row {
                    scene: "box".into(),
                    method: method.into(),
                    seed: seed as u64,
                    checkpoint,
                    render_seconds: seconds,
                    mse: Some(factor * constant * libm::pow(seconds, slope)),
                    ..Row::default()
                }
            }));
        }
        rows
    }

    fn one(rows: &[Row]) -> VerdictRow {
        let found = verdicts(rows, &[Metric::Mse]);
        assert_eq!(found.len(), 1);
        found[0].clone()
    }

    #[test]
    fn the_ratio_of_times_for_the_same_error_is_that_of_the_constants() {
        let noise = [0.9, 1.1, 1.05, 0.95];
        let verdict = one(&[render("slow", 6.0, -1.0, &noise), render("fast", 2.0, -1.0, &noise)].concat());
        assert_eq!((verdict.method.as_str(), verdict.other.as_str(), verdict.seeds), ("fast", "slow", 4));
        assert!((verdict.time_ratio.unwrap() - 3.0).abs() < 1e-12, "{verdict:?}");
        assert!(verdict.low.unwrap() > 2.5 && verdict.high.unwrap() < 3.6 && verdict.is_decided(), "{verdict:?}");
        assert!(verdict.verdict.starts_with("fast needs 3.00 times less time than slow for the same mse, 95 % ["));
        assert_eq!(verdict.crossing_seconds, None);
    }

    #[test]
    fn without_a_difference_none_is_told() {
        let rows = [render("a", 2.0, -1.0, &[0.8, 1.3, 1.0]), render("b", 2.02, -1.0, &[1.2, 0.9, 0.9])].concat();
        let verdict = one(&rows);
        assert!(!verdict.is_decided() && verdict.verdict.starts_with("no difference seen"), "{verdict:?}");
        let verdict = one(&[render("a", 2.0, -1.0, &[1.0]), render("b", 6.0, -1.0, &[1.0])].concat());
        assert!(verdict.low.is_none() && verdict.verdict.ends_with("by one seed: no interval"), "{verdict:?}");
    }

    #[test]
    fn curves_without_a_common_error_give_a_bound_or_nothing() {
        let noise = [0.99, 1.01];
        let verdict = one(&[render("slow", 1e4, -1.0, &noise), render("fast", 1.0, -1.0, &noise)].concat());
        assert!(verdict.time_ratio.is_none() && (verdict.low.unwrap() - 64.0).abs() < 1e-9, "{verdict:?}");
        assert!(verdict.verdict.contains("fast needs at least 64.0 times less"), "{verdict:?}");
        let mut late = render("late", 1e-3, -1.0, &noise);
        late.iter_mut().for_each(|row| row.render_seconds *= 1e4);
        let verdict = one(&[late, render("early", 1.0, -1.0, &noise)].concat());
        assert!(verdict.low.is_none() && verdict.verdict.contains("no common mse"), "{verdict:?}");
    }

    #[test]
    fn a_plateau_that_crosses_is_found_where_it_does() {
        let noise = [0.99, 1.0, 1.01];
        // 1/t against 1/16 · t^(-1/4) cross at t = 16^(4/3).
        let rows = [render("unbiased", 1.0, -1.0, &noise), render("biased", 1.0 / 16.0, -0.25, &noise)].concat();
        let crossing = one(&rows).crossing_seconds.unwrap();
        assert!((crossing / libm::pow(16.0, 4.0 / 3.0) - 1.0).abs() < 1e-9, "{crossing}");
        let same = [render("a", 1.0, -1.0, &noise), render("b", 1.0, -1.0, &noise)].concat();
        assert_eq!(one(&same).crossing_seconds, None);
    }

    #[test]
    fn unlike_machines_and_what_is_below_the_noise_of_the_reference_are_not_compared() {
        let (a, mut b) = (render("a", 1.0, -1.0, &[1.0, 1.1]), render("b", 2.0, -1.0, &[1.0, 1.1]));
        b.iter_mut().for_each(|row| row.hardware = "other".into());
        assert!(verdicts(&[a.clone(), b.clone()].concat(), &[Metric::Mse]).is_empty());
        b.iter_mut().for_each(|row| row.hardware.clear());
        let flag = |rows: &mut Vec<Row>| rows.iter_mut().for_each(|r| r.below_reference_noise = Some(r.checkpoint > 3));
        let (mut noisy_a, mut noisy_b) = (a, b);
        flag(&mut noisy_a);
        flag(&mut noisy_b);
        let verdict = one(&[noisy_a, noisy_b].concat());
        // Checkpoint 3 is at 8 s, the one to spare; the slower one's error at 4 s.
        assert!((verdict.target_error.unwrap() / (2.0 * 1.05 / 4.0) - 1.0).abs() < 1e-9, "{verdict:?}");
    }
}
