//! KHR_lights_punctual.

use super::camera::direction;
use super::document::Document;
use super::fault::{Fault, place};
use super::hierarchy::{Placed, node_place};
use super::tally::Tally;
use crate::scene::description::{Light, LightKind};
use crate::spectrum::Rgb;

/// The light that a node carries, if any: candela and lux are read as W/sr and W/m².
pub(super) fn read(document: &Document, placed: &Placed, tally: &mut Tally) -> Result<Option<Light>, Fault> {
    let node = node_place(document, placed.node);
    let Some(extension) = document.exact.nodes[placed.node].extensions.get("KHR_lights_punctual") else {
        return Ok(None);
    };
    let lights = &document.exact.extensions.lights.lights;
    let index = extension.get("light").and_then(serde_json::Value::as_u64).map(|index| index as usize);
    let Some((index, light)) = index.and_then(|index| Some((index, lights.get(index)?))) else {
        let problem = "refers to a light that does not exist";
        return Err(Fault::invalid(node, problem, "correct the index in its KHR_lights_punctual"));
    };
    let here = place("KHR_lights_punctual.lights", index, light.name.as_deref());
    let colour = Rgb::from(light.color);
    let strength = colour * light.intensity;
    if !strength.is_finite() || strength.min_component() < 0.0 {
        let problem = format!("its intensity times colour is {:?}", strength.to_array());
        return Err(Fault::invalid(here, problem, "make both zero or more"));
    }
    if light.range.is_some() && light.kind != "directional" {
        tally.ranges += 1;
    }
    let position = placed.world.translation;
    let direction = || {
        direction(&placed.world).ok_or_else(|| {
            let problem = "its transform leaves the light no direction";
            Fault::invalid(node.clone(), problem, "give it and its parents a scale other than zero")
        })
    };
    let kind = match light.kind.as_str() {
        "point" => LightKind::Point { position, intensity: strength },
        "directional" => LightKind::Directional { direction: direction()?, irradiance: strength },
        "spot" => {
            let (inner_angle, outer_angle) = (light.spot.inner_cone_angle, light.spot.outer_cone_angle);
            // Single precision writers round π/2 upwards.
            let right_angle = std::f64::consts::FRAC_PI_2;
            if !(inner_angle >= 0.0 && inner_angle < outer_angle && outer_angle <= right_angle + 1e-6) {
                let problem = format!("its cone goes from {inner_angle} to {outer_angle}");
                return Err(Fault::invalid(here, problem, "make 0 ≤ innerConeAngle < outerConeAngle ≤ π/2"));
            }
            let (direction, outer_angle) = (direction()?, outer_angle.min(right_angle));
            LightKind::Spot { position, direction, intensity: strength, inner_angle, outer_angle }
        }
        other => {
            let problem = format!("its type is {other:?}");
            return Err(Fault::invalid(here, problem, "make it point, spot or directional"));
        }
    };
    let name = light.name.clone().or_else(|| document.root.nodes[placed.node].name.clone());
    Ok(Some(Light { name: name.unwrap_or_else(|| format!("light {index}")), kind }))
}
