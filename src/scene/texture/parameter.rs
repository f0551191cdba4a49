use std::sync::Arc;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::spectrum::Rgb;

use super::{SurfacePoint, Texture};

/// Between two bounds; what is no number, which a broken image may hold, is the lower one.
pub(crate) fn clamped(x: f64, low: f64, high: f64) -> f64 {
    if x > low { x.min(high) } else { low }
}

/// A parameter of a material: a constant, or a texture that gives it at each point.
#[derive(Clone, Debug, PartialEq)]
pub enum Parameter<T> {
    /// The same everywhere.
    Constant(T),
    /// Given by a texture.
    Texture(Arc<Texture>),
}

/// What a texture can be read as.
pub trait FromTexture: Copy {
    /// The value at a point.
    fn from_texture(texture: &Texture, at: &SurfacePoint<'_>) -> Self;
}

impl FromTexture for Rgb {
    fn from_texture(texture: &Texture, at: &SurfacePoint<'_>) -> Self {
        texture.colour(at)
    }
}

impl FromTexture for f64 {
    fn from_texture(texture: &Texture, at: &SurfacePoint<'_>) -> Self {
        texture.scalar(at)
    }
}

impl<T: FromTexture> Parameter<T> {
    /// At a point.
    #[must_use]
    pub fn at(&self, at: &SurfacePoint<'_>) -> T {
        match self {
            Self::Constant(value) => *value,
            Self::Texture(texture) => T::from_texture(texture, at),
        }
    }
}

impl<T> Parameter<T> {
    /// The texture, where it is one.
    #[must_use]
    pub fn texture(&self) -> Option<&Texture> {
        match self {
            Self::Constant(_) => None,
            Self::Texture(texture) => Some(texture),
        }
    }

    /// The value, where it is the same everywhere.
    #[must_use]
    pub fn constant(&self) -> Option<&T> {
        match self {
            Self::Constant(value) => Some(value),
            Self::Texture(_) => None,
        }
    }
}

impl<T> From<T> for Parameter<T> {
    fn from(value: T) -> Self {
        Self::Constant(value)
    }
}

/// A file's extras say constants.
impl<'de, T: Deserialize<'de>> Deserialize<'de> for Parameter<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        T::deserialize(deserializer).map(Self::Constant)
    }
}

impl<T: Serialize> Serialize for Parameter<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Constant(value) => value.serialize(serializer),
            Self::Texture(_) => Err(serde::ser::Error::custom("a texture has no short form")),
        }
    }
}
