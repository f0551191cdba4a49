//! Images per path length and per technique, from every integrator of the registry.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use pathspace::estimator::{Control, Method};
use pathspace::film::{Film, Image, Layer, LayerSelection, Layers, Tally};
use pathspace::path::Technique;
use pathspace::scene::Scene;
use pathspace::scene::description::FilmSize;
use pathspace::spectrum::Rgb;
use pathspace::testing::scenes;

const BOTH: LayerSelection = LayerSelection { length: true, technique: true };

struct Passes(u64);

impl Control for Passes {
    fn next_passes(&mut self, film: &Film) -> u64 {
        self.0 - film.passes()
    }
}

fn all_methods(settings: &str) -> Vec<Method> {
    let registry = pathspace_builtin::registry();
    let text = |name: &str| if settings.is_empty() { name.to_owned() } else { format!("{name}:{settings}") };
    registry.entries().iter().map(|entry| registry.build(&text(entry.name), &[]).unwrap()).collect()
}

fn method(text: &str) -> Method {
    pathspace_builtin::registry().build(text, &[]).unwrap()
}

fn render(method: &Method, scene: &Scene, passes: u64, limit: Option<u64>) -> Film {
    let size = scene.sensor().film();
    let mut film = Film::new(size.width, size.height, None).unwrap();
    if let Some(limit) = limit {
        film.keep_layers(BOTH, limit).unwrap();
    }
    method.integrator.render(scene, 11, &mut film, &mut Passes(passes));
    film
}

fn with_layers(method: &Method, scene: &Scene, passes: u64) -> Film {
    render(method, scene, passes, Some(1 << 30))
}

/// The sum of the layers that `wanted` picks, and how many they are.
fn sum(layers: &Layers, wanted: impl Fn(&Layer) -> bool) -> (Image, usize) {
    let picked: Vec<Layer> = layers.layers().into_iter().filter(wanted).collect();
    let mut total = layers.mean_image(Layer::Length { edges: u32::MAX });
    assert!(total.pixels.iter().all(|pixel| pixel.is_black()), "a layer that nothing has reached is black");
    for &layer in &picked {
        for (total, pixel) in total.pixels.iter_mut().zip(layers.mean_image(layer).pixels) {
            *total += pixel;
        }
    }
    (total, picked.len())
}

/// Equal within the rounding of sums of positive numbers.
fn assert_equal(what: &str, a: &Image, b: &Image) {
    assert!(a.mean().min_component() > 0.0, "{what}: black");
    for (a, b) in a.pixels.iter().zip(&b.pixels) {
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-13 * a.abs();
        assert!(close(a.r, b.r) && close(a.g, b.g) && close(a.b, b.b), "{what}: {a:?} {b:?}");
    }
}

#[test]
fn lengths_sum_to_the_image_and_weighted_techniques_to_the_lengths() {
    let film = FilmSize { width: 12, height: 9 };
    let all =
        [scenes::room(film), scenes::cabinet(film), scenes::terrace(film), scenes::gallery(film), scenes::veneer(film)];
    for method in all_methods("max_length=5").into_iter().chain([method("bdpt:max_length=4:heuristic=maximum")]) {
        for description in &all {
            let scene = scenes::build(description);
            let what = format!("{}, {}", description.name, method.label);
            assert_eq!(method.integrator.supports(&scene), Ok(()), "{what}");
            let film = with_layers(&method, &scene, 20);
            let layers = film.layers().unwrap();
            let (lengths, count) = sum(layers, |layer| matches!(layer, Layer::Length { .. }));
            assert!(count >= 3, "{what}: {count} lengths");
            assert_equal(&what, &film.mean_image(), &lengths);
            let (techniques, count) = sum(layers, |layer| matches!(layer, Layer::Weighted(_)));
            assert!(count >= 4, "{what}: {count} techniques");
            assert_equal(&what, &film.mean_image(), &techniques);
            for edges in
                [1, 2, 5].into_iter().filter(|edges| layers.layers().contains(&Layer::Length { edges: *edges }))
            {
                let of_length = layers.mean_image(Layer::Length { edges });
                if of_length.mean().min_component() > 0.0 {
                    let among = |layer: &Layer| matches!(layer, Layer::Weighted(t) if t.edges() == edges);
                    assert_equal(&format!("{what}, {edges} edges"), &of_length, &sum(layers, among).0);
                }
            }
            let tallied: f64 =
                layers.tallies().map(|(_, tally)| tally).chain([layers.without_terms()]).map(|t| t.rays).sum();
            assert!((tallied / film.counters.rays as f64 - 1.0).abs() < 1e-9, "{what}: {tallied} rays");
        }
    }
}

#[test]
fn the_image_has_the_same_bits_with_and_without_layers() {
    let scene = scenes::build(&scenes::cabinet(FilmSize { width: 40, height: 30 }));
    for method in all_methods("") {
        let (without, with) = (render(&method, &scene, 3, None), with_layers(&method, &scene, 3));
        assert_eq!(without.mean_image(), with.mean_image(), "{}", method.label);
        assert_eq!(without.counters, with.counters, "{}", method.label);
    }
}

/// L_k = L_e ρ^k in the enclosure, each within 4 standard errors of the mean over the image, at significance 10⁻⁴ per length.
/// These are below 1 % of it, so a bias of 5.3 % in a single length would be seen with probability 0.9.
#[test]
fn each_length_meets_the_enclosure() {
    let (emission, reflectance) = (Rgb::new(0.3, 0.7, 1.0), Rgb::new(0.8, 0.5, 0.2));
    let scene = scenes::build(&scenes::enclosure(emission, reflectance, FilmSize { width: 24, height: 24 }));
    for method in all_methods("max_length=4") {
        let film = with_layers(&method, &scene, if method.name == "light" { 1200 } else { 200 });
        let layers = film.layers().unwrap();
        for edges in 1..=4 {
            let layer = Layer::Length { edges };
            let mean = layers.mean_image(layer).mean().g;
            let errors = layers.standard_error_image(layer).unwrap().pixels;
            let error = errors.iter().map(|e| e.g * e.g).sum::<f64>().sqrt() / errors.len() as f64;
            let expected = emission.g * reflectance.g.powi(edges as i32 - 1);
            let what = format!("{}, {layer}: {mean} ± {error}, expected {expected}", method.label);
            assert!(error < 0.01 * expected, "{what}");
            assert!((mean - expected).abs() < 4.0 * error + 1e-12, "{what}");
        }
    }
}

/// Unweighted, s = 0 multiplies L_e by ρ at each scattering and has no variance at all, in any pixel.
#[test]
fn the_technique_without_light_sampling_is_exact_in_the_enclosure_once_its_weight_is_gone() {
    let (emission, reflectance) = (Rgb::new(0.3, 0.7, 1.0), Rgb::new(0.8, 0.5, 0.2));
    let scene = scenes::build(&scenes::enclosure(emission, reflectance, FilmSize { width: 12, height: 9 }));
    for text in ["path:roulette=off", "bdpt:roulette=off", "path_bsdf:roulette=off"] {
        let film = with_layers(&method(&format!("{text}:max_length=4")), &scene, 4);
        let layers = film.layers().unwrap();
        for edges in 1..=4 {
            let technique = Technique { s: 0, t: edges + 1 };
            let expected = emission.g * reflectance.g.powi(edges as i32 - 1);
            for pixel in layers.mean_image(Layer::Unweighted(technique)).pixels {
                assert!((pixel.g / expected - 1.0).abs() < 1e-9, "{text}, {technique}: {} {expected}", pixel.g);
            }
        }
        let weighted = layers.mean_image(Layer::Weighted(Technique { s: 0, t: 3 })).mean().g;
        let alone = text.starts_with("path_bsdf");
        assert!(alone || weighted < 0.9 * emission.g * reflectance.g, "{text}: the weight is not gone: {weighted}");
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let scene = scenes::build(&scenes::cabinet(FilmSize { width: 70, height: 40 }));
    for method in all_methods("max_length=6") {
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| with_layers(&method, &scene, 3))
        };
        let (one, three) = (on(1), on(3));
        let (one, three) = (one.layers().unwrap(), three.layers().unwrap());
        assert_eq!(one.layers(), three.layers(), "{}", method.label);
        for layer in one.layers() {
            assert_eq!(one.mean_image(layer), three.mean_image(layer), "{}, {layer}", method.label);
            assert_eq!(one.standard_error_image(layer), three.standard_error_image(layer), "{}, {layer}", method.label);
        }
        let counted = |layers: &Layers| -> Vec<(Technique, Tally)> {
            layers.tallies().map(|(technique, &tally)| (technique, Tally { seconds: 0.0, ..tally })).collect()
        };
        assert_eq!(counted(one), counted(three), "{}", method.label);
    }
}

/// The first pass needs two tiles of sums in most layers, and each later one more where longer paths appear.
#[test]
fn what_exceeds_the_limit_is_refused_and_changes_nothing() {
    let scene = scenes::build(&scenes::room(FilmSize { width: 40, height: 30 }));
    let none = render(&method("path"), &scene, 4, Some(100_000));
    assert_eq!(none.passes(), 0);
    assert!(none.layers().unwrap().refused().unwrap().to_string().contains("GiB"));
    assert!(none.layers().unwrap().layers().is_empty());

    let first = with_layers(&method("path:max_length=none:roulette_start=1"), &scene, 1);
    let limit = first.layers().unwrap().bytes() + 1_000_000;
    let some = render(&method("path:max_length=none:roulette_start=1"), &scene, 4000, Some(limit));
    let layers = some.layers().unwrap();
    assert!(layers.refused().is_some() && (1..4000).contains(&some.passes()), "{} passes", some.passes());
    assert!(layers.bytes() <= limit && layers.passes() == some.passes());
    assert_equal("up to the limit", &some.mean_image(), &sum(layers, |layer| matches!(layer, Layer::Length { .. })).0);
}
