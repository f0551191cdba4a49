//! Triangles, eight at a time in single precision: which of them may a ray meet.

use wide::f32x8 as Lanes;

use crate::geometry::Ray;

use super::Triangle;

/// Triangles in a block.
pub(super) const LANES: usize = 8;

/// The whole line of a ray in Plücker coordinates, in single precision: its direction d and its moment o × d.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    direction: [f32; 3],
    moment: [f32; 3],
    /// Bound of the error of a side, over the length of the edge.
    error: f32,
    /// The same where corners are off.
    error_of_corners: f32,
}

/// Six products with factors that are rounded themselves, and their sum, in one edge's case by way of both others: less
/// than 20 half ulps.
const ERRORS_OF_SIDE: f64 = 12.0;

/// What a side loses where its parts are below the normal numbers: less than 20 of the smallest.
const ERROR_BELOW: f32 = f32::MIN_POSITIVE;

/// Up to here no part of a side overflows.
const MOST: f64 = 1e37;

impl Line {
    #[inline]
    pub fn new(ray: &Ray, reach: Reach) -> Self {
        let (origin, direction) = (ray.origin, ray.direction);
        let (from, length) = (origin.abs().element_sum(), direction.abs().element_sum());
        let error = ERRORS_OF_SIDE * f64::from(f32::EPSILON) * length * (from + reach.extent);
        let fits = length * (from + reach.extent) * reach.extent < MOST;
        Self {
            direction: direction.as_vec3().to_array(),
            moment: origin.cross(direction).as_vec3().to_array(),
            error: if fits { error as f32 } else { f32::INFINITY },
            error_of_corners: (length * from * reach.rounding) as f32 + ERROR_BELOW,
        }
    }
}

/// What a [`Line`] must know of the triangles.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Reach {
    /// Bounds the distance of their corners to the origin of coordinates.
    extent: f64,
    /// How far the edges of blocks are off, at most, since blocks round their corners.
    rounding: f64,
}

impl Reach {
    /// Of triangles whose corners are at most `extent` away and exactly, or not, those of the blocks.
    pub fn new(extent: f64, exact: bool) -> Self {
        // Half an ulp at each of four corners, where the third edge is made of both others.
        let rounding = if exact { 0.0 } else { 2.0 * f64::from(f32::EPSILON) * extent };
        Self { extent, rounding }
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

impl Block {
    pub fn new(triangles: &[Triangle]) -> Self {
        let mut block =
            Self { corners: [[[0.0; LANES]; 3]; 3], moments: [[[0.0; LANES]; 3]; 3], longest: [0.0; LANES], used: 0 };
        for (lane, Triangle { corners, .. }) in triangles.iter().take(LANES).enumerate() {
            block.used |= 1 << lane;
            for i in 0..3 {
                let (p, q) = (corners[(i + 1) % 3], corners[(i + 2) % 3]);
                // p × (q − p), whose error shrinks with the edge, where that of p × q does not.
                let moment = p.cross(q - p);
                for axis in 0..3 {
                    block.corners[i][axis][lane] = corners[i][axis] as f32;
                    block.moments[i][axis][lane] = moment[axis] as f32;
                }
                block.longest[lane] = block.longest[lane].max((p.distance(q) as f32).next_up());
            }
        }
        block
    }

    /// A coordinate of a corner, rounded to single precision.
    #[inline(always)]
    pub fn corner(&self, lane: usize, corner: usize, axis: usize) -> f64 {
        f64::from(self.corners[corner][axis][lane])
    }

    /// A bit for each triangle that the whole line may meet, seen in single precision; all that a
    /// [`LeafRay`](super::LeafRay) meets are among them.
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
        let error = Lanes::new(self.longest).mul_add(Lanes::splat(line.error), Lanes::splat(line.error_of_corners));
        let (least, most) = (u.fast_min(v).fast_min(w), u.fast_max(v).fast_max(w));
        // Where the error is infinite nothing is missed.
        let missed = least.simd_lt(-error) & most.simd_gt(error);
        !missed.to_bitmask() & self.used
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::sampler::Random;
    use crate::scene::accel::LeafRay;
    use crate::warp::{uniform_sphere, uniform_triangle};

    /// Rays aimed at corners, edges and insides of triangles from 1 m down to 10⁻¹² m, slivers among them, up to 10 m from the
    /// origin, all that times `scale`: single precision drops none that double precision meets. With a fortieth of its margin
    /// it drops some.
    fn check(scale: f64) {
        let mut random = Random::new(3, 0, 0);
        let mut met = 0;
        for i in 0..200_000 {
            let size = scale * libm::pow(10.0, -12.0 * random.uniform());
            let flatness = libm::pow(10.0, -4.0 * random.uniform());
            let place = uniform_sphere(random.uniform2()) * (scale * 10.0 * random.uniform());
            let (a, b) = (uniform_sphere(random.uniform2()), uniform_sphere(random.uniform2()));
            let corners = [place, place + a * size, place + (a * random.uniform() + b * flatness) * size];
            let rounded = i % 5 == 0;
            let corners = if rounded { corners.map(|c| c.as_vec3().as_dvec3()) } else { corners };
            let triangle = Triangle { corners, shape: 0 };
            let weights = match i % 3 {
                0 => [0.0, 0.0],
                1 => [random.uniform(), 0.0],
                _ => uniform_triangle(random.uniform2())[1..].try_into().unwrap(),
            };
            let origin = uniform_sphere(random.uniform2()) * (scale * 20.0 * random.uniform());
            let way = triangle.point(weights) - origin;
            let ray = Ray { origin, direction: if i % 2 == 0 { way } else { way.normalize() } };
            let extent = triangle.corners.map(DVec3::length).into_iter().fold(0.0, f64::max);
            if LeafRay::new(&ray).intersect(|i, axis| triangle.corners[i][axis], f64::MAX).is_some() {
                met += 1;
                let line = Line::new(&ray, Reach::new(extent, rounded));
                assert_eq!(Block::new(&[triangle]).candidates(&line), 1, "{triangle:?} {ray:?}");
            }
        }
        assert!(met > 100_000, "only {met} are met");
    }

    #[test]
    fn no_triangle_that_is_met_is_dropped() {
        check(1.0);
    }

    /// Where single precision overflows or underflows, too.
    #[test]
    fn scenes_of_any_size_keep_their_triangles() {
        for scale in [1e-30, 1e-18, 1e-12, 1e9, 1e12, 1e18, 1e30] {
            check(scale);
        }
    }
}
