//! Indices of refraction by name.

use super::fault::Result;
use super::node::Value;
use super::props::{Props, wrong};
use super::tables::METALS;
use crate::names::did_you_mean;
use crate::spectrum::Rgb;

/// What Mitsuba knows by name; most of them from Hecht (Optics, fourth edition), at 589 nm.
const NAMED: [(&str, f64); 23] = [
    ("vacuum", 1.0),
    ("helium", 1.000036),
    ("hydrogen", 1.000132),
    ("air", 1.000277),
    ("carbon dioxide", 1.00045),
    ("water", 1.3330),
    ("acetone", 1.36),
    ("ethanol", 1.361),
    ("carbon tetrachloride", 1.461),
    ("glycerol", 1.4729),
    ("benzene", 1.501),
    ("silicone oil", 1.52045),
    ("bromine", 1.661),
    ("water ice", 1.31),
    ("fused quartz", 1.458),
    ("pyrex", 1.470),
    ("acrylic glass", 1.49),
    ("polypropylene", 1.49),
    ("bk7", 1.5046),
    ("sodium chloride", 1.544),
    ("amber", 1.55),
    ("pet", 1.5750),
    ("diamond", 2.419),
];

/// An index of refraction as a number or by name.
pub(super) fn read(props: &Props<'_>, name: &'static str, default: f64) -> Result<f64> {
    let Some(property) = props.get(name) else { return Ok(default) };
    let value = match &property.value {
        Value::Float(x) => *x,
        Value::Integer(x) => *x as f64,
        Value::Text(text) => {
            let known = NAMED.iter().find(|(name, _)| text.eq_ignore_ascii_case(name));
            let Some(&(_, value)) = known else {
                let suggestion = did_you_mean(text, NAMED.iter().map(|&(name, _)| name));
                let problem = format!("no index of refraction is called {text:?}{suggestion}");
                return Err(props.fault(name, problem, "give a number".into()));
            };
            value
        }
        _ => return Err(wrong(property, "a float or a name")),
    };
    if value > 0.0 {
        return Ok(value);
    }
    Err(props.fault(name, "is not above zero".into(), "give an index of refraction, such as 1.5".into()))
}

/// The default of `int_ior` of glass.
pub(super) const BK7: f64 = 1.5046;
/// The default of `int_ior` of plastic.
pub(super) const POLYPROPYLENE: f64 = 1.49;
/// The default of `ext_ior`.
pub(super) const AIR: f64 = 1.000277;

/// η and k of a metal, by the name that Mitsuba has for it.
pub(super) fn metal(props: &Props<'_>, name: &str) -> Result<(Rgb, Rgb)> {
    match METALS.iter().find(|(metal, ..)| *metal == name) {
        Some(&(_, eta, k)) => Ok((eta.into(), k.into())),
        None => {
            let suggestion = did_you_mean(name, METALS.iter().map(|&(metal, ..)| metal));
            let problem = format!("no metal is called {name:?}{suggestion}");
            Err(props.fault("material", problem, "give eta and k".into()))
        }
    }
}
