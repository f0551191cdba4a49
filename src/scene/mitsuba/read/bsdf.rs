//! `<bsdf>`: the models of Mitsuba with its defaults.

use super::fault::{Fault, Result};
use super::ior;
use super::node::Kind;
use super::props::Props;
use super::reader::Reader;
use super::spectrum::Role;
use super::texture::constant;
use crate::names::did_you_mean;
use crate::scene::description::{
    BsdfDescription, ConductorFresnel, MicrofacetKind, NormalSource, PrincipledDescription,
};
use crate::scene::texture::{Parameter, Texture};
use crate::spectrum::Rgb;

/// Deepest nesting of models, by references too.
const DEEPEST: usize = 16;

const PLUGINS: [&str; 15] = [
    "diffuse",
    "conductor",
    "roughconductor",
    "dielectric",
    "thindielectric",
    "roughdielectric",
    "plastic",
    "roughplastic",
    "principled",
    "twosided",
    "mask",
    "blendbsdf",
    "bumpmap",
    "normalmap",
    "null",
];

impl Reader<'_> {
    /// The model of an object.
    pub(super) fn bsdf(&mut self, index: usize, depth: usize) -> Result<BsdfDescription> {
        if let Some(known) = self.bsdfs.get(&index) {
            return Ok(known.clone());
        }
        let props = Props::new(self.document, index);
        if depth > DEEPEST {
            let problem = format!("is nested more than {DEEPEST} deep");
            return Err(props.wrong(problem, "flatten it"));
        }
        let description = self.model(&props, depth)?;
        props.finish()?;
        self.bsdfs.insert(index, description.clone());
        Ok(description)
    }

    fn model(&mut self, props: &Props<'_>, depth: usize) -> Result<BsdfDescription> {
        Ok(match props.node.plugin.as_str() {
            "diffuse" => BsdfDescription::Diffuse { reflectance: self.share(props, "reflectance", 0.5)? },
            "conductor" => BsdfDescription::Conductor {
                fresnel: self.fresnel(props)?,
                reflectance: self.share(props, "specular_reflectance", 1.0)?,
            },
            "roughconductor" => {
                let (distribution, alpha, alpha_v) = self.roughness(props)?;
                BsdfDescription::RoughConductor {
                    distribution,
                    alpha,
                    alpha_v,
                    fresnel: self.fresnel(props)?,
                    reflectance: self.share(props, "specular_reflectance", 1.0)?,
                }
            }
            "dielectric" => BsdfDescription::Dielectric {
                interior_ior: ior::read(props, "int_ior", ior::BK7)?,
                exterior_ior: ior::read(props, "ext_ior", ior::AIR)?,
                reflectance: self.share(props, "specular_reflectance", 1.0)?,
                transmittance: self.share(props, "specular_transmittance", 1.0)?,
            },
            "thindielectric" => BsdfDescription::ThinDielectric {
                interior_ior: ior::read(props, "int_ior", ior::BK7)?,
                exterior_ior: ior::read(props, "ext_ior", ior::AIR)?,
                reflectance: self.share(props, "specular_reflectance", 1.0)?,
                transmittance: self.share(props, "specular_transmittance", 1.0)?,
            },
            "roughdielectric" => {
                let (distribution, alpha, alpha_v) = self.roughness(props)?;
                let interior_ior = ior::read(props, "int_ior", ior::BK7)?;
                let exterior_ior = ior::read(props, "ext_ior", ior::AIR)?;
                if interior_ior == exterior_ior {
                    return Err(props.wrong("has the same index of refraction on both sides", "make them differ"));
                }
                BsdfDescription::RoughDielectric {
                    distribution,
                    alpha,
                    alpha_v,
                    interior_ior,
                    exterior_ior,
                    reflectance: self.share(props, "specular_reflectance", 1.0)?,
                    transmittance: self.share(props, "specular_transmittance", 1.0)?,
                }
            }
            "plastic" => BsdfDescription::Plastic {
                interior_ior: ior::read(props, "int_ior", ior::POLYPROPYLENE)?,
                exterior_ior: ior::read(props, "ext_ior", ior::AIR)?,
                diffuse: self.share(props, "diffuse_reflectance", 0.5)?,
                specular: self.share(props, "specular_reflectance", 1.0)?,
                nonlinear: props.boolean_or("nonlinear", false)?,
            },
            "roughplastic" => self.rough_plastic(props)?,
            "principled" => BsdfDescription::Principled(Box::new(self.principled(props)?)),
            "twosided" => {
                let nested = self.nested(props, 1..=2, depth)?;
                // It says that what passes is wanted; nothing here passes.
                props.ignore(&["allow_transmission"]);
                if nested.iter().any(transmits) {
                    let problem = "holds a model that transmits light";
                    return Err(props.wrong(problem, "such a model has two sides already: take it out"));
                }
                let back = nested.last().cloned().unwrap_or(BsdfDescription::Null);
                let front = nested.into_iter().next().unwrap_or(BsdfDescription::Null);
                BsdfDescription::TwoSided { front: front.into(), back: back.into() }
            }
            "mask" => {
                let opacity = self.number(props, "opacity", 0.5)?;
                let nested = self.nested(props, 1..=1, depth)?;
                BsdfDescription::Mask { opacity, nested: only(nested) }
            }
            "blendbsdf" => {
                if !props.has("weight") {
                    return Err(props.wrong("has no weight", "add one"));
                }
                let weight = self.number(props, "weight", 0.5)?;
                let mut nested = self.nested(props, 2..=2, depth)?.into_iter();
                let mut next = || Box::new(nested.next().unwrap_or(BsdfDescription::Null));
                BsdfDescription::Blend { weight, first: next(), second: next() }
            }
            "bumpmap" | "normalmap" => self.perturbed(props, depth)?,
            "null" => BsdfDescription::Null,
            other => {
                let problem = format!("is the unsupported model {other:?}{}", did_you_mean(other, PLUGINS));
                return Err(props.wrong(problem, format!("use one of {}", PLUGINS.join(", "))));
            }
        })
    }

    fn share(&mut self, props: &Props<'_>, name: &'static str, default: f64) -> Result<Parameter<Rgb>> {
        let colour = self.textures.colour(self.document, props, name, Role::Share, &mut self.warnings)?;
        Ok(colour.unwrap_or(Rgb::grey(default).into()))
    }

    fn number(&mut self, props: &Props<'_>, name: &'static str, default: f64) -> Result<Parameter<f64>> {
        let number = self.textures.number(self.document, props, name, &mut self.warnings)?;
        Ok(number.unwrap_or(default.into()))
    }

    fn nested(
        &mut self,
        props: &Props<'_>,
        count: std::ops::RangeInclusive<usize>,
        depth: usize,
    ) -> Result<Vec<BsdfDescription>> {
        let objects = props.objects(Kind::Bsdf);
        if !count.contains(&objects.len()) {
            let wanted = if count.start() == count.end() {
                count.start().to_string()
            } else {
                format!("{} or {}", count.start(), count.end())
            };
            return Err(props.wrong(format!("holds {} models", objects.len()), format!("put {wanted} into it")));
        }
        objects.into_iter().map(|(index, _)| self.bsdf(index, depth + 1)).collect()
    }

    fn fresnel(&mut self, props: &Props<'_>) -> Result<ConductorFresnel> {
        let material = props.text("material")?.unwrap_or("none");
        if material != "none" && !props.has("eta") {
            let (eta, k) = ior::metal(props, material)?;
            return Ok(ConductorFresnel::Ior { eta, k });
        }
        if material != "none" {
            return Err(props.wrong("has a material and eta", "give one of the two"));
        }
        let number = |name: &'static str, default: f64| match props.get(name) {
            None => Ok(Rgb::grey(default)),
            Some(property) => {
                if let super::node::Value::Object(index) = property.value
                    && matches!(
                        self.document.nodes[index].plugin.as_str(),
                        "bitmap" | "checkerboard" | "mesh_attribute"
                    )
                {
                    let problem = format!("a textured {name} is not supported");
                    return Err(Fault::new(
                        &property.place,
                        problem,
                        "give a colour, and a textured specular_reflectance",
                    ));
                }
                self.textures
                    .colour(self.document, props, name, Role::Unbounded, &mut self.warnings)?
                    .and_then(|colour| colour.constant().copied())
                    .map_or_else(|| constant(property, Role::Unbounded), Ok)
            }
        };
        let mut number = number;
        let (eta, k) = (number("eta", 0.0)?, number("k", 1.0)?);
        if eta.min_component() < 0.0 || k.min_component() < 0.0 {
            return Err(props.wrong("has a negative index of refraction", "give eta and k from 0 on"));
        }
        // A perfect mirror: with eta = 0 everything is reflected, at every angle.
        if eta == Rgb::BLACK {
            return Ok(ConductorFresnel::Tint { specular_tint: Rgb::WHITE });
        }
        Ok(ConductorFresnel::Ior { eta, k })
    }

    fn distribution(props: &Props<'_>) -> Result<MicrofacetKind> {
        // Which half vectors are drawn, not which there are.
        props.ignore(&["sample_visible"]);
        props.choice("distribution", &[("beckmann", MicrofacetKind::Beckmann), ("ggx", MicrofacetKind::Ggx)])
    }

    fn roughness(&mut self, props: &Props<'_>) -> Result<(MicrofacetKind, Parameter<f64>, Option<Parameter<f64>>)> {
        let distribution = Self::distribution(props)?;
        if !props.has("alpha_u") && !props.has("alpha_v") {
            return Ok((distribution, self.number(props, "alpha", 0.1)?, None));
        }
        if !props.has("alpha_u") || !props.has("alpha_v") || props.has("alpha") {
            let problem = "has one of alpha_u and alpha_v, or alpha beside them";
            return Err(props.wrong(problem, "give alpha alone, or alpha_u and alpha_v"));
        }
        let along_u = self.number(props, "alpha_u", 0.1)?;
        let along_v = self.number(props, "alpha_v", 0.1)?;
        Ok(if along_u == along_v { (distribution, along_u, None) } else { (distribution, along_u, Some(along_v)) })
    }

    fn rough_plastic(&mut self, props: &Props<'_>) -> Result<BsdfDescription> {
        let (distribution, alpha, alpha_v) = self.roughness(props)?;
        if alpha_v.is_some() {
            return Err(props.wrong("is anisotropic, which Mitsuba does not support either", "give alpha"));
        }
        let Some(&alpha) = alpha.constant() else {
            return Err(props.fault(
                "alpha",
                "is textured, which Mitsuba does not support either".into(),
                "give a number".into(),
            ));
        };
        Ok(BsdfDescription::RoughPlastic {
            distribution,
            alpha,
            interior_ior: ior::read(props, "int_ior", ior::POLYPROPYLENE)?,
            exterior_ior: ior::read(props, "ext_ior", ior::AIR)?,
            diffuse: self.share(props, "diffuse_reflectance", 0.5)?,
            specular: self.share(props, "specular_reflectance", 1.0)?,
            nonlinear: props.boolean_or("nonlinear", false)?,
        })
    }

    fn principled(&mut self, props: &Props<'_>) -> Result<PrincipledDescription> {
        // How often which lobe is drawn.
        props.ignore(&["main_specular_sampling_rate", "clearcoat_sampling_rate", "diffuse_reflectance_sampling_rate"]);
        let spec_trans = self.number(props, "spec_trans", 0.0)?;
        let transmits = spec_trans.constant().is_none_or(|&x| x > 0.0);
        if props.has("eta") && props.has("specular") {
            return Err(props.wrong("has eta and specular", "give one of the two"));
        }
        let eta = match props.float("eta")? {
            Some(1.0) if transmits => 1.001,
            Some(eta) => eta,
            None => match props.float_or("specular", 0.5)? {
                0.0 if transmits => eta_of_specular(1e-3),
                specular => eta_of_specular(specular),
            },
        };
        if !(eta.is_finite() && eta > 0.0) {
            return Err(
                props.wrong("has no index of refraction above zero", "give eta above 0, or specular from 0 to 1")
            );
        }
        Ok(PrincipledDescription {
            base_color: self.share(props, "base_color", 0.5)?,
            roughness: self.number(props, "roughness", 0.5)?,
            anisotropic: self.number(props, "anisotropic", 0.0)?,
            metallic: self.number(props, "metallic", 0.0)?,
            spec_trans,
            eta,
            spec_tint: self.number(props, "spec_tint", 0.0)?,
            sheen: self.number(props, "sheen", 0.0)?,
            sheen_tint: self.number(props, "sheen_tint", 0.0)?,
            flatness: self.number(props, "flatness", 0.0)?,
            clearcoat: self.number(props, "clearcoat", 0.0)?,
            clearcoat_gloss: self.number(props, "clearcoat_gloss", 0.0)?,
        })
    }

    fn perturbed(&mut self, props: &Props<'_>, depth: usize) -> Result<BsdfDescription> {
        for name in ["flip_invalid_normals", "use_shadowing_function"] {
            if !props.boolean_or(name, true)? {
                let remedy = "remove it: true is what is supported";
                return Err(props.fault(name, "is false, which is not supported".into(), remedy.into()));
            }
        }
        let nested = only(self.nested(props, 1..=1, depth)?);
        let textures = props.objects(Kind::Texture);
        let [(index, property)] = textures.as_slice() else {
            let problem = format!("holds {} textures", textures.len());
            return Err(props.wrong(problem, "put one into it"));
        };
        let bump = props.node.plugin == "bumpmap";
        if !bump && property.name != "normalmap" {
            return Err(Fault::new(&property.place, "has another name than normalmap", "name it so"));
        }
        let texture = self.textures.object(self.document, *index, property, Role::Unbounded, &mut self.warnings)?;
        let texture = match texture {
            Parameter::Texture(texture) => texture,
            Parameter::Constant(Rgb { r, g, b }) => Texture::Constant([r, g, b, 1.0]).into(),
        };
        let normal = if bump {
            NormalSource::Bump { texture, scale: props.float_or("scale", 1.0)? }
        } else {
            NormalSource::Map { texture, scale: [1.0; 2], against_v: false }
        };
        Ok(BsdfDescription::Perturbed { normal, nested })
    }
}

/// The index of refraction of which `specular` is a name for: F₀ = 0.08 specular.
fn eta_of_specular(specular: f64) -> f64 {
    2.0 / (1.0 - (0.08 * specular).sqrt()) - 1.0
}

fn only(nested: Vec<BsdfDescription>) -> Box<BsdfDescription> {
    Box::new(nested.into_iter().next().unwrap_or(BsdfDescription::Null))
}

/// Light passes from one side to the other.
fn transmits(description: &BsdfDescription) -> bool {
    match description {
        BsdfDescription::Dielectric { .. }
        | BsdfDescription::ThinDielectric { .. }
        | BsdfDescription::RoughDielectric { .. }
        | BsdfDescription::Null
        | BsdfDescription::Mask { .. } => true,
        BsdfDescription::Principled(principled) => principled.spec_trans.constant().is_none_or(|&x| x > 0.0),
        other => other.nested().into_iter().any(transmits),
    }
}
