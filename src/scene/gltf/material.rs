//! Materials: glTF's parameters as one lobe, or the exact model that `extras` names.

use std::collections::HashMap;

use serde_json::Value;

use super::document::Document;
use super::exact::{self, AlphaMode};
use super::extras::{self, MaterialExtras, nearest};
use super::fault::{Fault, place};
use super::tally::Tally;
use crate::scene::description::{BsdfDescription, ConductorFresnel, Material};
use crate::spectrum::Rgb;

/// Below this a microfacet lobe is narrower than what is worth telling from a mirror.
const SMALLEST_ALPHA: f64 = 1e-4;

/// Extensions with lobes that do not exist here, and the factor that switches each one on.
const MORE_LOBES: &[(&str, &str)] = &[
    ("KHR_materials_anisotropy", "anisotropyStrength"),
    ("KHR_materials_clearcoat", "clearcoatFactor"),
    ("KHR_materials_diffuse_transmission", "diffuseTransmissionFactor"),
    ("KHR_materials_dispersion", "dispersion"),
    ("KHR_materials_iridescence", "iridescenceFactor"),
    ("KHR_materials_sheen", "sheenColorFactor"),
];

const REMEDY: &str = "use plain factors, or give the material a `bsdf` in extras.pathspace";

/// The materials in use, in the order of their first use.
pub(super) struct Materials<'a> {
    document: &'a Document,
    numbers: HashMap<Option<usize>, usize>,
    pub used: Vec<Material>,
}

impl<'a> Materials<'a> {
    pub(super) fn new(document: &'a Document) -> Self {
        Self { document, numbers: HashMap::new(), used: Vec::new() }
    }

    /// Index into `used` of a glTF material, `None` being glTF's default one.
    pub(super) fn number(&mut self, material: Option<usize>, tally: &mut Tally) -> Result<usize, Fault> {
        if let Some(&number) = self.numbers.get(&material) {
            return Ok(number);
        }
        let read = match material {
            Some(index) => {
                let found = &self.document.exact.materials[index];
                read(found, &place("materials", index, found.name.as_deref()), index, tally)?
            }
            None => read(&exact::Material::default(), "the default material", 0, tally)
                .map(|read| Material { name: "default".into(), ..read })?,
        };
        self.used.push(read);
        let number = self.used.len() - 1;
        self.numbers.insert(material, number);
        Ok(number)
    }

    /// The index of a glTF material that extras refer to by index or name.
    pub(super) fn find(&self, reference: &Value, owner: &str) -> Result<usize, Fault> {
        let all = &self.document.exact.materials;
        let names = || all.iter().filter_map(|material| material.name.as_deref());
        let (found, wanted) = match reference {
            Value::String(name) => (all.iter().position(|m| m.name.as_ref() == Some(name)), format!("{name:?}")),
            other => {
                let index = other.as_u64().map(|index| index as usize);
                (index.filter(|&index| index < all.len()), other.to_string())
            }
        };
        found.ok_or_else(|| {
            let remedy = match reference.as_str().and_then(|name| nearest(name, names())) {
                Some(name) => format!("did you mean {name:?}?"),
                None => format!("name one of the file's {} materials, or give its index", all.len()),
            };
            Fault::invalid(owner, format!("there is no material {wanted}"), remedy)
        })
    }
}

fn read(material: &exact::Material, here: &str, index: usize, tally: &mut Tally) -> Result<Material, Fault> {
    let ours: MaterialExtras = extras::read(material.extras.as_ref(), here)?;
    let name = material.name.clone().unwrap_or_else(|| format!("material {index}"));
    if material.normal_texture.is_some() {
        return Err(textures(here, "normalTexture"));
    }
    let emission = match ours.emission {
        Some(emission) => emission,
        None => emission(material, here)?,
    };
    let two_sided = ours.two_sided.unwrap_or(material.double_sided);
    if two_sided && ours.two_sided.is_none() && !emission.is_black() {
        tally.one_sided_emission.push(name.clone());
    }
    let bsdf = match ours.bsdf {
        Some(bsdf) => bsdf,
        None => {
            refuse_unsupported(material, here)?;
            let (bsdf, exact) = single_lobe(material, here)?;
            if !exact {
                tally.simplified.push(name.clone());
            }
            bsdf
        }
    };
    Ok(Material { name, bsdf, two_sided, emission: emission.into() })
}

/// `emissiveFactor · emissiveStrength` \[W/m²/sr\].
fn emission(material: &exact::Material, here: &str) -> Result<Rgb, Fault> {
    let factor = Rgb::from(material.emissive_factor);
    let strength = number(material, "KHR_materials_emissive_strength", "emissiveStrength", 1.0, here)?;
    for (name, value) in [("emissiveStrength", strength), ("emissiveFactor", factor.min_component())] {
        if value < 0.0 {
            return Err(Fault::invalid(
                format!("{here}.{name}"),
                format!("{value} is negative"),
                "make it zero or more",
            ));
        }
    }
    if material.emissive_texture.is_some() && !factor.is_black() {
        return Err(textures(here, "emissiveTexture"));
    }
    Ok(factor * strength)
}

/// Refuses by name what would change the picture and cannot be shown.
fn refuse_unsupported(material: &exact::Material, here: &str) -> Result<(), Fault> {
    let surface = &material.pbr_metallic_roughness;
    if surface.base_color_texture.is_some() {
        return Err(textures(here, "baseColorTexture"));
    }
    if surface.metallic_roughness_texture.is_some() {
        return Err(textures(here, "metallicRoughnessTexture"));
    }
    let alpha = surface.base_color_factor[3];
    let transparent = match material.alpha_mode {
        AlphaMode::Opaque => false,
        AlphaMode::Mask => alpha < material.alpha_cutoff.unwrap_or(0.5),
        AlphaMode::Blend => alpha < 1.0,
    };
    if transparent {
        return Err(Fault::unsupported(here, "surfaces with alpha below one (alphaMode MASK or BLEND)", REMEDY));
    }
    let extensions = &material.extensions;
    for (name, what) in [
        ("KHR_materials_unlit", "unlit materials (KHR_materials_unlit)"),
        ("KHR_materials_pbrSpecularGlossiness", "specular-glossiness materials (KHR_materials_pbrSpecularGlossiness)"),
    ] {
        if extensions.contains_key(name) {
            return Err(Fault::unsupported(here, what, REMEDY));
        }
    }
    for &(name, factor) in MORE_LOBES {
        if extensions.get(name).and_then(|extension| extension.get(factor)).is_some_and(has_effect) {
            return Err(Fault::unsupported(here, format!("materials with {name}"), REMEDY));
        }
    }
    let transmission = extensions.get("KHR_materials_transmission");
    if transmission.is_some_and(|extension| extension.get("transmissionTexture").is_some()) {
        return Err(textures(here, "transmissionTexture"));
    }
    let volume = extensions.get("KHR_materials_volume");
    let absorbs = volume.is_some_and(|extension| {
        extension.get("attenuationDistance").is_some() && extension.get("attenuationColor").is_some_and(is_not_white)
    });
    if absorbs && transmission.is_some() {
        return Err(Fault::unsupported(here, "absorbing volumes (KHR_materials_volume)", REMEDY));
    }
    Ok(())
}

/// The nearest model with one lobe, and whether it is all that the material says.
fn single_lobe(material: &exact::Material, here: &str) -> Result<(BsdfDescription, bool), Fault> {
    let surface = &material.pbr_metallic_roughness;
    let [r, g, b, _] = surface.base_color_factor;
    let colour = Rgb::new(r, g, b);
    let (metallic, roughness) = (surface.metallic_factor, surface.roughness_factor);
    let transmission = number(material, "KHR_materials_transmission", "transmissionFactor", 0.0, here)?;
    let ior = number(material, "KHR_materials_ior", "ior", 1.5, here)?;
    let channels = [("baseColorFactor", r), ("baseColorFactor", g), ("baseColorFactor", b)];
    let factors = [("metallicFactor", metallic), ("roughnessFactor", roughness), ("transmissionFactor", transmission)];
    for (name, value) in channels.into_iter().chain(factors) {
        if !(0.0..=1.0).contains(&value) {
            return Err(Fault::invalid(format!("{here}.{name}"), format!("{value} is no share"), "make it 0 … 1"));
        }
    }
    let alpha = roughness * roughness;
    let smooth = alpha < SMALLEST_ALPHA;
    // Metal covers what transmits: glTF mixes the two lobes by `metallicFactor`.
    if metallic >= 0.5 {
        let fresnel = ConductorFresnel::Tint { specular_tint: colour };
        // glTF's metal turns white at grazing angles, a constant tint does not.
        let exact = metallic == 1.0 && colour == Rgb::WHITE;
        let conductor =
            if smooth { BsdfDescription::conductor(fresnel) } else { BsdfDescription::rough_conductor(alpha, fresnel) };
        return Ok((conductor, exact));
    }
    if transmission >= 0.5 {
        if ior <= 0.0 {
            return Err(Fault::unsupported(here, "materials with an `ior` of zero", REMEDY));
        }
        let volume = material.extensions.get("KHR_materials_volume");
        let solid = volume.and_then(|extension| extension.get("thicknessFactor")).is_some_and(has_effect);
        let exact = transmission == 1.0 && metallic == 0.0 && colour == Rgb::WHITE && solid;
        let (interior_ior, exterior_ior) = (ior, 1.0);
        let dielectric = if smooth {
            BsdfDescription::dielectric(interior_ior, exterior_ior)
        } else {
            BsdfDescription::rough_dielectric(alpha, interior_ior, exterior_ior)
        };
        return Ok((dielectric, exact));
    }
    let specular = number(material, "KHR_materials_specular", "specularFactor", 1.0, here)?;
    let matt = roughness == 1.0 || ior == 1.0 || specular == 0.0;
    let exact = metallic == 0.0 && transmission == 0.0 && matt;
    Ok((BsdfDescription::Diffuse { reflectance: colour.into() }, exact))
}

fn textures(here: &str, slot: &str) -> Fault {
    Fault::unsupported(format!("{here}.{slot}"), "textures", REMEDY)
}

/// A number of an extension, or its default.
fn number(material: &exact::Material, extension: &str, key: &str, default: f64, here: &str) -> Result<f64, Fault> {
    match material.extensions.get(extension).and_then(|extension| extension.get(key)) {
        None => Ok(default),
        Some(value) => value.as_f64().filter(|number| number.is_finite()).ok_or_else(|| {
            Fault::invalid(format!("{here}.{extension}.{key}"), format!("{value} is no number"), "give a number")
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

fn is_not_white(colour: &Value) -> bool {
    colour.as_array().is_none_or(|channels| channels.iter().any(|channel| channel.as_f64() != Some(1.0)))
}
