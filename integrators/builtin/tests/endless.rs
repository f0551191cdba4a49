//! Walks end where no light is ever lost, in bounded time and without bias.

use glam::DVec3;
use pathspace::estimator::{Control, Method};
use pathspace::film::Film;
use pathspace::scene::description::{BsdfDescription, FilmSize, SceneDescription};
use pathspace::spectrum::Rgb;
use pathspace::testing::scenes;
use pathspace_builtin::registry;

const FILM: FilmSize = FilmSize { width: 12, height: 12 };

struct Passes(u64);

impl Control for Passes {
    fn next_passes(&mut self, film: &Film) -> u64 {
        self.0 - film.passes()
    }
}

fn method(text: &str) -> Method {
    registry().build(text, &[]).unwrap_or_else(|error| panic!("{text}: {error}"))
}

/// Mean of the image with its standard error.
fn mean(text: &str, scene: &SceneDescription, passes: u64) -> (f64, f64) {
    let mut film = Film::new(FILM.width, FILM.height, None).expect("it has pixels");
    method(text).integrator.render(&scenes::build(scene), 5, &mut film, &mut Passes(passes));
    assert_eq!((film.counters.invalid, film.counters.negative, film.passes()), (0, 0, passes), "{text}");
    let luminance = &film.block_statistics().image()[3];
    (luminance.mean, luminance.variance_of_mean().sqrt())
}

/// A cube of smooth glass around the camera, in a constant environment of radiance one.
fn trap() -> SceneDescription {
    SceneDescription {
        materials: vec![scenes::material("glass", BsdfDescription::dielectric(1.5, 1.0), Rgb::BLACK)],
        meshes: vec![scenes::cuboid("cube", DVec3::NEG_ONE, DVec3::ONE, false, 0)],
        environment: Some(Rgb::WHITE.into()),
        sensor: Some(scenes::pinhole(DVec3::new(0.1, -0.2, 0.3), DVec3::new(0.9, 1.0, 0.8), 60.0)),
        film: Some(FILM),
        ..SceneDescription::default()
    }
}

/// The share of the image whose directions are not totally reflected by one of the cube's faces: reflection does no more
/// than change the signs of a direction's coordinates, so no other face is ever met at another angle.
fn open_share() -> f64 {
    let forward = DVec3::new(0.8, 1.2, 0.5).normalize();
    let right = forward.cross(DVec3::Y).normalize();
    let (up, half, n) = (right.cross(forward), (30.0_f64).to_radians().tan(), 2000);
    let at = |i: i32| (f64::from(i) + 0.5) / f64::from(n) * 2.0 - 1.0;
    let open = |x: f64, y: f64| {
        let direction = (forward + half * (x * right + y * up)).normalize();
        direction.abs().max_element() > (1.0 - 1.0 / (1.5 * 1.5_f64)).sqrt()
    };
    f64::from((0..n * n).map(|i| u32::from(open(at(i % n), at(i / n)))).sum::<u32>()) / f64::from(n * n)
}

/// Directions trapped in glass by total reflection are dark, all others show the environment: n² times its radiance. Within
/// 4.5 standard errors, which are at most 2 %.
#[test]
fn glass_traps_no_walk() {
    let share = open_share();
    assert!((0.2..0.8).contains(&share), "{share}");
    let expected = 1.5 * 1.5 * share;
    for text in ["path", "path_bsdf", "bdpt", "path:roulette=local", "walks:s=0"] {
        let passes = if text.starts_with("walks") { 20 } else { 50 };
        let (mean, error) = mean(&format!("{text}:max_length=none"), &trap(), passes);
        println!("{text}: {mean} ± {error}, expected {expected}");
        assert!(error < 0.02 * expected, "{text}: standard error {error}");
        assert!((mean - expected).abs() < 4.5 * error, "{text}: {mean} ± {error}, expected {expected}");
    }
}

/// In a white enclosure no light is lost: every integrator's walks end all the same.
#[test]
fn white_walls_trap_no_walk() {
    let white = scenes::enclosure(Rgb::WHITE, Rgb::WHITE, FILM);
    for text in ["path", "light", "path_bsdf", "path:roulette=local", "bdpt:roulette_long=10"] {
        mean(&format!("{text}:max_length=none"), &white, 1);
    }
}

/// Where little is lost the cap decides, from the first edges on here, and the mean is `L_e/(1 − ρ)` all the same: within
/// 4.5 standard errors, which are at most 2 %.
#[test]
fn the_cap_has_no_bias() {
    let scene = scenes::enclosure(Rgb::grey(0.1), Rgb::grey(0.9), FILM);
    for text in ["path", "path_bsdf", "light", "bdpt", "path:roulette=local"] {
        let passes = if text == "light" { 1600 } else { 400 };
        let (mean, error) = mean(&format!("{text}:max_length=none:roulette_long=5"), &scene, passes);
        println!("{text}: {mean} ± {error}");
        assert!(error < 0.02, "{text}: standard error {error}");
        assert!((mean - 1.0).abs() < 4.5 * error, "{text}: {mean} ± {error}, expected 1");
    }
}

/// Enclosure of albedo 0.999: the variance that a walk of 1000 vertices has by nature (relative variance one), not more.
#[test]
fn variance_is_finite_at_high_albedo() {
    let scene = scenes::enclosure(Rgb::grey(1e-3), Rgb::grey(0.999), FILM);
    let (mean, error) = mean("path:max_length=none", &scene, 10);
    let relative_variance = error * error * f64::from(10 * FILM.width * FILM.height);
    println!("{mean} ± {error}: relative variance {relative_variance}");
    assert!((mean - 1.0).abs() < 4.5 * error, "{mean} ± {error}, expected 1");
    assert!(relative_variance < 1.5, "{relative_variance}");
}

#[test]
fn endless_walks_are_refused() {
    for integrator in ["path", "light", "path_bsdf", "bdpt", "walks", "direct"] {
        let Err(error) = registry().build(&format!("{integrator}:roulette=off:max_length=none"), &[]) else {
            panic!("{integrator} is built")
        };
        assert!(error.to_string().contains("max_length"), "{integrator}: {error}");
    }
}
