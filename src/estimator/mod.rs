//! From samples to images: weights, threads, seeds.

mod definition;
pub mod driver;
mod heuristic;
mod integrator;
mod registry;
mod settings;
mod sink;

pub use definition::Definition;
pub use driver::Control;
pub use heuristic::Heuristic;
pub use integrator::{Estimator, Integrator};
pub use registry::{Build, Entry, Method, Registry, RegistryError};
pub use settings::{Settings, SettingsError};
pub use sink::{RecordedTerm, Recorder, Sink, Term};
