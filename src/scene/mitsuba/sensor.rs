//! The camera for Mitsuba.
//!
//! Mitsuba's cameras look along their local z axis with y to the top of the image, and their local x axis points to the
//! *left* of the image.

use super::error::ExportError;
use super::export::ExportOptions;
use super::xml::Element;
use crate::geometry::Bounds;
use crate::scene::description::{Projection, SceneDescription, SensorDescription};

/// How far the ratio of the sides of a pixel may be from one, relatively.
const SQUARE_TOLERANCE: f64 = 1e-3;
/// Nearest and farthest visible distance over the size of the scene. Mitsuba clips what lies outside.
const CLIP: [f64; 2] = [1e-6, 1e2];

pub(super) fn sensor(scene: &SceneDescription, options: &ExportOptions) -> Result<Element, ExportError> {
    let Some(sensor) = &scene.sensor else {
        return Err(ExportError::invalid(&scene.name, "camera", "there is none; add one to the scene"));
    };
    let place = format!("camera '{}'", sensor.name);
    let left = sensor.up.cross(sensor.forward);
    let film_aspect = f64::from(options.film.width) / f64::from(options.film.height);

    let element = match sensor.projection {
        Projection::Perspective { vertical_fov, aspect, lens } => {
            let pixel_aspect = aspect.unwrap_or(film_aspect) / film_aspect;
            if (pixel_aspect - 1.0).abs() > SQUARE_TOLERANCE {
                let what = format!("pixels that are not square (width over height {pixel_aspect:.4})");
                let remedy = format!("use a film of {} pixels", square_film(aspect.unwrap_or(film_aspect), options));
                return Err(ExportError::unsupported(&scene.name, place, what, remedy));
            }
            let element = match lens {
                None => Element::plugin("sensor", "perspective"),
                Some(lens) => Element::plugin("sensor", "thinlens")
                    .float("aperture_radius", lens.aperture_radius)
                    .float("focus_distance", lens.focus_distance),
            };
            element.string("fov_axis", "y").float("fov", vertical_fov.to_degrees()).frame(
                left,
                sensor.up,
                sensor.forward,
                sensor.position,
            )
        }
        Projection::Hemisphere | Projection::Window { .. } | Projection::Ray => {
            let remedy = "choose a camera";
            return Err(ExportError::unsupported(&scene.name, place, "meters that are no cameras", remedy));
        }
        // Its film covers [−1, 1] in x and [−height/width, height/width] in y.
        Projection::Orthographic { half_width, half_height } => Element::plugin("sensor", "orthographic").frame(
            left * half_width,
            sensor.up * (half_height * film_aspect),
            sensor.forward,
            sensor.position,
        ),
    };

    let [near, far] = CLIP.map(|ratio| ratio * size(scene, sensor));
    let sampler = Element::plugin("sampler", "independent").integer("sample_count", i64::from(options.spp));
    Ok(element.float("near_clip", near).float("far_clip", far).child(film(options)).child(sampler))
}

fn film(options: &ExportOptions) -> Element {
    Element::plugin("film", "hdrfilm")
        .integer("width", i64::from(options.film.width))
        .integer("height", i64::from(options.film.height))
        .string("pixel_format", "rgb")
        .string("component_format", "float32")
        .child(Element::plugin("rfilter", "box"))
}

/// The film with the same number of pixels whose pixels are square.
fn square_film(aspect: f64, options: &ExportOptions) -> String {
    let pixels = f64::from(options.film.width) * f64::from(options.film.height);
    let height = (pixels / aspect).sqrt();
    format!("{} × {}", (height * aspect).round(), height.round())
}

/// Diagonal of the box around all surfaces and the camera \[m\].
fn size(scene: &SceneDescription, sensor: &SensorDescription) -> f64 {
    let meshes = scene.meshes.iter().map(|mesh| Bounds::around(mesh.positions.iter().copied()));
    let spheres = scene.spheres.iter().map(|s| Bounds::around([s.centre - s.radius, s.centre + s.radius]));
    let size = 2.0 * meshes.chain(spheres).fold(Bounds::around([sensor.position]), Bounds::union).radius();
    if size > 0.0 { size } else { 1.0 }
}
