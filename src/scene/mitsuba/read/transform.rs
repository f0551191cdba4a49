//! `<transform>`: operations, each applied after those before it.

use glam::{DMat4, DVec3, DVec4};

use super::document::{allow, coordinates, required};
use super::fault::{Fault, Place, Result, Warnings};
use super::number;
use super::tree::Element;
use crate::geometry::Frame;

/// The product of all operations inside of an element.
pub(super) fn compose(element: &Element, warnings: &mut Warnings) -> Result<DMat4> {
    let mut product = DMat4::IDENTITY;
    for operation in &element.children {
        product = matrix(operation, warnings)? * product;
        if !product.is_finite() {
            let problem = "leads to numbers that are not finite";
            return Err(Fault::new(&operation.place(), problem, "correct its numbers"));
        }
    }
    Ok(product)
}

fn matrix(element: &Element, warnings: &mut Warnings) -> Result<DMat4> {
    let place = element.place();
    if let Some(child) = element.children.first() {
        return Err(Fault::new(&child.place(), format!("cannot stand inside of <{}>", element.tag), "move it out"));
    }
    match element.tag.as_str() {
        "translate" => Ok(DMat4::from_translation(coordinates(element, Some(0.0))?)),
        "scale" => Ok(DMat4::from_scale(coordinates(element, Some(1.0))?)),
        "rotate" => {
            let axis = coordinates(element, Some(0.0))?;
            let angle = number::float(required(element, "angle")?, &place)?;
            if axis == DVec3::ZERO {
                return Err(Fault::new(&place, "has no axis", "give x, y or z other than zero"));
            }
            if (axis.length() - 1.0).abs() > 1e-4 {
                let text = "an axis that has not length one makes the transform more than a rotation, as in Mitsuba";
                warnings.add(&place, text);
            }
            Ok(rotation(axis, angle.to_radians()))
        }
        "lookat" | "lookAt" => {
            allow(element, &["origin", "target", "up"])?;
            let point = |name: &str, text: &str| -> Result<DVec3> {
                match number::floats(text, &place)?.as_slice() {
                    &[x, y, z] => Ok(DVec3::new(x, y, z)),
                    _ => Err(Fault::new(&place, format!("its {name} has not three numbers"), "give three")),
                }
            };
            let origin = point("origin", required(element, "origin")?)?;
            let target = point("target", required(element, "target")?)?;
            let up = element.attribute("up").filter(|text| !text.is_empty());
            let up = up.map(|text| point("up", text)).transpose()?;
            look_at(origin, target, up, &place)
        }
        "matrix" => {
            allow(element, &["value"])?;
            match number::floats(required(element, "value")?, &place)?.as_slice() {
                &[a, b, c, d, e, f, g, h, i] => Ok(DMat4::from_cols(
                    DVec4::new(a, d, g, 0.0),
                    DVec4::new(b, e, h, 0.0),
                    DVec4::new(c, f, i, 0.0),
                    DVec4::W,
                )),
                list if list.len() == 16 => {
                    let rows: [f64; 16] = std::array::from_fn(|i| list[i]);
                    Ok(DMat4::from_cols_array(&rows).transpose())
                }
                list => {
                    let problem = format!("has {} numbers", list.len());
                    Err(Fault::new(&place, problem, "give 9 or 16, row by row"))
                }
            }
        }
        tag => {
            let problem = format!("<{tag}> is no operation of a transform");
            Err(Fault::new(&place, problem, "use matrix, lookat, translate, rotate and scale"))
        }
    }
}

/// Rodrigues' formula, which turns around axes of length one; with sine and cosine that are the same on every CPU.
fn rotation(axis: DVec3, angle: f64) -> DMat4 {
    let (sin, cos) = libm::sincos(angle);
    let column = |e: DVec3| cos * e + sin * axis.cross(e) + (1.0 - cos) * axis.dot(e) * axis;
    DMat4::from_cols(column(DVec3::X).extend(0.0), column(DVec3::Y).extend(0.0), column(DVec3::Z).extend(0.0), DVec4::W)
}

/// The frame of a camera, which looks along +z, has y up and x to the left.
fn look_at(origin: DVec3, target: DVec3, up: Option<DVec3>, place: &Place) -> Result<DMat4> {
    let frame = || {
        let forward = (target - origin).try_normalize()?;
        let up = up.filter(|up| *up != DVec3::ZERO).unwrap_or_else(|| Frame::around(forward).x);
        let left = up.cross(forward).try_normalize()?;
        let up = forward.cross(left);
        Some(DMat4::from_cols(left.extend(0.0), up.extend(0.0), forward.extend(0.0), origin.extend(1.0)))
    };
    frame().ok_or_else(|| Fault::new(place, "does not say where to look", "keep origin, target and up apart"))
}
