//! The layers of a few pixels.

use std::collections::BTreeMap;

use crate::path::Technique;
use crate::spectrum::Rgb;

use super::{Contribution, Layer, LayerSelection};

/// Pixels whose sums are allocated together: few enough that the layers of rare long paths stay small.
pub(super) const TILE: usize = 1024;

/// Memory of a pixel in a layer \[bytes\]: a sum and a sum of squares.
const PIXEL_BYTES: u64 = 2 * size_of::<Rgb>() as u64;

/// A pixel in a layer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Sums {
    pub(super) sum: Rgb,
    pub(super) squares: Rgb,
}

impl Sums {
    fn add(&mut self, value: Rgb) {
        self.sum += value;
        self.squares += value * value;
    }
}

/// The sums of [`TILE`] pixels in a layer.
type Block = Vec<Sums>;

fn new_block() -> Block {
    vec![Sums::default(); TILE]
}

fn merge_blocks(mine: &mut Block, theirs: &Block) {
    for (mine, theirs) in mine.iter_mut().zip(theirs) {
        mine.sum += theirs.sum;
        mine.squares += theirs.squares;
    }
}

/// All layers of [`TILE`] pixels.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Tile {
    lengths: BTreeMap<u32, Block>,
    /// Weighted and unweighted.
    techniques: BTreeMap<Technique, [Block; 2]>,
}

impl Tile {
    /// Memory of the sums after these contributions, which are sorted \[bytes\].
    pub(super) fn bytes_with(&self, contributions: &[Contribution], selection: LayerSelection) -> u64 {
        let mut techniques: Vec<Technique> = contributions.iter().map(|c| c.technique).collect();
        techniques.dedup();
        techniques.sort_unstable_by_key(|technique| (technique.edges(), technique.s));
        techniques.dedup();
        let mut lengths: Vec<u32> = techniques.iter().map(|technique| technique.edges()).collect();
        lengths.dedup();
        let of_lengths = lengths.iter().filter(|edges| !self.lengths.contains_key(edges)).count();
        let of_techniques = techniques.iter().filter(|technique| !self.techniques.contains_key(technique)).count();
        let lengths = self.lengths.len() + if selection.length { of_lengths } else { 0 };
        let techniques = self.techniques.len() + if selection.technique { of_techniques } else { 0 };
        (lengths + 2 * techniques) as u64 * TILE as u64 * PIXEL_BYTES
    }

    /// Adds a pass's contributions, sorted by pixel, length and s, to pixels from `first` on.
    pub(super) fn add(&mut self, first: usize, contributions: &[Contribution], selection: LayerSelection) {
        let same_length =
            |a: &Contribution, b: &Contribution| a.pixel == b.pixel && a.technique.edges() == b.technique.edges();
        for of_length in contributions.chunk_by(same_length) {
            let at = of_length[0].pixel as usize - first;
            if selection.length {
                let total = of_length.iter().map(|c| c.value).sum();
                self.lengths.entry(of_length[0].technique.edges()).or_insert_with(new_block)[at].add(total);
            }
            if !selection.technique {
                continue;
            }
            for of_technique in of_length.chunk_by(|a, b| a.technique == b.technique) {
                let blocks = self.techniques.entry(of_technique[0].technique);
                let [weighted, unweighted] = blocks.or_insert_with(|| [new_block(), new_block()]);
                weighted[at].add(of_technique.iter().map(|c| c.value).sum());
                unweighted[at].add(of_technique.iter().filter_map(Contribution::unweighted).sum());
            }
        }
    }

    /// Adds the sums of another render.
    pub(super) fn merge(&mut self, other: &Self) {
        for (&edges, block) in &other.lengths {
            merge_blocks(self.lengths.entry(edges).or_insert_with(new_block), block);
        }
        for (&technique, [weighted, unweighted]) in &other.techniques {
            let mine = self.techniques.entry(technique).or_insert_with(|| [new_block(), new_block()]);
            merge_blocks(&mut mine[0], weighted);
            merge_blocks(&mut mine[1], unweighted);
        }
    }

    /// The sums of a layer, where it has got any.
    pub(super) fn sums(&self, layer: Layer) -> Option<&[Sums]> {
        let block = match layer {
            Layer::Length { edges } => self.lengths.get(&edges)?,
            Layer::Weighted(technique) => &self.techniques.get(&technique)?[0],
            Layer::Unweighted(technique) => &self.techniques.get(&technique)?[1],
        };
        Some(block)
    }
}
