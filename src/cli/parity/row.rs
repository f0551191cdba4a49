//! `parity.csv`: one line for each comparison.

use std::fmt;
use std::path::Path;

use serde::{Serialize, Serializer};

use crate::film::output::write_atomically;

/// What a comparison says, from the best to the worst.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Verdict {
    Agree,
    Undecided,
    Missing,
    Differ,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Agree => "agree",
            Self::Undecided => "undecided",
            Self::Missing => "missing",
            Self::Differ => "DIFFER",
        })
    }
}

impl Serialize for Verdict {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&self.to_string().to_lowercase())
    }
}

/// One comparison; columns stand in the order of the fields.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct ParityRow {
    /// Version of this table.
    pub schema: u32,
    /// GROUP/FEATURE.
    pub feature: String,
    /// `OURS/THEIRS` for images of integrators; what is compared point by point; `scene` where there is nothing to compare.
    pub comparison: String,
    /// `agree`, `undecided`, `missing` or `differ`.
    pub verdict: Verdict,
    /// Relative difference of the image's mean luminance, ours less theirs.
    pub difference: Option<f64>,
    /// Half the 95 % interval of it.
    pub interval: Option<f64>,
    /// Relative difference of the image that would have been seen with the probability `power`.
    pub detectable: Option<f64>,
    /// The same for a block: the median.
    pub block_detectable: Option<f64>,
    /// That probability.
    pub power: Option<f64>,
    /// Blocks and channels that differ.
    pub blocks_differing: Option<usize>,
    /// The largest error of a value point by point, relative to the largest value of its query; see `src/docs/parity.md`.
    pub largest_error: Option<f64>,
    /// What rounding explains of it.
    pub bound: Option<f64>,
    /// Values that are compared.
    pub values: Option<usize>,
    /// The outcome in one line, for people.
    pub details: String,
}

impl ParityRow {
    /// Version of the table.
    const SCHEMA: u32 = 1;

    pub(super) fn new(feature: &str, comparison: impl Into<String>, verdict: Verdict, details: String) -> Self {
        Self {
            schema: Self::SCHEMA,
            feature: feature.into(),
            comparison: comparison.into(),
            verdict,
            difference: None,
            interval: None,
            detectable: None,
            block_detectable: None,
            power: None,
            blocks_differing: None,
            largest_error: None,
            bound: None,
            values: None,
            details,
        }
    }

    /// One of the two cannot read or render the scene.
    pub(super) fn missing(feature: &str, why: &str) -> Self {
        Self::new(feature, "scene", Verdict::Missing, why.into())
    }
}

pub(super) fn write(path: &Path, rows: &[ParityRow]) -> anyhow::Result<()> {
    write_atomically(path, |file| {
        let mut writer = csv::Writer::from_writer(file);
        rows.iter().try_for_each(|row| writer.serialize(row))?;
        writer.flush()
    })?;
    Ok(())
}
