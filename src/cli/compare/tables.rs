//! What an experiment has found, in 80 columns.

use std::io::{self, Write};
use std::path::Path;

use crate::experiment::{AgreementRow, REFERENCE, Report};
use crate::report::tables;

pub(super) fn show(report: &Report, folder: &Path) -> io::Result<()> {
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
    writeln!(out, "wrote {}", folder.display())?;
    out.flush()
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
