//! Cameras, other sensors and their film.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// Pixels of the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FilmSize {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

/// A camera. It looks along `forward`, with `up` towards the top of the image; the two are orthonormal.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorDescription {
    /// Name in the file, for messages.
    pub name: String,
    /// Centre of projection, or of the lens, or of the orthographic film \[m\].
    pub position: DVec3,
    /// Viewing direction, of length one.
    pub forward: DVec3,
    /// Towards the top of the image, of length one and at right angles to `forward`.
    pub up: DVec3,
    /// How points become pixels.
    pub projection: Projection,
    /// The part of the whole image that the film covers, by its first and last corner: (0, 0) is the top left of the image,
    /// (1, 1) the bottom right. Other than the whole for films with a crop and shifted principal points.
    pub window: [DVec2; 2],
}

impl SensorDescription {
    /// The window that is the whole image.
    pub const WHOLE: [DVec2; 2] = [DVec2::ZERO, DVec2::ONE];

    /// Width over height of the whole image where the film covers the window with square pixels.
    #[must_use]
    pub fn film_aspect(&self, film: FilmSize) -> f64 {
        let covered = self.window[1] - self.window[0];
        f64::from(film.width) / f64::from(film.height) * (covered.y / covered.x)
    }
}

/// How a camera maps the world to its image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Central projection through a pinhole or a thin lens.
    Perspective {
        /// Full vertical field of view \[rad\].
        vertical_fov: f64,
        /// Width over height of the field of view; `None` takes the film's, so that pixels are square.
        aspect: Option<f64>,
        /// A thin lens, where it is no pinhole.
        lens: Option<Lens>,
    },
    /// Parallel projection.
    Orthographic {
        /// Half the width of what is seen \[m\].
        half_width: f64,
        /// Half the height of what is seen \[m\].
        half_height: f64,
    },
    /// No image but a meter: all light that arrives at the position from the hemisphere around `forward`, by its cosine. The
    /// pixels share the hemisphere; π times their mean is the irradiance \[W/m²\].
    Hemisphere,
    /// No image but a meter: all light that arrives at a rectangle from the hemisphere around `forward`. The pixels share the
    /// rectangle; π times their mean is the mean irradiance \[W/m²\].
    Window {
        /// Half the extent across `up` \[m\].
        half_width: f64,
        /// Half the extent along `up` \[m\].
        half_height: f64,
    },
    /// No image but a meter: the radiance that arrives at the position along `forward` \[W/m²/sr\], in a single pixel.
    Ray,
}

/// A thin lens.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lens {
    /// Radius of the aperture \[m\], positive.
    pub aperture_radius: f64,
    /// Distance along the viewing direction of the plane in focus \[m\], positive.
    pub focus_distance: f64,
}

/// The pixel filter h: how a pixel responds to light around its centre. Cut at the film's edge and normalised to ∫h = 1 for
/// each pixel. Radii are in pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum PixelFilter {
    /// One inside of the pixel.
    #[default]
    Box,
    /// `max(0, 1 − |x|/r) · max(0, 1 − |y|/r)`.
    Tent {
        /// r, positive.
        radius: f64,
    },
    /// `g(x) g(y)` with `g(x) = max(0, exp(−x²/2σ²) − exp(−r²/2σ²))` and r = 4σ.
    Gaussian {
        /// σ, positive.
        stddev: f64,
    },
}
