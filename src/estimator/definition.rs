//! What the weights of a path are by definition: from the densities of all its techniques.

use crate::path::{Path, Technique, WalkRules};
use crate::scene::Scene;
use crate::wide::Wide;

use super::heuristic::Heuristic;

/// A set of bidirectional techniques with everything that their weights depend on.
pub struct Definition<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// How the walks end.
    pub rules: WalkRules,
    /// How techniques share a path.
    pub heuristic: Heuristic,
    /// Which techniques take part, of those for paths with this many edges.
    pub takes_part: fn(Technique) -> bool,
}

impl Definition<'_> {
    /// `n_i`, the number of samples of a technique that serve a pixel in one pass: light walks serve all of them.
    #[must_use]
    pub fn count(&self, technique: Technique) -> f64 {
        let film = self.scene.sensor().film();
        if technique.t <= 1 { f64::from(film.width) * f64::from(film.height) } else { 1.0 }
    }

    /// `n_i p_i(x̄)` of all techniques that take part, in order of s; zero for the others.
    #[must_use]
    pub fn densities(&self, path: &Path) -> Vec<Wide> {
        Technique::all(path.edges() as u32)
            .map(|technique| {
                if (self.takes_part)(technique) {
                    self.scene.path_density(path, technique, &self.rules) * self.count(technique)
                } else {
                    Wide::ZERO
                }
            })
            .collect()
    }

    /// `w_i(x̄)` for the technique number i, given all `n_j p_j(x̄)`.
    #[must_use]
    pub fn weight(&self, densities: &[Wide], i: usize) -> f64 {
        if densities[i].is_zero() {
            return 0.0;
        }
        let ratio = |j: usize| (densities[j] / densities[i]).to_f64();
        self.heuristic.weight((0..i).map(ratio), (i + 1..densities.len()).map(ratio))
    }
}
