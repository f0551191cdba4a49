//! Which surface does a ray meet, and is a segment free: the only place that knows the BVH library.
//!
//! Boxes are single precision and padded so that rays in double precision, whose origin and direction are rounded for
//! the box tests, cannot slip past them. What lies in the leaves is tested in double precision. There is no epsilon:
//! a surface that the origin lies on is excluded by its identity.

mod sphere;
mod triangle;

use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::fast_stack;

use crate::geometry::{Bounds, Ray};

pub use sphere::SphereShape;
pub use triangle::Triangle;

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
    triangles: Vec<Triangle>,
    spheres: Vec<SphereShape>,
    triangle_tree: Tree,
    sphere_tree: Tree,
}

/// A hierarchy over boxes; `bvh` is `None` without any.
struct Tree {
    bvh: Option<Bvh2>,
}

impl std::fmt::Debug for Tree {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Tree({} nodes)", self.bvh.as_ref().map_or(0, |bvh| bvh.nodes.len()))
    }
}

impl Accel {
    /// Builds the hierarchies and puts the primitives in their order. `radius` bounds the distance of everything that
    /// rays start from to the origin. The second result maps each new position of a triangle to its old one.
    #[must_use]
    pub fn build(triangles: &[Triangle], spheres: &[SphereShape], radius: f64) -> (Self, Vec<u32>) {
        // Rounding of a ray to f32 moves it by less than 2⁻²² of the scene's size anywhere inside it.
        let pad = radius * f64::powi(2.0, -19);
        let (triangle_tree, triangle_order) = Tree::build(triangles.iter().map(Triangle::bounds), pad);
        let (sphere_tree, sphere_order) = Tree::build(spheres.iter().map(SphereShape::bounds), pad);
        let accel = Self {
            triangles: triangle_order.iter().map(|&i| triangles[i as usize]).collect(),
            spheres: sphere_order.iter().map(|&i| spheres[i as usize]).collect(),
            triangle_tree,
            sphere_tree,
        };
        (accel, triangle_order)
    }

    /// The triangles in the order of their ids.
    #[must_use]
    pub fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }

    /// The spheres in the order of their ids.
    #[must_use]
    pub fn spheres(&self) -> &[SphereShape] {
        &self.spheres
    }

    /// The id of a sphere by its position in [`spheres`](Self::spheres).
    #[must_use]
    pub fn sphere_id(&self, index: usize) -> PrimitiveId {
        PrimitiveId((self.triangles.len() + index) as u32)
    }

    /// The sphere with this id, or `None` where it is a triangle's.
    #[must_use]
    #[inline]
    pub fn as_sphere(&self, id: PrimitiveId) -> Option<&SphereShape> {
        (id.0 as usize).checked_sub(self.triangles.len()).map(|i| &self.spheres[i])
    }

    /// The triangle with this id.
    #[must_use]
    #[inline]
    pub fn triangle(&self, id: PrimitiveId) -> &Triangle {
        &self.triangles[id.0 as usize]
    }

    /// The nearest primitive in front of a ray that starts on `start`; of several at the same distance, the first.
    #[must_use]
    pub fn closest(&self, ray: &Ray, start: PrimitiveId) -> Option<Hit> {
        let mut best = Hit { t: f64::INFINITY, primitive: PrimitiveId::NONE, barycentric: [0.0; 2] };
        self.triangle_tree.visit(ray, &mut best.t, |slots, t_max| {
            for slot in slots {
                let id = PrimitiveId(slot as u32);
                if id == start {
                    continue;
                }
                if let Some((t, barycentric)) = self.triangles[slot].intersect(ray)
                    && (t < *t_max || (t == *t_max && id < best.primitive))
                {
                    *t_max = t;
                    best.primitive = id;
                    best.barycentric = barycentric;
                }
            }
            true
        });
        self.sphere_tree.visit(ray, &mut best.t, |slots, t_max| {
            for slot in slots {
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
        let mut free = true;
        self.triangle_tree.visit(&ray, &mut length.clone(), |slots, t_max| {
            for slot in slots {
                let id = PrimitiveId(slot as u32);
                if id != on_from && id != on_to && self.triangles[slot].intersect(&ray).is_some_and(|(t, _)| t < *t_max) {
                    free = false;
                    return false;
                }
            }
            true
        });
        if !free {
            return true;
        }
        self.sphere_tree.visit(&ray, &mut length.clone(), |slots, _| {
            for slot in slots {
                let id = self.sphere_id(slot);
                if self.spheres[slot].blocks(&ray, length, id == on_from, id == on_to) {
                    free = false;
                    return false;
                }
            }
            true
        });
        !free
    }
}

impl Tree {
    /// The tree, and the order of the leaves as indices into the input.
    fn build(boxes: impl Iterator<Item = Bounds>, pad: f64) -> (Self, Vec<u32>) {
        let boxes: Vec<Aabb> = boxes.map(|b| padded(b, pad)).collect();
        if boxes.is_empty() {
            return (Self { bvh: None }, Vec::new());
        }
        let params = BvhBuildParams { pre_split: false, max_prims_per_leaf: 4, ..BvhBuildParams::medium_build() };
        let mut bvh = build_bvh2(&boxes, params, &mut std::time::Duration::default());
        let order = std::mem::take(&mut bvh.primitive_indices);
        (Self { bvh: Some(bvh) }, order)
    }

    /// Calls `leaf` with the slots of each leaf that the ray may meet before `t_max`, near ones first, until it says no.
    #[inline]
    fn visit(&self, ray: &Ray, t_max: &mut f64, mut leaf: impl FnMut(std::ops::Range<usize>, &mut f64) -> bool) {
        let Some(bvh) = &self.bvh else { return };
        let single = |v: DVec3| Vec3A::new(v.x as f32, v.y as f32, v.z as f32);
        let rounded = obvhs::ray::Ray::new(single(ray.origin), single(ray.direction), 0.0, round_up(*t_max));
        let mut visit_leaf = |node: &Bvh2Node, rounded: &mut obvhs::ray::Ray, _: &mut obvhs::ray::RayHit| {
            let first = node.first_index as usize;
            let go_on = leaf(first..first + node.prim_count as usize, t_max);
            rounded.tmax = round_up(*t_max);
            go_on
        };
        fast_stack!(u32, (96, 192), bvh.max_depth, stack, {
            bvh.ray_traverse_dynamic(&mut stack, rounded, &mut obvhs::ray::RayHit::none(), &mut visit_leaf);
        });
    }
}

/// A single-precision distance that is no nearer, even after the box test's own rounding.
#[inline]
fn round_up(t: f64) -> f32 {
    t as f32 * (1.0 + 4.0 * f32::EPSILON) + f32::MIN_POSITIVE
}

/// The box, larger by `pad` on every side and rounded outwards.
fn padded(bounds: Bounds, pad: f64) -> Aabb {
    let pad = DVec3::splat(pad);
    let (min, max) = (bounds.min - pad, bounds.max + pad);
    let down = |x: f64| (x as f32).next_down();
    let up = |x: f64| (x as f32).next_up();
    Aabb::new(
        Vec3A::new(down(min.x), down(min.y), down(min.z)),
        Vec3A::new(up(max.x), up(max.y), up(max.z)),
    )
}
