//! Ray against triangles: eight at a time in single precision to find the few that it may meet, those in double precision.

use glam::{DVec3, Vec3};
use wide::f32x8 as Lanes;

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
    shear: [f64; 2],
    scale: f64,
    /// Which axes of the world x, y and z are.
    axes: [usize; 3],
}

impl ShearedRay {
    /// The direction may have any length; distances are in its units.
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
        Self { origin: ray.origin.to_array(), shear: [d[axes[0]] * scale, d[axes[1]] * scale], scale, axes }
    }
}

/// The whole line of a ray in Plücker coordinates, in single precision: its direction d and its moment o × d.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    direction: [f32; 3],
    moment: [f32; 3],
    /// Bound of the error of a side, over the length of the edge.
    error: f32,
}

/// Six products with factors that are rounded themselves, and their sum, in one edge's case by way of both others: less
/// than 20 half ulps.
const ERRORS_OF_SIDE: f64 = 12.0;

impl Line {
    /// `extent` bounds the distance of triangles to the origin of coordinates.
    #[inline]
    pub fn new(ray: &Ray, extent: f64) -> Self {
        let (origin, direction) = (ray.origin, ray.direction);
        let size = origin.abs().element_sum() + extent;
        let error = ERRORS_OF_SIDE * f64::from(f32::EPSILON) * direction.abs().element_sum() * size;
        Self {
            direction: direction.as_vec3().to_array(),
            moment: origin.cross(direction).as_vec3().to_array(),
            error: error as f32,
        }
    }
}

/// Triangles of a leaf, corner by corner and axis by axis.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Block {
    corners: [[[f32; LANES]; 3]; 3],
    /// Of the edge p → q opposite of each corner, p × q.
    moments: [[[f32; LANES]; 3]; 3],
    /// Length of the longest edge.
    longest: [f32; LANES],
    /// A bit for each lane that holds a triangle.
    used: u32,
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Default)]
pub(super) struct TriangleHit {
    /// Distance along the ray, in lengths of its direction.
    pub t: f64,
    v: f64,
    w: f64,
    volume: f64,
}

impl TriangleHit {
    /// Weights of the second and third corner.
    #[inline]
    pub fn barycentric(&self) -> [f64; 2] {
        let scale = 1.0 / self.volume;
        [self.v * scale, self.w * scale]
    }
}

impl Block {
    pub fn new(triangles: impl Iterator<Item = Triangle>) -> Self {
        let mut block =
            Self { corners: [[[0.0; LANES]; 3]; 3], moments: [[[0.0; LANES]; 3]; 3], longest: [0.0; LANES], used: 0 };
        for (lane, triangle) in triangles.take(LANES).enumerate() {
            block.used |= 1 << lane;
            let corners = triangle.corners();
            for (i, corner) in corners.iter().enumerate() {
                let (p, q) = (corners[(i + 1) % 3], corners[(i + 2) % 3]);
                let moment = p.cross(q);
                for axis in 0..3 {
                    block.corners[i][axis][lane] = corner[axis] as f32;
                    block.moments[i][axis][lane] = moment[axis] as f32;
                }
                block.longest[lane] = block.longest[lane].max((p.distance(q) as f32).next_up());
            }
        }
        block
    }

    #[inline]
    pub fn corners(&self, lane: usize) -> [Vec3; 3] {
        self.corners.map(|[x, y, z]| Vec3::new(x[lane], y[lane], z[lane]))
    }

    /// A bit for each triangle that the whole line may meet, seen in single precision; all that
    /// [`intersect`](Self::intersect) meets are among them.
    ///
    /// The line passes an edge p → q on the side that the sign of `d·(p × q) + (q − p)·(o × d)` tells. It misses the
    /// triangle where two sides differ by more than their errors.
    #[inline(always)]
    pub fn candidates(&self, line: &Line) -> u32 {
        let (direction, moment) = (line.direction.map(Lanes::splat), line.moment.map(Lanes::splat));
        let corners = |i: usize, axis: usize| Lanes::new(self.corners[i][axis]);
        // (q − p)·(o × d) of two edges; those of all three sum up to zero.
        let by_moment = |p: usize, q: usize| {
            let edge = |axis: usize| corners(q, axis) - corners(p, axis);
            edge(0).mul_add(moment[0], edge(1).mul_add(moment[1], edge(2) * moment[2]))
        };
        let side = |i: usize, by_moment: Lanes| {
            let own = |axis: usize| Lanes::new(self.moments[i][axis]);
            let first = own(0).mul_add(direction[0], by_moment);
            own(1).mul_add(direction[1], own(2).mul_add(direction[2], first))
        };
        let (at_u, at_v) = (by_moment(1, 2), by_moment(2, 0));
        let [u, v, w] = [side(0, at_u), side(1, at_v), side(2, -(at_u + at_v))];
        let error = Lanes::new(self.longest) * Lanes::splat(line.error);
        let (least, most) = (u.fast_min(v).fast_min(w), u.fast_max(v).fast_max(w));
        // What overflows compares as false and stays.
        let missed = least.simd_lt(-error) & most.simd_gt(error);
        !missed.to_bitmask() & self.used
    }

    /// Where a ray meets a triangle, from either side, at a distance above zero and up to `t_max`.
    ///
    /// In the ray's coordinates it meets a triangle whose three edges all have the origin on the same side. The side of an
    /// edge p → q is the sign of p_x q_y − p_y q_x; exchanging p and q flips it exactly, so a ray cannot pass between two
    /// triangles that share an edge. The distance is the z of the corners with the resulting weights.
    #[inline(always)]
    pub fn intersect(&self, lane: usize, ray: &ShearedRay, t_max: f64) -> Option<TriangleHit> {
        let [kx, ky, kz] = ray.axes;
        let corner = |i: usize| {
            let relative = |axis: usize| f64::from(self.corners[i][axis][lane]) - ray.origin[axis];
            let z = relative(kz);
            (relative(kx) - ray.shear[0] * z, relative(ky) - ray.shear[1] * z, z)
        };
        let ((ax, ay, az), (bx, by, bz), (cx, cy, cz)) = (corner(0), corner(1), corner(2));
        let u = cx * by - cy * bx;
        let v = ax * cy - ay * cx;
        let w = bx * ay - by * ax;
        let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
        let volume = u + v + w;
        let t = (u * az + v * bz + w * cz) * ray.scale / volume;
        // A division by zero gives NaN or ±∞, none of which is in the range.
        (inside && t > 0.0 && t <= t_max).then_some(TriangleHit { t, v, w, volume })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::Random;

    fn block(triangles: &[[[f32; 3]; 3]]) -> Block {
        Block::new(triangles.iter().map(|corners| Triangle { corners: corners.map(Vec3::from), shape: 0 }))
    }

    /// The nearest hit, and a bit for each triangle met.
    fn intersect(block: &Block, ray: &Ray) -> (Option<TriangleHit>, u32) {
        let (ray, line) = (ShearedRay::new(ray), Line::new(ray, 8.0));
        let met: Vec<(u32, TriangleHit)> =
            (0..2).filter_map(|i| Some((1 << i, block.intersect(i, &ray, f64::MAX)?))).collect();
        let mask = met.iter().map(|(bit, _)| bit).sum();
        assert_eq!(block.candidates(&line) & mask, mask);
        (met.into_iter().map(|(_, hit)| hit).min_by(|a, b| a.t.total_cmp(&b.t)), mask)
    }

    #[test]
    fn finds_distance_and_weights_from_both_sides() {
        let block = block(&[[[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]]]);
        for (z, sign) in [(3.0, -1.0), (-3.0, 1.0)] {
            let hit = intersect(&block, &Ray::new(DVec3::new(0.5, 1.0, z), DVec3::Z * sign)).0.unwrap();
            assert_eq!((hit.t, hit.barycentric()), (3.0, [0.25, 0.5]));
            assert_eq!(intersect(&block, &Ray::new(DVec3::new(0.5, 1.0, z), DVec3::Z * -sign)).1, 0);
            assert_eq!(intersect(&block, &Ray::new(DVec3::new(1.5, 1.0, z), DVec3::Z * sign)).1, 0);
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
            assert_ne!(intersect(&block, &ray).1, 0, "{ray:?}");
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
            let hit = intersect(&block, &ray).0.unwrap();
            let weights = hit.barycentric();
            assert!((hit.t - 2.5).abs() < 1e-12, "{ray:?}: {}", hit.t);
            assert!((weights[0] - v).abs() < 1e-12 && (weights[1] - w).abs() < 1e-12, "{ray:?}");
        }
    }

    /// Rays aimed at corners, edges and insides of triangles from 1 m down to 10⁻⁵ m, slivers among them, up to 10 m from the
    /// origin: single precision drops none that double precision meets. With a fortieth of its margin it drops some.
    #[test]
    fn no_triangle_that_is_met_is_dropped() {
        let mut random = Random::new(3, 0, 0);
        let mut met = 0;
        for i in 0..200_000 {
            let size = libm::pow(10.0, -5.0 * random.uniform());
            let flatness = libm::pow(10.0, -4.0 * random.uniform());
            let place = crate::warp::uniform_sphere(random.uniform2()) * 10.0 * random.uniform();
            let (a, b) =
                (crate::warp::uniform_sphere(random.uniform2()), crate::warp::uniform_sphere(random.uniform2()));
            let corners = [place, place + a * size, place + (a * random.uniform() + b * flatness) * size];
            let triangle = Triangle { corners: corners.map(DVec3::as_vec3), shape: 0 };
            let weights = match i % 3 {
                0 => [0.0, 0.0],
                1 => [random.uniform(), 0.0],
                _ => crate::warp::uniform_triangle(random.uniform2())[1..].try_into().unwrap(),
            };
            let origin = crate::warp::uniform_sphere(random.uniform2()) * 20.0 * random.uniform();
            let ray = Ray::new(origin, (triangle.point(weights) - origin).normalize());
            let block = Block::new([triangle].into_iter());
            let extent = triangle.corners().map(DVec3::length).into_iter().fold(0.0, f64::max);
            if block.intersect(0, &ShearedRay::new(&ray), f64::MAX).is_some() {
                met += 1;
                assert_eq!(block.candidates(&Line::new(&ray, extent)), 1, "{triangle:?} {ray:?}");
            }
        }
        assert!(met > 100_000, "only {met} are met");
    }
}
