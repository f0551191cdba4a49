//! Properties of the whole, one module each.
#![allow(clippy::unwrap_used)]

mod agreement;
mod coverage;
mod definition;
mod ends;
mod experiment;
mod known_answers;
mod mitsuba;
mod path_log;
mod path_log_recomputed;
mod radiosity;
mod range;
mod references;
mod visibility;
mod watertight;
