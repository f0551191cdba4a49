//! The layers of glTF's material and of its extensions.

use serde_json::Value;

use super::super::exact;
use super::super::fault::Fault;
use super::super::primitive::Handedness;
use super::slots::{check_shares, info_of};
use super::{REMEDY, Reader};
use crate::scene::description::{GltfAnisotropy, GltfCoat, GltfDescription, GltfSheen, GltfVolume, NormalSource, Slot};
use crate::spectrum::Rgb;

/// Extensions with lobes that do not exist here, and the factor that switches each one on.
const MORE_LOBES: &[(&str, &str)] = &[
    ("KHR_materials_diffuse_transmission", "diffuseTransmissionFactor"),
    ("KHR_materials_iridescence", "iridescenceFactor"),
];

impl Reader<'_, '_> {
    /// All layers over a base of this colour.
    pub(super) fn layers(&mut self, base_color: Slot) -> Result<GltfDescription, Fault> {
        self.refuse_unsupported()?;
        let (material, here) = (self.material, self.here.clone());
        let surface = &material.pbr_metallic_roughness;
        let (roughness, metallic) = (surface.roughness_factor, surface.metallic_factor);
        check_shares(&here, &[("roughnessFactor", &[roughness]), ("metallicFactor", &[metallic])])?;
        let place = format!("{here}.metallicRoughnessTexture");
        let info = surface.metallic_roughness_texture.as_ref();
        let metallic_roughness = self.slots().read([1.0, roughness, metallic, 1.0], info, true, &place)?;
        let normal = match &material.normal_texture {
            None => None,
            Some(info) => Some(self.normal_map(info, &format!("{here}.normalTexture"))?),
        };
        let ior = number(material, "KHR_materials_ior", "ior", 1.5, &here)?;
        let mut description =
            GltfDescription { base_color, metallic_roughness, ior, normal, ..GltfDescription::default() };
        if let Some(extension) = material.extensions.get("KHR_materials_specular") {
            self.specular(extension, &mut description)?;
        }
        if let Some(extension) = material.extensions.get("KHR_materials_transmission") {
            let place = format!("{here}.KHR_materials_transmission");
            let factor = share(extension, "transmissionFactor", 0.0, &place)?;
            let key = "transmissionTexture";
            if factor > 0.0 {
                description.transmission =
                    self.slots().of_extension(extension, key, [factor, 1.0, 1.0, 1.0], true, &place)?;
            }
        }
        if description.transmits() {
            if ior < 1.0 {
                return Err(Fault::unsupported(&here, "transmitting materials with an `ior` below one", REMEDY));
            }
            if let Some(extension) = material.extensions.get("KHR_materials_volume") {
                self.volume(extension, &mut description)?;
            }
            self.refuse_dispersion(&description)?;
        }
        if ior != 0.0 && !(1.0..=100.0).contains(&ior) {
            let place = format!("{here}.KHR_materials_ior.ior");
            return Err(Fault::invalid(place, format!("{ior} is no index of refraction"), "make it 1 … 100, or 0"));
        }
        if let Some(extension) = material.extensions.get("KHR_materials_clearcoat") {
            description.clearcoat = self.clearcoat(extension)?;
        }
        if let Some(extension) = material.extensions.get("KHR_materials_sheen") {
            description.sheen = self.sheen(extension)?;
        }
        if let Some(extension) = material.extensions.get("KHR_materials_anisotropy") {
            description.anisotropy = self.anisotropy(extension)?;
        }
        Ok(description)
    }

    fn normal_map(&mut self, info: &exact::TextureInfo, here: &str) -> Result<NormalSource, Fault> {
        let handedness = self.of.handedness;
        let texture = self.slots().texture(info, true, here)?;
        if !info.scale.is_finite() {
            return Err(Fault::invalid(format!("{here}.scale"), "is not finite", "give a number"));
        }
        // Unless images are mirrored, against v is the same as to the left of u, which is all that Mitsuba knows.
        let against_v = handedness == Handedness::Mixed;
        Ok(NormalSource::Map { texture, scale: [info.scale; 2], against_v })
    }

    fn specular(&mut self, extension: &Value, description: &mut GltfDescription) -> Result<(), Fault> {
        let here = format!("{}.KHR_materials_specular", self.here);
        let factor = share(extension, "specularFactor", 1.0, &here)?;
        let colour = colour(extension, "specularColorFactor", Rgb::WHITE, &here)?;
        if colour.min_component() < 0.0 {
            let place = format!("{here}.specularColorFactor");
            return Err(Fault::invalid(place, "is negative", "make it zero or more"));
        }
        let mut slots = self.slots();
        description.specular =
            slots.of_extension(extension, "specularTexture", [1.0, 1.0, 1.0, factor], true, &here)?;
        let Rgb { r, g, b } = colour;
        description.specular_color =
            slots.of_extension(extension, "specularColorTexture", [r, g, b, 1.0], false, &here)?;
        Ok(())
    }

    /// A volume that is thick; what is not changes nothing.
    fn volume(&mut self, extension: &Value, description: &mut GltfDescription) -> Result<(), Fault> {
        let here = format!("{}.KHR_materials_volume", self.here);
        let thickness = value_of(extension, "thicknessFactor", 0.0, &here)?;
        let attenuation_distance = value_of(extension, "attenuationDistance", f64::INFINITY, &here)?;
        let attenuation_color = colour(extension, "attenuationColor", Rgb::WHITE, &here)?;
        check_shares(&here, &[("attenuationColor", &attenuation_color.to_array())])?;
        for (key, value) in [("thicknessFactor", thickness), ("attenuationDistance", attenuation_distance)] {
            if value < 0.0 || (key == "attenuationDistance" && value == 0.0) {
                return Err(Fault::invalid(format!("{here}.{key}"), format!("is {value}"), "make it positive"));
            }
        }
        if thickness == 0.0 {
            return Ok(());
        }
        let absorbs = attenuation_distance.is_finite() && attenuation_color != Rgb::WHITE;
        let slot = if absorbs {
            self.tally.absorbing += 1;
            self.slots().of_extension(extension, "thicknessTexture", [1.0, thickness, 1.0, 1.0], true, &here)?
        } else {
            Slot::constant([1.0, thickness, 1.0, 1.0])
        };
        description.volume = Some(GltfVolume { thickness: slot, attenuation_color, attenuation_distance });
        Ok(())
    }

    fn clearcoat(&mut self, extension: &Value) -> Result<Option<GltfCoat>, Fault> {
        let here = format!("{}.KHR_materials_clearcoat", self.here);
        let factor = share(extension, "clearcoatFactor", 0.0, &here)?;
        let roughness = share(extension, "clearcoatRoughnessFactor", 0.0, &here)?;
        if factor == 0.0 {
            return Ok(None);
        }
        let normal = match info_of(extension, "clearcoatNormalTexture", &here)? {
            None => None,
            Some(info) => Some(self.normal_map(&info, &format!("{here}.clearcoatNormalTexture"))?),
        };
        let mut slots = self.slots();
        let factor = slots.of_extension(extension, "clearcoatTexture", [factor, 1.0, 1.0, 1.0], true, &here)?;
        let key = "clearcoatRoughnessTexture";
        let roughness = slots.of_extension(extension, key, [1.0, roughness, 1.0, 1.0], true, &here)?;
        Ok(Some(GltfCoat { factor, roughness, normal }))
    }

    fn sheen(&mut self, extension: &Value) -> Result<Option<GltfSheen>, Fault> {
        let here = format!("{}.KHR_materials_sheen", self.here);
        let colour = colour(extension, "sheenColorFactor", Rgb::BLACK, &here)?;
        check_shares(&here, &[("sheenColorFactor", &colour.to_array())])?;
        let roughness = share(extension, "sheenRoughnessFactor", 0.0, &here)?;
        if colour.is_black() {
            return Ok(None);
        }
        let Rgb { r, g, b } = colour;
        let mut slots = self.slots();
        let color = slots.of_extension(extension, "sheenColorTexture", [r, g, b, 1.0], false, &here)?;
        let key = "sheenRoughnessTexture";
        let roughness = slots.of_extension(extension, key, [1.0, 1.0, 1.0, roughness], true, &here)?;
        Ok(Some(GltfSheen { color, roughness }))
    }

    fn anisotropy(&mut self, extension: &Value) -> Result<Option<GltfAnisotropy>, Fault> {
        let here = format!("{}.KHR_materials_anisotropy", self.here);
        let strength = share(extension, "anisotropyStrength", 0.0, &here)?;
        let rotation = value_of(extension, "anisotropyRotation", 0.0, &here)?;
        if strength == 0.0 {
            return Ok(None);
        }
        let texture = match info_of(extension, "anisotropyTexture", &here)? {
            None => None,
            Some(info) => Some(self.slots().texture(&info, true, &format!("{here}.anisotropyTexture"))?),
        };
        Ok(Some(GltfAnisotropy { strength, rotation, texture }))
    }

    /// Refuses by name what would change the picture and cannot be shown.
    fn refuse_unsupported(&self) -> Result<(), Fault> {
        let extensions = &self.material.extensions;
        let name = "KHR_materials_pbrSpecularGlossiness";
        if extensions.contains_key(name) {
            let what = format!("specular-glossiness materials ({name})");
            return Err(Fault::unsupported(&self.here, what, REMEDY));
        }
        for &(name, factor) in MORE_LOBES {
            if extensions.get(name).and_then(|extension| extension.get(factor)).is_some_and(has_effect) {
                return Err(Fault::unsupported(&self.here, format!("materials with {name}"), REMEDY));
            }
        }
        Ok(())
    }

    /// Only what refracts disperses.
    fn refuse_dispersion(&self, description: &GltfDescription) -> Result<(), Fault> {
        let name = "KHR_materials_dispersion";
        let disperses = self.material.extensions.get(name).and_then(|extension| extension.get("dispersion"));
        if description.volume.is_some() && disperses.is_some_and(has_effect) {
            return Err(Fault::unsupported(&self.here, format!("materials with {name}"), REMEDY));
        }
        Ok(())
    }
}

/// A number of an extension, or its default.
pub(super) fn number(
    material: &exact::Material,
    extension: &str,
    key: &str,
    default: f64,
    here: &str,
) -> Result<f64, Fault> {
    let place = format!("{here}.{extension}");
    material.extensions.get(extension).map_or(Ok(default), |extension| value_of(extension, key, default, &place))
}

fn value_of(extension: &Value, key: &str, default: f64, here: &str) -> Result<f64, Fault> {
    match extension.get(key) {
        None => Ok(default),
        Some(value) => value
            .as_f64()
            .filter(|number| number.is_finite())
            .ok_or_else(|| Fault::invalid(format!("{here}.{key}"), format!("{value} is no number"), "give a number")),
    }
}

fn share(extension: &Value, key: &str, default: f64, here: &str) -> Result<f64, Fault> {
    let value = value_of(extension, key, default, here)?;
    check_shares(here, &[(key, &[value])])?;
    Ok(value)
}

fn colour(extension: &Value, key: &str, default: Rgb, here: &str) -> Result<Rgb, Fault> {
    match extension.get(key) {
        None => Ok(default),
        Some(value) => serde_json::from_value::<[f64; 3]>(value.clone()).map(Rgb::from).map_err(|_| {
            Fault::invalid(format!("{here}.{key}"), format!("{value} is no colour"), "give three numbers")
        }),
    }
}

/// A factor that is not zero in some channel.
fn has_effect(factor: &Value) -> bool {
    match factor {
        Value::Array(channels) => channels.iter().any(has_effect),
        other => other.as_f64() != Some(0.0),
    }
}
