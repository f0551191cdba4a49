//! glTF's own material: against its specification written out, against the models that it contains, and as all models.

use std::f64::consts::PI;

use rand::RngExt;

use super::composites::{bitmap, pinned};
use super::*;
use crate::scene::description::{GltfAnisotropy, GltfCoat, GltfDescription, GltfSheen, GltfVolume, NormalSource, Slot};

fn slot(r: f64, g: f64, b: f64, a: f64) -> Slot {
    Slot::constant([r, g, b, a])
}

/// A non-metal.
fn matter(roughness: f64) -> GltfDescription {
    GltfDescription {
        base_color: slot(0.9, 0.5, 0.2, 1.0),
        metallic_roughness: slot(1.0, roughness, 0.0, 1.0),
        ..GltfDescription::default()
    }
}

fn metal_of(roughness: f64, metallic: f64) -> GltfDescription {
    GltfDescription { metallic_roughness: slot(1.0, roughness, metallic, 1.0), ..matter(roughness) }
}

fn thin(roughness: f64, share: f64) -> GltfDescription {
    GltfDescription { transmission: slot(share, 1.0, 1.0, 1.0), ..matter(roughness) }
}

fn solid(roughness: f64, share: f64, ior: f64) -> GltfDescription {
    let volume = GltfVolume {
        thickness: slot(1.0, 0.5, 1.0, 1.0),
        attenuation_color: Rgb::new(0.5, 0.9, 1.0),
        attenuation_distance: 0.7,
    };
    GltfDescription { volume: Some(volume), ior, ..thin(roughness, share) }
}

fn coat(roughness: f64) -> GltfCoat {
    GltfCoat { factor: slot(0.8, 1.0, 1.0, 1.0), roughness: slot(1.0, roughness, 1.0, 1.0), normal: None }
}

fn sheen(roughness: f64) -> GltfSheen {
    GltfSheen { color: slot(0.9, 0.4, 0.1, 1.0), roughness: slot(1.0, 1.0, 1.0, roughness) }
}

fn brushed(roughness: f64) -> GltfDescription {
    let anisotropy = GltfAnisotropy { strength: 0.7, rotation: 0.4, texture: None };
    GltfDescription { anisotropy: Some(anisotropy), ..metal_of(roughness, 1.0) }
}

fn normal_map(seed: f32) -> NormalSource {
    let texture =
        bitmap([[0.6, 0.45 + seed, 0.9, 1.0], [0.4, 0.5, 0.95, 1.0], [0.7, 0.4, 0.8, 1.0], [0.5, 0.5, 1.0, 1.0]]);
    NormalSource::Map { texture, scale: [1.0; 2], against_v: true }
}

fn model(description: GltfDescription) -> Bsdf {
    Bsdf::new(&BsdfDescription::Gltf(Box::new(description))).unwrap()
}

fn at_a_point(description: GltfDescription) -> Bsdf {
    pinned(&BsdfDescription::Gltf(Box::new(description)))
}

/// Those that are reciprocal.
pub(super) fn reciprocal() -> Vec<Bsdf> {
    let tinted = GltfDescription {
        specular: slot(1.0, 1.0, 1.0, 0.7),
        specular_color: slot(3.0, 0.5, 0.0, 1.0),
        ior: 1.8,
        ..matter(0.4)
    };
    let cloth = GltfDescription { sheen: Some(sheen(0.5)), ..matter(0.9) };
    let velvet_glass = GltfDescription { sheen: Some(sheen(0.3)), ..solid(0.6, 0.8, 1.5) };
    vec![
        model(matter(0.6)),
        model(metal_of(0.5, 0.4)),
        model(metal_of(0.7, 1.0)),
        model(tinted),
        model(GltfDescription { ior: 0.0, ..matter(0.5) }),
        model(thin(0.4, 0.7)),
        model(thin(0.6, 1.0)),
        model(solid(0.5, 1.0, 1.5)),
        model(solid(0.7, 0.6, 2.4)),
        model(cloth),
        model(velvet_glass),
        at_a_point(brushed(0.5)),
    ]
}

/// All, wide enough for cells around the normal.
pub(super) fn wide() -> Vec<Bsdf> {
    let coated = |below: GltfDescription| GltfDescription { clearcoat: Some(coat(0.4)), ..below };
    let mapped = GltfDescription {
        normal: Some(normal_map(0.0)),
        clearcoat: Some(GltfCoat { normal: Some(normal_map(0.2)), ..coat(0.5) }),
        sheen: Some(sheen(0.6)),
        ..matter(0.5)
    };
    let mut all = reciprocal();
    all.extend([
        model(coated(matter(0.6))),
        model(coated(GltfDescription { sheen: Some(sheen(0.7)), ..metal_of(0.5, 0.5) })),
        model(coated(thin(0.5, 0.8))),
        model(coated(solid(0.5, 0.8, 1.5))),
        at_a_point(mapped.clone()),
        at_a_point(GltfDescription { transmission: slot(0.6, 1.0, 1.0, 1.0), ..mapped.clone() }),
        at_a_point(GltfDescription {
            volume: solid(0.5, 1.0, 1.5).volume,
            ..GltfDescription { transmission: slot(0.6, 1.0, 1.0, 1.0), ..mapped }
        }),
    ]);
    all
}

/// With narrow lobes too.
pub(super) fn all() -> Vec<Bsdf> {
    let polished = GltfDescription { clearcoat: Some(coat(0.0)), ..matter(0.0) };
    let mut all = wide();
    all.extend([
        model(metal_of(0.0, 1.0)),
        model(polished),
        model(thin(0.0, 1.0)),
        model(solid(0.0, 1.0, 1.5)),
        model(solid(0.0, 1.0, 1.0)),
        model(solid(0.5, 1.0, 1.0)),
    ]);
    all
}

/// `V · D` of the specification with a roughness along T and B; isotropic where both are alike.
fn specular(v: DVec3, l: DVec3, h: DVec3, t: DVec3, [at, ab]: [f64; 2]) -> f64 {
    let b = DVec3::Z.cross(t);
    let d = 1.0 / (PI * at * ab * ((t.dot(h) / at).powi(2) + (b.dot(h) / ab).powi(2) + h.z * h.z).powi(2));
    let smith = |w: DVec3| w.z.abs() + DVec3::new(at * t.dot(w), ab * b.dot(w), w.z).length();
    d / (smith(v) * smith(l))
}

/// The BRDF of glTF 2.0, appendix B, with KHR_materials_ior, specular, transmission and clearcoat, as their texts have it.
#[test]
fn it_is_what_the_specification_says() {
    let mut rng = random_numbers(31);
    for _ in 0..20_000 {
        let mut share = || rng.random::<f64>();
        let (base, roughness, metallic) = (Rgb::new(share(), share(), share()), 0.1 + 0.9 * share(), share());
        let (ior, weight, tint) = (1.0 + share(), share(), Rgb::new(2.0 * share(), share(), share()));
        let (transmission, coat_share, coat_roughness) = (share(), share(), 0.2 + 0.8 * share());
        let (strength, rotation) = (share(), 6.0 * share());
        let v = direction(0.05 + 0.95 * share(), 6.0 * share());
        let l = direction(1.9 * share() - 0.95, 6.0 * share());
        let description = GltfDescription {
            base_color: slot(base.r, base.g, base.b, 0.3),
            metallic_roughness: slot(0.5, roughness, metallic, 0.5),
            ior,
            specular: slot(0.1, 0.2, 0.3, weight),
            specular_color: slot(tint.r, tint.g, tint.b, 0.1),
            transmission: slot(transmission, 0.2, 0.3, 0.4),
            clearcoat: Some(GltfCoat {
                factor: slot(coat_share, 0.1, 0.1, 0.1),
                roughness: slot(0.1, coat_roughness, 0.1, 0.1),
                normal: None,
            }),
            anisotropy: Some(GltfAnisotropy { strength, rotation, texture: None }),
            ..GltfDescription::default()
        };
        let alpha = roughness * roughness;
        let alphas = [alpha + (1.0 - alpha) * strength * strength, alpha];
        // The point of these tests has v along y, against which the bitangent goes.
        let t = direction(0.0, -rotation);
        let fresnel = |f0: f64, cos: f64| f0 + (1.0 - f0) * (1.0 - cos).powi(5);
        let reflected = l.z > 0.0;
        let bent = if reflected { l } else { DVec3::new(l.x, l.y, -l.z) };
        let h = (v + bent).normalize();
        let lobe = specular(v, bent, h, t, alphas);
        let f0 = ((1.0 - ior) / (1.0 + ior)).powi(2);
        let dielectric_f0 = tint.map(|c| (f0 * c).min(1.0));
        let dielectric_fr = dielectric_f0.map(|f0| fresnel(f0, v.dot(h)));
        let below = 1.0 - weight * dielectric_fr.max_component();
        let (diffuse, layer, metal) = if reflected {
            let metal = base.map(|b| lobe * fresnel(b, v.dot(h)));
            (base * ((1.0 - transmission) / PI), dielectric_fr * (weight * lobe), metal)
        } else {
            (base * (lobe * transmission), Rgb::BLACK, Rgb::BLACK)
        };
        let material = (diffuse * below + layer) * (1.0 - metallic) + metal * metallic;
        let coat_fr = coat_share * fresnel(0.04, v.z);
        let coat_lobe = if reflected { specular(v, l, h, DVec3::X, [coat_roughness * coat_roughness; 2]) } else { 0.0 };
        let expected = material * (1.0 - coat_fr) + Rgb::grey(coat_fr * coat_lobe);
        let found = at_a_point(description).eval(l, v);
        for (found, expected) in found.to_array().into_iter().zip(expected.to_array()) {
            assert!((found - expected).abs() <= 1e-11 * expected, "{found}, not {expected}: {v} {l}");
        }
    }
}

/// KHR_materials_sheen: the fit at places where its text gives numbers by hand, and the albedo below.
#[test]
fn fibres_are_those_of_the_extension() {
    let mut rng = random_numbers(32);
    let (cloth, bare) = (model(GltfDescription { sheen: Some(sheen(0.5)), ..matter(0.9) }), model(matter(0.9)));
    let alpha = 0.25;
    let mix = |a: f64, b: f64| a + (b - a) * (1.0_f64 - alpha).powi(2);
    let l = |x: f64| {
        let (a, b, c) = (mix(21.5473, 25.3245), mix(3.82987, 3.32435), mix(0.19823, 0.16801));
        a / (1.0 + b * x.powf(c)) + mix(-1.97760, -1.27393) * x + mix(-4.32054, -4.85967)
    };
    let lambda = |x: f64| if x < 0.5 { l(x).exp() } else { (2.0 * l(0.5) - l(1.0 - x)).exp() };
    let brdf = |v: DVec3, w: DVec3| {
        let h = (v + w).normalize();
        let d = (2.0 + 1.0 / alpha) * (1.0 - h.z * h.z).powf(0.5 / alpha) / (2.0 * PI);
        d / ((1.0 + lambda(v.z) + lambda(w.z)) * 4.0 * v.z * w.z)
    };
    // By a plain Monte Carlo mean, whose standard error is below 1e-3 here.
    let mut albedo = |v: DVec3| {
        let n = 100_000;
        let sum: f64 = (0..n)
            .map(|_| direction(rng.random::<f64>(), std::f64::consts::TAU * rng.random::<f64>()))
            .map(|w| brdf(v, w) * w.z)
            .sum();
        2.0 * PI * sum / f64::from(n)
    };
    for (cos_v, cos_l) in [(0.9, 0.3), (0.2, 0.7), (0.5, 0.5), (0.1, 0.15)] {
        let (v, w) = (direction(cos_v, 1.0), direction(cos_l, 3.5));
        let scale = 1.0 - 0.9 * albedo(v).max(albedo(w));
        let expected = brdf(v, w) * 0.9 + bare.eval(w, v).r * scale;
        let found = cloth.eval(w, v).r;
        assert!((found / expected - 1.0).abs() < 0.01, "{found}, not {expected}");
    }
}

#[test]
fn white_metal_is_a_rough_conductor() {
    let white_metal = GltfDescription { base_color: slot(1.0, 1.0, 1.0, 1.0), ..metal_of(0.5, 1.0) };
    let (ours, theirs) = (model(white_metal), metal(0.25, white()));
    let mut rng = random_numbers(33);
    for _ in 0..2_000 {
        let (a, b) = (direction(rng.random(), rng.random()), direction(rng.random(), 5.0 * rng.random::<f64>()));
        assert!((ours.eval(a, b).r / theirs.eval(a, b).r - 1.0).abs() < 1e-12);
        assert!((ours.density(a, b).value() / theirs.density(a, b).value() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn without_its_layer_it_is_lamberts() {
    let matt = model(GltfDescription { specular: slot(1.0, 1.0, 1.0, 0.0), ..matter(0.3) });
    let (a, b) = (direction(0.3, 1.0), direction(0.9, 4.0));
    assert_eq!(matt.eval(a, b), Rgb::new(0.9, 0.5, 0.2) * (1.0 / PI));
    assert!(!matt.is_glossy() && matt.eval(-a, b).is_black() && matt.eval(-a, -b).is_black());
}

/// A solid one bends light as rough glass does: both are Walter's, with another Fresnel reflectance.
#[test]
fn a_solid_transmits_as_rough_glass_does() {
    let clear = GltfDescription {
        base_color: slot(1.0, 1.0, 1.0, 1.0),
        specular: slot(1.0, 1.0, 1.0, 0.0),
        volume: Some(GltfVolume { attenuation_distance: f64::INFINITY, ..solid(0.5, 1.0, 1.5).volume.unwrap() }),
        ..solid(0.5, 1.0, 1.5)
    };
    let (ours, theirs) = (model(clear), rough_glass(0.25, 1.5));
    let mut rng = random_numbers(34);
    let mut seen = 0;
    for _ in 0..5_000 {
        let from = direction(2.0 * rng.random::<f64>() - 1.0, 3.0);
        let Some(sample) = theirs.sample(Side::Sensor, from, rng.random()).filter(|s| s.to.z * from.z < 0.0) else {
            continue;
        };
        let h = -(from * if from.z > 0.0 { 1.0 } else { 1.5 } + sample.to * if from.z > 0.0 { 1.5 } else { 1.0 })
            .normalize();
        let outside = if from.z > 0.0 { from } else { sample.to };
        let transmitted =
            crate::scene::bsdf::fresnel::Interface::new(1.5, 1.0).fresnel(outside.dot(h).abs()).transmitted;
        let ratio = ours.eval(sample.to, from).r * transmitted / sample.value.r;
        assert!((ratio - 1.0).abs() < 1e-9, "{ratio}");
        seen += 1;
    }
    assert!(seen > 1_000);
}

/// `∫ f_s cos θ dσ` per channel seen from there, in energy, and its standard error.
fn albedo(bsdf: &Bsdf, from: DVec3, seed: u64) -> (Rgb, f64) {
    let mut rng = random_numbers(seed);
    let n = 60_000;
    let (mut sum, mut squares) = (Rgb::BLACK, 0.0);
    for _ in 0..n {
        let Some(sample) = bsdf.sample(Side::Sensor, from, rng.random()) else { continue };
        let energy = throughput(&sample) / bsdf.radiance_scale(sample.to, from);
        sum += energy;
        squares += energy.max_component().powi(2);
    }
    let n = f64::from(n);
    (sum / n, ((squares / n - (sum.max_component() / n).powi(2)) / n).max(0.0).sqrt())
}

/// White furnace: what is white reflects and transmits about one, seen from anywhere, and at grazing angles as much more as the
/// specification's mix of layers and the fit of the fibres give it. Fixed seed, four standard errors.
#[test]
fn white_furnace() {
    let white = slot(1.0, 1.0, 1.0, 1.0);
    for (name, most, description) in [
        ("matter", 1.35, matter(0.3)),
        ("half metal", 1.0, metal_of(0.6, 0.5)),
        ("thin", 1.15, thin(0.3, 0.5)),
        ("solid", 1.0, solid(0.4, 1.0, 1.5)),
        ("coat", 1.0, GltfDescription { clearcoat: Some(coat(0.2)), ..matter(0.8) }),
        (
            "sheen",
            1.08,
            GltfDescription { sheen: Some(GltfSheen { color: white.clone(), ..sheen(0.4) }), ..matter(0.8) },
        ),
        (
            "fine sheen",
            1.45,
            GltfDescription { sheen: Some(GltfSheen { color: white.clone(), ..sheen(0.1) }), ..matter(0.8) },
        ),
        (
            "rough sheen",
            1.09,
            GltfDescription { sheen: Some(GltfSheen { color: white.clone(), ..sheen(1.0) }), ..matter(0.8) },
        ),
    ] {
        let bsdf = model(GltfDescription { base_color: white.clone(), ..description });
        for cos in [1.0, 0.6, 0.2, 0.03, -0.5] {
            let (found, error) = albedo(&bsdf, direction(cos, 0.3), 35);
            let most = if cos >= 0.9 { 1.0 } else { most };
            assert!(found.max_component() < most + 4.0 * error, "{name} from {cos}: {found:?} ± {error}");
            // It loses little but by single scattering, the angles between the layers, and the attenuation.
            let dark = name == "solid" || (cos < 0.0 && name != "thin");
            assert!(dark || found.max_component() > 0.6, "{name} from {cos}: {found:?} ± {error}");
        }
    }
}

/// A white base without layers in front of it keeps everything at a normal roughness of 1, and smooth glass as well.
#[test]
fn smooth_thin_glass_is_lossless() {
    let pane = GltfDescription { base_color: slot(1.0, 1.0, 1.0, 1.0), ..thin(0.0, 1.0) };
    for cos in [1.0, 0.4, -0.7] {
        let (found, error) = albedo(&model(pane.clone()), direction(cos, 0.3), 36);
        assert!((found.r - 1.0).abs() < 1e-3 + 4.0 * error, "from {cos}: {found:?} ± {error}");
    }
}

#[test]
fn a_map_that_is_flat_turns_nothing() {
    let flat = NormalSource::Map { texture: bitmap([[0.5, 0.5, 1.0, 1.0]; 4]), scale: [1.0; 2], against_v: true };
    let mapped = GltfDescription {
        normal: Some(flat.clone()),
        clearcoat: Some(GltfCoat { normal: Some(flat), ..coat(0.4) }),
        ..matter(0.5)
    };
    let bare = GltfDescription { clearcoat: Some(coat(0.4)), ..matter(0.5) };
    let (a, b) = (direction(0.3, 1.0), direction(0.9, 4.0));
    let (mapped, bare) = (at_a_point(mapped).eval(a, b), at_a_point(bare).eval(a, b));
    assert!((mapped.g / bare.g - 1.0).abs() < 1e-12);
}

#[test]
fn the_axis_of_a_texture_is_turned_on() {
    // A direction of 90° in the texture is a rotation of 90°.
    let texture = bitmap([[0.5, 1.0, 1.0, 1.0]; 4]);
    let with = |rotation, texture| GltfDescription {
        anisotropy: Some(GltfAnisotropy { strength: 0.8, rotation, texture }),
        ..metal_of(0.4, 1.0)
    };
    let (a, b) = (direction(0.5, 1.0), direction(0.6, 4.4));
    let by_texture = at_a_point(with(0.2, Some(texture))).eval(a, b).r;
    let by_factor = at_a_point(with(0.2 + PI / 2.0, None)).eval(a, b).r;
    assert!((by_texture / by_factor - 1.0).abs() < 1e-12, "{by_texture} {by_factor}");
    assert!((at_a_point(with(0.2, None)).eval(a, b).r / by_factor - 1.0).abs() > 0.1);
}

#[test]
fn parameters_out_of_range_are_refused_by_name() {
    let refused = |description| Bsdf::new(&BsdfDescription::Gltf(Box::new(description))).unwrap_err().to_string();
    assert!(refused(metal_of(1.5, 0.0)).starts_with("roughness = 1.5"));
    assert!(refused(GltfDescription { ior: 0.5, ..matter(0.5) }).starts_with("ior = 0.5"));
    assert!(refused(GltfDescription { ior: 0.0, ..thin(0.5, 0.5) }).starts_with("ior = 0"));
    assert!(refused(GltfDescription { base_color: slot(2.0, 0.0, 0.0, 1.0), ..matter(0.5) }).contains("base_color"));
    assert!(
        refused(GltfDescription { specular_color: slot(f64::NAN, 0.0, 0.0, 1.0), ..matter(0.5) })
            .contains("specular_color")
    );
}

/// No parameters and no directions give NaN, infinities or negative numbers; 200 000 random ones.
#[test]
fn every_answer_is_finite_and_not_negative() {
    let mut rng = random_numbers(37);
    let fine = |x: f64| x.is_finite() && x >= 0.0;
    for _ in 0..200_000 {
        let edge = |rng: &mut Xoshiro256PlusPlus| [0.0, 1.0, 1e-9, rng.random(), rng.random()][rng.random_range(0..5)];
        let any = |rng: &mut Xoshiro256PlusPlus| slot(edge(rng), edge(rng), edge(rng), edge(rng));
        let mut description = GltfDescription {
            base_color: any(&mut rng),
            metallic_roughness: any(&mut rng),
            ior: [1.0, 1.5, 100.0, 1.0 + 1e-9][rng.random_range(0..4)],
            specular: any(&mut rng),
            specular_color: any(&mut rng),
            transmission: any(&mut rng),
            ..GltfDescription::default()
        };
        if rng.random_bool(0.5) {
            description.volume = solid(0.5, 1.0, 1.5).volume;
        }
        if rng.random_bool(0.5) {
            description.clearcoat = Some(GltfCoat { factor: any(&mut rng), roughness: any(&mut rng), normal: None });
        }
        if rng.random_bool(0.3) {
            description.sheen = Some(GltfSheen { color: any(&mut rng), roughness: any(&mut rng) });
        }
        let bsdf = model(description.clone());
        let mut unit = || {
            let cos = [1.0, 1e-9, 1e-4, rng.random(), rng.random()][rng.random_range(0..5)];
            direction(if rng.random_bool(0.5) { cos } else { -cos }, rng.random_range(0.0..6.3))
        };
        let (a, b) = (unit(), unit());
        let sample = bsdf.sample(Side::Sensor, a, rng.random());
        for to in [Some(b), Some(-a), Some(mirrored(a)), sample.map(|s| s.to)].into_iter().flatten() {
            for (from, to) in [(a, to), (to, a)] {
                let (value, density) = (bsdf.eval(from, to), bsdf.density(from, to).value());
                assert!(value.to_array().into_iter().all(fine), "{from} {to}: {value:?} of {description:?}");
                assert!(fine(density), "{from} {to}: {density} of {description:?}");
            }
        }
        if let Some(sample) = sample {
            assert!((sample.to.length() - 1.0).abs() < 1e-12 && sample.to.z != 0.0, "{sample:?}");
            assert!(throughput(&sample).to_array().into_iter().all(fine), "{sample:?} of {description:?}");
        }
    }
}
