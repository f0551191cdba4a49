//! What lies between: the shadow of a triangle, cut out exactly.

use glam::DVec3;

use crate::geometry::Bounds;
use crate::scene::{PrimitiveId, Scene};

use super::polygon::{Corners, Plane, Polygon, area_vector};

/// A triangle that may lie between two points of surfaces.
#[derive(Debug)]
pub(super) struct Obstacle {
    primitive: PrimitiveId,
    corners: Corners,
    plane: Plane,
    bounds: Bounds,
}

impl Obstacle {
    /// The triangles with some of the scene on either side, by more than `flat` \[m\]: no other can lie between.
    pub fn all(scene: &Scene, flat: f64) -> Vec<Self> {
        let triangles: Vec<_> = scene.accel().triangles().collect();
        let corners: Vec<DVec3> = triangles.iter().flat_map(|(_, t)| t.corners).collect();
        let candidates = triangles.iter().map(|&(primitive, triangle)| Self {
            primitive,
            corners: triangle.corners,
            plane: Plane::of(&triangle.corners),
            bounds: triangle.bounds(),
        });
        candidates.filter(|obstacle| obstacle.parts(&corners, flat)).collect()
    }

    /// It may lie between some two of the points of a convex hull, which are not its own.
    pub fn may_obstruct(&self, points: &[DVec3], hull: &Bounds, own: [PrimitiveId; 2], flat: f64) -> bool {
        let slack = DVec3::splat(flat);
        let near = hull.min.cmple(self.bounds.max + slack).all() && self.bounds.min.cmple(hull.max + slack).all();
        near && !own.contains(&self.primitive) && self.parts(points, flat)
    }

    /// Points lie on both sides of its plane.
    fn parts(&self, points: &[DVec3], flat: f64) -> bool {
        let heights = || points.iter().map(|&p| self.plane.height(p));
        heights().any(|h| h < -flat) && heights().any(|h| h > flat)
    }

    /// Convex polygons without what it hides from x: what lies beyond its plane, within the pyramid from x through it.
    pub fn hide(&self, x: DVec3, polygons: Vec<Polygon>, flat: f64) -> Vec<Polygon> {
        let height = self.plane.height(x);
        if height.abs() <= flat {
            return polygons;
        }
        let beyond = self.plane.turned(-height.signum());
        let [a, b, c] = self.corners.map(|corner| corner - x);
        // The three edges turn the same way round seen from x.
        let side = |p: DVec3, q: DVec3| Plane::at(x, p.cross(q)).turned(-height.signum());
        let shadow = [beyond, side(a, b), side(b, c), side(c, a)];
        let mut seen = Vec::with_capacity(polygons.len());
        for polygon in polygons {
            let hidden = shadow.iter().fold(polygon.clone(), |rest, plane| plane.clip(&rest));
            if hidden.len() < 3 || area_vector(&hidden) == DVec3::ZERO {
                seen.push(polygon);
                continue;
            }
            let mut rest = polygon;
            for plane in &shadow {
                let outside = plane.turned(-1.0).clip(&rest);
                if outside.len() > 2 {
                    seen.push(outside);
                }
                rest = plane.clip(&rest);
            }
        }
        seen
    }
}
