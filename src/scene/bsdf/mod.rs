//! How surfaces scatter, in the frame of the shading normal (z up, towards the front).
//!
//! Directions point away from the surface and are named by the side of the path that they lead to: `to_emitter` and
//! `to_sensor` where the roles matter, `from` (the walk's previous vertex) and `to` (its next) where only the walk does.
//! Nothing here knows shading normals, sidedness or the measure of a path; `SurfacePoint` adds what those need.

mod composite;
mod conductor;
mod dielectric;
mod diffuse;
pub mod fresnel;
mod gltf;
mod material;
mod microfacet;
mod perturbed;
mod plastic;
mod principled;
mod rough_dielectric;
mod rough_plastic;
mod source;
#[cfg(test)]
mod tests;
mod thin_dielectric;

use std::fmt::Debug;
use std::sync::Arc;

use glam::DVec3;

use crate::measure::{Density, ProjectedSolidAngle, SolidAngle};
use crate::spectrum::Rgb;

pub(crate) use composite::{Composite, CompositeAt};
pub use conductor::{Conductor, RoughConductor};
pub use dielectric::{Dielectric, Tints};
pub use diffuse::Diffuse;
pub use gltf::Gltf;
pub use material::MaterialError;
pub use microfacet::{Beckmann, Ggx, Microfacets};
pub use plastic::{Base, Plastic};
pub use principled::Principled;
pub use rough_dielectric::RoughDielectric;
pub use rough_plastic::{RoughCoat, RoughPlastic};
pub use thin_dielectric::ThinDielectric;

/// The end of the path from which a walk started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The walk started at the sensor: it draws `to_emitter`, coming from `to_sensor`.
    Sensor,
    /// The walk started at an emitter: it draws `to_sensor`, coming from `to_emitter`.
    Emitter,
}

impl Side {
    /// `(to_emitter, to_sensor)` of a walk from this side that comes from `from` and goes on along `to`.
    #[must_use]
    #[inline]
    pub fn by_role(self, from: DVec3, to: DVec3) -> (DVec3, DVec3) {
        match self {
            Self::Sensor => (to, from),
            Self::Emitter => (from, to),
        }
    }
}

/// How the next direction of a walk is distributed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LobeDensity {
    /// A density with respect to solid angle \[1/sr\].
    Finite(Density<SolidAngle>),
    /// The coefficient of a Dirac distribution in projected solid angle *on the emitter's side*. A walk from the sensor
    /// that takes the lobe with probability P has P; one from the emitter has P (η_o/η_i)², where η_o and η_i are the
    /// indices of refraction on the sensor's and on the emitter's side, because dσ⊥ shrinks across the refraction.
    Dirac(Density<ProjectedSolidAngle>),
}

/// The result of [`Bsdf::sample`].
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    /// The drawn direction, away from the surface, of length one.
    pub to: DVec3,
    /// How likely it was.
    pub density: LobeDensity,
    /// `f_s(to_emitter → to_sensor)` \[1/sr\], or the Dirac coefficient of [`Bsdf::eval_dirac`].
    pub value: Rgb,
}

/// What a model of scattering answers. All directions are unit vectors in the frame of the shading normal.
pub trait BsdfModel: Debug + Send + Sync {
    /// `f_s(to_emitter → to_sensor)` \[1/sr\] of the finite lobes, for radiance: refraction carries `(η_o/η_i)²`
    /// (Veach 1997, §5.2). Zero where it does not scatter.
    fn eval(&self, to_emitter: DVec3, to_sensor: DVec3) -> Rgb;

    /// The density with which a walk coming from `from` draws `to` by its finite lobes, the choice of lobe included.
    fn density(&self, from: DVec3, to: DVec3) -> Density<SolidAngle>;

    /// The coefficient of the Dirac distribution `δ_σ⊥(to_emitter − …)` in `f_s`, for a pair of directions that the Dirac
    /// lobe joins; which lobe (reflection or refraction) follows from their hemispheres. Zero without such a lobe.
    fn eval_dirac(&self, _to_emitter: DVec3, _to_sensor: DVec3) -> Rgb {
        Rgb::BLACK
    }

    /// The counterpart of [`density`](Self::density) for the Dirac lobes, as [`LobeDensity::Dirac`] defines it.
    fn density_dirac(&self, _side: Side, _from: DVec3, _to: DVec3) -> Density<ProjectedSolidAngle> {
        Density::ZERO
    }

    /// Draws the next direction of a walk that started on `side`; `None` where the walk ends. `u` is uniform in `[0, 1)³`.
    fn sample(&self, side: Side, from: DVec3, u: [f64; 3]) -> Option<BsdfSample>;

    /// `(η_o/η_i)²` for the pair: the part of `f_s` that changes radiance but not energy. One without refraction.
    fn radiance_scale(&self, _to_emitter: DVec3, _to_sensor: DVec3) -> f64 {
        1.0
    }

    /// It has lobes with a finite density, so a connection to it can succeed.
    fn has_finite(&self) -> bool {
        true
    }

    /// It has Dirac lobes, too or alone.
    fn has_dirac(&self) -> bool {
        !self.has_finite()
    }

    /// It depends on the direction of the tangents, not only of the normal.
    fn is_anisotropic(&self) -> bool {
        false
    }

    /// Its finite lobes are glossy rather than diffuse: letter G, not D, in the notation of paths.
    fn is_glossy(&self) -> bool {
        true
    }

    /// It scatters through the surface: its back is the inside, and sidedness does not apply.
    fn transmits(&self) -> bool {
        false
    }

    /// It has a Dirac lobe through the surface that bends light. One that does not must join opposite directions only.
    fn bends(&self) -> bool {
        self.transmits() && self.has_dirac()
    }
}

/// Directions count as opposite below this squared distance: those of a walk are rounded along short edges.
const OPPOSITE: f64 = 1e-12;

/// Light goes straight from one of these directions to the other.
fn opposite(a: DVec3, b: DVec3) -> bool {
    (a + b).length_squared() < OPPOSITE
}

/// A model of scattering: the built-in ones without indirection, research models through [`BsdfModel`].
#[derive(Clone, Debug)]
pub enum Bsdf {
    /// Lambert's.
    Diffuse(Diffuse),
    /// Smooth metal or mirror.
    Conductor(Conductor),
    /// Metal with microfacets.
    RoughConductor(RoughConductor),
    /// Smooth glass.
    Dielectric(Dielectric),
    /// A thin pane of smooth glass.
    ThinDielectric(ThinDielectric),
    /// Glass with microfacets.
    RoughDielectric(RoughDielectric),
    /// A diffuse base below a smooth coat.
    Plastic(Plastic),
    /// A diffuse base below a rough coat.
    RoughPlastic(RoughPlastic),
    /// Disney's.
    Principled(Box<Principled>),
    /// glTF's own.
    Gltf(Box<Gltf>),
    /// A research model from outside.
    Custom(Arc<dyn BsdfModel>),
}

macro_rules! dispatch {
    ($bsdf:expr, $model:ident => $answer:expr) => {
        match $bsdf {
            Bsdf::Diffuse($model) => $answer,
            Bsdf::Conductor($model) => $answer,
            Bsdf::RoughConductor($model) => $answer,
            Bsdf::Dielectric($model) => $answer,
            Bsdf::ThinDielectric($model) => $answer,
            Bsdf::RoughDielectric($model) => $answer,
            Bsdf::Plastic($model) => $answer,
            Bsdf::RoughPlastic($model) => $answer,
            Bsdf::Principled($model) => $answer,
            Bsdf::Gltf($model) => $answer,
            Bsdf::Custom($model) => $answer,
        }
    };
}

impl Bsdf {
    /// As a research model would be given.
    #[must_use]
    pub fn as_model(&self) -> &dyn BsdfModel {
        match self {
            Self::Custom(model) => model.as_ref(),
            Self::Diffuse(model) => model,
            Self::Conductor(model) => model,
            Self::RoughConductor(model) => model,
            Self::Dielectric(model) => model,
            Self::ThinDielectric(model) => model,
            Self::RoughDielectric(model) => model,
            Self::Plastic(model) => model,
            Self::RoughPlastic(model) => model,
            Self::Principled(model) => model.as_ref(),
            Self::Gltf(model) => model.as_ref(),
        }
    }

    /// See [`BsdfModel::eval`].
    #[must_use]
    #[inline(always)]
    pub fn eval(&self, to_emitter: DVec3, to_sensor: DVec3) -> Rgb {
        #[inline(never)]
        fn of_others(bsdf: &Bsdf, to_emitter: DVec3, to_sensor: DVec3) -> Rgb {
            dispatch!(bsdf, model => model.eval(to_emitter, to_sensor))
        }
        match self {
            Self::Diffuse(model) => model.eval(to_emitter, to_sensor),
            others => of_others(others, to_emitter, to_sensor),
        }
    }

    /// See [`BsdfModel::density`].
    #[must_use]
    #[inline(always)]
    pub fn density(&self, from: DVec3, to: DVec3) -> Density<SolidAngle> {
        #[inline(never)]
        fn of_others(bsdf: &Bsdf, from: DVec3, to: DVec3) -> Density<SolidAngle> {
            dispatch!(bsdf, model => model.density(from, to))
        }
        match self {
            Self::Diffuse(model) => model.density(from, to),
            others => of_others(others, from, to),
        }
    }

    /// See [`BsdfModel::eval_dirac`].
    #[must_use]
    #[inline]
    pub fn eval_dirac(&self, to_emitter: DVec3, to_sensor: DVec3) -> Rgb {
        dispatch!(self, model => model.eval_dirac(to_emitter, to_sensor))
    }

    /// See [`BsdfModel::density_dirac`].
    #[must_use]
    #[inline]
    pub fn density_dirac(&self, side: Side, from: DVec3, to: DVec3) -> Density<ProjectedSolidAngle> {
        dispatch!(self, model => model.density_dirac(side, from, to))
    }

    /// See [`BsdfModel::sample`].
    #[must_use]
    #[inline(always)]
    pub fn sample(&self, side: Side, from: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        #[inline(never)]
        fn of_others(bsdf: &Bsdf, side: Side, from: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
            dispatch!(bsdf, model => model.sample(side, from, u))
        }
        match self {
            Self::Diffuse(model) => model.sample(side, from, u),
            others => of_others(others, side, from, u),
        }
    }

    /// See [`BsdfModel::radiance_scale`].
    #[must_use]
    #[inline]
    pub fn radiance_scale(&self, to_emitter: DVec3, to_sensor: DVec3) -> f64 {
        dispatch!(self, model => model.radiance_scale(to_emitter, to_sensor))
    }

    /// See [`BsdfModel::has_finite`].
    #[must_use]
    #[inline]
    pub fn has_finite(&self) -> bool {
        dispatch!(self, model => model.has_finite())
    }

    /// See [`BsdfModel::has_dirac`].
    #[must_use]
    pub fn has_dirac(&self) -> bool {
        dispatch!(self, model => model.has_dirac())
    }

    /// See [`BsdfModel::is_anisotropic`].
    #[must_use]
    pub fn is_anisotropic(&self) -> bool {
        dispatch!(self, model => model.is_anisotropic())
    }

    /// See [`BsdfModel::is_glossy`].
    #[must_use]
    pub fn is_glossy(&self) -> bool {
        dispatch!(self, model => model.is_glossy())
    }

    /// See [`BsdfModel::transmits`].
    #[must_use]
    #[inline]
    pub fn transmits(&self) -> bool {
        dispatch!(self, model => model.transmits())
    }

    /// See [`BsdfModel::bends`].
    #[must_use]
    pub fn bends(&self) -> bool {
        dispatch!(self, model => model.bends())
    }
}
