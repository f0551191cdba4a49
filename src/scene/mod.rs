//! From a file to a scene that can be traced.

pub mod accel;
pub mod bsdf;
mod build;
pub mod description;
pub mod discrete;
pub mod emitter;
pub mod error;
pub mod gltf;
mod mapping;
mod material;
pub mod mesh_file;
pub mod meter;
pub mod mitsuba;
mod scatter;
pub mod sensor;
mod surfaces;
pub mod texture;
mod varying;

use std::sync::OnceLock;

use glam::{DVec3, Vec3};

use crate::geometry::Ray;
use crate::measure::Probability;
use crate::path::{Vertex, VertexKind};
use crate::spectrum::Rgb;

use accel::{Accel, Hit, ShapePoint};
use bsdf::Bsdf;
use description::{Reference, RenderHints};
use discrete::Discrete;
use emitter::Emitter;
use mapping::Mapping;
use material::{Scattering, SurfaceMaterial};
use sensor::Sensor;
use texture::Texture;

pub use accel::PrimitiveId;
pub use build::{BuildError, LightSelection, SceneOptions};
pub use description::SceneDescription;
pub use emitter::EmitterId;
pub use error::SceneError;
pub use scatter::Scattered;
pub use surfaces::Surfaces;

/// Index of a material of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MaterialId(pub u32);

/// A scene ready for tracing. Positions are relative to [`centre`](Self::centre).
#[derive(Debug)]
pub struct Scene {
    name: String,
    source: std::path::PathBuf,
    centre: DVec3,
    accel: Accel,
    /// Shading normals of the triangles' corners, by triangle; empty where no mesh has any.
    normals: Vec<[Vec3; 3]>,
    mapping: Mapping,
    shapes: Vec<Shape>,
    materials: Vec<SurfaceMaterial>,
    emitters: Vec<Emitter>,
    choice: Discrete,
    environment: Option<EmitterId>,
    sensor: Sensor,
    hints: RenderHints,
    reference: Option<Reference>,
    /// Made when somebody asks.
    surfaces: OnceLock<Option<Surfaces>>,
    names: Names,
}

/// What the file calls things, by their ids.
#[derive(Clone, Debug, Default)]
struct Names {
    materials: Vec<String>,
    emitters: Vec<String>,
}

/// What all triangles of a mesh, or an analytic shape, have in common.
#[derive(Clone, Copy, Debug)]
struct Shape {
    material: MaterialId,
    emitter: Option<EmitterId>,
}

impl Scene {
    /// Its name in tables and file names.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The file that it was read from.
    #[must_use]
    pub fn source(&self) -> &std::path::Path {
        &self.source
    }

    /// The point of the world that positions of vertices are relative to \[m\].
    #[must_use]
    pub fn centre(&self) -> DVec3 {
        self.centre
    }

    /// Its camera.
    #[must_use]
    #[inline]
    pub fn sensor(&self) -> &Sensor {
        &self.sensor
    }

    /// What it suggests for rendering.
    #[must_use]
    pub fn hints(&self) -> RenderHints {
        self.hints
    }

    /// What images of it are compared with.
    #[must_use]
    pub fn reference(&self) -> Option<&Reference> {
        self.reference.as_ref()
    }

    /// The triangles and analytic shapes.
    #[must_use]
    pub fn accel(&self) -> &Accel {
        &self.accel
    }

    /// The models of those of its materials that are the same everywhere, by the names of these.
    pub(crate) fn bsdfs(&self) -> impl Iterator<Item = (&str, &Bsdf)> {
        let named = self.names.materials.iter().map(String::as_str).zip(&self.materials);
        named.filter_map(|(name, material)| match &material.scattering {
            Scattering::Uniform(bsdf) => Some((name, bsdf)),
            Scattering::Varying(_) => None,
        })
    }

    /// Of every material, by id: its model, `None` where it depends on the point, and whether its back is as its front.
    pub(crate) fn uniform_materials(&self) -> impl Iterator<Item = (Option<&Bsdf>, bool)> {
        self.materials.iter().map(|material| match &material.scattering {
            Scattering::Uniform(bsdf) => (Some(bsdf), material.two_sided),
            Scattering::Varying(_) => (None, false),
        })
    }

    /// All emitters, in the order of their ids; there is at least one.
    #[must_use]
    pub fn emitters(&self) -> &[Emitter] {
        &self.emitters
    }

    /// All surfaces as one; `None` where there are none.
    #[must_use]
    pub fn surfaces(&self) -> Option<&Surfaces> {
        self.surfaces.get_or_init(|| Surfaces::new(self)).as_ref()
    }

    /// An emitter by its id.
    #[must_use]
    #[inline]
    pub fn emitter(&self, id: EmitterId) -> &Emitter {
        &self.emitters[id.0 as usize]
    }

    /// What the file calls a material.
    #[must_use]
    pub fn material_name(&self, id: MaterialId) -> &str {
        &self.names.materials[id.0 as usize]
    }

    /// What the file calls an emitter: the mesh, the analytic shape or the light; `environment` for that.
    #[must_use]
    pub fn emitter_name(&self, id: EmitterId) -> &str {
        &self.names.emitters[id.0 as usize]
    }

    /// Chooses an emitter; `u` is uniform in `[0, 1)`.
    #[must_use]
    #[inline]
    pub fn choose_emitter(&self, u: f64) -> EmitterId {
        EmitterId(self.choice.sample(u) as u32)
    }

    /// The probability of [`choose_emitter`](Self::choose_emitter).
    #[must_use]
    #[inline]
    pub fn emitter_probability(&self, id: EmitterId) -> Probability {
        self.choice.probability(id.0 as usize)
    }

    /// The next vertex of a walk from `from` along the unit vector `direction`: a surface, the environment's sphere, or
    /// nothing. Lenses are no obstacle.
    #[must_use]
    #[inline(always)]
    pub fn trace(&self, from: &Vertex, direction: DVec3) -> Option<Vertex> {
        let ray = Ray::new(from.position, direction);
        match self.accel.closest(&ray, from.primitive()) {
            // On an edge of two triangles the other one may be met at the very point: no edge leads there.
            Some(hit) => Some(self.surface_vertex(&ray, &hit)).filter(|vertex| vertex.position != from.position),
            None => self.environment_beyond(&ray),
        }
    }

    /// `V(a, b)`: no surface lies strictly between. The same for both orders, bit for bit.
    #[must_use]
    #[inline]
    pub fn visible(&self, a: &Vertex, b: &Vertex) -> bool {
        !self.accel.occluded(a.position, a.primitive(), b.position, b.primitive())
    }

    /// What a texture says that a vertex emits to its front.
    #[inline(never)]
    fn textured_emission(&self, texture: &Texture, x0: &Vertex) -> Rgb {
        self.mapping.emitted(&self.accel, texture, x0.primitive(), x0.position)
    }

    fn environment_beyond(&self, ray: &Ray) -> Option<Vertex> {
        match self.emitter(self.environment?) {
            Emitter::Environment(environment) => Some(environment.beyond(ray.origin, ray.direction)),
            Emitter::EnvironmentMap(map) => Some(map.beyond(ray.origin, ray.direction)),
            _ => None,
        }
    }

    #[inline(always)]
    fn surface_vertex(&self, ray: &Ray, hit: &Hit) -> Vertex {
        let (position, normal, shading_normal, shape) = if let Some(shape) = self.accel.as_analytic(hit.primitive) {
            let ShapePoint { position, normal } = shape.nearest(ray.at(hit.t));
            (position, normal, normal, shape.shape())
        } else {
            let triangle = self.accel.triangle(hit.primitive);
            let normal = self.accel.normal(hit.primitive);
            (triangle.point(hit.barycentric), normal, self.shading_normal(hit, normal), triangle.shape)
        };
        let Shape { material, emitter } = self.shapes[shape as usize];
        let kind = VertexKind::Surface { primitive: hit.primitive, material, emitter };
        Vertex { position, normal, shading_normal, kind }
    }

    #[inline]
    fn shading_normal(&self, hit: &Hit, geometric: DVec3) -> DVec3 {
        let Some(corners) = self.normals.get(hit.primitive.0 as usize) else { return geometric };
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let [v, w] = hit.barycentric;
        // A flat mesh among smooth ones stores zeros.
        (a * (1.0 - v - w) + b * v + c * w).try_normalize().unwrap_or(geometric)
    }

    #[inline]
    fn material_of(&self, vertex: &Vertex) -> &SurfaceMaterial {
        match vertex.kind {
            VertexKind::Surface { material, .. } => &self.materials[material.0 as usize],
            _ => unreachable!("only surfaces scatter"),
        }
    }
}
