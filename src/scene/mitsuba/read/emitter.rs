//! `<emitter>` outside of shapes: lights and the environment.

use glam::{DMat3, DMat4, DVec3};

use super::fault::Result;
use super::fov;
use super::node::{Kind, Value};
use super::props::Props;
use super::reader::Reader;
use super::spectrum::Role;
use crate::names::did_you_mean;
use crate::scene::description::{EnvironmentDescription, Light, LightKind};
use crate::scene::texture::{Filter, Parameter, Texture, Wrap};
use crate::spectrum::Rgb;

const PLUGINS: [&str; 6] = ["point", "spot", "directional", "constant", "envmap", "projector"];

/// How far a frame may be from orthonormal.
const ORTHONORMAL: f64 = 1e-3;

impl Reader<'_> {
    /// A light or the environment.
    pub(super) fn emitter(&mut self, index: usize) -> Result<()> {
        let props = Props::new(self.document, index);
        self.refuse_media(&props)?;
        // How often it is chosen, not how bright it is.
        props.ignore(&["sampling_weight"]);
        let kind = match props.node.plugin.as_str() {
            "constant" => {
                props.ignore(&["to_world"]);
                let radiance = self.light(&props, "radiance")?;
                return self.environment(&props, EnvironmentDescription::Constant(radiance));
            }
            "envmap" => {
                let map = self.map(&props)?;
                return self.environment(&props, map);
            }
            "point" => {
                let position = match (props.vector("position")?, props.has("to_world")) {
                    (Some(_), true) => return Err(props.wrong("has a position and to_world", "give one of the two")),
                    (Some(position), false) => position,
                    (None, _) => props.to_world()?.w_axis.truncate(),
                };
                LightKind::Point { position, intensity: self.light(&props, "intensity")? }
            }
            "spot" => self.spot(&props)?,
            "directional" => {
                let direction = match (props.vector("direction")?, props.has("to_world")) {
                    (Some(_), true) => return Err(props.wrong("has a direction and to_world", "give one of the two")),
                    (Some(direction), false) => direction,
                    (None, _) => props.to_world()?.z_axis.truncate(),
                };
                let Some(direction) = direction.try_normalize() else {
                    return Err(props.wrong("has no direction", "give one that is not zero"));
                };
                LightKind::Directional { direction, irradiance: self.light(&props, "irradiance")? }
            }
            "projector" => self.projector(&props)?,
            "area" => return Err(props.wrong("stands outside of a shape", "put it into one")),
            other => {
                let problem = format!("is the unsupported emitter {other:?}{}", did_you_mean(other, PLUGINS));
                return Err(props.wrong(problem, format!("use area or one of {}", PLUGINS.join(", "))));
            }
        };
        props.finish()?;
        self.scene.lights.push(Light { name: self.name_of(index), kind });
        Ok(())
    }

    fn environment(&mut self, props: &Props<'_>, environment: EnvironmentDescription) -> Result<()> {
        props.finish()?;
        if self.scene.environment.is_some() {
            return Err(props.wrong("is a second environment", "remove one of the two"));
        }
        self.scene.environment = Some(environment);
        Ok(())
    }

    /// A constant colour of light; one by default.
    fn light(&mut self, props: &Props<'_>, name: &'static str) -> Result<Rgb> {
        match self.textures.colour(self.document, props, name, Role::Emission, &mut self.warnings)? {
            None => Ok(Rgb::WHITE),
            Some(Parameter::Constant(colour)) => Ok(colour),
            Some(Parameter::Texture(_)) => Err(props.fault(
                name,
                "is textured, which Mitsuba does not support either".into(),
                "give a colour".into(),
            )),
        }
    }

    fn spot(&mut self, props: &Props<'_>) -> Result<LightKind> {
        if props.has("texture") {
            return Err(props.fault("texture", "textured spots are not supported".into(), "use a projector".into()));
        }
        let [_, _, direction] = frame(props)?;
        let position = props.to_world()?.w_axis.truncate();
        let cutoff = props.float_or("cutoff_angle", 20.0)?;
        let beam = props.float_or("beam_width", 0.75 * cutoff)?;
        if !(cutoff > 0.0 && cutoff <= 90.0 && (0.0..cutoff).contains(&beam)) {
            let problem = format!("has a beam of {beam}° in a cone of {cutoff}°");
            return Err(props.wrong(problem, "give 0 ≤ beam_width < cutoff_angle ≤ 90"));
        }
        Ok(LightKind::Spot {
            position,
            direction,
            intensity: self.light(props, "intensity")?,
            inner_angle: beam.to_radians(),
            outer_angle: cutoff.to_radians(),
        })
    }

    fn map(&mut self, props: &Props<'_>) -> Result<EnvironmentDescription> {
        // How it is sampled.
        props.ignore(&["mis_compensation"]);
        let scale = props.float_or("scale", 1.0)?;
        if scale < 0.0 {
            return Err(props.fault("scale", "is negative".into(), "give a factor from 0 on".into()));
        }
        let Some(name) = props.text("filename")? else { return Err(props.wrong("has no filename", "name an image")) };
        let bitmap = self.textures.image(self.document, props, name, false, Filter::Bilinear, Wrap::Repeat)?;
        let mut bitmap = (*bitmap).clone();
        bitmap.wrap[1] = Wrap::Clamp;
        let [x, y, z] = frame(props)?;
        let to_world = DMat3::from_cols(x, y, z);
        Ok(EnvironmentDescription::Map { bitmap: bitmap.into(), scale, to_world })
    }

    fn projector(&mut self, props: &Props<'_>) -> Result<LightKind> {
        let scale = props.float_or("scale", 1.0)?;
        let image = props.get("irradiance").map(|property| match property.value {
            Value::Object(index) if self.document.nodes[index].kind == Kind::Texture => {
                self.textures.object(self.document, index, property, Role::Emission, &mut self.warnings)
            }
            _ => Ok(Rgb::BLACK.into()),
        });
        let image = match image.transpose()? {
            Some(Parameter::Texture(texture)) => match &*texture {
                Texture::Bitmap { bitmap, to_uv } if *to_uv == glam::DAffine2::IDENTITY => bitmap.clone(),
                _ => {
                    let problem = "is another texture than a plain bitmap".into();
                    return Err(props.fault("irradiance", problem, "give a bitmap without to_uv".into()));
                }
            },
            _ => return Err(props.wrong("has no image", "give a bitmap as irradiance")),
        };
        let aspect = f64::from(image.width) / f64::from(image.height);
        let horizontal_fov = fov::horizontal(props, aspect)?;
        let [left, up, forward] = frame(props)?;
        if left.cross(up).dot(forward) < 0.0 {
            return Err(props.fault("to_world", "mirrors the image".into(), "mirror the image file instead".into()));
        }
        let position = props.to_world()?.w_axis.truncate();
        Ok(LightKind::Projector { position, forward, up, horizontal_fov, image, scale: Rgb::grey(scale) })
    }
}

/// The directions of the axes of `to_world`, which must be at right angles and equally long.
pub(super) fn frame(props: &Props<'_>) -> Result<[DVec3; 3]> {
    let m: DMat4 = props.to_world()?;
    let axes = [m.x_axis, m.y_axis, m.z_axis].map(glam::DVec4::truncate);
    let size = axes[2].length();
    let unit = axes.map(|axis| axis / size);
    let off = |a: DVec3, b: DVec3, expected: f64| (a.dot(b) - expected).abs() > ORTHONORMAL;
    let [x, y, z] = unit;
    if size == 0.0 || off(x, x, 1.0) || off(y, y, 1.0) || off(x, y, 0.0) || off(y, z, 0.0) || off(x, z, 0.0) {
        let problem = "is no rotation: its axes are not at right angles and equally long".into();
        return Err(props.fault("to_world", problem, "use lookat, rotate and translate".into()));
    }
    // Files round to single precision; what follows wants right angles.
    let y = (y - z * z.dot(y)).normalize();
    let across = y.cross(z);
    Ok([if across.dot(x) < 0.0 { -across } else { across }, y, z])
}
