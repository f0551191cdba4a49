//! Properties of the whole, one module each.

mod definition;
mod known_answers;
