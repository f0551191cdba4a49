//! What a scene is made of, in numbers: beside a path log all that f(x̄) and p(x̄) depend on.

use serde::Serialize;

use crate::scene::Scene;
use crate::scene::accel::{AnalyticShape, PrimitiveId};
use crate::scene::bsdf::{Bsdf, Microfacets, Tints};
use crate::scene::description::{ConductorFresnel, Lens};
use crate::scene::emitter::{Emitter, EmitterId, ShapeEmitter};
use crate::scene::texture::Parameter;
use crate::spectrum::Rgb;

/// The version of what [`SceneRecord`] holds.
pub const SCENE_SCHEMA: u32 = 1;

/// The parameters of a scene after it is built. Positions are relative to `centre`, as `local` of a
/// [`VertexRecord`](super::VertexRecord) is. What has no closed form here is `other`: textures and composites, models and
/// emitters that are not listed, meters, filters wider than a pixel's box.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SceneRecord {
    /// [`SCENE_SCHEMA`].
    pub schema: u32,
    /// Its name.
    pub scene: String,
    /// The point of the world that positions are relative to \[m\].
    pub centre: [f64; 3],
    /// By id.
    pub materials: Vec<MaterialRecord>,
    /// By id.
    pub emitters: Vec<EmitterRecord>,
    /// The camera.
    pub sensor: SensorRecord,
}

/// A material.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MaterialRecord {
    /// Its name in the file.
    pub name: String,
    /// The back is as the front.
    pub two_sided: bool,
    /// How it scatters.
    #[serde(flatten)]
    pub model: ModelRecord,
}

/// How a surface scatters, as [`BsdfDescription`](crate::scene::description::BsdfDescription) has it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum ModelRecord {
    /// Lambert's.
    Diffuse {
        /// Share of the flux that is reflected.
        reflectance: Rgb,
    },
    /// Metal: smooth, or rough with GGX microfacets.
    Conductor {
        /// α along u and v; `null` where it is smooth.
        alpha: Option<[f64; 2]>,
        /// What reflects how much.
        fresnel: ConductorFresnel,
        /// A factor of it.
        reflectance: Rgb,
    },
    /// Glass: smooth, or rough with GGX microfacets.
    Dielectric {
        /// α along u and v; `null` where it is smooth.
        alpha: Option<[f64; 2]>,
        /// η − 1, with η the index of the inside over that of the outside.
        contrast: f64,
        /// Factor of what is reflected.
        reflectance: Rgb,
        /// Factor of what is refracted.
        transmittance: Rgb,
    },
    /// Any other.
    Other,
}

/// An emitter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EmitterRecord {
    /// Its name in the file.
    pub name: String,
    /// The probability of choosing it.
    pub probability: f64,
    /// What it is.
    #[serde(flatten)]
    pub kind: EmitterKind,
}

/// Kinds of emitter.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum EmitterKind {
    /// The front of a mesh.
    Mesh {
        /// Radiance \[W/m²/sr\].
        radiance: Rgb,
        /// Corners of its triangles \[m\].
        triangles: Vec<[[f64; 3]; 3]>,
    },
    /// The front of a sphere.
    Sphere {
        /// Radiance \[W/m²/sr\].
        radiance: Rgb,
        /// Where \[m\].
        centre: [f64; 3],
        /// Radius \[m\].
        radius: f64,
        /// Its front is the inside.
        inward: bool,
    },
    /// Shines from one point in all directions.
    Point {
        /// Intensity \[W/sr\].
        intensity: Rgb,
    },
    /// The same from everywhere.
    Environment {
        /// Radiance \[W/m²/sr\].
        radiance: Rgb,
        /// Radius of the sphere that stands for infinity, around the centre \[m\].
        sphere_radius: f64,
    },
    /// Any other.
    Other,
}

/// The sensor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum SensorRecord {
    /// A pinhole or a thin lens, as [`Camera`](crate::scene::sensor::Camera) has it.
    Camera {
        /// Columns and rows.
        film: [u32; 2],
        /// Where \[m\].
        position: [f64; 3],
        /// Where it looks.
        forward: [f64; 3],
        /// Half the extent of the image at distance one, towards right and up.
        half_extent: [f64; 2],
        /// `null` for a pinhole.
        lens: Option<Lens>,
    },
    /// Any other.
    Other {
        /// Columns and rows.
        film: [u32; 2],
    },
}

impl SceneRecord {
    /// Of a scene.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        let materials = (0..).zip(scene.uniform_materials()).map(|(id, (bsdf, two_sided))| MaterialRecord {
            name: scene.material_name(crate::scene::MaterialId(id)).to_owned(),
            two_sided,
            model: bsdf.map_or(ModelRecord::Other, ModelRecord::new),
        });
        let emitters = (0..).zip(scene.emitters()).map(|(id, emitter)| EmitterRecord {
            name: scene.emitter_name(EmitterId(id)).to_owned(),
            probability: scene.emitter_probability(EmitterId(id)).value(),
            kind: EmitterKind::new(scene, emitter),
        });
        Self {
            schema: SCENE_SCHEMA,
            scene: scene.name().to_owned(),
            centre: scene.centre().to_array(),
            materials: materials.collect(),
            emitters: emitters.collect(),
            sensor: SensorRecord::new(scene),
        }
    }
}

impl ModelRecord {
    fn new(bsdf: &Bsdf) -> Self {
        let ggx = |distribution| match distribution {
            Microfacets::Ggx(ggx) => Some(ggx.alpha()),
            Microfacets::Beckmann(_) => None,
        };
        let dielectric = |alpha, contrast, Tints { reflectance, transmittance }| Self::Dielectric {
            alpha,
            contrast,
            reflectance,
            transmittance,
        };
        match bsdf {
            Bsdf::Diffuse(model) => Self::Diffuse { reflectance: model.reflectance },
            Bsdf::Conductor(model) => {
                Self::Conductor { alpha: None, fresnel: model.fresnel.clone(), reflectance: model.reflectance }
            }
            Bsdf::RoughConductor(model) => ggx(model.distribution).map_or(Self::Other, |alpha| Self::Conductor {
                alpha: Some(alpha),
                fresnel: model.fresnel.clone(),
                reflectance: model.reflectance,
            }),
            Bsdf::Dielectric(model) => dielectric(None, model.interface.contrast(), model.tints),
            Bsdf::RoughDielectric(model) => ggx(model.distribution)
                .map_or(Self::Other, |alpha| dielectric(Some(alpha), model.interface.contrast(), model.tints)),
            _ => Self::Other,
        }
    }
}

impl EmitterKind {
    fn new(scene: &Scene, emitter: &Emitter) -> Self {
        match emitter {
            Emitter::Mesh(mesh) => constant(&mesh.radiance).map_or(Self::Other, |radiance| {
                let corners = |&id: &PrimitiveId| scene.accel().triangle(id).corners.map(|c| c.to_array());
                Self::Mesh { radiance, triangles: mesh.triangles.iter().map(corners).collect() }
            }),
            Emitter::Shape(ShapeEmitter { radiance, primitive, .. }) => {
                match (constant(radiance), scene.accel().as_analytic(*primitive)) {
                    (Some(radiance), Some(AnalyticShape::Sphere(sphere))) => Self::Sphere {
                        radiance,
                        centre: sphere.centre.to_array(),
                        radius: sphere.radius,
                        inward: sphere.inward,
                    },
                    _ => Self::Other,
                }
            }
            Emitter::Point(light) => Self::Point { intensity: light.intensity },
            Emitter::Environment(light) => {
                Self::Environment { radiance: light.radiance, sphere_radius: light.sphere_radius }
            }
            _ => Self::Other,
        }
    }
}

impl SensorRecord {
    fn new(scene: &Scene) -> Self {
        let size = scene.sensor().film();
        let film = [size.width, size.height];
        scene.sensor().camera().map_or(Self::Other { film }, |camera| Self::Camera {
            film,
            position: camera.position.to_array(),
            forward: camera.forward.to_array(),
            half_extent: camera.half_extent.to_array(),
            lens: camera.lens,
        })
    }
}

fn constant(radiance: &Parameter<Rgb>) -> Option<Rgb> {
    radiance.constant().copied()
}
