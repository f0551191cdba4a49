//! Scattering by models that depend on the point of the surface: the counterpart of [`scatter`](super::scatter) for them.

use glam::DVec3;

use crate::geometry::Frame;
use crate::measure::{Density, ProjectedSolidAngle, SolidAngle};
use crate::path::Vertex;
use crate::spectrum::Rgb;

use super::Scene;
use super::bsdf::{BsdfModel, CompositeAt, LobeDensity, Side};
use super::material::Scattering;
use super::scatter::{Scattered, Sides, dirac_ratio};

/// The model at a vertex, its normals, and the frame that it is in.
struct Here<'a> {
    model: CompositeAt<'a>,
    sides: Sides,
    frame: Frame,
}

impl Scene {
    /// `None` where nothing that comes from there is scattered.
    fn here(&self, vertex: &Vertex, from: DVec3) -> Option<Here<'_>> {
        let Scattering::Varying(composite) = &self.material_of(vertex).scattering else { return None };
        let sides = Sides::as_they_are(vertex, from)?;
        let (frame, at) = self.surface_point(vertex);
        Some(Here { model: composite.at(at), sides, frame })
    }

    /// The same where both directions are known.
    fn here_for(&self, vertex: &Vertex, from: DVec3, to: DVec3) -> Option<Here<'_>> {
        self.here(vertex, from).filter(|here| here.sides.agree(to))
    }

    #[inline(never)]
    pub(super) fn varying_scatter(&self, vertex: &Vertex, to_emitter: DVec3, to_sensor: DVec3) -> Rgb {
        let Some(Here { model, sides, frame }) = self.here_for(vertex, to_sensor, to_emitter) else {
            return Rgb::BLACK;
        };
        model.eval(frame.to_local(to_emitter), frame.to_local(to_sensor)) * sides.ratio(to_emitter)
    }

    #[inline(never)]
    pub(super) fn varying_density(&self, vertex: &Vertex, from: DVec3, to: DVec3) -> Density<SolidAngle> {
        let Some(Here { model, frame, .. }) = self.here_for(vertex, from, to) else { return Density::ZERO };
        model.density(frame.to_local(from), frame.to_local(to))
    }

    #[inline(never)]
    pub(super) fn varying_dirac(&self, vertex: &Vertex, to_emitter: DVec3, to_sensor: DVec3) -> Rgb {
        let Some(Here { model, frame, .. }) = self.here_for(vertex, to_sensor, to_emitter) else { return Rgb::BLACK };
        model.eval_dirac(frame.to_local(to_emitter), frame.to_local(to_sensor))
    }

    #[inline(never)]
    pub(super) fn varying_dirac_density(
        &self,
        vertex: &Vertex,
        side: Side,
        from: DVec3,
        to: DVec3,
    ) -> Density<ProjectedSolidAngle> {
        let Some(Here { model, sides, frame }) = self.here_for(vertex, from, to) else { return Density::ZERO };
        model.density_dirac(side, frame.to_local(from), frame.to_local(to)) * dirac_ratio(&sides, side, from, to)
    }

    #[inline(never)]
    pub(super) fn sample_varying(&self, vertex: &Vertex, side: Side, from: DVec3, u: [f64; 3]) -> Option<Scattered> {
        let Here { model, sides, frame } = self.here(vertex, from)?;
        let sample = model.sample(side, frame.to_local(from), u)?;
        let to = frame.to_world(sample.to);
        if !sides.agree(to) {
            return None;
        }
        Some(match sample.density {
            LobeDensity::Finite(_) => {
                let (to_emitter, _) = side.by_role(from, to);
                Scattered { to, density: sample.density, value: sample.value * sides.ratio(to_emitter) }
            }
            LobeDensity::Dirac(density) => {
                let density = density * dirac_ratio(&sides, side, from, to);
                Scattered { to, density: LobeDensity::Dirac(density), value: sample.value }
            }
        })
    }

    pub(super) fn varying_scale(&self, vertex: &Vertex, to_emitter: DVec3, to_sensor: DVec3) -> f64 {
        let Some(Here { model, frame, .. }) = self.here_for(vertex, to_sensor, to_emitter) else { return 1.0 };
        model.radiance_scale(frame.to_local(to_emitter), frame.to_local(to_sensor))
    }
}
