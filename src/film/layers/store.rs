//! The sums behind the layers, allocated where something is drawn.

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::film::accumulator::standard_error;
use crate::film::error::FilmError;
use crate::film::image::Image;
use crate::path::Technique;
use crate::spectrum::Rgb;

use super::tally::{LayerPart, Tally};
use super::{Contribution, Layer, LayerSelection};

/// Pixels whose sums are allocated together: few enough that the layers of rare long paths stay small.
const TILE: usize = 1024;

/// Memory of a pixel in a layer \[bytes\]: a sum and a sum of squares.
const PIXEL_BYTES: u64 = 2 * size_of::<Rgb>() as u64;

/// An image for each path length and for each technique, with standard errors; see the module's introduction for what they
/// hold and how rays and time are shared.
///
/// There is no longest path: a layer begins with the first contribution to it, in tiles of 1024 pixels, and takes 48 bytes
/// per pixel of these. The contributions of the pass in progress are kept besides, 48 bytes each. When both exceed the
/// limit, the pass is refused, and so is every later one.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    width: u32,
    height: u32,
    selection: LayerSelection,
    limit: u64,
    passes: u64,
    tiles: Vec<Tile>,
    /// By length and then by s.
    tallies: BTreeMap<(u32, u32), Tally>,
    without_terms: Tally,
    refused: Option<FilmError>,
}

/// All that one pass gives to the layers.
#[derive(Clone, Debug)]
pub struct LayerPass {
    tiles: Vec<Vec<Contribution>>,
    tallies: BTreeMap<(u32, u32), Tally>,
    without_terms: Tally,
}

impl LayerPass {
    /// Adds what some of the pass's samples give. The sums depend on the order of the parts.
    ///
    /// # Panics
    /// If a pixel is outside the film.
    pub fn add(&mut self, part: LayerPart) {
        for (technique, tally) in part.tallies() {
            self.tallies.entry((technique.edges(), technique.s)).or_default().merge(tally);
        }
        self.without_terms.merge(&part.without_terms);
        for contribution in part.contributions {
            self.tiles[contribution.pixel as usize / TILE].push(contribution);
        }
    }
}

impl Layers {
    pub(in crate::film) fn new(width: u32, height: u32, selection: LayerSelection, limit: u64) -> Self {
        let tiles = (width as usize * height as usize).div_ceil(TILE);
        Self {
            width,
            height,
            selection,
            limit,
            passes: 0,
            tiles: vec![Tile::default(); tiles],
            tallies: BTreeMap::new(),
            without_terms: Tally::default(),
            refused: None,
        }
    }

    /// A pass without contributions yet.
    #[must_use]
    pub fn new_pass(&self) -> LayerPass {
        let tiles = vec![Vec::new(); self.tiles.len()];
        LayerPass { tiles, tallies: BTreeMap::new(), without_terms: Tally::default() }
    }

    /// Adds a pass. The result is the same on any number of threads.
    ///
    /// # Errors
    /// When it does not fit into the limit. Then nothing is added, and no later pass is.
    pub fn add_pass(&mut self, mut pass: LayerPass) -> Result<(), FilmError> {
        if let Some(refused) = &self.refused {
            return Err(refused.clone());
        }
        let selection = self.selection;
        let pairs = self.tiles.par_iter().zip(&mut pass.tiles);
        let needed: u64 = pairs
            .map(|(tile, contributions)| {
                // Stable: what a pixel gets is added in the order of its arrival.
                contributions.sort_by_key(|c| (c.pixel, c.technique.edges(), c.technique.s));
                let held = size_of_val(contributions.as_slice()) as u64;
                held + tile.bytes_with(contributions, selection)
            })
            .sum();
        if needed > self.limit {
            let (width, height, passes, limit) = (self.width, self.height, self.passes + 1, self.limit);
            let layers = self.names_with(&pass).len();
            let refused = FilmError::LayerMemory { layers, width, height, passes, needed, limit };
            self.refused = Some(refused.clone());
            return Err(refused);
        }
        let tiles = self.tiles.par_iter_mut().zip(pass.tiles).enumerate();
        tiles.for_each(|(index, (tile, contributions))| tile.add(index * TILE, &contributions, selection));
        for (key, tally) in &pass.tallies {
            self.tallies.entry(*key).or_default().merge(tally);
        }
        self.without_terms.merge(&pass.without_terms);
        self.passes += 1;
        Ok(())
    }

    /// Adds the passes of another render of the same size.
    pub(in crate::film) fn merge(&mut self, other: &Self) -> Result<(), FilmError> {
        let same = |layers: &Self| (layers.width, layers.height, layers.selection);
        if same(self) != same(other) {
            return Err(FilmError::Incompatible);
        }
        for (mine, theirs) in self.tiles.iter_mut().zip(&other.tiles) {
            mine.merge(theirs);
        }
        for (key, tally) in &other.tallies {
            self.tallies.entry(*key).or_default().merge(tally);
        }
        self.without_terms.merge(&other.without_terms);
        self.passes += other.passes;
        Ok(())
    }

    /// Why a pass was refused, if one was.
    #[must_use]
    pub fn refused(&self) -> Option<&FilmError> {
        self.refused.as_ref()
    }

    /// Which layers are kept.
    #[must_use]
    pub fn selection(&self) -> LayerSelection {
        self.selection
    }

    /// Passes added.
    #[must_use]
    pub fn passes(&self) -> u64 {
        self.passes
    }

    /// Memory of the sums \[bytes\].
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.tiles.iter().map(|tile| tile.bytes_with(&[], self.selection)).sum()
    }

    /// All layers that have got something, by length and then by s.
    #[must_use]
    pub fn layers(&self) -> Vec<Layer> {
        self.names_with(&self.new_pass())
    }

    /// The counts of all techniques, by length and then by s.
    pub fn tallies(&self) -> impl Iterator<Item = (Technique, &Tally)> {
        self.tallies.iter().map(|(&(edges, s), tally)| (Technique { s, t: edges + 1 - s }, tally))
    }

    /// The counts of samples without any term.
    #[must_use]
    pub fn without_terms(&self) -> &Tally {
        &self.without_terms
    }

    /// The mean of a layer over passes; black where nothing was drawn.
    #[must_use]
    pub fn mean_image(&self, layer: Layer) -> Image {
        let n = self.passes.max(1) as f64;
        self.image(layer, |sum, _| sum / n)
    }

    /// The estimated standard error of each pixel's mean; `None` below two passes.
    #[must_use]
    pub fn standard_error_image(&self, layer: Layer) -> Option<Image> {
        (self.passes >= 2).then(|| self.image(layer, |sum, squares| standard_error(sum, squares, self.passes)))
    }

    fn image(&self, layer: Layer, value: impl Fn(Rgb, Rgb) -> Rgb) -> Image {
        let count = self.width as usize * self.height as usize;
        let mut pixels = vec![Rgb::BLACK; count];
        for (pixels, tile) in pixels.chunks_mut(TILE).zip(&self.tiles) {
            let sums = tile.sums(layer).unwrap_or(&[]);
            for (pixel, &Sums { sum, squares }) in pixels.iter_mut().zip(sums) {
                *pixel = value(sum, squares);
            }
        }
        Image { width: self.width, height: self.height, pixels }
    }

    fn names_with(&self, pass: &LayerPass) -> Vec<Layer> {
        let given = |tally: &Tally| tally.samples > 0;
        let both = self.tallies.iter().chain(&pass.tallies).filter(|(_, tally)| given(tally));
        let techniques: std::collections::BTreeSet<(u32, u32)> = both.map(|(&key, _)| key).collect();
        let mut lengths: Vec<u32> = techniques.iter().map(|&(edges, _)| edges).collect();
        lengths.dedup();
        let lengths = lengths.into_iter().map(|edges| Layer::Length { edges }).filter(|_| self.selection.length);
        let techniques = techniques.into_iter().map(|(edges, s)| Technique { s, t: edges + 1 - s });
        let pair = |technique| [Layer::Weighted(technique), Layer::Unweighted(technique)];
        lengths.chain(techniques.flat_map(pair).filter(|_| self.selection.technique)).collect()
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Sums {
    sum: Rgb,
    squares: Rgb,
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

#[derive(Clone, Debug, Default, PartialEq)]
struct Tile {
    lengths: BTreeMap<u32, Block>,
    /// Weighted and unweighted.
    techniques: BTreeMap<Technique, [Block; 2]>,
}

impl Tile {
    /// Memory of the sums after these contributions, which are sorted \[bytes\].
    fn bytes_with(&self, contributions: &[Contribution], selection: LayerSelection) -> u64 {
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
    fn add(&mut self, first: usize, contributions: &[Contribution], selection: LayerSelection) {
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

    fn merge(&mut self, other: &Self) {
        for (&edges, block) in &other.lengths {
            merge_blocks(self.lengths.entry(edges).or_insert_with(new_block), block);
        }
        for (&technique, [weighted, unweighted]) in &other.techniques {
            let mine = self.techniques.entry(technique).or_insert_with(|| [new_block(), new_block()]);
            merge_blocks(&mut mine[0], weighted);
            merge_blocks(&mut mine[1], unweighted);
        }
    }

    fn sums(&self, layer: Layer) -> Option<&[Sums]> {
        let block = match layer {
            Layer::Length { edges } => self.lengths.get(&edges)?,
            Layer::Weighted(technique) => &self.techniques.get(&technique)?[0],
            Layer::Unweighted(technique) => &self.techniques.get(&technique)?[1],
        };
        Some(block)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOTH: LayerSelection = LayerSelection { length: true, technique: true };

    fn contribution(pixel: u32, s: u32, t: u32, value: f64, weight: f64) -> Contribution {
        Contribution { pixel, technique: Technique { s, t }, value: Rgb::grey(value), weight }
    }

    fn pass(layers: &Layers, samples: &[&[Contribution]]) -> LayerPass {
        let mut pass = layers.new_pass();
        let mut part = LayerPart::default();
        for sample in samples {
            sample.iter().for_each(|&contribution| part.add(contribution));
            part.end_sample(2, 0.5);
        }
        pass.add(part);
        pass
    }

    fn grey(layers: &Layers, layer: Layer, pixel: usize) -> (f64, f64) {
        let error = layers.standard_error_image(layer).unwrap();
        (layers.mean_image(layer).pixels[pixel].g, error.pixels[pixel].g)
    }

    /// Two passes over pixel 1500, in the second tile: 1 + 2 and 5 in length 2, of which (1, 2) has 1 and 5.
    fn two_passes() -> Layers {
        let mut layers = Layers::new(64, 32, BOTH, 1 << 20);
        let (a, b) = (contribution(1500, 1, 2, 1.0, 0.25), contribution(1500, 0, 3, 2.0, 1.0));
        layers.add_pass(pass(&layers, &[&[a, b], &[]])).unwrap();
        layers.add_pass(pass(&layers, &[&[contribution(1500, 1, 2, 5.0, 0.5)], &[]])).unwrap();
        layers
    }

    #[test]
    fn means_and_standard_errors_are_those_of_the_pass_values() {
        let layers = two_passes();
        let technique = Technique { s: 1, t: 2 };
        // Of two values a and b: (a + b)/2 and |a − b|/2.
        assert_eq!(grey(&layers, Layer::Length { edges: 2 }, 1500), (4.0, 1.0));
        assert_eq!(grey(&layers, Layer::Weighted(technique), 1500), (3.0, 2.0));
        assert_eq!(grey(&layers, Layer::Unweighted(technique), 1500), (7.0, 3.0));
        assert_eq!(grey(&layers, Layer::Weighted(Technique { s: 0, t: 3 }), 1500), (1.0, 1.0));
        assert_eq!(grey(&layers, Layer::Length { edges: 2 }, 3), (0.0, 0.0));
        let names: Vec<String> = layers.layers().iter().map(ToString::to_string).collect();
        assert_eq!(names, ["L_1", "s0_t3.weighted", "s0_t3.unweighted", "s1_t2.weighted", "s1_t2.unweighted"]);
        assert_eq!(layers.bytes(), 5 * 1024 * 48, "one tile of two in each layer");
        assert_eq!(layers.without_terms().samples, 2);
    }

    #[test]
    fn merged_layers_hold_the_passes_of_both() {
        let mut twice = two_passes();
        twice.merge(&two_passes()).unwrap();
        assert_eq!(twice.passes(), 4);
        assert_eq!(grey(&twice, Layer::Length { edges: 2 }, 1500).0, 4.0);
        assert_eq!(twice.tallies().map(|(_, tally)| tally.samples).collect::<Vec<_>>(), [2, 4]);
        assert!(twice.merge(&Layers::new(64, 31, BOTH, 1)).is_err());
    }

    #[test]
    fn a_pass_that_does_not_fit_is_refused_whole() {
        let mut layers = two_passes();
        layers.limit = layers.bytes() + 10_000;
        let before = (layers.passes(), layers.bytes(), layers.layers());
        let far = contribution(3, 700, 300, 1.0, 1.0);
        let refused = layers.add_pass(pass(&layers, &[&[contribution(1500, 1, 2, 5.0, 0.5)], &[far]])).unwrap_err();
        assert!(matches!(refused, FilmError::LayerMemory { layers: 8, passes: 3, .. }), "{refused}");
        assert_eq!((layers.passes(), layers.bytes(), layers.layers()), before);
        assert_eq!(layers.add_pass(layers.new_pass()), Err(refused));
    }
}
