//! `parity`: is each feature of a scene what it is in Mitsuba.

mod albedo;
mod case;
mod images;
mod mitsuba;
mod points;
mod row;
mod table;

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc;

use anyhow::{anyhow, bail};
use clap::Args;

use crate::estimator::Registry;
use crate::experiment::Mitsuba;
use crate::film::output::write_atomically;

use super::args::ParameterArgs;
use super::progress::CaseProgress;
use super::scene::{self, LoadOptions};
use super::{Outcome, UsageError, complain, interrupt, python};

use case::Case;
use mitsuba::Event;
use row::{ParityRow, Verdict};

const AFTER_HELP: &str = "\
Each feature is a small scene in Mitsuba's XML, which both programs read and render. Compared are
  image   independent passes of both, by Welch's test for the whole image and for each block of 16 × 16 pixels and channel, with
          a correction for all tests of all features: one report in 1000 on faultless renderers has a failure
  values  what Mitsuba's Python interface says of BSDFs, emitters and sensors for given directions, in single precision: ours must
          be within what rounding explains, which is derived for each value from how it changes with its directions; and albedos
          by both programs' samples, within their standard errors
Features are named by how GROUP/FEATURE begins (bsdf, texture, emitter, sensor, shape, filter), or by a part of FEATURE. Those
that one of the two programs cannot read are missing.
DIR gets parity.csv (all comparisons), the same as parity.md, parity.html (a page with the images), and in GROUP/FEATURE the
scenes and images.

Examples:
  pathspace parity
  pathspace parity bsdf/roughplastic emitter -o results/some
  pathspace parity --full
  pathspace parity bsdf/diffuse -D reflectance=0.7,0.41,0.2      ours alone: a planted difference, to see that it is told

Exit code 0: all agree; 1: some could not be compared, or nothing can be said of them; 3: one differs.";

/// Passes of Mitsuba's image; with --full.
const PASSES: [u32; 2] = [16, 64];

/// Compare each feature of scenes with Mitsuba: images and values
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct ParityArgs {
    /// Features [default: all]
    #[arg(value_name = "FEATURE")]
    features: Vec<String>,

    /// Four times as many samples, all pairs of integrators, and the scenes beside the repository
    #[arg(long)]
    full: bool,

    /// Folder to write into, made where it is missing
    #[arg(short, long, value_name = "DIR", default_value = "results/parity")]
    output: PathBuf,

    /// Seed of the random numbers of both
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,

    #[command(flatten)]
    defined: ParameterArgs,

    /// Names of features, one a line, and nothing else
    #[arg(long)]
    list: bool,
}

pub(super) fn run(registry: &Registry, args: &ParityArgs) -> anyhow::Result<Outcome> {
    interrupt::listen()?;
    let mitsuba = Mitsuba::find(interrupt::requested).map_err(|why| anyhow!("{why}"))?;
    if args.list {
        return list(&mitsuba, args);
    }
    let (sender, events) = mpsc::channel();
    let job = mitsuba::Job {
        features: &args.features,
        output: &args.output,
        full: args.full,
        passes: PASSES[usize::from(args.full)],
        seed: args.seed,
    };
    let mut rows = Vec::new();
    let ended = std::thread::scope(|scope| {
        let served = scope.spawn(|| mitsuba::serve(&mitsuba, &job, &sender));
        // Events end with the process, whatever ends that.
        let mut made = Ok(());
        let (progress, mut done) = (CaseProgress::new(), 0);
        while let Ok(event) = events.recv() {
            if matches!(event, Event::Ended) {
                break;
            }
            if made.is_ok() {
                done += 1;
                made = take(registry, args, &event, &mut rows, (&progress, done));
            }
        }
        progress.finish();
        let ended = served.join().unwrap_or_else(|_| bail!("the thread that waits for Python has died"));
        made.and(ended)
    });
    if rows.is_empty() {
        ended?;
        return Ok(Outcome::Interrupted);
    }
    row::write(&args.output.join("parity.csv"), &rows)?;
    write_atomically(&args.output.join("parity.md"), |file| file.write_all(table::markdown(&rows).as_bytes()))?;
    let page = python::make(&mitsuba, "parity.page", &args.output, "page");
    let mut out = io::stdout().lock();
    write!(out, "{}", table::table(&rows))?;
    writeln!(out, "page: {}", args.output.join("parity.html").display())?;
    out.flush()?;
    drop(out);
    ended.and(page)?;
    Ok(outcome(&rows))
}

fn list(mitsuba: &Mitsuba, args: &ParityArgs) -> anyhow::Result<Outcome> {
    let names = mitsuba::names(mitsuba, &args.features)?;
    let mut out = io::stdout().lock();
    for name in names {
        writeln!(out, "{name}")?;
    }
    Ok(Outcome::Done)
}

/// Compares what Mitsuba has finished.
fn take(
    registry: &Registry,
    args: &ParityArgs,
    event: &Event,
    rows: &mut Vec<ParityRow>,
    (progress, done): (&CaseProgress, usize),
) -> anyhow::Result<()> {
    let cases = case::read(&args.output.join("cases.json"))?;
    let find = |name: &str| cases.iter().find(|case| case.name == name);
    let before = rows.len();
    match event {
        Event::Done { case } => {
            let Some(case) = find(case) else { return Ok(()) };
            if interrupt::requested() {
                return Ok(());
            }
            match compare(registry, args, case, cases.len()) {
                // What is not finished says nothing.
                Err(_) if interrupt::requested() => return Ok(()),
                made => rows.extend(made?),
            }
        }
        Event::Failed { case, why } => rows.push(ParityRow::missing(case, &format!("Mitsuba: {why}"))),
        Event::Ended => {}
    }
    show(progress, &rows[before..], done, cases.len());
    Ok(())
}

/// All comparisons of a case.
fn compare(registry: &Registry, args: &ParityArgs, case: &Case, cases: usize) -> anyhow::Result<Vec<ParityRow>> {
    let parameters = case.parameters.iter().chain(&args.defined.parameters).cloned().collect();
    let options = LoadOptions { parameters, ..LoadOptions::default() };
    let scene = match scene::load(&case.scene, &options) {
        Ok(loaded) => loaded.scene,
        Err(error) => return Ok(vec![ParityRow::missing(&case.name, &error.to_string())]),
    };
    let folder = args.output.join(&case.name);
    let mut rows = images::compare(registry, &scene, case, &folder, args, cases)?;
    rows.extend(points::compare(&scene, case, &folder, args, cases)?);
    Ok(rows)
}

fn outcome(rows: &[ParityRow]) -> Outcome {
    for row in rows.iter().filter(|row| row.verdict == Verdict::Differ) {
        complain("DIFFER", &format!("{} {}: {}", row.feature, row.comparison, row.details));
    }
    if interrupt::requested() {
        Outcome::Interrupted
    } else if rows.iter().any(|row| row.verdict == Verdict::Differ) {
        Outcome::Differ
    } else if rows.iter().any(|row| row.verdict != Verdict::Agree) {
        Outcome::Failed
    } else {
        Outcome::Done
    }
}

fn show(progress: &CaseProgress, rows: &[ParityRow], done: usize, of: usize) {
    let Some(first) = rows.first() else { return };
    let verdict = rows.iter().map(|row| row.verdict).max().unwrap_or(Verdict::Agree);
    progress.show(done, of, &format!("{} {verdict}", first.feature));
}

/// An error of the user's words has its own exit code.
fn usage(what: String) -> anyhow::Error {
    UsageError(what).into()
}

fn read(path: &Path) -> anyhow::Result<Vec<u8>> {
    std::fs::read(path).map_err(|error| anyhow!("{}: cannot be read: {error}", path.display()))
}
