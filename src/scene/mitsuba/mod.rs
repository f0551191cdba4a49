//! The same scene for Mitsuba 3 (3.9.1): an XML file, one binary PLY file per mesh, and the images of textures.

mod error;
mod export;
mod light;
mod material;
mod ply;
mod sensor;
mod shape;
mod texture;
mod xml;

pub use error::ExportError;
pub use export::{ExportOptions, export};

#[cfg(test)]
mod tests;
