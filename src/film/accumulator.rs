//! The resumable state of a render.

use rayon::prelude::*;

use crate::spectrum::Rgb;

use super::blocks::{BLOCK_SIDE, BlockGrid, BlockStatistics};
use super::counters::Counters;
use super::error::FilmError;
use super::image::Image;
use super::layers::{LayerSelection, Layers};

/// Sums over passes of every pixel and of every block's mean, in double precision.
///
/// With `x_{p,i}` the value of pixel i in pass p of n, the mean is `1/n Σ_p x_{p,i}` and its variance is estimated by
/// `(Σ_p x² − (Σ_p x)²/n) / (n (n − 1))`. Values that are not finite are kept like any other, and whoever draws them
/// counts them in [`Film::counters`].
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    pub(super) sum: Vec<Rgb>,
    pub(super) sum_of_squares: Vec<Rgb>,
    pub(super) mask: Option<Vec<bool>>,
    pub(super) statistics: BlockStatistics,
    pub(super) restricted: Option<BlockStatistics>,
    layers: Option<Layers>,
    pub(super) passes: u64,
    /// What the render has counted so far.
    pub counters: Counters,
    /// What an integrator has learnt from the passes, in an order of its own: it goes on from there. Empty for most.
    pub learnt: Vec<f64>,
}

impl Film {
    /// An empty film; `mask` says which pixels count in the blocks (all where there is none). Images hold every pixel.
    ///
    /// # Errors
    /// When there are no pixels, too many, or the mask is not one value for each.
    pub fn new(width: u32, height: u32, mask: Option<Vec<bool>>) -> Result<Self, FilmError> {
        let grid = BlockGrid::new(width, height, mask.as_deref())?;
        let zero = vec![Rgb::BLACK; width as usize * height as usize];
        let statistics = BlockStatistics::new(grid);
        Ok(Self {
            sum: zero.clone(),
            sum_of_squares: zero,
            mask,
            statistics,
            restricted: None,
            layers: None,
            passes: 0,
            counters: Counters::default(),
            learnt: Vec::new(),
        })
    }

    /// Pixels in a row.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.statistics.grid.width()
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.statistics.grid.height()
    }

    /// Number of passes, that is, samples per pixel.
    #[must_use]
    pub fn passes(&self) -> u64 {
        self.passes
    }

    /// Which pixels count in the blocks; all where there is none.
    #[must_use]
    pub fn mask(&self) -> Option<&[bool]> {
        self.mask.as_deref()
    }

    /// The statistics of blocks over passes, for [`crate::report::agreement`].
    #[must_use]
    pub fn block_statistics(&self) -> &BlockStatistics {
        &self.statistics
    }

    /// Keeps besides the statistics of only those blocks for which `keep` holds. Not part of a saved state.
    ///
    /// # Errors
    /// When passes are there already, or `keep` is not one value for each block.
    pub fn keep_restricted(&mut self, keep: &[bool]) -> Result<(), FilmError> {
        if self.passes > 0 {
            return Err(FilmError::Incompatible);
        }
        self.restricted = Some(BlockStatistics::new(self.statistics.grid.restricted(keep)?));
        Ok(())
    }

    /// The statistics that [`Film::keep_restricted`] asks for.
    #[must_use]
    pub fn restricted_statistics(&self) -> Option<&BlockStatistics> {
        self.restricted.as_ref()
    }

    /// Keeps besides an image of each path length, of each technique, or both, in at most `limit` bytes. Whoever fills the
    /// film fills them with [`Layers::add_pass`]. Not part of a saved state.
    ///
    /// # Errors
    /// When passes are there already.
    pub fn keep_layers(&mut self, selection: LayerSelection, limit: u64) -> Result<(), FilmError> {
        if self.passes > 0 {
            return Err(FilmError::Incompatible);
        }
        self.layers = Some(Layers::new(self.width(), self.height(), selection, limit));
        Ok(())
    }

    /// The layers that [`Film::keep_layers`] asks for.
    #[must_use]
    pub fn layers(&self) -> Option<&Layers> {
        self.layers.as_ref()
    }

    /// The same, to be filled.
    #[must_use]
    pub fn layers_mut(&mut self) -> Option<&mut Layers> {
        self.layers.as_mut()
    }

    /// Adds one sample in every pixel, row by row from the top left. The result is the same on any number of threads.
    ///
    /// # Errors
    /// When the number of pixels is another one.
    pub fn add_pass(&mut self, pass: &[Rgb]) -> Result<(), FilmError> {
        if pass.len() != self.sum.len() {
            return Err(FilmError::Count { what: "pixels", expected: self.sum.len(), found: pass.len() });
        }
        let grid = &self.statistics.grid;
        let (columns, width) = (grid.columns(), grid.width() as usize);
        let band = width * BLOCK_SIDE as usize;
        let mask = self.mask.as_deref();
        let mut means = vec![Rgb::BLACK; grid.len()];
        // A band of blocks has one owner and is summed in one order, whichever thread it is.
        let bands = self
            .sum
            .par_chunks_mut(band)
            .zip(self.sum_of_squares.par_chunks_mut(band))
            .zip(pass.par_chunks(band))
            .zip(means.par_chunks_mut(columns));
        bands.enumerate().for_each(|(index, (((sum, squares), pass), means))| {
            add_squares(sum, squares, pass);
            match mask {
                None => add_blocks(means, pass, width),
                Some(mask) => add_counted_blocks(means, pass, &mask[index * band..], width),
            }
        });
        for (mean, &pixels) in means.iter_mut().zip(grid.pixels()) {
            *mean = *mean / f64::from(pixels.max(1));
        }
        self.statistics.add_pass(&means)?;
        if let Some(restricted) = &mut self.restricted {
            restricted.add_pass(&means)?;
        }
        self.passes += 1;
        Ok(())
    }

    /// Adds the passes of another render of the same size and mask, with another seed or other samples. What either has
    /// learnt is forgotten: it is about its own passes.
    ///
    /// # Errors
    /// When size or mask differ.
    pub fn merge(&mut self, other: &Self) -> Result<(), FilmError> {
        if self.mask != other.mask {
            return Err(FilmError::Incompatible);
        }
        match (&mut self.restricted, &other.restricted) {
            (None, None) => {}
            (Some(mine), Some(theirs)) => mine.merge(theirs)?,
            _ => return Err(FilmError::Incompatible),
        }
        match (&mut self.layers, &other.layers) {
            (None, None) => {}
            (Some(mine), Some(theirs)) => mine.merge(theirs)?,
            _ => return Err(FilmError::Incompatible),
        }
        self.statistics.merge(&other.statistics)?;
        for (mine, &theirs) in self.sum.iter_mut().zip(&other.sum) {
            *mine += theirs;
        }
        for (mine, &theirs) in self.sum_of_squares.iter_mut().zip(&other.sum_of_squares) {
            *mine += theirs;
        }
        self.passes += other.passes;
        self.counters.merge(&other.counters);
        self.learnt.clear();
        Ok(())
    }

    /// The mean over passes; black before the first.
    #[must_use]
    pub fn mean_image(&self) -> Image {
        let n = self.passes.max(1) as f64;
        self.image(self.sum.iter().map(|&sum| sum / n).collect())
    }

    /// The estimated standard error of each pixel's mean, `√(variance / passes)`; `None` below two passes.
    #[must_use]
    pub fn standard_error_image(&self) -> Option<Image> {
        if self.passes < 2 {
            return None;
        }
        let pixels = self.sum.iter().zip(&self.sum_of_squares);
        Some(self.image(pixels.map(|(&sum, &squares)| standard_error(sum, squares, self.passes)).collect()))
    }

    fn image(&self, pixels: Vec<Rgb>) -> Image {
        Image { width: self.width(), height: self.height(), pixels }
    }
}

/// The estimated standard error of a mean, `√((Σ x² − (Σ x)²/n) / (n (n − 1)))`, per channel, for n ≥ 2.
pub(super) fn standard_error(sum: Rgb, squares: Rgb, passes: u64) -> Rgb {
    let n = passes as f64;
    // Rounding may leave a tiny negative variance, but NaN must stay NaN: hence no f64::max.
    let error = |sum: f64, squares: f64| {
        let variance = (squares - sum * sum / n) / (n * (n - 1.0));
        if variance < 0.0 { 0.0 } else { variance.sqrt() }
    };
    Rgb::new(error(sum.r, squares.r), error(sum.g, squares.g), error(sum.b, squares.b))
}

fn add_squares(sum: &mut [Rgb], squares: &mut [Rgb], pass: &[Rgb]) {
    for ((sum, squares), &value) in sum.iter_mut().zip(squares).zip(pass) {
        *sum += value;
        *squares += value * value;
    }
}

fn add_blocks(sums: &mut [Rgb], band: &[Rgb], width: usize) {
    for row in band.chunks(width) {
        for (sum, pixels) in sums.iter_mut().zip(row.chunks(BLOCK_SIDE as usize)) {
            *sum += pixels.iter().copied().sum::<Rgb>();
        }
    }
}

fn add_counted_blocks(sums: &mut [Rgb], band: &[Rgb], mask: &[bool], width: usize) {
    let side = BLOCK_SIDE as usize;
    for (row, mask) in band.chunks(width).zip(mask.chunks(width)) {
        for ((sum, pixels), mask) in sums.iter_mut().zip(row.chunks(side)).zip(mask.chunks(side)) {
            *sum += pixels.iter().zip(mask).filter(|(_, counts)| **counts).map(|(&pixel, _)| pixel).sum::<Rgb>();
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    /// A uniform number in \[0, 1).
    fn uniform(random: &mut Xoshiro256PlusPlus) -> f64 {
        (random.next_u64() >> 11) as f64 * 0.5_f64.powi(53)
    }

    fn passes(width: u32, height: u32, count: usize, seed: u64) -> Vec<Vec<Rgb>> {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut pixel = || Rgb::new(uniform(&mut random), uniform(&mut random), uniform(&mut random));
        (0..count).map(|_| (0..width * height).map(|_| pixel()).collect()).collect()
    }

    fn film(width: u32, height: u32, mask: Option<Vec<bool>>, passes: &[Vec<Rgb>]) -> Film {
        let mut film = Film::new(width, height, mask).unwrap();
        passes.iter().for_each(|pass| film.add_pass(pass).unwrap());
        film
    }

    #[test]
    fn a_film_without_pixels_is_refused() {
        assert_eq!(Film::new(0, 0, None), Err(FilmError::Size { width: 0, height: 0 }));
        assert!(Film::new(4, 4, Some(vec![true; 15])).is_err());
        assert!(Film::new(4, 4, None).unwrap().add_pass(&[Rgb::WHITE; 15]).is_err());
    }

    #[test]
    fn any_number_of_threads_gives_the_same_bits() {
        let passes = passes(70, 90, 5, 1);
        let mask: Vec<bool> = (0..70 * 90).map(|i| i % 7 != 0).collect();
        let on = |threads: usize, mask: Option<Vec<bool>>| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| film(70, 90, mask, &passes))
        };
        for mask in [None, Some(mask)] {
            let one = on(1, mask.clone());
            assert_eq!(one, on(3, mask.clone()));
            assert_eq!(one, on(8, mask));
        }
    }

    #[test]
    fn mean_and_standard_error_equal_their_definitions() {
        let passes = passes(20, 18, 7, 2);
        let film = film(20, 18, None, &passes);
        let (mean, error) = (film.mean_image(), film.standard_error_image().unwrap());
        for i in 0..20 * 18 {
            let values: Vec<f64> = passes.iter().map(|pass| pass[i].g).collect();
            let expected = values.iter().sum::<f64>() / 7.0;
            let variance = values.iter().map(|x| (x - expected) * (x - expected)).sum::<f64>() / 6.0;
            assert!((mean.pixels[i].g - expected).abs() < 1e-14);
            assert!((error.pixels[i].g - (variance / 7.0).sqrt()).abs() < 1e-12);
        }
    }

    #[test]
    fn block_statistics_are_those_of_the_pass_images() {
        let passes = passes(40, 35, 6, 3);
        let mask: Vec<bool> = (0..40 * 35).map(|i| i % 3 != 0).collect();
        for mask in [None, Some(mask)] {
            let film = film(40, 35, mask.clone(), &passes);
            let grid = BlockGrid::new(40, 35, mask.as_deref()).unwrap();
            let mut expected = BlockStatistics::new(grid);
            for pass in &passes {
                let image = Image::new(40, 35, pass.clone()).unwrap();
                expected.add_pass(&image.block_means(mask.as_deref()).unwrap()).unwrap();
            }
            for (a, b) in film.block_statistics().blocks().iter().flatten().zip(expected.blocks().iter().flatten()) {
                assert_eq!(a.count, b.count);
                assert!((a.mean - b.mean).abs() < 1e-13 && (a.variance() - b.variance()).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn restricted_statistics_see_the_kept_blocks_alone() {
        let passes = passes(40, 35, 6, 3);
        let keep: Vec<bool> = (0..9).map(|block| block % 2 == 0).collect();
        let mut restricted = Film::new(40, 35, None).unwrap();
        restricted.keep_restricted(&keep).unwrap();
        let mask = (0..40 * 35).map(|i| keep[restricted.block_statistics().grid().block_of(i % 40, i / 40)]).collect();
        let masked = film(40, 35, Some(mask), &passes);
        passes.iter().for_each(|pass| restricted.add_pass(pass).unwrap());
        assert_eq!(restricted.restricted_statistics(), Some(masked.block_statistics()));
        assert_eq!(restricted.block_statistics(), film(40, 35, None, &passes).block_statistics());
        assert!(restricted.keep_restricted(&keep).is_err());
        assert!(Film::new(40, 35, None).unwrap().keep_restricted(&keep[1..]).is_err());
    }

    #[test]
    fn merged_films_hold_the_passes_of_both() {
        let passes = passes(20, 20, 9, 4);
        let whole = film(20, 20, None, &passes);
        let mut parts = film(20, 20, None, &passes[..4]);
        parts.merge(&film(20, 20, None, &passes[4..])).unwrap();
        assert_eq!(parts.passes(), 9);
        for (a, b) in parts.mean_image().pixels.iter().zip(&whole.mean_image().pixels) {
            assert!((a.r - b.r).abs() < 1e-14);
        }
        assert_eq!(parts.merge(&Film::new(20, 21, None).unwrap()), Err(FilmError::Incompatible));
        assert_eq!(parts.merge(&Film::new(20, 20, Some(vec![true; 400])).unwrap()), Err(FilmError::Incompatible));
    }

    #[test]
    fn a_nan_stays_in_its_pixel_and_in_its_standard_error() {
        let mut passes = passes(4, 4, 3, 5);
        passes[1][6].g = f64::NAN;
        let film = film(4, 4, None, &passes);
        assert!(film.mean_image().pixels[6].g.is_nan());
        assert!(film.standard_error_image().unwrap().pixels[6].g.is_nan());
        assert!(film.mean_image().pixels[5].is_finite());
    }
}
