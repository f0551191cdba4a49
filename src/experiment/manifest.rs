//! The manifest of an experiment, `exp.toml`: scenes × methods × seeds, a budget, and what errors are measured against.
//!
//! ```toml
//! scenes = ["cornell_box", { file = "rooms/hall.gltf", name = "hall", film = "320x180", max_length = 8 }]
//! methods = ["path", { name = "bdpt, power", integrator = "bdpt", settings = { heuristic = "power" } }, "mitsuba:path"]
//! seeds = 8
//!
//! [budget]
//! seconds = 10
//! ```

use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::names::did_you_mean;
use crate::report::Metric;
use crate::scene::LightSelection;
use crate::scene::gltf::MaterialModel;

use super::budget::Budget;
use super::entry::StringOr;
use super::error::ExperimentError;
use super::plan::Record;
use super::reference::ReferencePolicy;

/// An experiment as the user writes it. `experiment.toml` is one too, with every default written out and a record of what was
/// found, so that it repeats the experiment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Runs of each method on each scene.
    #[serde(default = "Manifest::default_seeds")]
    pub seeds: u32,
    /// The first seed; see [`super::seeds`].
    #[serde(default = "Manifest::default_seed")]
    pub seed: u64,
    /// Threads that render; 0 takes all that the machine has.
    #[serde(default)]
    pub threads: u16,
    /// How one of several emitters is chosen. Mitsuba chooses all alike.
    #[serde(default)]
    pub light_selection: LightSelection,
    /// What glTF's materials become; where nothing is said, `principled` with Mitsuba among the methods and `gltf` without.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub materials: Option<MaterialModel>,
    /// Longest path in edges, where neither scene nor method says one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_length: Option<MaxLength>,
    /// What errors are measured against, where a scene of the manifest does not say.
    #[serde(default)]
    pub reference: ReferencePolicy,
    /// Errors that curves and verdicts are made of; ꟻLIP is slow, and measured only where it is among them.
    #[serde(default = "Manifest::default_metrics")]
    pub metrics: Vec<Metric>,
    /// Whether images are written.
    #[serde(default = "Manifest::default_images")]
    pub images: bool,
    /// When a run ends.
    #[serde(default)]
    pub budget: Budget,
    /// The methods; none means the default ones.
    #[serde(default)]
    pub methods: Vec<StringOr<MethodEntry>>,
    /// The scenes.
    pub scenes: Vec<StringOr<SceneEntry>>,
    /// Of a resolved experiment.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub record: Option<Record>,
}

/// A scene, as a manifest names it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneEntry {
    /// A .gltf, .glb or Mitsuba .xml file, a folder with one, or the name of a folder in scenes/.
    pub file: PathBuf,
    /// Its name in tables; the scene's own where there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// A camera by name or number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<String>,
    /// Values of the parameters of a Mitsuba scene; in a resolved experiment all of them.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, String>,
    /// Size of the image, `WIDTHxHEIGHT`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub film: Option<String>,
    /// Longest path in edges.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_length: Option<MaxLength>,
    /// What errors are measured against.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<ReferencePolicy>,
}

/// A method, as a manifest names it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MethodEntry {
    /// Its name in tables; what the integrator says where there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// `name:key=value:…`, of the registry or of Mitsuba.
    pub integrator: String,
    /// Further settings.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub settings: BTreeMap<String, toml::Value>,
}

impl From<String> for SceneEntry {
    fn from(file: String) -> Self {
        Self { file: file.into(), ..Self::default() }
    }
}

impl From<String> for MethodEntry {
    fn from(integrator: String) -> Self {
        Self { integrator, ..Self::default() }
    }
}

impl MethodEntry {
    /// The integrator with all its settings.
    #[must_use]
    pub fn text(&self) -> String {
        let value = |value: &toml::Value| match value {
            toml::Value::String(text) => text.clone(),
            other => other.to_string(),
        };
        let settings = self.settings.iter().map(|(key, setting)| format!(":{key}={}", value(setting)));
        std::iter::once(self.integrator.trim().to_owned()).chain(settings).collect()
    }

    /// What it is called.
    #[must_use]
    pub fn label(&self) -> String {
        self.name.clone().unwrap_or_else(|| self.text())
    }
}

/// Longest path in edges; `none` is unlimited.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "toml::Value", into = "String")]
pub struct MaxLength(pub Option<u32>);

impl std::str::FromStr for MaxLength {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match (text, text.parse()) {
            ("none", _) => Ok(Self(None)),
            (_, Ok(edges @ 1..)) => Ok(Self(Some(edges))),
            _ => Err("expected a whole number of edges from 1 on, or none for unlimited".into()),
        }
    }
}

impl TryFrom<toml::Value> for MaxLength {
    type Error = String;

    fn try_from(value: toml::Value) -> Result<Self, String> {
        value.as_str().map_or_else(|| value.to_string(), str::to_owned).parse()
    }
}

impl From<MaxLength> for String {
    fn from(length: MaxLength) -> Self {
        length.to_string()
    }
}

/// As the setting `max_length` is written.
impl Display for MaxLength {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(edges) => write!(f, "{edges}"),
            None => f.write_str("none"),
        }
    }
}

impl Manifest {
    /// Scenes and methods with the defaults of all else.
    #[must_use]
    pub fn new<S: Into<String>>(scenes: Vec<SceneEntry>, methods: impl IntoIterator<Item = S>) -> Self {
        Self {
            seeds: Self::default_seeds(),
            seed: Self::default_seed(),
            threads: 0,
            light_selection: LightSelection::default(),
            materials: None,
            max_length: None,
            reference: ReferencePolicy::default(),
            metrics: Self::default_metrics(),
            images: Self::default_images(),
            budget: Budget::default(),
            methods: methods.into_iter().map(|method| StringOr(MethodEntry::from(method.into()))).collect(),
            scenes: scenes.into_iter().map(StringOr).collect(),
            record: None,
        }
    }

    fn default_seeds() -> u32 {
        4
    }

    fn default_seed() -> u64 {
        1
    }

    fn default_metrics() -> Vec<Metric> {
        Metric::ALL.into_iter().filter(|&metric| metric != Metric::Flip).collect()
    }

    fn default_images() -> bool {
        true
    }

    /// Reads a file.
    ///
    /// # Errors
    /// Where it cannot be read or is no manifest: one line with its place, and the nearest valid name for one that is unknown.
    pub fn read(file: &Path) -> Result<Self, ExperimentError> {
        let refuse = |what: String| ExperimentError::Scene(format!("{}: {what}", file.display()));
        let text = std::fs::read_to_string(file).map_err(|error| refuse(format!("cannot be read: {error}")))?;
        Self::parse(&text).map_err(refuse)
    }

    /// From the text of a manifest.
    ///
    /// # Errors
    /// What is wrong, in one line.
    pub fn parse(text: &str) -> Result<Self, String> {
        let manifest: Self = toml::from_str(text).map_err(|error| explain(text, &error))?;
        manifest.check()?;
        Ok(manifest)
    }

    fn check(&self) -> Result<(), String> {
        if self.scenes.is_empty() {
            return Err("an experiment needs at least one scene".into());
        }
        if !(1..=super::seeds::MOST).contains(&self.seeds) {
            return Err(format!("seeds = {}: expected 1 to {}", self.seeds, super::seeds::MOST));
        }
        self.budget.check()
    }
}

/// Line and column, what is wrong, and the nearest valid name.
fn explain(text: &str, error: &toml::de::Error) -> String {
    let message = error.message().trim().replace('\n', " ");
    let mut words = message.split('`').skip(1).step_by(2);
    let unknown = message.starts_with("unknown").then(|| words.next()).flatten();
    let suggestion = unknown.map(|unknown| did_you_mean(unknown, words)).unwrap_or_default();
    let Some(span) = error.span() else { return format!("{message}{suggestion}") };
    let before = &text[..span.start.min(text.len())];
    let line = before.matches('\n').count() + 1;
    let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
    format!("line {line}, column {column}: {message}{suggestion}")
}
