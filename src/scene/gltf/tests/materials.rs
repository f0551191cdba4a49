use serde_json::{Value, json};

use super::{assert_refused, assert_unsupported, read_json, triangle};
use crate::scene::description::{
    BsdfDescription, ConductorFresnel, GltfAnisotropy, GltfCoat, GltfDescription, GltfSheen, Material, Slot,
};
use crate::spectrum::Rgb;

fn with_material(material: Value) -> Value {
    let mut json = triangle();
    json["materials"] = json!([material]);
    json["meshes"][0]["primitives"][0]["material"] = json!(0);
    json
}

/// The material and the number of warnings.
fn read(material: Value) -> (Material, usize) {
    let scene = read_json(&with_material(material)).unwrap();
    (scene.materials[0].clone(), scene.warnings.len())
}

fn layers(material: Value) -> GltfDescription {
    match read(material).0.bsdf {
        BsdfDescription::Gltf(gltf) => *gltf,
        other => panic!("{other:?}"),
    }
}

fn constant(r: f64, g: f64, b: f64, a: f64) -> Slot {
    Slot::constant([r, g, b, a])
}

#[test]
fn non_metals_without_a_specular_layer_are_lamberts() {
    let (material, warnings) = read(json!({
        "name": "red", "pbrMetallicRoughness": {"baseColorFactor": [0.6, 0.1, 0.2, 1], "metallicFactor": 0},
        "extensions": {"KHR_materials_specular": {"specularFactor": 0}},
    }));
    assert_eq!(material.bsdf, BsdfDescription::Diffuse { reflectance: Rgb::new(0.6, 0.1, 0.2).into() });
    assert_eq!(
        (material.name.as_str(), material.two_sided, material.emission, warnings),
        ("red", false, Rgb::BLACK.into(), 0)
    );
}

#[test]
fn factors_are_those_of_gltfs_own_model() {
    let factors = json!({"baseColorFactor": [0.9, 0.8, 0.7, 1], "roughnessFactor": 0.5, "metallicFactor": 0.25});
    let found = layers(json!({"pbrMetallicRoughness": factors}));
    let expected = GltfDescription {
        base_color: constant(0.9, 0.8, 0.7, 1.0),
        metallic_roughness: constant(1.0, 0.5, 0.25, 1.0),
        ..GltfDescription::default()
    };
    assert_eq!(found, expected);
}

#[test]
fn without_a_material_the_default_one_is_taken() {
    let scene = read_json(&triangle()).unwrap();
    assert_eq!(scene.materials[0].bsdf, BsdfDescription::Gltf(Box::default()));
    assert!(scene.warnings.is_empty());
}

#[test]
fn each_extension_is_a_layer() {
    let with =
        |extensions: Value| layers(json!({"pbrMetallicRoughness": {"metallicFactor": 0}, "extensions": extensions}));
    let found = with(json!({"KHR_materials_ior": {"ior": 1.3}, "KHR_materials_specular": {
        "specularFactor": 0.5, "specularColorFactor": [2, 1, 0.5],
    }}));
    assert_eq!(
        (found.ior, found.specular, found.specular_color),
        (1.3, constant(1.0, 1.0, 1.0, 0.5), constant(2.0, 1.0, 0.5, 1.0))
    );
    let found = with(json!({"KHR_materials_transmission": {"transmissionFactor": 0.6}}));
    assert_eq!((found.transmission, found.volume), (constant(0.6, 1.0, 1.0, 1.0), None));
    let volume = |volume: Value| {
        with(json!({"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_volume": volume})).volume
    };
    assert_eq!(volume(json!({"thicknessFactor": 0, "attenuationDistance": 1, "attenuationColor": [1, 0, 0]})), None);
    let found =
        volume(json!({"thicknessFactor": 2, "attenuationDistance": 3, "attenuationColor": [1, 0.5, 0.25]})).unwrap();
    assert_eq!((found.thickness.factor[1], found.attenuation_distance), (2.0, 3.0));
    assert_eq!(found.attenuation_color, Rgb::new(1.0, 0.5, 0.25));
    assert_eq!(with(json!({"KHR_materials_volume": {"thicknessFactor": 2}})).volume, None);
    let found = with(json!({"KHR_materials_clearcoat": {"clearcoatFactor": 0.7, "clearcoatRoughnessFactor": 0.3}}));
    let expected =
        GltfCoat { factor: constant(0.7, 1.0, 1.0, 1.0), roughness: constant(1.0, 0.3, 1.0, 1.0), normal: None };
    assert_eq!(found.clearcoat, Some(expected));
    let found =
        with(json!({"KHR_materials_sheen": {"sheenColorFactor": [0.1, 0.2, 0.3], "sheenRoughnessFactor": 0.4}}));
    let expected = GltfSheen { color: constant(0.1, 0.2, 0.3, 1.0), roughness: constant(1.0, 1.0, 1.0, 0.4) };
    assert_eq!(found.sheen, Some(expected));
    let found = with(json!({"KHR_materials_anisotropy": {"anisotropyStrength": 0.5, "anisotropyRotation": 1.25}}));
    assert_eq!(found.anisotropy, Some(GltfAnisotropy { strength: 0.5, rotation: 1.25, texture: None }));
    let off = with(json!({
        "KHR_materials_clearcoat": {"clearcoatFactor": 0}, "KHR_materials_sheen": {}, "KHR_materials_anisotropy": {},
    }));
    assert_eq!((off.clearcoat, off.sheen, off.anisotropy), (None, None, None));
}

#[test]
fn unlit_materials_emit_their_colour() {
    let (material, warnings) = read(json!({
        "pbrMetallicRoughness": {"baseColorFactor": [0.9, 0.8, 0.7, 1]}, "extensions": {"KHR_materials_unlit": {}},
    }));
    assert_eq!(material.bsdf, BsdfDescription::Diffuse { reflectance: Rgb::BLACK.into() });
    assert_eq!((material.emission, warnings), (Rgb::new(0.9, 0.8, 0.7).into(), 1));
}

#[test]
fn emission_is_factor_times_strength() {
    let (material, warnings) = read(json!({
        "emissiveFactor": [1, 0.5, 0.25], "doubleSided": true,
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 8}},
    }));
    assert_eq!(material.emission, Rgb::new(8.0, 4.0, 2.0).into());
    assert!(material.two_sided);
    assert_eq!(warnings, 1);
}

#[test]
fn what_would_change_the_picture_is_refused_by_name() {
    for (name, on, off) in [
        ("KHR_materials_iridescence", json!({"iridescenceFactor": 1}), json!({})),
        ("KHR_materials_diffuse_transmission", json!({"diffuseTransmissionFactor": 0.5}), json!({})),
        ("KHR_materials_dispersion", json!({"dispersion": 0.5}), json!({"dispersion": 0})),
    ] {
        let material = |extension: Value| {
            json!({"pbrMetallicRoughness": {"metallicFactor": 0}, "extensions": {
                name: extension, "KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_volume": {"thicknessFactor": 1},
            }})
        };
        assert_unsupported(&with_material(material(on)), &[name]);
        assert!(read_json(&with_material(material(off))).is_ok(), "{name}");
    }
    let old = json!({"extensions": {"KHR_materials_pbrSpecularGlossiness": {}}});
    assert_unsupported(&with_material(old), &["KHR_materials_pbrSpecularGlossiness"]);
}

#[test]
fn alpha_is_a_mask() {
    let with_alpha = |mode: &str, alpha: f64| {
        let factors = json!({"baseColorFactor": [1, 1, 1, alpha]});
        read(json!({"alphaMode": mode, "pbrMetallicRoughness": factors})).0.bsdf
    };
    let opacity = |bsdf| match bsdf {
        BsdfDescription::Mask { opacity, .. } => opacity.constant().copied(),
        _ => Some(1.0),
    };
    assert_eq!(opacity(with_alpha("BLEND", 0.4)), Some(0.4));
    assert_eq!(opacity(with_alpha("MASK", 0.4)), Some(0.0));
    for (mode, alpha) in [("MASK", 0.6), ("BLEND", 1.0), ("OPAQUE", 0.5)] {
        assert_eq!(opacity(with_alpha(mode, alpha)), Some(1.0), "{mode}");
    }
    // Each side of what is double-sided is as the other, below the mask too.
    let both =
        json!({"alphaMode": "BLEND", "doubleSided": true, "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.5]}});
    let BsdfDescription::Mask { nested, .. } = read(both).0.bsdf else { panic!() };
    assert!(matches!(*nested, BsdfDescription::TwoSided { .. }));
}

#[test]
fn exact_models_in_extras_replace_gltfs() {
    let (material, warnings) = read(json!({
        "alphaMode": "BLEND", "doubleSided": true, "emissiveFactor": [1, 1, 1],
        "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.2]},
        "extras": {"pathspace": {
            "bsdf": {"type": "rough_conductor", "alpha": 0.1, "fresnel": {"eta": [0.2, 0.9, 1.1], "k": [3.9, 2.4, 2.2]}},
            "emission": [0, 0, 0], "two_sided": false,
        }},
    }));
    let fresnel = ConductorFresnel::Ior { eta: Rgb::new(0.2, 0.9, 1.1), k: Rgb::new(3.9, 2.4, 2.2) };
    assert_eq!(material.bsdf, BsdfDescription::rough_conductor(0.1, fresnel));
    assert_eq!((material.emission, material.two_sided, warnings), (Rgb::BLACK.into(), false, 0));
}

#[test]
fn factors_out_of_range_are_refused() {
    assert_refused(&with_material(json!({"pbrMetallicRoughness": {"roughnessFactor": 2}})), &["roughnessFactor"]);
    assert_refused(
        &with_material(json!({"pbrMetallicRoughness": {"baseColorFactor": [2, 0, 0, 1]}})),
        &["baseColorFactor"],
    );
    for (extension, key) in [
        ("KHR_materials_clearcoat", "clearcoatFactor"),
        ("KHR_materials_transmission", "transmissionFactor"),
        ("KHR_materials_anisotropy", "anisotropyStrength"),
        ("KHR_materials_specular", "specularFactor"),
    ] {
        assert_refused(&with_material(json!({"extensions": {extension: {key: 1.5}}})), &[extension, key, "1.5"]);
    }
    let much = json!({"extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": "much"}}});
    assert_refused(&with_material(much), &["KHR_materials_clearcoat", "clearcoatFactor", "is no number"]);
    assert_refused(&with_material(json!({"extensions": {"KHR_materials_ior": {"ior": 0.5}}})), &["ior", "0.5"]);
    assert_refused(&with_material(json!({"emissiveFactor": [-1, 0, 0]})), &["emissiveFactor"]);
}
