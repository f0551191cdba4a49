//! Surfaces as geometry: what is where.

use glam::{DAffine3, DMat3, DVec3, Vec2};

/// A triangle mesh in world coordinates.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Name in the file, for messages.
    pub name: String,
    /// Vertex positions \[m\].
    pub positions: Vec<DVec3>,
    /// Unit shading normals, one per vertex, where the file has them.
    pub normals: Option<Vec<DVec3>>,
    /// Texture coordinates, one per vertex, where the file has them.
    pub texcoords: Option<Vec<Vec2>>,
    /// What else the file says of vertices or faces, for textures.
    pub attributes: Vec<Attribute>,
    /// Vertex indices, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Index into [`SceneDescription::materials`](super::SceneDescription::materials).
    pub material: usize,
}

/// Values that a mesh has at its vertices or faces.
#[derive(Clone, Debug, PartialEq)]
pub struct Attribute {
    /// What textures call it.
    pub name: String,
    /// One for each triangle rather than for each vertex.
    pub per_face: bool,
    /// Numbers in a value: 1, 3 or 4.
    pub channels: usize,
    /// The values, one after the other.
    pub values: Vec<f32>,
}

impl Attribute {
    /// Of a vertex, or of a triangle.
    #[must_use]
    pub fn value(&self, index: usize) -> &[f32] {
        &self.values[index * self.channels..][..self.channels]
    }

    /// At the corners of a triangle: linear RGB and opacity; what has one channel is grey.
    #[must_use]
    pub fn corners(&self, triangle: usize, vertices: [u32; 3]) -> [[f32; 4]; 3] {
        let at = |index: usize| match *self.value(index) {
            [x] => [x, x, x, 1.0],
            [r, g, b] => [r, g, b, 1.0],
            [r, g, b, a] => [r, g, b, a],
            _ => [0.0, 0.0, 0.0, 1.0],
        };
        if self.per_face { [at(triangle); 3] } else { vertices.map(|i| at(i as usize)) }
    }
}

/// An analytic sphere.
#[derive(Clone, Debug)]
pub struct Sphere {
    /// Name in the file, for messages.
    pub name: String,
    /// Centre \[m\].
    pub centre: DVec3,
    /// Radius \[m\], positive.
    pub radius: f64,
    /// Unit vectors at right angles, mirrored or not: v is the angle from the third over π, u the angle from the first, on
    /// the side of the second, over 2π.
    pub axes: DMat3,
    /// Its front is the inside.
    pub inward: bool,
    /// Index into [`SceneDescription::materials`](super::SceneDescription::materials).
    pub material: usize,
}

impl Sphere {
    /// With the pole along z and its front outside.
    #[must_use]
    pub fn new(name: impl Into<String>, centre: DVec3, radius: f64, material: usize) -> Self {
        Self { name: name.into(), centre, radius, axes: DMat3::IDENTITY, inward: false, material }
    }

    /// The unit sphere under a similarity. A mirrored one faces inwards, or with `flip_normals` outwards, as in Mitsuba 3.
    #[must_use]
    pub fn transformed(name: impl Into<String>, to_world: &DAffine3, flip_normals: bool, material: usize) -> Self {
        let radius = to_world.matrix3.x_axis.length();
        let axes = to_world.matrix3 * radius.recip();
        let inward = flip_normals != (to_world.matrix3.determinant() < 0.0);
        Self { name: name.into(), centre: to_world.translation, radius, axes, inward, material }
    }
}

/// An analytic disk, or an ellipse: all `centre + x axes[0] + y axes[1]` with `x² + y² ≤ 1`.
#[derive(Clone, Debug)]
pub struct Disk {
    /// Name in the file, for messages.
    pub name: String,
    /// Centre \[m\].
    pub centre: DVec3,
    /// Where (1, 0) and (0, 1) are, relative to the centre \[m\]; its front is where their cross product points. As texture
    /// coordinates, u is the distance √(x² + y²) and v the angle from the first, on the side of the second, over 2π.
    pub axes: [DVec3; 2],
    /// Its front is the other side.
    pub flipped: bool,
    /// Index into [`SceneDescription::materials`](super::SceneDescription::materials).
    pub material: usize,
}

impl Disk {
    /// The unit disk in the plane z = 0, which faces +z, under an affine map; its normal is turned as one.
    #[must_use]
    pub fn transformed(name: impl Into<String>, to_world: &DAffine3, flip_normals: bool, material: usize) -> Self {
        let axes = [to_world.matrix3.x_axis, to_world.matrix3.y_axis];
        let flipped = flip_normals != (to_world.matrix3.determinant() < 0.0);
        Self { name: name.into(), centre: to_world.translation, axes, flipped, material }
    }
}

/// An analytic cylinder without its ends.
#[derive(Clone, Debug)]
pub struct Cylinder {
    /// Name in the file, for messages.
    pub name: String,
    /// Centre of the circle at v = 0 \[m\].
    pub base: DVec3,
    /// From there to the centre of the circle at v = 1 \[m\].
    pub axis: DVec3,
    /// Radius \[m\], positive.
    pub radius: f64,
    /// Unit vector at right angles to the axis, along which u = 0; u is the angle from there over 2π, counter-clockwise
    /// around the axis.
    pub meridian: DVec3,
    /// u grows the other way, as it does on a mirrored cylinder.
    pub clockwise: bool,
    /// Its front is the inside.
    pub inward: bool,
    /// Index into [`SceneDescription::materials`](super::SceneDescription::materials).
    pub material: usize,
}

impl Cylinder {
    /// The cylinder of radius one around z from 0 to 1, which faces outwards, under a map that leaves it a cylinder. Mirrored or
    /// not, it faces inwards with `flip_normals` only, as in Mitsuba 3.
    #[must_use]
    pub fn transformed(name: impl Into<String>, to_world: &DAffine3, flip_normals: bool, material: usize) -> Self {
        let DMat3 { x_axis, z_axis: axis, .. } = to_world.matrix3;
        let radius = x_axis.length();
        Self {
            name: name.into(),
            base: to_world.translation,
            axis,
            radius,
            meridian: x_axis / radius,
            clockwise: to_world.matrix3.determinant() < 0.0,
            inward: flip_normals,
            material,
        }
    }
}

/// A shape of a scene: its place in the description's list of its kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShapeIndex {
    /// A triangle mesh.
    Mesh(usize),
    /// A sphere.
    Sphere(usize),
    /// A disk.
    Disk(usize),
    /// A cylinder.
    Cylinder(usize),
}
