//! One line for each feature in a terminal of 80 columns.

use std::fmt::Write;

use crate::report::{cut, number};

use super::row::{ParityRow, Verdict};

const NAME_WIDTH: usize = 36;

/// The worst comparison of each kind counts.
pub(super) fn table(rows: &[ParityRow]) -> String {
    let mut text =
        format!("{:NAME_WIDTH$} {:>15} {:>6} {:>8} {}\n", "feature", "image differs %", "finds", "error of", "verdict");
    let mut count = [0_usize; 4];
    for rows in rows.chunk_by(|a, b| a.feature == b.feature) {
        let verdict = rows.iter().map(|row| row.verdict).max().unwrap_or(Verdict::Missing);
        count[verdict as usize] += 1;
        let line = line(rows, verdict);
        let _ = writeln!(text, "{}", line.trim_end());
    }
    let [agree, undecided, missing, differ] = count;
    let _ = writeln!(text, "\n{agree} agree, {differ} differ, {undecided} undecided, {missing} missing");
    text += "image: ours less Mitsuba's, with 95 % interval; finds: what would show with probability 0.9\n";
    text
}

fn line(rows: &[ParityRow], verdict: Verdict) -> String {
    let worst = |images: bool| {
        let is_of_kind = |row: &&ParityRow| {
            if images { row.comparison.contains('/') } else { row.largest_error.is_some() }
        };
        let of_kind = rows.iter().filter(is_of_kind);
        of_kind.max_by(|a, b| a.verdict.cmp(&b.verdict).then(surprise(a).total_cmp(&surprise(b))))
    };
    let percent = |value: Option<f64>| value.map_or_else(String::new, |value| number(100.0 * value));
    let image = worst(true);
    let difference = image.map_or_else(String::new, |row| {
        format!("{:+.2} ± {:.2}", 100.0 * row.difference.unwrap_or(0.0), 100.0 * row.interval.unwrap_or(0.0))
    });
    let points = worst(false);
    let error = points.map_or_else(String::new, |row| format!("{:.0e}", row.largest_error.unwrap_or(0.0)));
    let name = cut(&rows[0].feature, NAME_WIDTH);
    let finds = percent(image.and_then(|row| row.detectable));
    format!("{name:NAME_WIDTH$} {difference:>15} {finds:>6} {error:>8} {verdict}")
}

/// The same for a document, in full.
pub(super) fn markdown(rows: &[ParityRow]) -> String {
    let mut text = String::from(
        "| feature | comparison | verdict | image differs by [%] | finds [%] | in a block [%] | largest error | bound |\n\
         |---|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        let percent = |value: Option<f64>| value.map_or_else(String::new, |value| number(100.0 * value));
        let difference = row.difference.map_or_else(String::new, |difference| {
            let interval = row.interval.map_or_else(String::new, |interval| format!(" ± {:.3}", 100.0 * interval));
            format!("{:+.3}{interval}", 100.0 * difference)
        });
        let error = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:.1e}"));
        let _ = writeln!(
            text,
            "| {} | {} | {} | {difference} | {} | {} | {} | {} |",
            row.feature,
            row.comparison,
            row.verdict,
            percent(row.detectable),
            percent(row.block_detectable),
            error(row.largest_error),
            error(row.bound)
        );
    }
    text
}

/// How far a comparison is from none, in its own measure.
fn surprise(row: &ParityRow) -> f64 {
    match (row.difference, row.interval, row.largest_error, row.bound) {
        (Some(difference), Some(interval), _, _) if interval > 0.0 => difference.abs() / interval,
        (_, _, Some(error), Some(bound)) if bound > 0.0 => error / bound,
        _ => 0.0,
    }
}
