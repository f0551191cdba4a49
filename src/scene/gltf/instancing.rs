//! EXT_mesh_gpu_instancing: one node that draws its mesh many times.

use glam::DAffine3;
use serde_json::Value;

use super::accessor::Accessors;
use super::document::Document;
use super::fault::Fault;
use super::hierarchy::{Placed, compose, node_place};

/// The transforms to the world of each time that the node draws its mesh.
pub(super) fn transforms(
    document: &Document,
    accessors: &Accessors<'_>,
    placed: &Placed,
) -> Result<Vec<DAffine3>, Fault> {
    let Some(extension) = document.exact.nodes[placed.node].extensions.get("EXT_mesh_gpu_instancing") else {
        return Ok(vec![placed.world]);
    };
    let here = format!("{}.EXT_mesh_gpu_instancing", node_place(document, placed.node));
    let attribute = |name: &str| {
        let index = extension.get("attributes").and_then(|attributes| attributes.get(name)).map(Value::as_u64)?;
        Some(index.map_or(usize::MAX, |index| index as usize))
    };
    let translations = attribute("TRANSLATION").map(|index| accessors.vectors::<3>(index, &here)).transpose()?;
    let rotations = attribute("ROTATION").map(|index| accessors.vectors::<4>(index, &here)).transpose()?;
    let scales = attribute("SCALE").map(|index| accessors.vectors::<3>(index, &here)).transpose()?;
    let lengths =
        [translations.as_ref().map(Vec::len), rotations.as_ref().map(Vec::len), scales.as_ref().map(Vec::len)];
    let count = lengths.iter().flatten().copied().next().unwrap_or(0);
    if lengths.iter().flatten().any(|&length| length != count) {
        return Err(Fault::invalid(here, "its attributes differ in length", "correct the file or export it again"));
    }
    let of_instance = |i: usize| {
        let translation = translations.as_ref().map_or([0.0; 3], |all| all[i]);
        let rotation = rotations.as_ref().map_or([0.0, 0.0, 0.0, 1.0], |all| all[i]);
        let scale = scales.as_ref().map_or([1.0; 3], |all| all[i]);
        Ok(placed.world * compose(translation, rotation, scale, &here)?)
    };
    (0..count).map(of_instance).collect()
}
