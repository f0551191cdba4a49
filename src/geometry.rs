//! Rays, frames and boxes in double precision.

use glam::DVec3;

/// A half-line from `origin` along the unit vector `direction`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts \[m\].
    pub origin: DVec3,
    /// Where it goes, of length one.
    pub direction: DVec3,
}

impl Ray {
    /// From its parts; `direction` has length one.
    #[must_use]
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        Self { origin, direction }
    }

    /// The point at distance `t` \[m\].
    #[must_use]
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }
}

/// An orthonormal basis whose z axis is a given normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// First tangent.
    pub x: DVec3,
    /// Second tangent.
    pub y: DVec3,
    /// The normal.
    pub z: DVec3,
}

impl Frame {
    /// A frame around the unit vector `normal`, without branches (Duff et al. 2017, listing 3).
    #[must_use]
    #[inline]
    pub fn around(normal: DVec3) -> Self {
        let sign = 1.0_f64.copysign(normal.z);
        let a = -1.0 / (sign + normal.z);
        let b = normal.x * normal.y * a;
        Self {
            x: DVec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
            y: DVec3::new(b, sign + normal.y * normal.y * a, -normal.y),
            z: normal,
        }
    }

    /// A frame around the unit vector `normal` whose x axis follows `tangent` as far as it is at right angles to the normal.
    #[must_use]
    pub fn along(normal: DVec3, tangent: DVec3) -> Self {
        let Some(x) = (tangent - normal * normal.dot(tangent)).try_normalize() else { return Self::around(normal) };
        Self { x, y: normal.cross(x), z: normal }
    }

    /// World coordinates of a vector given in this frame.
    #[must_use]
    #[inline]
    pub fn to_world(&self, local: DVec3) -> DVec3 {
        self.x * local.x + self.y * local.y + self.z * local.z
    }

    /// Coordinates in this frame of a vector given in the world.
    #[must_use]
    #[inline]
    pub fn to_local(&self, world: DVec3) -> DVec3 {
        DVec3::new(world.dot(self.x), world.dot(self.y), world.dot(self.z))
    }
}

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest corner; above `max` where the box is empty.
    pub min: DVec3,
    /// Largest corner.
    pub max: DVec3,
}

impl Bounds {
    /// The box that holds nothing.
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// The smallest box around the points.
    pub fn around(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self { min: b.min.min(p), max: b.max.max(p) })
    }

    /// The smallest box around both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Holds nothing, not even a point.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    /// Its centre.
    #[must_use]
    pub fn centre(&self) -> DVec3 {
        0.5 * (self.min + self.max)
    }

    /// Distance from the centre to a corner.
    #[must_use]
    pub fn radius(&self) -> f64 {
        0.5 * (self.max - self.min).length()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_orthonormal_and_right_handed() {
        for n in [DVec3::Z, -DVec3::Z, DVec3::X, DVec3::new(1e-9, -1e-9, -1.0), DVec3::new(-3.0, 2.0, -1.0)] {
            let f = Frame::around(n.normalize());
            assert!((f.x.cross(f.y) - f.z).length() < 1e-14, "{n}");
            assert!(f.x.dot(f.y).abs() < 1e-15 && f.x.dot(f.z).abs() < 1e-15, "{n}");
            let v = DVec3::new(0.1, -0.7, 0.4);
            assert!((f.to_world(f.to_local(v)) - v).length() < 1e-15, "{n}");
        }
    }
}
