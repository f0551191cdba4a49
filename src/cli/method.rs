//! From what the user calls an integrator to one that can render the scene.

use anyhow::{anyhow, bail};

use crate::estimator::{Method, Registry};
use crate::scene::Scene;

use super::UsageError;
use super::args::MaxLength;

const DEFAULT: &str = "path";

/// The integrator that `text` asks for, `path` where it does not. The longest path is the user's, or the scene's.
///
/// # Errors
/// Where there is no such integrator, lengths contradict each other, or it cannot render the scene.
pub(super) fn build(
    registry: &Registry,
    text: Option<&str>,
    max_length: Option<MaxLength>,
    scene: &Scene,
) -> anyhow::Result<Method> {
    let length = max_length.unwrap_or(MaxLength(scene.hints().max_length)).to_string();
    let method = registry.build(text.unwrap_or(DEFAULT), &[("max_length", length.clone())])?;
    let applies = method.settings.get("max_length").filter(|applies| max_length.is_some() && **applies != length);
    if let Some(applies) = applies {
        let given =
            format!("--max-length {length} contradicts max_length={applies} of the integrator; give one of them");
        bail!(UsageError(given));
    }
    let supported = method.integrator.supports(scene);
    supported.map_err(|why| anyhow!("{}: integrator {}: {why}", scene.source().display(), method.name))?;
    Ok(method)
}
