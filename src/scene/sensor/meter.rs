//! Sensors that make no image but measure one radiometric quantity.
//!
//! The pixels of a hemisphere and of a window share what is measured; the mean over them is the quantity. Those of the other
//! meters all measure the same: ζ chooses the pixel, `H = n` is the number of pixels, and each owns an interval of 1/n.

use glam::{DVec2, DVec3};

use crate::geometry::Frame;
use crate::measure::{Area, Density};
use crate::path::{Edge, Vertex, VertexKind};
use crate::sampler::Random;
use crate::scene::Scene;
use crate::scene::emitter::{DirectSample, EdgeDensity};
use crate::warp;

use super::distant::Aperture;
use super::sampling::inwards;
use super::{Importance, Pixel, Sensor};

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Meter {
    /// Irradiance at a point.
    Hemisphere,
    /// Mean irradiance over a rectangle in space.
    Window,
    /// Radiance along a ray.
    Ray,
    /// Mean irradiance over the front of a shape of the scene, uniform by area.
    Surface,
    /// Mean radiance in one direction over an aperture.
    Distant(Aperture),
}

impl Meter {
    /// Its pixels share what is measured.
    pub fn has_image(self) -> bool {
        matches!(self, Self::Hemisphere | Self::Window)
    }
}

/// None of these is inlined: renders have cameras.
impl Sensor {
    #[inline(never)]
    pub(super) fn sample_meter(
        &self,
        meter: Meter,
        scene: &Scene,
        pixel: Pixel,
        u: [f64; 4],
        random: &mut Random,
    ) -> (Vertex, DVec3) {
        let index = f64::from(pixel.y) * f64::from(self.film.width) + f64::from(pixel.x);
        let zeta = (index + inwards(u[0])) / self.pixels();
        let at = [u[2], u[3]];
        match meter {
            Meter::Hemisphere | Meter::Window => self.meter_through(meter, pixel.at([u[0], u[1]]), at),
            Meter::Ray => (self.vertex(self.position, zeta), self.forward),
            Meter::Distant(aperture) => (self.vertex(self.position + aperture.sample(at), zeta), self.forward),
            Meter::Surface => {
                let vertex = self.on_surface(scene, zeta, random);
                (vertex, Frame::around(vertex.normal).to_world(warp::cosine_hemisphere(at)))
            }
        }
    }

    /// As [`through`](Self::through). On a surface, which has no image, nothing is told.
    #[inline(never)]
    pub(super) fn meter_through(&self, meter: Meter, raster: DVec2, u: [f64; 2]) -> (Vertex, DVec3) {
        let unit = raster / self.size();
        let image = self.image_at(unit);
        let (position, direction) = match meter {
            Meter::Hemisphere => (self.position, self.to_world(warp::cosine_hemisphere(unit.to_array()))),
            Meter::Window => {
                (self.position + self.right * image.x + self.up * image.y, self.to_world(warp::cosine_hemisphere(u)))
            }
            Meter::Distant(aperture) => (self.position + aperture.sample(u), self.forward),
            Meter::Ray | Meter::Surface => (self.position, self.forward),
        };
        (self.vertex(position, 0.0), direction)
    }

    pub(super) fn meter_position(&self, meter: Meter, scene: &Scene, random: &mut Random) -> Option<Vertex> {
        match meter {
            Meter::Hemisphere => {
                let _ = random.uniform4();
                Some(self.vertex(self.position, 0.0))
            }
            Meter::Surface => {
                let zeta = self.zeta(random);
                Some(self.on_surface(scene, zeta, random))
            }
            Meter::Window | Meter::Ray | Meter::Distant(_) => None,
        }
    }

    #[inline(never)]
    pub(super) fn meter_sample_direct(
        &self,
        meter: Meter,
        scene: &Scene,
        from: &Vertex,
        random: &mut Random,
    ) -> Option<DirectSample> {
        let u = random.uniform2();
        let zeta = self.zeta(random);
        let vertex = match meter {
            Meter::Hemisphere => self.vertex(self.position, zeta),
            Meter::Window => {
                let at = (DVec2::from_array(u) * 2.0 - 1.0) * self.half_extent + self.image_centre;
                self.vertex(self.position + self.right * at.x + self.up * at.y, zeta)
            }
            Meter::Surface => self.on_surface(scene, zeta, random),
            Meter::Distant(aperture) => {
                let depth = (from.position - self.position).dot(self.forward);
                let position = from.position - self.forward * depth;
                if depth <= 0.0 || !aperture.contains(position - self.position) {
                    return None;
                }
                self.vertex(position, zeta)
            }
            Meter::Ray => return None,
        };
        Some(DirectSample { vertex, density: self.meter_direct_density(meter, from, &vertex) })
    }

    #[inline(never)]
    pub(super) fn meter_direct_density(&self, meter: Meter, from: &Vertex, xk: &Vertex) -> Density<Area> {
        match meter {
            Meter::Hemisphere => Density::new(1.0),
            Meter::Window => Density::new(1.0 / self.area()),
            Meter::Surface => self.surface_density(),
            Meter::Distant(_) => Density::new(1.0) * Edge::between(from, xk).solid_angle_to_area(xk),
            Meter::Ray => Density::ZERO,
        }
    }

    #[inline(never)]
    pub(super) fn meter_density(&self, meter: Meter, xk: &Vertex, direction: DVec3) -> EdgeDensity {
        let cosine = warp::cosine_hemisphere_density(xk.normal.dot(direction));
        let one = Density::new(1.0);
        match meter {
            Meter::Hemisphere => EdgeDensity { position: one, direction: self.pixels() * cosine },
            Meter::Window => EdgeDensity { position: Density::new(1.0 / self.pixel_area()), direction: cosine },
            Meter::Surface => EdgeDensity { position: self.surface_density(), direction: self.pixels() * cosine },
            Meter::Ray => EdgeDensity { position: one, direction: Density::new(self.pixels()) },
            Meter::Distant(aperture) => {
                EdgeDensity { position: Density::new(self.pixels() / aperture.area()), direction: Density::new(1.0) }
            }
        }
    }

    #[inline(never)]
    pub(super) fn meter_importance(&self, meter: Meter, xk: &Vertex, direction: DVec3) -> Option<Importance> {
        let cos = xk.normal.dot(direction);
        // Points at one place have no direction.
        if cos <= 0.0 || cos.is_nan() {
            return None;
        }
        let offset = xk.position - self.position;
        let pixel = match meter {
            Meter::Hemisphere => {
                let direction = DVec2::new(direction.dot(self.right), direction.dot(self.up));
                self.pixel_of(DVec2::from_array(warp::concentric_square(direction)) * self.size())?
            }
            Meter::Window => self.pixel_of(self.raster(DVec2::new(offset.dot(self.right), offset.dot(self.up))))?,
            // Paths of its own walks come back along it but for rounding; no others reach it.
            Meter::Ray if cos <= 1.0 - 1e-9 => return None,
            Meter::Distant(aperture) if !aperture.contains(offset) => return None,
            Meter::Ray | Meter::Distant(_) | Meter::Surface => self.chosen(xk)?,
        };
        let density = self.meter_density(meter, xk, direction);
        let value = self.response() * density.position.value() * density.direction.value() / xk.abs_cos(direction);
        Some(Importance { pixel, value })
    }

    #[inline(never)]
    pub(super) fn meter_crossing(
        &self,
        meter: Meter,
        scene: &Scene,
        from: &Vertex,
        direction: DVec3,
        t_max: f64,
        random: &mut Random,
    ) -> Option<Vertex> {
        match meter {
            Meter::Window => {
                let (t, position) = self.in_plane(from, direction)?;
                let offset = position - self.position;
                let at = DVec2::new(offset.dot(self.right), offset.dot(self.up)) - self.image_centre;
                let inside = at.abs().cmple(self.half_extent).all();
                (inside && t < t_max).then(|| self.vertex(position, 0.0))
            }
            // A surface of the scene: what the walk meets next is on it, or it is not.
            Meter::Surface => {
                let next = scene.trace(from, direction)?;
                let front = next.normal.dot(direction) < 0.0;
                let own = || self.surface.as_ref().is_some_and(|surface| surface.contains(next.primitive()));
                (front && own()).then(|| Self::end_on(next, self.zeta(random)))
            }
            Meter::Hemisphere | Meter::Ray | Meter::Distant(_) => None,
        }
    }

    /// The pixel that ζ chooses, where all measure the same.
    fn chosen(&self, xk: &Vertex) -> Option<Pixel> {
        let VertexKind::Sensor { zeta, .. } = xk.kind else { return None };
        let (width, height) = (u64::from(self.film.width), u64::from(self.film.height));
        let index = ((zeta * self.pixels()) as u64).min(width * height - 1);
        Some(Pixel { x: (index % width) as u32, y: (index / width) as u32 })
    }

    /// Uniform by area.
    fn on_surface(&self, scene: &Scene, zeta: f64, random: &mut Random) -> Vertex {
        let surface = self.surface.as_ref().expect("an irradiance meter is attached to a surface");
        Self::end_on(surface.sample(scene, random.uniform3()), zeta)
    }

    fn surface_density(&self) -> Density<Area> {
        self.surface.as_ref().map_or(Density::ZERO, |surface| surface.density())
    }

    /// The sensor's vertex where a vertex of the scene is.
    fn end_on(at: Vertex, zeta: f64) -> Vertex {
        let kind = VertexKind::Sensor { zeta, primitive: at.primitive() };
        Vertex { shading_normal: at.normal, kind, ..at }
    }

    fn to_world(&self, local: DVec3) -> DVec3 {
        self.right * local.x + self.up * local.y + self.forward * local.z
    }
}
