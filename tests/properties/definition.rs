//! Fast integrators equal the definition, path by path.

use pathspace::estimator::{Estimator, RecordedTerm, Settings};
use pathspace::path::{Roulette, Technique, WalkRules};
use pathspace::scene::description::{FilmSize, SceneDescription};
use pathspace::testing::definition::Definition;
use pathspace::testing::scenes;
use pathspace_bdpt::Bidirectional;
use pathspace_light::LightTracer;
use pathspace_path::PathTracer;
use pathspace_path_bsdf::BsdfPathTracer;

const FILM: FilmSize = FilmSize { width: 12, height: 9 };

fn check<E: Estimator>(
    scene: &SceneDescription,
    estimator: &E,
    rules: WalkRules,
    heuristic: pathspace::estimator::Heuristic,
    takes_part: fn(Technique) -> bool,
) {
    let built = scenes::build(scene);
    let definition = Definition { scene: &built, rules, heuristic, takes_part };
    let comparison = definition.compare(estimator, 1, 30);
    assert!(comparison.terms > 100, "{}: only {} terms", scene.name, comparison.terms);
    let term = |term: &Option<RecordedTerm>| term.as_ref().map_or_else(String::new, ToString::to_string);
    let (value, weight) = (&comparison.value, &comparison.weight);
    assert!(value.0 < 1e-6, "{}: value differs by {}: {}", scene.name, value.0, term(&value.1));
    assert!(weight.0 < 1e-6, "{}: weight differs by {}: {}", scene.name, weight.0, term(&weight.1));
    assert!(comparison.partition < 1e-9, "{}: weights add up to 1 ± {}", scene.name, comparison.partition);
    assert_eq!(comparison.hidden, 0, "{}: edges that the walk has drawn are denied", scene.name);
}

fn all_scenes() -> [SceneDescription; 4] {
    [scenes::room(FILM), scenes::cabinet(FILM), scenes::terrace(FILM), scenes::gallery(FILM)]
}

fn rules(roulette: Roulette) -> WalkRules {
    WalkRules { sensor: roulette, emitter: roulette }
}

const SETTINGS: [&str; 5] = [
    "max_length=6:roulette=throughput:roulette_start=2",
    "max_length=5:roulette=local:roulette_start=1:heuristic=power",
    "max_length=7:roulette=off:heuristic=maximum",
    "max_length=4:roulette=local:heuristic=cutoff:threshold=0.3",
    "max_length=5:heuristic=power:exponent=1.3",
];

fn settings(text: &str) -> Settings {
    Settings::parse(text).expect("well formed")
}

#[test]
fn path_equals_the_definition() {
    for scene in all_scenes() {
        for text in SETTINGS {
            let e = PathTracer::new(&mut settings(text)).expect("valid");
            check(&scene, &e, rules(e.roulette), e.heuristic, |technique| technique.s <= 1 && technique.t >= 2);
        }
    }
}

#[test]
fn light_equals_the_definition() {
    for scene in all_scenes() {
        for text in SETTINGS {
            let e = LightTracer::new(&mut settings(text)).expect("valid");
            check(&scene, &e, rules(e.roulette), e.heuristic, |technique| technique.t <= 1);
        }
    }
}

#[test]
fn path_bsdf_equals_the_definition() {
    for scene in all_scenes() {
        let e = BsdfPathTracer::new(&mut settings("max_length=6")).expect("valid");
        let heuristic = pathspace::estimator::Heuristic::Balance;
        check(&scene, &e, rules(e.roulette), heuristic, |technique| technique.s == 0);
    }
}

#[test]
fn bdpt_equals_the_definition() {
    for scene in all_scenes() {
        for text in SETTINGS.iter().filter(|text| !text.contains("throughput")) {
            let e = Bidirectional::new(&mut settings(text)).expect("valid");
            check(&scene, &e, rules(e.roulette), e.heuristic, |_| true);
        }
    }
}
