//! Weights of long and of nearly specular paths, whose densities no floating-point number holds.

use pathspace::estimator::{Combination, Estimator, Heuristic, Recorder, Settings, driver};
use pathspace::path::Roulette;
use pathspace::sampler::Tracer;
use pathspace::scene::description::{BsdfDescription, FilmSize};
use pathspace::scene::sensor::Pixel;
use pathspace::spectrum::Rgb;
use pathspace::testing::definition::compare;
use pathspace::testing::scenes;
use pathspace_bdpt::Bidirectional;
use pathspace_path_bsdf::BsdfPathTracer;
use pathspace_walks::{Fixed, Walks};

const FILM: FilmSize = FilmSize { width: 4, height: 4 };

fn all_techniques(longest: u32) -> Combination {
    let bdpt =
        Bidirectional::new(&mut Settings::parse(&format!("max_length={longest}:roulette=off")).unwrap()).unwrap();
    Estimator::definition(&bdpt, longest).unwrap()
}

#[test]
fn weights_of_a_thousand_vertices_add_up_to_one() {
    let scene = scenes::build(&scenes::enclosure(Rgb::WHITE, Rgb::grey(0.99), FILM));
    let mut settings = Settings::parse("max_length=1000:roulette=off").unwrap();
    let estimator = BsdfPathTracer::new(&mut settings).unwrap();
    let pixel = Pixel { x: 1, y: 2 };
    let mut recorder = Recorder::default();
    let mut random = driver::random_of(&scene, 1, pixel, 0);
    estimator.sample(&mut Tracer::new(&scene), &mut random, pixel, &mut (), &mut recorder);
    let path = &recorder.terms.last().unwrap().path;
    assert_eq!(path.edges(), 1000);
    for heuristic in [
        Heuristic::Balance,
        Heuristic::Power { exponent: 2.0 },
        Heuristic::Maximum,
        Heuristic::Cutoff { threshold: 0.1 },
    ] {
        let definition = Combination { heuristic, ..all_techniques(1000) };
        let densities = definition.densities(&scene, path);
        let plain = densities.iter().filter(|p| (1e-300..1e300).contains(&p.to_f64())).count();
        assert!(plain < densities.len() / 2, "the path is no test: {plain} densities are in range");
        let total: f64 = (0..densities.len()).map(|i| definition.weight(&densities, i)).sum();
        assert!((total - 1.0).abs() < 1e-9, "{heuristic:?}: {total}");
    }
}

/// In a closed box that emits everywhere and is drawn by the cosine, the term of length k is ρ^(k−1) L_e for every sample. f(x̄)
/// falls to 1e-950 there, and to 1e+17000 in a box of a nanometre.
#[test]
fn terms_are_kept_where_f_is_beyond_every_number() {
    for scale in [1.0, 1e-9, 1e9] {
        let mut description = scenes::enclosure(Rgb::WHITE, Rgb::grey(0.99), FILM);
        description.meshes.iter_mut().flat_map(|mesh| &mut mesh.positions).for_each(|p| *p *= scale);
        if let Some(sensor) = &mut description.sensor {
            sensor.position *= scale;
        }
        let scene = scenes::build(&description);
        let sampler = Walks::shared(Fixed::Emitter(0), Roulette::Off);
        let estimator = Combination::of(vec![sampler], Heuristic::Balance, 1000);
        let pixel = Pixel { x: 1, y: 2 };
        let mut recorder = Recorder::default();
        let mut random = driver::random_of(&scene, 1, pixel, 0);
        estimator.sample(&mut Tracer::new(&scene), &mut random, pixel, &mut (), &mut recorder);
        assert_eq!(recorder.terms.len(), 1000, "scale {scale}");
        for recorded in &recorder.terms {
            let k = recorded.path.edges() as i32;
            let ratio = recorded.term.value.r / 0.99_f64.powi(k - 1);
            assert!((ratio - 1.0).abs() < 1e-11, "scale {scale}, {k} edges: off by {:e}", ratio - 1.0);
        }
        let f = scene.contribution(&recorder.terms[999].path).expect("a pixel sees it").value[0];
        assert!(f.to_normal().is_none(), "the path is no test: f = {f:?}");
    }
}

#[test]
fn nearly_specular_paths_equal_the_definition() {
    let mut description = scenes::cabinet(FILM);
    for material in &mut description.materials {
        match &mut material.bsdf {
            BsdfDescription::RoughConductor { alpha, .. } | BsdfDescription::RoughDielectric { alpha, .. } => {
                *alpha = 1e-6.into();
            }
            _ => {}
        }
    }
    let scene = scenes::build(&description);
    let bdpt = Bidirectional::new(&mut Settings::parse("max_length=6:roulette=off").unwrap()).unwrap();
    let comparison = compare(&bdpt, &all_techniques(6), &scene, 5, 200);
    assert!(comparison.terms > 10_000, "only {} terms", comparison.terms);
    assert!(comparison.partition < 1e-9, "weights add up to 1 ± {}", comparison.partition);
    // The half vector of a lobe 10⁻⁶ wide keeps about ten of its digits.
    let (weight, term) = &comparison.weight;
    let term = term.as_ref().map_or_else(String::new, ToString::to_string);
    assert!(*weight < 1e-3, "weight differs by {weight}: {term}");
}
