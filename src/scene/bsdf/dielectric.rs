//! Smooth glass.

use glam::DVec3;

use super::fresnel::Interface;
use super::{BsdfModel, BsdfSample, LobeDensity, Side};
use crate::measure::{Density, ProjectedSolidAngle, SolidAngle};
use crate::spectrum::Rgb;

/// A smooth interface of dielectrics: `f_s = r F δ_σ⊥(reflected) + t (1 − F) (η_o/η_i)² δ_σ⊥(refracted)`, drawn by F.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    /// The two indices of refraction.
    pub interface: Interface,
    /// The factors r and t, 0 … 1.
    pub tints: Tints,
}

/// Factors of what an interface reflects and transmits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tints {
    /// Of what stays on its side.
    pub reflectance: Rgb,
    /// Of what changes it.
    pub transmittance: Rgb,
}

impl Tints {
    /// None.
    pub const WHITE: Self = Self { reflectance: Rgb::WHITE, transmittance: Rgb::WHITE };

    /// The factor for a pair of directions.
    #[must_use]
    #[inline]
    pub fn of(&self, a: DVec3, b: DVec3) -> Rgb {
        if a.z * b.z > 0.0 { self.reflectance } else { self.transmittance }
    }
}

impl Dielectric {
    /// `(P, (η_o/η_i)²)`: the share of the flux that goes from one direction to the other, and its radiance scale.
    #[inline]
    fn lobe(&self, to_emitter: DVec3, to_sensor: DVec3) -> (f64, f64) {
        let (i, o) = (to_emitter.z, to_sensor.z);
        if i * o > 0.0 {
            // The cosines differ by rounding only; their mean is the same for either direction of the walk.
            (self.interface.fresnel(0.5 * (i + o)).reflected, 1.0)
        } else if i * o < 0.0 {
            (self.interface.transmittance(i, o), self.interface.radiance_scale(i, o))
        } else {
            (0.0, 1.0)
        }
    }

    /// The coefficient of a walk that takes a lobe with probability `share`, as [`LobeDensity::Dirac`] defines it.
    fn density_of(side: Side, share: f64, scale: f64) -> Density<ProjectedSolidAngle> {
        Density::new(match side {
            Side::Sensor => share,
            Side::Emitter => share * scale,
        })
    }
}

impl BsdfModel for Dielectric {
    fn eval(&self, _to_emitter: DVec3, _to_sensor: DVec3) -> Rgb {
        Rgb::BLACK
    }

    fn density(&self, _from: DVec3, _to: DVec3) -> Density<SolidAngle> {
        Density::ZERO
    }

    fn eval_dirac(&self, to_emitter: DVec3, to_sensor: DVec3) -> Rgb {
        let (share, scale) = self.lobe(to_emitter, to_sensor);
        self.tints.of(to_emitter, to_sensor) * (share * scale)
    }

    fn density_dirac(&self, side: Side, from: DVec3, to: DVec3) -> Density<ProjectedSolidAngle> {
        let (to_emitter, to_sensor) = side.by_role(from, to);
        let (share, scale) = self.lobe(to_emitter, to_sensor);
        Self::density_of(side, share, scale)
    }

    fn sample(&self, side: Side, from: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        if from.z == 0.0 {
            return None;
        }
        let to = if u[2] < self.interface.fresnel(from.z).reflected {
            DVec3::new(-from.x, -from.y, from.z)
        } else {
            let to = self.interface.refract(from, DVec3::Z, from.z)?;
            if to.z * from.z >= 0.0 {
                return None;
            }
            to
        };
        let (to_emitter, to_sensor) = side.by_role(from, to);
        let (share, scale) = self.lobe(to_emitter, to_sensor);
        let density = Self::density_of(side, share, scale);
        let value = self.tints.of(from, to) * (share * scale);
        (share > 0.0).then_some(BsdfSample { to, density: LobeDensity::Dirac(density), value })
    }

    fn radiance_scale(&self, to_emitter: DVec3, to_sensor: DVec3) -> f64 {
        self.interface.radiance_scale(to_emitter.z, to_sensor.z)
    }

    fn has_finite(&self) -> bool {
        false
    }

    fn transmits(&self) -> bool {
        true
    }
}
