//! The sums behind the layers, allocated where something is drawn.

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::film::accumulator::standard_error;
use crate::film::error::FilmError;
use crate::film::image::Image;
use crate::path::Technique;
use crate::spectrum::Rgb;

use super::tally::{LayerPart, Tally};
use super::tile::{Sums, TILE, Tile};
use super::{Contribution, Layer, LayerSelection};

/// An image of each path length and of each technique, beside the film's own, with standard errors.
///
/// The image is a sum over path lengths, `I = Σ_k L_k`, and each of these over techniques, `L_k = Σ_{s+t=k+2} C_{s,t}`. The
/// layers are the terms of both sums:
///
/// | layer | content | expectation |
/// |---|---|---|
/// | `L_k` | paths with k + 1 edges: L_0 is seen emission, L_1 direct light | `∫ f_j dμ` over those |
/// | `s2_t3.weighted` | what technique (2, 3) adds to the image | `∫ w_{2,3} f_j dμ` |
/// | `s2_t3.unweighted` | its terms divided by their weights | `∫ f_j dμ` over the paths with `w_{2,3} > 0` |
///
/// The unweighted image is that of the technique alone (Veach 1997, figure 10.2 shows both). Where the weight is zero it is
/// undefined: `0 / 0`, for the term itself is zero. Such terms are left out, and so are those whose quotient is beyond a
/// double's range; [`Tally::undefined`] counts those that integrators give. With the balance and power heuristics w > 0
/// wherever the technique can draw the path, so nothing is missing; with the maximum and cutoff heuristics it is the image of
/// the paths that the technique keeps. Its variance may be infinite where the weighted one's is not.
///
/// A layer `NAME.standard_error` beside each is that of the mean over passes, as for the image; its square times the number
/// of passes is the variance of one sample.
///
/// **Rays and time.** What the techniques of a sample share (the walks) belongs to none of them alone, and rays that led to
/// no term carry no technique. So each sample's rays, which are counted exactly, and its time, which is measured around it
/// with a monotonic clock, are shared among the sample's terms in proportion to the edges of their paths: what each would
/// have cost if drawn alone. Samples without any term are told apart as [`Layers::without_terms`]. The sums are those of all
/// samples; the shares are a convention, and time alone is not the same from run to run.
///
/// **Memory.** There is no longest path: a layer begins with the first contribution to it, in tiles of 1024 pixels, and takes 48
/// bytes per pixel of these. The contributions of the pass in progress are kept besides, 48 bytes each. When both exceed the
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
