//! Pixels: what a render accumulates, how certain it is, and the files it ends up in.
//!
//! A [`Film`] sums passes; a pass is one sample in every pixel, an independent unbiased estimate of the whole image.
//! Beside the image it may keep [`Layers`], one per path length and per technique.
//! Its state goes to a file of its own ([`state`]), from which the render can go on; EXR and PNG are for looking.

mod accumulator;
mod blocks;
mod counters;
mod error;
pub mod exr;
mod image;
mod layers;
mod moments;
pub mod output;
pub mod png;
pub mod state;

pub use accumulator::Film;
pub use blocks::{BLOCK_SIDE, BlockGrid, BlockStatistics};
pub use counters::{Counters, ReplayKey};
pub use error::{FileError, FilmError};
pub use image::Image;
pub use layers::{
    Contribution, Layer, LayerListing, LayerPart, LayerPass, LayerSelection, Layers, Tally, TechniqueRow,
};
pub use moments::Moments;
pub use output::{OutputFormat, RenderInfo, check_writable, write_image};
