//! The oracle: is an integrator what it claims to be?
//!
//! An integrator is run on small scenes with a bit of everything, and every term that it gives is looked at: against the
//! definition of f, p and w that it declares ([`Integrator::definition`]), against its own image, against closed forms and
//! against an integrator made of bare samplers. An integrator without a definition gets the checks that need none.

mod convergence;
mod densities;
mod parts;
mod report;
mod scene;

use crate::estimator::{Integrator, Method, Registry};
use crate::scene::SceneDescription;
use crate::scene::description::FilmSize;
use crate::spectrum::Rgb;

use super::scenes;

pub(super) use convergence::TailIndex;
pub use parts::{verify_bsdf, verify_parts};
pub use report::{Check, POWER, Report, SIGNIFICANCE, Verdict};

/// How much is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Effort {
    /// Passes of the integrator over a film of 12 × 9 pixels in each scene.
    pub passes: u64,
    /// Seed of its random numbers.
    pub seed: u64,
    /// In so many scenes, from the first on: the first seven have all that an integrator may do wrong, the others all that a
    /// scene may hold.
    pub scenes: usize,
}

impl Default for Effort {
    fn default() -> Self {
        Self { passes: 300, seed: 1, scenes: usize::MAX }
    }
}

/// Paths of up to so many edges are looked at.
const LONGEST: u32 = 5;

const FILM: FilmSize = FilmSize { width: 12, height: 9 };

/// All techniques but those with long walks from both ends: made of samplers alone.
const REFERENCE: &str = "mis:samplers=walks(s=0)+walks(s=1)+walks(s=2)+walks(t=1)+walks(t=0)";

/// A scene to check in.
struct Stage {
    scene: SceneDescription,
    /// The mean luminance of its image, where there is a closed form for paths of up to [`LONGEST`] edges.
    known: Option<f64>,
}

fn stages() -> Vec<Stage> {
    let (emission, reflectance) = (Rgb::new(0.3, 0.7, 1.0), Rgb::new(0.8, 0.5, 0.2));
    let channel = |l: f64, rho: f64| l * (1.0 - libm::pow(rho, f64::from(LONGEST))) / (1.0 - rho);
    let (l, rho) = (emission.to_array(), reflectance.to_array());
    let truncated = Rgb::from([0, 1, 2].map(|c| channel(l[c], rho[c]))).luminance();
    let enclosure = Stage { scene: scenes::enclosure(emission, reflectance, FILM), known: Some(truncated) };
    use scenes::{bazaar, cabinet, gallery, lanterns, observatory, room, showroom, terrace, veneer};
    use scenes::{frieze, overlook, photometer, vignette};
    let cameras = [room, bazaar, cabinet, terrace, gallery, veneer, showroom, lanterns, observatory, vignette, frieze];
    let others = cameras.into_iter().chain([photometer, overlook]);
    std::iter::once(enclosure).chain(others.map(|make| Stage { scene: make(FILM), known: None })).collect()
}

/// Checks an integrator of the registry, with settings as the user writes them. The registry's samplers make the reference
/// image; without them that check stays open.
///
/// # Errors
/// Where the registry does not know the integrator.
pub fn verify(registry: &Registry, label: &str, effort: Effort) -> Result<Report, crate::estimator::RegistryError> {
    let defaults = [("max_length", LONGEST.to_string())];
    let method = registry.build(label, &defaults)?;
    let reference = registry.build(REFERENCE, &defaults).ok();
    Ok(verify_integrator(label, method.integrator.as_ref(), reference.as_ref(), effort))
}

/// Checks an integrator whose paths have up to 5 edges; `reference` renders the images that its are compared with.
#[must_use]
pub fn verify_integrator(
    label: &str,
    integrator: &dyn Integrator,
    reference: Option<&Method>,
    effort: Effort,
) -> Report {
    let mut checks = Vec::new();
    for stage in stages().into_iter().take(effort.scenes) {
        checks.extend(scene::check(integrator, reference.map(|r| r.integrator.as_ref()), &stage, effort));
    }
    Report::new(label.into(), checks)
}
