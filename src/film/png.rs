//! PNG files: eight bits in the sRGB transfer curve, for looking.

use std::io;
use std::path::Path;

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};

use super::error::FileError;
use super::image::Image;
use super::output::write_atomically;

/// The sRGB transfer curve from linear to encoded, both clamped to 0 … 1; NaN becomes 0 (IEC 61966-2-1).
///
/// `12.92 x` up to 0.0031308, `1.055 x^(1/2.4) − 0.055` above.
#[must_use]
pub fn srgb_from_linear(linear: f64) -> f64 {
    if linear.is_nan() || linear <= 0.0 {
        0.0
    } else if linear <= 0.003_130_8 {
        12.92 * linear
    } else if linear < 1.0 {
        1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055
    } else {
        1.0
    }
}

/// The bytes of [`write_png`], three a pixel.
#[must_use]
pub fn to_srgb8(image: &Image, exposure: f64) -> Vec<u8> {
    let factor = libm::exp2(exposure);
    let values = image.pixels.iter().flat_map(|pixel| pixel.to_array());
    values.map(|value| (255.0 * srgb_from_linear(factor * value)).round() as u8).collect()
}

/// Writes `2^exposure · image` \[exposure in stops\], clamped and encoded; atomically. Clamping keeps what is in range as
/// it is, so that images of equal exposure compare by eye; what is brighter than 1 is white.
///
/// # Errors
/// When the file cannot be written.
pub fn write_png(path: &Path, image: &Image, exposure: f64) -> Result<(), FileError> {
    let bytes = to_srgb8(image, exposure);
    write_atomically(path, |writer| {
        PngEncoder::new(writer)
            .write_image(&bytes, image.width, image.height, ExtendedColorType::Rgb8)
            .map_err(io::Error::other)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::Rgb;

    #[test]
    fn the_transfer_curve_is_continuous_monotonic_and_clamped() {
        assert!((srgb_from_linear(0.003_130_8) - srgb_from_linear(0.003_130_9)).abs() < 2e-6);
        // The encoded middle grey of 18 % reflectance.
        assert!((srgb_from_linear(0.18) - 0.461_356).abs() < 1e-6);
        let values: Vec<f64> = (0..=1000).map(|i| srgb_from_linear(f64::from(i) * 1e-3)).collect();
        assert!(values.windows(2).all(|pair| pair[0] < pair[1]));
        let clamped = [-1.0, f64::NAN, 2.0, f64::INFINITY].map(srgb_from_linear);
        assert_eq!(clamped, [0.0, 0.0, 1.0, 1.0]);
    }

    #[test]
    fn a_stop_of_exposure_doubles_the_image() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let grey = Image::constant(3, 2, Rgb::new(0.09, 0.0, 5.0)).unwrap();
        write_png(&path, &grey, 1.0).unwrap();
        let read = image::open(&path).unwrap().into_rgb8();
        assert_eq!(read.dimensions(), (3, 2));
        assert!(read.pixels().all(|pixel| pixel.0 == [118, 0, 255]));
    }
}
