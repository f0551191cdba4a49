//! Ray against analytic sphere.

use glam::DVec3;

use crate::geometry::{Bounds, Ray};

use super::analytic::ShapePoint;

/// An analytic sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereShape {
    /// Centre, relative to the scene's \[m\].
    pub centre: DVec3,
    /// Radius \[m\].
    pub radius: f64,
    /// Its front is the inside.
    pub inward: bool,
    /// The shape that it belongs to.
    pub shape: u32,
}

impl SphereShape {
    /// The smallest box around it.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        let r = DVec3::splat(self.radius);
        Bounds { min: self.centre - r, max: self.centre + r }
    }

    /// Its area, 4πr² \[m²\].
    #[must_use]
    pub fn area(&self) -> f64 {
        4.0 * std::f64::consts::PI * self.radius * self.radius
    }

    /// The nearest distance at which a ray meets it. With `starts_here` the origin lies on the sphere and is no hit.
    #[must_use]
    #[inline]
    pub fn intersect(&self, ray: &Ray, starts_here: bool) -> Option<f64> {
        let [near, far] = self.roots(ray, starts_here)?;
        if near > 0.0 { Some(near) } else { (far > 0.0).then_some(far) }
    }

    /// It blocks a segment of the given length, whose ends may lie on it.
    #[must_use]
    #[inline]
    pub fn blocks(&self, ray: &Ray, length: f64, starts_here: bool, ends_here: bool) -> bool {
        if starts_here && ends_here {
            return false;
        }
        if ends_here {
            // Seen from its end the segment has one other root, which is known better than both from afar.
            let reversed = Ray::new(ray.at(length), -ray.direction);
            return self.blocks(&reversed, length, true, false);
        }
        self.roots(ray, starts_here).is_some_and(|roots| roots.iter().any(|&t| t > 0.0 && t < length))
    }

    #[inline]
    pub(super) fn nearest(&self, point: DVec3) -> ShapePoint {
        self.along((point - self.centre).normalize())
    }

    /// The point in a direction, of length one, from the centre.
    #[must_use]
    #[inline]
    pub fn along(&self, outward: DVec3) -> ShapePoint {
        let position = self.centre + outward * self.radius;
        ShapePoint { position, normal: if self.inward { -outward } else { outward } }
    }

    /// Both roots of ‖o + t d − c‖ = r, in order, without cancellation; a root at the start is reported as zero.
    #[inline]
    fn roots(&self, ray: &Ray, starts_here: bool) -> Option<[f64; 2]> {
        let to_origin = ray.origin - self.centre;
        let b = to_origin.dot(ray.direction);
        if starts_here {
            let other = -2.0 * b;
            return Some([other.min(0.0), other.max(0.0)]);
        }
        // Distance of the centre to the line, from its components rather than as a difference of squares.
        let nearest = to_origin - ray.direction * b;
        let discriminant = self.radius * self.radius - nearest.length_squared();
        if discriminant < 0.0 {
            return None;
        }
        let c = (to_origin.length() - self.radius) * (to_origin.length() + self.radius);
        let q = -b - discriminant.sqrt().copysign(b);
        if q == 0.0 {
            return Some([0.0, 0.0]);
        }
        let (t0, t1) = (q, c / q);
        Some([t0.min(t1), t0.max(t1)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_from_the_surface_meets_only_the_other_side() {
        let s = SphereShape { centre: DVec3::new(1.0, 2.0, 3.0), radius: 0.5, inward: false, shape: 0 };
        let start = s.centre + DVec3::X * 0.5;
        assert_eq!(s.intersect(&Ray::new(start, DVec3::X), true), None);
        assert_eq!(s.intersect(&Ray::new(start, -DVec3::X), true), Some(1.0));
        assert_eq!(s.intersect(&Ray::new(s.centre - DVec3::X, DVec3::X), false), Some(0.5));
        assert_eq!(s.intersect(&Ray::new(s.centre, DVec3::X), false), Some(0.5));
    }

    #[test]
    fn a_segment_is_blocked_from_both_ends_alike() {
        let s = SphereShape { centre: DVec3::ZERO, radius: 1.0, inward: false, shape: 0 };
        let forth = Ray::new(DVec3::new(-3.0, 0.0, 0.0), DVec3::X);
        assert!(!s.blocks(&forth, 2.0, false, true), "ends on the near side");
        assert!(s.blocks(&forth, 4.0, false, true), "ends on the far side");
        assert!(s.blocks(&forth, 6.0, false, false), "passes through");
        assert!(!s.blocks(&forth, 1.0, false, false), "stays before it");
    }
}
