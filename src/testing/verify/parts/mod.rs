//! The oracle for what every sampler draws with: BSDFs, emitters and sensors.

mod bsdf;
mod counting;
mod emitter;
mod ends;
mod reversal;
mod sensor;

use glam::DVec3;

use crate::sampler::Random;
use crate::scene::EmitterId;
use crate::scene::bsdf::{Bsdf, BsdfModel};
use crate::testing::scenes;

use super::report::{Check, Report};
use super::{Effort, Stage, stages};

/// Draws of a sampler for each pass of [`Effort`].
const DRAWS: u64 = 1000;

/// Emitters of a kind that are looked at in a scene.
const EMITTERS: usize = 2;

fn draws(effort: Effort) -> u32 {
    u32::try_from(effort.passes.saturating_mul(DRAWS)).unwrap_or(u32::MAX).min(50_000_000)
}

/// Checks the local samplers of all parts of the small scenes: each draws as its density claims, and the densities of whole
/// walks are the same from both ends.
#[must_use]
pub fn verify_parts(effort: Effort) -> Report {
    let mut seen = Vec::new();
    let mut checks = Vec::new();
    for (number, stage) in (0..).zip(stages()) {
        checks.extend(of_stage(&stage, &mut seen, effort, &mut Random::new(effort.seed, number, 0)));
    }
    checks.extend(reversal::checks(effort));
    Report::new("scene parts".into(), checks)
}

/// Checks a model of scattering: samples follow its density, its Dirac lobes their probabilities, and samples say what
/// [`BsdfModel::eval`] and [`BsdfModel::density`] say, none of them anything impossible at the ends of `[0, 1)`.
#[must_use]
pub fn verify_bsdf(label: &str, model: &dyn BsdfModel, effort: Effort) -> Report {
    let random = &mut Random::new(effort.seed, 0, 0);
    let mut checks = bsdf::checks(model, label, label, draws(effort), random);
    checks.push(ends::of_bsdf(model, label, label));
    Report::new(label.into(), checks)
}

/// What was not seen in an earlier scene: they share many parts.
fn of_stage(stage: &Stage, seen: &mut Vec<String>, effort: Effort, random: &mut Random) -> Vec<Check> {
    let scene = scenes::build(&stage.scene);
    let (name, n) = (scene.name(), draws(effort));
    let mut new = |what: String| {
        let is_new = !seen.contains(&what);
        seen.push(what);
        is_new
    };
    let mut checks = Vec::new();
    for (material, model) in scene.bsdfs() {
        // All diffuse ones draw alike.
        let kind = if let Bsdf::Diffuse(_) = model { "diffuse".to_owned() } else { format!("{model:?}") };
        if new(kind) {
            checks.extend(bsdf::checks(model.as_model(), name, &format!("'{material}'"), n, random));
            checks.push(ends::of_bsdf(model.as_model(), name, &format!("'{material}'")));
        }
    }
    let ids = (0..scene.emitters().len() as u32).map(EmitterId);
    let points = [scene.sensor().position(), scene.sensor().position() + DVec3::new(0.05, -0.1, -0.2)];
    let mut kinds = Vec::new();
    for id in ids.filter(|&id| new(format!("{:?}", scene.emitter(id)))) {
        checks.push(ends::of_emitter(&scene, id, &points, name, &format!("'{}'", scene.emitter_name(id))));
        let kind = std::mem::discriminant(scene.emitter(id));
        if kinds.iter().filter(|other| **other == kind).count() >= EMITTERS {
            continue;
        }
        kinds.push(kind);
        checks.extend(emitter::checks(&scene, id, &points, name, n, random));
    }
    if scene.emitters().len() > 1 {
        checks.push(emitter::choice(&scene, name, n, random));
    }
    if new(format!("{:?}", stage.scene.sensor)) {
        checks.push(sensor::check(&scene, name, n, random));
        checks.extend(scene.surfaces().map(|surfaces| {
            let x = surfaces.sample(&scene, [0.4, 0.5, 0.6]);
            ends::of_sensor(&scene, &x, name)
        }));
    }
    checks
}
