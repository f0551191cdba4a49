//! Sensors infinitely far away: all that leaves the scene in one direction, on average over a target.

use glam::{DVec2, DVec3};

use crate::geometry::Bounds;
use crate::scene::description::{Projection, SensorDescription, Target};
use crate::warp;

/// How much the sphere around the scene is larger than the one around the corners of its box, as Mitsuba has it: 1500 times
/// the rounding of single precision. It is part of what is averaged over.
const MARGIN: f64 = 1500.0 / (1 << 24) as f64;

/// Puts a distant sensor just outside of the scene, where nothing lies before it, and turns its target into what it sees. The
/// cross-section of the sphere around the scene is the target where that is all. Others stay as they are.
pub(in crate::scene) fn placed(sensor: SensorDescription, geometry: Bounds) -> SensorDescription {
    let Projection::Distant { target } = sensor.projection else { return sensor };
    let nothing = Bounds { min: DVec3::ZERO, max: DVec3::ZERO };
    let bounds = if geometry.is_empty() { nothing } else { geometry };
    let (centre, forward) = (bounds.centre(), sensor.forward);
    let radius = (bounds.radius() * (1.0 + MARGIN)).max(MARGIN);
    let nearest = (0.5 * (bounds.max - bounds.min)).dot(forward.abs());
    let plane = centre.dot(forward) - nearest - MARGIN * radius;
    let in_plane = |point: DVec3| point + forward * (plane - point.dot(forward));
    let right = forward.cross(sensor.up);
    let (target, at) = match target {
        Target::Scene => (Target::Ellipse { centre, u: right * radius, v: sensor.up * radius }, centre),
        Target::Point(point) => {
            return SensorDescription { position: in_plane(point), projection: Projection::Ray, ..sensor };
        }
        Target::Parallelogram { centre, .. } | Target::Ellipse { centre, .. } => (target, centre),
    };
    SensorDescription { position: in_plane(at), projection: Projection::Distant { target }, ..sensor }
}

/// A target as the sensor sees it, around its own position: the points `a u + b v`, uniform by area, with both of a and b
/// in `[−1, 1]`, or `a² + b² ≤ 1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Aperture {
    u: DVec3,
    v: DVec3,
    /// `a = p · to_a`, `b = p · to_b`.
    to_a: DVec3,
    to_b: DVec3,
    round: bool,
}

impl Aperture {
    /// The projection of a parallelogram or an ellipse along `forward`.
    pub fn new(u: DVec3, v: DVec3, forward: DVec3, round: bool) -> Self {
        let flat = |side: DVec3| side - forward * side.dot(forward);
        let (u, v) = (flat(u), flat(v));
        let determinant = u.cross(v).dot(forward);
        Self { u, v, to_a: v.cross(forward) / determinant, to_b: forward.cross(u) / determinant, round }
    }

    /// The farthest point \[m\].
    pub fn extent(&self) -> f64 {
        let (uu, vv, uv) = (self.u.length_squared(), self.v.length_squared(), self.u.dot(self.v));
        // Of an ellipse the longer half axis: the root of the larger eigenvalue of (u v)ᵀ(u v).
        let longest = || (0.5 * (uu + vv) + (0.5 * (uu - vv)).hypot(uv)).sqrt();
        if self.round { longest() } else { uu.sqrt() + vv.sqrt() }
    }

    /// \[m²\], at right angles to the direction.
    pub fn area(&self) -> f64 {
        let parallelogram = self.u.cross(self.v).length();
        parallelogram * if self.round { std::f64::consts::PI } else { 4.0 }
    }

    pub fn sample(&self, u: [f64; 2]) -> DVec3 {
        let at = if self.round { warp::concentric_disk(u) } else { DVec2::from_array(u) * 2.0 - 1.0 };
        self.u * at.x + self.v * at.y
    }

    pub fn contains(&self, offset: DVec3) -> bool {
        let (a, b) = (offset.dot(self.to_a), offset.dot(self.to_b));
        // Points of the rim, moved by rounding, belong to it.
        let end = 1.0 + 1e-12;
        if self.round { a * a + b * b <= end } else { a.abs() <= end && b.abs() <= end }
    }
}
