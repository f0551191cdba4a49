//! Disney's principled model.

use std::f64::consts::{FRAC_1_PI, PI};

use glam::DVec3;

use super::dielectric::Tints;
use super::fresnel::Interface;
use super::microfacet::{Ggx, Microfacets};
use super::rough_dielectric::RoughDielectric;
use super::{BsdfModel, BsdfSample, LobeDensity, Side};
use crate::measure::{Density, SolidAngle};
use crate::spectrum::Rgb;
use crate::warp;

/// The numbers of the principled model at one point, shares 0 … 1, by the names of
/// [`PrincipledDescription`](crate::scene::description::PrincipledDescription).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shares {
    pub roughness: f64,
    pub anisotropic: f64,
    pub metallic: f64,
    pub spec_trans: f64,
    pub spec_tint: f64,
    pub sheen: f64,
    pub sheen_tint: f64,
    pub flatness: f64,
    pub clearcoat: f64,
    pub clearcoat_gloss: f64,
}

/// A mixture of a diffuse base with sheen, metal, glass and a coat (Burley 2012, 2015), as Mitsuba 3 has it.
///
/// In front: `(1 − metallic)(1 − spec_trans)` of the diffuse base, microfacets (GGX) with a Fresnel factor between that of a
/// dielectric and Schlick's (1994), `(1 − metallic) spec_trans` of refraction, and a coat (GTR1). Behind, which is the inside
/// of what transmits: reflection and refraction by that share. May reflect more than it receives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Principled {
    base_color: Rgb,
    shares: Shares,
    /// GGX at the interface of the glass.
    glass: RoughDielectric,
    /// α of the coat.
    coat_alpha: f64,
}

/// The least α of the microfacets.
const LEAST_ALPHA: f64 = 1e-3;

/// The contrast `η − 1` below which glass of the least α would refract less sharply than double precision can tell.
const LEAST_CONTRAST: f64 = 1e-9;

/// α of the coat's shadowing.
const COAT_SHADOWING: f64 = 0.25;

impl Principled {
    pub(super) fn new(base_color: Rgb, shares: Shares, eta: f64) -> Self {
        // Mitsuba has the same in place of an index of one.
        let without_contrast = shares.spec_trans > 0.0 && (eta - 1.0).abs() < LEAST_CONTRAST;
        let interface = Interface::new(if without_contrast { 1.001 } else { eta }, 1.0);
        let square = shares.roughness * shares.roughness;
        let aspect = (1.0 - 0.9 * shares.anisotropic).sqrt();
        let alphas = [square / aspect, square * aspect].map(|alpha| alpha.max(LEAST_ALPHA));
        let glass =
            RoughDielectric { distribution: Microfacets::Ggx(Ggx::new(alphas)), interface, tints: Tints::WHITE };
        Self { base_color, shares, glass, coat_alpha: 0.1 + (0.001 - 0.1) * shares.clearcoat_gloss }
    }

    /// Share of the diffuse base.
    fn brdf(&self) -> f64 {
        (1.0 - self.shares.metallic) * (1.0 - self.shares.spec_trans)
    }

    /// Share of glass.
    fn bsdf(&self) -> f64 {
        (1.0 - self.shares.metallic) * self.shares.spec_trans
    }

    /// The base colour at luminance one.
    fn tint(&self) -> Rgb {
        let Rgb { r, g, b } = self.base_color;
        // Mitsuba's weights, which have more digits than Rec. 709.
        let luminance = 0.212_671 * r + 0.715_160 * g + 0.072_169 * b;
        if luminance > 0.0 { self.base_color / luminance } else { Rgb::WHITE }
    }

    /// Schlick's `F₀ + (1 − F₀)(1 − cos)⁵`, with the cosine beyond the interface where that is the smaller one.
    fn schlick(&self, f0: Rgb, cos: f64) -> Rgb {
        let eta = self.glass.interface.index(-1.0);
        let cos = if eta > 1.0 { cos } else { self.glass.interface.cos_refracted(cos).unwrap_or(0.0) };
        let weight = fifth(1.0 - cos);
        f0.map(|f0| weight + (1.0 - weight) * f0)
    }

    /// The Fresnel factor of the reflecting microfacets, for the cosine in front of them or, negative, behind.
    fn fresnel(&self, cos: f64) -> Rgb {
        let Shares { metallic, spec_tint, .. } = self.shares;
        let dielectric = self.glass.interface.fresnel(cos).reflected;
        if cos < 0.0 {
            return Rgb::grey(self.bsdf() * dielectric);
        }
        // Without an interface nothing is reflected, by metal neither.
        if dielectric == 0.0 {
            return Rgb::BLACK;
        }
        let mut sum = Rgb::grey((1.0 - metallic) * (1.0 - spec_tint) * dielectric);
        if metallic > 0.0 {
            sum += self.schlick(self.base_color, cos) * metallic;
        }
        if spec_tint > 0.0 {
            let eta = self.glass.interface.index(-1.0);
            let along_normal = self.glass.interface.contrast() / (eta + 1.0);
            let f0 = self.tint() * (along_normal * along_normal);
            sum += self.schlick(f0, cos) * ((1.0 - metallic) * spec_tint);
        }
        sum
    }

    /// The coat's `D(h) = (α² − 1) / (π ln α² (1 + (α² − 1) cos²θ))`, GTR1 (Burley 2012).
    fn coat_distribution(&self, cos: f64) -> f64 {
        let a2 = self.coat_alpha * self.coat_alpha;
        (a2 - 1.0) / (PI * libm::log(a2) * (1.0 + (a2 - 1.0) * cos * cos))
    }

    /// The coat; `0.04` along the normal.
    fn coat(&self, i: DVec3, o: DVec3, h: DVec3, cos: f64) -> f64 {
        let shadowing = |v: DVec3| {
            let a2 = COAT_SHADOWING * COAT_SHADOWING;
            2.0 * v.z / (v.z + (v.z * v.z + a2 * (v.x * v.x + v.y * v.y)).sqrt())
        };
        let fresnel = self.schlick(Rgb::grey(0.04), cos).r;
        0.25 * self.shares.clearcoat * fresnel * self.coat_distribution(h.z) * shadowing(i) * shadowing(o)
    }

    /// Diffuse base, retro-reflection, what imitates scattering below the surface, and sheen.
    fn diffuse(&self, i: DVec3, o: DVec3, cos: f64) -> Rgb {
        let Shares { roughness, flatness, sheen, sheen_tint, metallic, .. } = self.shares;
        let (fi, fo) = (fifth(1.0 - i.z), fifth(1.0 - o.z));
        let retro = 2.0 * roughness * cos * cos;
        let diffuse = (1.0 - 0.5 * fi) * (1.0 - 0.5 * fo) + retro * (fo + fi + fo * fi * (retro - 1.0));
        let f90 = 0.5 * retro;
        let both = (1.0 + (f90 - 1.0) * fo) * (1.0 + (f90 - 1.0) * fi);
        let below = 1.25 * (both * (1.0 / (i.z + o.z) - 0.5) + 0.5);
        let base = self.base_color * (self.brdf() * FRAC_1_PI * (diffuse + flatness * (below - diffuse)));
        if sheen == 0.0 {
            return base;
        }
        let colour = Rgb::grey(1.0 - sheen_tint) + self.tint() * sheen_tint;
        base + colour * (sheen * (1.0 - metallic) * fifth(1.0 - cos))
    }

    /// The probabilities of diffuse base, coat and glass in front; the rest is reflection by microfacets. Glass stands for
    /// what its microfacets reflect too.
    fn choice(&self) -> [f64; 3] {
        let (diffuse, coat) = (self.brdf(), 0.25 * self.shares.clearcoat);
        let sum = 1.0 + coat + diffuse;
        [diffuse / sum, coat / sum, self.bsdf() / sum]
    }

    /// It has nothing to say of light from there.
    fn is_black(&self, from: DVec3) -> bool {
        from.z == 0.0 || (from.z < 0.0 && self.bsdf() == 0.0)
    }
}

/// `x⁵` of what is between 0 and 1.
fn fifth(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    let x2 = x * x;
    x2 * x2 * x
}

impl BsdfModel for Principled {
    fn eval(&self, to_emitter: DVec3, to_sensor: DVec3) -> Rgb {
        let (i, o) = (to_emitter, to_sensor);
        if i.z * o.z < 0.0 {
            let colour = self.base_color.map(f64::sqrt) * self.bsdf();
            return if self.bsdf() > 0.0 { colour * self.glass.eval(i, o) } else { Rgb::BLACK };
        }
        if i.z * o.z == 0.0 || self.is_black(o) {
            return Rgb::BLACK;
        }
        let Some((h, cos)) = half_vector(i, o) else { return Rgb::BLACK };
        let distribution = &self.glass.distribution;
        let g = distribution.shadowing_over_cos(i) * distribution.shadowing_over_cos(o);
        let reflected = self.fresnel(cos) * (0.25 * distribution.distribution(h) * g);
        if o.z < 0.0 {
            return reflected;
        }
        let coat = if self.shares.clearcoat > 0.0 { self.coat(i, o, h, cos) } else { 0.0 };
        reflected + Rgb::grey(coat) + self.diffuse(i, o, cos)
    }

    /// The sum of cosine-weighted directions, reflections by the coat's microfacets with density `D(h) cos θ_h / (4 i·h)`, and
    /// those of rough glass, each by its probability \[1/sr\].
    fn density(&self, from: DVec3, to: DVec3) -> Density<SolidAngle> {
        if from.z * to.z == 0.0 || self.is_black(from) {
            return Density::ZERO;
        }
        let [diffuse, coat, glass] = if from.z > 0.0 { self.choice() } else { [0.0, 0.0, 1.0] };
        if from.z * to.z < 0.0 {
            return if glass > 0.0 { self.glass.density(from, to) * glass } else { Density::ZERO };
        }
        let Some((h, cos)) = half_vector(from, to) else { return Density::ZERO };
        let distribution = &self.glass.distribution;
        // Of the microfacets' share, F of the glass and all of the rest reflect.
        let f = self.glass.interface.fresnel(cos).reflected;
        let reflecting = if from.z > 0.0 { (1.0 - diffuse - coat - glass).max(0.0) + glass * f } else { f };
        let mut sum = reflecting * 0.25 * distribution.distribution(h) * distribution.shadowing_over_cos(from);
        if from.z > 0.0 {
            sum += diffuse * warp::cosine_hemisphere_density(to.z).value();
            if coat > 0.0 {
                sum += coat * self.coat_distribution(h.z) * h.z / (4.0 * cos);
            }
        }
        Density::new(sum)
    }

    fn sample(&self, side: Side, from: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        if self.is_black(from) {
            return None;
        }
        let [diffuse, coat, glass] = if from.z > 0.0 { self.choice() } else { [0.0, 0.0, 1.0] };
        let to = if u[2] < diffuse {
            warp::cosine_hemisphere([u[0], u[1]])
        } else if u[2] < diffuse + coat {
            // tan²θ of GTR1 by inversion (Burley 2012).
            let a2 = self.coat_alpha * self.coat_alpha;
            let cos2 = ((1.0 - libm::pow(a2, 1.0 - u[1])) / (1.0 - a2)).clamp(0.0, 1.0);
            let (s, c) = warp::sin_cos_turn(u[0]);
            let sine = (1.0 - cos2).sqrt();
            let m = DVec3::new(sine * c, sine * s, cos2.sqrt());
            m * (2.0 * from.dot(m)) - from
        } else {
            let upright = if from.z > 0.0 { from } else { -from };
            let m = self.glass.distribution.sample_visible(upright, [u[0], u[1]]);
            let cos = from.dot(m);
            let passes = u[2] - diffuse - coat < glass * self.glass.interface.fresnel(cos).transmitted;
            let to = if passes { self.glass.interface.refract(from, m, cos)? } else { m * (2.0 * cos) - from };
            // Single scattering: what leaves the microfacet towards the wrong side of the surface is lost.
            if (to.z * from.z < 0.0) != passes {
                return None;
            }
            to
        };
        if from.z > 0.0 && to.z < 0.0 && u[2] < diffuse + coat {
            return None;
        }
        let density = self.density(from, to);
        let (to_emitter, to_sensor) = side.by_role(from, to);
        let value = self.eval(to_emitter, to_sensor);
        (density.value() > 0.0).then_some(BsdfSample { to, density: LobeDensity::Finite(density), value })
    }

    fn radiance_scale(&self, to_emitter: DVec3, to_sensor: DVec3) -> f64 {
        if self.transmits() { self.glass.radiance_scale(to_emitter, to_sensor) } else { 1.0 }
    }

    fn is_anisotropic(&self) -> bool {
        self.glass.is_anisotropic()
    }

    fn transmits(&self) -> bool {
        self.shares.spec_trans > 0.0
    }
}

/// `(h, i·h)`, h in front and the cosine negative behind; `None` for directions that are all but opposite.
fn half_vector(a: DVec3, b: DVec3) -> Option<(DVec3, f64)> {
    let sum = a + b;
    let length = sum.length();
    // |a + b| = 2 a·h for unit vectors.
    (length > 1e-30).then(|| (sum / length.copysign(sum.z), (0.5 * length).copysign(a.z)))
}
