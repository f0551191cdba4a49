//! Heuristics for multiple importance sampling.

use serde::{Deserialize, Serialize};

/// How the techniques that can draw the same sample share it (Veach 1997, §9.2). All are given `n_i p_i`, the density of
/// technique i times the number of samples drawn with it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Heuristic {
    /// `w_i = n_i p_i / Σ_j n_j p_j`.
    #[default]
    Balance,
    /// `w_i = (n_i p_i)^β / Σ_j (n_j p_j)^β`.
    Power {
        /// β, above zero.
        exponent: f64,
    },
    /// All weight to the largest `n_i p_i`; of several, to the first.
    Maximum,
    /// The balance heuristic among those with `n_i p_i ≥ α max_j n_j p_j`.
    Cutoff {
        /// α, 0 … 1.
        threshold: f64,
    },
}

impl Heuristic {
    /// All of them by name, each with a line of explanation.
    pub const NAMES: [(&str, &str); 4] = [
        ("balance", "w_i = n_i p_i / Σ n_j p_j"),
        ("power", "w_i = (n_i p_i)^β / Σ (n_j p_j)^β; `exponent` sets β (2)"),
        ("maximum", "all weight to the technique with the largest n_i p_i"),
        ("cutoff", "balance among those with n_i p_i ≥ α · largest; `threshold` sets α (0.1)"),
    ];

    /// The weight of the technique that drew the sample, from the ratios `n_j p_j / (n_i p_i)` of all *other* techniques:
    /// `before` those with a lower number (nearest first or last alike), `after` those with a higher one. Zero and infinite
    /// ratios are fine.
    #[must_use]
    #[inline]
    pub fn weight<B, A>(&self, mut before: B, mut after: A) -> f64
    where
        B: Iterator<Item = f64> + Clone,
        A: Iterator<Item = f64> + Clone,
    {
        match *self {
            Self::Balance => 1.0 / (1.0 + before.chain(after).sum::<f64>()),
            Self::Power { exponent } => {
                let power = |r: f64| if exponent == 2.0 { r * r } else { libm::pow(r, exponent) };
                1.0 / (1.0 + before.chain(after).map(power).sum::<f64>())
            }
            Self::Maximum => {
                let beaten = before.any(|r| r >= 1.0) || after.any(|r| r > 1.0);
                if beaten { 0.0 } else { 1.0 }
            }
            Self::Cutoff { threshold } => {
                let others = before.chain(after);
                let least = threshold * others.clone().fold(1.0, f64::max);
                if 1.0 < least { 0.0 } else { 1.0 / (1.0 + others.filter(|&r| r >= least).sum::<f64>()) }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all() -> [Heuristic; 5] {
        [
            Heuristic::Balance,
            Heuristic::Power { exponent: 2.0 },
            Heuristic::Power { exponent: 7.5 },
            Heuristic::Maximum,
            Heuristic::Cutoff { threshold: 0.1 },
        ]
    }

    #[test]
    fn weights_sum_to_one() {
        let densities: [&[f64]; 5] =
            [&[0.2, 3.0, 0.7], &[1.0, 1.0, 1.0, 1.0], &[0.0, 2.0], &[1e-200, 1e150, 3e149], &[0.1, 1.0]];
        for heuristic in all() {
            for p in densities {
                let total: f64 = (0..p.len())
                    .filter(|&i| p[i] > 0.0)
                    .map(|i| {
                        let ratio = |j: usize| p[j] / p[i];
                        heuristic.weight((0..i).map(ratio), (i + 1..p.len()).map(ratio))
                    })
                    .sum();
                assert!((total - 1.0).abs() < 1e-14, "{heuristic:?} {p:?}: {total}");
            }
        }
    }

    #[test]
    fn infinitely_better_competitors_take_everything() {
        for heuristic in all() {
            assert_eq!(heuristic.weight([f64::INFINITY].into_iter(), std::iter::empty()), 0.0);
        }
    }
}
