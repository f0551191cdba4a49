//! Meshes that are rectangles.

use glam::DVec3;

use super::MeterError;
use crate::names::did_you_mean;
use crate::scene::SceneDescription;
use crate::scene::description::Mesh;

/// Positions come in single precision: how far a rectangle may be from one, relatively.
const TOLERANCE: f64 = 1e-5;
/// How far in front of a surface it is measured, over the size of the scene: several times the rounding of positions in single
/// precision, and the share of light that slips in at the edges stays at a few times this length over the surface's.
const GAP: f64 = 1e-6;
/// Names that an error lists at most.
const LISTED: usize = 12;

/// A rectangle in space that light arrives at from the side `forward`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rectangle {
    pub centre: DVec3,
    /// Along the first side, of length one.
    pub right: DVec3,
    /// At right angles to the rectangle, of length one.
    pub forward: DVec3,
    /// Half of each side \[m\].
    pub half: [f64; 2],
}

impl Rectangle {
    /// Of the surface with this name, a little in front of it.
    pub(super) fn in_front_of(scene: &SceneDescription, name: &str) -> Result<Self, MeterError> {
        let mesh = find(scene, name)?;
        let rectangle = Self::of(mesh).ok_or_else(|| {
            MeterError::new(
                format!("the surface '{name}' is not a flat rectangle"),
                "measure through a rectangle in front of it, by a corner and two sides",
            )
        })?;
        let size = scene.bounds().map_or(0.0, |bounds| bounds.radius());
        Ok(Self { centre: rectangle.centre + rectangle.forward * (GAP * size), ..rectangle })
    }

    pub(super) fn area(&self) -> f64 {
        4.0 * self.half[0] * self.half[1]
    }

    /// A mesh that is one, however it is cut into triangles.
    fn of(mesh: &Mesh) -> Option<Self> {
        let corners = |triangle: &[u32; 3]| triangle.map(|i| mesh.positions[i as usize]);
        let triangles: Vec<[DVec3; 3]> = mesh.triangles.iter().map(corners).collect();
        let normals = || triangles.iter().map(|[a, b, c]| 0.5 * (*b - *a).cross(*c - *a));
        let (area, sum) = (normals().map(DVec3::length).sum::<f64>(), normals().sum::<DVec3>());
        let forward = sum.try_normalize()?;
        let all_face_alike = sum.length() >= (1.0 - TOLERANCE) * area;
        // Of the points of a rectangle the one that is farthest from a point in it is a corner, and its sides start there.
        let inside = triangles.as_flattened().iter().sum::<DVec3>() / (3 * triangles.len()) as f64;
        let farther = |a: &DVec3, b: &DVec3| a.distance_squared(inside).total_cmp(&b.distance_squared(inside));
        let corner = triangles.as_flattened().iter().copied().max_by(farther)?;
        let at_corner = triangles.iter().filter(|triangle| triangle.contains(&corner)).flatten();
        let sides = at_corner.filter_map(|end| (end - corner).try_normalize());
        let found = sides.map(|right| Self::around(triangles.as_flattened(), corner, right, forward));
        let fits = |(rectangle, depth): &(Self, f64)| {
            (rectangle.area() - area).abs() <= TOLERANCE * area && *depth <= TOLERANCE * area.sqrt()
        };
        found.filter(|_| all_face_alike).find(fits).map(|(rectangle, _)| rectangle)
    }

    /// The least one with this direction around some points, and how far they lie outside its plane.
    fn around(points: &[DVec3], corner: DVec3, right: DVec3, forward: DVec3) -> (Self, f64) {
        let right = (right - forward * forward.dot(right)).normalize_or_zero();
        let axes = [right, forward.cross(right), forward];
        let (mut low, mut high) = ([0.0_f64; 3], [0.0_f64; 3]);
        for point in points {
            for axis in 0..3 {
                let along = (point - corner).dot(axes[axis]);
                low[axis] = low[axis].min(along);
                high[axis] = high[axis].max(along);
            }
        }
        let middle = |axis: usize| axes[axis] * (0.5 * (low[axis] + high[axis]));
        let half = [0, 1].map(|axis| 0.5 * (high[axis] - low[axis]));
        (Self { centre: corner + middle(0) + middle(1) + middle(2), right, forward, half }, high[2] - low[2])
    }
}

fn find<'a>(scene: &'a SceneDescription, name: &str) -> Result<&'a Mesh, MeterError> {
    let mut called = scene.meshes.iter().filter(|mesh| mesh.name == name);
    match (called.next(), called.next()) {
        (Some(mesh), None) => Ok(mesh),
        (Some(_), Some(_)) => {
            Err(MeterError::new(format!("several surfaces are called '{name}'"), "give them names of their own"))
        }
        (None, _) if scene.spheres.iter().any(|sphere| sphere.name == name) => Err(MeterError::new(
            format!("'{name}' is a sphere"),
            "measure at a flat rectangle, or through one in front of it",
        )),
        (None, _) => {
            let names = || scene.meshes.iter().map(|mesh| mesh.name.as_str());
            let suggestion = did_you_mean(name, names());
            let problem = format!("there is no surface '{name}'{suggestion}");
            let more = if scene.meshes.len() > LISTED { ", …" } else { "" };
            let listed = names().take(LISTED).collect::<Vec<_>>().join(", ");
            let remedy =
                if listed.is_empty() { "the scene has none".into() } else { format!("there are {listed}{more}") };
            Err(MeterError::new(problem, remedy))
        }
    }
}
