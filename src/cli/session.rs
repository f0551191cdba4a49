//! A render from its first pass to its last: budget, clock, checkpoints, and the files it ends up in.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use cpu_time::ProcessTime;

use crate::estimator::Control;
use crate::film::{FileError, Film, RenderInfo, state, write_image};

use super::progress::{Progress, Standing};
use super::{complain, interrupt};

/// Rendering time between two looks at the clock \[s\]: short enough for a hand on Ctrl-C, long enough to cost nothing.
const LOOK_EVERY: f64 = 0.1;

/// Rendering time of the first checkpoint \[s\]; the others follow at twice the time of the one before.
const FIRST_CHECKPOINT: f64 = 1.0;

/// When a render is done. Both count from the first pass, those of a resumed film included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Budget {
    /// Samples per pixel.
    Passes(u64),
    /// Rendering time \[s\].
    Seconds(f64),
}

/// The files of a render.
#[derive(Clone, Debug)]
pub(super) struct Outputs {
    /// For looking.
    pub image: PathBuf,
    /// For going on.
    pub state: PathBuf,
    /// The state is written in any case, not only when interrupted.
    pub keep_state: bool,
    /// Brightness of a PNG \[stops\].
    pub exposure: f64,
}

impl Outputs {
    /// Writes the state, if it is wanted, and the image. When one fails the other is written nevertheless.
    pub(super) fn write(&self, film: &Film, info: &RenderInfo, with_state: bool) -> Result<(), FileError> {
        let state = if with_state { state::save(&self.state, film, info) } else { Ok(()) };
        write_image(&self.image, film, info, self.exposure).and(state)
    }
}

/// What the driver asks how to go on.
pub(super) struct Session {
    budget: Budget,
    outputs: Outputs,
    /// The times in it are those before this run.
    info: RenderInfo,
    earlier_passes: u64,
    earlier_rays: u64,
    rendering: Duration,
    processing: Duration,
    batch: Option<(Instant, ProcessTime)>,
    checkpoint: Option<f64>,
    progress: Progress,
    interrupted: bool,
}

impl Session {
    /// Goes on with `film`, which `info` has made so far; writes checkpoints if asked to.
    pub(super) fn new(budget: Budget, outputs: Outputs, info: RenderInfo, film: &Film, checkpoints: bool) -> Self {
        let mut checkpoint = FIRST_CHECKPOINT;
        while checkpoint <= info.render_seconds {
            checkpoint *= 2.0;
        }
        Self {
            budget,
            outputs,
            progress: Progress::new(&info.scene),
            info,
            earlier_passes: film.passes(),
            earlier_rays: film.counters.rays,
            rendering: Duration::ZERO,
            processing: Duration::ZERO,
            batch: None,
            checkpoint: checkpoints.then_some(checkpoint),
            interrupted: false,
        }
    }

    /// What has made the film up to now.
    pub(super) fn info(&self) -> RenderInfo {
        RenderInfo {
            render_seconds: self.seconds(),
            cpu_seconds: self.info.cpu_seconds + self.processing.as_secs_f64(),
            ..self.info.clone()
        }
    }

    /// Takes the progress bar away, whoever has ended the render.
    pub(super) fn end(&self) {
        self.progress.finish();
    }

    /// The user has ended it before its budget was spent.
    pub(super) fn interrupted(&self) -> bool {
        self.interrupted
    }

    /// Where it stands.
    pub(super) fn standing(&self, film: &Film) -> Standing {
        let seconds = self.rendering.as_secs_f64();
        let passes = (film.passes() - self.earlier_passes) as f64;
        let pixels = f64::from(film.width()) * f64::from(film.height());
        let (share, seconds_left) = match self.budget {
            Budget::Passes(all) => {
                (film.passes() as f64 / all as f64, all.saturating_sub(film.passes()) as f64 * seconds / passes)
            }
            Budget::Seconds(all) => (self.seconds() / all, all - self.seconds()),
        };
        let per_second = |count: f64| if seconds > 0.0 { count / seconds } else { 0.0 };
        Standing {
            share,
            seconds_left,
            samples_per_second: per_second(passes * pixels),
            rays_per_second: per_second((film.counters.rays - self.earlier_rays) as f64),
        }
    }

    /// Rendering time of all runs \[s\].
    fn seconds(&self) -> f64 {
        self.info.render_seconds + self.rendering.as_secs_f64()
    }

    fn decide(&self, film: &Film) -> u64 {
        let done = film.passes() - self.earlier_passes;
        let per_pass = self.rendering.as_secs_f64() / done as f64;
        let until_look = if done == 0 { 1 } else { ((LOOK_EVERY / per_pass) as u64).max(1) };
        match self.budget {
            Budget::Passes(all) => until_look.min(all.saturating_sub(film.passes())),
            Budget::Seconds(all) => {
                let left = all - self.seconds();
                // The last pass is drawn where it ends nearer to the budget than the one before it.
                let fitting = if done == 0 { u64::from(left > 0.0) } else { (left / per_pass).round() as u64 };
                until_look.min(fitting)
            }
        }
    }

    fn write_checkpoint(&mut self, film: &Film) {
        let Some(due) = self.checkpoint.filter(|&due| self.seconds() >= due) else { return };
        if let Err(error) = self.outputs.write(film, &self.info(), true) {
            complain("warning", &format!("checkpoint: {error}"));
        }
        let mut next = due;
        while next <= self.seconds() {
            next *= 2.0;
        }
        self.checkpoint = Some(next);
    }
}

impl Control for Session {
    fn next_passes(&mut self, film: &Film) -> u64 {
        if let Some((wall, processor)) = self.batch.take() {
            self.rendering += wall.elapsed();
            self.processing += processor.elapsed();
        }
        let wanted = self.decide(film);
        self.interrupted = wanted > 0 && interrupt::requested();
        if wanted == 0 || self.interrupted {
            return 0;
        }
        self.write_checkpoint(film);
        self.progress.update(film, &self.standing(film));
        self.batch = Some((Instant::now(), ProcessTime::now()));
        wanted
    }
}
