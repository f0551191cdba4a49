//! Ray against triangles in double precision, eight at a time.

use glam::{DVec3, Vec3};
use wide::f64x8;

use crate::geometry::{Bounds, Ray};

/// Triangles in a block.
pub(super) const LANES: usize = 8;

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
        self.corners.map(Vec3::as_dvec3)
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
}

/// A ray in coordinates in which it runs along the z axis from the origin (Woop et al. 2013): z is the largest component
/// of its direction, and x and y are sheared along it.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShearedRay {
    origin: [f64; 3],
    axes: [usize; 3],
    shear: [f64; 2],
    scale: f64,
}

impl ShearedRay {
    #[inline]
    pub fn new(ray: &Ray) -> Self {
        let d = ray.direction.to_array();
        let [x, y, z] = d.map(f64::abs);
        let axes = if x > y && x > z {
            [1, 2, 0]
        } else if y > z {
            [2, 0, 1]
        } else {
            [0, 1, 2]
        };
        let scale = 1.0 / d[axes[2]];
        Self { origin: ray.origin.to_array(), axes, shear: [d[axes[0]] * scale, d[axes[1]] * scale], scale }
    }
}

/// Up to eight triangles of a leaf, corner by corner and axis by axis; unused lanes are NaN, which no ray meets.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub(super) struct Block {
    corners: [[[f32; LANES]; 3]; 3],
}

/// Where a ray meets the triangles of a block.
pub(super) struct BlockHits {
    /// A bit for each triangle that is met within the range.
    pub mask: u32,
    t: f64x8,
    v: f64x8,
    w: f64x8,
    volume: f64x8,
}

impl Block {
    pub fn new(triangles: impl Iterator<Item = Triangle>) -> Self {
        let mut corners = [[[f32::NAN; LANES]; 3]; 3];
        for (lane, triangle) in triangles.take(LANES).enumerate() {
            for (corner, point) in triangle.corners.iter().enumerate() {
                for axis in 0..3 {
                    corners[corner][axis][lane] = point[axis];
                }
            }
        }
        Self { corners }
    }

    #[inline]
    pub fn corners(&self, lane: usize) -> [Vec3; 3] {
        self.corners.map(|[x, y, z]| Vec3::new(x[lane], y[lane], z[lane]))
    }

    /// The triangles that a ray meets, from either side, at a distance above zero and up to `t_max`.
    ///
    /// In the ray's coordinates it meets a triangle whose three edges all have the origin on the same side. The side of an
    /// edge p → q is the sign of p_x q_y − p_y q_x; exchanging p and q flips it exactly, so a ray cannot pass between two
    /// triangles that share an edge. The distance is the z of the corners with the resulting weights.
    #[inline(always)]
    pub fn intersect(&self, ray: &ShearedRay, t_max: f64) -> BlockHits {
        let [kx, ky, kz] = ray.axes;
        let relative = |corner: usize, axis: usize| {
            f64x8::from(self.corners[corner][axis].map(f64::from)) - f64x8::splat(ray.origin[axis])
        };
        let (shear_x, shear_y) = (f64x8::splat(ray.shear[0]), f64x8::splat(ray.shear[1]));
        let corner = |i: usize| {
            let z = relative(i, kz);
            (relative(i, kx) - shear_x * z, relative(i, ky) - shear_y * z, z)
        };
        let ((ax, ay, az), (bx, by, bz), (cx, cy, cz)) = (corner(0), corner(1), corner(2));
        let u = cx * by - cy * bx;
        let v = ax * cy - ay * cx;
        let w = bx * ay - by * ax;
        let zero = f64x8::ZERO;
        let inside = (u.simd_ge(zero) & v.simd_ge(zero) & w.simd_ge(zero))
            | (u.simd_le(zero) & v.simd_le(zero) & w.simd_le(zero));
        let volume = u + v + w;
        let t = (u * az + v * bz + w * cz) * f64x8::splat(ray.scale) / volume;
        // A division by zero gives NaN or ±∞, none of which is in the range.
        let mask = (inside & t.simd_gt(zero) & t.simd_le(f64x8::splat(t_max))).to_bitmask();
        BlockHits { mask, t, v, w, volume }
    }
}

impl BlockHits {
    /// Distance and weights of the second and third corner for one of the triangles met.
    #[inline]
    pub fn hit(&self, lane: usize) -> (f64, [f64; 2]) {
        let volume = self.volume.as_array()[lane];
        (self.t.as_array()[lane], [self.v.as_array()[lane] / volume, self.w.as_array()[lane] / volume])
    }

    /// Distance for one of the triangles met.
    #[inline]
    pub fn distance(&self, lane: usize) -> f64 {
        self.t.as_array()[lane]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::Random;

    fn block(triangles: &[[[f32; 3]; 3]]) -> Block {
        Block::new(triangles.iter().map(|corners| Triangle { corners: corners.map(Vec3::from), shape: 0 }))
    }

    fn intersect(block: &Block, ray: &Ray) -> BlockHits {
        block.intersect(&ShearedRay::new(ray), f64::MAX)
    }

    #[test]
    fn finds_distance_and_weights_from_both_sides() {
        let block = block(&[[[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]]]);
        for (z, sign) in [(3.0, -1.0), (-3.0, 1.0)] {
            let hits = intersect(&block, &Ray::new(DVec3::new(0.5, 1.0, z), DVec3::Z * sign));
            assert_eq!(hits.mask, 1);
            assert_eq!(hits.hit(0), (3.0, [0.25, 0.5]));
            assert_eq!(intersect(&block, &Ray::new(DVec3::new(0.5, 1.0, z), DVec3::Z * -sign)).mask, 0);
            assert_eq!(intersect(&block, &Ray::new(DVec3::new(1.5, 1.0, z), DVec3::Z * sign)).mask, 0);
        }
    }

    /// 10⁵ rays aimed at random points of the shared edge of two triangles: none passes between them.
    #[test]
    fn shared_edges_do_not_leak() {
        let (p, q) = ([0.137, -1.913, 0.71], [2.3, 1.77, -0.433]);
        let block = block(&[[p, q, [-1.1, 1.3, 0.21]], [q, p, [3.7, -1.2, 0.57]]]);
        let mut random = Random::new(1, 0, 0);
        for _ in 0..100_000 {
            let [u, v] = random.uniform2();
            let edge = Vec3::from(p).as_dvec3().lerp(Vec3::from(q).as_dvec3(), 0.01 + 0.98 * u);
            let origin = DVec3::new(4.0 * v - 2.0, random.uniform() - 0.5, 5.0);
            let ray = Ray::new(origin, (edge - origin).normalize());
            assert_ne!(intersect(&block, &ray).mask, 0, "{ray:?}");
        }
    }

    /// Every axis may be the largest of the direction.
    #[test]
    fn all_directions_agree_with_the_plane() {
        let corners = [[0.3, -0.2, 0.1], [0.7, 0.9, -0.4], [-0.5, 0.2, 0.8]];
        let block = block(&[corners]);
        let [a, b, c] = corners.map(|c| Vec3::from(c).as_dvec3());
        let normal = (b - a).cross(c - a);
        let mut random = Random::new(2, 0, 0);
        for _ in 0..1000 {
            let [v, w] = random.uniform2().map(|u| 0.45 * u);
            let target = a + (b - a) * v + (c - a) * w;
            let direction = crate::warp::uniform_sphere(random.uniform2());
            let ray = Ray::new(target - direction * 2.5, direction);
            if normal.normalize().dot(direction).abs() < 0.01 {
                continue;
            }
            let (t, weights) = intersect(&block, &ray).hit(0);
            assert!((t - 2.5).abs() < 1e-12, "{ray:?}: {t}");
            assert!((weights[0] - v).abs() < 1e-12 && (weights[1] - w).abs() < 1e-12, "{ray:?}");
        }
    }
}
