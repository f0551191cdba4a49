//! From images to statements: errors against a reference, rows of measurements, tests of agreement, tables.

pub mod agreement;
pub mod curves;
mod error;
pub mod flip;
pub mod interval;
mod metric;
pub mod metrics;
pub mod npy;
pub mod paths;
pub mod pyramid;
pub mod replicas;
pub mod rows;
pub(crate) mod statistics;
pub mod summary;
mod table;
pub mod verdicts;

pub use agreement::{Agreement, AgreementSettings, Verdict};
pub use curves::{CurveRow, curves};
pub use error::ReportError;
pub use metric::Metric;
pub use metrics::{Errors, Reference};
pub use rows::{Row, SCHEMA};
pub use summary::{SummaryRow, summarise};
pub use table::{TABLE_WIDTH, tables};
pub(crate) use table::{cut, number};
pub use verdicts::{VerdictRow, verdicts};
