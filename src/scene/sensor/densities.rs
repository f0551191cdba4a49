//! Densities and importance of the sensor's end of a path: pure functions of x_k and the direction of the last edge.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use crate::measure::{Area, Density};
use crate::path::{Edge, Vertex, VertexKind};
use crate::scene::emitter::EdgeDensity;

use super::filter::Filter;
use super::{Importance, Kind, Pixel, Sensor};

impl Sensor {
    /// The density with which [`sample`](Self::sample) draws x_k and `direction` for the pixel that they belong to.
    #[must_use]
    #[inline(always)]
    pub fn density(&self, xk: &Vertex, direction: DVec3) -> EdgeDensity {
        if let Kind::Meter(meter) = self.kind {
            return self.meter_density(meter, xk, direction);
        }
        let density = self.density_of_box(direction);
        match &self.filter {
            None => density,
            Some(filter) => self.filtered(density, filter, xk, direction),
        }
    }

    /// One pixel to every point of the film: the measure of points in pixels, as one of edges.
    #[inline(always)]
    fn density_of_box(&self, direction: DVec3) -> EdgeDensity {
        let pixel_area = self.pixel_area();
        let cos = self.forward.dot(direction);
        // dσ = dA cos³θ, with A on the image at distance one.
        let per_solid_angle = Density::new(1.0 / (pixel_area * cos * cos * cos));
        match self.kind {
            Kind::ThinLens { radius, .. } => EdgeDensity { position: lens_density(radius), direction: per_solid_angle },
            Kind::Orthographic => {
                EdgeDensity { position: Density::new(1.0 / pixel_area), direction: Density::new(1.0) }
            }
            Kind::Pinhole | Kind::Meter(_) => EdgeDensity { position: Density::new(1.0), direction: per_solid_angle },
        }
    }

    /// H(r) times that of a box, at what depends on r: the position of an orthographic film, else the direction.
    #[inline(never)]
    fn filtered(&self, density: EdgeDensity, filter: &Filter, xk: &Vertex, direction: DVec3) -> EdgeDensity {
        let total = filter.total(self.raster(self.in_image(xk, direction)));
        match self.kind {
            Kind::Orthographic => EdgeDensity { position: total * density.position, ..density },
            _ => EdgeDensity { direction: total * density.direction, ..density },
        }
    }

    /// The pixel that sees along the last edge, and how much; `direction` leads from x_k to x_{k−1}.
    #[must_use]
    #[inline(always)]
    pub fn importance(&self, xk: &Vertex, direction: DVec3) -> Option<Importance> {
        if let Kind::Meter(meter) = self.kind {
            return self.meter_importance(meter, xk, direction);
        }
        let cos = self.forward.dot(direction);
        // Points at one place have no direction.
        if cos <= 0.0 || cos.is_nan() {
            return None;
        }
        let raster = self.raster(self.in_image(xk, direction));
        let pixel = match &self.filter {
            None => self.pixel_of(raster)?,
            Some(filter) => {
                let VertexKind::Sensor { zeta, .. } = xk.kind else { return None };
                filter.owner(raster, zeta)?
            }
        };
        let density = self.density(xk, direction);
        let value = density.position.value() * density.direction.value() / xk.abs_cos(direction);
        Some(Importance { pixel, value })
    }

    /// The density with which [`sample_direct`](Self::sample_direct) draws x_k for x_{k−1}.
    #[must_use]
    #[inline(always)]
    pub fn direct_density(&self, from: &Vertex, xk: &Vertex) -> Density<Area> {
        match self.kind {
            Kind::Pinhole => Density::new(1.0),
            Kind::ThinLens { radius, .. } => lens_density(radius),
            Kind::Orthographic => {
                let edge = Edge::between(from, xk);
                Density::new(1.0) * edge.solid_angle_to_area(xk)
            }
            Kind::Meter(meter) => self.meter_direct_density(meter, from, xk),
        }
    }

    /// Where the last edge of a camera meets the image, towards right and up: at distance one, or in metres.
    #[inline(always)]
    fn in_image(&self, xk: &Vertex, direction: DVec3) -> DVec2 {
        let offset = xk.position - self.position;
        let to_image = || direction / self.forward.dot(direction);
        let point = match self.kind {
            Kind::ThinLens { focus_distance, .. } => to_image() + offset / focus_distance,
            Kind::Orthographic => offset,
            Kind::Pinhole | Kind::Meter(_) => to_image(),
        };
        DVec2::new(point.dot(self.right), point.dot(self.up))
    }

    /// A point of the image in pixels of the film, from the top left.
    #[inline]
    pub(super) fn raster(&self, image: DVec2) -> DVec2 {
        ((image - self.image_centre) / self.half_extent * DVec2::new(1.0, -1.0) + 1.0) * 0.5 * self.size()
    }

    /// The pixel that a point of the film lies in.
    #[inline]
    pub(super) fn pixel_of(&self, raster: DVec2) -> Option<Pixel> {
        let inside = raster.cmpge(DVec2::ZERO).all() && raster.cmplt(self.size()).all();
        inside.then_some(Pixel { x: raster.x as u32, y: raster.y as u32 })
    }
}

/// `1 / (π a²)`.
pub(super) fn lens_density(radius: f64) -> Density<Area> {
    Density::new(1.0 / (PI * radius * radius))
}
