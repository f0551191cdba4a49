//! Diffuse surfaces below a smooth coat of glass.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use super::fresnel::{self, Interface};
use super::{BsdfModel, BsdfSample, LobeDensity, Side};
use crate::measure::{Density, ProjectedSolidAngle, SolidAngle};
use crate::spectrum::Rgb;
use crate::warp;

/// What a coat lies on, and the colour of what it reflects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Base {
    /// ρ, the reflectance of the base, 0 … 1.
    pub diffuse: Rgb,
    /// s, the factor of what the coat reflects, 0 … 1.
    pub specular: Rgb,
    /// Light that the coat sends back to the base takes its colour each time.
    pub nonlinear: bool,
}

impl Base {
    /// `ρ / (π (1 − ρ R))`, or `ρ / (π (1 − R))` where the colour is kept, for a share R that the coat sends back \[1/sr\].
    #[inline]
    pub(super) fn scattered(&self, internal_reflectance: f64) -> Rgb {
        self.diffuse.map(|rho| {
            let colour = if self.nonlinear { rho } else { 1.0 };
            rho * FRAC_1_PI / (1.0 - colour * internal_reflectance)
        })
    }

    /// The probabilities of the coat's lobe and of the base's for the shares of the flux that are reflected and that enter,
    /// each weighted by its mean colour. Zero where both are black.
    #[inline]
    pub(super) fn choice(&self, reflected: f64, entering: f64) -> [f64; 2] {
        let (coat, base) = (reflected * self.specular.mean(), entering * self.diffuse.mean());
        let sum = coat + base;
        if sum > 0.0 { [coat / sum, base / sum] } else { [0.0; 2] }
    }
}

/// A diffuse base below a smooth coat, with all that is reflected between them; nothing behind.
///
/// `f_s = s F(θ_o) δ_σ⊥(reflected) + ρ (1 − F(θ_i)) (1 − F(θ_o)) / (π η² (1 − ρ R))` with R the share of diffuse light from
/// below that the coat reflects, and without ρ before R where the colour is kept. Drawn by the share that the coat
/// reflects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plastic {
    interface: Interface,
    base: Base,
    /// `1 / η²`.
    compression: f64,
    /// R.
    internal_reflectance: f64,
}

impl Plastic {
    /// A base below the interface.
    #[must_use]
    pub fn new(interface: Interface, base: Base) -> Self {
        let eta = interface.index(-1.0);
        let internal_reflectance = fresnel::diffuse_reflectance(1.0 / eta);
        Self { interface, base, compression: 1.0 / (eta * eta), internal_reflectance }
    }

    /// The probabilities of coat and base.
    fn choice(&self, from: DVec3) -> [f64; 2] {
        let split = self.interface.fresnel(from.z);
        self.base.choice(split.reflected, split.transmitted)
    }
}

impl BsdfModel for Plastic {
    fn eval(&self, to_emitter: DVec3, to_sensor: DVec3) -> Rgb {
        if !(to_emitter.z > 0.0 && to_sensor.z > 0.0) {
            return Rgb::BLACK;
        }
        let [i, o] = [to_emitter, to_sensor].map(|v| self.interface.fresnel(v.z).transmitted);
        self.base.scattered(self.internal_reflectance) * (self.compression * i * o)
    }

    /// `p_σ = P cos θ / π` \[1/sr\].
    fn density(&self, from: DVec3, to: DVec3) -> Density<SolidAngle> {
        if from.z > 0.0 { warp::cosine_hemisphere_density(to.z) * self.choice(from)[1] } else { Density::ZERO }
    }

    /// s F, from the mean of the two cosines, which differ by rounding only.
    fn eval_dirac(&self, to_emitter: DVec3, to_sensor: DVec3) -> Rgb {
        if to_emitter.z > 0.0 && to_sensor.z > 0.0 {
            self.base.specular * self.interface.fresnel(0.5 * (to_emitter.z + to_sensor.z)).reflected
        } else {
            Rgb::BLACK
        }
    }

    fn density_dirac(&self, _side: Side, from: DVec3, to: DVec3) -> Density<ProjectedSolidAngle> {
        if from.z > 0.0 && to.z > 0.0 { Density::new(self.choice(from)[0]) } else { Density::ZERO }
    }

    fn sample(&self, side: Side, from: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        if from.z <= 0.0 {
            return None;
        }
        if u[2] < self.choice(from)[0] {
            let to = DVec3::new(-from.x, -from.y, from.z);
            let density = LobeDensity::Dirac(self.density_dirac(side, from, to));
            return Some(BsdfSample { to, density, value: self.eval_dirac(to, from) });
        }
        let to = warp::cosine_hemisphere([u[0], u[1]]);
        let density = self.density(from, to);
        let (to_emitter, to_sensor) = side.by_role(from, to);
        let value = self.eval(to_emitter, to_sensor);
        // The rim of the disk, u = 0, has density zero.
        (density.value() > 0.0).then_some(BsdfSample { to, density: LobeDensity::Finite(density), value })
    }

    fn has_dirac(&self) -> bool {
        true
    }

    fn is_glossy(&self) -> bool {
        false
    }
}
