//! Where on its surface a vertex is: texture coordinates, tangents, attributes.

#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec2, DVec3, Vec2};

use crate::geometry::Frame;
use crate::path::Vertex;
use crate::spectrum::Rgb;

use super::Scene;
use super::accel::{Accel, AnalyticShape, PrimitiveId, Triangle};
use super::texture::{AttributeTable, SurfacePoint, Texture, clamped};

/// What textures know of the surfaces.
#[derive(Clone, Debug, Default)]
pub(super) struct Mapping {
    /// Texture coordinates of the triangles' corners, by primitive id; of meshes without any, NaN. Empty where nothing of the
    /// scene asks.
    pub(super) texcoords: Vec<[Vec2; 3]>,
    pub(super) attributes: HashMap<String, AttributeTable>,
    /// Of the analytic shapes, in the order of their ids.
    pub(super) placements: Vec<Placement>,
}

/// Where an analytic shape of unit size was put: `p = origin + to_world · local`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    origin: DVec3,
    to_world: DMat3,
    to_local: DMat3,
}

impl Placement {
    pub(super) fn new(origin: DVec3, to_world: DMat3) -> Self {
        Self { origin, to_world, to_local: to_world.inverse() }
    }
}

/// Texture coordinates, barycentric weights and the tangents along u and v.
struct Coordinates {
    uv: DVec2,
    barycentric: [f64; 2],
    tangents: [DVec3; 2],
}

impl Mapping {
    /// What a texture says a point of a surface emits \[W/m²/sr\]; what is negative or no number is black.
    pub(super) fn emitted(&self, accel: &Accel, texture: &Texture, primitive: PrimitiveId, position: DVec3) -> Rgb {
        let Coordinates { uv, barycentric, tangents } = self.coordinates(accel, primitive, position, DVec3::Z);
        let at = SurfacePoint { uv, tangents, primitive, barycentric, attributes: &self.attributes };
        Rgb::from(texture.colour(&at).to_array().map(|x| clamped(x, 0.0, f64::MAX)))
    }

    /// Around `normal` are the tangents of a surface that has none.
    fn coordinates(&self, accel: &Accel, primitive: PrimitiveId, position: DVec3, normal: DVec3) -> Coordinates {
        match accel.analytic_index(primitive) {
            Some(index) => {
                let (uv, tangents) = on_analytic(&accel.analytic()[index], &self.placements[index], position);
                Coordinates { uv, barycentric: [0.0; 2], tangents }
            }
            None => self.on_triangle(&accel.triangle(primitive), primitive, position, normal),
        }
    }

    fn on_triangle(&self, triangle: &Triangle, primitive: PrimitiveId, position: DVec3, normal: DVec3) -> Coordinates {
        let barycentric = barycentric(triangle, position);
        let around = || {
            let Frame { x, y, .. } = Frame::around(normal);
            [x, y]
        };
        let corners = self.texcoords.get(primitive.0 as usize).filter(|corners| !corners[0].x.is_nan());
        let Some(corners) = corners else {
            return Coordinates { uv: DVec2::from_array(barycentric), barycentric, tangents: around() };
        };
        let [a, b, c] = corners.map(Vec2::as_dvec2);
        let (along_v, along_w) = (b - a, c - a);
        let uv = a + along_v * barycentric[0] + along_w * barycentric[1];
        let [p, q, r] = triangle.corners;
        let (edge_v, edge_w) = (q - p, r - p);
        let determinant = along_v.perp_dot(along_w);
        let tangents = if determinant == 0.0 {
            around()
        } else {
            [edge_v * along_w.y - edge_w * along_v.y, edge_w * along_v.x - edge_v * along_w.x].map(|t| t / determinant)
        };
        Coordinates { uv, barycentric, tangents }
    }
}

impl Scene {
    /// The frame of the shading normal whose first axis follows u, and the point in it.
    pub(super) fn surface_point(&self, vertex: &Vertex) -> (Frame, SurfacePoint<'_>) {
        let (primitive, normal) = (vertex.primitive(), vertex.shading_normal);
        let Coordinates { uv, barycentric, tangents } =
            self.mapping.coordinates(&self.accel, primitive, vertex.position, normal);
        let frame = Frame::along(normal, tangents[0]);
        let tangents = tangents.map(|tangent| frame.to_local(tangent));
        (frame, SurfacePoint { uv, tangents, primitive, barycentric, attributes: &self.mapping.attributes })
    }
}

/// Weights of the second and third corner for a point of the triangle; of its middle where it has no area.
fn barycentric(triangle: &Triangle, point: DVec3) -> [f64; 2] {
    let [a, b, c] = triangle.corners;
    let (v, w, p) = (b - a, c - a, point - a);
    let normal = v.cross(w);
    let scale = 1.0 / normal.length_squared();
    let weights = [p.cross(w).dot(normal) * scale, v.cross(p).dot(normal) * scale];
    if weights.iter().all(|weight| weight.is_finite()) { weights } else { [1.0 / 3.0; 2] }
}

/// Texture coordinates and the tangents along both, as Mitsuba 3 has them.
fn on_analytic(shape: &AnalyticShape, placement: &Placement, position: DVec3) -> (DVec2, [DVec3; 2]) {
    let p = placement.to_local * (position - placement.origin);
    let rim = p.truncate().length();
    let (c, s) = if rim > 0.0 { (p.x / rim, p.y / rim) } else { (1.0, 0.0) };
    let turn = libm::atan2(p.y, p.x) / TAU;
    let turn = if turn < 0.0 { turn + 1.0 } else { turn };
    let around = DVec3::new(-p.y, p.x, 0.0) * TAU;
    let (uv, tangents) = match shape {
        AnalyticShape::Sphere(_) => {
            let pole_to_pole = DVec3::new(p.z * c, p.z * s, -rim) * PI;
            (DVec2::new(turn, libm::atan2(rim, p.z) / PI), [around, pole_to_pole])
        }
        AnalyticShape::Disk(_) => (DVec2::new(rim, turn), [DVec3::new(c, s, 0.0), around]),
        AnalyticShape::Cylinder(_) => (DVec2::new(turn, p.z), [around, DVec3::Z]),
    };
    (uv, tangents.map(|tangent| placement.to_world * tangent))
}
