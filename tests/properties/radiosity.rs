//! Images of diffuse scenes against the radiosity equation, solved without random numbers.

use std::path::Path;
use std::time::Instant;

use glam::DVec3;
use pathspace::estimator::{Control, Integrator, Settings};
use pathspace::film::{Film, Moments};
use pathspace::scene::description::{FilmSize, Material, SceneDescription};
use pathspace::scene::gltf;
use pathspace::spectrum::Rgb;
use pathspace::testing::radiosity::{Bounces, DiffuseScene, Estimate, Extrapolation};
use pathspace::testing::scenes;
use pathspace_bdpt::Bidirectional;

const FILM: FilmSize = FilmSize { width: 64, height: 64 };

/// 4.2 standard errors for each of the 3 channels of 12 images: significance 10⁻³ for all of them together.
const IMAGE_Z: f64 = 4.2;
/// 5.2 standard errors for each of the 3 channels of 16 blocks of 12 images: significance 1.2 · 10⁻⁴ for all of them together.
const BLOCK_Z: f64 = 5.2;
/// A difference of so many standard errors more than what is tolerated is seen with probability 0.9.
const POWER_Z: f64 = 1.28;

struct Passes(u64);

impl Control for Passes {
    fn next_passes(&mut self, film: &Film) -> u64 {
        self.0 - film.passes()
    }
}

fn bdpt(scene: &DiffuseScene, settings: &str, seed: u64, passes: u64) -> Film {
    let estimator = Bidirectional::new(&mut Settings::parse(settings).unwrap()).unwrap();
    let mut film = Film::new(FILM.width, FILM.height, None).unwrap();
    estimator.render(scene.scene(), seed, &mut film, &mut Passes(passes));
    film
}

/// The box as measured, without what stands in it.
fn empty_cornell_box() -> SceneDescription {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell_box/scene.gltf");
    let mut scene = gltf::read(&file).unwrap();
    let before = scene.meshes.len();
    scene.meshes.retain(|mesh| !mesh.name.contains("block"));
    assert_eq!(scene.meshes.len(), before - 2);
    scene.film = Some(FILM);
    scene
}

/// Largest differences that are to be seen with probability 0.9: in the whole image, as part of its mean, and in a block,
/// as part of its own mean or the image's, whichever is larger.
struct Power {
    image: f64,
    block: f64,
}

fn compare(name: &str, film: &Film, truth: &[Estimate], power: &Power) {
    let statistics = film.block_statistics();
    let count = truth.len() as f64;
    let all = |part: fn(&Estimate) -> Rgb| truth.iter().map(part).sum::<Rgb>() / count;
    // Errors of blocks have one cause, so they add up and do not cancel.
    let image = Estimate { value: all(|e| e.value), error: all(|e| e.error) };
    let mut worst = 0.0_f64;
    for c in 0..3 {
        let mean = image.value.to_array()[c];
        let check = |what: &str, moments: &Moments, truth: &Estimate, z: f64, power: f64| {
            let (value, uncertain) = (truth.value.to_array()[c], truth.error.to_array()[c]);
            let standard_error = moments.variance_of_mean().sqrt();
            let difference = (moments.mean - value).abs();
            let what = format!(
                "{name}, {what}, channel {c}: {} ± {standard_error}, expected {value} ± {uncertain}",
                moments.mean
            );
            assert!(difference <= z * standard_error + uncertain + 1e-9 * mean, "{what}");
            let detectable = (z + POWER_Z) * standard_error + uncertain;
            assert!(detectable < power * mean.max(value), "{what}: would have seen {detectable} only");
            (difference / mean, standard_error / mean, uncertain / mean, difference / standard_error.max(1e-300))
        };
        let (difference, error, own, z) = check("image", &statistics.image()[c], &image, IMAGE_Z, power.image);
        println!(
            "{name}, channel {c}: differs by {difference:.1e}, standard error {error:.1e}, own error {own:.1e}, z {z:.1}"
        );
        assert!(difference < 2e-3, "{name}, channel {c}: differs by {difference}");
        for (i, (moments, truth)) in statistics.blocks().iter().zip(truth).enumerate() {
            let (.., own, z) = check(&format!("block {i}"), &moments[c], truth, BLOCK_Z, power.block);
            worst = worst.max(if truth.value.to_array()[c] > 0.0 { z } else { 0.0 });
            assert!(own < 3e-3, "{name}, block {i}: own error {own}");
        }
    }
    println!("{name}: worst block at z {worst:.1}");
}

/// All light, and the partial sums of few bounces.
fn check(description: &SceneDescription, edge: f64, passes: u64, power: &Power) {
    let name = &description.name;
    let start = Instant::now();
    let scene = DiffuseScene::new(description).unwrap();
    let truth = Extrapolation::new(&scene, edge).unwrap();
    println!("{name}: {} patches solved after {:.1?}", truth.fine().factors().patches().len(), start.elapsed());
    for (seed, (settings, bounces)) in [
        ("max_length=none", Bounces::Any),
        ("max_length=1", Bounces::AtMost(0)),
        ("max_length=2", Bounces::AtMost(1)),
        ("max_length=3", Bounces::AtMost(2)),
    ]
    .into_iter()
    .enumerate()
    {
        let start = Instant::now();
        let means = truth.block_means(bounces);
        let gathered = start.elapsed();
        let film = bdpt(&scene, settings, seed as u64, passes);
        println!("{name}, {settings}: {gathered:.1?} for the truth, {:.1?} with bdpt", start.elapsed());
        compare(&format!("{name}, {settings}"), &film, &means, power);
    }
}

#[test]
fn bdpt_meets_radiosity_in_the_empty_cornell_box() {
    check(&empty_cornell_box(), 0.14, 300, &Power { image: 2e-3, block: 3e-2 });
}

#[test]
fn bdpt_meets_radiosity_between_plates() {
    check(&scenes::plates(FILM), 0.2, 1000, &Power { image: 2e-3, block: 3e-2 });
}

/// A screen halfway between the plates, grey on both sides, hides parts of them from each other.
fn plates_with_a_screen() -> SceneDescription {
    let mut scene = scenes::plates(FILM);
    scene.name = "plates with a screen".into();
    scene.meshes.push(scenes::rectangle("screen", DVec3::new(0.1, 0.5, 0.3), DVec3::Z * 0.5, DVec3::X * 0.6, 2));
    let grey = scenes::diffuse("screen", Rgb::new(0.9, 0.5, 0.3), Rgb::BLACK);
    scene.materials.push(Material { two_sided: true, ..grey });
    scene
}

#[test]
fn bdpt_meets_radiosity_around_a_screen() {
    check(&plates_with_a_screen(), 0.3, 800, &Power { image: 2e-3, block: 3e-2 });
}
