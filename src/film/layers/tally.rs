//! What each technique has drawn, and the rays and the time that go to it.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::path::Technique;

use super::{Contribution, LayerSelection, Layers};

/// What is counted for a technique; see the rule for rays and time in [`Layers`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tally {
    /// Samples in which it has contributed; for samples without terms their number.
    pub samples: u64,
    /// Terms without an unweighted value, as far as the integrator gives them.
    pub undefined: u64,
    /// Its share of the rays.
    pub rays: f64,
    /// Its share of the time of all threads \[s\].
    pub seconds: f64,
}

impl Tally {
    /// Adds what `other` has counted.
    pub fn merge(&mut self, other: &Self) {
        self.samples += other.samples;
        self.undefined += other.undefined;
        self.rays += other.rays;
        self.seconds += other.seconds;
    }
}

#[derive(Clone, Debug, Default)]
struct Count {
    tally: Tally,
    /// Where the contributions of the sample begin that it has counted last, plus one.
    sample: usize,
}

/// What some samples of a pass give to the layers, in order. It is filled by one thread.
#[derive(Clone, Debug, Default)]
pub struct LayerPart {
    pub(super) contributions: Vec<Contribution>,
    counts: BTreeMap<Technique, Count>,
    pub(super) without_terms: Tally,
    sample_begins: usize,
}

impl LayerPart {
    /// Adds a term of the present sample, whose value is finite. Black terms contribute nothing.
    pub fn add(&mut self, contribution: Contribution) {
        if contribution.unweighted().is_none() {
            self.counts.entry(contribution.technique).or_default().tally.undefined += 1;
        }
        if !contribution.value.is_black() {
            self.contributions.push(contribution);
        }
    }

    /// Ends the present sample, which took so many rays and so much time \[s\].
    pub fn end_sample(&mut self, rays: u64, seconds: f64) {
        let terms = &self.contributions[self.sample_begins..];
        let edges: f64 = terms.iter().map(|term| f64::from(term.technique.edges())).sum();
        if terms.is_empty() {
            self.without_terms.merge(&Tally { samples: 1, undefined: 0, rays: rays as f64, seconds });
        }
        for term in terms {
            let share = f64::from(term.technique.edges()) / edges;
            let count = self.counts.entry(term.technique).or_default();
            let first = count.sample != self.sample_begins + 1;
            count.sample = self.sample_begins + 1;
            count.tally.merge(&Tally {
                samples: u64::from(first),
                undefined: 0,
                rays: share * rays as f64,
                seconds: share * seconds,
            });
        }
        self.sample_begins = self.contributions.len();
    }

    pub(super) fn tallies(&self) -> impl Iterator<Item = (Technique, &Tally)> {
        self.counts.iter().map(|(&technique, count)| (technique, &count.tally))
    }
}

/// What a file says of its layers: the attribute `layers` of an EXR file, as JSON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LayerListing {
    /// Names of all layers, by length and then by s; each has one `NAME.standard_error` beside it from two passes on.
    pub layers: Vec<String>,
    /// What is known of each technique, where these were asked for.
    pub techniques: Vec<TechniqueRow>,
    /// The samples in which no technique has contributed.
    pub without_terms: Tally,
    /// How rays and time are shared.
    pub rule: String,
}

/// What is known of a technique.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TechniqueRow {
    /// Vertices of the walk from the emitter.
    pub s: u32,
    /// Vertices of the walk from the sensor.
    pub t: u32,
    /// Its counts.
    #[serde(flatten)]
    pub tally: Tally,
    /// Its share of all rays, 0 … 1.
    pub ray_share: f64,
    /// Its share of the time of all samples, 0 … 1.
    pub time_share: f64,
}

const RULE: &str = "each sample's rays and time, shared among its terms in proportion to their paths' edges";

impl Layers {
    /// Which layers there are, for a file.
    #[must_use]
    pub fn listing(&self) -> LayerListing {
        let LayerSelection { technique, .. } = self.selection();
        let all = self.tallies().map(|(_, tally)| tally).chain([self.without_terms()]);
        let (rays, seconds) = all.fold((0.0, 0.0), |sum, tally| (sum.0 + tally.rays, sum.1 + tally.seconds));
        let share = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
        let row = |(technique, tally): (Technique, &Tally)| TechniqueRow {
            s: technique.s,
            t: technique.t,
            tally: *tally,
            ray_share: share(tally.rays, rays),
            time_share: share(tally.seconds, seconds),
        };
        LayerListing {
            layers: self.layers().iter().map(ToString::to_string).collect(),
            techniques: if technique { self.tallies().map(row).collect() } else { Vec::new() },
            without_terms: *self.without_terms(),
            rule: RULE.to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::Rgb;

    fn term(s: u32, t: u32, value: f64) -> Contribution {
        Contribution { pixel: 0, technique: Technique { s, t }, value: Rgb::grey(value), weight: value }
    }

    #[test]
    fn rays_and_time_are_shared_by_edges_and_samples_counted_once() {
        let mut part = LayerPart::default();
        for term in [term(0, 2, 1.0), term(1, 2, 0.5), term(1, 2, 0.5), term(2, 2, 0.0)] {
            part.add(term);
        }
        part.end_sample(10, 1.0);
        part.end_sample(7, 0.5);
        part.add(term(1, 2, 1.0));
        part.end_sample(3, 0.25);
        let tallies: Vec<_> = part.tallies().map(|(technique, &tally)| (technique.s, tally)).collect();
        let tally = |samples, undefined, rays, seconds| Tally { samples, undefined, rays, seconds };
        assert_eq!(tallies[0], (0, tally(1, 0, 2.0, 0.2)));
        assert_eq!(tallies[1], (1, tally(2, 0, 11.0, 1.05)));
        assert_eq!(tallies[2], (2, tally(0, 1, 0.0, 0.0)));
        assert_eq!(part.without_terms, tally(1, 0, 7.0, 0.5));
    }
}
