//! Panes of glass.

use glam::DVec3;

use super::dielectric::Tints;
use super::fresnel::{Interface, Split};
use super::{BsdfModel, BsdfSample, LobeDensity, Side, opposite};
use crate::measure::{Density, ProjectedSolidAngle, SolidAngle};
use crate::spectrum::Rgb;

/// A thin pane of smooth glass, with what is reflected between its two interfaces:
/// `f_s = r R δ_σ⊥(reflected) + t (1 − R) δ_σ⊥(opposite)` with `R = F + (1 − F)² F (1 + F² + …) = 2F / (1 + F)`, drawn by R.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinDielectric {
    /// The indices of refraction of the pane and around it.
    pub interface: Interface,
    /// The factors r and t, 0 … 1.
    pub tints: Tints,
}

impl ThinDielectric {
    /// R and 1 − R for light from either side.
    #[inline]
    fn split(&self, cos: f64) -> Split {
        let f = self.interface.fresnel(cos.abs());
        let rest = 1.0 / (1.0 + f.reflected);
        Split { reflected: 2.0 * f.reflected * rest, transmitted: f.transmitted * rest }
    }

    /// The share of the flux that goes from one direction to the other.
    #[inline]
    fn share(&self, a: DVec3, b: DVec3) -> f64 {
        if a.z * b.z > 0.0 {
            // The cosines differ by rounding only; their mean is the same for either direction of the walk.
            self.split(0.5 * (a.z + b.z)).reflected
        } else if a.z * b.z < 0.0 && opposite(a, b) {
            self.split(0.5 * (a.z - b.z)).transmitted
        } else {
            0.0
        }
    }
}

impl BsdfModel for ThinDielectric {
    fn eval(&self, _to_emitter: DVec3, _to_sensor: DVec3) -> Rgb {
        Rgb::BLACK
    }

    fn density(&self, _from: DVec3, _to: DVec3) -> Density<SolidAngle> {
        Density::ZERO
    }

    fn eval_dirac(&self, to_emitter: DVec3, to_sensor: DVec3) -> Rgb {
        self.tints.of(to_emitter, to_sensor) * self.share(to_emitter, to_sensor)
    }

    fn density_dirac(&self, _side: Side, from: DVec3, to: DVec3) -> Density<ProjectedSolidAngle> {
        Density::new(self.share(from, to))
    }

    fn sample(&self, _side: Side, from: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        if from.z == 0.0 {
            return None;
        }
        let reflects = u[2] < self.split(from.z).reflected;
        let to = if reflects { DVec3::new(-from.x, -from.y, from.z) } else { -from };
        let share = self.share(from, to);
        let value = self.tints.of(from, to) * share;
        (share > 0.0).then_some(BsdfSample { to, density: LobeDensity::Dirac(Density::new(share)), value })
    }

    fn has_finite(&self) -> bool {
        false
    }

    fn transmits(&self) -> bool {
        true
    }

    fn bends(&self) -> bool {
        false
    }
}
