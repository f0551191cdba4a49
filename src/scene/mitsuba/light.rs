//! Lights without a surface as Mitsuba's emitters.

use std::cmp::Ordering;
use std::sync::Arc;

use glam::DAffine2;

use super::error::ExportError;
use super::texture::Images;
use super::xml::Element;
use crate::geometry::Frame;
use crate::scene::description::{EnvironmentDescription, Light, LightKind, SceneDescription};
use crate::scene::texture::{Bitmap, Texels, Texture};
use crate::spectrum::Rgb;

/// An emitter from one point or direction.
pub(super) fn light(scene: &SceneDescription, light: &Light, images: &mut Images) -> Result<Element, ExportError> {
    let place = format!("light '{}'", light.name);
    match &light.kind {
        &LightKind::Point { position, intensity } => {
            check_power(scene, &place, intensity)?;
            Ok(Element::plugin("emitter", "point").point("position", position).rgb("intensity", intensity))
        }
        &LightKind::Spot { position, direction, intensity, inner_angle, outer_angle } => {
            check_power(scene, &place, intensity)?;
            // Mitsuba divides by the difference of the angles.
            if inner_angle.partial_cmp(&outer_angle) != Some(Ordering::Less) {
                let what =
                    format!("a spot whose inner cone ({inner_angle} rad) is not inside the outer ({outer_angle} rad)");
                let remedy = "make the outer angle larger";
                return Err(ExportError::unsupported(&scene.name, place, what, remedy));
            }
            let frame = Frame::around(direction);
            Ok(Element::plugin("emitter", "spot")
                .rgb("intensity", intensity)
                .float("cutoff_angle", outer_angle.to_degrees())
                .float("beam_width", inner_angle.to_degrees())
                .frame(frame.x, frame.y, frame.z, position))
        }
        LightKind::Projector { position, forward, up, horizontal_fov, image, scale } => {
            check_power(scene, &place, *scale)?;
            // Mitsuba's scale has no colour.
            let grey = scale.r == scale.g && scale.g == scale.b;
            let (image, factor) = if grey { (image.clone(), scale.r) } else { (Arc::new(tinted(image, *scale)), 1.0) };
            let texture = Texture::Bitmap { bitmap: image, to_uv: DAffine2::IDENTITY };
            Ok(Element::plugin("emitter", "projector")
                .child(images.element(&texture, true, "irradiance", scene, &place)?)
                .float("scale", factor)
                .float("fov", horizontal_fov.to_degrees())
                .string("fov_axis", "x")
                .frame(up.cross(*forward), *up, *forward, *position))
        }
        &LightKind::Directional { direction, irradiance } => {
            check_power(scene, &place, irradiance)?;
            Ok(Element::plugin("emitter", "directional").vector("direction", direction).rgb("irradiance", irradiance))
        }
    }
}

/// The emitter at infinity.
pub(super) fn environment(
    scene: &SceneDescription,
    environment: &EnvironmentDescription,
    images: &mut Images,
) -> Result<Element, ExportError> {
    match environment {
        EnvironmentDescription::Constant(radiance) => {
            check_power(scene, "environment", *radiance)?;
            Ok(Element::plugin("emitter", "constant").rgb("radiance", *radiance))
        }
        EnvironmentDescription::Map { bitmap, scale, to_world } => {
            check_power(scene, "environment", Rgb::grey(*scale))?;
            // Mitsuba takes every image of eight bits for sRGB here.
            let linear = matches!(bitmap.texels, Texels::Linear8(_));
            let bitmap = if linear { Arc::new(tinted(bitmap, Rgb::WHITE)) } else { bitmap.clone() };
            Ok(Element::plugin("emitter", "envmap")
                .string("filename", &images.file(&bitmap))
                .float("scale", *scale)
                .frame(to_world.x_axis, to_world.y_axis, to_world.z_axis, glam::DVec3::ZERO))
        }
    }
}

/// The image times a colour, in floating point.
fn tinted(bitmap: &Bitmap, tint: Rgb) -> Bitmap {
    let places = (0..bitmap.height).flat_map(|y| (0..bitmap.width).map(move |x| (x, y)));
    let texels = places.map(|(x, y)| {
        let [r, g, b, a] = bitmap.texel(x.into(), y.into());
        [r * tint.r, g * tint.g, b * tint.b, a].map(|x| x as f32)
    });
    Bitmap { texels: Texels::Float(texels.collect()), ..bitmap.clone() }
}

pub(super) fn check_power(scene: &SceneDescription, place: &str, value: Rgb) -> Result<(), ExportError> {
    if value.is_finite() && value.min_component() >= 0.0 {
        return Ok(());
    }
    let problem = format!("emits {:?}; give finite values that are not negative", value.to_array());
    Err(ExportError::invalid(&scene.name, place, problem))
}
