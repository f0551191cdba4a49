//! The camera or another sensor for Mitsuba.
//!
//! Mitsuba's cameras look along their local z axis with y to the top of the image, and their local x axis points to the
//! *left* of the image.

use glam::{DVec2, DVec3};

use super::error::ExportError;
use super::export::ExportOptions;
use super::xml::Element;
use crate::geometry::Bounds;
use crate::scene::description::{
    FilmSize, Lens, PixelFilter, Projection, SceneDescription, SensorDescription, ShapeIndex, Target,
};

/// How far the ratio of the sides of a pixel may be from one, relatively.
const SQUARE_TOLERANCE: f64 = 1e-3;
/// How far the edge of a crop may be from that of a pixel, in pixels.
const CROP_TOLERANCE: f64 = 1e-6;
/// Nearest and farthest visible distance over the size of the scene. Mitsuba clips what lies outside.
const CLIP: [f64; 2] = [1e-6, 1e2];

/// The sensor, and the shape that it belongs into where it is a part of one.
pub(super) fn sensor(
    scene: &SceneDescription,
    options: &ExportOptions,
) -> Result<(Element, Option<ShapeIndex>), ExportError> {
    let Some(sensor) = &scene.sensor else {
        return Err(ExportError::invalid(&scene.name, "camera", "there is none; add one to the scene"));
    };
    let place = format!("camera '{}'", sensor.name);
    let crop = Crop::of(sensor.window, options.film);
    let left = sensor.up.cross(sensor.forward);
    let film_aspect = f64::from(options.film.width) / f64::from(options.film.height);
    let covered = sensor.window[1] - sensor.window[0];
    let shift = (sensor.window[0] + sensor.window[1] - 1.0) * 0.5;

    let (element, crop) = match sensor.projection {
        Projection::Perspective { vertical_fov, aspect, lens } => {
            let square = sensor.film_aspect(options.film);
            let pixel_aspect = aspect.unwrap_or(square) / square;
            if (pixel_aspect - 1.0).abs() > SQUARE_TOLERANCE {
                let what = format!("pixels that are not square (width over height {pixel_aspect:.4})");
                let remedy = format!("use a film of {} pixels", square_film(film_aspect * pixel_aspect, options));
                return Err(ExportError::unsupported(&scene.name, place, what, remedy));
            }
            let fov = if crop.is_some() { vertical_fov } else { narrowed(vertical_fov, covered.y) };
            let element = match lens {
                None => Element::plugin("sensor", "perspective"),
                Some(Lens { aperture_radius, focus_distance }) => Element::plugin("sensor", "thinlens")
                    .float("aperture_radius", aperture_radius)
                    .float("focus_distance", focus_distance),
            };
            let element = element.string("fov_axis", "y").float("fov", fov.to_degrees());
            let element = match crop {
                None if shift == DVec2::ZERO => element,
                None if lens.is_some() => {
                    let what = "a thin lens with an image that is shifted by parts of a pixel";
                    let remedy = "use the scene's own film, or no lens";
                    return Err(ExportError::unsupported(&scene.name, place, what, remedy));
                }
                None => {
                    let offset = shift / covered;
                    element.float("principal_point_offset_x", offset.x).float("principal_point_offset_y", offset.y)
                }
                Some(_) => element,
            };
            (element.frame(left, sensor.up, sensor.forward, sensor.position), crop)
        }
        Projection::Hemisphere | Projection::Window { .. } => {
            let remedy = "choose a camera";
            return Err(ExportError::unsupported(&scene.name, place, "a meter in empty space", remedy));
        }
        Projection::Ray | Projection::Surface { .. } | Projection::Distant { .. } => {
            return meter(scene, sensor, options).map(|element| {
                let shape = if let Projection::Surface { shape } = sensor.projection { Some(shape) } else { None };
                (element, shape)
            });
        }
        // Its film covers [−1, 1] in x and [−height/width, height/width] in y.
        Projection::Orthographic { half_width, half_height } => {
            let centre = 2.0 * shift * DVec2::new(-half_width, -half_height);
            let element = Element::plugin("sensor", "orthographic").frame(
                left * (half_width * covered.x),
                sensor.up * (half_height * covered.y * film_aspect),
                sensor.forward,
                sensor.position + left * centre.x + sensor.up * centre.y,
            );
            (element, None)
        }
    };

    let [near, far] = CLIP.map(|ratio| ratio * size(scene, sensor));
    let film = film(scene.filter, options.film, crop);
    Ok((element.float("near_clip", near).float("far_clip", far).child(film).child(sampler(options)), None))
}

fn sampler(options: &ExportOptions) -> Element {
    Element::plugin("sampler", "independent").integer("sample_count", i64::from(options.spp))
}

/// What makes no image. Mitsuba has such sensors for a single pixel only.
fn meter(
    scene: &SceneDescription,
    sensor: &SensorDescription,
    options: &ExportOptions,
) -> Result<Element, ExportError> {
    if options.film != (FilmSize { width: 1, height: 1 }) {
        let place = format!("sensor '{}'", sensor.name);
        let what = "a meter with more than one pixel";
        return Err(ExportError::unsupported(&scene.name, place, what, "use a film of 1x1 pixels"));
    }
    let element = match sensor.projection {
        Projection::Surface { .. } => Element::plugin("sensor", "irradiancemeter"),
        Projection::Distant { target } => {
            let element = Element::plugin("sensor", "distant").vector("direction", sensor.forward);
            let shape = |plugin: &str, u: DVec3, v: DVec3, centre: DVec3| {
                Element::plugin("shape", plugin).with("name", "target").frame(u, v, u.cross(v).normalize(), centre)
            };
            match target {
                Target::Scene => element,
                Target::Point(point) => element.point("target", point),
                Target::Parallelogram { centre, u, v } => element.child(shape("rectangle", u, v, centre)),
                Target::Ellipse { centre, u, v } => element.child(shape("disk", u, v, centre)),
            }
        }
        _ => Element::plugin("sensor", "radiancemeter")
            .point("origin", sensor.position)
            .vector("direction", sensor.forward),
    };
    Ok(element.child(film(PixelFilter::Box, options.film, None)).child(sampler(options)))
}

/// The full angle that covers this share of the image's height.
fn narrowed(fov: f64, share: f64) -> f64 {
    if share == 1.0 { fov } else { 2.0 * libm::atan(share * libm::tan(0.5 * fov)) }
}

/// A film that is a part of a larger image, by whole pixels.
#[derive(Clone, Copy, Debug)]
struct Crop {
    image: FilmSize,
    offset: [u32; 2],
}

impl Crop {
    /// `None` where the film is the whole image, or no such part of one.
    fn of([first, last]: [DVec2; 2], film: FilmSize) -> Option<Self> {
        let image = DVec2::new(f64::from(film.width), f64::from(film.height)) / (last - first);
        let offset = first * image;
        let whole = |x: f64| (x - x.round()).abs() < CROP_TOLERANCE && (-0.5..65_535.5).contains(&x);
        let is_crop = [image.x, image.y, offset.x, offset.y].into_iter().all(whole);
        let [width, height, x, y] = [image.x, image.y, offset.x, offset.y].map(|x| x.round() as u32);
        let inside = x.saturating_add(film.width) <= width && y.saturating_add(film.height) <= height;
        let smaller = width > film.width || height > film.height;
        (is_crop && inside && smaller).then_some(Self { image: FilmSize { width, height }, offset: [x, y] })
    }
}

fn film(filter: PixelFilter, size: FilmSize, crop: Option<Crop>) -> Element {
    let image = crop.map_or(size, |crop| crop.image);
    let film = Element::plugin("film", "hdrfilm")
        .integer("width", i64::from(image.width))
        .integer("height", i64::from(image.height));
    let film = match crop {
        None => film,
        Some(crop) => film
            .integer("crop_width", i64::from(size.width))
            .integer("crop_height", i64::from(size.height))
            .integer("crop_offset_x", i64::from(crop.offset[0]))
            .integer("crop_offset_y", i64::from(crop.offset[1])),
    };
    let filter = match filter {
        PixelFilter::Box => Element::plugin("rfilter", "box"),
        PixelFilter::Tent { radius } => Element::plugin("rfilter", "tent").float("radius", radius),
        PixelFilter::Gaussian { stddev } => Element::plugin("rfilter", "gaussian").float("stddev", stddev),
    };
    film.string("pixel_format", "rgb").string("component_format", "float32").child(filter)
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
