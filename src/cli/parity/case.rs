//! The list of cases, as Mitsuba's side writes it.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use serde::Deserialize;

/// A feature and its scene.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct Case {
    /// GROUP/FEATURE.
    pub name: String,
    /// The file.
    pub scene: PathBuf,
    /// Values of its parameters.
    pub parameters: Vec<(String, String)>,
    /// An image of it by a third renderer.
    pub independent: Option<PathBuf>,
    /// Longest path in edges.
    pub max_depth: u32,
    /// So many pixels at the film's edge are left out.
    pub border: u32,
    /// Multiple of the usual number of samples.
    pub effort: u64,
    /// Mitsuba's integrators.
    pub integrators: Vec<String>,
    /// `same` where densities are Mitsuba's.
    pub pdf: String,
    /// Relative error of a table that Mitsuba has instead of a formula.
    pub table: f64,
    /// The same of its densities alone.
    pub fit: f64,
}

impl Case {
    pub(super) fn same_densities(&self) -> bool {
        self.pdf == "same"
    }
}

pub(super) fn read(path: &Path) -> anyhow::Result<Vec<Case>> {
    serde_json::from_slice(&super::read(path)?).map_err(|error| anyhow!("{}: {error}; run again", path.display()))
}
