//! Where on its surface a vertex is: texture coordinates, tangents, attributes.

use std::collections::HashMap;

use glam::{DVec2, DVec3, Vec2};

use crate::geometry::Frame;
use crate::path::Vertex;

use super::Scene;
use super::accel::{PrimitiveId, Triangle};
use super::texture::{AttributeTable, SurfacePoint};

/// What textures know of the triangles, by primitive id. Empty where nothing of the scene asks.
#[derive(Clone, Debug, Default)]
pub(super) struct Mapping {
    /// Texture coordinates of the corners; of meshes without any, NaN.
    pub(super) texcoords: Vec<[Vec2; 3]>,
    pub(super) attributes: HashMap<String, AttributeTable>,
}

impl Scene {
    /// The frame of the shading normal whose first axis follows u, and the point in it.
    pub(super) fn surface_point(&self, vertex: &Vertex) -> (Frame, SurfacePoint<'_>) {
        let primitive = vertex.primitive();
        let (uv, barycentric, tangents) = match self.accel.as_sphere(primitive) {
            Some(sphere) => {
                let (uv, tangents) = on_sphere(vertex.position - sphere.centre);
                (uv, [0.0; 2], tangents)
            }
            None => self.on_triangle(vertex, primitive),
        };
        let frame = Frame::along(vertex.shading_normal, tangents[0]);
        let tangents = tangents.map(|tangent| frame.to_local(tangent));
        (frame, SurfacePoint { uv, tangents, primitive, barycentric, attributes: &self.mapping.attributes })
    }

    fn on_triangle(&self, vertex: &Vertex, primitive: PrimitiveId) -> (DVec2, [f64; 2], [DVec3; 2]) {
        let triangle = self.accel.triangle(primitive);
        let barycentric = barycentric(&triangle, vertex.position);
        let corners = self.mapping.texcoords.get(primitive.0 as usize).filter(|corners| !corners[0].x.is_nan());
        let Some(corners) = corners else {
            let Frame { x, y, .. } = Frame::around(vertex.shading_normal);
            return (DVec2::from_array(barycentric), barycentric, [x, y]);
        };
        let [a, b, c] = corners.map(Vec2::as_dvec2);
        let (along_v, along_w) = (b - a, c - a);
        let uv = a + along_v * barycentric[0] + along_w * barycentric[1];
        let [p, q, r] = triangle.corners();
        let (edge_v, edge_w) = (q - p, r - p);
        let determinant = along_v.perp_dot(along_w);
        let tangents = if determinant == 0.0 {
            let Frame { x, y, .. } = Frame::around(vertex.shading_normal);
            [x, y]
        } else {
            [edge_v * along_w.y - edge_w * along_v.y, edge_w * along_v.x - edge_v * along_w.x].map(|t| t / determinant)
        };
        (uv, barycentric, tangents)
    }
}

/// Weights of the second and third corner for a point of the triangle.
fn barycentric(triangle: &Triangle, point: DVec3) -> [f64; 2] {
    let [a, b, c] = triangle.corners();
    let (v, w, p) = (b - a, c - a, point - a);
    let normal = v.cross(w);
    let scale = 1.0 / normal.length_squared();
    [p.cross(w).dot(normal) * scale, v.cross(p).dot(normal) * scale]
}

/// `u = φ / 2π`, `v = θ / π`, and the tangents along both, for a point relative to the centre.
fn on_sphere(p: DVec3) -> (DVec2, [DVec3; 2]) {
    use std::f64::consts::{PI, TAU};
    let rim = p.truncate().length();
    let phi = libm::atan2(p.y, p.x);
    let theta = libm::atan2(rim, p.z);
    let uv = DVec2::new((if phi < 0.0 { phi + TAU } else { phi }) / TAU, theta / PI);
    let (c, s) = if rim > 0.0 { (p.x / rim, p.y / rim) } else { (1.0, 0.0) };
    (uv, [DVec3::new(-p.y, p.x, 0.0) * TAU, DVec3::new(p.z * c, p.z * s, -rim) * PI])
}
