//! What one method makes of one value of a case: a line of `stability.csv`.

use std::fmt;

use serde::{Serialize, Serializer};

use super::case::Case;

/// What is said of a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Verdict {
    /// The truth lies within the noise, which is small enough to say so, and nothing impossible was seen.
    Holds,
    /// The noise is too large to say anything, or there is no variance.
    Noise,
    /// The method does not claim to see this light.
    Blind,
    /// It would take too long.
    Slow,
    /// It does not hold, where nothing in double precision can.
    Beyond,
    /// It does not hold.
    Fails,
    /// It could not be measured.
    #[default]
    Missing,
}

impl Verdict {
    /// In words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Noise => "noise",
            Self::Blind => "blind",
            Self::Slow => "slow",
            Self::Beyond => "beyond",
            Self::Fails => "fails",
            Self::Missing => "missing",
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl Serialize for Verdict {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// One value of a case by one method; columns stand in the order of the fields. What is unknown is `None`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Cell {
    /// Version of this table.
    pub schema: u32,
    /// Of the case.
    pub group: String,
    /// Name of the case within its group.
    pub case: String,
    /// What is swept.
    pub parameter: String,
    /// Its value.
    pub value: f64,
    /// The integrator with its settings, `mitsuba:INTEGRATOR:VARIANT`, or `core` for what needs no integrator.
    pub method: String,
    /// What is said of it.
    pub verdict: Verdict,
    /// Mean luminance of the image.
    pub estimate: Option<f64>,
    /// What it should be.
    pub truth: Option<f64>,
    /// Their difference over its standard error.
    pub z: Option<f64>,
    /// Relative difference.
    pub difference: Option<f64>,
    /// Half the 95 % interval of it.
    pub interval: Option<f64>,
    /// The relative bias that would have been found with probability [`POWER`](super::POWER): a bound of what is there.
    pub detectable: Option<f64>,
    /// Independent passes.
    pub passes: Option<u64>,
    /// Samples: passes times pixels.
    pub samples: Option<u64>,
    /// Relative variance of a sample.
    pub variance: Option<f64>,
    /// The same over that of the tame value.
    pub variance_growth: Option<f64>,
    /// α of the tail `P(X > x) ~ x^(−α)` of pixels of a pass; there is no variance where it is below 2.
    pub tail_index: Option<f64>,
    /// Contributions that were NaN or infinite.
    pub invalid: Option<u64>,
    /// Contributions that were negative.
    pub negative: Option<u64>,
    /// The largest pixel of a pass over the mean.
    pub firefly: Option<f64>,
    /// Largest deviation from one of the weights of all techniques of a path, summed.
    pub weights: Option<f64>,
    /// Largest relative deviation of a term from what the definition says of its path.
    pub definition: Option<f64>,
    /// Of one core \[s\].
    pub seconds_per_sample: Option<f64>,
    /// The same over that of the tame value.
    pub time_growth: Option<f64>,
    /// Rays and segments.
    pub rays_per_sample: Option<f64>,
    /// Why it is as it is, for people.
    pub details: String,
}

impl Cell {
    /// Version of the table.
    pub const SCHEMA: u32 = 1;

    /// A cell of which nothing is known but where it stands.
    #[must_use]
    pub fn of(case: &Case, value: f64, method: &str) -> Self {
        let (group, name, parameter) = (case.group.into(), case.name.into(), case.parameter.into());
        Self { schema: Self::SCHEMA, group, case: name, parameter, value, method: method.into(), ..Self::default() }
    }

    /// It fails, or is missing.
    #[must_use]
    pub fn is_bad(&self) -> bool {
        matches!(self.verdict, Verdict::Fails | Verdict::Missing)
    }
}
