//! Lights at infinity, placed on a sphere around the whole scene, sensor included.
//!
//! The first vertex of their paths is the point of that sphere from which the light comes, so the first edge is like any
//! other. A walk draws its direction first and then a point on the disk that the sphere casts along it; the disk's area
//! measure is the sphere's times |cos θ_0|.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use crate::geometry::Frame;
use crate::measure::{Density, SolidAngle};
use crate::path::{Edge, Vertex, VertexKind};
use crate::spectrum::Rgb;
use crate::warp;

use super::{DirectSample, EdgeDensity, EmissionSample, EmitterId};

/// The same radiance from everywhere.
#[derive(Clone, Copy, Debug)]
pub struct Environment {
    /// Its own id.
    pub id: EmitterId,
    /// Radiance \[W/m²/sr\].
    pub radiance: Rgb,
    /// Radius of the sphere that stands for infinity, around the scene's centre \[m\].
    pub sphere_radius: f64,
}

/// Parallel light: Dirac in the direction of the first edge.
#[derive(Clone, Copy, Debug)]
pub struct Directional {
    /// Its own id.
    pub id: EmitterId,
    /// Where the light goes, of length one.
    pub direction: DVec3,
    /// Irradiance of a surface that faces it \[W/m²\].
    pub irradiance: Rgb,
    /// Radius of the sphere that stands for infinity, around the scene's centre \[m\].
    pub sphere_radius: f64,
}

impl Environment {
    /// The vertex where a ray that leaves the scene meets infinity.
    #[must_use]
    #[inline]
    pub fn beyond(&self, origin: DVec3, direction: DVec3) -> Vertex {
        infinite_vertex(self.id, leave_sphere(origin, direction, self.sphere_radius), self.sphere_radius)
    }

    pub(super) fn sample_emission(&self, u: [f64; 5]) -> EmissionSample {
        let direction = warp::uniform_sphere([u[3], u[4]]);
        EmissionSample { vertex: entry(self.id, direction, self.sphere_radius, [u[1], u[2]]), direction }
    }

    pub(super) fn emission_density(&self, x0: &Vertex, direction: DVec3) -> EdgeDensity {
        EdgeDensity {
            position: disk_density(self.sphere_radius) * x0.abs_cos(direction),
            direction: warp::UNIFORM_SPHERE_DENSITY,
        }
    }

    pub(super) fn sample_direct(&self, x1: DVec3, u: [f64; 2]) -> DirectSample {
        let direction = warp::uniform_sphere(u);
        let vertex = self.beyond(x1, direction);
        let edge = Edge::from_to(x1, vertex.position);
        DirectSample { vertex, density: Self::direct_density() * edge.solid_angle_to_area(&vertex) }
    }

    pub(super) fn direct_density() -> Density<SolidAngle> {
        warp::UNIFORM_SPHERE_DENSITY
    }

    /// `4π² R² L`: what enters the sphere.
    pub(super) fn flux(&self) -> Rgb {
        self.radiance * (4.0 * PI * PI * self.sphere_radius * self.sphere_radius)
    }
}

impl Directional {
    pub(super) fn sample_emission(&self, u: [f64; 5]) -> EmissionSample {
        let vertex = entry(self.id, self.direction, self.sphere_radius, [u[1], u[2]]);
        EmissionSample { vertex, direction: self.direction }
    }

    pub(super) fn emission_density(&self, x0: &Vertex, direction: DVec3) -> EdgeDensity {
        EdgeDensity { position: disk_density(self.sphere_radius) * x0.abs_cos(direction), direction: Density::new(1.0) }
    }

    pub(super) fn sample_direct(&self, x1: DVec3) -> DirectSample {
        let position = leave_sphere(x1, -self.direction, self.sphere_radius);
        let vertex = infinite_vertex(self.id, position, self.sphere_radius);
        let edge = Edge::from_to(x1, vertex.position);
        DirectSample { vertex, density: Density::<SolidAngle>::new(1.0) * edge.solid_angle_to_area(&vertex) }
    }

    /// `π R² E`: what enters the sphere.
    pub(super) fn flux(&self) -> Rgb {
        self.irradiance * (PI * self.sphere_radius * self.sphere_radius)
    }
}

/// `1 / (π R²)`: uniform on the disk that the sphere casts.
pub(super) fn disk_density(radius: f64) -> Density<crate::measure::Area> {
    Density::new(1.0 / (PI * radius * radius))
}

/// Where a line with this direction, drawn uniformly among those that meet the sphere, enters it.
pub(super) fn entry(id: EmitterId, direction: DVec3, radius: f64, u: [f64; 2]) -> Vertex {
    let frame = Frame::around(direction);
    let DVec2 { x, y } = warp::concentric_disk(u);
    // The rim itself has density zero.
    let height = (1.0 - x * x - y * y).max(f64::EPSILON).sqrt();
    infinite_vertex(id, frame.to_world(DVec3::new(x, y, -height)) * radius, radius)
}

/// The vertex at a position on the sphere.
pub(crate) fn infinite_vertex(id: EmitterId, position: DVec3, radius: f64) -> Vertex {
    let normal = -position / radius;
    Vertex { position, normal, shading_normal: normal, kind: VertexKind::Infinite(id) }
}

/// Where a ray from inside the sphere around the centre leaves it.
pub(super) fn leave_sphere(origin: DVec3, direction: DVec3, radius: f64) -> DVec3 {
    let b = origin.dot(direction);
    let nearest = origin - direction * b;
    let t = (radius * radius - nearest.length_squared()).max(0.0).sqrt() - b;
    origin + direction * t
}
