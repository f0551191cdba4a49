//! Experiments: scenes × methods × seeds, the error of each render over its time, and whether the methods agree.
//!
//! A *method* is an integrator of the registry with its settings, or `mitsuba:path`, `mitsuba:ptracer`. Its *runs* differ in
//! their seed. Runs never overlap in time. What a run measures is rendering alone: a clock stands still while errors are
//! computed, progress is shown and files are written.
//!
//! Every run has a seed of its own, so that methods that share random number streams are independent too, as the test of
//! agreement requires: repetition r of method i among m has the seed `first + r m + i`, and `render --seed` repeats it.

mod agreement;
mod error;
mod files;
pub mod mask;
mod method;
mod mitsuba;
mod own;
mod plan;
mod process;
mod reference;
mod run;

pub use agreement::AgreementRow;
pub use error::ExperimentError;
pub use files::Folder;
pub use mitsuba::Mitsuba;
pub use plan::{Budget, Plan, Request, ScenePlan};
pub use reference::{ReferenceChoice, check_reference};
pub use run::{Observer, Report, RunId, Standing, Unfinished, run};

use crate::scene::{Scene, SceneDescription};

/// A scene that takes part.
#[derive(Debug)]
pub struct Subject {
    /// Ready for tracing.
    pub scene: Scene,
    /// The same for other renderers.
    pub description: SceneDescription,
    /// Changes with whatever its images depend on.
    pub fingerprint: String,
    /// Wall-clock time of reading it \[s\].
    pub load_seconds: f64,
    /// Wall-clock time of building the acceleration structure and all else before the first sample \[s\].
    pub build_seconds: f64,
}
