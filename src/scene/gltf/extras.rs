//! The object `pathspace` in `extras`: what glTF itself cannot say.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::fault::Fault;
use crate::scene::description::{BsdfDescription, FilmSize, Lens, Reference, RenderHints};
use crate::spectrum::Rgb;

/// `scenes[i].extras.pathspace`.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct SceneExtras {
    pub environment: Option<Rgb>,
    pub film: Option<FilmSize>,
    pub render: Option<RenderHints>,
    pub reference: Option<Reference>,
    /// By name.
    pub sensors: BTreeMap<String, Value>,
}

/// `nodes[i].extras.pathspace`.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct NodeExtras {
    pub sphere: Option<SphereExtras>,
}

/// An analytic sphere around the node's origin.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SphereExtras {
    pub radius: f64,
    /// Index or name; without it, the material of the node's mesh.
    pub material: Option<Value>,
}

/// `materials[i].extras.pathspace`; each key replaces what glTF says.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct MaterialExtras {
    pub bsdf: Option<BsdfDescription>,
    pub emission: Option<Rgb>,
    pub two_sided: Option<bool>,
}

/// `cameras[i].extras.pathspace`.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct CameraExtras {
    pub lens: Option<Lens>,
    pub film: Option<FilmSize>,
}

/// Reads our part of an object's extras; its default where there is none.
pub(super) fn read<T: DeserializeOwned + Default>(extras: Option<&Value>, owner: &str) -> Result<T, Fault> {
    let Some(ours) = extras.and_then(|extras| extras.get("pathspace")) else {
        return Ok(T::default());
    };
    let place = format!("{owner}.extras.pathspace");
    if !ours.is_object() {
        return Err(Fault::invalid(place, "is no object", "scenes/README.md says what can stand here"));
    }
    T::deserialize(ours).map_err(|error| explain(&error.to_string(), &place))
}

/// Turns serde's message into one that names the nearest valid word.
fn explain(message: &str, place: &str) -> Fault {
    if message.contains("ConductorFresnel") {
        let remedy = "give it `eta` and `k`, or `specular_tint`, each three numbers";
        return Fault::invalid(place, "`fresnel` is not understood", remedy);
    }
    let mut words = message.split('`').skip(1).step_by(2);
    let unknown = message.starts_with("unknown").then(|| words.next()).flatten();
    let Some(unknown) = unknown else {
        return Fault::invalid(place, message, "scenes/README.md says what can stand here");
    };
    let valid: Vec<&str> = words.collect();
    let remedy = match nearest(unknown, valid.iter().copied()) {
        Some(nearest) => format!("did you mean `{nearest}`? Known here: {}", valid.join(", ")),
        None => "remove it".into(),
    };
    Fault::invalid(place, format!("`{unknown}` is unknown"), remedy)
}

/// The candidate that looks most like `word`.
pub(super) fn nearest<'a>(word: &str, candidates: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    candidates.max_by(|a, b| strsim::jaro_winkler(word, a).total_cmp(&strsim::jaro_winkler(word, b)))
}
