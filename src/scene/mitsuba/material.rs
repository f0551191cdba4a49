//! Materials as Mitsuba's BSDFs.

use std::path::Path;
use std::sync::Arc;

use super::error::ExportError;
use super::texture::Images;
use super::xml::Element;
use crate::scene::description::{
    BsdfDescription, ConductorFresnel, Material, MicrofacetKind, NormalSource, PrincipledDescription, SceneDescription,
};
use crate::scene::texture::{Parameter, Texture};
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

    /// The images that elements refer to.
    pub(super) fn images(&mut self) -> &mut Images {
        &mut self.images
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
            BsdfDescription::Conductor { fresnel, reflectance } => {
                self.conductor(Element::plugin("bsdf", "conductor"), fresnel, reflectance, place)?
            }
            BsdfDescription::RoughConductor { distribution, alpha, alpha_v, fresnel, reflectance } => {
                let rough = self.rough("roughconductor", *distribution, alpha, alpha_v.as_ref(), place)?;
                self.conductor(rough, fresnel, reflectance, place)?
            }
            BsdfDescription::Dielectric { interior_ior, exterior_ior, reflectance, transmittance } => {
                let element = indices(Element::plugin("bsdf", "dielectric"), *interior_ior, *exterior_ior);
                self.tints(element, reflectance, transmittance, place)?
            }
            BsdfDescription::ThinDielectric { interior_ior, exterior_ior, reflectance, transmittance } => {
                let element = indices(Element::plugin("bsdf", "thindielectric"), *interior_ior, *exterior_ior);
                self.tints(element, reflectance, transmittance, place)?
            }
            BsdfDescription::RoughDielectric {
                distribution,
                alpha,
                alpha_v,
                interior_ior,
                exterior_ior,
                reflectance,
                transmittance,
            } => {
                // Mitsuba refuses rough interfaces of equal indices, which bend nothing.
                let element = if interior_ior == exterior_ior {
                    Element::plugin("bsdf", "dielectric")
                } else {
                    self.rough("roughdielectric", *distribution, alpha, alpha_v.as_ref(), place)?
                };
                self.tints(indices(element, *interior_ior, *exterior_ior), reflectance, transmittance, place)?
            }
            BsdfDescription::Gltf(_) => {
                let (what, remedy) = ("glTF's own material", "export with --materials principled");
                return Err(ExportError::unsupported(&self.scene.name, place, what, remedy));
            }
            BsdfDescription::Plastic { interior_ior, exterior_ior, diffuse, specular, nonlinear } => {
                let element = indices(Element::plugin("bsdf", "plastic"), *interior_ior, *exterior_ior);
                self.base(element, diffuse, specular, *nonlinear, place)?
            }
            BsdfDescription::RoughPlastic {
                distribution,
                alpha,
                interior_ior,
                exterior_ior,
                diffuse,
                specular,
                nonlinear,
            } => {
                if interior_ior == exterior_ior {
                    let what = "a rough coat with the index of refraction of the outside";
                    return Err(ExportError::unsupported(&self.scene.name, place, what, "leave the coat out"));
                }
                let element = self.rough("roughplastic", *distribution, &(*alpha).into(), None, place)?;
                self.base(indices(element, *interior_ior, *exterior_ior), diffuse, specular, *nonlinear, place)?
            }
            BsdfDescription::Principled(parameters) => self.principled(parameters, place)?,
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

    fn rough(
        &mut self,
        plugin: &str,
        distribution: MicrofacetKind,
        alpha: &Parameter<f64>,
        alpha_v: Option<&Parameter<f64>>,
        place: &str,
    ) -> Result<Element, ExportError> {
        let name = match distribution {
            MicrofacetKind::Ggx => "ggx",
            MicrofacetKind::Beckmann => "beckmann",
        };
        let element = Element::plugin("bsdf", plugin).string("distribution", name);
        let Some(alpha_v) = alpha_v else { return self.number(element, "alpha", alpha, place) };
        let element = self.number(element, "alpha_u", alpha, place)?;
        self.number(element, "alpha_v", alpha_v, place)
    }

    fn conductor(
        &mut self,
        element: Element,
        fresnel: &ConductorFresnel,
        reflectance: &Parameter<Rgb>,
        place: &str,
    ) -> Result<Element, ExportError> {
        match fresnel {
            ConductorFresnel::Ior { eta, k } => {
                self.tint(element.rgb("eta", *eta).rgb("k", *k), "specular_reflectance", reflectance, place)
            }
            ConductorFresnel::Tint { specular_tint } => {
                self.check_share(place, *specular_tint)?;
                let product = times(*specular_tint, reflectance);
                self.share(element.string("material", "none"), "specular_reflectance", &product, place)
            }
        }
    }

    fn tints(
        &mut self,
        element: Element,
        reflectance: &Parameter<Rgb>,
        transmittance: &Parameter<Rgb>,
        place: &str,
    ) -> Result<Element, ExportError> {
        let element = self.tint(element, "specular_reflectance", reflectance, place)?;
        self.tint(element, "specular_transmittance", transmittance, place)
    }

    /// A factor, where it is not one.
    fn tint(
        &mut self,
        element: Element,
        name: &str,
        value: &Parameter<Rgb>,
        place: &str,
    ) -> Result<Element, ExportError> {
        if value.constant() == Some(&Rgb::WHITE) { Ok(element) } else { self.share(element, name, value, place) }
    }

    fn base(
        &mut self,
        element: Element,
        diffuse: &Parameter<Rgb>,
        specular: &Parameter<Rgb>,
        nonlinear: bool,
        place: &str,
    ) -> Result<Element, ExportError> {
        let element = self.share(element, "diffuse_reflectance", diffuse, place)?;
        Ok(self.tint(element, "specular_reflectance", specular, place)?.boolean("nonlinear", nonlinear))
    }

    fn principled(&mut self, parameters: &PrincipledDescription, place: &str) -> Result<Element, ExportError> {
        let element = Element::plugin("bsdf", "principled").float("eta", parameters.eta);
        let mut element = self.share(element, "base_color", &parameters.base_color, place)?;
        for (name, value) in parameters.numbers() {
            element = self.number(element, name, value, place)?;
        }
        Ok(element)
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
        | BsdfDescription::ThinDielectric { .. }
        | BsdfDescription::RoughDielectric { .. }
        | BsdfDescription::Null
        | BsdfDescription::Mask { .. }
        | BsdfDescription::TwoSided { .. } => true,
        BsdfDescription::Principled(parameters) => parameters.spec_trans.constant() != Some(&0.0),
        other => other.nested().into_iter().any(has_two_sides),
    }
}

fn indices(element: Element, interior_ior: f64, exterior_ior: f64) -> Element {
    element.float("int_ior", interior_ior).float("ext_ior", exterior_ior)
}

fn times(tint: Rgb, reflectance: &Parameter<Rgb>) -> Parameter<Rgb> {
    match reflectance {
        Parameter::Constant(value) => (*value * tint).into(),
        Parameter::Texture(_) if tint == Rgb::WHITE => reflectance.clone(),
        Parameter::Texture(texture) => {
            let tint = Texture::Constant([tint.r, tint.g, tint.b, 1.0]);
            Parameter::Texture(Arc::new(Texture::Product(vec![tint, (**texture).clone()])))
        }
    }
}
