//! Diffuse surfaces below a rough coat of glass.

use std::sync::Arc;

use glam::DVec3;

use super::fresnel::Interface;
use super::microfacet::Microfacets;
use super::plastic::Base;
use super::{BsdfModel, BsdfSample, LobeDensity, Side};
use crate::measure::{Density, SolidAngle};
use crate::quadrature::gauss_legendre;
use crate::spectrum::Rgb;
use crate::warp;

/// Number of angles for which the transmittance of a coat is tabulated: Mitsuba's, so that both interpolate alike.
const ANGLES: usize = 64;

/// Number of nodes of Gauss's rule along each dimension of the microfacets' unit square: T is within 2e-5 and R, which the
/// critical angle of total reflection makes less smooth, within some 1e-4.
const NODES: u32 = 64;

/// A rough coat, and how much of the flux it lets through.
#[derive(Clone, Debug, PartialEq)]
pub struct RoughCoat {
    distribution: Microfacets,
    interface: Interface,
    /// T at cosines from 0 to 1.
    transmittance: [f64; ANGLES],
    /// R, as the mean of `2 cos θ R(θ)` over the same cosines.
    internal_reflectance: f64,
}

impl RoughCoat {
    /// Integrates over the microfacets, which takes some tens of milliseconds.
    #[must_use]
    pub fn new(distribution: Microfacets, interface: Interface) -> Self {
        let rule = gauss_legendre(NODES);
        let (mut transmittance, mut internal_reflectance) = ([0.0; ANGLES], 0.0);
        for (i, transmitted) in transmittance.iter_mut().enumerate() {
            let cos = (i as f64 / (ANGLES - 1) as f64).max(1e-6);
            let from = DVec3::new(((1.0 - cos) * (1.0 + cos)).sqrt(), 0.0, cos);
            let normals = distribution.visible_rule(from, &rule);
            *transmitted = passing(&distribution, &interface, &normals, from, false);
            // From below the opposite direction sees the same microfacets.
            internal_reflectance += 2.0 * cos * passing(&distribution, &interface, &normals, -from, true);
        }
        Self { distribution, interface, transmittance, internal_reflectance: internal_reflectance / ANGLES as f64 }
    }

    /// T by linear interpolation.
    #[inline]
    fn transmittance(&self, cos: f64) -> f64 {
        let x = cos * (ANGLES - 1) as f64;
        let i = (x as usize).min(ANGLES - 2);
        let (low, high) = (self.transmittance[i], self.transmittance[i + 1]);
        low + (high - low) * (x - i as f64)
    }
}

/// The share of the flux from a direction that the rough interface reflects, or lets through, by single scattering:
/// `∫ D_v(m) F(v·m) G₁(to) dσ_m`, or the same of `1 − F`, over the visible microfacets.
fn passing(
    distribution: &Microfacets,
    interface: &Interface,
    normals: &[(DVec3, f64)],
    from: DVec3,
    reflected: bool,
) -> f64 {
    let share = |m: DVec3| {
        let cos = from.dot(m);
        let split = interface.fresnel(cos);
        let to = if reflected { Some(m * (2.0 * cos) - from) } else { interface.refract(from, m, cos) };
        let to = to.filter(|to| (to.z * from.z > 0.0) == reflected)?;
        let share = if reflected { split.reflected } else { split.transmitted };
        Some(share * distribution.shadowing_over_cos(to) * to.z.abs())
    };
    normals.iter().map(|&(m, weight)| weight * share(m).unwrap_or(0.0)).sum()
}

/// A diffuse base below a rough coat: microfacets that reflect, and what enters, scatters and leaves; nothing behind.
///
/// `f_s = s F(i·h) D(h) G₁(i) G₁(o) / (4 cos θ_i cos θ_o) + ρ T(θ_i) T(θ_o) / (π η² (1 − ρ R))`, without ρ before R where the
/// colour is kept. Mitsuba's `roughplastic`.
#[derive(Clone, Debug, PartialEq)]
pub struct RoughPlastic {
    pub(super) coat: Arc<RoughCoat>,
    pub(super) base: Base,
}

impl RoughPlastic {
    /// A base below the coat.
    #[must_use]
    pub fn new(coat: Arc<RoughCoat>, base: Base) -> Self {
        Self { coat, base }
    }

    #[inline]
    fn borrowed(&self) -> RoughPlasticAt<'_> {
        RoughPlasticAt { coat: &self.coat, base: self.base }
    }
}

/// The same with the colours of one point: the coat is shared, and counting its owners would cost more than its use.
#[derive(Clone, Copy, Debug)]
pub(super) struct RoughPlasticAt<'a> {
    pub(super) coat: &'a RoughCoat,
    pub(super) base: Base,
}

impl RoughPlasticAt<'_> {
    /// `(D(h)/4, i·h)`, `None` where nothing is reflected.
    fn half_vector(&self, a: DVec3, b: DVec3) -> Option<(f64, f64)> {
        if !(a.z > 0.0 && b.z > 0.0) {
            return None;
        }
        let sum = a + b;
        let length = sum.length();
        // |a + b| = 2 a·h for unit vectors. Below the threshold the squares in D would underflow.
        (length > 1e-30).then(|| (0.25 * self.coat.distribution.distribution(sum / length), 0.5 * length))
    }

    /// The probabilities of coat and base.
    fn choice(&self, from: DVec3) -> [f64; 2] {
        let entering = self.coat.transmittance(from.z);
        self.base.choice((1.0 - entering).max(0.0), entering)
    }
}

impl BsdfModel for RoughPlasticAt<'_> {
    fn eval(&self, to_emitter: DVec3, to_sensor: DVec3) -> Rgb {
        let Some((d, cos)) = self.half_vector(to_emitter, to_sensor) else { return Rgb::BLACK };
        let RoughCoat { distribution, interface, .. } = self.coat;
        let g = distribution.shadowing_over_cos(to_emitter) * distribution.shadowing_over_cos(to_sensor);
        let [i, o] = [to_emitter, to_sensor].map(|v| self.coat.transmittance(v.z));
        let eta = interface.index(-1.0);
        self.base.specular * (interface.fresnel(cos).reflected * (d * g))
            + self.base.scattered(self.coat.internal_reflectance) * (i * o / (eta * eta))
    }

    /// `p_σ = P G₁(from) D(h) / (4 cos θ_from) + (1 − P) cos θ / π` \[1/sr\].
    fn density(&self, from: DVec3, to: DVec3) -> Density<SolidAngle> {
        let Some((d, _)) = self.half_vector(from, to) else { return Density::ZERO };
        let [coat, base] = self.choice(from);
        let reflected = d * self.coat.distribution.visibility_over_cos(from);
        Density::new(coat * reflected + base * warp::cosine_hemisphere_density(to.z).value())
    }

    fn sample(&self, side: Side, from: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        if from.z <= 0.0 {
            return None;
        }
        let to = if u[2] < self.choice(from)[0] {
            let m = self.coat.distribution.sample_visible(from, [u[0], u[1]]);
            m * (2.0 * from.dot(m)) - from
        } else {
            warp::cosine_hemisphere([u[0], u[1]])
        };
        let density = self.density(from, to);
        let (to_emitter, to_sensor) = side.by_role(from, to);
        let value = self.eval(to_emitter, to_sensor);
        (density.value() > 0.0).then_some(BsdfSample { to, density: LobeDensity::Finite(density), value })
    }
}

impl BsdfModel for RoughPlastic {
    fn eval(&self, to_emitter: DVec3, to_sensor: DVec3) -> Rgb {
        self.borrowed().eval(to_emitter, to_sensor)
    }

    fn density(&self, from: DVec3, to: DVec3) -> Density<SolidAngle> {
        self.borrowed().density(from, to)
    }

    fn sample(&self, side: Side, from: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        self.borrowed().sample(side, from, u)
    }
}
