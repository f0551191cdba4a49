//! What an integrator is, to the driver and to the command line.

use crate::film::Film;
use crate::film::ReplayKey;
use crate::sampler::{Random, Tracer};
use crate::scene::Scene;
use crate::scene::sensor::Pixel;

use super::combination::Combination;
use super::driver::{self, Control};
use super::sink::{RecordedTerm, Recorder, Sink};

/// An integrator that draws independent samples, one for each pixel and pass: what most of them are. It is written once,
/// for any [`Sink`]; [`Integrator`] follows from it.
pub trait Estimator: Send + Sync {
    /// Memory that is kept from one sample to the next.
    type Scratch: Default;

    /// Draws one sample for `pixel` and gives all its terms to the sink. Over all pixels of the film together, the terms'
    /// expectation is the image. Light walks, which serve all pixels, are one per pixel too: they ignore which.
    fn sample<S: Sink>(
        &self,
        tracer: &mut Tracer<'_>,
        random: &mut Random,
        pixel: Pixel,
        scratch: &mut Self::Scratch,
        sink: &mut S,
    );

    /// What it claims to equal, path by path, for paths of up to `longest` edges: samplers with their full densities, and
    /// how they are weighted. The checks of [`testing`](crate::testing) hold it to that.
    fn definition(&self, _longest: u32) -> Option<Combination> {
        None
    }

    /// Which light of a scene is missing in its images, for the user; `None` where they are complete.
    fn misses(&self, _scene: &Scene) -> Option<String> {
        None
    }

    /// Why it cannot render a scene, for the user; `Ok` where it can.
    ///
    /// # Errors
    /// One sentence.
    fn supports(&self, _scene: &Scene) -> Result<(), String> {
        Ok(())
    }
}

/// What an integrator promises; the checks of [`testing`](crate::testing) hold it to that and no more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Promises {
    /// The expectation of each pass is the image, and passes are uncorrelated. Without, it is at most consistent: the image is
    /// approached as the number of passes grows.
    pub unbiased: bool,
    /// Its weights lie between 0 and 1, and so no term is negative.
    pub positive: bool,
}

impl Default for Promises {
    fn default() -> Self {
        Self { unbiased: true, positive: true }
    }
}

/// Anything that fills a film.
pub trait Integrator: Send + Sync {
    /// Renders into the film, which may hold earlier passes, until `control` says stop.
    fn render(&self, scene: &Scene, seed: u64, film: &mut Film, control: &mut dyn Control);

    /// The terms and paths of one sample.
    fn replay(&self, scene: &Scene, key: ReplayKey) -> Vec<RecordedTerm>;

    /// The terms and paths of the first passes, one pass after the other: for integrators to which a pass is more than its
    /// samples one by one.
    fn replay_passes(&self, scene: &Scene, seed: u64, passes: u64, take: &mut dyn FnMut(Vec<RecordedTerm>)) {
        let size = scene.sensor().film();
        for sample in 0..passes {
            let pixels = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y)));
            take(pixels.flat_map(|pixel| self.replay(scene, ReplayKey { seed, sample, pixel })).collect());
        }
    }

    /// What it promises of its terms and its mean.
    fn promises(&self) -> Promises {
        Promises::default()
    }

    /// See [`Estimator::definition`].
    fn definition(&self, _longest: u32) -> Option<Combination> {
        None
    }

    /// See [`Estimator::misses`].
    fn misses(&self, _scene: &Scene) -> Option<String> {
        None
    }

    /// Why it cannot render a scene, for the user; `Ok` where it can.
    ///
    /// # Errors
    /// One sentence.
    fn supports(&self, scene: &Scene) -> Result<(), String>;
}

impl<E: Estimator> Integrator for E {
    fn render(&self, scene: &Scene, seed: u64, film: &mut Film, control: &mut dyn Control) {
        driver::render(self, scene, seed, film, control);
    }

    fn replay(&self, scene: &Scene, key: ReplayKey) -> Vec<RecordedTerm> {
        let pixel = Pixel { x: key.pixel.0, y: key.pixel.1 };
        let mut recorder = Recorder::default();
        let mut random = driver::random_of(scene, key.seed, pixel, key.sample);
        self.sample(&mut Tracer::new(scene), &mut random, pixel, &mut E::Scratch::default(), &mut recorder);
        recorder.terms
    }

    fn definition(&self, longest: u32) -> Option<Combination> {
        Estimator::definition(self, longest)
    }

    fn misses(&self, scene: &Scene) -> Option<String> {
        Estimator::misses(self, scene)
    }

    fn supports(&self, scene: &Scene) -> Result<(), String> {
        Estimator::supports(self, scene)
    }
}
