//! Lambert's model.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use super::{BsdfModel, BsdfSample, LobeDensity, Side};
use crate::measure::{Density, SolidAngle};
use crate::spectrum::Rgb;
use crate::warp;

/// `f_s = reflectance / π` where both directions are in front, drawn in proportion to the cosine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Diffuse {
    /// Share of the flux that is reflected, 0 … 1.
    pub reflectance: Rgb,
}

impl BsdfModel for Diffuse {
    #[inline(always)]
    fn eval(&self, to_emitter: DVec3, to_sensor: DVec3) -> Rgb {
        if to_emitter.z > 0.0 && to_sensor.z > 0.0 { self.reflectance * FRAC_1_PI } else { Rgb::BLACK }
    }

    /// `p_σ = cos θ / π` \[1/sr\].
    #[inline(always)]
    fn density(&self, from: DVec3, to: DVec3) -> Density<SolidAngle> {
        if from.z > 0.0 { warp::cosine_hemisphere_density(to.z) } else { Density::ZERO }
    }

    #[inline(always)]
    fn sample(&self, _side: Side, from: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        let to = warp::cosine_hemisphere([u[0], u[1]]);
        // The rim of the disk, u = 0, has density zero.
        (from.z > 0.0 && to.z > 0.0).then(|| BsdfSample {
            to,
            density: LobeDensity::Finite(warp::cosine_hemisphere_density(to.z)),
            value: self.reflectance * FRAC_1_PI,
        })
    }

    fn is_glossy(&self) -> bool {
        false
    }
}
