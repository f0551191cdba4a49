//! Lambert's model.

use crate::spectrum::Rgb;

/// `f_s = reflectance / π` where both directions are in front, drawn in proportion to the cosine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Diffuse {
    /// Share of the flux that is reflected, 0 … 1.
    pub reflectance: Rgb,
}
