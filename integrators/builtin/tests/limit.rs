//! Dirac events are the limit of rough ones: weights across a specular chain, and images, as α → 0.

use pathspace::estimator::{Control, Method};
use pathspace::film::{Film, ReplayKey};
use pathspace::path::{Path, VertexKind};
use pathspace::scene::Scene;
use pathspace::scene::description::{BsdfDescription, FilmSize};
use pathspace::testing::scenes;
use pathspace_builtin::registry;

const FILM: FilmSize = FilmSize { width: 16, height: 12 };
const LONGEST: u32 = 5;

fn bdpt() -> Method {
    registry().build(&format!("bdpt:max_length={LONGEST}:roulette=off"), &[]).expect("it is known")
}

/// The cabinet, its smooth glass replaced by rough glass where there is an α; and the number of that material.
fn cabinet(alpha: Option<f64>) -> (Scene, u32) {
    let mut description = scenes::cabinet(FILM);
    let smooth = |bsdf: &BsdfDescription| matches!(bsdf, BsdfDescription::Dielectric { .. });
    let glass =
        description.materials.iter().position(|material| smooth(&material.bsdf)).expect("the cabinet has glass");
    if let (Some(alpha), BsdfDescription::Dielectric { interior_ior, exterior_ior, .. }) =
        (alpha, description.materials[glass].bsdf.clone())
    {
        description.materials[glass].bsdf = BsdfDescription::rough_dielectric(alpha, interior_ior, exterior_ior);
    }
    (scenes::build(&description), glass as u32)
}

/// The same vertices, those on the material without Dirac marks; `None` where it has none.
fn roughened(path: &Path, glass: u32) -> Option<Path> {
    let on_glass =
        |i: usize| matches!(path.vertex(i).kind, VertexKind::Surface { material, .. } if material.0 == glass);
    let rough = |i: usize| path.is_dirac(i) && on_glass(i);
    let marked = (0..=path.edges()).map(|i| (*path.vertex(i), path.is_dirac(i) && !on_glass(i)));
    (0..=path.edges()).any(rough).then(|| Path::new(marked)).flatten()
}

/// The weights of all techniques for paths over smooth glass are the limit of those over rough glass: the largest
/// difference falls with α, to below 10⁻⁴ at α = 10⁻⁵. A density with one in place of the lobe's coefficient, the usual trick,
/// would leave a difference at every α.
#[test]
fn weights_converge() {
    let (smooth, glass) = cabinet(None);
    let bdpt = bdpt();
    let definition = bdpt.integrator.definition(LONGEST).expect("bdpt has one");
    let mut paths = Vec::new();
    for index in 0..FILM.width * FILM.height * 16 {
        let pixel = (index % FILM.width, index / FILM.width % FILM.height);
        let key = ReplayKey { seed: 9, sample: u64::from(index / (FILM.width * FILM.height)), pixel };
        for term in bdpt.integrator.replay(&smooth, key) {
            if let Some(rough) = roughened(&term.path, glass) {
                paths.push((term.path, rough));
            }
        }
    }
    assert!(paths.len() > 200, "only {} paths pass the glass", paths.len());
    let mut before = f64::INFINITY;
    for alpha in [1e-2, 1e-3, 1e-4, 1e-5] {
        let (scene, _) = cabinet(Some(alpha));
        let mut largest = 0.0_f64;
        for (smooth_path, rough_path) in &paths {
            let (p, q) = (definition.densities(&smooth, smooth_path), definition.densities(&scene, rough_path));
            for i in 0..p.len() {
                largest = largest.max((definition.weight(&p, i) - definition.weight(&q, i)).abs());
            }
        }
        println!("α = {alpha:.0e}: {} paths, weights differ by {largest:.1e} at most", paths.len());
        assert!(largest < before, "α = {alpha}: {largest}, before {before}");
        before = largest;
    }
    assert!(before < 1e-4, "{before}");
}

struct Passes(u64);

impl Control for Passes {
    fn next_passes(&mut self, film: &Film) -> u64 {
        self.0 - film.passes()
    }
}

/// The mean of the image with α = 10⁻⁴ is that of smooth glass: within 4.5 standard errors, which are at most 2 %.
#[test]
fn images_converge() {
    let mean = |alpha: Option<f64>, seed: u64| {
        let mut film = Film::new(FILM.width, FILM.height, None).expect("it has pixels");
        bdpt().integrator.render(&cabinet(alpha).0, seed, &mut film, &mut Passes(600));
        let luminance = film.block_statistics().image()[3];
        (luminance.mean, luminance.variance_of_mean().sqrt())
    };
    let ((smooth, e), (rough, f)) = (mean(None, 1), mean(Some(1e-4), 2));
    let error = e.hypot(f);
    println!("smooth {smooth} ± {e}, rough {rough} ± {f}");
    assert!(error < 0.02 * smooth, "standard error {error} of {smooth}");
    assert!((smooth - rough).abs() < 4.5 * error, "{smooth} and {rough} ± {error}");
}
