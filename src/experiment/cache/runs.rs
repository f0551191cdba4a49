//! References by Mitsuba: an experiment of runs with seeds of their own, whose images are the passes of a film.

use std::path::Path;

use crate::film::{Film, RenderInfo};

use super::super::budget::Budget;
use super::super::error::ExperimentError;
use super::super::files::Folder;
use super::super::job;
use super::super::manifest::{Manifest, MaxLength, SceneEntry};
use super::super::method::name_of;
use super::super::plan::Plan;
use super::super::reference::ReferencePolicy;
use super::super::run::{Renderers, run};
use super::super::seeds::{MOST, seed_of};
use super::{Cache, Kept, Wanted};

/// Rendering time of a run \[s\].
const SECONDS: f64 = 10.0;

/// Samples per pixel of a run.
const SPP: u64 = 64;

/// A name for the scene below the folder of the reference, whatever the experiment calls it.
const SCENE: &str = "scene";

impl Cache<'_> {
    /// Makes the runs that are missing until the wanted time or samples are spent.
    pub(super) fn extend_runs(&mut self, wanted: &Wanted<'_>, place: &Path) -> Result<(), ExperimentError> {
        let Wanted { subject, plan: scene, method, until } = *wanted;
        let (budget, count) = match until {
            Budget::Seconds(seconds) => (Budget::Seconds(SECONDS), (seconds / SECONDS).ceil()),
            Budget::Spp(spp) => (Budget::Spp(SPP), (spp as f64 / SPP as f64).ceil()),
            Budget::Error(target) => (Budget::Seconds(SECONDS), (target.seconds / SECONDS).ceil()),
        };
        let folder = Folder::open(place, false)?;
        let earlier = folder.manifest()?;
        let entry = SceneEntry { file: scene.file.clone(), name: Some(SCENE.into()), ..SceneEntry::default() };
        let mut manifest = Manifest::new(vec![entry], [method]);
        manifest.max_length = Some(MaxLength(scene.longest()));
        manifest.reference = ReferencePolicy::None;
        manifest.threads = u16::try_from(self.pool.current_num_threads()).unwrap_or(u16::MAX);
        manifest.seeds = (count as u32).clamp(1, MOST - 1);
        // As if it were the last method that an experiment can have, so that no run has the same random numbers.
        manifest.seed = seed_of(0, MOST - 1, 0);
        manifest.budget = earlier.as_ref().map_or(budget, |earlier| earlier.budget);
        if manifest.budget != budget {
            let what = format!(
                "{}: the reference's runs are counted in {}; go on so, or remove it",
                place.display(),
                if matches!(budget, Budget::Spp(_)) { "seconds" } else { "samples" }
            );
            return Err(ExperimentError::Usage(what));
        }
        let subjects = std::slice::from_ref(subject);
        let plan = Plan::resolve(manifest, subjects, self.registry, self.mitsuba, earlier.as_ref(), "reference")?;
        if let Some(why) = plan.scenes[0].skipped.get(method) {
            return Err(ExperimentError::Scene(format!("{}: reference by {method}: {why}", scene.name)));
        }
        let renderers = Renderers { registry: self.registry, mitsuba: self.mitsuba };
        let made = run(&plan, subjects, renderers, &folder, &[], self.observer)?;
        if let Some((_, why)) = made.failed.first() {
            return Err(ExperimentError::Scene(format!("{}: reference by {method}: {why}", scene.name)));
        }
        if made.stopped {
            let what = format!("{}: reference stopped; it goes on where it was", scene.name);
            return Err(ExperimentError::Stopped(what));
        }
        Ok(())
    }
}

/// All finished runs as one film.
pub(super) fn read_runs(place: &Path) -> Result<Option<Kept>, ExperimentError> {
    let folder = Folder::open(place, false)?;
    let Some(manifest) = folder.manifest()? else { return Ok(None) };
    let (Some(entry), Some(record)) = (manifest.methods.first(), &manifest.record) else { return Ok(None) };
    let (label, text) = (entry.label(), entry.text());
    let stream = record.streams.get(&label).copied().unwrap_or(0);
    let mut kept: Option<Kept> = None;
    for repetition in 0..manifest.seeds {
        let seed = seed_of(manifest.seed, stream, repetition);
        let Some((_, run)) = job::load(&folder.run(SCENE, &label, seed))? else { continue };
        let (Some(image), Some(last)) = (run.image, run.rows.last()) else { continue };
        let kept = match &mut kept {
            Some(kept) => kept,
            None => kept.insert(Kept {
                method: text.clone(),
                film: Film::new(image.width, image.height, None)?,
                spp: 0,
                info: RenderInfo {
                    scene: SCENE.into(),
                    integrator: name_of(&text).to_owned(),
                    seed: manifest.seed,
                    version: record.mitsuba.clone().unwrap_or_default(),
                    ..RenderInfo::default()
                },
            }),
        };
        kept.film.add_pass(&image.pixels)?;
        kept.spp += last.spp;
        kept.info.render_seconds += last.render_seconds;
        kept.info.cpu_seconds += last.cpu_seconds.unwrap_or(0.0);
    }
    Ok(kept)
}
