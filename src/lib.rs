//! A path-space framework for research on light transport.

pub mod cli;
pub mod estimator;
pub mod experiment;
pub mod film;
pub mod geometry;
pub mod measure;
mod names;
pub mod path;
mod quadrature;
pub mod report;
pub mod sampler;
pub mod scene;
pub mod spectrum;
pub mod testing;
pub mod warp;
pub mod wide;
