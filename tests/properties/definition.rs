//! Fast integrators equal the definition, path by path.

use pathspace::estimator::{Estimator, RecordedTerm, Settings};
use pathspace::scene::description::{FilmSize, Projection, SceneDescription};
use pathspace::testing::definition::compare;
use pathspace::testing::scenes;
use pathspace_bdpt::Bidirectional;
use pathspace_light::LightTracer;
use pathspace_path::PathTracer;
use pathspace_path_bsdf::BsdfPathTracer;

const FILM: FilmSize = FilmSize { width: 12, height: 9 };

fn check<E: Estimator>(scene: &SceneDescription, estimator: &E) {
    let built = scenes::build(scene);
    let definition = Estimator::definition(estimator, 8).expect("it has one");
    let comparison = compare(estimator, &definition, &built, 1, 30);
    assert!(comparison.terms > 100, "{}: only {} terms", scene.name, comparison.terms);
    let term = |term: &Option<RecordedTerm>| term.as_ref().map_or_else(String::new, ToString::to_string);
    let (value, weight) = (&comparison.value, &comparison.weight);
    assert!(value.0 < 1e-6, "{}: value differs by {}: {}", scene.name, value.0, term(&value.1));
    assert!(weight.0 < 1e-6, "{}: weight differs by {}: {}", scene.name, weight.0, term(&weight.1));
    assert!(comparison.partition < 1e-9, "{}: weights add up to 1 ± {}", scene.name, comparison.partition);
    assert_eq!(comparison.hidden, 0, "{}: edges that the walk has drawn are denied", scene.name);
}

/// The terrace seen by a window, which walks from its environment pass but which has no points of its own.
fn skylight(film: FilmSize) -> SceneDescription {
    let mut scene = scenes::terrace(film);
    scene.name = "skylight".into();
    if let Some(sensor) = &mut scene.sensor {
        sensor.projection = Projection::Window { half_width: 0.3, half_height: 0.2 };
    }
    scene
}

fn all_scenes() -> [SceneDescription; 13] {
    use scenes::{cabinet, gallery, lanterns, observatory, room, showroom, terrace, veneer};
    use scenes::{frieze, overlook, photometer, vignette};
    let makers = [
        room,
        cabinet,
        terrace,
        gallery,
        veneer,
        showroom,
        lanterns,
        observatory,
        vignette,
        frieze,
        photometer,
        overlook,
        skylight,
    ];
    makers.map(|make| make(FILM))
}

const SETTINGS: [&str; 6] = [
    "max_length=6:roulette=throughput:roulette_start=2:roulette_long=4",
    "max_length=5:roulette=local:roulette_start=1:heuristic=power",
    "max_length=7:roulette=off:heuristic=maximum",
    "max_length=4:roulette=local:heuristic=cutoff:threshold=0.3",
    "max_length=7:roulette=local:roulette_long=2",
    "max_length=5:heuristic=power:exponent=1.3",
];

fn settings(text: &str) -> Settings {
    Settings::parse(text).expect("well formed")
}

#[test]
fn path_equals_the_definition() {
    for scene in all_scenes() {
        for text in SETTINGS {
            check(&scene, &PathTracer::new(&mut settings(text)).expect("valid"));
        }
    }
}

#[test]
fn light_equals_the_definition() {
    for scene in all_scenes() {
        for text in SETTINGS {
            check(&scene, &LightTracer::new(&mut settings(text)).expect("valid"));
        }
    }
}

#[test]
fn path_bsdf_equals_the_definition() {
    for scene in all_scenes() {
        check(&scene, &BsdfPathTracer::new(&mut settings("max_length=6")).expect("valid"));
    }
}

#[test]
fn bdpt_equals_the_definition() {
    for scene in all_scenes() {
        for text in SETTINGS.iter().filter(|text| !text.contains("throughput")) {
            check(&scene, &Bidirectional::new(&mut settings(text)).expect("valid"));
        }
    }
}
