//! `render --replay`: the paths of one sample, for people.

use std::io::{self, Write};

use crate::estimator::Method;
use crate::film::ReplayKey;
use crate::scene::Scene;
use crate::scene::sensor::Pixel;

use super::Outcome;
use super::args::check_pixel;

/// Draws the sample again and prints its terms with their paths, in world coordinates.
pub(super) fn run(scene: &Scene, method: &Method, key: ReplayKey) -> anyhow::Result<Outcome> {
    let pixel = Pixel { x: key.pixel.0, y: key.pixel.1 };
    check_pixel(&format!("--replay {key}"), pixel, scene.sensor().film())?;
    let terms = method.integrator.replay(scene, key);
    let mut out = io::stdout().lock();
    writeln!(out, "{}, {}, sample {key}: {} terms", scene.name(), method.label, terms.len())?;
    for term in &terms {
        write!(out, "{}", term.in_world(scene))?;
    }
    out.flush()?;
    Ok(Outcome::Done)
}
