//! Optimal weights as an integrator.

use crate::film::{Counters, Film, ReplayKey};
use crate::sampler::Tracer;
use crate::scene::Scene;
use crate::scene::sensor::Pixel;

use super::super::combination::Combination;
use super::super::driver::{Control, random_of};
use super::super::integrator::{Estimator, Integrator, Promises};
use super::super::settings::{Settings, SettingsError};
use super::super::sink::{RecordedTerm, Term};
use super::learning::Alpha;
use super::share::{Share, draw_pass};
use super::weigher::{Form, Weigher};

/// A [`Combination`] whose samplers share a path by optimal weights instead of its heuristic.
///
/// It declares no definition of its own, for its weights depend on the passes before.
#[derive(Clone, Debug)]
pub struct Optimal {
    /// What is drawn; its heuristic counts for nothing.
    pub combination: Combination,
    /// Which samples the coefficients come from.
    pub form: Form,
    /// Which pixels share them.
    pub alpha: Alpha,
}

impl Optimal {
    fn add_pass(&self, scene: &Scene, key: (u64, u64), weigher: &mut Weigher) -> Counters {
        weigher.begin_pass();
        draw_pass(&self.combination, scene, key, &mut |share| weigher.add(share))
    }

    /// Of one sample, with the coefficients that apply.
    fn terms(&self, scene: &Scene, weigher: &Weigher, key: ReplayKey) -> Vec<RecordedTerm> {
        let mut terms = Vec::new();
        let pixel = Pixel { x: key.pixel.0, y: key.pixel.1 };
        let mut random = random_of(scene, key.seed, pixel, key.sample);
        self.combination.draw(&mut Tracer::new(scene), &mut random, pixel, &mut |draw| {
            let Some(share) = Share::new(&self.combination, scene, &draw) else { return };
            let value = weigher.optimal(&share);
            // w_i = (value / y) q_i, which differs by channel: that of luminance.
            let weight = value.luminance() / share.y.luminance() * share.q[share.sampler];
            let technique = self.combination.samplers[share.sampler].technique(share.edges);
            let sampler = Some(share.sampler as u32);
            let term = Term { pixel: draw.contribution.pixel, value, technique, weight, sampler };
            terms.push(RecordedTerm { term, path: draw.path });
        });
        terms
    }

    fn weigher(&self, scene: &Scene, learnt: &[f64]) -> Weigher {
        Weigher::new(&self.combination, scene, self.form, self.alpha, learnt)
    }
}

/// What `weights` asks for: `None` where a heuristic weights.
pub(in super::super) fn from_settings(settings: &mut Settings) -> Result<Option<(Form, Alpha)>, SettingsError> {
    let weights = settings.get("weights", "heuristic".to_owned(), "")?;
    let form = match weights.as_str() {
        "heuristic" => return Ok(None),
        "optimal_progressive" => Form::Progressive,
        "optimal_direct" => Form::Direct,
        _ => return Err(Settings::wrong("weights", &weights, "heuristic, optimal_progressive or optimal_direct")),
    };
    let heuristic = settings.get("heuristic", "balance".to_owned(), "")?;
    if heuristic != "balance" {
        return Err(Settings::wrong("heuristic", &heuristic, "none beside optimal weights: leave it out"));
    }
    Ok(Some((form, settings.get("alpha", Alpha::default(), "expected image or block")?)))
}

impl Integrator for Optimal {
    fn render(&self, scene: &Scene, seed: u64, film: &mut Film, control: &mut dyn Control) {
        let mut weigher = self.weigher(scene, &film.learnt);
        loop {
            let passes = control.next_passes(film);
            if passes == 0 {
                return;
            }
            for _ in 0..passes {
                let counters = self.add_pass(scene, (seed, film.passes()), &mut weigher);
                film.add_pass(weigher.end_pass()).expect("the film is the scene's");
                film.counters.merge(&counters);
            }
            film.learnt = weigher.learnt();
        }
    }

    /// Draws all passes before anew: the terms depend on what was learnt from them.
    fn replay(&self, scene: &Scene, key: ReplayKey) -> Vec<RecordedTerm> {
        let mut weigher = self.weigher(scene, &[]);
        let last = if self.form == Form::Direct { key.sample + 1 } else { key.sample };
        for sample in 0..last {
            self.add_pass(scene, (key.seed, sample), &mut weigher);
            weigher.end_pass();
        }
        if self.form == Form::Progressive {
            weigher.begin_pass();
        }
        self.terms(scene, &weigher, key)
    }

    fn replay_passes(&self, scene: &Scene, seed: u64, passes: u64, take: &mut dyn FnMut(Vec<RecordedTerm>)) {
        let mut weigher = self.weigher(scene, &[]);
        let size = scene.sensor().film();
        for sample in 0..passes {
            let pixels = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y)));
            let keys = pixels.map(|pixel| ReplayKey { seed, sample, pixel });
            let of = |weigher: &Weigher, keys: &mut dyn Iterator<Item = ReplayKey>| {
                keys.flat_map(|key| self.terms(scene, weigher, key)).collect()
            };
            match self.form {
                Form::Progressive => {
                    weigher.begin_pass();
                    take(of(&weigher, &mut keys.into_iter()));
                    self.add_pass(scene, (seed, sample), &mut weigher);
                    weigher.end_pass();
                }
                Form::Direct => {
                    self.add_pass(scene, (seed, sample), &mut weigher);
                    weigher.end_pass();
                    take(of(&weigher, &mut keys.into_iter()));
                }
            }
        }
    }

    fn promises(&self) -> Promises {
        Promises { unbiased: self.form == Form::Progressive, positive: false }
    }

    fn supports(&self, scene: &Scene) -> Result<(), String> {
        Estimator::supports(&self.combination, scene)
    }
}
