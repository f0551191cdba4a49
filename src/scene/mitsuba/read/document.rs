//! From elements to objects: parameters, includes, references.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use super::fault::{Fault, Place, Result, Warnings};
use super::files::Files;
use super::node::{Kind, Node, Property, Value};
use super::parameters::Parameters;
use super::spectrum::Spectrum;
use super::tree::{self, Element};
use super::{number, transform, upgrade};
use crate::names::did_you_mean;
use crate::scene::texture::srgb_to_linear;
use crate::spectrum::Rgb;

/// Deepest nesting of included files, as in Mitsuba.
const DEEPEST_INCLUDE: usize = 15;

/// Deepest nesting of objects, those of included files within those that include them.
const DEEPEST: usize = 128;

/// Most included files in a scene.
const MOST_INCLUDES: usize = 1000;

/// All objects of a scene, the scene itself first.
#[derive(Debug)]
pub(super) struct Document {
    pub nodes: Vec<Node>,
    pub files: Files,
    pub parameters: Parameters,
    pub warnings: Warnings,
    ids: HashMap<String, usize>,
    includes: usize,
    nesting: usize,
}

impl Document {
    /// From the bytes of the scene's file.
    pub(super) fn read(bytes: &[u8], path: &Path, parameters: Parameters) -> Result<Self> {
        let files = Files::new(path);
        let mut document = Self {
            nodes: Vec::new(),
            files,
            parameters,
            warnings: Warnings::default(),
            ids: HashMap::new(),
            includes: 0,
            nesting: 0,
        };
        let file: Arc<Path> = path.into();
        let mut root = tree::parse(bytes, &file)?;
        let old = document.version(&mut root)?;
        let place = root.place();
        if Kind::of_tag(&root.tag) != Some(Kind::Scene) {
            return Err(Fault::new(&place, "is no scene", "give a file whose root is <scene version=\"3.0.0\">"));
        }
        let node = Node { kind: Kind::Scene, plugin: "scene".into(), id: None, properties: Vec::new(), place, old };
        document.nodes.push(node);
        document.children(root, 0, old, 0)?;
        document.nodes.iter_mut().try_for_each(upgrade::node)?;
        document.resolve()?;
        document.check_cycles()?;
        Ok(document)
    }

    /// Whether it is of version 0.
    fn version(&mut self, root: &mut Element) -> Result<bool> {
        self.parameters.substitute(root)?;
        let place = root.place();
        let Some(version) = root.attribute("version") else {
            return Err(Fault::new(&place, "has no version", "add the attribute version=\"3.0.0\""));
        };
        let numbers: Option<Vec<u32>> = version.split('.').map(|part| part.trim().parse().ok()).collect();
        match numbers.as_deref() {
            Some([major, ..]) if *major <= 3 => Ok(*major < 2),
            Some([_, ..]) => {
                let problem = format!("is of the unknown version {version}");
                Err(Fault::new(&place, problem, "give a file of version 3 or before"))
            }
            _ => Err(Fault::new(&place, format!("{version:?} is no version"), "write for example 3.0.0")),
        }
    }

    fn children(&mut self, element: Element, parent: usize, old: bool, depth: usize) -> Result<()> {
        self.nesting += 1;
        if self.nesting > DEEPEST {
            let problem = format!("objects are nested more than {DEEPEST} deep");
            return Err(Fault::new(&element.place(), problem, "flatten the scene"));
        }
        element.children.into_iter().try_for_each(|child| self.element(child, parent, old, depth))?;
        self.nesting -= 1;
        Ok(())
    }

    fn element(&mut self, mut element: Element, parent: usize, old: bool, depth: usize) -> Result<()> {
        self.parameters.substitute(&mut element)?;
        let place = element.place();
        let name = element.attribute("name").unwrap_or_default().to_owned();
        let kind = Kind::of_tag(&element.tag).or_else(|| is_spectrum_object(&element).then_some(Kind::Texture));
        if let Some(kind) = kind {
            allow(&element, &["type", "id", "name"])?;
            let plugin = required(&element, "type")?.to_owned();
            let id = element.attribute("id").map(str::to_owned);
            let index = self.nodes.len();
            if let Some(id) = &id {
                self.name(id.clone(), index, &place)?;
            }
            self.add(parent, name, Value::Object(index), &place)?;
            self.nodes.push(Node { kind, plugin, id, properties: Vec::new(), place, old });
            return self.children(element, index, old, depth);
        }
        if element.tag != "transform" && !element.children.is_empty() {
            let child = element.children[0].place();
            return Err(Fault::new(&child, format!("cannot stand inside of <{}>", element.tag), "move it out"));
        }
        let value = match element.tag.as_str() {
            "default" => {
                allow(&element, &["name", "value"])?;
                let (name, value) = (required(&element, "name")?, required(&element, "value")?);
                if name.is_empty() {
                    return Err(Fault::new(&place, "has no name", "name the parameter"));
                }
                self.parameters.set_default(name, value);
                return Ok(());
            }
            "include" => {
                allow(&element, &["filename", "name"])?;
                let file = required(&element, "filename")?.to_owned();
                return self.include(&file, name, parent, &place, depth);
            }
            "path" => {
                allow(&element, &["value"])?;
                if parent != 0 {
                    return Err(Fault::new(&place, "stands inside of an object", "move it below <scene>"));
                }
                let folder = self.files.folder_of(&place.file).to_owned();
                return self.files.search(required(&element, "value")?, &folder, &place);
            }
            "alias" => {
                allow(&element, &["id", "as"])?;
                let (id, alias) = (required(&element, "id")?, required(&element, "as")?.to_owned());
                let Some(&index) = self.ids.get(id) else {
                    return Err(Fault::new(&place, format!("no object before it has the id {id:?}"), "correct the id"));
                };
                return self.name(alias, index, &place);
            }
            "ref" => {
                allow(&element, &["id", "name"])?;
                Value::Reference(required(&element, "id")?.to_owned())
            }
            "transform" => {
                allow(&element, &["name"])?;
                for operation in &mut element.children {
                    self.parameters.substitute(operation)?;
                }
                required(&element, "name")?;
                Value::Transform(transform::compose(&element, &mut self.warnings)?)
            }
            _ => self.plain(&element, &place)?,
        };
        if !matches!(value, Value::Reference(_)) {
            required(&element, "name")?;
        }
        self.add(parent, name, value, &place)
    }

    /// A value that stands in the attributes.
    fn plain(&self, element: &Element, place: &Place) -> Result<Value> {
        let value = || {
            allow(element, &["name", "value"])?;
            required(element, "value")
        };
        Ok(match element.tag.as_str() {
            "float" => Value::Float(number::float(value()?, place)?),
            "integer" => Value::Integer(number::integer(value()?, place)?),
            "boolean" => Value::Boolean(number::boolean(value()?, place)?),
            "string" => Value::Text(value()?.to_owned()),
            "vector" | "point" => Value::Vector(coordinates(element, None)?),
            "rgb" => Value::Colour(colour(value()?, place)?),
            "srgb" => Value::Colour(colour(value()?, place)?.map(srgb_to_linear)),
            "blackbody" => {
                allow(element, &["name", "temperature", "scale"])?;
                // Mitsuba 0.6 writes a K behind the number.
                let kelvin = required(element, "temperature")?.trim_end_matches(['K', 'k', ' ']);
                let scale = element.attribute("scale").map_or(Ok(1.0), |text| number::float(text, place))?;
                Value::Spectrum(Spectrum::black_body(number::float(kelvin, place)?, scale, place)?)
            }
            "spectrum" => {
                allow(element, &["name", "value", "filename"])?;
                match (element.attribute("value"), element.attribute("filename")) {
                    (Some(value), None) => Value::Spectrum(Spectrum::from_pairs(value, place)?),
                    (None, Some(file)) => {
                        Value::Spectrum(Spectrum::from_lines(&self.files.read_text(file, place)?, place)?)
                    }
                    _ => {
                        return Err(Fault::new(place, "needs a value or a filename, and not both", "give one of them"));
                    }
                }
            }
            "translate" | "rotate" | "scale" | "lookat" | "lookAt" | "matrix" => {
                return Err(Fault::new(place, "stands outside of a <transform>", "put it into one"));
            }
            tag => {
                let known = [
                    "alias",
                    "blackbody",
                    "boolean",
                    "bsdf",
                    "default",
                    "emitter",
                    "film",
                    "float",
                    "include",
                    "integer",
                    "integrator",
                    "lookat",
                    "matrix",
                    "medium",
                    "path",
                    "phase",
                    "point",
                    "ref",
                    "rfilter",
                    "rgb",
                    "rotate",
                    "sampler",
                    "scale",
                    "scene",
                    "sensor",
                    "shape",
                    "spectrum",
                    "srgb",
                    "string",
                    "texture",
                    "transform",
                    "translate",
                    "vector",
                    "volume",
                ];
                let problem = format!("<{tag}> is no element of the format{}", did_you_mean(tag, known));
                return Err(Fault::new(place, problem, "remove it or correct its name"));
            }
        })
    }

    fn add(&mut self, parent: usize, name: String, value: Value, place: &Place) -> Result<()> {
        let properties = &mut self.nodes[parent].properties;
        // Most of a scene's thousands of shapes have no name.
        let first = if name.is_empty() { None } else { properties.iter().find(|property| property.name == name) };
        if let Some(first) = first {
            let problem = format!("{name:?} stands here a second time, after line {}", first.place.line);
            return Err(Fault::new(place, problem, "remove one of the two"));
        }
        properties.push(Property { name, value, place: place.clone() });
        Ok(())
    }

    fn name(&mut self, id: String, index: usize, place: &Place) -> Result<()> {
        match self.ids.get(&id) {
            Some(&first) => {
                let line = self.nodes.get(first).map_or(0, |node| node.place.line);
                let problem = format!("the id {id:?} is taken already, by line {line}");
                Err(Fault::new(place, problem, "choose another"))
            }
            None => {
                self.ids.insert(id, index);
                Ok(())
            }
        }
    }

    fn include(&mut self, file: &str, name: String, parent: usize, place: &Place, depth: usize) -> Result<()> {
        self.includes += 1;
        if depth + 1 >= DEEPEST_INCLUDE {
            let problem = format!("files are included more than {DEEPEST_INCLUDE} deep");
            return Err(Fault::new(place, problem, "check that no file includes itself"));
        }
        if self.includes > MOST_INCLUDES {
            let problem = format!("more than {MOST_INCLUDES} files are included");
            return Err(Fault::new(place, problem, "put their content into fewer files"));
        }
        let path = self.files.find_included(file, place)?;
        let bytes = self.files.read_xml(&path)?;
        let mut root = tree::parse(&bytes, &Arc::from(path))?;
        let old = self.version(&mut root)?;
        if Kind::of_tag(&root.tag) == Some(Kind::Scene) {
            return self.children(root, parent, old, depth + 1);
        }
        // One object, for which the file gives no name.
        root.attributes.retain(|(key, _)| key != "version" && key != "name");
        if !name.is_empty() {
            root.attributes.push(("name".into(), name));
        }
        self.element(root, parent, old, depth + 1)
    }

    /// From ids to indices.
    fn resolve(&mut self) -> Result<()> {
        for node in &mut self.nodes {
            for property in &mut node.properties {
                let Value::Reference(id) = &property.value else { continue };
                let Some(&index) = self.ids.get(id) else {
                    let suggestion = did_you_mean(id, self.ids.keys().map(String::as_str));
                    let problem = format!("no object has the id {id:?}{suggestion}");
                    return Err(Fault::new(&property.place, problem, "define it or correct the id"));
                };
                property.value = Value::Object(index);
            }
        }
        Ok(())
    }

    /// No object is part of itself. Without recursion, since chains of references may be long.
    fn check_cycles(&self) -> Result<()> {
        #[derive(Clone, Copy, PartialEq)]
        enum State {
            New,
            Open,
            Done,
        }
        let mut states = vec![State::New; self.nodes.len()];
        for start in 0..self.nodes.len() {
            let mut stack = vec![(start, 0)];
            while let Some((node, next)) = stack.pop() {
                if next == 0 {
                    if states[node] == State::Done {
                        continue;
                    }
                    states[node] = State::Open;
                }
                match self.nodes[node].properties.get(next) {
                    None => states[node] = State::Done,
                    Some(property) => {
                        stack.push((node, next + 1));
                        if let Value::Object(child) = property.value {
                            match states[child] {
                                State::Open => {
                                    let problem = "makes an object a part of itself";
                                    return Err(Fault::new(&property.place, problem, "remove it"));
                                }
                                State::New => stack.push((child, 0)),
                                State::Done => {}
                            }
                        }
                    }
                }
            }
        }
        Ok(())
    }
}

/// `<spectrum type="d65">` is an object as textures are.
fn is_spectrum_object(element: &Element) -> bool {
    element.tag == "spectrum" && element.attribute("type").is_some()
}

/// It has no other attributes.
pub(super) fn allow(element: &Element, names: &[&str]) -> Result<()> {
    match element.attributes.iter().find(|(key, _)| !names.contains(&key.as_str())) {
        None => Ok(()),
        Some((key, _)) => {
            let suggestion = did_you_mean(key, names.iter().copied());
            let problem = format!("has the unknown attribute {key:?}{suggestion}");
            let remedy = format!("it may have {}", names.join(", "));
            Err(Fault::new(&element.place(), problem, remedy))
        }
    }
}

/// An attribute that must be there.
pub(super) fn required<'a>(element: &'a Element, name: &str) -> Result<&'a str> {
    element
        .attribute(name)
        .ok_or_else(|| Fault::new(&element.place(), format!("has no {name:?}"), "add this attribute"))
}

/// Three numbers as `x`, `y` and `z` or as a `value`; what is left out is `default`, or an error without one.
pub(super) fn coordinates(element: &Element, default: Option<f64>) -> Result<DVec3> {
    let place = element.place();
    let axes = ["x", "y", "z"];
    if let Some(value) = element.attribute("value") {
        if axes.iter().any(|axis| element.attribute(axis).is_some()) {
            return Err(Fault::new(&place, "has a value and x, y or z", "give one of the two"));
        }
        allow(element, &["name", "value", "angle"])?;
        return number::vector(value, &place);
    }
    allow(element, &["name", "x", "y", "z", "angle"])?;
    let coordinate = |axis: &str| match (element.attribute(axis), default) {
        (Some(text), _) => number::float(text, &place),
        (None, Some(default)) => Ok(default),
        (None, None) => Err(Fault::new(&place, format!("has no {axis}"), "give x, y and z, or a value")),
    };
    Ok(DVec3::new(coordinate("x")?, coordinate("y")?, coordinate("z")?))
}

/// One or three numbers, or `#rrggbb` as Mitsuba 0.6 writes it.
fn colour(text: &str, place: &Place) -> Result<Rgb> {
    if let Some(digits) = text.trim().strip_prefix('#') {
        let encoded = u32::from_str_radix(digits, 16).ok().filter(|_| digits.len() == 6);
        let Some(encoded) = encoded else {
            return Err(Fault::new(place, format!("{text:?} is no colour"), "write #rrggbb"));
        };
        let channel = |shift: u32| f64::from(encoded >> shift & 0xFF) / 255.0;
        return Ok(Rgb::new(channel(16), channel(8), channel(0)));
    }
    Ok(Rgb::from(number::vector(text, place)?.to_array()))
}
