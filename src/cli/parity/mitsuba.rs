//! Mitsuba's side: one process of `pathspace.parity.run` for all cases.

use std::path::Path;
use std::process::Command;
use std::sync::mpsc::Sender;
use std::time::Duration;

use anyhow::bail;
use serde::Deserialize;

use crate::cli::{complain, interrupt};
use crate::experiment::Mitsuba;
use crate::experiment::process::{Ended, Line, run_limited};

/// All cases with --full, on a slow machine.
const LIMIT: Duration = Duration::from_secs(2 * 3600);

/// What is asked for.
pub(super) struct Job<'a> {
    pub features: &'a [String],
    pub output: &'a Path,
    pub full: bool,
    pub passes: u32,
    pub seed: u64,
}

/// What has happened.
#[derive(Debug)]
pub(super) enum Event {
    /// A case is rendered.
    Done { case: String },
    /// Mitsuba refuses it.
    Failed { case: String, why: String },
    /// Nothing more comes.
    Ended,
}

/// A line of the process.
#[derive(Deserialize)]
struct Told {
    case: String,
    failed: Option<String>,
}

/// Runs the process to its end; each finished case is told as it comes.
pub(super) fn serve(mitsuba: &Mitsuba, job: &Job<'_>, events: &Sender<Event>) -> anyhow::Result<()> {
    let mut command = mitsuba.command("parity.run");
    command.arg("--out").arg(job.output).args(["--passes", &job.passes.to_string()]);
    command.args(["--seed", &job.seed.to_string()]).args(job.full.then_some("--full")).args(job.features);
    let mut last = String::new();
    let ended = run_limited(&mut command, LIMIT, interrupt::requested, |line| {
        let Line::Error(text) = line else { return };
        match serde_json::from_str::<Told>(&text) {
            Ok(Told { case, failed: None }) => drop(events.send(Event::Done { case })),
            Ok(Told { case, failed: Some(why) }) => drop(events.send(Event::Failed { case, why })),
            Err(_) if text.is_empty() => {}
            Err(_) => last = text,
        }
    });
    let _ = events.send(Event::Ended);
    match ended? {
        Ended::Stopped => Ok(()),
        Ended::TimedOut => bail!("Mitsuba takes longer than {} s; name fewer features", LIMIT.as_secs()),
        Ended::Itself(status) => match status.code() {
            Some(0 | 130) => {
                if !last.is_empty() {
                    complain("note", &format!("Mitsuba: {last}"));
                }
                Ok(())
            }
            Some(2) => Err(super::usage(format!("{last}; `pathspace parity --list` shows all"))),
            code => bail!("Mitsuba's side ended with {code:?}: {last}"),
        },
    }
}

/// The names of features.
pub(super) fn names(mitsuba: &Mitsuba, features: &[String]) -> anyhow::Result<Vec<String>> {
    let mut command: Command = mitsuba.command("parity.run");
    command.args(["--out", ".", "--list"]).args(features);
    let (mut names, mut last) = (Vec::new(), String::new());
    let ended = run_limited(&mut command, LIMIT, interrupt::requested, |line| match line {
        Line::Out(text) => names.push(text),
        Line::Error(text) => last = text,
    })?;
    match ended {
        Ended::Itself(status) if status.success() => Ok(names),
        _ => Err(super::usage(format!("{last}; `pathspace parity --list` shows all"))),
    }
}
