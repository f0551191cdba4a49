//! When a run ends, and where its error is measured.

use serde::{Deserialize, Serialize};

use crate::report::{Metric, Row};

/// The first checkpoint of a timed run is not before this time \[s\].
const FIRST_CHECKPOINT: f64 = 0.1;

const DEFAULT_SECONDS: f64 = 5.0;

/// When a run ends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Budget {
    /// With the first pass that reaches this rendering time \[s\].
    Seconds(f64),
    /// After so many samples per pixel.
    Spp(u64),
    /// With the first checkpoint whose error is small enough.
    Error(TargetError),
}

/// An error to reach.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TargetError {
    /// How the error is measured.
    pub metric: Metric,
    /// The error.
    pub target: f64,
    /// Where it is not reached, the run ends after this rendering time \[s\].
    pub seconds: f64,
}

impl TargetError {
    /// A checkpoint is good enough.
    #[must_use]
    pub fn reached(&self, row: &Row) -> bool {
        self.metric.of(row).is_some_and(|error| self.metric.shown(error.max(0.0)) <= self.target)
    }
}

impl Default for Budget {
    fn default() -> Self {
        Self::Seconds(DEFAULT_SECONDS)
    }
}

impl Budget {
    /// The longest rendering time, where it is limited \[s\].
    #[must_use]
    pub fn seconds(self) -> Option<f64> {
        match self {
            Self::Seconds(seconds) | Self::Error(TargetError { seconds, .. }) => Some(seconds),
            Self::Spp(_) => None,
        }
    }

    /// Where it ends, in the unit of the checkpoints.
    #[must_use]
    pub fn end(self) -> f64 {
        match self {
            Self::Seconds(seconds) | Self::Error(TargetError { seconds, .. }) => seconds,
            Self::Spp(spp) => spp as f64,
        }
    }

    /// # Errors
    /// Where no run could have it.
    pub fn check(self) -> Result<(), String> {
        match self {
            Self::Seconds(seconds) | Self::Error(TargetError { seconds, .. }) if !(seconds > 0.0 && seconds < 1e9) => {
                Err(format!("budget: seconds = {seconds}: expected a time in seconds above 0"))
            }
            Self::Spp(spp) if !(1..=1 << 31).contains(&spp) => {
                Err(format!("budget: spp = {spp}: expected a whole number from 1 to {}", 1_u64 << 31))
            }
            Self::Error(TargetError { target, .. }) if !(target > 0.0 && target.is_finite()) => {
                Err(format!("budget: target = {target}: expected an error above 0"))
            }
            _ => Ok(()),
        }
    }

    /// Where errors are measured, ascending, the end of the budget last. In seconds: `T 2^(−j/2)` down to 0.1 s. In samples
    /// per pixel: the powers of two.
    #[must_use]
    pub fn checkpoints(self) -> Vec<f64> {
        let mut times = match self {
            Self::Seconds(seconds) | Self::Error(TargetError { seconds, .. }) => {
                let time = |j: i32| seconds * libm::exp2(-0.5 * f64::from(j));
                (0..).map(time).take_while(|&time| time >= FIRST_CHECKPOINT || time == seconds).collect::<Vec<_>>()
            }
            Self::Spp(spp) => {
                let below = (0..63).map(|j| 1_u64 << j).take_while(|&power| power < spp);
                let below: Vec<f64> = below.map(|power| power as f64).collect();
                std::iter::once(spp as f64).chain(below.into_iter().rev()).collect()
            }
        };
        times.reverse();
        times
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checkpoints_ascend_by_root_two_to_the_budget() {
        let times = Budget::Seconds(8.0).checkpoints();
        assert_eq!((times.len(), times[12], times[10]), (13, 8.0, 4.0));
        assert!(times[0] >= FIRST_CHECKPOINT && times.windows(2).all(|pair| pair[0] < pair[1]));
        assert_eq!(Budget::Seconds(0.01).checkpoints(), [0.01]);
        assert_eq!(Budget::Spp(12).checkpoints(), [1.0, 2.0, 4.0, 8.0, 12.0]);
        assert_eq!(Budget::Spp(8).checkpoints(), [1.0, 2.0, 4.0, 8.0]);
        assert_eq!(Budget::Spp(1).checkpoints(), [1.0]);
    }
}
