//! A triangle of a mesh.

use glam::DVec3;

use crate::geometry::Bounds;

/// A triangle; its front is where its corners go round counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// The corners, relative to the scene's centre \[m\].
    pub corners: [DVec3; 3],
    /// The shape that it belongs to.
    pub shape: u32,
}

impl Triangle {
    /// The edges opposite of each corner, in turn around the triangle, and the number of the longest.
    #[inline]
    fn edges(&self) -> ([DVec3; 3], usize) {
        let [a, b, c] = self.corners;
        let edges = [c - b, a - c, b - a];
        let [x, y, z] = edges.map(DVec3::length_squared);
        (edges, if x >= y && x >= z { 0 } else { 1 + usize::from(z > y) })
    }

    /// Twice the area times the unit normal.
    ///
    /// Any two edges have the same product; of a needle the two shorter ones are almost at right angles, where the long ones
    /// are almost parallel and would cancel.
    #[must_use]
    pub fn area_vector(&self) -> DVec3 {
        let (edges, longest) = self.edges();
        edges[(longest + 1) % 3].cross(edges[(longest + 2) % 3])
    }

    /// Its area \[m²\].
    #[must_use]
    pub fn area(&self) -> f64 {
        0.5 * self.area_vector().length()
    }

    /// The unit normal of its front. Where it has no area, at right angles to its longest edge: rounding may make a ray meet
    /// it there.
    #[must_use]
    pub fn normal(&self) -> DVec3 {
        let (edges, longest) = self.edges();
        // To length one first: areas of areas leave the range of numbers early.
        let scale = edges[longest].abs().max_element().recip();
        let [p, q, r] = [longest, (longest + 1) % 3, (longest + 2) % 3].map(|edge| edges[edge] * scale);
        let along = || p.try_normalize().map_or(DVec3::Z, DVec3::any_orthonormal_vector);
        q.cross(r).try_normalize().unwrap_or_else(along)
    }

    /// The point with the given weights of the second and third corner.
    #[must_use]
    #[inline]
    pub fn point(&self, [v, w]: [f64; 2]) -> DVec3 {
        let [a, b, c] = self.corners;
        a + (b - a) * v + (c - a) * w
    }

    /// The smallest box around it.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        Bounds::around(self.corners)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(corners: [[f64; 3]; 3]) -> Triangle {
        Triangle { corners: corners.map(DVec3::from_array), shape: 0 }
    }

    #[test]
    fn needles_have_exact_normals() {
        let long = DVec3::new(0.3, -0.7, 0.2);
        for start in 0..3 {
            let mut corners = [DVec3::ZERO, long + DVec3::X * 1e-12, long];
            corners.rotate_left(start);
            let needle = Triangle { corners, shape: 0 };
            let short = (long + DVec3::X * 1e-12).x - long.x;
            let expected = DVec3::new(short, 0.0, 0.0).cross(long);
            assert!((needle.area_vector() - expected).length() < 1e-15 * expected.length(), "{needle:?}");
            assert!((needle.normal() - expected.normalize()).length() < 1e-15, "{needle:?}");
        }
    }

    #[test]
    fn what_has_no_area_has_a_normal() {
        let (p, q) = ([0.3, -0.7, 0.2], [0.6, -1.4, 0.4]);
        for corners in [[[0.0; 3], p, q], [p, [0.0; 3], q], [p, p, q], [p, p, p]] {
            let flat = triangle(corners);
            assert!((flat.normal().length() - 1.0).abs() < 1e-15 && flat.area() < 1e-16, "{flat:?}: {}", flat.normal());
        }
    }

    #[test]
    fn size_does_not_matter() {
        let of_one = triangle([[0.1, 0.2, 0.3], [0.9, -0.4, 0.2], [0.5, 0.8, -0.6]]);
        for size in [f64::powi(2.0, -300), f64::powi(2.0, 300)] {
            let other = Triangle { corners: of_one.corners.map(|c| c * size), shape: 0 };
            assert!((other.normal() - of_one.normal()).length() < 1e-15);
        }
    }
}
