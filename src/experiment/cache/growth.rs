//! How far a reference is, and whether that is enough.

use std::time::{Duration, Instant};

use crate::experiment::error::ExperimentError;
use crate::experiment::run::{Observer, Standing};
use crate::film::{Film, RenderInfo};

use super::kept;

/// Noise is looked at no more often: it takes a look at every pixel.
const NOISE_EVERY: Duration = Duration::from_secs(1);

/// Noise that is estimated from fewer passes is not believed.
const FEWEST_PASSES: u64 = 16;

/// Where so many passes show no noise at all, there is none to reach.
const MOST_PASSES_WITHOUT_NOISE: u64 = 1024;

/// How far a reference is rendered; what is there already counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Until {
    /// Rendering time \[s\].
    Seconds(f64),
    /// Samples per pixel; of Mitsuba the next multiple of those of a pass.
    Spp(u64),
    /// [`super::Kept::noise`].
    Noise(f64),
}

/// A reference on its way.
pub(super) struct Growth<'a> {
    pub until: Until,
    pub observer: &'a mut (dyn Observer + Send),
    noise: Option<f64>,
    next_noise: Option<Instant>,
}

impl<'a> Growth<'a> {
    pub fn new(until: Until, observer: &'a mut (dyn Observer + Send)) -> Self {
        Self { until, observer, noise: None, next_noise: None }
    }

    /// Tells where the reference stands, and whether that is enough.
    pub fn look(&mut self, film: &Film, info: &RenderInfo) -> Result<bool, ExperimentError> {
        let now = Instant::now();
        if self.noise.is_none() || self.next_noise.is_none_or(|next| now >= next) {
            self.noise = kept::noise(film);
            // Of a large film, less than a twentieth of the time goes into this.
            self.next_noise = Some(now + NOISE_EVERY.max(20 * now.elapsed()));
        }
        let (seconds, passes, spp) = (info.render_seconds, film.passes(), kept::spp(film, info));
        let (share, seconds_left) = match self.until {
            Until::Seconds(all) => (seconds / all, all - seconds),
            Until::Spp(all) => {
                let share = spp as f64 / all as f64;
                (share, seconds / share - seconds)
            }
            Until::Noise(goal) => {
                // The error falls with the root of the time.
                let share = self.noise.map_or(0.0, |noise| (goal / noise) * (goal / noise));
                (if passes < FEWEST_PASSES { share.min(0.99) } else { share }, seconds / share - seconds)
            }
        };
        let seconds_left = (passes > 0).then_some(seconds_left);
        self.observer.progress(&Standing { share, seconds, spp, rmse: None, noise: self.noise, seconds_left });
        if matches!(self.until, Until::Noise(_)) && self.noise.is_none() && passes >= MOST_PASSES_WITHOUT_NOISE {
            let what = format!("{}: the reference is black or not finite, so its noise says nothing", info.scene);
            return Err(ExperimentError::Scene(what));
        }
        Ok(share >= 1.0)
    }
}
