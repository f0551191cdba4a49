//! The microfacets of glTF's material.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use crate::warp;

/// GGX with a roughness along each of two axes, and Smith's shadowing, separable as in glTF 2.0, appendix B.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Facets {
    /// Roughness along both axes, above 0.
    alpha: [f64; 2],
    /// Cosine and sine of the angle from x to the first axis.
    axis: [f64; 2],
}

impl Facets {
    pub(super) fn isotropic(alpha: f64) -> Self {
        Self { alpha: [alpha; 2], axis: [1.0, 0.0] }
    }

    pub(super) fn along(axis: [f64; 2], alpha: [f64; 2]) -> Self {
        Self { alpha, axis }
    }

    #[inline]
    fn along_axes(&self, v: DVec3) -> (f64, f64) {
        let [c, s] = self.axis;
        (c * v.x + s * v.y, c * v.y - s * v.x)
    }

    /// `D(m) = 1 / (π α₁ α₂ (m₁²/α₁² + m₂²/α₂² + m_z²)²)` \[1/sr\]. Zero below the horizon.
    #[inline]
    pub(super) fn distribution(&self, m: DVec3) -> f64 {
        if m.z <= 0.0 {
            return 0.0;
        }
        let [a, b] = self.alpha;
        let (x, y) = self.along_axes(m);
        let d = a * b * m.z * m.z + (x * x * (b / a) + y * y * (a / b));
        a * b * FRAC_1_PI / (d * d)
    }

    /// `G₁(v) / |cos θ_v| = 2 / (|cos θ| + √(cos²θ + α₁² v₁² + α₂² v₂²))`.
    #[inline]
    pub(super) fn shadowing_over_cos(&self, v: DVec3) -> f64 {
        let [a, b] = self.alpha;
        let (x, y) = self.along_axes(v);
        2.0 / (v.z.abs() + (v.z * v.z + (a * a * x * x + b * b * y * y)).sqrt())
    }

    /// A normal as seen from `v` with `v.z > 0`, by the density `G₁(v) max(0, v·m) D(m) / cos θ_v`: halfway between the
    /// stretched `v` and a uniform spherical cap (Dupuy and Benyoub 2023).
    #[inline]
    pub(super) fn sample_visible(&self, v: DVec3, u: [f64; 2]) -> DVec3 {
        let [a, b] = self.alpha;
        let (x, y) = self.along_axes(v);
        let w = DVec3::new(a * x, b * y, v.z).normalize();
        let above = 1.0 + w.z;
        // As in the isotropic case: 1 − w.z from the sine, because the roughness may be tiny.
        let height = (1.0 - u[1]) * above;
        let sine = (u[1] * above * ((w.x * w.x + w.y * w.y) / above + height)).sqrt();
        let (s, c) = warp::sin_cos_turn(u[0]);
        let (x, y) = (a * (sine * c + w.x), b * (sine * s + w.y));
        let [cos, sin] = self.axis;
        DVec3::new(cos * x - sin * y, sin * x + cos * y, height).normalize()
    }
}
