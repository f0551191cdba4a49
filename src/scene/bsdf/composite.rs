//! Models made of others, and models whose parameters vary over the surface.

use glam::DVec3;

use super::material::coated;
use super::perturbed::{TurnedFrame, TurnedNormal};
use super::{Bsdf, BsdfModel, BsdfSample, LobeDensity, MaterialError, Side, opposite};
use crate::measure::{Density, ProjectedSolidAngle, SolidAngle};
use crate::scene::description::{BsdfDescription, NormalSource};
use crate::scene::texture::{Parameter, SurfacePoint, Texture, clamped};
use crate::spectrum::Rgb;

/// A model that depends on the point of the surface, or is made of others.
#[derive(Clone, Debug)]
pub(crate) enum Composite {
    /// The same everywhere.
    Leaf(Bsdf),
    /// One whose parameters are textures.
    Textured(Box<TexturedLeaf>),
    /// Light goes straight through.
    Null,
    /// One model for each side; without a second, both are alike.
    TwoSided { front: Box<Composite>, back: Option<Box<Composite>> },
    /// The nested model by `opacity`, straight through by the rest.
    Mask { opacity: Parameter<f64>, nested: Box<Composite> },
    /// `(1 − weight) models[0] + weight models[1]`.
    Blend { weight: Parameter<f64>, models: Box<[Composite; 2]> },
    /// The nested model under a turned normal.
    Perturbed { normal: NormalSource, nested: Box<Composite> },
}

fn goes_straight(bsdf: &Bsdf) -> bool {
    bsdf.transmits() && bsdf.has_dirac() && !bsdf.bends()
}

fn turned_over(v: DVec3) -> DVec3 {
    DVec3::new(v.x, v.y, -v.z)
}

/// A single model whose parameters are textures.
#[derive(Clone, Debug)]
pub(crate) struct TexturedLeaf {
    description: BsdfDescription,
    /// One of the models that it can be: what does not depend on the point.
    example: Bsdf,
}

/// The answer of a textured leaf at a point.
macro_rules! at_point {
    ($leaf:expr, $at:expr, $model:ident => $answer:expr) => {
        match coated(&$leaf.example, &$leaf.description, $at) {
            Some($model) => $answer,
            None => {
                let $model = Bsdf::at(&$leaf.description, $at).expect("a textured leaf is no composite");
                $answer
            }
        }
    };
}

impl Composite {
    /// From a description.
    pub(crate) fn new(description: &BsdfDescription) -> Result<Self, MaterialError> {
        let nested = |nested: &BsdfDescription| Self::new(nested).map(Box::new);
        Ok(match description {
            BsdfDescription::Null => Self::Null,
            BsdfDescription::TwoSided { front, back } => {
                let same = front == back;
                let (front, back) = (nested(front)?, if same { None } else { Some(nested(back)?) });
                if front.transmits() || back.as_ref().is_some_and(|back| back.transmits()) {
                    return Err(MaterialError::Composition(
                        "what transmits light has two sides already: take it out of the two-sided model",
                    ));
                }
                Self::TwoSided { front, back }
            }
            BsdfDescription::Mask { opacity, nested: inner } => {
                Self::Mask { opacity: checked_share("opacity", opacity)?, nested: nested(inner)? }
            }
            BsdfDescription::Blend { weight, first, second } => {
                let models = Box::new([Self::new(first)?, Self::new(second)?]);
                if models.iter().all(Self::refracts) && first != second {
                    return Err(MaterialError::Composition(
                        "a blend of two smooth glasses: which of them a refracted path took cannot be told",
                    ));
                }
                Self::Blend { weight: checked_share("weight", weight)?, models }
            }
            BsdfDescription::Perturbed { normal, nested: inner } => {
                Self::Perturbed { normal: normal.clone(), nested: nested(inner)? }
            }
            leaf => {
                let bsdf = Bsdf::new(leaf)?;
                // glTF turns its anisotropy by where v goes.
                let turned = matches!(leaf, BsdfDescription::Gltf(gltf) if gltf.anisotropy.is_some());
                if leaf.textures().is_empty() && !turned {
                    Self::Leaf(bsdf)
                } else {
                    Self::Textured(Box::new(TexturedLeaf { description: leaf.clone(), example: bsdf }))
                }
            }
        })
    }

    /// It needs no point to be evaluated at.
    #[allow(clippy::result_large_err, reason = "called once for each material")]
    pub(crate) fn into_uniform(self) -> Result<Bsdf, Self> {
        match self {
            Self::Leaf(bsdf) if !bsdf.is_anisotropic() => Ok(bsdf),
            other => Err(other),
        }
    }

    /// Both sides alike, unless it has two already.
    pub(crate) fn two_sided(self) -> Self {
        if self.scatters_behind() { self } else { Self::TwoSided { front: Box::new(self), back: None } }
    }

    /// See [`BsdfModel::has_finite`].
    pub(crate) fn has_finite(&self) -> bool {
        self.any(&|bsdf| bsdf.has_finite())
    }

    /// See [`BsdfModel::has_dirac`].
    pub(crate) fn has_dirac(&self) -> bool {
        match self {
            Self::Null => true,
            Self::Mask { opacity, nested } => opacity.constant() != Some(&1.0) || nested.has_dirac(),
            _ => self.any(&|bsdf| bsdf.has_dirac()),
        }
    }

    /// See [`BsdfModel::is_glossy`].
    pub(crate) fn is_glossy(&self) -> bool {
        self.any(&|bsdf| bsdf.is_glossy())
    }

    /// Light passes through it.
    pub(crate) fn transmits(&self) -> bool {
        match self {
            Self::Null | Self::Mask { .. } => true,
            _ => self.any(&|bsdf| bsdf.transmits()),
        }
    }

    /// Some light that comes from behind is not absorbed.
    pub(crate) fn scatters_behind(&self) -> bool {
        match self {
            Self::TwoSided { .. } => true,
            Self::Blend { models, .. } => models.iter().any(Self::scatters_behind),
            Self::Perturbed { nested, .. } => nested.scatters_behind(),
            _ => self.transmits(),
        }
    }

    /// Its Dirac lobes bend light.
    fn refracts(&self) -> bool {
        self.any(&Bsdf::bends)
    }

    /// Some leaf has the property; a textured one has what its example has.
    fn any(&self, has: &dyn Fn(&Bsdf) -> bool) -> bool {
        match self {
            Self::Null => false,
            Self::Leaf(bsdf) => has(bsdf),
            Self::Textured(leaf) => has(&leaf.example),
            Self::TwoSided { front, back } => front.any(has) || back.as_ref().is_some_and(|back| back.any(has)),
            Self::Mask { nested, .. } | Self::Perturbed { nested, .. } => nested.any(has),
            Self::Blend { models, .. } => models.iter().any(|model| model.any(has)),
        }
    }

    /// At a point of the surface.
    pub(crate) fn at<'a>(&'a self, at: SurfacePoint<'a>) -> CompositeAt<'a> {
        CompositeAt { model: self, at }
    }
}

impl BsdfDescription {
    /// The textures of its own parameters, not those of nested models.
    #[must_use]
    pub fn textures(&self) -> Vec<&Texture> {
        match self {
            Self::Diffuse { reflectance } | Self::Conductor { reflectance, .. } => one(reflectance.texture()),
            Self::RoughConductor { alpha, alpha_v, reflectance, .. } => {
                several([alpha.texture(), of_v(alpha_v), reflectance.texture()])
            }
            Self::Dielectric { reflectance, transmittance, .. }
            | Self::ThinDielectric { reflectance, transmittance, .. } => {
                several([reflectance.texture(), transmittance.texture()])
            }
            Self::RoughDielectric { alpha, alpha_v, reflectance, transmittance, .. } => {
                several([alpha.texture(), of_v(alpha_v), reflectance.texture(), transmittance.texture()])
            }
            Self::Plastic { diffuse, specular, .. } | Self::RoughPlastic { diffuse, specular, .. } => {
                several([diffuse.texture(), specular.texture()])
            }
            Self::Principled(parameters) => {
                let numbers = parameters.numbers().into_iter().filter_map(|(_, number)| number.texture());
                parameters.base_color.texture().into_iter().chain(numbers).collect()
            }
            Self::Mask { opacity: share, .. } | Self::Blend { weight: share, .. } => one(share.texture()),
            Self::Perturbed {
                normal: NormalSource::Map { texture, .. } | NormalSource::Bump { texture, .. }, ..
            } => {
                vec![texture]
            }
            Self::Gltf(gltf) => gltf.textures(),
            Self::Null | Self::TwoSided { .. } => Vec::new(),
        }
    }

    /// Visits all textures of the model and of those that it is made of.
    pub fn visit_textures(&self, see: &mut dyn FnMut(&Texture)) {
        self.textures().iter().for_each(|texture| texture.visit(see));
        self.nested().iter().for_each(|nested| nested.visit_textures(see));
    }

    /// It or a model that it is made of has the property.
    #[must_use]
    pub fn contains(&self, has: &dyn Fn(&Self) -> bool) -> bool {
        has(self) || self.nested().into_iter().any(|nested| nested.contains(has))
    }

    /// The models that it is made of.
    #[must_use]
    pub fn nested(&self) -> Vec<&Self> {
        match self {
            Self::TwoSided { front: a, back: b } | Self::Blend { first: a, second: b, .. } => vec![a, b],
            Self::Mask { nested, .. } | Self::Perturbed { nested, .. } => vec![nested],
            _ => Vec::new(),
        }
    }
}

fn one(texture: Option<&Texture>) -> Vec<&Texture> {
    texture.into_iter().collect()
}

fn several<const N: usize>(textures: [Option<&Texture>; N]) -> Vec<&Texture> {
    textures.into_iter().flatten().collect()
}

fn of_v(alpha_v: &Option<Parameter<f64>>) -> Option<&Texture> {
    alpha_v.as_ref().and_then(Parameter::texture)
}

fn checked_share(parameter: &'static str, share: &Parameter<f64>) -> Result<Parameter<f64>, MaterialError> {
    match share.constant() {
        Some(&value) if !(0.0..=1.0).contains(&value) => {
            Err(MaterialError::Number { parameter, value, range: "0 … 1" })
        }
        _ => Ok(share.clone()),
    }
}

/// A composite at one point of its surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CompositeAt<'a> {
    model: &'a Composite,
    at: SurfacePoint<'a>,
}

impl<'a> CompositeAt<'a> {
    fn nested(&self, model: &'a Composite) -> Self {
        Self { model, at: self.at }
    }

    fn share(&self, share: &Parameter<f64>) -> f64 {
        clamped(share.at(&self.at), 0.0, 1.0)
    }

    /// The model of the side that `v` is on, and whether that is the back.
    fn side(&self, front: &'a Composite, back: &'a Option<Box<Composite>>, v: DVec3) -> (Self, bool) {
        let behind = v.z < 0.0;
        (self.nested(if behind { back.as_deref().unwrap_or(front) } else { front }), behind)
    }

    /// The nested model in a frame.
    fn in_frame(&self, frame: TurnedFrame, nested: &'a Composite) -> Self {
        let tangents = self.at.tangents.map(|tangent| frame.to_nested(tangent));
        Self { model: nested, at: SurfacePoint { tangents, ..self.at } }
    }
}

impl BsdfModel for CompositeAt<'_> {
    fn eval(&self, to_emitter: DVec3, to_sensor: DVec3) -> Rgb {
        match self.model {
            Composite::Null => Rgb::BLACK,
            Composite::Leaf(bsdf) => bsdf.eval(to_emitter, to_sensor),
            Composite::Textured(leaf) => at_point!(leaf, &self.at, model => model.eval(to_emitter, to_sensor)),
            Composite::TwoSided { front, back } => match self.side(front, back, to_sensor) {
                (model, true) => model.eval(turned_over(to_emitter), turned_over(to_sensor)),
                (model, false) => model.eval(to_emitter, to_sensor),
            },
            Composite::Mask { opacity, nested } => {
                self.nested(nested).eval(to_emitter, to_sensor) * self.share(opacity)
            }
            Composite::Blend { weight, models } => {
                let weight = self.share(weight);
                let [first, second] = [&models[0], &models[1]].map(|m| self.nested(m).eval(to_emitter, to_sensor));
                first * (1.0 - weight) + second * weight
            }
            Composite::Perturbed { normal, nested } => {
                let normal = TurnedNormal::new(normal, &self.at);
                let frame = normal.frame(to_sensor);
                let Some([i, o]) = frame.both_to_nested(to_emitter, to_sensor) else { return Rgb::BLACK };
                let factor = TurnedFrame::ratio(to_emitter, i) * normal.shadowing(to_emitter);
                self.in_frame(frame, nested).eval(i, o) * factor
            }
        }
    }

    fn density(&self, from: DVec3, to: DVec3) -> Density<SolidAngle> {
        match self.model {
            Composite::Null => Density::ZERO,
            Composite::Leaf(bsdf) => bsdf.density(from, to),
            Composite::Textured(leaf) => at_point!(leaf, &self.at, model => model.density(from, to)),
            Composite::TwoSided { front, back } => match self.side(front, back, from) {
                (model, true) => model.density(turned_over(from), turned_over(to)),
                (model, false) => model.density(from, to),
            },
            Composite::Mask { opacity, nested } => self.nested(nested).density(from, to) * self.share(opacity),
            Composite::Blend { weight, models } => {
                let weight = self.share(weight);
                let [first, second] = [&models[0], &models[1]].map(|m| self.nested(m).density(from, to).value());
                Density::new((1.0 - weight) * first + weight * second)
            }
            Composite::Perturbed { normal, nested } => {
                let normal = TurnedNormal::new(normal, &self.at);
                let parts = normal.choice(from).map(|(frame, share)| {
                    let both = frame.both_to_nested(from, to).filter(|_| share > 0.0);
                    both.map_or(0.0, |[from, to]| self.in_frame(frame, nested).density(from, to).value() * share)
                });
                Density::new(parts[0] + parts[1])
            }
        }
    }

    fn eval_dirac(&self, to_emitter: DVec3, to_sensor: DVec3) -> Rgb {
        match self.model {
            Composite::Null => {
                if opposite(to_emitter, to_sensor) {
                    Rgb::WHITE
                } else {
                    Rgb::BLACK
                }
            }
            Composite::Leaf(bsdf) => bsdf.eval_dirac(to_emitter, to_sensor),
            Composite::Textured(leaf) => at_point!(leaf, &self.at, model => model.eval_dirac(to_emitter, to_sensor)),
            Composite::TwoSided { front, back } => match self.side(front, back, to_sensor) {
                (model, true) => model.eval_dirac(turned_over(to_emitter), turned_over(to_sensor)),
                (model, false) => model.eval_dirac(to_emitter, to_sensor),
            },
            Composite::Mask { opacity, nested } => {
                let opacity = self.share(opacity);
                let through = if opposite(to_emitter, to_sensor) { 1.0 - opacity } else { 0.0 };
                Rgb::grey(through) + self.nested(nested).eval_part(to_emitter, to_sensor) * opacity
            }
            Composite::Blend { weight, models } => {
                let weight = self.share(weight);
                let [first, second] = [&models[0], &models[1]].map(|m| self.nested(m).eval_part(to_emitter, to_sensor));
                first * (1.0 - weight) + second * weight
            }
            Composite::Perturbed { normal, nested } => {
                let normal = TurnedNormal::new(normal, &self.at);
                let frame = normal.frame(to_sensor);
                let Some([i, o]) = frame.both_to_nested(to_emitter, to_sensor) else { return Rgb::BLACK };
                self.in_frame(frame, nested).eval_dirac(i, o) * normal.shadowing(to_emitter)
            }
        }
    }

    fn density_dirac(&self, side: Side, from: DVec3, to: DVec3) -> Density<ProjectedSolidAngle> {
        match self.model {
            Composite::Null => {
                if opposite(from, to) {
                    Density::new(1.0)
                } else {
                    Density::ZERO
                }
            }
            Composite::Leaf(bsdf) => bsdf.density_dirac(side, from, to),
            Composite::Textured(leaf) => at_point!(leaf, &self.at, model => model.density_dirac(side, from, to)),
            Composite::TwoSided { front, back } => match self.side(front, back, from) {
                (model, true) => model.density_dirac(side, turned_over(from), turned_over(to)),
                (model, false) => model.density_dirac(side, from, to),
            },
            Composite::Mask { opacity, nested } => {
                let opacity = self.share(opacity);
                let through = if opposite(from, to) { 1.0 - opacity } else { 0.0 };
                Density::new(through + opacity * self.nested(nested).density_part(side, from, to))
            }
            Composite::Blend { weight, models } => {
                let weight = self.share(weight);
                let [first, second] = [&models[0], &models[1]].map(|m| self.nested(m).density_part(side, from, to));
                Density::new((1.0 - weight) * first + weight * second)
            }
            Composite::Perturbed { normal, nested } => {
                let normal = TurnedNormal::new(normal, &self.at);
                let (_, to_sensor) = side.by_role(from, to);
                let frame = normal.frame(to_sensor);
                let Some([f, t]) = frame.both_to_nested(from, to) else { return Density::ZERO };
                let ratio = TurnedFrame::dirac_ratio(side, [from, f], [to, t]) * normal.share(from, to_sensor);
                self.in_frame(frame, nested).density_dirac(side, f, t) * ratio
            }
        }
    }

    fn sample(&self, side: Side, from: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        match self.model {
            Composite::Null => {
                Some(BsdfSample { to: -from, density: LobeDensity::Dirac(Density::new(1.0)), value: Rgb::WHITE })
            }
            Composite::Leaf(bsdf) => bsdf.sample(side, from, u),
            Composite::Textured(leaf) => at_point!(leaf, &self.at, model => model.sample(side, from, u)),
            Composite::TwoSided { front, back } => match self.side(front, back, from) {
                (model, true) => {
                    let sample = model.sample(side, turned_over(from), u)?;
                    Some(BsdfSample { to: turned_over(sample.to), ..sample })
                }
                (model, false) => model.sample(side, from, u),
            },
            Composite::Mask { opacity, nested } => {
                let opacity = self.share(opacity);
                if u[2] < opacity {
                    let sample = self.nested(nested).sample(side, from, [u[0], u[1], u[2] / opacity])?;
                    self.whole(side, from, sample.to, matches!(sample.density, LobeDensity::Dirac(_)))
                } else {
                    self.whole(side, from, -from, true)
                }
            }
            Composite::Blend { weight, models } => {
                let weight = self.share(weight);
                let (model, rest) = if u[2] < weight {
                    (&models[1], u[2] / weight)
                } else {
                    (&models[0], (u[2] - weight) / (1.0 - weight))
                };
                let sample = self.nested(model).sample(side, from, [u[0], u[1], rest.min(1.0_f64.next_down())])?;
                self.whole(side, from, sample.to, matches!(sample.density, LobeDensity::Dirac(_)))
            }
            Composite::Perturbed { normal, nested } => {
                let normal = TurnedNormal::new(normal, &self.at);
                let [(first, share), (second, rest)] = normal.choice(from);
                let (frame, u2) = if u[2] < share { (first, u[2] / share) } else { (second, (u[2] - share) / rest) };
                let nested_from = frame.same_side(from)?;
                let u = [u[0], u[1], u2.min(1.0_f64.next_down())];
                let sample = self.in_frame(frame, nested).sample(side, nested_from, u)?;
                let to = frame.to_outer(sample.to);
                // What this frame refuses is not to pass for a sample of the other one.
                frame.same_side(to)?;
                let dirac = matches!(sample.density, LobeDensity::Dirac(_));
                let (_, to_sensor) = side.by_role(from, to);
                // Another frame's mirror joins nothing to the sensor.
                if dirac && frame != normal.frame(to_sensor) {
                    return None;
                }
                self.whole(side, from, to, dirac)
            }
        }
    }

    fn radiance_scale(&self, to_emitter: DVec3, to_sensor: DVec3) -> f64 {
        if opposite(to_emitter, to_sensor) {
            return 1.0;
        }
        match self.model {
            Composite::Null | Composite::TwoSided { .. } => 1.0,
            Composite::Leaf(bsdf) => bsdf.radiance_scale(to_emitter, to_sensor),
            Composite::Textured(leaf) => {
                at_point!(leaf, &self.at, model => model.radiance_scale(to_emitter, to_sensor))
            }
            Composite::Mask { nested, .. } | Composite::Perturbed { nested, .. } => {
                self.nested(nested).radiance_scale(to_emitter, to_sensor)
            }
            Composite::Blend { models, .. } => {
                let transmits = models.iter().find(|model| model.transmits());
                transmits.map_or(1.0, |model| self.nested(model).radiance_scale(to_emitter, to_sensor))
            }
        }
    }

    fn has_finite(&self) -> bool {
        self.model.has_finite()
    }

    fn has_dirac(&self) -> bool {
        self.model.has_dirac()
    }

    fn is_glossy(&self) -> bool {
        self.model.is_glossy()
    }

    fn transmits(&self) -> bool {
        self.model.scatters_behind()
    }
}

impl CompositeAt<'_> {
    /// What all parts together say of a direction that one of them drew.
    fn whole(&self, side: Side, from: DVec3, to: DVec3, dirac: bool) -> Option<BsdfSample> {
        let (to_emitter, to_sensor) = side.by_role(from, to);
        if dirac {
            let density = self.density_dirac(side, from, to);
            let value = self.eval_dirac(to_emitter, to_sensor);
            (density.value() > 0.0).then_some(BsdfSample { to, density: LobeDensity::Dirac(density), value })
        } else {
            let density = self.density(from, to);
            let value = self.eval(to_emitter, to_sensor);
            (density.value() > 0.0).then_some(BsdfSample { to, density: LobeDensity::Finite(density), value })
        }
    }

    /// Its Dirac lobes include one that does not bend light.
    fn goes_straight(&self) -> bool {
        match self.model {
            Composite::Null | Composite::Mask { .. } => true,
            Composite::Leaf(bsdf) => goes_straight(bsdf),
            Composite::Textured(leaf) => goes_straight(&leaf.example),
            Composite::Blend { models, .. } => models.iter().any(|model| self.nested(model).goes_straight()),
            Composite::Perturbed { nested, .. } => self.nested(nested).goes_straight(),
            _ => false,
        }
    }

    /// Its lobes may have drawn one of these directions for the other: a lobe that bends light did not draw opposite ones.
    fn may_join(&self, a: DVec3, b: DVec3) -> bool {
        self.goes_straight() || !opposite(a, b)
    }

    fn eval_part(&self, to_emitter: DVec3, to_sensor: DVec3) -> Rgb {
        if self.may_join(to_emitter, to_sensor) { self.eval_dirac(to_emitter, to_sensor) } else { Rgb::BLACK }
    }

    fn density_part(&self, side: Side, from: DVec3, to: DVec3) -> f64 {
        if self.may_join(from, to) { self.density_dirac(side, from, to).value() } else { 0.0 }
    }
}
