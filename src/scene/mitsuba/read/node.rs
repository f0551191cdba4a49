//! The objects of a scene with their properties, before they mean anything.

use glam::{DMat4, DVec3};

use super::fault::Place;
use super::spectrum::Spectrum;
use crate::spectrum::Rgb;

/// What an object is, by its tag.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Scene,
    Bsdf,
    Texture,
    Shape,
    Emitter,
    Sensor,
    Film,
    Filter,
    Sampler,
    Integrator,
    Medium,
    Phase,
    Volume,
}

impl Kind {
    pub(super) fn of_tag(tag: &str) -> Option<Self> {
        Some(match tag {
            "scene" => Self::Scene,
            "bsdf" => Self::Bsdf,
            "texture" => Self::Texture,
            "shape" => Self::Shape,
            "emitter" | "luminaire" => Self::Emitter,
            "sensor" | "camera" => Self::Sensor,
            "film" => Self::Film,
            "rfilter" => Self::Filter,
            "sampler" => Self::Sampler,
            "integrator" => Self::Integrator,
            "medium" => Self::Medium,
            "phase" => Self::Phase,
            "volume" => Self::Volume,
            _ => return None,
        })
    }
}

/// A value of a property.
#[derive(Clone, Debug)]
pub(super) enum Value {
    Boolean(bool),
    Integer(i64),
    Float(f64),
    Text(String),
    /// A vector or a point; the format does not tell them apart.
    Vector(DVec3),
    Colour(Rgb),
    Spectrum(Spectrum),
    Transform(DMat4),
    /// An object by its id, until all ids are known.
    Reference(String),
    /// An object by its index.
    Object(usize),
}

impl Value {
    /// Its kind, with an article, for messages.
    pub(super) fn what(&self) -> &'static str {
        match self {
            Self::Boolean(_) => "a boolean",
            Self::Integer(_) => "an integer",
            Self::Float(_) => "a float",
            Self::Text(_) => "a string",
            Self::Vector(_) => "a vector",
            Self::Colour(_) => "a colour",
            Self::Spectrum(_) => "a spectrum",
            Self::Transform(_) => "a transform",
            Self::Reference(_) | Self::Object(_) => "an object",
        }
    }
}

/// A named value of an object. What has no name in the file has an empty one.
#[derive(Clone, Debug)]
pub(super) struct Property {
    pub name: String,
    pub value: Value,
    pub place: Place,
}

/// An object.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub kind: Kind,
    pub plugin: String,
    pub id: Option<String>,
    pub properties: Vec<Property>,
    pub place: Place,
    /// The file is of the format's version 0, as Mitsuba 0.5 and 0.6 wrote it.
    pub old: bool,
}
