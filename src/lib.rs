//! A path-space framework for research on light transport.

pub mod film;
pub mod geometry;
pub mod measure;
pub mod report;
pub mod scene;
pub mod spectrum;
