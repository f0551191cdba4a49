//! From what a file says about a material to a model of scattering.

use thiserror::Error;

use super::fresnel::Interface;
use super::principled::Shares;
use super::rough_plastic::RoughPlasticAt;
use super::source::{ALPHA_RANGE, Checked, SMOOTH_COAT, SMOOTH_GLASS, SMOOTH_METAL, Source};
use super::{
    Bsdf, Conductor, Dielectric, Diffuse, Microfacets, Plastic, Principled, RoughConductor, RoughDielectric,
    RoughPlastic, ThinDielectric, Tints,
};
use crate::scene::description::{BsdfDescription, MicrofacetKind, PrincipledDescription};
use crate::scene::texture::SurfacePoint;

/// A material's parameter that no model can use. The message says which and what would be right, not where: the caller
/// knows the file and the name.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum MaterialError {
    /// A number out of its range.
    #[error("{parameter} = {value} is outside {range}")]
    Number {
        /// Name of the parameter as in [`BsdfDescription`].
        parameter: &'static str,
        /// What it is.
        value: f64,
        /// What it may be.
        range: &'static str,
    },
    /// One channel of a colour out of its range.
    #[error("{parameter} = {value} in the {channel} channel is outside {range}")]
    Channel {
        /// Name of the parameter as in [`BsdfDescription`].
        parameter: &'static str,
        /// Red, green or blue.
        channel: &'static str,
        /// What it is.
        value: f64,
        /// What it may be.
        range: &'static str,
    },
    /// A roughness that no microfacets can have.
    #[error("{parameter} = {value} is outside {ALPHA_RANGE}: use `{smooth}` for {substance}")]
    Smooth {
        /// Name of the parameter as in [`BsdfDescription`].
        parameter: &'static str,
        /// What it is.
        value: f64,
        /// The model without roughness.
        smooth: &'static str,
        /// What it is a model of.
        substance: &'static str,
    },
    /// A composite where a single model is needed.
    #[error("a composite (two-sided, mask, blend, null, normal or bump map) cannot stand here")]
    Composite,
    /// A composite of what cannot be composed.
    #[error("{0}")]
    Composition(&'static str),
}

/// Below this width `α |η − 1|` of the refracted lobe, directions in double precision hold less than four of its digits.
const NARROWEST_REFRACTION: f64 = 1e-12;

impl Bsdf {
    /// The model that a file describes, where it is the same all over the surface and no composite.
    ///
    /// A rough dielectric whose refracted lobe is narrower than double precision can resolve, `α |η − 1| < 1e-12`, becomes
    /// a smooth one; with equal indices on both sides that is light going straight through. Where a parameter is a
    /// texture, one of its values stands for it.
    ///
    /// # Errors
    /// The first parameter that is out of its range or not a number.
    pub fn new(description: &BsdfDescription) -> Result<Self, MaterialError> {
        let mut source = Checked::default();
        let bsdf = Self::leaf(description, &mut source).ok_or(MaterialError::Composite);
        source.fault.map_or(bsdf, Err)
    }

    /// The same at one point of a surface, with the values of its textures there, clamped to what the model can use. `None`
    /// for composites, and for rough plastic, whose coat is shared: [`coated`] has that.
    #[must_use]
    pub(super) fn at(description: &BsdfDescription, mut at: &SurfacePoint<'_>) -> Option<Self> {
        Self::leaf(description, &mut at)
    }

    fn leaf(description: &BsdfDescription, source: &mut impl Source) -> Option<Self> {
        Some(match description {
            BsdfDescription::Diffuse { reflectance } => {
                Self::Diffuse(Diffuse { reflectance: source.share("reflectance", reflectance) })
            }
            BsdfDescription::Conductor { fresnel, reflectance } => Self::Conductor(Conductor {
                fresnel: source.fresnel(fresnel),
                reflectance: source.share("reflectance", reflectance),
            }),
            BsdfDescription::RoughConductor { distribution, alpha, alpha_v, fresnel, reflectance } => {
                Self::RoughConductor(RoughConductor {
                    distribution: Microfacets::new(*distribution, source.alphas(alpha, alpha_v, SMOOTH_METAL)),
                    fresnel: source.fresnel(fresnel),
                    reflectance: source.share("reflectance", reflectance),
                })
            }
            BsdfDescription::Dielectric { interior_ior, exterior_ior, reflectance, transmittance } => {
                Self::Dielectric(Dielectric {
                    interface: source.interface(*interior_ior, *exterior_ior),
                    tints: source.tints(reflectance, transmittance),
                })
            }
            BsdfDescription::ThinDielectric { interior_ior, exterior_ior, reflectance, transmittance } => {
                Self::ThinDielectric(ThinDielectric {
                    interface: source.interface(*interior_ior, *exterior_ior),
                    tints: source.tints(reflectance, transmittance),
                })
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
                let alphas = source.alphas(alpha, alpha_v, SMOOTH_GLASS);
                let interface = source.interface(*interior_ior, *exterior_ior);
                rough_dielectric(*distribution, alphas, interface, source.tints(reflectance, transmittance))
            }
            BsdfDescription::Plastic { interior_ior, exterior_ior, diffuse, specular, nonlinear } => {
                let interface = source.interface(*interior_ior, *exterior_ior);
                Self::Plastic(Plastic::new(interface, source.base(diffuse, specular, *nonlinear)))
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
                let alpha = source.alpha("alpha", &(*alpha).into(), SMOOTH_COAT);
                let interface = source.interface(*interior_ior, *exterior_ior);
                let base = source.base(diffuse, specular, *nonlinear);
                let coat = source.coat(Microfacets::new(*distribution, [alpha; 2]), interface)?;
                Self::RoughPlastic(RoughPlastic::new(coat, base))
            }
            BsdfDescription::Principled(parameters) => Self::Principled(Box::new(principled(parameters, source))),
            BsdfDescription::Gltf(gltf) => Self::Gltf(Box::new(source.gltf(gltf))),
            BsdfDescription::Null
            | BsdfDescription::TwoSided { .. }
            | BsdfDescription::Mask { .. }
            | BsdfDescription::Blend { .. }
            | BsdfDescription::Perturbed { .. } => return None,
        })
    }
}

fn principled(parameters: &PrincipledDescription, source: &mut impl Source) -> Principled {
    let shares = Shares {
        roughness: source.number("roughness", &parameters.roughness),
        anisotropic: source.number("anisotropic", &parameters.anisotropic),
        metallic: source.number("metallic", &parameters.metallic),
        spec_trans: source.number("spec_trans", &parameters.spec_trans),
        spec_tint: source.number("spec_tint", &parameters.spec_tint),
        sheen: source.number("sheen", &parameters.sheen),
        sheen_tint: source.number("sheen_tint", &parameters.sheen_tint),
        flatness: source.number("flatness", &parameters.flatness),
        clearcoat: source.number("clearcoat", &parameters.clearcoat),
        clearcoat_gloss: source.number("clearcoat_gloss", &parameters.clearcoat_gloss),
    };
    Principled::new(source.share("base_color", &parameters.base_color), shares, source.eta(parameters.eta))
}

/// Rough plastic at a point, with the coat of an example of it; `None` for other models.
pub(super) fn coated<'a>(
    example: &'a Bsdf,
    description: &BsdfDescription,
    mut at: &SurfacePoint<'_>,
) -> Option<RoughPlasticAt<'a>> {
    match (example, description) {
        (Bsdf::RoughPlastic(example), BsdfDescription::RoughPlastic { diffuse, specular, nonlinear, .. }) => {
            Some(RoughPlasticAt { coat: &example.coat, base: at.base(diffuse, specular, *nonlinear) })
        }
        _ => None,
    }
}

fn rough_dielectric(kind: MicrofacetKind, alphas: [f64; 2], interface: Interface, tints: Tints) -> Bsdf {
    let narrowest = alphas[0].min(alphas[1]);
    if narrowest * interface.contrast().abs() < NARROWEST_REFRACTION {
        Bsdf::Dielectric(Dielectric { interface, tints })
    } else {
        Bsdf::RoughDielectric(RoughDielectric { distribution: Microfacets::new(kind, alphas), interface, tints })
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::scene::description::ConductorFresnel;
    use crate::spectrum::Rgb;

    fn message(description: &BsdfDescription) -> String {
        Bsdf::new(description).expect_err("must be refused").to_string()
    }

    #[test]
    fn what_no_model_can_use_is_refused_by_name() {
        let tint = ConductorFresnel::Tint { specular_tint: Rgb::WHITE };
        let ior = |eta, k| ConductorFresnel::Ior { eta: Rgb::grey(eta), k: Rgb::new(1.0, k, 1.0) };
        let metal = |alpha: f64| BsdfDescription::rough_conductor(alpha, tint.clone());
        let glass = |alpha: f64, interior_ior| BsdfDescription::rough_dielectric(alpha, interior_ior, 1.0);
        for (description, expected) in [
            (
                BsdfDescription::Diffuse { reflectance: Rgb::new(0.1, 1.5, 0.1).into() },
                "reflectance = 1.5 in the green channel is outside 0 … 1",
            ),
            (
                BsdfDescription::Diffuse { reflectance: Rgb::new(f64::NAN, 0.5, 0.1).into() },
                "reflectance = NaN in the red channel is outside 0 … 1",
            ),
            (metal(0.0), "alpha = 0 is outside 1e-8 … 10: use `conductor` for a smooth metal"),
            (metal(-1.0), "alpha = -1 is outside 1e-8 … 10"),
            (metal(f64::NAN), "alpha = NaN is outside 1e-8 … 10"),
            (glass(1e-9, 1.5), "alpha = 0.000000001 is outside 1e-8 … 10: use `dielectric` for smooth glass"),
            (glass(0.1, 0.0), "interior_ior = 0 is outside 0.01 … 100"),
            (glass(0.1, f64::INFINITY), "interior_ior = inf is outside 0.01 … 100"),
            (BsdfDescription::conductor(ior(1.0, -0.5)), "k = -0.5 in the green channel is outside 0 … 1e6"),
            (BsdfDescription::conductor(ior(-0.5, 1.0)), "eta = -0.5 in the red channel is outside 0 … 1e6"),
        ] {
            assert_eq!(message(&description), expected);
        }
    }

    #[test]
    fn equal_indices_make_no_interface() {
        let glass = BsdfDescription::rough_dielectric(0.5, 1.3, 1.3);
        let Ok(Bsdf::Dielectric(smooth)) = Bsdf::new(&glass) else { panic!("must become smooth") };
        assert_eq!(smooth.interface.fresnel(0.3).transmitted, 1.0);
        let from = DVec3::new(0.8, 0.0, 0.6);
        assert_eq!(smooth.interface.refract(from, DVec3::Z, 0.6), Some(-from));
    }
}
