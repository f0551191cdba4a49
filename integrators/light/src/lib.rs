//! The integrator `light`.
