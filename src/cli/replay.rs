//! `render --replay`: the paths of one sample, for people.

use std::io::{self, Write};

use anyhow::bail;

use crate::estimator::Method;
use crate::film::ReplayKey;
use crate::scene::Scene;

use super::{Outcome, UsageError};

/// Draws the sample again and prints its terms with their paths, in world coordinates.
pub(super) fn run(scene: &Scene, method: &Method, key: ReplayKey) -> anyhow::Result<Outcome> {
    let (size, (x, y)) = (scene.sensor().film(), key.pixel);
    if x >= size.width || y >= size.height {
        let Some(right) = size.width.checked_sub(1).zip(size.height.checked_sub(1)) else { return Ok(Outcome::Done) };
        bail!(UsageError(format!(
            "--replay {key}: pixel {x},{y} is outside the film, which ends at {},{}",
            right.0, right.1
        )));
    }
    let terms = method.integrator.replay(scene, key);
    let mut out = io::stdout().lock();
    writeln!(out, "{}, {}, sample {key}: {} terms", scene.name(), method.label, terms.len())?;
    for term in &terms {
        write!(out, "{}", term.in_world(scene))?;
    }
    out.flush()?;
    Ok(Outcome::Done)
}
