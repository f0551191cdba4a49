//! From images to statements: errors against a reference, rows of measurements, tests of agreement, tables.

pub mod agreement;
mod error;
pub mod metrics;
pub mod npy;
pub mod paths;
pub mod pyramid;
pub mod rows;
pub(crate) mod statistics;
pub mod summary;
mod table;

pub use agreement::{Agreement, AgreementSettings, Verdict};
pub use error::ReportError;
pub use metrics::{Errors, Reference};
pub use rows::Row;
pub use summary::{SummaryRow, summarise};
pub(crate) use table::cut;
pub use table::{TABLE_WIDTH, tables};
