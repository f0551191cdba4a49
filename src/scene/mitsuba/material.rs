//! Materials as Mitsuba's BSDFs.

use std::path::Path;

use super::error::ExportError;
use super::texture::Images;
use super::xml::Element;
use crate::scene::description::{BsdfDescription, ConductorFresnel, Material, NormalSource, SceneDescription};
use crate::scene::texture::Parameter;
use crate::spectrum::Rgb;

/// Writes materials and collects the images of their textures.
pub(super) struct Materials<'a> {
    scene: &'a SceneDescription,
    images: Images,
}

impl<'a> Materials<'a> {
    pub(super) fn new(scene: &'a SceneDescription) -> Self {
        Self { scene, images: Images::default() }
    }

    /// The BSDF of a material.
    pub(super) fn element(&mut self, material: &Material) -> Result<Element, ExportError> {
        let place = format!("material '{}'", material.name);
        let element = self.bsdf(&material.bsdf, &place)?;
        let wrap = material.two_sided && !has_two_sides(&material.bsdf);
        Ok(if wrap { Element::plugin("bsdf", "twosided").child(element) } else { element })
    }

    /// Writes what the elements refer to.
    pub(super) fn write_images(&self, folder: &Path) -> Result<(), ExportError> {
        self.images.write(folder)
    }

    fn bsdf(&mut self, description: &BsdfDescription, place: &str) -> Result<Element, ExportError> {
        Ok(match description {
            BsdfDescription::Diffuse { reflectance } => {
                self.share(Element::plugin("bsdf", "diffuse"), "reflectance", reflectance, place)?
            }
            BsdfDescription::Conductor { fresnel, .. } => {
                self.conductor(place, Element::plugin("bsdf", "conductor"), fresnel)?
            }
            BsdfDescription::RoughConductor { alpha, fresnel, .. } => {
                let rough = self.rough("roughconductor", alpha, place)?;
                self.conductor(place, rough, fresnel)?
            }
            BsdfDescription::Dielectric { interior_ior, exterior_ior, .. } => {
                dielectric(Element::plugin("bsdf", "dielectric"), *interior_ior, *exterior_ior)
            }
            BsdfDescription::RoughDielectric { alpha, interior_ior, exterior_ior, .. } => {
                dielectric(self.rough("roughdielectric", alpha, place)?, *interior_ior, *exterior_ior)
            }
            BsdfDescription::ThinDielectric { .. }
            | BsdfDescription::Plastic { .. }
            | BsdfDescription::RoughPlastic { .. }
            | BsdfDescription::Principled(_) => {
                return Err(ExportError::unsupported(&self.scene.name, place, "this model yet", "choose another"));
            }
            BsdfDescription::Gltf(_) => {
                let (what, remedy) = ("glTF's own material", "export with --materials principled");
                return Err(ExportError::unsupported(&self.scene.name, place, what, remedy));
            }
            BsdfDescription::Null => Element::plugin("bsdf", "null"),
            BsdfDescription::TwoSided { front, back } => {
                let element = Element::plugin("bsdf", "twosided").child(self.bsdf(front, place)?);
                if front == back { element } else { element.child(self.bsdf(back, place)?) }
            }
            BsdfDescription::Mask { opacity, nested } => {
                let element = Element::plugin("bsdf", "mask").child(self.bsdf(nested, place)?);
                self.number(element, "opacity", opacity, place)?
            }
            BsdfDescription::Blend { weight, first, second } => {
                let element = Element::plugin("bsdf", "blendbsdf");
                let element = element.child(self.bsdf(first, place)?).child(self.bsdf(second, place)?);
                self.number(element, "weight", weight, place)?
            }
            BsdfDescription::Perturbed { normal, nested } => {
                let nested = self.bsdf(nested, place)?;
                self.perturbed(normal, nested, place)?
            }
        })
    }

    fn perturbed(&mut self, normal: &NormalSource, nested: Element, place: &str) -> Result<Element, ExportError> {
        let unsupported = |what: &str, remedy: &str| ExportError::unsupported(&self.scene.name, place, what, remedy);
        match normal {
            NormalSource::Map { against_v: true, .. } => {
                Err(unsupported("normal maps whose second axis goes against v, as glTF has them", "leave the map out"))
            }
            NormalSource::Map { scale, .. } if *scale != [1.0; 2] => {
                Err(unsupported("normal maps with a scale", "bake it into the image"))
            }
            NormalSource::Map { texture, .. } => {
                let map = self.images.element(texture, true, "normalmap", self.scene, place)?;
                Ok(Element::plugin("bsdf", "normalmap").child(map).child(nested))
            }
            NormalSource::Bump { texture, scale } => {
                let map = self.images.element(texture, true, "arbitrary", self.scene, place)?;
                Ok(Element::plugin("bsdf", "bumpmap").child(map).float("scale", *scale).child(nested))
            }
        }
    }

    fn rough(&mut self, plugin: &str, alpha: &Parameter<f64>, place: &str) -> Result<Element, ExportError> {
        let element = Element::plugin("bsdf", plugin).string("distribution", "ggx");
        self.number(element, "alpha", alpha, place)
    }

    fn conductor(&self, place: &str, element: Element, fresnel: &ConductorFresnel) -> Result<Element, ExportError> {
        match fresnel {
            ConductorFresnel::Ior { eta, k } => Ok(element.rgb("eta", *eta).rgb("k", *k)),
            ConductorFresnel::Tint { specular_tint } => {
                self.check_share(place, *specular_tint)?;
                Ok(element.string("material", "none").rgb("specular_reflectance", *specular_tint))
            }
        }
    }

    /// A reflectance.
    fn share(
        &mut self,
        element: Element,
        name: &str,
        value: &Parameter<Rgb>,
        place: &str,
    ) -> Result<Element, ExportError> {
        match value {
            Parameter::Constant(value) => {
                self.check_share(place, *value)?;
                Ok(element.rgb(name, *value))
            }
            Parameter::Texture(texture) => {
                Ok(element.child(self.images.element(texture, false, name, self.scene, place)?))
            }
        }
    }

    fn number(
        &mut self,
        element: Element,
        name: &str,
        value: &Parameter<f64>,
        place: &str,
    ) -> Result<Element, ExportError> {
        match value {
            Parameter::Constant(value) => Ok(element.float(name, *value)),
            Parameter::Texture(texture) => {
                Ok(element.child(self.images.element(texture, true, name, self.scene, place)?))
            }
        }
    }

    /// Mitsuba refuses a reflectance outside `[0, 1]`.
    fn check_share(&self, place: &str, value: Rgb) -> Result<(), ExportError> {
        if value.to_array().iter().all(|channel| (0.0..=1.0).contains(channel)) {
            return Ok(());
        }
        let what = format!("a reflectance outside [0, 1] ({:?})", value.to_array());
        Err(ExportError::unsupported(&self.scene.name, place, what, "reduce it"))
    }
}

/// What Mitsuba's `twosided` refuses or has no effect on.
fn has_two_sides(description: &BsdfDescription) -> bool {
    match description {
        BsdfDescription::Dielectric { .. }
        | BsdfDescription::RoughDielectric { .. }
        | BsdfDescription::Null
        | BsdfDescription::Mask { .. }
        | BsdfDescription::TwoSided { .. } => true,
        other => other.nested().into_iter().any(has_two_sides),
    }
}

fn dielectric(element: Element, interior_ior: f64, exterior_ior: f64) -> Element {
    element.float("int_ior", interior_ior).float("ext_ior", exterior_ior)
}
