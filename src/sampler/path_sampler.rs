//! What it takes to draw light paths.

use std::fmt::Debug;
use std::ops::RangeInclusive;

use crate::path::{Path, Technique, WalkRules};
use crate::scene::Scene;
use crate::scene::sensor::Pixel;
use crate::wide::Wide;

use super::{Random, Tracer};

/// Draws whole paths and knows the density of any path, its own or another's. An integrator follows from it, alone or
/// weighted with others: [`Combination`](crate::estimator::Combination).
pub trait PathSampler: Debug + Send + Sync {
    /// Draws one sample for `pixel` and gives its paths whose number of edges lies in `lengths`: at most one of each length.
    /// Paths of different lengths may share vertices. A sampler whose samples serve all pixels ignores which pixel it is.
    /// What is given may be hidden or black; whoever takes it evaluates f(x̄).
    fn sample(
        &self,
        lengths: RangeInclusive<u32>,
        tracer: &mut Tracer<'_>,
        random: &mut Random,
        pixel: Pixel,
        give: &mut dyn FnMut(Path),
    );

    /// p(x̄), the density in area measure \[1/m²\]^(k+1) with which a sample for the path's own pixel gives x̄, where its
    /// length is asked for. Zero where it never does. Dirac distributions enter by their coefficients.
    fn density(&self, scene: &Scene, path: &Path) -> Wide;

    /// n, the number of samples that serve a pixel in one pass: one, or one for each pixel of the film.
    fn count(&self, _scene: &Scene) -> f64 {
        1.0
    }

    /// How many vertices of a path with this many edges it draws from the emitter's and from the sensor's side.
    fn technique(&self, edges: u32) -> Technique;

    /// How its walks end, where it walks.
    fn rules(&self) -> Option<WalkRules> {
        None
    }

    /// Its samples end by themselves, whatever lengths are asked for.
    fn ends(&self) -> bool {
        true
    }

    /// Which light of a scene it cannot find, in one sentence for the user; `Ok` where it finds all.
    ///
    /// # Errors
    /// One sentence.
    fn covers(&self, _scene: &Scene) -> Result<(), String> {
        Ok(())
    }
}

/// The number of samples that serve a pixel where every sample serves every pixel: width · height of the film.
#[must_use]
pub fn samples_for_all_pixels(scene: &Scene) -> f64 {
    let film = scene.sensor().film();
    f64::from(film.width) * f64::from(film.height)
}
