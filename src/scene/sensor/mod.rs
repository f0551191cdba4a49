//! Cameras and meters as sensors of path space: how important light is that arrives along the last edge of a path.
//!
//! For pixel j with the filter h_j, `W_e^j` is such that `I_j = ∫ W_e^j L dA dσ⊥` is the mean over the film, weighted by h_j
//! (and over the lens), of the radiance that arrives. Walks from the sensor are drawn *per pixel*: their density is the one
//! given j, so that `W_e^j / p` is a constant, [`Sensor::response`], and n = 1 walk serves each pixel; light walks serve all
//! pixels at once. Where several pixels share a point of the film, the sensor's vertex says which of them is meant: see the
//! `filter` module. Meters without an image are the extreme of that: all their pixels share everything.

mod camera;
mod densities;
mod distant;
mod filter;
mod meter;
mod sampling;
#[cfg(test)]
mod tests;

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use crate::path::{Vertex, VertexKind};
use crate::sampler::Random;

use super::accel::PrimitiveId;
use super::description::{FilmSize, PixelFilter, Projection, SensorDescription, Target};
use super::surfaces::Surfaces;
pub use camera::Camera;
use distant::Aperture;
use filter::Filter;
use meter::Meter;

pub(super) use distant::placed;

/// A pixel, by column and row from the top left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Pixel {
    /// Column.
    pub x: u32,
    /// Row.
    pub y: u32,
}

/// A camera or a meter with its film.
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
    /// `None` for a box of one pixel.
    filter: Option<Box<Filter>>,
    /// Of an irradiance meter; `None` for all else.
    surface: Option<Box<Surfaces>>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Pinhole,
    ThinLens { radius: f64, focus_distance: f64 },
    Orthographic,
    Meter(Meter),
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
    /// From its description, with positions relative to `centre`. Cameras have a filter; meters do without. A distant sensor
    /// has been placed, and the surface of an irradiance meter is given later.
    #[must_use]
    pub fn new(description: &SensorDescription, film: FilmSize, filter: PixelFilter, centre: DVec3) -> Self {
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
            Projection::Hemisphere => (DVec2::ONE, Kind::Meter(Meter::Hemisphere)),
            Projection::Window { half_width, half_height } => {
                (DVec2::new(half_width, half_height), Kind::Meter(Meter::Window))
            }
            Projection::Distant { target: Target::Parallelogram { u, v, .. } } => {
                (DVec2::ONE, Kind::Meter(Meter::Distant(Aperture::new(u, v, description.forward, false))))
            }
            Projection::Distant { target: Target::Ellipse { u, v, .. } } => {
                (DVec2::ONE, Kind::Meter(Meter::Distant(Aperture::new(u, v, description.forward, true))))
            }
            Projection::Surface { .. } => (DVec2::ONE, Kind::Meter(Meter::Surface)),
            Projection::Ray | Projection::Distant { target: Target::Scene | Target::Point(_) } => {
                (DVec2::ONE, Kind::Meter(Meter::Ray))
            }
        };
        let filter = match kind {
            Kind::Meter(_) => None,
            _ => Filter::new(filter, film).map(Box::new),
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
            filter,
            surface: None,
        }
    }

    /// The surface that an irradiance meter measures at.
    pub(super) fn attach(&mut self, surface: Surfaces) {
        self.surface = Some(Box::new(surface));
    }

    /// Size of the image.
    #[must_use]
    pub fn film(&self) -> FilmSize {
        self.film
    }

    /// All points from which its walks start lie within this distance of its position \[m\], or on a surface of the scene.
    #[must_use]
    pub fn extent(&self) -> f64 {
        match self.kind {
            Kind::Pinhole | Kind::Meter(Meter::Hemisphere | Meter::Ray | Meter::Surface) => 0.0,
            Kind::ThinLens { radius, .. } => radius,
            Kind::Meter(Meter::Distant(aperture)) => aperture.extent(),
            Kind::Orthographic | Kind::Meter(Meter::Window) => self.image_centre.length() + self.half_extent.length(),
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
        matches!(self.kind, Kind::Pinhole | Kind::ThinLens { .. } | Kind::Meter(Meter::Hemisphere | Meter::Surface))
    }

    /// It sees along one direction only: that of the last edge is Dirac.
    #[must_use]
    pub fn has_one_direction(&self) -> bool {
        matches!(self.kind, Kind::Orthographic | Kind::Meter(Meter::Ray | Meter::Distant(_)))
    }

    /// A point of it can be drawn for a vertex (technique t = 1): it is not Dirac in position and direction.
    #[must_use]
    pub fn can_be_connected(&self) -> bool {
        self.kind != Kind::Meter(Meter::Ray)
    }

    /// Light walks can end on it by chance (technique t = 0): it has a lens, a window or a surface of finite size.
    #[must_use]
    pub fn can_be_hit(&self) -> bool {
        matches!(self.kind, Kind::ThinLens { .. } | Kind::Meter(Meter::Window | Meter::Surface))
    }

    /// `W_e^j / p` of its own walks, which is what their contribution starts with: π for irradiance meters, which add radiance
    /// up by the cosine, and one for all else, which takes means of radiance.
    #[must_use]
    #[inline]
    pub fn response(&self) -> f64 {
        match self.kind {
            Kind::Meter(Meter::Hemisphere | Meter::Window | Meter::Surface) => PI,
            _ => 1.0,
        }
    }

    /// ζ for a vertex that is drawn for all pixels. No random number is used up where it decides nothing.
    #[inline]
    fn zeta(&self, random: &mut Random) -> f64 {
        let shared = match self.kind {
            Kind::Meter(meter) => !meter.has_image(),
            _ => self.filter.is_some(),
        };
        if shared { random.uniform() } else { 0.0 }
    }

    #[inline]
    fn vertex(&self, position: DVec3, zeta: f64) -> Vertex {
        let normal = if self.kind == Kind::Pinhole { DVec3::ZERO } else { self.forward };
        let kind = VertexKind::Sensor { zeta, primitive: PrimitiveId::NONE };
        Vertex { position, normal, shading_normal: normal, kind }
    }

    /// Of the film's window \[m²\], for those that have one in the scene: orthographic films and windows.
    #[must_use]
    pub fn area(&self) -> f64 {
        4.0 * self.half_extent.x * self.half_extent.y
    }

    #[inline]
    fn pixels(&self) -> f64 {
        f64::from(self.film.width) * f64::from(self.film.height)
    }

    #[inline]
    fn pixel_area(&self) -> f64 {
        self.area() / self.pixels()
    }

    #[inline]
    fn size(&self) -> DVec2 {
        DVec2::new(f64::from(self.film.width), f64::from(self.film.height))
    }
}
