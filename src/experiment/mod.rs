//! Experiments: scenes × methods × seeds, the error of each render over its time, and whether the methods agree.
//!
//! A *method* is an integrator of the registry with its settings, or `mitsuba:path`, `mitsuba:ptracer`. Its *runs* differ in
//! their seed. Runs never overlap in time. What a run measures is rendering alone: a clock stands still while errors are
//! computed, progress is shown and files are written.
//!
//! An experiment lives in a [`Folder`]. [`run`] makes the runs that are missing there, each a job of its own in a folder of its
//! own, and [`collect`] makes the tables of whatever is finished: both can be repeated, interrupted, and shared by machines.

mod agreement;
pub mod budget;
pub mod cache;
mod collect;
mod entry;
mod error;
mod files;
mod job;
mod machine;
pub mod manifest;
pub mod mask;
mod method;
mod mitsuba;
mod own;
mod plan;
pub(crate) mod process;
mod reference;
mod run;
mod score;
pub mod seeds;

pub use agreement::{AgreementRow, REFERENCE};
pub use budget::Budget;
pub use collect::{Report, collect};
pub use entry::StringOr;
pub use error::ExperimentError;
pub use files::Folder;
pub use machine::Machine;
pub use manifest::{Manifest, MethodEntry, SceneEntry};
pub use method::MITSUBA;
pub use mitsuba::Mitsuba;
pub use plan::{MethodPlan, Plan, Record, ScenePlan};
pub use reference::{ReferencePolicy, RenderedReference, read_reference};
pub use run::{Made, Observer, Renderers, RunId, Standing, Unfinished, missing, run};
pub use score::{Listed, read_list, score, score_into};

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
