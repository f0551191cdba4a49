//! Truncation of walks by a random length, without bias.

use serde::{Deserialize, Serialize};

use crate::spectrum::Rgb;

/// How a walk decides whether to go on. Its survival probability is a pure function of the walk's own prefix, so the
/// density of any path can be evaluated, whoever drew it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Roulette {
    /// Goes on until it leaves the scene or reaches the longest length.
    Off,
    /// `q` the same everywhere.
    Fixed {
        /// Edges before the first decision.
        start: u32,
        /// q, above 0.
        survival: f64,
    },
    /// `q = min(1, max_c w)`, with w the weight `f_s |cos θ| / p_σ` of the last scattering alone. Local, so the walk that
    /// comes from the other end can evaluate it too.
    Local {
        /// Edges before the first decision.
        start: u32,
    },
    /// `q = min(0.95, max_c β)`, with β the product of the weights and the survival probabilities' reciprocals so far.
    Throughput {
        /// Edges before the first decision.
        start: u32,
    },
}

impl Roulette {
    /// The probability of going on from a vertex that `edges` edges lead to. `local` gives the weight of the scattering
    /// there and `throughput` the product of the walk's weights up to and including it, both without the radiance's η²;
    /// they are asked only where the answer depends on them.
    #[must_use]
    #[inline(always)]
    pub fn survival(&self, edges: u32, local: impl FnOnce() -> Rgb, throughput: impl FnOnce() -> Rgb) -> f64 {
        match *self {
            Self::Fixed { survival, .. } if self.applies(edges) => survival,
            Self::Local { .. } if self.applies(edges) => local().max_component().min(1.0),
            Self::Throughput { .. } if self.applies(edges) => throughput().max_component().min(0.95),
            _ => 1.0,
        }
    }

    /// A decision is made at a vertex that `edges` edges lead to.
    #[must_use]
    #[inline]
    pub fn applies(&self, edges: u32) -> bool {
        match *self {
            Self::Off => false,
            Self::Fixed { start, .. } | Self::Local { start } | Self::Throughput { start } => edges >= start,
        }
    }

    /// [`survival`](Self::survival) needs no more than the scattering at the vertex itself.
    #[must_use]
    pub fn is_local(&self) -> bool {
        !matches!(self, Self::Throughput { .. })
    }
}
