//! The GGX distribution of microfacet normals.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use crate::measure::{Density, SolidAngle};
use crate::warp;

/// GGX (Trowbridge and Reitz 1975; Walter et al. 2007) with isotropic roughness α and Smith's shadowing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ggx {
    /// Roughness, above 0.
    alpha: f64,
}

impl Ggx {
    /// With roughness α.
    #[must_use]
    pub fn new(alpha: f64) -> Self {
        Self { alpha }
    }

    /// `D(m) = α² / (π (α² cos²θ + sin²θ)²)`, the density of microfacets by area times 1/cos θ \[1/sr\]. Zero below the horizon.
    #[must_use]
    #[inline]
    pub fn distribution(&self, m: DVec3) -> f64 {
        if m.z <= 0.0 {
            return 0.0;
        }
        let a2 = self.alpha * self.alpha;
        let d = a2 * m.z * m.z + (m.x * m.x + m.y * m.y);
        a2 * FRAC_1_PI / (d * d)
    }

    /// `G₁(v) / |cos θ_v| = 2 / (|cos θ| + √(cos²θ + α² sin²θ))`: finite at grazing angles, where its parts are not.
    #[must_use]
    #[inline]
    pub fn shadowing_over_cos(&self, v: DVec3) -> f64 {
        let a2 = self.alpha * self.alpha;
        2.0 / (v.z.abs() + (v.z * v.z + a2 * (v.x * v.x + v.y * v.y)).sqrt())
    }

    /// `D_v(m) = G₁(v) max(0, v·m) D(m) / |cos θ_v|`, the density of [`sample_visible`](Self::sample_visible) \[1/sr\].
    #[must_use]
    #[inline]
    pub fn visible_density(&self, v: DVec3, m: DVec3) -> Density<SolidAngle> {
        Density::new(self.shadowing_over_cos(v) * v.dot(m).max(0.0) * self.distribution(m))
    }

    /// A microfacet normal as seen from `v` with `v.z > 0`: stretched to the hemisphere, where the visible normals are
    /// halfway between `v` and a uniform spherical cap (Dupuy and Benyoub 2023).
    #[must_use]
    #[inline]
    pub fn sample_visible(&self, v: DVec3, u: [f64; 2]) -> DVec3 {
        let w = DVec3::new(self.alpha * v.x, self.alpha * v.y, v.z).normalize();
        let above = 1.0 + w.z;
        // The cap z > −w.z, its height measured from its rim; 1 − w.z from the sine, because α may be tiny.
        let height = (1.0 - u[1]) * above;
        let sine = (u[1] * above * ((w.x * w.x + w.y * w.y) / above + height)).sqrt();
        let (s, c) = warp::sin_cos_turn(u[0]);
        DVec3::new(self.alpha * (sine * c + w.x), self.alpha * (sine * s + w.y), height).normalize()
    }
}
