//! Images of several seeds: their bias and their variance, told apart.

use crate::film::Image;
use crate::spectrum::Rgb;

use super::metrics::Reference;

/// Mean and spread of images with independent random numbers, pixel by pixel.
#[derive(Clone, Debug, Default)]
pub struct Replicas {
    count: u32,
    mean: Option<Image>,
    /// Sums of squared deviations from the mean (Welford 1962).
    squares: Vec<Rgb>,
}

/// Squared bias with its standard error, both means over pixels and channels \[radiance²\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bias {
    /// `1/(3N) Σ ((x̄ − r)² − s²/n − v)` of the mean x̄ of n images, their variance s², the reference r and its variance v.
    pub squared: f64,
    /// From the spread over the N pixels, taken as independent.
    pub error: f64,
}

impl Replicas {
    /// Adds an image; one of another size, or that is not finite somewhere, is left out.
    pub fn add(&mut self, image: &Image) {
        if image.pixels.iter().any(|pixel| !pixel.is_finite()) {
            return;
        }
        let Some(mean) = &mut self.mean else {
            (self.count, self.squares) = (1, vec![Rgb::BLACK; image.pixels.len()]);
            self.mean = Some(image.clone());
            return;
        };
        if (mean.width, mean.height) != (image.width, image.height) {
            return;
        }
        self.count += 1;
        let n = f64::from(self.count);
        for ((mean, squares), &x) in mean.pixels.iter_mut().zip(&mut self.squares).zip(&image.pixels) {
            let before = x - *mean;
            *mean += before / n;
            *squares += before * (x - *mean);
        }
    }

    /// The mean of all.
    #[must_use]
    pub fn mean(&self) -> Option<&Image> {
        self.mean.as_ref()
    }

    /// Of one image, pixel by pixel; `None` below two images.
    #[must_use]
    pub fn variance_image(&self) -> Option<Image> {
        let mean = self.mean.as_ref().filter(|_| self.count > 1)?;
        let n = f64::from(self.count);
        Some(Image { pixels: self.squares.iter().map(|&squares| squares / (n - 1.0)).collect(), ..*mean })
    }

    /// Of one image, mean over pixels and channels.
    #[must_use]
    pub fn variance(&self) -> Option<f64> {
        let image = self.variance_image()?;
        let sum: f64 = image.pixels.iter().flat_map(|pixel| pixel.to_array()).sum();
        Some(sum / (3.0 * image.pixels.len() as f64))
    }

    /// `None` below two images, and where the reference is of another size or its variance is not known.
    #[must_use]
    pub fn bias(&self, reference: &Reference) -> Option<Bias> {
        let (variance, mean) = (self.variance_image()?, self.mean.as_ref()?);
        let noise = reference.variance.as_ref().filter(|noise| noise.pixels.len() == mean.pixels.len())?;
        let n = f64::from(self.count);
        let pixels: Vec<f64> = (0..mean.pixels.len())
            .map(|i| {
                let difference = mean.pixels[i] - reference.mean.pixels[i];
                let [r, g, b] = (difference * difference - variance.pixels[i] / n - noise.pixels[i]).to_array();
                (r + g + b) / 3.0
            })
            .collect();
        let count = pixels.len() as f64;
        let squared = pixels.iter().sum::<f64>() / count;
        let spread: f64 = pixels.iter().map(|pixel| (pixel - squared) * (pixel - squared)).sum();
        Some(Bias { squared, error: (spread / (count - 1.0) / count).sqrt() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Unit variance around 5 and a bias.
    fn image(salt: u64, bias: f64) -> Image {
        let unit = |i: u64| {
            let bits = xxhash_rust::xxh3::xxh3_64_with_seed(&i.to_le_bytes(), salt);
            (bits >> 11) as f64 * 2.0_f64.powi(-53)
        };
        let normal = |i: u64| (0..12).map(|j| unit(12 * i + j)).sum::<f64>() - 6.0;
        let pixel = |p: u64| Rgb::from([0, 1, 2].map(|c| 5.0 + bias + normal(3 * p + c)));
        Image::new(64, 64, (0..64 * 64).map(pixel).collect()).unwrap()
    }

    /// Four images of 12 288 values. The standard error of the squared bias is √(2/12288)/4 = 0.0032, of the variance
    /// √(2/3/12288) = 0.0074; four of them are allowed, and a bias of 0.15, whose square is 0.0225, is seen.
    #[test]
    fn bias_and_variance_are_told_apart() {
        let reference = Reference::exact(Image::constant(64, 64, Rgb::grey(5.0)).unwrap());
        for (bias, seen) in [(0.0, false), (0.15, true)] {
            let mut replicas = Replicas::default();
            (0..4).for_each(|salt| replicas.add(&image(salt, bias)));
            let found = replicas.bias(&reference).unwrap();
            assert!((found.squared - bias * bias).abs() < 4.0 * 0.0035, "{found:?}");
            assert!((found.error / 0.0032 - 1.0).abs() < 0.3, "{found:?}");
            assert_eq!(found.squared > 4.0 * found.error, seen, "{found:?}");
            assert!((replicas.variance().unwrap() - 1.0).abs() < 4.0 * 0.0074);
        }
    }

    #[test]
    fn what_cannot_be_told_is_none() {
        let exact = Reference::exact(Image::constant(64, 64, Rgb::grey(5.0)).unwrap());
        let mut replicas = Replicas::default();
        replicas.add(&image(1, 0.0));
        assert!(replicas.variance().is_none() && replicas.bias(&exact).is_none());
        replicas.add(&Image::constant(64, 64, Rgb::grey(f64::NAN)).unwrap());
        replicas.add(&Image::constant(3, 2, Rgb::grey(1.0)).unwrap());
        assert!(replicas.variance().is_none());
        replicas.add(&image(2, 0.0));
        assert!(replicas.bias(&exact).is_some());
        assert!(replicas.bias(&Reference { variance: None, ..exact }).is_none());
    }
}
