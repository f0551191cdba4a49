//! From samples to images: weights, threads, seeds.

mod combination;
pub mod driver;
mod heuristic;
mod integrator;
mod lengths;
pub mod optimal;
mod registry;
mod settings;
mod sink;
mod what_if;

pub use combination::{Combination, Draw};
pub use driver::Control;
pub use heuristic::Heuristic;
pub use integrator::{Estimator, Integrator, Promises};
pub use lengths::Lengths;
pub use registry::{Build, Entry, Method, Registry, RegistryError, SamplerEntry};
pub use settings::{Settings, SettingsError};
pub use sink::{RecordedTerm, Recorder, Sink, Term};
pub use what_if::{Reweighted, Weights, what_if};
