//! The metrics by name.

use std::fmt::{self, Display, Formatter};

use serde::{Deserialize, Serialize};

use super::rows::Row;

/// A column of errors; [`super::metrics`] says what each is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Metric {
    /// Mean squared error.
    Mse,
    /// Its root.
    Rmse,
    /// Relative mean squared error.
    Relmse,
    /// Mean absolute relative error.
    Mape,
    /// Symmetric mean absolute relative error.
    Smape,
    /// MSE without outliers.
    TrimmedMse,
    /// relMSE without outliers.
    TrimmedRelmse,
    /// ꟻLIP.
    Flip,
}

impl Metric {
    /// All, in the order of the columns.
    pub const ALL: [Self; 8] = [
        Self::Mse,
        Self::Rmse,
        Self::Relmse,
        Self::Mape,
        Self::Smape,
        Self::TrimmedMse,
        Self::TrimmedRelmse,
        Self::Flip,
    ];

    /// The name of its column.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Mse => "mse",
            Self::Rmse => "rmse",
            Self::Relmse => "relmse",
            Self::Mape => "mape",
            Self::Smape => "smape",
            Self::TrimmedMse => "trimmed_mse",
            Self::TrimmedRelmse => "trimmed_relmse",
            Self::Flip => "flip",
        }
    }

    /// Its value in a row. The root is told by its square, over which means are taken.
    #[must_use]
    pub fn of(self, row: &Row) -> Option<f64> {
        match self {
            Self::Mse | Self::Rmse => row.mse,
            Self::Relmse => row.relmse,
            Self::Mape => row.mape,
            Self::Smape => row.smape,
            Self::TrimmedMse => row.trimmed_mse,
            Self::TrimmedRelmse => row.trimmed_relmse,
            Self::Flip => row.flip,
        }
    }

    /// From what [`Metric::of`] tells, or a mean of it, to the metric.
    #[must_use]
    pub fn shown(self, value: f64) -> f64 {
        if self == Self::Rmse { value.sqrt() } else { value }
    }
}

impl Display for Metric {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
