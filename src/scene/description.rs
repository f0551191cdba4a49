//! What a scene file says, whatever its format: the common ground of readers, the renderer and exporters.
//!
//! Everything is in world coordinates and double precision, as composed from the file's transforms. Readers check what
//! only they can name (a place in the file); [`Scene::build`](super::Scene::build) checks the rest.

use std::path::PathBuf;
use std::sync::Arc;

use glam::{DVec3, Vec2};
use serde::{Deserialize, Serialize};

use super::meter::NamedMeter;
use super::texture::{Parameter, Texture};
use crate::spectrum::Rgb;

/// A whole scene as its file describes it.
#[derive(Clone, Debug, Default)]
pub struct SceneDescription {
    /// Name for tables and file names: that of the folder in `scenes/`, or of the file without its ending.
    pub name: String,
    /// The file it was read from.
    pub source: PathBuf,
    /// Triangle meshes, one for each node that draws a primitive.
    pub meshes: Vec<Mesh>,
    /// Analytic spheres.
    pub spheres: Vec<Sphere>,
    /// What meshes and spheres are made of; they refer to it by index.
    pub materials: Vec<Material>,
    /// Lights without a surface.
    pub lights: Vec<Light>,
    /// Radiance of a constant environment \[W/m²/sr\], where there is one.
    pub environment: Option<Rgb>,
    /// The camera; `None` asks for one that frames the scene.
    pub sensor: Option<SensorDescription>,
    /// Sensors besides the camera, which `measure` measures.
    pub meters: Vec<NamedMeter>,
    /// Size of the image in pixels; `None` leaves it to the command line or the default.
    pub film: Option<FilmSize>,
    /// Settings that the scene suggests for a comparison.
    pub render: RenderHints,
    /// The image that its errors are measured against.
    pub reference: Option<Reference>,
    /// What the reader took differently from what the file says; each a sentence for the user.
    pub warnings: Vec<String>,
}

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
    /// Index into [`SceneDescription::materials`].
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

/// An analytic sphere; its front is the outside.
#[derive(Clone, Debug)]
pub struct Sphere {
    /// Name in the file, for messages.
    pub name: String,
    /// Centre \[m\].
    pub centre: DVec3,
    /// Radius \[m\], positive.
    pub radius: f64,
    /// Index into [`SceneDescription::materials`].
    pub material: usize,
}

/// How a surface scatters and what it emits.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in the file, for messages.
    pub name: String,
    /// How it scatters.
    pub bsdf: BsdfDescription,
    /// Both sides scatter alike. Otherwise the back absorbs. Dielectrics have an inside and ignore this.
    pub two_sided: bool,
    /// Radiance leaving the front in every direction \[W/m²/sr\]. The back never emits.
    pub emission: Rgb,
}

impl Material {
    /// It emits at all.
    #[must_use]
    pub fn emits(&self) -> bool {
        !self.emission.is_black()
    }
}

/// How a surface scatters; in glTF the material's `extras.pathspace.bsdf` says those without a texture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum BsdfDescription {
    /// Lambert's: `f_s = reflectance / π`.
    Diffuse {
        /// Share of the flux that is reflected, 0 … 1.
        reflectance: Parameter<Rgb>,
    },
    /// Smooth metal or mirror.
    Conductor {
        /// What reflects how much.
        fresnel: ConductorFresnel,
    },
    /// Rough metal: GGX microfacets, single scattering.
    RoughConductor {
        /// GGX roughness α, above 0.
        alpha: Parameter<f64>,
        /// What reflects how much.
        fresnel: ConductorFresnel,
    },
    /// Smooth glass. The normal points to the outside.
    Dielectric {
        /// Index of refraction of the inside.
        interior_ior: f64,
        /// Index of refraction of the outside.
        #[serde(default = "one")]
        exterior_ior: f64,
    },
    /// Rough glass: GGX microfacets, single scattering (Walter et al. 2007).
    RoughDielectric {
        /// GGX roughness α, above 0.
        alpha: Parameter<f64>,
        /// Index of refraction of the inside.
        interior_ior: f64,
        /// Index of refraction of the outside.
        #[serde(default = "one")]
        exterior_ior: f64,
    },
    /// Light goes straight through: there is no surface but in the count of edges.
    Null,
    /// One model for each side. Neither transmits.
    TwoSided {
        /// On the side that the normal points to.
        front: Box<BsdfDescription>,
        /// On the other, as if the normal pointed there.
        back: Box<BsdfDescription>,
    },
    /// The nested model by `opacity`, straight through by the rest.
    Mask {
        /// Share of the nested model, 0 … 1.
        opacity: Parameter<f64>,
        /// The nested model.
        nested: Box<BsdfDescription>,
    },
    /// `(1 − weight) first + weight second`.
    Blend {
        /// Share of the second model, 0 … 1.
        weight: Parameter<f64>,
        /// The model at weight 0.
        first: Box<BsdfDescription>,
        /// The model at weight 1.
        second: Box<BsdfDescription>,
    },
    /// The nested model under a turned normal.
    #[serde(skip)]
    Perturbed {
        /// What turns it.
        normal: NormalSource,
        /// The nested model.
        nested: Box<BsdfDescription>,
    },
}

/// What turns the shading normal of a point.
#[derive(Clone, Debug, PartialEq)]
pub enum NormalSource {
    /// A normal map: `2 · rgb − 1` in the frame of the tangent along u, the tangent at right angles to it, and the normal.
    Map {
        /// The map.
        texture: Arc<Texture>,
        /// Factors of the first two coordinates.
        scale: [f64; 2],
        /// The second axis follows v where this is true (glTF, against v), and normal × first axis otherwise (Mitsuba).
        against_v: bool,
    },
    /// A bump map: the surface displaced along its normal by a height \[m\] (Blinn 1978).
    Bump {
        /// The height.
        texture: Arc<Texture>,
        /// Its factor.
        scale: f64,
    },
}

/// How a metal's reflectance depends on the angle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, deny_unknown_fields)]
pub enum ConductorFresnel {
    /// Fresnel's equations with the complex index of refraction `eta + i k`, per channel, relative to the outside.
    Ior {
        /// Real part.
        eta: Rgb,
        /// Imaginary part, the extinction coefficient.
        k: Rgb,
    },
    /// The same reflectance at every angle.
    Tint {
        /// Share of the flux that is reflected, 0 … 1.
        specular_tint: Rgb,
    },
}

/// A light without a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Name in the file, for messages.
    pub name: String,
    /// What it is.
    pub kind: LightKind,
}

/// Kinds of light without a surface. Photometric units of a file are read as radiometric ones, without the factor 683.
#[derive(Clone, Debug, PartialEq)]
pub enum LightKind {
    /// Shines from one point, equally in all directions.
    Point {
        /// Where \[m\].
        position: DVec3,
        /// Intensity \[W/sr\].
        intensity: Rgb,
    },
    /// Shines from one point into a cone. Intensity falls off linearly in the *angle*, from the inner to the outer cone.
    Spot {
        /// Where \[m\].
        position: DVec3,
        /// Axis of the cone, of length one.
        direction: DVec3,
        /// Intensity on the axis \[W/sr\].
        intensity: Rgb,
        /// Angle from the axis up to which the intensity is full \[rad\].
        inner_angle: f64,
        /// Angle from the axis from which it is dark \[rad\], above the inner one and at most π/2.
        outer_angle: f64,
    },
    /// Shines in one direction from infinitely far away.
    Directional {
        /// Where the light goes, of length one.
        direction: DVec3,
        /// Irradiance on a surface that faces it \[W/m²\].
        irradiance: Rgb,
    },
}

/// Pixels of the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FilmSize {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

/// A camera. It looks along `forward`, with `up` towards the top of the image; the two are orthonormal.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorDescription {
    /// Name in the file, for messages.
    pub name: String,
    /// Centre of projection, or of the lens, or of the orthographic film \[m\].
    pub position: DVec3,
    /// Viewing direction, of length one.
    pub forward: DVec3,
    /// Towards the top of the image, of length one and at right angles to `forward`.
    pub up: DVec3,
    /// How points become pixels.
    pub projection: Projection,
}

/// How a camera maps the world to its image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Central projection through a pinhole or a thin lens.
    Perspective {
        /// Full vertical field of view \[rad\].
        vertical_fov: f64,
        /// Width over height of the field of view; `None` takes the film's, so that pixels are square.
        aspect: Option<f64>,
        /// A thin lens, where it is no pinhole.
        lens: Option<Lens>,
    },
    /// Parallel projection.
    Orthographic {
        /// Half the width of what is seen \[m\].
        half_width: f64,
        /// Half the height of what is seen \[m\].
        half_height: f64,
    },
    /// No image but a meter: all light that arrives at the position from the hemisphere around `forward`, by its cosine. The
    /// pixels share the hemisphere; π times their mean is the irradiance \[W/m²\].
    Hemisphere,
    /// No image but a meter: all light that arrives at a rectangle from the hemisphere around `forward`. The pixels share the
    /// rectangle; π times their mean is the mean irradiance \[W/m²\].
    Window {
        /// Half the extent across `up` \[m\].
        half_width: f64,
        /// Half the extent along `up` \[m\].
        half_height: f64,
    },
    /// No image but a meter: the radiance that arrives at the position along `forward` \[W/m²/sr\], in a single pixel.
    Ray,
}

/// A thin lens.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lens {
    /// Radius of the aperture \[m\], positive.
    pub aperture_radius: f64,
    /// Distance along the viewing direction of the plane in focus \[m\], positive.
    pub focus_distance: f64,
}

/// Settings that a scene suggests; the command line overrides them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RenderHints {
    /// Longest path in edges; `None` is unlimited.
    pub max_length: Option<u32>,
}

/// What the errors of an image are measured against.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Reference {
    /// An image beside the scene's file.
    Image {
        /// Its path, relative to the scene's file.
        file: PathBuf,
        /// Longest path in edges that it holds; `None` is unlimited. It is compared with images of the same length only.
        #[serde(default)]
        max_length: Option<u32>,
    },
    /// The closed diffuse enclosure: `L = emission · Σ_{i<K} reflectance^i` for paths of at most K edges, in every pixel.
    Enclosure {
        /// Emission of every surface \[W/m²/sr\].
        emission: Rgb,
        /// Reflectance of every surface.
        reflectance: Rgb,
    },
}

fn one() -> f64 {
    1.0
}
