use std::f64::consts::{FRAC_1_PI, FRAC_2_SQRT_PI};

use glam::DVec3;

use crate::quadrature::Rule;

/// √π.
const SQRT_PI: f64 = 2.0 / FRAC_2_SQRT_PI;

/// Beckmann's distribution, that of a surface with Gaussian slopes (Beckmann and Spizzichino 1963; Walter et al. 2007), with
/// Smith's shadowing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beckmann {
    /// Roughness along u and v, above 0: √2 times the standard deviation of the slopes.
    alpha: [f64; 2],
    /// One over it.
    inverse: [f64; 2],
    /// `1 / (π α_u α_v)`.
    scale: f64,
}

impl Beckmann {
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

    /// `D(m) = exp(−((m_x/α_u)² + (m_y/α_v)²) / m_z²) / (π α_u α_v m_z⁴)` \[1/sr\]. Zero below the horizon.
    #[must_use]
    pub fn distribution(&self, m: DVec3) -> f64 {
        if m.z <= 0.0 {
            return 0.0;
        }
        let (x, y, z2) = (m.x * self.inverse[0], m.y * self.inverse[1], m.z * m.z);
        let exponent = (x * x + y * y) / z2;
        // Beyond, the exponential is zero before 1/m_z⁴ is infinite; NaN from 0/0 included.
        if exponent < 700.0 { self.scale * libm::exp(-exponent) / (z2 * z2) } else { 0.0 }
    }

    /// `√((α_u v_x)² + (α_v v_y)²) = |v_z| / a`, with `a = 1 / (α tan θ)` as Walter et al. have it.
    fn spread(&self, v: DVec3) -> f64 {
        let (x, y) = (self.alpha[0] * v.x, self.alpha[1] * v.y);
        (x * x + y * y).sqrt()
    }

    /// `G₁(v) / |cos θ_v|` with `G₁ = (3.535 a + 2.181 a²) / (1 + 2.276 a + 2.577 a²)` for `a < 1.6` and one beyond
    /// (Walter et al. 2007, equation 27), within 0.4 % of the exact one. Mitsuba has it too.
    #[must_use]
    pub fn shadowing_over_cos(&self, v: DVec3) -> f64 {
        let (z, r) = (v.z.abs(), self.spread(v));
        if z >= 1.6 * r { 1.0 / z } else { (3.535 * r + 2.181 * z) / (r * r + 2.276 * z * r + 2.577 * z * z) }
    }

    /// Exactly, `G₁(v) / |cos θ_v| = 2 / (|v_z| (1 + erf a) + (|v_z| / a) exp(−a²) / √π)`.
    #[must_use]
    pub fn visibility_over_cos(&self, v: DVec3) -> f64 {
        let (z, r) = (v.z.abs(), self.spread(v));
        let a = z / r;
        2.0 / (z * libm::erfc(-a) + r * libm::exp(-a * a) / SQRT_PI)
    }

    /// A microfacet normal as seen from `v` with `v.z > 0`: for unit roughness, the slopes along and across the view are
    /// independent, with densities `∝ max(0, cos θ − x sin θ) exp(−x²)` and `∝ exp(−y²)` (Heitz and d'Eon 2014).
    #[must_use]
    pub fn sample_visible(&self, v: DVec3, u: [f64; 2]) -> DVec3 {
        let w = DVec3::new(self.alpha[0] * v.x, self.alpha[1] * v.y, v.z).normalize();
        let sine = (w.x * w.x + w.y * w.y).sqrt();
        let (c, s) = if sine > 0.0 { (w.x / sine, w.y / sine) } else { (1.0, 0.0) };
        let along = slope(w.z, sine, u[0]);
        // By symmetry from the lower half, where the inversion takes the fewest steps.
        let across = if u[1] > 0.5 { -slope(1.0, 0.0, 1.0 - u[1]) } else { slope(1.0, 0.0, u[1]) };
        self.of_slopes([c * along - s * across, s * along + c * across])
    }

    /// The normal for slopes along u and v at unit roughness.
    fn of_slopes(&self, [x, y]: [f64; 2]) -> DVec3 {
        DVec3::new(-self.alpha[0] * x, -self.alpha[1] * y, 1.0).normalize()
    }

    /// See [`Microfacets::visible_rule`](super::Microfacets::visible_rule). One half of the slopes across is enough.
    pub(super) fn visible_rule(&self, v: DVec3, rule: &Rule) -> Vec<(DVec3, f64)> {
        let w = DVec3::new(self.alpha[0] * v.x, 0.0, v.z).normalize();
        let slopes = |cos: f64, sin: f64, share: f64| {
            rule.iter().map(|&(u, weight)| (slope(cos, sin, share * u), weight)).collect::<Rule>()
        };
        let (along, across) = (slopes(w.z, w.x, 1.0), slopes(1.0, 0.0, 0.5));
        let pairs = along.iter().flat_map(|&(x, wx)| across.iter().map(move |&(y, wy)| ([x, y], wx * wy)));
        pairs.map(|(slopes, weight)| (self.of_slopes(slopes), weight)).collect()
    }
}

/// The slope at which the cumulative distribution of the density `∝ max(0, cos − x sin) exp(−x²)` is `u`, by Newton's
/// method for the logarithm of its integral, `∝ √π cos erfc(−x) + sin exp(−x²)`.
///
/// The logarithm is concave, because the density's is, so from below the root the steps never pass it. The start is the
/// root for cos = 0, which is below all others because the ratio of the densities rises with x.
fn slope(cos: f64, sin: f64, u: f64) -> f64 {
    let integral = |x: f64| cos * SQRT_PI * libm::erfc(-x) + sin * libm::exp(-x * x);
    // The rim of the unit square: beyond the 2⁻¹⁰⁰ quantile nothing is drawn.
    let u = u.max(8e-31);
    let target = u * integral(cos / sin);
    let mut x = -(-libm::log(u)).sqrt();
    for _ in 0..100 {
        let rise = 2.0 * libm::exp(-x * x) * (cos - x * sin);
        let below = integral(x);
        let step = libm::log(target / below) * below / rise;
        // False also where nothing is left of the density, and for NaN.
        if step > 1e-15 * (1.0 + x.abs()) {
            x += step;
        } else {
            break;
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The integral over the slopes up to the drawn one is `u` of the whole, at all elevations.
    #[test]
    fn slopes_invert_their_distribution() {
        for cos in [1.0_f64, 0.9, 0.3, 1e-3, 1e-9, 0.0] {
            let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
            let whole = |x: f64| cos * SQRT_PI * libm::erfc(-x) + sin * libm::exp(-x * x);
            let end = cos / sin;
            for u in [1e-20, 1e-6, 0.01, 0.3, 0.5, 0.7, 0.99, 1.0 - 1e-9] {
                let x = slope(cos, sin, u);
                let found = whole(x) / whole(end);
                assert!(x <= end && (found / u - 1.0).abs() < 1e-12, "cos {cos}, u {u}: {found} at {x}");
            }
            assert!(slope(cos, sin, 0.0).is_finite() && slope(cos, sin, 1.0_f64.next_down()).is_finite());
        }
    }

    /// `∫ G₁(v) max(0, v·m) D(m) dσ_m = cos θ_v` of the exact one; the rational one is within Walter's bound.
    #[test]
    fn the_rational_shadowing_is_near_the_exact_one() {
        let beckmann = Beckmann::new([0.3, 0.7]);
        for i in 1..1000 {
            let theta = f64::from(i) * 1.5708e-3;
            let (s, c) = libm::sincos(theta);
            let v = DVec3::new(0.6 * s, 0.8 * s, c);
            let ratio = beckmann.shadowing_over_cos(v) / beckmann.visibility_over_cos(v);
            assert!((ratio - 1.0).abs() < 4e-3, "θ {theta}: {ratio}");
        }
    }
}
