//! `stability`: where numbers hold, and where they stop holding.

mod exact;
mod mitsuba;
mod output;
mod table;

use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::Mutex;

use anyhow::anyhow;
use clap::Args;

use crate::estimator::Registry;
use crate::experiment::Mitsuba;
use crate::testing::stability::{Case, Cell, Effort, Progress, Run, Verdict, all};

use super::progress::CaseProgress;
use super::{Outcome, UsageError, complain, interrupt, python};

const AFTER_HELP: &str = "\
A case is a small scene whose parameter goes from tame to extreme, with a known truth for each value: a closed form, a
quadrature, or a scaling law. A cell is one value by one method; it
  holds    the truth is within the noise, a bias above the one in the column `detectable` of the table would have been found (with
           probability 0.9; one report in 1000 on faultless methods has a failure), all values are finite and not negative,
           weights add up to one within 1e-9, and terms are w f / p of their paths within 1e-6
  noise    the noise is too large to say so (10 %), or light was hardly ever found
  blind    the method says that it misses this light
  slow     it would take too long; the law is told
  beyond   it does not hold, where nothing in double precision can; the reason is told
  fails    it does not hold
Work is counted in rays: the same seed gives the same numbers, times aside, on any machine and any number of threads.
Cases are named by how GROUP/CASE begins or by a part of CASE.
DIR gets stability.csv (every cell with estimate, truth, z, detectable bias, variance and its growth, impossible values,
fireflies, weights, time per sample), stability.md, a picture of the table where Python is set up, and in mitsuba/ the exported
scenes. Some cases of algebra/ are path logs, left in logs/, which Python evaluates a second time with 60 digits
(`python -m pathspace.stability.exact`); they hold where rounding explains every difference.

Examples:
  pathspace stability
  pathspace stability light/ --integrators path,bdpt:heuristic=power
  pathspace stability --full -o results/stability-full

Exit code 0: nothing of ours fails or is missing; 1: something is.";

/// Where numbers hold, and where they stop holding: stiff and extreme cases with known answers
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct StabilityArgs {
    /// Cases [default: all]
    #[arg(value_name = "CASE")]
    cases: Vec<String>,

    /// Integrators with settings, separated by commas [default: all but those made of bare samplers]
    #[arg(long, value_name = "NAME[:setting=value…]", value_delimiter = ',')]
    integrators: Vec<String>,

    /// All values of all parameters, four times as many samples, and up to 200 times where needed
    #[arg(long)]
    full: bool,

    /// Mitsuba's path tracer besides, in scalar_rgb and llvm_ad_rgb, on what can be exported
    #[arg(long)]
    mitsuba: bool,

    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = Effort::QUICK.seed)]
    seed: u64,

    /// Threads [default: all]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    threads: Option<u32>,

    /// Folder to write into, made where it is missing
    #[arg(short, long, value_name = "DIR", default_value = "results/stability")]
    output: PathBuf,

    /// All cases with their truths and limits, and nothing else
    #[arg(long)]
    list: bool,
}

pub(super) fn run(registry: &Registry, args: &StabilityArgs) -> anyhow::Result<Outcome> {
    let cases = chosen(&args.cases)?;
    if args.list {
        io::stdout().lock().write_all(table::list(&cases).as_bytes())?;
        return Ok(Outcome::Done);
    }
    interrupt::listen()?;
    let methods = match args.integrators.as_slice() {
        [] => registry.entries().iter().map(|entry| entry.name.to_owned()).collect(),
        named => named.to_vec(),
    };
    let effort = if args.full { Effort::FULL } else { Effort::QUICK };
    let effort = Effort { seed: args.seed, ..effort };
    let available = || std::thread::available_parallelism().map_or(1, usize::from);
    let threads = args.threads.map_or_else(available, |threads| threads as usize);
    let run = Run { registry, methods: &methods, cases: &cases, effort, threads };
    output::check(&args.output)?;
    let found = Mitsuba::find(interrupt::requested);
    if let (true, Err(why)) = (args.mitsuba, &found) {
        return Err(anyhow!("{why}"));
    }
    let bar = Mutex::new(CaseProgress::new());
    let told = |progress: Progress<'_>| {
        if let Ok(bar) = bar.lock() {
            show(&bar, &progress);
        }
    };
    let mut cells = run.cells(&interrupt::requested, &told)?;
    if let (true, Ok(mitsuba)) = (args.mitsuba && !interrupt::requested(), &found) {
        let say = |text: String| {
            if let Ok(bar) = bar.lock() {
                bar.say(text);
            }
        };
        let tests = run.tests() / methods.len() * (methods.len() + 2);
        let theirs = mitsuba::cells(mitsuba, &cases, effort, tests, &args.output, &say)?;
        cells.extend(theirs);
    }
    if let Ok(bar) = bar.lock() {
        bar.finish();
    }
    if !interrupt::requested() {
        cells.extend(exact::cells(registry, &cases, effort, &args.output)?);
    }
    if cells.is_empty() {
        return Ok(Outcome::Interrupted);
    }
    output::write(&args.output, &cells)?;
    let mut out = io::stdout().lock();
    out.write_all(table::table(&cells).as_bytes())?;
    writeln!(out, "table: {}", args.output.join("stability.csv").display())?;
    match found
        .map_err(|why| anyhow!("{why}"))
        .and_then(|found| python::make(&found, "stability.figure", &args.output, "picture"))
    {
        Ok(()) => writeln!(out, "picture: {}", args.output.join("stability.png").display())?,
        Err(why) => complain("note", &format!("no picture: {why}")),
    }
    out.flush()?;
    Ok(ending(&cells))
}

fn chosen(names: &[String]) -> anyhow::Result<Vec<Case>> {
    let all = all();
    let is_meant = |case: &Case, name: &str| case.full_name().starts_with(name) || case.name.contains(name);
    if let Some(name) = names.iter().find(|name| !all.iter().any(|case| is_meant(case, name))) {
        let known = all.iter().map(Case::full_name).collect::<Vec<_>>();
        let suggestion = crate::names::did_you_mean(name, known.iter().map(String::as_str));
        let what = format!("no case is called '{name}'{suggestion}; `pathspace stability --list` shows all");
        return Err(UsageError(what).into());
    }
    Ok(all.into_iter().filter(|case| names.is_empty() || names.iter().any(|name| is_meant(case, name))).collect())
}

fn ending(cells: &[Cell]) -> Outcome {
    let ours = || cells.iter().filter(|cell| !cell.method.starts_with("mitsuba:"));
    for cell in ours().filter(|cell| cell.verdict == Verdict::Fails) {
        let Cell { group, case, parameter, value, method, details, .. } = cell;
        complain("FAILS", &format!("{group}/{case} {method}: {parameter} = {}: {details}", table::value(*value)));
    }
    let missing: Vec<&Cell> = ours().filter(|cell| cell.verdict == Verdict::Missing).collect();
    if let Some(first) = missing.first() {
        complain(
            "missing",
            &format!("{} cells, {}/{} first: {}", missing.len(), first.group, first.case, first.details),
        );
    }
    if interrupt::requested() {
        Outcome::Interrupted
    } else if ours().any(Cell::is_bad) {
        Outcome::Failed
    } else {
        Outcome::Done
    }
}

fn show(bar: &CaseProgress, progress: &Progress<'_>) {
    let Some(first) = progress.cells.first() else { return };
    let bad = progress.cells.iter().filter(|cell| cell.is_bad()).count();
    let bad = if bad > 0 { format!(", {bad} FAIL") } else { String::new() };
    bar.show(progress.done, progress.of, &format!("{}/{}{bad}", first.group, first.case));
}
