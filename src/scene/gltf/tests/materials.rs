use serde_json::{Value, json};

use super::{assert_refused, assert_unsupported, read_json, triangle};
use crate::scene::description::{BsdfDescription, ConductorFresnel, Material};
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

fn tint(r: f64, g: f64, b: f64) -> ConductorFresnel {
    ConductorFresnel::Tint { specular_tint: Rgb::new(r, g, b) }
}

#[test]
fn rough_non_metals_are_diffuse_without_a_warning() {
    let (material, warnings) = read(
        json!({"name": "red", "pbrMetallicRoughness": {"baseColorFactor": [0.6, 0.1, 0.2, 1], "metallicFactor": 0}}),
    );
    assert_eq!(material.bsdf, BsdfDescription::Diffuse { reflectance: Rgb::new(0.6, 0.1, 0.2).into() });
    assert_eq!(
        (material.name.as_str(), material.two_sided, material.emission, warnings),
        ("red", false, Rgb::BLACK.into(), 0)
    );
    let (_, warnings) = read(json!({"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0.5}}));
    assert_eq!(warnings, 1);
}

#[test]
fn metals_are_tinted_conductors() {
    let metal = |roughness: f64| {
        let factors = json!({"baseColorFactor": [0.9, 0.8, 0.7, 1], "roughnessFactor": roughness});
        read(json!({"pbrMetallicRoughness": factors})).0.bsdf
    };
    assert_eq!(metal(0.5), BsdfDescription::rough_conductor(0.25, tint(0.9, 0.8, 0.7)));
    assert_eq!(metal(0.009), BsdfDescription::conductor(tint(0.9, 0.8, 0.7)));
}

#[test]
fn without_a_material_the_default_one_is_taken() {
    let scene = read_json(&triangle()).unwrap();
    assert_eq!(scene.materials[0].bsdf, BsdfDescription::rough_conductor(1.0, tint(1.0, 1.0, 1.0)));
    assert!(scene.warnings.is_empty());
}

#[test]
fn transmission_makes_a_dielectric() {
    let glass = |roughness: f64, ior: Value| {
        let factors = json!({"metallicFactor": 0, "roughnessFactor": roughness});
        let extensions = json!({"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": ior});
        read(json!({"pbrMetallicRoughness": factors, "extensions": extensions})).0.bsdf
    };
    assert_eq!(glass(0.0, json!({})), BsdfDescription::dielectric(1.5, 1.0));
    let rough = BsdfDescription::rough_dielectric(0.25, 1.3, 1.0);
    assert_eq!(glass(0.5, json!({"ior": 1.3})), rough);
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
fn textures_are_refused_by_slot() {
    let info = json!({"index": 0});
    for (slot, material) in [
        ("baseColorTexture", json!({"pbrMetallicRoughness": {"baseColorTexture": info}})),
        ("metallicRoughnessTexture", json!({"pbrMetallicRoughness": {"metallicRoughnessTexture": info}})),
        ("normalTexture", json!({"normalTexture": info})),
        ("emissiveTexture", json!({"emissiveTexture": info, "emissiveFactor": [1, 1, 1]})),
    ] {
        let mut json = with_material(material);
        json["textures"] = json!([{"source": 0}]);
        json["images"] = json!([{"uri": "a.png"}]);
        assert_unsupported(&json, &["textures are not supported yet", slot, "materials[0]"]);
        // Nobody sees a material that nothing is made of.
        json["meshes"][0]["primitives"][0].as_object_mut().unwrap().remove("material");
        assert!(read_json(&json).is_ok(), "{slot}");
    }
    let mut json = with_material(json!({"occlusionTexture": info, "emissiveTexture": info}));
    json["textures"] = json!([{"source": 0}]);
    json["images"] = json!([{"uri": "a.png"}]);
    assert!(read_json(&json).is_ok());
}

#[test]
fn what_would_change_the_picture_is_refused_by_name() {
    for (name, on, off) in [
        ("KHR_materials_clearcoat", json!({"clearcoatFactor": 0.5}), json!({"clearcoatFactor": 0})),
        ("KHR_materials_sheen", json!({"sheenColorFactor": [0, 0.1, 0]}), json!({"sheenColorFactor": [0, 0, 0]})),
        ("KHR_materials_anisotropy", json!({"anisotropyStrength": 0.5}), json!({})),
        ("KHR_materials_iridescence", json!({"iridescenceFactor": 1}), json!({})),
        (
            "KHR_materials_volume",
            json!({"attenuationDistance": 1, "attenuationColor": [1, 0, 0]}),
            json!({"thicknessFactor": 1}),
        ),
    ] {
        let material = |extension: Value| json!({"extensions": {name: extension, "KHR_materials_transmission": {"transmissionFactor": 1}}});
        assert_unsupported(&with_material(material(on)), &[name]);
        assert!(read_json(&with_material(material(off))).is_ok(), "{name}");
    }
    assert_unsupported(&with_material(json!({"extensions": {"KHR_materials_unlit": {}}})), &["KHR_materials_unlit"]);
}

#[test]
fn transparency_by_alpha_is_refused_where_it_shows() {
    let with_alpha = |mode: &str, alpha: f64| {
        let factors = json!({"baseColorFactor": [1, 1, 1, alpha]});
        with_material(json!({"alphaMode": mode, "pbrMetallicRoughness": factors}))
    };
    assert_unsupported(&with_alpha("BLEND", 0.5), &["alpha", "materials[0]"]);
    assert_unsupported(&with_alpha("MASK", 0.4), &["alpha"]);
    assert!(read_json(&with_alpha("MASK", 0.6)).is_ok());
    assert!(read_json(&with_alpha("BLEND", 1.0)).is_ok());
    assert!(read_json(&with_alpha("OPAQUE", 0.5)).is_ok());
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
    assert_refused(&with_material(json!({"emissiveFactor": [-1, 0, 0]})), &["emissiveFactor"]);
}
