//! Textures in every slot, and how they lie.

use std::io::Cursor;
use std::sync::Arc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::{DVec2, DVec3, Vec2};
use image::{ImageFormat, RgbaImage};
use serde_json::{Value, json};

use super::bad_files::glb;
use super::{File, TRIANGLE, assert_refused, assert_unsupported, message, read, read_bytes, read_json};
use crate::scene::description::{BsdfDescription, GltfDescription, NormalSource, SceneDescription, Slot};
use crate::scene::texture::{Bitmap, Filter, Parameter, Texels, Texture, Wrap};

/// Two by two pixels whose channels all differ.
const PIXELS: [[u8; 4]; 4] = [[255, 128, 0, 255], [10, 20, 30, 40], [50, 60, 70, 80], [90, 100, 110, 120]];

fn encoded(format: ImageFormat) -> Vec<u8> {
    let image = RgbaImage::from_raw(2, 2, PIXELS.concat()).unwrap();
    let mut bytes = Cursor::new(Vec::new());
    match format {
        ImageFormat::Jpeg => image::DynamicImage::from(image).into_rgb8().write_to(&mut bytes, format).unwrap(),
        _ => image.write_to(&mut bytes, format).unwrap(),
    }
    bytes.into_inner()
}

fn png_uri() -> String {
    format!("data:image/png;base64,{}", STANDARD.encode(encoded(ImageFormat::Png)))
}

/// A triangle with two sets of texture coordinates and colours, of a material; one texture of one image.
pub(super) fn textured(material: Value) -> Value {
    let mut file = File::default();
    let positions = file.vectors(&TRIANGLE);
    let first = file.vectors(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    let second = file.vectors(&[[0.5, 0.25], [0.5, 0.75], [1.0, 0.25]]);
    let mut json = file.finish_with(json!({
        "attributes": {"POSITION": positions, "TEXCOORD_0": first, "TEXCOORD_1": second}, "material": 0,
    }));
    json["materials"] = json!([material]);
    json["textures"] = json!([{"source": 0}]);
    json["images"] = json!([{"uri": png_uri()}]);
    json
}

fn gltf_of(scene: &SceneDescription) -> &GltfDescription {
    match &scene.materials[0].bsdf {
        BsdfDescription::Gltf(gltf) => gltf,
        other => panic!("{other:?}"),
    }
}

fn layers(material: Value) -> GltfDescription {
    gltf_of(&read_json(&textured(material)).unwrap()).clone()
}

/// The image of a texture that is one.
fn bitmap(texture: Option<&Arc<Texture>>) -> &Bitmap {
    match texture.map(Arc::as_ref) {
        Some(Texture::Bitmap { bitmap, .. }) => bitmap,
        other => panic!("{other:?}"),
    }
}

fn is_raw(slot: &Slot) -> bool {
    match bitmap(slot.texture.as_ref()).texels {
        Texels::Linear8(ref texels) => *texels == PIXELS,
        Texels::Srgb8(ref texels) => {
            assert_eq!(*texels, PIXELS);
            false
        }
        Texels::Float(_) => panic!("eight bits"),
    }
}

#[test]
fn every_slot_has_its_texture_with_the_right_curve() {
    let info = json!({"index": 0});
    let found = layers(json!({
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.5, 0.6, 0.7, 1], "baseColorTexture": info,
            "metallicRoughnessTexture": info, "metallicFactor": 0.25, "roughnessFactor": 0.75,
        },
        "normalTexture": {"index": 0, "scale": 0.5},
        "extensions": {
            "KHR_materials_specular": {"specularTexture": info, "specularColorTexture": info},
            "KHR_materials_transmission": {"transmissionFactor": 0.5, "transmissionTexture": info},
            "KHR_materials_volume": {
                "thicknessFactor": 2, "thicknessTexture": info, "attenuationDistance": 1, "attenuationColor": [1, 0, 0],
            },
            "KHR_materials_clearcoat": {
                "clearcoatFactor": 1, "clearcoatTexture": info, "clearcoatRoughnessTexture": info, "clearcoatNormalTexture": info,
            },
            "KHR_materials_sheen": {
                "sheenColorFactor": [1, 1, 1], "sheenColorTexture": info, "sheenRoughnessTexture": info,
            },
            "KHR_materials_anisotropy": {"anisotropyStrength": 0.5, "anisotropyTexture": info},
        },
    }));
    assert_eq!(found.base_color.factor, [0.5, 0.6, 0.7, 1.0]);
    assert_eq!(found.metallic_roughness.factor, [1.0, 0.75, 0.25, 1.0]);
    let (coat, sheen) = (found.clearcoat.unwrap(), found.sheen.unwrap());
    let volume = found.volume.unwrap();
    for (name, slot, raw) in [
        ("baseColor", &found.base_color, false),
        ("metallicRoughness", &found.metallic_roughness, true),
        ("specular", &found.specular, true),
        ("specularColor", &found.specular_color, false),
        ("transmission", &found.transmission, true),
        ("thickness", &volume.thickness, true),
        ("clearcoat", &coat.factor, true),
        ("clearcoatRoughness", &coat.roughness, true),
        ("sheenColor", &sheen.color, false),
        ("sheenRoughness", &sheen.roughness, true),
    ] {
        assert_eq!(is_raw(slot), raw, "{name}");
    }
    for normal in [found.normal.unwrap(), coat.normal.unwrap()] {
        let NormalSource::Map { texture, .. } = normal else { panic!() };
        assert!(matches!(bitmap(Some(&texture)).texels, Texels::Linear8(_)));
    }
    assert!(matches!(bitmap(found.anisotropy.unwrap().texture.as_ref()).texels, Texels::Linear8(_)));
}

#[test]
fn emission_has_a_texture() {
    let material = json!({
        "emissiveFactor": [1, 0.5, 0.25], "emissiveTexture": {"index": 0},
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 8}},
    });
    let scene = read_json(&textured(material)).unwrap();
    let Parameter::Texture(texture) = &scene.materials[0].emission else { panic!() };
    let Texture::Product(factors) = &**texture else { panic!() };
    assert!(factors.contains(&Texture::Constant([8.0, 4.0, 2.0, 1.0])));
    // Black emits nothing, and its image need not be there.
    let mut json = textured(json!({"emissiveTexture": {"index": 0}, "occlusionTexture": {"index": 0}}));
    json["images"] = json!([{"uri": "none.png"}]);
    let scene = read_json(&json).unwrap();
    assert!(!scene.materials[0].emits());
    assert!(scene.warnings.iter().any(|warning| warning.contains("occlusion")), "{:?}", scene.warnings);
}

#[test]
fn samplers_say_how_images_go_on() {
    let mut json = textured(json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}));
    let of = |json: &Value| {
        let scene = read_json(json).unwrap();
        let bitmap = bitmap(gltf_of(&scene).base_color.texture.as_ref());
        ((bitmap.filter, bitmap.wrap), scene.warnings.iter().filter(|warning| warning.contains("mipmaps")).count())
    };
    assert_eq!(of(&json), ((Filter::Bilinear, [Wrap::Repeat; 2]), 0));
    json["textures"] = json!([{"source": 0, "sampler": 0}]);
    json["samplers"] = json!([{"magFilter": 9728, "minFilter": 9987, "wrapS": 33071, "wrapT": 33648}]);
    assert_eq!(of(&json), ((Filter::Nearest, [Wrap::Clamp, Wrap::Mirror]), 1));
    for (key, value) in [("wrapS", 1), ("magFilter", 2)] {
        let mut json = json.clone();
        json["samplers"][0][key] = json!(value);
        // The crate knows the modes, too.
        message(read_json(&json));
    }
}

#[test]
fn transforms_scale_then_turn_then_move() {
    let transform = |transform: Value| {
        let info = json!({"index": 0, "extensions": {"KHR_texture_transform": transform}});
        let found = layers(json!({"pbrMetallicRoughness": {"baseColorTexture": info}}));
        match found.base_color.texture.as_deref() {
            Some(Texture::Bitmap { to_uv, .. }) => *to_uv,
            other => panic!("{other:?}"),
        }
    };
    // The extension's own example: the lower left quarter, turned clockwise by 90°.
    let quarter = transform(json!({"offset": [0, 1], "rotation": std::f64::consts::FRAC_PI_2, "scale": [0.5, 0.5]}));
    for (uv, expected) in [([0.0, 0.0], [0.0, 1.0]), ([1.0, 0.0], [0.0, 0.5]), ([0.0, 1.0], [0.5, 1.0])] {
        let found = quarter.transform_point2(DVec2::from(uv));
        assert!((found - DVec2::from(expected)).length() < 1e-12, "{uv:?}: {found}");
    }
    let stretched = transform(json!({"scale": [2, 3]}));
    assert_eq!(stretched.transform_point2(DVec2::new(0.5, 0.5)), DVec2::new(1.0, 1.5));
    for wrong in [json!({"offset": [0]}), json!({"rotation": "much"}), json!({"scale": [1, "a"]})] {
        let info = json!({"index": 0, "extensions": {"KHR_texture_transform": wrong}});
        assert_refused(&textured(json!({"normalTexture": info})), &["KHR_texture_transform", "normalTexture"]);
    }
}

#[test]
fn tangents_follow_the_normal_maps_set_and_other_sets_are_attributes() {
    let material = json!({
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
        "normalTexture": {"index": 0, "texCoord": 1},
    });
    let scene = read_json(&textured(material)).unwrap();
    let mesh = &scene.meshes[0];
    assert_eq!(mesh.texcoords.as_ref().unwrap()[0], Vec2::new(0.5, 0.25));
    assert_eq!(mesh.attributes[0].name, "vertex_texcoord_0");
    assert_eq!(mesh.attributes[0].value(1), [1.0, 0.0, 0.0]);
    let texture = gltf_of(&scene).base_color.texture.as_deref();
    assert!(matches!(texture, Some(Texture::OtherCoordinates { attribute, .. }) if attribute == "vertex_texcoord_0"));
    // An extension may name another set.
    let info = json!({"index": 0, "extensions": {"KHR_texture_transform": {"texCoord": 1}}});
    let scene = read_json(&textured(json!({"pbrMetallicRoughness": {"baseColorTexture": info}}))).unwrap();
    assert_eq!(scene.meshes[0].texcoords.as_ref().unwrap()[0], Vec2::new(0.5, 0.25));
    assert!(scene.meshes[0].attributes.is_empty());
    // None is there.
    let info = json!({"index": 0, "texCoord": 3});
    let scene = read_json(&textured(json!({"pbrMetallicRoughness": {"baseColorTexture": info}}))).unwrap();
    assert_eq!(scene.meshes[0].texcoords.as_ref().unwrap()[2], Vec2::ZERO);
    assert!(scene.warnings.iter().any(|warning| warning.contains("without the texture coordinates")));
}

#[test]
fn colours_of_vertices_multiply_the_base_colour() {
    for (colours, channels) in [(json!("VEC4"), 4), (json!("VEC3"), 3)] {
        let mut file = File::default();
        let positions = file.vectors(&TRIANGLE);
        let view = file.view(&[255, 0, 128, 255, 255, 255, 255, 255, 0, 51, 102, 153], Some(4));
        let colours = file.accessor(json!({
            "bufferView": view, "componentType": super::U8, "count": 3, "type": colours, "normalized": true,
        }));
        let scene =
            read_json(&file.finish_with(json!({"attributes": {"POSITION": positions, "COLOR_0": colours}}))).unwrap();
        let attribute = &scene.meshes[0].attributes[0];
        assert_eq!((attribute.name.as_str(), attribute.channels), ("vertex_color_0", channels));
        assert_eq!(attribute.value(2)[..3], [0.0, 0.2, 0.4]);
        let texture = gltf_of(&scene).base_color.texture.as_deref();
        assert_eq!(texture, Some(&Texture::Attribute { name: "vertex_color_0".into() }));
    }
    // White ones are none.
    let mut file = File::default();
    let positions = file.vectors(&TRIANGLE);
    let colours = file.vectors(&[[1.0; 4]; 3]);
    let scene =
        read_json(&file.finish_with(json!({"attributes": {"POSITION": positions, "COLOR_0": colours}}))).unwrap();
    assert!(scene.meshes[0].attributes.is_empty() && gltf_of(&scene).base_color.texture.is_none());
    let mut file = File::default();
    let positions = file.vectors(&TRIANGLE);
    let colours = file.vectors(&[[0.5; 4]; 2]);
    assert_refused(
        &file.finish_with(json!({"attributes": {"POSITION": positions, "COLOR_0": colours}})),
        &["COLOR_0", "2 values for 3"],
    );
}

#[test]
fn alpha_of_a_texture_is_a_mask() {
    let of = |mode: &str, alpha: f64| {
        let surface = json!({"baseColorTexture": {"index": 0}, "baseColorFactor": [1, 1, 1, alpha]});
        let scene =
            read_json(&textured(json!({"alphaMode": mode, "alphaCutoff": 0.25, "pbrMetallicRoughness": surface})))
                .unwrap();
        match scene.materials[0].bsdf.clone() {
            BsdfDescription::Mask { opacity: Parameter::Texture(texture), .. } => Some((*texture).clone()),
            _ => None,
        }
    };
    assert_eq!(of("OPAQUE", 1.0), None);
    assert!(matches!(of("BLEND", 1.0), Some(Texture::Channel { channel: 3, .. })));
    assert!(matches!(of("BLEND", 0.5), Some(Texture::Remapped { scale, .. }) if scale == 0.5));
    assert!(matches!(of("MASK", 1.0), Some(Texture::Step { threshold, .. }) if threshold == 0.25));
}

#[test]
fn mirrored_images_need_green_against_v() {
    let of = |flipped: bool| {
        let mut file = File::default();
        let positions = file.vectors(&TRIANGLE);
        // Upright, as images lie: v grows downwards.
        let uv = if flipped { [[1.0, 1.0], [0.0, 1.0], [1.0, 0.0]] } else { [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]] };
        let first = file.vectors(&uv);
        let mut json =
            file.finish_with(json!({"attributes": {"POSITION": positions, "TEXCOORD_0": first}, "material": 0}));
        json["materials"] = json!([{"normalTexture": {"index": 0, "scale": 2}}]);
        json["textures"] = json!([{"source": 0}]);
        json["images"] = json!([{"uri": png_uri()}]);
        match gltf_of(&read_json(&json).unwrap()).normal.clone() {
            Some(NormalSource::Map { scale, against_v, .. }) => (scale, against_v),
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(of(false), ([2.0; 2], false));
    assert_eq!(of(true), ([2.0; 2], true));
}

#[test]
fn images_are_files_data_or_views() {
    let material = json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}});
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("outside.png"), encoded(ImageFormat::Png)).unwrap();
    let inside = folder.path().join("scene");
    std::fs::create_dir_all(&inside).unwrap();
    std::fs::write(inside.join("a b.png"), encoded(ImageFormat::Png)).unwrap();
    std::fs::write(inside.join("b.jpg"), encoded(ImageFormat::Jpeg)).unwrap();
    std::fs::write(inside.join("c.png"), b"no image").unwrap();
    let path = inside.join("scene.gltf");
    let with = |image: Value| {
        let mut json = textured(material.clone());
        json["images"] = json!([image]);
        std::fs::write(&path, json.to_string()).unwrap();
        read(&path)
    };
    for uri in ["a%20b.png", "b.jpg"] {
        let scene = with(json!({"uri": uri})).unwrap();
        let bitmap = bitmap(gltf_of(&scene).base_color.texture.as_ref());
        assert_eq!((bitmap.width, bitmap.height, bitmap.name.as_str()), (2, 2, uri));
    }
    for (image, words) in [
        (json!({"uri": "../outside.png"}), "leads out of the scene's folder"),
        (json!({"uri": "none.png"}), "images[0]: none.png cannot be read"),
        (json!({"uri": "c.png"}), "images[0]: is no image that can be read"),
        (json!({"uri": "https://example.org/a.png"}), "https: addresses are not supported"),
        (json!({"uri": "data:image/png;base64,AA*A"}), "base64 is broken"),
        (json!({"bufferView": 99, "mimeType": "image/png"}), "bufferViews[99] does not exist"),
        (json!({"name": "empty"}), "images[0] \"empty\": has neither"),
    ] {
        let text = message(with(image));
        assert!(text.contains(words), "{words:?} is not in {text}");
    }
    let mut json = textured(material.clone());
    json["textures"] = json!([{}]);
    assert_unsupported(&json, &["textures[0]", "PNG or JPEG"]);
    // In the binary chunk of a .glb.
    let mut json = textured(material);
    let image = encoded(ImageFormat::Png);
    let uri = json["buffers"][0]["uri"].as_str().unwrap().split_once(',').unwrap().1.to_owned();
    let mut bytes = STANDARD.decode(uri).unwrap();
    let offset = bytes.len();
    bytes.extend(&image);
    json["buffers"] = json!([{"byteLength": bytes.len()}]);
    let views = json["bufferViews"].as_array_mut().unwrap();
    views.push(json!({"buffer": 0, "byteOffset": offset, "byteLength": image.len()}));
    json["images"] = json!([{"bufferView": views.len() - 1, "mimeType": "image/png"}]);
    let scene = read_bytes("a.glb", &glb(json.to_string().as_bytes(), Some(&bytes))).unwrap();
    assert!(!is_raw(&gltf_of(&scene).base_color));
    assert_eq!(scene.meshes[0].positions[1], DVec3::X);
}
