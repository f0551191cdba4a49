//! What varies over surfaces: textures, and the parameters of materials that may be one.

mod bitmap;
mod decode;
mod parameter;
mod point;

use std::sync::Arc;

use glam::{DAffine2, DVec2};

use crate::spectrum::Rgb;

pub(crate) use bitmap::srgb_to_linear;
pub use bitmap::{Bitmap, Filter, Texels, Wrap};
pub use decode::{ImageError, decode, read};
pub(crate) use parameter::clamped;
pub use parameter::{FromTexture, Parameter};
pub use point::{AttributeTable, SurfacePoint};

/// A function of a point of a surface, with four channels: linear RGB and opacity.
#[derive(Clone, Debug, PartialEq)]
pub enum Texture {
    /// The same everywhere.
    Constant([f64; 4]),
    /// An image, repeated over the plane of texture coordinates.
    Bitmap {
        /// The image.
        bitmap: Arc<Bitmap>,
        /// From the surface's texture coordinates to the image's, where it fills the unit square, its first row at v = 0.
        to_uv: DAffine2,
    },
    /// Two textures in the squares of a board: the first where both or neither of u and v, modulo one, exceed a half.
    Checkerboard {
        /// The two.
        colours: Box<[Texture; 2]>,
        /// From the surface's texture coordinates to the board's.
        to_uv: DAffine2,
    },
    /// A named attribute of the mesh, interpolated between its vertices; black and opaque where the mesh has none of that
    /// name.
    Attribute {
        /// Its name, as [`Attribute::name`](super::description::Attribute::name).
        name: String,
    },
    /// Another one, where the first two channels of an attribute are the texture coordinates: of meshes with several sets.
    OtherCoordinates {
        /// The other.
        of: Box<Texture>,
        /// The attribute's name.
        attribute: String,
    },
    /// One where another is at least a threshold and zero elsewhere, channel by channel.
    Step {
        /// The other.
        of: Box<Texture>,
        /// The threshold.
        threshold: f64,
    },
    /// The product of all, channel by channel.
    Product(Vec<Texture>),
    /// One channel of another as a grey one.
    Channel {
        /// The other.
        of: Box<Texture>,
        /// 0 red, 1 green, 2 blue, 3 opacity.
        channel: usize,
    },
    /// `scale · x + offset` of each channel, squared where asked for: from an artist's parameter to a model's.
    Remapped {
        /// The artist's.
        of: Box<Texture>,
        /// Factor.
        scale: f64,
        /// Summand.
        offset: f64,
        /// Square the result.
        squared: bool,
    },
}

impl Texture {
    /// Its four channels at a point.
    #[must_use]
    pub fn eval(&self, at: &SurfacePoint<'_>) -> [f64; 4] {
        match self {
            Self::Constant(value) => *value,
            Self::Bitmap { bitmap, to_uv } => bitmap.eval(to_uv.transform_point2(at.uv)),
            Self::Checkerboard { colours, to_uv } => {
                let uv = to_uv.transform_point2(at.uv);
                let upper = |x: f64| x - x.floor() > 0.5;
                colours[usize::from(upper(uv.x) != upper(uv.y))].eval(at)
            }
            Self::Attribute { name } => at.attribute(name),
            Self::OtherCoordinates { of, attribute } => {
                let [u, v, ..] = at.attribute(attribute);
                of.eval(&SurfacePoint { uv: DVec2::new(u, v), ..*at })
            }
            Self::Step { of, threshold } => of.eval(at).map(|x| if x >= *threshold { 1.0 } else { 0.0 }),
            Self::Product(factors) => {
                let mut product = [1.0; 4];
                for factor in factors {
                    let value = factor.eval(at);
                    product.iter_mut().zip(value).for_each(|(p, v)| *p *= v);
                }
                product
            }
            Self::Channel { of, channel } => {
                let value = of.eval(at)[*channel];
                [value, value, value, 1.0]
            }
            Self::Remapped { of, scale, offset, squared } => of.eval(at).map(|x| {
                let y = scale * x + offset;
                if *squared { y * y } else { y }
            }),
        }
    }

    /// Its colour at a point.
    #[must_use]
    pub fn colour(&self, at: &SurfacePoint<'_>) -> Rgb {
        let [r, g, b, _] = self.eval(at);
        Rgb::new(r, g, b)
    }

    /// As one number: the luminance of its colour, or the value of what is grey.
    #[must_use]
    pub fn scalar(&self, at: &SurfacePoint<'_>) -> f64 {
        let [r, g, b, _] = self.eval(at);
        if r == g && g == b { r } else { Rgb::new(r, g, b).luminance() }
    }

    /// The derivatives of [`scalar`](Self::scalar) by the surface's u and v: exact for one bilinear image, by differences
    /// otherwise.
    #[must_use]
    pub fn gradient(&self, at: &SurfacePoint<'_>) -> DVec2 {
        match self {
            Self::Bitmap { bitmap, to_uv } => {
                to_uv.matrix2.transpose() * bitmap.gradient(to_uv.transform_point2(at.uv))
            }
            Self::Remapped { of, scale, squared: false, .. } => of.gradient(at) * *scale,
            _ => {
                const STEP: f64 = 1e-4;
                let along = |d: DVec2| {
                    let moved = |by: f64| self.scalar(&SurfacePoint { uv: at.uv + d * by, ..*at });
                    (moved(STEP) - moved(-STEP)) / (2.0 * STEP)
                };
                DVec2::new(along(DVec2::X), along(DVec2::Y))
            }
        }
    }

    /// All textures of which it is made, itself included.
    pub fn visit(&self, see: &mut dyn FnMut(&Self)) {
        see(self);
        match self {
            Self::Constant(_) | Self::Bitmap { .. } | Self::Attribute { .. } => {}
            Self::Checkerboard { colours, .. } => colours.iter().for_each(|colour| colour.visit(see)),
            Self::Product(factors) => factors.iter().for_each(|factor| factor.visit(see)),
            Self::Channel { of, .. }
            | Self::Remapped { of, .. }
            | Self::OtherCoordinates { of, .. }
            | Self::Step { of, .. } => of.visit(see),
        }
    }
}
