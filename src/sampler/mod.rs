//! Who draws paths, and with which random numbers.

mod path_sampler;
mod random;
mod tracer;
mod walk;

pub use path_sampler::{PathSampler, samples_for_all_pixels};
pub use random::Random;
pub use tracer::Tracer;
pub use walk::{Walk, walk_from_emitter, walk_from_sensor};
