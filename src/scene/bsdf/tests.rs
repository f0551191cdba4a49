//! Properties that all models share.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod chi2;
mod composites;
mod consistency;
mod energy;
mod gltf;
mod robustness;

use std::sync::LazyLock;

use glam::DVec3;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

use super::{Bsdf, BsdfSample, LobeDensity, Side};
use crate::scene::description::{BsdfDescription, ConductorFresnel, MicrofacetKind, PrincipledDescription};
use crate::scene::texture::Parameter;
use crate::spectrum::Rgb;

const SIDES: [Side; 2] = [Side::Sensor, Side::Emitter];

fn random_numbers(seed: u64) -> Xoshiro256PlusPlus {
    Xoshiro256PlusPlus::seed_from_u64(seed)
}

fn diffuse() -> Bsdf {
    Bsdf::new(&BsdfDescription::Diffuse { reflectance: Rgb::new(0.2, 0.5, 1.0).into() }).unwrap()
}

/// Gold, about.
fn gold() -> ConductorFresnel {
    ConductorFresnel::Ior { eta: Rgb::new(0.14, 0.37, 1.44), k: Rgb::new(4.0, 2.4, 1.6) }
}

fn white() -> ConductorFresnel {
    ConductorFresnel::Tint { specular_tint: Rgb::WHITE }
}

fn mirror(fresnel: ConductorFresnel) -> Bsdf {
    Bsdf::new(&BsdfDescription::conductor(fresnel)).unwrap()
}

fn metal(alpha: f64, fresnel: ConductorFresnel) -> Bsdf {
    Bsdf::new(&BsdfDescription::rough_conductor(alpha, fresnel)).unwrap()
}

fn glass(interior_ior: f64) -> Bsdf {
    Bsdf::new(&BsdfDescription::dielectric(interior_ior, 1.0)).unwrap()
}

fn rough_glass(alpha: f64, interior_ior: f64) -> Bsdf {
    Bsdf::new(&BsdfDescription::rough_dielectric(alpha, interior_ior, 1.0)).unwrap()
}

/// Metal of other microfacets than isotropic GGX, which reflects a part of what it would.
fn tinted_metal(distribution: MicrofacetKind, [alpha, alpha_v]: [f64; 2]) -> Bsdf {
    Bsdf::new(&BsdfDescription::RoughConductor {
        distribution,
        alpha: alpha.into(),
        alpha_v: Some(alpha_v.into()),
        fresnel: gold(),
        reflectance: Rgb::new(0.9, 0.5, 0.0).into(),
    })
    .unwrap()
}

fn reflects() -> Parameter<Rgb> {
    Rgb::new(0.8, 0.5, 1.0).into()
}

fn passes() -> Parameter<Rgb> {
    Rgb::new(0.6, 1.0, 0.2).into()
}

/// The same of glass.
fn tinted_glass(distribution: MicrofacetKind, [alpha, alpha_v]: [f64; 2], interior_ior: f64) -> Bsdf {
    Bsdf::new(&BsdfDescription::RoughDielectric {
        distribution,
        alpha: alpha.into(),
        alpha_v: Some(alpha_v.into()),
        interior_ior,
        exterior_ior: 1.0,
        reflectance: reflects(),
        transmittance: passes(),
    })
    .unwrap()
}

fn tinted_smooth_glass(interior_ior: f64) -> Bsdf {
    let (reflectance, transmittance) = (reflects(), passes());
    Bsdf::new(&BsdfDescription::Dielectric { interior_ior, exterior_ior: 1.0, reflectance, transmittance }).unwrap()
}

fn pane(interior_ior: f64) -> Bsdf {
    let (reflectance, transmittance) = (reflects(), passes());
    Bsdf::new(&BsdfDescription::ThinDielectric { interior_ior, exterior_ior: 1.0, reflectance, transmittance }).unwrap()
}

fn plastic(interior_ior: f64, nonlinear: bool) -> Bsdf {
    let (diffuse, specular) = (passes(), reflects());
    Bsdf::new(&BsdfDescription::Plastic { interior_ior, exterior_ior: 1.0, diffuse, specular, nonlinear }).unwrap()
}

fn rough_plastic(distribution: MicrofacetKind, alpha: f64, interior_ior: f64, nonlinear: bool) -> Bsdf {
    let (diffuse, specular, exterior_ior) = (passes(), reflects(), 1.0);
    let description =
        BsdfDescription::RoughPlastic { distribution, alpha, interior_ior, exterior_ior, diffuse, specular, nonlinear };
    Bsdf::new(&description).unwrap()
}

fn principled(parameters: PrincipledDescription) -> Bsdf {
    Bsdf::new(&BsdfDescription::Principled(Box::new(parameters))).unwrap()
}

/// A bit of everything, but glass.
fn opaque_principled() -> PrincipledDescription {
    PrincipledDescription {
        base_color: Rgb::new(0.8, 0.5, 0.1).into(),
        roughness: 0.6.into(),
        anisotropic: 0.5.into(),
        metallic: 0.3.into(),
        spec_tint: 0.4.into(),
        sheen: 0.7.into(),
        sheen_tint: 0.3.into(),
        flatness: 0.4.into(),
        clearcoat: 0.8.into(),
        ..Default::default()
    }
}

/// With everything.
fn glassy_principled(eta: f64) -> PrincipledDescription {
    PrincipledDescription { spec_trans: 0.6.into(), eta, ..opaque_principled() }
}

/// Models beside the plain ones, the wide lobes of which are no narrower than 0.1.
fn others() -> Vec<Bsdf> {
    use MicrofacetKind::{Beckmann, Ggx};
    // Their coats take a while to integrate.
    static COATED: LazyLock<Vec<Bsdf>> =
        LazyLock::new(|| vec![rough_plastic(Ggx, 0.3, 1.5, true), rough_plastic(Beckmann, 0.15, 1.3, false)]);
    let mut all = tinted();
    all.extend([plastic(1.5, true), plastic(1.3, false), plastic(0.8, true)]);
    all.extend(COATED.iter().cloned());
    all.extend([PrincipledDescription::default(), opaque_principled()].map(principled));
    all.extend([1.4, 0.8].map(|eta| principled(glassy_principled(eta))));
    all
}

/// Those of metal and glass.
fn tinted() -> Vec<Bsdf> {
    use MicrofacetKind::{Beckmann, Ggx};
    let mut all = vec![tinted_smooth_glass(1.5), pane(1.5), pane(0.7)];
    for kind in [Ggx, Beckmann] {
        all.extend([[0.1, 0.4], [0.7, 0.2], [0.5, 0.5]].map(|alphas| tinted_metal(kind, alphas)));
        all.extend([[0.15, 0.6], [0.8, 0.8]].map(|alphas| tinted_glass(kind, alphas, 1.5)));
        all.push(tinted_glass(kind, [0.5, 0.2], 0.7));
    }
    all
}

/// The unit vector with this cosine and azimuth.
fn direction(cos: f64, phi: f64) -> DVec3 {
    let (s, c) = libm::sincos(phi);
    let sine = ((1.0 - cos) * (1.0 + cos)).sqrt();
    DVec3::new(sine * c, sine * s, cos)
}

fn mirrored(from: DVec3) -> DVec3 {
    DVec3::new(-from.x, -from.y, from.z)
}

/// Snell's law by its textbook form, for an inside of index `ior`; `None` for total reflection.
fn refracted(from: DVec3, ior: f64) -> Option<DVec3> {
    let n = if from.z > 0.0 { ior } else { 1.0 / ior };
    let (x, y) = (-from.x / n, -from.y / n);
    let square = 1.0 - x * x - y * y;
    (square > 0.0).then(|| DVec3::new(x, y, -square.sqrt().copysign(from.z)))
}

/// `f cos θ / p` of a drawn direction: the factor by which a walk's throughput changes.
fn throughput(sample: &BsdfSample) -> Rgb {
    match sample.density {
        LobeDensity::Finite(density) => sample.value * (sample.to.z.abs() / density.value()),
        LobeDensity::Dirac(density) => sample.value / density.value(),
    }
}
