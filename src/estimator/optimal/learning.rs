//! What is learnt from the samples of all passes: one system for each region of the film and each length.

use std::fmt::{self, Display, Formatter};
use std::str::FromStr;

use crate::film::BlockGrid;
use crate::scene::Scene;
use crate::spectrum::Rgb;

use super::super::combination::Combination;
use super::share::Share;
use super::system::System;

/// The longest paths with coefficients of their own; longer ones are weighted by the balance heuristic.
const LONGEST: u32 = 16;

/// The region of the film that shares its coefficients α.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Alpha {
    /// The image.
    Image,
    /// A block of [`BLOCK_SIDE`](crate::film::BLOCK_SIDE)² pixels.
    #[default]
    Block,
}

impl FromStr for Alpha {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "image" => Ok(Self::Image),
            "block" => Ok(Self::Block),
            _ => Err("expected image or block".into()),
        }
    }
}

impl Display for Alpha {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(if *self == Self::Image { "image" } else { "block" })
    }
}

/// The systems of all regions and lengths.
#[derive(Clone, Debug)]
pub(super) struct Learning {
    /// The region of each pixel.
    regions: Vec<u32>,
    /// How many pixels each has.
    pixels: Vec<u32>,
    /// n_i of each sampler.
    counts: Vec<f64>,
    lengths: usize,
    passes: f64,
    systems: Vec<System>,
}

impl Learning {
    /// Before the first pass, or from what a film has kept of the same combination and film.
    pub(super) fn new(combination: &Combination, scene: &Scene, alpha: Alpha, kept: &[f64]) -> Self {
        let size = scene.sensor().film();
        let (regions, pixels) = match (alpha, BlockGrid::new(size.width, size.height, None)) {
            (Alpha::Block, Ok(grid)) => {
                let block = |x, y| grid.block_of(x, y) as u32;
                let regions = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y)));
                (regions.map(|(x, y)| block(x, y)).collect(), grid.pixels().to_vec())
            }
            _ => (vec![0; size.width as usize * size.height as usize], vec![size.width * size.height]),
        };
        let counts: Vec<f64> = combination.samplers.iter().map(|sampler| sampler.count(scene)).collect();
        let lengths = combination.max_length.min(LONGEST) as usize;
        let (number, length) = (pixels.len() * lengths, System::len_of(counts.len()));
        let (passes, systems) = match kept.split_first() {
            Some((&passes, numbers)) if numbers.len() == number * length => (
                passes,
                numbers.chunks_exact(length).map(|numbers| System::from_numbers(counts.len(), numbers)).collect(),
            ),
            _ => (0.0, vec![System::new(counts.len()); number]),
        };
        Self { regions, pixels, counts, lengths, passes, systems }
    }

    /// To be kept in the film.
    pub(super) fn numbers(&self) -> Vec<f64> {
        std::iter::once(self.passes).chain(self.systems.iter().flat_map(System::numbers)).collect()
    }

    /// The number of samplers.
    pub(super) fn techniques(&self) -> usize {
        self.counts.len()
    }

    /// Coefficients, and controls, of a pixel: those of all lengths and samplers.
    pub(super) fn per_pixel(&self) -> usize {
        self.lengths * self.techniques()
    }

    /// Where the controls of a length begin in its pixel's; `None` for lengths without.
    pub(super) fn offset(&self, edges: u32) -> Option<usize> {
        let length = edges as usize - 1;
        (length < self.lengths).then(|| length * self.techniques())
    }

    /// Where the coefficients of a pixel begin.
    pub(super) fn first(&self, pixel: usize) -> usize {
        self.regions[pixel] as usize * self.per_pixel()
    }

    pub(super) fn add(&mut self, share: &Share) {
        if share.edges as usize <= self.lengths {
            let system = self.regions[share.pixel] as usize * self.lengths + share.edges as usize - 1;
            self.systems[system].add(share.sampler, &share.q, share.y);
        }
    }

    pub(super) fn end_pass(&mut self) {
        self.passes += 1.0;
    }

    /// β by region, length and sampler.
    pub(super) fn solve(&self) -> Vec<Rgb> {
        let solve = |(index, system): (usize, &System)| {
            let estimates = self.passes * f64::from(self.pixels[index / self.lengths]);
            let samples: Vec<f64> = self.counts.iter().map(|count| count * estimates).collect();
            system.solve(&samples)
        };
        self.systems.iter().enumerate().flat_map(solve).collect()
    }
}
