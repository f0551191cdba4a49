//! `<sensor>` with its film, and `<integrator>` as far as it says how long paths may be.

use glam::{DVec2, DVec3};

use super::emitter::frame;
use super::fault::{Fault, Result};
use super::fov;
use super::node::{Kind, Value};
use super::props::{Props, wrong};
use super::reader::Reader;
use crate::names::did_you_mean;
use crate::scene::description::{FilmSize, Lens, PixelFilter, Projection, SensorDescription, Target};

/// Mitsuba's default of the distance in focus, its far clipping plane \[m\].
const FAR: f64 = 1e4;

const PLUGINS: [&str; 5] = ["perspective", "thinlens", "orthographic", "radiancemeter", "distant"];

/// What of the film matters here.
struct Film {
    /// The whole image.
    size: FilmSize,
    /// The part that is rendered.
    crop: FilmSize,
    /// Its corner.
    offset: [u32; 2],
    filter: PixelFilter,
}

impl Film {
    fn aspect(&self) -> f64 {
        f64::from(self.size.width) / f64::from(self.size.height)
    }

    /// The part of the whole image that is rendered, moved by a share of its width and height.
    fn window(&self, shift: DVec2) -> [DVec2; 2] {
        let size = DVec2::new(self.size.width.into(), self.size.height.into());
        let first = DVec2::new(self.offset[0].into(), self.offset[1].into());
        let extent = DVec2::new(self.crop.width.into(), self.crop.height.into());
        [first / size + shift, (first + extent) / size + shift]
    }
}

impl Reader<'_> {
    /// Chooses a camera and reads it; the others are read for their mistakes only.
    pub(super) fn sensor(&mut self, wanted: Option<&str>) -> Result<()> {
        let sensors = std::mem::take(&mut self.sensors);
        let chosen = match wanted {
            None => 0,
            Some(wanted) => {
                let ids = || sensors.iter().filter_map(|&(index, _)| self.document.nodes[index].id.as_deref());
                let by_id = |&(index, _): &(usize, _)| self.document.nodes[index].id.as_deref() == Some(wanted);
                let number = wanted.parse().ok().filter(|&number: &usize| number < sensors.len());
                let Some(chosen) = sensors.iter().position(by_id).or(number) else {
                    let problem = format!("no sensor is called {wanted:?}{}", did_you_mean(wanted, ids()));
                    let remedy = format!("there are {}: name one by its id or by its number from 0", sensors.len());
                    return Err(Fault::new(&self.document.nodes[0].place, problem, remedy));
                };
                chosen
            }
        };
        let Some(&(index, shape)) = sensors.get(chosen) else { return Ok(()) };
        let props = Props::new(self.document, index);
        self.refuse_media(&props)?;
        let Some(film) = self.film(&props)? else { return Ok(()) };
        let sensor = match shape {
            None => self.camera(&props, &film)?,
            Some(shape) => {
                if props.node.plugin != "irradiancemeter" {
                    let problem = format!("a shape cannot have the sensor {:?}", props.node.plugin);
                    return Err(props.wrong(problem, "move it out of the shape"));
                }
                self.clipping(&props)?;
                let window = film.window(DVec2::ZERO);
                let projection = Projection::Surface { shape };
                let (position, forward, up) = (DVec3::ZERO, DVec3::Z, DVec3::Y);
                SensorDescription { name: String::new(), position, forward, up, projection, window }
            }
        };
        props.finish()?;
        self.scene.sensor = Some(SensorDescription { name: self.name_of(index), ..sensor });
        self.scene.film = Some(film.crop);
        self.scene.filter = film.filter;
        Ok(())
    }

    fn camera(&mut self, props: &Props<'_>, film: &Film) -> Result<SensorDescription> {
        self.clipping(props)?;
        let plugin = props.node.plugin.as_str();
        let (position, axes) = match plugin {
            "radiancemeter" | "distant" => self.ray(props)?,
            "perspective" | "thinlens" | "orthographic" => (props.to_world()?.w_axis.truncate(), self.axes(props)?),
            "irradiancemeter" => return Err(props.wrong("stands outside of a shape", "put it into one")),
            other => {
                let problem = format!("is the unsupported sensor {other:?}{}", did_you_mean(other, PLUGINS));
                return Err(props.wrong(problem, format!("use one of {}", PLUGINS.join(", "))));
            }
        };
        let [left, up, forward] = axes;
        if left.cross(up).dot(forward) < 0.0 {
            return Err(props.fault("to_world", "mirrors the image".into(), "scale x by −1".into()));
        }
        let mut shift = DVec2::ZERO;
        let projection = match plugin {
            "perspective" | "thinlens" => {
                let horizontal = fov::horizontal(props, film.aspect())?;
                let vertical_fov = 2.0 * libm::atan(libm::tan(0.5 * horizontal) / film.aspect());
                // A thin lens of Mitsuba has no such parameters.
                if plugin == "perspective" {
                    shift.x = props.float_or("principal_point_offset_x", 0.0)?;
                    shift.y = props.float_or("principal_point_offset_y", 0.0)?;
                }
                Projection::Perspective { vertical_fov, aspect: None, lens: self.lens(props)? }
            }
            "orthographic" => {
                let half_width = props.to_world()?.x_axis.truncate().length();
                Projection::Orthographic { half_width, half_height: half_width / film.aspect() }
            }
            "distant" => Projection::Distant { target: self.target(props)? },
            _ => Projection::Ray,
        };
        let window = film.window(shift);
        Ok(SensorDescription { name: String::new(), position, forward, up, projection, window })
    }

    /// The axes of a camera; an orthographic one may be scaled.
    fn axes(&self, props: &Props<'_>) -> Result<[DVec3; 3]> {
        let m = props.to_world()?;
        let scale = m.z_axis.truncate().length();
        if props.node.plugin != "orthographic" && (scale - 1.0).abs() > 1e-3 {
            let remedy = "remove the scale from its to_world".to_owned();
            return Err(props.fault("to_world", "scales a camera".into(), remedy));
        }
        if props.node.plugin != "orthographic" {
            return frame(props);
        }
        // Its image is as large as x and y say; z says where it looks only.
        let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis].map(glam::DVec4::truncate);
        let skewed = |a: DVec3, b: DVec3| a.dot(b).abs() > 1e-3 * a.length() * b.length();
        if skewed(x, y) || skewed(y, z) || skewed(x, z) || (x.length() / y.length() - 1.0).abs() > 1e-3 {
            let problem = "skews the image, or scales x and y differently".to_owned();
            return Err(props.fault("to_world", problem, "scale both alike".into()));
        }
        match [x, y, z].map(DVec3::try_normalize) {
            [Some(x), Some(y), Some(z)] => {
                let y = (y - z * z.dot(y)).normalize();
                let across = y.cross(z);
                Ok([if across.dot(x) < 0.0 { -across } else { across }, y, z])
            }
            _ => Err(props.fault("to_world", "makes the image flat".into(), "scale by other numbers than zero".into())),
        }
    }

    fn lens(&self, props: &Props<'_>) -> Result<Option<Lens>> {
        // A pinhole has the parameter and does not use it.
        let focus_distance = props.float_or("focus_distance", FAR)?;
        if props.node.plugin == "perspective" {
            return Ok(None);
        }
        let Some(aperture_radius) = props.float("aperture_radius")? else {
            return Err(props.wrong("has no aperture_radius", "add one, or use perspective"));
        };
        if aperture_radius <= 0.0 || focus_distance <= 0.0 {
            let problem = "has an aperture_radius or a focus_distance that is not above zero";
            return Err(props.wrong(problem, "correct it, or use perspective"));
        }
        Ok(Some(Lens { aperture_radius, focus_distance }))
    }

    /// Where a sensor of one ray stands and looks.
    fn ray(&self, props: &Props<'_>) -> Result<(DVec3, [DVec3; 3])> {
        let distant = props.node.plugin == "distant";
        let direction = props.vector("direction")?;
        // From far away, wherever that is.
        let far = direction.filter(|_| distant).map(|_| DVec3::ZERO);
        let origin = if distant { far } else { props.vector("origin")? };
        match (props.has("to_world"), origin, direction) {
            (true, _, Some(_)) if distant => Err(props.wrong("has a direction and to_world", "give one of the two")),
            (true, ..) => Ok((props.to_world()?.w_axis.truncate(), frame(props)?)),
            (false, Some(origin), Some(direction)) => {
                let Some(forward) = direction.try_normalize() else {
                    return Err(props.fault("direction", "is zero".into(), "give another".into()));
                };
                let frame = crate::geometry::Frame::around(forward);
                Ok((origin, [frame.y.cross(forward), frame.y, forward]))
            }
            (false, None, None) => Ok((DVec3::ZERO, [DVec3::X, DVec3::Y, DVec3::Z])),
            _ => Err(props.wrong("has an origin or a direction alone", "give both, or to_world")),
        }
    }

    /// What a distant sensor takes the mean over.
    fn target(&self, props: &Props<'_>) -> Result<Target> {
        let Some(property) = props.get("target") else { return Ok(Target::Scene) };
        let index = match property.value {
            Value::Vector(point) => return Ok(Target::Point(point)),
            Value::Object(index) => index,
            _ => return Err(wrong(property, "a point or a shape")),
        };
        let shape = Props::new(self.document, index);
        let m = shape.to_world()?;
        let [u, v, centre] = [m.x_axis, m.y_axis, m.w_axis].map(glam::DVec4::truncate);
        match shape.node.plugin.as_str() {
            "rectangle" => Ok(Target::Parallelogram { centre, u, v }),
            "disk" => Ok(Target::Ellipse { centre, u, v }),
            other => {
                let problem = format!("a target of the shape {other:?} is not supported");
                Err(Fault::new(&property.place, problem, "give a point, a rectangle or a disk"))
            }
        }
    }

    /// Clipping planes are not there; whether they would cut something is for the user to see.
    fn clipping(&mut self, props: &Props<'_>) -> Result<()> {
        for (name, default) in [("near_clip", 1e-2), ("far_clip", FAR)] {
            if props.float_or(name, default)? != default {
                let place = props.get(name).map_or(&props.node.place, |property| &property.place);
                self.warnings.add(place, "nothing is clipped: what lies nearer or farther is seen all the same");
            }
        }
        // Nothing moves.
        props.ignore(&["shutter_open", "shutter_close"]);
        if props.has("srf") {
            let problem = "spectral response functions are not supported".to_owned();
            return Err(props.fault("srf", problem, "remove it".into()));
        }
        Ok(())
    }

    /// The film of a sensor, and its sampler, of which nothing depends.
    fn film(&mut self, props: &Props<'_>) -> Result<Option<Film>> {
        if let Some(sampler) = props.object(Kind::Sampler)? {
            let _ = sampler;
        }
        let Some(index) = props.object(Kind::Film)? else {
            let size = FilmSize { width: 768, height: 576 };
            let filter = PixelFilter::Gaussian { stddev: 0.5 };
            return Ok(Some(Film { size, crop: size, offset: [0; 2], filter }));
        };
        let film = Props::new(self.document, index);
        if film.node.plugin != "hdrfilm" {
            let problem = format!("is the unsupported film {:?}", film.node.plugin);
            return Err(film.wrong(problem, "use hdrfilm"));
        }
        // How the image is stored.
        film.ignore(&["file_format", "pixel_format", "component_format", "banner", "compensate", "sample_border"]);
        let number = |name: &'static str, default: u32| match film.integer(name)? {
            None => Ok(default),
            Some(number) => u32::try_from(number)
                .map_err(|_| film.fault(name, format!("is {number}"), "give a number of pixels".into())),
        };
        let size = FilmSize { width: number("width", 768)?, height: number("height", 576)? };
        let crop = FilmSize { width: number("crop_width", size.width)?, height: number("crop_height", size.height)? };
        let offset = [number("crop_offset_x", 0)?, number("crop_offset_y", 0)?];
        let fits =
            |whole: u32, part: u32, from: u32| part > 0 && part.checked_add(from).is_some_and(|end| end <= whole);
        if !fits(size.width, crop.width, offset[0]) || !fits(size.height, crop.height, offset[1]) {
            return Err(film.wrong("has no pixels, or a crop outside of the image", "correct its sizes"));
        }
        let filter =
            film.object(Kind::Filter)?.map_or(Ok(PixelFilter::Gaussian { stddev: 0.5 }), |f| self.filter(f))?;
        film.finish()?;
        Ok(Some(Film { size, crop, offset, filter }))
    }

    fn filter(&self, index: usize) -> Result<PixelFilter> {
        let props = Props::new(self.document, index);
        let positive = |name: &'static str, default: f64| {
            let value = props.float_or(name, default)?;
            if value > 0.0 {
                return Ok(value);
            }
            Err(props.fault(name, "is not above zero".into(), "give a width in pixels".into()))
        };
        let filter = match props.node.plugin.as_str() {
            "box" => PixelFilter::Box,
            "tent" => PixelFilter::Tent { radius: positive("radius", 1.0)? },
            "gaussian" => PixelFilter::Gaussian { stddev: positive("stddev", 0.5)? },
            other => {
                let problem = format!(
                    "the filter {other:?} is not supported{}",
                    did_you_mean(other, ["box", "tent", "gaussian"])
                );
                return Err(props.wrong(problem, "use box, tent or gaussian: others have negative weights"));
            }
        };
        props.finish()?;
        Ok(filter)
    }

    /// What the integrator says about the length of paths.
    pub(super) fn integrator(&mut self, index: usize) -> Result<()> {
        let props = Props::new(self.document, index);
        let plugin = props.node.plugin.as_str();
        let known = ["path", "ptracer", "direct", "volpath", "volpathmip", "prb", "prb_basic", "prb_projective"];
        if !known.contains(&plugin) {
            let text = format!("the integrator {plugin:?} is not known here; the method is chosen on the command line");
            self.warnings.add(&props.node.place, text);
        }
        if props.boolean_or("hide_emitters", false)? {
            let problem = "emitters cannot be hidden".to_owned();
            return Err(props.fault("hide_emitters", problem, "set it to false".into()));
        }
        self.scene.render.max_length = match props.integer("max_depth")? {
            // One bounce, which is what it does.
            None if plugin == "direct" => Some(2),
            None | Some(-1) => None,
            Some(depth) => match u32::try_from(depth) {
                Ok(length @ 1..) => Some(length),
                _ => {
                    let remedy = "give the longest path in edges, or -1 for any length";
                    return Err(props.fault("max_depth", format!("is {depth}"), remedy.into()));
                }
            },
        };
        Ok(())
    }
}
