//! Ray against one triangle, in double precision and without gaps.

use crate::geometry::Ray;

/// A ray in coordinates in which it runs along the z axis from the origin (Woop et al. 2013): z is the largest component
/// of its direction, and x and y are sheared along it.
#[derive(Clone, Copy, Debug)]
pub(super) struct LeafRay {
    origin: [f64; 3],
    shear: [f64; 2],
    scale: f64,
    /// Which axes of the world x, y and z are.
    axes: [usize; 3],
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Default)]
pub(super) struct TriangleHit {
    /// Distance along the ray, in lengths of its direction.
    pub t: f64,
    pub v: f64,
    pub w: f64,
    /// One over what the weights add up to.
    pub scale: f64,
}

impl TriangleHit {
    /// Weights of the second and third corner.
    #[inline]
    pub fn barycentric(&self) -> [f64; 2] {
        [self.v * self.scale, self.w * self.scale]
    }
}

impl LeafRay {
    /// The direction may have any length; distances are in its units.
    #[inline]
    pub fn new(ray: &Ray) -> Self {
        let d = ray.direction.to_array();
        let [x, y, z] = d.map(f64::abs);
        // Without branches, whose outcome nothing predicts.
        let largest = usize::from((x <= y) | (x <= z)) * (1 + usize::from(y <= z));
        let axes = [[1, 2, 0], [2, 0, 1], [0, 1, 2]][largest];
        let scale = 1.0 / d[axes[2]];
        Self { origin: ray.origin.to_array(), shear: [d[axes[0]] * scale, d[axes[1]] * scale], scale, axes }
    }

    /// Where the ray meets a triangle, from either side, at a distance above zero and up to `t_max`. `corners` knows the
    /// coordinate of a corner along an axis.
    ///
    /// In the ray's coordinates it meets a triangle whose three edges all have the origin on the same side. The side of an
    /// edge p → q is the sign of p_x q_y − p_y q_x. Exchanging p and q flips it exactly, and rounding, which keeps the order of
    /// the two products, can make it zero but not flip it: so a ray cannot pass between triangles that share an edge or a
    /// corner. The distance is the z of the corners with the resulting weights.
    #[inline(always)]
    pub fn intersect(&self, corners: impl Fn(usize, usize) -> f64, t_max: f64) -> Option<TriangleHit> {
        let [kx, ky, kz] = self.axes;
        let corner = |i: usize| {
            let relative = |axis: usize| corners(i, axis) - self.origin[axis];
            let z = relative(kz);
            [relative(kx) - self.shear[0] * z, relative(ky) - self.shear[1] * z, z]
        };
        let [a, b, c] = [corner(0), corner(1), corner(2)];
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
        let volume = u + v + w;
        let scale = 1.0 / volume;
        let t = (u * a[2] + v * b[2] + w * c[2]) * (self.scale * scale);
        if inside && volume == 0.0 {
            return self.intersect_edge_on([a, b, c], t_max);
        }
        (inside && t > 0.0 && t <= t_max).then_some(TriangleHit { t, v, w, scale })
    }

    /// Seen edge-on all sides may round to zero, and the triangle still be the only one that the ray meets. Here they are right
    /// to 1.5 ulps, so that zero is zero.
    #[cold]
    fn intersect_edge_on(&self, [a, b, c]: [[f64; 3]; 3], t_max: f64) -> Option<TriangleHit> {
        let side = |p: [f64; 3], q: [f64; 3]| difference_of_products(p[0], q[1], p[1], q[0]);
        let (u, v, w) = (side(c, b), side(a, c), side(b, a));
        let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
        let scale = 1.0 / (u + v + w);
        let t = (u * a[2] + v * b[2] + w * c[2]) * (self.scale * scale);
        // A division by zero gives NaN or infinity, which are in no range.
        (inside && t > 0.0 && t <= t_max).then_some(TriangleHit { t, v, w, scale })
    }
}

/// a b − c d to 1.5 ulps (Kahan's algorithm; Jeannerod, Louvet and Muller 2013).
fn difference_of_products(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let second = c * d;
    let error = (-c).mul_add(d, second);
    a.mul_add(b, -second) + error
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::sampler::Random;
    use crate::scene::accel::Triangle;

    /// The nearest hit, and a bit for each triangle met.
    fn intersect(triangles: &[[[f64; 3]; 3]], ray: &Ray) -> (Option<TriangleHit>, u32) {
        let ray = LeafRay::new(ray);
        let hit = |corners: &[[f64; 3]; 3]| ray.intersect(|i, axis| corners[i][axis], f64::MAX);
        let hits: Vec<Option<TriangleHit>> = triangles.iter().map(hit).collect();
        let mask = hits.iter().enumerate().map(|(i, hit)| u32::from(hit.is_some()) << i).sum();
        (hits.into_iter().flatten().min_by(|a, b| a.t.total_cmp(&b.t)), mask)
    }

    #[test]
    fn finds_distance_and_weights_from_both_sides() {
        let triangle = [[[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]]];
        for (z, sign) in [(3.0, -1.0), (-3.0, 1.0)] {
            let hit = intersect(&triangle, &Ray::new(DVec3::new(0.5, 1.0, z), DVec3::Z * sign)).0.unwrap();
            assert_eq!((hit.t, hit.barycentric()), (3.0, [0.25, 0.5]));
            assert_eq!(intersect(&triangle, &Ray::new(DVec3::new(0.5, 1.0, z), DVec3::Z * -sign)).1, 0);
            assert_eq!(intersect(&triangle, &Ray::new(DVec3::new(1.5, 1.0, z), DVec3::Z * sign)).1, 0);
        }
    }

    /// 10⁵ rays aimed at random points of the shared edge of two triangles: none passes between them.
    #[test]
    fn shared_edges_do_not_leak() {
        let (p, q) = ([0.137, -1.913, 0.71], [2.3, 1.77, -0.433]);
        let triangles = [[p, q, [-1.1, 1.3, 0.21]], [q, p, [3.7, -1.2, 0.57]]];
        let mut random = Random::new(1, 0, 0);
        for _ in 0..100_000 {
            let [u, v] = random.uniform2();
            let edge = DVec3::from_array(p).lerp(DVec3::from_array(q), 0.01 + 0.98 * u);
            let origin = DVec3::new(4.0 * v - 2.0, random.uniform() - 0.5, 5.0);
            let ray = Ray::new(origin, (edge - origin).normalize());
            assert_ne!(intersect(&triangles, &ray).1, 0, "{ray:?}");
        }
    }

    /// Every axis may be the largest of the direction.
    #[test]
    fn all_directions_agree_with_the_plane() {
        let corners = [[0.3, -0.2, 0.1], [0.7, 0.9, -0.4], [-0.5, 0.2, 0.8]];
        let triangle = Triangle { corners: corners.map(DVec3::from_array), shape: 0 };
        let mut random = Random::new(2, 0, 0);
        for _ in 0..1000 {
            let [v, w] = random.uniform2().map(|u| 0.45 * u);
            let direction = crate::warp::uniform_sphere(random.uniform2());
            let ray = Ray::new(triangle.point([v, w]) - direction * 2.5, direction);
            if triangle.normal().dot(direction).abs() < 0.01 {
                continue;
            }
            let hit = intersect(&[corners], &ray).0.unwrap();
            let weights = hit.barycentric();
            assert!((hit.t - 2.5).abs() < 1e-12, "{ray:?}: {}", hit.t);
            assert!((weights[0] - v).abs() < 1e-12 && (weights[1] - w).abs() < 1e-12, "{ray:?}");
        }
    }

    /// Two triangles with a gap of 10⁻¹⁰ a thousand times their size away from the origin: the nearer one is met.
    #[test]
    fn a_narrow_gap_stays_open() {
        let at = |z: f64| [[999.0, 0.0, z], [1001.0, 0.0, z], [1000.0, 2.0, z]];
        let triangles = [at(7.0 - 1e-10), at(7.0)];
        let down = Ray::new(DVec3::new(1000.0, 1.0, 9.0), -DVec3::Z);
        assert_eq!(intersect(&triangles[..1], &down).0.unwrap().t, 2.0 + (7.0 - (7.0 - 1e-10)));
        assert_eq!(intersect(&triangles, &down).0.unwrap().t, 2.0);
    }

    /// Seen so that all products of its sides round to the same.
    #[test]
    fn a_triangle_seen_edge_on_is_met() {
        let ulp = f64::EPSILON;
        // With p = 1 + ε, q = 1 + 2ε and r = 1: p² = q r + ε², which rounding loses.
        let (p, q) = (1.0 + ulp, 1.0 + 2.0 * ulp);
        let corners = [[p, q, 5.0], [1.0, p, 5.0], [-1.0, -p, 5.0]];
        let hit = intersect(&[corners], &Ray::new(DVec3::ZERO, DVec3::Z)).0.unwrap();
        assert_eq!(hit.t, 5.0);
        assert_eq!(difference_of_products(p, p, q, 1.0), ulp * ulp);
    }
}
