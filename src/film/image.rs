//! A finished image in linear colours.

use crate::spectrum::Rgb;

use super::blocks::BlockGrid;
use super::error::FilmError;

/// An image in linear RGB, row by row from the top left. The unit is that of what was rendered, mostly \[W/m²/sr\].
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels in a row, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// `width · height` pixels; that of column x and row y has the index `y · width + x`.
    pub pixels: Vec<Rgb>,
}

/// The number of pixels, where it is neither zero nor beyond 2²⁸.
pub(super) fn pixel_count(width: u32, height: u32) -> Result<usize, FilmError> {
    let count = u64::from(width) * u64::from(height);
    if count == 0 || count > 1 << 28 {
        return Err(FilmError::Size { width, height });
    }
    Ok(count as usize)
}

impl Image {
    /// From its pixels, row by row from the top left.
    ///
    /// # Errors
    /// When the number of pixels is zero or is not `width · height`.
    pub fn new(width: u32, height: u32, pixels: Vec<Rgb>) -> Result<Self, FilmError> {
        let expected = pixel_count(width, height)?;
        if pixels.len() != expected {
            return Err(FilmError::Count { what: "pixels", expected, found: pixels.len() });
        }
        Ok(Self { width, height, pixels })
    }

    /// The same value everywhere.
    ///
    /// # Errors
    /// When there are no pixels.
    pub fn constant(width: u32, height: u32, value: Rgb) -> Result<Self, FilmError> {
        Ok(Self { width, height, pixels: vec![value; pixel_count(width, height)?] })
    }

    /// From a function of column and row.
    ///
    /// # Errors
    /// When there are no pixels.
    pub fn from_fn(width: u32, height: u32, mut value: impl FnMut(u32, u32) -> Rgb) -> Result<Self, FilmError> {
        let mut pixels = Vec::with_capacity(pixel_count(width, height)?);
        for y in 0..height {
            pixels.extend((0..width).map(|x| value(x, y)));
        }
        Ok(Self { width, height, pixels })
    }

    /// The pixel of column `x` and row `y`; `None` outside.
    #[must_use]
    pub fn get(&self, x: u32, y: u32) -> Option<Rgb> {
        (x < self.width && y < self.height).then(|| self.pixels[y as usize * self.width as usize + x as usize])
    }

    /// All pixels with column and row, row by row.
    pub fn enumerate(&self) -> impl Iterator<Item = ((u32, u32), Rgb)> + '_ {
        let place = |index: usize| ((index % self.width as usize) as u32, (index / self.width as usize) as u32);
        self.pixels.iter().enumerate().map(move |(index, &pixel)| (place(index), pixel))
    }

    /// The mean over all pixels, `1/N Σ_i x_i`, per channel.
    #[must_use]
    pub fn mean(&self) -> Rgb {
        self.pixels.iter().copied().sum::<Rgb>() / self.pixels.len() as f64
    }

    /// The mean over the pixels of each block that the mask leaves, row by row of blocks; zero in blocks without any.
    ///
    /// # Errors
    /// When the mask is not one value for each pixel.
    pub fn block_means(&self, mask: Option<&[bool]>) -> Result<Vec<Rgb>, FilmError> {
        let grid = BlockGrid::new(self.width, self.height, mask)?;
        let mut sums = vec![Rgb::BLACK; grid.len()];
        for (index, ((x, y), pixel)) in self.enumerate().enumerate() {
            if mask.is_none_or(|mask| mask[index]) {
                sums[grid.block_of(x, y)] += pixel;
            }
        }
        for (sum, &pixels) in sums.iter_mut().zip(grid.pixels()) {
            *sum = *sum / f64::from(pixels.max(1));
        }
        Ok(sums)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_without_pixels_are_refused() {
        assert_eq!(Image::new(0, 0, vec![]), Err(FilmError::Size { width: 0, height: 0 }));
        assert_eq!(Image::constant(0, 5, Rgb::WHITE), Err(FilmError::Size { width: 0, height: 5 }));
        assert!(Image::constant(u32::MAX, u32::MAX, Rgb::WHITE).is_err());
        assert!(Image::new(2, 2, vec![Rgb::WHITE; 3]).is_err());
    }

    #[test]
    fn pixels_run_row_by_row_from_the_top_left() {
        let image = Image::from_fn(3, 2, |x, y| Rgb::new(f64::from(x), f64::from(y), 0.0)).unwrap();
        assert_eq!(image.pixels[4], Rgb::new(1.0, 1.0, 0.0));
        assert_eq!(image.get(2, 1), Some(Rgb::new(2.0, 1.0, 0.0)));
        assert_eq!(image.get(3, 0), None);
        assert!(image.enumerate().all(|((x, y), pixel)| image.get(x, y) == Some(pixel)));
        assert_eq!(image.mean(), Rgb::new(1.0, 0.5, 0.0));
    }

    #[test]
    fn block_means_leave_out_masked_pixels_and_weigh_the_rest_equally() {
        // 17 × 1 pixels: a full block and one of a single pixel.
        let image = Image::from_fn(17, 1, |x, _| Rgb::grey(f64::from(x))).unwrap();
        assert_eq!(image.block_means(None).unwrap(), [Rgb::grey(7.5), Rgb::grey(16.0)]);
        let mask: Vec<bool> = (0..17).map(|x| x < 2).collect();
        assert_eq!(image.block_means(Some(&mask)).unwrap(), [Rgb::grey(0.5), Rgb::BLACK]);
    }
}
