//! ꟻLIP (Andersson et al. 2020): the difference that an observer sees who flips between the images on a display.
//!
//! NVIDIA's implementation of the form for displayed images, at 67 pixels per degree. Both images are shown with one exposure,
//! which brings the log-average luminance of the reference to 0.18 (Reinhard et al. 2002), in sRGB, clamped.

use std::ops::Range;

use rayon::prelude::*;

use crate::film::Image;
use crate::film::png::to_srgb8;

/// The luminance that the log-average of the reference is shown with.
const KEY: f64 = 0.18;

/// Keeps the logarithm of black finite; small beside whatever is seen.
const DARKEST: f64 = 1e-6;

/// Pixels that an error depends on in each direction: three standard deviations of the widest filter (the blue-yellow contrast
/// sensitivity's, at 67 pixels per degree), rounded up.
const REACH: u32 = 10;

/// Mean over all pixels; `None` where the sizes differ, there are no pixels, or some are not finite.
#[must_use]
pub fn flip(image: &Image, reference: &Image) -> Option<f64> {
    let alike = (image.width, image.height) == (reference.width, reference.height);
    let finite = |image: &Image| image.pixels.iter().all(|pixel| pixel.is_finite());
    if !alike || image.pixels.is_empty() || !finite(image) || !finite(reference) {
        return None;
    }
    let logs = reference.pixels.iter().map(|pixel| libm::log(pixel.luminance().max(0.0) + DARKEST));
    let stops = libm::log2(KEY / libm::exp(logs.sum::<f64>() / reference.pixels.len() as f64));
    let (shown, expected) = rayon::join(|| to_srgb8(image, stops), || to_srgb8(reference, stops));
    let strips = rayon::current_num_threads() as u32;
    let rows = image.height.div_ceil(strips).max(REACH);
    let starts: Vec<u32> = (0..image.height).step_by(rows as usize).collect();
    let parts: Vec<Vec<f32>> = starts
        .into_par_iter()
        .map(|start| strip(&expected, &shown, image.width, image.height, start..(start + rows).min(image.height)))
        .collect();
    let sum: f64 = parts.iter().flatten().map(|&error| f64::from(error)).sum();
    Some(sum / image.pixels.len() as f64)
}

/// The errors of these rows, from as much of the images as they depend on.
fn strip(expected: &[u8], shown: &[u8], width: u32, height: u32, rows: Range<u32>) -> Vec<f32> {
    let seen = rows.start.saturating_sub(REACH)..(rows.end + REACH).min(height);
    let bytes = (seen.start * width * 3) as usize..(seen.end * width * 3) as usize;
    let part = |data: &[u8]| nv_flip::FlipImageRgb8::with_data(width, seen.end - seen.start, &data[bytes.clone()]);
    let errors = nv_flip::flip(part(expected), part(shown), nv_flip::DEFAULT_PIXELS_PER_DEGREE);
    let kept = ((rows.start - seen.start) * width) as usize..((rows.end - seen.start) * width) as usize;
    errors.to_vec()[kept].to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::Rgb;

    #[test]
    fn strips_have_the_bits_of_the_whole() {
        let picture = |bright: f64| {
            let pixels = (0..70 * 90).map(|i| {
                let (x, y) = (f64::from(i % 70), f64::from(i / 70));
                Rgb::new(1.0 + (x * 0.7).sin(), 1.0 + bright * (y * 0.4).cos(), 0.1 + bright * ((i * 7919) % 13) as f64)
            });
            to_srgb8(&Image { width: 70, height: 90, pixels: pixels.collect() }, -1.0)
        };
        let (expected, shown) = (picture(0.2), picture(0.9));
        let whole = strip(&expected, &shown, 70, 90, 0..90);
        for rows in [1, 7, 45] {
            let parts = (0..90).step_by(rows).map(|start| start as u32..(start + rows).min(90) as u32);
            let parts: Vec<f32> = parts.flat_map(|rows| strip(&expected, &shown, 70, 90, rows)).collect();
            assert_eq!(parts, whole, "strips of {rows} rows");
        }
        assert!(whole.iter().all(|&error| error > 0.0), "the pictures differ everywhere");
    }
}
