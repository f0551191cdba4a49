//! From a file to a scene that can be traced.

pub mod bsdf;
pub mod description;
pub mod mitsuba;

pub use description::SceneDescription;
