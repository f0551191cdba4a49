//! From a description to a scene: centring, rounding, choosing what is sampled, and refusing what makes no sense.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::OnceLock;

use glam::{DVec3, Vec2, Vec3};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::geometry::Bounds;

use super::accel::{Accel, SphereShape, Triangle};
use super::bsdf::{Composite, MaterialError};
use super::description::{
    EnvironmentDescription, FilmSize, LightKind, Material, Mesh, PixelFilter, Projection, SensorDescription,
    ShapeIndex, Target,
};
use super::discrete::Discrete;
use super::emitter::{Directional, Emitter, EmitterId, Environment, MeshEmitter, Point, SphereEmitter, Spot};
use super::mapping::Mapping;
use super::material::SurfaceMaterial;
use super::sensor::{self, Sensor};
use super::texture::Texture;
use super::{MaterialId, Names, Scene, SceneDescription, Shape, Surfaces};
use crate::spectrum::Rgb;

/// What a user may decide about a scene beyond its file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SceneOptions {
    /// Size of the image instead of the file's.
    pub film: Option<FilmSize>,
    /// How emitters are chosen.
    pub light_selection: LightSelection,
}

/// How one of several emitters is chosen, for emission and for direct light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LightSelection {
    /// In proportion to its flux.
    #[default]
    Power,
    /// All alike, as Mitsuba does.
    Uniform,
}

/// Why a description is no scene.
#[derive(Debug, Error)]
pub enum BuildError {
    /// Nothing emits.
    #[error("{}: no light: give a material an emission, add a light, or render with --environment 1", .0.display())]
    NoLight(PathBuf),
    /// No camera, and nothing that one could be pointed at.
    #[error("{}: no camera and nothing to frame: add a camera node", .0.display())]
    NoCamera(PathBuf),
    /// The image has no pixels.
    #[error("{}: a film of {}×{} pixels: both sides must be between 1 and 65535", file.display(), size.width, size.height)]
    EmptyFilm {
        /// The file.
        file: PathBuf,
        /// The size.
        size: FilmSize,
    },
    /// A parameter is out of range.
    #[error("{}: {place}: {what}", file.display())]
    Invalid {
        /// The file.
        file: PathBuf,
        /// Which thing in it.
        place: String,
        /// What is wrong, and what would be right.
        what: String,
    },
}

impl Scene {
    /// Makes a scene of its description. The second result are sentences for the user about what was decided for them.
    ///
    /// # Errors
    /// [`BuildError`] where there is no light, nothing to look at, or a parameter that makes no sense.
    pub fn build(description: &SceneDescription, options: SceneOptions) -> Result<(Self, Vec<String>), BuildError> {
        Builder { description, options, notes: description.warnings.clone() }.build()
    }
}

struct Builder<'a> {
    description: &'a SceneDescription,
    options: SceneOptions,
    notes: Vec<String>,
}

impl Builder<'_> {
    fn build(mut self) -> Result<(Scene, Vec<String>), BuildError> {
        let materials = self.description.materials.iter().map(|m| self.material(m)).collect::<Result<Vec<_>, _>>()?;
        let geometry = bounds(self.description);
        let camera = sensor::placed(self.camera(geometry)?, geometry);
        let film = self.film(&camera)?;
        let everything = self.everything(geometry, &camera);
        let centre = everything.centre();
        let sensor = Sensor::new(&camera, film, self.description.filter, centre);
        let (accel, normals, order) = self.geometry(centre, everything.radius());
        let mapping = self.mapping(&order, &materials);
        let mut shapes = self.shapes();
        let reach = self.reach(geometry, &sensor, centre);
        let emitters = self.emitters(&accel, &mut shapes, centre, reach)?;
        let choice = Discrete::new(emitters.iter().map(|e| match self.options.light_selection {
            LightSelection::Power => e.flux().mean(),
            LightSelection::Uniform => 1.0,
        }));
        let choice = choice.ok_or_else(|| self.invalid("lights", "a flux that is not finite: check the emission"))?;
        let environment = emitters.iter().position(|e| matches!(e, Emitter::Environment(_)));
        let names = self.names(&shapes);
        let mut scene = Scene {
            name: self.description.name.clone(),
            source: self.description.source.clone(),
            centre,
            accel,
            normals,
            mapping,
            shapes,
            materials,
            emitters,
            choice,
            environment: environment.map(|i| EmitterId(i as u32)),
            sensor,
            hints: self.description.render,
            reference: self.description.reference.clone(),
            surfaces: OnceLock::new(),
            names,
        };
        if let Projection::Surface { shape } = camera.projection {
            let surface = self.shape_number(shape).and_then(|number| Surfaces::of_shape(&scene, number));
            let nothing = || self.invalid(&format!("sensor '{}'", camera.name), "its shape is missing or has no area");
            let surface = surface.ok_or_else(nothing)?;
            scene.sensor.attach(surface);
        }
        Ok((scene, self.notes))
    }

    fn invalid(&self, place: &str, what: &str) -> BuildError {
        BuildError::Invalid { file: self.description.source.clone(), place: place.into(), what: what.into() }
    }

    fn material(&self, material: &Material) -> Result<SurfaceMaterial, BuildError> {
        let place = || format!("material '{}'", material.name);
        let model =
            Composite::new(&material.bsdf).map_err(|e: MaterialError| self.invalid(&place(), &e.to_string()))?;
        if material
            .emission
            .constant()
            .unwrap_or(&Rgb::BLACK)
            .to_array()
            .iter()
            .any(|c| !(0.0..f64::INFINITY).contains(c))
        {
            return Err(self.invalid(&place(), "the emission must be finite and not negative"));
        }
        Ok(SurfaceMaterial::new(model, material.two_sided))
    }

    /// Everything that rays start from or end at, at finite distance.
    fn everything(&self, geometry: Bounds, camera: &SensorDescription) -> Bounds {
        let lights = self.description.lights.iter().filter_map(|light| match light.kind {
            LightKind::Point { position, .. }
            | LightKind::Spot { position, .. }
            | LightKind::Projector { position, .. } => Some(position),
            LightKind::Directional { .. } => None,
        });
        geometry.union(Bounds::around(lights.chain([camera.position])))
    }

    /// Radius of the sphere around `centre` that stands for infinity: geometry and sensor lie well inside.
    fn reach(&self, geometry: Bounds, sensor: &Sensor, centre: DVec3) -> f64 {
        let corners = if geometry.is_empty() { 0.0 } else { (geometry.centre() - centre).length() + geometry.radius() };
        let reach = corners.max(sensor.position().length() + sensor.extent());
        1.001 * if reach > 0.0 { reach } else { 1.0 }
    }

    fn camera(&mut self, geometry: Bounds) -> Result<SensorDescription, BuildError> {
        if let Some(camera) = &self.description.sensor {
            let [first, last] = camera.window;
            if !(first.is_finite() && last.is_finite() && first.cmplt(last).all()) {
                let what = "its film covers nothing of the image: the window's first corner must be left of and above the last";
                return Err(self.invalid(&format!("camera '{}'", camera.name), what));
            }
            if let Projection::Distant { target: Target::Parallelogram { u, v, .. } | Target::Ellipse { u, v, .. } } =
                camera.projection
            {
                let seen = u.cross(v).dot(camera.forward).abs();
                // Not so for a side that is no number either.
                if !(seen > 1e-9 * u.length() * v.length()) {
                    let what = "it sees its target edge-on: turn one of them, or give the target an area";
                    return Err(self.invalid(&format!("sensor '{}'", camera.name), what));
                }
            }
            return Ok(camera.clone());
        }
        let camera = framing_camera(geometry).ok_or_else(|| BuildError::NoCamera(self.description.source.clone()))?;
        self.notes.push("no camera in the file: one that frames the whole scene is used".into());
        Ok(camera)
    }

    fn film(&self, camera: &SensorDescription) -> Result<FilmSize, BuildError> {
        let covered = camera.window[1] - camera.window[0];
        let width = 256;
        let height = |aspect: f64| ((f64::from(width) / aspect * covered.y / covered.x).round() as u32).max(1);
        let default = match camera.projection {
            Projection::Perspective { aspect, .. } => FilmSize { width, height: height(aspect.unwrap_or(1.0)) },
            Projection::Orthographic { half_width, half_height } => {
                FilmSize { width, height: height(half_width / half_height) }
            }
            Projection::Hemisphere | Projection::Window { .. } => FilmSize { width: 64, height: 64 },
            Projection::Ray | Projection::Surface { .. } | Projection::Distant { .. } => {
                FilmSize { width: 1, height: 1 }
            }
        };
        if !self.description.filter.is_valid() {
            let what = format!(
                "a {} filter: its radius must be above 0 and at most {} pixels",
                self.description.filter,
                PixelFilter::LARGEST_RADIUS
            );
            return Err(self.invalid("film", &what));
        }
        let size = self.options.film.or(self.description.film).unwrap_or(default);
        let valid = 1..=65535;
        if valid.contains(&size.width) && valid.contains(&size.height) {
            Ok(size)
        } else {
            Err(BuildError::EmptyFilm { file: self.description.source.clone(), size })
        }
    }

    fn geometry(&self, centre: DVec3, radius: f64) -> (Accel, Vec<[Vec3; 3]>, Vec<Option<u32>>) {
        let smooth = self.description.meshes.iter().any(|m| m.normals.is_some());
        let mut triangles = Vec::new();
        let mut normals = Vec::new();
        for (shape, mesh) in self.description.meshes.iter().enumerate() {
            for indices in &mesh.triangles {
                let corners = indices.map(|i| (mesh.positions[i as usize] - centre).as_vec3());
                triangles.push(Triangle { corners, shape: shape as u32 });
                if smooth {
                    let normal = |i: u32| mesh.normals.as_ref().map_or(Vec3::ZERO, |n| n[i as usize].as_vec3());
                    normals.push(indices.map(normal));
                }
            }
        }
        let first = self.description.meshes.len();
        let spheres: Vec<SphereShape> = (self.description.spheres.iter().enumerate())
            .map(|(i, s)| SphereShape { centre: s.centre - centre, radius: s.radius, shape: (first + i) as u32 })
            .collect();
        let (accel, order) = Accel::build(&triangles, &spheres, radius);
        let unused = [Vec3::ZERO; 3];
        let normals = match smooth {
            true => order.iter().map(|i| i.map_or(unused, |i| normals[i as usize])).collect(),
            false => Vec::new(),
        };
        (accel, normals, order)
    }

    /// What the materials ask of the meshes' triangles, in the order of their ids.
    fn mapping(&self, order: &[Option<u32>], materials: &[SurfaceMaterial]) -> Mapping {
        let asks = |mesh: &Mesh| materials[mesh.material].varies();
        if !self.description.meshes.iter().any(asks) {
            return Mapping::default();
        }
        let none = [Vec2::NAN; 3];
        let corners = |mesh: &Mesh, triangle: usize| {
            mesh.texcoords.as_ref().map_or(none, |all| mesh.triangles[triangle].map(|i| all[i as usize]))
        };
        let texcoords =
            self.by_id(order, none, |mesh, triangle| if asks(mesh) { corners(mesh, triangle) } else { none });
        let mut names = BTreeSet::new();
        for material in &self.description.materials {
            material.bsdf.visit_textures(&mut |texture| {
                if let Texture::Attribute { name } = texture {
                    names.insert(name.clone());
                }
            });
        }
        let table = |name: &String| {
            let missing = [[0.0, 0.0, 0.0, 1.0]; 3];
            self.by_id(order, missing, |mesh, triangle| {
                let attribute = mesh.attributes.iter().find(|attribute| attribute.name == *name);
                attribute.map_or(missing, |attribute| attribute.corners(triangle, mesh.triangles[triangle]))
            })
        };
        let attributes = names.iter().map(|name| (name.clone(), table(name))).collect();
        Mapping { texcoords, attributes }
    }

    /// A value for each triangle's id; `unused` where no triangle has it.
    fn by_id<T: Copy>(&self, order: &[Option<u32>], unused: T, value: impl Fn(&Mesh, usize) -> T) -> Vec<T> {
        let meshes = &self.description.meshes;
        let in_order: Vec<T> = meshes
            .iter()
            .flat_map(|mesh| (0..mesh.triangles.len()).map(|i| value(mesh, i)).collect::<Vec<_>>())
            .collect();
        order.iter().map(|i| i.map_or(unused, |i| in_order[i as usize])).collect()
    }

    /// Of a shape, in the order of [`shapes`](Self::shapes).
    fn shape_number(&self, shape: ShapeIndex) -> Option<u32> {
        let SceneDescription { meshes, spheres, .. } = self.description;
        let (before, index, count) = match shape {
            ShapeIndex::Mesh(index) => (0, index, meshes.len()),
            ShapeIndex::Sphere(index) => (meshes.len(), index, spheres.len()),
            ShapeIndex::Disk(_) | ShapeIndex::Cylinder(_) => return None,
        };
        (index < count).then_some((before + index) as u32)
    }

    fn shapes(&self) -> Vec<Shape> {
        let meshes = self.description.meshes.iter().map(|m| m.material);
        let spheres = self.description.spheres.iter().map(|s| s.material);
        meshes.chain(spheres).map(|m| Shape { material: MaterialId(m as u32), emitter: None }).collect()
    }

    /// Emitters have the order of [`emitters`](Self::emitters): meshes, spheres, lights, environment.
    fn names(&self, shapes: &[Shape]) -> Names {
        let SceneDescription { meshes, spheres, materials, lights, environment, .. } = self.description;
        let shape_names = meshes.iter().map(|m| &m.name).chain(spheres.iter().map(|s| &s.name));
        let mut surfaces: Vec<(EmitterId, &String)> =
            shapes.iter().zip(shape_names).filter_map(|(shape, name)| Some((shape.emitter?, name))).collect();
        surfaces.sort_by_key(|(id, _)| id.0);
        let surfaces = surfaces.into_iter().map(|(_, name)| name.clone());
        let lights = lights.iter().map(|light| light.name.clone());
        let emitters = surfaces.chain(lights).chain(environment.as_ref().map(|_| "environment".to_owned()));
        Names { materials: materials.iter().map(|m| m.name.clone()).collect(), emitters: emitters.collect() }
    }

    fn emitters(
        &self,
        accel: &Accel,
        shapes: &mut [Shape],
        centre: DVec3,
        sphere_radius: f64,
    ) -> Result<Vec<Emitter>, BuildError> {
        let mut emitters = Vec::new();
        let meshes = self.description.meshes.len();
        let mut triangles = vec![Vec::new(); meshes];
        for (id, triangle) in accel.triangles() {
            if self.description.materials[shapes[triangle.shape as usize].material.0 as usize].emits() {
                triangles[triangle.shape as usize].push(id);
            }
        }
        for (shape, (mesh, triangles)) in self.description.meshes.iter().zip(triangles).enumerate() {
            let material = &self.description.materials[mesh.material];
            if !material.emits() {
                continue;
            }
            let id = EmitterId(emitters.len() as u32);
            let areas: Vec<f64> = triangles.iter().map(|&t| accel.triangle(t).area()).collect();
            let area: f64 = areas.iter().sum();
            let choice = Discrete::new(areas).filter(|_| area > 0.0 && area.is_finite());
            let Some(choice) = choice else {
                let what = format!("emits, but its area is {area}: give it area or no emission");
                return Err(self.invalid(&format!("mesh '{}'", mesh.name), &what));
            };
            let material_id = shapes[shape].material;
            shapes[shape].emitter = Some(id);
            emitters.push(Emitter::Mesh(MeshEmitter {
                id,
                radiance: *material.emission.constant().unwrap_or(&Rgb::BLACK),
                area,
                triangles,
                choice,
                material: material_id,
            }));
        }
        for (i, sphere) in accel.spheres().iter().enumerate() {
            let shape = sphere.shape as usize;
            let material = shapes[shape].material;
            let description = &self.description.materials[material.0 as usize];
            if description.emits() {
                let id = EmitterId(emitters.len() as u32);
                shapes[shape].emitter = Some(id);
                let radiance = *description.emission.constant().unwrap_or(&Rgb::BLACK);
                let primitive = accel.sphere_id(i);
                let area = sphere.area();
                emitters.push(Emitter::Sphere(SphereEmitter { id, radiance, area, primitive, material }));
            }
        }
        for light in &self.description.lights {
            let id = EmitterId(emitters.len() as u32);
            emitters.push(match light.kind {
                LightKind::Point { position, intensity } => {
                    Emitter::Point(Point { id, position: position - centre, intensity })
                }
                LightKind::Spot { position, direction, intensity, inner_angle, outer_angle } => {
                    let position = position - centre;
                    Emitter::Spot(Spot::new(id, position, direction, intensity, inner_angle, outer_angle))
                }
                LightKind::Projector { .. } => return Err(self.invalid("lights", "projectors are not supported yet")),
                LightKind::Directional { direction, irradiance } => {
                    Emitter::Directional(Directional { id, direction, irradiance, sphere_radius })
                }
            });
        }
        if let Some(EnvironmentDescription::Constant(radiance)) = self.description.environment {
            let id = EmitterId(emitters.len() as u32);
            emitters.push(Emitter::Environment(Environment { id, radiance, sphere_radius }));
        }
        if emitters.is_empty() { Err(BuildError::NoLight(self.description.source.clone())) } else { Ok(emitters) }
    }
}

impl SceneDescription {
    /// The smallest box around all surfaces; `None` where there are none.
    #[must_use]
    pub fn bounds(&self) -> Option<Bounds> {
        Some(bounds(self)).filter(|bounds| !bounds.is_empty())
    }

    /// The camera that [`Scene::build`] uses for a file without one: it sees all surfaces, from the front and a little
    /// above. `None` where there are none.
    #[must_use]
    pub fn framing_camera(&self) -> Option<SensorDescription> {
        framing_camera(bounds(self))
    }
}

fn bounds(description: &SceneDescription) -> Bounds {
    let meshes = description
        .meshes
        .iter()
        .map(|m| Bounds::around(m.triangles.iter().flatten().map(|&i| m.positions[i as usize])));
    let spheres = description.spheres.iter().map(|s| {
        let r = DVec3::splat(s.radius);
        Bounds { min: s.centre - r, max: s.centre + r }
    });
    meshes.chain(spheres).fold(Bounds::EMPTY, Bounds::union)
}

fn framing_camera(geometry: Bounds) -> Option<SensorDescription> {
    if geometry.is_empty() {
        return None;
    }
    let vertical_fov = 40.0_f64.to_radians();
    let backward = DVec3::new(0.4, 0.3, 1.0).normalize();
    let radius = if geometry.radius() > 0.0 { geometry.radius() } else { 1.0 };
    let distance = radius / libm::sin(0.5 * vertical_fov);
    let right = DVec3::Y.cross(backward).normalize();
    Some(SensorDescription {
        name: "framing camera".into(),
        position: geometry.centre() + backward * distance,
        forward: -backward,
        up: backward.cross(right),
        projection: Projection::Perspective { vertical_fov, aspect: None, lens: None },
        window: SensorDescription::WHOLE,
    })
}
