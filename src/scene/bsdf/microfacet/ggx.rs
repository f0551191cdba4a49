use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use crate::quadrature::Rule;
use crate::warp;

/// GGX (Trowbridge and Reitz 1975; Walter et al. 2007) with Smith's shadowing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ggx {
    /// Roughness along u and v, above 0.
    alpha: [f64; 2],
    /// One over it.
    inverse: [f64; 2],
    /// `1 / (π α_u α_v)`.
    scale: f64,
}

impl Ggx {
    /// With roughness α along u and v.
    #[must_use]
    pub fn new(alpha: [f64; 2]) -> Self {
        Self { alpha, inverse: alpha.map(|a| 1.0 / a), scale: FRAC_1_PI / (alpha[0] * alpha[1]) }
    }

    /// α along u and v.
    #[must_use]
    pub fn alpha(&self) -> [f64; 2] {
        self.alpha
    }

    /// `D(m) = 1 / (π α_u α_v ((m_x/α_u)² + (m_y/α_v)² + m_z²)²)` \[1/sr\]. Zero below the horizon.
    #[must_use]
    #[inline]
    pub fn distribution(&self, m: DVec3) -> f64 {
        if m.z <= 0.0 {
            return 0.0;
        }
        let (x, y) = (m.x * self.inverse[0], m.y * self.inverse[1]);
        let d = m.z * m.z + (x * x + y * y);
        self.scale / (d * d)
    }

    /// `G₁(v) / |cos θ_v| = 2 / (|v_z| + √(v_z² + (α_u v_x)² + (α_v v_y)²))`.
    #[must_use]
    #[inline]
    pub fn shadowing_over_cos(&self, v: DVec3) -> f64 {
        let (x, y) = (self.alpha[0] * v.x, self.alpha[1] * v.y);
        2.0 / (v.z.abs() + (v.z * v.z + (x * x + y * y)).sqrt())
    }

    /// A microfacet normal as seen from `v` with `v.z > 0`: stretched to the hemisphere, where the visible normals are
    /// halfway between `v` and a uniform spherical cap (Dupuy and Benyoub 2023).
    #[must_use]
    #[inline]
    pub fn sample_visible(&self, v: DVec3, u: [f64; 2]) -> DVec3 {
        let w = DVec3::new(self.alpha[0] * v.x, self.alpha[1] * v.y, v.z).normalize();
        let above = 1.0 + w.z;
        // The cap z > −w.z, its height measured from its rim; 1 − w.z from the sine, because α may be tiny.
        let height = (1.0 - u[1]) * above;
        let sine = (u[1] * above * ((w.x * w.x + w.y * w.y) / above + height)).sqrt();
        let (s, c) = warp::sin_cos_turn(u[0]);
        DVec3::new(self.alpha[0] * (sine * c + w.x), self.alpha[1] * (sine * s + w.y), height).normalize()
    }

    /// See [`Microfacets::visible_rule`](super::Microfacets::visible_rule). Half of a turn is drawn with the first number,
    /// and what is symmetric and periodic in it has equal weights.
    pub(super) fn visible_rule(&self, v: DVec3, rule: &Rule) -> Vec<(DVec3, f64)> {
        let count = rule.len();
        let turns = (0..count).map(|i| (i as f64 + 0.5) / (2 * count) as f64);
        let pairs = turns.flat_map(|turn| rule.iter().map(move |&(u, weight)| ([turn, u], weight / count as f64)));
        pairs.map(|(u, weight)| (self.sample_visible(v, u), weight)).collect()
    }
}
