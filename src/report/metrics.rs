//! How far an image is from its reference.
//!
//! With `x` the image, `r` the reference, `v` the variance of its pixels where it is known (else 0), `ε` = 0.01, and sums over the
//! 3 channels of the N pixels in which `x` is finite:
//!
//! | metric | formula | unit |
//! |---|---|---|
//! | MSE | `1/(3N) Σ ((x − r)² − v)` | radiance² |
//! | RMSE | `√MSE` | radiance |
//! | relMSE | `1/(3N) Σ ((x − r)² − v) / (r² + ε)` | 1 |
//! | MAPE | `1/(3N) Σ |x − r| / (|r| + ε)` | 1 |
//! | SMAPE | `1/(3N) Σ |x − r| / (|x| + |r|)`, a term being 0 where both are 0 | 1, from 0 to 1 |
//! | trimmed | MSE, relMSE without the 0.1 % of pixels with the largest | as they |
//! | FLIP | mean of ꟻLIP over pixels, see [`super::flip`] | 1, from 0 to 1 |
//! | mean ratio | `Σ x / Σ r` | 1 |
//!
//! relMSE is the relative error in the form customary since Rousselle, Knaus and Zwicker (2011); its constant 0.01 is in
//! radiance², so what is much darker than 0.1 counts by its absolute error. As `E (x − r̂)² = E (x − r)² + v` for a reference r̂ that is
//! independent of the image, the noise of the reference is taken off the squared errors: they are unbiased, and may be
//! negative by chance where they are smaller than that noise, which [`Errors::below_reference_noise`] tells. Absolute errors and FLIP
//! keep it. Pixels in which the image is not finite are counted in [`Errors::invalid`] and left out of all sums: a metric beside a
//! non-zero count says nothing of them. Trimming hides lost light and fireflies alike; the mean ratio shows them.

use crate::film::Image;
use crate::spectrum::Rgb;

use super::error::ReportError;

/// The constant of relMSE \[radiance²\] and of MAPE \[radiance\].
pub const EPSILON: f64 = 0.01;

/// The share of pixels that trimmed errors leave out.
pub const TRIMMED: f64 = 0.001;

/// What images are measured against.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// The image.
    pub mean: Image,
    /// Squared standard error of each pixel, where it is known.
    pub variance: Option<Image>,
}

impl Reference {
    /// Without noise.
    #[must_use]
    pub fn exact(mean: Image) -> Self {
        let variance = Some(Image { pixels: vec![Rgb::BLACK; mean.pixels.len()], ..mean });
        Self { mean, variance }
    }
}

/// The metrics of one image. All are NaN where no pixel is left, the mean ratio also over a black reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// Mean squared error without the reference's noise \[radiance²\].
    pub mse: f64,
    /// Its root; `None` where it is negative \[radiance\].
    pub rmse: Option<f64>,
    /// Mean squared error relative to the reference, without the reference's noise.
    pub relmse: f64,
    /// Mean absolute error relative to the reference.
    pub mape: f64,
    /// Symmetric mean absolute relative error, 0 … 1.
    pub smape: f64,
    /// MSE without the pixels that have most of it \[radiance²\].
    pub trimmed_mse: f64,
    /// relMSE without the pixels that have most of it.
    pub trimmed_relmse: f64,
    /// Mean of the image over mean of the reference: 1 where energy is right.
    pub mean_ratio: f64,
    /// What the reference's noise alone makes of the MSE; `None` where it is not known \[radiance²\].
    pub reference_mse: Option<f64>,
    /// The same of relMSE.
    pub reference_relmse: Option<f64>,
    /// Pixels that are not finite, and left out.
    pub invalid: u64,
}

/// A pixel's sums over channels.
#[derive(Clone, Copy)]
struct Squares {
    square: f64,
    relative: f64,
    noise: f64,
    relative_noise: f64,
}

impl Errors {
    /// Of `image` against `reference`.
    ///
    /// # Errors
    /// When sizes differ or the reference is not finite.
    pub fn between(image: &Image, reference: &Reference) -> Result<Self, ReportError> {
        let mean = &reference.mean;
        for other in std::iter::once(mean).chain(&reference.variance) {
            let (size, expected) = ((image.width, image.height), (other.width, other.height));
            if size != expected || image.pixels.len() != other.pixels.len() {
                return Err(ReportError::Size { image: size, reference: expected });
            }
        }
        let unusable = mean.pixels.iter().filter(|pixel| !pixel.is_finite()).count() as u64;
        if unusable > 0 {
            return Err(ReportError::Reference { count: unusable });
        }
        Ok(Self::of_counted(image, reference))
    }

    /// Squared errors are below what the reference's noise alone makes of them: they say little of the method, and absolute
    /// errors nothing. `None` where the noise is not known.
    #[must_use]
    pub fn below_reference_noise(&self) -> Option<bool> {
        let (mse, relmse) = self.reference_mse.zip(self.reference_relmse)?;
        Some(self.mse < mse || self.relmse < relmse)
    }

    fn of_counted(image: &Image, reference: &Reference) -> Self {
        let mut invalid = 0;
        let [mut absolute, mut symmetric, mut image_sum, mut reference_sum] = [0.0; 4];
        let mut pixels = Vec::with_capacity(image.pixels.len());
        for (index, (x, r)) in image.pixels.iter().zip(&reference.mean.pixels).enumerate() {
            if !x.is_finite() {
                invalid += 1;
                continue;
            }
            let noise = reference.variance.as_ref().map_or(Rgb::BLACK, |variance| variance.pixels[index]);
            let mut pixel = Squares { square: 0.0, relative: 0.0, noise: 0.0, relative_noise: 0.0 };
            for ((x, r), v) in x.to_array().into_iter().zip(r.to_array()).zip(noise.to_array()) {
                let difference = x - r;
                let weight = 1.0 / (r * r + EPSILON);
                pixel.square += difference * difference;
                pixel.relative += difference * difference * weight;
                pixel.noise += v;
                pixel.relative_noise += v * weight;
                absolute += difference.abs() / (r.abs() + EPSILON);
                if difference != 0.0 {
                    symmetric += difference.abs() / (x.abs() + r.abs());
                }
                image_sum += x;
                reference_sum += r;
            }
            pixels.push(pixel);
        }
        let values = 3.0 * pixels.len() as f64;
        let mean = |of: &dyn Fn(&Squares) -> f64| pixels.iter().map(of).sum::<f64>() / values;
        let (reference_mse, reference_relmse) = (mean(&|pixel| pixel.noise), mean(&|pixel| pixel.relative_noise));
        let mse = mean(&|pixel| pixel.square) - reference_mse;
        let relmse = mean(&|pixel| pixel.relative) - reference_relmse;
        let known = |noise: f64| reference.variance.is_some().then_some(noise);
        Self {
            mse,
            rmse: (mse >= 0.0).then(|| mse.sqrt()),
            relmse,
            mape: absolute / values,
            smape: symmetric / values,
            mean_ratio: image_sum / reference_sum,
            reference_mse: known(reference_mse),
            reference_relmse: known(reference_relmse),
            invalid,
            trimmed_mse: trimmed(&mut pixels, |pixel| pixel.square, |pixel| pixel.noise),
            trimmed_relmse: trimmed(&mut pixels, |pixel| pixel.relative, |pixel| pixel.relative_noise),
        }
    }
}

/// The mean of `of` less `noise` without the largest of `of`.
fn trimmed(pixels: &mut [Squares], of: impl Fn(&Squares) -> f64, noise: impl Fn(&Squares) -> f64) -> f64 {
    let kept = pixels.len() - (TRIMMED * pixels.len() as f64).ceil() as usize;
    if kept > 0 && kept < pixels.len() {
        pixels.select_nth_unstable_by(kept, |a, b| of(a).total_cmp(&of(b)));
    }
    pixels[..kept].iter().map(|pixel| of(pixel) - noise(pixel)).sum::<f64>() / (3.0 * kept as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(pixels: &[[f64; 3]]) -> Image {
        Image::new(pixels.len() as u32, 1, pixels.iter().copied().map(Rgb::from).collect()).unwrap()
    }

    fn exact(pixels: &[[f64; 3]]) -> Reference {
        Reference::exact(image(pixels))
    }

    fn expect(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-14, "{found} {expected}");
    }

    #[test]
    fn metrics_equal_their_formulas() {
        let x = image(&[[1.0, 0.0, 0.5], [3.0, 2.0, 0.0]]);
        let r = exact(&[[1.0, 0.0, 1.0], [1.0, 2.0, 0.2]]);
        let errors = Errors::between(&x, &r).unwrap();
        expect(errors.mse, (0.25 + 4.0 + 0.04) / 6.0);
        expect(errors.rmse.unwrap(), errors.mse.sqrt());
        expect(errors.relmse, (0.25 / 1.01 + 4.0 / 1.01 + 0.04 / 0.05) / 6.0);
        expect(errors.mape, (0.5 / 1.01 + 2.0 / 1.01 + 0.2 / 0.21) / 6.0);
        expect(errors.smape, (0.5 / 1.5 + 2.0 / 4.0 + 1.0) / 6.0);
        expect(errors.trimmed_mse, 0.25 / 3.0);
        expect(errors.trimmed_relmse, 0.25 / 1.01 / 3.0);
        expect(errors.mean_ratio, 6.5 / 5.2);
        assert_eq!((errors.invalid, errors.below_reference_noise()), (0, Some(false)));
    }

    #[test]
    fn an_image_equals_itself() {
        let pixels = [[1.0, 0.0, 0.5]; 2];
        let errors = Errors::between(&image(&pixels), &exact(&pixels)).unwrap();
        assert_eq!((errors.mse, errors.relmse, errors.smape, errors.mean_ratio), (0.0, 0.0, 0.0, 1.0));
        assert_eq!((errors.mape, errors.trimmed_mse, errors.rmse), (0.0, 0.0, Some(0.0)));
    }

    /// Image and reference of unit variance around the same mean, apart by nothing but noise: without the reference's, the
    /// MSE is the image's variance. Over 30 000 values its standard error is √(8/30000) = 0.016, less than a third of what is allowed.
    #[test]
    fn the_noise_of_the_reference_is_taken_off() {
        let noise = |salt: u64| {
            // Sums of twelve uniform numbers have unit variance.
            let unit = |i: u64| {
                let bits = xxhash_rust::xxh3::xxh3_64_with_seed(&i.to_le_bytes(), salt);
                (bits >> 11) as f64 * 2.0_f64.powi(-53)
            };
            let normal = move |i: u64| (0..12).map(|j| unit(12 * i + j)).sum::<f64>() - 6.0;
            (0..10_000).map(|p| [0, 1, 2].map(|c| 5.0 + normal(3 * p + c))).collect::<Vec<_>>()
        };
        let variance = Some(image(&[[1.0; 3]; 10_000]));
        let reference = Reference { mean: image(&noise(1)), variance };
        let errors = Errors::between(&image(&noise(2)), &reference).unwrap();
        assert!((errors.mse - 1.0).abs() < 0.06, "{}", errors.mse);
        assert_eq!(errors.reference_mse, Some(1.0));
        let better: Vec<_> = noise(2).iter().map(|p| p.map(|x| 5.0 + 0.1 * (x - 5.0))).collect();
        let errors = Errors::between(&image(&better), &reference).unwrap();
        assert!(errors.mse.abs() < 0.06, "{}", errors.mse);
        assert_eq!(errors.below_reference_noise(), Some(true));
        let unknown = Reference { variance: None, ..reference };
        let errors = Errors::between(&image(&better), &unknown).unwrap();
        assert!((errors.mse - 1.01).abs() < 0.06 && errors.below_reference_noise().is_none(), "{}", errors.mse);
    }

    #[test]
    fn pixels_that_are_not_finite_are_counted_and_left_out() {
        let r = exact(&[[1.0; 3]; 4]);
        let x = image(&[[1.5; 3], [1.0, f64::NAN, 1.0], [f64::INFINITY; 3], [f64::NAN; 3]]);
        let errors = Errors::between(&x, &r).unwrap();
        assert_eq!((errors.invalid, errors.mse), (3, 0.25));
        assert!(Errors::between(&image(&[[f64::NAN; 3]; 4]), &r).unwrap().mse.is_nan());
    }

    #[test]
    fn what_cannot_be_compared_is_refused() {
        let one = image(&[[1.0; 3]]);
        assert!(matches!(Errors::between(&one, &exact(&[[1.0; 3]; 2])), Err(ReportError::Size { .. })));
        let bad = exact(&[[f64::NAN; 3]]);
        assert!(matches!(Errors::between(&one, &bad), Err(ReportError::Reference { count: 1 })));
    }
}
