//! Cameras, other sensors and their film.

use std::fmt;
use std::str::FromStr;

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::shape::ShapeIndex;

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
    /// pixels share the hemisphere; their mean is the irradiance \[W/m²\].
    Hemisphere,
    /// No image but a meter: all light that arrives at a rectangle from the hemisphere around `forward`. The pixels share the
    /// rectangle; their mean is the mean irradiance \[W/m²\].
    Window {
        /// Half the extent across `up` \[m\].
        half_width: f64,
        /// Half the extent along `up` \[m\].
        half_height: f64,
    },
    /// No image but a meter: the radiance that arrives at the position along `forward` \[W/m²/sr\], the same in every pixel.
    Ray,
    /// No image but a meter: the irradiance at the front of a shape of the scene, its mean over the shape's area \[W/m²\], the
    /// same in every pixel. The shape stays a surface of the scene. The sensor's position and directions say nothing.
    Surface {
        /// The shape.
        shape: ShapeIndex,
    },
    /// No image but a meter: the radiance that leaves the scene against `forward`, its mean over a target \[W/m²/sr\], the
    /// same in every pixel. The sensor's position says nothing.
    Distant {
        /// What it looks at.
        target: Target,
    },
}

/// What a distant sensor takes the mean over. It is no part of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// The cross-section of the sphere around the corners of the box around all surfaces.
    Scene,
    /// A point: the sensor is a ray through it.
    Point(DVec3),
    /// The points `centre + a u + b v` with a and b in `[−1, 1]`, uniform by area.
    Parallelogram {
        /// Its centre \[m\].
        centre: DVec3,
        /// Half a side \[m\].
        u: DVec3,
        /// Half of the other side \[m\].
        v: DVec3,
    },
    /// The points `centre + a u + b v` with `a² + b² ≤ 1`, uniform by area.
    Ellipse {
        /// Its centre \[m\].
        centre: DVec3,
        /// A half axis, or any other half diameter \[m\].
        u: DVec3,
        /// The half diameter conjugate to it: at right angles for a disk \[m\].
        v: DVec3,
    },
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

impl PixelFilter {
    /// Wider ones are refused: they have a pixel respond to what is seen far away, and cost time without end.
    pub const LARGEST_RADIUS: f64 = 100.0;

    /// How far from its centre a pixel responds, in pixels; the box responds to half a pixel on either side.
    #[must_use]
    pub fn radius(self) -> f64 {
        match self {
            Self::Box => 0.5,
            Self::Tent { radius } => radius,
            Self::Gaussian { stddev } => 4.0 * stddev,
        }
    }

    /// Its radius is positive and not absurd.
    #[must_use]
    pub fn is_valid(self) -> bool {
        self.radius() > 0.0 && self.radius() <= Self::LARGEST_RADIUS
    }
}

impl fmt::Display for PixelFilter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Box => write!(f, "box"),
            Self::Tent { radius } => write!(f, "tent:{radius}"),
            Self::Gaussian { stddev } => write!(f, "gaussian:{stddev}"),
        }
    }
}

/// `box`, `tent:RADIUS` or `gaussian:STDDEV`; without a number, Mitsuba's defaults of 1 and 0.5 pixels.
impl FromStr for PixelFilter {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (kind, number) = match text.split_once(':') {
            None => (text, None),
            Some((kind, number)) => (kind, Some(number.trim().parse().ok())),
        };
        let filter = match (kind, number) {
            ("box", None) => Some(Self::Box),
            ("tent", None) => Some(Self::Tent { radius: 1.0 }),
            ("tent", Some(radius)) => radius.map(|radius| Self::Tent { radius }),
            ("gaussian", None) => Some(Self::Gaussian { stddev: 0.5 }),
            ("gaussian", Some(stddev)) => stddev.map(|stddev| Self::Gaussian { stddev }),
            _ => None,
        };
        let expected = "expected box, tent, tent:RADIUS, gaussian or gaussian:STDDEV, in pixels, for example gaussian:0.5; \
                        it may reach 100 pixels far, a gaussian reaches 4 standard deviations";
        filter.filter(|filter| filter.is_valid()).ok_or(expected)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filters_are_read_as_they_are_written() {
        for filter in [PixelFilter::Box, PixelFilter::Tent { radius: 1.25 }, PixelFilter::Gaussian { stddev: 0.1 }] {
            assert_eq!(filter.to_string().parse(), Ok(filter));
        }
        assert_eq!("tent".parse(), Ok(PixelFilter::Tent { radius: 1.0 }));
        assert_eq!("gaussian".parse(), Ok(PixelFilter::Gaussian { stddev: 0.5 }));
        for text in ["", "mitchell", "box:1", "tent:", "tent:0", "tent:-1", "tent:inf", "gaussian:NaN", "gaussian:26"] {
            assert!(text.parse::<PixelFilter>().is_err(), "{text}");
        }
    }
}
