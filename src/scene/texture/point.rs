use std::collections::HashMap;

use glam::{DVec2, DVec3};

use crate::scene::PrimitiveId;

/// The values of one attribute at the corners of all triangles, by primitive id: linear RGB and opacity.
pub type AttributeTable = Vec<[[f32; 4]; 3]>;

/// What of a point of a surface its textures depend on.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint<'a> {
    /// Texture coordinates.
    pub uv: DVec2,
    /// How the position \[m\] changes with u and v; not unit vectors, and not at right angles in general.
    pub tangents: [DVec3; 2],
    /// The triangle or other shape.
    pub primitive: PrimitiveId,
    /// Barycentric weights of the triangle's second and third corner.
    pub barycentric: [f64; 2],
    /// The attributes of the scene's meshes that textures ask for, by name.
    pub attributes: &'a HashMap<String, AttributeTable>,
}

impl SurfacePoint<'_> {
    /// An attribute of the mesh here, interpolated; black and opaque where there is none.
    #[must_use]
    pub fn attribute(&self, name: &str) -> [f64; 4] {
        let Some([a, b, c]) = self.attributes.get(name).and_then(|table| table.get(self.primitive.0 as usize)) else {
            return [0.0, 0.0, 0.0, 1.0];
        };
        let [v, w] = self.barycentric;
        let u = 1.0 - v - w;
        std::array::from_fn(|i| u * f64::from(a[i]) + v * f64::from(b[i]) + w * f64::from(c[i]))
    }
}
