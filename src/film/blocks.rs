//! Blocks of pixels and their statistics over passes.
//!
//! Pixels of one pass may depend on each other (a light path reaches many of them), so the spread of a block's mean
//! cannot be told from the spread of its pixels. Passes are independent: the spread over passes can.

use crate::spectrum::Rgb;

use serde::{Deserialize, Serialize};

use super::error::FilmError;
use super::image::{Image, pixel_count};
use super::moments::Moments;

/// A reference's error is known as if from so many passes: its Student distribution is the normal one.
const AS_IF_PASSES: u64 = 1 << 24;

/// Side of a block in pixels; the last blocks of a row or column may be smaller.
pub const BLOCK_SIDE: u32 = 16;

/// How an image is cut into blocks, and how many pixels count in each.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BlockGrid {
    width: u32,
    height: u32,
    pixels: Vec<u32>,
}

impl BlockGrid {
    /// Blocks of an image; `mask` says which pixels count, all of them where there is none.
    ///
    /// # Errors
    /// When there are no pixels, or the mask is not one value for each.
    pub fn new(width: u32, height: u32, mask: Option<&[bool]>) -> Result<Self, FilmError> {
        let expected = pixel_count(width, height)?;
        if let Some(mask) = mask
            && mask.len() != expected
        {
            return Err(FilmError::Count { what: "values of the mask", expected, found: mask.len() });
        }
        let mut grid = Self { width, height, pixels: Vec::new() };
        grid.pixels = vec![0; grid.columns() * grid.rows()];
        for index in 0..expected {
            if mask.is_none_or(|mask| mask[index]) {
                let (x, y) = (index % width as usize, index / width as usize);
                let block = grid.block_of(x as u32, y as u32);
                grid.pixels[block] += 1;
            }
        }
        Ok(grid)
    }

    /// The same blocks, of which those count no pixels for which `keep` does not hold.
    ///
    /// # Errors
    /// When `keep` is not one value for each block.
    pub fn restricted(&self, keep: &[bool]) -> Result<Self, FilmError> {
        if keep.len() != self.pixels.len() {
            return Err(FilmError::Count { what: "blocks", expected: self.pixels.len(), found: keep.len() });
        }
        let pixels = self.pixels.iter().zip(keep).map(|(&pixels, &keep)| if keep { pixels } else { 0 }).collect();
        Ok(Self { pixels, ..*self })
    }

    /// Pixels in a row of the image.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows of pixels of the image.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Blocks in a row.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.width.div_ceil(BLOCK_SIDE) as usize
    }

    /// Rows of blocks.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.height.div_ceil(BLOCK_SIDE) as usize
    }

    /// Number of blocks, at least 1.
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "no grid is empty")]
    pub fn len(&self) -> usize {
        self.pixels.len()
    }

    /// The block of the pixel in column `x` and row `y`.
    #[must_use]
    pub fn block_of(&self, x: u32, y: u32) -> usize {
        (y / BLOCK_SIDE) as usize * self.columns() + (x / BLOCK_SIDE) as usize
    }

    /// How many pixels count in each block, row by row of blocks.
    #[must_use]
    pub fn pixels(&self) -> &[u32] {
        &self.pixels
    }
}

/// Moments over passes of the mean value of each block and of the whole image.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BlockStatistics {
    pub(super) grid: BlockGrid,
    pub(super) blocks: Vec<[Moments; 3]>,
    pub(super) image: [Moments; 4],
}

impl BlockStatistics {
    /// Before the first pass.
    #[must_use]
    pub fn new(grid: BlockGrid) -> Self {
        let blocks = vec![[Moments::default(); 3]; grid.len()];
        Self { grid, blocks, image: [Moments::default(); 4] }
    }

    /// From the block means of several passes: `passes · rows · columns · 3` numbers in this order, as another renderer
    /// reports them. Blocks in which no pixel counts may hold anything.
    ///
    /// # Errors
    /// When the shape is another one.
    pub fn from_passes(grid: BlockGrid, shape: &[usize], means: &[f64]) -> Result<Self, FilmError> {
        let per_pass = grid.len() * 3;
        let &[passes, rows, columns, 3] = shape else {
            return Err(FilmError::Count { what: "dimensions or channels", expected: 4, found: shape.len() });
        };
        if (rows, columns) != (grid.rows(), grid.columns()) {
            return Err(FilmError::Count { what: "blocks", expected: grid.len(), found: rows.saturating_mul(columns) });
        }
        let expected = passes.saturating_mul(per_pass);
        if means.len() != expected {
            return Err(FilmError::Count { what: "numbers", expected, found: means.len() });
        }
        let mut statistics = Self::new(grid);
        let mut pass = Vec::with_capacity(statistics.grid.len());
        for numbers in means.chunks_exact(per_pass) {
            pass.clear();
            pass.extend(numbers.chunks_exact(3).map(|c| Rgb::new(c[0], c[1], c[2])));
            statistics.add_pass(&pass)?;
        }
        Ok(statistics)
    }

    /// Of a mean image and the variance of each of its pixels, as if from many passes. Pixels count as independent; the
    /// luminance's error as if channels erred together. A pixel's third moment is taken for that of a single outlier, `v^(3/2)`:
    /// a block whose variance is that of few pixels is as heavy-tailed as they may be.
    ///
    /// # Errors
    /// When an image has another size than the grid.
    pub fn of_reference(grid: BlockGrid, mean: &Image, variance: &Image) -> Result<Self, FilmError> {
        let pixels = grid.width as usize * grid.height as usize;
        for image in [mean, variance] {
            if image.pixels.len() != pixels {
                return Err(FilmError::Count { what: "pixels", expected: pixels, found: image.pixels.len() });
            }
        }
        // Of each block and of the image: pixels, and sums of value, variance, variance^(3/2) for r, g, b, luminance.
        let mut sums = vec![[[0.0; 3]; 4]; grid.len() + 1];
        for index in 0..pixels {
            let block = grid.block_of(index as u32 % grid.width, index as u32 / grid.width);
            if grid.pixels[block] == 0 {
                continue;
            }
            let (value, error) = (mean.pixels[index], variance.pixels[index].map(f64::sqrt));
            let values = [value.r, value.g, value.b, value.luminance()];
            let errors = [error.r, error.g, error.b, error.luminance()];
            for place in [block, grid.len()] {
                for (sum, (value, error)) in sums[place].iter_mut().zip(values.into_iter().zip(errors)) {
                    let [first, second, third] = sum;
                    *first += value;
                    *second += error * error;
                    *third += error * error * error;
                }
            }
        }
        let moments = |[first, second, third]: [f64; 3], pixels: f64| {
            let (mean, count) = (first / pixels, AS_IF_PASSES as f64);
            Moments {
                count: AS_IF_PASSES,
                mean,
                second: second / (pixels * pixels) * count * (count - 1.0),
                third: third / (pixels * pixels * pixels) * count * count * count,
                largest: mean.abs(),
            }
        };
        let mut statistics = Self::new(grid);
        let total: f64 = statistics.grid.pixels.iter().map(|&pixels| f64::from(pixels)).sum();
        let image = sums.pop().unwrap_or_default();
        statistics.image = image.map(|sum| moments(sum, total));
        for ((block, sum), &pixels) in statistics.blocks.iter_mut().zip(sums).zip(&statistics.grid.pixels) {
            if pixels > 0 {
                *block = [0, 1, 2].map(|channel| moments(sum[channel], f64::from(pixels)));
            }
        }
        Ok(statistics)
    }

    /// Adds the block means of one pass, row by row of blocks.
    ///
    /// # Errors
    /// When their number is not that of the blocks.
    pub fn add_pass(&mut self, means: &[Rgb]) -> Result<(), FilmError> {
        if means.len() != self.blocks.len() {
            return Err(FilmError::Count { what: "blocks", expected: self.blocks.len(), found: means.len() });
        }
        let mut sum = Rgb::BLACK;
        let mut total = 0_u64;
        for ((block, &mean), &pixels) in self.blocks.iter_mut().zip(means).zip(&self.grid.pixels) {
            if pixels == 0 {
                continue;
            }
            sum += mean * f64::from(pixels);
            total += u64::from(pixels);
            for (moments, value) in block.iter_mut().zip(mean.to_array()) {
                moments.push(value);
            }
        }
        let mean = sum / total.max(1) as f64;
        for (moments, value) in self.image.iter_mut().zip([mean.r, mean.g, mean.b, mean.luminance()]) {
            moments.push(value);
        }
        Ok(())
    }

    /// Adds the passes of another render of the same size and mask, such as one with another seed.
    ///
    /// # Errors
    /// When size or mask differ.
    pub fn merge(&mut self, other: &Self) -> Result<(), FilmError> {
        if self.grid != other.grid {
            return Err(FilmError::Incompatible);
        }
        for (mine, theirs) in self.blocks.iter_mut().flatten().zip(other.blocks.iter().flatten()) {
            mine.merge(theirs);
        }
        for (mine, theirs) in self.image.iter_mut().zip(&other.image) {
            mine.merge(theirs);
        }
        Ok(())
    }

    /// How the image is cut into blocks.
    #[must_use]
    pub fn grid(&self) -> &BlockGrid {
        &self.grid
    }

    /// Number of passes.
    #[must_use]
    pub fn passes(&self) -> u64 {
        self.image[0].count
    }

    /// Moments of each block's mean, red, green and blue; without numbers in blocks where no pixel counts.
    #[must_use]
    pub fn blocks(&self) -> &[[Moments; 3]] {
        &self.blocks
    }

    /// Moments of the mean over all pixels that count: red, green, blue, luminance.
    #[must_use]
    pub fn image(&self) -> &[Moments; 4] {
        &self.image
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_whole_image_weighs_blocks_by_the_pixels_that_count() {
        let grid = BlockGrid::new(17, 1, None).unwrap();
        assert_eq!((grid.columns(), grid.rows(), grid.pixels()), (2, 1, &[16, 1][..]));
        let mut statistics = BlockStatistics::new(grid);
        statistics.add_pass(&[Rgb::grey(1.0), Rgb::grey(18.0)]).unwrap();
        assert!((statistics.image()[3].mean - 2.0).abs() < 1e-12);
    }

    #[test]
    fn a_reference_has_the_variance_of_its_pixels_and_a_firefly_makes_its_block_heavy() {
        let grid = BlockGrid::new(32, 16, None).unwrap();
        let mean = Image::constant(32, 16, Rgb::new(1.0, 2.0, 3.0)).unwrap();
        let mut variance = Image::constant(32, 16, Rgb::grey(0.04)).unwrap();
        variance.pixels[20].r = 4e4;
        let statistics = BlockStatistics::of_reference(grid, &mean, &variance).unwrap();
        let [calm, wild] = [0, 1].map(|block| statistics.blocks()[block][0]);
        let close = |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
        close(calm.variance_of_mean(), 0.04 / 256.0);
        close(statistics.blocks()[1][2].variance_of_mean(), 0.04 / 256.0);
        let skewness = |m: Moments| m.third_of_mean() / m.variance_of_mean().powf(1.5);
        close(skewness(calm), 1.0 / 16.0);
        assert!(skewness(wild) > 0.99);
        assert_eq!((calm.mean, statistics.image()[2].mean), (1.0, 3.0));
    }

    #[test]
    fn passes_of_another_renderer_are_read_in_order_of_pass_row_column_channel() {
        let grid = BlockGrid::new(20, 20, None).unwrap();
        let means: Vec<f64> = (0..2 * 2 * 2 * 3).map(f64::from).collect();
        let statistics = BlockStatistics::from_passes(grid.clone(), &[2, 2, 2, 3], &means).unwrap();
        assert_eq!(statistics.passes(), 2);
        assert_eq!(statistics.blocks()[1][2].mean, (5.0 + 17.0) / 2.0);
        for shape in [&[2, 2, 2][..], &[2, 2, 2, 4], &[3, 2, 2, 3], &[2, 4, 1, 3], &[usize::MAX, 2, 2, 3]] {
            assert!(BlockStatistics::from_passes(grid.clone(), shape, &means).is_err());
        }
    }

    #[test]
    fn blocks_without_pixels_that_count_take_no_numbers() {
        let mask: Vec<bool> = (0..17).map(|x| x < 16).collect();
        let mut statistics = BlockStatistics::new(BlockGrid::new(17, 1, Some(&mask)).unwrap());
        statistics.add_pass(&[Rgb::WHITE, Rgb::grey(f64::NAN)]).unwrap();
        assert_eq!(statistics.blocks()[1][0].count, 0);
        assert_eq!(statistics.image()[0].mean, 1.0);
    }
}
