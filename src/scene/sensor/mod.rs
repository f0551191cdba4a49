//! Cameras as sensors of path space: how important light is that arrives along the last edge of a path.
//!
//! For pixel j and a box filter of one pixel, `W_e^j` is such that `I_j = ∫ W_e^j L dA dσ⊥` is the mean over the pixel (and
//! over the lens) of the radiance that arrives. Walks from the sensor are drawn *per pixel*: their density is the one given
//! j, so that `W_e^j / p` is one and n = 1 walk serves each pixel; light walks serve all pixels at once.

#[cfg(test)]
mod tests;

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use crate::measure::{Area, Density};
use crate::path::{Edge, Vertex, VertexKind};
use crate::warp;

use super::description::{FilmSize, Projection, SensorDescription};
use super::emitter::{DirectSample, EdgeDensity};

/// A pixel, by column and row from the top left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Pixel {
    /// Column.
    pub x: u32,
    /// Row.
    pub y: u32,
}

/// A camera with its film.
#[derive(Clone, Debug)]
pub struct Sensor {
    film: FilmSize,
    position: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    /// Centre of the film's window in the image, towards right and up: at distance one (perspective), or in metres
    /// (orthographic).
    image_centre: DVec2,
    /// Half the extent of the window, alike.
    half_extent: DVec2,
    kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Pinhole,
    ThinLens { radius: f64, focus_distance: f64 },
    Orthographic,
    Hemisphere,
    Window,
    Ray,
}

/// How much a pixel responds to light that arrives along an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Importance {
    /// The pixel.
    pub pixel: Pixel,
    /// `W_e^j(x_{k−1} → x_k)`: \[1/m²/sr\] for a lens, \[1/sr\] for a pinhole, \[1/m²\] for an orthographic film, the
    /// latter two as coefficients of their Dirac distribution.
    pub value: f64,
}

impl Sensor {
    /// From its description, with positions relative to `centre`.
    #[must_use]
    pub fn new(description: &SensorDescription, film: FilmSize, centre: DVec3) -> Self {
        let (half_extent, kind) = match description.projection {
            Projection::Perspective { vertical_fov, aspect, lens } => {
                let half_height = libm::tan(0.5 * vertical_fov);
                let aspect = aspect.unwrap_or_else(|| description.film_aspect(film));
                let kind = lens.map_or(Kind::Pinhole, |lens| Kind::ThinLens {
                    radius: lens.aperture_radius,
                    focus_distance: lens.focus_distance,
                });
                (DVec2::new(aspect * half_height, half_height), kind)
            }
            Projection::Orthographic { half_width, half_height } => {
                (DVec2::new(half_width, half_height), Kind::Orthographic)
            }
            Projection::Hemisphere => (DVec2::ONE, Kind::Hemisphere),
            Projection::Window { half_width, half_height } => (DVec2::new(half_width, half_height), Kind::Window),
            Projection::Ray => (DVec2::ONE, Kind::Ray),
        };
        let [first, last] = description.window;
        let image_centre = (first + last - 1.0) * DVec2::new(1.0, -1.0) * half_extent;
        let half_extent = (last - first) * half_extent;
        Self {
            film,
            position: description.position - centre,
            right: description.forward.cross(description.up),
            up: description.up,
            forward: description.forward,
            image_centre,
            half_extent,
            kind,
        }
    }

    /// Size of the image.
    #[must_use]
    pub fn film(&self) -> FilmSize {
        self.film
    }

    /// All points from which its walks start lie within this distance of its position \[m\].
    #[must_use]
    pub fn extent(&self) -> f64 {
        match self.kind {
            Kind::Pinhole | Kind::Hemisphere | Kind::Ray => 0.0,
            Kind::ThinLens { radius, .. } => radius,
            Kind::Orthographic | Kind::Window => self.image_centre.length() + self.half_extent.length(),
        }
    }

    /// Its position relative to the scene's centre \[m\].
    #[must_use]
    pub fn position(&self) -> DVec3 {
        self.position
    }

    /// x_k can be drawn before the direction of the last edge, whatever the pixel, and seen from anywhere.
    #[must_use]
    pub fn has_position(&self) -> bool {
        matches!(self.kind, Kind::Pinhole | Kind::ThinLens { .. } | Kind::Hemisphere)
    }

    /// A point of it can be drawn for a vertex (technique t = 1): it is not Dirac in position and direction.
    #[must_use]
    pub fn can_be_connected(&self) -> bool {
        self.kind != Kind::Ray
    }

    /// Light walks can end on it by chance (technique t = 0): it has a lens or a window of finite size.
    #[must_use]
    pub fn can_be_hit(&self) -> bool {
        matches!(self.kind, Kind::ThinLens { .. } | Kind::Window)
    }

    /// Draws x_k and the direction of the last edge for a pixel. `u` is uniform in `[0, 1)⁴`.
    #[must_use]
    #[inline(always)]
    pub fn sample(&self, pixel: Pixel, u: [f64; 4]) -> (Vertex, DVec3) {
        let raster = DVec2::new(f64::from(pixel.x) + u[0], f64::from(pixel.y) + u[1]);
        let size = DVec2::new(f64::from(self.film.width), f64::from(self.film.height));
        let image = (raster / size * 2.0 - 1.0) * DVec2::new(1.0, -1.0) * self.half_extent + self.image_centre;
        let in_image = self.right * image.x + self.up * image.y;
        match self.kind {
            Kind::Pinhole => (self.vertex(self.position), (in_image + self.forward).normalize()),
            Kind::ThinLens { radius, focus_distance } => {
                let DVec2 { x, y } = warp::concentric_disk([u[2], u[3]]);
                let offset = (self.right * x + self.up * y) * radius;
                let direction = (in_image + self.forward) * focus_distance - offset;
                (self.vertex(self.position + offset), direction.normalize())
            }
            Kind::Orthographic => (self.vertex(self.position + in_image), self.forward),
            Kind::Hemisphere | Kind::Window | Kind::Ray => self.sample_meter(raster / size, in_image, [u[2], u[3]]),
        }
    }

    /// Not inlined: renders have cameras.
    #[inline(never)]
    fn sample_meter(&self, unit: DVec2, in_image: DVec3, u: [f64; 2]) -> (Vertex, DVec3) {
        match self.kind {
            Kind::Hemisphere => (self.vertex(self.position), self.to_world(warp::cosine_hemisphere(unit.to_array()))),
            Kind::Window => (self.vertex(self.position + in_image), self.to_world(warp::cosine_hemisphere(u))),
            _ => (self.vertex(self.position), self.forward),
        }
    }

    /// The density with which [`sample`](Self::sample) draws x_k and `direction` for the pixel that they belong to.
    #[must_use]
    #[inline(always)]
    pub fn density(&self, direction: DVec3) -> EdgeDensity {
        let pixel_area = self.pixel_area();
        let cos = self.forward.dot(direction);
        // dσ = dA cos³θ, with A on the image at distance one.
        let per_solid_angle = Density::new(1.0 / (pixel_area * cos * cos * cos));
        match self.kind {
            Kind::Pinhole => EdgeDensity { position: Density::new(1.0), direction: per_solid_angle },
            Kind::ThinLens { radius, .. } => EdgeDensity { position: lens_density(radius), direction: per_solid_angle },
            Kind::Orthographic => {
                EdgeDensity { position: Density::new(1.0 / pixel_area), direction: Density::new(1.0) }
            }
            Kind::Hemisphere => {
                let pixels = f64::from(self.film.width) * f64::from(self.film.height);
                let direction = pixels * warp::cosine_hemisphere_density(cos);
                EdgeDensity { position: Density::new(1.0), direction }
            }
            Kind::Window => EdgeDensity {
                position: Density::new(1.0 / pixel_area),
                direction: warp::cosine_hemisphere_density(cos),
            },
            Kind::Ray => EdgeDensity { position: Density::new(1.0), direction: Density::new(1.0) },
        }
    }

    /// The pixel that sees along the last edge, and how much; `direction` leads from x_k to x_{k−1}.
    #[must_use]
    #[inline(always)]
    pub fn importance(&self, xk: &Vertex, direction: DVec3) -> Option<Importance> {
        let cos = self.forward.dot(direction);
        if cos <= 0.0 {
            return None;
        }
        let offset = xk.position - self.position;
        let in_image = match self.kind {
            Kind::Pinhole => direction / cos,
            Kind::ThinLens { focus_distance, .. } => direction / cos + offset / focus_distance,
            Kind::Orthographic | Kind::Window => offset,
            Kind::Hemisphere => direction,
            // Paths of its own walks come back along it but for rounding; no others reach it.
            Kind::Ray => {
                return (cos > 1.0 - 1e-9).then(|| Importance { pixel: Pixel { x: 0, y: 0 }, value: 1.0 / cos });
            }
        };
        let in_image = DVec2::new(in_image.dot(self.right), in_image.dot(self.up));
        let pixel = match self.kind {
            Kind::Hemisphere => self.pixel_of(DVec2::from_array(warp::concentric_square(in_image)))?,
            _ => self.pixel_at(in_image)?,
        };
        let density = self.density(direction);
        let value = density.position.value() * density.direction.value() / xk.abs_cos(direction);
        Some(Importance { pixel, value })
    }

    /// Draws x_k for a given x_{k−1} (technique t = 1); `None` where the sensor cannot see it. `u` is uniform in `[0, 1)²`.
    #[must_use]
    #[inline(always)]
    pub fn sample_direct(&self, from: &Vertex, u: [f64; 2]) -> Option<DirectSample> {
        match self.kind {
            Kind::Pinhole | Kind::Hemisphere => {
                Some(DirectSample { vertex: self.vertex(self.position), density: Density::new(1.0) })
            }
            Kind::ThinLens { radius, .. } => {
                let DVec2 { x, y } = warp::concentric_disk(u);
                let position = self.position + (self.right * x + self.up * y) * radius;
                Some(DirectSample { vertex: self.vertex(position), density: lens_density(radius) })
            }
            Kind::Orthographic => {
                let depth = (from.position - self.position).dot(self.forward);
                let vertex = self.vertex(from.position - self.forward * depth);
                (depth > 0.0).then_some(DirectSample { vertex, density: self.direct_density(from, &vertex) })
            }
            Kind::Window => {
                let at = (DVec2::from_array(u) * 2.0 - 1.0) * self.half_extent + self.image_centre;
                let vertex = self.vertex(self.position + self.right * at.x + self.up * at.y);
                Some(DirectSample { vertex, density: self.direct_density(from, &vertex) })
            }
            Kind::Ray => None,
        }
    }

    /// The density with which [`sample_direct`](Self::sample_direct) draws x_k for x_{k−1}.
    #[must_use]
    #[inline(always)]
    pub fn direct_density(&self, from: &Vertex, xk: &Vertex) -> Density<Area> {
        match self.kind {
            Kind::Pinhole | Kind::Hemisphere => Density::new(1.0),
            Kind::ThinLens { radius, .. } => lens_density(radius),
            Kind::Window => Density::new(1.0 / self.area()),
            Kind::Ray => Density::ZERO,
            Kind::Orthographic => {
                let edge = Edge::between(from, xk);
                Density::new(1.0) * edge.solid_angle_to_area(xk)
            }
        }
    }

    /// Where a light walk that leaves `from` along `direction` passes through the lens before `t_max`.
    #[must_use]
    #[inline]
    pub fn crossing(&self, from: &Vertex, direction: DVec3, t_max: f64) -> Option<Vertex> {
        if !self.can_be_hit() {
            return None;
        }
        let approach = -direction.dot(self.forward);
        if approach <= 0.0 {
            return None;
        }
        let t = (from.position - self.position).dot(self.forward) / approach;
        let position = from.position + direction * t;
        let offset = position - self.position;
        let inside = match self.kind {
            Kind::ThinLens { radius, .. } => offset.length_squared() <= radius * radius,
            _ => {
                let at = DVec2::new(offset.dot(self.right), offset.dot(self.up)) - self.image_centre;
                at.abs().cmple(self.half_extent).all()
            }
        };
        (t > 0.0 && t < t_max && inside).then(|| self.vertex(position))
    }

    #[inline]
    fn vertex(&self, position: DVec3) -> Vertex {
        let normal = if self.kind == Kind::Pinhole { DVec3::ZERO } else { self.forward };
        Vertex { position, normal, shading_normal: normal, kind: VertexKind::Sensor }
    }

    #[inline]
    fn to_world(&self, local: DVec3) -> DVec3 {
        self.right * local.x + self.up * local.y + self.forward * local.z
    }

    /// Of the film's window \[m²\], for those that have one in the scene: orthographic films and windows.
    #[must_use]
    pub fn area(&self) -> f64 {
        4.0 * self.half_extent.x * self.half_extent.y
    }

    #[inline]
    fn pixel_area(&self) -> f64 {
        let pixels = f64::from(self.film.width) * f64::from(self.film.height);
        self.area() / pixels
    }

    #[inline]
    fn pixel_at(&self, image: DVec2) -> Option<Pixel> {
        self.pixel_of(((image - self.image_centre) / self.half_extent * DVec2::new(1.0, -1.0) + 1.0) * 0.5)
    }

    /// The pixel at a point of the unit square.
    #[inline]
    fn pixel_of(&self, unit: DVec2) -> Option<Pixel> {
        let raster = unit * DVec2::new(f64::from(self.film.width), f64::from(self.film.height));
        let inside = raster.cmpge(DVec2::ZERO).all()
            && raster.x < f64::from(self.film.width)
            && raster.y < f64::from(self.film.height);
        inside.then_some(Pixel { x: raster.x as u32, y: raster.y as u32 })
    }
}

/// `1 / (π a²)`.
fn lens_density(radius: f64) -> Density<Area> {
    Density::new(1.0 / (PI * radius * radius))
}
