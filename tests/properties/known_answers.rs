//! Images with a closed form.

use pathspace::estimator::{Control, Estimator, Integrator, Settings};
use pathspace::film::Film;
use pathspace::scene::Scene;
use pathspace::scene::description::FilmSize;
use pathspace::spectrum::Rgb;
use pathspace::testing::scenes;
use pathspace_bdpt::Bidirectional;
use pathspace_light::LightTracer;
use pathspace_path::PathTracer;
use pathspace_path_bsdf::BsdfPathTracer;

pub(crate) struct Passes(pub u64);

impl Control for Passes {
    fn next_passes(&mut self, film: &Film) -> u64 {
        self.0 - film.passes()
    }
}

fn render<E: Estimator>(estimator: &E, scene: &Scene, passes: u64) -> Film {
    let size = scene.sensor().film();
    let mut film = Film::new(size.width, size.height, None).expect("a film with pixels");
    estimator.render(scene, 7, &mut film, &mut Passes(passes));
    film
}

/// Mean over the image and its standard error, of one channel.
fn mean_and_error(film: &Film) -> (f64, f64) {
    let mean = film.mean_image().mean().g;
    let error = film.standard_error_image().expect("two passes");
    let variance: f64 = error.pixels.iter().map(|e| e.g * e.g).sum();
    (mean, variance.sqrt() / error.pixels.len() as f64)
}

/// Within 4 standard errors of the closed form, which are at most 0.1 % of it: a bias of 0.8 % would be seen always, one of
/// 0.4 % with probability one half at the least.
fn check<E: Estimator>(name: &str, estimator: &E, max_length: Option<i32>, passes: u64) {
    let (emission, reflectance) = (Rgb::new(0.3, 0.7, 1.0), Rgb::new(0.8, 0.5, 0.2));
    let scene = scenes::build(&scenes::enclosure(emission, reflectance, FilmSize { width: 32, height: 32 }));
    let film = render(estimator, &scene, passes);
    let (mean, error) = mean_and_error(&film);
    let tail = max_length.map_or(0.0, |n| reflectance.g.powi(n));
    let expected = emission.g * (1.0 - tail) / (1.0 - reflectance.g);
    assert!(error / expected < 1e-3, "{name}: standard error {error} of {expected}");
    assert!((mean - expected).abs() < 4.0 * error + 1e-12 * expected, "{name}: {mean} ± {error}, expected {expected}");
}

const LENGTHS: [(&str, Option<i32>); 3] =
    [("max_length=none", None), ("max_length=3", Some(3)), ("max_length=1", Some(1))];

fn settings(text: &str) -> Settings {
    Settings::parse(text).unwrap()
}

#[test]
fn path_meets_the_enclosure() {
    for (text, max_length) in LENGTHS {
        check("path", &PathTracer::new(&mut settings(text)).unwrap(), max_length, 200);
        check("path_bsdf", &BsdfPathTracer::new(&mut settings(text)).unwrap(), max_length, 200);
    }
}

#[test]
fn bdpt_meets_the_enclosure() {
    for (text, max_length) in LENGTHS {
        check("bdpt", &Bidirectional::new(&mut settings(text)).unwrap(), max_length, 400);
    }
}

#[test]
fn light_meets_the_enclosure() {
    for (text, max_length) in LENGTHS {
        check("light", &LightTracer::new(&mut settings(text)).unwrap(), max_length, 4000);
    }
}
