//! Closed meshes around the origin, each triangle seen from there from its back.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use glam::DVec3;
use pathspace::sampler::Random;
use pathspace::scene::accel::Triangle;

/// Positions that triangles share bit for bit.
pub struct Mesh {
    pub name: &'static str,
    pub positions: Vec<DVec3>,
    pub triangles: Vec<[usize; 3]>,
}

impl Mesh {
    /// Radius of a ball around the origin that lies behind all triangles. Slivers lie in the planes of others.
    pub fn inner_radius(&self) -> f64 {
        let distance = |corners: &[usize; 3]| {
            let corners = corners.map(|i| self.positions[i]);
            let triangle = Triangle { corners, shape: 0 };
            let [a, b, c] = corners;
            let longest = (b - a).length().max((c - b).length()).max((a - c).length());
            (triangle.area() > 1e-6 * longest * longest).then(|| triangle.normal().dot(a))
        };
        let radius = self.triangles.iter().filter_map(distance).fold(f64::INFINITY, f64::min);
        assert!(radius > 0.0, "{}: the origin is not inside", self.name);
        radius
    }

    /// Every edge belongs to two triangles, which pass it in opposite directions.
    pub fn assert_closed(&self) {
        let mut edges: HashMap<[usize; 2], i32> = HashMap::new();
        for triangle in &self.triangles {
            for i in 0..3 {
                let [p, q] = [triangle[i], triangle[(i + 1) % 3]];
                *edges.entry([p.min(q), p.max(q)]).or_default() += if p < q { 1 } else { -1 };
            }
        }
        assert!(edges.values().all(|&sum| sum == 0), "{} is open", self.name);
    }

    fn mapped(self, name: &'static str, map: impl FnMut(DVec3) -> DVec3) -> Self {
        Self { name, positions: self.positions.into_iter().map(map).collect(), ..self }
    }
}

/// 20 · 4ⁿ triangles.
pub fn icosphere(subdivisions: u32) -> Mesh {
    let phi = 0.5 + 1.25_f64.sqrt();
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for (i, j) in [(1.0, phi), (-1.0, phi), (1.0, -phi), (-1.0, -phi)] {
        positions.extend([DVec3::new(0.0, i, j), DVec3::new(i, j, 0.0), DVec3::new(j, 0.0, i)]);
    }
    // Faces: three corners at the least distance from each other.
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                let near = |p: usize, q: usize| (positions[p] - positions[q]).length() < 2.1;
                if near(a, b) && near(b, c) && near(a, c) {
                    let [p, q, r] = [a, b, c].map(|i| positions[i]);
                    let outwards = (q - p).cross(r - p).dot(p) > 0.0;
                    triangles.push(if outwards { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    for _ in 0..subdivisions {
        let mut middles: HashMap<[usize; 2], usize> = HashMap::new();
        let mut middle = |p: usize, q: usize| {
            *middles.entry([p.min(q), p.max(q)]).or_insert_with(|| {
                positions.push(0.5 * (positions[p] + positions[q]));
                positions.len() - 1
            })
        };
        let split = |&[a, b, c]: &[usize; 3]| {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
        };
        triangles = triangles.iter().flat_map(split).collect();
    }
    Mesh { name: "icosphere", positions, triangles }.mapped("icosphere", DVec3::normalize)
}

/// Directions of an icosphere at random distances.
pub fn star(subdivisions: u32) -> Mesh {
    let mut random = Random::new(5, 0, 0);
    icosphere(subdivisions).mapped("star", |p| p * (0.6 + 0.8 * random.uniform()))
}

/// Circles of latitude and longitude, with triangles that meet at the poles.
pub fn globe(circles: usize, meridians: usize) -> Mesh {
    let at = |row: usize, column: usize| {
        let (theta, phi) = (PI * row as f64 / circles as f64, TAU * column as f64 / meridians as f64);
        DVec3::new(libm::sin(theta) * libm::cos(phi), libm::sin(theta) * libm::sin(phi), libm::cos(theta))
    };
    let mut positions = vec![DVec3::Z, -DVec3::Z];
    positions.extend((1..circles).flat_map(|row| (0..meridians).map(move |column| at(row, column))));
    let index = |row: usize, column: usize| 2 + (row - 1) * meridians + column % meridians;
    let mut triangles = Vec::new();
    for column in 0..meridians {
        triangles.push([0, index(1, column), index(1, column + 1)]);
        triangles.push([1, index(circles - 1, column + 1), index(circles - 1, column)]);
        for row in 1..circles - 1 {
            let [a, b] = [index(row, column), index(row, column + 1)];
            let [c, d] = [index(row + 1, column), index(row + 1, column + 1)];
            triangles.extend([[a, c, d], [a, d, b]]);
        }
    }
    Mesh { name: "globe", positions, triangles }
}

/// A cube whose sides are cut by lines closer and closer to its edges: slivers down to a ratio of 10¹².
pub fn crate_of_slivers(lines: i32) -> Mesh {
    let near = |i: i32| 1.0 - libm::pow(10.0, -12.0 * f64::from(i) / f64::from(lines));
    let mut stops: Vec<f64> = (1..=lines).flat_map(|i| [near(i), -near(i)]).chain([-1.0, 0.0, 1.0]).collect();
    stops.sort_by(f64::total_cmp);
    let last = stops.len() - 1;
    let mut indices: HashMap<[u64; 3], usize> = HashMap::new();
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    let mut index = |p: DVec3| {
        *indices.entry(p.to_array().map(f64::to_bits)).or_insert_with(|| {
            positions.push(p);
            positions.len() - 1
        })
    };
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let mut at = |i: usize, j: usize| {
                let mut p = DVec3::ZERO;
                p[axis] = side;
                p[(axis + 1) % 3] = if side > 0.0 { stops[i] } else { stops[j] };
                p[(axis + 2) % 3] = if side > 0.0 { stops[j] } else { stops[i] };
                index(p)
            };
            for i in 0..last {
                for j in 0..last {
                    let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                    triangles.extend([[a, b, c], [a, c, d]]);
                }
            }
        }
    }
    Mesh { name: "crate of slivers", positions, triangles }
}
