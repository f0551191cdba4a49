//! Integrators estimate the same image, whatever the scene has.

use pathspace::estimator::{Control, Estimator, Integrator, Settings};
use pathspace::film::Film;
use pathspace::report::{Agreement, AgreementSettings, Verdict};
use pathspace::scene::description::{BsdfDescription, FilmSize, SceneDescription};
use pathspace::testing::scenes;
use pathspace_bdpt::Bidirectional;
use pathspace_light::LightTracer;
use pathspace_path::PathTracer;

const FILM: FilmSize = FilmSize { width: 32, height: 24 };

struct Passes(u64);

impl Control for Passes {
    fn next_passes(&mut self, film: &Film) -> u64 {
        self.0 - film.passes()
    }
}

fn render<E: Estimator>(estimator: &E, scene: &SceneDescription, seed: u64, passes: u64) -> Film {
    let mut film = Film::new(FILM.width, FILM.height, None).unwrap();
    estimator.render(&scenes::build(scene), seed, &mut film, &mut Passes(passes));
    film
}

fn settings() -> Settings {
    Settings::parse("max_length=5").unwrap()
}

/// At significance 10⁻³ the test would have seen a difference of the whole image by `power` with probability 0.9.
fn assert_same(name: &str, a: &Film, b: &Film, power: f64) {
    let limits = AgreementSettings::default();
    let agreement = Agreement::test(a.block_statistics(), b.block_statistics(), &limits).unwrap();
    assert!(!matches!(agreement.verdict, Verdict::Differ), "{name}: {agreement}");
    let detectable = agreement.image.detectable;
    assert!(detectable < power, "{name}: would have seen {detectable} only: {agreement}");
}

/// Without Dirac lobes, behind which `path` cannot see point and directional lights.
fn roughened(mut scene: SceneDescription) -> SceneDescription {
    for material in &mut scene.materials {
        material.bsdf = match material.bsdf.clone() {
            BsdfDescription::Conductor { fresnel, .. } => BsdfDescription::rough_conductor(0.4, fresnel),
            BsdfDescription::Dielectric { interior_ior, exterior_ior, .. } => {
                BsdfDescription::rough_dielectric(0.5, interior_ior, exterior_ior)
            }
            other => other,
        };
    }
    scene
}

/// Rough glass and metals; area, point, spot, directional light and environment; thin lens and orthographic camera.
#[test]
fn path_and_bdpt_agree_everywhere() {
    for scene in [scenes::cabinet(FILM), scenes::terrace(FILM), scenes::gallery(FILM)].map(roughened) {
        let path = render(&PathTracer::new(&mut settings()).unwrap(), &scene, 1, 1200);
        let bdpt = render(&Bidirectional::new(&mut settings()).unwrap(), &scene, 2, 600);
        assert_same(&scene.name, &path, &bdpt, 0.02);
    }
}

/// Through a lens the walks from the emitters draw every path that there is, caustics seen in mirrors included.
#[test]
fn light_and_bdpt_agree_through_a_lens() {
    let scene = scenes::cabinet(FILM);
    let light = render(&LightTracer::new(&mut settings()).unwrap(), &scene, 3, 8000);
    let bdpt = render(&Bidirectional::new(&mut settings()).unwrap(), &scene, 2, 600);
    assert_same(&scene.name, &light, &bdpt, 0.05);
}
