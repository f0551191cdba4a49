//! How the terms of I = Σ_k I^(k), one for each path length, are estimated.

use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};

use crate::sampler::Random;

use super::settings::{Settings, SettingsError};

/// Which lengths one sample estimates. All but a `longest` length are unbiased.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "terms", rename_all = "snake_case", deny_unknown_fields)]
pub enum Lengths {
    /// All from one sample, whose paths share what they begin with.
    Together,
    /// Each from a sample of its own.
    Apart,
    /// One length N, drawn in advance with P(N = k) = (1 − q) q^(k−1): the term I^(N) / P(N).
    Single {
        /// q, the probability of each further edge.
        further: f64,
    },
    /// All up to a length N drawn like that: the terms I^(k) / P(N ≥ k) with P(N ≥ k) = q^(k−1).
    UpTo {
        /// q.
        further: f64,
    },
}

impl Lengths {
    /// All of them by name, each with a line of explanation.
    pub const NAMES: [(&str, &str); 4] = [
        ("together", "all from one sample, whose paths share what they begin with"),
        ("apart", "each length from a sample of its own"),
        ("single", "one length N drawn in advance: I^(N) / P(N); `further` sets P(N ≥ k) = q^(k−1)"),
        ("up_to", "all lengths up to such an N: I^(k) / P(N ≥ k)"),
    ];

    /// The `terms` setting (`together`, `apart`, `single`, `up_to`) and `further`, the q of the latter two.
    ///
    /// # Errors
    /// Where one is unknown or out of range.
    pub fn new(settings: &mut Settings) -> Result<Self, SettingsError> {
        let kind = settings.get("terms", "together".to_owned(), "")?;
        let mut further = || {
            let q = settings.get("further", 0.7, "a number between 0 and 1")?;
            if q > 0.0 && q < 1.0 {
                Ok(q)
            } else {
                Err(Settings::wrong("further", &q.to_string(), "a number between 0 and 1"))
            }
        };
        match kind.as_str() {
            "together" => Ok(Self::Together),
            "apart" => Ok(Self::Apart),
            "single" => Ok(Self::Single { further: further()? }),
            "up_to" => Ok(Self::UpTo { further: further()? }),
            _ => Err(Settings::wrong("terms", &kind, "together, apart, single or up_to")),
        }
    }

    /// It ends by itself, without a longest length.
    #[must_use]
    pub fn ends(self) -> bool {
        matches!(self, Self::Single { .. } | Self::UpTo { .. })
    }

    /// Each length takes a sample of its own.
    #[must_use]
    pub fn apart(self) -> bool {
        self == Self::Apart
    }

    /// The lengths that one sample estimates; none where the drawn one is beyond the longest.
    #[must_use]
    pub fn draw(self, longest: u32, random: &mut Random) -> RangeInclusive<u32> {
        match self {
            Self::Together | Self::Apart => 1..=longest,
            Self::Single { further } => {
                let n = draw(further, random);
                n..=n.min(longest)
            }
            Self::UpTo { further } => 1..=draw(further, random).min(longest),
        }
    }

    /// The probability that a length is among those of a sample.
    #[must_use]
    pub fn probability(self, edges: u32) -> f64 {
        match self {
            Self::Together | Self::Apart => 1.0,
            Self::Single { further } => (1.0 - further) * power(further, edges - 1),
            Self::UpTo { further } => power(further, edges - 1),
        }
    }
}

/// N ≥ 1 with P(N ≥ k) = q^(k−1).
fn draw(q: f64, random: &mut Random) -> u32 {
    // 1 − u is in (0, 1].
    1 + (libm::log(1.0 - random.uniform()) / libm::log(q)).floor().min(1e6) as u32
}

fn power(q: f64, n: u32) -> f64 {
    libm::pow(q, f64::from(n))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 10⁵ draws for each q: the frequency of N ≥ k for k = 1 … 6 within 4.5 standard errors of q^(k−1). A probability off
    /// by 0.01 would be seen always.
    #[test]
    fn lengths_are_drawn_with_their_probability() {
        for q in [0.3, 0.5, 0.9] {
            let mut random = Random::new(1, 0, 0);
            let draws: Vec<u32> = (0..100_000).map(|_| draw(q, &mut random)).collect();
            for k in 1..=6 {
                let (p, found) = (power(q, k - 1), draws.iter().filter(|&&n| n >= k).count() as f64 / 1e5);
                let error = (p * (1.0 - p) / 1e5).sqrt();
                assert!((found - p).abs() <= 4.5 * error, "q = {q}, k = {k}: {found}, expected {p}");
            }
        }
    }

    #[test]
    fn no_length_is_beyond_the_longest() {
        let mut random = Random::new(1, 0, 0);
        assert_eq!(Lengths::Apart.draw(4, &mut random), 1..=4);
        let mut beyond = 0;
        for _ in 0..100 {
            let single = Lengths::Single { further: 0.9 }.draw(4, &mut random);
            assert!(single.is_empty() || (single.start() == single.end() && *single.end() <= 4));
            beyond += u32::from(single.is_empty());
            let up_to = Lengths::UpTo { further: 0.9 }.draw(4, &mut random);
            assert!(*up_to.start() == 1 && (1..=4).contains(up_to.end()));
        }
        assert!((40..90).contains(&beyond), "{beyond} of about 66 are beyond");
    }
}
