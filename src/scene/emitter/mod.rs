//! Where light comes from.
//!
//! Every emitter answers the same questions about the first edge x_0 → x_1 of a path: how much it emits along it, with
//! which density a walk that starts at the emitter draws it, and with which density x_0 is drawn for a given x_1.
//! Lights that are concentrated in a point or a direction answer with the coefficients of their Dirac distribution,
//! emission and densities alike, so that their ratios are right.

mod environment_map;
mod infinite;
mod projector;
mod punctual;
mod surface;
mod texels;

use glam::DVec3;

use crate::measure::{Area, Density, SolidAngle};
use crate::path::{Edge, Vertex, VertexKind};
use crate::spectrum::Rgb;

use super::Scene;
use super::accel::Accel;
use super::texture::Parameter;

pub use environment_map::EnvironmentMap;
pub(crate) use infinite::infinite_vertex;
pub use infinite::{Directional, Environment};
pub use projector::Projector;
pub use punctual::{Point, Spot};
pub use surface::{MeshEmitter, ShapeEmitter};

/// Index of an emitter of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct EmitterId(pub u32);

/// An emitter.
#[derive(Clone, Debug)]
pub enum Emitter {
    /// The front of a triangle mesh.
    Mesh(MeshEmitter),
    /// The front of an analytic shape.
    Shape(ShapeEmitter),
    /// A point light.
    Point(Point),
    /// A spot light.
    Spot(Spot),
    /// A light that shines an image.
    Projector(Box<Projector>),
    /// A directional light.
    Directional(Directional),
    /// The constant environment.
    Environment(Environment),
    /// The environment by an image.
    EnvironmentMap(Box<EnvironmentMap>),
}

/// The first edge of a walk from an emitter.
#[derive(Clone, Copy, Debug)]
pub struct EmissionSample {
    /// x_0.
    pub vertex: Vertex,
    /// The direction towards x_1.
    pub direction: DVec3,
}

/// The densities with which a walk draws its first edge: their product, the second turned to area at the next vertex,
/// is the joint density of both vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeDensity {
    /// Of the first vertex, given the direction where that is drawn first.
    pub position: Density<Area>,
    /// Of the direction.
    pub direction: Density<SolidAngle>,
}

/// x_0 drawn for a given x_1.
#[derive(Clone, Copy, Debug)]
pub struct DirectSample {
    /// x_0.
    pub vertex: Vertex,
    /// Its density, given the emitter.
    pub density: Density<Area>,
}

impl Emitter {
    /// `L_e(x_0 → x_1)`: radiance \[W/m²/sr\], intensity of a point \[W/sr\], or irradiance of a directional light \[W/m²\].
    /// `direction` leads from x_0 to x_1.
    #[must_use]
    #[inline(always)]
    pub fn emission(&self, scene: &Scene, x0: &Vertex, direction: DVec3) -> Rgb {
        match self {
            Self::Mesh(MeshEmitter { radiance, .. }) | Self::Shape(ShapeEmitter { radiance, .. }) => {
                // Between points at one place there is no direction: NaN, which is not in front either.
                let in_front = x0.normal.dot(direction) > 0.0;
                match radiance {
                    _ if !in_front => Rgb::BLACK,
                    Parameter::Constant(radiance) => *radiance,
                    Parameter::Texture(texture) => scene.textured_emission(texture, x0),
                }
            }
            Self::Point(light) => light.intensity,
            Self::Spot(light) => light.intensity(direction),
            Self::Directional(light) => light.irradiance,
            Self::Environment(light) => light.radiance,
            Self::Projector(light) => light.intensity(direction),
            Self::EnvironmentMap(light) => light.radiance(direction),
        }
    }

    /// Draws x_0 and the direction of the first edge. `u` is uniform in `[0, 1)⁵`, the first number already used up for
    /// what the rest decide.
    #[must_use]
    pub fn sample_emission(&self, accel: &Accel, u: [f64; 5]) -> EmissionSample {
        match self {
            Self::Mesh(light) => light.sample_emission(accel, u),
            Self::Shape(light) => light.sample_emission(accel, u),
            Self::Point(light) => light.sample_emission(u),
            Self::Spot(light) => light.sample_emission(u),
            Self::Directional(light) => light.sample_emission(u),
            Self::Environment(light) => light.sample_emission(u),
            Self::Projector(light) => light.sample_emission(u),
            Self::EnvironmentMap(light) => light.sample_emission(u),
        }
    }

    /// The density with which [`sample_emission`](Self::sample_emission) draws x_0 and `direction`.
    #[must_use]
    #[inline(always)]
    pub fn emission_density(&self, x0: &Vertex, direction: DVec3) -> EdgeDensity {
        match self {
            Self::Mesh(MeshEmitter { area, .. }) | Self::Shape(ShapeEmitter { area, .. }) => {
                surface::emission_density(*area, x0, direction)
            }
            Self::Point(_) => Point::emission_density(),
            Self::Spot(light) => light.emission_density(direction),
            Self::Directional(light) => light.emission_density(x0, direction),
            Self::Environment(light) => light.emission_density(x0, direction),
            Self::Projector(light) => light.emission_density(direction),
            Self::EnvironmentMap(light) => light.emission_density(x0, direction),
        }
    }

    /// Draws x_0 for a given x_1, of which the position is enough; `None` where no light can come from here. `u` is uniform
    /// in `[0, 1)³`.
    #[must_use]
    #[inline(always)]
    pub fn sample_direct(&self, accel: &Accel, x1: DVec3, u: [f64; 3]) -> Option<DirectSample> {
        match self {
            Self::Mesh(light) => Some(light.sample_direct(accel, u)),
            other => other.sample_direct_otherwise(accel, x1, u),
        }
    }

    #[inline(never)]
    fn sample_direct_otherwise(&self, accel: &Accel, x1: DVec3, u: [f64; 3]) -> Option<DirectSample> {
        match self {
            Self::Mesh(light) => Some(light.sample_direct(accel, u)),
            Self::Shape(light) => light.sample_direct(accel, x1, [u[1], u[2]]),
            Self::Point(light) => Some(light.sample_direct()),
            Self::Spot(light) => Some(light.sample_direct()),
            Self::Directional(light) => Some(light.sample_direct(x1)),
            Self::Environment(light) => Some(light.sample_direct(x1, [u[1], u[2]])),
            Self::Projector(light) => Some(light.sample_direct()),
            Self::EnvironmentMap(light) => Some(light.sample_direct(x1, u)),
        }
    }

    /// The density with which [`sample_direct`](Self::sample_direct) draws x_0 for x_1; `edge` leads from x_1 to x_0.
    #[must_use]
    #[inline]
    pub fn direct_density(&self, accel: &Accel, x1: DVec3, x0: &Vertex, edge: &Edge) -> Density<Area> {
        let to_area = || edge.solid_angle_to_area(x0);
        match self {
            Self::Mesh(light) => light.direct_density(),
            Self::Shape(light) => light.direct_density(accel, x1, x0, edge),
            Self::Point(_) | Self::Spot(_) | Self::Projector(_) => Density::new(1.0),
            Self::Directional(_) => Density::new(1.0) * to_area(),
            Self::EnvironmentMap(light) => light.direct_density(edge) * to_area(),
            Self::Environment(_) => Environment::direct_density() * to_area(),
        }
    }

    /// Radiant flux \[W\], exact or nearly so: what emitters are chosen by. Of a textured
    /// surface, from the mean over 2¹⁴ points.
    #[must_use]
    pub fn flux(&self) -> Rgb {
        match self {
            Self::Mesh(MeshEmitter { flux, .. }) | Self::Shape(ShapeEmitter { flux, .. }) => *flux,
            Self::Point(light) => light.flux(),
            Self::Spot(light) => light.flux(),
            Self::Directional(light) => light.flux(),
            Self::Environment(light) => light.flux(),
            Self::Projector(light) => light.flux(),
            Self::EnvironmentMap(light) => light.flux(),
        }
    }

    /// It is a surface of the scene.
    #[must_use]
    pub fn is_surface(&self) -> bool {
        matches!(self, Self::Mesh(_) | Self::Shape(_))
    }

    /// It is what rays that leave the scene meet.
    #[must_use]
    pub fn is_environment(&self) -> bool {
        matches!(self, Self::Environment(_) | Self::EnvironmentMap(_))
    }

    /// Its points are at a finite place, so that x_0 can be drawn on its own, before any direction.
    #[must_use]
    pub fn is_local(&self) -> bool {
        !matches!(self, Self::Directional(_)) && !self.is_environment()
    }

    /// A walk that hits a surface or leaves the scene can find it (technique s = 0).
    #[must_use]
    pub fn can_be_hit(&self) -> bool {
        self.is_surface() || self.is_environment()
    }
}

/// A vertex on a light without a surface.
fn point_vertex(id: EmitterId, position: DVec3) -> Vertex {
    Vertex { position, normal: DVec3::ZERO, shading_normal: DVec3::ZERO, kind: VertexKind::Light(id) }
}
