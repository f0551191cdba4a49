//! Ray against analytic disk.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use crate::geometry::{Bounds, Ray};

use super::analytic::ShapePoint;

/// A disk, or an ellipse: all `centre + x axes[0] + y axes[1]` with `x² + y² ≤ 1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiskShape {
    centre: DVec3,
    axes: [DVec3; 2],
    /// Unit normal of the front.
    normal: DVec3,
    /// What turns an offset from the centre to x and y.
    reciprocal: [DVec3; 2],
    shape: u32,
}

impl DiskShape {
    /// From the centre, relative to the scene's, and the places of (1, 0) and (0, 1) relative to it \[m\], which must span a
    /// plane. Its front is where their cross product points, or with `flipped` the other side.
    #[must_use]
    pub fn new(centre: DVec3, axes: [DVec3; 2], flipped: bool, shape: u32) -> Self {
        let [u, v] = axes;
        let normal = u.cross(v).normalize();
        let (across_v, across_u) = (v.cross(normal), normal.cross(u));
        let reciprocal = [across_v / across_v.dot(u), across_u / across_u.dot(v)];
        Self { centre, axes, normal: if flipped { -normal } else { normal }, reciprocal, shape }
    }

    /// The number of the scene's shape that it is.
    #[must_use]
    pub fn shape(&self) -> u32 {
        self.shape
    }

    /// The smallest box around it.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        let [u, v] = self.axes;
        let reach = |i: usize| libm::hypot(u[i], v[i]);
        let reach = DVec3::new(reach(0), reach(1), reach(2));
        Bounds { min: self.centre - reach, max: self.centre + reach }
    }

    /// Its area, `π ‖axes[0] × axes[1]‖` \[m²\].
    #[must_use]
    pub fn area(&self) -> f64 {
        PI * self.axes[0].cross(self.axes[1]).length()
    }

    /// The distance at which a ray that starts elsewhere meets it.
    #[must_use]
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<f64> {
        let to_centre = self.centre - ray.origin;
        let t = to_centre.dot(self.normal) / ray.direction.dot(self.normal);
        let offset = ray.direction * t - to_centre;
        let [x, y] = self.reciprocal.map(|axis| axis.dot(offset));
        // No comparison holds for what is no number: rays in the plane.
        (t > 0.0 && t < f64::INFINITY && x * x + y * y <= 1.0).then_some(t)
    }

    pub(super) fn nearest(&self, point: DVec3) -> ShapePoint {
        let height = (point - self.centre).dot(self.normal);
        ShapePoint { position: point - self.normal * height, normal: self.normal }
    }

    pub(super) fn at(&self, place: DVec2) -> ShapePoint {
        let position = self.centre + self.axes[0] * place.x + self.axes[1] * place.y;
        ShapePoint { position, normal: self.normal }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::Random;
    use crate::warp::uniform_sphere;

    /// Its axes are as 1 to 10⁹: what is aimed just inside is met, what is aimed just outside is not.
    #[test]
    fn an_ellipse_may_be_a_needle() {
        let mut random = Random::new(7, 0, 0);
        for i in 0..10_000 {
            let (along, other) = (uniform_sphere(random.uniform2()), uniform_sphere(random.uniform2()));
            let across = along.cross(other).normalize();
            let centre = uniform_sphere(random.uniform2());
            let disk = DiskShape::new(centre, [along, across * 1e-9], i % 2 == 0, 0);
            let origin = centre + (disk.normal + 0.5 * other) * (1.0 + random.uniform());
            let (x, y) = crate::warp::sin_cos_turn(random.uniform());
            let met = |share: f64| {
                let target = disk.at(DVec2::new(x, y) * share).position;
                disk.intersect(&Ray::new(origin, (target - origin).normalize()))
            };
            if (origin - centre).dot(disk.normal).abs() > 0.1 {
                let t = met(1.0 - 1e-5).expect("aimed inside");
                assert!((t - (disk.at(DVec2::new(x, y)).position - origin).length()).abs() < 1e-4);
                assert_eq!(met(1.0 + 1e-5), None);
            }
        }
    }

    #[test]
    fn a_ray_meets_the_ellipse_and_not_the_plane_beyond() {
        let axes = [DVec3::new(2.0, 0.0, 0.0), DVec3::new(1.0, 1.0, 0.0)];
        let disk = DiskShape::new(DVec3::new(0.0, 0.0, 3.0), axes, false, 0);
        let down = |x: f64, y: f64| disk.intersect(&Ray::new(DVec3::new(x, y, 5.0), -DVec3::Z));
        assert_eq!(down(0.0, 0.0), Some(2.0));
        assert_eq!(down(1.999, 0.0), Some(2.0));
        assert_eq!(down(2.001, 0.0), None);
        assert_eq!(down(1.0, 0.999), Some(2.0));
        assert_eq!(down(-1.0, 0.9), None);
        assert_eq!(disk.intersect(&Ray::new(DVec3::new(0.0, 0.0, 3.0), DVec3::X)), None, "a ray in its plane");
        assert!((disk.area() - 2.0 * PI).abs() < 1e-15);
        let Bounds { min, max } = disk.bounds();
        let five = 5.0_f64.sqrt();
        assert!((max - DVec3::new(five, 1.0, 3.0)).length() < 1e-15 && (min + max).truncate().length() < 1e-15);
    }
}
