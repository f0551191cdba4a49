//! Truncation of walks by a random length, without bias.

use serde::{Deserialize, Serialize};

use crate::spectrum::Rgb;

/// How a walk decides whether to go on. Its survival probability is a pure function of the walk's own prefix, so the
/// density of any path can be evaluated, whoever drew it.
///
/// Where light is lost, what is left of it decides. Where none is, as on directions that total reflection traps in glass, the
/// [cap](Self::cap) ends walks: with probability one, and at a bounded expected cost.
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
    /// `q = min(c, max w)`, with c the [cap](Self::cap) and w the weight `f_s |cos θ| / p_σ` of the last scattering alone, the
    /// largest of its channels. Local, so the walk that comes from the other end can evaluate it too.
    Local {
        /// Edges before the first decision.
        start: u32,
        /// Edges from which on the cap is below one.
        long: u32,
    },
    /// `q = min(c, max β)`, with β the product of the weights and the survival probabilities' reciprocals so far.
    Throughput {
        /// Edges before the first decision.
        start: u32,
        /// Edges from which on the cap is below one.
        long: u32,
    },
}

impl Roulette {
    /// Of integrators whose time for a sample grows with its walk: `long` as below for 2000 edges. An enclosure of albedo
    /// 0.9999, walks of 10⁴ vertices without a cap, then has 41 times the variance at 3.5 times less time.
    pub const LONG: u32 = 2000;

    /// Of what takes time in proportion to the square of a walk's length: connecting all pairs of two walks' vertices, and
    /// samplers, which give all paths along a walk whole.
    pub const LONG_FOR_PAIRS: u32 = 100;

    /// The probability of going on from a vertex that `edges` edges lead to. `local` gives the weight of the scattering
    /// there and `throughput` the product of the walk's weights up to and including it, both without the radiance's η²;
    /// they are asked only where the answer depends on them.
    #[must_use]
    #[inline(always)]
    pub fn survival(&self, edges: u32, local: impl FnOnce() -> Rgb, throughput: impl FnOnce() -> Rgb) -> f64 {
        match *self {
            Self::Fixed { survival, .. } if self.applies(edges) => survival,
            Self::Local { .. } if self.applies(edges) => local().max_component().min(self.cap(edges)),
            Self::Throughput { .. } if self.applies(edges) => throughput().max_component().min(self.cap(edges)),
            _ => 1.0,
        }
    }

    /// The largest probability of going on, however little is lost: 1 before `long` edges, and `c = (n/(n+1))^(5/2)` after n.
    ///
    /// Then `P(N ≥ n) ≤ (long/n)^(5/2)` for the length N of a walk, so the expectations of N and of N², what connecting
    /// all pairs of two walks' vertices costs, are at most 5/3 of `long` and 5 of `long²`. Any albedo below 1 − 5/(2n) loses
    /// more in the long run than weights gain by the cap, whose variance is finite therefore. A cap that is constant has
    /// one or the other: with 0.95, it is infinite wherever the squared albedo is above that.
    #[must_use]
    #[inline]
    pub fn cap(&self, edges: u32) -> f64 {
        match *self {
            Self::Local { long, .. } | Self::Throughput { long, .. } if edges >= long => {
                let n = f64::from(edges);
                let ratio = n / (n + 1.0);
                ratio * ratio * ratio.sqrt()
            }
            _ => 1.0,
        }
    }

    /// A decision is made at a vertex that `edges` edges lead to.
    #[must_use]
    #[inline]
    pub fn applies(&self, edges: u32) -> bool {
        match *self {
            Self::Off => false,
            Self::Fixed { start, .. } | Self::Local { start, .. } | Self::Throughput { start, .. } => edges >= start,
        }
    }

    /// [`survival`](Self::survival) needs no more than the scattering at the vertex itself and the number of edges.
    #[must_use]
    pub fn is_local(&self) -> bool {
        !matches!(self, Self::Throughput { .. })
    }

    /// Every walk ends, even in a closed scene that loses nothing.
    #[must_use]
    pub fn ends(&self) -> bool {
        *self != Self::Off
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What nothing is lost in ends as the docs say: lengths N with `P(N ≥ n) = (long/n)^(5/2)`.
    #[test]
    fn the_cap_is_a_power_law() {
        for roulette in [Roulette::Local { start: 3, long: 100 }, Roulette::Throughput { start: 5, long: 100 }] {
            let survival = |edges| roulette.survival(edges, || Rgb::WHITE, || Rgb::WHITE);
            assert!((1..100).all(|edges| survival(edges) == 1.0));
            let (mut reach, mut mean, mut square) = (1.0, 0.0, 0.0);
            for edges in 1..4_000_000 {
                mean += reach;
                square += reach * (2.0 * f64::from(edges) - 1.0);
                reach *= survival(edges);
                if edges == 9_999 {
                    assert!((reach / 1e-5 - 1.0).abs() < 1e-9, "{reach}");
                }
            }
            assert!((160.0..100.0 * 5.0 / 3.0 + 1.0).contains(&mean), "{mean}");
            assert!((45_000.0..5.0 * 1e4).contains(&square), "{square}");
        }
    }

    #[test]
    fn what_is_lost_comes_first() {
        let grey = || Rgb::grey(0.9);
        let (local, fixed) = (Roulette::Local { start: 3, long: 10 }, Roulette::Fixed { start: 3, survival: 0.8 });
        assert_eq!([2, 3, 9].map(|edges| local.survival(edges, grey, grey)), [1.0, 0.9, 0.9]);
        assert!((local.survival(10, grey, grey) - libm::pow(10.0 / 11.0, 2.5)).abs() < 1e-15);
        assert_eq!([2, 3, 1_000_000].map(|edges| fixed.survival(edges, grey, grey)), [1.0, 0.8, 0.8]);
        assert_eq!(Roulette::Off.survival(1_000_000, grey, grey), 1.0);
    }
}
