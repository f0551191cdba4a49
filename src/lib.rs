//! A path-space framework for research on light transport.

pub mod geometry;
pub mod measure;
pub mod scene;
pub mod spectrum;
pub mod warp;
