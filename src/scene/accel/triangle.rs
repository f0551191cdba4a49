//! Ray against triangle in double precision.

use glam::{DVec3, Vec3};

use crate::geometry::{Bounds, Ray};

/// A triangle, stored in single precision; its front is where its corners go round counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// The corners, relative to the scene's centre \[m\].
    pub corners: [Vec3; 3],
    /// The shape that it belongs to.
    pub shape: u32,
}

impl Triangle {
    /// The corners in double precision.
    #[must_use]
    #[inline]
    pub fn corners(&self) -> [DVec3; 3] {
        self.corners.map(|c| c.as_dvec3())
    }

    /// Twice the area times the unit normal.
    #[must_use]
    #[inline]
    pub fn area_vector(&self) -> DVec3 {
        let [a, b, c] = self.corners();
        (b - a).cross(c - a)
    }

    /// Its area \[m²\].
    #[must_use]
    pub fn area(&self) -> f64 {
        0.5 * self.area_vector().length()
    }

    /// The point with the given weights of the second and third corner.
    #[must_use]
    #[inline]
    pub fn point(&self, [v, w]: [f64; 2]) -> DVec3 {
        let [a, b, c] = self.corners();
        a + (b - a) * v + (c - a) * w
    }

    /// The smallest box around it.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        Bounds::around(self.corners())
    }

    /// The distance at which a ray meets it, from either side, and the weights of its second and third corner.
    ///
    /// The ray meets the triangle where it passes all three edges on the same side. The side of an edge p → q is the sign
    /// of the volume d · (p × q) with p and q relative to the origin; exchanging p and q flips its sign exactly, so a ray
    /// cannot pass between two triangles that share an edge.
    #[must_use]
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<(f64, [f64; 2])> {
        let [a, b, c] = self.corners.map(|p| p.as_dvec3() - ray.origin);
        let d = ray.direction;
        let u = d.dot(c.cross(b));
        let v = d.dot(a.cross(c));
        let w = d.dot(b.cross(a));
        let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
        let volume = u + v + w;
        if !inside || volume == 0.0 {
            return None;
        }
        let normal = (b - a).cross(c - a);
        let t = a.dot(normal) / d.dot(normal);
        (t > 0.0 && t < f64::INFINITY).then(|| (t, [v / volume, w / volume]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::Random;

    fn triangle(corners: [[f32; 3]; 3]) -> Triangle {
        Triangle { corners: corners.map(Vec3::from), shape: 0 }
    }

    #[test]
    fn finds_distance_and_weights_from_both_sides() {
        let t = triangle([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]]);
        for (z, sign) in [(3.0, -1.0), (-3.0, 1.0)] {
            let hit = t.intersect(&Ray::new(DVec3::new(0.5, 1.0, z), DVec3::Z * sign)).expect("a hit");
            assert_eq!(hit, (3.0, [0.25, 0.5]));
            assert!(t.intersect(&Ray::new(DVec3::new(0.5, 1.0, z), DVec3::Z * -sign)).is_none());
            assert!(t.intersect(&Ray::new(DVec3::new(1.5, 1.0, z), DVec3::Z * sign)).is_none());
        }
    }

    /// 10⁵ rays aimed at random points of the shared edge of two triangles: none passes between them.
    #[test]
    fn shared_edges_do_not_leak() {
        let (p, q) = ([0.137, -1.913, 0.71], [2.3, 1.77, -0.433]);
        let left = triangle([p, q, [-1.1, 1.3, 0.21]]);
        let right = triangle([q, p, [3.7, -1.2, 0.57]]);
        let mut random = Random::new(1, 0, 0);
        for _ in 0..100_000 {
            let [u, v] = random.uniform2();
            let edge = Vec3::from(p).as_dvec3().lerp(Vec3::from(q).as_dvec3(), 0.01 + 0.98 * u);
            let origin = DVec3::new(4.0 * v - 2.0, random.uniform() - 0.5, 5.0);
            let ray = Ray::new(origin, (edge - origin).normalize());
            assert!(left.intersect(&ray).is_some() || right.intersect(&ray).is_some(), "{ray:?}");
        }
    }
}
