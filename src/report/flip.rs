//! ꟻLIP (Andersson et al. 2020): the difference that an observer sees who flips between the images on a display.
//!
//! NVIDIA's implementation of the form for displayed images, at 67 pixels per degree. Both images are shown with one exposure,
//! which brings the log-average luminance of the reference to 0.18 (Reinhard et al. 2002), in sRGB, clamped.

use crate::film::Image;
use crate::film::png::to_srgb8;

/// The luminance that the log-average of the reference is shown with.
const KEY: f64 = 0.18;

/// Keeps the logarithm of black finite; small beside whatever is seen.
const DARKEST: f64 = 1e-6;

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
    let shown = |image: &Image| nv_flip::FlipImageRgb8::with_data(image.width, image.height, &to_srgb8(image, stops));
    let error = nv_flip::flip(shown(reference), shown(image), nv_flip::DEFAULT_PIXELS_PER_DEGREE);
    Some(f64::from(nv_flip::FlipPool::from_image(&error).mean()))
}
