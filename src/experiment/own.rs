//! A run of an integrator of this program, in this process.

use std::time::{Duration, Instant};

use cpu_time::ProcessTime;

use crate::estimator::{Control, Integrator};
use crate::film::Film;
use crate::report::Row;

use super::Subject;
use super::budget::Budget;
use super::error::ExperimentError;
use super::run::{Finished, Job, Observer, RunEnd, Standing};

/// Rendering time between two looks at the clock \[s\].
const LOOK_EVERY: f64 = 0.1;

/// One run on the threads of `pool`.
pub(super) fn render(
    integrator: &dyn Integrator,
    subject: &Subject,
    job: &Job<'_>,
    pool: &rayon::ThreadPool,
    observer: &mut (dyn Observer + Send),
) -> Result<RunEnd, ExperimentError> {
    let size = subject.scene.sensor().film();
    let mut film = Film::new(size.width, size.height, None)?;
    if let Some(keep) = job.keep {
        film.keep_restricted(keep)?;
    }
    let mut clock = Clock {
        job,
        subject,
        observer,
        wall: Duration::ZERO,
        processor: Duration::ZERO,
        batch: None,
        next: 0,
        rows: Vec::new(),
        stopped: false,
        failure: None,
    };
    pool.install(|| integrator.render(&subject.scene, job.seed, &mut film, &mut clock));
    let Clock { rows, stopped, failure, .. } = clock;
    if let Some(failure) = failure {
        return Err(failure);
    }
    if stopped {
        return Ok(RunEnd::Stopped);
    }
    Ok(RunEnd::Finished(Box::new(Finished {
        rows,
        image: Some(film.mean_image()),
        statistics: film.block_statistics().clone(),
        restricted: film.restricted_statistics().cloned(),
        pass_spp: 1,
    })))
}

/// Runs while the integrator renders, and stands still while it is asked what to do next.
struct Clock<'a> {
    job: &'a Job<'a>,
    subject: &'a Subject,
    observer: &'a mut (dyn Observer + Send),
    wall: Duration,
    processor: Duration,
    batch: Option<(Instant, ProcessTime)>,
    /// Index of the checkpoint to reach next.
    next: usize,
    rows: Vec<Row>,
    stopped: bool,
    failure: Option<ExperimentError>,
}

impl Clock<'_> {
    /// In the unit of the budget and of the checkpoints.
    fn spent(&self, film: &Film) -> f64 {
        match self.job.budget() {
            Budget::Seconds(_) | Budget::Error(_) => self.wall.as_secs_f64(),
            Budget::Spp(_) => film.passes() as f64,
        }
    }

    /// Where several checkpoints are reached at once, only the last of them is recorded.
    fn record(&mut self, film: &Film) -> Result<(), ExperimentError> {
        let spent = self.spent(film);
        let reached = self.job.plan.checkpoints.iter().filter(|&&time| time <= spent).count();
        if reached <= self.next || film.passes() == 0 {
            return Ok(());
        }
        self.next = reached;
        let machine = &self.job.plan.machine;
        let row = Row {
            scene: self.job.scene.name.clone(),
            method: self.job.method.label.clone(),
            renderer: format!("pathspace {}", env!("CARGO_PKG_VERSION")),
            seed: self.job.seed,
            hardware: machine.hardware.clone(),
            host: machine.host.clone(),
            threads: machine.threads as u32,
            checkpoint: reached as u32 - 1,
            spp: film.passes(),
            render_seconds: self.wall.as_secs_f64(),
            cpu_seconds: Some(self.processor.as_secs_f64()),
            setup_seconds: Some(self.subject.build_seconds),
            rays: Some(film.counters.rays),
            invalid: film.counters.invalid,
            load_seconds: Some(self.subject.load_seconds),
            negative: Some(film.counters.negative),
            ..Row::default()
        };
        self.rows.push(self.job.measured(row, &film.mean_image())?);
        Ok(())
    }

    /// Passes up to the next checkpoint or look at the clock, whatever comes first; zero at the end.
    fn wanted(&self, film: &Film) -> u64 {
        let Some(&target) = self.job.plan.checkpoints.get(self.next) else { return 0 };
        if let (Budget::Error(wanted), Some(row)) = (self.job.budget(), self.rows.last())
            && wanted.reached(row)
        {
            return 0;
        }
        if film.passes() == 0 {
            return 1;
        }
        let per_pass = self.wall.as_secs_f64() / film.passes() as f64;
        let until_look = (LOOK_EVERY / per_pass) as u64;
        let until_target = match self.job.budget() {
            Budget::Seconds(_) | Budget::Error(_) => ((target - self.wall.as_secs_f64()) / per_pass) as u64,
            Budget::Spp(_) => target as u64 - film.passes(),
        };
        until_look.min(until_target).max(1)
    }
}

impl Control for Clock<'_> {
    fn next_passes(&mut self, film: &Film) -> u64 {
        if let Some((wall, processor)) = self.batch.take() {
            self.wall += wall.elapsed();
            self.processor += processor.elapsed();
        }
        if let Err(error) = self.record(film) {
            self.failure = Some(error);
            return 0;
        }
        let wanted = self.wanted(film);
        self.stopped = wanted > 0 && self.observer.stopped();
        if wanted == 0 || self.stopped {
            return 0;
        }
        let share = self.spent(film) / self.job.budget().end();
        let rmse = self.rows.last().and_then(|row| row.rmse);
        let seconds = self.wall.as_secs_f64();
        self.observer.progress(&Standing { share, seconds, spp: film.passes(), rmse, ..Standing::default() });
        self.batch = Some((Instant::now(), ProcessTime::now()));
        wanted
    }
}
