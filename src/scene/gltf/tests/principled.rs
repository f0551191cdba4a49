//! glTF's materials as Mitsuba's principled model, and their export.

use serde_json::{Value, json};

use super::textures::textured;
use crate::scene::description::{BsdfDescription, FilmSize, PrincipledDescription, SceneDescription};
use crate::scene::gltf::{MaterialModel, ReadOptions, read_with};
use crate::scene::mitsuba::{ExportOptions, export};
use crate::scene::texture::{Parameter, Texture};
use crate::spectrum::Rgb;

fn read(json: &Value, materials: MaterialModel) -> SceneDescription {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("file.gltf");
    std::fs::write(&path, json.to_string()).unwrap();
    read_with(&path, &ReadOptions { materials, ..ReadOptions::default() }).unwrap()
}

fn principled(material: Value) -> (PrincipledDescription, Vec<String>) {
    let scene = read(&textured(material), MaterialModel::Principled);
    match &scene.materials[0].bsdf {
        BsdfDescription::Principled(principled) => ((**principled).clone(), scene.warnings),
        other => panic!("{other:?}"),
    }
}

#[test]
fn what_both_models_have_is_the_same() {
    let (found, warnings) = principled(json!({
        "pbrMetallicRoughness": {"baseColorFactor": [0.9, 0.8, 0.7, 1], "roughnessFactor": 0.4, "metallicFactor": 0.25},
        "extensions": {"KHR_materials_ior": {"ior": 1.3}},
    }));
    let expected = PrincipledDescription {
        base_color: Rgb::new(0.9, 0.8, 0.7).into(),
        roughness: 0.4.into(),
        metallic: 0.25.into(),
        eta: 1.3,
        ..PrincipledDescription::default()
    };
    assert_eq!((found, warnings), (expected, Vec::new()));
}

#[test]
fn what_it_loses_is_told() {
    let (found, warnings) = principled(json!({
        "name": "all", "pbrMetallicRoughness": {"metallicFactor": 0},
        "extensions": {
            "KHR_materials_transmission": {"transmissionFactor": 0.5},
            "KHR_materials_specular": {"specularFactor": 0.5},
            "KHR_materials_clearcoat": {"clearcoatFactor": 0.7, "clearcoatRoughnessFactor": 0.2},
            "KHR_materials_sheen": {"sheenColorFactor": [1, 0, 0]},
        },
    }));
    assert_eq!((found.spec_trans, found.clearcoat, found.sheen_tint), (0.5.into(), 0.7.into(), 1.0.into()));
    assert!((found.clearcoat_gloss.constant().unwrap() - 0.06 / 0.099).abs() < 1e-12);
    for words in ["thin walls", "KHR_materials_specular", "clearcoat", "sheen"] {
        let told = warnings.iter().any(|warning| warning.contains(words) && warning.contains("all"));
        assert!(told, "{words}: {warnings:?}");
    }
}

/// α along both axes is as glTF has it, up to the limit of Mitsuba's aspect.
#[test]
fn anisotropy_keeps_both_roughnesses() {
    let (found, _) = principled(json!({
        "pbrMetallicRoughness": {"roughnessFactor": 0.7},
        "extensions": {"KHR_materials_anisotropy": {"anisotropyStrength": 0.5}},
    }));
    let (roughness, anisotropic) = (found.roughness.constant().unwrap(), found.anisotropic.constant().unwrap());
    let aspect = (1.0 - 0.9 * anisotropic).sqrt();
    let alpha = 0.49;
    assert!((roughness * roughness / aspect - (alpha + (1.0 - alpha) * 0.25)).abs() < 1e-12);
    assert!((roughness * roughness * aspect - alpha).abs() < 1e-12);
}

#[test]
fn textures_are_channels_times_factors() {
    let (found, _) = principled(json!({
        "pbrMetallicRoughness": {
            "baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 0}, "roughnessFactor": 0.5,
        },
    }));
    assert!(matches!(found.base_color.texture(), Some(Texture::Bitmap { .. })));
    assert!(matches!(found.metallic.texture(), Some(Texture::Channel { channel: 2, .. })));
    let Some(Texture::Remapped { of, scale, .. }) = found.roughness.texture() else { panic!() };
    assert!(*scale == 0.5 && matches!(**of, Texture::Channel { channel: 1, .. }));
}

#[test]
fn only_principled_can_be_exported() {
    let json = textured(json!({
        "pbrMetallicRoughness": {
            "baseColorTexture": {"index": 0}, "baseColorFactor": [0.5, 1, 1, 1],
            "metallicRoughnessTexture": {"index": 0}, "roughnessFactor": 0.5,
        },
        "emissiveFactor": [1, 1, 1],
    }));
    let folder = tempfile::tempdir().unwrap();
    let options = ExportOptions { film: FilmSize { width: 8, height: 8 }, ..ExportOptions::default() };
    let scene = |materials| {
        let mut scene = read(&json, materials);
        scene.sensor = scene.framing_camera();
        scene
    };
    let refused = export(&scene(MaterialModel::Gltf), &options, folder.path()).unwrap_err().to_string();
    assert!(refused.contains("--materials principled"), "{refused}");
    let file = export(&scene(MaterialModel::Principled), &options, folder.path()).unwrap();
    let xml = std::fs::read_to_string(file).unwrap();
    assert!(xml.contains("principled") && xml.contains("base_color") && xml.contains("textures/"), "{xml}");
}

#[test]
fn matt_materials_are_lamberts_in_both() {
    let material = json!({"pbrMetallicRoughness": {"metallicFactor": 0}, "extensions": {"KHR_materials_specular": {"specularFactor": 0}}});
    for model in [MaterialModel::Gltf, MaterialModel::Principled] {
        let scene = read(&textured(material.clone()), model);
        assert_eq!(scene.materials[0].bsdf, BsdfDescription::Diffuse { reflectance: Parameter::Constant(Rgb::WHITE) });
    }
}
