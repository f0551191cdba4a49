//! Lights without a surface.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use crate::scene::texture::Bitmap;
use crate::spectrum::Rgb;

/// A light without a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Name in the file, for messages.
    pub name: String,
    /// What it is.
    pub kind: LightKind,
}

/// Kinds of light without a surface. Photometric units of a file are read as radiometric ones, without the factor 683.
#[derive(Clone, Debug, PartialEq)]
pub enum LightKind {
    /// Shines from one point, equally in all directions.
    Point {
        /// Where \[m\].
        position: DVec3,
        /// Intensity \[W/sr\].
        intensity: Rgb,
    },
    /// Shines from one point into a cone. Intensity falls off linearly in the *angle*, from the inner to the outer cone.
    Spot {
        /// Where \[m\].
        position: DVec3,
        /// Axis of the cone, of length one.
        direction: DVec3,
        /// Intensity on the axis \[W/sr\].
        intensity: Rgb,
        /// Angle from the axis up to which the intensity is full \[rad\].
        inner_angle: f64,
        /// Angle from the axis from which it is dark \[rad\], not below the inner one and at most π.
        outer_angle: f64,
    },
    /// Shines in one direction from infinitely far away.
    Directional {
        /// Where the light goes, of length one.
        direction: DVec3,
        /// Irradiance on a surface that faces it \[W/m²\].
        irradiance: Rgb,
    },
    /// Shines an image from one point, as a pinhole camera would take it.
    Projector {
        /// Where \[m\].
        position: DVec3,
        /// Axis, of length one.
        forward: DVec3,
        /// Towards the top of the image, of length one and at right angles to the axis.
        up: DVec3,
        /// Full horizontal field of view \[rad\].
        horizontal_fov: f64,
        /// The image: on a white diffuse screen across the axis at distance one, the radiance `scale · image`, so the intensity
        /// `I(ω) = π · scale · image / cos³θ` \[W/sr\] where ω meets that screen within the image. As Mitsuba 3 has it.
        image: Arc<Bitmap>,
        /// Factor of the image.
        scale: Rgb,
    },
}

/// Radiance from infinitely far away \[W/m²/sr\].
#[derive(Clone, Debug, PartialEq)]
pub enum EnvironmentDescription {
    /// The same from everywhere.
    Constant(Rgb),
    /// An image over all directions, by longitude and latitude.
    Map {
        /// The image, as Mitsuba 3 takes it. Its first row is the pole +y of `to_world`, its last −y. Along a row it shows −z at
        /// the left edge, then +x, +z in the middle, −x, and −z again. Colours are interpolated between the centres of
        /// columns and between rows, of which the first and the last lie on the poles; the bitmap's own filter and wrap are
        /// not asked.
        bitmap: Arc<Bitmap>,
        /// Factor.
        scale: f64,
        /// From the image's frame to the world, a rotation or a reflection.
        to_world: DMat3,
    },
}

impl From<Rgb> for EnvironmentDescription {
    fn from(radiance: Rgb) -> Self {
        Self::Constant(radiance)
    }
}
