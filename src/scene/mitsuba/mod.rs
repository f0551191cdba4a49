//! The same scene for Mitsuba 3 (3.9.1): an XML file, and one binary PLY file per mesh.

mod error;
mod export;
mod ply;
mod sensor;
mod xml;

pub use error::ExportError;
pub use export::{ExportOptions, export};

#[cfg(test)]
mod tests;
