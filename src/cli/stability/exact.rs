//! Cells of path logs, which `python -m pathspace.stability.exact` evaluates a second time with many digits.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::Deserialize;

use crate::cli::interrupt;
use crate::estimator::Registry;
use crate::experiment::Mitsuba;
use crate::experiment::process::{Ended, Line, run_limited};
use crate::film::output::write_atomically;
use crate::testing::stability::{Case, Cell, Effort, Journal, Subject, Verdict, beyond};

/// All logs, on a slow machine.
const LIMIT: Duration = Duration::from_secs(1800);

/// What a method is called where there is none.
const CORE: &str = "core";

/// What Python says of a log.
#[derive(Debug, Deserialize)]
struct Told {
    log: PathBuf,
    paths: u64,
    edges: u32,
    log10_p: Option<[f64; 2]>,
    quantities: BTreeMap<String, Quantity>,
    skipped: BTreeMap<String, u64>,
    holds: bool,
}

/// The worst number of a kind.
#[derive(Debug, Deserialize)]
struct Quantity {
    /// `None`: infinite.
    error: Option<f64>,
    bound: f64,
    loosest: f64,
    ratio: Option<f64>,
    at: String,
    beyond: u64,
}

/// The cells of all cases that are logs, which are left in the folder `logs`.
pub(super) fn cells(registry: &Registry, cases: &[Case], effort: Effort, folder: &Path) -> anyhow::Result<Vec<Cell>> {
    let mut cells = Vec::new();
    let mut logs = BTreeMap::new();
    let logs_folder = folder.join("logs");
    for case in cases {
        let Subject::Journal(make) = case.subject else { continue };
        fs::create_dir_all(&logs_folder)?;
        for value in effort.values(case) {
            if interrupt::requested() {
                return Ok(Vec::new());
            }
            let log = logs_folder.join(format!("{}.jsonl", case.file_name(value)));
            let mut cell = Cell::of(case, value, CORE);
            match write(registry, &make(value), effort.seed, &log)? {
                Ok(()) => drop(logs.insert(log, cells.len())),
                Err(why) => cell.details = why,
            }
            cells.push(cell);
        }
    }
    let mut why = "Python has said nothing of it".to_owned();
    let ended = if logs.is_empty() { Ok(()) } else { evaluate(&logs, |told, index| judge(&mut cells[index], told)) };
    if let Err(error) = ended {
        why = error;
    }
    for &index in logs.values() {
        if cells[index].verdict == Verdict::Missing {
            cells[index].details.clone_from(&why);
        }
    }
    let of = |cell: &Cell| cases.iter().find(|case| case.group == cell.group && case.name == cell.case);
    Ok(cells.into_iter().map(|cell| of(&cell).map_or(cell.clone(), |case| beyond(case, cell))).collect())
}

/// Writes a log and its scene, or says why there is none.
fn write(registry: &Registry, journal: &Journal, seed: u64, log: &Path) -> anyhow::Result<Result<(), String>> {
    let (scene, records) = match journal.records(registry, seed) {
        Ok(records) => records,
        Err(why) => return Ok(Err(why)),
    };
    write_atomically(&log.with_extension("json"), |out| Ok(serde_json::to_writer(out, &scene)?))?;
    write_atomically(log, |out| {
        records.iter().try_for_each(|record| {
            serde_json::to_writer(&mut *out, record)?;
            writeln!(out)
        })
    })?;
    Ok(Ok(()))
}

/// Lets Python evaluate them, one after the other.
fn evaluate(logs: &BTreeMap<PathBuf, usize>, mut take: impl FnMut(&Told, usize)) -> Result<(), String> {
    let python = Mitsuba::unasked();
    let mut command = python.command("stability.exact");
    command.args(logs.keys());
    let mut last = String::new();
    let ended = run_limited(&mut command, LIMIT, interrupt::requested, |line| match line {
        Line::Out(text) => {
            let told = serde_json::from_str::<Told>(&text).ok();
            if let Some((told, &index)) = told.as_ref().and_then(|told| Some((told, logs.get(&told.log)?))) {
                take(told, index);
            }
        }
        Line::Error(text) => last = text,
    });
    let advice = "run scripts/setup, or name a Python with mpmath in $PATHSPACE_PYTHON";
    match ended {
        Ok(Ended::Itself(status)) if matches!(status.code(), Some(0 | 1)) && last.is_empty() => Ok(()),
        Ok(Ended::Itself(_)) => Err(format!("not evaluated: {last}; {advice}")),
        Ok(Ended::TimedOut) => Err(format!("not evaluated within {} s", LIMIT.as_secs())),
        Ok(Ended::Stopped) => Err("interrupted".into()),
        Err(error) => Err(format!("not evaluated: no Python ({error}); {advice}")),
    }
}

fn judge(cell: &mut Cell, told: &Told) {
    let error = |name: &str| told.quantities.get(name).and_then(|quantity| quantity.error);
    let blind: u64 = told.quantities.values().map(|quantity| quantity.beyond).sum();
    let wrong: Vec<String> = told
        .quantities
        .iter()
        .filter(|(_, quantity)| quantity.ratio.is_none_or(|ratio| ratio > 1.0))
        .map(told_of)
        .collect();
    let skipped: Vec<String> = told.skipped.iter().map(|(why, n)| format!("{n} paths: {why}")).collect();
    cell.verdict = match () {
        () if !told.holds => Verdict::Fails,
        () if blind > 0 || !skipped.is_empty() => Verdict::Noise,
        () => Verdict::Holds,
    };
    cell.samples = Some(told.paths);
    cell.difference = error("p");
    cell.detectable = told.quantities.get("p").map(|quantity| quantity.loosest);
    cell.weights = error("Σ w");
    cell.definition = error("w f/(n p)");
    let range = told.log10_p.map_or_else(String::new, |[low, high]| format!(", p from 1e{low:.0} to 1e{high:.0}"));
    let worst = ["f", "ln f", "p", "w of all", "f/p", "w f/(n p)"].iter().filter_map(|name| Some((name, error(name)?)));
    let worst: Vec<String> = worst.map(|(name, error)| format!("{name} {error:.0e}")).collect();
    let beyond = if blind > 0 { vec![format!("{blind} numbers have no digits")] } else { Vec::new() };
    let size = format!("{} paths of up to {} edges{range}; errors: {}", told.paths, told.edges, worst.join(", "));
    cell.details = [wrong, skipped, beyond, vec![size]].concat().join("; ");
}

fn told_of((name, quantity): (&String, &Quantity)) -> String {
    let Quantity { error, bound, at, .. } = quantity;
    let error = error.map_or("∞".to_owned(), |error| format!("{error:.1e}"));
    format!("{name} off by {error} in the worst case ({at}), where rounding explains {bound:.1e}")
}
