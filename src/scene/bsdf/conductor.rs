//! Metals, smooth and rough.

use glam::DVec3;

use super::microfacet::{Distribution, Microfacets, of_either};
use super::{BsdfModel, BsdfSample, LobeDensity, Side, fresnel};
use crate::measure::{Density, ProjectedSolidAngle, SolidAngle};
use crate::scene::description::ConductorFresnel;
use crate::spectrum::Rgb;

/// A mirror: `f_s = r F(cos θ) δ_σ⊥(to_emitter − reflected(to_sensor))` in front, nothing behind.
#[derive(Clone, Debug, PartialEq)]
pub struct Conductor {
    /// What reflects how much.
    pub fresnel: ConductorFresnel,
    /// r, a factor of it, 0 … 1.
    pub reflectance: Rgb,
}

impl BsdfModel for Conductor {
    fn eval(&self, _to_emitter: DVec3, _to_sensor: DVec3) -> Rgb {
        Rgb::BLACK
    }

    fn density(&self, _from: DVec3, _to: DVec3) -> Density<SolidAngle> {
        Density::ZERO
    }

    /// r F, from the mean of the two cosines, which differ by rounding only.
    fn eval_dirac(&self, to_emitter: DVec3, to_sensor: DVec3) -> Rgb {
        if to_emitter.z > 0.0 && to_sensor.z > 0.0 {
            fresnel::conductor(&self.fresnel, 0.5 * (to_emitter.z + to_sensor.z)) * self.reflectance
        } else {
            Rgb::BLACK
        }
    }

    fn density_dirac(&self, _side: Side, from: DVec3, to: DVec3) -> Density<ProjectedSolidAngle> {
        if from.z > 0.0 && to.z > 0.0 { Density::new(1.0) } else { Density::ZERO }
    }

    fn sample(&self, _side: Side, from: DVec3, _u: [f64; 3]) -> Option<BsdfSample> {
        (from.z > 0.0).then(|| BsdfSample {
            to: DVec3::new(-from.x, -from.y, from.z),
            density: LobeDensity::Dirac(Density::new(1.0)),
            value: fresnel::conductor(&self.fresnel, from.z) * self.reflectance,
        })
    }

    fn has_finite(&self) -> bool {
        false
    }
}

/// Metal with microfacets and single scattering, drawn by visible normals; nothing behind (Walter et al. 2007).
///
/// `f_s = r F(i·h) D(h) G₁(i) G₁(o) / (4 cos θ_i cos θ_o)`. The half vector h of two rounded directions is off by about
/// 2⁻⁵³ / cos(i,h), so D has a relative error of about 1e-16 / (α cos(i,h)): it matters where α cos(i,h) < 1e-12. Samples
/// are weighed by the directions they return, so value and density agree there too.
#[derive(Clone, Debug, PartialEq)]
pub struct RoughConductor {
    /// The microfacets.
    pub distribution: Microfacets,
    /// What reflects how much.
    pub fresnel: ConductorFresnel,
    /// r, a factor of it, 0 … 1.
    pub reflectance: Rgb,
}

/// `(D(h)/4, i·h)`, `None` where nothing is reflected.
#[inline(always)]
fn half_vector(distribution: &impl Distribution, a: DVec3, b: DVec3) -> Option<(f64, f64)> {
    if !(a.z > 0.0 && b.z > 0.0) {
        return None;
    }
    let sum = a + b;
    let length = sum.length();
    // |a + b| = 2 a·h for unit vectors. Below the threshold the squares in D would underflow.
    (length > 1e-30).then(|| (0.25 * distribution.distribution(sum / length), 0.5 * length))
}

impl RoughConductor {
    #[inline(always)]
    fn eval_by(&self, distribution: &impl Distribution, a: DVec3, b: DVec3) -> Rgb {
        let Some((d, cos)) = half_vector(distribution, a, b) else { return Rgb::BLACK };
        let g = distribution.shadowing_over_cos(a) * distribution.shadowing_over_cos(b);
        fresnel::conductor(&self.fresnel, cos) * self.reflectance * (d * g)
    }

    #[inline(always)]
    fn sample_by(&self, distribution: &impl Distribution, from: DVec3, u: [f64; 2]) -> Option<BsdfSample> {
        let m = distribution.sample_visible(from, u);
        let to = m * (2.0 * from.dot(m)) - from;
        let (d, cos) = half_vector(distribution, from, to)?;
        let (g_from, g_to) = (distribution.shadowing_over_cos(from), distribution.shadowing_over_cos(to));
        let density = d * distribution.visibility_over_cos(from);
        let value = fresnel::conductor(&self.fresnel, cos) * self.reflectance * (d * (g_from * g_to));
        (density > 0.0).then_some(BsdfSample { to, density: LobeDensity::Finite(Density::new(density)), value })
    }
}

impl BsdfModel for RoughConductor {
    fn eval(&self, to_emitter: DVec3, to_sensor: DVec3) -> Rgb {
        of_either!(&self.distribution, distribution => self.eval_by(distribution, to_emitter, to_sensor))
    }

    /// `p_σ = D_v(h) / (4 i·h) = G₁(from) D(h) / (4 cos θ_from)` \[1/sr\].
    fn density(&self, from: DVec3, to: DVec3) -> Density<SolidAngle> {
        of_either!(&self.distribution, distribution => match half_vector(distribution, from, to) {
            Some((d, _)) => Density::new(d * distribution.visibility_over_cos(from)),
            None => Density::ZERO,
        })
    }

    fn sample(&self, _side: Side, from: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        if from.z <= 0.0 {
            return None;
        }
        of_either!(&self.distribution, distribution => self.sample_by(distribution, from, [u[0], u[1]]))
    }

    fn is_anisotropic(&self) -> bool {
        self.distribution.is_anisotropic()
    }
}
