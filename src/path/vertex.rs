//! A vertex of a light path.

use glam::DVec3;

use crate::measure::{Area, Jacobian, SolidAngle};
use crate::scene::{EmitterId, MaterialId, PrimitiveId};

/// A point that a path visits, relative to the scene's centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Where it is \[m\].
    pub position: DVec3,
    /// Unit geometric normal towards the front. Zero where there is no surface: point lights and pinholes.
    pub normal: DVec3,
    /// Unit shading normal, interpolated between a mesh's vertices; elsewhere the geometric normal.
    pub shading_normal: DVec3,
    /// What it lies on.
    pub kind: VertexKind,
}

/// What a vertex lies on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum VertexKind {
    /// A surface of the scene.
    Surface {
        /// The triangle or sphere.
        primitive: PrimitiveId,
        /// How it scatters.
        material: MaterialId,
        /// The emitter that the surface is, where it is one.
        emitter: Option<EmitterId>,
    },
    /// A light without a surface.
    Light(EmitterId),
    /// The sphere around the scene that stands for infinity, seen as this emitter; its normal points inwards.
    Infinite(EmitterId),
    /// The pinhole, a point of the lens, or a point of an orthographic film; the latter two face the scene.
    Sensor {
        /// ζ in `[0, 1)`: which of the pixels is meant that share the edge's point of the film, as
        /// [`Sensor`](crate::scene::sensor::Sensor) has it.
        zeta: f64,
        /// The surface of the scene that it lies on: that of an irradiance meter, else none.
        primitive: PrimitiveId,
    },
}

impl VertexKind {
    /// In one word, for people.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Surface { emitter: Some(_), .. } => "emitter",
            Self::Surface { .. } => "surface",
            Self::Light(_) => "light",
            Self::Infinite(_) => "infinity",
            Self::Sensor { .. } => "sensor",
        }
    }
}

impl Vertex {
    /// The surface that it lies on, or none.
    #[must_use]
    #[inline]
    pub fn primitive(&self) -> PrimitiveId {
        match self.kind {
            VertexKind::Surface { primitive, .. } | VertexKind::Sensor { primitive, .. } => primitive,
            _ => PrimitiveId::NONE,
        }
    }

    /// The emitter that it lies on, or none.
    #[must_use]
    #[inline]
    pub fn emitter(&self) -> Option<EmitterId> {
        match self.kind {
            VertexKind::Surface { emitter, .. } => emitter,
            VertexKind::Light(emitter) | VertexKind::Infinite(emitter) => Some(emitter),
            VertexKind::Sensor { .. } => None,
        }
    }

    /// A path can go on from here: it is on a surface of the scene.
    #[must_use]
    #[inline]
    pub fn scatters(&self) -> bool {
        matches!(self.kind, VertexKind::Surface { .. })
    }

    /// `|cos θ|` of a unit direction against the geometric normal; one where there is no surface.
    #[must_use]
    #[inline]
    pub fn abs_cos(&self, direction: DVec3) -> f64 {
        if self.normal == DVec3::ZERO { 1.0 } else { self.normal.dot(direction).abs() }
    }

    /// `dσ_self / dA(next)`, for turning a density of directions from here into one of points there.
    #[must_use]
    #[inline]
    pub fn solid_angle_to_area(&self, next: &Self) -> Jacobian<SolidAngle, Area> {
        let edge = Edge::between(self, next);
        edge.solid_angle_to_area(next)
    }

    /// The unit direction to another vertex.
    #[must_use]
    #[inline]
    pub fn direction_to(&self, other: &Self) -> DVec3 {
        Edge::between(self, other).direction
    }
}

/// The edge between two vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Unit direction from the first to the second.
    pub direction: DVec3,
    /// Squared distance \[m²\].
    pub length_squared: f64,
}

impl Edge {
    /// From `a` to `b`. Exchanging the two changes the sign of the direction and nothing else, bit for bit.
    #[must_use]
    #[inline]
    pub fn between(a: &Vertex, b: &Vertex) -> Self {
        Self::from_to(a.position, b.position)
    }

    /// The same for bare points.
    #[must_use]
    #[inline]
    pub fn from_to(a: DVec3, b: DVec3) -> Self {
        let offset = b - a;
        let length_squared = offset.length_squared();
        Self { direction: offset * (1.0 / length_squared.sqrt()), length_squared }
    }

    /// The same edge from its other end.
    #[must_use]
    #[inline]
    pub fn reversed(&self) -> Self {
        Self { direction: -self.direction, ..*self }
    }

    /// `dσ_start / dA(end)`: from directions at the edge's start to points at its end, which is given.
    #[must_use]
    #[inline]
    pub fn solid_angle_to_area(&self, end: &Vertex) -> Jacobian<SolidAngle, Area> {
        Jacobian::solid_angle_to_area(end.abs_cos(self.direction), self.length_squared)
    }

    /// `G = |cos θ_a cos θ_b| / ‖a−b‖²` \[1/m²\] without visibility.
    #[must_use]
    #[inline]
    pub fn geometry(&self, a: &Vertex, b: &Vertex) -> f64 {
        a.abs_cos(self.direction) * b.abs_cos(self.direction) / self.length_squared
    }
}
