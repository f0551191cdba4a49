//! glTF's own material: metallic-roughness with the layers of its extensions.

mod facets;
mod point;
mod sheen;

use std::f64::consts::{FRAC_1_PI, TAU};

use glam::DVec3;

use self::facets::Facets;
use self::point::{mirrored, schlick};
use self::sheen::Sheen;
use super::fresnel::Interface;
use super::perturbed::TurnedFrame;
use super::{BsdfModel, BsdfSample, LobeDensity, Side};
use crate::measure::{Density, SolidAngle};
use crate::spectrum::Rgb;
use crate::warp;

pub(super) use self::point::check;

/// The material of glTF 2.0, appendix B, and of KHR_materials_ior, specular, transmission, volume, clearcoat, sheen and
/// anisotropy, at one point. V leads to the sensor, L to the emitter, H halfway, `s = (1 − V·H)⁵`:
///
/// - `dielectric = (1 − w max F_d) ((1 − t) base/π + t base · btdf) + w F_d · ggx`, with `F_d = F₀ + (1 − F₀) s`;
/// - `metal = (base + (1 − base) s) ggx`, `ggx = D(H) G₁(L) G₁(V) / (4 |cos θ_L cos θ_V|)`;
/// - `material = (1 − metallic) dielectric + metallic metal`, below sheen: times `1 − max(colour) max(E(L), E(V))`;
/// - coated: `(1 − c F_c) material + c F_c ggx_c`, with `F_c = 0.04 + 0.96 (1 − |N_c·V|)⁵`.
///
/// What transmits is thin, its two sides alike: btdf is ggx of L mirrored at the surface. Or it is solid: btdf is Walter's
/// (2007) with `(η_o/η_i)²`, s is that of the angle outside, one for total reflection, and only the outside has a diffuse
/// base, sheen and a coat. Light from behind is absorbed by what is opaque.
///
/// It is reciprocal (up to `η²`) but for the coat, whose `F_c` is the sensor's alone, and for turned normals. Its albedo may
/// exceed one, as the specification has it: because s is that of the half vector, white matter reflects up to 1.93 of light
/// from a grazing angle where its layer is smooth, and 1.32 at roughness 0.3 (1.042 in the mean over the hemisphere where it
/// is smooth); fine white fibres reflect up to 1.41. Metal and what transmits all lose energy by single scattering.
///
/// α is at least 1e-4. Drawn from cosine, GGX's visible normals, and a uniform hemisphere for the fibres, by estimates of
/// their shares from the side of the walk.
#[derive(Clone, Debug)]
pub struct Gltf {
    base: Rgb,
    metallic: f64,
    facets: Facets,
    /// Reflectance of the dielectric along the normal.
    f0: Rgb,
    /// Strength of the dielectric's reflection, w above.
    specular: f64,
    transmission: f64,
    body: Body,
    sheen: Option<Sheen>,
    coat: Option<Coat>,
    /// Of all but the coat, where a map turns it.
    frame: Option<TurnedFrame>,
}

/// What is below the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Body {
    Opaque,
    Thin,
    Solid {
        interface: Interface,
        /// What a crossing of the surface leaves.
        tint: Rgb,
    },
}

#[derive(Clone, Copy, Debug)]
struct Coat {
    share: f64,
    facets: Facets,
    frame: Option<TurnedFrame>,
}

/// In the frame, where there is one; `None` where its normal and the surface's disagree about the side.
#[inline]
fn enter(frame: Option<TurnedFrame>, v: DVec3) -> Option<DVec3> {
    match frame {
        None => (v.z != 0.0).then_some(v),
        Some(frame) => frame.same_side(v),
    }
}

/// Out of the frame; `None` where its normal and the surface's disagree about the side, so that no lobe speaks for another's
/// directions.
#[inline]
fn leave(frame: Option<TurnedFrame>, v: DVec3) -> Option<DVec3> {
    let Some(frame) = frame else { return Some(v) };
    let outer = frame.to_outer(v);
    frame.same_side(outer).filter(|again| again.z * v.z > 0.0).map(|_| outer)
}

impl Coat {
    /// `c F_c` for the direction to the sensor.
    fn share(&self, v: DVec3) -> f64 {
        let cos = self.frame.map_or(v, |frame| frame.to_nested(v)).z;
        self.share * (0.04 + 0.96 * schlick(cos.abs()))
    }

    /// Both directions in the coat's frame, in front of it.
    fn enter(&self, a: DVec3, b: DVec3, thin: bool) -> Option<[DVec3; 2]> {
        let (a, b) = (enter(self.frame, a)?, enter(self.frame, b)?);
        let [a, b] = if thin && a.z < 0.0 { [mirrored(a), mirrored(b)] } else { [a, b] };
        (a.z > 0.0 && b.z > 0.0).then_some([a, b])
    }
}

/// A pair of directions joined by a microfacet.
struct Joined {
    /// `D/4` or, across a solid's surface, `D |a·h| |b·h| / ‖η_a a + η_b b‖²`.
    core: f64,
    /// `(1 − cos)⁵` of the angle at the microfacet, outside.
    s: f64,
}

/// The shares of a walk's lobes.
#[derive(Clone, Copy, Debug, Default)]
struct Shares {
    diffuse: f64,
    facets: f64,
    sheen: f64,
    coat: f64,
}

impl Gltf {
    fn is_thin(&self) -> bool {
        self.body == Body::Thin
    }

    /// In the frame of the layers below the coat. Both sides of what is thin are alike.
    fn enter(&self, a: DVec3, b: DVec3) -> Option<[DVec3; 2]> {
        let (a, b) = (enter(self.frame, a)?, enter(self.frame, b)?);
        Some(if self.is_thin() && a.z < 0.0 { [mirrored(a), mirrored(b)] } else { [a, b] })
    }

    /// `(1 − cos)⁵` outside for an angle at a microfacet that is seen from outside or inside.
    fn rise(&self, cos: f64, outside: bool) -> f64 {
        let cos = cos.abs().min(1.0);
        match &self.body {
            Body::Solid { interface, .. } if !outside => interface.cos_refracted(-cos).map_or(1.0, schlick),
            _ => schlick(cos),
        }
    }

    /// `w F_d`.
    fn layer(&self, s: f64) -> Rgb {
        self.f0.map(|f0| self.specular * (f0 + (1.0 - f0) * s))
    }

    /// What the microfacets of dielectric and metal reflect.
    fn reflected(&self, s: f64) -> Rgb {
        let metal = self.base.map(|base| base + (1.0 - base) * s);
        self.layer(s) * (1.0 - self.metallic) + metal * self.metallic
    }

    /// What the base below the microfacets receives.
    fn received(&self, s: f64) -> f64 {
        (1.0 - self.metallic) * (1.0 - self.layer(s).max_component())
    }

    /// What passes through the microfacets.
    fn transmitted(&self, s: f64) -> Rgb {
        let through = self.base * (self.received(s) * self.transmission);
        match &self.body {
            Body::Opaque => Rgb::BLACK,
            Body::Thin => through,
            Body::Solid { tint, .. } => through * *tint,
        }
    }

    /// The probability that a walk is reflected by a microfacet rather than refracted.
    fn reflects(&self, s: f64) -> f64 {
        let (reflected, transmitted) = (self.reflected(s).mean(), self.transmitted(s).mean());
        if transmitted > 0.0 { reflected / (reflected + transmitted) } else { 1.0 }
    }

    /// `None` where no microfacet joins them.
    fn join(&self, a: DVec3, b: DVec3) -> Option<Joined> {
        let half = |sum: DVec3| {
            let length = sum.length();
            (length > 1e-30).then(|| (sum / length.copysign(sum.z), length))
        };
        if a.z * b.z > 0.0 {
            // |a + b| = 2 a·h for unit vectors.
            let (h, length) = half(a + b)?;
            let s = self.rise(0.5 * length, a.z > 0.0);
            return Some(Joined { core: 0.25 * self.facets.distribution(h), s });
        }
        match &self.body {
            Body::Opaque => None,
            Body::Thin => {
                let (h, length) = half(a + mirrored(b))?;
                Some(Joined { core: 0.25 * self.facets.distribution(h), s: self.rise(0.5 * length, true) })
            }
            Body::Solid { interface, .. } => {
                let (inside, outside) = if a.z < 0.0 { (a, b) } else { (b, a) };
                // η_a a + η_b b as a difference of directions, so that little cancels where the indices are alike.
                let (h, length) = half((a + b) + inside * interface.contrast())?;
                let (ah, bh) = (a.dot(h), b.dot(h));
                if ah * a.z <= 0.0 || bh * b.z <= 0.0 {
                    return None;
                }
                let core = self.facets.distribution(h) * ((ah * bh).abs() / (length * length));
                Some(Joined { core, s: self.rise(outside.dot(h), true) })
            }
        }
    }

    /// `η²` on the side of `v` where the pair crosses a solid's surface.
    fn index_squared(&self, v: DVec3, other: DVec3) -> f64 {
        match &self.body {
            Body::Solid { interface, .. } if v.z * other.z < 0.0 => {
                let index = interface.index(v.z);
                index * index
            }
            _ => 1.0,
        }
    }

    /// What is below the coat, both directions in its frame.
    fn eval_below(&self, i: DVec3, o: DVec3) -> Rgb {
        let (in_front, same_side) = (i.z > 0.0 && o.z > 0.0, i.z * o.z > 0.0);
        let mut value = Rgb::BLACK;
        if (in_front || self.body != Body::Opaque)
            && let Some(Joined { core, s }) = self.join(i, o)
        {
            let colour = if same_side { self.reflected(s) } else { self.transmitted(s) };
            let g = self.facets.shadowing_over_cos(i) * self.facets.shadowing_over_cos(o);
            value = colour * (core * self.index_squared(o, i) * g);
            if in_front {
                value += self.base * (self.received(s) * (1.0 - self.transmission) * FRAC_1_PI);
            }
        }
        if let Some(sheen) = &self.sheen {
            value *= sheen.scale(i, o);
            if in_front {
                value += sheen.eval(i, o);
            }
        }
        value
    }

    /// The shares of a walk that comes from there; they add up to one, or are all zero where nothing is scattered.
    fn shares(&self, from: DVec3) -> Shares {
        /// Steeper directions count as this, where the reflectance of a black layer vanishes.
        const STEEPEST: f64 = 0.8;
        /// Fibres seen from above reflect little, but sideways.
        const LEAST_SHEEN: f64 = 0.05;
        let mut shares = Shares::default();
        let mut below = 1.0;
        if let Some(coat) = &self.coat {
            let share = coat.share(from);
            below -= share;
            let seen = enter(coat.frame, from).is_some_and(|v| v.z > 0.0 || self.is_thin());
            shares.coat = if seen { share } else { 0.0 };
        }
        if let Some(v) = enter(self.frame, from).filter(|v| v.z > 0.0 || self.body != Body::Opaque) {
            let in_front = v.z > 0.0 || self.is_thin();
            if let Some(sheen) = &self.sheen {
                let albedo = sheen.albedo(v.z);
                shares.sheen = if in_front { below * sheen.colour.mean() * albedo.max(LEAST_SHEEN) } else { 0.0 };
                below *= 1.0 - sheen.colour.max_component() * albedo;
            }
            let s = self.rise(v.z.abs().min(STEEPEST), in_front);
            shares.facets = below * (self.reflected(s).mean() + self.transmitted(s).mean());
            if in_front {
                shares.diffuse = below * self.base.mean() * self.received(s) * (1.0 - self.transmission);
            }
        }
        let sum = shares.diffuse + shares.facets + shares.sheen + shares.coat;
        if sum > 0.0 {
            let of = |share: f64| share / sum;
            let Shares { diffuse, facets, sheen, coat } = shares;
            return Shares { diffuse: of(diffuse), facets: of(facets), sheen: of(sheen), coat: of(coat) };
        }
        Shares::default()
    }

    /// The density of what is drawn below the coat, times its shares; both directions in its frame.
    fn density_below(&self, shares: Shares, from: DVec3, to: DVec3) -> f64 {
        let (in_front, same_side) = (from.z > 0.0 && to.z > 0.0, from.z * to.z > 0.0);
        let mut density = 0.0;
        if in_front {
            density += shares.diffuse * warp::cosine_hemisphere_density(to.z).value() + shares.sheen / TAU;
        }
        if (in_front || self.body != Body::Opaque)
            && let Some(Joined { core, s }) = self.join(from, to)
        {
            let reflects = self.reflects(s);
            let chosen = if same_side { reflects } else { 1.0 - reflects };
            let scale = self.index_squared(to, from) * self.facets.shadowing_over_cos(from);
            density += shares.facets * chosen * core * scale;
        }
        density
    }

    /// By a microfacet as seen from there, in the frame below the coat; `u[2]` chooses between its two sides.
    fn sample_facets(&self, from: DVec3, u: [f64; 3]) -> Option<DVec3> {
        let upright = if from.z > 0.0 { from } else { -from };
        let m = self.facets.sample_visible(upright, [u[0], u[1]]);
        let cos = from.dot(m);
        if u[2] < self.reflects(self.rise(cos, from.z > 0.0)) {
            let to = m * (2.0 * cos) - from;
            return (to.z * from.z > 0.0).then_some(to);
        }
        match &self.body {
            Body::Opaque => None,
            Body::Thin => {
                let to = m * (2.0 * cos) - from;
                (to.z * from.z > 0.0).then_some(mirrored(to))
            }
            Body::Solid { interface, .. } => interface.refract(from, m, cos).filter(|to| to.z * from.z < 0.0),
        }
    }

    /// A direction by one of the lobes.
    fn draw(&self, from: DVec3, u: [f64; 3]) -> Option<DVec3> {
        let shares = self.shares(from);
        let mut rest = u[2];
        if let Some(coat) = self.coat.as_ref().filter(|_| shares.coat > 0.0) {
            if rest < shares.coat {
                let v = enter(coat.frame, from)?;
                let upright = if v.z > 0.0 { v } else { mirrored(v) };
                let m = coat.facets.sample_visible(upright, [u[0], u[1]]);
                let to = m * (2.0 * upright.dot(m)) - upright;
                return leave(coat.frame, if v.z > 0.0 { to } else { mirrored(to) }).filter(|_| to.z > 0.0);
            }
            rest -= shares.coat;
        }
        let v = enter(self.frame, from)?;
        let flipped = self.is_thin() && v.z < 0.0;
        let upright = if flipped { mirrored(v) } else { v };
        let to = if rest < shares.diffuse {
            warp::cosine_hemisphere([u[0], u[1]])
        } else if rest < shares.diffuse + shares.sheen {
            let to = warp::uniform_sphere([u[0], u[1]]);
            DVec3::new(to.x, to.y, to.z.abs())
        } else {
            let rest = ((rest - shares.diffuse - shares.sheen) / shares.facets).min(1.0_f64.next_down());
            self.sample_facets(upright, [u[0], u[1], rest])?
        };
        leave(self.frame, if flipped { mirrored(to) } else { to })
    }
}

impl BsdfModel for Gltf {
    fn eval(&self, to_emitter: DVec3, to_sensor: DVec3) -> Rgb {
        let mut value = match self.enter(to_emitter, to_sensor) {
            // Neither side of a thin one is the first: mirroring both is no change.
            Some([i, o]) if self.frame.is_some() => self.eval_below(i, o) * TurnedFrame::ratio(to_emitter, i),
            Some([i, o]) => self.eval_below(i, o),
            None => Rgb::BLACK,
        };
        if let Some(coat) = &self.coat {
            let share = coat.share(to_sensor);
            value *= 1.0 - share;
            if let Some([i, o]) = coat.enter(to_emitter, to_sensor, self.is_thin()) {
                let sum = i + o;
                let g = coat.facets.shadowing_over_cos(i) * coat.facets.shadowing_over_cos(o);
                let f = 0.25 * coat.facets.distribution(sum / sum.length()) * g;
                let ratio = if coat.frame.is_some() { TurnedFrame::ratio(to_emitter, i) } else { 1.0 };
                value += Rgb::grey(share * f * ratio);
            }
        }
        value
    }

    fn density(&self, from: DVec3, to: DVec3) -> Density<SolidAngle> {
        let shares = self.shares(from);
        let mut density = self.enter(from, to).map_or(0.0, |[from, to]| self.density_below(shares, from, to));
        if let Some(coat) = self.coat.as_ref().filter(|_| shares.coat > 0.0)
            && let Some([from, to]) = coat.enter(from, to, self.is_thin())
        {
            let sum = from + to;
            let d = 0.25 * coat.facets.distribution(sum / sum.length());
            density += shares.coat * d * coat.facets.shadowing_over_cos(from);
        }
        Density::new(density)
    }

    fn sample(&self, side: Side, from: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        let to = self.draw(from, u)?;
        let density = self.density(from, to);
        let (to_emitter, to_sensor) = side.by_role(from, to);
        let value = self.eval(to_emitter, to_sensor);
        (density.value() > 0.0).then_some(BsdfSample { to, density: LobeDensity::Finite(density), value })
    }

    fn radiance_scale(&self, to_emitter: DVec3, to_sensor: DVec3) -> f64 {
        match &self.body {
            Body::Solid { interface, .. } => interface.radiance_scale(to_emitter.z, to_sensor.z),
            _ => 1.0,
        }
    }

    fn is_glossy(&self) -> bool {
        self.metallic > 0.0 || self.specular > 0.0 || self.transmission > 0.0 || self.coat.is_some()
    }

    fn transmits(&self) -> bool {
        self.body != Body::Opaque
    }
}
