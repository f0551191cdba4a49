//! Numbers and lists of them as attributes hold them.

use glam::DVec3;

use super::fault::{Fault, Place, Result};

/// A finite number.
pub(super) fn float(text: &str, place: &Place) -> Result<f64> {
    let value = text.trim().parse().ok().filter(|x: &f64| x.is_finite());
    value.ok_or_else(|| Fault::new(place, format!("{text:?} is no finite number"), "correct it"))
}

/// A whole number.
pub(super) fn integer(text: &str, place: &Place) -> Result<i64> {
    let value = text.trim().parse().ok();
    value.ok_or_else(|| Fault::new(place, format!("{text:?} is no whole number"), "correct it"))
}

/// `true` or `false`.
pub(super) fn boolean(text: &str, place: &Place) -> Result<bool> {
    match text.to_ascii_lowercase().as_str() {
        "true" => Ok(true),
        "false" => Ok(false),
        _ => Err(Fault::new(place, format!("{text:?} is neither true nor false"), "write one of them")),
    }
}

/// The parts of a list with commas or spaces between.
pub(super) fn tokens(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| c == ',' || c.is_ascii_whitespace()).filter(|token| !token.is_empty())
}

/// A list of numbers.
pub(super) fn floats(text: &str, place: &Place) -> Result<Vec<f64>> {
    tokens(text).map(|token| float(token, place)).collect()
}

/// Three numbers, or one for all.
pub(super) fn vector(text: &str, place: &Place) -> Result<DVec3> {
    match floats(text, place)?.as_slice() {
        &[x] => Ok(DVec3::splat(x)),
        &[x, y, z] => Ok(DVec3::new(x, y, z)),
        list => Err(Fault::new(place, format!("has {} numbers", list.len()), "give one or three")),
    }
}
