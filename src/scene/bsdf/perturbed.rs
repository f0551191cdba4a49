//! Shading normals turned by a texture.
//!
//! As in Mitsuba 3: a normal that would look away from the sensor is mirrored at the outer one, and f_s has the shadowing of
//! the facets that such normals stand for (Estevez et al. 2019), which keeps the terminator soft. Whether the normal is
//! mirrored depends on the direction to the sensor, which a walk from an emitter does not know when it draws that direction.
//! So where a walk's direction could belong to either normal, both are drawn from.

use glam::{DVec2, DVec3};

use super::Side;
use crate::scene::description::NormalSource;
use crate::scene::texture::SurfacePoint;

/// How often a walk draws from the mirrored normal where it is not the one that belongs to its direction.
const MIRRORED: f64 = 0.1;

/// The turned normal at a point, in the frame around it.
#[derive(Clone, Copy, Debug)]
pub(super) struct TurnedNormal {
    normal: DVec3,
    /// What the first axis is as near to as it can be.
    along: DVec3,
}

impl TurnedNormal {
    pub(super) fn new(source: &NormalSource, at: &SurfacePoint<'_>) -> Self {
        let (normal, along) = match source {
            NormalSource::Map { texture, scale, against_v } => {
                let [r, g, b, _] = texture.eval(at);
                let follows_v = at.tangents[1].y >= 0.0;
                let sign = if *against_v && follows_v { -1.0 } else { 1.0 };
                let normal = DVec3::new((2.0 * r - 1.0) * scale[0], (2.0 * g - 1.0) * scale[1] * sign, 2.0 * b - 1.0);
                (normal, DVec3::X)
            }
            NormalSource::Bump { texture, scale } => {
                (displaced_normal(texture.gradient(at) * *scale, at.tangents), at.tangents[0])
            }
        };
        Self { normal: normal.try_normalize().filter(|normal| normal.z > 0.0).unwrap_or(DVec3::Z), along }
    }

    /// The normal that belongs to a direction to the sensor.
    fn facing(&self, to_sensor: DVec3) -> DVec3 {
        if agree(self.normal, to_sensor) { self.normal } else { mirrored(self.normal) }
    }

    /// The frame of f_s for a direction to the sensor.
    pub(super) fn frame(&self, to_sensor: DVec3) -> TurnedFrame {
        self.frame_of(self.facing(to_sensor))
    }

    /// The frame of the normal as the texture has it, for models that are black where it looks away.
    pub(super) fn frame_as_it_is(&self) -> TurnedFrame {
        self.frame_of(self.normal)
    }

    fn frame_of(&self, z: DVec3) -> TurnedFrame {
        let along = self.along - z * z.dot(self.along);
        let x = along.try_normalize().unwrap_or_else(|| z.any_orthonormal_vector());
        TurnedFrame { axes: [x, z.cross(x), z] }
    }

    /// The frames that a walk which comes from `from` draws from, and how often.
    pub(super) fn choice(&self, from: DVec3) -> [(TurnedFrame, f64); 2] {
        let (normal, other) = (self.normal, mirrored(self.normal));
        let second = if !agree(normal, from) {
            1.0
        } else if agree(other, from) && (normal.x, normal.y) != (0.0, 0.0) {
            MIRRORED
        } else {
            0.0
        };
        [(self.frame_of(normal), 1.0 - second), (self.frame_of(other), second)]
    }

    /// How often a walk which comes from `from` draws from the frame of f_s for a direction to the sensor.
    pub(super) fn share(&self, from: DVec3, to_sensor: DVec3) -> f64 {
        let [(_, first), (_, second)] = self.choice(from);
        if agree(self.normal, to_sensor) { first } else { second }
    }

    /// The factor `2 / (1 + √(1 + α² tan²θ))` with `α² = min(tan²θ_n / 8, 1)`, θ_n between the normals and θ between the outer
    /// one and the emitter (Estevez et al. 2019).
    pub(super) fn shadowing(&self, to_emitter: DVec3) -> f64 {
        let (n, w) = (self.normal, to_emitter);
        let alpha2 = (0.125 * (n.x * n.x + n.y * n.y) / (n.z * n.z)).min(1.0);
        let z = w.z.abs();
        2.0 * z / (z + (w.z * w.z + alpha2 * (w.x * w.x + w.y * w.y)).sqrt())
    }
}

/// The direction is on the same side of the turned normal as of the outer one.
fn agree(normal: DVec3, direction: DVec3) -> bool {
    normal.dot(direction) * direction.z > 0.0
}

fn mirrored(normal: DVec3) -> DVec3 {
    DVec3::new(-normal.x, -normal.y, normal.z)
}

/// The frame of a nested model in the frame around it: coordinates of the former are products with its axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TurnedFrame {
    axes: [DVec3; 3],
}

impl TurnedFrame {
    #[inline]
    pub(super) fn to_nested(self, v: DVec3) -> DVec3 {
        let [x, y, z] = self.axes;
        DVec3::new(v.dot(x), v.dot(y), v.dot(z))
    }

    #[inline]
    pub(super) fn to_outer(self, v: DVec3) -> DVec3 {
        let [x, y, z] = self.axes;
        x * v.x + y * v.y + z * v.z
    }

    /// In the nested frame; `None` where the two normals disagree about the side.
    #[inline]
    pub(super) fn same_side(self, v: DVec3) -> Option<DVec3> {
        let nested = self.to_nested(v);
        (v.z * nested.z > 0.0).then_some(nested)
    }

    #[inline]
    pub(super) fn both_to_nested(self, a: DVec3, b: DVec3) -> Option<[DVec3; 2]> {
        Some([self.same_side(a)?, self.same_side(b)?])
    }

    /// `|cos θ| under the turned normal / |cos θ| under the outer one`.
    #[inline]
    pub(super) fn ratio(outer: DVec3, nested: DVec3) -> f64 {
        (nested.z / outer.z).abs()
    }

    /// What the turned normal does to a Dirac density, which counts in the outer projected solid angle on the emitter's side;
    /// the pairs are a direction in the outer and in the nested frame.
    pub(super) fn dirac_ratio(side: Side, from: [DVec3; 2], to: [DVec3; 2]) -> f64 {
        match side {
            Side::Sensor => 1.0,
            Side::Emitter => Self::ratio(to[0], to[1]) / Self::ratio(from[0], from[1]),
        }
    }
}

/// The normal of the surface displaced by a height of this gradient (by u and v), in the frame of the normal.
fn displaced_normal(gradient: DVec2, tangents: [DVec3; 2]) -> DVec3 {
    let [along_u, along_v] = tangents;
    let lifted_u = DVec3::new(along_u.x, along_u.y, gradient.x);
    let lifted_v = DVec3::new(along_v.x, along_v.y, gradient.y);
    let normal = lifted_u.cross(lifted_v);
    // Mirrored texture coordinates have their tangents the other way round.
    if along_u.x * along_v.y < along_u.y * along_v.x { -normal } else { normal }
}
