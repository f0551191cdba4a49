//! `experiment.toml`: all that an experiment depends on.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::estimator::Registry;
use crate::scene::LightSelection;
use crate::scene::description::FilmSize;

use super::Subject;
use super::error::ExperimentError;
use super::method::{self, MethodKind};
use super::mitsuba::Mitsuba;

/// The first checkpoint of a timed run is not before this time \[s\].
const FIRST_CHECKPOINT: f64 = 0.1;

/// When a run ends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Budget {
    /// With the first pass that reaches this rendering time \[s\].
    Seconds(f64),
    /// After so many samples per pixel.
    Spp(u64),
}

impl Budget {
    /// Where errors are measured, ascending, the budget itself last. In seconds: `T 2^(−j/2)` down to 0.1 s. In samples per
    /// pixel: the powers of two.
    #[must_use]
    pub fn checkpoints(self) -> Vec<f64> {
        let mut times = match self {
            Self::Seconds(seconds) => {
                let time = |j: i32| seconds * libm::exp2(-0.5 * f64::from(j));
                (0..).map(time).take_while(|&time| time >= FIRST_CHECKPOINT || time == seconds).collect::<Vec<_>>()
            }
            Self::Spp(spp) => {
                let below = (0..63).map(|j| 1_u64 << j).take_while(|&power| power < spp);
                let below: Vec<f64> = below.map(|power| power as f64).collect();
                std::iter::once(spp as f64).chain(below.into_iter().rev()).collect()
            }
        };
        times.reverse();
        times
    }
}

/// What the user asks for, beside scenes.
#[derive(Clone, Debug)]
pub struct Request {
    /// `name:key=value:…`, of the registry or of Mitsuba.
    pub methods: Vec<String>,
    /// When a run ends.
    pub budget: Budget,
    /// The first seed.
    pub seed: u64,
    /// Runs of each method on each scene.
    pub seeds: u32,
    /// Threads that render.
    pub threads: usize,
    /// Longest path in edges, `Some(None)` for unlimited; `None` leaves it to each scene.
    pub max_length: Option<Option<u32>>,
    /// How the scenes were built.
    pub light_selection: LightSelection,
    /// The command line, for the record.
    pub command: String,
}

/// A resolved experiment: with the same scenes it gives the same images, where the budget counts samples and the renderer is
/// this one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Version of this program.
    pub version: String,
    /// Versions of Mitsuba and its LLVM, where they take part.
    #[serde(default)]
    pub mitsuba: Option<String>,
    /// The command line that asked for it.
    pub command: String,
    /// Model of the processor.
    pub cpu: String,
    /// Threads that render.
    pub threads: usize,
    /// The first seed; see [`Plan::seed_of`].
    pub seed: u64,
    /// Runs of each method on each scene.
    pub seeds: u32,
    /// How one of several emitters is chosen. Mitsuba chooses all alike.
    pub light_selection: LightSelection,
    /// Methods as the user wrote them, in the order of their runs.
    pub methods: Vec<String>,
    /// Where errors are measured: in seconds or samples per pixel, as the budget is.
    pub checkpoints: Vec<f64>,
    /// When a run ends.
    pub budget: Budget,
    /// The scenes.
    pub scenes: Vec<ScenePlan>,
}

/// A scene of an experiment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScenePlan {
    /// Its name.
    pub name: String,
    /// Its file.
    pub file: PathBuf,
    /// See [`Subject::fingerprint`].
    pub fingerprint: String,
    /// Its camera.
    pub camera: String,
    /// Longest path in edges, or `none`.
    pub max_length: String,
    /// What errors are measured against.
    #[serde(default)]
    pub reference: String,
    /// Size of the image.
    pub film: FilmSize,
    /// Methods that cannot render it, and why.
    #[serde(default)]
    pub skipped: BTreeMap<String, String>,
    /// All settings of each method with the values that apply.
    pub settings: BTreeMap<String, BTreeMap<String, String>>,
}

impl ScenePlan {
    /// Longest path in edges; `None` is unlimited.
    #[must_use]
    pub fn longest(&self) -> Option<u32> {
        self.max_length.parse().ok()
    }
}

impl Plan {
    /// Resolves what is asked for; nothing has run when it fails.
    ///
    /// # Errors
    /// Where a method or setting is unknown, or something is named twice.
    pub fn resolve(
        request: &Request,
        subjects: &[Subject],
        registry: &Registry,
        mitsuba: Option<&Mitsuba>,
    ) -> Result<Self, ExperimentError> {
        if subjects.is_empty() || request.methods.is_empty() || request.seeds == 0 {
            let what = "an experiment needs at least one scene, one method and one seed";
            return Err(ExperimentError::Usage(what.into()));
        }
        refuse_twins("method", request.methods.iter().map(String::as_str))?;
        refuse_twins("scene", subjects.iter().map(|subject| subject.scene.name()))?;
        let scenes = subjects.iter().map(|subject| resolve_scene(request, subject, registry, mitsuba));
        let scenes = scenes.collect::<Result<Vec<_>, ExperimentError>>()?;
        let has_mitsuba = request.methods.iter().any(|method| method.starts_with(method::MITSUBA));
        Ok(Self {
            version: env!("CARGO_PKG_VERSION").into(),
            mitsuba: mitsuba.filter(|_| has_mitsuba).map(Mitsuba::versions),
            command: request.command.clone(),
            cpu: cpu_model(),
            threads: request.threads.max(1),
            seed: request.seed,
            seeds: request.seeds,
            light_selection: request.light_selection,
            methods: request.methods.clone(),
            checkpoints: request.budget.checkpoints(),
            budget: request.budget,
            scenes,
        })
    }

    /// The seed of a repetition of a method, both counted from 0: no two runs on a scene have the same.
    #[must_use]
    pub fn seed_of(&self, method: usize, repetition: u32) -> u64 {
        let run = u64::from(repetition) * self.methods.len() as u64 + method as u64;
        self.seed.wrapping_add(run)
    }

    /// As the text of `experiment.toml`.
    ///
    /// # Errors
    /// Where a seed exceeds what the format can hold.
    pub fn to_toml(&self) -> Result<String, ExperimentError> {
        toml::to_string(self).map_err(|error| ExperimentError::Usage(format!("experiment.toml: {error}")))
    }

    /// From the text of `experiment.toml`.
    ///
    /// # Errors
    /// Where it is none.
    pub fn from_toml(text: &str) -> Result<Self, ExperimentError> {
        toml::from_str(text).map_err(|error| ExperimentError::Scene(format!("experiment.toml: {}", error.message())))
    }
}

fn resolve_scene(
    request: &Request,
    subject: &Subject,
    registry: &Registry,
    mitsuba: Option<&Mitsuba>,
) -> Result<ScenePlan, ExperimentError> {
    let longest = request.max_length.unwrap_or(subject.scene.hints().max_length);
    let max_length = longest.map_or_else(|| "none".to_owned(), |edges| edges.to_string());
    let mut plan = ScenePlan {
        name: subject.scene.name().into(),
        file: subject.scene.source().into(),
        fingerprint: subject.fingerprint.clone(),
        camera: subject.description.sensor.as_ref().map_or_else(String::new, |sensor| sensor.name.clone()),
        max_length: max_length.clone(),
        reference: String::new(),
        film: subject.scene.sensor().film(),
        skipped: BTreeMap::new(),
        settings: BTreeMap::new(),
    };
    for label in &request.methods {
        let method = method::build(label, registry, &max_length)?;
        let refusal = match &method.kind {
            MethodKind::Own(integrator) => integrator.supports(&subject.scene).err(),
            MethodKind::Mitsuba(wanted) => match mitsuba {
                Some(mitsuba) => mitsuba.supports(wanted).err(),
                None => Some("no Python with Mitsuba here: run scripts/setup, or name one in $PATHSPACE_PYTHON".into()),
            },
        };
        let mut settings = method.settings;
        if let (MethodKind::Mitsuba(wanted), Some(mitsuba)) = (&method.kind, mitsuba) {
            settings.insert("variant".into(), mitsuba.variant(wanted).into());
        }
        plan.settings.insert(label.clone(), settings);
        if let Some(why) = refusal {
            plan.skipped.insert(label.clone(), why);
        }
    }
    Ok(plan)
}

fn refuse_twins<'a>(what: &str, names: impl Iterator<Item = &'a str>) -> Result<(), ExperimentError> {
    let mut seen = Vec::new();
    for name in names {
        // Two names that make the same folder are twins too.
        let folder = super::files::file_name(name);
        if seen.contains(&folder) {
            return Err(ExperimentError::Usage(format!("the {what} {name} is there twice; leave one out")));
        }
        seen.push(folder);
    }
    Ok(())
}

fn cpu_model() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = info.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    model.map_or_else(|| std::env::consts::ARCH.to_owned(), |(_, model)| model.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checkpoints_ascend_by_root_two_to_the_budget() {
        let times = Budget::Seconds(8.0).checkpoints();
        assert_eq!((times.len(), times[12], times[10]), (13, 8.0, 4.0));
        assert!(times[0] >= FIRST_CHECKPOINT && times.windows(2).all(|pair| pair[0] < pair[1]));
        assert_eq!(Budget::Seconds(0.01).checkpoints(), [0.01]);
        assert_eq!(Budget::Spp(12).checkpoints(), [1.0, 2.0, 4.0, 8.0, 12.0]);
        assert_eq!(Budget::Spp(8).checkpoints(), [1.0, 2.0, 4.0, 8.0]);
        assert_eq!(Budget::Spp(1).checkpoints(), [1.0]);
    }
}
