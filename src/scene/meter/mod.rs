//! Meters: sensors of path space that make no image but measure one radiometric quantity, as the command line and a scene's
//! extras write them.
//!
//! | text | quantity | unit |
//! |---|---|---|
//! | `irradiance:P:N` | `E = ∫ L cos θ dσ` at the point P of a surface that faces N | W/m² |
//! | `irradiance:P:U:V`, `irradiance:SURFACE` | the mean of E over a rectangle | W/m² |
//! | `flux:P:U:V`, `flux:SURFACE` | `Φ = ∫ E dA`, what arrives at a rectangle | W |
//! | `flux:SURFACE:leaving` | Φ that leaves the front of a surface, emitted and reflected | W |
//! | `radiance:P:D` | L that arrives at P from the direction D | W/m²/sr |
//! | `intensity:D` | `I = ∫ L cos θ dA` of all surfaces, seen from far away in the direction D | W/sr |
//!
//! P, N, U, V and D are each three numbers with commas between, in the scene's coordinates. A rectangle has the corner P and
//! the sides U and V, and light arrives on the side where U × V points. A SURFACE is a flat rectangular mesh, by its name.

mod aim;
mod surface;
#[cfg(test)]
mod tests;

use std::str::FromStr;

use glam::DVec3;
use thiserror::Error;

use crate::names::did_you_mean;

pub use aim::Aim;

/// What is measured, and where.
#[derive(Clone, Debug, PartialEq)]
pub enum Meter {
    /// Irradiance at a point.
    Irradiance {
        /// The point \[m\].
        position: DVec3,
        /// Where the surface that is lit faces, of length one.
        normal: DVec3,
    },
    /// Mean irradiance over an area.
    MeanIrradiance(Region),
    /// Flux that arrives at an area.
    Flux(Region),
    /// Flux that leaves the front of a surface, by its name.
    FluxLeaving(String),
    /// Radiance along a ray.
    Radiance {
        /// Where it arrives \[m\].
        position: DVec3,
        /// Where it comes from, of length one.
        direction: DVec3,
    },
    /// Intensity of everything.
    Intensity {
        /// Where it is seen from, of length one.
        direction: DVec3,
    },
}

/// An area that light arrives at.
#[derive(Clone, Debug, PartialEq)]
pub enum Region {
    /// A rectangle in space, lit from the side where u × v points.
    Rectangle {
        /// A corner \[m\].
        corner: DVec3,
        /// A side \[m\].
        u: DVec3,
        /// The other side \[m\], at right angles.
        v: DVec3,
    },
    /// The front of a flat rectangular mesh, by its name.
    Surface(String),
}

/// A meter that a scene brings along.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedMeter {
    /// What the scene calls it.
    pub name: String,
    /// What it measures.
    pub meter: Meter,
}

/// Why a meter cannot be had: one sentence.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{problem}; {remedy}")]
pub struct MeterError {
    /// What is wrong.
    pub problem: String,
    /// What to do.
    pub remedy: String,
}

impl MeterError {
    fn new(problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { problem: problem.into(), remedy: remedy.into() }
    }
}

/// All meters with their forms.
const FORMS: [(&str, &str); 4] = [
    ("irradiance", "irradiance:X,Y,Z:NX,NY,NZ, irradiance:X,Y,Z:UX,UY,UZ:VX,VY,VZ or irradiance:SURFACE"),
    ("flux", "flux:X,Y,Z:UX,UY,UZ:VX,VY,VZ, flux:SURFACE or flux:SURFACE:leaving"),
    ("radiance", "radiance:X,Y,Z:DX,DY,DZ"),
    ("intensity", "intensity:DX,DY,DZ"),
];

/// How far sides may be from a right angle, as a cosine.
const RIGHT_ANGLE: f64 = 1e-9;

impl Meter {
    /// `text` is the name of a kind of meter.
    #[must_use]
    pub fn is_kind(text: &str) -> bool {
        FORMS.iter().any(|(kind, _)| *kind == text)
    }
}

impl FromStr for Meter {
    type Err = MeterError;

    fn from_str(text: &str) -> Result<Self, MeterError> {
        let (kind, rest) = text.split_once(':').unwrap_or((text, ""));
        let Some((_, form)) = FORMS.iter().find(|(known, _)| *known == kind) else {
            let known = FORMS.map(|(kind, _)| kind);
            let suggestion = did_you_mean(kind, known);
            return Err(MeterError::new(
                format!("unknown meter '{kind}'{suggestion}"),
                format!("known meters are {}", known.join(", ")),
            ));
        };
        let wrong = |problem: &str| MeterError::new(problem, format!("write {form}"));
        let place = Place::read(rest).map_err(wrong)?;
        let unit = |v: DVec3| v.try_normalize().ok_or_else(|| wrong("a direction must not be zero"));
        match (kind, &place) {
            ("irradiance", Place::Vectors(v)) if v.len() == 2 => {
                Ok(Self::Irradiance { position: v[0], normal: unit(v[1])? })
            }
            ("irradiance", _) => place.region().map(Self::MeanIrradiance).map_err(wrong),
            ("flux", Place::Name(name)) if name.ends_with(LEAVING) => {
                Ok(Self::FluxLeaving(name[..name.len() - LEAVING.len()].into()))
            }
            ("flux", _) => place.region().map(Self::Flux).map_err(wrong),
            ("radiance", Place::Vectors(v)) if v.len() == 2 => {
                Ok(Self::Radiance { position: v[0], direction: unit(v[1])? })
            }
            ("intensity", Place::Vectors(v)) if v.len() == 1 => Ok(Self::Intensity { direction: unit(v[0])? }),
            (_, Place::Vectors(_)) => Err(wrong(COUNT)),
            (_, Place::Name(_)) => Err(wrong("it is measured at no surface")),
        }
    }
}

const COUNT: &str = "another number of vectors is expected";
const LEAVING: &str = ":leaving";

/// What stands behind a meter's kind.
enum Place<'a> {
    Vectors(Vec<DVec3>),
    Name(&'a str),
}

impl<'a> Place<'a> {
    fn read(text: &'a str) -> Result<Self, &'static str> {
        if text.is_empty() {
            return Err("it does not say where");
        }
        match text.split(':').map(vector).collect::<Option<Vec<DVec3>>>() {
            Some(vectors) => Ok(Self::Vectors(vectors)),
            // Names have no commas, so this was meant to be numbers.
            None if text.contains(',') => Err("expected three finite numbers with commas between"),
            None => Ok(Self::Name(text)),
        }
    }

    fn region(&self) -> Result<Region, &'static str> {
        let vectors = match self {
            Self::Name(name) => return Ok(Region::Surface((*name).into())),
            Self::Vectors(vectors) => vectors,
        };
        let &[corner, u, v] = &vectors[..] else { return Err(COUNT) };
        if u.cross(v).try_normalize().is_none() {
            return Err("the sides must span an area");
        }
        if u.dot(v).abs() > RIGHT_ANGLE * u.length() * v.length() {
            return Err("the sides must be at right angles");
        }
        Ok(Region::Rectangle { corner, u, v })
    }
}

fn vector(text: &str) -> Option<DVec3> {
    let numbers = text.split(',').map(|x| x.trim().parse().ok().filter(|x: &f64| x.is_finite()));
    match numbers.collect::<Option<Vec<f64>>>()?[..] {
        [x, y, z] => Some(DVec3::new(x, y, z)),
        _ => None,
    }
}
