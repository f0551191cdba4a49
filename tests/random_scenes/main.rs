//! Properties that hold in any scene, looked for in random ones. `PROPTEST_CASES` sets how many, `PROPTEST_SEED` which.
#![allow(clippy::unwrap_used)]

mod condition;
mod strategies;

use std::sync::LazyLock;

use pathspace::estimator::{Control, Estimator, Integrator, RecordedTerm, Settings};
use pathspace::film::Film;
use pathspace::sampler::Random;
use pathspace::scene::bsdf::{Bsdf, LobeDensity, Side};
use pathspace::scene::description::SceneDescription;
use pathspace::scene::{Scene, SceneOptions};
use pathspace::testing::definition::{Comparison, replay_all};
use pathspace::testing::ends;
use pathspace_bdpt::Bidirectional;
use pathspace_light::LightTracer;
use pathspace_path::PathTracer;
use pathspace_path_bsdf::BsdfPathTracer;
use proptest::prelude::*;
use proptest::test_runner::{RngAlgorithm, RngSeed};
use rayon::{ThreadPool, ThreadPoolBuilder};

use strategies::{FILM, any_direction, plain_bsdf, scene};

/// Cases without `PROPTEST_CASES`: some seconds.
const CASES: u32 = 100;

fn config(factor: u32) -> ProptestConfig {
    let number = |name: &str| std::env::var(name).ok().and_then(|number| number.parse::<u32>().ok());
    ProptestConfig {
        cases: factor * number("PROPTEST_CASES").unwrap_or(CASES),
        failure_persistence: None,
        rng_algorithm: RngAlgorithm::ChaCha,
        rng_seed: RngSeed::Fixed(number("PROPTEST_SEED").unwrap_or(6).into()),
        max_shrink_iters: 300,
        max_global_rejects: 1_000_000,
        ..ProptestConfig::default()
    }
}

struct Passes(u64);

impl Control for Passes {
    fn next_passes(&mut self, film: &Film) -> u64 {
        self.0 - film.passes()
    }
}

/// Differences below this are rounding in any case.
const TOLERANCE: f64 = 1e-6;

/// First faults of the terms of an integrator, whose random numbers are ordinary ones and then some of the ends of `[0, 1)`.
fn faults<E: Estimator>(name: &str, integrator: &E, scene: &Scene, description: &SceneDescription) -> Option<String> {
    if integrator.supports(scene).is_err() {
        return None;
    }
    let definition = Estimator::definition(integrator, 5).unwrap();
    let mut found = None;
    let mut look = |term: RecordedTerm, ordinary: bool| {
        if found.is_some() {
            return;
        }
        let fault = ends::fault(&term)
            .or_else(|| disagreement(&definition, scene, description, &term, ordinary))
            .or_else(|| ordinary.then(|| hidden(scene, &term)).flatten());
        found = fault.map(|fault| format!("{name}: {fault}: {term}"));
    };
    replay_all(integrator, scene, 1, 2).for_each(|term| look(term, true));
    // The ends put points on edges between triangles, where rounding decides on which side they are.
    ends::sample(integrator, scene, 1, 1, |term| look(term, false));
    found
}

fn disagreement(
    definition: &pathspace::estimator::Combination,
    scene: &Scene,
    description: &SceneDescription,
    term: &RecordedTerm,
    ordinary: bool,
) -> Option<String> {
    let seen_by = scene.contribution(&term.path).map(|contribution| contribution.pixel);
    if seen_by != Some(term.term.pixel) && condition::rounds_beyond_pixels(description) {
        return None;
    }
    let mut comparison = Comparison::default();
    let densities = comparison.add(definition, scene, term);
    let allowed = TOLERANCE.max(condition::relative_error(scene, description, term));
    let Comparison { value: (value, _), weight: (weight, _), partition, .. } = comparison;
    if partition.is_nan() || partition > 1e-9 {
        return Some(format!("weights add up to 1 ± {partition:.1e}"));
    }
    let Some((_, densities)) = densities else {
        // Rounding may put a vertex in a corner behind the surface of the one before, and at the ends decides on which side of
        // the surface an upright microfacet is.
        return (ordinary && allowed < 1e-2).then(|| "no technique draws it".into());
    };
    if densities.iter().any(|density| !(density.parts().0.is_finite() && density.parts().0 >= 0.0)) {
        return Some(format!("densities {densities:?}"));
    }
    let differs = weight > allowed || value > allowed;
    differs.then(|| format!("value differs by {value:.1e}, weight by {weight:.1e}, allowed {allowed:.1e}"))
}

/// Edges that were drawn are visible from both ends, and any two vertices of the path alike from each other.
fn hidden(scene: &Scene, term: &RecordedTerm) -> Option<String> {
    let vertices = term.path.vertices();
    let all = (0..vertices.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let asymmetric = |&(i, j): &(usize, usize)| {
        scene.visible(&vertices[i], &vertices[j]) != scene.visible(&vertices[j], &vertices[i])
    };
    if let Some(pair) = all.clone().find(asymmetric) {
        return Some(format!("vertices {pair:?} see each other from one side"));
    }
    let denied = vertices.windows(2).position(|pair| !scene.visible(&pair[0], &pair[1]));
    denied.map(|i| format!("edge {i} is denied"))
}

fn settings(text: &str) -> Settings {
    Settings::parse(text).unwrap()
}

/// The same bits on 1, 2 and 16 threads.
fn depends_on_threads(integrator: &dyn Integrator, scene: &Scene) -> bool {
    static POOLS: LazyLock<[ThreadPool; 3]> =
        LazyLock::new(|| [1, 2, 16].map(|threads| ThreadPoolBuilder::new().num_threads(threads).build().unwrap()));
    let images = POOLS.each_ref().map(|pool| {
        let mut film = Film::new(FILM.width, FILM.height, None).unwrap();
        pool.install(|| integrator.render(scene, 3, &mut film, &mut Passes(2)));
        film.mean_image().pixels.into_iter().flat_map(|p| p.to_array().map(f64::to_bits)).collect::<Vec<_>>()
    });
    images[0] != images[1] || images[0] != images[2]
}

proptest! {
    #![proptest_config(config(1))]

    /// Terms are numbers, not negative, with weights that add up to one over all techniques; they equal the definition as far
    /// as rounding lets them; what is drawn is visible from both ends; and threads change no bit.
    #[test]
    fn integrators_are_right_in_random_scenes(description in scene(), heuristic in 0..4_usize, roulette in 0..3_usize) {
        let built = Scene::build(&description, SceneOptions::default());
        prop_assume!(built.is_ok());
        let (scene, _) = built.unwrap();
        let heuristic = ["balance", "power", "power:exponent=7", "maximum"][heuristic];
        let roulette = ["local:roulette_start=1", "off", "fixed:survival=0.8:roulette_start=2"][roulette];
        let text = format!("max_length=5:heuristic={heuristic}:roulette={roulette}");
        let path = PathTracer::new(&mut settings(&text.replace("local", "throughput"))).unwrap();
        let bdpt = Bidirectional::new(&mut settings(&text)).unwrap();
        let light = LightTracer::new(&mut settings(&text)).unwrap();
        let path_bsdf = BsdfPathTracer::new(&mut settings("max_length=5")).unwrap();
        let fault = faults("path", &path, &scene, &description)
            .or_else(|| faults("light", &light, &scene, &description))
            .or_else(|| faults("bdpt", &bdpt, &scene, &description))
            .or_else(|| faults("path_bsdf", &path_bsdf, &scene, &description));
        prop_assert!(fault.is_none(), "{text}: {}", fault.unwrap());
        for integrator in [&path as &dyn Integrator, &light, &bdpt] {
            prop_assert!(!depends_on_threads(integrator, &scene), "{text}: threads differ");
        }
    }
}

/// The share of the flux from `from` that goes on, with a bound of its standard error; by draws one in each cell.
fn albedo(bsdf: &Bsdf, from: glam::DVec3, side: Side) -> (f64, f64) {
    const CELLS: [u32; 3] = [16, 16, 4];
    let n = CELLS.iter().product::<u32>();
    let (mut sum, mut squares) = (0.0, 0.0);
    for sample in 0..n {
        let cell = [sample % 16, sample / 16 % 16, sample / 256];
        let jitter = Random::new(9, 0, sample.into()).uniform3();
        let u = std::array::from_fn(|i| (f64::from(cell[i]) + jitter[i]) / f64::from(CELLS[i]));
        let Some(drawn) = weight_of_one(bsdf, side, from, u) else { continue };
        sum += drawn;
        squares += drawn * drawn;
    }
    let mean = sum / f64::from(n);
    (mean, ((squares / f64::from(n) - mean * mean).max(0.0) / f64::from(n)).sqrt())
}

/// `f |cos θ| / p` without the radiance's η².
fn weight_of_one(bsdf: &Bsdf, side: Side, from: glam::DVec3, u: [f64; 3]) -> Option<f64> {
    let sample = bsdf.sample(side, from, u)?;
    let (to_emitter, to_sensor) = side.by_role(from, sample.to);
    let weight = match sample.density {
        LobeDensity::Finite(density) => sample.value * (sample.to.z.abs() / density.value()),
        LobeDensity::Dirac(density) => sample.value / density.value(),
    };
    let scale = if side == Side::Sensor { bsdf.radiance_scale(to_emitter, to_sensor) } else { 1.0 };
    Some(weight.max_component() / scale)
}

proptest! {
    #![proptest_config(config(10))]

    /// `f(a → b) = (η_b/η_a)² f(b → a)` to 1e-9 and more where directions are rounded, and no model makes energy: the mean weight
    /// of 1024 draws is at most one within 5 standard errors and the 0.005 by which losses at grazing angles are missed.
    #[test]
    fn models_are_reciprocal_and_make_no_energy(
        description in plain_bsdf(),
        a in any_direction(),
        b in any_direction(),
        emitter in any::<bool>(),
    ) {
        let bsdf = Bsdf::new(&description);
        prop_assume!(bsdf.is_ok());
        let bsdf = bsdf.unwrap();
        let (there, back) = (bsdf.eval(a, b), bsdf.eval(b, a) * bsdf.radiance_scale(a, b));
        let (x, y) = (there.max_component(), back.max_component());
        let allowed = 1e-9_f64.max(condition::of_bsdf(&description) * 1e-13 / a.z.abs().min(b.z.abs()));
        prop_assert!((x - y).abs() <= allowed * x.max(y), "f(a, b) = {x:e}, back {y:e}");
        let (mean, error) = albedo(&bsdf, a, if emitter { Side::Emitter } else { Side::Sensor });
        prop_assert!(mean <= 1.005 + 5.0 * error, "albedo {mean} ± {error} from {a}");
    }
}
