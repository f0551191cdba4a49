//! Meshes with many, or with bad, triangles.

use glam::DVec3;

use crate::scene::description::Mesh;

/// The unit sphere as a subdivided octahedron would be coarse at first: an icosahedron, each triangle cut in four so many
/// times. Its front is the inside.
pub(super) fn subdivided(levels: u32) -> Mesh {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let mut positions: Vec<DVec3> = Vec::new();
    for (a, b) in [(1.0, golden), (1.0, -golden), (-1.0, golden), (-1.0, -golden)] {
        positions.extend([DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)].map(DVec3::normalize));
    }
    // Neighbours are those at the distance of the edge: all triples of them.
    let edge = 2.0 / (1.0 + golden * golden).sqrt();
    let near = |i: usize, j: usize| (positions[i].distance(positions[j]) - edge).abs() < 1e-6;
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                if near(i, j) && near(j, k) && near(k, i) {
                    let outward =
                        (positions[j] - positions[i]).cross(positions[k] - positions[i]).dot(positions[i]) > 0.0;
                    let [i, j, k] = [i as u32, j as u32, k as u32];
                    triangles.push(if outward { [i, k, j] } else { [i, j, k] });
                }
            }
        }
    }
    for _ in 0..levels {
        let mut middles = std::collections::HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push((positions[a as usize] + positions[b as usize]).normalize());
                positions.len() as u32 - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    Mesh { name: "icosphere".into(), positions, triangles, ..Mesh::default() }
}

/// The unit sphere by longitude and latitude, in about so many triangles. It is convex: its quadrangles are flat.
pub(super) fn latitude_longitude(triangles: f64) -> Mesh {
    let rows = (0.5 * triangles.sqrt()).round() as u32;
    let columns = 2 * rows;
    let at = |row: u32, column: u32| {
        let polar = std::f64::consts::PI * f64::from(row) / f64::from(rows);
        let turn = 2.0 * std::f64::consts::PI * f64::from(column) / f64::from(columns);
        let (sine, cosine) = (libm::sin(polar), libm::cos(polar));
        DVec3::new(sine * libm::cos(turn), sine * libm::sin(turn), cosine)
    };
    let mut positions = vec![DVec3::Z];
    positions.extend((1..rows).flat_map(|row| (0..columns).map(move |column| at(row, column))));
    positions.push(-DVec3::Z);
    let index = |row: u32, column: u32| match row {
        0 => 0,
        row if row == rows => (rows - 1) * columns + 1,
        row => 1 + (row - 1) * columns + column % columns,
    };
    let cell = |row: u32, column: u32| {
        let [a, b] = [index(row, column), index(row, column + 1)];
        let [c, d] = [index(row + 1, column), index(row + 1, column + 1)];
        let upper = (row > 0).then_some([a, c, b]);
        let lower = (row + 1 < rows).then_some([b, c, d]);
        // At the poles one of the two has no area.
        [if row + 1 == rows { Some([a, c, b]) } else { upper }, if row == 0 { Some([b, c, d]) } else { lower }]
    };
    let cells = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
    let mut triangles: Vec<[u32; 3]> =
        cells.flat_map(|(row, column)| cell(row, column).into_iter().flatten()).collect();
    triangles.sort_unstable();
    triangles.dedup();
    Mesh { name: "sphere".into(), positions, triangles, ..Mesh::default() }
}

/// Each triangle cut at points of its first edge whose distances to the corner shrink to 1/aspect of its length, and a triangle
/// without area in each cut.
pub(super) fn sliced(mesh: &Mesh, aspect: f64) -> Mesh {
    let mut cut = Mesh { triangles: Vec::new(), ..mesh.clone() };
    let pieces = 4;
    for &[a, b, c] in &mesh.triangles {
        let (from, to) = (mesh.positions[a as usize], mesh.positions[b as usize]);
        let mut last = b;
        for i in 1..=pieces {
            let share = libm::pow(0.5 / aspect, f64::from(i) / f64::from(pieces));
            cut.positions.push(from + (to - from) * share);
            let next = cut.positions.len() as u32 - 1;
            cut.triangles.extend([[next, last, c], [next, next, c], [next, last, next]]);
            last = next;
        }
        cut.triangles.push([a, last, c]);
    }
    cut
}
