//! Where a model's parameters come from, and what they may be.

use std::ops::RangeInclusive;
use std::sync::Arc;

use super::fresnel::Interface;
use super::{Base, Gltf, MaterialError, Microfacets, RoughCoat, Tints, gltf};
use crate::scene::description::{ConductorFresnel, GltfDescription};
use crate::scene::texture::{Parameter, SurfacePoint, clamped};
use crate::spectrum::Rgb;

pub(super) const ALPHA_RANGE: &str = "1e-8 … 10";
const INDEX_RANGE: &str = "0.01 … 100";
const INDICES: RangeInclusive<f64> = 0.01..=100.0;

/// Where a model's parameters come from: a file, which may be wrong, or the textures at a point, which are clamped.
pub(super) trait Source {
    fn share(&mut self, parameter: &'static str, of: &Parameter<Rgb>) -> Rgb;
    fn alpha(&mut self, parameter: &'static str, of: &Parameter<f64>, smooth: Smooth) -> f64;
    fn interface(&mut self, interior_ior: f64, exterior_ior: f64) -> Interface;
    fn fresnel(&mut self, fresnel: &ConductorFresnel) -> ConductorFresnel;
    fn number(&mut self, parameter: &'static str, of: &Parameter<f64>) -> f64;
    fn eta(&mut self, eta: f64) -> f64;
    fn gltf(&mut self, description: &GltfDescription) -> Gltf;
    /// `None` where it would have to be integrated anew for each point.
    fn coat(&mut self, distribution: Microfacets, interface: Interface) -> Option<Arc<RoughCoat>>;

    fn base(&mut self, diffuse: &Parameter<Rgb>, specular: &Parameter<Rgb>, nonlinear: bool) -> Base {
        Base { diffuse: self.share("diffuse", diffuse), specular: self.share("specular", specular), nonlinear }
    }

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
pub(super) struct Smooth(&'static str, &'static str);

pub(super) const SMOOTH_METAL: Smooth = Smooth("conductor", "a smooth metal");
pub(super) const SMOOTH_COAT: Smooth = Smooth("plastic", "a smooth coat");
pub(super) const SMOOTH_GLASS: Smooth = Smooth("dielectric", "smooth glass");

/// Constants as they stand; textures count as their middle. Remembers the first fault.
#[derive(Default)]
pub(super) struct Checked {
    pub(super) fault: Option<MaterialError>,
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

    fn number(&mut self, parameter: &'static str, of: &Parameter<f64>) -> f64 {
        let value = of.constant().copied().unwrap_or(0.5);
        let fault = MaterialError::Number { parameter, value, range: "0 … 1" };
        self.take(if (0.0..=1.0).contains(&value) { Ok(value) } else { Err(fault) }, 0.0)
    }

    fn eta(&mut self, value: f64) -> f64 {
        let fault = MaterialError::Number { parameter: "eta", value, range: INDEX_RANGE };
        self.take(if INDICES.contains(&value) { Ok(value) } else { Err(fault) }, 1.5)
    }

    fn gltf(&mut self, description: &GltfDescription) -> Gltf {
        self.take(gltf::check(description), ());
        Gltf::typical(description)
    }

    fn coat(&mut self, distribution: Microfacets, interface: Interface) -> Option<Arc<RoughCoat>> {
        // Not for parameters that are refused in the end.
        self.fault.is_none().then(|| Arc::new(RoughCoat::new(distribution, interface)))
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

    fn number(&mut self, _: &'static str, of: &Parameter<f64>) -> f64 {
        clamped(of.at(self), 0.0, 1.0)
    }

    fn eta(&mut self, eta: f64) -> f64 {
        eta
    }

    fn gltf(&mut self, description: &GltfDescription) -> Gltf {
        Gltf::at(description, self)
    }

    fn coat(&mut self, _: Microfacets, _: Interface) -> Option<Arc<RoughCoat>> {
        None
    }
}

/// What a texture of roughness is raised to: Mitsuba has the same limit.
const SMALLEST_TEXTURED_ALPHA: f64 = 1e-4;

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
        if !INDICES.contains(&value) {
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
