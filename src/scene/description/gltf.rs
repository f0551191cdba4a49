//! glTF's own material, with the layers of its extensions.

use std::sync::Arc;

use super::material::NormalSource;
use crate::scene::texture::{SurfacePoint, Texture};
use crate::spectrum::Rgb;

/// Four numbers of a material, and the texture that they are factors of, channel by channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Slot {
    /// The factors of red, green, blue and opacity.
    pub factor: [f64; 4],
    /// What they are multiplied by, where there is something.
    pub texture: Option<Arc<Texture>>,
}

impl Slot {
    /// The same everywhere.
    #[must_use]
    pub fn constant(factor: [f64; 4]) -> Self {
        Self { factor, texture: None }
    }

    /// At a point.
    #[must_use]
    pub fn at(&self, at: &SurfacePoint<'_>) -> [f64; 4] {
        match &self.texture {
            None => self.factor,
            Some(texture) => {
                let texel = texture.eval(at);
                std::array::from_fn(|i| self.factor[i] * texel[i])
            }
        }
    }

    /// Zero everywhere in a channel.
    #[must_use]
    pub fn vanishes(&self, channel: usize) -> bool {
        self.factor[channel] == 0.0
    }
}

/// The material of glTF 2.0 (appendix B), by the names that its specification and its extensions give the parameters. A
/// slot's comment says which channels count; shares are 0 … 1.
#[derive(Clone, Debug, PartialEq)]
pub struct GltfDescription {
    /// RGB: colour of the diffuse base, of metal, and of what passes through.
    pub base_color: Slot,
    /// Green: roughness, the square root of α. Blue: share of metal.
    pub metallic_roughness: Slot,
    /// Index of refraction of the inside, from 1 up; 0 stands for infinity (KHR_materials_ior).
    pub ior: f64,
    /// Opacity channel: strength of the specular layer (KHR_materials_specular).
    pub specular: Slot,
    /// RGB, from 0 up: factor of the specular layer's reflectance along the normal (KHR_materials_specular).
    pub specular_color: Slot,
    /// Red: share of the base that transmits (KHR_materials_transmission).
    pub transmission: Slot,
    /// What lies below the surface; without it what transmits is thin and bends nothing (KHR_materials_volume).
    pub volume: Option<GltfVolume>,
    /// A smooth coat (KHR_materials_clearcoat).
    pub clearcoat: Option<GltfCoat>,
    /// Fibres (KHR_materials_sheen).
    pub sheen: Option<GltfSheen>,
    /// Another roughness along one direction (KHR_materials_anisotropy).
    pub anisotropy: Option<GltfAnisotropy>,
    /// What turns the normal of all layers but the coat.
    pub normal: Option<NormalSource>,
}

/// The inside of a closed surface, as far as a surface can tell.
#[derive(Clone, Debug, PartialEq)]
pub struct GltfVolume {
    /// Green: how thick it is below each point \[m\].
    pub thickness: Slot,
    /// What is left of white light after the distance below.
    pub attenuation_color: Rgb,
    /// That distance \[m\]; infinite where nothing is absorbed.
    pub attenuation_distance: f64,
}

/// A coat of index 1.5.
#[derive(Clone, Debug, PartialEq)]
pub struct GltfCoat {
    /// Red: its share of the surface.
    pub factor: Slot,
    /// Green: its roughness, the square root of α.
    pub roughness: Slot,
    /// What turns its normal.
    pub normal: Option<NormalSource>,
}

/// Fibres that stand on the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct GltfSheen {
    /// RGB: how much they reflect.
    pub color: Slot,
    /// Opacity channel: how much they diverge from the normal, the square root of α.
    pub roughness: Slot,
}

/// Roughness that is larger along one direction.
#[derive(Clone, Debug, PartialEq)]
pub struct GltfAnisotropy {
    /// Its strength, 0 … 1, times the texture's blue.
    pub strength: f64,
    /// From the tangent along u, counter-clockwise against v \[rad\]; on top of the texture's direction.
    pub rotation: f64,
    /// Red and green: the direction, 0 … 1 standing for −1 … 1. Blue: strength.
    pub texture: Option<Arc<Texture>>,
}

impl Default for GltfDescription {
    /// glTF's own defaults: white and rough metal.
    fn default() -> Self {
        let ones = || Slot::constant([1.0; 4]);
        Self {
            base_color: ones(),
            metallic_roughness: ones(),
            ior: 1.5,
            specular: ones(),
            specular_color: ones(),
            transmission: Slot::constant([0.0; 4]),
            volume: None,
            clearcoat: None,
            sheen: None,
            anisotropy: None,
            normal: None,
        }
    }
}

impl GltfDescription {
    /// Light passes through it somewhere.
    #[must_use]
    pub fn transmits(&self) -> bool {
        let metal = &self.metallic_roughness;
        let is_metal = metal.texture.is_none() && metal.factor[2] == 1.0;
        !(is_metal || self.transmission.vanishes(0))
    }

    /// All its textures.
    #[must_use]
    pub fn textures(&self) -> Vec<&Texture> {
        let mut slots =
            vec![&self.base_color, &self.metallic_roughness, &self.specular, &self.specular_color, &self.transmission];
        slots.extend(self.volume.iter().map(|volume| &volume.thickness));
        slots.extend(self.clearcoat.iter().flat_map(|coat| [&coat.factor, &coat.roughness]));
        slots.extend(self.sheen.iter().flat_map(|sheen| [&sheen.color, &sheen.roughness]));
        let normals = self.normal.iter().chain(self.clearcoat.iter().filter_map(|coat| coat.normal.as_ref()));
        let of_normals = normals.map(|source| match source {
            NormalSource::Map { texture, .. } | NormalSource::Bump { texture, .. } => texture,
        });
        let of_slots = slots.into_iter().filter_map(|slot| slot.texture.as_ref());
        let turned = self.anisotropy.iter().filter_map(|anisotropy| anisotropy.texture.as_ref());
        of_slots.chain(turned).chain(of_normals).map(Arc::as_ref).collect()
    }
}
