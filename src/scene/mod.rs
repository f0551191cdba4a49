//! From a file to a scene that can be traced.

pub mod bsdf;
pub mod description;
pub mod error;
pub mod gltf;

pub use description::SceneDescription;
pub use error::SceneError;
