//! The summary as tables for a terminal of 80 columns.

use comfy_table::presets::NOTHING;
use comfy_table::{Cell, CellAlignment, ContentArrangement, Table};

use super::summary::{Bound, SummaryRow};

/// Columns of the widest line.
pub const TABLE_WIDTH: usize = 80;

const LABEL_WIDTH: usize = 20;
const DASH: &str = "-";

/// One table per scene, each below a line that names the scene and the time at which errors are compared.
#[must_use]
pub fn tables(summary: &[SummaryRow]) -> String {
    let mut text = String::new();
    for rows in summary.chunk_by(|a, b| a.scene == b.scene) {
        if !text.is_empty() {
            text.push('\n');
        }
        text.push_str(&heading(&rows[0]));
        text.push_str(&table(rows));
    }
    text
}

fn heading(row: &SummaryRow) -> String {
    let scene = cut(&row.scene, 40);
    let Some(time) = row.equal_time else {
        return format!("{scene}: no errors to compare\n");
    };
    let base = cut(&row.base, LABEL_WIDTH);
    let target = row.target_rmse.map_or(DASH.to_owned(), number);
    format!("{scene} after {} s\n  time: until RMSE {target}; gain: efficiency over {base}\n", number(time))
}

fn table(rows: &[SummaryRow]) -> String {
    let mut table = Table::new();
    table.load_style(NOTHING).set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(["method", "spp/s", "RMSE", "± %", "relMSE", "time [s]", "gain", "slope"].map(Cell::new));
    for row in rows {
        // The machine is told only where it tells two lines apart.
        let ambiguous = rows.iter().filter(|other| other.method == row.method).count() > 1;
        let label = if ambiguous { format!("{} {}", row.method, row.hardware) } else { row.method.clone() };
        let plain = |value: Option<f64>| value.map_or(DASH.to_owned(), number);
        table.add_row([
            cut(&label, LABEL_WIDTH),
            plain(row.spp_per_second),
            plain(row.rmse),
            half_width(row).map_or(DASH.to_owned(), |half| number(100.0 * half)),
            plain(row.relmse),
            row.time_to_target.map_or(DASH.to_owned(), |time| format!("{}{}", sign(row.time_bound), number(time))),
            plain(row.relative_efficiency),
            slope(row),
        ]);
    }
    for (index, column) in table.column_iter_mut().enumerate() {
        column.set_padding((0, 1));
        column.set_cell_alignment(if index == 0 { CellAlignment::Left } else { CellAlignment::Right });
    }
    let lines: Vec<String> = table.lines().map(|line| format!("{}\n", line.trim_end())).collect();
    lines.concat()
}

fn sign(bound: Option<Bound>) -> &'static str {
    match bound {
        Some(Bound::Before) => "<",
        Some(Bound::After) => ">",
        Some(Bound::At) | None => "",
    }
}

/// Of the interval of the RMSE, relative to it.
fn half_width(row: &SummaryRow) -> Option<f64> {
    let (low, high) = row.mse_low.zip(row.mse_high)?;
    Some(0.5 * (high.sqrt() - low.sqrt()) / row.rmse?)
}

fn slope(row: &SummaryRow) -> String {
    let error = row.slope_low.zip(row.slope_high).map(|(low, high)| 0.5 * (high - low));
    match (row.slope, error) {
        (Some(slope), Some(error)) if slope.abs() < 100.0 && error < 100.0 => format!("{slope:.2}±{error:.2}"),
        (Some(slope), None) if slope.abs() < 100.0 => format!("{slope:.2}"),
        _ => DASH.to_owned(),
    }
}

/// Three significant digits in at most 9 characters.
pub(crate) fn number(value: f64) -> String {
    let size = value.abs();
    if !value.is_finite() {
        return DASH.to_owned();
    }
    match size {
        _ if size == 0.0 => "0".to_owned(),
        _ if !(0.01..99_999.5).contains(&size) => format!("{value:.2e}"),
        _ if size < 0.0995 => format!("{value:.4}"),
        _ if size < 0.9995 => format!("{value:.3}"),
        _ if size < 9.995 => format!("{value:.2}"),
        _ if size < 99.95 => format!("{value:.1}"),
        _ => format!("{value:.0}"),
    }
}

pub(crate) fn cut(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.to_owned();
    }
    text.chars().take(width - 1).chain(['…']).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Row;
    use crate::report::summary::summarise;

    fn row(method: &str, seed: u64, time: f64, mse: f64) -> Row {
        Row {
            scene: "a_scene_with_a_name_that_is_longer_than_any_line_should_ever_be_in_a_table".into(),
            method: method.into(),
            hardware: format!("machine {seed}"),
            spp: 123_456_789,
            render_seconds: time,
            mse: Some(mse),
            relmse: Some(-1.0),
            ..Row::default()
        }
    }

    #[test]
    fn lines_fit_whatever_the_numbers_and_names() {
        let mut rows = Vec::new();
        for (index, method) in ["mitsuba:ptracer_with_a_very_long_name", "path", "path", "ü"].iter().enumerate() {
            for (time, mse) in [(1.234e-7, 1.0e-300), (1e-3, 1e200), (0.099_96, 3.0), (1.2345e9, 1.234e-99)] {
                rows.push(row(method, index as u64, time * (1.0 + index as f64), mse));
            }
        }
        let text = tables(&summarise(&rows));
        assert!(text.lines().all(|line| line.chars().count() <= TABLE_WIDTH), "{text}");
        assert_eq!(text.lines().count(), 2 + 1 + 4, "{text}");
        assert!(text.contains("path machine 1") && text.contains("path machine 2"), "{text}");
    }

    #[test]
    fn numbers_are_aligned_and_missing_ones_are_dashes() {
        let mut rows = vec![row("path", 1, 1.0, 4.0), row("path", 1, 16.0, 0.25), row("none", 1, 1.0, 4.0)];
        rows[2].mse = None;
        rows.iter_mut().for_each(|row| row.scene = "box".into());
        let text = tables(&summarise(&rows));
        let expected = "\
box after 16.0 s
  time: until RMSE 0.500; gain: efficiency over path
method  spp/s  RMSE ± % relMSE time [s] gain slope
path   7.72e6 0.500   -      -     16.0 1.00 -0.50
none   1.23e8     -   -      -        -    -     -
";
        assert_eq!(text, expected);
    }

    #[test]
    fn numbers_keep_three_digits() {
        let shown = [0.0, 1.0, 0.099_96, 0.01234, 99.96, 12_345.6, 1e5, 1.234e-300, -0.5, f64::NAN].map(number);
        assert_eq!(shown, ["0", "1.00", "0.100", "0.0123", "100", "12346", "1.00e5", "1.23e-300", "-0.500", "-"]);
    }
}
