//! Distributions of microfacet normals.
//!
//! Heights above a plane with the frame's u along x and v along y; α along each. Distributions stretched along both axes have
//! the shadowing of the isotropic ones in stretched directions (Heitz 2014).

mod beckmann;
mod ggx;

use glam::DVec3;

use crate::measure::{Density, SolidAngle};
use crate::quadrature::Rule;
use crate::scene::description::MicrofacetKind;

pub use beckmann::Beckmann;
pub use ggx::Ggx;

/// A distribution of microfacet normals with Smith's shadowing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Microfacets {
    /// Trowbridge and Reitz's.
    Ggx(Ggx),
    /// Beckmann and Spizzichino's.
    Beckmann(Beckmann),
}

/// What a family of distributions answers, documented at [`Microfacets`].
pub(super) trait Distribution {
    fn distribution(&self, m: DVec3) -> f64;
    fn shadowing_over_cos(&self, v: DVec3) -> f64;
    fn visibility_over_cos(&self, v: DVec3) -> f64;
    fn sample_visible(&self, v: DVec3, u: [f64; 2]) -> DVec3;
}

impl Distribution for Ggx {
    #[inline(always)]
    fn distribution(&self, m: DVec3) -> f64 {
        self.distribution(m)
    }

    #[inline(always)]
    fn shadowing_over_cos(&self, v: DVec3) -> f64 {
        self.shadowing_over_cos(v)
    }

    #[inline(always)]
    fn visibility_over_cos(&self, v: DVec3) -> f64 {
        self.shadowing_over_cos(v)
    }

    #[inline(always)]
    fn sample_visible(&self, v: DVec3, u: [f64; 2]) -> DVec3 {
        self.sample_visible(v, u)
    }
}

impl Distribution for Beckmann {
    fn distribution(&self, m: DVec3) -> f64 {
        self.distribution(m)
    }

    fn shadowing_over_cos(&self, v: DVec3) -> f64 {
        self.shadowing_over_cos(v)
    }

    fn visibility_over_cos(&self, v: DVec3) -> f64 {
        self.visibility_over_cos(v)
    }

    fn sample_visible(&self, v: DVec3, u: [f64; 2]) -> DVec3 {
        self.sample_visible(v, u)
    }
}

/// An answer by either family. Models ask once and not for each part of a formula, which takes half of the time.
macro_rules! of_either {
    ($either:expr, $model:ident => $answer:expr) => {
        match $either {
            Microfacets::Ggx($model) => $answer,
            Microfacets::Beckmann($model) => $answer,
        }
    };
}

pub(super) use of_either;

impl Microfacets {
    /// With roughness α along u and along v, both above 0.
    #[must_use]
    pub fn new(kind: MicrofacetKind, alpha: [f64; 2]) -> Self {
        match kind {
            MicrofacetKind::Ggx => Self::Ggx(Ggx::new(alpha)),
            MicrofacetKind::Beckmann => Self::Beckmann(Beckmann::new(alpha)),
        }
    }

    /// The roughness along v is not that along u.
    #[must_use]
    pub fn is_anisotropic(&self) -> bool {
        let [u, v] = of_either!(self, model => model.alpha());
        u != v
    }

    /// `D(m)`, the density of microfacets by area times 1/cos θ \[1/sr\]. Zero below the horizon.
    #[must_use]
    #[inline]
    pub fn distribution(&self, m: DVec3) -> f64 {
        of_either!(self, model => model.distribution(m))
    }

    /// `G₁(v) / |cos θ_v|` as f_s has it: finite at grazing angles, where its parts are not.
    #[must_use]
    #[inline]
    pub fn shadowing_over_cos(&self, v: DVec3) -> f64 {
        of_either!(self, model => model.shadowing_over_cos(v))
    }

    /// `G₁(v) / |cos θ_v|` that makes the density of visible normals integrate to one: the same for GGX, within 0.4 % for
    /// Beckmann, whose f_s has a rational approximation.
    #[must_use]
    #[inline]
    pub fn visibility_over_cos(&self, v: DVec3) -> f64 {
        match self {
            Self::Ggx(model) => model.shadowing_over_cos(v),
            Self::Beckmann(model) => model.visibility_over_cos(v),
        }
    }

    /// `D_v(m) = G₁(v) max(0, v·m) D(m) / |cos θ_v|`, the density of [`sample_visible`](Self::sample_visible) \[1/sr\].
    #[must_use]
    #[inline]
    pub fn visible_density(&self, v: DVec3, m: DVec3) -> Density<SolidAngle> {
        Density::new(self.visibility_over_cos(v) * v.dot(m).max(0.0) * self.distribution(m))
    }

    /// A microfacet normal as seen from `v` with `v.z > 0`.
    #[must_use]
    #[inline]
    pub fn sample_visible(&self, v: DVec3, u: [f64; 2]) -> DVec3 {
        of_either!(self, model => model.sample_visible(v, u))
    }

    /// Visible normals as seen from a direction in the plane of u and the normal, and weights that add up to one: a rule for
    /// integrals over `D_v` of what is symmetric about that plane.
    pub(super) fn visible_rule(&self, v: DVec3, rule: &Rule) -> Vec<(DVec3, f64)> {
        of_either!(self, model => model.visible_rule(v, rule))
    }
}
