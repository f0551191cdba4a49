//! Ray against analytic cylinder.

use std::f64::consts::PI;

use glam::DVec3;

use crate::geometry::{Bounds, Frame, Ray};
use crate::warp;

use super::analytic::ShapePoint;

/// An analytic cylinder without its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CylinderShape {
    base: DVec3,
    /// Of length one.
    axis: DVec3,
    length: f64,
    radius: f64,
    /// Its front is the inside.
    inward: bool,
    shape: u32,
}

impl CylinderShape {
    /// From the centre of one end, relative to the scene's, the way from there to the other, and the radius \[m\]. Its front is
    /// the outside, or with `inward` the inside.
    #[must_use]
    pub fn new(base: DVec3, axis: DVec3, radius: f64, inward: bool, shape: u32) -> Self {
        let length = axis.length();
        Self { base, axis: axis / length, length, radius, inward, shape }
    }

    /// The number of the scene's shape that it is.
    #[must_use]
    pub fn shape(&self) -> u32 {
        self.shape
    }

    /// The smallest box around it.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        let reach = |i: usize| self.radius * ((1.0 - self.axis[i]) * (1.0 + self.axis[i])).max(0.0).sqrt();
        let reach = DVec3::new(reach(0), reach(1), reach(2));
        let ends = Bounds::around([self.base, self.base + self.axis * self.length]);
        Bounds { min: ends.min - reach, max: ends.max + reach }
    }

    /// Its area, 2πrl \[m²\].
    #[must_use]
    pub fn area(&self) -> f64 {
        2.0 * PI * self.radius * self.length
    }

    /// The nearest distance at which a ray meets it. With `starts_here` the origin lies on the cylinder and is no hit.
    #[must_use]
    pub fn intersect(&self, ray: &Ray, starts_here: bool) -> Option<f64> {
        self.roots(ray, starts_here)?.into_iter().find(|&t| t > 0.0 && self.holds(ray, t))
    }

    /// It blocks a segment of the given length, whose ends may lie on it.
    #[must_use]
    pub fn blocks(&self, ray: &Ray, length: f64, starts_here: bool, ends_here: bool) -> bool {
        if starts_here && ends_here {
            return false;
        }
        if ends_here {
            // Seen from its end the segment has one other root, which is known better than both from afar.
            let reversed = Ray::new(ray.at(length), -ray.direction);
            return self.blocks(&reversed, length, true, false);
        }
        let within = |&t: &f64| t > 0.0 && t < length && self.holds(ray, t);
        self.roots(ray, starts_here).is_some_and(|roots| roots.iter().any(within))
    }

    /// A point on the infinite cylinder lies between the ends.
    fn holds(&self, ray: &Ray, t: f64) -> bool {
        let height = (ray.origin - self.base).dot(self.axis) + t * ray.direction.dot(self.axis);
        (0.0..=self.length).contains(&height)
    }

    /// The part of a vector at right angles to the axis.
    fn across(&self, vector: DVec3) -> DVec3 {
        vector - self.axis * vector.dot(self.axis)
    }

    /// Both roots for the infinite cylinder, in order, without cancellation: those of the sphere, in the plane at right
    /// angles to the axis. A root at the start is reported as zero.
    fn roots(&self, ray: &Ray, starts_here: bool) -> Option<[f64; 2]> {
        let (origin, direction) = (self.across(ray.origin - self.base), self.across(ray.direction));
        let a = direction.length_squared();
        if a == 0.0 {
            return None;
        }
        let b = origin.dot(direction);
        if starts_here {
            let other = -2.0 * b / a;
            return Some([other.min(0.0), other.max(0.0)]);
        }
        let nearest = origin - direction * (b / a);
        let discriminant = self.radius * self.radius - nearest.length_squared();
        if discriminant < 0.0 {
            return None;
        }
        let c = (origin.length() - self.radius) * (origin.length() + self.radius);
        let q = -b - (a * discriminant).sqrt().copysign(b);
        if q == 0.0 {
            return Some([0.0, 0.0]);
        }
        let (t0, t1) = (q / a, c / q);
        Some([t0.min(t1), t0.max(t1)])
    }

    pub(super) fn nearest(&self, point: DVec3) -> ShapePoint {
        let offset = point - self.base;
        let height = offset.dot(self.axis);
        self.along((offset - self.axis * height).normalize(), height.clamp(0.0, self.length))
    }

    /// `u` are shares of the turn and of the length.
    pub(super) fn at(&self, u: [f64; 2]) -> ShapePoint {
        let frame = Frame::around(self.axis);
        let (s, c) = warp::sin_cos_turn(u[0]);
        self.along(frame.x * c + frame.y * s, self.length * u[1])
    }

    fn along(&self, outward: DVec3, height: f64) -> ShapePoint {
        let position = self.base + self.axis * height + outward * self.radius;
        ShapePoint { position, normal: if self.inward { -outward } else { outward } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::Random;
    use crate::warp::uniform_sphere;

    fn pipe() -> CylinderShape {
        CylinderShape::new(DVec3::new(1.0, 0.0, 0.0), DVec3::Z * 2.0, 0.5, false, 0)
    }

    #[test]
    fn a_ray_meets_the_wall_and_passes_the_open_ends() {
        let pipe = pipe();
        let hit = |origin: [f64; 3], direction: [f64; 3], here: bool| {
            let direction = DVec3::from_array(direction).normalize();
            pipe.intersect(&Ray::new(DVec3::from_array(origin), direction), here)
        };
        assert_eq!(hit([-1.0, 0.0, 1.0], [1.0, 0.0, 0.0], false), Some(1.5));
        assert_eq!(hit([-1.0, 0.0, 2.5], [1.0, 0.0, 0.0], false), None, "above");
        assert_eq!(hit([1.0, 0.0, 5.0], [0.0, 0.0, -1.0], false), None, "along the axis");
        assert_eq!(hit([1.0, 0.0, 1.0], [1.0, 0.0, 0.0], false), Some(0.5), "from the inside");
        assert_eq!(hit([0.5, 0.0, 1.0], [1.0, 0.0, 0.0], true), Some(1.0), "across");
        assert_eq!(hit([0.5, 0.0, 1.0], [-1.0, 0.0, 0.0], true), None, "outwards");
        let through_the_top = hit([0.5, 0.0, 3.0], [0.5, 0.0, -1.0], false).expect("it meets the inside");
        assert!((through_the_top - 5.0_f64.sqrt()).abs() < 1e-14);
    }

    #[test]
    fn a_segment_is_blocked_from_both_ends_alike() {
        let pipe = pipe();
        let forth = Ray::new(DVec3::new(-1.0, 0.0, 1.0), DVec3::X);
        assert!(!pipe.blocks(&forth, 1.5, false, true), "ends on the near side");
        assert!(pipe.blocks(&forth, 2.5, false, true), "ends on the far side");
        assert!(pipe.blocks(&forth, 4.0, false, false), "passes through");
        assert!(!pipe.blocks(&forth, 1.0, false, false), "stays before it");
        assert!(!pipe.blocks(&Ray::new(DVec3::new(0.5, 0.0, 1.0), DVec3::X), 1.0, true, true), "from wall to wall");
    }

    /// A wire of 10⁻⁹ of its length and of its distance: what is aimed just inside is met, what is aimed just beside is not.
    #[test]
    fn a_wire_is_met() {
        let mut random = Random::new(8, 0, 0);
        for _ in 0..10_000 {
            let axis = uniform_sphere(random.uniform2());
            let base = uniform_sphere(random.uniform2());
            let wire = CylinderShape::new(base, axis, 1e-9, false, 0);
            let across = axis.cross(uniform_sphere(random.uniform2())).normalize();
            let side = axis.cross(across);
            let middle = base + axis * (0.1 + 0.8 * random.uniform());
            let origin = middle + across + axis * (random.uniform() - 0.5);
            let aimed = |off: f64| Ray::new(origin, (middle + side * (off * 1e-9) - origin).normalize());
            let ray = aimed(0.9999);
            let t = wire.intersect(&ray, false).expect("aimed inside");
            let point = wire.nearest(ray.at(t));
            assert!((point.position - ray.at(t)).length() < 1e-14 && point.normal.is_normalized());
            assert!(wire.intersect(&aimed(1.0001), false).is_none());
        }
    }

    #[test]
    fn the_box_is_tight() {
        let axis = DVec3::new(1.0, 2.0, -2.0);
        let pipe = CylinderShape::new(DVec3::ZERO, axis, 0.7, false, 0);
        let found =
            Bounds::around((0..200_000).map(|i| pipe.at([f64::from(i) / 1e5, f64::from(i / 100_000)]).position));
        let Bounds { min, max } = pipe.bounds();
        assert!((found.min - min).length() < 1e-8 && (found.max - max).length() < 1e-8);
        assert!((pipe.area() - 2.0 * PI * 0.7 * 3.0).abs() < 1e-14);
    }
}
