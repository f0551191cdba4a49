//! Paths with all their numbers, for a second evaluation elsewhere.

use crate::estimator::{Integrator, RecordedTerm, Registry, Term};
use crate::film::ReplayKey;
use crate::report::paths::{Origin, PathRecord, SceneRecord};
use crate::scene::{LightSelection, Scene, SceneDescription, SceneOptions};

/// Samples that are drawn to find the paths.
const MOST_SAMPLES: u64 = 1000;

/// Which paths to log.
#[derive(Clone, Debug)]
pub struct Journal {
    /// Where they lie.
    pub scene: SceneDescription,
    /// Whose definition says their densities and weights.
    pub integrator: String,
    /// Who draws them, where that is somebody else: then weights and terms are those of the definition, too.
    pub drawn_by: Option<String>,
    /// Edges at least.
    pub edges: u32,
    /// How many.
    pub paths: usize,
}

impl Journal {
    /// What the scene is made of, and the paths.
    ///
    /// # Errors
    /// Why there are none, in one line.
    pub fn records(&self, registry: &Registry, seed: u64) -> Result<(SceneRecord, Vec<PathRecord>), String> {
        let build = |text: &str| registry.build(text, &[]).map_err(|error| error.to_string());
        let options = SceneOptions { film: None, light_selection: LightSelection::Power };
        let (scene, _) = Scene::build(&self.scene, options).map_err(|error| error.to_string())?;
        let method = build(&self.integrator)?;
        let other = self.drawn_by.as_deref().map(build).transpose()?;
        let drawer = other.as_ref().unwrap_or(&method).integrator.as_ref();
        let mut records = Vec::new();
        let film = scene.sensor().film();
        let pixels = (0..film.height).flat_map(|y| (0..film.width).map(move |x| (x, y)));
        let keys = (0..MOST_SAMPLES).flat_map(|sample| pixels.clone().map(move |pixel| (sample, pixel)));
        for (sample, pixel) in keys {
            let key = ReplayKey { seed, sample, pixel };
            for (index, term) in drawer.replay(&scene, key).iter().enumerate() {
                let edges = term.path.edges() as u32;
                if edges < self.edges {
                    continue;
                }
                let definition = method.integrator.definition(edges);
                let origin = Origin { scene: &scene, integrator: &self.integrator, definition: definition.as_ref() };
                let term = match &other {
                    None => Some(term.clone()),
                    Some(_) => defined(method.integrator.as_ref(), &scene, term),
                };
                records.extend(term.map(|term| PathRecord::new(&origin, key, index, &term)));
                if records.len() == self.paths {
                    return Ok((SceneRecord::new(&scene), records));
                }
            }
        }
        Err(format!("only {} paths of {} edges or more were found", records.len(), self.edges))
    }
}

/// The term of the path by the integrator's definition; `None` where it has no such technique.
fn defined(integrator: &dyn Integrator, scene: &Scene, recorded: &RecordedTerm) -> Option<RecordedTerm> {
    let RecordedTerm { term, path } = recorded;
    let edges = path.edges() as u32;
    let definition = integrator.definition(edges)?;
    let densities = definition.densities(scene, path);
    let is_drawn = |&i: &usize| definition.samplers[i].technique(edges) == term.technique && !densities[i].is_zero();
    let i = (0..densities.len()).find(is_drawn)?;
    let value = definition.estimate(&scene.contribution(path)?, edges, &densities, i);
    let weight = definition.weight(&densities, i);
    let sampler = Some(i as u32);
    Some(RecordedTerm { term: Term { value, weight, sampler, ..*term }, path: path.clone() })
}
