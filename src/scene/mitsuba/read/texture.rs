//! Colours and numbers of materials and lights: constants or textures.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use glam::{DAffine2, DMat2, DMat4, DVec2};

use super::document::Document;
use super::fault::{Fault, Result, Warnings};
use super::node::{Kind, Property, Value};
use super::props::{Props, wrong};
use super::spectrum::{Role, Spectrum};
use crate::scene::texture::{self, Bitmap, Filter, Parameter, Texture, Wrap};
use crate::spectrum::Rgb;

/// Deepest nesting of textures, by references too: each level may double their number.
const DEEPEST: usize = 8;

/// Reads textures, each image file once.
#[derive(Default)]
pub(super) struct Textures {
    depth: usize,
    images: HashMap<(PathBuf, bool, u8, u8), Arc<Bitmap>>,
    read: HashMap<(usize, Role), Parameter<Rgb>>,
}

impl Textures {
    /// A colour, or `None` where the object has none of this name.
    pub(super) fn colour(
        &mut self,
        document: &Document,
        props: &Props<'_>,
        name: &'static str,
        role: Role,
        warnings: &mut Warnings,
    ) -> Result<Option<Parameter<Rgb>>> {
        let Some(property) = props.get(name) else { return Ok(None) };
        let colour = match property.value {
            Value::Object(index) => self.object(document, index, property, role, warnings)?,
            _ => constant(property, role)?.into(),
        };
        if let Parameter::Constant(value) = &colour {
            check(property, *value, role)?;
        }
        Ok(Some(colour))
    }

    /// A number, or `None` where the object has none of this name. A colour counts by its mean, a coloured image by its
    /// luminance, as in Mitsuba.
    pub(super) fn number(
        &mut self,
        document: &Document,
        props: &Props<'_>,
        name: &'static str,
        warnings: &mut Warnings,
    ) -> Result<Option<Parameter<f64>>> {
        let colour = self.colour(document, props, name, Role::Unbounded, warnings)?;
        Ok(colour.map(|colour| match colour {
            Parameter::Constant(Rgb { r, g, b }) if r == g && g == b => r.into(),
            Parameter::Constant(Rgb { r, g, b }) => ((r + g + b) / 3.0).into(),
            Parameter::Texture(texture) => Parameter::Texture(texture),
        }))
    }

    /// A texture by its object.
    pub(super) fn object(
        &mut self,
        document: &Document,
        index: usize,
        property: &Property,
        role: Role,
        warnings: &mut Warnings,
    ) -> Result<Parameter<Rgb>> {
        if let Some(known) = self.read.get(&(index, role)) {
            return Ok(known.clone());
        }
        let node = &document.nodes[index];
        if node.kind != Kind::Texture {
            return Err(Fault::new(&property.place, "is no texture", "give a <texture> or a colour"));
        }
        let props = Props::new(document, index);
        if self.depth >= DEEPEST {
            return Err(props.wrong(format!("is nested more than {DEEPEST} deep"), "bake it into an image"));
        }
        self.depth += 1;
        let texture = match node.plugin.as_str() {
            "bitmap" => self.bitmap(document, &props)?,
            "checkerboard" => {
                let mut colours = Vec::new();
                for (name, default) in [("color0", 0.4), ("color1", 0.2)] {
                    let colour = self.colour(document, &props, name, role, warnings)?;
                    colours.push(as_texture(colour.unwrap_or(Rgb::grey(default).into())));
                }
                let colours: [Texture; 2] = colours.try_into().unwrap_or_else(|_| unreachable!("there are two"));
                Parameter::Texture(Arc::new(Texture::Checkerboard { colours: colours.into(), to_uv: to_uv(&props)? }))
            }
            "mesh_attribute" => {
                let name = attribute_name(&props)?;
                let scale = props.float_or("scale", 1.0)?;
                let attribute = Texture::Attribute { name };
                let scaled = Texture::Remapped { of: Box::new(attribute.clone()), scale, offset: 0.0, squared: false };
                Parameter::Texture(Arc::new(if scale == 1.0 { attribute } else { scaled }))
            }
            "srgb" => {
                let Some(color) = props.get("color") else {
                    return Err(props.wrong("has no color", "add an <rgb name=\"color\">"));
                };
                let unbounded = props.boolean_or("unbounded", false)?;
                let value = constant(color, Role::Unbounded)?;
                check(color, value, if unbounded { Role::Unbounded } else { Role::Share })?;
                value.into()
            }
            "uniform" => {
                props.ignore(&["wavelength_min", "wavelength_max"]);
                let value = props.float("value")?.ok_or_else(|| props.wrong("has no value", "add one"))?;
                Rgb::grey(value).into()
            }
            "d65" => self.daylight(document, &props, warnings)?,
            "blackbody" => {
                props.ignore(&["wavelength_min", "wavelength_max"]);
                let text =
                    "Mitsuba's RGB variants cannot render a black body; it is turned to RGB by the CIE's observer";
                warnings.add(&node.place, text);
                let kelvin = props.float("temperature")?.ok_or_else(|| props.wrong("has no temperature", "add one"))?;
                Spectrum::black_body(kelvin, 1.0, &node.place)?.rgb(Role::Emission).into()
            }
            "regular" | "irregular" => {
                let remedy = "write <spectrum name=\"…\" value=\"wavelength:value, …\">";
                return Err(props.wrong("is a spectrum that Mitsuba's RGB variants cannot render", remedy));
            }
            "rgb" => {
                let Some(value) = props.get("value") else { return Err(props.wrong("has no value", "add one")) };
                constant(value, role)?.into()
            }
            other => {
                let known = ["bitmap", "checkerboard", "mesh_attribute", "srgb", "uniform", "d65", "blackbody"];
                let suggestion = crate::names::did_you_mean(other, known);
                let problem = format!("is the unsupported texture {other:?}{suggestion}");
                return Err(
                    props.wrong(problem, "use bitmap, checkerboard or mesh_attribute, or bake it into an image")
                );
            }
        };
        self.depth -= 1;
        props.finish()?;
        self.read.insert((index, role), texture.clone());
        Ok(texture)
    }

    /// In RGB, white is D65 and the illuminant is a factor of one.
    fn daylight(&mut self, document: &Document, props: &Props<'_>, warnings: &mut Warnings) -> Result<Parameter<Rgb>> {
        let scale = props.float_or("scale", 1.0)?;
        let nested = props.objects(Kind::Texture);
        if let Some(&(index, property)) = nested.first() {
            if nested.len() > 1 || props.has("color") || scale != 1.0 {
                let problem = "has more than one nested texture, or a texture beside a color or a scale";
                return Err(props.wrong(problem, "leave one nested texture"));
            }
            return self.object(document, index, property, Role::Emission, warnings);
        }
        let colour = props.get("color").map(|color| constant(color, Role::Unbounded)).transpose()?;
        Ok((colour.unwrap_or(Rgb::WHITE) * scale).into())
    }

    fn bitmap(&mut self, document: &Document, props: &Props<'_>) -> Result<Parameter<Rgb>> {
        let raw = props.boolean_or("raw", false)?;
        let filter = props.choice("filter_type", &[("bilinear", Filter::Bilinear), ("nearest", Filter::Nearest)])?;
        let wrap = [("repeat", Wrap::Repeat), ("mirror", Wrap::Mirror), ("clamp", Wrap::Clamp)];
        let wrap = props.choice("wrap_mode", &wrap)?;
        // How an image is stored: nothing but memory and precision depends on it.
        props.ignore(&["format", "accel"]);
        let to_uv = to_uv(props)?;
        let Some(name) = props.text("filename")? else {
            return Err(props.wrong("has no filename", "name an image"));
        };
        let bitmap = self.image(document, props, name, raw, filter, wrap)?;
        Ok(Parameter::Texture(Arc::new(Texture::Bitmap { bitmap, to_uv })))
    }

    /// An image that an object names by its `filename`.
    pub(super) fn image(
        &mut self,
        document: &Document,
        props: &Props<'_>,
        name: &str,
        raw: bool,
        filter: Filter,
        wrap: Wrap,
    ) -> Result<Arc<Bitmap>> {
        let place = props.get("filename").map_or(&props.node.place, |property| &property.place);
        let file = document.files.find(name, place)?;
        let key = (file, raw, filter as u8, wrap as u8);
        if let Some(known) = self.images.get(&key) {
            return Ok(known.clone());
        }
        let (width, height, texels) =
            texture::read(&key.0, raw).map_err(|error| Fault::new(place, error.to_string(), "give another image"))?;
        let bitmap = Arc::new(Bitmap { name: name.into(), width, height, texels, filter, wrap: [wrap; 2] });
        self.images.insert(key, bitmap.clone());
        Ok(bitmap)
    }
}

/// The name of an attribute. It is what Mitsuba calls `name`, which is the texture's own place in its parent as well.
fn attribute_name(props: &Props<'_>) -> Result<String> {
    let Some(name) = props.text("name")? else { return Err(props.wrong("has no name", "name an attribute")) };
    if name.contains("vertex_") || name.contains("face_") {
        return Ok(name.into());
    }
    let problem = format!("{name:?} is no name of an attribute");
    Err(props.fault("name", problem, "write vertex_… or face_…".into()))
}

/// The upper left of the matrix and its translation, which is what Mitsuba takes of it.
fn to_uv(props: &Props<'_>) -> Result<DAffine2> {
    let m = props.transform("to_uv")?.unwrap_or(DMat4::IDENTITY);
    let flat = [m.x_axis.z, m.y_axis.z, m.z_axis.x, m.z_axis.y, m.w_axis.z];
    if flat.iter().any(|&x| x != 0.0) {
        let problem = "turns texture coordinates out of their plane".into();
        let remedy = "write a matrix of 16 numbers whose third row and column are 0 0 1 0".into();
        return Err(props.fault("to_uv", problem, remedy));
    }
    let matrix2 = DMat2::from_cols(DVec2::new(m.x_axis.x, m.x_axis.y), DVec2::new(m.y_axis.x, m.y_axis.y));
    Ok(DAffine2 { matrix2, translation: DVec2::new(m.w_axis.x, m.w_axis.y) })
}

/// The colour of a plain value.
pub(super) fn constant(property: &Property, role: Role) -> Result<Rgb> {
    match &property.value {
        Value::Float(x) => Ok(Rgb::grey(*x)),
        Value::Integer(x) => Ok(Rgb::grey(*x as f64)),
        Value::Colour(colour) => Ok(*colour),
        Value::Spectrum(spectrum) => Ok(spectrum.rgb(role)),
        _ => Err(wrong(property, "a colour, a number or a texture")),
    }
}

fn check(property: &Property, value: Rgb, role: Role) -> Result<()> {
    if !value.is_finite() {
        return Err(Fault::new(&property.place, "is not finite", "use smaller numbers"));
    }
    if role == Role::Share && !value.to_array().iter().all(|x| (0.0..=1.0).contains(x)) {
        let problem = format!("is {:?}, but a share of light lies between 0 and 1", value.to_array());
        return Err(Fault::new(&property.place, problem, "correct it"));
    }
    // A uniform spectrum of light is a colour with all channels above zero.
    if role == Role::Emission && value.min_component() < 0.0 {
        return Err(Fault::new(&property.place, "is negative", "give light from 0 on"));
    }
    Ok(())
}

fn as_texture(colour: Parameter<Rgb>) -> Texture {
    match colour {
        Parameter::Constant(Rgb { r, g, b }) => Texture::Constant([r, g, b, 1.0]),
        Parameter::Texture(texture) => Arc::unwrap_or_clone(texture),
    }
}
