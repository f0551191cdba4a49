//! Samples whose random numbers are 0 or the largest below one are as right as all others.

use std::sync::Arc;

use glam::DVec3;
use pathspace::estimator::{Combination, Estimator, RecordedTerm, Settings};
use pathspace::path::Vertex;
use pathspace::sampler::PathSampler;
use pathspace::scene::Scene;
use pathspace::scene::description::FilmSize;
use pathspace::testing::definition::Comparison;
use pathspace::testing::{ends, scenes};
use pathspace_bdpt::Bidirectional;
use pathspace_direct::Direct;
use pathspace_light::LightTracer;
use pathspace_path::PathTracer;
use pathspace_path_bsdf::BsdfPathTracer;
use pathspace_walks::Walks;

const FILM: FilmSize = FilmSize { width: 12, height: 9 };

fn all_scenes() -> impl Iterator<Item = Scene> {
    use pathspace::testing::scenes::{
        bazaar, cabinet, gallery, lanterns, observatory, room, showroom, terrace, veneer,
    };
    use pathspace::testing::scenes::{frieze, overlook, photometer, vignette};
    let cameras = [room, bazaar, cabinet, terrace, gallery, veneer, showroom, lanterns, observatory, vignette, frieze];
    cameras.into_iter().chain([photometer, overlook]).map(|make| scenes::build(&make(FILM)))
}

/// Its density can be told from its vertices: u = 0 gives directions of cos 1.5e-8, along which an edge in a corner or
/// around the inside of a curve may be off its surface by no more than vertices are rounded.
fn is_exact(term: &RecordedTerm) -> bool {
    term.path.vertices().windows(2).all(|pair| {
        let offset = pair[1].position - pair[0].position;
        let height = |vertex: &Vertex| if vertex.normal == DVec3::ZERO { 1.0 } else { vertex.normal.dot(offset).abs() };
        height(&pair[0]).min(height(&pair[1])) > 1e-8
    })
}

fn check<E: Estimator>(what: &str, estimator: &E, passes: u64) {
    for scene in all_scenes() {
        if estimator.supports(&scene).is_err() {
            continue;
        }
        let definition = estimator.definition(8).expect("it has one");
        let (mut terms, mut drawable) = (0_usize, 0_usize);
        let (mut value, mut weight, mut partition) = (0.0_f64, 0.0_f64, 0.0_f64);
        ends::sample(estimator, &scene, 1, passes, |term| {
            if let Some(fault) = ends::fault(&term) {
                panic!("{what} in {}: {fault}: {term}", scene.name());
            }
            if is_exact(&term) {
                let mut one = Comparison::default();
                drawable += usize::from(one.add(&definition, &scene, &term).is_some());
                terms += 1;
                value = value.max(if one.value.0.is_finite() { one.value.0 } else { 0.0 });
                weight = weight.max(one.weight.0);
                partition = partition.max(one.partition);
            }
        });
        let name = scene.name();
        println!("{what} in {name}: {drawable} of {terms} terms, {value:.1e} {weight:.1e} {partition:.1e}");
        assert!(terms > 50, "{what} in {name}: {terms} terms");
        assert!(value < 1e-6 && weight < 1e-6, "{what} in {name}: value {value}, weight {weight}");
        assert!(partition < 1e-9, "{what} in {name}: {partition}");
        // Where a microfacet stands upright, its side and so the whole lobe is a matter of rounding.
        assert!(terms - drawable <= 1 + terms / 1000, "{what} in {name}: {drawable} of {terms}");
    }
}

fn settings(text: &str) -> Settings {
    Settings::parse(text).unwrap()
}

#[test]
fn of_integrators() {
    check("path", &PathTracer::new(&mut settings("max_length=6")).unwrap(), 40);
    check("light", &LightTracer::new(&mut settings("max_length=6")).unwrap(), 40);
    check("path_bsdf", &BsdfPathTracer::new(&mut settings("max_length=6")).unwrap(), 40);
    check("bdpt", &Bidirectional::new(&mut settings("max_length=6")).unwrap(), 20);
}

#[test]
fn of_samplers() {
    let combination = |samplers: Vec<Arc<dyn PathSampler>>| {
        Combination::new(samplers, &mut settings("max_length=4:terms=up_to")).unwrap()
    };
    let walks = |text: &str| -> Arc<dyn PathSampler> { Arc::new(Walks::new(&mut settings(text)).unwrap()) };
    check("walks", &combination(["s=0", "s=1", "s=2", "t=1", "t=0"].map(walks).into()), 10);
    for by in ["hemisphere", "cosine", "bsdf", "emitters", "surfaces"] {
        let direct = Direct::new(&mut settings(&format!("by={by}"))).unwrap();
        check(by, &combination(vec![Arc::new(direct), walks("s=1")]), 10);
    }
}
