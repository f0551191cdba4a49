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
    /// ‖c‖² − r² \[m²\].
    power: f64,
}

impl SphereShape {
    /// From the centre, relative to the scene's, and the radius \[m\]. Its front is the outside, or with `inward` the inside.
    #[must_use]
    pub fn new(centre: DVec3, radius: f64, inward: bool, shape: u32) -> Self {
        // Both squares to all digits: the ground under a scene may be a sphere of 10¹² m, of which this is what is left.
        let squares = [centre.x, centre.y, centre.z].map(|x| (x * x, x.mul_add(x, -(x * x))));
        let radius_squared = (radius * radius, radius.mul_add(radius, -(radius * radius)));
        let terms = squares.into_iter().chain([(-radius_squared.0, -radius_squared.1)]);
        let (mut sum, mut rest) = (0.0_f64, 0.0);
        for (square, error) in terms {
            let next = sum + square;
            rest += error + if sum.abs() >= square.abs() { (sum - next) + square } else { (square - next) + sum };
            sum = next;
        }
        Self { centre, radius, inward, shape, power: sum + rest }
    }

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
        let from_centre = point - self.centre;
        let distance = from_centre.length();
        let outward = from_centre / distance;
        // Along the normal only: from the centre of a huge sphere rounding would move it along the surface, too.
        let position = point - outward * (self.power_of(point, distance) / (distance + self.radius));
        ShapePoint { position, normal: if self.inward { -outward } else { outward } }
    }

    /// ‖p − c‖² − r², without cancellation: of a point near the surface of a small sphere by their difference, of one near the
    /// surface of a huge sphere by what both have in common.
    #[inline]
    fn power_of(&self, point: DVec3, distance: f64) -> f64 {
        let near_origin = 16.0 * point.length_squared() < self.radius * self.radius;
        if near_origin {
            (point - self.centre * 2.0).dot(point) + self.power
        } else {
            (distance - self.radius) * (distance + self.radius)
        }
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
        let c = self.power_of(ray.origin, to_origin.length());
        let square = self.radius * self.radius;
        let discriminant = if c.abs() < 0.25 * square {
            b * b - c
        } else {
            // By the distance of the centre to the line, from its components rather than as a difference of squares.
            square - (to_origin - ray.direction * b).length_squared()
        };
        if discriminant < 0.0 {
            return None;
        }
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
    use crate::sampler::Random;
    use crate::warp::uniform_sphere;

    #[test]
    fn a_ray_from_the_surface_meets_only_the_other_side() {
        let s = SphereShape::new(DVec3::new(1.0, 2.0, 3.0), 0.5, false, 0);
        let start = s.centre + DVec3::X * 0.5;
        assert_eq!(s.intersect(&Ray::new(start, DVec3::X), true), None);
        assert_eq!(s.intersect(&Ray::new(start, -DVec3::X), true), Some(1.0));
        assert_eq!(s.intersect(&Ray::new(s.centre - DVec3::X, DVec3::X), false), Some(0.5));
        assert_eq!(s.intersect(&Ray::new(s.centre, DVec3::X), false), Some(0.5));
    }

    #[test]
    fn a_segment_is_blocked_from_both_ends_alike() {
        let s = SphereShape::new(DVec3::ZERO, 1.0, false, 0);
        let forth = Ray::new(DVec3::new(-3.0, 0.0, 0.0), DVec3::X);
        assert!(!s.blocks(&forth, 2.0, false, true), "ends on the near side");
        assert!(s.blocks(&forth, 4.0, false, true), "ends on the far side");
        assert!(s.blocks(&forth, 6.0, false, false), "passes through");
        assert!(!s.blocks(&forth, 1.0, false, false), "stays before it");
    }

    /// From a distance of 10⁹ radii rays meet what they are aimed at and nothing beside it, where a direction still has digits
    /// for it: 10⁻⁷ of the radius.
    #[test]
    fn a_tiny_sphere_is_met_from_afar() {
        let mut random = Random::new(4, 0, 0);
        for _ in 0..10_000 {
            let distance = 1e9;
            let s = SphereShape::new(uniform_sphere(random.uniform2()), 1e-6, false, 0);
            let towards = uniform_sphere(random.uniform2());
            let across = towards.cross(uniform_sphere(random.uniform2())).normalize();
            let origin = s.centre - towards * (s.radius * distance);
            let aimed = |off: f64| Ray::new(origin, (s.centre + across * (s.radius * off) - origin).normalize());
            let ray = aimed(0.99999);
            let point = s.nearest(ray.at(s.intersect(&ray, false).expect("aimed inside"))).position;
            assert!((point - s.centre).length() - s.radius < 1e-9 * s.radius);
            assert!(s.intersect(&aimed(1.00001), false).is_none());
        }
    }

    /// The ground is a sphere of 10¹² m: heights above it keep their digits, where its centre has none after 10⁻⁴ m.
    #[test]
    fn the_ground_may_be_a_huge_sphere() {
        let down = DVec3::new(0.48, -0.64, 0.6);
        let s = SphereShape::new(down * 1e12, 1e12, false, 0);
        // Its surface is not at the origin, since the centre is rounded; here is how high it is.
        let ground = s.power / (2.0 * s.radius);
        assert!(ground.abs() < 1e-3);
        let mut random = Random::new(5, 0, 0);
        for _ in 0..1000 {
            let origin = DVec3::from_array(random.uniform3()) - down * 3.0;
            let height = ground - origin.dot(down) + origin.cross(down).length_squared() / 2e12;
            let direction = uniform_sphere(random.uniform2());
            let ray = Ray::new(origin, direction);
            let expected = height / direction.dot(down);
            if direction.dot(down) < 1e-3 {
                continue;
            }
            let t = s.intersect(&ray, false).expect("it goes down");
            // The surface falls by d²/2r at distance d.
            assert!((t / expected - 1.0).abs() < 1e-12 * expected.max(1.0) / direction.dot(down), "{t} {expected}");
            let point = s.nearest(ray.at(t)).position;
            assert!((point - ray.at(t)).length() < 1e-12 * t.max(1.0));
        }
    }

    #[test]
    fn a_huge_sphere_around_everything_is_met_once() {
        let s = SphereShape::new(DVec3::new(0.3, 0.1, -0.2), 1e12, true, 0);
        let mut random = Random::new(6, 0, 0);
        for _ in 0..1000 {
            let ray = Ray::new(DVec3::from_array(random.uniform3()), uniform_sphere(random.uniform2()));
            let t = s.intersect(&ray, false).expect("inside");
            assert!((t - 1e12).abs() < 4.0);
            let from_it = s.nearest(ray.at(t)).position;
            let back = Ray::new(from_it, -ray.direction);
            assert!((s.intersect(&back, true).expect("across") - 2e12).abs() < 1e-2);
            assert!(s.intersect(&Ray::new(from_it, ray.direction), true).is_none());
        }
    }
}
