//! The microfacets of glTF's material.

use glam::DVec3;

use crate::scene::bsdf::Ggx;

/// GGX with its axes turned around the normal; shadowing is separable, as in glTF 2.0, appendix B.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Facets {
    ggx: Ggx,
    /// Cosine and sine of the angle from x to the first axis; `None` where both roughnesses are alike.
    axis: Option<[f64; 2]>,
}

impl Facets {
    pub(super) fn isotropic(alpha: f64) -> Self {
        Self { ggx: Ggx::new([alpha; 2]), axis: None }
    }

    /// With α along the axis and across.
    pub(super) fn along(axis: [f64; 2], alpha: [f64; 2]) -> Self {
        Self { ggx: Ggx::new(alpha), axis: Some(axis) }
    }

    #[inline]
    fn to_axes(self, v: DVec3) -> DVec3 {
        self.axis.map_or(v, |[c, s]| DVec3::new(c * v.x + s * v.y, c * v.y - s * v.x, v.z))
    }

    /// `D(m)` \[1/sr\].
    #[inline]
    pub(super) fn distribution(&self, m: DVec3) -> f64 {
        self.ggx.distribution(self.to_axes(m))
    }

    /// `G₁(v) / |cos θ_v|`.
    #[inline]
    pub(super) fn shadowing_over_cos(&self, v: DVec3) -> f64 {
        self.ggx.shadowing_over_cos(self.to_axes(v))
    }

    /// A normal as seen from `v` with `v.z > 0`.
    #[inline]
    pub(super) fn sample_visible(&self, v: DVec3, u: [f64; 2]) -> DVec3 {
        let m = self.ggx.sample_visible(self.to_axes(v), u);
        self.axis.map_or(m, |[c, s]| DVec3::new(c * m.x - s * m.y, s * m.x + c * m.y, m.z))
    }
}
