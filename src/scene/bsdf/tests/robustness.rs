//! No parameters and no directions give NaN, infinities or negative numbers; Fresnel's equations at known points.

use std::sync::LazyLock;

use proptest::prelude::*;

use super::super::fresnel::{Interface, conductor_channel};
use super::*;

/// Cosines of both signs down to 1e-9.
fn cosine() -> impl Strategy<Value = f64> {
    (prop_oneof![0.0..=1.0_f64, (-9.0..0.0_f64).prop_map(|e| 10.0_f64.powf(e)), Just(1.0)], any::<bool>())
        .prop_map(|(cos, up)| if up { cos } else { -cos })
}

fn any_unit() -> impl Strategy<Value = DVec3> {
    (cosine(), 0.0..6.3_f64).prop_map(|(cos, phi)| direction(cos, phi))
}

fn index() -> impl Strategy<Value = f64> {
    prop_oneof![
        0.01..3.0_f64,
        Just(1.0),
        Just(1.0 + 1e-9),
        Just(1.0 - 1e-9),
        Just(100.0),
        (1e-13..1e-3_f64).prop_map(|d| 1.0 + d)
    ]
}

fn roughness() -> impl Strategy<Value = f64> {
    prop_oneof![(-8.0..1.0_f64).prop_map(|e| 10.0_f64.powf(e).max(1e-8)), Just(1e-8), Just(1.0)]
}

fn fresnel() -> impl Strategy<Value = ConductorFresnel> {
    let part = || prop_oneof![Just(0.0), Just(1.0), 0.0..10.0_f64, Just(1e6)];
    prop_oneof![
        (0.0..=1.0_f64).prop_map(|t| ConductorFresnel::Tint { specular_tint: Rgb::new(t, 0.0, 1.0) }),
        (part(), part())
            .prop_map(|(eta, k)| ConductorFresnel::Ior { eta: Rgb::new(eta, k, 1.0), k: Rgb::new(k, 0.0, eta) })
    ]
}

fn kind() -> impl Strategy<Value = MicrofacetKind> {
    prop_oneof![Just(MicrofacetKind::Ggx), Just(MicrofacetKind::Beckmann)]
}

fn any_other() -> impl Strategy<Value = BsdfDescription> {
    let tint = || (0.0..=1.0_f64).prop_map(|t| Parameter::from(Rgb::new(t, 0.0, 1.0)));
    prop_oneof![
        (kind(), roughness(), roughness(), fresnel(), tint()).prop_map(|(distribution, u, v, fresnel, reflectance)| {
            BsdfDescription::RoughConductor {
                distribution,
                alpha: u.into(),
                alpha_v: Some(v.into()),
                fresnel,
                reflectance,
            }
        }),
        (kind(), roughness(), roughness(), index(), index(), tint()).prop_map(
            |(distribution, u, v, interior_ior, exterior_ior, reflectance)| BsdfDescription::RoughDielectric {
                distribution,
                alpha: u.into(),
                alpha_v: Some(v.into()),
                interior_ior,
                exterior_ior,
                reflectance,
                transmittance: passes(),
            }
        ),
        (index(), index(), tint()).prop_map(|(interior_ior, exterior_ior, reflectance)| {
            BsdfDescription::ThinDielectric { interior_ior, exterior_ior, reflectance, transmittance: passes() }
        }),
    ]
}

fn any_coated() -> impl Strategy<Value = BsdfDescription> {
    let tint = || (0.0..=1.0_f64).prop_map(|t| Parameter::from(Rgb::new(t, 0.0, 1.0)));
    (index(), index(), tint(), any::<bool>()).prop_map(|(interior_ior, exterior_ior, diffuse, nonlinear)| {
        BsdfDescription::Plastic { interior_ior, exterior_ior, diffuse, specular: reflects(), nonlinear }
    })
}

fn any_principled() -> impl Strategy<Value = BsdfDescription> {
    let share = || prop_oneof![Just(0.0), Just(1.0), 0.0..=1.0_f64, Just(1e-9)];
    (prop::array::uniform10(share()), index(), any::<bool>()).prop_map(|(shares, eta, black)| {
        let [roughness, anisotropic, metallic, spec_trans, spec_tint, sheen, sheen_tint, flatness, clearcoat, gloss] =
            shares.map(Parameter::from);
        BsdfDescription::Principled(Box::new(PrincipledDescription {
            base_color: if black { Rgb::BLACK.into() } else { passes() },
            roughness,
            anisotropic,
            metallic,
            spec_trans,
            eta,
            spec_tint,
            sheen,
            sheen_tint,
            flatness,
            clearcoat,
            clearcoat_gloss: gloss,
        }))
    })
}

/// Coats of extreme parameters, which take too long to integrate for every case.
fn any_rough_plastic() -> impl Strategy<Value = Bsdf> {
    static ALL: LazyLock<Vec<Bsdf>> = LazyLock::new(|| {
        use MicrofacetKind::{Beckmann, Ggx};
        [(Ggx, 1e-8, 1.5), (Ggx, 10.0, 1.0 + 1e-9), (Ggx, 0.3, 100.0), (Ggx, 0.1, 0.01), (Ggx, 1.0, 1.0)]
            .into_iter()
            .chain([(Beckmann, 1e-8, 100.0), (Beckmann, 10.0, 0.7), (Beckmann, 0.3, 1.0 - 1e-9)])
            .map(|(kind, alpha, ior)| rough_plastic(kind, alpha, ior, false))
            .collect()
    });
    (0..8_usize).prop_map(|i| ALL[i].clone())
}

fn any_bsdf() -> impl Strategy<Value = Bsdf> {
    prop_oneof![
        (0.0..=1.0_f64).prop_map(|r| BsdfDescription::Diffuse { reflectance: Rgb::new(r, 0.0, 1.0).into() }),
        fresnel().prop_map(BsdfDescription::conductor),
        (roughness(), fresnel()).prop_map(|(alpha, fresnel)| BsdfDescription::rough_conductor(alpha, fresnel)),
        (index(), index())
            .prop_map(|(interior_ior, exterior_ior)| BsdfDescription::dielectric(interior_ior, exterior_ior)),
        (roughness(), index(), index()).prop_map(|(alpha, interior_ior, exterior_ior)| {
            BsdfDescription::rough_dielectric(alpha, interior_ior, exterior_ior)
        }),
        any_other(),
        any_coated(),
        any_principled(),
    ]
    .prop_map(|description| Bsdf::new(&description).unwrap())
}

fn fine(value: f64) -> bool {
    value.is_finite() && value >= 0.0
}

fn fine_rgb(value: Rgb) -> bool {
    value.to_array().into_iter().all(fine)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20_000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_answer_is_finite_and_not_negative(
        bsdf in prop_oneof![9 => any_bsdf(), 1 => any_rough_plastic()],
        a in any_unit(),
        b in any_unit(),
        u in any::<[u32; 3]>().prop_map(|u| u.map(|u| f64::from(u) / 4_294_967_296.0)),
        to_sensor in any::<bool>(),
    ) {
        let side = SIDES[usize::from(to_sensor)];
        let sample = bsdf.sample(side, a, u);
        for to in [Some(b), Some(-a), Some(mirrored(a)), sample.map(|s| s.to)].into_iter().flatten() {
            for (from, to) in [(a, to), (to, a)] {
                prop_assert!(fine_rgb(bsdf.eval(from, to)), "eval {from} {to}: {:?}", bsdf.eval(from, to));
                prop_assert!(fine(bsdf.density(from, to).value()), "density {from} {to}");
                prop_assert!(fine_rgb(bsdf.eval_dirac(from, to)), "eval_dirac {from} {to}");
                prop_assert!(fine(bsdf.density_dirac(side, from, to).value()), "density_dirac {from} {to}");
                prop_assert!(fine(bsdf.radiance_scale(from, to)));
            }
        }
        if let Some(sample) = sample {
            prop_assert!((sample.to.length() - 1.0).abs() < 1e-12 && sample.to.z != 0.0, "to {}", sample.to);
            prop_assert!(fine_rgb(throughput(&sample)), "throughput {:?}", sample);
        }
    }

    #[test]
    fn the_two_shares_of_fresnel_add_up_to_one(cos in cosine(), inside in index(), outside in index()) {
        let split = Interface::new(inside, outside).fresnel(cos);
        prop_assert!(fine(split.reflected) && fine(split.transmitted));
        prop_assert!((split.reflected + split.transmitted - 1.0).abs() < 1e-12, "{split:?}");
    }
}

#[test]
fn fresnel_at_known_points() {
    let glass = Interface::new(1.5, 1.0);
    assert!((glass.fresnel(1.0).reflected - 0.04).abs() < 1e-16);
    assert!((glass.fresnel(-1.0).reflected - 0.04).abs() < 1e-16);
    // At Brewster's angle tan θ = η only s-polarised light is reflected: F = ((η² − 1) / (η² + 1))² / 2.
    let brewster = 1.0 / (1.0_f64 + 2.25).sqrt();
    assert!((glass.fresnel(brewster).reflected - 0.5 * (1.25_f64 / 3.25).powi(2)).abs() < 1e-15);
    // Metal along the normal: ((η − 1)² + k²) / ((η + 1)² + k²).
    assert!((conductor_channel(0.2, 3.9, 1.0) - (0.64 + 15.21) / (1.44 + 15.21)).abs() < 1e-15);
    assert_eq!(conductor_channel(0.2, 3.9, 0.0), 1.0);
}

#[test]
fn metal_without_extinction_is_a_dielectric() {
    for eta in [1.5, 0.6, 2.4, 1.0] {
        // Both sides of the critical angle of 0.6, cos θ = 0.8, where F is not smooth.
        for cos in [1.0, 0.81, 0.79, 0.5, 0.1, 1e-7] {
            let (metal, glass) = (conductor_channel(eta, 0.0, cos), Interface::new(eta, 1.0).fresnel(cos).reflected);
            assert!((metal - glass).abs() < 1e-14, "η {eta}, cos {cos}: {metal}, not {glass}");
        }
    }
}
