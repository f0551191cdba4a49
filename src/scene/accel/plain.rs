//! Ray against one triangle as it is done where gaps are put up with: what watertightness costs is measured against it.

use glam::DVec3;

use crate::geometry::Ray;

use super::TriangleHit;

/// A ray as it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct LeafRay(Ray);

impl LeafRay {
    #[inline]
    pub fn new(ray: &Ray) -> Self {
        Self(*ray)
    }

    /// Where the ray meets a triangle, from either side, at a distance above zero and up to `t_max` (Möller and Trumbore 1997).
    #[inline(always)]
    pub fn intersect(&self, corners: impl Fn(usize, usize) -> f64, t_max: f64) -> Option<TriangleHit> {
        let Ray { origin, direction } = self.0;
        let [a, b, c] = [0, 1, 2].map(|i| DVec3::new(corners(i, 0), corners(i, 1), corners(i, 2)));
        let (along_v, along_w) = (b - a, c - a);
        let p = direction.cross(along_w);
        let scale = 1.0 / along_v.dot(p);
        let to_origin = origin - a;
        let v = to_origin.dot(p) * scale;
        let q = to_origin.cross(along_v);
        let w = direction.dot(q) * scale;
        let t = along_w.dot(q) * scale;
        let inside = v >= 0.0 && w >= 0.0 && v + w <= 1.0;
        (inside && t > 0.0 && t <= t_max).then_some(TriangleHit { t, v, w, scale: 1.0 })
    }
}
