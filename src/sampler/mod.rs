//! Who draws paths, and with which random numbers.

mod random;
mod tracer;

pub use random::Random;
pub use tracer::Tracer;
