//! Which surface does a ray meet, and is a segment free.
//!
//! Boxes are single precision and padded so that rays in double precision, whose origin and direction are rounded for
//! the box tests, cannot slip past them. What lies in the leaves is tested in double precision, all parts of it. There is no
//! epsilon: a surface that the origin lies on is excluded by its identity.

mod analytic;
mod block;
mod cylinder;
mod disk;
#[cfg(feature = "plain_intersection")]
mod plain;
mod sphere;
mod tree;
mod triangle;
#[cfg_attr(feature = "plain_intersection", allow(dead_code, reason = "the plain one takes its place"))]
mod watertight;

use glam::DVec3;
use smallvec::SmallVec;

use crate::geometry::{Bounds, Ray};

pub use analytic::{AnalyticShape, ShapePoint};
use block::{Block, LANES, Line, Reach};
pub use cylinder::CylinderShape;
pub use disk::DiskShape;
#[cfg(feature = "plain_intersection")]
use plain::LeafRay;
pub use sphere::SphereShape;
use tree::{Leaves, Tree};
pub use triangle::Triangle;
#[cfg(not(feature = "plain_intersection"))]
use watertight::LeafRay;
use watertight::TriangleHit;

/// A triangle or an analytic shape of the scene: triangles first, in the order of the BVH's leaves, then the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct PrimitiveId(pub u32);

impl PrimitiveId {
    /// No primitive.
    pub const NONE: Self = Self(u32::MAX);
}

/// Where a ray meets a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray \[m\].
    pub t: f64,
    /// What it meets.
    pub primitive: PrimitiveId,
    /// Barycentric weights of the triangle's second and third corner; zero for an analytic shape.
    pub barycentric: [f64; 2],
}

/// Up to so many triangles keep all digits of their corners: that costs no time, where more of them leave the cache.
const FEW_TO_ROUND: usize = 1 << 14;

/// A triangle whose corners single precision moves by more than this share of its longest edge looks different, ...
const SEEN: f64 = 1e-3;
/// ... and a shape of which more than this share of triangles do.
const SHARE_SEEN: f64 = 0.01;

/// Up to so many triangles there is no tree: asking all of them is faster.
const FEW_TRIANGLES: usize = 64;
/// The same for analytic shapes.
const FEW_SHAPES: usize = 4;

/// Analytic shapes in a leaf of their tree.
const SHAPES: usize = 4;

/// The primitives of a scene and the hierarchies above them.
#[derive(Debug)]
pub struct Accel {
    reach: Reach,
    /// One for each leaf of the triangles' tree. A triangle's id is the number of its lane among all lanes.
    blocks: Vec<Block>,
    /// The corners of the triangles, by id; of unused lanes, zero. Empty where the blocks have them to all digits.
    exact_corners: Vec<[DVec3; 3]>,
    /// Their shapes, by id; of unused lanes, none.
    triangle_shapes: Vec<u32>,
    /// Their unit normals, by id.
    triangle_normals: Vec<DVec3>,
    analytic: Vec<AnalyticShape>,
    /// The analytic shapes of each leaf of their tree.
    analytic_ranges: Vec<std::ops::Range<usize>>,
    /// None where there are few.
    triangle_tree: Option<Tree>,
    analytic_tree: Option<Tree>,
}

impl Accel {
    /// Builds the hierarchies over `count` triangles, which `triangle` knows by their positions, and gives each primitive its
    /// id. The second result has the old position of each triangle id; `None` where no triangle has it.
    #[must_use]
    pub fn build(
        count: usize,
        triangle: impl Fn(u32) -> Triangle,
        analytic: &[AnalyticShape],
    ) -> (Self, Vec<Option<u32>>) {
        let exact = count <= FEW_TO_ROUND || rounding_is_seen(count, &triangle);
        let rounded = |i: u32| {
            let Triangle { corners, shape } = triangle(i);
            let corners = corners.map(|corner| if exact { corner } else { corner.as_vec3().as_dvec3() });
            Triangle { corners, shape }
        };
        let boxes = (0..count).map(|i| rounded(i as u32).bounds());
        let (triangle_tree, leaves) = tree_of_many(boxes, LANES, FEW_TRIANGLES);
        let (analytic_tree, analytic_leaves) =
            tree_of_many(analytic.iter().map(AnalyticShape::bounds), SHAPES, FEW_SHAPES);
        let slots = leaves.len() * LANES;
        let mut accel = Self {
            reach: Reach::default(),
            blocks: Vec::with_capacity(leaves.len()),
            exact_corners: Vec::with_capacity(if exact { slots } else { 0 }),
            triangle_shapes: Vec::with_capacity(slots),
            triangle_normals: Vec::with_capacity(slots),
            analytic: Vec::with_capacity(analytic.len()),
            analytic_ranges: Vec::with_capacity(analytic_leaves.len()),
            triangle_tree,
            analytic_tree,
        };
        let mut order = Vec::with_capacity(slots);
        let mut extent = 0.0;
        for leaf in leaves.iter() {
            let triangles: SmallVec<[Triangle; LANES]> = leaf.iter().map(|&i| rounded(i)).collect();
            extent = triangles.iter().flat_map(|t| t.corners).map(DVec3::length).fold(extent, f64::max);
            accel.add_block(&triangles, exact);
            order.extend((0..LANES).map(|lane| leaf.get(lane).copied()));
        }
        accel.reach = Reach::new(extent, !exact);
        for leaf in analytic_leaves.iter() {
            let first = accel.analytic.len();
            accel.analytic.extend(leaf.iter().map(|&i| analytic[i as usize].clone()));
            accel.analytic_ranges.push(first..accel.analytic.len());
        }
        (accel, order)
    }

    fn add_block(&mut self, triangles: &[Triangle], exact: bool) {
        for lane in 0..LANES {
            let triangle = triangles.get(lane);
            if exact {
                self.exact_corners.push(triangle.map_or([DVec3::ZERO; 3], |t| t.corners));
            }
            self.triangle_normals.push(triangle.map_or(DVec3::ZERO, Triangle::normal));
            self.triangle_shapes.push(triangle.map_or(u32::MAX, |t| t.shape));
        }
        self.blocks.push(Block::new(triangles));
    }

    /// The triangles with their ids.
    pub fn triangles(&self) -> impl Iterator<Item = (PrimitiveId, Triangle)> + '_ {
        let ids = (0..self.triangle_shapes.len() as u32).map(PrimitiveId);
        ids.filter(|id| self.triangle_shapes[id.0 as usize] != u32::MAX).map(|id| (id, self.triangle(id)))
    }

    /// The analytic shapes in the order of their ids.
    #[must_use]
    pub fn analytic(&self) -> &[AnalyticShape] {
        &self.analytic
    }

    /// The id of an analytic shape by its position in [`analytic`](Self::analytic).
    #[must_use]
    pub fn analytic_id(&self, index: usize) -> PrimitiveId {
        PrimitiveId((self.triangle_shapes.len() + index) as u32)
    }

    /// The position in [`analytic`](Self::analytic) of the shape with this id, or `None` where it is a triangle's.
    #[must_use]
    #[inline]
    pub fn analytic_index(&self, id: PrimitiveId) -> Option<usize> {
        (id.0 as usize).checked_sub(self.triangle_shapes.len())
    }

    /// The analytic shape with this id, or `None` where it is a triangle's.
    #[must_use]
    #[inline]
    pub fn as_analytic(&self, id: PrimitiveId) -> Option<&AnalyticShape> {
        self.analytic_index(id).map(|i| &self.analytic[i])
    }

    /// The triangle with this id.
    #[must_use]
    #[inline]
    pub fn triangle(&self, id: PrimitiveId) -> Triangle {
        let slot = id.0 as usize;
        let corners = self.exact_corners.get(slot).copied().unwrap_or_else(|| {
            let corner = |i: usize, axis: usize| self.blocks[slot / LANES].corner(slot % LANES, i, axis);
            [0, 1, 2].map(|i| DVec3::new(corner(i, 0), corner(i, 1), corner(i, 2)))
        });
        Triangle { corners, shape: self.triangle_shapes[slot] }
    }

    /// The unit normal of the front of the triangle with this id.
    #[must_use]
    #[inline]
    pub fn normal(&self, id: PrimitiveId) -> DVec3 {
        self.triangle_normals[id.0 as usize]
    }

    /// The nearest primitive in front of a ray that starts on `start`; of several at the same distance, the first.
    #[must_use]
    #[inline(always)]
    pub fn closest(&self, ray: &Ray, start: PrimitiveId) -> Option<Hit> {
        let hit = match &self.triangle_tree {
            None => {
                let mut nearest = Nearest::none();
                nearest.update(self, self.all_candidates(&Line::new(ray, self.reach)), &LeafRay::new(ray), start);
                nearest.hit()
            }
            Some(tree) => self.closest_in_tree(tree, ray, start),
        };
        if self.analytic.is_empty() { hit } else { self.closest_analytic(ray, start, hit) }
    }

    #[inline(never)]
    fn closest_in_tree(&self, tree: &Tree, ray: &Ray, start: PrimitiveId) -> Option<Hit> {
        let (line, sheared) = (Line::new(ray, self.reach), LeafRay::new(ray));
        let mut nearest = Nearest::none();
        tree.visit(ray, f64::MAX, |leaf| {
            nearest.update(self, self.candidates(leaf, &line), &sheared, start);
            nearest.t
        });
        nearest.hit()
    }

    /// The nearest analytic shape, if it is nearer than the hit.
    #[inline(never)]
    fn closest_analytic(&self, ray: &Ray, start: PrimitiveId, mut hit: Option<Hit>) -> Option<Hit> {
        let hit_distance = hit.map_or(f64::MAX, |hit| hit.t);
        let mut nearest = hit_distance;
        let mut test = |slot: usize| {
            let primitive = self.analytic_id(slot);
            if let Some(t) = self.analytic[slot].intersect(ray, primitive == start)
                && t < nearest
            {
                nearest = t;
                hit = Some(Hit { t, primitive, barycentric: [0.0; 2] });
            }
            nearest
        };
        match &self.analytic_tree {
            None => (0..self.analytic.len()).for_each(|slot| _ = test(slot)),
            Some(tree) => tree.visit(ray, hit_distance, |leaf| {
                self.analytic_ranges[leaf].clone().map(&mut test).last().expect("leaves are not empty")
            }),
        }
        hit
    }

    /// Something lies strictly between two points of the primitives `on_a` and `on_b`. The same bits for both orders.
    #[must_use]
    #[inline(always)]
    pub fn occluded(&self, a: DVec3, on_a: PrimitiveId, b: DVec3, on_b: PrimitiveId) -> bool {
        let swap = (b.x, b.y, b.z) < (a.x, a.y, a.z);
        let (from, to, on_from, on_to) = if swap { (b, a, on_b, on_a) } else { (a, b, on_a, on_b) };
        self.occluded_in_order(from.x, from.y, from.z, to.x, to.y, to.z, [on_from, on_to])
    }

    /// Coordinates come in registers: points would come in memory, where their parts, just written one by one, are read two at
    /// a time and wait for the cache.
    #[allow(clippy::too_many_arguments, reason = "six of them are two points")]
    #[inline(never)]
    fn occluded_in_order(&self, ax: f64, ay: f64, az: f64, bx: f64, by: f64, bz: f64, on: [PrimitiveId; 2]) -> bool {
        let (from, to, [on_from, on_to]) = (DVec3::new(ax, ay, az), DVec3::new(bx, by, bz), on);
        // Distances are in units of the segment: triangles need no length.
        let segment = Ray { origin: from, direction: to - from };
        let line = Line::new(&segment, self.reach);
        let sheared = LeafRay::new(&segment);
        let meets = |candidates: Candidates| {
            let mut others = candidates.without(on_from).without(on_to);
            others.any(|id| self.intersect(id, &sheared, 1.0_f64.next_down()).is_some())
        };
        let by_triangle = match &self.triangle_tree {
            None => meets(self.all_candidates(&line)),
            Some(tree) => tree.any(&segment, 1.0, |leaf| meets(self.candidates(leaf, &line))),
        };
        by_triangle || (!self.analytic.is_empty() && self.occluded_by_analytic(&segment, on_from, on_to))
    }

    fn occluded_by_analytic(&self, segment: &Ray, on_from: PrimitiveId, on_to: PrimitiveId) -> bool {
        let length = segment.direction.length();
        let ray = Ray::new(segment.origin, segment.direction / length);
        let blocks = |slot: usize| {
            let id = self.analytic_id(slot);
            self.analytic[slot].blocks(&ray, length, id == on_from, id == on_to)
        };
        match &self.analytic_tree {
            None => (0..self.analytic.len()).any(blocks),
            Some(tree) => tree.any(&ray, length, |leaf| self.analytic_ranges[leaf].clone().any(blocks)),
        }
    }

    #[inline(always)]
    fn intersect(&self, id: PrimitiveId, ray: &LeafRay, t_max: f64) -> Option<TriangleHit> {
        let slot = id.0 as usize;
        match self.exact_corners.get(slot) {
            Some(corners) => ray.intersect(|i, axis| corners[i].as_ref()[axis], t_max),
            None => ray.intersect(|i, axis| self.blocks[slot / LANES].corner(slot % LANES, i, axis), t_max),
        }
    }

    #[inline(always)]
    fn candidates(&self, leaf: usize, line: &Line) -> Candidates {
        Candidates { first: (leaf * LANES) as u32, mask: u64::from(self.blocks[leaf].candidates(line)) }
    }

    /// Of all triangles, where there are few.
    #[inline(always)]
    fn all_candidates(&self, line: &Line) -> Candidates {
        let shifted = |(i, block): (usize, &Block)| u64::from(block.candidates(line)) << (i * LANES);
        Candidates { first: 0, mask: self.blocks.iter().enumerate().map(shifted).fold(0, |all, mask| all | mask) }
    }
}

/// The nearest triangle so far.
struct Nearest {
    t: f64,
    primitive: PrimitiveId,
    hit: TriangleHit,
}

impl Nearest {
    #[inline(always)]
    fn none() -> Self {
        Self { t: f64::MAX, primitive: PrimitiveId::NONE, hit: TriangleHit::default() }
    }

    #[inline(always)]
    fn update(&mut self, accel: &Accel, candidates: Candidates, ray: &LeafRay, start: PrimitiveId) {
        for primitive in candidates.without(start) {
            if let Some(hit) = accel.intersect(primitive, ray, self.t)
                && (hit.t < self.t || primitive < self.primitive)
            {
                *self = Self { t: hit.t, primitive, hit };
            }
        }
    }

    #[inline(always)]
    fn hit(&self) -> Option<Hit> {
        let Self { t, primitive, .. } = *self;
        (primitive != PrimitiveId::NONE).then(|| Hit { t, primitive, barycentric: self.hit.barycentric() })
    }
}

/// Up to 64 neighbouring triangles, of which those count whose bit is set.
#[derive(Clone, Copy)]
struct Candidates {
    first: u32,
    mask: u64,
}

impl Candidates {
    #[inline]
    fn without(self, id: PrimitiveId) -> Self {
        let bit = 1_u64.checked_shl(id.0.wrapping_sub(self.first)).unwrap_or(0);
        Self { mask: self.mask & !bit, ..self }
    }
}

impl Iterator for Candidates {
    type Item = PrimitiveId;

    #[inline]
    fn next(&mut self) -> Option<PrimitiveId> {
        let id = PrimitiveId(self.first + self.mask.trailing_zeros());
        let some = self.mask != 0;
        self.mask &= self.mask.wrapping_sub(1);
        some.then_some(id)
    }
}

/// Single precision would change some shape. All triangles of a scene are treated alike: those that share corners still do.
fn rounding_is_seen(count: usize, triangle: impl Fn(u32) -> Triangle) -> bool {
    let mut by_shape: Vec<[u32; 2]> = Vec::new();
    for Triangle { corners, shape } in (0..count).map(|i| triangle(i as u32)) {
        let shape = shape as usize;
        by_shape.resize(by_shape.len().max(shape + 1), [0; 2]);
        let [a, b, c] = corners;
        let longest = [b - a, c - b, a - c].map(DVec3::length_squared).into_iter().fold(0.0, f64::max);
        let moved = corners.map(|p| p.distance_squared(p.as_vec3().as_dvec3())).into_iter().fold(0.0, f64::max);
        by_shape[shape][0] += 1;
        by_shape[shape][1] += u32::from(moved > SEEN * SEEN * longest);
    }
    by_shape.iter().any(|&[all, moved]| f64::from(moved) > SHARE_SEEN * f64::from(all))
}

/// A tree above the boxes unless they are few, and what is in its leaves.
fn tree_of_many(boxes: impl ExactSizeIterator<Item = Bounds>, leaf_size: usize, few: usize) -> (Option<Tree>, Leaves) {
    if boxes.len() <= few {
        return (None, Leaves::in_order(boxes.len(), leaf_size));
    }
    let (tree, leaves) = Tree::build(boxes, leaf_size);
    (Some(tree), leaves)
}
