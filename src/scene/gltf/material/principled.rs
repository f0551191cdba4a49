//! glTF's material as Mitsuba's `principled`.

use std::sync::Arc;

use crate::scene::description::{GltfDescription, PrincipledDescription, Slot};
use crate::scene::texture::{Parameter, Texture};

/// The nearest `principled`, and what of the material it cannot say.
///
/// Base colour, roughness and metallic are the same; transmission is `spec_trans`. The coat's roughness r becomes the gloss
/// whose α = 0.1 + (0.001 − 0.1) gloss is r²; of sheen the luminance and whether it is tinted; anisotropy becomes the aspect
/// √(1 − 0.9 a) that has the same ratio of α along both axes where it is textured in no way.
pub(super) fn from_gltf(gltf: &GltfDescription) -> (PrincipledDescription, Vec<&'static str>) {
    let mut lost = Vec::new();
    let base_color = super::colour(&gltf.base_color);
    let mut principled = PrincipledDescription {
        base_color,
        roughness: channel(&gltf.metallic_roughness, 1),
        metallic: channel(&gltf.metallic_roughness, 2),
        spec_trans: channel(&gltf.transmission, 0),
        eta: if gltf.ior >= 1.0 { gltf.ior.max(1.0 + 1e-4) } else { 1.5 },
        ..PrincipledDescription::default()
    };
    if gltf.ior < 1.0 {
        lost.push("an index of refraction of infinity (1.5 is taken)");
    }
    let ones =
        |slot: &Slot, channels: &[usize]| slot.texture.is_none() && channels.iter().all(|&i| slot.factor[i] == 1.0);
    if !(ones(&gltf.specular, &[3]) && ones(&gltf.specular_color, &[0, 1, 2])) {
        lost.push("KHR_materials_specular");
    }
    match &gltf.volume {
        None if gltf.transmits() => lost.push("thin walls: what transmits is solid"),
        Some(volume) if volume.attenuation_distance.is_finite() => lost.push("absorption (KHR_materials_volume)"),
        _ => {}
    }
    if let Some(coat) = &gltf.clearcoat {
        principled.clearcoat = channel(&coat.factor, 0);
        principled.clearcoat_gloss = gloss(&coat.roughness);
        if coat.normal.is_some() {
            lost.push("clearcoatNormalTexture");
        }
        lost.push("the strength of clearcoat: Mitsuba's is a quarter of it, and of another distribution");
    }
    if let Some(sheen) = &gltf.sheen {
        let [r, g, b, _] = sheen.color.factor;
        let luminance = crate::spectrum::Rgb::new(r, g, b).luminance();
        principled.sheen = luminance.into();
        let grey = r == g && g == b;
        principled.sheen_tint = if grey { 0.0 } else { 1.0 }.into();
        lost.push("colour, textures and roughness of sheen");
    }
    if let Some(anisotropy) = &gltf.anisotropy {
        lost.push("direction and textures of anisotropy");
        if let Some(roughness) = principled.roughness.constant().filter(|_| anisotropy.texture.is_none()) {
            let (along, ratio) = axes(*roughness, anisotropy.strength);
            principled.roughness = along.into();
            principled.anisotropic = ratio.into();
        }
    }
    (principled, lost)
}

/// Mitsuba's roughness and `anisotropic` for glTF's: α_u = r²/aspect and α_v = r² aspect with aspect = √(1 − 0.9 anisotropic).
fn axes(roughness: f64, strength: f64) -> (f64, f64) {
    let alpha = (roughness * roughness).max(1e-4);
    let along = alpha + (1.0 - alpha) * strength * strength;
    let aspect = (alpha / along).sqrt().max(0.1_f64.sqrt());
    ((along * alpha).sqrt().sqrt(), ((1.0 - aspect * aspect) / 0.9).clamp(0.0, 1.0))
}

/// `(0.1 − r²) / 0.099`.
fn gloss(roughness: &Slot) -> Parameter<f64> {
    match channel(roughness, 1) {
        Parameter::Constant(r) => ((0.1 - r * r) / 0.099).clamp(0.0, 1.0).into(),
        Parameter::Texture(texture) => {
            let squared = remapped(&texture, 1.0, 0.0, true);
            Parameter::Texture(remapped(&squared, -1.0 / 0.099, 0.1 / 0.099, false))
        }
    }
}

fn remapped(of: &Texture, scale: f64, offset: f64, squared: bool) -> Arc<Texture> {
    Arc::new(Texture::Remapped { of: Box::new(of.clone()), scale, offset, squared })
}

/// One channel of a slot.
fn channel(slot: &Slot, channel: usize) -> Parameter<f64> {
    let factor = slot.factor[channel];
    match &slot.texture {
        Some(texture) if factor != 0.0 => {
            let grey = Arc::new(Texture::Channel { of: Box::new((**texture).clone()), channel });
            Parameter::Texture(if factor == 1.0 { grey } else { remapped(&grey, factor, 0.0, false) })
        }
        _ => factor.into(),
    }
}
