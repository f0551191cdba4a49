//! Runs an [`Estimator`] over passes, on all threads, with the same bits on any number of them.
//!
//! A pass is one sample in every pixel. Its pixels are cut into tiles; a tile is the work of one thread at a time. What a
//! sample adds to its own pixel is summed in the tile. What it adds to others (light walks) is kept in a list, and the
//! lists are added in the order of the tiles, so no sum depends on who finished first. Where the film keeps layers, each tile
//! keeps its terms besides, in the same order; where it does not, that code is not compiled in.

use std::ops::Range;
use std::time::Instant;

use rayon::prelude::*;

use crate::film::{Contribution, Counters, Film, LayerPart, ReplayKey};
use crate::path::Path;
use crate::sampler::{Random, Tracer};
use crate::scene::Scene;
use crate::scene::description::FilmSize;
use crate::scene::sensor::Pixel;
use crate::spectrum::Rgb;

use super::integrator::Estimator;
use super::sink::{Sink, Term};

/// Pixels in a tile: enough work to be worth handing out, little enough to share evenly.
const TILE: usize = 1024;

/// Tiles in flight per thread. It bounds the memory for contributions to other pixels.
const TILES_PER_THREAD: usize = 16;

/// Decides how long a render goes on, and looks at it in between.
pub trait Control {
    /// Called between passes, on the calling thread. Returns how many passes to add before the next call; zero stops.
    fn next_passes(&mut self, film: &Film) -> u64;
}

/// The random numbers of a pixel's sample.
#[must_use]
pub fn random_of(scene: &Scene, seed: u64, pixel: Pixel, sample: u64) -> Random {
    let width = u64::from(scene.sensor().film().width);
    Random::new(seed, u64::from(pixel.y) * width + u64::from(pixel.x), sample)
}

/// Adds passes to the film until `control` says stop, or its layers refuse a pass: `control` is then asked a last time. Passes
/// are numbered on from those that the film holds.
///
/// # Panics
/// If the film's size is not that of the scene's sensor.
pub fn render<E: Estimator>(estimator: &E, scene: &Scene, seed: u64, film: &mut Film, control: &mut dyn Control) {
    let size = scene.sensor().film();
    assert_eq!((film.width(), film.height()), (size.width, size.height), "the film is the scene's");
    let mut pass = vec![Rgb::BLACK; size.width as usize * size.height as usize];
    loop {
        let passes = control.next_passes(film);
        let refused = film.layers().is_some_and(|layers| layers.refused().is_some());
        if passes == 0 || refused {
            return;
        }
        for _ in 0..passes {
            let job = Job { estimator, scene, seed, sample: film.passes(), size };
            let counters = match film.layers_mut() {
                None => job.add_pass(&mut pass, |()| ()),
                Some(layers) => {
                    let mut of_pass = layers.new_pass();
                    let counters = job.add_pass(&mut pass, |part: TimedPart| of_pass.add(part.layers));
                    if layers.add_pass(of_pass).is_err() {
                        break;
                    }
                    counters
                }
            };
            film.add_pass(&pass).expect("the pass has the film's size");
            film.counters.merge(&counters);
        }
    }
}

/// What a tile remembers of its samples beside what they add to pixels.
trait Memory: Default + Send {
    /// Begins a sample.
    fn begin(&mut self);
    /// Takes a term of the sample, to the pixel of this index.
    fn add(&mut self, index: usize, term: &Term);
    /// Ends the sample, which took so many rays.
    fn end(&mut self, rays: u64);
}

/// Nothing.
impl Memory for () {
    #[inline(always)]
    fn begin(&mut self) {}
    #[inline(always)]
    fn add(&mut self, _: usize, _: &Term) {}
    #[inline(always)]
    fn end(&mut self, _: u64) {}
}

/// All terms, for layers.
#[derive(Default)]
struct TimedPart {
    layers: LayerPart,
    began: Option<Instant>,
}

impl Memory for TimedPart {
    fn begin(&mut self) {
        self.began = Some(Instant::now());
    }

    fn add(&mut self, index: usize, term: &Term) {
        let Term { technique, value, weight, .. } = *term;
        self.layers.add(Contribution { pixel: index as u32, technique, value, weight });
    }

    fn end(&mut self, rays: u64) {
        let seconds = self.began.map_or(0.0, |began| began.elapsed().as_secs_f64());
        self.layers.end_sample(rays, seconds);
    }
}

struct Job<'a, E> {
    estimator: &'a E,
    scene: &'a Scene,
    seed: u64,
    sample: u64,
    size: FilmSize,
}

/// What a tile's samples add to pixels of other tiles, in order.
struct TileResult<M> {
    splats: Vec<(u32, Rgb)>,
    counters: Counters,
    memory: M,
}

impl<E: Estimator> Job<'_, E> {
    /// Draws a sample in every pixel. `take` gets what the tiles remember, in their order.
    fn add_pass<M: Memory>(&self, pass: &mut [Rgb], mut take: impl FnMut(M)) -> Counters {
        pass.fill(Rgb::BLACK);
        let mut counters = Counters::default();
        let tiles: Vec<Range<usize>> =
            (0..pass.len()).step_by(TILE).map(|first| first..(first + TILE).min(pass.len())).collect();
        for group in tiles.chunks(TILES_PER_THREAD * rayon::current_num_threads()) {
            let span = group[0].start..group[group.len() - 1].end;
            let results: Vec<TileResult<M>> = (pass[span].par_chunks_mut(TILE).zip(group))
                .map_init(E::Scratch::default, |scratch, (pixels, tile)| self.tile(tile.start, pixels, scratch))
                .collect();
            for result in results {
                for (pixel, value) in result.splats {
                    pass[pixel as usize] += value;
                }
                counters.merge(&result.counters);
                take(result.memory);
            }
        }
        counters
    }

    #[inline(never)]
    fn tile<M: Memory>(&self, first: usize, pixels: &mut [Rgb], scratch: &mut E::Scratch) -> TileResult<M> {
        let mut tracer = Tracer::new(self.scene);
        let mut sink = TileSink {
            first,
            pixels,
            size: self.size,
            splats: Vec::new(),
            counters: Counters::default(),
            key: self.key(first),
            memory: M::default(),
        };
        for index in first..first + sink.pixels.len() {
            sink.key = self.key(index);
            let (x, y) = sink.key.pixel;
            let mut random = Random::new(self.seed, index as u64, self.sample);
            let rays = tracer.rays();
            sink.memory.begin();
            self.estimator.sample(&mut tracer, &mut random, Pixel { x, y }, scratch, &mut sink);
            sink.memory.end(tracer.rays() - rays);
        }
        sink.counters.rays = tracer.rays();
        sink.counters.paths = sink.pixels.len() as u64;
        TileResult { splats: sink.splats, counters: sink.counters, memory: sink.memory }
    }

    fn key(&self, index: usize) -> ReplayKey {
        let width = self.size.width as usize;
        ReplayKey { seed: self.seed, sample: self.sample, pixel: ((index % width) as u32, (index / width) as u32) }
    }
}

/// Aligned to a cache line, and so is the stack below it: whether a sample's variables straddle lines is otherwise up to the
/// depth of the call, and was worth 15 %.
#[repr(align(64))]
struct TileSink<'a, M> {
    first: usize,
    pixels: &'a mut [Rgb],
    size: FilmSize,
    splats: Vec<(u32, Rgb)>,
    counters: Counters,
    key: ReplayKey,
    memory: M,
}

impl<M> TileSink<'_, M> {
    /// A value that cannot be right is counted with the key that draws it again. One that is not finite would erase all
    /// that its pixel has gathered, so the counter is all that becomes of it; a negative one is added like any other.
    #[cold]
    fn count(&mut self, value: Rgb) {
        if value.is_finite() {
            self.counters.negative += 1;
        } else {
            self.counters.invalid += 1;
        }
        self.counters.keep_for_replay(self.key);
    }
}

impl<M: Memory> Sink for TileSink<'_, M> {
    const RECORDS: bool = false;

    #[inline(always)]
    fn add(&mut self, term: Term, _path: impl FnOnce() -> Option<Path>) {
        let value = term.value;
        if !(value.is_finite() && value.min_component() >= 0.0) {
            self.count(value);
            if !value.is_finite() {
                return;
            }
        }
        let index = term.pixel.y as usize * self.size.width as usize + term.pixel.x as usize;
        self.memory.add(index, &term);
        match self.pixels.get_mut(index.wrapping_sub(self.first)) {
            Some(pixel) => *pixel += value,
            None => self.splats.push((index as u32, value)),
        }
    }
}
