//! Optimal weights.

mod integrator;
mod learning;
pub(super) mod share;
mod system;
#[cfg(test)]
mod tests;
pub(super) mod weigher;

pub(super) use integrator::from_settings;
pub use integrator::Optimal;
pub use learning::Alpha;
pub use system::{System, term};
pub use weigher::Form;
