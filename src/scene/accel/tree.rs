//! A hierarchy of boxes, eight to a node.
//!
//! The library builds a binary tree; here it is flattened to nodes of eight boxes, which one pass of SIMD tests together.
//! With leaves of eight triangles that is faster than the library's own traversal of its binary tree (see
//! `tests/benches/README.md`).

use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use smallvec::{SmallVec, smallvec};
use wide::f32x8;

use crate::geometry::{Bounds, Ray};

/// Boxes in a node.
const WIDTH: usize = 8;

/// The hierarchy.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    nodes: Vec<Node>,
    /// Padding where a coordinate is zero: what lies in that plane must be met.
    least_padding: f32,
}

/// Eight boxes, axis by axis. Unused ones are inside out, which no ray meets.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
struct Node {
    /// `bounds[0]` are the smaller, `bounds[1]` the larger coordinates.
    bounds: [[[f32; WIDTH]; 3]; 2],
    children: [Child; WIDTH],
}

/// What is in the leaves, by their numbers: indices of boxes.
#[derive(Clone, Debug, Default)]
pub(super) struct Leaves {
    members: Vec<u32>,
    /// Where in `members` each leaf ends.
    ends: Vec<u32>,
}

impl Leaves {
    /// So many boxes in their order, `size` to a leaf.
    pub fn in_order(boxes: usize, size: usize) -> Self {
        let members = (0..boxes as u32).collect();
        let ends = (0..boxes.div_ceil(size)).map(|leaf| ((leaf + 1) * size).min(boxes) as u32).collect();
        Self { members, ends }
    }

    pub fn len(&self) -> usize {
        self.ends.len()
    }

    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let mut start = 0;
        self.ends.iter().map(move |&end| {
            let leaf = &self.members[start as usize..end as usize];
            start = end;
            leaf
        })
    }

    /// Adds a leaf and says its number.
    fn push(&mut self, members: &[u32]) -> u32 {
        self.members.extend_from_slice(members);
        self.ends.push(self.members.len() as u32);
        self.ends.len() as u32 - 1
    }
}

/// The number of a node, or, with the highest bit set, of a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Child(u32);

const LEAF: u32 = 1 << 31;

impl Child {
    fn leaf(self) -> Option<usize> {
        (self.0 & LEAF != 0).then_some((self.0 & !LEAF) as usize)
    }
}

impl Tree {
    /// The tree over boxes, at least one, and its leaves: each the indices of up to `leaf_size` boxes.
    pub fn build(boxes: impl Iterator<Item = Bounds>, leaf_size: usize) -> (Self, Leaves) {
        let boxes: Vec<Aabb> = boxes.map(padded).collect();
        let params =
            BvhBuildParams { pre_split: false, max_prims_per_leaf: leaf_size as u32, ..BvhBuildParams::medium_build() };
        let bvh = build_bvh2(&boxes, params, &mut std::time::Duration::default());
        let Aabb { min, max } = *bvh.nodes[0].aabb();
        let least_padding = min.abs().max(max.abs()).max_element() * LEAST_PADDING;
        let mut flattening =
            Flattening { bvh: &bvh, tree: Self { nodes: Vec::new(), least_padding }, leaves: Leaves::default() };
        flattening.run();
        (flattening.tree, flattening.leaves)
    }

    /// Calls `leaf` with each leaf that the ray may meet before `t_max`, near ones first; it answers with the new `t_max`.
    #[inline]
    pub fn visit(&self, ray: &Ray, t_max: f64, mut leaf: impl FnMut(usize) -> f64) {
        let ray = BoxRay::new(ray, self.least_padding);
        let mut limit = round_up(t_max);
        let mut stack: SmallVec<[(f32, Child); 64]> = SmallVec::new();
        let mut current = Child(0);
        loop {
            if let Some(number) = current.leaf() {
                limit = round_up(leaf(number));
            } else {
                let node = &self.nodes[current.0 as usize];
                let (near, mut mask) = node.intersect(&ray, limit);
                if mask != 0 {
                    let mut next = || {
                        let lane = mask.trailing_zeros() as usize % WIDTH;
                        mask &= mask - 1;
                        ((near[lane], node.children[lane]), mask != 0)
                    };
                    // The nearest is next; the others wait, the near ones on top.
                    let (mut nearest, mut more) = next();
                    let first = stack.len();
                    while more {
                        let other;
                        (other, more) = next();
                        let closer = other.0 < nearest.0;
                        stack.push(if closer { nearest } else { other });
                        nearest = if closer { other } else { nearest };
                        let mut at = stack.len() - 1;
                        while at > first && stack[at - 1].0 < stack[at].0 {
                            stack.swap(at - 1, at);
                            at -= 1;
                        }
                    }
                    current = nearest.1;
                    continue;
                }
            }
            loop {
                let Some((near, child)) = stack.pop() else { return };
                if near <= limit {
                    current = child;
                    break;
                }
            }
        }
    }

    /// Some leaf that the ray may meet before `t_max` answers yes; they are asked in no order.
    #[inline]
    pub fn any(&self, ray: &Ray, t_max: f64, mut leaf: impl FnMut(usize) -> bool) -> bool {
        let ray = BoxRay::new(ray, self.least_padding);
        let limit = round_up(t_max);
        let mut stack: SmallVec<[Child; 64]> = SmallVec::new();
        let mut node = &self.nodes[0];
        loop {
            let (_, mut mask) = node.intersect(&ray, limit);
            while mask != 0 {
                let child = node.children[mask.trailing_zeros() as usize % WIDTH];
                mask &= mask - 1;
                match child.leaf() {
                    Some(number) if leaf(number) => return true,
                    Some(_) => {}
                    None => stack.push(child),
                }
            }
            let Some(child) = stack.pop() else { return false };
            node = &self.nodes[child.0 as usize];
        }
    }
}

impl Node {
    const EMPTY: Self =
        Self { bounds: [[[f32::INFINITY; WIDTH]; 3], [[f32::NEG_INFINITY; WIDTH]; 3]], children: [Child(0); WIDTH] };

    /// Where the ray enters each box, and a bit for each that it meets up to `limit`.
    #[inline]
    fn intersect(&self, ray: &BoxRay, limit: f32) -> ([f32; WIDTH], u32) {
        let (mut near, mut far) = (f32x8::ZERO, f32x8::splat(limit));
        for axis in 0..3 {
            let inverse = f32x8::splat(ray.inverse[axis]);
            let bound =
                |side: usize, origin: f32| (f32x8::new(self.bounds[side][axis]) - f32x8::splat(origin)) * inverse;
            near = near.fast_max(bound(ray.near_side[axis], ray.origin_to_near[axis]));
            far = far.fast_min(bound(1 - ray.near_side[axis], ray.origin_to_far[axis]));
        }
        (near.to_array(), near.simd_le(far).to_bitmask())
    }
}

/// What coordinates of boxes and of rays' origins are moved by, over themselves. On the way from both to a distance they,
/// the direction and three results are rounded: less than five half ulps of the distance's part along the axis, which is no
/// more than both coordinates together. So padding shrinks towards the origin of coordinates, where the details are.
const PADDING: f64 = 4.0 * f32::EPSILON as f64;

/// The smallest component of a direction whose inverse is a number. Where it takes the place of zero, the ray leaves its plane
/// by 10⁻³⁷ of its length.
const LEAST_DIRECTION: f32 = 1e-37;

/// The least padding over the largest coordinate of all boxes: far more than a ray leaves its plane by.
const LEAST_PADDING: f32 = 1e-20;

/// A ray in single precision, prepared for boxes.
struct BoxRay {
    /// The origin moved along the ray, and against it: planes of boxes are met too early, and left too late.
    origin_to_near: [f32; 3],
    origin_to_far: [f32; 3],
    inverse: [f32; 3],
    /// Which side of a box the ray meets first, for each axis.
    near_side: [usize; 3],
}

impl BoxRay {
    #[inline]
    fn new(ray: &Ray, least_padding: f32) -> Self {
        // A component of zero must not become an infinity, whose product with zero is NaN.
        let direction = ray.direction.as_vec3a();
        let direction = direction.abs().max(Vec3A::splat(LEAST_DIRECTION)).copysign(direction);
        let origin = ray.origin.as_vec3a();
        let pad = (origin.abs() * PADDING as f32 + Vec3A::splat(least_padding)).copysign(direction);
        Self {
            origin_to_near: (origin + pad).to_array(),
            origin_to_far: (origin - pad).to_array(),
            inverse: direction.recip().to_array(),
            near_side: direction.to_array().map(|d| usize::from(d.is_sign_negative())),
        }
    }
}

/// A binary tree on its way to nodes of eight.
struct Flattening<'a> {
    bvh: &'a Bvh2,
    tree: Tree,
    leaves: Leaves,
}

impl Flattening<'_> {
    fn run(&mut self) {
        let mut open = vec![(0_usize, self.new_node())];
        while let Some((binary, node)) = open.pop() {
            for (lane, part) in self.parts(binary).into_iter().enumerate() {
                let source = &self.bvh.nodes[part];
                let child = if source.is_leaf() {
                    let first = source.first_index as usize;
                    let members = &self.bvh.primitive_indices[first..first + source.prim_count as usize];
                    Child(LEAF | self.leaves.push(members))
                } else {
                    let number = self.new_node();
                    open.push((part, number));
                    Child(number as u32)
                };
                let target = &mut self.tree.nodes[node];
                target.children[lane] = child;
                for axis in 0..3 {
                    target.bounds[0][axis][lane] = source.aabb().min[axis];
                    target.bounds[1][axis][lane] = source.aabb().max[axis];
                }
            }
        }
    }

    fn new_node(&mut self) -> usize {
        self.tree.nodes.push(Node::EMPTY);
        self.tree.nodes.len() - 1
    }

    /// Up to eight descendants that together hold what a node holds: the largest are opened first.
    fn parts(&self, binary: usize) -> SmallVec<[usize; WIDTH]> {
        let nodes = &self.bvh.nodes;
        let mut parts: SmallVec<[usize; WIDTH]> = smallvec![binary];
        while parts.len() < WIDTH {
            let inner = (0..parts.len()).filter(|&i| !nodes[parts[i]].is_leaf());
            let area = |i: &usize| nodes[parts[*i]].aabb().half_area();
            let Some(largest) = inner.max_by(|a, b| area(a).total_cmp(&area(b))) else { break };
            let first = nodes[parts[largest]].first_index as usize;
            parts[largest] = first;
            parts.push(first + 1);
        }
        parts
    }
}

/// A single-precision distance that is no nearer, even after the box test's own rounding.
#[inline]
fn round_up(t: f64) -> f32 {
    t as f32 * (1.0 + 8.0 * f32::EPSILON) + f32::MIN_POSITIVE
}

/// The box, a little larger and rounded outwards.
fn padded(bounds: Bounds) -> Aabb {
    let (min, max) = (bounds.min - bounds.min.abs() * PADDING, bounds.max + bounds.max.abs() * PADDING);
    let down = |x: f64| (x as f32).next_down();
    let up = |x: f64| (x as f32).next_up();
    Aabb::new(Vec3A::new(down(min.x), down(min.y), down(min.z)), Vec3A::new(up(max.x), up(max.y), up(max.z)))
}
