//! Drawing the sensor's end of a path.

use glam::{DVec2, DVec3};

use crate::measure::Density;
use crate::path::Vertex;
use crate::sampler::Random;
use crate::scene::Scene;
use crate::scene::emitter::DirectSample;
use crate::warp;

use super::densities::lens_density;
use super::{Kind, Pixel, Sensor};

/// A billionth away from the ends of `[0, 1]`, so that what is drawn there in a pixel is not another's by rounding.
#[inline(always)]
pub(super) fn inwards(u: f64) -> f64 {
    const MARGIN: f64 = 1e-9;
    u.clamp(MARGIN, 1.0 - MARGIN)
}

impl Pixel {
    /// The point of the film at `u` of the pixel's square.
    #[inline(always)]
    pub(super) fn at(self, u: [f64; 2]) -> DVec2 {
        DVec2::new(f64::from(self.x) + inwards(u[0]), f64::from(self.y) + inwards(u[1]))
    }
}

/// `scene` is the one that the sensor belongs to.
impl Sensor {
    /// Draws x_k and the direction of the last edge for a pixel.
    #[must_use]
    #[inline(always)]
    pub fn sample(&self, scene: &Scene, pixel: Pixel, random: &mut Random) -> (Vertex, DVec3) {
        let u = random.uniform4();
        if let Kind::Meter(meter) = self.kind {
            return self.sample_meter(meter, scene, pixel, u, random);
        }
        let (raster, zeta) = match &self.filter {
            None => (pixel.at([u[0], u[1]]), 0.0),
            Some(filter) => filter.sample(pixel, [u[0], u[1]].map(inwards), inwards(random.uniform())),
        };
        self.start(raster, zeta, [u[2], u[3]])
    }

    /// x_k and the direction of the last edge through a point of the film, in pixels from the top left; `u`, uniform in
    /// `[0, 1)²`, is the place on the lens. Where several pixels share the point, it is the first one's.
    #[must_use]
    pub fn through(&self, raster: DVec2, u: [f64; 2]) -> (Vertex, DVec3) {
        match self.kind {
            Kind::Meter(meter) => self.meter_through(meter, raster, u),
            _ => self.start(raster, 0.0, u),
        }
    }

    /// A point of the image, towards right and up, from one of the film's unit square.
    #[inline(always)]
    pub(super) fn image_at(&self, unit: DVec2) -> DVec2 {
        (unit * 2.0 - 1.0) * DVec2::new(1.0, -1.0) * self.half_extent + self.image_centre
    }

    #[inline(always)]
    fn start(&self, raster: DVec2, zeta: f64, u: [f64; 2]) -> (Vertex, DVec3) {
        let image = self.image_at(raster / self.size());
        let in_image = self.right * image.x + self.up * image.y;
        match self.kind {
            Kind::ThinLens { radius, focus_distance } => {
                let offset = self.on_lens(radius, u);
                let direction = (in_image + self.forward) * focus_distance - offset;
                (self.vertex(self.position + offset, zeta), direction.normalize())
            }
            Kind::Orthographic => (self.vertex(self.position + in_image, zeta), self.forward),
            Kind::Pinhole | Kind::Meter(_) => (self.vertex(self.position, zeta), (in_image + self.forward).normalize()),
        }
    }

    /// Draws x_k alone, for all pixels, with the density of its position; `None` unless it [has one](Self::has_position).
    #[must_use]
    pub fn sample_position(&self, scene: &Scene, random: &mut Random) -> Option<Vertex> {
        let offset = match self.kind {
            Kind::Pinhole => {
                let _ = random.uniform4();
                DVec3::ZERO
            }
            Kind::ThinLens { radius, .. } => {
                let u = random.uniform4();
                self.on_lens(radius, [u[2], u[3]])
            }
            Kind::Orthographic => return None,
            Kind::Meter(meter) => return self.meter_position(meter, scene, random),
        };
        Some(self.vertex(self.position + offset, self.zeta(random)))
    }

    /// Draws x_k for a given x_{k−1} (technique t = 1), for all pixels; `None` where the sensor cannot see it.
    #[must_use]
    #[inline(always)]
    pub fn sample_direct(&self, scene: &Scene, from: &Vertex, random: &mut Random) -> Option<DirectSample> {
        if let Kind::Meter(meter) = self.kind {
            return self.meter_sample_direct(meter, scene, from, random);
        }
        let u = random.uniform2();
        let zeta = self.zeta(random);
        match self.kind {
            Kind::ThinLens { radius, .. } => {
                let vertex = self.vertex(self.position + self.on_lens(radius, u), zeta);
                Some(DirectSample { vertex, density: lens_density(radius) })
            }
            Kind::Orthographic => {
                let depth = (from.position - self.position).dot(self.forward);
                let vertex = self.vertex(from.position - self.forward * depth, zeta);
                (depth > 0.0).then_some(DirectSample { vertex, density: self.direct_density(from, &vertex) })
            }
            Kind::Pinhole | Kind::Meter(_) => {
                Some(DirectSample { vertex: self.vertex(self.position, zeta), density: Density::new(1.0) })
            }
        }
    }

    /// Where a light walk that leaves `from` along `direction`, and meets the next surface at `t_max`, passes through the
    /// lens or ends on the sensor, for all pixels.
    #[must_use]
    #[inline]
    pub fn crossing(
        &self,
        scene: &Scene,
        from: &Vertex,
        direction: DVec3,
        t_max: f64,
        random: &mut Random,
    ) -> Option<Vertex> {
        match self.kind {
            Kind::Pinhole | Kind::Orthographic => None,
            Kind::Meter(meter) => self.meter_crossing(meter, scene, from, direction, t_max, random),
            Kind::ThinLens { radius, .. } => {
                let (t, position) = self.in_plane(from, direction)?;
                let inside = (position - self.position).length_squared() <= radius * radius;
                (inside && t < t_max).then(|| self.vertex(position, self.zeta(random)))
            }
        }
    }

    /// Where a ray that comes from the front meets the plane of the lens or the window, and at what distance.
    #[inline]
    pub(super) fn in_plane(&self, from: &Vertex, direction: DVec3) -> Option<(f64, DVec3)> {
        let approach = -direction.dot(self.forward);
        if approach <= 0.0 {
            return None;
        }
        let t = (from.position - self.position).dot(self.forward) / approach;
        (t > 0.0).then(|| (t, from.position + direction * t))
    }

    #[inline(always)]
    fn on_lens(&self, radius: f64, u: [f64; 2]) -> DVec3 {
        let DVec2 { x, y } = warp::concentric_disk(u);
        (self.right * x + self.up * y) * radius
    }
}
