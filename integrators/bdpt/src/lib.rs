//! The integrator `bdpt`.
