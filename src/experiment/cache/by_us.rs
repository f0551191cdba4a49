//! References by integrators of this program.

use std::path::Path;
use std::time::{Duration, Instant};

use cpu_time::ProcessTime;

use crate::estimator::{Control, Integrator};
use crate::experiment::error::ExperimentError;
use crate::film::{Film, RenderInfo};

use super::growth::{Growth, Until};
use super::{Cache, Kept, SAVE_EVERY, Wanted, save};

/// Rendering time between two looks at the clock \[s\].
const LOOK_EVERY: f64 = 0.2;

impl Cache<'_> {
    /// Whether it is as far as is wanted, or else was stopped.
    pub(super) fn by_us(
        &mut self,
        wanted: &Wanted<'_>,
        integrator: &dyn Integrator,
        kept: &mut Kept,
        file: &Path,
    ) -> Result<bool, ExperimentError> {
        let growth = Growth::new(wanted.until, self.observer);
        let Kept { film, info, .. } = kept;
        let mut clock = Clock { growth, save_at: 0.0, info, batch: None, done: Ok(false) };
        loop {
            clock.save_at = clock.info.render_seconds + SAVE_EVERY;
            let seed = clock.info.seed;
            self.pool.install(|| integrator.render(&wanted.subject.scene, seed, film, &mut clock));
            save(file, film, clock.info)?;
            match &clock.done {
                Ok(false) if !clock.growth.observer.stopped() => {}
                _ => return clock.done,
            }
        }
    }
}

struct Clock<'a, 'b> {
    growth: Growth<'a>,
    /// Rendering time at which what is done is written \[s\].
    save_at: f64,
    info: &'b mut RenderInfo,
    batch: Option<(Instant, ProcessTime, u64)>,
    done: Result<bool, ExperimentError>,
}

impl Control for Clock<'_, '_> {
    fn next_passes(&mut self, film: &Film) -> u64 {
        let mut per_pass = Duration::ZERO;
        if let Some((wall, processor, passes)) = self.batch.take() {
            let wall = wall.elapsed();
            self.info.render_seconds += wall.as_secs_f64();
            self.info.cpu_seconds += processor.elapsed().as_secs_f64();
            per_pass = wall / (film.passes() - passes).max(1) as u32;
        }
        self.done = self.growth.look(film, self.info);
        let is_time = self.info.render_seconds >= self.save_at;
        if !matches!(self.done, Ok(false)) || is_time || self.growth.observer.stopped() {
            return 0;
        }
        self.batch = Some((Instant::now(), ProcessTime::now(), film.passes()));
        let fitting = LOOK_EVERY / per_pass.as_secs_f64();
        let passes = if fitting.is_finite() { (fitting as u64).max(1) } else { 1 };
        match self.growth.until {
            Until::Spp(spp) => passes.min(spp - film.passes()),
            Until::Seconds(_) | Until::Noise(_) => passes,
        }
    }
}
