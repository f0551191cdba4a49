//! Properties of the whole, one module each.

mod definition;
mod experiment;
mod known_answers;
