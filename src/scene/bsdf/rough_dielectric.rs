//! Rough glass.

use glam::DVec3;

use super::dielectric::Tints;
use super::fresnel::Interface;
use super::microfacet::{Distribution, Microfacets, of_either};
use super::{BsdfModel, BsdfSample, LobeDensity, Side};
use crate::measure::{Density, SolidAngle};
use crate::spectrum::Rgb;

/// An interface of dielectrics with microfacets and single scattering (Walter et al. 2007), drawn by visible normals
/// and then by F of the drawn one.
///
/// Reflection: `f_s = r F(i·h) D(h) G₁(i) G₁(o) / (4 |cos θ_i cos θ_o|)`. Refraction:
/// `f_s = t η_o² |i·h| |o·h| (1 − F) D(h) G₁(i) G₁(o) / (|cos θ_i cos θ_o| ‖η_i i + η_o o‖²)`, h along `η_i i + η_o o`.
///
/// Rounded directions put a relative error of about 1e-16 / (α cos(i,h)) into D of a reflection and of about
/// 1e-16 / (α |η − 1|) into that of a refraction. Samples are weighed by the directions they return, so value and density
/// agree nevertheless; [`Bsdf::new`](super::Bsdf::new) makes an interface smooth whose refracted lobe is too narrow for
/// double precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughDielectric {
    /// The microfacets.
    pub distribution: Microfacets,
    /// The two indices of refraction.
    pub interface: Interface,
    /// The factors r and t, 0 … 1.
    pub tints: Tints,
}

impl RoughDielectric {
    /// What value and density share: `F D / 4` or `|a·h| |b·h| (1 − F) D / ‖η_a a + η_b b‖²`, symmetric in a and b.
    #[inline(always)]
    fn core(&self, distribution: &impl Distribution, a: DVec3, b: DVec3) -> f64 {
        let across = a.z * b.z;
        if across > 0.0 {
            let sum = a + b;
            let length = sum.length();
            if length < 1e-30 {
                return 0.0;
            }
            let h = sum / length.copysign(sum.z);
            // a·h = |a + b| / 2 for unit vectors.
            let f = self.interface.fresnel((0.5 * length).copysign(a.z)).reflected;
            0.25 * f * distribution.distribution(h)
        } else if across < 0.0 {
            let inside = if a.z < 0.0 { a } else { b };
            // η_a a + η_b b as a difference of directions, so that little cancels where the indices are alike.
            let sum = (a + b) + inside * self.interface.contrast();
            let length = sum.length();
            if length < 1e-30 {
                return 0.0;
            }
            let h = sum / length.copysign(sum.z);
            let (ah, bh) = (a.dot(h), b.dot(h));
            // Each direction sees the microfacet from the side on which it sees the surface.
            if ah * a.z <= 0.0 || bh * b.z <= 0.0 {
                return 0.0;
            }
            let t = self.interface.transmittance(ah, bh);
            t * distribution.distribution(h) * ((ah * bh).abs() / (length * length))
        } else {
            0.0
        }
    }

    /// `η²` on the side of `v`, one for the pairs of a reflection.
    #[inline]
    fn index_squared(&self, v: DVec3, other: DVec3) -> f64 {
        if v.z * other.z > 0.0 {
            return 1.0;
        }
        let index = self.interface.index(v.z);
        index * index
    }

    #[inline(always)]
    fn eval_by(&self, distribution: &impl Distribution, to_emitter: DVec3, to_sensor: DVec3) -> Rgb {
        let g = distribution.shadowing_over_cos(to_emitter) * distribution.shadowing_over_cos(to_sensor);
        let core = self.core(distribution, to_emitter, to_sensor);
        self.tints.of(to_emitter, to_sensor) * (core * self.index_squared(to_sensor, to_emitter) * g)
    }

    #[inline(always)]
    fn sample_by(&self, distribution: &impl Distribution, side: Side, from: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        let upright = if from.z > 0.0 { from } else { -from };
        let m = distribution.sample_visible(upright, [u[0], u[1]]);
        let cos = from.dot(m);
        let reflects = u[2] < self.interface.fresnel(cos).reflected;
        let to = if reflects { m * (2.0 * cos) - from } else { self.interface.refract(from, m, cos)? };
        // Single scattering: what leaves the microfacet towards the wrong side of the surface is lost.
        if (to.z * from.z > 0.0) != reflects {
            return None;
        }
        let core = self.core(distribution, from, to);
        let (g_from, g_to) = (distribution.shadowing_over_cos(from), distribution.shadowing_over_cos(to));
        let density = core * (self.index_squared(to, from) * distribution.visibility_over_cos(from));
        let (to_emitter, to_sensor) = side.by_role(from, to);
        let value = self.tints.of(from, to) * (core * self.index_squared(to_sensor, to_emitter) * (g_from * g_to));
        (density > 0.0).then_some(BsdfSample { to, density: LobeDensity::Finite(Density::new(density)), value })
    }
}

impl BsdfModel for RoughDielectric {
    fn eval(&self, to_emitter: DVec3, to_sensor: DVec3) -> Rgb {
        of_either!(&self.distribution, distribution => self.eval_by(distribution, to_emitter, to_sensor))
    }

    /// `p_σ = P D_v(h) dσ_h/dσ_to`, with P = F and `dσ_h/dσ_to = 1 / (4 |to·h|)` for reflection, P = 1 − F and
    /// `η_to² |to·h| / ‖η_i i + η_o o‖²` for refraction \[1/sr\].
    fn density(&self, from: DVec3, to: DVec3) -> Density<SolidAngle> {
        Density::new(of_either!(&self.distribution, distribution => {
            let scale = self.index_squared(to, from) * distribution.visibility_over_cos(from);
            self.core(distribution, from, to) * scale
        }))
    }

    fn sample(&self, side: Side, from: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        if from.z == 0.0 {
            return None;
        }
        of_either!(&self.distribution, distribution => self.sample_by(distribution, side, from, u))
    }

    fn radiance_scale(&self, to_emitter: DVec3, to_sensor: DVec3) -> f64 {
        self.interface.radiance_scale(to_emitter.z, to_sensor.z)
    }

    fn transmits(&self) -> bool {
        true
    }

    fn is_anisotropic(&self) -> bool {
        self.distribution.is_anisotropic()
    }
}
