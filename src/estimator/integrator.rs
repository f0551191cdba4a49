//! What an integrator is, to the driver and to the command line.

use crate::film::Film;
use crate::film::ReplayKey;
use crate::sampler::{Random, Tracer};
use crate::scene::Scene;
use crate::scene::sensor::Pixel;

use super::definition::Definition;
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

    /// Why it cannot render a scene, for the user; `Ok` where it can.
    ///
    /// # Errors
    /// One sentence.
    fn supports(&self, _scene: &Scene) -> Result<(), String> {
        Ok(())
    }

    /// Its techniques with everything that their weights depend on, so that all densities of a path can be told. `None`
    /// where it is more than a set of bidirectional techniques.
    fn definition<'a>(&self, _scene: &'a Scene) -> Option<Definition<'a>> {
        None
    }
}

/// Anything that fills a film.
pub trait Integrator: Send + Sync {
    /// Renders into the film, which may hold earlier passes, until `control` says stop.
    fn render(&self, scene: &Scene, seed: u64, film: &mut Film, control: &mut dyn Control);

    /// The terms and paths of one sample.
    fn replay(&self, scene: &Scene, key: ReplayKey) -> Vec<RecordedTerm>;

    /// Why it cannot render a scene, for the user; `Ok` where it can.
    ///
    /// # Errors
    /// One sentence.
    fn supports(&self, scene: &Scene) -> Result<(), String>;

    /// See [`Estimator::definition`].
    fn definition<'a>(&self, _scene: &'a Scene) -> Option<Definition<'a>> {
        None
    }
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

    fn supports(&self, scene: &Scene) -> Result<(), String> {
        Estimator::supports(self, scene)
    }

    fn definition<'a>(&self, scene: &'a Scene) -> Option<Definition<'a>> {
        Estimator::definition(self, scene)
    }
}
