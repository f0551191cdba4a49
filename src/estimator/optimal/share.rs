//! All paths of a pass with their densities: what any weights are made of.

use std::ops::Range;

use rayon::prelude::*;
use smallvec::SmallVec;

use crate::film::{Counters, ReplayKey};
use crate::sampler::Tracer;
use crate::scene::Scene;
use crate::scene::sensor::Pixel;
use crate::spectrum::Rgb;
use crate::wide::Wide;

use super::super::combination::{Combination, Draw};
use super::super::driver::random_of;

/// Pixels that are the work of one thread at a time, and how many such works are in flight per thread.
const TILE: usize = 256;
const TILES_PER_THREAD: usize = 16;

/// How the samplers share a path that one of them has drawn.
#[derive(Clone, Debug)]
pub(in super::super) struct Share {
    /// The number of the sampler.
    pub sampler: usize,
    /// The index of the pixel that sees the path.
    pub pixel: usize,
    /// Its length.
    pub edges: u32,
    /// `f / Σ_l n_l p_l`, over the probability that its length is estimated.
    pub y: Rgb,
    /// `n_k p_k / Σ_l n_l p_l`.
    pub q: SmallVec<[f64; 4]>,
}

impl Share {
    /// `None` where it cannot be right: not finite.
    pub(in super::super) fn new(combination: &Combination, scene: &Scene, draw: &Draw) -> Option<Self> {
        let total: Wide = draw.densities.iter().copied().sum();
        let edges = draw.path.edges() as u32;
        let scale = 1.0 / combination.lengths.probability(edges);
        let y = draw.contribution.over(total, scale);
        let q: SmallVec<[f64; 4]> = draw.densities.iter().map(|&density| (density / total).to_f64()).collect();
        let Pixel { x, y: row } = draw.contribution.pixel;
        let pixel = row as usize * scene.sensor().film().width as usize + x as usize;
        (y.is_finite() && q.iter().all(|q| q.is_finite())).then_some(Self { sampler: draw.sampler, pixel, edges, y, q })
    }
}

/// Draws pass number `sample` and gives its paths in one order, whatever the number of threads.
pub(in super::super) fn draw_pass(
    combination: &Combination,
    scene: &Scene,
    (seed, sample): (u64, u64),
    take: &mut dyn FnMut(&Share),
) -> Counters {
    let size = scene.sensor().film();
    let pixels = size.width as usize * size.height as usize;
    let tiles: Vec<Range<usize>> = (0..pixels).step_by(TILE).map(|first| first..(first + TILE).min(pixels)).collect();
    let mut counters = Counters::default();
    for group in tiles.chunks(TILES_PER_THREAD * rayon::current_num_threads()) {
        let drawn: Vec<(Vec<Share>, Counters)> =
            group.par_iter().map(|tile| draw_tile(combination, scene, (seed, sample), tile.clone())).collect();
        for (shares, counted) in &drawn {
            shares.iter().for_each(&mut *take);
            counters.merge(counted);
        }
    }
    counters
}

fn draw_tile(
    combination: &Combination,
    scene: &Scene,
    (seed, sample): (u64, u64),
    tile: Range<usize>,
) -> (Vec<Share>, Counters) {
    let width = scene.sensor().film().width as usize;
    let mut tracer = Tracer::new(scene);
    let (mut shares, mut counters) = (Vec::new(), Counters::default());
    counters.paths = tile.len() as u64;
    for index in tile {
        let pixel = Pixel { x: (index % width) as u32, y: (index / width) as u32 };
        let mut random = random_of(scene, seed, pixel, sample);
        combination.draw(&mut tracer, &mut random, pixel, &mut |draw| match Share::new(combination, scene, &draw) {
            Some(share) => shares.push(share),
            None => {
                counters.invalid += 1;
                counters.keep_for_replay(ReplayKey { seed, sample, pixel: (pixel.x, pixel.y) });
            }
        });
    }
    counters.rays = tracer.rays();
    (shares, counters)
}
