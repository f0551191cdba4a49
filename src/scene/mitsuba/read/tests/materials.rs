//! Models and their defaults.

use std::process::Command;

use super::super::tables::METALS;
use super::{bsdf, scene};
use crate::scene::description::{
    BsdfDescription, ConductorFresnel, MicrofacetKind, NormalSource, PrincipledDescription,
};
use crate::spectrum::Rgb;

const BK7: f64 = 1.5046;
const AIR: f64 = 1.000277;

#[test]
fn defaults_are_those_of_mitsuba() {
    let plain = |plugin: &str| bsdf(&format!("<bsdf type=\"{plugin}\"/>"));
    let (white, grey) = (Rgb::WHITE, Rgb::grey(0.5));
    let mirror = ConductorFresnel::Tint { specular_tint: Rgb::WHITE };
    assert_eq!(plain("diffuse"), BsdfDescription::Diffuse { reflectance: grey.into() });
    assert_eq!(plain("conductor"), BsdfDescription::conductor(mirror.clone()));
    assert_eq!(plain("dielectric"), BsdfDescription::dielectric(BK7, AIR));
    let thin = BsdfDescription::ThinDielectric {
        interior_ior: BK7,
        exterior_ior: AIR,
        reflectance: white.into(),
        transmittance: white.into(),
    };
    assert_eq!(plain("thindielectric"), thin);
    let rough = BsdfDescription::RoughConductor {
        distribution: MicrofacetKind::Beckmann,
        alpha: 0.1.into(),
        alpha_v: None,
        fresnel: mirror,
        reflectance: white.into(),
    };
    assert_eq!(plain("roughconductor"), rough);
    let rough = BsdfDescription::RoughDielectric {
        distribution: MicrofacetKind::Beckmann,
        alpha: 0.1.into(),
        alpha_v: None,
        interior_ior: BK7,
        exterior_ior: AIR,
        reflectance: white.into(),
        transmittance: white.into(),
    };
    assert_eq!(plain("roughdielectric"), rough);
    let plastic = BsdfDescription::Plastic {
        interior_ior: 1.49,
        exterior_ior: AIR,
        diffuse: grey.into(),
        specular: white.into(),
        nonlinear: false,
    };
    assert_eq!(plain("plastic"), plastic);
    let plastic = BsdfDescription::RoughPlastic {
        distribution: MicrofacetKind::Beckmann,
        alpha: 0.1,
        interior_ior: 1.49,
        exterior_ior: AIR,
        diffuse: grey.into(),
        specular: white.into(),
        nonlinear: false,
    };
    assert_eq!(plain("roughplastic"), plastic);
    let eta = 2.0 / (1.0 - (0.08_f64 * 0.5).sqrt()) - 1.0;
    assert_eq!(
        plain("principled"),
        BsdfDescription::Principled(Box::new(PrincipledDescription { eta, ..PrincipledDescription::default() }))
    );
    assert_eq!(plain("null"), BsdfDescription::Null);
}

#[test]
fn a_shape_without_a_model_is_grey_and_one_that_shines_black() {
    let scene = scene("<shape type=\"sphere\"/><shape type=\"sphere\"><emitter type=\"area\"/></shape>");
    let diffuse = |value: f64| BsdfDescription::Diffuse { reflectance: Rgb::grey(value).into() };
    assert_eq!([&scene.materials[0].bsdf, &scene.materials[1].bsdf], [&diffuse(0.5), &diffuse(0.0)]);
    assert!(!scene.materials[0].emits());
    assert_eq!(scene.materials[1].emission.constant(), Some(&Rgb::WHITE));
}

#[test]
fn metals_and_glasses_have_names() {
    let copper = bsdf(
        "<bsdf type=\"roughconductor\"><string name=\"material\" value=\"Cu\"/>\
        <float name=\"alpha_u\" value=\"0.1\"/><float name=\"alpha_v\" value=\"0.2\"/>\
        <string name=\"distribution\" value=\"GGX\"/></bsdf>",
    );
    let BsdfDescription::RoughConductor { distribution, alpha, alpha_v, fresnel, .. } = copper else {
        panic!("no metal")
    };
    assert_eq!((distribution, alpha, alpha_v), (MicrofacetKind::Ggx, 0.1.into(), Some(0.2.into())));
    let ConductorFresnel::Ior { eta, k } = fresnel else { panic!("a tint") };
    let near = |a: Rgb, b: [f64; 3]| a.to_array().iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
    assert!(near(eta, [0.20100504, 0.92374903, 1.1022143]) && near(k, [3.9132574, 2.4530439, 2.1420906]));
    let diamond = "<bsdf type=\"dielectric\"><string name=\"int_ior\" value=\"Diamond\"/><string name=\"ext_ior\" value=\"water\"/></bsdf>";
    assert_eq!(bsdf(diamond), BsdfDescription::dielectric(2.419, 1.333));
}

/// The tables are what the script makes of Mitsuba's data; skipped where there is no Mitsuba.
#[test]
fn the_tables_are_those_of_the_script() {
    let (python, script) = (".venv/bin/python", "scripts/pathspace/mitsuba_tables.py");
    let Ok(output) = Command::new(python).arg(script).output() else {
        eprintln!("skipped: there is no {python}");
        return;
    };
    if !output.status.success() {
        eprintln!("skipped: {python} has no Mitsuba");
        return;
    }
    let same = String::from_utf8_lossy(&output.stdout) == include_str!("../tables.rs");
    assert!(same, "run {script} again");
    assert!(METALS.len() > 30);
}

#[test]
fn composites_hold_what_stands_in_them() {
    let inner = "<bsdf type=\"diffuse\"/>";
    let diffuse = BsdfDescription::Diffuse { reflectance: Rgb::grey(0.5).into() };
    let mask = bsdf(&format!("<bsdf type=\"mask\"><float name=\"opacity\" value=\"0.3\"/>{inner}</bsdf>"));
    assert_eq!(mask, BsdfDescription::Mask { opacity: 0.3.into(), nested: diffuse.clone().into() });
    let blend = bsdf(&format!(
        "<bsdf type=\"blendbsdf\"><float name=\"weight\" value=\"0.3\"/>{inner}<bsdf type=\"null\"/></bsdf>"
    ));
    let expected = BsdfDescription::Blend {
        weight: 0.3.into(),
        first: diffuse.clone().into(),
        second: BsdfDescription::Null.into(),
    };
    assert_eq!(blend, expected);
    let scene = scene(&format!("<shape type=\"sphere\"><bsdf type=\"twosided\">{inner}</bsdf></shape>"));
    assert_eq!((&scene.materials[0].bsdf, scene.materials[0].two_sided), (&diffuse, true));
    let metal = "<bsdf type=\"conductor\"/>";
    let BsdfDescription::TwoSided { front, back } = bsdf(&format!("<bsdf type=\"twosided\">{inner}{metal}</bsdf>"))
    else {
        panic!("one side")
    };
    assert_eq!(*front, diffuse);
    assert!(matches!(*back, BsdfDescription::Conductor { .. }));
    let bump = bsdf(&format!(
        "<bsdf type=\"bumpmap\"><texture type=\"checkerboard\"/><float name=\"scale\" value=\"2\"/>{inner}</bsdf>"
    ));
    let BsdfDescription::Perturbed { normal: NormalSource::Bump { scale, .. }, nested } = bump else {
        panic!("no bumps")
    };
    assert_eq!((scale, *nested), (2.0, diffuse));
}
