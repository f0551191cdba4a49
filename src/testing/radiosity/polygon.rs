//! Flat convex polygons: planes, clipping, subdivision.

use glam::DVec3;
use smallvec::SmallVec;

/// Corners of a convex polygon, counter-clockwise seen from its front \[m\].
pub(super) type Polygon = SmallVec<[DVec3; 8]>;

/// Corners of a triangle, counter-clockwise seen from its front \[m\].
pub(super) type Corners = [DVec3; 3];

/// The points x with `normal · x = offset`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    pub normal: DVec3,
    pub offset: f64,
}

impl Plane {
    /// Through `point`.
    pub fn at(point: DVec3, normal: DVec3) -> Self {
        Self { normal, offset: normal.dot(point) }
    }

    /// Of a polygon, its front on the positive side; a polygon without area has a zero normal.
    pub fn of(polygon: &[DVec3]) -> Self {
        let normal = area_vector(polygon).normalize_or_zero();
        Self::at(polygon[0], normal)
    }

    /// The same plane, turned round where `sign` is −1.
    pub fn turned(self, sign: f64) -> Self {
        Self { normal: self.normal * sign, offset: self.offset * sign }
    }

    /// `normal · x − offset`: the signed distance where the normal has length one.
    pub fn height(&self, x: DVec3) -> f64 {
        self.normal.dot(x) - self.offset
    }

    /// The part of a polygon on the positive side (Sutherland & Hodgman 1974).
    pub fn clip(&self, polygon: &[DVec3]) -> Polygon {
        let mut kept = Polygon::new();
        for (i, &a) in polygon.iter().enumerate() {
            let b = polygon[(i + 1) % polygon.len()];
            let (ha, hb) = (self.height(a), self.height(b));
            if ha >= 0.0 {
                kept.push(a);
            }
            if (ha > 0.0 && hb < 0.0) || (ha < 0.0 && hb > 0.0) {
                kept.push(a + (b - a) * (ha / (ha - hb)));
            }
        }
        kept
    }
}

/// Area times unit normal: `½ Σ_i (v_i − v_0) × (v_{i+1} − v_0)` \[m²\].
pub(super) fn area_vector(polygon: &[DVec3]) -> DVec3 {
    let Some(&first) = polygon.first() else { return DVec3::ZERO };
    polygon.windows(2).map(|e| (e[0] - first).cross(e[1] - first)).sum::<DVec3>() * 0.5
}

/// The edges, in order.
pub(super) fn edges(polygon: &[DVec3]) -> impl Iterator<Item = [DVec3; 2]> + '_ {
    (0..polygon.len()).map(|i| [polygon[i], polygon[(i + 1) % polygon.len()]])
}

/// Mean of the corners.
pub(super) fn centroid(polygon: &[DVec3]) -> DVec3 {
    polygon.iter().sum::<DVec3>() / polygon.len() as f64
}

/// The smallest radius around the mean of the corners that holds all of them \[m\].
pub(super) fn radius(polygon: &[DVec3]) -> f64 {
    let centre = centroid(polygon);
    polygon.iter().map(|c| c.distance(centre)).fold(0.0, f64::max)
}

/// The n² congruent triangles that a triangle divides into, oriented as it is.
pub(super) fn subdivide([a, b, c]: Corners, n: usize) -> Vec<Corners> {
    let (u, v) = ((b - a) / n as f64, (c - a) / n as f64);
    let at = |i: usize, j: usize| a + u * i as f64 + v * j as f64;
    let mut parts = Vec::with_capacity(n * n);
    for i in 0..n {
        for j in 0..n - i {
            parts.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
            if i + j + 1 < n {
                parts.push([at(i + 1, j + 1), at(i, j + 1), at(i + 1, j)]);
            }
        }
    }
    parts
}
