//! What emits: surfaces, lights, the environment.

use std::f64::consts::PI;

use glam::DVec3;

use crate::scene::accel::{Accel, PrimitiveId};
use crate::scene::description::{EnvironmentDescription, LightKind};
use crate::scene::discrete::Discrete;
use crate::scene::emitter::{
    Directional, Emitter, EmitterId, Environment, EnvironmentMap, MeshEmitter, Point, Projector, ShapeEmitter, Spot,
};
use crate::scene::mapping::Mapping;
use crate::scene::texture::Parameter;
use crate::scene::{Names, SceneDescription, Shape};
use crate::spectrum::Rgb;
use crate::warp;

use super::{BuildError, Builder};

/// What [`Builder::emitters`] needs to know.
pub(super) struct Place<'a> {
    pub accel: &'a Accel,
    pub mapping: &'a Mapping,
    pub centre: DVec3,
    /// Of the sphere that stands for infinity.
    pub sphere_radius: f64,
}

impl Builder<'_> {
    /// Emitters have the order of [`emitters`](Self::emitters): meshes, analytic shapes, lights, environment.
    pub(super) fn names(&self, shapes: &[Shape]) -> Names {
        let SceneDescription { materials, lights, environment, .. } = self.description;
        let shape_names = self.description.shape_materials();
        let mut surfaces: Vec<(EmitterId, &String)> =
            shapes.iter().zip(shape_names).filter_map(|(shape, (name, _))| Some((shape.emitter?, name))).collect();
        surfaces.sort_by_key(|(id, _)| id.0);
        let surfaces = surfaces.into_iter().map(|(_, name)| name.clone());
        let lights = lights.iter().map(|light| light.name.clone());
        let emitters = surfaces.chain(lights).chain(environment.as_ref().map(|_| "environment".to_owned()));
        Names { materials: materials.iter().map(|m| m.name.clone()).collect(), emitters: emitters.collect() }
    }

    pub(super) fn emitters(&self, place: &Place<'_>, shapes: &mut [Shape]) -> Result<Vec<Emitter>, BuildError> {
        let mut emitters = Vec::new();
        self.meshes(place, shapes, &mut emitters)?;
        self.analytic_emitters(place, shapes, &mut emitters);
        self.lights(place, &mut emitters)?;
        if let Some(environment) = &self.description.environment {
            let id = EmitterId(emitters.len() as u32);
            emitters.push(self.environment(environment, id, place.sphere_radius)?);
        }
        if emitters.is_empty() { Err(BuildError::NoLight(self.description.source.clone())) } else { Ok(emitters) }
    }

    fn meshes(&self, place: &Place<'_>, shapes: &mut [Shape], emitters: &mut Vec<Emitter>) -> Result<(), BuildError> {
        let Place { accel, mapping, .. } = *place;
        let mut triangles = vec![Vec::new(); self.description.meshes.len()];
        for (id, triangle) in accel.triangles() {
            if self.description.materials[shapes[triangle.shape as usize].material.0 as usize].emits() {
                triangles[triangle.shape as usize].push(id);
            }
        }
        for (shape, (mesh, triangles)) in self.description.meshes.iter().zip(triangles).enumerate() {
            let description = &self.description.materials[mesh.material];
            if !description.emits() {
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
            let material = shapes[shape].material;
            shapes[shape].emitter = Some(id);
            let radiance = description.emission.clone();
            let point = |u: [f64; 2]| {
                let (triangle, within) = choice.split(u[0]);
                let primitive = triangles[triangle];
                let [_, v, w] = warp::uniform_triangle([within, u[1]]);
                (primitive, accel.triangle(primitive).point([v, w]))
            };
            let flux = mean_radiance(&radiance, place.accel, mapping, point) * (PI * area);
            emitters.push(Emitter::Mesh(MeshEmitter { id, radiance, flux, area, triangles, choice, material }));
        }
        Ok(())
    }

    fn analytic_emitters(&self, place: &Place<'_>, shapes: &mut [Shape], emitters: &mut Vec<Emitter>) {
        for (i, analytic) in place.accel.analytic().iter().enumerate() {
            let shape = &mut shapes[analytic.shape() as usize];
            let material = shape.material;
            let description = &self.description.materials[material.0 as usize];
            if !description.emits() {
                continue;
            }
            let id = EmitterId(emitters.len() as u32);
            shape.emitter = Some(id);
            let (primitive, area, radiance) =
                (place.accel.analytic_id(i), analytic.area(), description.emission.clone());
            let point = |u: [f64; 2]| (primitive, analytic.sample(u).position);
            let flux = mean_radiance(&radiance, place.accel, place.mapping, point) * (PI * area);
            emitters.push(Emitter::Shape(ShapeEmitter { id, radiance, flux, area, primitive, material }));
        }
    }

    fn lights(&self, place: &Place<'_>, emitters: &mut Vec<Emitter>) -> Result<(), BuildError> {
        let Place { centre, sphere_radius, .. } = *place;
        for light in &self.description.lights {
            let id = EmitterId(emitters.len() as u32);
            emitters.push(match &light.kind {
                &LightKind::Point { position, intensity } => {
                    Emitter::Point(Point { id, position: position - centre, intensity })
                }
                &LightKind::Spot { position, direction, intensity, inner_angle, outer_angle } => {
                    let position = position - centre;
                    Emitter::Spot(Spot::new(id, position, direction, intensity, inner_angle, outer_angle))
                }
                LightKind::Projector { position, forward, up, horizontal_fov, image, scale } => {
                    let position = *position - centre;
                    let axes = [*forward, *up];
                    let projector = Projector::new(id, position, axes, *horizontal_fov, image.clone(), *scale);
                    let black = || self.invalid(&format!("light '{}'", light.name), "its image is black: give another");
                    Emitter::Projector(Box::new(projector.ok_or_else(black)?))
                }
                &LightKind::Directional { direction, irradiance } => {
                    Emitter::Directional(Directional { id, direction, irradiance, sphere_radius })
                }
            });
        }
        Ok(())
    }

    fn environment(
        &self,
        environment: &EnvironmentDescription,
        id: EmitterId,
        sphere_radius: f64,
    ) -> Result<Emitter, BuildError> {
        let constant = |radiance| Emitter::Environment(Environment { id, radiance, sphere_radius });
        Ok(match environment {
            EnvironmentDescription::Constant(radiance) => constant(*radiance),
            EnvironmentDescription::Map { bitmap, scale, to_world } => {
                self.check_environment(bitmap, *scale, to_world)?;
                let map = EnvironmentMap::new(id, bitmap.clone(), *scale, *to_world, sphere_radius);
                map.map_or_else(|| constant(Rgb::BLACK), |map| Emitter::EnvironmentMap(Box::new(map)))
            }
        })
    }
}

/// Points in the mean of a texture over a surface.
const MEAN_POINTS: u32 = 1 << 14;

/// The mean over a surface: of a texture, over a sequence of points that is even by area (Roberts 2018). What the points all
/// miss must still be chosen now and then, so a texture that is black at all of them counts as white.
fn mean_radiance(
    radiance: &Parameter<Rgb>,
    accel: &Accel,
    mapping: &Mapping,
    point: impl Fn([f64; 2]) -> (PrimitiveId, DVec3),
) -> Rgb {
    let texture = match radiance {
        Parameter::Constant(radiance) => return *radiance,
        Parameter::Texture(texture) => texture,
    };
    let emitted = |i: u32| {
        let u = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3].map(|step| (0.5 + f64::from(i) * step).fract());
        let (primitive, position) = point(u);
        mapping.emitted(accel, texture, primitive, position)
    };
    let mean = (0..MEAN_POINTS).map(emitted).sum::<Rgb>() / f64::from(MEAN_POINTS);
    if mean.is_black() { Rgb::WHITE } else { mean }
}
