//! Scenes of Mitsuba 3 (3.9.1). [`read`] takes them as they are; [`export`] writes the same scene for Mitsuba: an XML
//! file, one binary PLY file per mesh, and the images of textures.

mod error;
mod export;
mod light;
mod material;
mod ply;
pub mod read;
mod sensor;
mod shape;
mod texture;
mod xml;

pub use error::ExportError;
pub use export::{ExportOptions, export};

#[cfg(test)]
mod tests;
