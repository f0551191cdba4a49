//! Lights that shine from one point: Dirac in x_0.

use std::f64::consts::PI;

use glam::DVec3;

use crate::geometry::Frame;
use crate::measure::Density;
use crate::spectrum::Rgb;
use crate::warp;

use super::{DirectSample, EdgeDensity, EmissionSample, EmitterId, point_vertex};

/// Shines equally in all directions.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Its own id.
    pub id: EmitterId,
    /// Where \[m\].
    pub position: DVec3,
    /// Intensity \[W/sr\].
    pub intensity: Rgb,
}

impl Point {
    pub(super) fn sample_emission(&self, u: [f64; 5]) -> EmissionSample {
        EmissionSample { vertex: point_vertex(self.id, self.position), direction: warp::uniform_sphere([u[3], u[4]]) }
    }

    pub(super) fn emission_density() -> EdgeDensity {
        EdgeDensity { position: Density::new(1.0), direction: warp::UNIFORM_SPHERE_DENSITY }
    }

    pub(super) fn sample_direct(&self) -> DirectSample {
        DirectSample { vertex: point_vertex(self.id, self.position), density: Density::new(1.0) }
    }

    /// `4π I`.
    pub(super) fn flux(&self) -> Rgb {
        self.intensity * (4.0 * PI)
    }
}

/// Shines into a cone: full intensity up to the inner angle, then linear in the angle down to zero at the outer one.
#[derive(Clone, Copy, Debug)]
pub struct Spot {
    id: EmitterId,
    position: DVec3,
    frame: Frame,
    intensity: Rgb,
    inner_angle: f64,
    outer_angle: f64,
    one_minus_cos_outer: f64,
}

impl Spot {
    /// A spot light at `position` along the unit vector `axis`; angles from the axis in radians.
    #[must_use]
    pub fn new(
        id: EmitterId,
        position: DVec3,
        axis: DVec3,
        intensity: Rgb,
        inner_angle: f64,
        outer_angle: f64,
    ) -> Self {
        let half = libm::sin(0.5 * outer_angle);
        let one_minus_cos_outer = 2.0 * half * half;
        Self { id, position, frame: Frame::around(axis), intensity, inner_angle, outer_angle, one_minus_cos_outer }
    }

    /// Intensity along a unit direction \[W/sr\].
    #[must_use]
    pub fn intensity(&self, direction: DVec3) -> Rgb {
        let angle = self.angle(direction);
        if angle <= self.inner_angle {
            self.intensity
        } else if angle >= self.outer_angle {
            Rgb::BLACK
        } else {
            self.intensity * ((self.outer_angle - angle) / (self.outer_angle - self.inner_angle))
        }
    }

    /// Angle from the axis; the arc tangent keeps its digits where the cosine is close to one.
    fn angle(&self, direction: DVec3) -> f64 {
        let axis = self.frame.z;
        libm::atan2(axis.cross(direction).length(), axis.dot(direction))
    }

    pub(super) fn sample_emission(&self, u: [f64; 5]) -> EmissionSample {
        let local = warp::uniform_cone([u[3], u[4]], self.one_minus_cos_outer);
        EmissionSample { vertex: point_vertex(self.id, self.position), direction: self.frame.to_world(local) }
    }

    pub(super) fn emission_density(&self, direction: DVec3) -> EdgeDensity {
        // Rounding must not deny directions that were drawn at the cone's edge.
        let inside = self.angle(direction) <= self.outer_angle * (1.0 + 1e-9);
        EdgeDensity {
            position: Density::new(1.0),
            direction: if inside { warp::uniform_cone_density(self.one_minus_cos_outer) } else { Density::ZERO },
        }
    }

    pub(super) fn sample_direct(&self) -> DirectSample {
        DirectSample { vertex: point_vertex(self.id, self.position), density: Density::new(1.0) }
    }

    /// `2π I ∫ falloff(θ) sin θ dθ`, for which the linear part gives `(sin b − sin a)/(b − a) − cos b` beyond the inner cone.
    pub(super) fn flux(&self) -> Rgb {
        let (a, b) = (self.inner_angle, self.outer_angle);
        let mean_cos = if b > a { (libm::sin(b) - libm::sin(a)) / (b - a) } else { libm::cos(b) };
        self.intensity * (2.0 * PI * (1.0 - mean_cos))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flux_of_a_spot_is_its_integrated_intensity() {
        let spot = Spot::new(EmitterId(0), DVec3::ZERO, DVec3::Z, Rgb::WHITE, 0.3, 0.8);
        let n = 200_000;
        let integral: f64 = (0..n)
            .map(|i| {
                let theta = 0.8 * (f64::from(i) + 0.5) / f64::from(n);
                let direction = DVec3::new(libm::sin(theta), 0.0, libm::cos(theta));
                spot.intensity(direction).r * 2.0 * PI * libm::sin(theta) * 0.8 / f64::from(n)
            })
            .sum();
        assert!((spot.flux().r / integral - 1.0).abs() < 1e-9);
    }
}
