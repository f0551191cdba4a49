//! References by Mitsuba: its passes, one by one, are added up here, so that they go on like any other's.

use std::cell::RefCell;
use std::fs;
use std::path::Path;
use std::time::Duration;

use serde::Deserialize;

use crate::experiment::error::ExperimentError;
use crate::experiment::method::MitsubaMethod;
use crate::experiment::mitsuba::{Mitsuba, image_of};
use crate::experiment::process::{Ended, Line, run_limited};
use crate::film::{Film, FilmError, RenderInfo};
use crate::report::npy::read_npy;
use crate::scene::mitsuba::{ExportOptions, export};

use super::growth::{Growth, Until};
use super::{Cache, Kept, SAVE_EVERY, Wanted, save};

/// Samples per pixel of a pass: enough to be worth a call, few enough to stop at. It is the same for all passes, which count
/// alike, and on every machine, so that a number of samples means the same passes everywhere.
pub(super) const PASS_SPP: u64 = 16;

/// A line of the runner, about a pass.
#[derive(Deserialize)]
struct Pass {
    /// Its image.
    file: String,
    /// Rendering time of all passes of this process \[s\].
    seconds: f64,
    /// The same of the processor.
    cpu_seconds: f64,
    /// Its pixels that cannot be right.
    invalid: u64,
}

impl Cache<'_> {
    /// Whether it is as far as is wanted, or else was stopped.
    pub(super) fn by_mitsuba(
        &mut self,
        wanted: &Wanted<'_>,
        method: &MitsubaMethod,
        kept: &mut Kept,
        file: &Path,
    ) -> Result<bool, ExperimentError> {
        let words = format!("{}: reference by {}", wanted.plan.name, kept.method);
        let refuse = |what: String| ExperimentError::Scene(format!("{words}: {what}"));
        let mitsuba = self.mitsuba.ok_or_else(|| refuse(Mitsuba::MISSING.into()))?;
        let scratch = tempfile::tempdir().map_err(|error| refuse(format!("no place for its passes: {error}")))?;
        let options =
            ExportOptions { film: wanted.plan.film, max_length: wanted.plan.longest(), ..ExportOptions::default() };
        let scene = scratch.path().join("scene");
        export(&wanted.subject.description, &options, &scene)?;

        let Kept { film, info, .. } = kept;
        let mut command = mitsuba.run(method, &scene.join("scene.xml"), scratch.path());
        command.args(["--seed", &info.seed.to_string(), "--threads", &self.pool.current_num_threads().to_string()]);
        // Each pass of the film has used up one of the seeds.
        command.args(["--reference-from", &film.passes().to_string(), "--pass-spp", &PASS_SPP.to_string()]);
        match wanted.until {
            Until::Spp(spp) => {
                let missing = spp.div_ceil(PASS_SPP).saturating_sub(film.passes());
                command.args(["--spp", &(missing * PASS_SPP).to_string()])
            }
            // Whoever adds the passes up ends it when that is enough.
            Until::Seconds(_) | Until::Noise(_) => command.args(["--seconds", "1e9"]),
        };
        let save_at = info.render_seconds + SAVE_EVERY;
        let growth = Growth::new(wanted.until, self.observer);
        let before = (info.render_seconds, info.cpu_seconds);
        let sum = RefCell::new(Sum { film, info, before, growth, file, save_at, done: Ok(false) });
        let mut last = String::new();
        let ended = run_limited(
            &mut command,
            Duration::MAX,
            || sum.borrow().is_over(),
            |line| match line {
                Line::Error(text) if text.starts_with('{') => {
                    if let Ok(pass) = serde_json::from_str(&text) {
                        sum.borrow_mut().take(&pass, scratch.path());
                    }
                }
                Line::Error(text) if !text.is_empty() => last = text,
                _ => {}
            },
        );
        let Sum { film, info, growth, done, .. } = sum.into_inner();
        save(file, film, info)?;
        if done? {
            return Ok(true);
        }
        match ended {
            Err(error) => Err(refuse(format!("Python cannot be run: {error}"))),
            Ok(_) if growth.observer.stopped() => Ok(false),
            Ok(Ended::Itself(status)) if status.code() == Some(130) => Ok(false),
            Ok(Ended::Itself(status)) => Err(refuse(format!("{status}: {last}"))),
            Ok(Ended::Stopped | Ended::TimedOut) => Ok(false),
        }
    }
}

/// The film while passes come in.
struct Sum<'a, 'b> {
    film: &'b mut Film,
    info: &'b mut RenderInfo,
    /// Rendering and processor time of earlier processes \[s\].
    before: (f64, f64),
    growth: Growth<'a>,
    file: &'b Path,
    /// Rendering time at which what is done is written \[s\].
    save_at: f64,
    done: Result<bool, ExperimentError>,
}

impl Sum<'_, '_> {
    fn is_over(&self) -> bool {
        !matches!(self.done, Ok(false)) || self.growth.observer.stopped()
    }

    /// What comes after the last pass that is wanted is left out: it has not used up its seed.
    fn take(&mut self, pass: &Pass, folder: &Path) {
        if matches!(self.done, Ok(false)) {
            self.done = self.add(pass, folder);
        }
    }

    fn add(&mut self, pass: &Pass, folder: &Path) -> Result<bool, ExperimentError> {
        let file = folder.join(&pass.file);
        let image = image_of(&read_npy(&file)?).ok_or(FilmError::Incompatible)?;
        let _ = fs::remove_file(&file);
        if (image.width, image.height) != (self.film.width(), self.film.height()) {
            return Err(FilmError::Incompatible.into());
        }
        self.film.add_pass(&image.pixels)?;
        self.film.counters.invalid += pass.invalid;
        self.info.render_seconds = self.before.0 + pass.seconds;
        self.info.cpu_seconds = self.before.1 + pass.cpu_seconds;
        if self.info.render_seconds >= self.save_at {
            save(self.file, self.film, self.info)?;
            self.save_at = self.info.render_seconds + SAVE_EVERY;
        }
        self.growth.look(self.film, self.info)
    }
}
