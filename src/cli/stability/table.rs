//! A line for each case in a terminal of 80 columns, and what does not hold below.

use std::collections::BTreeSet;
use std::fmt::Write;

use crate::report::cut;
use crate::testing::stability::{Case, Cell, Outcome, Verdict, outcome};

const NAME_WIDTH: usize = 28;
const COLUMN_WIDTH: usize = 12;
/// Columns of methods beside each other.
const COLUMNS: usize = 4;

/// Of the parameter: as short as it can be told.
pub(super) fn value(value: f64) -> String {
    let plain = format!("{value}");
    let scientific = format!("{value:e}");
    if plain.len() <= scientific.len().max(4) { plain } else { scientific }
}

/// One table for each few methods.
pub(super) fn table(cells: &[Cell]) -> String {
    let methods = methods(cells);
    let mut text = String::new();
    for methods in methods.chunks(COLUMNS) {
        if !text.is_empty() {
            text.push('\n');
        }
        text += &heading(methods);
        for of_case in of_cases(cells) {
            let columns: Vec<Vec<&Cell>> = methods.iter().map(|method| by(&of_case, method)).collect();
            if columns.iter().all(Vec::is_empty) {
                continue;
            }
            let name = format!("{}/{}", of_case[0].group, of_case[0].case);
            let _ = write!(text, "{:NAME_WIDTH$}", cut(&name, NAME_WIDTH));
            for column in columns {
                let _ = write!(text, " {:COLUMN_WIDTH$}", short(&column));
            }
            text.truncate(text.trim_end().len());
            text.push('\n');
        }
    }
    text + &count(cells)
}

fn heading(methods: &[&str]) -> String {
    let mut text = format!("{:NAME_WIDTH$}", "case");
    for method in methods {
        // Of Mitsuba's the variant tells them apart.
        let name = method.strip_prefix("mitsuba:path:").unwrap_or(method);
        let _ = write!(text, " {:COLUMN_WIDTH$}", cut(name, COLUMN_WIDTH));
    }
    text.trim_end().to_owned() + "\n"
}

/// What a case says of a method: `holds`, or the last value that holds and what stops it.
fn short(cells: &[&Cell]) -> String {
    match outcome(cells) {
        _ if cells.is_empty() => String::new(),
        Outcome { first: None, .. } => "holds".into(),
        Outcome { last: None, first: Some(cell) } => shown(cell.verdict).into(),
        Outcome { last: Some(last), first: Some(cell) } => format!("{} {}", value(last), shown(cell.verdict)),
    }
}

fn shown(verdict: Verdict) -> &'static str {
    if verdict == Verdict::Fails { "FAILS" } else { verdict.name() }
}

fn count(cells: &[Cell]) -> String {
    let of = |verdict: Verdict| cells.iter().filter(|cell| cell.verdict == verdict).count();
    use Verdict::{Beyond, Blind, Fails, Holds, Missing, Noise, Slow};
    let all = [Holds, Noise, Blind, Slow, Beyond, Missing, Fails];
    let counts = all.map(|verdict| (verdict, of(verdict)));
    let counts: Vec<String> =
        counts.iter().filter(|(_, n)| *n > 0).map(|(verdict, n)| format!("{n} {}", shown(*verdict))).collect();
    format!(
        "\ncells: {}\nnumbers: the last value of the parameter that holds; words: what comes after it\n",
        counts.join(", ")
    )
}

/// The same for a document, each case with its truth, its values and what does not hold.
pub(super) fn markdown(cells: &[Cell]) -> String {
    let methods = methods(cells);
    let mut text = format!("| case | values | {} |\n|---|---|{}\n", methods.join(" | "), "---|".repeat(methods.len()));
    for of_case in of_cases(cells) {
        let Cell { group, case, parameter, .. } = of_case[0];
        let first = by(&of_case, &of_case[0].method);
        let range = format!("{parameter}: {} … {}", value(first[0].value), value(first[first.len() - 1].value));
        let columns: Vec<String> = methods.iter().map(|method| short(&by(&of_case, method))).collect();
        let _ = writeln!(text, "| {group}/{case} | {range} | {} |", columns.join(" | "));
    }
    text.push('\n');
    for cell in cells.iter().filter(|cell| !matches!(cell.verdict, Verdict::Holds | Verdict::Blind)) {
        let Cell { group, case, parameter, value: at, method, verdict, details, .. } = cell;
        let _ = writeln!(text, "- {group}/{case}, {method}, {parameter} = {}: {verdict}: {details}", value(*at));
    }
    text
}

/// All cases with what is true of them.
pub(super) fn list(cases: &[Case]) -> String {
    let mut text = String::new();
    for case in cases {
        let values = case.values.iter().map(|&v| value(v)).collect::<Vec<_>>().join(", ");
        let _ = writeln!(text, "{}: {} = {values}\n  {}", case.full_name(), case.parameter, case.about);
        if let Some(limit) = case.limit {
            let _ = writeln!(text, "  ends at {}: {}", value(limit.last), limit.why);
        }
    }
    text
}

fn methods(cells: &[Cell]) -> Vec<&str> {
    let mut seen = BTreeSet::new();
    cells.iter().map(|cell| cell.method.as_str()).filter(|method| seen.insert(*method)).collect()
}

fn of_cases(cells: &[Cell]) -> Vec<Vec<&Cell>> {
    let mut names: Vec<(&str, &str)> = cells.iter().map(|cell| (cell.group.as_str(), cell.case.as_str())).collect();
    let mut seen = BTreeSet::new();
    names.retain(|name| seen.insert(*name));
    let of = |(group, case): (&str, &str)| cells.iter().filter(|c| c.group == group && c.case == case).collect();
    names.into_iter().map(of).collect()
}

fn by<'a>(cells: &[&'a Cell], method: &str) -> Vec<&'a Cell> {
    cells.iter().copied().filter(|cell| cell.method == method).collect()
}
