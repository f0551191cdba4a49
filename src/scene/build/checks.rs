//! What makes no sense, told with its name and a remedy.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use crate::geometry::Bounds;
use crate::scene::description::{Cylinder, Disk, LightKind, Material, Mesh, SensorDescription, Sphere};
use crate::scene::texture::{Bitmap, Texels, Texture};

use super::{BuildError, Builder};

/// Cosine of the angle between two axes that counts as a right one: transforms in files are of single precision.
const RIGHT_ANGLE: f64 = 1e-4;

/// Extents of scenes \[m\]. Boxes are single precision, whose normal numbers end at 10^±38, and so does the inverse of a
/// segment's direction; volumes of three edges stay within double precision's 10^±308 with room for details.
const EXTENTS: std::ops::RangeInclusive<f64> = 1e-30..=1e30;

/// The smallest radius or axis of a shape \[m\]: the square of an area and its inverse are still normal numbers.
const SMALLEST: f64 = 1e-70;

fn at_right_angles(a: DVec3, b: DVec3) -> bool {
    a.dot(b).abs() <= RIGHT_ANGLE * a.length() * b.length()
}

fn has_length(vector: DVec3) -> bool {
    vector.is_finite() && is_size(vector.length())
}

fn is_size(x: f64) -> bool {
    (SMALLEST..f64::INFINITY).contains(&x)
}

fn is_orthonormal(axes: &DMat3) -> bool {
    let difference = (axes.transpose() * *axes - DMat3::IDENTITY).to_cols_array();
    difference.iter().all(|x| x.abs() <= RIGHT_ANGLE)
}

fn bad_pixel(bitmap: &Bitmap, index: usize) -> String {
    let (x, y) = (index % bitmap.width as usize, index / bitmap.width as usize);
    format!("pixel {x},{y} of its image '{}' is not finite; repair the image", bitmap.name)
}

fn sphere(sphere: &Sphere) -> Option<String> {
    let axes = sphere.axes;
    if !sphere.centre.is_finite() {
        return Some(format!("its centre is {}; give three numbers", sphere.centre));
    }
    if !is_size(sphere.radius) {
        return Some(format!("its radius is {:?}; give a number of at least {SMALLEST:e}", sphere.radius));
    }
    (!is_orthonormal(&axes))
        .then(|| "its axes are not three unit vectors at right angles; scale it evenly and shear it not at all".into())
}

fn disk(disk: &Disk) -> Option<String> {
    let [u, v] = disk.axes;
    if !disk.centre.is_finite() {
        return Some(format!("its centre is {}; give three numbers", disk.centre));
    }
    let flat = !has_length(u) || !has_length(v) || u.cross(v).length() <= f64::EPSILON * u.length() * v.length();
    flat.then(|| format!("its axes {u} and {v} span no plane; give two vectors in different directions"))
}

fn cylinder(cylinder: &Cylinder) -> Option<String> {
    let Cylinder { base, axis, radius, meridian, .. } = *cylinder;
    if !base.is_finite() || !has_length(axis) {
        return Some(format!("it goes from {base} along {axis}; give numbers and a length of at least {SMALLEST:e}"));
    }
    if !is_size(radius) {
        return Some(format!("its radius is {radius:?}; give a number of at least {SMALLEST:e}"));
    }
    let unit = (meridian.length() - 1.0).abs() <= RIGHT_ANGLE;
    (!unit || !at_right_angles(axis, meridian)).then(|| {
        "its meridian is no unit vector at right angles to its axis; scale it evenly across and shear it not".into()
    })
}

fn mesh(mesh: &Mesh) -> Option<String> {
    let Mesh { positions, normals, texcoords, triangles, .. } = mesh;
    let count = positions.len();
    if let Some(i) = triangles.iter().flatten().find(|&&i| i as usize >= count) {
        return Some(format!("a triangle names vertex {i}, but there are {count}; correct the number"));
    }
    if let Some(i) = positions.iter().position(|p| !p.is_finite()) {
        return Some(format!("its vertex {i} is at {}; give three numbers", positions[i]));
    }
    let lengths =
        [("normals", normals.as_ref().map(Vec::len)), ("texture coordinates", texcoords.as_ref().map(Vec::len))];
    let (what, given) = lengths.into_iter().find_map(|(what, n)| Some((what, n.filter(|&n| n != count)?)))?;
    Some(format!("it has {given} {what} for {count} vertices; give one for each"))
}

impl Builder<'_> {
    /// Everything at finite distance lies within numbers that can be calculated with.
    pub(super) fn check_extent(&self, everything: Bounds, camera: &SensorDescription) -> Result<(), BuildError> {
        if !camera.position.is_finite() {
            let what = format!("it is at {}; give three numbers", camera.position);
            return Err(self.invalid(&format!("camera '{}'", camera.name), &what));
        }
        let extent = (everything.max - everything.min).max_element();
        // A camera alone has none.
        if extent == 0.0 || EXTENTS.contains(&extent) {
            return Ok(());
        }
        let (least, most) = (EXTENTS.start(), EXTENTS.end());
        let what = format!(
            "it is {extent:e} m large; scale it, or move what is far away: {least:e} to {most:e} m is possible"
        );
        Err(self.invalid("the scene", &what))
    }

    pub(super) fn check_shapes(&self) -> Result<(), BuildError> {
        let materials = self.description.materials.len();
        for (name, material) in self.description.shape_materials() {
            if material >= materials {
                let what = format!("refers to material {material}, but there are {materials}; correct the number");
                return Err(self.invalid(&format!("'{name}'"), &what));
            }
        }
        let meshes = self.description.meshes.iter().map(|m| ("mesh", &m.name, mesh(m)));
        let spheres = self.description.spheres.iter().map(|s| ("sphere", &s.name, sphere(s)));
        let disks = self.description.disks.iter().map(|d| ("disk", &d.name, disk(d)));
        let cylinders = self.description.cylinders.iter().map(|c| ("cylinder", &c.name, cylinder(c)));
        match meshes
            .chain(spheres)
            .chain(disks)
            .chain(cylinders)
            .find_map(|(kind, name, problem)| Some((kind, name, problem?)))
        {
            Some((kind, name, problem)) => Err(self.invalid(&format!("{kind} '{name}'"), &problem)),
            None => Ok(()),
        }
    }

    pub(super) fn check_lights(&self) -> Result<(), BuildError> {
        let problem = |kind: &LightKind| {
            let (values, directions, problem) = match kind {
                LightKind::Point { intensity, .. } => (*intensity, vec![], None),
                LightKind::Spot { direction, intensity, inner_angle, outer_angle, .. } => {
                    let ordered = (0.0..=*outer_angle).contains(inner_angle) && *outer_angle <= PI;
                    let problem = format!(
                        "its cones have {inner_angle} and {outer_angle} rad; the inner must not exceed the outer, nor that π"
                    );
                    (*intensity, vec![*direction], (!ordered || *outer_angle <= 0.0).then_some(problem))
                }
                LightKind::Directional { direction, irradiance } => (*irradiance, vec![*direction], None),
                LightKind::Projector { forward, up, horizontal_fov, image, scale, .. } => {
                    let problem = if !(*horizontal_fov > 0.0 && *horizontal_fov < PI) {
                        Some(format!("its field of view is {horizontal_fov} rad; give an angle between 0 and π"))
                    } else if !at_right_angles(*forward, *up) {
                        Some("the top of its image is not at right angles to its axis; turn it".into())
                    } else {
                        not_finite_image(&image.texels).map(|i| bad_pixel(image, i))
                    };
                    (*scale, vec![*forward, *up], problem)
                }
            };
            let placed = match kind {
                LightKind::Point { position, .. }
                | LightKind::Spot { position, .. }
                | LightKind::Projector { position, .. } => position.is_finite(),
                LightKind::Directional { .. } => true,
            };
            let emits = values.to_array().iter().all(|c| (0.0..f64::INFINITY).contains(c));
            let unit = directions.iter().all(|d| (d.length() - 1.0).abs() <= RIGHT_ANGLE);
            problem
                .or_else(|| (!placed).then(|| "its position is not finite; give three numbers".into()))
                .or_else(|| (!unit).then(|| "its directions are not of length one; give unit vectors".into()))
                .or_else(|| {
                    (!emits)
                        .then(|| format!("it emits {:?}; give finite values that are not negative", values.to_array()))
                })
        };
        match self.description.lights.iter().find_map(|light| Some((light, problem(&light.kind)?))) {
            Some((light, problem)) => Err(self.invalid(&format!("light '{}'", light.name), &problem)),
            None => Ok(()),
        }
    }

    pub(super) fn check_environment(&self, bitmap: &Bitmap, scale: f64, to_world: &DMat3) -> Result<(), BuildError> {
        let problem = if !(0.0..f64::INFINITY).contains(&scale) {
            Some(format!("its scale is {scale}; give a finite number that is not negative"))
        } else if !is_orthonormal(to_world) {
            Some("its transform is no rotation; neither scale nor shear it".into())
        } else {
            not_finite_image(&bitmap.texels).map(|i| bad_pixel(bitmap, i))
        };
        problem.map_or(Ok(()), |problem| Err(self.invalid("environment", &problem)))
    }

    pub(super) fn check_emission(&self, material: &Material) -> Result<(), BuildError> {
        let place = format!("material '{}'", material.name);
        if let Some(emission) = material.emission.constant()
            && emission.to_array().iter().any(|c| !(0.0..f64::INFINITY).contains(c))
        {
            return Err(self.invalid(&place, "the emission must be finite and not negative"));
        }
        let mut problem = None;
        if let Some(texture) = material.emission.texture() {
            texture.visit(&mut |texture| problem = problem.take().or_else(|| not_finite(texture)));
        }
        problem.map_or(Ok(()), |problem| Err(self.invalid(&place, &problem)))
    }
}

/// What in a texture, apart from those it is made of, is no number.
fn not_finite(texture: &Texture) -> Option<String> {
    match texture {
        Texture::Constant(value) if !value.iter().all(|x| x.is_finite()) => {
            Some("the emission is not finite; correct the texture's colour".into())
        }
        Texture::Bitmap { bitmap, .. } => not_finite_image(&bitmap.texels).map(|_| {
            format!("the emission's image '{}' has a pixel that is not finite; repair the image", bitmap.name)
        }),
        _ => None,
    }
}

/// The number of a pixel with a colour that is not finite.
pub(super) fn not_finite_image(texels: &Texels) -> Option<usize> {
    match texels {
        Texels::Float(texels) => texels.iter().position(|texel| !texel[..3].iter().all(|x| x.is_finite())),
        Texels::Srgb8(_) | Texels::Linear8(_) => None,
    }
}
