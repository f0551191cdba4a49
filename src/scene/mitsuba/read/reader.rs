//! From objects to a description of the scene.

use std::collections::HashMap;

use super::document::Document;
use super::fault::{Fault, Result, Warnings};
use super::node::{Kind, Value};
use super::props::Props;
use super::shape::Part;
use super::spectrum::Role;
use super::texture::Textures;
use crate::scene::description::{BsdfDescription, Material, SceneDescription, ShapeIndex};
use crate::scene::texture::Parameter;
use crate::spectrum::Rgb;

/// Reads the objects of a scene one after the other.
pub(super) struct Reader<'a> {
    pub document: &'a Document,
    pub scene: SceneDescription,
    pub warnings: Warnings,
    pub textures: Textures,
    pub bsdfs: HashMap<usize, BsdfDescription>,
    /// By the objects of the model and of the emission.
    pub materials: HashMap<(Option<usize>, Option<usize>), usize>,
    /// The shapes of groups, before they are placed.
    pub groups: HashMap<usize, Vec<Part>>,
    /// Triangles that instances have made.
    pub instanced: usize,
    /// Sensors with the shape that they sit on.
    pub sensors: Vec<(usize, Option<ShapeIndex>)>,
}

impl<'a> Reader<'a> {
    pub(super) fn new(document: &'a Document) -> Self {
        Self {
            document,
            scene: SceneDescription::default(),
            warnings: document.warnings.clone(),
            textures: Textures::default(),
            bsdfs: HashMap::new(),
            materials: HashMap::new(),
            groups: HashMap::new(),
            instanced: 0,
            sensors: Vec::new(),
        }
    }

    /// Everything that stands in the scene, with the camera of this name or number, else the first.
    pub(super) fn run(mut self, camera: Option<&str>) -> Result<SceneDescription> {
        let root = &self.document.nodes[0];
        for property in &root.properties {
            let Value::Object(index) = property.value else {
                let problem = "has no place in the scene";
                return Err(Fault::new(&property.place, problem, "remove it, or put it into an object"));
            };
            match self.document.nodes[index].kind {
                Kind::Shape => self.shape(index)?,
                Kind::Emitter => self.emitter(index)?,
                Kind::Sensor => self.sensors.push((index, None)),
                Kind::Integrator => self.integrator(index)?,
                // Read where something refers to them.
                Kind::Bsdf | Kind::Texture => {}
                Kind::Film | Kind::Filter | Kind::Sampler => {
                    let place = &self.document.nodes[index].place;
                    self.warnings.add(place, "stands outside of a sensor and is ignored");
                }
                Kind::Medium | Kind::Phase | Kind::Volume => {
                    let place = &self.document.nodes[index].place;
                    return Err(Fault::new(place, "media are not supported", "remove it and what refers to it"));
                }
                Kind::Scene => {
                    let place = &self.document.nodes[index].place;
                    return Err(Fault::new(place, "is a scene inside of a scene", "include it as a file"));
                }
            }
        }
        self.sensor(camera)?;
        self.unused()?;
        self.scene.warnings = self.warnings.into_sentences();
        Ok(self.scene)
    }

    /// Models that no shape has are read all the same: a mistake in them is one.
    fn unused(&mut self) -> Result<()> {
        for property in &self.document.nodes[0].properties {
            if let Value::Object(index) = property.value
                && self.document.nodes[index].kind == Kind::Bsdf
            {
                self.bsdf(index, 0)?;
            }
        }
        Ok(())
    }

    /// The material of a shape with this model and this emission.
    pub(super) fn material(&mut self, bsdf: Option<usize>, emitter: Option<usize>) -> Result<usize> {
        if let Some(&known) = self.materials.get(&(bsdf, emitter)) {
            return Ok(known);
        }
        let emission = emitter.map_or(Ok(Rgb::BLACK.into()), |index| self.emission(index))?;
        let (bsdf_description, two_sided) = match bsdf {
            // Mitsuba's default, which is black for a shape that shines.
            None => {
                let grey = if emitter.is_some() { 0.0 } else { 0.5 };
                (BsdfDescription::Diffuse { reflectance: Rgb::grey(grey).into() }, false)
            }
            Some(index) => match self.bsdf(index, 0)? {
                BsdfDescription::TwoSided { front, .. } if self.nested_in(index) == 1 => (*front, true),
                other => (other, false),
            },
        };
        let id = bsdf.and_then(|index| self.document.nodes[index].id.clone());
        let name = id.unwrap_or_else(|| format!("material {}", self.scene.materials.len()));
        self.scene.materials.push(Material { name, bsdf: bsdf_description, two_sided, emission });
        let index = self.scene.materials.len() - 1;
        self.materials.insert((bsdf, emitter), index);
        Ok(index)
    }

    fn nested_in(&self, bsdf: usize) -> usize {
        Props::new(self.document, bsdf).objects(Kind::Bsdf).len()
    }

    /// The radiance of an area light.
    fn emission(&mut self, index: usize) -> Result<Parameter<Rgb>> {
        let props = Props::new(self.document, index);
        if props.node.plugin != "area" {
            let problem = format!("a shape cannot have the emitter {:?}", props.node.plugin);
            return Err(props.wrong(problem, "use area, or move the emitter out of the shape"));
        }
        props.ignore(&["sampling_weight"]);
        self.refuse_media(&props)?;
        let radiance = self.textures.colour(self.document, &props, "radiance", Role::Emission, &mut self.warnings)?;
        props.finish()?;
        Ok(radiance.unwrap_or(Rgb::WHITE.into()))
    }

    /// An object that lies in a medium would be seen through it.
    pub(super) fn refuse_media(&self, props: &Props<'_>) -> Result<()> {
        match props.objects(Kind::Medium).first() {
            None => Ok(()),
            Some((_, property)) => Err(Fault::new(&property.place, "media are not supported", "remove it")),
        }
    }

    /// What an object is called in messages.
    pub(super) fn name_of(&self, index: usize) -> String {
        let node = &self.document.nodes[index];
        node.id.clone().unwrap_or_else(|| format!("{} of line {}", node.plugin, node.place.line))
    }
}
