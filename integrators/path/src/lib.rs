//! The integrator `path`.
