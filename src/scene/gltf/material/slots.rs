//! Slots: factors with their textures.

use std::sync::Arc;

use serde_json::Value;

use super::super::exact::{self, TextureInfo};
use super::super::fault::Fault;
use super::super::tally::Tally;
use super::super::texture::{Textures, Transform};
use crate::scene::description::Slot;
use crate::scene::texture::{Parameter, Texture};
use crate::spectrum::Rgb;

/// Reads slots of one material.
pub(super) struct Slots<'r> {
    pub textures: &'r mut dyn ReadTexture,
    /// The meshes' own set of texture coordinates.
    pub main: usize,
    pub tally: &'r mut Tally,
}

/// [`Textures`] without its lifetimes.
pub(super) trait ReadTexture {
    /// See [`Textures::read`].
    fn texture(
        &mut self,
        info: &TextureInfo,
        raw: bool,
        main: usize,
        here: &str,
        tally: &mut Tally,
    ) -> Result<Texture, Fault>;
}

impl ReadTexture for Textures<'_> {
    fn texture(
        &mut self,
        info: &TextureInfo,
        raw: bool,
        main: usize,
        here: &str,
        tally: &mut Tally,
    ) -> Result<Texture, Fault> {
        self.read(info, raw, main, here, tally)
    }
}

impl Slots<'_> {
    /// Factors and the texture that they belong to. `raw` says that it holds no colours.
    pub(super) fn read(
        &mut self,
        factor: [f64; 4],
        info: Option<&TextureInfo>,
        raw: bool,
        here: &str,
    ) -> Result<Slot, Fault> {
        let texture = info.map(|info| self.texture(info, raw, here)).transpose()?;
        Ok(Slot { factor, texture })
    }

    /// A texture on its own.
    pub(super) fn texture(&mut self, info: &TextureInfo, raw: bool, here: &str) -> Result<Arc<Texture>, Fault> {
        self.textures.texture(info, raw, self.main, here, self.tally).map(Arc::new)
    }

    /// The same of an extension, whose JSON stands as it is.
    pub(super) fn of_extension(
        &mut self,
        extension: &Value,
        key: &str,
        factor: [f64; 4],
        raw: bool,
        here: &str,
    ) -> Result<Slot, Fault> {
        let info = info_of(extension, key, here)?;
        // A factor of zero in all channels that count leaves nothing to look up.
        self.read(factor, info.as_ref(), raw, &format!("{here}.{key}"))
    }
}

/// A texture's entry in an extension.
pub(super) fn info_of(extension: &Value, key: &str, here: &str) -> Result<Option<TextureInfo>, Fault> {
    let Some(value) = extension.get(key) else { return Ok(None) };
    serde_json::from_value(value.clone()).map(Some).map_err(|error| {
        Fault::invalid(format!("{here}.{key}"), error.to_string(), "correct the file or export it again")
    })
}

/// All textures of a material that are looked at: those that depend on the tangents, and all.
pub(super) fn infos(material: &exact::Material) -> (Vec<TextureInfo>, Vec<TextureInfo>) {
    let surface = &material.pbr_metallic_roughness;
    let core = [&surface.base_color_texture, &surface.metallic_roughness_texture, &material.emissive_texture];
    let mut turning: Vec<TextureInfo> = material.normal_texture.iter().cloned().collect();
    let mut all: Vec<TextureInfo> = core.into_iter().flatten().cloned().collect();
    all.extend(turning.clone());
    for extension in material.extensions.values().filter_map(Value::as_object) {
        for (key, value) in extension.iter().filter(|(key, _)| key.ends_with("Texture")) {
            let Ok(info) = serde_json::from_value::<TextureInfo>(value.clone()) else { continue };
            if matches!(key.as_str(), "anisotropyTexture" | "clearcoatNormalTexture") {
                turning.push(info.clone());
            }
            all.push(info);
        }
    }
    (turning, all)
}

/// Some layer has a normal map.
pub(super) fn has_normal_map(material: &exact::Material) -> bool {
    let coat = material.extensions.get("KHR_materials_clearcoat");
    material.normal_texture.is_some() || coat.is_some_and(|coat| coat.get("clearcoatNormalTexture").is_some())
}

/// The set of texture coordinates that a texture uses.
pub(super) fn set_of(info: &TextureInfo) -> usize {
    Transform::of(info, "").map_or(info.tex_coord, |transform| transform.set)
}

/// A colour times a share.
pub(super) fn product(colour: Parameter<Rgb>, share: Option<&Parameter<f64>>) -> Parameter<Rgb> {
    let texture_of = |parameter: &Parameter<Rgb>| match parameter {
        Parameter::Constant(Rgb { r, g, b }) => Texture::Constant([*r, *g, *b, 1.0]),
        Parameter::Texture(texture) => (**texture).clone(),
    };
    match (share, colour.constant()) {
        (None, _) | (_, Some(&Rgb::BLACK)) => colour,
        (Some(Parameter::Constant(share)), Some(&constant)) => (constant * *share).into(),
        (Some(Parameter::Constant(share)), None) => {
            let factors = vec![texture_of(&colour), Texture::Constant([*share, *share, *share, 1.0])];
            Parameter::Texture(Arc::new(Texture::Product(factors)))
        }
        (Some(Parameter::Texture(share)), _) => {
            Parameter::Texture(Arc::new(Texture::Product(vec![texture_of(&colour), (**share).clone()])))
        }
    }
}

/// Factors are shares.
pub(super) fn check_shares(here: &str, factors: &[(&str, &[f64])]) -> Result<(), Fault> {
    for (name, values) in factors {
        for value in *values {
            if !(0.0..=1.0).contains(value) {
                let problem = format!("{value} is no share");
                return Err(Fault::invalid(format!("{here}.{name}"), problem, "make it 0 … 1"));
            }
        }
    }
    Ok(())
}
