//! Materials close to their limits.

use glam::{DVec2, DVec3};

use super::super::case::{Case, Stage, Subject};
use super::super::truth::{Microfacets, fresnel_conductor, image_mean};
use super::case;
use super::scenery::{ASPECT, sample_in_furnace, slanted_camera};
use crate::scene::description::{BsdfDescription, ConductorFresnel, MicrofacetKind, Sphere};
use crate::spectrum::Rgb;
use crate::testing::scenes::pinhole;

/// Relative error of the quadrature over facets.
const QUADRATURE: f64 = 1e-5;

pub(super) fn cases() -> Vec<Case> {
    let new = |name, sweep: (&'static str, &[f64]), stage| case("material", name, sweep, Subject::Scene(stage));
    vec![
        new("rough metal", ("alpha", &[1.0, 0.1, 1e-2, 1e-4, 1e-6, 1e-8]), |alpha| metal(alpha, alpha))
            .about("GGX facets in a constant environment: their albedo by quadrature, 1 in the smooth limit"),
        new("brushed metal", ("alpha along over across", &[1.0, 10.0, 1e2, 1e3, 1e4]), |ratio| metal(0.3, 0.3 / ratio))
            .about("the same, of roughness 0.3 along the brush"),
        new("rough glass", ("alpha", &[1.0, 0.1, 1e-2, 1e-4, 1e-6, 1e-8]), |alpha| glass(alpha, 1.5))
            .about("an interface of GGX facets in a constant environment, refracted radiance by 1/η²: quadrature"),
        new("rough glass of little contrast", ("index - 1", &[0.5, 1e-3, 1e-6, 1e-9, 0.0]), |contrast| {
            // Without contrast there is no interface, and no masking either, which the limit would have.
            let stage = glass(0.1, 1.0 + contrast);
            if contrast == 0.0 { Stage::new(stage.scene, 1.0) } else { stage }
        })
        .about("the same at α = 0.1: half vectors vanish as the index goes to one"),
        new("glass of little contrast", ("index - 1", &[0.5, 1e-3, 1e-6, 1e-9, 0.0]), |contrast| ball(1.0 + contrast))
            .about("a lossless ball in a constant environment: L = 1"),
        new("dense glass", ("index", &[1.5, 3.0, 10.0, 30.0, 100.0]), ball).about("the same"),
        new("glass thinner than air", ("index", &[0.9, 0.67, 0.3, 0.1, 0.01]), ball).about("the same"),
        new("dark", ("albedo", &[0.5, 1e-3, 1e-9, 0.0]), white)
            .about("a convex diffuse ball in a constant environment: L = albedo"),
        new("bright", ("albedo", &[0.5, 0.999, 1.0]), white).about("the same"),
        new("metal without absorption", ("k", &[3.0, 1e-3, 1e-9, 0.0]), |k| smooth_metal(1.5, k))
            .about("smooth metal of η = 1.5 in a constant environment: Fresnel's formulas with complex numbers"),
        new("metal of strong absorption", ("k", &[3.0, 1e2, 1e4, 1e6]), |k| smooth_metal(1.5, k)).about("the same"),
    ]
}

fn white_metal() -> ConductorFresnel {
    ConductorFresnel::Tint { specular_tint: Rgb::WHITE }
}

fn metal(alpha_u: f64, alpha_v: f64) -> Stage {
    let bsdf = BsdfDescription::RoughConductor {
        distribution: MicrofacetKind::Ggx,
        alpha: alpha_u.into(),
        alpha_v: Some(alpha_v.into()),
        fresnel: white_metal(),
        reflectance: Rgb::WHITE.into(),
    };
    let camera = slanted_camera();
    let facets = Microfacets { alpha: DVec2::new(alpha_u, alpha_v) };
    let truth = image_mean(&camera, ASPECT, |direction| facets.mirror(-direction));
    Stage::new(sample_in_furnace(bsdf, camera), truth).within(QUADRATURE)
}

fn glass(alpha: f64, index: f64) -> Stage {
    let camera = slanted_camera();
    let facets = Microfacets { alpha: DVec2::splat(alpha) };
    let truth = image_mean(&camera, ASPECT, |direction| facets.glass(-direction, index));
    Stage::new(sample_in_furnace(BsdfDescription::rough_dielectric(alpha, index, 1.0), camera), truth)
        .within(QUADRATURE)
}

/// A ball in the furnace, and nothing else.
fn balled(bsdf: BsdfDescription, truth: f64) -> Stage {
    let mut scene = sample_in_furnace(bsdf, pinhole(DVec3::new(0.3, 0.4, 3.0), DVec3::ZERO, 20.0));
    scene.meshes.clear();
    scene.spheres.push(Sphere::new("ball", DVec3::ZERO, 1.0, 0));
    Stage::new(scene, truth)
}

fn ball(index: f64) -> Stage {
    balled(BsdfDescription::dielectric(index, 1.0), 1.0)
}

fn white(albedo: f64) -> Stage {
    balled(BsdfDescription::Diffuse { reflectance: Rgb::grey(albedo).into() }, albedo)
}

fn smooth_metal(eta: f64, k: f64) -> Stage {
    let camera = slanted_camera();
    let truth = image_mean(&camera, ASPECT, |direction| fresnel_conductor(-direction.z, eta, k));
    let fresnel = ConductorFresnel::Ior { eta: Rgb::grey(eta), k: Rgb::grey(k) };
    Stage::new(sample_in_furnace(BsdfDescription::conductor(fresnel), camera), truth)
}
