//! Scattering at a vertex: the models of [`bsdf`](super::bsdf) in the world, with sidedness and shading normals.
//!
//! Everything is with respect to the *geometric* normal, whose cosines the geometry factor has. With a shading normal N_s
//! beside the geometric N_g the scattering function is `f̄_s = f_s |ω·N_s| / |ω·N_g|`, where ω leads to the emitter
//! (Veach 1997, §5.3). Directions for which the two normals disagree about the side are black.

use glam::DVec3;

use crate::geometry::Frame;
use crate::measure::{Density, ProjectedSolidAngle, SolidAngle};
use crate::path::Vertex;
use crate::spectrum::Rgb;

use super::Scene;
use super::bsdf::{LobeDensity, Side};
use super::material::{Scattering, SurfaceMaterial};

/// The next direction of a walk.
#[derive(Clone, Copy, Debug)]
pub struct Scattered {
    /// The drawn direction, away from the vertex, of length one.
    pub to: DVec3,
    /// Its density, or the coefficient of a Dirac one.
    pub density: LobeDensity,
    /// `f̄_s(to_emitter → to_sensor)` \[1/sr\], or the coefficient of the Dirac lobe.
    pub value: Rgb,
}

impl Scattered {
    /// The walk took a Dirac lobe.
    #[must_use]
    #[inline]
    pub fn is_dirac(&self) -> bool {
        matches!(self.density, LobeDensity::Dirac(_))
    }

    /// `f̄_s |cos θ| / p_σ` of the drawn direction: what the throughput of the walk is multiplied by.
    #[must_use]
    #[inline(always)]
    pub fn weight(&self, vertex: &Vertex) -> Rgb {
        match self.density {
            LobeDensity::Finite(density) => self.value * (vertex.abs_cos(self.to) / density.value()),
            LobeDensity::Dirac(density) => self.value / density.value(),
        }
    }
}

/// The normals as the arriving light sees them, both on its side.
pub(super) struct Sides {
    pub(super) shading: DVec3,
    geometric: DVec3,
}

impl Sides {
    /// `None` where the surface absorbs: on the back of a one-sided one.
    #[inline(always)]
    fn new(material: &SurfaceMaterial, vertex: &Vertex, from: DVec3) -> Option<Self> {
        let mut sides = Self { shading: vertex.shading_normal, geometric: vertex.normal };
        if material.two_sided && from.dot(vertex.normal) < 0.0 {
            sides = Self { shading: -sides.shading, geometric: -sides.geometric };
        }
        (sides.agree(from) && (material.transmits || from.dot(sides.geometric) > 0.0)).then_some(sides)
    }

    /// Of a model that tells the sides apart itself.
    pub(super) fn as_they_are(vertex: &Vertex, from: DVec3) -> Option<Self> {
        let sides = Self { shading: vertex.shading_normal, geometric: vertex.normal };
        sides.agree(from).then_some(sides)
    }

    /// Both normals have this direction on the same side.
    #[inline(always)]
    pub(super) fn agree(&self, direction: DVec3) -> bool {
        direction.dot(self.shading) * direction.dot(self.geometric) > 0.0
    }

    /// `|ω·N_s| / |ω·N_g|`.
    #[inline(always)]
    pub(super) fn ratio(&self, direction: DVec3) -> f64 {
        if self.shading == self.geometric {
            return 1.0;
        }
        (direction.dot(self.shading) / direction.dot(self.geometric)).abs()
    }
}

impl Scene {
    /// `f̄_s(to_emitter → to_sensor)` \[1/sr\] of the finite lobes.
    #[must_use]
    #[inline(always)]
    pub fn scatter(&self, vertex: &Vertex, to_emitter: DVec3, to_sensor: DVec3) -> Rgb {
        let material = self.material_of(vertex);
        let Scattering::Uniform(bsdf) = &material.scattering else {
            return self.varying_scatter(vertex, to_emitter, to_sensor);
        };
        let Some(sides) = Sides::new(material, vertex, to_sensor).filter(|s| s.agree(to_emitter)) else {
            return Rgb::BLACK;
        };
        let frame = Frame::around(sides.shading);
        let value = bsdf.eval(frame.to_local(to_emitter), frame.to_local(to_sensor));
        value * sides.ratio(to_emitter)
    }

    /// The density with which a walk that comes from `from` draws `to` by the finite lobes.
    #[must_use]
    #[inline(always)]
    pub fn scatter_density(&self, vertex: &Vertex, from: DVec3, to: DVec3) -> Density<SolidAngle> {
        let material = self.material_of(vertex);
        let Scattering::Uniform(bsdf) = &material.scattering else {
            return self.varying_density(vertex, from, to);
        };
        let Some(sides) = Sides::new(material, vertex, from).filter(|s| s.agree(to)) else {
            return Density::ZERO;
        };
        let frame = Frame::around(sides.shading);
        bsdf.density(frame.to_local(from), frame.to_local(to))
    }

    /// The coefficient of `δ_σ⊥` in `f̄_s` for a pair of directions joined by a Dirac lobe. Shading normals leave it as it is.
    #[must_use]
    pub fn scatter_dirac(&self, vertex: &Vertex, to_emitter: DVec3, to_sensor: DVec3) -> Rgb {
        let material = self.material_of(vertex);
        let Scattering::Uniform(bsdf) = &material.scattering else {
            return self.varying_dirac(vertex, to_emitter, to_sensor);
        };
        let Some(sides) = Sides::new(material, vertex, to_sensor).filter(|s| s.agree(to_emitter)) else {
            return Rgb::BLACK;
        };
        let frame = Frame::around(sides.shading);
        bsdf.eval_dirac(frame.to_local(to_emitter), frame.to_local(to_sensor))
    }

    /// The counterpart of [`scatter_density`](Self::scatter_density) for Dirac lobes, as [`LobeDensity::Dirac`] has it.
    #[must_use]
    pub fn scatter_dirac_density(
        &self,
        vertex: &Vertex,
        side: Side,
        from: DVec3,
        to: DVec3,
    ) -> Density<ProjectedSolidAngle> {
        let material = self.material_of(vertex);
        let Scattering::Uniform(bsdf) = &material.scattering else {
            return self.varying_dirac_density(vertex, side, from, to);
        };
        let Some(sides) = Sides::new(material, vertex, from).filter(|s| s.agree(to)) else {
            return Density::ZERO;
        };
        let frame = Frame::around(sides.shading);
        let density = bsdf.density_dirac(side, frame.to_local(from), frame.to_local(to));
        density * dirac_ratio(&sides, side, from, to)
    }

    /// Draws the next direction of a walk that started on `side` and comes from `from`; `None` where it ends.
    #[must_use]
    #[inline(always)]
    pub fn sample_scatter(&self, vertex: &Vertex, side: Side, from: DVec3, u: [f64; 3]) -> Option<Scattered> {
        let material = self.material_of(vertex);
        let Scattering::Uniform(bsdf) = &material.scattering else {
            return self.sample_varying(vertex, side, from, u);
        };
        let sides = Sides::new(material, vertex, from)?;
        let frame = Frame::around(sides.shading);
        let sample = bsdf.sample(side, frame.to_local(from), u)?;
        let to = frame.to_world(sample.to);
        if !sides.agree(to) || (!material.transmits && to.dot(sides.geometric) <= 0.0) {
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

    /// `(η_o/η_i)²` for a pair of directions: what refraction does to radiance beyond energy.
    #[must_use]
    #[inline]
    pub fn radiance_scale(&self, vertex: &Vertex, to_emitter: DVec3, to_sensor: DVec3) -> f64 {
        let material = self.material_of(vertex);
        if material.transmits { self.refraction_scale(vertex, to_emitter, to_sensor) } else { 1.0 }
    }

    #[inline(never)]
    fn refraction_scale(&self, vertex: &Vertex, to_emitter: DVec3, to_sensor: DVec3) -> f64 {
        match &self.material_of(vertex).scattering {
            Scattering::Uniform(bsdf) => {
                let frame = Frame::around(vertex.shading_normal);
                bsdf.radiance_scale(frame.to_local(to_emitter), frame.to_local(to_sensor))
            }
            Scattering::Varying(_) => self.varying_scale(vertex, to_emitter, to_sensor),
        }
    }

    /// Light passes through the surface at this vertex.
    #[must_use]
    pub fn transmits(&self, vertex: &Vertex) -> bool {
        self.material_of(vertex).transmits
    }

    /// Some surface has Dirac lobes: a mirror, smooth glass, a smooth coat.
    #[must_use]
    pub fn has_dirac_surfaces(&self) -> bool {
        self.materials.iter().any(|material| material.scattering.has_dirac())
    }

    /// A connection to this vertex can succeed: it scatters by finite lobes too.
    #[must_use]
    #[inline]
    pub fn has_finite(&self, vertex: &Vertex) -> bool {
        self.material_of(vertex).scattering.has_finite()
    }

    /// Its finite lobes are glossy rather than diffuse, as [`BsdfModel::is_glossy`](super::bsdf::BsdfModel::is_glossy) has
    /// it; false where there is no surface.
    #[must_use]
    pub fn is_glossy(&self, vertex: &Vertex) -> bool {
        vertex.scatters() && self.material_of(vertex).scattering.is_glossy()
    }
}

/// What shading normals do to the Dirac density of a walk from the emitter: the mirror of the shading normal preserves
/// `|cos θ_s| dσ` (up to η²), while the path counts in `|cos θ_g| dσ` on the emitter's side.
pub(super) fn dirac_ratio(sides: &Sides, side: Side, from: DVec3, to: DVec3) -> f64 {
    match side {
        Side::Sensor => 1.0,
        Side::Emitter => sides.ratio(to) / sides.ratio(from),
    }
}
