//! What an experiment has found, in 80 columns.

use std::io::{self, Write};
use std::path::Path;

use crate::experiment::{AgreementRow, REFERENCE, Report};
use crate::report::{Metric, VerdictRow, cut, number, tables};

pub(in crate::cli) fn show(report: &Report, folder: &Path) -> io::Result<()> {
    let mut out = io::stdout().lock();
    for scene in report.scenes() {
        for (method, why) in &scene.skipped {
            writeln!(out, "skipped: {}, {method}: {why}", scene.name)?;
        }
    }
    for rows in report.agreement.chunk_by(|a, b| a.scene == b.scene) {
        for rows in rows.chunk_by(|a, b| a.against == b.against) {
            write!(out, "{}", agreement_table(rows))?;
        }
        write!(out, "{}", agreement_note(rows))?;
    }
    writeln!(out, "\n{}", tables(&report.summary))?;
    let metric = report.manifest.metrics.iter().find(|&&metric| metric == Metric::Relmse);
    if let Some(metric) = metric.or(report.manifest.metrics.first()) {
        let verdicts: Vec<&VerdictRow> = report.verdicts.iter().filter(|row| row.metric == metric.name()).collect();
        for rows in verdicts.chunk_by(|a, b| (&a.scene, &a.hardware) == (&b.scene, &b.hardware)) {
            if rows.iter().all(|row| row.target_error.is_none()) {
                continue;
            }
            writeln!(out, "{}", verdict_table(rows))?;
        }
    }
    writeln!(out, "wrote {}", folder.display())?;
    out.flush()
}

/// The method that wins most often against each of the others, in 80 columns.
fn verdict_table(rows: &[&VerdictRow]) -> String {
    let Some(first) = rows.first() else { return String::new() };
    let wins = |method: &str| rows.iter().filter(|row| row.method == method && row.low.is_some()).count();
    let best = rows.iter().map(|row| row.method.as_str()).max_by_key(|method| wins(method)).unwrap_or_default();
    let scene = cut(&first.scene, 24);
    let mut text = format!("{scene}: times less time that {} needs for the same {}\n", cut(best, 20), first.metric);
    let against = |row: &&&VerdictRow| row.method == best || row.other == best;
    let other = |row: &VerdictRow| cut(if row.method == best { &row.other } else { &row.method }, 24);
    let width = rows.iter().filter(against).map(|row| other(row).chars().count()).max().unwrap_or(0);
    for row in rows.iter().filter(against) {
        let turned = |value: Option<f64>| value.map(|value| if row.method == best { value } else { 1.0 / value });
        let (mut low, mut high) = (turned(row.low), turned(row.high));
        if row.method != best {
            (low, high) = (high, low);
        }
        let what = match (turned(row.time_ratio), low, high) {
            (Some(ratio), Some(low), Some(high)) => {
                let unclear = if row.is_decided() { "" } else { "  (no difference seen)" };
                format!("{:>8}  95 % [{}, {}]{unclear}", number(ratio), number(low), number(high))
            }
            (Some(ratio), ..) => format!("{:>8}  (one seed: no interval)", number(ratio)),
            (None, Some(low), None) => format!("{:>8}  at least", number(low)),
            (None, None, Some(high)) => format!("{:>8}  at most", number(high)),
            _ => "no common error".to_owned(),
        };
        let crossing =
            row.crossing_seconds.map_or_else(String::new, |time| format!("; order changes at {} s", number(time)));
        text += &format!("  {:width$}  {what}{crossing}\n", other(row));
    }
    text
}

/// One line for each method, in 80 columns.
fn agreement_table(rows: &[AgreementRow]) -> String {
    let Some(first) = rows.first() else { return String::new() };
    let against = match first.against.as_str() {
        "exact" => "the exact answer",
        REFERENCE => "the reference",
        method => method,
    };
    let mut text = format!("{}: same image as {against}?\n", first.scene);
    let width = rows.iter().map(|row| row.method.chars().count()).max().unwrap_or(0).min(24);
    for row in rows {
        let verdict = match row.verdict.as_str() {
            "differ" => "DIFFER",
            verdict => verdict,
        };
        let method: String = row.method.chars().take(24).collect();
        let difference = format!("{:+.3} ± {:.3} %", 100.0 * row.image_difference, 100.0 * row.image_error);
        let reach = match (row.image_detectable, row.block_detectable) {
            (Some(image), Some(block)) => {
                format!("finds {:.2} %, in a block {:.1} %", 100.0 * image, 100.0 * block)
            }
            _ => format!("at most {:.1} standard errors", row.worst_t.unwrap_or(f64::NAN).abs()),
        };
        text += &format!("  {method:width$}  {verdict}: {difference}; {reach}\n");
    }
    text
}

/// What the tables of a scene mean.
fn agreement_note(rows: &[AgreementRow]) -> String {
    let Some(row) = rows.iter().find(|row| row.image_detectable.is_some()) else { return String::new() };
    let masked = rows.iter().map(|row| row.blocks_masked).max().unwrap_or(0);
    let mut text = format!("  (finds: differences that show with probability {}", row.power);
    if masked > 0 {
        text += &format!("; light tracing: without {masked} blocks that see Dirac surfaces");
    }
    text + ")\n"
}
