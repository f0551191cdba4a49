//! From what a file says about a material to a model of scattering.

use thiserror::Error;

use super::fresnel::Interface;
use super::{
    Bsdf, Conductor, Dielectric, Diffuse, Gltf, Microfacets, RoughConductor, RoughDielectric, ThinDielectric, Tints,
    gltf,
};
use crate::scene::description::{BsdfDescription, ConductorFresnel, GltfDescription, MicrofacetKind};
use crate::scene::texture::{Parameter, SurfacePoint, clamped};
use crate::spectrum::Rgb;

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

const ALPHA_RANGE: &str = "1e-8 … 10";
const INDEX_RANGE: &str = "0.01 … 100";

/// Below this width `α |η − 1|` of the refracted lobe, directions in double precision hold less than four of its digits.
const NARROWEST_REFRACTION: f64 = 1e-12;

/// Where a model's parameters come from: a file, which may be wrong, or the textures at a point, which are clamped.
trait Source {
    fn share(&mut self, parameter: &'static str, of: &Parameter<Rgb>) -> Rgb;
    fn alpha(&mut self, parameter: &'static str, of: &Parameter<f64>, smooth: Smooth) -> f64;
    fn interface(&mut self, interior_ior: f64, exterior_ior: f64) -> Interface;
    fn fresnel(&mut self, fresnel: &ConductorFresnel) -> ConductorFresnel;
    fn gltf(&mut self, description: &GltfDescription) -> Gltf;

    fn tints(&mut self, reflectance: &Parameter<Rgb>, transmittance: &Parameter<Rgb>) -> Tints {
        Tints {
            reflectance: self.share("reflectance", reflectance),
            transmittance: self.share("transmittance", transmittance),
        }
    }

    /// α along u and v.
    fn alphas(&mut self, alpha: &Parameter<f64>, alpha_v: &Option<Parameter<f64>>, smooth: Smooth) -> [f64; 2] {
        let along_u = self.alpha("alpha", alpha, smooth);
        [along_u, alpha_v.as_ref().map_or(along_u, |alpha_v| self.alpha("alpha_v", alpha_v, smooth))]
    }
}

/// The model without roughness, and what it is a model of.
#[derive(Clone, Copy)]
struct Smooth(&'static str, &'static str);

const SMOOTH_METAL: Smooth = Smooth("conductor", "a smooth metal");
const SMOOTH_GLASS: Smooth = Smooth("dielectric", "smooth glass");

/// Constants as they stand; textures count as their middle. Remembers the first fault.
struct Checked {
    fault: Option<MaterialError>,
}

impl Checked {
    fn take<T>(&mut self, result: Result<T, MaterialError>, otherwise: T) -> T {
        result.unwrap_or_else(|fault| {
            self.fault.get_or_insert(fault);
            otherwise
        })
    }
}

impl Source for Checked {
    fn share(&mut self, parameter: &'static str, of: &Parameter<Rgb>) -> Rgb {
        let value = of.constant().copied().unwrap_or(Rgb::grey(0.5));
        self.take(share(parameter, value), Rgb::BLACK)
    }

    fn alpha(&mut self, parameter: &'static str, of: &Parameter<f64>, smooth: Smooth) -> f64 {
        self.take(alpha(parameter, of.constant().copied().unwrap_or(0.5), smooth), 1.0)
    }

    fn interface(&mut self, interior_ior: f64, exterior_ior: f64) -> Interface {
        self.take(interface(interior_ior, exterior_ior), Interface::new(1.0, 1.0))
    }

    fn fresnel(&mut self, fresnel: &ConductorFresnel) -> ConductorFresnel {
        self.take(checked_fresnel(fresnel), ConductorFresnel::Tint { specular_tint: Rgb::BLACK })
    }

    fn gltf(&mut self, description: &GltfDescription) -> Gltf {
        self.take(gltf::check(description), ());
        Gltf::typical(description)
    }
}

impl Source for &SurfacePoint<'_> {
    fn share(&mut self, _: &'static str, of: &Parameter<Rgb>) -> Rgb {
        of.at(self).map(|x| clamped(x, 0.0, 1.0))
    }

    fn alpha(&mut self, _: &'static str, of: &Parameter<f64>, _: Smooth) -> f64 {
        clamped(of.at(self), SMALLEST_TEXTURED_ALPHA, 10.0)
    }

    fn interface(&mut self, interior_ior: f64, exterior_ior: f64) -> Interface {
        Interface::new(interior_ior, exterior_ior)
    }

    fn fresnel(&mut self, fresnel: &ConductorFresnel) -> ConductorFresnel {
        fresnel.clone()
    }

    fn gltf(&mut self, description: &GltfDescription) -> Gltf {
        Gltf::at(description, self)
    }
}

/// What a texture of roughness is raised to: Mitsuba has the same limit.
const SMALLEST_TEXTURED_ALPHA: f64 = 1e-4;

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
        let mut source = Checked { fault: None };
        let bsdf = Self::leaf(description, &mut source).ok_or(MaterialError::Composite);
        source.fault.map_or(bsdf, Err)
    }

    /// The same at one point of a surface, with the values of its textures there, clamped to what the model can use. `None`
    /// for composites.
    #[must_use]
    pub fn at(description: &BsdfDescription, mut at: &SurfacePoint<'_>) -> Option<Self> {
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
            BsdfDescription::Gltf(gltf) => Self::Gltf(Box::new(source.gltf(gltf))),
            BsdfDescription::Plastic { .. }
            | BsdfDescription::RoughPlastic { .. }
            | BsdfDescription::Principled(_)
            | BsdfDescription::Null
            | BsdfDescription::TwoSided { .. }
            | BsdfDescription::Mask { .. }
            | BsdfDescription::Blend { .. }
            | BsdfDescription::Perturbed { .. } => return None,
        })
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

fn alpha(parameter: &'static str, value: f64, Smooth(smooth, substance): Smooth) -> Result<f64, MaterialError> {
    if (1e-8..=10.0).contains(&value) {
        Ok(value)
    } else if (0.0..1e-8).contains(&value) {
        Err(MaterialError::Smooth { parameter, value, smooth, substance })
    } else {
        Err(MaterialError::Number { parameter, value, range: ALPHA_RANGE })
    }
}

fn interface(interior_ior: f64, exterior_ior: f64) -> Result<Interface, MaterialError> {
    for (parameter, value) in [("interior_ior", interior_ior), ("exterior_ior", exterior_ior)] {
        if !(0.01..=100.0).contains(&value) {
            return Err(MaterialError::Number { parameter, value, range: INDEX_RANGE });
        }
    }
    Ok(Interface::new(interior_ior, exterior_ior))
}

fn checked_fresnel(fresnel: &ConductorFresnel) -> Result<ConductorFresnel, MaterialError> {
    match fresnel {
        ConductorFresnel::Tint { specular_tint } => share("specular_tint", *specular_tint).map(drop)?,
        ConductorFresnel::Ior { eta, k } => {
            channels("eta", *eta, 1e6, "0 … 1e6")?;
            channels("k", *k, 1e6, "0 … 1e6")?;
        }
    }
    Ok(fresnel.clone())
}

pub(super) fn share(parameter: &'static str, value: Rgb) -> Result<Rgb, MaterialError> {
    channels(parameter, value, 1.0, "0 … 1")
}

fn channels(parameter: &'static str, rgb: Rgb, max: f64, range: &'static str) -> Result<Rgb, MaterialError> {
    for (channel, value) in ["red", "green", "blue"].into_iter().zip(rgb.to_array()) {
        if !(0.0..=max).contains(&value) {
            return Err(MaterialError::Channel { parameter, channel, value, range });
        }
    }
    Ok(rgb)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

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
