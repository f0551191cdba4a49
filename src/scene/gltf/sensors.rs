//! `sensors` in the extras of a scene: meters with names.

use std::collections::BTreeMap;

use serde_json::Value;

use super::fault::Fault;
use crate::scene::description::SceneDescription;
use crate::scene::meter::{Meter, MeterError, NamedMeter};

/// In the order of their names.
pub(super) fn read(
    sensors: &BTreeMap<String, Value>,
    scene: &SceneDescription,
    owner: &str,
) -> Result<Vec<NamedMeter>, Fault> {
    let read = |(name, value): (&String, &Value)| {
        let place = format!("{owner}.extras.pathspace.sensors.{name}");
        // What has a colon is a meter on the command line, where names stand in the same place.
        if name.is_empty() || name.contains(':') || Meter::is_kind(name) {
            let remedy = "give it a name without colons that is not that of a meter";
            return Err(Fault::invalid(place, "a sensor cannot be called that", remedy));
        }
        let Some(text) = value.as_str() else {
            return Err(Fault::invalid(place, format!("{value} is no text"), "write, say, \"irradiance:0,0,0:0,1,0\""));
        };
        let wrong = |error: MeterError| Fault::invalid(&place, format!("{text:?}: {}", error.problem), error.remedy);
        let meter: Meter = text.parse().map_err(wrong)?;
        meter.check_surface(scene).map_err(wrong)?;
        Ok(NamedMeter { name: name.clone(), meter })
    };
    sensors.iter().map(read).collect()
}
