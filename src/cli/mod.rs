//! The command line. A program of one's own is a registry and a call of [`main`].

mod args;
mod compare;
mod export;
mod interrupt;
mod layers;
mod list;
mod measure;
mod method;
mod parity;
mod paths;
mod progress;
mod pyramid;
mod python;
mod reference;
mod render;
mod replay;
mod scene;
mod score;
mod session;
mod stability;
mod verify;
mod what_if;

use std::io::{self, Write};
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use thiserror::Error;

use crate::estimator::{Registry, RegistryError};

const AFTER_HELP: &str = "\
Exit codes:
  0    done (values that cannot be right are counted and told on stderr, and do not change the code)
  1    a scene, film or file cannot be used: one line `error: FILE: place: what; remedy` on stderr
  2    the command line makes no sense: unknown option, integrator or setting
  3    compare, reference, parity: a method estimates another image, told after everything is written
  130  interrupted by Ctrl-C or SIGTERM after what was finished has been written";

/// Path-space light transport: renders scenes of glTF and Mitsuba 3 and says how certain each image is.
#[derive(Debug, Parser)]
#[command(name = "pathspace", version, after_help = AFTER_HELP, max_term_width = 110)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Render(Box<render::RenderArgs>),
    Compare(Box<compare::CompareArgs>),
    Reference(reference::ReferenceArgs),
    Score(score::ScoreArgs),
    Pyramid(pyramid::PyramidArgs),
    Paths(Box<paths::PathsArgs>),
    Parity(parity::ParityArgs),
    Stability(stability::StabilityArgs),
    Export(export::ExportArgs),
    List(list::ListArgs),
    Verify(verify::VerifyArgs),
    Measure(measure::MeasureArgs),
    #[command(name = "whatif")]
    WhatIf(what_if::WhatIfArgs),
}

/// A command line that makes no sense.
#[derive(Debug, Error)]
#[error("{0}")]
struct UsageError(String);

/// The user has ended it before there was anything to show.
#[derive(Debug, Error)]
#[error("{0}")]
struct Stopped(String);

/// How a command that did not fail has ended.
enum Outcome {
    Done,
    Interrupted,
    /// Methods estimate different images.
    Differ,
    /// Some of it went wrong, and was told.
    Failed,
}

/// Parses the command line of this process, does what it says with the integrators of `registry`, and returns the exit
/// code. Errors are one line on stderr.
#[must_use]
pub fn main(registry: &Registry) -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // Where the message cannot be shown, the code still tells.
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { 2 } else { 0 });
        }
    };
    let result = match &cli.command {
        Command::Render(args) => render::run(registry, args),
        Command::Compare(args) => compare::run(registry, args),
        Command::Reference(args) => reference::run(registry, args),
        Command::Score(args) => score::run(args),
        Command::Pyramid(args) => pyramid::run(args),
        Command::Paths(args) => paths::run(registry, args),
        Command::Parity(args) => parity::run(registry, args),
        Command::Stability(args) => stability::run(registry, args),
        Command::Export(args) => export::run(args),
        Command::List(_) => list::run(registry),
        Command::Verify(args) => verify::run(registry, args),
        Command::Measure(args) => measure::run(registry, args),
        Command::WhatIf(args) => what_if::run(registry, args),
    };
    match result {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::Interrupted) => ExitCode::from(130),
        Ok(Outcome::Differ) => ExitCode::from(3),
        Ok(Outcome::Failed) => ExitCode::from(1),
        // Whoever reads our output has seen enough.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) if error.is::<Stopped>() => {
            complain("note", &error.to_string());
            ExitCode::from(130)
        }
        Err(error) => {
            complain("error", &error.to_string());
            let usage = error.is::<UsageError>() || error.is::<RegistryError>();
            ExitCode::from(if usage { 2 } else { 1 })
        }
    }
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.downcast_ref::<io::Error>().is_some_and(|e| e.kind() == io::ErrorKind::BrokenPipe)
}

/// One line on stderr, whatever the text holds. A closed stderr is no reason to stop.
fn complain(kind: &str, text: &str) {
    let text: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    let _ = writeln!(io::stderr(), "{kind}: {text}");
}
