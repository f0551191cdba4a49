//! How surfaces scatter and emit.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::gltf::GltfDescription;
use crate::scene::texture::{Parameter, Texture};
use crate::spectrum::Rgb;

/// How a surface scatters and what it emits.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in the file, for messages.
    pub name: String,
    /// How it scatters.
    pub bsdf: BsdfDescription,
    /// Both sides scatter alike. Otherwise the back absorbs. Dielectrics have an inside and ignore this.
    pub two_sided: bool,
    /// Radiance leaving the front in every direction \[W/m²/sr\]. The back never emits.
    pub emission: Parameter<Rgb>,
}

impl Material {
    /// It emits at all.
    #[must_use]
    pub fn emits(&self) -> bool {
        self.emission.constant() != Some(&Rgb::BLACK)
    }
}

/// How a surface scatters; in glTF the material's `extras.pathspace.bsdf` says those without a texture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum BsdfDescription {
    /// Lambert's: `f_s = reflectance / π`.
    Diffuse {
        /// Share of the flux that is reflected, 0 … 1.
        reflectance: Parameter<Rgb>,
    },
    /// Smooth metal or mirror.
    Conductor {
        /// What reflects how much.
        fresnel: ConductorFresnel,
        /// Factor of what is reflected, 0 … 1.
        #[serde(default = "white")]
        reflectance: Parameter<Rgb>,
    },
    /// Rough metal: microfacets, single scattering.
    RoughConductor {
        /// Which microfacets.
        #[serde(default)]
        distribution: MicrofacetKind,
        /// Roughness α, above 0; along u where there is another along v.
        alpha: Parameter<f64>,
        /// Roughness along v, where it is not the same as along u.
        #[serde(default)]
        alpha_v: Option<Parameter<f64>>,
        /// What reflects how much.
        fresnel: ConductorFresnel,
        /// Factor of what is reflected, 0 … 1.
        #[serde(default = "white")]
        reflectance: Parameter<Rgb>,
    },
    /// Smooth glass. The normal points to the outside.
    Dielectric {
        /// Index of refraction of the inside.
        interior_ior: f64,
        /// Index of refraction of the outside.
        #[serde(default = "one")]
        exterior_ior: f64,
        /// Factor of what is reflected, 0 … 1.
        #[serde(default = "white")]
        reflectance: Parameter<Rgb>,
        /// Factor of what is refracted, 0 … 1.
        #[serde(default = "white")]
        transmittance: Parameter<Rgb>,
    },
    /// A thin pane of smooth glass: two interfaces in one, which bend nothing.
    ThinDielectric {
        /// Index of refraction of the pane.
        interior_ior: f64,
        /// Index of refraction around it.
        #[serde(default = "one")]
        exterior_ior: f64,
        /// Factor of what is reflected, 0 … 1.
        #[serde(default = "white")]
        reflectance: Parameter<Rgb>,
        /// Factor of what passes, 0 … 1.
        #[serde(default = "white")]
        transmittance: Parameter<Rgb>,
    },
    /// Rough glass: microfacets, single scattering (Walter et al. 2007).
    RoughDielectric {
        /// Which microfacets.
        #[serde(default)]
        distribution: MicrofacetKind,
        /// Roughness α, above 0; along u where there is another along v.
        alpha: Parameter<f64>,
        /// Roughness along v, where it is not the same as along u.
        #[serde(default)]
        alpha_v: Option<Parameter<f64>>,
        /// Index of refraction of the inside.
        interior_ior: f64,
        /// Index of refraction of the outside.
        #[serde(default = "one")]
        exterior_ior: f64,
        /// Factor of what is reflected, 0 … 1.
        #[serde(default = "white")]
        reflectance: Parameter<Rgb>,
        /// Factor of what is refracted, 0 … 1.
        #[serde(default = "white")]
        transmittance: Parameter<Rgb>,
    },
    /// A diffuse base below a smooth coat of glass.
    Plastic {
        /// Index of refraction of the coat.
        interior_ior: f64,
        /// Index of refraction of the outside.
        #[serde(default = "one")]
        exterior_ior: f64,
        /// Reflectance of the base, 0 … 1.
        diffuse: Parameter<Rgb>,
        /// Factor of what the coat reflects, 0 … 1.
        #[serde(default = "white")]
        specular: Parameter<Rgb>,
        /// Colours shift by reflection between base and coat.
        #[serde(default)]
        nonlinear: bool,
    },
    /// A diffuse base below a rough coat of glass.
    RoughPlastic {
        /// Which microfacets.
        #[serde(default)]
        distribution: MicrofacetKind,
        /// Roughness α of the coat, above 0.
        alpha: f64,
        /// Index of refraction of the coat.
        interior_ior: f64,
        /// Index of refraction of the outside.
        #[serde(default = "one")]
        exterior_ior: f64,
        /// Reflectance of the base, 0 … 1.
        diffuse: Parameter<Rgb>,
        /// Factor of what the coat reflects, 0 … 1.
        #[serde(default = "white")]
        specular: Parameter<Rgb>,
        /// Colours shift by reflection between base and coat.
        #[serde(default)]
        nonlinear: bool,
    },
    /// Disney's model (Burley 2012, 2015) as Mitsuba 3 has it.
    #[serde(skip)]
    Principled(Box<PrincipledDescription>),
    /// glTF's own model.
    #[serde(skip)]
    Gltf(Box<GltfDescription>),
    /// Light goes straight through: there is no surface but in the count of edges.
    Null,
    /// One model for each side. Neither transmits.
    TwoSided {
        /// On the side that the normal points to.
        front: Box<BsdfDescription>,
        /// On the other, as if the normal pointed there.
        back: Box<BsdfDescription>,
    },
    /// The nested model by `opacity`, straight through by the rest.
    Mask {
        /// Share of the nested model, 0 … 1.
        opacity: Parameter<f64>,
        /// The nested model.
        nested: Box<BsdfDescription>,
    },
    /// `(1 − weight) first + weight second`.
    Blend {
        /// Share of the second model, 0 … 1.
        weight: Parameter<f64>,
        /// The model at weight 0.
        first: Box<BsdfDescription>,
        /// The model at weight 1.
        second: Box<BsdfDescription>,
    },
    /// The nested model under a turned normal.
    #[serde(skip)]
    Perturbed {
        /// What turns it.
        normal: NormalSource,
        /// The nested model.
        nested: Box<BsdfDescription>,
    },
}

/// What turns the shading normal of a point.
#[derive(Clone, Debug, PartialEq)]
pub enum NormalSource {
    /// A normal map: `2 · rgb − 1` in the frame of the tangent along u, the tangent at right angles to it, and the normal.
    Map {
        /// The map.
        texture: Arc<Texture>,
        /// Factors of the first two coordinates.
        scale: [f64; 2],
        /// The second axis follows v where this is true (glTF, against v), and normal × first axis otherwise (Mitsuba).
        against_v: bool,
    },
    /// A bump map: the surface displaced along its normal by a height \[m\] (Blinn 1978).
    Bump {
        /// The height.
        texture: Arc<Texture>,
        /// Its factor.
        scale: f64,
    },
}

/// How a metal's reflectance depends on the angle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, deny_unknown_fields)]
pub enum ConductorFresnel {
    /// Fresnel's equations with the complex index of refraction `eta + i k`, per channel, relative to the outside.
    Ior {
        /// Real part.
        eta: Rgb,
        /// Imaginary part, the extinction coefficient.
        k: Rgb,
    },
    /// The same reflectance at every angle.
    Tint {
        /// Share of the flux that is reflected, 0 … 1.
        specular_tint: Rgb,
    },
}

fn one() -> f64 {
    1.0
}

fn white() -> Parameter<Rgb> {
    Rgb::WHITE.into()
}

/// A family of microfacet distributions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MicrofacetKind {
    /// Trowbridge and Reitz (1975), Walter et al. (2007).
    #[default]
    Ggx,
    /// Beckmann and Spizzichino (1963), Walter et al. (2007).
    Beckmann,
}

/// The parameters of the principled model, by the names that Mitsuba 3 gives them. Shares are 0 … 1.
#[derive(Clone, Debug, PartialEq)]
pub struct PrincipledDescription {
    /// Colour of the diffuse base and of metal.
    pub base_color: Parameter<Rgb>,
    /// Square root of α.
    pub roughness: Parameter<f64>,
    /// How much rougher across the tangent than along it.
    pub anisotropic: Parameter<f64>,
    /// Share of metal.
    pub metallic: Parameter<f64>,
    /// Share of the non-metal that is glass.
    pub spec_trans: Parameter<f64>,
    /// Index of refraction of the inside, relative to the outside.
    pub eta: f64,
    /// How much of the base colour the specular lobe of the non-metal has.
    pub spec_tint: Parameter<f64>,
    /// Strength of the sheen.
    pub sheen: Parameter<f64>,
    /// How much of the base colour the sheen has.
    pub sheen_tint: Parameter<f64>,
    /// How much the base is as if light were scattered below it.
    pub flatness: Parameter<f64>,
    /// Strength of the coat.
    pub clearcoat: Parameter<f64>,
    /// How smooth the coat is.
    pub clearcoat_gloss: Parameter<f64>,
}

impl PrincipledDescription {
    /// The parameters that are numbers and may be textures, by the names of Mitsuba.
    #[must_use]
    pub fn numbers(&self) -> [(&'static str, &Parameter<f64>); 10] {
        [
            ("roughness", &self.roughness),
            ("anisotropic", &self.anisotropic),
            ("metallic", &self.metallic),
            ("spec_trans", &self.spec_trans),
            ("spec_tint", &self.spec_tint),
            ("sheen", &self.sheen),
            ("sheen_tint", &self.sheen_tint),
            ("flatness", &self.flatness),
            ("clearcoat", &self.clearcoat),
            ("clearcoat_gloss", &self.clearcoat_gloss),
        ]
    }
}

impl Default for PrincipledDescription {
    /// Mitsuba's defaults.
    fn default() -> Self {
        Self {
            base_color: Rgb::grey(0.5).into(),
            roughness: 0.5.into(),
            anisotropic: 0.0.into(),
            metallic: 0.0.into(),
            spec_trans: 0.0.into(),
            eta: 1.5,
            spec_tint: 0.0.into(),
            sheen: 0.0.into(),
            sheen_tint: 0.0.into(),
            flatness: 0.0.into(),
            clearcoat: 0.0.into(),
            clearcoat_gloss: 0.0.into(),
        }
    }
}

impl BsdfDescription {
    /// Smooth glass without tints.
    #[must_use]
    pub fn dielectric(interior_ior: f64, exterior_ior: f64) -> Self {
        let (reflectance, transmittance) = (white(), white());
        Self::Dielectric { interior_ior, exterior_ior, reflectance, transmittance }
    }

    /// Rough glass without tints, of isotropic GGX microfacets.
    #[must_use]
    pub fn rough_dielectric(alpha: impl Into<Parameter<f64>>, interior_ior: f64, exterior_ior: f64) -> Self {
        let (reflectance, transmittance) = (white(), white());
        let (distribution, alpha, alpha_v) = (MicrofacetKind::Ggx, alpha.into(), None);
        Self::RoughDielectric { distribution, alpha, alpha_v, interior_ior, exterior_ior, reflectance, transmittance }
    }

    /// Smooth metal.
    #[must_use]
    pub fn conductor(fresnel: ConductorFresnel) -> Self {
        Self::Conductor { fresnel, reflectance: white() }
    }

    /// Rough metal of isotropic GGX microfacets.
    #[must_use]
    pub fn rough_conductor(alpha: impl Into<Parameter<f64>>, fresnel: ConductorFresnel) -> Self {
        let (distribution, alpha, alpha_v) = (MicrofacetKind::Ggx, alpha.into(), None);
        Self::RoughConductor { distribution, alpha, alpha_v, fresnel, reflectance: white() }
    }
}
