//! Closed forms and quadratures that the truths of cases are made of, written without the renderer's own code.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use crate::quadrature::gauss_legendre;
use crate::scene::description::{Projection, SensorDescription};

/// `∫∫ f / 4` over `[−1, 1]²`, by n × n nodes.
pub(super) fn square_mean(n: u32, f: impl Fn(DVec2) -> f64) -> f64 {
    let rule = gauss_legendre(n);
    let column = |&(x, wx): &(f64, f64)| {
        let row = |&(y, wy): &(f64, f64)| wx * wy * f(DVec2::new(2.0 * x - 1.0, 2.0 * y - 1.0));
        rule.iter().map(row).sum::<f64>()
    };
    rule.iter().map(column).sum()
}

/// The mean over a pinhole camera's image of the radiance that arrives against a direction.
pub(super) fn image_mean(camera: &SensorDescription, aspect: f64, radiance: impl Fn(DVec3) -> f64) -> f64 {
    let Projection::Perspective { vertical_fov, .. } = camera.projection else { return f64::NAN };
    let up = camera.up * libm::tan(0.5 * vertical_fov);
    let right = camera.forward.cross(camera.up) * (libm::tan(0.5 * vertical_fov) * aspect);
    square_mean(10, |at| radiance((camera.forward + right * at.x + up * at.y).normalize()))
}

/// `F(cos θ)` of a dielectric of relative index η, unpolarised (Fresnel); 1 where nothing is refracted.
pub(super) fn fresnel_dielectric(cosine: f64, eta: f64) -> f64 {
    let sine2 = (1.0 - cosine * cosine) / (eta * eta);
    if sine2 >= 1.0 || cosine <= 0.0 {
        return 1.0;
    }
    let refracted = (1.0 - sine2).sqrt();
    let s = (cosine - eta * refracted) / (cosine + eta * refracted);
    let p = (eta * cosine - refracted) / (eta * cosine + refracted);
    0.5 * (s * s + p * p)
}

/// `F(cos θ)` of a conductor of index η + ik, unpolarised, by complex numbers.
pub(super) fn fresnel_conductor(cosine: f64, eta: f64, k: f64) -> f64 {
    use nalgebra::Complex;
    let index = Complex::new(eta, k);
    let one = Complex::new(1.0, 0.0);
    // Of the refracted direction: its cosine by Snell's law, on the branch that decays inwards.
    let refracted = (one - (one - one * (cosine * cosine)) / (index * index)).sqrt();
    let s = (one * cosine - index * refracted) / (one * cosine + index * refracted);
    let p = (index * cosine - refracted) / (index * cosine + refracted);
    0.5 * (s.norm_sqr() + p.norm_sqr())
}

/// Rough interfaces of GGX microfacets with separable masking, in a constant environment of radiance one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Microfacets {
    /// Roughness along x and y.
    pub alpha: DVec2,
}

impl Microfacets {
    /// Smith's masking `G₁(v) = 2 / (1 + √(1 + (α_x² v_x² + α_y² v_y²)/v_z²))`; zero below the surface.
    fn masking(self, v: DVec3, side: f64) -> f64 {
        if v.z * side <= 0.0 {
            return 0.0;
        }
        let slope = (self.alpha * v.truncate()).length_squared() / (v.z * v.z);
        2.0 / (1.0 + (1.0 + slope).sqrt())
    }

    /// `G₁(o)/cos θ_o ∫ (o·h)⁺/cos θ_h · g(h) · D(h) cos θ_h dh`, where g is the masked light by way of the facets of normal h.
    fn facets(self, o: DVec3, g: impl Fn(DVec3) -> f64) -> f64 {
        const TURNS: u32 = 96;
        let rule = gauss_legendre(96);
        let at = |u: f64, turn: f64| {
            let radius = (u / (1.0 - u)).sqrt();
            let slopes = self.alpha * DVec2::new(libm::cos(turn), libm::sin(turn)) * radius;
            let h = DVec3::new(slopes.x, slopes.y, 1.0).normalize();
            o.dot(h).max(0.0) / h.z * g(h)
        };
        let ring = |u: f64| {
            let turns = (0..TURNS).map(|i| at(u, 2.0 * PI * (f64::from(i) + 0.5) / f64::from(TURNS)));
            turns.sum::<f64>() / f64::from(TURNS)
        };
        // By u = 1 − v²: rings towards the horizon grow as 1/√(1 − u).
        self.masking(o, 1.0) / o.z * rule.iter().map(|&(v, w)| w * 2.0 * v * ring(1.0 - v * v)).sum::<f64>()
    }

    /// What a perfect mirror's facets reflect to `o`.
    pub fn mirror(self, o: DVec3) -> f64 {
        self.facets(o, |h| self.masking(h * (2.0 * o.dot(h)) - o, 1.0))
    }

    /// What facets of glass of relative index η reflect and refract to `o`, which is outside: refracted radiance by 1/η².
    pub fn glass(self, o: DVec3, eta: f64) -> f64 {
        self.facets(o, |h| {
            let cosine = o.dot(h);
            let fresnel = fresnel_dielectric(cosine, eta);
            let reflected = h * (2.0 * cosine) - o;
            let inside = (1.0 - (1.0 - cosine * cosine) / (eta * eta)).max(0.0).sqrt();
            let refracted = (h * cosine - o) / eta - h * inside;
            fresnel * self.masking(reflected, 1.0) + (1.0 - fresnel) * self.masking(refracted, -1.0) / (eta * eta)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smooth_limits_are_met() {
        let o = DVec3::new(0.6, 0.0, 0.8);
        let smooth = Microfacets { alpha: DVec2::splat(1e-9) };
        assert!((smooth.mirror(o) - 1.0).abs() < 1e-9);
        let fresnel = fresnel_dielectric(0.8, 1.5);
        assert!((smooth.glass(o, 1.5) - fresnel - (1.0 - fresnel) / 2.25).abs() < 1e-9);
        assert!((smooth.glass(o, 1.0) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn a_conductor_without_absorption_is_a_dielectric() {
        for cosine in [1.0, 0.7, 0.1] {
            let difference = fresnel_conductor(cosine, 1.5, 0.0) - fresnel_dielectric(cosine, 1.5);
            assert!(difference.abs() < 1e-14, "{cosine}: {difference:e}");
        }
        // Silver-like: (η − 1)² + k² over (η + 1)² + k² along the normal.
        assert!((fresnel_conductor(1.0, 0.2, 3.0) - 9.64 / 10.44).abs() < 1e-14);
    }

    /// At α = 1 and along the normal the facets of `u < ½` reflect upwards, by cos θ = 1 − 2u: ∫ (1 − 2u)/(1 − u) du = 1 − ln 2.
    #[test]
    fn rough_facets_lose_light() {
        let error = Microfacets { alpha: DVec2::ONE }.mirror(DVec3::Z) - (1.0 - std::f64::consts::LN_2);
        assert!(error.abs() < 1e-4, "{error:e}");
    }

    #[test]
    fn means_over_squares() {
        assert!((square_mean(8, |p| p.x * p.x + 3.0 * p.y) - 1.0 / 3.0).abs() < 1e-14);
    }
}
