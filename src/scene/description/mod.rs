//! What a scene file says, whatever its format: the common ground of readers, the renderer and exporters.
//!
//! Everything is in world coordinates and double precision, as composed from the file's transforms. Readers check what
//! only they can name (a place in the file); [`Scene::build`](super::Scene::build) checks the rest.

mod gltf;
mod light;
mod material;
mod sensor;
mod shape;

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::meter::NamedMeter;
use crate::spectrum::Rgb;

pub use gltf::{GltfAnisotropy, GltfCoat, GltfDescription, GltfSheen, GltfVolume, Slot};
pub use light::{EnvironmentDescription, Light, LightKind};
pub use material::{BsdfDescription, ConductorFresnel, Material, MicrofacetKind, NormalSource, PrincipledDescription};
pub use sensor::{FilmSize, Lens, PixelFilter, Projection, SensorDescription, Target};
pub use shape::{Attribute, Cylinder, Disk, Mesh, ShapeIndex, Sphere};

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
    /// Analytic disks.
    pub disks: Vec<Disk>,
    /// Analytic cylinders.
    pub cylinders: Vec<Cylinder>,
    /// What surfaces are made of; they refer to it by index.
    pub materials: Vec<Material>,
    /// Lights without a surface.
    pub lights: Vec<Light>,
    /// The light from infinitely far away in all directions, where there is some.
    pub environment: Option<EnvironmentDescription>,
    /// The camera; `None` asks for one that frames the scene.
    pub sensor: Option<SensorDescription>,
    /// Sensors besides the camera, which `measure` measures.
    pub meters: Vec<NamedMeter>,
    /// Size of the image in pixels; `None` leaves it to the command line or the default.
    pub film: Option<FilmSize>,
    /// How pixels respond to what surrounds them.
    pub filter: PixelFilter,
    /// Settings that the scene suggests for a comparison.
    pub render: RenderHints,
    /// The image that its errors are measured against.
    pub reference: Option<Reference>,
    /// Values of the file's parameters that were used, where its format has such.
    pub parameters: BTreeMap<String, String>,
    /// What the reader took differently from what the file says; each a sentence for the user.
    pub warnings: Vec<String>,
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
