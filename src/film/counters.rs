//! What a render counts beside its pixels.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// Names one sample of one pixel, so that its path can be drawn again; written `seed:x,y:sample`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct ReplayKey {
    /// Seed of the render.
    pub seed: u64,
    /// Index of the sample in its pixel, from 0.
    pub sample: u64,
    /// Column and row of the pixel.
    pub pixel: (u32, u32),
}

impl fmt::Display for ReplayKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{},{}:{}", self.seed, self.pixel.0, self.pixel.1, self.sample)
    }
}

impl FromStr for ReplayKey {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parse = || {
            let (seed, rest) = text.split_once(':')?;
            let (pixel, sample) = rest.split_once(':')?;
            let (x, y) = pixel.split_once(',')?;
            Some(Self {
                seed: seed.parse().ok()?,
                sample: sample.parse().ok()?,
                pixel: (x.parse().ok()?, y.parse().ok()?),
            })
        };
        parse().ok_or_else(|| format!("'{text}' names no sample; write seed:x,y:sample, for example 1:12,34:567"))
    }
}

impl TryFrom<String> for ReplayKey {
    type Error = String;
    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<ReplayKey> for String {
    fn from(key: ReplayKey) -> Self {
        key.to_string()
    }
}

/// Events of a render, counted and never acted upon.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Counters {
    /// Rays traced: closest-hit queries and visibility tests.
    pub rays: u64,
    /// Paths whose contribution was evaluated.
    pub paths: u64,
    /// Contributions that were NaN or infinite.
    pub invalid: u64,
    /// Contributions that were negative where the weighting promises none.
    pub negative: u64,
    /// Samples to replay, the first [`Counters::REPLAY_KEYS`] by seed, sample and pixel, in this order.
    pub replay: Vec<ReplayKey>,
}

impl Counters {
    /// How many replay keys are kept.
    pub const REPLAY_KEYS: usize = 8;

    /// Keeps a sample for replay, unless enough earlier ones are kept.
    pub fn keep_for_replay(&mut self, key: ReplayKey) {
        if let Err(place) = self.replay.binary_search(&key) {
            self.replay.insert(place, key);
            self.replay.truncate(Self::REPLAY_KEYS);
        }
    }

    /// Adds the events of `other`; the result does not depend on the order in which counters are merged.
    pub fn merge(&mut self, other: &Self) {
        self.rays += other.rays;
        self.paths += other.paths;
        self.invalid += other.invalid;
        self.negative += other.negative;
        for &key in &other.replay {
            self.keep_for_replay(key);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(sample: u64) -> ReplayKey {
        ReplayKey { seed: 7, sample, pixel: (3, 4) }
    }

    #[test]
    fn replay_keys_read_what_they_write() {
        assert_eq!(key(9).to_string(), "7:3,4:9");
        assert_eq!("7:3,4:9".parse(), Ok(key(9)));
        for text in ["", "7", "7:3:9", "7:3,4", "7:3,-4:9", "7:3,4:9:1", "x:3,4:9"] {
            assert!(text.parse::<ReplayKey>().is_err(), "{text}");
        }
    }

    #[test]
    fn merging_does_not_depend_on_the_order() {
        let counters = |samples: &[u64]| {
            let mut counters = Counters { rays: samples.len() as u64, ..Counters::default() };
            samples.iter().for_each(|&sample| counters.keep_for_replay(key(sample)));
            counters
        };
        let (a, b) = (counters(&[20, 3, 5, 11]), counters(&[1, 4, 30, 3, 12, 13]));
        let (mut ab, mut ba) = (a.clone(), b.clone());
        ab.merge(&b);
        ba.merge(&a);
        assert_eq!(ab, ba);
        assert_eq!(ab.replay, [1, 3, 4, 5, 11, 12, 13, 20].map(key));
    }
}
