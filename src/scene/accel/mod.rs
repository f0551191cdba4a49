//! Which surface does a ray meet, and is a segment free.
//!
//! Boxes are single precision and padded so that rays in double precision, whose origin and direction are rounded for
//! the box tests, cannot slip past them. What lies in the leaves is tested in double precision. There is no epsilon:
//! a surface that the origin lies on is excluded by its identity.

mod sphere;
mod tree;
mod triangle;

use glam::DVec3;

use crate::geometry::Ray;

pub use sphere::SphereShape;
use tree::Tree;
pub use triangle::Triangle;
use triangle::{Block, LANES, ShearedRay};

/// A triangle or an analytic sphere of the scene: triangles first, in the order of the BVH's leaves, then spheres.
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
    /// Barycentric weights of the triangle's second and third corner; zero for a sphere.
    pub barycentric: [f64; 2],
}

/// The primitives of a scene and the hierarchies above them.
#[derive(Debug)]
pub struct Accel {
    /// One for each leaf of the triangles' tree. A triangle's id is the number of its lane among all lanes.
    blocks: Vec<Block>,
    /// The shapes of the triangles, by id; of unused lanes, none.
    triangle_shapes: Vec<u32>,
    /// Their unit normals, by id.
    triangle_normals: Vec<DVec3>,
    spheres: Vec<SphereShape>,
    /// The spheres of each leaf of their tree.
    sphere_ranges: Vec<std::ops::Range<usize>>,
    triangle_tree: Tree,
    sphere_tree: Tree,
}

impl Accel {
    /// Builds the hierarchies and gives each primitive its id. `radius` bounds the distance of everything that rays start
    /// from to the origin. The second result has the old position of each triangle id; `None` where no triangle has it.
    #[must_use]
    pub fn build(triangles: &[Triangle], spheres: &[SphereShape], radius: f64) -> (Self, Vec<Option<u32>>) {
        // Rounding of a ray to f32 moves it by less than 2⁻²² of the scene's size anywhere inside it.
        let pad = radius * f64::powi(2.0, -19);
        let (triangle_tree, leaves) = Tree::build(triangles.iter().map(Triangle::bounds), pad);
        let blocks = leaves.iter().map(|leaf| Block::new(leaf.iter().map(|&i| triangles[i as usize]))).collect();
        let lanes = |leaf: &Vec<u32>| (0..LANES).map(|i| leaf.get(i).copied()).collect::<Vec<_>>();
        let slots: Vec<Option<u32>> = leaves.iter().flat_map(lanes).collect();
        let (sphere_tree, sphere_leaves) = Tree::build(spheres.iter().map(SphereShape::bounds), pad);
        let mut ordered_spheres = Vec::new();
        let sphere_ranges = (sphere_leaves.iter())
            .map(|leaf| {
                let first = ordered_spheres.len();
                ordered_spheres.extend(leaf.iter().map(|&i| spheres[i as usize]));
                first..ordered_spheres.len()
            })
            .collect();
        let accel = Self {
            blocks,
            triangle_normals: (slots.iter())
                .map(|i| i.map_or(DVec3::ZERO, |i| triangles[i as usize].area_vector().normalize()))
                .collect(),
            triangle_shapes: slots.iter().map(|i| i.map_or(u32::MAX, |i| triangles[i as usize].shape)).collect(),
            spheres: ordered_spheres,
            sphere_ranges,
            triangle_tree,
            sphere_tree,
        };
        (accel, slots)
    }

    /// The triangles with their ids.
    pub fn triangles(&self) -> impl Iterator<Item = (PrimitiveId, Triangle)> + '_ {
        let ids = (0..self.triangle_shapes.len() as u32).map(PrimitiveId);
        ids.filter(|id| self.triangle_shapes[id.0 as usize] != u32::MAX).map(|id| (id, self.triangle(id)))
    }

    /// The spheres in the order of their ids.
    #[must_use]
    pub fn spheres(&self) -> &[SphereShape] {
        &self.spheres
    }

    /// The id of a sphere by its position in [`spheres`](Self::spheres).
    #[must_use]
    pub fn sphere_id(&self, index: usize) -> PrimitiveId {
        PrimitiveId((self.triangle_shapes.len() + index) as u32)
    }

    /// The sphere with this id, or `None` where it is a triangle's.
    #[must_use]
    #[inline]
    pub fn as_sphere(&self, id: PrimitiveId) -> Option<&SphereShape> {
        (id.0 as usize).checked_sub(self.triangle_shapes.len()).map(|i| &self.spheres[i])
    }

    /// The triangle with this id.
    #[must_use]
    #[inline]
    pub fn triangle(&self, id: PrimitiveId) -> Triangle {
        let slot = id.0 as usize;
        Triangle { corners: self.blocks[slot / LANES].corners(slot % LANES), shape: self.triangle_shapes[slot] }
    }

    /// The unit normal of the front of the triangle with this id.
    #[must_use]
    #[inline]
    pub fn normal(&self, id: PrimitiveId) -> DVec3 {
        self.triangle_normals[id.0 as usize]
    }

    /// The nearest primitive in front of a ray that starts on `start`; of several at the same distance, the first.
    #[must_use]
    pub fn closest(&self, ray: &Ray, start: PrimitiveId) -> Option<Hit> {
        let mut best = Hit { t: f64::MAX, primitive: PrimitiveId::NONE, barycentric: [0.0; 2] };
        let sheared = ShearedRay::new(ray);
        self.triangle_tree.visit(ray, &mut best.t, |leaf, t_max| {
            let hits = self.blocks[leaf].intersect(&sheared, *t_max);
            let mut mask = hits.mask & !lane_of(start, leaf);
            while mask != 0 {
                let lane = mask.trailing_zeros() as usize;
                mask &= mask - 1;
                let id = PrimitiveId((leaf * LANES + lane) as u32);
                let t = hits.distance(lane);
                if t < *t_max || (t == *t_max && id < best.primitive) {
                    *t_max = t;
                    best.primitive = id;
                    best.barycentric = hits.hit(lane).1;
                }
            }
            true
        });
        self.sphere_tree.visit(ray, &mut best.t, |leaf, t_max| {
            for slot in self.sphere_ranges[leaf].clone() {
                let id = self.sphere_id(slot);
                if let Some(t) = self.spheres[slot].intersect(ray, id == start)
                    && t < *t_max
                {
                    *t_max = t;
                    best.primitive = id;
                    best.barycentric = [0.0; 2];
                }
            }
            true
        });
        (best.primitive != PrimitiveId::NONE).then_some(best)
    }

    /// Something lies strictly between two points of the primitives `on_a` and `on_b`. The same bits for both orders.
    #[must_use]
    pub fn occluded(&self, a: DVec3, on_a: PrimitiveId, b: DVec3, on_b: PrimitiveId) -> bool {
        let swap = (b.x, b.y, b.z) < (a.x, a.y, a.z);
        let (from, to, on_from, on_to) = if swap { (b, a, on_b, on_a) } else { (a, b, on_a, on_b) };
        let offset = to - from;
        let length = offset.length();
        let ray = Ray::new(from, offset / length);
        let sheared = ShearedRay::new(&ray);
        let by_triangle = self.triangle_tree.any(&ray, length, |leaf| {
            let hits = self.blocks[leaf].intersect(&sheared, length.next_down());
            hits.mask & !(lane_of(on_from, leaf) | lane_of(on_to, leaf)) != 0
        });
        by_triangle
            || self.sphere_tree.any(&ray, length, |leaf| {
                self.sphere_ranges[leaf].clone().any(|slot| {
                    let id = self.sphere_id(slot);
                    self.spheres[slot].blocks(&ray, length, id == on_from, id == on_to)
                })
            })
    }
}

/// The bit of a triangle in the mask of a leaf's hits; zero where it lies in another leaf.
#[inline]
fn lane_of(id: PrimitiveId, leaf: usize) -> u32 {
    let slot = id.0 as usize;
    u32::from(slot / LANES == leaf) << (slot % LANES)
}
