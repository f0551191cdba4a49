//! What a manifest comes to: scenes that were read, methods with all settings, and what cannot be done.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::estimator::Registry;
use crate::scene::description::FilmSize;

use super::entry::StringOr;
use super::error::ExperimentError;
use super::machine::Machine;
use super::manifest::{Manifest, MethodEntry, SceneEntry};
use super::method::{self, MethodKind};
use super::mitsuba::Mitsuba;
use super::{Subject, files, seeds};

/// A resolved experiment: with the same scenes it gives the same images, where the budget counts samples and the renderer is
/// this one.
#[derive(Clone, Debug)]
pub struct Plan {
    /// What was asked for, with names for all scenes and methods.
    pub manifest: Manifest,
    /// Methods, in the order of their runs.
    pub methods: Vec<MethodPlan>,
    /// Scenes, as the manifest's.
    pub scenes: Vec<ScenePlan>,
    /// Where errors are measured: in seconds or samples per pixel, as the budget is.
    pub checkpoints: Vec<f64>,
    /// Versions of Mitsuba and its LLVM, where they take part.
    pub mitsuba: Option<String>,
    /// The command line that asked for it.
    pub command: String,
    /// Where it runs.
    pub machine: Machine,
}

/// A method of an experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct MethodPlan {
    /// What it is called in every table.
    pub label: String,
    /// `name:key=value:…`.
    pub text: String,
    /// When it joined the experiment, from 0; see [`seeds`].
    pub stream: u32,
}

/// A scene of an experiment, read.
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
    /// What errors are measured against, in words.
    #[serde(default)]
    pub reference: String,
    /// The radiance of every pixel, red, green and blue, where it is known exactly.
    #[serde(default)]
    pub exact: Option<[f64; 3]>,
    /// Size of the image.
    pub film: FilmSize,
    /// Methods that cannot render it, and why.
    #[serde(default)]
    pub skipped: BTreeMap<String, String>,
    /// All settings of each method with the values that apply.
    pub settings: BTreeMap<String, BTreeMap<String, String>>,
}

/// What an experiment has found out about itself, for the record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Record {
    /// Version of this program.
    pub version: String,
    /// See [`Plan::mitsuba`].
    #[serde(default)]
    pub mitsuba: Option<String>,
    /// See [`Plan::command`]; the latest.
    pub command: String,
    /// See [`Plan::checkpoints`].
    pub checkpoints: Vec<f64>,
    /// See [`MethodPlan::stream`].
    pub streams: BTreeMap<String, u32>,
    /// The scenes.
    pub scenes: Vec<ScenePlan>,
}

impl ScenePlan {
    /// Longest path in edges; `None` is unlimited.
    #[must_use]
    pub fn longest(&self) -> Option<u32> {
        self.max_length.parse().ok()
    }
}

impl Plan {
    /// Resolves a manifest with its scenes, in its order; nothing has run when it fails. `earlier` is what the folder holds
    /// already: its methods keep their seeds.
    ///
    /// # Errors
    /// Where a method or setting is unknown, or something is named twice.
    pub fn resolve(
        mut manifest: Manifest,
        subjects: &[Subject],
        registry: &Registry,
        mitsuba: Option<&Mitsuba>,
        earlier: Option<&Manifest>,
        command: &str,
    ) -> Result<Self, ExperimentError> {
        if manifest.scenes.is_empty() || manifest.methods.is_empty() || manifest.seeds == 0 {
            let what = "an experiment needs at least one scene, one method and one seed";
            return Err(ExperimentError::Usage(what.into()));
        }
        for (StringOr(entry), subject) in manifest.scenes.iter_mut().zip(subjects) {
            entry.name.get_or_insert_with(|| subject.scene.name().to_owned());
            // A default that changes in the file must not change the experiment.
            entry.parameters.clone_from(&subject.description.parameters);
        }
        let names = manifest.scenes.iter().filter_map(|entry| entry.name.as_deref());
        refuse_twins("scene", names)?;
        let mut streams =
            earlier.and_then(|earlier| earlier.record.as_ref()).map_or_else(BTreeMap::new, |r| r.streams.clone());
        let mut methods = Vec::new();
        for StringOr(entry) in &mut manifest.methods {
            let label = entry.label();
            entry.name = Some(label.clone());
            let next = streams.values().max().map_or(0, |last| last + 1);
            let stream = *streams.entry(label.clone()).or_insert(next);
            methods.push(MethodPlan { label, text: entry.text(), stream });
        }
        refuse_twins("method", methods.iter().map(|method| method.label.as_str()))?;
        let entries = manifest.scenes.iter().zip(subjects);
        let scenes =
            entries.map(|(entry, subject)| resolve_scene(&manifest, entry, subject, &methods, registry, mitsuba));
        let scenes = scenes.collect::<Result<Vec<_>, ExperimentError>>()?;
        let has_mitsuba = methods.iter().any(|method| method.text.starts_with(method::MITSUBA));
        Ok(Self {
            mitsuba: mitsuba.filter(|_| has_mitsuba).map(Mitsuba::versions),
            command: command.to_owned(),
            machine: Machine::this(manifest.threads),
            checkpoints: manifest.budget.checkpoints(),
            methods,
            scenes,
            manifest,
        })
    }

    /// The seed of a repetition of a method.
    #[must_use]
    pub fn seed_of(&self, method: &MethodPlan, repetition: u32) -> u64 {
        seeds::seed_of(self.manifest.seed, method.stream, repetition)
    }

    /// The manifest with its record, together with all that an earlier one has besides: what `experiment.toml` holds.
    #[must_use]
    pub fn recorded(&self, earlier: Option<&Manifest>) -> Manifest {
        let mut manifest = self.manifest.clone();
        manifest.materials = manifest.materials.or(earlier.and_then(|earlier| earlier.materials));
        let mut record = Record {
            version: env!("CARGO_PKG_VERSION").into(),
            mitsuba: self.mitsuba.clone(),
            command: self.command.clone(),
            checkpoints: self.checkpoints.clone(),
            streams: self.methods.iter().map(|method| (method.label.clone(), method.stream)).collect(),
            scenes: self.scenes.clone(),
        };
        if let Some((earlier, old)) = earlier.and_then(|earlier| Some((earlier, earlier.record.as_ref()?))) {
            manifest.seeds = manifest.seeds.max(earlier.seeds);
            merge(&earlier.methods, &mut manifest.methods, |method: &MethodEntry| method.label());
            merge(&earlier.scenes, &mut manifest.scenes, |scene: &SceneEntry| scene.name.clone().unwrap_or_default());
            for (label, stream) in &old.streams {
                record.streams.entry(label.clone()).or_insert(*stream);
            }
            record.mitsuba = record.mitsuba.or_else(|| old.mitsuba.clone());
            for scene in &mut record.scenes {
                if let Some(old) = old.scenes.iter().find(|old| old.name == scene.name) {
                    let (settings, skipped) = (old.settings.clone(), old.skipped.clone());
                    scene.settings = settings.into_iter().chain(std::mem::take(&mut scene.settings)).collect();
                    let asked = |label: &String| self.methods.iter().any(|method| method.label == *label);
                    scene.skipped.extend(skipped.into_iter().filter(|(label, _)| !asked(label)));
                }
            }
            let missing = |old: &&ScenePlan| !self.scenes.iter().any(|scene| scene.name == old.name);
            let mut scenes: Vec<ScenePlan> = old.scenes.iter().filter(missing).cloned().collect();
            scenes.append(&mut record.scenes);
            let place = |scene: &ScenePlan| manifest.scenes.iter().position(|e| e.name.as_ref() == Some(&scene.name));
            scenes.sort_by_key(place);
            record.scenes = scenes;
        }
        manifest.record = Some(record);
        manifest
    }
}

/// Old elements first, in their order, each as the new list has it where it does.
fn merge<T: Clone>(old: &[StringOr<T>], new: &mut Vec<StringOr<T>>, name: impl Fn(&T) -> String) {
    let mut all = Vec::new();
    for entry in old {
        let known = new.iter().position(|other| name(other) == name(entry));
        all.push(known.map_or_else(|| entry.clone(), |place| new.remove(place)));
    }
    all.append(new);
    *new = all;
}

fn resolve_scene(
    manifest: &Manifest,
    entry: &SceneEntry,
    subject: &Subject,
    methods: &[MethodPlan],
    registry: &Registry,
    mitsuba: Option<&Mitsuba>,
) -> Result<ScenePlan, ExperimentError> {
    let longest = entry.max_length.or(manifest.max_length).map_or(subject.scene.hints().max_length, |length| length.0);
    let max_length = longest.map_or_else(|| "none".to_owned(), |edges| edges.to_string());
    let mut plan = ScenePlan {
        name: entry.name.clone().unwrap_or_default(),
        file: subject.scene.source().into(),
        fingerprint: subject.fingerprint.clone(),
        camera: subject.description.sensor.as_ref().map_or_else(String::new, |sensor| sensor.name.clone()),
        max_length: max_length.clone(),
        reference: String::new(),
        exact: None,
        film: subject.scene.sensor().film(),
        skipped: BTreeMap::new(),
        settings: BTreeMap::new(),
    };
    for MethodPlan { label, text, .. } in methods {
        let method = method::build(text, registry, &max_length)?;
        let refusal = match &method.kind {
            MethodKind::Own(integrator) => integrator.supports(&subject.scene).err(),
            MethodKind::Mitsuba(wanted) => match mitsuba {
                Some(mitsuba) => mitsuba.supports(wanted).err(),
                None => Some(Mitsuba::MISSING.into()),
            },
        };
        plan.settings.insert(label.clone(), method.settings);
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
        let folder = files::file_name(name);
        if seen.contains(&folder) {
            let what =
                format!("the {what} {name} is there twice; leave one out, or give it a name of its own in a manifest");
            return Err(ExperimentError::Usage(what));
        }
        seen.push(folder);
    }
    Ok(())
}
