//! From a primitive in its node's coordinates to one in the world's.

use glam::{DAffine3, DMat3, DVec3};

use super::fault::Fault;
use super::primitive::Primitive;
use super::tally::Tally;

/// Shading normals this close to the geometric ones say nothing of their own.
const SAME_NORMAL: f64 = 1e-5;

/// Positions, shading normals and triangles in world coordinates.
#[derive(Clone, Debug, Default)]
pub(super) struct Surface {
    pub positions: Vec<DVec3>,
    pub normals: Option<Vec<DVec3>>,
    pub triangles: Vec<[u32; 3]>,
}

/// Applies a node's transform; `None` where no triangle is left.
///
/// A mirroring transform turns the order of the corners round, so that the front stays the front (glTF 2.0, section
/// 3.7.4).
pub(super) fn to_world(
    primitive: &Primitive,
    world: &DAffine3,
    node: &str,
    tally: &mut Tally,
) -> Result<Option<Surface>, Fault> {
    let mut positions = Vec::with_capacity(primitive.positions.len());
    for &position in &primitive.positions {
        let moved = world.transform_point3(position);
        if !moved.is_finite() {
            let problem = format!("its transform moves a vertex of {} to {moved}", primitive.place);
            return Err(Fault::invalid(node, problem, "correct the transforms above it"));
        }
        positions.push(moved);
    }
    let cofactor = Cofactor::of(world.matrix3);
    let mut triangles = primitive.triangles.clone();
    if cofactor.mirrors {
        triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
    }
    let before = triangles.len();
    triangles.retain(|corners| has_area(corners.map(|i| positions[i as usize])));
    tally.zero_area += before - triangles.len();
    if triangles.is_empty() {
        return Ok(None);
    }
    let normals = primitive.normals.as_ref().and_then(|normals| {
        let moved = normals.iter().map(|&normal| cofactor.normal(normal)).collect();
        shading_normals(moved, &positions, &triangles, tally)
    });
    Ok(Some(Surface { positions, normals, triangles }))
}

/// `det(M) M⁻ᵀ`, which maps normals and exists for singular M too.
struct Cofactor {
    matrix: DMat3,
    mirrors: bool,
}

impl Cofactor {
    fn of(linear: DMat3) -> Self {
        // Only directions count: without this, tiny scales would underflow.
        let largest = linear.to_cols_array().into_iter().fold(0.0_f64, |m, entry| m.max(entry.abs()));
        let m = if largest > 0.0 { linear * (1.0 / largest) } else { linear };
        let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
        let matrix = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
        Self { matrix, mirrors: x.dot(y.cross(z)) < 0.0 }
    }

    /// The unit normal along `M⁻ᵀ n`; `None` where there is no such direction.
    fn normal(&self, normal: DVec3) -> Option<DVec3> {
        let moved = self.matrix * normal.try_normalize()?;
        (if self.mirrors { -moved } else { moved }).try_normalize()
    }
}

/// Whether the corners span an area that exceeds the rounding errors of their coordinates.
fn has_area([a, b, c]: [DVec3; 3]) -> bool {
    let (ab, ac) = (b - a, c - a);
    let edge = ab.length().max(ac.length()).max((c - b).length());
    let coordinate = a.abs().max(b.abs()).max(c.abs()).max_element();
    ab.cross(ac).length() > 4.0 * f64::EPSILON * coordinate * edge
}

/// The vertex normals, geometric ones where the file's are useless; `None` where all are geometric anyway.
fn shading_normals(
    normals: Vec<Option<DVec3>>,
    positions: &[DVec3],
    triangles: &[[u32; 3]],
    tally: &mut Tally,
) -> Option<Vec<DVec3>> {
    let geometric = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|i| positions[i as usize]);
        (b - a).cross(c - a)
    };
    let says_nothing = triangles.iter().all(|corners| {
        let normal = geometric(corners).normalize_or_zero();
        corners.iter().all(|&i| normals[i as usize].is_none_or(|n| (n - normal).length() <= SAME_NORMAL))
    });
    let mut used = vec![false; normals.len()];
    triangles.iter().flatten().for_each(|&i| used[i as usize] = true);
    let bad = normals.iter().zip(&used).filter(|(normal, used)| normal.is_none() && **used).count();
    tally.bad_normals += bad;
    if says_nothing {
        return None;
    }
    if bad == 0 {
        return Some(normals.into_iter().map(|n| n.unwrap_or(DVec3::Z)).collect());
    }
    let mut sums = vec![DVec3::ZERO; positions.len()];
    let mut firsts = vec![DVec3::Z; positions.len()];
    for corners in triangles.iter().rev() {
        let normal = geometric(corners);
        for &i in corners {
            sums[i as usize] += normal;
            firsts[i as usize] = normal.normalize_or(DVec3::Z);
        }
    }
    let repaired = normals.into_iter().zip(sums.into_iter().zip(firsts));
    Some(repaired.map(|(normal, (sum, first))| normal.or(sum.try_normalize()).unwrap_or(first)).collect())
}
