//! From a description to a scene: centring, rounding, choosing what is sampled, and refusing what makes no sense.

mod checks;
mod emitters;
mod geometry;
#[cfg(test)]
mod tests;

use std::path::PathBuf;
use std::sync::OnceLock;

use glam::DVec3;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::geometry::Bounds;

use super::bsdf::{Composite, MaterialError};
use super::description::{
    FilmSize, LightKind, Material, PixelFilter, Projection, SensorDescription, ShapeIndex, Target,
};
use super::discrete::Discrete;
use super::emitter::{Emitter, EmitterId};
use super::material::SurfaceMaterial;
use super::sensor::{self, Sensor};
use super::{Scene, SceneDescription, Surfaces};

use emitters::Place;
use geometry::{bounds, boxes, centre};

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
        self.check_shapes()?;
        self.check_lights()?;
        let materials = self.description.materials.iter().map(|m| self.material(m)).collect::<Result<Vec<_>, _>>()?;
        let boxes = boxes(self.description);
        let geometry = boxes.iter().copied().fold(Bounds::EMPTY, Bounds::union);
        let camera = sensor::placed(self.camera(geometry)?, geometry);
        let film = self.film(&camera)?;
        let points = self.points(&camera);
        self.check_extent(geometry.union(points), &camera)?;
        let centre = centre(boxes, points);
        let sensor = Sensor::new(&camera, film, self.description.filter, centre);
        let (analytic, placements) = self.analytic(centre);
        let (accel, normals, order) = self.geometry(&analytic, centre);
        let mapping = self.mapping(&accel, &placements, &order, &materials);
        let mut shapes = self.shapes();
        let sphere_radius = self.reach(geometry, &sensor, centre);
        let place = Place { accel: &accel, mapping: &mapping, centre, sphere_radius };
        let emitters = self.emitters(&place, &mut shapes)?;
        let choice = Discrete::new(emitters.iter().map(|e| match self.options.light_selection {
            LightSelection::Power => e.flux().mean(),
            LightSelection::Uniform => 1.0,
        }));
        let choice = choice.ok_or_else(|| self.invalid("lights", "a flux that is not finite: check the emission"))?;
        let environment = emitters.iter().position(Emitter::is_environment);
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
        self.check_emission(material)?;
        Ok(SurfaceMaterial::new(model, material.two_sided))
    }

    /// Around the points at finite distance that rays start from or end at.
    fn points(&self, camera: &SensorDescription) -> Bounds {
        let lights = self.description.lights.iter().filter_map(|light| match light.kind {
            LightKind::Point { position, .. }
            | LightKind::Spot { position, .. }
            | LightKind::Projector { position, .. } => Some(position),
            LightKind::Directional { .. } => None,
        });
        Bounds::around(lights.chain([camera.position]))
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
                let edge_on = seen <= 1e-9 * u.length() * v.length();
                if edge_on || !seen.is_finite() {
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

    /// Of a shape, in the order of [`shapes`](Self::shapes).
    fn shape_number(&self, shape: ShapeIndex) -> Option<u32> {
        let SceneDescription { meshes, spheres, disks, cylinders, .. } = self.description;
        let (before, index, count) = match shape {
            ShapeIndex::Mesh(index) => (0, index, meshes.len()),
            ShapeIndex::Sphere(index) => (meshes.len(), index, spheres.len()),
            ShapeIndex::Disk(index) => (meshes.len() + spheres.len(), index, disks.len()),
            ShapeIndex::Cylinder(index) => (meshes.len() + spheres.len() + disks.len(), index, cylinders.len()),
        };
        (index < count).then_some((before + index) as u32)
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
