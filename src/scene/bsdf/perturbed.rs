//! Shading normals turned by a texture.

use glam::DVec3;

use super::Side;
use crate::scene::description::NormalSource;
use crate::scene::texture::SurfacePoint;

/// The frame of a nested model in the frame around it: coordinates of the former are products with its axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct TurnedFrame {
    axes: [DVec3; 3],
}

impl TurnedFrame {
    pub(super) fn new(source: &NormalSource, at: &SurfacePoint<'_>) -> Self {
        let normal = match source {
            NormalSource::Map { texture, scale, against_v } => {
                let [r, g, b, _] = texture.eval(at);
                let follows_v = at.tangents[1].y >= 0.0;
                let sign = if *against_v && follows_v { -1.0 } else { 1.0 };
                DVec3::new((2.0 * r - 1.0) * scale[0], (2.0 * g - 1.0) * scale[1] * sign, 2.0 * b - 1.0)
            }
            NormalSource::Bump { texture, scale } => displaced_normal(texture.gradient(at) * *scale, at.tangents),
        };
        let z = normal.try_normalize().filter(|normal| normal.z > 0.0).unwrap_or(DVec3::Z);
        let along = at.tangents[0] - z * z.dot(at.tangents[0]);
        let x = along.try_normalize().unwrap_or_else(|| z.any_orthonormal_vector());
        Self { axes: [x, z.cross(x), z] }
    }

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
fn displaced_normal(gradient: glam::DVec2, tangents: [DVec3; 2]) -> DVec3 {
    let [along_u, along_v] = tangents;
    let lifted_u = DVec3::new(along_u.x, along_u.y, gradient.x);
    let lifted_v = DVec3::new(along_v.x, along_v.y, gradient.y);
    let normal = lifted_u.cross(lifted_v);
    // Mirrored texture coordinates have their tangents the other way round.
    if along_u.x * along_v.y < along_u.y * along_v.x { -normal } else { normal }
}
