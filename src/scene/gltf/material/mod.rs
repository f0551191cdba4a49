//! Materials: glTF's own model, Mitsuba's `principled` instead of it, or the exact model that `extras` names.

mod layers;
mod principled;
mod slots;

use std::collections::HashMap;
use std::sync::Arc;

use serde_json::Value;

use super::document::Document;
use super::exact::{self, AlphaMode};
use super::extras::{self, MaterialExtras, nearest};
use super::fault::{Fault, place};
use super::tally::Tally;
use super::texture::Textures;
use super::{MaterialModel, primitive};
use crate::scene::description::{BsdfDescription, GltfDescription, Material, Slot};
use crate::scene::texture::{Parameter, Texture};
use crate::spectrum::Rgb;

use slots::Slots;

pub(super) const REMEDY: &str = "use plain factors, or give the material a `bsdf` in extras.pathspace";

/// What of a material depends on the primitive that has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Use {
    /// Index of the glTF material, `None` being glTF's default one.
    pub material: Option<usize>,
    /// The primitive has colours at its vertices.
    pub colours: bool,
    /// How its texture coordinates lie.
    pub handedness: primitive::Handedness,
}

/// The materials in use, in the order of their first use.
pub(super) struct Materials<'a> {
    textures: Textures<'a>,
    model: MaterialModel,
    numbers: HashMap<Use, usize>,
    pub used: Vec<Material>,
}

impl<'a> Materials<'a> {
    pub(super) fn new(textures: Textures<'a>, model: MaterialModel) -> Self {
        Self { textures, model, numbers: HashMap::new(), used: Vec::new() }
    }

    /// Index into `used`.
    pub(super) fn number(&mut self, of: Use, tally: &mut Tally) -> Result<usize, Fault> {
        let document = self.textures.document;
        let asks = of.material.is_some_and(|index| slots::has_normal_map(&document.exact.materials[index]));
        // How images lie matters to normal maps alone.
        let of = if asks { of } else { Use { handedness: primitive::Handedness::Plain, ..of } };
        if let Some(&number) = self.numbers.get(&of) {
            return Ok(number);
        }
        let (found, here, name) = match of.material {
            Some(index) => {
                let found = &document.exact.materials[index];
                let name = found.name.clone().unwrap_or_else(|| format!("material {index}"));
                (found, place("materials", index, found.name.as_deref()), name)
            }
            None => (&exact::Material::default(), "the default material".to_owned(), "default".to_owned()),
        };
        let mut reader = Reader { textures: &mut self.textures, model: self.model, material: found, here, of, tally };
        let read = reader.read(name)?;
        self.used.push(read);
        let number = self.used.len() - 1;
        self.numbers.insert(of, number);
        Ok(number)
    }

    /// The index of a glTF material that extras refer to by index or name.
    pub(super) fn find(&self, reference: &Value, owner: &str) -> Result<usize, Fault> {
        let all = &self.textures.document.exact.materials;
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

/// The sets of texture coordinates that a material asks for, the one that its tangents follow first.
pub(super) fn coordinate_sets(document: &Document, material: Option<usize>) -> Vec<usize> {
    let Some(material) = material.and_then(|index| document.exact.materials.get(index)) else { return Vec::new() };
    let (turning, others) = slots::infos(material);
    let mut sets: Vec<usize> = others.iter().map(slots::set_of).collect();
    sets.sort_unstable();
    sets.dedup();
    if sets.is_empty() && material.extensions.contains_key("KHR_materials_anisotropy") {
        sets.push(0);
    }
    if let Some(main) = turning.first().map(slots::set_of) {
        sets.retain(|&set| set != main);
        sets.insert(0, main);
    }
    sets
}

/// Reads one material.
struct Reader<'r, 'a> {
    textures: &'r mut Textures<'a>,
    model: MaterialModel,
    material: &'r exact::Material,
    here: String,
    of: Use,
    tally: &'r mut Tally,
}

impl Reader<'_, '_> {
    fn read(&mut self, name: String) -> Result<Material, Fault> {
        let (material, here) = (self.material, self.here.clone());
        let ours: MaterialExtras = extras::read(material.extras.as_ref(), &here)?;
        let two_sided = ours.two_sided.unwrap_or(material.double_sided);
        let base = self.base()?;
        let opacity = if ours.bsdf.is_some() { None } else { self.opacity(&base)? };
        let unlit = ours.bsdf.is_none() && material.extensions.contains_key("KHR_materials_unlit");
        let emission = match ours.emission {
            Some(emission) => emission.into(),
            None if unlit => {
                self.tally.unlit.push(name.clone());
                slots::product(colour(&base), opacity.as_ref())
            }
            None => {
                let emission = colour(&self.emission()?);
                // Nobody sees what is not there.
                slots::product(emission, opacity.as_ref())
            }
        };
        let emits = emission.constant() != Some(&Rgb::BLACK);
        if two_sided && ours.two_sided.is_none() && emits {
            self.tally.one_sided_emission.push(name.clone());
        }
        let bsdf = match ours.bsdf {
            Some(bsdf) => return Ok(Material { name, bsdf, two_sided, emission }),
            None if unlit => BsdfDescription::Diffuse { reflectance: Rgb::BLACK.into() },
            None => {
                if material.occlusion_texture.is_some() {
                    self.tally.occlusion += 1;
                }
                let description = self.layers(base)?;
                self.model_of(description, &name)
            }
        };
        let bsdf = match opacity {
            None => bsdf,
            Some(opacity) => {
                // A mask has two sides: its nested model must know of the back.
                let nested = if two_sided && !transmits(&bsdf) {
                    BsdfDescription::TwoSided { front: Box::new(bsdf.clone()), back: Box::new(bsdf) }
                } else {
                    bsdf
                };
                BsdfDescription::Mask { opacity, nested: Box::new(nested) }
            }
        };
        Ok(Material { name, bsdf, two_sided, emission })
    }

    fn slots(&mut self) -> Slots<'_> {
        let main = coordinate_sets(self.textures.document, self.of.material).first().copied().unwrap_or(0);
        Slots { textures: self.textures, main, tally: self.tally }
    }

    /// Base colour and opacity, with the colours of the vertices.
    fn base(&mut self) -> Result<Slot, Fault> {
        let surface = &self.material.pbr_metallic_roughness;
        let here = format!("{}.baseColorTexture", self.here);
        let factor = surface.base_color_factor;
        slots::check_shares(&self.here, &[("baseColorFactor", &factor)])?;
        let colours = self.of.colours;
        let mut slot = self.slots().read(factor, surface.base_color_texture.as_ref(), false, &here)?;
        if colours {
            let attribute = Texture::Attribute { name: super::texture::COLOURS.into() };
            slot.texture = Some(Arc::new(match slot.texture {
                None => attribute,
                Some(texture) => Texture::Product(vec![(*texture).clone(), attribute]),
            }));
        }
        Ok(slot)
    }

    /// The share of the surface that is there, where that is not all.
    fn opacity(&self, base: &Slot) -> Result<Option<Parameter<f64>>, Fault> {
        let cutoff = self.material.alpha_cutoff.unwrap_or(0.5);
        if cutoff < 0.0 {
            let place = format!("{}.alphaCutoff", self.here);
            return Err(Fault::invalid(place, format!("{cutoff} is negative"), "make it zero or more"));
        }
        let masked = match self.material.alpha_mode {
            AlphaMode::Opaque => return Ok(None),
            AlphaMode::Mask => true,
            AlphaMode::Blend => false,
        };
        let alpha = base.factor[3];
        let Some(texture) = &base.texture else {
            let opacity = if masked { f64::from(u8::from(alpha >= cutoff)) } else { alpha };
            return Ok((opacity < 1.0).then(|| opacity.into()));
        };
        let channel = Texture::Channel { of: Box::new((**texture).clone()), channel: 3 };
        let opacity = if alpha == 1.0 {
            channel
        } else {
            Texture::Remapped { of: Box::new(channel), scale: alpha, offset: 0.0, squared: false }
        };
        let opacity = if masked { Texture::Step { of: Box::new(opacity), threshold: cutoff } } else { opacity };
        Ok(Some(Parameter::Texture(Arc::new(opacity))))
    }

    /// `emissiveFactor · emissiveStrength · emissiveTexture` \[W/m²/sr\].
    fn emission(&mut self) -> Result<Slot, Fault> {
        let (material, here) = (self.material, self.here.clone());
        let [r, g, b] = material.emissive_factor;
        let strength = layers::number(material, "KHR_materials_emissive_strength", "emissiveStrength", 1.0, &here)?;
        for (name, value) in [("emissiveStrength", strength), ("emissiveFactor", r.min(g).min(b))] {
            if value < 0.0 {
                let problem = format!("{value} is negative");
                return Err(Fault::invalid(format!("{here}.{name}"), problem, "make it zero or more"));
            }
        }
        let factor = [r * strength, g * strength, b * strength, 1.0];
        // Black emits nothing, whatever its texture: many files have such.
        let info = material.emissive_texture.as_ref().filter(|_| r > 0.0 || g > 0.0 || b > 0.0);
        self.slots().read(factor, info, false, &format!("{here}.emissiveTexture"))
    }

    /// The model that was asked for.
    fn model_of(&mut self, description: GltfDescription, name: &str) -> BsdfDescription {
        let lamberts = description.metallic_roughness.vanishes(2)
            && description.specular.vanishes(3)
            && !description.transmits()
            && description.clearcoat.is_none()
            && description.sheen.is_none();
        if lamberts {
            let matt = BsdfDescription::Diffuse { reflectance: colour(&description.base_color) };
            return turned(matt, description.normal);
        }
        match self.model {
            MaterialModel::Gltf => BsdfDescription::Gltf(Box::new(description)),
            MaterialModel::Principled => {
                let (principled, lost) = principled::from_gltf(&description);
                for what in lost {
                    self.tally.lose(what, name);
                }
                turned(BsdfDescription::Principled(Box::new(principled)), description.normal)
            }
        }
    }
}

fn turned(nested: BsdfDescription, normal: Option<crate::scene::description::NormalSource>) -> BsdfDescription {
    match normal {
        None => nested,
        Some(normal) => BsdfDescription::Perturbed { normal, nested: Box::new(nested) },
    }
}

/// It needs no second side.
fn transmits(bsdf: &BsdfDescription) -> bool {
    match bsdf {
        BsdfDescription::Gltf(gltf) => gltf.transmits(),
        BsdfDescription::Principled(principled) => principled.spec_trans.constant() != Some(&0.0),
        BsdfDescription::Perturbed { nested, .. } => transmits(nested),
        _ => false,
    }
}

/// A slot's colour as a parameter.
fn colour(slot: &Slot) -> Parameter<Rgb> {
    let [r, g, b, _] = slot.factor;
    match &slot.texture {
        _ if [r, g, b] == [0.0; 3] => Rgb::BLACK.into(),
        None => Rgb::new(r, g, b).into(),
        Some(texture) if [r, g, b] == [1.0; 3] => Parameter::Texture(texture.clone()),
        Some(texture) => {
            let factor = Texture::Constant([r, g, b, 1.0]);
            Parameter::Texture(Arc::new(Texture::Product(vec![(**texture).clone(), factor])))
        }
    }
}
