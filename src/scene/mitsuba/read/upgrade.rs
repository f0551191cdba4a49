//! Files of Mitsuba 0.5 and 0.6 as those of Mitsuba 3, where the meaning is clear: the upgrade that Mitsuba makes itself.

use glam::{DMat4, DVec3};

use super::fault::{Fault, Result};
use super::node::{Node, Property, Value};

/// Renames what an object of an old file has.
pub(super) fn node(node: &mut Node) -> Result<()> {
    if !node.old {
        return Ok(());
    }
    for property in &mut node.properties {
        property.name = underscored(&property.name);
        if node.plugin == "diffuse" && property.name == "diffuse_reflectance" {
            property.name = "reflectance".into();
        }
    }
    let mut scale = DVec3::ONE;
    let mut offset = DVec3::ZERO;
    let mut first = None;
    for property in &node.properties {
        let target = match property.name.as_str() {
            "uoffset" => &mut offset.x,
            "voffset" => &mut offset.y,
            "uscale" => &mut scale.x,
            "vscale" => &mut scale.y,
            _ => continue,
        };
        *target = match property.value {
            Value::Float(x) => x,
            Value::Integer(x) => x as f64,
            _ => return Err(Fault::new(&property.place, "is no number", "give a <float>")),
        };
        first.get_or_insert_with(|| property.place.clone());
    }
    if let Some(place) = first {
        node.properties.retain(|p| !matches!(p.name.as_str(), "uoffset" | "voffset" | "uscale" | "vscale"));
        if node.properties.iter().any(|p| p.name == "to_uv") {
            return Err(Fault::new(&place, "stands beside to_uv", "give one of the two"));
        }
        let value = Value::Transform(DMat4::from_scale(scale) * DMat4::from_translation(offset));
        node.properties.push(Property { name: "to_uv".into(), value, place });
    }
    Ok(())
}

/// `toWorld` → `to_world`, `specularReflectance` → `specular_reflectance`, `intIOR` → `int_ior`.
fn underscored(name: &str) -> String {
    let mut result = String::with_capacity(name.len() + 4);
    let mut lower = false;
    let mut capitals = false;
    for c in name.chars() {
        capitals = c.is_ascii_uppercase() && (lower || capitals);
        if capitals {
            if lower {
                result.push('_');
            }
            result.push(c.to_ascii_lowercase());
        } else {
            result.push(c);
        }
        lower = c.is_ascii_lowercase();
    }
    result
}
