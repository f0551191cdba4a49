//! How far an image is from its reference.
//!
//! With `x` the image, `r` the reference, and sums over the 3 channels of the N pixels in which `x` is finite:
//!
//! | metric | formula | unit |
//! |---|---|---|
//! | MSE | `1/(3N) Σ (x − r)²` | radiance² |
//! | RMSE | `√MSE` | radiance |
//! | relMSE | `1/(3N) Σ (x − r)² / (r² + 0.01)` | 1 |
//! | SMAPE | `1/(3N) Σ |x − r| / (|x| + |r|)`, a term being 0 where both are 0 | 1, from 0 to 1 |
//! | mean ratio | `Σ x / Σ r` | 1 |
//!
//! relMSE is the relative error in the form customary since Rousselle, Knaus and Zwicker (2011); its constant 0.01 is in
//! radiance², so what is much darker than 0.1 counts by its absolute error. Pixels in which the image is not finite are
//! counted in [`Errors::invalid`] and left out of all sums: a metric beside a non-zero count says nothing of them.

use crate::film::Image;

use super::error::ReportError;

/// The constant of relMSE \[radiance²\].
pub const RELMSE_EPSILON: f64 = 0.01;

/// What images are measured against.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// The image.
    pub mean: Image,
    /// Squared standard error of each pixel, where it is known.
    pub variance: Option<Image>,
}

/// The metrics of one image. All are NaN where no pixel is left, the mean ratio also over a black reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// Mean squared error \[radiance²\].
    pub mse: f64,
    /// Its root \[radiance\].
    pub rmse: f64,
    /// Mean squared error relative to the reference.
    pub relmse: f64,
    /// Symmetric mean absolute relative error, 0 … 1.
    pub smape: f64,
    /// Mean of the image over mean of the reference: 1 where energy is right.
    pub mean_ratio: f64,
    /// Pixels that are not finite, and left out.
    pub invalid: u64,
}

impl Errors {
    /// Of `image` against `reference`, in the pixels that `mask` leaves (all where there is none).
    ///
    /// # Errors
    /// When sizes differ, the mask is not one value for each pixel, or the reference is not finite.
    pub fn between(image: &Image, reference: &Image, mask: Option<&[bool]>) -> Result<Self, ReportError> {
        let (size, reference_size) = ((image.width, image.height), (reference.width, reference.height));
        if size != reference_size || image.pixels.len() != reference.pixels.len() {
            return Err(ReportError::Size { image: size, reference: reference_size });
        }
        if let Some(mask) = mask
            && mask.len() != image.pixels.len()
        {
            let (expected, found) = (image.pixels.len(), mask.len());
            return Err(crate::film::FilmError::Count { what: "values of the mask", expected, found }.into());
        }
        let unusable = reference.pixels.iter().filter(|pixel| !pixel.is_finite()).count() as u64;
        if unusable > 0 {
            return Err(ReportError::Reference { count: unusable });
        }
        Ok(Self::of_counted(image, reference, mask))
    }

    fn of_counted(image: &Image, reference: &Image, mask: Option<&[bool]>) -> Self {
        let mut invalid = 0;
        let mut values = 0.0;
        let [mut squares, mut relative, mut symmetric, mut image_sum, mut reference_sum] = [0.0; 5];
        for (index, (x, r)) in image.pixels.iter().zip(&reference.pixels).enumerate() {
            if mask.is_some_and(|mask| !mask[index]) {
                continue;
            }
            if !x.is_finite() {
                invalid += 1;
                continue;
            }
            for (x, r) in x.to_array().into_iter().zip(r.to_array()) {
                let difference = x - r;
                values += 1.0;
                squares += difference * difference;
                relative += difference * difference / (r * r + RELMSE_EPSILON);
                if difference != 0.0 {
                    symmetric += difference.abs() / (x.abs() + r.abs());
                }
                image_sum += x;
                reference_sum += r;
            }
        }
        let mse = squares / values;
        Self {
            mse,
            rmse: mse.sqrt(),
            relmse: relative / values,
            smape: symmetric / values,
            mean_ratio: image_sum / reference_sum,
            invalid,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::Rgb;

    fn image(pixels: &[[f64; 3]]) -> Image {
        Image::new(pixels.len() as u32, 1, pixels.iter().copied().map(Rgb::from).collect()).unwrap()
    }

    #[test]
    fn metrics_equal_their_formulas() {
        let x = image(&[[1.0, 0.0, 0.5], [3.0, 2.0, 0.0]]);
        let r = image(&[[1.0, 0.0, 1.0], [1.0, 2.0, 0.2]]);
        let errors = Errors::between(&x, &r, None).unwrap();
        let expect = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-14, "{found} {expected}");
        expect(errors.mse, (0.25 + 4.0 + 0.04) / 6.0);
        expect(errors.rmse, errors.mse.sqrt());
        expect(errors.relmse, (0.25 / 1.01 + 4.0 / 1.01 + 0.04 / 0.05) / 6.0);
        expect(errors.smape, (0.5 / 1.5 + 2.0 / 4.0 + 1.0) / 6.0);
        expect(errors.mean_ratio, 6.5 / 5.2);
        assert_eq!(errors.invalid, 0);
    }

    #[test]
    fn an_image_equals_itself() {
        let x = image(&[[1.0, 0.0, 0.5]]);
        let errors = Errors::between(&x, &x, None).unwrap();
        assert_eq!((errors.mse, errors.relmse, errors.smape, errors.mean_ratio), (0.0, 0.0, 0.0, 1.0));
    }

    #[test]
    fn pixels_that_are_not_finite_are_counted_and_left_out() {
        let r = image(&[[1.0; 3]; 4]);
        let x = image(&[[1.5; 3], [1.0, f64::NAN, 1.0], [f64::INFINITY; 3], [f64::NAN; 3]]);
        let errors = Errors::between(&x, &r, Some(&[true, true, true, false])).unwrap();
        assert_eq!((errors.invalid, errors.mse), (2, 0.25));
        assert!(Errors::between(&image(&[[f64::NAN; 3]; 4]), &r, None).unwrap().mse.is_nan());
    }

    #[test]
    fn what_cannot_be_compared_is_refused() {
        let (one, two) = (image(&[[1.0; 3]]), image(&[[1.0; 3]; 2]));
        assert!(matches!(Errors::between(&one, &two, None), Err(ReportError::Size { .. })));
        assert!(matches!(Errors::between(&one, &one, Some(&[])), Err(ReportError::Film(_))));
        let bad = image(&[[f64::NAN; 3]]);
        assert!(matches!(Errors::between(&one, &bad, None), Err(ReportError::Reference { count: 1 })));
    }
}
