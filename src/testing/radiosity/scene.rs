//! The scenes that the solver accepts: flat diffuse triangles.

use std::f64::consts::PI;

use glam::DVec3;

use crate::geometry::Bounds;
use crate::scene::description::{BsdfDescription, Lens, Mesh, PixelFilter, Projection, SensorDescription};
use crate::scene::texture::Parameter;
use crate::scene::{PrimitiveId, Scene, SceneDescription, SceneOptions};
use crate::spectrum::Rgb;

use super::error::RadiosityError;
use super::obstacle::Obstacle;
use super::polygon::{Corners, Plane, Polygon, area_vector};

/// One side of a triangle of the scene: a two-sided triangle has two.
#[derive(Clone, Copy, Debug)]
pub struct Facet {
    /// Counter-clockwise seen from the side that it is, relative to the scene's centre \[m\].
    pub corners: [DVec3; 3],
    /// Unit normal of its side.
    pub normal: DVec3,
    /// The triangle.
    pub primitive: PrimitiveId,
    /// Index of its mesh in the description.
    pub mesh: usize,
    /// ρ, the share of the flux that it reflects.
    pub reflectance: Rgb,
    /// Radiosity of its own, π L_e \[W/m²\].
    pub emission: Rgb,
}

impl Facet {
    pub(super) fn plane(&self) -> Plane {
        Plane::at(self.corners[0], self.normal)
    }
}

/// A point of a surface.
#[derive(Clone, Copy, Debug)]
pub struct FacetPoint {
    /// Index into [`DiffuseScene::facets`].
    pub facet: usize,
    /// Where it is, relative to the scene's centre \[m\].
    pub position: DVec3,
}

/// A scene of flat diffuse surfaces, with the geometry that integrators see: corners as they are rounded for tracing.
#[derive(Debug)]
pub struct DiffuseScene {
    scene: Scene,
    facets: Vec<Facet>,
    /// The triangles with some of the scene on either side: no other can lie between two points of surfaces.
    obstacles: Vec<Obstacle>,
    /// Up to this distance from a plane \[m\] a point counts as on it.
    flat: f64,
    camera: SensorDescription,
}

impl DiffuseScene {
    /// Accepts a description.
    ///
    /// # Errors
    /// Names what is not a flat diffuse surface, or what [`Scene::build`] refuses.
    pub fn new(description: &SceneDescription) -> Result<Self, RadiosityError> {
        check(description)?;
        let (scene, _) = Scene::build(description, SceneOptions::default())?;
        let camera = description.sensor.clone().or_else(|| description.framing_camera());
        // Scene::build has made one or refused.
        let camera = camera.ok_or_else(|| crate::scene::BuildError::NoCamera(description.source.clone()))?;
        let mut facets = Vec::new();
        for (primitive, triangle) in scene.accel().triangles() {
            let [a, b, c] = triangle.corners;
            let mesh = triangle.shape as usize;
            let material = &description.materials[description.meshes[mesh].material];
            let BsdfDescription::Diffuse { reflectance: Parameter::Constant(reflectance) } = material.bsdf else {
                continue;
            };
            let Some(normal) = area_vector(&[a, b, c]).try_normalize() else { continue };
            let side = |corners: Corners, normal: DVec3, emission: Rgb| Facet {
                corners,
                normal,
                primitive,
                mesh,
                reflectance,
                emission,
            };
            facets.push(side([a, b, c], normal, *material.emission.constant().unwrap_or(&Rgb::BLACK) * PI));
            if material.two_sided {
                facets.push(side([a, c, b], -normal, Rgb::BLACK));
            }
        }
        let flat = 1e-6 * Bounds::around(facets.iter().flat_map(|f| f.corners)).radius();
        let obstacles = Obstacle::all(&scene, flat);
        Ok(Self { scene, facets, obstacles, flat, camera })
    }

    /// The sides of triangles that light leaves.
    #[must_use]
    pub fn facets(&self) -> &[Facet] {
        &self.facets
    }

    /// The scene as integrators see it.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The camera, its position relative to the scene's centre \[m\].
    pub(super) fn camera(&self) -> SensorDescription {
        SensorDescription { position: self.camera.position - self.scene.centre(), ..self.camera.clone() }
    }

    /// Something may lie between some two points of the convex hull of these, apart from the given facets' triangles.
    /// False only where nothing can.
    pub(super) fn may_obstruct(&self, points: &[DVec3], own: [usize; 2]) -> bool {
        let own = own.map(|facet| self.facets[facet].primitive);
        let hull = Bounds::around(points.iter().copied());
        self.obstacles.iter().any(|obstacle| obstacle.may_obstruct(points, &hull, own, self.flat))
    }

    /// What is seen from x of a polygon of a facet, in convex parts; `None` where nothing can lie between.
    pub(super) fn visible_parts(&self, x: FacetPoint, facet: usize, polygon: &[DVec3]) -> Option<Vec<Polygon>> {
        let own = [x.facet, facet].map(|facet| self.facets[facet].primitive);
        let points: Polygon = polygon.iter().copied().chain([x.position]).collect();
        let hull = Bounds::around(points.iter().copied());
        let mut parts = None;
        for obstacle in self.obstacles.iter().filter(|o| o.may_obstruct(&points, &hull, own, self.flat)) {
            let before = parts.unwrap_or_else(|| vec![Polygon::from_slice(polygon)]);
            parts = Some(obstacle.hide(x.position, before, self.flat));
        }
        parts
    }

    /// Nothing lies strictly between two points of the given triangles.
    pub(super) fn visible(&self, a: DVec3, on_a: PrimitiveId, b: DVec3, on_b: PrimitiveId) -> bool {
        !self.scene.accel().occluded(a, on_a, b, on_b)
    }
}

fn check(description: &SceneDescription) -> Result<(), RadiosityError> {
    if let Some(sphere) = description.spheres.first() {
        return Err(RadiosityError::Sphere(sphere.name.clone()));
    }
    if let Some(light) = description.lights.first() {
        return Err(RadiosityError::Light(light.name.clone()));
    }
    if description.environment.is_some() {
        return Err(RadiosityError::Environment);
    }
    for mesh in &description.meshes {
        let material = &description.materials[mesh.material];
        if !matches!(material.bsdf, BsdfDescription::Diffuse { reflectance: Parameter::Constant(_) }) {
            return Err(RadiosityError::NotDiffuse(material.name.clone()));
        }
        if !is_flat(mesh) {
            return Err(RadiosityError::ShadingNormals(mesh.name.clone()));
        }
    }
    match &description.sensor {
        Some(SensorDescription {
            name,
            projection:
                Projection::Perspective { lens: Some(Lens { .. }), .. }
                | Projection::Hemisphere
                | Projection::Window { .. }
                | Projection::Ray
                | Projection::Surface { .. }
                | Projection::Distant { .. },
            ..
        }) => Err(RadiosityError::Lens(name.clone())),
        Some(camera) if camera.window != SensorDescription::WHOLE => Err(RadiosityError::Film(camera.name.clone())),
        Some(camera) if description.filter != PixelFilter::Box => Err(RadiosityError::Film(camera.name.clone())),
        _ => Ok(()),
    }
}

/// Vertex normals, where there are any, are those of the triangles.
fn is_flat(mesh: &Mesh) -> bool {
    let Some(normals) = &mesh.normals else { return true };
    mesh.triangles.iter().all(|triangle| {
        let corners = triangle.map(|i| mesh.positions[i as usize]);
        let normal = area_vector(&corners).normalize_or_zero();
        normal == DVec3::ZERO || triangle.iter().all(|&i| normals[i as usize].distance(normal) < 1e-5)
    })
}
