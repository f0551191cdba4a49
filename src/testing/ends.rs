//! Random numbers at the ends of `[0, 1)`, where samplers break: 0 and the largest below one.

use crate::estimator::{Estimator, RecordedTerm, Recorder};
use crate::sampler::{Random, Tracer};
use crate::scene::Scene;
use crate::scene::sensor::Pixel;

/// Numbers in a row that are forced.
const ROW: usize = 3;

/// So many random numbers of a sample are reached: those of the sensor's and the emitter's walk over a few vertices.
const REACH: u64 = 40;

/// What a random number may be: 0, the largest below one, or as it is drawn.
pub const CHOICES: [Option<f64>; 3] = [Some(0.0), Some(Random::LARGEST), None];

/// All rows of N [`CHOICES`].
pub fn rows<const N: usize>() -> impl Iterator<Item = [Option<f64>; N]> {
    let choices = CHOICES.len();
    (0..choices.pow(N as u32)).map(move |row| std::array::from_fn(|i| CHOICES[row / choices.pow(i as u32) % choices]))
}

/// Draws `passes` samples in every pixel, in each of which three random numbers in a row are replaced by one of the
/// [`rows`], anywhere among the first; gives their terms to `take`.
pub fn sample<E: Estimator>(estimator: &E, scene: &Scene, seed: u64, passes: u64, mut take: impl FnMut(RecordedTerm)) {
    let film = scene.sensor().film();
    let rows: Vec<[Option<f64>; ROW]> = rows().collect();
    let mut scratch = E::Scratch::default();
    for sample in 0..passes {
        for index in 0..film.width * film.height {
            let mut random = Random::new(seed, index.into(), sample);
            let [which, place] = random.uniform2();
            let row = rows[(which * rows.len() as f64) as usize];
            let mut random = random.forced((place * REACH as f64) as u32, row);
            let pixel = Pixel { x: index % film.width, y: index / film.width };
            let mut recorder = Recorder::default();
            estimator.sample(&mut Tracer::new(scene), &mut random, pixel, &mut scratch, &mut recorder);
            recorder.terms.into_iter().for_each(&mut take);
        }
    }
}

/// What is wrong with a term and its path, if anything is: a value that is negative or no number, a weight outside of 0 … 1,
/// a vertex that is nowhere, a normal that is not of length one, an edge without a length.
#[must_use]
pub fn fault(recorded: &RecordedTerm) -> Option<String> {
    let RecordedTerm { term, path } = recorded;
    let wrong = |value: f64| !(value.is_finite() && value >= 0.0);
    if term.value.to_array().into_iter().any(wrong) {
        return Some(format!("value {:?}", term.value));
    }
    if !(0.0..=1.0 + 1e-9).contains(&term.weight) {
        return Some(format!("weight {}", term.weight));
    }
    for (i, vertex) in path.vertices().iter().enumerate() {
        let unit = |normal: glam::DVec3| (normal.length() - 1.0).abs() < 1e-9;
        let normals = unit(vertex.normal) && unit(vertex.shading_normal);
        if !vertex.position.is_finite() || !(normals || vertex.normal == glam::DVec3::ZERO) {
            return Some(format!("vertex {i}: {vertex:?}"));
        }
    }
    let no_length = path.vertices().windows(2).position(|edge| edge[0].position == edge[1].position);
    no_length.map(|i| format!("edge {i} has no length"))
}
