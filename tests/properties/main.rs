//! Properties of the whole, one module each.
#![allow(clippy::unwrap_used)]

mod definition;
mod experiment;
mod known_answers;
