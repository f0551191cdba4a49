//! Mitsuba 3 as a method like any other: `python -m pathspace.mitsuba_run` in a process of its own.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use serde::Deserialize;

use crate::film::{BLOCK_SIDE, BlockGrid, BlockStatistics, Image};
use crate::report::npy::{Array, read_npy};
use crate::report::{ReportError, Row};
use crate::spectrum::Rgb;

use super::budget::Budget;
use super::error::ExperimentError;
use super::method::MitsubaMethod;
use super::process::{Ended, Line, run_limited};
use super::run::{Finished, Job, Observer, RunEnd, Standing};

/// Time to find out what Mitsuba can do, trying LLVM libraries included.
const PROBE_LIMIT: Duration = Duration::from_secs(300);

/// Beyond its rendering time, a run may take so long for loading, compilation, calibration and output \[s\].
const SLACK: f64 = 180.0;

/// Beyond its rendering time, a run may take this multiple of it: for passes that overshoot.
const OVERSHOOT: f64 = 3.0;

/// A run whose budget counts samples is killed after this time \[s\].
const SPP_LIMIT: f64 = 3600.0;

/// A budget in samples is split into so many passes, for the statistics over passes.
const PASSES_OF_BUDGET: u64 = 32;

/// A Python that has Mitsuba.
#[derive(Clone, Debug)]
pub struct Mitsuba {
    python: PathBuf,
    scripts: Option<PathBuf>,
    version: String,
    llvm: Option<String>,
}

#[derive(Deserialize)]
struct Probe {
    mitsuba: String,
    llvm: Option<String>,
}

#[derive(Deserialize)]
struct RunFile {
    renderer: String,
    variant: String,
    threads: u32,
    pass_spp: u64,
    passes: Vec<Pass>,
    load_seconds: f64,
    setup_seconds: f64,
    checkpoints: Vec<Checkpoint>,
}

#[derive(Deserialize)]
struct Pass {
    spp: u64,
}

#[derive(Deserialize)]
struct Checkpoint {
    index: u32,
    file: String,
    spp: u64,
    render_seconds: f64,
    cpu_seconds: f64,
    invalid: u64,
}

/// A line of progress.
#[derive(Deserialize)]
struct Progress {
    seconds: f64,
    spp: u64,
}

impl Mitsuba {
    /// `$PATHSPACE_PYTHON`, or else `.venv/bin/python` below the current folder, if it has what it takes.
    ///
    /// # Errors
    /// Why not, and what to do, in one line.
    pub fn find(stopped: impl Fn() -> bool) -> Result<Self, String> {
        let mut mitsuba = Self::unasked();
        let python = mitsuba.python.clone();
        let refuse = |what: &str| {
            format!(
                "{}: {what}; run scripts/setup, or name a Python with Mitsuba in $PATHSPACE_PYTHON",
                python.display()
            )
        };
        let (mut out, mut last) = (String::new(), String::new());
        let mut command = mitsuba.command("mitsuba_probe");
        let ended = run_limited(&mut command, PROBE_LIMIT, stopped, |line| match line {
            Line::Out(text) => out += &text,
            Line::Error(text) => last = text,
        });
        match ended {
            Ok(Ended::Itself(status)) if status.success() => {}
            Ok(Ended::Itself(_)) => return Err(refuse(&format!("cannot run Mitsuba ({last})"))),
            Ok(_) => return Err(refuse("takes too long to say what Mitsuba can do")),
            Err(error) => return Err(refuse(&format!("cannot be run ({error})"))),
        }
        let probe: Probe = serde_json::from_str(&out).map_err(|_| refuse("says nothing of Mitsuba"))?;
        (mitsuba.version, mitsuba.llvm) = (probe.mitsuba, probe.llvm);
        Ok(mitsuba)
    }

    /// The same Python, whether it has Mitsuba or not.
    pub(crate) fn unasked() -> Self {
        let named = std::env::var_os("PATHSPACE_PYTHON").map(PathBuf::from);
        let scripts =
            fs::canonicalize("scripts").ok().filter(|folder| folder.join("pathspace/mitsuba_run.py").is_file());
        let python = named.unwrap_or_else(|| PathBuf::from(".venv/bin/python"));
        Self { python, scripts, version: String::new(), llvm: None }
    }

    /// How to get the faster variant, where it is not there.
    #[must_use]
    pub fn advice(&self) -> Option<&'static str> {
        self.llvm.is_none().then_some(
            "Mitsuba runs as scalar_rgb; to get the faster llvm_ad_rgb, install LLVM 16 or newer (Debian: apt-get install \
             libllvm19)",
        )
    }

    /// Why it does not take part where none was found.
    pub(super) const MISSING: &str = "no Python with Mitsuba here: run scripts/setup, or name one in $PATHSPACE_PYTHON";

    pub(super) fn versions(&self) -> String {
        format!("mitsuba {}, LLVM {}", self.version, self.llvm.as_deref().unwrap_or("none"))
    }

    /// The variant that a method means.
    pub(super) fn variant(&self, method: &MitsubaMethod) -> &'static str {
        match (method.variant.as_str(), &self.llvm) {
            ("llvm_ad_rgb", _) | ("auto", Some(_)) => "llvm_ad_rgb",
            _ => "scalar_rgb",
        }
    }

    pub(super) fn supports(&self, method: &MitsubaMethod) -> Result<(), String> {
        match (self.variant(method), self.advice()) {
            ("llvm_ad_rgb", Some(advice)) => Err(advice.into()),
            _ => Ok(()),
        }
    }

    /// A run of `method` on an exported scene, whose files go to `out`.
    pub(super) fn run(&self, method: &MitsubaMethod, scene: &Path, out: &Path) -> Command {
        let mut command = self.command("mitsuba_run");
        command.arg("--scene").arg(scene).arg("--out").arg(out);
        command.args(["--integrator", method.integrator, "--variant", &method.variant]);
        command.args(["--max-length", &method.max_length, "--rr-depth", &method.rr_depth.to_string()]);
        command.args(["--block", &BLOCK_SIDE.to_string()]);
        command
    }

    /// Runs a module of the scripts.
    pub(crate) fn command(&self, module: &str) -> Command {
        let mut command = Command::new(&self.python);
        command.args(["-m", &format!("pathspace.{module}")]);
        if let Some(scripts) = &self.scripts {
            let before = std::env::var_os("PYTHONPATH").unwrap_or_default();
            let paths = std::iter::once(scripts.clone()).chain(std::env::split_paths(&before));
            if let Ok(joined) = std::env::join_paths(paths.filter(|path| !path.as_os_str().is_empty())) {
                command.env("PYTHONPATH", joined);
            }
        }
        command
    }
}

/// One run; its files lie in `folder` and are cleared away except for `run.json` and `blocks.npy`.
pub(super) fn render(
    mitsuba: &Mitsuba,
    method: &MitsubaMethod,
    job: &Job<'_>,
    scene: &Path,
    folder: &Path,
    pass_spp: Option<u64>,
    observer: &mut (dyn Observer + Send),
) -> Result<RunEnd, ExperimentError> {
    let mut command = mitsuba.run(method, scene, folder);
    let checkpoints = job.plan.checkpoints.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
    command.args(["--seed", &job.seed.to_string(), "--threads", &job.plan.machine.threads.to_string()]);
    let (limit, pass_of_budget) = match job.budget() {
        Budget::Spp(spp) => {
            command.args(["--spp", &spp.to_string()]);
            (SPP_LIMIT, Some((spp / PASSES_OF_BUDGET).max(1)))
        }
        timed => {
            command.args(["--seconds", &timed.end().to_string(), "--checkpoints", &checkpoints]);
            (SLACK + OVERSHOOT * timed.end(), None)
        }
    };
    let pass_spp = pass_spp.or(pass_of_budget);
    if let Some(pass_spp) = pass_spp {
        command.args(["--pass-spp", &pass_spp.to_string()]);
    }
    let mut last = String::new();
    let mut stopped = false;
    let ended = {
        let cell = std::cell::RefCell::new(observer);
        run_limited(
            &mut command,
            Duration::from_secs_f64(limit),
            || cell.borrow().stopped(),
            |line| match line {
                Line::Error(text) if text.starts_with('{') => {
                    if let Ok(Progress { seconds, spp }) = serde_json::from_str(&text) {
                        let spent = if job.budget().seconds().is_some() { seconds } else { spp as f64 };
                        let share = spent / job.budget().end();
                        cell.borrow_mut().progress(&Standing { share, seconds, spp, ..Standing::default() });
                    }
                }
                Line::Error(text) if !text.is_empty() => last = text,
                _ => {}
            },
        )
    };
    match ended {
        Err(error) => return Ok(RunEnd::Failed(format!("Python cannot be run: {error}"))),
        Ok(Ended::TimedOut) => {
            return Ok(RunEnd::Failed(format!("killed after {limit:.0} s, more than its budget allows")));
        }
        Ok(Ended::Stopped) => stopped = true,
        Ok(Ended::Itself(status)) => match status.code() {
            Some(0) => {}
            Some(3) => return Ok(RunEnd::Unsupported(last)),
            Some(130) => stopped = true,
            Some(code) => return Ok(RunEnd::Failed(format!("exit code {code}: {last}"))),
            None => return Ok(RunEnd::Failed(format!("ended by a signal: {last}"))),
        },
    }
    if stopped {
        return Ok(RunEnd::Stopped);
    }
    collect(job, folder).map(|run| RunEnd::Finished(Box::new(run)))
}

/// Turns the files of a run into rows, image and statistics.
fn collect(job: &Job<'_>, folder: &Path) -> Result<Finished, ExperimentError> {
    let path = folder.join("run.json");
    let text = fs::read(&path).map_err(|source| ReportError::Read { path: path.clone(), source })?;
    let damaged = |what: String| ExperimentError::Scene(format!("{}: {what}; run again", path.display()));
    let run: RunFile = serde_json::from_slice(&text).map_err(|error| damaged(error.to_string()))?;
    let mut image = None;
    let mut rows: Vec<Row> = Vec::new();
    for checkpoint in &run.checkpoints {
        let file = folder.join(&checkpoint.file);
        // Mitsuba does not know the reference, and has gone on to the end of its time.
        if let (Budget::Error(target), Some(row)) = (job.budget(), rows.last())
            && target.reached(row)
        {
            let _ = fs::remove_file(file);
            continue;
        }
        let found = image_of(&read_npy(&file)?).ok_or_else(|| damaged(format!("{} is no image", checkpoint.file)))?;
        let row = Row {
            scene: job.scene.name.clone(),
            method: job.method.label.clone(),
            renderer: format!("{} {}", run.renderer, run.variant),
            seed: job.seed,
            hardware: job.plan.machine.hardware.clone(),
            host: job.plan.machine.host.clone(),
            threads: run.threads,
            checkpoint: checkpoint.index,
            spp: checkpoint.spp,
            render_seconds: checkpoint.render_seconds,
            cpu_seconds: Some(checkpoint.cpu_seconds),
            setup_seconds: Some(run.setup_seconds),
            invalid: checkpoint.invalid,
            load_seconds: Some(run.load_seconds),
            ..Row::default()
        };
        rows.push(job.measured(row, &found)?);
        image = Some(found);
        let _ = fs::remove_file(file);
    }
    let image = image.ok_or_else(|| damaged("there is no checkpoint".into()))?;

    // A replicate is a pass of the usual size; a smaller last one is none.
    let blocks = read_npy(&folder.join("blocks.npy"))?;
    let alike = run.passes.iter().take_while(|pass| pass.spp == run.passes[0].spp).count();
    let Array { mut shape, mut data } = blocks;
    let per_pass: usize = shape.iter().skip(1).product();
    if let Some(passes) = shape.first_mut() {
        *passes = alike.min(*passes);
        data.truncate(*passes * per_pass);
    }
    let grid = BlockGrid::new(image.width, image.height, None)?;
    let restricted = match job.keep {
        Some(keep) => Some(BlockStatistics::from_passes(grid.restricted(keep)?, &shape, &data)?),
        None => None,
    };
    let statistics = BlockStatistics::from_passes(grid, &shape, &data)?;
    Ok(Finished { rows, image: Some(image), statistics, restricted, pass_spp: run.pass_spp })
}

pub(super) fn image_of(array: &Array) -> Option<Image> {
    let &[height, width, 3] = array.shape.as_slice() else { return None };
    let pixels = array.data.chunks_exact(3).map(|c| Rgb::new(c[0], c[1], c[2])).collect();
    Image::new(u32::try_from(width).ok()?, u32::try_from(height).ok()?, pixels).ok()
}
