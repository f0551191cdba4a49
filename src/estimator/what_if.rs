//! What if the same samples were weighted in another way?

use std::fmt::{self, Display, Formatter};

use crate::film::{Film, FilmError};
use crate::scene::Scene;
use crate::spectrum::Rgb;

use super::combination::Combination;
use super::heuristic::Heuristic;
use super::optimal::share::{Share, draw_pass};
use super::optimal::weigher::Weigher;
use super::optimal::{Alpha, Form};

/// A way to share a path among the samplers that can draw it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Weights {
    /// By the densities alone.
    Heuristic(Heuristic),
    /// By the integrand too: see [`optimal`](super::optimal).
    Optimal(Form, Alpha),
}

impl Weights {
    /// One of each kind.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let heuristics = [
            Heuristic::Balance,
            Heuristic::Power { exponent: 2.0 },
            Heuristic::Maximum,
            Heuristic::Cutoff { threshold: 0.1 },
        ];
        let forms = [Form::Progressive, Form::Direct].into_iter();
        let optimal = forms.flat_map(|form| [Alpha::Image, Alpha::Block].map(|alpha| Self::Optimal(form, alpha)));
        heuristics.map(Self::Heuristic).into_iter().chain(optimal).collect()
    }
}

impl Display for Weights {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Heuristic(Heuristic::Balance) => write!(f, "balance"),
            Self::Heuristic(Heuristic::Power { exponent }) => write!(f, "power β={exponent}"),
            Self::Heuristic(Heuristic::Maximum) => write!(f, "maximum"),
            Self::Heuristic(Heuristic::Cutoff { threshold }) => write!(f, "cutoff α={threshold}"),
            Self::Optimal(form, alpha) => write!(f, "{form} {alpha}"),
        }
    }
}

/// The image that some weights make of the samples.
#[derive(Clone, Debug)]
pub struct Reweighted {
    /// How they were weighted.
    pub weights: Weights,
    /// What came of it.
    pub film: Film,
}

impl Reweighted {
    /// Mean luminance over the image, and its standard error over passes.
    #[must_use]
    pub fn mean(&self) -> (f64, f64) {
        let luminance = &self.film.block_statistics().image()[3];
        (luminance.mean, luminance.variance_of_mean().sqrt())
    }

    /// The variance of one pass in one pixel, `n · standard error²`, its mean over pixels and channels; NaN below two passes.
    #[must_use]
    pub fn variance(&self) -> f64 {
        let Some(error) = self.film.standard_error_image() else { return f64::NAN };
        let sum: f64 = error.pixels.iter().map(|&error| (error * error).mean()).sum();
        self.film.passes() as f64 * sum / error.pixels.len() as f64
    }
}

enum Method {
    Heuristic(Heuristic, Vec<Rgb>),
    Optimal(Box<Weigher>),
}

impl Method {
    fn begin_pass(&mut self) {
        match self {
            Self::Heuristic(_, pass) => pass.fill(Rgb::BLACK),
            Self::Optimal(weigher) => weigher.begin_pass(),
        }
    }

    fn add(&mut self, share: &Share) {
        match self {
            Self::Heuristic(heuristic, pass) => {
                let q = |j: usize| share.q[j] / share.q[share.sampler];
                let weight = heuristic.weight((0..share.sampler).map(q), (share.sampler + 1..share.q.len()).map(q));
                if weight > 0.0 {
                    pass[share.pixel] += share.y * (weight / share.q[share.sampler]);
                }
            }
            Self::Optimal(weigher) => weigher.add(share),
        }
    }

    fn end_pass(&mut self) -> &[Rgb] {
        match self {
            Self::Heuristic(_, pass) => pass,
            Self::Optimal(weigher) => weigher.end_pass(),
        }
    }
}

/// Draws passes once and weights them in all these ways: common random numbers, so that small differences show. The
/// combination's own heuristic counts for nothing.
///
/// # Errors
/// Where the film has no size that a film can have.
pub fn what_if(
    combination: &Combination,
    scene: &Scene,
    seed: u64,
    passes: u64,
    weights: &[Weights],
) -> Result<Vec<Reweighted>, FilmError> {
    let size = scene.sensor().film();
    let mut films = Vec::new();
    let mut methods = Vec::new();
    for &weights in weights {
        films.push(Reweighted { weights, film: Film::new(size.width, size.height, None)? });
        methods.push(match weights {
            Weights::Heuristic(heuristic) => {
                Method::Heuristic(heuristic, vec![Rgb::BLACK; size.width as usize * size.height as usize])
            }
            Weights::Optimal(form, alpha) => {
                Method::Optimal(Box::new(Weigher::new(combination, scene, form, alpha, &[])))
            }
        });
    }
    for sample in 0..passes {
        methods.iter_mut().for_each(Method::begin_pass);
        let counters = draw_pass(combination, scene, (seed, sample), &mut |share| {
            methods.iter_mut().for_each(|method| method.add(share));
        });
        for (reweighted, method) in films.iter_mut().zip(&mut methods) {
            reweighted.film.add_pass(method.end_pass())?;
            reweighted.film.counters.merge(&counters);
        }
    }
    Ok(films)
}
