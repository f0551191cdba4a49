//! The numbers that a camera's importance is made of.

use glam::{DVec2, DVec3};

use crate::scene::description::Lens;

use super::{Kind, Sensor};

/// A pinhole or thin-lens camera whose pixels are boxes. With n the film's pixels, A = 4 · half_extent.x · half_extent.y / n and
/// θ the angle between an edge and `forward`, a pinhole has `W_e = 1 / (A cos³θ)` and a lens of radius a
/// `W_e = 1 / (π a² A cos⁴θ)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The pinhole or the lens's centre, relative to the scene's centre \[m\].
    pub position: DVec3,
    /// Towards the right of the image, of length one.
    pub right: DVec3,
    /// Towards its top, of length one.
    pub up: DVec3,
    /// Where it looks, of length one.
    pub forward: DVec3,
    /// Centre of the film's window in the image at distance one, towards right and up.
    pub image_centre: DVec2,
    /// Half the extent of the window, alike.
    pub half_extent: DVec2,
    /// `None` for a pinhole.
    pub lens: Option<Lens>,
}

impl Sensor {
    /// What it is made of; `None` where it is no such camera: meters, orthographic films, filters wider than a pixel's box.
    #[must_use]
    pub fn camera(&self) -> Option<Camera> {
        let lens = match self.kind {
            Kind::Pinhole => None,
            Kind::ThinLens { radius, focus_distance } => Some(Lens { aperture_radius: radius, focus_distance }),
            Kind::Orthographic | Kind::Meter(_) => return None,
        };
        let Self { position, right, up, forward, image_centre, half_extent, .. } = *self;
        self.filter.is_none().then_some(Camera { position, right, up, forward, image_centre, half_extent, lens })
    }
}
