//! Models made of others, at points where their textures have some value.

use std::collections::HashMap;
use std::sync::{Arc, LazyLock};

use glam::{DAffine2, DVec2};

use super::*;
use crate::measure::{Density, ProjectedSolidAngle, SolidAngle};
use crate::scene::PrimitiveId;
use crate::scene::bsdf::{BsdfModel, Composite};
use crate::scene::description::NormalSource;
use crate::scene::texture::{AttributeTable, Bitmap, Filter, Parameter, SurfacePoint, Texels, Texture, Wrap};

static NO_ATTRIBUTES: LazyLock<HashMap<String, AttributeTable>> = LazyLock::new(HashMap::new);

/// A composite at one point, as a model of its own.
#[derive(Debug)]
struct Pinned {
    model: Composite,
    at: SurfacePoint<'static>,
}

impl BsdfModel for Pinned {
    fn eval(&self, to_emitter: DVec3, to_sensor: DVec3) -> Rgb {
        self.model.at(self.at).eval(to_emitter, to_sensor)
    }

    fn density(&self, from: DVec3, to: DVec3) -> Density<SolidAngle> {
        self.model.at(self.at).density(from, to)
    }

    fn eval_dirac(&self, to_emitter: DVec3, to_sensor: DVec3) -> Rgb {
        self.model.at(self.at).eval_dirac(to_emitter, to_sensor)
    }

    fn density_dirac(&self, side: Side, from: DVec3, to: DVec3) -> Density<ProjectedSolidAngle> {
        self.model.at(self.at).density_dirac(side, from, to)
    }

    fn sample(&self, side: Side, from: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        self.model.at(self.at).sample(side, from, u)
    }

    fn radiance_scale(&self, to_emitter: DVec3, to_sensor: DVec3) -> f64 {
        self.model.at(self.at).radiance_scale(to_emitter, to_sensor)
    }

    fn has_finite(&self) -> bool {
        self.model.has_finite()
    }

    fn has_dirac(&self) -> bool {
        self.model.has_dirac()
    }

    fn transmits(&self) -> bool {
        self.model.scatters_behind()
    }
}

/// Where u and v are a third, along tangents that are skewed.
pub(super) fn pinned(description: &BsdfDescription) -> Bsdf {
    let at = SurfacePoint {
        uv: DVec2::splat(1.0 / 3.0),
        tangents: [DVec3::X * 2.0, DVec3::new(0.3, 1.5, 0.0)],
        primitive: PrimitiveId(0),
        barycentric: [0.2, 0.3],
        attributes: &NO_ATTRIBUTES,
    };
    Bsdf::Custom(Arc::new(Pinned { model: Composite::new(description).unwrap(), at }))
}

pub(super) fn bitmap(texels: [[f32; 4]; 4]) -> Arc<Texture> {
    let (filter, wrap, texels) = (Filter::Bilinear, [Wrap::Repeat; 2], Texels::Float(texels.to_vec()));
    let bitmap = Bitmap { name: "four".into(), width: 2, height: 2, texels, filter, wrap };
    Arc::new(Texture::Bitmap { bitmap: Arc::new(bitmap), to_uv: DAffine2::IDENTITY })
}

fn grey(values: [f32; 4]) -> Arc<Texture> {
    bitmap(values.map(|x| [x, x, x, 1.0]))
}

fn matt() -> Box<BsdfDescription> {
    Box::new(BsdfDescription::Diffuse { reflectance: Rgb::new(0.2, 0.5, 1.0).into() })
}

fn shiny() -> Box<BsdfDescription> {
    Box::new(BsdfDescription::rough_conductor(Parameter::Texture(grey([0.1, 0.3, 0.2, 0.6])), gold()))
}

fn coloured() -> Arc<Texture> {
    bitmap([[0.6, 0.4, 0.9, 1.0], [0.4, 0.5, 0.7, 1.0], [0.7, 0.3, 0.8, 1.0], [0.5, 0.9, 1.0, 1.0]])
}

/// Glass with grooves along v.
fn brushed() -> BsdfDescription {
    BsdfDescription::RoughDielectric {
        distribution: MicrofacetKind::Beckmann,
        alpha: Parameter::Texture(grey([0.8, 0.5, 0.6, 0.4])),
        alpha_v: Some(Parameter::Texture(grey([0.1, 0.2, 0.2, 0.3]))),
        interior_ior: 1.4,
        exterior_ior: 1.0,
        reflectance: Parameter::Texture(coloured()),
        transmittance: Rgb::grey(0.5).into(),
    }
}

fn lacquer() -> BsdfDescription {
    BsdfDescription::Plastic {
        interior_ior: 1.5,
        exterior_ior: 1.0,
        diffuse: Parameter::Texture(coloured()),
        specular: Parameter::Texture(grey([0.8, 0.5, 0.6, 0.4])),
        nonlinear: true,
    }
}

fn rough_lacquer() -> Box<BsdfDescription> {
    Box::new(BsdfDescription::RoughPlastic {
        distribution: MicrofacetKind::Ggx,
        alpha: 0.2,
        interior_ior: 1.5,
        exterior_ior: 1.0,
        diffuse: Parameter::Texture(coloured()),
        specular: Rgb::WHITE.into(),
        nonlinear: true,
    })
}

/// The principled model with a texture for each parameter.
fn everything() -> Box<BsdfDescription> {
    let share = |low: f32, high: f32| Parameter::Texture(grey([low, high, high, low]));
    Box::new(BsdfDescription::Principled(Box::new(PrincipledDescription {
        base_color: Parameter::Texture(coloured()),
        roughness: share(0.5, 0.8),
        anisotropic: share(0.2, 0.5),
        metallic: share(0.1, 0.4),
        spec_trans: share(0.3, 0.6),
        eta: 1.4,
        spec_tint: share(0.2, 0.5),
        sheen: share(0.2, 0.5),
        sheen_tint: share(0.2, 0.5),
        flatness: share(0.2, 0.5),
        clearcoat: share(0.2, 0.5),
        clearcoat_gloss: share(0.0, 0.1),
    })))
}

fn mirror_and_matt() -> Box<BsdfDescription> {
    let mirror = Box::new(BsdfDescription::conductor(gold()));
    Box::new(BsdfDescription::Blend { weight: 0.4.into(), first: mirror, second: matt() })
}

fn turned(nested: Box<BsdfDescription>) -> BsdfDescription {
    let texture = bitmap([[0.6, 0.45, 0.9, 1.0], [0.4, 0.5, 0.95, 1.0], [0.7, 0.3, 0.8, 1.0], [0.5, 0.5, 1.0, 1.0]]);
    BsdfDescription::Perturbed { normal: NormalSource::Map { texture, scale: [1.0; 2], against_v: true }, nested }
}

fn steep(nested: Box<BsdfDescription>) -> BsdfDescription {
    let texture = bitmap([[0.9, 0.7, 0.7, 1.0]; 4]);
    BsdfDescription::Perturbed { normal: NormalSource::Map { texture, scale: [1.0; 2], against_v: false }, nested }
}

/// Each composite, over models with finite and with Dirac lobes.
pub(super) fn all() -> Vec<Bsdf> {
    descriptions().iter().map(pinned).collect()
}

pub(super) fn descriptions() -> Vec<BsdfDescription> {
    let glass = || Box::new(BsdfDescription::dielectric(1.5, 1.0));
    let opacity = Parameter::Texture(grey([0.9, 0.3, 0.5, 0.6]));
    let bump = NormalSource::Bump { texture: grey([0.0, 0.4, 0.2, 0.1]), scale: 0.3 };
    let pane = BsdfDescription::ThinDielectric {
        interior_ior: 1.5,
        exterior_ior: 1.0,
        reflectance: Parameter::Texture(coloured()),
        transmittance: Parameter::Texture(coloured()),
    };
    vec![
        BsdfDescription::Null,
        *shiny(),
        *mirror_and_matt(),
        BsdfDescription::TwoSided { front: shiny(), back: mirror_and_matt() },
        BsdfDescription::Mask { opacity: opacity.clone(), nested: mirror_and_matt() },
        BsdfDescription::Mask { opacity: 0.7.into(), nested: glass() },
        BsdfDescription::Mask { opacity, nested: Box::new(BsdfDescription::TwoSided { front: matt(), back: matt() }) },
        BsdfDescription::Blend { weight: 0.25.into(), first: Box::new(BsdfDescription::Null), second: matt() },
        BsdfDescription::Blend { weight: 0.3.into(), first: glass(), second: Box::new(pane.clone()) },
        pane,
        brushed(),
        lacquer(),
        *rough_lacquer(),
        *everything(),
        BsdfDescription::TwoSided { front: Box::new(lacquer()), back: rough_lacquer() },
        BsdfDescription::Mask { opacity: 0.6.into(), nested: rough_lacquer() },
        BsdfDescription::Blend { weight: 0.4.into(), first: Box::new(lacquer()), second: everything() },
        turned(rough_lacquer()),
        turned(everything()),
        turned(Box::new(lacquer())),
        steep(mirror_and_matt()),
        steep(shiny()),
        steep(Box::new(brushed())),
        turned(shiny()),
        turned(mirror_and_matt()),
        BsdfDescription::Perturbed { normal: bump, nested: shiny() },
    ]
}

/// Those whose parts are reciprocal: a turned normal is not.
pub(super) fn reciprocal() -> Vec<Bsdf> {
    all().into_iter().take(17).collect()
}

#[test]
fn a_mask_lets_the_rest_through() {
    let mask = pinned(&BsdfDescription::Mask { opacity: 0.7.into(), nested: matt() });
    let bare = Bsdf::new(&matt()).unwrap();
    let (i, o) = (direction(0.5, 1.0), direction(0.8, 2.0));
    assert_eq!(mask.eval(i, o), bare.eval(i, o) * 0.7);
    for side in SIDES {
        let through = mask.density_dirac(side, o, -o).value();
        assert!((through - 0.3).abs() < 1e-15 && mask.eval_dirac(-o, o) == Rgb::grey(1.0 - 0.7));
        // From behind, where the nested model absorbs.
        assert!(matches!(mask.sample(side, -o, [0.5, 0.5, 0.9]), Some(s) if s.to == o));
        assert!(mask.sample(side, -o, [0.5, 0.5, 0.1]).is_none());
    }
}

#[test]
fn a_flat_normal_map_and_a_flat_bump_change_nothing() {
    let flat_map = NormalSource::Map { texture: bitmap([[0.5, 0.5, 1.0, 1.0]; 4]), scale: [1.0; 2], against_v: false };
    let flat_bump = NormalSource::Bump { texture: grey([0.3; 4]), scale: 5.0 };
    let bare = pinned(&shiny());
    for normal in [flat_map, flat_bump] {
        let turned = pinned(&BsdfDescription::Perturbed { normal, nested: shiny() });
        let (i, o) = (direction(0.5, 1.0), direction(0.8, 2.0));
        assert!((turned.eval(i, o).r / bare.eval(i, o).r - 1.0).abs() < 1e-13);
        assert!((turned.density(i, o).value() / bare.density(i, o).value() - 1.0).abs() < 1e-13);
    }
}

/// A plane displaced by a height h(u, v) has the normal (−∂h/∂x, −∂h/∂y, 1).
#[test]
fn a_bump_turns_the_normal_against_the_slope() {
    let bump = NormalSource::Bump { texture: grey([0.0, 0.5, 0.0, 0.5]), scale: 0.4 };
    let mirror = Box::new(BsdfDescription::conductor(white()));
    let turned = pinned(&BsdfDescription::Perturbed { normal: bump, nested: mirror });
    // Between the columns the height rises by 0.5 · 0.4 over half of u, whose tangent has length two: a slope of 0.2.
    let normal = DVec3::new(-0.2, 0.0, 1.0);
    // The second tangent leans by 0.3 : 1.5, so that y must follow for h to be constant along it.
    let normal = (normal + DVec3::Y * (0.2 * 0.3 / 1.5)).normalize();
    let from = direction(0.9, 0.3);
    let sample = turned.sample(Side::Sensor, from, [0.5; 3]).unwrap();
    let expected = normal * (2.0 * from.dot(normal)) - from;
    assert!((sample.to - expected).length() < 1e-12, "{}, not {expected}", sample.to);
}

/// The formula of Estevez et al. (2019) for a normal of slope 0.5, and a normal that looks away from the sensor mirrored.
#[test]
fn turned_normals_cast_soft_shadows_and_face_the_sensor() {
    let texture = bitmap([[0.7, 0.5, 0.9, 1.0]; 4]);
    let normal = NormalSource::Map { texture, scale: [1.0; 2], against_v: false };
    let turned = pinned(&BsdfDescription::Perturbed { normal, nested: matt() });
    let bare = Bsdf::new(&matt()).unwrap();
    let n = DVec3::new(0.4, 0.0, 0.8).normalize();
    let tan2 = 3.0;
    let shadowing = 2.0 / (1.0 + (1.0_f64 + 0.125 * 0.25 * tan2).sqrt());
    let to_emitter = direction(0.5, 0.0);
    for (to_sensor, facing) in
        [(direction(0.8, 2.0), n), (direction(0.1, std::f64::consts::PI), DVec3::new(-n.x, 0.0, n.z))]
    {
        let cos = to_emitter.dot(facing);
        let expected = if cos > 0.0 { bare.eval(DVec3::Z, DVec3::Z).g * cos / to_emitter.z * shadowing } else { 0.0 };
        let found = turned.eval(to_emitter, to_sensor).g;
        // The image holds single precision.
        assert!((found - expected).abs() < 1e-6 * expected, "{to_sensor}: {found}, not {expected}");
    }
}

#[test]
fn what_cannot_be_told_apart_is_refused() {
    let glass = |interior_ior| Box::new(BsdfDescription::dielectric(interior_ior, 1.0));
    let blend = BsdfDescription::Blend { weight: 0.5.into(), first: glass(1.3), second: glass(1.5) };
    assert!(Composite::new(&blend).unwrap_err().to_string().contains("two smooth glasses"));
    let two_sided = BsdfDescription::TwoSided { front: glass(1.5), back: matt() };
    assert!(Composite::new(&two_sided).unwrap_err().to_string().contains("two sides already"));
    let mask = BsdfDescription::Mask { opacity: 1.5.into(), nested: matt() };
    assert!(Composite::new(&mask).unwrap_err().to_string().contains("opacity = 1.5"));
}
