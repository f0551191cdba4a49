//! From JSON to a document whose indices are known to lead somewhere.

use gltf::json;
use gltf::json::validation::{Error as Reason, Validate};
use serde::Deserialize;

use super::exact::Exact;
use super::fault::Fault;

/// Extensions that a file may require: what they can ask for is either done or refused where it is asked for.
const KNOWN_EXTENSIONS: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// Parts of the file that are never looked at, so that a mistake in them does no harm.
const IGNORED: &[&str] = &["animations", "extensionsRequired", "images", "samplers", "skins", "textures"];

/// A parsed file.
pub(super) struct Document {
    /// Structure, as the crate `gltf` sees it.
    pub root: json::Root,
    /// Numbers, extensions and extras.
    pub exact: Exact,
}

/// Just enough of a file to see whether it is one.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Head {
    asset: Option<Asset>,
    #[serde(default)]
    extensions_required: Vec<String>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Asset {
    version: String,
    min_version: Option<String>,
}

impl Document {
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, Fault> {
        check_head(bytes)?;
        let root: json::Root = serde_json::from_slice(bytes).map_err(|error| misfit(&error))?;
        check_structure(&root)?;
        let exact: Exact = serde_json::from_slice(bytes).map_err(|error| misfit(&error))?;
        Ok(Self { root, exact })
    }

    /// Extensions in use that change nothing here, though the file's author meant something by them.
    pub(super) fn ignored_extensions(&self) -> impl Iterator<Item = &str> {
        self.exact.extensions_used.iter().map(String::as_str).filter(|name| !KNOWN_EXTENSIONS.contains(name))
    }
}

fn check_head(bytes: &[u8]) -> Result<(), Fault> {
    let head: Head = serde_json::from_slice(bytes).map_err(|error| {
        if error.is_data() { misfit(&error) } else { Fault::NotGltf(format!("its JSON is broken: {error}")) }
    })?;
    let Some(asset) = head.asset else {
        return Err(Fault::NotGltf("its JSON has no `asset`".into()));
    };
    let needed = asset.min_version.unwrap_or(asset.version);
    if needed != "2.0" && !(needed.starts_with("2.") && needed.len() > 2) {
        let feature = format!("glTF files of version {needed:?}");
        return Err(Fault::unsupported("asset.version", feature, "export it as glTF 2.0"));
    }
    for (number, name) in head.extensions_required.iter().enumerate() {
        if !KNOWN_EXTENSIONS.contains(&name.as_str()) {
            let place = format!("extensionsRequired[{number}]");
            let feature = format!("files that require the extension {name}");
            return Err(Fault::unsupported(place, feature, "export the scene without it"));
        }
    }
    Ok(())
}

fn check_structure(root: &json::Root) -> Result<(), Fault> {
    // The crate's own check takes this index for granted.
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            if primitive.attributes.values().any(|accessor| accessor.value() >= root.accessors.len()) {
                let place = format!("meshes[{m}].primitives[{p}].attributes");
                return Err(Fault::invalid(place, "refers to an accessor that does not exist", EXPORT_AGAIN));
            }
        }
    }
    let mut first = None;
    root.validate(root, json::Path::new, &mut |path, reason| {
        if first.is_none() {
            let path = path();
            if matters(path.as_str(), reason) {
                first = Some((path, reason));
            }
        }
    });
    let Some((path, reason)) = first else { return Ok(()) };
    let problem = match reason {
        Reason::IndexOutOfBounds => "the index leads nowhere",
        Reason::Invalid => "the value is not allowed here",
        Reason::Missing => "is missing",
        Reason::Oversize => "the number is too large",
        Reason::Unsupported => "is not supported",
    };
    Err(Fault::invalid(path.as_str(), problem, EXPORT_AGAIN))
}

const EXPORT_AGAIN: &str = "correct the file or export it again";

/// Not everything that the specification demands is needed here.
fn matters(path: &str, reason: Reason) -> bool {
    let ignored = IGNORED.iter().any(|part| path.strip_prefix(part).is_some_and(|rest| rest.starts_with('[')));
    let positions = path.contains("\"POSITION\"") && reason == Reason::Missing;
    !(ignored || positions)
}

fn misfit(error: &serde_json::Error) -> Fault {
    let place = format!("line {} column {}", error.line(), error.column());
    let text = error.to_string();
    let problem = text.split(" at line ").next().unwrap_or(&text);
    Fault::invalid(place, problem, EXPORT_AGAIN)
}
